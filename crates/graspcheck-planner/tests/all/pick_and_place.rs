//! Picks on both arms, from task to plan.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]
#![expect(clippy::float_cmp, reason = "these values must be met to the last digit")]

use crate::robots::{bench_with_wall, cell, cube, pace, pose, rrr, rrr_pick, scara, scara_pick};
use graspcheck_model::{
    Pose,
    object::Object,
    plan::{Holding, Plan},
    robot::{Joint, RobotModel},
    task::{PhasePace, PickAndPlace, Task},
};
use graspcheck_planner::{
    CandidateOutcome, PlanError, branch::BranchFault, candidate::Stage, find, opening::SQUEEZE, plan,
};

/// Distance (m) and angle (rad) between two poses.
fn apart(a: &Pose, b: &Pose) -> f64 {
    let distance = (a.translation.vector - b.translation.vector).norm();
    distance.max(a.rotation.angle_to(&b.rotation))
}

/// The largest share of the robot's limits that a plan uses in a phase, over all joints and orders.
fn utilisation(robot: &RobotModel, plan: &Plan, phase: &str) -> f64 {
    let phase = plan.phases.iter().find(|p| p.name == phase).unwrap();
    let mut most: f64 = 0.0;
    for (joint, Joint { limits, .. }) in robot.joints.iter().enumerate() {
        for (order, limit) in [(1, limits.velocity), (2, limits.acceleration), (3, limits.jerk)] {
            let peak = plan.trajectory.peaks_in(joint, order, phase.start, phase.end);
            most = most.max(peak.value.abs() / limit);
        }
    }
    most
}

/// What every plan of a pick must keep.
fn check_pick(robot: &RobotModel, object: &Object, task: &PickAndPlace, share: f64, plan: &Plan) {
    assert!(plan.trajectory.breaks().is_empty(), "{:?}", plan.trajectory.breaks());
    assert!(plan.opening.breaks().is_empty(), "{:?}", plan.opening.breaks());
    let names: Vec<&str> = plan.phases.iter().map(|phase| phase.name.as_str()).collect();
    assert_eq!(names, ["approach", "descend", "close", "lift", "carry", "lower", "open", "retreat"]);
    assert_eq!(plan.phases[0].start, 0.0);
    for pair in plan.phases.windows(2) {
        assert_eq!(pair[0].end, pair[1].start);
    }
    assert_eq!(plan.phases[7].end, plan.duration());
    assert_eq!(plan.opening.duration(), plan.duration());
    let grasp = plan.grasp.as_ref().unwrap();
    let tool_at = |t: f64| robot.world_from_tool(&plan.trajectory.eval(t).q);
    let phase = |name: &str| plan.phases.iter().find(|phase| phase.name == name).unwrap();

    // The start, and the object where it is grasped and put down.
    assert_eq!(plan.trajectory.eval(0.0).q, task.start);
    for t in [phase("close").start, phase("close").end] {
        let world_from_object = tool_at(t) * grasp.tool_from_object;
        assert!(apart(&world_from_object, &object.world_from_object) < 1e-9);
    }
    for t in [phase("open").start, phase("open").end] {
        let world_from_object = tool_at(t) * grasp.tool_from_object;
        assert!(apart(&world_from_object, &task.world_from_placed) < 1e-9);
    }

    // Ends of the straight moves.
    let grasp_pose = tool_at(phase("close").start);
    let pregrasp = grasp_pose * pose([-task.pregrasp_distance, 0.0, 0.0], [0.0; 3]);
    assert!(apart(&tool_at(phase("descend").start), &pregrasp) < 1e-9);
    let lifted = tool_at(phase("lift").end).translation.vector - grasp_pose.translation.vector;
    assert!((lifted - task.departure).norm() < 1e-9);
    let place_pose = tool_at(phase("open").start);
    let arrives = tool_at(phase("lower").start).translation.vector - place_pose.translation.vector;
    assert!((arrives - task.arrival).norm() < 1e-9);
    let retreat = place_pose * pose([-task.retreat_distance, 0.0, 0.0], [0.0; 3]);
    assert!(apart(&tool_at(plan.duration()), &retreat) < 1e-9);

    // Straight moves are straight everywhere, also between the places that the planner compared.
    for name in ["descend", "lift", "lower", "retreat"] {
        let (start, end) = (phase(name).start, phase(name).end);
        let (from, to) = (tool_at(start), tool_at(end));
        let along = (to.translation.vector - from.translation.vector).normalize();
        for k in 0..=997 {
            let tool = tool_at(start + (end - start) * f64::from(k) / 997.0);
            let way = tool.translation.vector - from.translation.vector;
            let beside = (way - along * way.dot(&along)).norm();
            assert!(beside < 1e-5, "{name}: {beside} m beside the line");
            assert!(tool.rotation.angle_to(&from.rotation) < 1e-5, "{name}: the tool turns");
        }
    }

    // Limits: kept everywhere, and the tightest reached in every phase that moves.
    for name in ["approach", "descend", "lift", "carry", "lower", "retreat"] {
        let used = utilisation(robot, plan, name) / share;
        assert!(used <= 1.0 + 1e-12 && used > 1.0 - 1e-8, "{name} uses {used} of its share");
    }
    for (joint, Joint { limits, .. }) in robot.joints.iter().enumerate() {
        let [low, high] = plan.trajectory.position_range(joint, 0.0, plan.duration());
        assert!(low >= limits.position_min - 1e-9 && high <= limits.position_max + 1e-9);
    }

    // The gripper.
    assert_eq!(
        grasp.opening,
        (grasp.width + 2.0 * robot.gripper.free_opening).min(robot.gripper.opening_max)
    );
    for phase in &plan.phases {
        let held = grasp.width - SQUEEZE;
        let (start, end) = match phase.holding {
            Holding::Closing => (grasp.opening, held),
            Holding::Held => (held, held),
            Holding::Opening => (held, grasp.opening),
            _ => (grasp.opening, grasp.opening),
        };
        assert!((plan.opening.eval(phase.start).q[0] - start).abs() < 1e-15);
        assert!((plan.opening.eval(phase.end).q[0] - end).abs() < 1e-15);
    }
}

