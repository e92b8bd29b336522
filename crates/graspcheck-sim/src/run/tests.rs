//! Runs of the step loop: moves, lifts, collisions, and what is refused.

use super::simulate;
use crate::{
    SimError,
    fixtures::{self, Lift},
};
use graspcheck_model::{
    Pose, execution::Controller, execution::Execution, plan::Holding, plan::Plan, robot::RobotModel,
};
use graspcheck_model::{
    plan::{Phase, PlanFault},
    shape::Shape,
};
use graspcheck_recording::Recording;
use graspcheck_recording::{ContactSample, Level};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

fn run(robot: &RobotModel, gravity: Vector3<f64>, plan: &Plan, execution: &Execution) -> Recording {
    simulate(robot, &fixtures::empty_cell(gravity), None, plan, execution, &mut |_, _| {}).unwrap()
}

fn run_lift(lift: &Lift, execution: &Execution) -> Result<Recording, SimError> {
    simulate(&lift.robot, &lift.cell, Some(&lift.object), &lift.plan, execution, &mut |_, _| {})
}

/// The largest |measured − commanded| position of the arm's joints.
fn worst_error(recording: &Recording, dof: usize) -> f64 {
    (0..recording.measured.len())
        .flat_map(|row| {
            let measured = &recording.measured.position_row(row)[..dof];
            measured.iter().zip(recording.reference.position_row(row)).map(|(a, b)| (a - b).abs())
        })
        .fold(0.0, f64::max)
}

/// The largest |effort| of a joint.
fn peak_effort(series: &graspcheck_recording::JointSeries, joint: usize) -> f64 {
    (0..series.len()).map(|row| series.effort_row(row)[joint].abs()).fold(0.0, f64::max)
}

fn pose(row: &[f64; 7]) -> Pose {
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(row[6], row[3], row[4], row[5]));
    Isometry3::from_parts(Translation3::new(row[0], row[1], row[2]), rotation)
}

fn tool_from_object(recording: &Recording, row: usize) -> Pose {
    pose(&recording.tool.pose[row]).inverse() * pose(&recording.object.pose[row])
}

fn scara_move() -> Plan {
    fixtures::move_plan(&[0.0, 0.0, -0.05, 0.0], &[(1.0, vec![1.1, 1.7, -0.25, 3.0])])
}

#[test]
fn computed_torque_follows_a_quintic_on_both_arms() {
    let execution = fixtures::execution();
    let recording = run(&fixtures::scara(), fixtures::GRAVITY, &scara_move(), &execution);
    let error = worst_error(&recording, 4);
    assert!(error < 5e-4, "scara: {error}");
    assert!(recording.monitor.iter().all(|row| row.saturated_joints == 0));

    let plan = fixtures::move_plan(&[0.3, 0.5, -0.4], &[(2.0, vec![1.0, 1.2, 0.3])]);
    for gravity in [fixtures::GRAVITY, Vector3::new(0.0, -9.81, 0.0)] {
        let recording = run(&fixtures::rrr(), gravity, &plan, &execution);
        let error = worst_error(&recording, 3);
        assert!(error < 5e-4, "rrr: {error}");
        assert!(recording.monitor.iter().all(|row| row.tool_error_m < 1e-3));
    }
}

#[test]
fn friction_and_damping_are_fed_forward() {
    let mut robot = fixtures::scara();
    for (joint, friction) in robot.joints.iter_mut().zip([4.0, 1.5, 6.0, 0.05]) {
        joint.friction = friction;
        joint.damping = friction / 5.0;
    }
    let recording = run(&robot, fixtures::GRAVITY, &scara_move(), &fixtures::execution());
    let error = worst_error(&recording, 4);
    assert!(error < 5e-4, "{error}");
    let without = run(&fixtures::scara(), fixtures::GRAVITY, &scara_move(), &fixtures::execution());
    assert!(peak_effort(&recording.measured, 0) > peak_effort(&without.measured, 0) + 3.0);
}

