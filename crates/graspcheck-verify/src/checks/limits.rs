//! `planned.position`, `planned.velocity`, `planned.acceleration`, `planned.jerk`: the plan against the
//! limits of its joints, by exact extrema at every instant.
//!
//! A value at a knot counts from both sides. An acceleration that jumps has no finite jerk there: that is
//! the business of `planned.continuity`.

use graspcheck_model::robot::JointLimits;

use super::continuity::largest_acceleration_step;
use crate::{
    evidence::Evidence,
    finding::{Finding, Gap, ROUNDING, worst_by},
    note::Note,
    verdict::Unit,
};

/// How far a planned position may be beyond its limit, rad or m: a motion planned to end *at* a limit
/// comes out within rounding of it.
const POSITION_ROUNDING: f64 = 1e-9;

/// The joint that is nearest to, or farthest beyond, one of its position limits. The value is the position,
/// the limit the nearer of the two, the margin the room to it, rad or m.
pub(super) fn position(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    let trajectory = &evidence.plan.trajectory;
    let sides = evidence.joints().iter().enumerate().flat_map(|(joint, model)| {
        let [low, high] = trajectory.range_in(joint, 0, 0.0, trajectory.duration());
        let JointLimits { position_min, position_max, .. } = model.limits;
        let unit = Unit::of_derivative(model.kind, 0);
        [
            (joint, Finding::at_least(low.value, position_min, unit).at(low.time)),
            (joint, Finding::at_most(high.value, position_max, unit).at(high.time)),
        ]
    });
    let (joint, mut worst) = worst_by(sides, |(_, side)| -side.margin).ok_or_else(no_joint)?;
    worst.passes = worst.margin >= -POSITION_ROUNDING;
    let violated = evidence.joints().iter().enumerate().flat_map(|(joint, model)| {
        let JointLimits { position_min, position_max, .. } = model.limits;
        trajectory.exceeds(joint, 0, position_min - POSITION_ROUNDING, position_max + POSITION_ROUNDING)
    });
    Ok(located(worst, joint, &violated.collect::<Vec<_>>(), evidence))
}

/// The joint that uses the largest share of its velocity limit.
pub(super) fn velocity(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    derivative(evidence, 1, |limits| limits.velocity)
}

/// The joint that uses the largest share of its acceleration limit.
pub(super) fn acceleration(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    derivative(evidence, 2, |limits| limits.acceleration)
}

/// The joint that uses the largest share of its jerk limit.
pub(super) fn jerk(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    let finding = derivative(evidence, 3, |limits| limits.jerk)?;
    let Some(step) = largest_acceleration_step(evidence) else { return Ok(finding) };
    let joint = &evidence.joints()[step.joint];
    let apart = if finding.note.is_empty() { "" } else { "; " };
    let note = finding.note.clone().and(format!("{apart}without the impulse where the acceleration of "));
    let note = note
        .and(joint.name.as_str())
        .and(" steps by ")
        .quantity(step.size, Unit::of_derivative(joint.kind, 2));
    Ok(finding.noted(note.and(" at ").quantity(step.time, Unit::Second)))
}

/// The joint that uses the largest share of its limit of the `order`-th derivative: the largest magnitude,
/// with its margin as a share of the limit.
pub(super) fn derivative(
    evidence: &Evidence<'_>,
    order: usize,
    limit_of: impl Fn(&JointLimits) -> f64,
) -> Result<Finding, Gap> {
    let trajectory = &evidence.plan.trajectory;
    let peaks = evidence.joints().iter().enumerate().map(|(joint, model)| {
        let peak = trajectory.peak(joint, order);
        let unit = Unit::of_derivative(model.kind, order);
        let limit = limit_of(&model.limits);
        (joint, Finding::at_most(peak.value.abs(), limit, unit).by_share().at(peak.time))
    });
    let (joint, worst) = worst_by(peaks, |(_, peak)| -peak.margin).ok_or_else(no_joint)?;
    let violated = evidence.joints().iter().enumerate().flat_map(|(joint, model)| {
        let limit = limit_of(&model.limits) * (1.0 + ROUNDING);
        trajectory.exceeds(joint, order, -limit, limit)
    });
    Ok(located(worst.slower(order), joint, &violated.collect::<Vec<_>>(), evidence))
}

/// The finding with joint and phase, and with the first and last instant of the violations of all joints.
fn located(finding: Finding, joint: usize, violated: &[[f64; 2]], evidence: &Evidence<'_>) -> Finding {
    let time = finding.time.unwrap_or(0.0);
    let mut located = finding.of([evidence.joints()[joint].name.as_str()]).during(evidence.phase_name(time));
    if located.passes {
        return located;
    }
    let first = violated.iter().map(|interval| interval[0]).fold(time, f64::min);
    let last = violated.iter().map(|interval| interval[1]).fold(time, f64::max);
    located.violated = Some([first, last]);
    if violated.len() > 1 {
        let total: f64 = violated.iter().map(|[from, to]| to - from).sum();
        located.note = Note::from(format!("{} intervals of all joints, ", violated.len()))
            .quantity(total, Unit::Second)
            .and(" in all");
    }
    located
}

