//! Mass matrix and bias forces of both arms against MuJoCo, which read the same URDFs:
//! `tests/oracles/dynamics.py` wrote the numbers.

use graspcheck_model::dynamics::Dynamics;
use nalgebra::{DMatrix, Vector3};
use serde_json::Value;

/// Largest difference, as a share of the largest entry: both sides sum some hundred products, each with a
/// rounding error of 1.1e-16.
const TOLERANCE: f64 = 1e-9;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("it is a list").iter().map(|x| x.as_f64().expect("of numbers")).collect()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, value| largest.max(value.abs()))
}

#[test]
fn both_arms_have_the_dynamics_that_mujoco_finds_in_their_urdfs() {
    let oracle: Value =
        serde_json::from_str(include_str!("../oracles/dynamics.json")).expect("the oracle is JSON");
    let arms = oracle["arms"].as_array().expect("it has arms");
    assert_eq!(arms.len(), 2);
    for arm in arms {
        let scenario = match arm["robot"].as_str().expect("an arm has a name") {
            "scara" => "scara/pick_cube",
            "rrr" => "rrr/shelf_top_down",
            other => panic!("{other} is not an arm of ours"),
        };
        let path = format!("{}/../scenarios/{scenario}.toml", env!("CARGO_MANIFEST_DIR"));
        let robot = graspcheck::load(path.as_ref()).expect("the scenario is valid").resolved.robot;
        let dof = robot.dof();
        let mut dynamics = Dynamics::new(&robot, Vector3::from_vec(numbers(&arm["gravity"])));
        dynamics.set_load(arm["opening"].as_f64().expect("an opening"), None);
        let states = arm["states"].as_array().expect("it has states");
        assert!(states.len() >= 20, "{} states", states.len());
        for state in states {
            let (q, qd) = (numbers(&state["q"]), numbers(&state["qd"]));
            let rows: Vec<f64> =
                state["mass_matrix"].as_array().expect("a matrix").iter().flat_map(numbers).collect();
            let expected = DMatrix::from_row_slice(dof, dof, &rows);
            let difference = (dynamics.mass_matrix(&q) - &expected).amax() / expected.amax();
            assert!(difference < TOLERANCE, "{scenario} at {q:?}: mass matrix differs by {difference}");

            let expected = numbers(&state["bias"]);
            let mut bias = vec![0.0; dof];
            dynamics.inverse(&q, &qd, &vec![0.0; dof], &mut bias);
            let difference: Vec<f64> = bias.iter().zip(&expected).map(|(a, b)| a - b).collect();
            let difference = largest(&difference) / largest(&expected);
            assert!(difference < TOLERANCE, "{scenario} at {q:?}: bias differs by {difference}");
        }
    }
}
