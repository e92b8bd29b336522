//! An arm with its inverse kinematics, measured once for all paths of a plan.

use graspcheck_model::{
    Pose,
    inverse::{InverseKinematics, Unreachable},
    robot::{Joint, RobotModel},
    task::Elbow,
};

use crate::branch::BranchFault;

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

    /// The solution on the elbow branch of `near`, in the turns nearest to it, limits or not.
    ///
    /// # Errors
    /// When the pose is out of reach.
    pub(crate) fn solve_near(&self, world_from_tool: &Pose, near: &[f64]) -> Result<Vec<f64>, Unreachable> {
        let mut q = vec![0.0; near.len()];
        self.inverse.solve_near(world_from_tool, self.elbow(near), near, &mut q)?;
        Ok(q)
    }

    /// The elbow branch of these joint positions.
    fn elbow(&self, q: &[f64]) -> Elbow {
        if self.elbow_angle(q).sin() < 0.0 { Elbow::Right } else { Elbow::Left }
    }

    /// |sin| of the angle at the elbow: the area of the triangle of the two links as a share of the
    /// largest, which is zero where the arm is singular.
    pub(crate) fn sine_of_elbow(&self, q: &[f64]) -> f64 {
        self.elbow_angle(q).sin().abs()
    }

    /// Angle from the upper arm to the forearm, rad.
    fn elbow_angle(&self, q: &[f64]) -> f64 {
        q[1] + self.inverse.geometry().elbow_zero
    }

    /// How far a joint at `value` is beyond its nearer position limit, rad or m; negative inside.
    pub(crate) fn excess(&self, joint: usize, value: f64) -> f64 {
        let limits = &self.robot.joints[joint].limits;
        (value - limits.position_max).max(limits.position_min - value)
    }

    /// The fault of a joint that would have to go to `value`, beyond a limit.
    pub(crate) fn limit_fault(&self, joint: usize, value: f64) -> BranchFault {
        let Joint { name, limits, .. } = &self.robot.joints[joint];
        let limit = if value > limits.position_max { limits.position_max } else { limits.position_min };
        BranchFault::Limit { joint: name.clone(), value, limit, excess: self.excess(joint, value) }
    }
}
