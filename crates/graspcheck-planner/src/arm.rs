//! An arm with its inverse kinematics, measured once for all paths of a plan.

use graspcheck_model::{
    inverse::{InverseKinematics, Unreachable},
    robot::RobotModel,
    task::Elbow,
};

/// An arm with its inverse kinematics.
#[derive(Clone, Debug)]
pub(crate) struct Arm<'a> {
    pub(crate) robot: &'a RobotModel,
    pub(crate) inverse: InverseKinematics,
}

impl<'a> Arm<'a> {
    /// The arm of `robot`.
    ///
    /// # Errors
    /// When it has no closed-form inverse kinematics.
    pub(crate) fn new(robot: &'a RobotModel) -> Result<Self, Unreachable> {
        Ok(Self { robot, inverse: InverseKinematics::new(robot)? })
    }

    /// The elbow branch of these joint positions.
    pub(crate) fn elbow(&self, q: &[f64]) -> Elbow {
        if (q[1] + self.inverse.geometry().elbow_zero).sin() < 0.0 { Elbow::Right } else { Elbow::Left }
    }

    /// How far the wrist is from axis 1 when the elbow joint is at `position`, m.
    pub(crate) fn wrist_distance_at(&self, position: f64) -> f64 {
        let geometry = self.inverse.geometry();
        let (upper, fore) = (geometry.upper, geometry.fore);
        let cos = (position + geometry.elbow_zero).cos();
        (upper * upper + fore * fore + 2.0 * upper * fore * cos).max(0.0).sqrt()
    }

    /// How far a joint at `value` is beyond its nearer position limit, rad or m; negative inside.
    pub(crate) fn excess(&self, joint: usize, value: f64) -> f64 {
        let limits = &self.robot.joints[joint].limits;
        (value - limits.position_max).max(limits.position_min - value)
    }
}
