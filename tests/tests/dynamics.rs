//! Dynamics and kinematics of both arms, and of one of six joints, against MuJoCo, which read the same URDFs:
//! `tests/oracles/dynamics.py` wrote the numbers.

#[path = "../../crates/graspcheck-model/tests/arms/mod.rs"]
mod arms;

use graspcheck_model::{Pose, chain::SerialChain, dynamics::Dynamics, robot::RobotModel};
use nalgebra::{DMatrix, Matrix3, Vector3};
use serde_json::Value;

/// Largest difference, as a share of the largest entry: both sides sum some hundred products, each with a
/// rounding error of 1.1e-16.
const TOLERANCE: f64 = 1e-9;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("it is a list").iter().map(|x| x.as_f64().expect("of numbers")).collect()
}

/// The matrix of this many rows that a list of rows holds.
fn matrix(value: &Value, rows: usize) -> DMatrix<f64> {
    let all: Vec<f64> = value.as_array().expect("a list of rows").iter().flat_map(numbers).collect();
    DMatrix::from_row_slice(rows, all.len() / rows, &all)
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, value| largest.max(value.abs()))
}

/// The arms of the oracle, each with its robot.
fn arms_of_the_oracle() -> Vec<(RobotModel, Value)> {
    let oracle: Value =
        serde_json::from_str(include_str!("../oracles/dynamics.json")).expect("the oracle is JSON");
    let arms: Vec<(RobotModel, Value)> = oracle["arms"]
        .as_array()
        .expect("it has arms")
        .iter()
        .map(|arm| {
            let load = |scenario: &str| {
                let path = format!("{}/../scenarios/{scenario}.toml", env!("CARGO_MANIFEST_DIR"));
                graspcheck::load(path.as_ref()).expect("the scenario is valid").resolved.robot
            };
            let robot = match arm["robot"].as_str().expect("an arm has a name") {
                "scara" => load("scara/pick_cube"),
                "rrr" => load("rrr/shelf_top_down"),
                "six" => arms::six(),
                other => unreachable!("{other} is not an arm of the oracle"),
            };
            (robot, arm.clone())
        })
        .collect();
    assert_eq!(arms.len(), 3);
    arms
}

fn states(arm: &Value) -> &[Value] {
    let states = arm["states"].as_array().expect("it has states");
    assert!(states.len() >= 20, "{} states", states.len());
    states
}

#[test]
fn all_arms_have_the_dynamics_that_mujoco_finds_in_their_urdfs() {
    for (mut robot, arm) in arms_of_the_oracle() {
        // Both give gravity in the frame of the URDF's root.
        robot.world_from_base = Pose::identity();
        let dof = robot.dof();
        let mut dynamics = Dynamics::new(&robot, Vector3::from_vec(numbers(&arm["gravity"])));
        dynamics.set_load(arm["opening"].as_f64().expect("an opening"), None);
        for state in states(&arm) {
            let (q, qd) = (numbers(&state["q"]), numbers(&state["qd"]));
            let expected = matrix(&state["mass_matrix"], dof);
            let difference = (dynamics.mass_matrix(&q) - &expected).amax() / expected.amax();
            assert!(difference < TOLERANCE, "{} at {q:?}: mass matrix differs by {difference}", robot.name);

            let expected = numbers(&state["bias"]);
            let mut bias = vec![0.0; dof];
            dynamics.inverse(&q, &qd, &vec![0.0; dof], &mut bias);
            let difference: Vec<f64> = bias.iter().zip(&expected).map(|(a, b)| a - b).collect();
            let difference = largest(&difference) / largest(&expected);
            assert!(difference < TOLERANCE, "{} at {q:?}: bias differs by {difference}", robot.name);
        }
    }
}

#[test]
fn all_arms_stand_and_move_as_mujoco_finds_in_their_urdfs() {
    for (mut robot, arm) in arms_of_the_oracle() {
        robot.world_from_base = Pose::identity();
        // The oracle has the frame of the last link.
        robot.link_from_tool = Pose::identity();
        let chain = SerialChain::of(&robot);
        for state in states(&arm) {
            let (q, found) = (numbers(&state["q"]), &state["last_link"]);
            let rotation = Matrix3::from_row_slice(&numbers(&found["rotation"]));
            let origin = Vector3::from_vec(numbers(&found["origin"]));
            for (way, pose) in
                [("product", chain.tool(&q).to_pose()), ("quaternions", robot.world_from_tool(&q))]
            {
                let turned = (pose.rotation.to_rotation_matrix().matrix() - rotation).amax();
                let moved = (pose.translation.vector - origin).amax() / origin.amax();
                assert!(
                    turned < TOLERANCE && moved < TOLERANCE,
                    "{} at {q:?} by {way}: {turned} {moved}",
                    robot.name
                );
            }
            let expected = matrix(&found["jacobian"], 6);
            for jacobian in [chain.jacobian(&q), robot.tool_jacobian(&q)] {
                let difference = (jacobian - &expected).amax() / expected.amax();
                assert!(difference < TOLERANCE, "{} at {q:?}: Jacobian differs by {difference}", robot.name);
            }
        }
    }
}
