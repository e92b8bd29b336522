//! `planned.torque`: no joint takes more than its effort limit at any instant of the plan, with what it holds.
//! Proved by bounds over stretches of time; see [`graspcheck_proof::torque`].
//!
//! What gravity takes stays when a motion is given more time; the rest goes as 1/k². The stretch that would cure a failure
//! is therefore found by proofs of stretched motions, and there is none when holding still takes too much.

use graspcheck_proof::{
    TorqueLimits, TorquePeak, keep_torque_limits,
    slower::stretched,
    torque::{TORQUE_TOLERANCE, torque_peaks},
};

use crate::{
    evidence::Evidence,
    finding::{Finding, Gap, worst_by},
    note::Note,
    verdict::Unit,
};

/// The tolerance, a share of the limit, to which a torque is known that comes so near to its limit that
/// [`TORQUE_TOLERANCE`] does not tell.
const FINE_TOLERANCE: f64 = 1e-4;

/// The joint that uses the largest share of its effort limit. While all keep theirs the value is a proved upper
/// bound; when one does not, what it takes at an instant at least.
pub(super) fn torque(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    for tolerance in [TORQUE_TOLERANCE, FINE_TOLERANCE] {
        let peaks = peaks(evidence, tolerance)?;
        let taken = findings(evidence, &peaks, |peak| peak.lower);
        if let Some(exceeds) = worst_by(taken.filter(|taken| !taken.passes), |taken| -taken.margin) {
            return Ok(match stretch(evidence) {
                Some(stretch) => Finding { stretch: Some(stretch), ..exceeds },
                None => exceeds.noted("slower is no cure: holding still takes too much"),
            });
        }
        let mut bounds = findings(evidence, &peaks, |peak| peak.upper);
        if bounds.all(|bound| bound.passes) {
            let bounds = findings(evidence, &peaks, |peak| peak.upper);
            let mut worst = worst_by(bounds, |bound| -bound.margin)
                .ok_or_else(|| Gap::inconclusive(None, "the arm has no joint"))?;
            worst.value_is_bound = true;
            return Ok(worst);
        }
    }
    let peaks = peaks(evidence, FINE_TOLERANCE)?;
    let near = worst_by(&peaks, |peak| peak.upper / limit(evidence, peak)).map(|peak| {
        let joint = &evidence.joints()[peak.joint];
        let unit = Unit::of_effort(joint.kind);
        let note = Note::from(format!("{}: its largest torque is between ", joint.name))
            .quantity(peak.lower, unit)
            .and(" and ")
            .quantity(peak.upper, unit)
            .and(if peak.is_settled { ", too near to the limit to tell" } else { "; the search gave up" });
        Gap::inconclusive(Some(peak.time), note)
    });
    Err(near.unwrap_or_else(|| Gap::inconclusive(None, "the arm has no joint")))
}

/// A motion that is given this many times as long takes what holding still takes, but for a few millionths.
const LARGEST_STRETCH: f64 = 1024.0;

/// To what share a stretch is found.
const STRETCH_TOLERANCE: f64 = 1e-3;

/// The least stretch of time, to a tolerance, for which the effort limits are proved to be kept.
fn stretch(evidence: &Evidence<'_>) -> Option<f64> {
    let resolved = &evidence.resolved;
    let (gravity, object) = (resolved.cell.gravity, resolved.object.as_ref());
    let is_kept = |stretch: f64| {
        let Ok(plan) = stretched(&evidence.plan, stretch) else { return false };
        keep_torque_limits(&resolved.robot, gravity, object, &plan, 1.0) == Ok(TorqueLimits::Kept)
    };
    let (mut broken, mut kept) = (1.0, 2.0);
    while !is_kept(kept) {
        (broken, kept) = (kept, 2.0 * kept);
        if kept > LARGEST_STRETCH {
            return None;
        }
    }
    while kept > broken * (1.0 + STRETCH_TOLERANCE) {
        let between = 0.5 * (broken + kept);
        if is_kept(between) { kept = between } else { broken = between }
    }
    Some(kept)
}

