//! What carries a solid, and which joints move it.

use graspcheck_model::{
    Pose,
    robot::{JointKind, RobotModel},
};
use nalgebra::Vector3;

use crate::solid::Solid;

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
    /// From the solid's frame to the carrier's.
    pub(crate) carrier_from_solid: Pose,
    /// For each arm joint that moves it: how far its points lie at most from the line through its origin
    /// along the joint's axis, m, wherever the joints between are.
    pub(crate) radial_extents: Vec<f64>,
}

impl Mount {
    pub(crate) fn new(robot: &RobotModel, solid: &Solid, carrier: Carrier, carrier_from_solid: Pose) -> Self {
        let joints = carrier.arm_joints(robot.dof());
        let radial_extents = (0..joints)
            .map(|joint| match axis_in_carrier(robot, joint, carrier) {
                Some(axis) => solid.radial_extent(&(carrier_from_solid.rotation.inverse() * axis)),
                None => solid.bounding_radius(),
            })
            .collect();
        Self { carrier, carrier_from_solid, radial_extents }
    }
}

/// The direction of a joint's axis in the frame of a carrier further out, when it is the same wherever the
/// joints between are: every revolute joint between turns about a parallel axis.
fn axis_in_carrier(robot: &RobotModel, joint: usize, carrier: Carrier) -> Option<Vector3<f64>> {
    /// Sine of the largest angle between axes that count as parallel: rounding of file formats with seven
    /// digits is larger, and then the bound that needs no parallel axes is used.
    const PARALLEL: f64 = 1e-12;

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
