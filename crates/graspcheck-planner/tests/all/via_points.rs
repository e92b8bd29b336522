//! The RRR example of the worked examples, section 6: four via points, blends of 0.5 s.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]
#![expect(clippy::float_cmp, reason = "these values must be met to the last digit")]

use crate::robots::{cell, pace, pose, rrr};
use graspcheck_model::{
    inverse::PlanarWrist,
    plan::{Plan, TrackedPoint},
    planar_path::PlanarPath,
    robot::RobotModel,
    task::{CartesianVia, Elbow, PhasePace, Task, ViaPoint},
    via::{Blend, BlendEnds, EndCondition, ParabolicBlends, PointBlends, ViaLaw},
};
use graspcheck_planner::{PlanError, branch::BranchFault, plan};
use graspcheck_proof::deviation::{Deviation, DeviationOutcome, prove_deviation};
use nalgebra::Point2;

fn example(elbow: Elbow) -> CartesianVia {
    let point = |t: f64, x: f64, y: f64, theta: f64| ViaPoint {
        t,
        wrist: Point2::new(x, y),
        theta: theta.to_radians(),
    };
    let points = vec![
        point(0.0, -4.0, 0.0, 90.0),
        point(2.0, 0.0, 3.0, 45.0),
        point(4.0, 3.0, 3.0, 30.0),
        point(7.0, 4.0, 0.0, 0.0),
    ];
    CartesianVia { points, law: ViaLaw::blends_of(0.5, 4, 3), elbow, tolerance: 1e-5 }
}

fn planned(robot: &RobotModel, task: CartesianVia) -> Result<Plan, PlanError> {
    plan(robot, &cell(0.0, &[]), None, &Task::CartesianVia(task), &pace(1.0))
}

/// Wrist (m) and theta (degrees, literal) at time `t`, by forward kinematics.
fn wrist_at(robot: &RobotModel, plan: &Plan, t: f64) -> [f64; 3] {
    let PlanarWrist { position, theta } = robot.planar_wrist(&plan.trajectory.eval(t).q).unwrap();
    [position.x, position.y, theta.to_degrees()]
}

#[test]
fn wrist_passes_where_the_worked_example_says() {
    let robot = rrr();
    for elbow in [Elbow::Left, Elbow::Right] {
        let plan = planned(&robot, example(elbow)).unwrap();
        for (t, x, y, theta) in [
            (0.0, -4.0, 0.0, 90.0),
            (0.5, -3.428_571_428_6, 0.428_571_428_6, 83.571_428_571),
            (2.0, -11.0 / 224.0, 3.0 - 3.0 / 28.0, 45.0 + 255.0 / 224.0),
            (4.0, 3.0 - 25.0 / 352.0, 3.0 - 3.0 / 44.0, 30.0 - 75.0 / 352.0),
            (5.0, 3.363_636_363_6, 1.909_090_909_1, 19.090_909_091),
            (6.5, 3.909_090_909_1, 0.272_727_272_7, 2.727_272_727),
            (7.0, 4.0, 0.0, 0.0),
        ] {
            let got = wrist_at(&robot, &plan, t);
            assert!((got[0] - x).abs() < 1e-6, "{elbow:?}: x({t}) = {} is not {x}", got[0]);
            assert!((got[1] - y).abs() < 1e-6, "{elbow:?}: y({t}) = {} is not {y}", got[1]);
            assert!((got[2] - theta).abs() < 1e-6, "{elbow:?}: theta({t}) = {} is not {theta}", got[2]);
        }
    }
}

#[test]
fn inner_points_are_missed_by_the_blend() {
    let robot = rrr();
    let plan = planned(&robot, example(Elbow::Right)).unwrap();
    for (point, dx, dy) in [(1, 11.0 / 224.0, 3.0 / 28.0), (2, 25.0 / 352.0, 3.0 / 44.0)] {
        let via = example(Elbow::Right).points[point];
        let got = wrist_at(&robot, &plan, via.t);
        let miss = (got[0] - via.wrist.x).hypot(got[1] - via.wrist.y);
        assert!((miss - f64::hypot(dx, dy)).abs() < 1e-6, "{miss}");
    }
}

