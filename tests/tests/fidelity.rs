//! How far the plant of the two robots is from the exact equations, with the robots' own friction.

#![expect(clippy::panic, reason = "helpers of tests: what cannot be read fails the test")]

use std::path::Path;

use graspcheck_model::robot::RobotModel;
use graspcheck_sim::fidelity::{Fidelity, Trial, fidelity};

/// Applied torque against the recorded motion, as a share of the joint's peak. Measured: shoulder 0.11 %, elbow 0.24 %, wrist
/// 1.6 %, which is the dry friction of its first steps, where the sign of a velocity near zero decides.
const RECORDED_TORQUE: f64 = 2e-2;

/// Steps of the plant, s.
const DT: f64 = 1e-3;

fn robot(scenario: &str) -> RobotModel {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios").join(scenario);
    graspcheck::load(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display())).resolved.robot
}

fn value(found: &Fidelity, quantity: &str) -> f64 {
    let row = found.rows.iter().find(|row| row.quantity.starts_with(quantity));
    row.unwrap_or_else(|| panic!("no row {quantity}")).value
}

/// What holds for every robot.
fn holds_for_any(found: &Fidelity, robot: &RobotModel) {
    assert!((value(found, "order of convergence") - 1.0).abs() < 0.1);
    assert!(value(found, "period").abs() < 1e-4);
    assert!(value(found, "torques at rest") < 1e-8);
    assert!(value(found, "slope").abs() < 0.02);
    for joint in &robot.joints {
        let of_torque =
            |against: &str| value(found, &format!("torque of {} against the {against}", joint.name));
        let (recorded, commanded) = (of_torque("recorded"), of_torque("commanded"));
        assert!(recorded < RECORDED_TORQUE, "{}: {recorded}", joint.name);
        assert!(commanded < 5e-3, "{}: {commanded}", joint.name);
    }
}

#[test]
fn the_planar_arm_swings_and_follows_within_the_promised_errors() {
    let robot = robot("rrr/pedestal_to_pedestal.toml");
    let trial = Trial { from: vec![0.0; 3], to: vec![1.0, -0.8, 0.5], duration: 3.0, ..Trial::of(&robot) };
    let found = fidelity(&robot, &trial, DT).unwrap();
    let [one, four] = &found.swings;
    assert!(one.worst() < 1.5e-3, "{} rad", one.worst());
    assert!(four.worst() < 4e-4, "{} rad", four.worst());
    assert!(one.energy_drift() < 1.5e-3, "{}", one.energy_drift());
    assert!(four.energy_drift() < 4e-4, "{}", four.energy_drift());
    for joint in &robot.joints {
        let tracking = value(&found, &format!("tracking of {}", joint.name));
        assert!(tracking < 5e-4, "{}: {tracking} rad", joint.name);
    }
    holds_for_any(&found, &robot);
}

#[test]
fn the_scara_follows_within_the_promised_errors() {
    let robot = robot("scara/pick_cube.toml");
    let gravity = nalgebra::Vector3::new(0.0, 0.0, -9.81);
    let from = vec![0.0, 0.0, -0.05, 0.0];
    let trial = Trial { from, to: vec![1.1, 1.7, -0.25, 3.0], duration: 1.0, gravity, ..Trial::of(&robot) };
    let found = fidelity(&robot, &trial, DT).unwrap();
    for (joint, limit) in robot.joints.iter().zip([5e-4, 5e-4, 1e-4, 5e-4]) {
        let tracking = value(&found, &format!("tracking of {}", joint.name));
        assert!(tracking < limit, "{}: {tracking}", joint.name);
    }
}
