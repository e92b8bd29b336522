//! Straight lines of the tool: how near the joints follow, which limits are reached, and the three ways to
//! fail of the worked examples, section 7.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]
#![expect(clippy::float_cmp, reason = "these values must be met to the last digit")]

use crate::robots::{pose, rrr, scara};
use graspcheck_model::{Pose, inverse::Unreachable, robot::RobotModel, task::Elbow};
use graspcheck_planner::{
    branch::BranchFault,
    cartesian::{LineError, line},
    path::{PathMotion, ToolPath, line::straight_line},
};
use proptest::prelude::*;

/// Joint positions of the R-R-R with its wrist at (x, y) and link 3 along x.
fn rrr_at(robot: &RobotModel, x: f64, y: f64, elbow: Elbow) -> Vec<f64> {
    let solutions = robot.inverse(&rrr_pose(x, y)).unwrap();
    solutions.into_iter().find(|solution| solution.elbow == elbow && solution.is_legal()).unwrap().q
}

/// Pose of the R-R-R's tool with its wrist at (x, y) and link 3 along x.
fn rrr_pose(x: f64, y: f64) -> Pose {
    pose([x + 1.0, y, 0.0], [0.0; 3])
}

/// The R-R-R with an elbow that can fold right over.
fn free_rrr() -> RobotModel {
    let mut robot = rrr();
    robot.joints[1].limits.position_min = -200.0_f64.to_radians();
    robot.joints[1].limits.position_max = 200.0_f64.to_radians();
    robot.joints[2].limits.position_min = -3.0 * std::f64::consts::PI;
    robot.joints[2].limits.position_max = 3.0 * std::f64::consts::PI;
    robot
}

fn fault(robot: &RobotModel, from: (f64, f64), to: (f64, f64)) -> (f64, BranchFault) {
    let start = rrr_at(robot, from.0, from.1, Elbow::Left);
    let error = line(robot, &start, &rrr_pose(to.0, to.1), 1.0, None).unwrap_err();
    let LineError::Branch { at, fault } = error else { unreachable!("not a fault of the branch: {error}") };
    (at, fault)
}

#[test]
fn a_line_that_leaves_the_outer_reach_is_located() {
    let (at, fault) = fault(&free_rrr(), (5.0, 0.0), (5.0, 6.0));
    assert!((at - 24.0_f64.sqrt() / 6.0).abs() < 1e-6, "{at}");
    let BranchFault::OutOfReach { until, bound: Unreachable::TooFar { reach, .. } } = fault else {
        panic!("{fault}")
    };
    assert!((reach - 7.0).abs() < 1e-12 && (until - 1.0).abs() < 1e-12);
}

#[test]
fn a_line_through_the_hole_is_located_on_both_sides() {
    let (at, fault) = fault(&free_rrr(), (-3.0, 0.5), (3.0, 0.5));
    let half = 0.75_f64.sqrt() / 6.0;
    assert!((at - (0.5 - half)).abs() < 1e-6, "{at}");
    let BranchFault::OutOfReach { until, bound: Unreachable::TooNear { hole, .. } } = fault else {
        panic!("{fault}")
    };
    assert!((until - (0.5 + half)).abs() < 1e-6 && (hole - 1.0).abs() < 1e-12);
}

#[test]
fn a_line_that_touches_the_singular_circle_changes_branch() {
    let (at, fault) = fault(&free_rrr(), (-3.0, 1.0), (3.0, 1.0));
    let BranchFault::BranchChange { slope } = fault else { panic!("{fault}") };
    // Near x = 0 it is cos q2 = -1 + x²/24, so that q2 passes π with slope 1/√12 rad/m.
    assert!((slope - 1.0 / 12.0_f64.sqrt()).abs() < 1e-9, "{slope}");
    assert!((at - 0.5).abs() < 1e-7, "{at}");
}

#[test]
fn a_line_that_passes_near_the_singular_circle_is_refused_with_the_sine() {
    let (at, fault) = fault(&free_rrr(), (-3.0, 1.002), (3.0, 1.002));
    let BranchFault::NearSingular { sine, .. } = fault else { panic!("{fault}") };
    let cosine = (1.002_f64.powi(2) - 25.0) / 24.0;
    assert!((sine - (1.0 - cosine * cosine).sqrt()).abs() < 1e-9, "{sine}");
    assert!((at - 0.5).abs() < 1e-4, "{at}");
    // Outwards along a ray the least sine is at the end.
    let (at, fault) = self::fault(&free_rrr(), (5.0, 0.0), (6.998, 0.0));
    let BranchFault::NearSingular { sine, .. } = fault else { panic!("{fault}") };
    let cosine = (6.998_f64.powi(2) - 25.0) / 24.0;
    assert!((sine - (1.0 - cosine * cosine).sqrt()).abs() < 1e-9 && (at - 1.0).abs() < 1e-9);
}