#[test]
fn a_torque_limit_shows_as_saturation_and_not_as_a_larger_torque() {
    let mut robot = fixtures::scara();
    let free = run(&robot, fixtures::GRAVITY, &scara_move(), &fixtures::execution());
    let peak = peak_effort(&free.reference, 0);
    robot.joints[0].limits.effort = 1.01 * peak;
    let above = run(&robot, fixtures::GRAVITY, &scara_move(), &fixtures::execution());
    assert!(above.monitor.iter().all(|row| row.saturated_joints == 0));

    let limit = 0.8 * peak;
    robot.joints[0].limits.effort = limit;
    let below = run(&robot, fixtures::GRAVITY, &scara_move(), &fixtures::execution());
    let saturated = below.monitor.iter().filter(|row| row.saturated_joints > 0).count();
    assert!(saturated > 50, "{saturated} steps");
    assert!((peak_effort(&below.measured, 0) - limit).abs() < 1e-12);
    assert!(peak_effort(&below.reference, 0) > limit);
    assert!(below.monitor.iter().any(|row| row.torque_ratio > 1.0));
    assert!(worst_error(&below, 4) > 2.0 * worst_error(&free, 4));
}

#[test]
fn friction_holds_the_cube_while_it_is_lifted() {
    let lift = fixtures::lift(10.0);
    let recording = run_lift(&lift, &fixtures::execution()).unwrap();
    let (lift_begins, end) = (500, recording.measured.len() - 1);
    let grip = recording.monitor[lift_begins].grip_force_n;
    assert!((9.5..10.5).contains(&grip), "{grip} N before the lift");
    let held = tool_from_object(&recording, lift_begins);
    for row in lift_begins..=end {
        let moved = held.inverse() * tool_from_object(&recording, row);
        let slip = moved.translation.vector.norm();
        assert!(slip < 5e-5, "slip {slip} m at {row} ms");
        assert!(moved.rotation.angle() < 1e-3);
    }
    let height = recording.object.pose[end][2] - recording.object.pose[0][2];
    assert!((height - 0.1).abs() < 1e-4, "lifted by {height} m");
    assert!((recording.monitor[end].opening_m - fixtures::CUBE).abs() < 2e-4);
    // At rest the model of the held cube is right: the quill bears the weight without error.
    assert!(recording.monitor[end].tool_error_m < 1e-6);
}

/// Contacts are predicted up to 2 mm. One that is predicted and does not come must not act: the cube is
/// carried 0.8 mm above the table and slips no more than when the table is out of reach.
#[test]
fn a_table_just_below_the_held_cube_does_not_hold_it_back() {
    let slip_above = |gap: f64, prediction: f64| {
        let mut lift = fixtures::lift(10.0);
        let low = lift.plan.trajectory.eval(0.0).q;
        let mut high = low.clone();
        high[2] += gap;
        let mut aside = high.clone();
        aside[0] += 0.15;
        let legs = [(0.5, low.clone()), (0.5, high), (0.5, aside.clone()), (1.0, aside)];
        lift.plan.trajectory = fixtures::through(&low, &legs);
        lift.cell.bodies[0].shape = Shape::Box { half_extents: Vector3::new(0.3, 0.3, 0.05) };
        let mut execution = fixtures::execution();
        execution.contact.prediction = prediction;
        let recording = run_lift(&lift, &execution).unwrap();
        let carried = 1_000_000_000;
        assert!(!recording.contacts.iter().any(|row| row.time_ns > carried && row.body_b == "table"));
        let held = tool_from_object(&recording, 500);
        (held.inverse() * tool_from_object(&recording, 2500)).translation.vector.norm()
    };
    let [near, near_unpredicted, far] =
        [(8e-4, 2e-3), (8e-4, 2e-4), (5e-3, 2e-3)].map(|(gap, prediction)| slip_above(gap, prediction));
    assert!((near - near_unpredicted).abs() < 1e-9, "{near} m is not {near_unpredicted} m");
    assert!(near < 1e-5 && far < 1e-5, "{near} m, {far} m");
}

