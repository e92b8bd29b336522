//! A motion cut into stretches: of a plan, on which every joint is one polynomial and the phase is one; of a
//! plan with all that tracking may add; or of a logged motion.

use graspcheck_model::plan::Plan;
use graspcheck_motion::{Polynomial, Trajectory};

use crate::logged_motion::LoggedMotion;

/// Cuts nearer than this to the one before, s, are the same instant: a joint at 10 rad/s turns 1e-11 rad in
/// it, which is far below the slack of the gaps.
const SAME_INSTANT: f64 = 1e-12;

/// A speed times the stretch's duration below this, rad or m, counts as standing still when the sign of the
/// speed is found: a hundredth of what the slack of the gaps covers on an arm that reaches 8 m.
const STANDING_STILL: f64 = 1e-12;

/// A stretch of a motion.
#[derive(Clone, Debug)]
pub(crate) struct Stretch<'p> {
    pub(crate) start: f64,
    pub(crate) end: f64,
    /// Index into the plan's phases.
    pub(crate) phase: usize,
    source: Source<'p>,
}

/// What says where the joints are.
#[derive(Clone, Debug)]
enum Source<'p> {
    Plan { arm: Coordinates<'p>, opening: Coordinates<'p> },
    Tube { arm: Coordinates<'p>, opening: Coordinates<'p>, around: Around },
    Logged(&'p LoggedMotion),
}

/// How far the joints may be from a plan.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Around {
    /// Of each arm joint, rad or m.
    pub(crate) arm: Vec<f64>,
    /// Of the opening, m.
    pub(crate) opening: f64,
    /// The pads stop here, m, whatever opening is commanded.
    pub(crate) opening_min: f64,
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

impl Range {
    /// The range of what may be farther out by `more` on either side.
    fn widened(self, more: f64) -> Self {
        Self { below: self.below + more, above: self.above + more, ..self }
    }

    /// The range of what stops at `least`.
    pub(crate) fn stopped_at(self, least: f64) -> Self {
        let reference = self.reference.max(least);
        let [low, high] =
            [self.reference - self.below, self.reference + self.above].map(|end| end.max(least));
        Self { reference, below: reference - low, above: high - reference }
    }
}

impl<'p> Stretch<'p> {
    /// A stretch of a logged motion.
    pub(crate) fn logged(motion: &'p LoggedMotion, [start, end]: [f64; 2], phase: usize) -> Self {
        Self { start, end, phase, source: Source::Logged(motion) }
    }

    /// A stretch of a plan as a set of motions: all that stay this near to it.
    pub(crate) fn around(self, around: Around) -> Self {
        let source = match self.source {
            Source::Plan { arm, opening } => Source::Tube { arm, opening, around },
            other => other,
        };
        Self { source, ..self }
    }

    /// Whether it is a set of motions: not even at one instant is it known where the joints are.
    pub(crate) fn is_tube(&self) -> bool {
        matches!(self.source, Source::Tube { .. })
    }

    /// Position of an arm joint at the middle of `[start, end]`, and its range there.
    pub(crate) fn arm(&self, joint: usize, start: f64, end: f64) -> Range {
        match &self.source {
            Source::Plan { arm, .. } => arm.range(joint, start, end),
            Source::Tube { arm, around, .. } => arm.range(joint, start, end).widened(around.arm[joint]),
            Source::Logged(motion) => motion.arm(joint, start, end),
        }
    }

    /// The opening likewise.
    pub(crate) fn opening(&self, start: f64, end: f64) -> Range {
        match &self.source {
            Source::Plan { opening, .. } => opening.range(0, start, end),
            Source::Tube { opening, around, .. } => {
                opening.range(0, start, end).stopped_at(around.opening_min).widened(around.opening)
            }
            Source::Logged(motion) => motion.opening(start, end),
        }
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
    let stretch = |pair: &[f64]| {
        let (start, end) = (pair[0], pair[1]);
        let phase = plan.phase_index_at(middle(start, end));
        let arm = Coordinates::new(&plan.trajectory, start, end);
        let opening = Coordinates::new(&plan.opening, start, end);
        Stretch { start, end, phase, source: Source::Plan { arm, opening } }
    };
    Ok(cuts(plan, dof)?.windows(2).map(stretch).collect())
}

/// The instants at which stretches of a plan begin and end, from 0 to its duration, s.
///
/// # Errors
/// Says in words what is wrong with the plan.
pub(crate) fn cuts(plan: &Plan, dof: usize) -> Result<Vec<f64>, String> {
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
    Ok(cuts)
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
