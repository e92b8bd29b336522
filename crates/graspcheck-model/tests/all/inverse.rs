//! Inverse kinematics: it inverts, it finds every branch and turn, and it explains what it cannot reach.

use std::f64::consts::{PI, TAU};

use graspcheck_model::{
    Pose,
    inverse::{InverseKinematics, PlanarWrist, Unreachable},
    robot::{Family, JointKind, RobotModel},
    task::Elbow,
};
use nalgebra::{Point2, UnitQuaternion, Vector3};
use proptest::prelude::*;

use crate::arms;

/// Distance and angle between two poses, m and rad.
fn difference(a: &Pose, b: &Pose) -> (f64, f64) {
    ((a.translation.vector - b.translation.vector).norm(), a.rotation.angle_to(&b.rotation))
}

/// A position of every joint within its limits, from numbers in 0..1.
fn within_limits(robot: &RobotModel, share: &[f64]) -> Vec<f64> {
    let range = robot.joints.iter().map(|joint| joint.limits);
    range.zip(share).map(|(l, s)| l.position_min + s * (l.position_max - l.position_min)).collect()
}

/// Every solution reaches the pose, is marked legal exactly when it is, and one of them is `q`.
fn check_solutions(robot: &RobotModel, q: &[f64]) -> Result<(), TestCaseError> {
    let world_from_tool = robot.world_from_tool(q);
    let solutions = robot.inverse(&world_from_tool).expect("within reach");
    let size = robot.forward(q).iter().map(|pose| pose.translation.vector.norm()).fold(1.0, f64::max);
    for solution in &solutions {
        let (distance, angle) = difference(&robot.world_from_tool(&solution.q), &world_from_tool);
        prop_assert!(distance < 1e-12 * size && angle < 1e-12, "{distance} m, {angle} rad: {solution:?}");
        let legal = robot.joints.iter().zip(&solution.q).all(|(joint, &value)| {
            (joint.limits.position_min - 1e-9..=joint.limits.position_max + 1e-9).contains(&value)
        });
        prop_assert_eq!(legal, solution.is_legal());
    }
    for solution in &solutions {
        let wrapped = solution.q[q.len() - 1] - TAU * f64::from(solution.turn);
        prop_assert!(wrapped > -PI - 1e-12 && wrapped < PI + 1e-12, "turn {} of {solution:?}", solution.turn);
    }
    for elbow in [Elbow::Left, Elbow::Right] {
        prop_assert!(solutions.iter().any(|solution| solution.elbow == elbow));
    }
    // Where the arm is nearly straight the angles lose half of their digits, the pose does not.
    let found = solutions.iter().any(|solution| solution.q.iter().zip(q).all(|(a, b)| (a - b).abs() < 1e-6));
    prop_assert!(found, "{q:?} is not among {solutions:?}");
    Ok(())
}

fn shares(count: usize) -> impl Strategy<Value = Vec<f64>> {
    proptest::collection::vec(0.0..=1.0, count)
}

proptest! {
    #[test]
    fn scara_inverts_on_every_branch(share in shares(4)) {
        check_solutions(&arms::scara(), &within_limits(&arms::scara(), &share))?;
    }

    #[test]
    fn askew_scara_inverts_on_every_branch(share in shares(4)) {
        check_solutions(&arms::askew_scara(), &within_limits(&arms::askew_scara(), &share))?;
    }

    #[test]
    fn rrr_inverts_on_every_branch(share in shares(3)) {
        check_solutions(&arms::rrr(), &within_limits(&arms::rrr(), &share))?;
    }

    #[test]
    fn askew_rrr_inverts_on_every_branch(share in shares(3)) {
        check_solutions(&arms::askew_rrr(), &within_limits(&arms::askew_rrr(), &share))?;
    }

    #[test]
    fn the_nearest_solution_on_a_branch_is_the_one_followed(share in shares(4), step in -0.1..0.1_f64) {
        let robot = arms::askew_scara();
        let inverse = InverseKinematics::new(&robot).unwrap();
        let q = within_limits(&robot, &share);
        let bend = q[1] + inverse.geometry().elbow_zero;
        prop_assume!(bend.sin().abs() > 1e-3);
        let elbow = if bend.sin() > 0.0 { Elbow::Left } else { Elbow::Right };
        let near: Vec<f64> = q.iter().map(|value| value + step).collect();
        let mut found = vec![0.0; 4];
        inverse.solve_near(&robot.world_from_tool(&q), elbow, &near, &mut found).unwrap();
        for (a, b) in found.iter().zip(&q) {
            prop_assert!((a - b).abs() < 1e-9, "{found:?} {q:?}");
        }
    }

    #[test]
    fn wrist_and_tool_angle_of_the_planar_arm_invert(share in shares(3)) {
        let robot = arms::askew_rrr();
        let q = within_limits(&robot, &share);
        let wrist = robot.planar_wrist(&q).unwrap();
        let (distance, angle) =
            difference(&robot.world_from_tool_at(&wrist).unwrap(), &robot.world_from_tool(&q));
        prop_assert!(distance < 1e-13 && angle < 1e-13);
    }
}