#[test]
fn joints_start_and_end_on_the_branch_that_was_asked_for() {
    for (elbow, start, end) in [
        (Elbow::Left, [135.951_374, 112.024_313, -157.975_687], [-44.048_626, 112.024_313, -67.975_687]),
        (Elbow::Right, [224.048_626, -112.024_313, -22.024_313], [44.048_626, -112.024_313, 67.975_687]),
    ] {
        let plan = planned(&rrr(), example(elbow)).unwrap();
        for (t, expected) in [(0.0, start), (plan.duration(), end)] {
            for (got, expected) in plan.trajectory.eval(t).q.iter().zip(expected) {
                assert!((got.to_degrees() - expected).abs() < 1e-6, "{elbow:?} at {t}: {}", got.to_degrees());
            }
        }
    }
}

#[test]
fn joint_peaks_are_those_of_the_worked_example() {
    let plans = [Elbow::Left, Elbow::Right].map(|elbow| planned(&rrr(), example(elbow)).unwrap());
    // The larger of both branches.
    for (joint, velocity, acceleration) in [(0, 1.19, 1.93), (1, 0.71, 1.64), (2, 0.94, 1.91)] {
        let peak = |order| {
            let of_plan = |plan: &Plan| plan.trajectory.peak(joint, order).value.abs();
            plans.iter().map(of_plan).fold(0.0, f64::max)
        };
        assert!((peak(1) - velocity).abs() < 0.005, "joint {joint}: {} rad/s", peak(1));
        assert!((peak(2) - acceleration).abs() < 0.005, "joint {joint}: {} rad/s²", peak(2));
    }
    let [lowest, _] = plans[0].trajectory.position_range(2, 0.0, 7.0);
    assert!((lowest.to_degrees() + 170.86).abs() < 0.005, "{}", lowest.to_degrees());
}

#[test]
fn only_the_acceleration_jumps_and_only_where_blends_meet_lines() {
    let plan = planned(&rrr(), example(Elbow::Right)).unwrap();
    let breaks: Vec<(f64, usize)> =
        plan.trajectory.breaks().iter().map(|b| (plan.trajectory.knots()[b.knot], b.order)).collect();
    let expected = [0.5, 1.75, 2.25, 3.75, 4.25, 6.5];
    assert_eq!(breaks.len(), expected.len(), "{breaks:?}");
    for ((time, order), expected) in breaks.into_iter().zip(expected) {
        assert!((time - expected).abs() < 1e-12);
        assert_eq!(order, 2);
    }
    let ends = [0.0, plan.duration()].map(|t| plan.trajectory.eval(t).qd);
    assert!(ends.iter().flatten().all(|qd| qd.abs() < 1e-12));
}

#[test]
fn the_wrist_stays_on_its_lines_and_parabolas_everywhere() {
    // x, y and theta as polynomials written down from the worked example's velocities and accelerations.
    let robot = rrr();
    let plan = planned(&robot, example(Elbow::Left)).unwrap();
    let expected = |t: f64, points: [f64; 4], v: [f64; 3], a: [f64; 4]| {
        let line = |k: usize, from: f64| points[k] + v[k] * (t - from);
        match t {
            t if t < 0.5 => points[0] + 0.5 * a[0] * t * t,
            t if t < 1.75 => line(0, 0.25),
            t if t < 2.25 => line(0, 0.25) + 0.5 * a[1] * (t - 1.75).powi(2),
            t if t < 3.75 => line(1, 2.0),
            t if t < 4.25 => line(1, 2.0) + 0.5 * a[2] * (t - 3.75).powi(2),
            t if t < 6.5 => line(2, 4.0),
            t => points[3] + 0.5 * a[3] * (7.0 - t).powi(2),
        }
    };
    let mut worst: f64 = 0.0;
    for k in 0..=7000 {
        let t = f64::from(k) / 1000.0;
        let [x, y, theta] = wrist_at(&robot, &plan, t.min(plan.duration()));
        let at_x = expected(
            t,
            [-4.0, 0.0, 3.0, 4.0],
            [16.0 / 7.0, 1.5, 4.0 / 11.0],
            [32.0 / 7.0, -11.0 / 7.0, -25.0 / 11.0, -8.0 / 11.0],
        );
        let at_y = expected(
            t,
            [0.0, 3.0, 3.0, 0.0],
            [12.0 / 7.0, 0.0, -12.0 / 11.0],
            [24.0 / 7.0, -24.0 / 7.0, -24.0 / 11.0, 24.0 / 11.0],
        );
        let at_theta = expected(
            t,
            [90.0, 45.0, 30.0, 0.0],
            [-180.0 / 7.0, -7.5, -120.0 / 11.0],
            [-360.0 / 7.0, 255.0 / 7.0, -75.0 / 11.0, 240.0 / 11.0],
        );
        worst = worst.max((x - at_x).hypot(y - at_y)).max((theta - at_theta).to_radians().abs());
    }
    assert!(worst < 1e-5, "{worst} m or rad");
}