#[test]
fn scara_picks_a_cube_over_a_wall() {
    let robot = scara();
    let (object, task) = scara_pick();
    let planned =
        find(&robot, &bench_with_wall(), Some(&object), &Task::PickAndPlace(task.clone()), &pace(0.9));
    let planned = planned.unwrap();
    check_pick(&robot, &object, &task, 0.9, &planned.plan);
    let certificate = planned.certificate.as_ref().unwrap();
    assert!(certificate.is_free(), "{:?}", certificate.violations().map(|(_, v)| v).collect::<Vec<_>>());
    assert_eq!(planned.candidates[0].outcome, CandidateOutcome::Chosen);
    // Two handles, each with a half turn, two elbows and three turns, at grasp and at place.
    assert!(planned.candidates.len() >= 4, "{}", planned.candidates.len());
    // All others take longer or are not clear.
    for candidate in &planned.candidates[1..] {
        match &candidate.outcome {
            CandidateOutcome::Slower { by } => assert!(*by > -1e-9),
            CandidateOutcome::Chosen => panic!("only one can be chosen"),
            _ => {}
        }
    }
}

#[test]
fn the_quill_alone_moves_exactly() {
    let robot = scara();
    let (object, task) = scara_pick();
    let plan =
        plan(&robot, &bench_with_wall(), Some(&object), &Task::PickAndPlace(task), &pace(1.0)).unwrap();
    for name in ["descend", "lift", "lower", "retreat"] {
        let phase = plan.phases.iter().find(|phase| phase.name == name).unwrap();
        for joint in [0, 1, 3] {
            let [low, high] = plan.trajectory.position_range(joint, phase.start, phase.end);
            assert_eq!(low, high, "{name}: joint {joint} moves");
            for order in 1..=3 {
                assert_eq!(plan.trajectory.peaks_in(joint, order, phase.start, phase.end).value, 0.0);
            }
        }
        // A jerk of constant magnitude in each of seven phases, or fewer: cubics.
        let pieces = plan.trajectory.piece_at(phase.start)..=plan.trajectory.piece_at(phase.end - 1e-9);
        assert!(pieces.clone().count() <= 7);
        for piece in pieces {
            assert!(plan.trajectory.piece(piece, 2).degree() <= 3);
        }
    }
}