#[test]
fn families_are_found_with_their_lengths() {
    let close = |a: f64, b: f64| (a - b).abs() < 1e-14;
    for robot in [arms::scara(), arms::askew_scara()] {
        let geometry = InverseKinematics::new(&robot).unwrap().geometry().clone();
        assert_eq!(geometry.quill, Some(2));
        assert!(matches!(geometry.family(), Family::Scara { .. }));
    }
    let Family::Scara { upper, fore } = arms::scara().family else { panic!("not a SCARA") };
    assert!(close(upper, 0.25) && close(fore, 0.2));
    for robot in [arms::rrr(), arms::askew_rrr()] {
        let geometry = InverseKinematics::new(&robot).unwrap().geometry().clone();
        let Family::PlanarRrr { upper, fore, hand } = geometry.family() else { panic!("not planar") };
        assert!(close(upper, 4.0) && close(fore, 3.0) && close(hand, 1.0), "{upper} {fore} {hand}");
    }
    assert_eq!(arms::spatial().family, Family::General);
}

#[test]
fn an_arm_without_closed_form_says_why() {
    let mut sliding = arms::rrr();
    sliding.joints[0].kind = JointKind::Prismatic;
    let message = sliding.inverse(&Pose::identity()).unwrap_err().to_string();
    assert_eq!(
        message,
        "robot arm: no closed-form inverse kinematics: its joints are neither R-R-P-R nor R-R-R"
    );
    let mut tilted = arms::rrr();
    tilted.joints[1].parent_from_joint = arms::pose([4.0, 0.0, 0.0], [0.01, 0.0, 0.0]);
    let message = tilted.inverse(&Pose::identity()).unwrap_err().to_string();
    assert!(message.contains("axis of joint elbow leans 1.000e-2 rad from the base's z"), "{message}");
    let mut folded = arms::rrr();
    folded.joints[2].parent_from_joint = Pose::identity();
    let message = folded.inverse(&Pose::identity()).unwrap_err().to_string();
    assert!(message.contains("axes 2 and the last are 0.000e0 m apart"), "{message}");
}

/// Solutions of the planar arm at a wrist, in degrees, elbow by elbow.
fn planar(x: f64, y: f64, theta_deg: f64) -> Vec<(Elbow, [f64; 3], bool)> {
    let robot = arms::rrr();
    let wrist = PlanarWrist { position: Point2::new(x, y), theta: theta_deg.to_radians() };
    let solutions =
        robot.inverse(&robot.world_from_tool_at(&wrist).expect("a planar arm")).expect("within reach");
    solutions
        .iter()
        .map(|s| (s.elbow, [0, 1, 2].map(|joint| s.q[joint].to_degrees()), s.is_legal()))
        .collect()
}

fn has(solutions: &[(Elbow, [f64; 3], bool)], elbow: Elbow, expected: [f64; 3]) -> bool {
    solutions.iter().any(|(found, q, legal)| {
        *legal && *found == elbow && q.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6)
    })
}

#[test]
fn the_planar_example_has_the_known_angles_on_both_branches() {
    // Section 6 of the worked examples, at t = 0 and at t = 7.
    let start = planar(-4.0, 0.0, 90.0);
    assert!(has(&start, Elbow::Left, [135.951_374, 112.024_313, -157.975_687]), "{start:?}");
    assert!(has(&start, Elbow::Right, [224.048_626, -112.024_313, -22.024_313]), "{start:?}");
    // The same arm positions a whole turn of joint 1 away are within ±270° too: two ways per branch.
    assert!(has(&start, Elbow::Left, [-224.048_626, 112.024_313, -157.975_687]), "{start:?}");
    assert!(has(&start, Elbow::Right, [-135.951_374, -112.024_313, -22.024_313]), "{start:?}");
    assert_eq!(start.len(), 4);
    let end = planar(4.0, 0.0, 0.0);
    assert!(has(&end, Elbow::Left, [-44.048_626, 112.024_313, -67.975_687]), "{end:?}");
    assert!(has(&end, Elbow::Right, [44.048_626, -112.024_313, 67.975_687]), "{end:?}");
    // −44° − 360° and 44° − 360° are outside ±270°.
    assert_eq!(end.len(), 2);
    // The sign of a zero does not choose the half-plane: atan2(−0, −4) is −180°.
    assert_eq!(planar(-4.0, -0.0, 90.0), start);
}

