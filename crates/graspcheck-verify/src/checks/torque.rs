//! `planned.torque`: no joint takes more than its effort limit at any instant of the plan, with what it holds.
//! Proved by bounds over stretches of time; see [`graspcheck_proof::torque`].

use graspcheck_proof::{
    TorquePeak,
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
            return Ok(exceeds);
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
            .and(", too near to the limit to tell");
        Gap::inconclusive(Some(peak.time), note)
    });
    Err(near.unwrap_or_else(|| Gap::inconclusive(None, "the arm has no joint")))
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
    fn a_heavier_object_takes_more() {
        let mut run = fixture::pick();
        let light = run.check("planned.torque").value.unwrap();
        run.resolved.object.as_mut().unwrap().mass *= 20.0;
        assert!(run.check("planned.torque").value.unwrap() > light);
    }
}
