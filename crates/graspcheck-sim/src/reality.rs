//! What stands in the plant where it is not what the plan and the controller believe.

use graspcheck_model::{Pose, execution::Imperfections, object::Object, robot::RobotModel};
use nalgebra::{Translation3, UnitQuaternion, Vector3};

/// The robot as it is.
pub(crate) fn robot(declared: &RobotModel, imperfections: &Imperfections) -> RobotModel {
    let mut robot = declared.clone();
    if let Some(share) = imperfections.joint_friction {
        for joint in &mut robot.joints {
            joint.damping *= share;
            joint.friction *= share;
        }
    }
    robot
}

/// The object as it is, where it stands.
pub(crate) fn object(declared: &Object, imperfections: &Imperfections) -> Object {
    let mut object = declared.clone();
    object.mass += imperfections.payload;
    if let Some(friction) = imperfections.object_friction {
        object.friction = friction;
    }
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), imperfections.object_yaw);
    let shift = Translation3::from(Vector3::from(imperfections.object_offset));
    let declared = declared.world_from_object;
    object.world_from_object = Pose::from_parts(shift * declared.translation, turn * declared.rotation);
    object
}