#[test]
fn a_joint_at_half_a_turn_has_both_ends_of_its_range() {
    // q₃ = ±180° exactly: the hand folded back on the forearm.
    let robot = arms::rrr();
    let q = [0.3, 0.5, PI];
    let solutions = robot.inverse(&robot.world_from_tool(&q)).unwrap();
    let ends: Vec<f64> = solutions.iter().filter(|s| s.elbow == Elbow::Left).map(|s| s.q[2]).collect();
    assert_eq!(ends.len(), 2, "{solutions:?}");
    assert!((ends[0] + PI).abs() < 1e-12 && (ends[1] - PI).abs() < 1e-12);
}

/// The number of legal solutions on the left elbow when the tool's yaw q₁ + q₂ + q₄ leaves q₄ at `wrist_deg`.
fn legal_wrist_turns(wrist_deg: f64) -> Vec<f64> {
    let robot = arms::scara();
    let q = [0.2, 0.7, -0.1, wrist_deg.to_radians()];
    let solutions = robot.inverse(&robot.world_from_tool(&q)).expect("within reach");
    let left = solutions.iter().filter(|s| s.elbow == Elbow::Left && s.is_legal());
    left.map(|s| s.q[3].to_degrees()).collect()
}

#[test]
fn a_tool_angle_has_three_legal_wrist_turns_or_four() {
    for (wrist, expected) in [
        (0.0, vec![0.0, 360.0, 720.0, 1080.0]),
        (350.0, vec![-10.0, 350.0, 710.0, 1070.0]),
        (-20.0, vec![-20.0, 340.0, 700.0, 1060.0]),
        (339.0, vec![339.0, 699.0, 1059.0]),
        (1.0, vec![1.0, 361.0, 721.0]),
        (200.0, vec![200.0, 560.0, 920.0]),
    ] {
        let found = legal_wrist_turns(wrist);
        assert_eq!(found.len(), expected.len(), "{wrist}°: {found:?}");
        for (a, b) in found.iter().zip(&expected) {
            assert!((a - b).abs() < 1e-9, "{wrist}°: {found:?}");
        }
    }
}

#[test]
fn the_hole_of_the_scara_is_set_by_the_limit_of_the_elbow() {
    let reach = InverseKinematics::new(&arms::scara()).unwrap().reach();
    assert!((reach.inner - 0.229_128_784_747_792).abs() < 1e-15, "{reach:?}");
    assert!((reach.outer - 0.45).abs() < 1e-15);
    assert!((reach.inner_without_limits - 0.05).abs() < 1e-15);
    assert!((reach.outer_without_limits - 0.45).abs() < 1e-15);
    // Other forearms: hole and reach of section 7.
    for (fore, outer, hole) in [(0.10, 0.35, 0.2179), (0.25, 0.50, 0.25), (0.30, 0.55, 0.2784)] {
        let mut robot = arms::scara();
        robot.joints[2].parent_from_joint = arms::pose([fore, 0.0, 0.0], [0.0; 3]);
        let reach = InverseKinematics::new(&robot).unwrap().reach();
        assert!((reach.outer - outer).abs() < 1e-12 && (reach.inner - hole).abs() < 5e-5, "{reach:?}");
    }
}

#[test]
fn a_place_in_the_hole_is_given_with_the_limit_that_it_breaks() {
    // The near-base example of the terminal mock-ups: wrist at (190, −60) mm, elbow 128.9° against 120°.
    let robot = arms::scara();
    let tool = robot.world_from_tool(&[0.0; 4]);
    let target = Pose::from_parts(Vector3::new(0.19, -0.06, 0.2).into(), tool.rotation);
    let inverse = InverseKinematics::new(&robot).unwrap();
    assert!((inverse.wrist_distance(&target).unwrap() - 0.19_f64.hypot(0.06)).abs() < 1e-15);
    let solutions = inverse.solve(&target).unwrap();
    assert!(solutions.iter().all(|solution| !solution.is_legal()));
    let violation = solutions[0].violations[0];
    assert_eq!((violation.joint, solutions[0].elbow), (1, Elbow::Left));
    assert!((violation.value.to_degrees() - 128.9).abs() < 0.05, "{violation:?}");
    assert!((violation.excess.to_degrees() - 8.9).abs() < 0.05, "{violation:?}");
    assert!((violation.limit.to_degrees() - 120.0).abs() < 1e-9, "{violation:?}");
    assert!((solutions[0].q[0].to_degrees() + 68.9).abs() < 0.05);
    let right = solutions.iter().find(|solution| solution.elbow == Elbow::Right).unwrap();
    assert!((right.q[0].to_degrees() - 33.8).abs() < 0.05, "{right:?}");
}

