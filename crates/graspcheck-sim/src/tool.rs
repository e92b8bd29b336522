//! Pose and twist of the tool, without allocating.

use graspcheck_model::{
    Pose,
    robot::{JointKind, RobotModel},
};
use graspcheck_recording::recording::PoseRow;
use nalgebra::Vector3;

/// The pose of the tool in the world from the poses of the links.
pub(crate) fn world_from_tool(robot: &RobotModel, world_from_link: &[Pose]) -> Pose {
    world_from_link.last().unwrap_or(&robot.world_from_base) * robot.link_from_tool
}

/// Linear velocity of the tool's origin and angular velocity, in the world, m/s and rad/s: the sum over the
/// joints of axis × lever · qd and axis · qd (geometric Jacobian).
pub(crate) fn twist(robot: &RobotModel, world_from_link: &[Pose], qd: &[f64]) -> [f64; 6] {
    let tool = world_from_tool(robot, world_from_link).translation.vector;
    let (mut linear, mut angular) = (Vector3::zeros(), Vector3::zeros());
    for ((joint, world_from_link), rate) in robot.joints.iter().zip(world_from_link).zip(qd) {
        // A joint leaves its own axis where it is: the axis in the link's frame is the one in the joint's.
        let axis = world_from_link.rotation * joint.axis.into_inner() * *rate;
        match joint.kind {
            JointKind::Revolute => {
                linear += axis.cross(&(tool - world_from_link.translation.vector));
                angular += axis;
            }
            JointKind::Prismatic => linear += axis,
        }
    }
    [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]
}

/// A pose in the form of a recording.
pub(crate) fn row(pose: &Pose) -> PoseRow {
    let (t, r) = (pose.translation.vector, pose.rotation.coords);
    [t.x, t.y, t.z, r.x, r.y, r.z, r.w]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures;

    #[test]
    fn agrees_with_the_jacobian_of_the_model() {
        for robot in [fixtures::scara(), fixtures::rrr(), fixtures::tilted()] {
            let q: Vec<f64> = (0..robot.dof()).map(|k| 0.3 - 0.2 * k as f64).collect();
            let qd: Vec<f64> = (0..robot.dof()).map(|k| 1.0 + 0.5 * k as f64).collect();
            let world_from_link = robot.forward(&q);
            let expected = robot.tool_jacobian(&q) * nalgebra::DVector::from_column_slice(&qd);
            for (value, expected) in twist(&robot, &world_from_link, &qd).iter().zip(&expected) {
                assert!((value - expected).abs() < 1e-12, "{}: {value} is not {expected}", robot.name);
            }
            let tool = world_from_tool(&robot, &world_from_link);
            assert!((tool.inverse() * robot.world_from_tool(&q)).translation.vector.norm() < 1e-12);
        }
    }
}
