//! Where the object, or its place, could be moved to so that there is a plan.
//!
//! A suggestion that fails when it is followed is worse than none. So places are tried, nearest first, in the
//! form in which they would be written down, and the first with a plan that is proved clear is suggested.

use std::f64::consts::TAU;

use graspcheck_model::task::Task;
use graspcheck_planner::{NothingReachable, PlanError};
use graspcheck_proof::Certificate;
use graspcheck_scenario::unsupported;
use graspcheck_verify::Resolved;
use nalgebra::Vector3;

/// How far beyond the bound of the reach places are tried, m: straight moves need some room there.
const BEYOND: [f64; 8] = [1e-3, 2e-3, 4e-3, 8e-3, 15e-3, 25e-3, 40e-3, 60e-3];

/// How far from the asked place others are tried when it is not known which way leads into reach, m. Arms
/// differ in size: these are shares of the largest reach.
const SHARES_OF_REACH: [f64; 6] = [0.0125, 0.025, 0.05, 0.1, 0.2, 0.4];

/// In how many directions.
const DIRECTIONS: u32 = 16;

/// A change of the scenario with which there is a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Nearby {
    /// Whether it is the place that moves, rather than the object.
    pub placing: bool,
    /// Where to, in the world, whole tenths of a millimetre where it differs from what was asked, m.
    pub at: Vector3<f64>,
    /// How far that is from where it was, m.
    pub moved: f64,
}

/// The changes, one of the object, one of its place, or both, with which there is a plan that is proved clear.
/// Empty when none was found.
#[must_use]
pub fn places(resolved: &Resolved, nothing: &NothingReachable) -> Vec<Nearby> {
    let mut changed = resolved.clone();
    let Some(first) = nearest(&mut changed, nothing) else { return Vec::new() };
    match first {
        Found::Plan(nearby) => vec![nearby],
        // The other end of the motion is out of reach, too.
        Found::Next(nearby, next) => match nearest(&mut changed, &next) {
            Some(Found::Plan(second)) => vec![nearby, second],
            _ => Vec::new(),
        },
    }
}

enum Found {
    /// There is a plan.
    Plan(Nearby),
    /// The object can be grasped there; for its place nothing can be reached.
    Next(Nearby, Box<NothingReachable>),
}

/// Moves what cannot be reached to the nearest of the places that are tried.
fn nearest(resolved: &mut Resolved, nothing: &NothingReachable) -> Option<Found> {
    let placing = nothing.wrist.is_some_and(|wrist| wrist.placing);
    let asked = if placing { nothing.world_from_placed } else { nothing.world_from_object };
    let asked = asked.translation.vector;
    for step in steps(resolved, nothing) {
        let at = asked + tenths(&step, &asked);
        if !move_to(resolved, placing, &at) {
            continue;
        }
        let nearby = Nearby { placing, at, moved: (at - asked).norm() };
        let Resolved { robot, cell, object, task, pace, .. } = &*resolved;
        match graspcheck_planner::find(robot, cell, object.as_ref(), task, pace) {
            Ok(planned) if planned.certificate.as_ref().is_none_or(Certificate::is_free) => {
                return Some(Found::Plan(nearby));
            }
            Err(PlanError::Unreachable(next))
                if !placing && next.wrist.is_some_and(|wrist| wrist.placing) =>
            {
                return Some(Found::Next(nearby, next));
            }
            _ => {}
        }
    }
    None
}

/// Moves to try, nearest first: straight into reach where that is known, then all around. They are level, so
/// that what stood on a body still does.
fn steps(resolved: &Resolved, nothing: &NothingReachable) -> Vec<Vector3<f64>> {
    let up = resolved.cell.gravity.try_normalize(0.0);
    let level = |step: Vector3<f64>| up.map_or(step, |up| step - up * step.dot(&up));
    let mut steps = Vec::new();
    let Some(wrist) = &nothing.wrist else { return steps };
    if let Some(shift) = wrist.shift {
        steps.extend(BEYOND.iter().map(|beyond| level(shift + shift.normalize() * *beyond)));
    }
    for share in SHARES_OF_REACH {
        for k in 0..DIRECTIONS {
            let (sin, cos) = (f64::from(k) / f64::from(DIRECTIONS) * TAU).sin_cos();
            steps.push(level(Vector3::new(cos, sin, 0.0) * share * wrist.reach.outer));
        }
    }
    steps
}

/// The step to the nearest place whose coordinates, where it moves along them, are whole tenths of a
/// millimetre.
fn tenths(step: &Vector3<f64>, from: &Vector3<f64>) -> Vector3<f64> {
    from.zip_map(step, |from, step| {
        let moves = step.abs() > 1e-9;
        if moves { ((from + step) * 1e4).round() / 1e4 - from } else { 0.0 }
    })
}

/// Moves the object or its place; false when the object would float there or be inside something.
fn move_to(resolved: &mut Resolved, placing: bool, at: &Vector3<f64>) -> bool {
    let Some(object) = &mut resolved.object else { return false };
    if !placing {
        object.world_from_object.translation.vector = *at;
        let bodies: Vec<_> = resolved.cell.bodies.iter().collect();
        return unsupported(object, &bodies, Some(&resolved.robot), &resolved.cell.gravity).is_none();
    }
    let Task::PickAndPlace(task) = &mut resolved.task else { return false };
    task.world_from_placed.translation.vector = *at;
    let mut placed = object.clone();
    placed.world_from_object = task.world_from_placed;
    let bodies: Vec<_> = resolved.cell.bodies.iter().collect();
    unsupported(&placed, &bodies, Some(&resolved.robot), &resolved.cell.gravity).is_none()
}