#[test]
fn a_narrow_shoulder_makes_the_right_branch_infeasible() {
    let mut robot = rrr();
    robot.joints[0].limits.position_min = -std::f64::consts::PI;
    robot.joints[0].limits.position_max = std::f64::consts::PI;
    assert!(planned(&robot, example(Elbow::Left)).is_ok());
    let error = planned(&robot, example(Elbow::Right)).unwrap_err();
    // The last point can be reached, but in another turn of the shoulder.
    let PlanError::Via {
        elbow: Elbow::Right,
        at,
        fault: BranchFault::OtherBranch { joint, limit, same_elbow, .. },
    } = &error
    else {
        panic!("{error}")
    };
    assert_eq!((joint.as_str(), *same_elbow), ("shoulder", true));
    assert!((limit.to_degrees() + 180.0).abs() < 1e-9);
    assert!(*at > 0.0 && *at < 7.0);
}

#[test]
fn a_motion_out_of_reach_is_located_in_time() {
    let mut task = example(Elbow::Left);
    task.points[1].wrist = Point2::new(0.0, 9.0);
    let error = planned(&rrr(), task).unwrap_err();
    let PlanError::Via { at, fault: BranchFault::OutOfReach { until, .. }, .. } = error else {
        panic!("{error}")
    };
    // The wrist is 7 m from the shoulder: on the line from (-4, 0), as long as it has not begun to blend.
    let way = |t: f64| (t - 0.25) / 1.75;
    let distance = f64::hypot(-4.0 + 4.0 * way(at), 9.0 * way(at));
    assert!((distance - 7.0).abs() < 1e-6, "{distance} m at {at} s");
    assert!(until > 2.0 && until < 4.0, "{until}");
}

#[test]
fn a_first_point_beyond_a_limit_says_which() {
    let mut robot = rrr();
    robot.joints[2].limits.position_min = -1.0;
    robot.joints[2].limits.position_max = 1.0;
    let error = planned(&robot, example(Elbow::Left)).unwrap_err();
    let PlanError::ViaStart { reason: BranchFault::Limit { joint, .. }, .. } = &error else {
        panic!("{error}")
    };
    assert_eq!(joint, "wrist");
}

#[test]
fn a_duration_stretches_the_whole_motion() {
    let mut pace = pace(1.0);
    pace.phases.push(PhasePace {
        phase: "via".to_owned(),
        share: None,
        duration: Some(3.5),
        ..PhasePace::default()
    });
    let task = Task::CartesianVia(example(Elbow::Left));
    let fast = plan(&rrr(), &cell(0.0, &[]), None, &task, &pace).unwrap();
    let slow = planned(&rrr(), example(Elbow::Left)).unwrap();
    assert_eq!(fast.duration(), 3.5);
    let ratio = fast.trajectory.peak(0, 2).value / slow.trajectory.peak(0, 2).value;
    assert!((ratio - 4.0).abs() < 1e-9);
}

