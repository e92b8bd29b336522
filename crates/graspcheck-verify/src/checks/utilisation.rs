//! `planned.utilisation`, `executed.utilisation`: whether the motion uses as much of the robot as the
//! scenario claims. A scenario that claims to go to 90 % of a limit and does not would prove little.

use crate::{
    checks::{executed, limits},
    evidence::Evidence,
    finding::{Finding, Gap},
    verdict::Unit,
};

/// The lesser of the largest shares that any joint uses of its velocity and of its acceleration limit.
pub(super) fn planned(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    let least = claimed(evidence)?;
    let velocity = limits::velocity(evidence)?;
    let acceleration = limits::acceleration(evidence)?;
    let (quantity, lesser) = if acceleration.value / acceleration.limit < velocity.value / velocity.limit {
        ("acceleration", acceleration)
    } else {
        ("velocity", velocity)
    };
    Ok(share_of(&lesser, least, quantity))
}

/// The largest share that any joint uses of its effort limit.
pub(super) fn executed(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    let least = claimed(evidence)?;
    Ok(share_of(&executed::torque(evidence)?, least, "torque"))
}

fn claimed(evidence: &Evidence<'_>) -> Result<f64, Gap> {
    evidence
        .resolved
        .checks
        .utilisation_min
        .ok_or_else(|| Gap::not_requested("the scenario claims no utilisation"))
}

fn share_of(peak: &Finding, least: f64, quantity: &str) -> Finding {
    let mut finding = Finding::at_least(peak.value / peak.limit, least, Unit::One)
        .noted(format!("share of the {quantity} limit"));
    finding.time = peak.time;
    finding.place = peak.place.clone();
    finding
}

#[cfg(test)]
mod tests {
    use crate::{Outcome, fixture};

    #[test]
    fn the_lesser_share_of_velocity_and_acceleration_counts() {
        let mut run = fixture::pick();
        // Velocity 0.9375 of its limit, acceleration 0.577 of its.
        run.resolved.checks.utilisation_min = Some(0.5);
        let result = run.check("planned.utilisation");
        assert_eq!(result.outcome, Outcome::Pass);
        assert!((result.value.unwrap() - 10.0 / 3.0_f64.sqrt() / 10.0).abs() < 1e-9, "{result:?}");
        run.resolved.checks.utilisation_min = Some(0.9);
        let result = run.check("planned.utilisation");
        assert_eq!(result.outcome, Outcome::Fail);
        assert!(result.note.to_string().contains("acceleration"));
        run.resolved.robot.joints[1].limits.acceleration = 3.0;
        assert_eq!(run.check("planned.utilisation").outcome, Outcome::Pass);
    }

    #[test]
    fn the_largest_share_of_an_effort_limit_counts() {
        let mut run = fixture::pick();
        run.resolved.checks.utilisation_min = Some(0.9);
        // 10 N of 50 N.
        let result = run.check("executed.utilisation");
        assert_eq!((result.outcome, result.value), (Outcome::Fail, Some(0.2)));
        run.recording.reference.effort[4] = -45.0;
        assert_eq!(run.check("executed.utilisation").outcome, Outcome::Pass);
    }

    #[test]
    fn nothing_claimed_is_nothing_requested() {
        let run = fixture::pick();
        assert_eq!(run.check("planned.utilisation").outcome, Outcome::NotRequested);
        assert_eq!(run.check("executed.utilisation").outcome, Outcome::NotRequested);
    }
}