/// A planar arm takes the cube off a pedestal narrower than itself and swings it through a quarter.
#[test]
fn friction_holds_the_cube_along_an_arc() {
    let robot = fixtures::rrr();
    let start = vec![0.3, 0.5, -0.4];
    let end = vec![1.0, 1.2, 0.3];
    let mut plan = fixtures::lift(10.0).plan;
    plan.trajectory =
        fixtures::through(&start, &[(0.5, start.clone()), (1.5, end.clone()), (0.5, end.clone())]);
    let world_from_tool = robot.world_from_tool(&start);
    let middle = world_from_tool.translation.vector;
    let mut pedestal = fixtures::table(middle.x, middle.y, middle.z - fixtures::CUBE / 2.0);
    pedestal.shape = Shape::Box { half_extents: Vector3::new(0.01, 0.01, 0.05) };
    let mut cell = fixtures::empty_cell(fixtures::GRAVITY);
    cell.bodies.push(pedestal);
    let lift = Lift { robot, cell, object: fixtures::cube(world_from_tool), plan };
    let recording = run_lift(&lift, &fixtures::execution()).unwrap();
    // Without the correction of the arc the cube creeps by 5 mm.
    let held = tool_from_object(&recording, 500);
    for row in 500..recording.measured.len() {
        let moved = held.inverse() * tool_from_object(&recording, row);
        let slip = moved.translation.vector.norm();
        assert!(slip < 5e-5, "slip {slip} m at {row} ms");
    }
    let far = pose(&recording.object.pose[2500]).translation.vector - middle;
    assert!(far.norm() > 3.0);
}

#[test]
fn coulombs_limit_decides_whether_the_cube_is_lifted() {
    // Two pads with friction 0.8 bear 0.1 kg · (9.81 + 0.58) m/s² from 0.65 N each.
    for (force, lifted) in [(0.4, false), (0.6, false), (0.75, true)] {
        let recording = run_lift(&fixtures::lift(force), &fixtures::execution()).unwrap();
        let end = recording.measured.len() - 1;
        let slip = tool_from_object(&recording, end).translation.vector.norm();
        let height = recording.object.pose[end][2] - recording.object.pose[0][2];
        if lifted {
            assert!(slip < 1e-4, "{force} N: slip {slip} m");
        } else {
            assert!(slip > 0.005, "{force} N: slip {slip} m");
            assert!(height < 0.095, "{force} N: lifted by {height} m");
        }
    }
}

#[test]
fn a_placed_cube_stays_where_it_was_put() {
    let mut lift = fixtures::lift(10.0);
    let low = lift.plan.trajectory.eval(0.0).q;
    let mut high = low.clone();
    high[2] += 0.1;
    let legs = [&low, &high, &low, &low, &high].map(|q| (0.5, q.clone()));
    lift.plan.trajectory = fixtures::through(&low, &legs);
    let (open, below) = (fixtures::CUBE + 0.02, fixtures::CUBE - 0.004);
    let openings = [below, below, below, open, open].map(|opening| (0.5, vec![opening]));
    lift.plan.opening = fixtures::through(&[open], &openings);
    let holdings = [Holding::Closing, Holding::Held, Holding::Held, Holding::Opening, Holding::Placed];
    lift.plan.phases = holdings
        .into_iter()
        .enumerate()
        .map(|(index, holding)| Phase {
            name: format!("{index} {holding:?}"),
            start: 0.5 * index as f64,
            end: 0.5 * (index + 1) as f64,
            holding,
        })
        .collect();
    let recording = run_lift(&lift, &fixtures::execution()).unwrap();
    let end = recording.measured.len() - 1;
    let moved = pose(&recording.object.pose[0]).inverse() * pose(&recording.object.pose[end]);
    assert!(moved.translation.vector.norm() < 1e-4, "{}", moved.translation.vector.norm());
    assert!(moved.rotation.angle() < 1e-3, "{}", moved.rotation.angle());
    assert!(recording.object.pose[1000][2] > recording.object.pose[0][2] + 0.099);
    assert!((recording.monitor[end].opening_m - open).abs() < 1e-6);
    let touching: Vec<_> = recording
        .contacts
        .iter()
        .filter(|row| row.time_ns == recording.monitor[end].time_ns)
        .map(|row| (row.body_a.as_str(), row.body_b.as_str()))
        .collect();
    assert_eq!(touching, [("cube", "table")]);
}

#[test]
fn the_same_run_twice_gives_the_same_recording() {
    let lift = fixtures::lift(10.0);
    let first = run_lift(&lift, &fixtures::execution()).unwrap();
    let second = run_lift(&lift, &fixtures::execution()).unwrap();
    assert!(first == second);
}