#[test]
fn a_limit_on_the_way_comes_before_the_singularity_behind_it() {
    let (at, fault) = fault(&rrr(), (-3.0, 1.0), (3.0, 1.0));
    let BranchFault::Limit { joint, limit, excess, .. } = fault else { panic!("{fault}") };
    assert_eq!(joint, "elbow");
    assert!((limit.to_degrees() - 170.0).abs() < 1e-9 && excess > 0.0);
    let x = (24.0 * (1.0 + 170.0_f64.to_radians().cos())).sqrt();
    assert!((at - (3.0 - x) / 6.0).abs() < 1e-6, "{at}");
}

#[test]
fn a_quill_beyond_its_stroke_is_located() {
    let robot = scara();
    let from = [0.3, 1.0, -0.2, 2.0];
    let down = pose([0.0, 0.0, -0.2], [0.0; 3]) * robot.world_from_tool(&from);
    let Err(LineError::Branch { at, fault: BranchFault::Limit { joint, value, limit, excess, .. } }) =
        line(&robot, &from, &down, 1.0, None)
    else {
        panic!("a quill cannot go to -0.4 m")
    };
    assert_eq!(joint, "quill");
    assert!((at - 0.65).abs() < 1e-12 && (value + 0.4).abs() < 1e-12);
    assert!((limit + 0.33).abs() < 1e-12 && (excess - 0.07).abs() < 1e-12);
}

#[test]
fn a_tilted_goal_is_out_of_reach() {
    let robot = scara();
    let from = [0.3, 1.0, -0.2, 2.0];
    let tilted = robot.world_from_tool(&from) * pose([0.0; 3], [0.0, 0.2, 0.0]);
    let Err(LineError::Branch { fault: BranchFault::OutOfReach { bound, .. }, .. }) =
        line(&robot, &from, &tilted, 1.0, None)
    else {
        panic!("a SCARA cannot tilt its tool")
    };
    assert!(matches!(bound, Unreachable::Tilted { .. }));
}

/// Largest distance (m) and angle (rad) between the tool and where the law wants it on the path, sampled.
fn deviation(robot: &RobotModel, found: &PathMotion, path: &ToolPath) -> (f64, f64) {
    let mut worst = (0.0_f64, 0.0_f64);
    let samples = 40 * found.motion.piece_count() as u32;
    for k in 0..=samples {
        let t = (found.motion.duration() * f64::from(k) / f64::from(samples)).min(found.motion.duration());
        let tool = robot.world_from_tool(&found.motion.eval(t).q);
        let s = found.law.eval(t.min(found.law.duration())).q[0].clamp(path.start(), path.end());
        let wanted = path.pose(s);
        worst.0 = worst.0.max((tool.translation.vector - wanted.translation.vector).norm());
        worst.1 = worst.1.max(tool.rotation.angle_to(&wanted.rotation));
    }
    worst
}