#[test]
fn a_quill_beyond_its_stroke_is_a_violation_of_the_quill() {
    let robot = arms::scara();
    let q = [0.1, 0.5, -0.34, 1.0];
    let solutions = robot.inverse(&robot.world_from_tool(&q)).unwrap();
    for solution in &solutions {
        let quill = solution.violations.iter().find(|violation| violation.joint == 2).unwrap();
        assert!((quill.excess - 0.01).abs() < 1e-12 && (quill.limit + 0.33).abs() < 1e-15);
    }
}

#[test]
fn the_nearest_turn_is_given_when_none_is_legal() {
    let mut robot = arms::scara();
    robot.joints[3].limits.position_min = 100.0_f64.to_radians();
    robot.joints[3].limits.position_max = 200.0_f64.to_radians();
    for (wrist, expected, excess) in [(95.0, 95.0, 5.0), (-150.0, 210.0, 10.0), (300.0, 300.0, 100.0)] {
        let q = [0.2, 0.7, -0.1, f64::to_radians(wrist)];
        let solutions = robot.inverse(&robot.world_from_tool(&q)).unwrap();
        let left = &solutions[0];
        assert!((left.q[3].to_degrees() - expected).abs() < 1e-9, "{wrist}°: {left:?}");
        assert!((left.violations[0].excess.to_degrees() - excess).abs() < 1e-9, "{wrist}°: {left:?}");
    }
}

#[test]
fn what_cannot_be_reached_is_explained_with_value_and_limit() {
    let robot = arms::scara();
    let down = robot.world_from_tool(&[0.0; 4]).rotation;
    let at = |x: f64, y: f64| Pose::from_parts(Vector3::new(x, y, 0.2).into(), down);
    assert_eq!(
        robot.inverse(&at(0.3, 0.4)).unwrap_err().to_string(),
        "wrist: 0.500000 m from axis 1 exceeds the outer reach of 0.450000 m by 0.050000 m"
    );
    assert_eq!(
        robot.inverse(&at(0.02, 0.0)).unwrap_err().to_string(),
        "wrist: 0.020000 m from axis 1 is inside the hole of radius 0.050000 m by 0.030000 m"
    );
    let lean = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 0.1);
    let leaning = Pose::from_parts(Vector3::new(0.3, 0.0, 0.2).into(), lean * down);
    assert_eq!(
        robot.inverse(&leaning).unwrap_err().to_string(),
        "tool pose: leans 0.100000 rad from the only direction that the arm can give its tool"
    );
    let nowhere = at(f64::NAN, 0.0);
    assert_eq!(robot.inverse(&nowhere), Err(Unreachable::NotFinite));
    let planar = arms::rrr();
    let above = Pose::from_parts(Vector3::new(3.0, 1.0, 0.25).into(), UnitQuaternion::identity());
    assert_eq!(
        planar.inverse(&above).unwrap_err().to_string(),
        "tool pose: 0.250000 m out of the plane in which the arm moves"
    );
}

#[test]
fn a_tool_upside_down_leans_half_a_turn() {
    let planar = arms::rrr();
    let flipped = Pose::from_parts(
        Vector3::new(3.0, 1.0, 0.0).into(),
        UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI),
    );
    let Err(Unreachable::Tilted { angle }) = planar.inverse(&flipped) else { panic!("reached") };
    assert!((angle - PI).abs() < 1e-12);
}

#[test]
fn the_straight_and_the_folded_arm_are_reached() {
    for q in [[0.3, 0.0, -0.1, 1.0], [0.3, PI, -0.1, 1.0]] {
        let robot = arms::scara();
        let pose = robot.world_from_tool(&q);
        for solution in robot.inverse(&pose).unwrap() {
            let (distance, angle) = difference(&robot.world_from_tool(&solution.q), &pose);
            assert!(distance < 1e-12 && angle < 1e-12, "{distance} {angle} {solution:?}");
        }
    }
}