#[test]
fn rows_frames_and_events_are_on_the_time_base() {
    let lift = fixtures::lift(10.0);
    let mut reports = Vec::new();
    let recording = simulate(
        &lift.robot,
        &lift.cell,
        Some(&lift.object),
        &lift.plan,
        &fixtures::execution(),
        &mut |done, total| reports.push((done, total)),
    )
    .unwrap();
    // 2.5 s of plan, 0.2 s at rest, and the row at the end.
    assert_eq!(recording.measured.len(), 2701);
    let names = ["shoulder", "elbow", "quill", "wrist", "finger_left_slide", "finger_right_slide"];
    assert_eq!(recording.measured.names, names);
    assert_eq!(recording.measured.time_ns[1234], 1_234_000_000);
    for times in [&recording.reference.time_ns, &recording.tool.time_ns, &recording.object.time_ns] {
        assert_eq!(times, &recording.measured.time_ns);
    }
    assert_eq!(recording.reference.position.len(), 6 * 2701);
    assert_eq!((recording.monitor[499].phase, recording.monitor[500].phase), (0, 1));
    let frames: Vec<(&str, usize)> =
        recording.frames.iter().map(|frame| (frame.child.as_str(), frame.pose.len())).collect();
    let moving = ["upper_arm", "forearm", "spindle", "hand", "finger_left", "finger_right", "cube", "tool"];
    let expected: Vec<(&str, usize)> =
        [("column", 1)].into_iter().chain(moving.map(|name| (name, 271))).collect();
    assert_eq!(frames, expected);
    let events: Vec<(i64, Level, &str, &str)> = recording
        .events
        .iter()
        .map(|event| (event.time_ns, event.level, event.source.as_str(), event.message.as_str()))
        .collect();
    assert_eq!(
        events,
        [
            (0, Level::Info, "phase", "close"),
            (500_000_000, Level::Info, "phase", "lift"),
            (1_500_000_000, Level::Info, "phase", "hold"),
        ]
    );
    assert_eq!(reports.last(), Some(&(2700, 2700)));
}

#[test]
fn contacts_name_their_bodies_in_order_and_balance_the_weight() {
    let lift = fixtures::lift(10.0);
    let recording = run_lift(&lift, &fixtures::execution()).unwrap();
    assert!(recording.contacts.iter().all(|row| row.body_a < row.body_b));
    assert!(recording.contacts.iter().all(|row| row.normal_force_n > 0.0 || row.depth_m > 0.0));
    let at = |time_ns| recording.contacts.iter().filter(move |row| row.time_ns == time_ns);
    let standing: Vec<_> = at(200_000_000).collect();
    assert_eq!(standing.len(), 1);
    assert_eq!((standing[0].body_a.as_str(), standing[0].body_b.as_str()), ("cube", "table"));
    assert!((standing[0].normal_force_n - 0.981).abs() < 0.01, "{}", standing[0].normal_force_n);
    assert!((Vector3::from(standing[0].normal) + Vector3::z()).norm() < 1e-3, "normal from cube to table");
    let carried: Vec<_> = at(2_000_000_000).map(|row| row.body_b.as_str()).collect();
    assert_eq!(carried, ["finger_left", "finger_right"]);
    for row in at(2_000_000_000) {
        let lever = Vector3::from(row.point) - pose(&recording.object.pose[2000]).translation.vector;
        let along = lever.dot(&Vector3::from(row.normal));
        assert!((along - fixtures::CUBE / 2.0).abs() < 1e-3, "the point is on the face: {along}");
    }
}

#[test]
fn an_arm_that_runs_into_a_wall_is_recorded_to_the_end() {
    let robot = fixtures::scara();
    let mut cell = fixtures::empty_cell(fixtures::GRAVITY);
    let mut wall = fixtures::table(0.2, 0.3, 0.6);
    wall.name = "wall".to_owned();
    cell.bodies.push(wall);
    let plan = scara_move();
    let recording = simulate(&robot, &cell, None, &plan, &fixtures::execution(), &mut |_, _| {}).unwrap();
    assert!(recording.contacts.iter().any(|row| row.body_b == "wall" && row.normal_force_n > 1.0));
    assert!(recording.monitor.iter().any(|row| row.tool_error_m > 0.01));
    assert_eq!(recording.measured.len(), 1201);
}

/// The planar arm with its hand folded back beside its upper arm; it then turns the hand into it.
fn folding_arm() -> (RobotModel, Plan) {
    let start = [0.0, 2.9, 0.8];
    (fixtures::rrr(), fixtures::move_plan(&start, &[(2.0, vec![0.0, 2.9, 1.8])]))
}