#[test]
fn the_plan_carries_the_path_of_the_wrist_and_it_is_proved_at_any_duration() {
    for askew in [pose([0.0; 3], [0.0; 3]), pose([0.3, -1.2, 0.5], [0.2, 0.1, 0.7])] {
        let mut robot = rrr();
        robot.world_from_base = askew;
        for duration in [None, Some(21.0)] {
            let mut pace = pace(1.0);
            let phase = PhasePace { phase: "via".into(), duration, ..PhasePace::default() };
            pace.phases = vec![phase];
            let task = Task::CartesianVia(example(Elbow::Left));
            let plan = plan(&robot, &cell(0.0, &[]), None, &task, &pace).unwrap();
            let [planned] = &plan.paths[..] else { panic!("one path") };
            assert_eq!((planned.point, planned.phase.as_str()), (TrackedPoint::Wrist, "via"));
            let path = PlanarPath::tracking(&robot, &planned.path, planned.point).unwrap();
            let tolerance = Deviation { position: 1e-5, angle: 1e-5 };
            let outcome = prove_deviation(&path, &planned.law, &plan.trajectory, tolerance).unwrap();
            assert!(outcome.bound().is_some_and(|bound| bound.position > 1e-9), "{outcome:?}");
            // As a path of the tool it is metres off.
            let of_tool = PlanarPath::new(&robot, &planned.path).unwrap();
            let outcome = prove_deviation(&of_tool, &planned.law, &plan.trajectory, tolerance).unwrap();
            assert!(matches!(outcome, DeviationOutcome::Exceeds { .. }));
        }
    }
}

#[test]
fn an_arm_that_stands_askew_follows_in_its_own_plane() {
    let mut robot = rrr();
    robot.world_from_base = pose([1.0, 2.0, 3.0], [std::f64::consts::FRAC_PI_2, 0.0, 0.7]);
    let plan = planned(&robot, example(Elbow::Left)).unwrap();
    let straight = planned(&rrr(), example(Elbow::Left)).unwrap();
    for t in [0.3, 2.1, 5.5] {
        for (a, b) in plan.trajectory.eval(t).q.iter().zip(straight.trajectory.eval(t).q) {
            assert!((a - b).abs() < 1e-9);
        }
    }
}

#[test]
fn a_scara_cannot() {
    let error = planned(&crate::robots::scara(), example(Elbow::Left)).unwrap_err();
    assert!(matches!(error, PlanError::NoInverse(_)), "{error}");
}

/// The example under another law.
fn under(law: ViaLaw, shift: f64) -> CartesianVia {
    let mut task = CartesianVia { law, ..example(Elbow::Left) };
    for point in &mut task.points {
        point.t += shift;
    }
    task
}

fn assert_wrist(robot: &RobotModel, plan: &Plan, t: f64, expected: [f64; 3]) {
    for (found, expected) in wrist_at(robot, plan, t).into_iter().zip(expected) {
        assert!((found - expected).abs() < 1e-5, "{found} is not {expected} at {t} s");
    }
}

#[test]
fn every_coordinate_can_have_blends_of_its_own() {
    // x by blend times, y by the accelerations that the worked example comes to, theta slower.
    let robot = rrr();
    let accelerations = [24.0 / 7.0, 24.0 / 7.0, 24.0 / 11.0, 24.0 / 11.0];
    let point = |acceleration| PointBlends {
        blends: vec![Blend::Duration(0.5), Blend::Acceleration(acceleration), Blend::Duration(1.0)],
        met: None,
        velocity: None,
    };
    let blends = ParabolicBlends { points: accelerations.map(point).to_vec(), ends: BlendEnds::Inside };
    let plan = planned(&robot, under(ViaLaw::ParabolicBlends(blends), 0.0)).unwrap();
    // Theta: -45/1.5, -7.5 and -30/2.5 degrees/s, so that the points are missed by 22.5/8 and -4.5/8 degrees.
    assert_wrist(&robot, &plan, 2.0, [-11.0 / 224.0, 3.0 - 3.0 / 28.0, 45.0 + 22.5 / 8.0]);
    assert_wrist(&robot, &plan, 4.0, [3.0 - 25.0 / 352.0, 3.0 - 3.0 / 44.0, 30.0 - 4.5 / 8.0]);
}

