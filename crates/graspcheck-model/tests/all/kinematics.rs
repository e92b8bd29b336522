//! Forward kinematics against the closed form, the Jacobian against differences.

use graspcheck_model::{Pose, robot::RobotModel};
use nalgebra::{Matrix6xX, Vector3, Vector6};

use crate::arms;

/// The Jacobian by central differences of the tool's pose.
fn differences(robot: &RobotModel, q: &[f64]) -> Matrix6xX<f64> {
    let step = 1e-6;
    let mut jacobian = Matrix6xX::zeros(q.len());
    for k in 0..q.len() {
        let at = |offset: f64| -> Pose {
            let mut moved = q.to_vec();
            moved[k] += offset;
            robot.world_from_tool(&moved)
        };
        let (before, after) = (at(-step), at(step));
        let linear = (after.translation.vector - before.translation.vector) / (2.0 * step);
        let angular: Vector3<f64> = (after.rotation * before.rotation.inverse()).scaled_axis() / (2.0 * step);
        jacobian.set_column(k, &Vector6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z));
    }
    jacobian
}

#[test]
fn the_jacobian_equals_differences_of_the_pose() {
    for (robot, q) in [
        (arms::scara(), vec![0.3, -0.9, -0.1, 4.0]),
        (arms::askew_scara(), vec![-0.7, 1.1, -0.2, -0.2]),
        (arms::askew_rrr(), vec![2.0, -1.3, 0.4]),
        (arms::spatial(), vec![0.4, -1.2, 0.3, 2.2]),
    ] {
        let error = (robot.tool_jacobian(&q) - differences(&robot, &q)).amax();
        assert!(error < 1e-8, "{}: {error}", robot.name);
    }
}

#[test]
fn the_planar_arm_is_where_its_triangle_says() {
    let robot = arms::rrr();
    let q = [0.7_f64, -1.9, 2.3];
    let (a, b, c) = (q[0], q[0] + q[1], q[0] + q[1] + q[2]);
    let wrist = robot.world_from_wrist(&q).translation.vector;
    assert!(
        (wrist - Vector3::new(4.0 * a.cos() + 3.0 * b.cos(), 4.0 * a.sin() + 3.0 * b.sin(), 0.0)).norm()
            < 1e-14
    );
    let tool = robot.world_from_tool(&q);
    assert!((tool.translation.vector - wrist - Vector3::new(c.cos(), c.sin(), 0.0)).norm() < 1e-14);
    assert!((tool * Vector3::x() - Vector3::new(c.cos(), c.sin(), 0.0)).norm() < 1e-14);
}

#[test]
fn the_scara_points_its_tool_down_and_turns_it_by_the_sum_of_its_angles() {
    let robot = arms::scara();
    let q = [0.4_f64, 0.8, -0.12, 5.0];
    let tool = robot.world_from_tool(&q);
    let yaw = q[0] + q[1] + q[3];
    assert!((tool * Vector3::x() + Vector3::z()).norm() < 1e-14);
    assert!((tool * Vector3::y() - Vector3::new(-yaw.sin(), yaw.cos(), 0.0)).norm() < 1e-14);
    assert!((tool.translation.z - (0.4 + 0.05 - 0.12 - 0.1)).abs() < 1e-15);
}

#[test]
fn forward_gives_every_link_and_the_last_one_carries_the_tool() {
    let robot = arms::spatial();
    let q = [0.1, 0.2, 0.3, 0.4];
    let links = robot.forward(&q);
    assert_eq!(links.len(), 4);
    let tool = links[3] * robot.link_from_tool;
    assert!((tool.to_homogeneous() - robot.world_from_tool(&q).to_homogeneous()).amax() < 1e-15);
}