#[test]
fn an_arm_that_touches_itself_is_recorded() {
    let (mut robot, plan) = folding_arm();
    let recording = run(&robot, fixtures::GRAVITY, &plan, &fixtures::execution());
    let touch = |recording: &Recording| {
        let on_itself = |row: &&ContactSample| row.body_a.contains("finger") && row.body_b == "link1";
        recording.contacts.iter().find(on_itself).map(|row| (row.time_ns, row.normal_force_n))
    };
    let (time_ns, force) = touch(&recording).expect("the fingers meet the upper arm");
    assert!(force > 0.01 && (500_000_000..2_000_000_000).contains(&time_ns), "{force} N at {time_ns} ns");
    // Bodies that may pass through each other do: no other pair of the arm is found.
    assert!(recording.contacts.iter().all(|row| row.body_b == "link1" || row.body_a == "link1"));
    for finger in ["finger_left", "finger_right", "link3"] {
        robot.allowed_contacts.push(graspcheck_model::robot::AllowedContact {
            a: "link1".to_owned(),
            b: finger.to_owned(),
            reason: "for the test".to_owned(),
        });
    }
    let recording = run(&robot, fixtures::GRAVITY, &plan, &fixtures::execution());
    assert_eq!(recording.contacts, []);
}

#[test]
fn the_monitor_counts_the_contacts_of_its_step() {
    let recording = run_lift(&fixtures::lift(10.0), &fixtures::execution()).unwrap();
    for row in &recording.monitor {
        let there = recording.contacts.iter().filter(|contact| contact.time_ns == row.time_ns).count();
        assert_eq!(row.contacts as usize, there, "at {} ns", row.time_ns);
    }
}

#[test]
fn a_body_that_could_pass_through_another_in_one_step_ends_the_run() {
    let robot = fixtures::rrr();
    let mut cell = fixtures::empty_cell(fixtures::GRAVITY);
    let mut sheet = fixtures::table(20.0, 20.0, 0.0);
    sheet.name = "sheet".to_owned();
    sheet.shape = Shape::Box { half_extents: Vector3::new(1.0, 1.0, 0.0005) };
    cell.bodies.push(sheet);
    // The tip moves at up to 15/8 · 8 m · 1 rad / 1.2 s: 12.5 mm in a step of 1 ms.
    let plan = fixtures::move_plan(&[0.0, 0.0, 0.0], &[(1.2, vec![1.0, 0.0, 0.0])]);
    let mut execution = fixtures::execution();
    let run = |execution: &Execution| simulate(&robot, &cell, None, &plan, execution, &mut |_, _| {});
    match run(&execution) {
        Err(SimError::StepTooLong { a, b, moved, thickness, .. }) => {
            assert!(a.contains("finger") && b == "sheet", "{a} - {b}");
            assert!((thickness - 0.011).abs() < 1e-12 && moved > thickness && moved < 0.013, "{moved}");
        }
        other => panic!("{:?}", other.err()),
    }
    execution.dt = 5e-4;
    assert!(run(&execution).is_ok());
}

#[test]
fn fingers_that_cannot_follow_are_refused_and_not_cut_off() {
    let open = |from: f64, to: f64, duration: f64| {
        let mut lift = fixtures::lift(10.0);
        let rest = 2.5 - duration;
        lift.plan.opening = fixtures::through(&[from], &[(duration, vec![to]), (rest, vec![to])]);
        run_lift(&lift, &fixtures::execution())
    };
    // One finger moves by half: 15/8 · 0.012 m / 0.45 s is 0.05 m/s to the last digit.
    assert!(open(0.06, 0.036, 0.45).is_ok());
    match open(0.06, 0.036, 0.449) {
        Err(SimError::FingerSpeed { speed, speed_max, time }) => {
            assert!(speed > speed_max && speed < 1.003 * speed_max && (time - 0.2245).abs() < 1e-6);
        }
        other => panic!("{:?}", other.err()),
    }
    assert!(matches!(open(0.0801, 0.08, 1.0), Err(SimError::Opening { time: 0.0, .. })));
    assert!(matches!(open(0.06, -0.001, 1.5), Err(SimError::Opening { .. })));
}