#[test]
fn rrr_picks_in_its_plane() {
    let robot = rrr();
    let (object, task) = rrr_pick(0.4);
    let cell = cell(0.02, &[("post", [0.2, 0.2, 0.4], [6.5, 3.0, 0.0])]);
    let planned = find(&robot, &cell, Some(&object), &Task::PickAndPlace(task.clone()), &pace(0.8)).unwrap();
    check_pick(&robot, &object, &task, 0.8, &planned.plan);
    let certificate = planned.certificate.as_ref().unwrap();
    assert!(certificate.is_free(), "{:?}", certificate.violations().map(|(_, v)| v).collect::<Vec<_>>());
    // A half turn about the approach would turn the tool upside down, which a planar arm cannot.
    assert!(
        planned
            .candidates
            .iter()
            .any(|candidate| candidate.half_turn
                && matches!(candidate.outcome, CandidateOutcome::OutOfReach(_)))
    );
}

#[test]
fn same_task_same_plan() {
    let (object, task) = scara_pick();
    let task = Task::PickAndPlace(task);
    let once = find(&scara(), &bench_with_wall(), Some(&object), &task, &pace(0.9)).unwrap();
    let twice = find(&scara(), &bench_with_wall(), Some(&object), &task, &pace(0.9)).unwrap();
    assert_eq!(once, twice);
}

#[test]
fn zero_distances_make_no_phase() {
    let (object, mut task) = scara_pick();
    task.pregrasp_distance = 0.0;
    task.departure.fill(0.0);
    task.retreat_distance = 0.0;
    let cell = cell(0.0, &[]);
    let plan = plan(&scara(), &cell, Some(&object), &Task::PickAndPlace(task), &pace(0.9)).unwrap();
    let names: Vec<&str> = plan.phases.iter().map(|phase| phase.name.as_str()).collect();
    assert_eq!(names, ["approach", "close", "carry", "lower", "open"]);
    assert!(plan.trajectory.breaks().is_empty());
}

#[test]
fn a_phase_with_a_duration_lasts_exactly_that_even_past_limits() {
    let robot = scara();
    let (object, task) = scara_pick();
    let task = Task::PickAndPlace(task);
    let mut pace = pace(0.9);
    pace.phases = vec![
        PhasePace { phase: "carry".to_owned(), share: None, duration: Some(0.2), ..PhasePace::default() },
        PhasePace { phase: "lift".to_owned(), share: Some(0.4), duration: None, ..PhasePace::default() },
    ];
    let plan = plan(&robot, &bench_with_wall(), Some(&object), &task, &pace).unwrap();
    let carry = plan.phases.iter().find(|phase| phase.name == "carry").unwrap();
    assert!((carry.end - carry.start - 0.2).abs() < 1e-14);
    assert!(utilisation(&robot, &plan, "carry") > 1.5);
    let lift = utilisation(&robot, &plan, "lift");
    assert!(lift <= 0.4 + 1e-12 && lift > 0.4 - 1e-8, "{lift}");
    assert!(plan.trajectory.breaks().is_empty());
}

#[test]
fn what_is_not_clear_is_returned_and_named() {
    let (object, task) = scara_pick();
    // A wall as high as the arm, right across the way.
    let cell = cell(0.002, &[("wall", [0.6, 0.02, 0.5], [0.5, 0.0, 0.25])]);
    let planned = find(&scara(), &cell, Some(&object), &Task::PickAndPlace(task), &pace(0.9)).unwrap();
    assert!(!planned.certificate.unwrap().is_free());
    assert_eq!(planned.candidates[0].outcome, CandidateOutcome::Chosen);
    let second = &planned.candidates[1].outcome;
    assert!(
        matches!(second, CandidateOutcome::TooNear { a, b, .. } if a == "wall" || b == "wall"),
        "{second}"
    );
    // The fastest of all is the one that is returned.
    let fastest = planned.candidates[0].moving.unwrap();
    assert!(planned.candidates.iter().filter_map(|c| c.moving).all(|moving| moving > fastest - 1e-9));
}

