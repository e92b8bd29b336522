//! What carries a solid, and which joints move it.

use graspcheck_model::{
    Pose,
    robot::{Joint, JointKind, RobotModel},
};
use nalgebra::{Matrix3, Vector3};

use crate::solid::{Place, Solid};

/// What a solid is fixed to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Carrier {
    /// The world: it does not move.
    World,
    /// A moving link of the arm, by index.
    Link(usize),
    /// A finger of the gripper, by index.
    Finger(usize),
}

impl Carrier {
    /// The number of arm joints, counted from the base, that move it.
    pub(crate) fn arm_joints(self, dof: usize) -> usize {
        match self {
            Self::World => 0,
            Self::Link(link) => link + 1,
            Self::Finger(_) => dof,
        }
    }
}

/// A solid fixed to its carrier.
#[derive(Clone, Debug)]
pub(crate) struct Mount {
    pub(crate) carrier: Carrier,
    /// Of the solid's frame in the carrier's.
    pub(crate) place: Place,
    /// For each arm joint that moves it: how far the points of its core lie at most from the line through
    /// its origin along the joint's axis, m, wherever the joints between are.
    pub(crate) radial_extents: Vec<f64>,
}

impl Mount {
    pub(crate) fn new(
        robot: &RobotModel,
        solid: &Solid,
        carrier: Carrier,
        carrier_from_solid: &Pose,
    ) -> Self {
        let joints = carrier.arm_joints(robot.dof());
        let radial_extents = (0..joints)
            .map(|joint| match axis_in_carrier(robot, joint, carrier) {
                Some(axis) => solid.core().radial_extent(&(carrier_from_solid.rotation.inverse() * axis)),
                None => solid.core().bounding_radius(),
            })
            .collect();
        Self { carrier, place: Place::from(carrier_from_solid), radial_extents }
    }
}

/// A joint, prepared for many positions.
#[derive(Clone, Debug)]
pub(crate) struct Hinge {
    kind: JointKind,
    /// In the frame of the joint and of the link beyond it.
    pub(crate) axis: Vector3<f64>,
    /// Of the joint in the frame of the link before it.
    parent_from_joint: Place,
    /// What the sine of a turn adds to the rotation, and what 1 less its cosine adds: Rodrigues' formula.
    with_sine: Matrix3<f64>,
    with_versine: Matrix3<f64>,
}

impl Hinge {
    pub(crate) fn new(joint: &Joint) -> Self {
        let axis = joint.axis.into_inner();
        let across = axis.cross_matrix();
        let parent_from_joint = Place::from(&joint.parent_from_joint);
        let with_sine = parent_from_joint.rotation * across;
        Self { kind: joint.kind, axis, parent_from_joint, with_sine, with_versine: with_sine * across }
    }

    /// Where the link beyond the joint is, when the one before it is at `parent` and the joint at a position
    /// (rad or m).
    pub(crate) fn link_beyond(&self, parent: &Place, position: f64) -> Place {
        let joint = &self.parent_from_joint;
        let moved = match self.kind {
            JointKind::Revolute => {
                let (sine, cosine) = position.sin_cos();
                let rotation = joint.rotation + self.with_sine * sine + self.with_versine * (1.0 - cosine);
                Place { rotation, ..*joint }
            }
            JointKind::Prismatic => {
                Place { center: joint.center + joint.rotation * self.axis * position, ..*joint }
            }
        };
        parent.then(&moved)
    }
}

/// Sine of the largest angle between axes that count as parallel: rounding of file formats with seven digits
/// is larger, and then the bounds that need no parallel axes are used.
const PARALLEL: f64 = 1e-12;

/// Whether no joint turns the axis of another: the axes of all joints beyond a revolute one are parallel to
/// it.
pub(crate) fn has_steady_axes(robot: &RobotModel) -> bool {
    let mut base_from_link = Pose::identity();
    let mut turning: Option<Vector3<f64>> = None;
    robot.joints.iter().all(|joint| {
        base_from_link *= joint.parent_from_joint;
        let axis = base_from_link.rotation * joint.axis.into_inner();
        let steady = turning.is_none_or(|turning| turning.cross(&axis).norm() <= PARALLEL);
        if joint.kind == JointKind::Revolute {
            turning = turning.or(Some(axis));
        }
        steady
    })
}

/// The direction of a joint's axis in the frame of a carrier further out, when it is the same wherever the
/// joints between are: every revolute joint between turns about a parallel axis.
fn axis_in_carrier(robot: &RobotModel, joint: usize, carrier: Carrier) -> Option<Vector3<f64>> {
    let mut joint_from_link = Pose::identity();
    let axis = robot.joints[joint].axis.into_inner();
    for between in &robot.joints[joint + 1..carrier.arm_joints(robot.dof())] {
        joint_from_link *= between.parent_from_joint;
        let other = joint_from_link.rotation * between.axis.into_inner();
        if between.kind == JointKind::Revolute && other.cross(&axis).norm() > PARALLEL {
            return None;
        }
    }
    if let Carrier::Finger(finger) = carrier {
        joint_from_link *= robot.gripper.fingers[finger].link_from_finger;
    }
    Some(joint_from_link.rotation.inverse() * axis)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        fixtures::{self, at},
        solid::Core,
    };

    fn rod() -> Solid {
        Solid::new(Core::Cylinder { radius: 0.01, half_length: 0.2 }, 0.0)
    }

    #[test]
    fn extents_count_across_parallel_axes_only() {
        let mount = Mount::new(&fixtures::scara(), &rod(), Carrier::Link(3), &Pose::identity());
        assert_eq!(mount.radial_extents.len(), 4);
        for extent in mount.radial_extents {
            assert!((extent - 0.01).abs() < 1e-12, "{extent}");
        }
    }

    #[test]
    fn a_skewed_joint_between_makes_the_extent_count_in_every_direction() {
        let mut robot = fixtures::scara();
        robot.joints[1].axis = Vector3::x_axis();
        assert!(!has_steady_axes(&robot) && has_steady_axes(&fixtures::scara()));
        let mount = Mount::new(&robot, &rod(), Carrier::Link(3), &Pose::identity());
        let all_round = 0.01_f64.hypot(0.2);
        let expected = [all_round, all_round, 0.01, 0.01];
        for (joint, (extent, expected)) in mount.radial_extents.iter().zip(expected).enumerate() {
            // Across the skewed axis itself a cylinder has the bound radius plus half length.
            let tolerance = if joint == 1 { 0.011 } else { 1e-12 };
            assert!((extent - expected).abs() < tolerance, "joint {joint}: {extent}");
        }
    }

    #[test]
    fn a_slide_before_all_turns_may_point_anywhere() {
        let mut robot = fixtures::scara();
        robot
            .joints
            .insert(0, fixtures::joint("rail", JointKind::Prismatic, at(0.0, 0.0, 0.0), Vector3::x()));
        assert!(has_steady_axes(&robot));
        let rail = robot.joints.remove(0);
        robot.joints.push(rail);
        assert!(!has_steady_axes(&robot), "the wrist turns the last slide");
    }
}