fn no_joint() -> Gap {
    Gap::inconclusive(None, "the robot has no joint")
}

#[cfg(test)]
mod tests {
    use graspcheck_motion::{Polynomial, Trajectory};

    use crate::{
        Basis, Outcome, Unit,
        fixture::{self, Run},
    };

    /// The pick with the motion of one joint replaced in its first phase, which lasts 1 s.
    fn with_first_piece(joint: usize, piece: Polynomial) -> Run {
        let mut run = fixture::pick();
        let old = &run.plan.trajectory;
        let mut pieces: Vec<Polynomial> =
            (0..old.piece_count()).flat_map(|k| old.piece_of_all(k).to_vec()).collect();
        pieces[joint] = piece;
        run.plan.trajectory = Trajectory::new(2, old.knots().to_vec(), pieces).unwrap();
        run
    }

    #[test]
    fn a_plan_within_its_limits_passes_with_the_peak_of_a_quintic() {
        // The turn by 0.5 rad in 1 s: peaks 15/8 D/T, 10/√3 D/T², 60 D/T³.
        let run = fixture::pick();
        for (name, peak, limit) in [
            ("planned.velocity", 15.0 / 8.0 * 0.5, 1.0),
            ("planned.acceleration", 10.0 / 3.0_f64.sqrt() * 0.5, 5.0),
            ("planned.jerk", 30.0, 60.0),
        ] {
            let result = run.check(name);
            assert_eq!((result.outcome, result.basis), (Outcome::Pass, Basis::Exact), "{result:?}");
            assert!((result.value.unwrap() - peak).abs() < 1e-9, "{result:?}");
            assert!((result.margin.unwrap() - (limit - peak) / limit).abs() < 1e-9);
            assert!(result.margin_is_share);
            assert_eq!(result.place.subjects, ["turn"]);
            assert_eq!(result.place.phase.as_deref(), Some("carry"));
            assert_eq!(result.violated, None);
        }
        assert_eq!(run.check("planned.velocity").unit, Unit::RadianPerSecond);
    }

    #[test]
    fn the_worst_share_counts_and_not_the_largest_number() {
        let mut run = fixture::pick();
        // The lift moves 0.13 m in 1 s: 0.24 m/s is less than 0.94 rad/s, but all of this limit.
        run.resolved.robot.joints[0].limits.velocity = 0.25;
        let result = run.check("planned.velocity");
        assert_eq!(result.place.subjects, ["lift"]);
        assert_eq!(result.unit, Unit::MeterPerSecond);
        assert_eq!(result.outcome, Outcome::Pass);
    }

    #[test]
    fn a_broken_limit_fails_with_the_exact_interval() {
        // v(t) = 15/8·4·s(1 - s)… of a quintic is symmetric about the middle of carry, at 3.8 s.
        let mut run = fixture::pick();
        run.resolved.robot.joints[1].limits.velocity = 0.9;
        let result = run.check("planned.velocity");
        assert_eq!(result.outcome, Outcome::Fail);
        assert!((result.time.unwrap() - 3.8).abs() < 1e-6, "{result:?}");
        assert!(result.margin.unwrap() < 0.0);
        let [from, to] = result.violated.unwrap();
        assert!((from + to - 2.0 * 3.8).abs() < 1e-6 && from < 3.8, "{from} {to}");
        // 30 D τ²(1 - τ)² = 0.9 with D = 0.5: τ(1 - τ) = √0.06.
        let tau = 0.5 - (0.25 - 0.06_f64.sqrt()).sqrt();
        assert!((from - (3.3 + tau)).abs() < 1e-6, "{from} is not {}", 3.3 + tau);
    }

    #[test]
    fn a_failure_says_how_much_longer_the_motion_must_be_given() {
        // 15/8 D/T, 10/√3 D/T², 60 D/T³ with D = 0.5, T = 1: what k times as long would bring to the limit.
        for (order, limit) in [(1, 0.8), (2, 2.0), (3, 10.0)] {
            let mut run = fixture::pick();
            let limits = &mut run.resolved.robot.joints[1].limits;
            let slot =
                [&mut limits.velocity, &mut limits.acceleration, &mut limits.jerk].into_iter().nth(order - 1);
            *slot.unwrap() = limit;
            let name = ["planned.velocity", "planned.acceleration", "planned.jerk"][order - 1];
            let stretch = run.check(name).stretch.unwrap();
            let peak = [15.0 / 16.0, 10.0 / 3.0_f64.sqrt() * 0.5, 30.0][order - 1];
            assert!((peak / stretch.powf(order as f64) - limit).abs() < 1e-9, "{name} {stretch}");
            assert!(stretch > 1.0);
        }
        assert_eq!(fixture::pick().check("planned.velocity").stretch, None);
    }

