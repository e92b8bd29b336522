//! Numerical inverse kinematics: it inverts arms of every structure, keeps to their limits, gives the same answer
//! twice, and says what is in the way.

use std::f64::consts::PI;

use graspcheck_model::{
    Pose,
    inverse::{POSE_TOLERANCE, Unreachable},
    numerical::{NumericalError, NumericalInverse, NumericalSolution},
    robot::{Family, RobotModel},
};
use nalgebra::{Translation3, Vector3};
use proptest::prelude::*;

use crate::arms;

/// A position of every joint within its limits, from numbers in 0..1.
fn within_limits(robot: &RobotModel, share: &[f64]) -> Vec<f64> {
    let range = robot.joints.iter().map(|joint| joint.limits);
    range.zip(share).map(|(l, s)| l.position_min + s * (l.position_max - l.position_min)).collect()
}

fn middle(robot: &RobotModel) -> Vec<f64> {
    within_limits(robot, &vec![0.5; robot.dof()])
}

fn check(robot: &RobotModel, wanted: &Pose, found: &NumericalSolution) -> Result<(), TestCaseError> {
    let reached = robot.world_from_tool(&found.q);
    let distance = (reached.translation.vector - wanted.translation.vector).norm();
    let angle = reached.rotation.angle_to(&wanted.rotation);
    prop_assert!(
        distance < 1.1 * POSE_TOLERANCE && angle < 1.1 * POSE_TOLERANCE + 1e-7,
        "{distance} {angle}"
    );
    prop_assert!(found.residual.distance <= POSE_TOLERANCE && found.residual.angle <= POSE_TOLERANCE);
    for (joint, &value) in robot.joints.iter().zip(&found.q) {
        prop_assert!((joint.limits.position_min..=joint.limits.position_max).contains(&value));
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn an_arm_without_closed_form_inverts(shares in proptest::collection::vec(0.02..0.98_f64, 6), seed in any::<u64>()) {
        let robot = arms::six();
        let wanted = robot.world_from_tool(&within_limits(&robot, &shares));
        let inverse = NumericalInverse::new(&robot).expect("limits are finite");
        let found = inverse.solve(&wanted, &middle(&robot), seed).expect("it was made from joint positions");
        check(&robot, &wanted, &found)?;
        prop_assert_eq!(inverse.solve(&wanted, &middle(&robot), seed), Ok(found), "the same twice");
    }

    #[test]
    fn arms_with_a_closed_form_are_inverted_without_it(
        shares in proptest::collection::vec(0.0..=1.0_f64, 4), which in 0..5_usize,
    ) {
        let robot = [arms::scara, arms::askew_scara, arms::rrr, arms::askew_rrr, arms::spatial][which]();
        let wanted = robot.world_from_tool(&within_limits(&robot, &shares[..robot.dof()]));
        let inverse = NumericalInverse::new(&robot).expect("limits are finite");
        let found = inverse.solve(&wanted, &middle(&robot), 7).expect("it was made from joint positions");
        check(&robot, &wanted, &found)?;
    }

    #[test]
    fn a_start_beside_the_solution_leads_to_it(shares in proptest::collection::vec(0.1..0.9_f64, 6)) {
        let robot = arms::six();
        let q = within_limits(&robot, &shares);
        // Where the Jacobian loses rank another solution may be as near.
        let singular_values = robot.tool_jacobian(&q).singular_values();
        prop_assume!(singular_values.min() > 0.05);
        let start: Vec<f64> = q.iter().map(|q| q + 0.01).collect();
        let found = NumericalInverse::new(&robot).expect("finite").solve(&robot.world_from_tool(&q), &start, 0).expect("near");
        prop_assert_eq!(found.searches, 1);
        for (a, b) in found.q.iter().zip(&q) {
            prop_assert!((a - b).abs() < 1e-6, "{:?} is not {q:?}", found.q);
        }
    }
}

#[test]
fn the_six_joint_arm_has_no_closed_form() {
    let robot = arms::six();
    assert_eq!(robot.family, Family::General);
    let pose = robot.world_from_tool(&[0.1; 6]);
    assert!(matches!(robot.inverse(&pose), Err(Unreachable::NoClosedForm { .. })));
}

#[test]
fn what_is_out_of_reach_comes_with_the_nearest_pose() {
    // A planar arm of 4 + 3 + 1 m cannot reach 9 m: it stretches, and 1 m is lacking.
    let robot = arms::rrr();
    let inverse = NumericalInverse::new(&robot).expect("finite");
    let wanted = Pose::from(Translation3::new(9.0, 0.0, 0.0));
    let error = inverse.solve(&wanted, &[0.3, 0.3, 0.3], 5).expect_err("too far");
    let NumericalError::NotFound { residual, q, active, searches } = &error else { panic!("{error}") };
    assert!((residual.distance - 1.0).abs() < 1e-6 && residual.angle < 1e-6, "{error}");
    assert!(q.iter().all(|q| q.abs() < 1e-3) && active.is_empty() && *searches > 30, "{error}");
    assert!(error.to_string().contains("off by 1.000e0 m"), "{error}");
    assert!(error.to_string().ends_with("the pose is out of reach, move it or turn it"), "{error}");
}

#[test]
fn a_limit_in_the_way_is_named() {
    // The quill of the SCARA ends 5 mm above its zero; the tool is wanted 25 mm above it.
    let robot = arms::scara();
    let inverse = NumericalInverse::new(&robot).expect("finite");
    let wanted = Translation3::new(0.0, 0.0, 0.025) * robot.world_from_tool(&[0.4, 0.9, 0.0, 1.0]);
    let error = inverse.solve(&wanted, &[0.0, 0.5, -0.1, 1.0], 3).expect_err("above the stroke");
    let NumericalError::NotFound { residual, active, .. } = &error else { panic!("{error}") };
    assert!((residual.distance - 0.02).abs() < 1e-6, "{error}");
    assert!(active.len() == 1 && active[0].joint == "quill" && active[0].upper, "{error}");
    assert!(error.to_string().contains("joint quill stands at its upper limit of 0.005000"), "{error}");
    // The hole that the elbow's limit leaves: the nearest place is at its rim, 0.229129 m from the axis.
    let wanted = Translation3::new(0.2, 0.0, 0.0) * robot.world_from_tool(&[0.0, 0.0, -0.1, 0.0]);
    let wanted = Pose::from_parts(Translation3::new(0.2, 0.0, wanted.translation.z), wanted.rotation);
    let error = inverse.solve(&wanted, &[0.0, 0.5, -0.1, 0.0], 3).expect_err("in the hole");
    let NumericalError::NotFound { residual, active, .. } = &error else { panic!("{error}") };
    let rim = (0.25_f64.powi(2) + 0.2 * 0.2 - 0.25 * 0.2).sqrt();
    assert!((residual.distance - (rim - 0.2)).abs() < 1e-3, "{error}");
    assert!(active.iter().any(|limit| limit.joint == "elbow"), "{error}");
}

#[test]
fn bad_input_is_a_typed_error() {
    let robot = arms::scara();
    let inverse = NumericalInverse::new(&robot).expect("finite");
    let pose = robot.world_from_tool(&[0.1, 0.2, -0.1, 0.3]);
    assert_eq!(inverse.solve(&pose, &[0.0; 3], 0), Err(NumericalError::WrongLength { count: 3, dof: 4 }));
    for bad in [2.0, f64::NAN, f64::NEG_INFINITY] {
        let error = inverse.solve(&pose, &[0.0, 0.0, bad, 0.0], 0).expect_err("outside");
        assert!(error.to_string().starts_with("start: joint quill at "), "{error}");
    }
    let mut nowhere = pose;
    nowhere.translation.vector.x = f64::NAN;
    assert_eq!(inverse.solve(&nowhere, &[0.0; 4], 0), Err(NumericalError::NotFinite));
    nowhere.translation.vector = Vector3::new(f64::INFINITY, 0.0, 0.0);
    assert_eq!(inverse.solve(&nowhere, &[0.0; 4], 0), Err(NumericalError::NotFinite));
    for limits in [[-PI, f64::INFINITY], [f64::NAN, 1.0], [1.0, -1.0]] {
        let mut robot = arms::scara();
        (robot.joints[3].limits.position_min, robot.joints[3].limits.position_max) = (limits[0], limits[1]);
        let error = NumericalInverse::new(&robot).expect_err("no range");
        assert!(error.to_string().starts_with("joint wrist: position limits from "), "{error}");
    }
}
