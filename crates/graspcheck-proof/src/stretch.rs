//! A plan cut into stretches on which every joint is one polynomial and the phase is one.

use graspcheck_model::plan::Plan;
use graspcheck_motion::{Polynomial, Trajectory};

/// Cuts nearer than this to the one before, s, are the same instant: a joint at 10 rad/s turns 1e-11 rad in
/// it, which is far below the slack of the gaps.
const SAME_INSTANT: f64 = 1e-12;

/// A speed times the stretch's duration below this, rad or m, counts as standing still when the sign of the
/// speed is found: a hundredth of what the slack of the gaps covers on an arm that reaches 8 m.
const STANDING_STILL: f64 = 1e-12;

/// A stretch of a plan.
#[derive(Clone, Debug)]
pub(crate) struct Stretch<'p> {
    pub(crate) start: f64,
    pub(crate) end: f64,
    /// Index into the plan's phases.
    pub(crate) phase: usize,
    arm: Coordinates<'p>,
    opening: Coordinates<'p>,
}

/// The polynomials of some joints, and where their local time begins.
#[derive(Clone, Debug)]
struct Coordinates<'p> {
    polynomials: &'p [Polynomial],
    zero: f64,
    /// Bit j: joint j does not turn back on this stretch.
    monotone: u64,
}

/// The position of a joint at a reference time, and how far it goes below and above that on an interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Range {
    pub(crate) reference: f64,
    pub(crate) below: f64,
    pub(crate) above: f64,
}

impl<'p> Coordinates<'p> {
    fn new(trajectory: &'p Trajectory, start: f64, end: f64) -> Self {
        let piece = trajectory.piece_at(0.5 * (start + end));
        let zero = trajectory.knots()[piece];
        let polynomials = trajectory.piece_of_all(piece);
        let monotone = polynomials.iter().take(64).enumerate().fold(0, |bits, (joint, polynomial)| {
            let [slowest, fastest] = polynomial.range(1, start - zero, end - zero);
            let still = STANDING_STILL / (end - start);
            let turns_back = !(slowest.value >= -still || fastest.value <= still);
            bits | u64::from(!turns_back) << joint
        });
        Self { polynomials, zero, monotone }
    }

    /// Position at the middle of `[start, end]` and range there, exact to rounding.
    fn range(&self, joint: usize, start: f64, end: f64) -> Range {
        let polynomial = &self.polynomials[joint];
        let (a, b) = (start - self.zero, end - self.zero);
        let reference = value(polynomial, middle(start, end) - self.zero);
        let [low, high] = if joint < 64 && self.monotone >> joint & 1 == 1 {
            let (from, to) = (value(polynomial, a), value(polynomial, b));
            [from.min(to), from.max(to)]
        } else {
            polynomial.range(0, a, b).map(|extremum| extremum.value)
        };
        Range { reference, below: (reference - low).max(0.0), above: (high - reference).max(0.0) }
    }
}

impl Stretch<'_> {
    /// Position of an arm joint at the middle of `[start, end]`, and its range there.
    pub(crate) fn arm(&self, joint: usize, start: f64, end: f64) -> Range {
        self.arm.range(joint, start, end)
    }

    /// The commanded opening likewise.
    pub(crate) fn opening(&self, start: f64, end: f64) -> Range {
        self.opening.range(0, start, end)
    }
}

/// The reference time of an interval, s.
pub(crate) fn middle(start: f64, end: f64) -> f64 {
    0.5 * (start + end)
}

fn value(polynomial: &Polynomial, tau: f64) -> f64 {
    polynomial.coefficients().iter().rev().fold(0.0, |sum, c| sum * tau + c)
}

/// The stretches of a plan, one after the other from 0 to its duration.
///
/// # Errors
/// Says in words what is wrong with the plan.
pub(crate) fn stretches(plan: &Plan, dof: usize) -> Result<Vec<Stretch<'_>>, String> {
    plan.check(dof).map_err(|fault| format!("plan: {fault}"))?;
    let mut cuts: Vec<f64> =
        Vec::with_capacity(plan.trajectory.knots().len() + plan.opening.knots().len() + plan.phases.len());
    cuts.extend_from_slice(plan.trajectory.knots());
    cuts.extend_from_slice(plan.opening.knots());
    cuts.extend(plan.phases.iter().map(|phase| phase.end));
    cuts.sort_by(f64::total_cmp);
    let duration = plan.duration();
    cuts.retain(|&cut| cut <= duration);
    cuts.dedup_by(|later, earlier| *later - *earlier <= SAME_INSTANT);
    // The last cut may have fallen to one just before it.
    if let Some(last) = cuts.last_mut() {
        *last = duration;
    }
    let stretch = |pair: &[f64]| {
        let (start, end) = (pair[0], pair[1]);
        let phase = plan.phase_index_at(middle(start, end));
        let arm = Coordinates::new(&plan.trajectory, start, end);
        let opening = Coordinates::new(&plan.opening, start, end);
        Stretch { start, end, phase, arm, opening }
    };
    Ok(cuts.windows(2).map(stretch).collect())
}

#[cfg(test)]
mod tests {
    use graspcheck_model::plan::{Holding, Phase};

    use super::*;

    fn plan(knots: Vec<f64>, pieces: Vec<Polynomial>, phases: &[(f64, f64)]) -> Plan {
        let duration = knots[knots.len() - 1];
        let phase = |&(start, end): &(f64, f64)| Phase {
            name: format!("from {start}"),
            start,
            end,
            holding: Holding::Nothing,
        };
        Plan {
            trajectory: Trajectory::new(1, knots, pieces).unwrap(),
            opening: Trajectory::hold(&[0.05], duration).unwrap(),
            phases: phases.iter().map(phase).collect(),
            grasp: None,
            paths: Vec::new(),
        }
    }

    #[test]
    fn a_joint_that_turns_back_has_its_whole_range() {
        // q = τ (1 - τ): from 0 to 0 over 1/4, which only the inside of the interval shows.
        let plan = plan(vec![0.0, 1.0], vec![Polynomial::new([0.0, 1.0, -1.0])], &[(0.0, 1.0)]);
        let stretches = stretches(&plan, 1).unwrap();
        let range = stretches[0].arm(0, 0.0, 1.0);
        assert!((range.reference - 0.25).abs() < 1e-15 && range.above.abs() < 1e-15, "{range:?}");
        assert!((range.below - 0.25).abs() < 1e-15, "{range:?}");
        let early = stretches[0].arm(0, 0.3, 0.6);
        assert!(
            (early.reference - 0.2475).abs() < 1e-15 && (early.above - 0.0025).abs() < 1e-15,
            "{early:?}"
        );
        let rising = stretches[0].arm(0, 0.0, 0.2);
        assert!((rising.below - 0.09).abs() < 1e-15 && (rising.above - 0.07).abs() < 1e-15, "{rising:?}");
    }

    #[test]
    fn cuts_fall_at_knots_and_phases_and_equal_times_fall_together() {
        let p = Polynomial::constant(0.0);
        let plan =
            plan(vec![0.0, 1.0, 3.0], vec![p, p], &[(0.0, 1.0 + 1e-16), (1.0, 2.0), (2.0, 3.0 - 1e-13)]);
        let stretches = stretches(&plan, 1).unwrap();
        let found: Vec<_> = stretches.iter().map(|s| (s.start, s.end, s.phase)).collect();
        assert_eq!(found, [(0.0, 1.0, 0), (1.0, 2.0, 1), (2.0, 3.0, 2)]);
    }
}