#[test]
fn with_centred_ends_every_line_has_its_mean_velocity() {
    let robot = rrr();
    let ViaLaw::ParabolicBlends(blends) = ViaLaw::blends_of(0.5, 4, 3) else { panic!() };
    let law = ViaLaw::ParabolicBlends(ParabolicBlends { ends: BlendEnds::Centred, ..blends });
    let plan = planned(&robot, under(law.clone(), 0.25)).unwrap();
    assert!((plan.duration() - 7.5).abs() < 1e-12);
    // From rest at the first point to rest at the last; on the first line in between at (2, 1.5, -22.5).
    assert_wrist(&robot, &plan, 0.0, [-4.0, 0.0, 90.0]);
    assert_wrist(&robot, &plan, 1.25, [-2.0, 1.5, 67.5]);
    assert_wrist(&robot, &plan, 7.5, [4.0, 0.0, 0.0]);
    // At its own time the first point is missed by a b²/8.
    assert_wrist(&robot, &plan, 0.25, [-3.875, 0.09375, 90.0 - 1.40625]);
    let error = planned(&robot, under(law, 0.0)).unwrap_err();
    assert_eq!(
        error.to_string(),
        "task cartesian_via: the motion would begin at -0.25 s, before the plan; every point must be due at \
         least 0.25 s later"
    );
}

#[test]
fn a_point_that_must_be_met_is_met() {
    let robot = rrr();
    let ViaLaw::ParabolicBlends(mut blends) = ViaLaw::blends_of(0.5, 4, 3) else { panic!() };
    blends.points[1].met = Some(0.3);
    let plan = planned(&robot, under(ViaLaw::ParabolicBlends(blends), 0.0)).unwrap();
    assert_wrist(&robot, &plan, 2.0, [0.0, 3.0, 45.0]);
    // On the line through it: the mean of the slopes in x and theta, 0 in y, where one slope is 0.
    assert_wrist(&robot, &plan, 2.04, [0.04 * 1.75, 3.0, 45.0 - 0.04 * 15.0]);
}

#[test]
fn a_spline_of_the_wrist_meets_all_points() {
    let robot = rrr();
    let plan = planned(&robot, under(ViaLaw::Spline(EndCondition::AtRest), 0.0)).unwrap();
    for ViaPoint { t, wrist, theta } in example(Elbow::Left).points {
        assert_wrist(&robot, &plan, t, [wrist.x, wrist.y, theta.to_degrees()]);
    }
    assert!(plan.trajectory.breaks().is_empty(), "{:?}", plan.trajectory.breaks());
}

#[test]
fn blends_that_do_not_fit_name_coordinate_segment_and_what_would_do() {
    let ViaLaw::ParabolicBlends(mut blends) = ViaLaw::blends_of(0.5, 4, 3) else { panic!() };
    blends.points[1].blends[1] = Blend::Acceleration(0.5);
    let error = planned(&rrr(), under(ViaLaw::ParabolicBlends(blends), 0.0)).unwrap_err();
    let text = error.to_string();
    assert!(
        text.starts_with("task cartesian_via: y: segment from point 1 to point 2: its blends take "),
        "{text}"
    );
    assert!(text.contains("raise the acceleration at point 2 to at least 0.571"), "{text}");
}

#[test]
fn a_start_on_the_negative_x_axis_is_one_whatever_the_sign_of_zero() {
    let plans = [0.0, -0.0].map(|y| {
        let mut task = example(Elbow::Left);
        task.points[0].wrist.y = y;
        planned(&rrr(), task).unwrap()
    });
    assert_eq!(plans[0].trajectory.eval(0.0), plans[1].trajectory.eval(0.0));
}

#[test]
fn a_task_in_an_older_log_is_read_and_todays_form_comes_back_as_it_is() {
    let task = Task::CartesianVia(example(Elbow::Left));
    let text = serde_json::to_string(&task).unwrap();
    assert_eq!(serde_json::from_str::<Task>(&text).unwrap(), task);
    // Older ones have one duration for all blends in the place of the law.
    let law = format!(r#""law":{}"#, serde_json::to_string(&ViaLaw::blends_of(0.5, 4, 3)).unwrap());
    assert!(text.contains(&law), "{text}");
    let older = text.replace(&law, r#""blend":0.5"#);
    assert_eq!(serde_json::from_str::<Task>(&older).unwrap(), task);
    assert!(serde_json::from_str::<Task>(&text.replace(&law, r#""blend":null"#)).is_err());
}