#[test]
fn an_object_that_starts_inside_something_is_an_error_with_the_depth() {
    let mut lift = fixtures::lift(10.0);
    lift.object.world_from_object.translation.vector.z -= 0.003;
    match run_lift(&lift, &fixtures::execution()) {
        Err(SimError::StartsInPenetration { object, other, depth, .. }) => {
            assert_eq!((object.as_str(), other.as_str()), ("cube", "table"));
            assert!((depth - 0.003).abs() < 1e-9, "{depth}");
        }
        other => panic!("{:?}", other.err()),
    }
}

#[test]
fn the_margin_is_that_of_the_nearest_pair_that_may_not_touch() {
    let robot = fixtures::scara();
    let mut cell = fixtures::empty_cell(fixtures::GRAVITY);
    let mut floor = fixtures::table(0.45, 0.0, 0.12);
    floor.name = "floor".to_owned();
    cell.bodies.push(floor);
    let q = vec![0.0, 0.0, -0.15, 0.0];
    let plan = fixtures::move_plan(&q, &[(0.1, q.clone())]);
    let mut execution = fixtures::execution();
    execution.settle = 0.0;
    let recording = simulate(&robot, &cell, None, &plan, &execution, &mut |_, _| {}).unwrap();
    // Finger tips at 0.4 - 0.15 - 0.1 - 0.015 m, floor at 0.12 m, required 5 mm.
    for row in &recording.monitor {
        match row.clearance_margin_m {
            Some(margin) => assert!((margin - 0.01).abs() < 1e-5, "{margin}"),
            None => assert_ne!(row.time_ns % 10_000_000, 0, "computed every 10 ms"),
        }
    }
}

type Change = dyn Fn(&mut Execution);
type Spoil<'a> = dyn Fn(&mut Lift) + 'a;

#[test]
fn what_does_not_fit_together_is_a_typed_error() {
    let lift = fixtures::lift(10.0);
    let error = |change: &dyn Fn(&mut Lift, &mut Execution)| {
        let mut lift = fixtures::lift(10.0);
        let mut execution = fixtures::execution();
        change(&mut lift, &mut execution);
        run_lift(&lift, &execution).unwrap_err()
    };
    assert_eq!(error(&|_, execution| execution.dt = 0.003), SimError::Step { dt: 0.003 });
    let settings: [(&str, &Change); 5] = [
        ("substeps", &|execution| execution.substeps = 0),
        ("settle", &|execution| execution.settle = -1.0),
        ("controller bandwidth", &|execution| {
            execution.controller = Controller::ComputedTorque { bandwidth: 0.0, damping_ratio: 1.0 };
        }),
        ("contact frequency", &|execution| execution.contact.frequency = f64::NAN),
        ("contact friction", &|execution| execution.contact.friction = f64::INFINITY),
    ];
    for (name, change) in settings {
        match error(&|_, execution| change(execution)) {
            SimError::Setting { setting, .. } => assert_eq!(setting, name),
            other => panic!("{other}"),
        }
    }
    let two_joints = fixtures::through(&[0.0, 0.0], &[(2.5, vec![0.0, 0.0])]);
    let plans: [(&str, &Spoil<'_>); 3] = [
        ("the number of joints", &|lift| lift.plan.trajectory = two_joints.clone()),
        ("the number of openings", &|lift| lift.plan.opening = two_joints.clone()),
        ("the end of the last phase", &|lift| lift.plan.phases.clear()),
    ];
    for (part, spoil) in plans {
        match error(&|lift, _| spoil(lift)) {
            SimError::Plan(PlanFault { what, .. }) => assert_eq!(what, part),
            other => panic!("{other}"),
        }
    }
    let without = simulate(&lift.robot, &lift.cell, None, &lift.plan, &fixtures::execution(), &mut |_, _| {});
    assert_eq!(without, Err(SimError::GraspWithoutObject { handle: "sides".to_owned() }));
}

#[test]
fn a_run_of_too_many_steps_is_refused_before_it_begins() {
    let robot = fixtures::scara();
    let mut execution = fixtures::execution();
    execution.settle = 1e6;
    let plan = fixtures::move_plan(&[0.0; 4], &[(0.5, vec![0.1; 4])]);
    let cell = fixtures::empty_cell(fixtures::GRAVITY);
    let error = simulate(&robot, &cell, None, &plan, &execution, &mut |_, _| {}).unwrap_err();
    assert!(matches!(error, SimError::TooManySteps { .. }), "{error}");
    assert!(error.to_string().contains("settle"), "{error}");
}