#[test]
fn an_object_too_near_the_base_is_explained() {
    let (_, task) = scara_pick();
    // As in the look-and-feel notes: the wrist would be 199.2 mm from the shoulder axis.
    let object = cube([0.19, -0.06, 0.015], 0.0);
    let error = plan(&scara(), &cell(0.0, &[]), Some(&object), &Task::PickAndPlace(task), &pace(0.9));
    let Err(PlanError::Unreachable(nothing)) = error else { panic!("{error:?}") };
    let wrist = nothing.wrist.unwrap();
    assert!(!wrist.placing);
    assert!((wrist.distance - 0.199_248_588).abs() < 1e-9, "{}", wrist.distance);
    assert!((wrist.reach.inner - 0.229_128_785).abs() < 1e-9);
    assert!((wrist.reach.outer - 0.45).abs() < 1e-12);
    let to = object.world_from_object.translation.vector + wrist.shift.unwrap();
    assert!((to.xy().norm() - wrist.reach.inner).abs() < 1e-12, "{to}");
    assert!((to.x - 0.2185).abs() < 1e-4 && (to.y + 0.0690).abs() < 1e-4, "{to}");
    // 2 handles, each with a half turn, on 2 elbows with 3 turns: the elbow is 8.9° beyond 120° in all.
    let at_grasp: Vec<_> = nothing.candidates.iter().filter(|c| c.grasp.is_some()).collect();
    assert_eq!(at_grasp.len(), 24);
    for candidate in at_grasp {
        let CandidateOutcome::Limit { joint, value, limit, excess } = &candidate.outcome else {
            panic!("{}", candidate.outcome)
        };
        assert_eq!(joint, "elbow");
        assert!((limit.abs().to_degrees() - 120.0).abs() < 1e-9);
        assert!((value.abs().to_degrees() - 128.9).abs() < 0.05);
        assert!((excess.to_degrees() - 8.9).abs() < 0.05);
    }
    let message = nothing.to_string();
    assert!(message.starts_with("object cube at (0.1900, -0.0600, 0.0150) m: none of "), "{message}");
    assert!(message.contains("elbow"), "{message}");
    assert!(message.ends_with("try (0.2185, -0.0690, 0.0150) m, 0.0299 m away"), "{message}");
}

#[test]
fn a_place_out_of_reach_is_blamed_on_the_place() {
    let (object, mut task) = scara_pick();
    task.world_from_placed = pose([0.4, 0.3, 0.015], [0.0; 3]);
    let error = plan(&scara(), &cell(0.0, &[]), Some(&object), &Task::PickAndPlace(task), &pace(0.9));
    let Err(PlanError::Unreachable(nothing)) = error else { panic!("{error:?}") };
    assert!(nothing.wrist.unwrap().placing);
    assert!(nothing.candidates.iter().all(|candidate| candidate.grasp.is_none()));
    assert!(nothing.to_string().contains("placed at (0.4000, 0.3000, 0.0150) m"), "{nothing}");
}

#[test]
fn tasks_that_make_no_sense_are_errors_that_teach() {
    let robot = scara();
    let (object, task) = scara_pick();
    let empty = cell(0.0, &[]);
    let message = |change: &dyn Fn(&mut PickAndPlace, &mut Object)| {
        let (mut task, mut object) = (task.clone(), object.clone());
        change(&mut task, &mut object);
        plan(&robot, &empty, Some(&object), &Task::PickAndPlace(task), &pace(0.9)).unwrap_err().to_string()
    };
    assert_eq!(message(&|task, _| task.start.truncate(3)), "start: 3 joint positions for an arm of 4 joints");
    assert_eq!(
        message(&|task, _| task.pregrasp_distance = -0.1),
        "pre-grasp distance, m: -0.1 must be finite and not negative"
    );
    assert_eq!(message(&|task, _| task.departure.x = f64::NAN), "departure, m: NaN must be finite");
    assert_eq!(
        message(&|task, _| task.grip_force = 25.0),
        "gripper: grip force 25 N is not above 0 N and at most the fingers' 20 N"
    );
    assert_eq!(
        message(&|task, _| task.close_duration = 0.1),
        "gripper: phase close: finger speed 0.1500 m/s exceeds 0.0600 m/s; give it at least 0.2500 s"
    );
    assert_eq!(
        message(&|_, object| object.handles[0].width = 0.08),
        "gripper: handle side y: width 0.08 m leaves no room in the gripper, which opens 0.07 m; use another \
         handle or gripper"
    );
    assert!(message(&|_, object| object.handles.clear()).starts_with("object cube: has no handle"));
    let nothing = plan(&robot, &empty, None, &Task::PickAndPlace(task.clone()), &pace(0.9)).unwrap_err();
    assert_eq!(nothing, PlanError::NoObject);
}

