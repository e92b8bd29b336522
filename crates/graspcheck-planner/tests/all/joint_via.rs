//! Via points in joint space as a task.

use crate::robots::{cell, pace, rrr};
use graspcheck_model::{
    plan::{Holding, Plan},
    task::{JointVia, JointViaPoint, PhasePace, Task},
    via::{EndCondition, ViaLaw},
};
use graspcheck_motion::ContinuityClass;
use graspcheck_planner::{PlanError, plan};

const TIMES: [f64; 4] = [0.0, 2.0, 3.0, 5.0];
const POINTS: [[f64; 3]; 4] = [[0.0, 0.5, -1.0], [1.0, 1.0, 0.0], [0.25, 1.5, 0.5], [0.5, 1.0, 1.0]];

fn task(law: ViaLaw) -> JointVia {
    let point = |(t, q): (f64, [f64; 3])| JointViaPoint { t, q: q.to_vec() };
    JointVia { points: TIMES.into_iter().zip(POINTS).map(point).collect(), law }
}

fn planned(task: JointVia) -> Result<Plan, PlanError> {
    plan(&rrr(), &cell(0.0, &[]), None, &Task::JointVia(task), &pace(1.0))
}

#[test]
fn every_law_is_one_phase_that_passes_the_points() {
    for law in [
        ViaLaw::ImposedVelocities(vec![vec![0.0; 3], vec![0.1; 3], vec![-0.2; 3], vec![0.0; 3]]),
        ViaLaw::ComputedVelocities,
        ViaLaw::Spline(EndCondition::AtRest),
        ViaLaw::Spline(EndCondition::Natural),
        ViaLaw::Spline(EndCondition::NotAKnot),
        ViaLaw::VirtualPoints([0.5, 4.5]),
    ] {
        let plan = planned(task(law.clone())).unwrap();
        assert!((plan.duration() - 5.0).abs() < 1e-15);
        assert_eq!(plan.phases.len(), 1);
        assert_eq!((plan.phases[0].name.as_str(), plan.phases[0].holding), ("via", Holding::Nothing));
        for (t, q) in TIMES.into_iter().zip(POINTS) {
            for (found, expected) in plan.trajectory.eval(t).q.iter().zip(q) {
                assert!((found - expected).abs() < 1e-12, "{law:?} at {t} s");
            }
        }
    }
    let smooth = planned(task(ViaLaw::VirtualPoints([0.5, 4.5]))).unwrap();
    assert_eq!(smooth.trajectory.continuity().class, ContinuityClass::C2);
    assert!(smooth.trajectory.eval(0.0).qdd.iter().all(|&acceleration| acceleration == 0.0));
}

#[test]
fn blends_pass_near_the_points() {
    let plan = planned(task(ViaLaw::blends_of(0.4, 4, 3))).unwrap();
    // Joint 1: 0.5/1.8, 0.5 rad/s about the second point.
    let miss = (0.5 - 0.5 / 1.8) * 0.4 / 8.0;
    assert!((plan.trajectory.eval(2.0).q[1] - 1.0 - miss).abs() < 1e-12);
    assert_eq!(plan.trajectory.continuity().class, ContinuityClass::C1);
}

#[test]
fn a_duration_stretches_the_whole_motion() {
    let mut slow = pace(1.0);
    slow.phases.push(PhasePace {
        phase: "via".to_owned(),
        share: None,
        duration: Some(10.0),
        ..PhasePace::default()
    });
    let task = Task::JointVia(task(ViaLaw::ComputedVelocities));
    let plan = plan(&rrr(), &cell(0.0, &[]), None, &task, &slow).unwrap();
    assert!((plan.trajectory.eval(4.0).q[0] - 1.0).abs() < 1e-12);
}

#[test]
fn what_is_wrong_is_named() {
    let mut short = task(ViaLaw::ComputedVelocities);
    short.points[2].q.pop();
    assert_eq!(
        planned(short).unwrap_err().to_string(),
        "via point 3: 2 joint positions for an arm of 3 joints"
    );

    let mut late = task(ViaLaw::ComputedVelocities);
    late.points[2].t = 2.0;
    assert_eq!(
        planned(late).unwrap_err().to_string(),
        "task joint_via: point 3: time 2 s must be later than that of the point before it, 2 s"
    );
    assert_eq!(
        planned(task(ViaLaw::VirtualPoints([2.0, 4.5]))).unwrap_err().to_string(),
        "task joint_via: first virtual point: time 2 s must be later than 0 s and earlier than 2 s"
    );
    let open = planned(task(ViaLaw::Spline(EndCondition::Periodic))).unwrap_err().to_string();
    assert!(
        open.starts_with("task joint_via: point 4, joint 0: position 0.5 must be the first one, 0"),
        "{open}"
    );
    let blends = planned(task(ViaLaw::blends_of(1.5, 4, 3))).unwrap_err().to_string();
    assert!(blends.starts_with("task joint_via: shoulder: segment from point 1 to point 2"), "{blends}");
}
