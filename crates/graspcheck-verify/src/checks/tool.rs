//! `planned.tool_speed`, `planned.tool_acceleration`: how fast the tool's origin is and how hard it accelerates at most,
//! at every instant of the plan. Proved by bounds over stretches of time; see [`graspcheck_proof::tool_speed`].
//!
//! A phase may have limits of its own, such as the 250 mm/s that are common for reduced speed.

use graspcheck_proof::tool_speed::{ToolPeak, tool_peaks};

use crate::{
    evidence::Evidence,
    finding::{Finding, Gap, worst_by},
    note::Note,
    resolved::ToolLimits,
    verdict::Unit,
};

/// To what share of the least limit a peak is known, and to what share when that does not tell.
const TOLERANCES: [f64; 2] = [1e-3, 1e-6];

/// The phase in which the tool's speed takes the largest share of its limit.
pub(super) fn speed(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    let all = evidence.resolved.checks.tool_speed;
    largest(evidence, 0, |own| own.and_then(|own| own.speed).or(all))
}

/// The phase in which the tool's acceleration takes the largest share of its limit.
pub(super) fn acceleration(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    let all = evidence.resolved.checks.tool_acceleration;
    largest(evidence, 1, |own| own.and_then(|own| own.acceleration).or(all))
}

/// The largest share of a limit: a proved upper bound, or, when it is exceeded, what is reached at an instant at least.
/// `quantity` is 0 for the speed and 1 for the acceleration.
fn largest(
    evidence: &Evidence<'_>,
    quantity: usize,
    limit_of: impl Fn(Option<&ToolLimits>) -> Option<f64>,
) -> Result<Finding, Gap> {
    let what = ["speed", "acceleration"][quantity];
    let phases = &evidence.plan.phases;
    let named = &evidence.resolved.checks.tool_in_phases;
    if let Some(lost) = named.iter().find(|own| phases.iter().all(|phase| phase.name != own.phase)) {
        let there: Vec<&str> = phases.iter().map(|phase| phase.name.as_str()).collect();
        let note =
            format!("a limit is set for the phase `{}`; the plan has {}", lost.phase, there.join(", "));
        return Err(Gap::inconclusive(None, note));
    }
    let of_phase = |name: &str| named.iter().find(|own| own.phase == name);
    let limits: Vec<Option<f64>> = phases.iter().map(|phase| limit_of(of_phase(&phase.name))).collect();
    let least = limits.iter().flatten().copied().fold(f64::INFINITY, f64::min);
    if least == f64::INFINITY {
        return Err(Gap::not_requested(format!("the {what} of the tool has no limit")));
    }
    let unit = [Unit::MeterPerSecond, Unit::MeterPerSecond2][quantity];
    let mut last = None;
    for share in TOLERANCES {
        let mut tolerances = [f64::INFINITY; 2];
        tolerances[quantity] = share * least;
        let peaks = tool_peaks(&evidence.resolved.robot, &evidence.plan, tolerances)
            .map_err(|reason| Gap::inconclusive(None, reason))?;
        let findings = |value: fn(&ToolPeak) -> f64| {
            let limited = peaks.iter().zip(phases).zip(&limits);
            limited.filter_map(move |((peaks, phase), limit)| {
                let peak = &peaks[quantity];
                let finding = Finding::at_most(value(peak), (*limit)?, unit).by_share().at(peak.time);
                Some(finding.of(["tool"]).during(phase.name.as_str()).slower(quantity + 1))
            })
        };
        let exceeded = findings(|peak| peak.lower).filter(|finding| !finding.passes);
        if let Some(exceeded) = worst_by(exceeded, |finding| -finding.margin) {
            return Ok(exceeded);
        }
        let worst = worst_by(findings(|peak| peak.upper), |finding| -finding.margin);
        let mut worst = worst.ok_or_else(|| Gap::inconclusive(None, "the plan has no phase"))?;
        if worst.passes {
            worst.value_is_bound = true;
            return Ok(worst);
        }
        last = Some(worst);
    }
    let note = Note::from(format!("the {what} of the tool is at most "));
    Err(match last {
        Some(worst) => Gap::inconclusive(
            worst.time,
            note.quantity(worst.value, unit).and(", too near to the limit to tell"),
        ),
        None => Gap::inconclusive(None, "the plan has no phase"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Basis, Outcome, fixture};

    #[test]
    fn the_peak_is_held_against_the_limit() {
        let mut run = fixture::pick();
        run.resolved.checks.tool_speed = Some(1.0);
        // Known to a thousandth of the limit: once of a large one, then of one that is near.
        run.resolved.checks.tool_speed = run.check("planned.tool_speed").value.map(|near| 1.1 * near);
        let reached = run.check("planned.tool_speed").value.unwrap();
        run.resolved.checks.tool_speed = Some(reached * 1.01);
        let result = run.check("planned.tool_speed");
        assert_eq!((result.outcome, result.basis), (Outcome::Pass, Basis::Proved), "{result:?}");
        assert!(result.value_is_bound && result.margin_is_share && result.stretch.is_none());
        run.resolved.checks.tool_speed = Some(reached / 1.1);
        let result = run.check("planned.tool_speed");
        assert_eq!((result.outcome, result.unit), (Outcome::Fail, Unit::MeterPerSecond), "{result:?}");
        // Speed goes as 1/k.
        assert!((result.stretch.unwrap() - 1.1).abs() < 3e-3, "{result:?}");
        assert_eq!(run.check("planned.tool_acceleration").outcome, Outcome::NotRequested);
    }

    #[test]
    fn a_phase_has_limits_of_its_own() {
        let mut run = fixture::pick();
        run.resolved.checks.tool_acceleration = Some(100.0);
        let near = run.check("planned.tool_acceleration").value;
        run.resolved.checks.tool_acceleration = near.map(|near| 1.1 * near);
        let result = run.check("planned.tool_acceleration");
        assert_eq!(result.outcome, Outcome::Pass, "{result:?}");
        let phase = result.place.phase.clone().unwrap();
        let own =
            ToolLimits { phase: phase.clone(), speed: None, acceleration: Some(result.value.unwrap() / 4.0) };
        run.resolved.checks.tool_in_phases = vec![own];
        let result = run.check("planned.tool_acceleration");
        assert_eq!((result.outcome, result.place.phase), (Outcome::Fail, Some(phase)));
        // Acceleration goes as 1/k².
        assert!((result.stretch.unwrap() - 2.0).abs() < 5e-3, "{:?}", result.stretch);
        // A limit of one phase alone asks for the check, too.
        run.resolved.checks.tool_acceleration = None;
        assert_eq!(run.check("planned.tool_acceleration").outcome, Outcome::Fail);
        // A name that no phase has would be a limit that holds nowhere.
        run.resolved.checks.tool_in_phases[0].phase = "aproach".to_owned();
        assert_eq!(run.check("planned.tool_acceleration").outcome, Outcome::Inconclusive);
    }
}
