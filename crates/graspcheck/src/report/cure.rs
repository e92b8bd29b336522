//! The least change that would cure a failure, where it can be computed.

use graspcheck_model::plan::Plan;
use graspcheck_model::robot::JointLimits;
use graspcheck_verify::{CheckResult, Outcome, Resolved};

use super::quantity::instant;

/// Kept away from the ends of a phase, as a share of it: at its very ends the derivatives of its neighbours
/// count, too.
const INSET: f64 = 1e-9;

/// What to write instead for a limit of velocity, acceleration or jerk that is broken in a phase of given
/// duration: the least duration that keeps all of them.
///
/// Failing that, how many times as long the whole motion must be given, where slower is a cure.
#[must_use]
pub(super) fn cure(result: &CheckResult, resolved: &Resolved, plan: &Plan) -> Option<String> {
    least_written(result, resolved, plan).or_else(|| slower(result, plan))
}

fn slower(result: &CheckResult, plan: &Plan) -> Option<String> {
    let stretch = result.stretch.filter(|_| result.outcome == Outcome::Fail)?;
    // Rounded up, so that what one reads suffices.
    let written = (stretch * 1e4).ceil() / 1e4;
    Some(format!(
        "{written} times as long, {} for the whole motion, keeps this limit",
        seconds(written * plan.duration())
    ))
}

fn least_written(result: &CheckResult, resolved: &Resolved, plan: &Plan) -> Option<String> {
    let is_of_time =
        ["planned.velocity", "planned.acceleration", "planned.jerk"].contains(&result.check.as_str());
    if result.outcome != Outcome::Fail || !is_of_time {
        return None;
    }
    let phase = result.place.phase.as_ref()?;
    let given = resolved.pace.phases.iter().find(|pace| pace.phase == *phase)?.duration?;
    let least = least_duration(resolved, plan, phase)?;
    // Rounded up to what one would write.
    let written = (least * 1e3).ceil() / 1e3;
    Some(format!(
        "[phase.{phase}] duration_s = {written}: {} is the least in which this phase keeps its limits, {} are given",
        seconds(least),
        instant(given)
    ))
}

fn seconds(value: f64) -> String {
    format!("{value:.4} s")
}

/// The least duration of a phase that keeps every joint's limits of velocity, acceleration and jerk, s.
///
/// The law of a phase keeps its shape when it is given more time: the k-th derivative goes as 1/Tᵏ. So it is
/// the duration times the largest of the k-th roots of peak over limit.
fn least_duration(resolved: &Resolved, plan: &Plan, phase: &str) -> Option<f64> {
    let phase = plan.phases.iter().find(|other| other.name == phase)?;
    let duration = phase.end - phase.start;
    let (start, end) = (phase.start + INSET * duration, phase.end - INSET * duration);
    let mut stretch: f64 = 0.0;
    for (joint, model) in resolved.robot.joints.iter().enumerate() {
        let JointLimits { velocity, acceleration, jerk, .. } = model.limits;
        for (order, limit) in [(1, velocity), (2, acceleration), (3, jerk)] {
            let [low, high] = plan.trajectory.range_in(joint, order, start, end);
            let share = low.value.abs().max(high.value.abs()) / limit;
            stretch = stretch.max(share.powf(1.0 / f64::from(u8::try_from(order).ok()?)));
        }
    }
    Some(stretch * duration)
}