    #[test]
    fn a_cubic_that_overshoots_its_limit_by_a_thousandth_between_two_points_is_found() {
        // From 0.2 m to 0.1 m in 1 s, at 0.05 m/s at both points, and fastest halfway.
        let piece = Polynomial::new([0.2, -0.05, -0.15, 0.1]);
        let fastest = 0.05 + 0.15 * 0.15 / (3.0 * 0.1);
        for (share, outcome) in [(1.0 / 1.001, Outcome::Fail), (1.001, Outcome::Pass)] {
            let mut run = with_first_piece(0, piece);
            run.resolved.robot.joints[0].limits.velocity = share * fastest;
            // The other phases of this run must not be what fails.
            run.plan.trajectory = only_first_piece_of(&run, 0);
            let result = run.check("planned.velocity");
            assert_eq!(result.outcome, outcome, "{result:?}");
            if outcome == Outcome::Fail {
                assert!((result.time.unwrap() - 0.5).abs() < 1e-9, "{result:?}");
                let [from, to] = result.violated.unwrap();
                assert!(from < 0.5 && 0.5 < to && to - from < 0.1, "{from} {to}");
                assert!((result.value.unwrap() / fastest - 1.0).abs() < 1e-12);
            }
        }
    }

    /// The motion of a run with one joint at rest in all pieces but the first.
    fn only_first_piece_of(run: &Run, joint: usize) -> Trajectory {
        let old = &run.plan.trajectory;
        let mut pieces: Vec<Polynomial> =
            (0..old.piece_count()).flat_map(|k| old.piece_of_all(k).to_vec()).collect();
        for piece in 1..old.piece_count() {
            pieces[piece * old.dof() + joint] = Polynomial::constant(0.05);
        }
        Trajectory::new(old.dof(), old.knots().to_vec(), pieces).unwrap()
    }

    #[test]
    fn a_step_of_acceleration_is_an_impulse_of_jerk_and_said_to_be_one() {
        let run = with_first_piece(0, Polynomial::new([0.2, 0.0, 0.5]));
        let note = run.check("planned.jerk").note.to_string();
        assert!(note.contains("impulse") && note.contains("m/s²"), "{note}");
        assert!(!fixture::pick().check("planned.jerk").note.to_string().contains("impulse"));
    }

    #[test]
    fn each_derivative_has_its_own_limit() {
        for (name, index) in [("planned.acceleration", 2), ("planned.jerk", 3)] {
            let mut run = fixture::pick();
            let limits = &mut run.resolved.robot.joints[1].limits;
            *(if index == 2 { &mut limits.acceleration } else { &mut limits.jerk }) = 1.0;
            assert_eq!(run.check(name).outcome, Outcome::Fail);
            assert_eq!(run.check("planned.velocity").outcome, Outcome::Pass);
        }
    }

    #[test]
    fn a_limit_that_is_met_exactly_holds() {
        let mut run = fixture::pick();
        run.resolved.robot.joints[1].limits.velocity = 15.0 / 16.0;
        assert_eq!(run.check("planned.velocity").outcome, Outcome::Pass);
        run.resolved.robot.joints[1].limits.velocity = 15.0 / 16.0 - 1e-8;
        assert_eq!(run.check("planned.velocity").outcome, Outcome::Fail);
    }

    #[test]
    fn a_position_is_held_against_the_nearer_limit() {
        let result = fixture::pick().check("planned.position");
        assert_eq!(result.outcome, Outcome::Pass);
        assert_eq!(result.place.subjects, ["lift"]);
        assert!((result.margin.unwrap() - 0.02).abs() < 1e-12, "{result:?}");
        assert_eq!(result.limit, Some(0.0));
        assert!(!result.margin_is_share);
    }

    #[test]
    fn an_overshoot_between_two_positions_within_limits_is_found() {
        // From 0.2 m to 0.1 m, but by way of less than 0 m: cubic-1 of the worked examples overshoots so.
        let run = with_first_piece(0, Polynomial::new([0.2, 0.0, -1.6, 1.5]));
        let result = run.check("planned.position");
        assert_eq!(result.outcome, Outcome::Fail, "{result:?}");
        let tau = 3.2 / 4.5;
        let lowest = 0.2 - 1.6 * tau * tau + 1.5 * tau * tau * tau;
        assert!((result.value.unwrap() - lowest).abs() < 1e-9 && lowest < 0.0, "{result:?}");
        assert!((result.time.unwrap() - tau).abs() < 1e-6);
        assert!(result.violated.unwrap()[0] < tau && tau < result.violated.unwrap()[1]);
    }

    #[test]
    fn numbers_that_overflow_never_pass() {
        let run = with_first_piece(1, Polynomial::new([0.0, 1e308, 1e308, 1e308, 1e308]));
        for name in ["planned.position", "planned.velocity", "planned.acceleration", "planned.jerk"] {
            let result = run.check(name);
            assert_eq!(result.outcome, Outcome::Fail, "{result:?}");
            // JSON has no NaN: what is not a number is no value.
            assert!(result.value.is_none_or(f64::is_finite), "{result:?}");
            assert!(result.margin.is_none_or(f64::is_finite), "{result:?}");
        }
    }
}
