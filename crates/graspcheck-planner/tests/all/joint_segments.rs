//! Joint moves one after the other.

#![expect(clippy::float_cmp, reason = "these values must be met to the last digit")]

use crate::robots::{cell, cube, pace, scara};
use graspcheck_model::{
    plan::Holding,
    task::{JointSegment, JointSegments, PhasePace, Task},
};
use graspcheck_planner::{PlanError, plan};

fn segment(name: &str, from: [f64; 4], to: [f64; 4]) -> JointSegment {
    JointSegment { name: name.to_owned(), from: from.to_vec(), to: to.to_vec() }
}

const A: [f64; 4] = [0.0, 0.5, -0.1, 1.0];
const B: [f64; 4] = [0.8, -0.5, -0.2, 2.0];
const C: [f64; 4] = [0.8, 1.0, 0.0, 0.0];

#[test]
fn segments_that_fit_join_without_a_break() {
    let task =
        Task::JointSegments(JointSegments { segments: vec![segment("out", A, B), segment("up", B, C)] });
    let plan = plan(&scara(), &cell(0.0, &[]), None, &task, &pace(0.7)).unwrap();
    assert!(plan.trajectory.breaks().is_empty());
    let names: Vec<&str> = plan.phases.iter().map(|phase| phase.name.as_str()).collect();
    assert_eq!(names, ["out", "up"]);
    assert!(plan.phases.iter().all(|phase| phase.holding == Holding::Nothing));
    assert_eq!(plan.trajectory.eval(0.0).q, A);
    assert_eq!(plan.trajectory.eval(plan.duration()).q.len(), 4);
    for (got, expected) in plan.trajectory.eval(plan.phases[0].end).q.iter().zip(B) {
        assert!((got - expected).abs() < 1e-12);
    }
    assert_eq!(plan.opening.eval(0.0).q, [scara().gripper.opening_max]);
    assert!(plan.grasp.is_none());
}

#[test]
fn a_segment_that_begins_elsewhere_is_left_as_a_jump() {
    let elsewhere = [0.8, -0.4, -0.2, 2.0];
    let segments = vec![segment("out", A, B), segment("up", elsewhere, C)];
    let task = Task::JointSegments(JointSegments { segments });
    let cube = cube([0.3, 0.0, 0.015], 0.0);
    let plan = plan(&scara(), &cell(0.0, &[]), Some(&cube), &task, &pace(1.0)).unwrap();
    let [jump] = plan.trajectory.breaks() else { panic!("{:?}", plan.trajectory.breaks()) };
    assert_eq!((jump.order, plan.trajectory.knots()[jump.knot]), (0, plan.phases[0].end));
    assert!((jump.jump[1] - 0.1).abs() < 1e-12 && jump.jump[0].abs() < 1e-12);
    assert!(plan.phases.iter().all(|phase| phase.holding == Holding::AtStart));
}

#[test]
fn bad_segments_are_errors_that_name_the_segment() {
    let robot = scara();
    let empty = cell(0.0, &[]);
    let error = |segments: Vec<JointSegment>| {
        let task = Task::JointSegments(JointSegments { segments });
        plan(&robot, &empty, None, &task, &pace(1.0)).unwrap_err()
    };
    assert_eq!(error(vec![]), PlanError::NoSegment);
    let mut short = segment("out", A, B);
    short.to.pop();
    assert_eq!(error(vec![short]).to_string(), "segment out, to: 3 joint positions for an arm of 4 joints");
    let mut infinite = segment("out", A, B);
    infinite.from[1] = f64::INFINITY;
    assert_eq!(error(vec![infinite]).to_string(), "segment out, from, joint 1: inf must be finite");
}

#[test]
fn pace_is_checked_against_the_segments() {
    let task = Task::JointSegments(JointSegments { segments: vec![segment("out", A, B)] });
    let mut pace = pace(1.0);
    pace.phases.push(PhasePace {
        phase: "carry".to_owned(),
        share: None,
        duration: None,
        ..PhasePace::default()
    });
    let error = plan(&scara(), &cell(0.0, &[]), None, &task, &pace).unwrap_err();
    assert_eq!(error.to_string(), "pace: phase carry: the task has no such phase, only out");
    pace.phases[0] =
        PhasePace { phase: "out".to_owned(), share: None, duration: Some(2.5), ..PhasePace::default() };
    assert_eq!(plan(&scara(), &cell(0.0, &[]), None, &task, &pace).unwrap().duration(), 2.5);
}