/// What holds of every line, whatever the arm.
fn check_line(robot: &RobotModel, from: &[f64], goal: &Pose, share: f64) -> Result<(), TestCaseError> {
    let found = match line(robot, from, goal, share, None) {
        Ok(found) => found,
        // The arm cannot follow every line that can be drawn.
        Err(LineError::Branch { at, .. }) => {
            prop_assert!((0.0..=1.0).contains(&at));
            return Err(TestCaseError::reject("the arm cannot follow"));
        }
        Err(other) => return Err(TestCaseError::fail(other.to_string())),
    };
    let motion = &found.motion;
    prop_assert!(motion.breaks().is_empty(), "{:?}", motion.breaks());
    let (start, end) = (motion.eval(0.0), motion.eval(motion.duration()));
    for (joint, &from) in from.iter().enumerate() {
        prop_assert!((start.q[joint] - from).abs() < 1e-9);
        prop_assert!(start.qd[joint].abs().max(end.qd[joint].abs()) < 1e-9);
        prop_assert!(start.qdd[joint].abs().max(end.qdd[joint].abs()) < 1e-8);
    }
    let arrived = robot.world_from_tool(&end.q);
    prop_assert!((arrived.translation.vector - goal.translation.vector).norm() < 1e-9);
    prop_assert!(arrived.rotation.angle_to(&goal.rotation) < 1e-9);
    let path = straight_line(&robot.world_from_tool(from), goal).unwrap();
    let (distance, angle) = deviation(robot, &found, &path);
    let bound = found.deviation();
    prop_assert!(bound.position <= 1e-5 && bound.angle <= 1e-5, "{bound:?}");
    prop_assert!(distance <= bound.position, "{distance} beyond the proved {bound:?}");
    // An angle between quaternions is rounded to the root of their rounding.
    prop_assert!(angle <= bound.angle.max(1e-7), "{angle} beyond the proved {bound:?}");
    prop_assert!(bound.position < 3.0 * distance + 1e-11, "{distance} far below the proved {bound:?}");
    let mut used: f64 = 0.0;
    for (joint, limits) in robot.joints.iter().map(|joint| joint.limits).enumerate() {
        for (order, limit) in [(1, limits.velocity), (2, limits.acceleration), (3, limits.jerk)] {
            used = used.max(motion.peak(joint, order).value.abs() / (share * limit));
        }
    }
    prop_assert!(used <= 1.0 + 1e-12 && used > 1.0 - 1e-8, "{used}");
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 100,
        max_global_rejects: 100_000,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn rrr_lines_keep_limits_and_reach_one(
        q in [-2.0..2.0, 0.3..2.8, -1.5..1.5],
        dx in -2.0..2.0, dy in -2.0..2.0, turn in -1.0..1.0,
        share in 0.2..1.0,
    ) {
        let robot = rrr();
        let from = robot.world_from_tool(&q);
        let goal = Pose::from_parts(
            (from.translation.vector + nalgebra::Vector3::new(dx, dy, 0.0)).into(),
            pose([0.0; 3], [0.0, 0.0, turn]).rotation * from.rotation,
        );
        check_line(&robot, &q, &goal, share)?;
    }

    #[test]
    fn scara_lines_keep_limits_and_reach_one(
        q in [-1.2..1.2, -1.9..1.9, -0.3..0.0, 1.0..15.0],
        dx in -0.2..0.2, dy in -0.2..0.2, dz in -0.1..0.1, turn in -1.5..1.5,
        share in 0.2..1.0,
    ) {
        let robot = scara();
        let from = robot.world_from_tool(&q);
        let goal = Pose::from_parts(
            (from.translation.vector + nalgebra::Vector3::new(dx, dy, dz)).into(),
            pose([0.0; 3], [0.0, 0.0, turn]).rotation * from.rotation,
        );
        check_line(&robot, &q, &goal, share)?;
    }
}

#[test]
fn a_line_takes_few_pieces() {
    let robot = scara();
    for (length, most) in [(0.1, 14), (0.3, 40)] {
        let start = robot.inverse(&pose([0.3, -0.15, 0.2], [0.0, std::f64::consts::FRAC_PI_2, 0.0])).unwrap();
        let start = start.into_iter().find(|solution| solution.is_legal() && solution.turn == 1).unwrap().q;
        let goal = pose([0.0, length, 0.0], [0.0; 3]) * robot.world_from_tool(&start);
        let found = line(&robot, &start, &goal, 1.0, None).unwrap();
        let path = straight_line(&robot.world_from_tool(&start), &goal).unwrap();
        let (pieces, proved) = (found.motion.piece_count(), found.deviation().position);
        println!("{length} m: {pieces} pieces, {:.2e} m of {proved:.2e}", deviation(&robot, &found, &path).0);
        assert!(pieces <= most, "{length} m: {pieces} pieces");
    }
}

#[test]
fn a_turn_of_the_wrist_alone_is_exact() {
    let robot = scara();
    let from = [0.3, 1.0, -0.2, 2.0];
    let goal = robot.world_from_tool(&from) * pose([0.0; 3], [0.7, 0.0, 0.0]);
    let motion = line(&robot, &from, &goal, 1.0, None).unwrap().motion;
    let end = motion.eval(motion.duration()).q;
    assert_eq!(end[..3], from[..3]);
    assert!((end[3] - (2.0 - 0.7)).abs() < 1e-12, "{}", end[3]);
    for joint in 0..3 {
        assert_eq!(motion.peak(joint, 1).value, 0.0);
    }
}

#[test]
fn a_duration_is_exact() {
    let robot = scara();
    let from = [0.3, 1.0, -0.2, 2.0];
    let goal = pose([-0.03, 0.05, 0.0], [0.0; 3]) * robot.world_from_tool(&from);
    let motion = line(&robot, &from, &goal, 1.0, Some(0.777)).unwrap().motion;
    assert_eq!(motion.duration(), 0.777);
    assert!(line(&robot, &from, &goal, 1.0, Some(0.0)).is_err());
    assert!(line(&robot, &from, &goal, 0.0, None).is_err());
}
