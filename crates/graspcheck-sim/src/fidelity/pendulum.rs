//! The first link as a pendulum: its period is known in closed form.

use graspcheck_model::{
    dynamics::Dynamics,
    robot::{JointKind, RobotModel},
};
use nalgebra::Vector3;

use super::{FidelityError, GRAVITY, plant_of, unhindered};

/// The period of the first link with the gripper on it, without friction, from 1.2 rad: by how much the plant's is off
/// the closed form, as a share.
pub(super) fn period(robot: &RobotModel, dt: f64) -> Result<f64, FidelityError> {
    const AMPLITUDE: f64 = 1.2;
    let mut robot = unhindered(robot);
    let refuse = || FidelityError::NoPendulum { robot: robot.name.clone() };
    let Some(JointKind::Revolute) = robot.joints.first().map(|joint| joint.kind) else {
        return Err(refuse());
    };
    let name = robot.name.clone();
    robot.joints.truncate(1);
    robot.links.truncate(1);
    (robot.joints[0].friction, robot.joints[0].damping) = (0.0, 0.0);
    let mut dynamics = Dynamics::new(&robot, Vector3::zeros());
    let inertia = dynamics.mass_matrix(&[0.0])[(0, 0)];
    // Two directions of gravity across the axis show where the link hangs, and how heavy it is.
    let axis = robot.world_from_base * robot.joints[0].parent_from_joint * robot.joints[0].axis;
    let across = axis.cross(&least_parallel(&axis)).normalize();
    let weight = |gravity: Vector3<f64>| {
        let (mut torque, rest) = ([0.0], [0.0]);
        Dynamics::new(&robot, gravity).inverse(&rest, &rest, &rest, &mut torque);
        torque[0]
    };
    let gravity = across * GRAVITY;
    let (sine, cosine) = (weight(gravity), weight(gravity.cross(&axis)));
    let moment = sine.hypot(cosine);
    if moment < 1e-9 * inertia {
        return Err(FidelityError::NoPendulum { robot: name });
    }
    // The torque that holds it is moment · sin(q − hanging); under gravity that is turned back by a quarter, where it
    // hangs is, too.
    let hanging = (-sine).atan2(cosine);
    let small = std::f64::consts::TAU * (inertia / moment).sqrt();
    // The exact period is that of a small swing over the arithmetic-geometric mean of 1 and cos(amplitude / 2).
    let (mut a, mut b) = (1.0, (AMPLITUDE / 2.0).cos());
    for _ in 0..8 {
        (a, b) = ((a + b) / 2.0, f64::sqrt(a * b));
    }
    let expected = small / a;
    let mut plant = plant_of(&robot, gravity, dt, 4)?;
    plant.set_state(&[hanging + AMPLITUDE, 0.0, 0.0], &[0.0; 3]);
    let (mut q, mut qd) = ([0.0; 3], [0.0; 3]);
    let (mut last, mut crossings) = (AMPLITUDE, Vec::new());
    for step in 1..(2.5 * expected / dt) as usize {
        plant.drive_fingers(0.0, robot.gripper.force_max);
        plant.step(&());
        plant.read_state(&mut q, &mut qd);
        let angle = q[0] - hanging;
        if last < 0.0 && angle >= 0.0 {
            crossings.push(dt * (step as f64 - angle / (angle - last)));
        }
        last = angle;
    }
    match crossings[..] {
        [first, second, ..] => Ok((second - first) / expected - 1.0),
        _ => Err(FidelityError::NoPendulum { robot: name }),
    }
}

fn least_parallel(axis: &Vector3<f64>) -> Vector3<f64> {
    if axis.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() }
}