fn peaks(evidence: &Evidence<'_>, tolerance: f64) -> Result<Vec<TorquePeak>, Gap> {
    let resolved = &evidence.resolved;
    let (gravity, object) = (resolved.cell.gravity, resolved.object.as_ref());
    torque_peaks(&resolved.robot, gravity, object, &evidence.plan, tolerance)
        .map_err(|reason| Gap::inconclusive(None, reason))
}

fn limit(evidence: &Evidence<'_>, peak: &TorquePeak) -> f64 {
    evidence.joints()[peak.joint].limits.effort
}

fn findings<'f>(
    evidence: &'f Evidence<'_>,
    peaks: &'f [TorquePeak],
    value: impl Fn(&TorquePeak) -> f64 + 'f,
) -> impl Iterator<Item = Finding> + 'f {
    peaks.iter().map(move |peak| {
        let joint = &evidence.joints()[peak.joint];
        Finding::at_most(value(peak), limit(evidence, peak), Unit::of_effort(joint.kind))
            .by_share()
            .at(peak.time)
            .of([joint.name.as_str()])
            .during(peak.phase.as_str())
    })
}

#[cfg(test)]
mod tests {
    use crate::{Basis, Outcome, fixture};

    #[test]
    fn a_plan_within_its_limits_passes_with_a_proved_bound() {
        let result = fixture::pick().check("planned.torque");
        assert_eq!((result.outcome, result.basis), (Outcome::Pass, Basis::Proved), "{result:?}");
        assert!(result.value_is_bound && result.margin_is_share && result.margin.unwrap() > 0.0);
    }

    #[test]
    fn a_limit_below_what_is_taken_fails_with_joint_time_and_phase() {
        let mut run = fixture::pick();
        let taken = run.check("planned.torque").value.unwrap();
        for joint in &mut run.resolved.robot.joints {
            joint.limits.effort = 0.5 * taken;
        }
        let result = run.check("planned.torque");
        assert_eq!(result.outcome, Outcome::Fail, "{result:?}");
        assert!(result.time.is_some() && result.place.phase.is_some() && !result.place.subjects.is_empty());
    }

    #[test]
    fn the_stretch_is_that_of_what_gravity_leaves() {
        // The lift alone, whose force is m (g + a): gravity stays, the rest goes as 1/k².
        let mut run = fixture::pick();
        run.resolved.object = None;
        run.plan.grasp = None;
        for phase in &mut run.plan.phases {
            phase.holding = graspcheck_model::plan::Holding::Nothing;
        }
        for joint in &mut run.resolved.robot.joints {
            (joint.damping, joint.friction, joint.limits.effort) = (0.0, 0.0, 1e6);
        }
        let motion = &run.plan.trajectory;
        let peak = motion.range_in(0, 2, 0.0, motion.duration())[1].value;
        let robot = &run.resolved.robot;
        let weight = {
            let mut arm = graspcheck_model::dynamics::Dynamics::new(robot, run.resolved.cell.gravity);
            let mut tau = [0.0; 2];
            arm.inverse(&[0.0; 2], &[0.0; 2], &[0.0; 2], &mut tau);
            tau[0]
        };
        let mass = weight / -run.resolved.cell.gravity.z + robot.joints[0].rotor_inertia;
        // Half of what acceleration adds is too much.
        run.resolved.robot.joints[0].limits.effort = weight + 0.5 * mass * peak;
        let result = run.check("planned.torque");
        assert_eq!(result.outcome, Outcome::Fail, "{result:?}");
        assert!((result.stretch.unwrap() - 2.0_f64.sqrt()).abs() < 3e-3, "{result:?}");
        run.resolved.robot.joints[0].limits.effort = 0.99 * weight;
        let result = run.check("planned.torque");
        assert_eq!((result.outcome, result.stretch), (Outcome::Fail, None));
        assert!(result.note.to_string().contains("slower is no cure"), "{}", result.note);
    }

    #[test]
    fn a_heavier_object_takes_more() {
        let mut run = fixture::pick();
        let light = run.check("planned.torque").value.unwrap();
        run.resolved.object.as_mut().unwrap().mass *= 20.0;
        assert!(run.check("planned.torque").value.unwrap() > light);
    }
}