#[test]
fn the_first_way_that_is_clear_is_chosen() {
    let robot = scara();
    let (object, task) = scara_pick();
    let task = Task::PickAndPlace(task);
    let open = find(&robot, &cell(0.002, &[]), Some(&object), &task, &pace(0.9)).unwrap();
    assert_eq!(open.plan.grasp.unwrap().handle, "side y");
    // A pin where a finger would go down beside the cube's y face leaves its x faces free.
    let pin = object.world_from_object * nalgebra::Point3::new(0.0, 0.03, 0.005);
    let pinned = cell(0.002, &[("pin", [0.004, 0.004, 0.03], pin.coords.into())]);
    let planned = find(&robot, &pinned, Some(&object), &task, &pace(0.9)).unwrap();
    assert!(planned.certificate.unwrap().is_free());
    assert_eq!(planned.plan.grasp.unwrap().handle, "side x");
    let chosen = &planned.candidates[0];
    assert_eq!((&chosen.outcome, chosen.handle.as_str()), (&CandidateOutcome::Chosen, "side x"));
    let first = &planned.candidates[1];
    assert!(first.moving.unwrap() < chosen.moving.unwrap() + 1e-9 && first.handle == "side y");
    let (CandidateOutcome::TooNear { a, b, .. } | CandidateOutcome::Undecided { a, b }) = &first.outcome
    else {
        panic!("{}", first.outcome)
    };
    assert!((a.starts_with("finger") || b.starts_with("finger")) && (a == "pin" || b == "pin"), "{a} {b}");
}

#[test]
fn a_half_turn_of_the_gripper_leaves_the_object_as_it_is() {
    let robot = scara();
    let (object, mut task) = scara_pick();
    let mut turned = [false, false];
    for wrist in [1.0, 2.5, 4.0, 5.5, 7.0] {
        task.start[3] = wrist;
        let pick = Task::PickAndPlace(task.clone());
        let planned = find(&robot, &bench_with_wall(), Some(&object), &pick, &pace(0.9)).unwrap();
        // Object poses at grasp and place are checked in there.
        check_pick(&robot, &object, &task, 0.9, &planned.plan);
        turned[usize::from(planned.candidates[0].half_turn)] = true;
    }
    assert_eq!(turned, [true, true], "both must have been looked at");
}

#[test]
fn an_approach_from_out_of_reach_is_located_on_the_way_to_the_grasp() {
    let robot = rrr();
    let (mut object, mut task) = rrr_pick(std::f64::consts::PI);
    let outcome = |object: &Object, task: &PickAndPlace| {
        let pick = Task::PickAndPlace(task.clone());
        let error = plan(&robot, &cell(0.0, &[]), Some(object), &pick, &pace(1.0)).unwrap_err();
        let PlanError::Unreachable(nothing) = error else { panic!("{error}") };
        // Not those at the place, nor the half turns, which a planar arm cannot make.
        let candidates = nothing.candidates.into_iter();
        candidates.filter(|c| c.grasp.is_some()).map(|c| (c.stage, c.outcome)).next().unwrap()
    };
    // The tool points along −x, so the wrist is 1 m further out: 6.5 m at the grasp, 7.3 m before it.
    object.world_from_object = pose([5.5, 0.0, 0.0], [0.0, 0.0, std::f64::consts::PI]);
    task.pregrasp_distance = 0.8;
    let (stage, CandidateOutcome::Line { at, fault }) = outcome(&object, &task) else {
        panic!("the approach must fail")
    };
    let BranchFault::OutOfReach { until, .. } = fault else { panic!("{fault}") };
    assert_eq!(stage, Stage::Descend);
    assert!(at.abs() < 1e-9 && (until - 0.375).abs() < 1e-6, "{at} {until}");
    // At 6.998 m before it the arm is too straight there, at the beginning of the approach.
    task.pregrasp_distance = 0.498;
    let (_, CandidateOutcome::Line { at, fault }) = outcome(&object, &task) else {
        panic!("the approach must fail")
    };
    assert!(matches!(fault, BranchFault::NearSingular { .. }) && at.abs() < 1e-9, "{at}: {fault}");
}
