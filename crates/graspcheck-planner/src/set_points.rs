//! What a controller makes of a motion that reaches it as set points.
//!
//! A controller that is sent positions at 100 Hz does not execute the planner's polynomials: between two set points it
//! interpolates, linearly where it gets positions alone, by cubics with velocities, by quintics with accelerations.
//! That motion is the one that is to be proved and executed, so it takes the place of the plan's.
//!
//! Set points stand at every multiple of the period from the beginning of each phase, and at its end: every phase is
//! sent as a motion of its own.
//!
//! ```
//! use graspcheck_model::{plan::{Holding, Phase, Plan}, task::{Interpolation, SetPoints}};
//! use graspcheck_motion::{Polynomial, Trajectory};
//! use graspcheck_planner::set_points::interpolated;
//!
//! let swing = Polynomial::quintic_hermite([0.0; 3], [1.0, 0.0, 0.0], 2.0);
//! let trajectory = Trajectory::new(1, vec![0.0, 2.0], vec![swing]).expect("one piece");
//! let phases = vec![Phase { name: "swing".into(), start: 0.0, end: 2.0, holding: Holding::Nothing }];
//! let opening = Trajectory::hold(&[0.0], 2.0).expect("it lasts");
//! let plan = Plan { trajectory, opening, phases, grasp: None, paths: Vec::new() };
//!
//! // Straight lines between ten points a second: 20 pieces, and the velocity jumps at the 19 points between them but the
//! // middle one, on both sides of which the swing covers the same.
//! let points = SetPoints { period: 0.1, interpolation: Interpolation::Linear };
//! let executed = interpolated(plan, points).expect("few points").trajectory;
//! assert_eq!((executed.piece_count(), executed.breaks().len()), (20, 18));
//! assert!(executed.breaks().iter().all(|at| at.order == 1));
//! ```

use graspcheck_model::{
    plan::Plan,
    task::{Interpolation, SetPoints},
};
use graspcheck_motion::{Polynomial, Trajectory};

use crate::error::PlanError;

/// At most so many set points make a plan: more pieces than that are not proved in a minute.
const MOST_POINTS: f64 = 20_000.0;

/// A rest of a phase shorter than this share of the period is no piece of its own: it is rounding.
const LEAST_REST: f64 = 1e-6;

/// The plan with the motion that a controller executes which gets it as these set points.
///
/// # Errors
/// When the period is not positive, or there would be more than 20,000 set points.
pub fn interpolated(plan: Plan, points: SetPoints) -> Result<Plan, PlanError> {
    let SetPoints { period, interpolation } = points;
    let fault = |must| {
        Err(PlanError::BadNumber { place: "period of set points, s,".to_owned(), value: period, must })
    };
    if !(period > 0.0 && period.is_finite()) {
        return fault("positive and finite");
    }
    if plan.duration() / period > MOST_POINTS {
        return fault("long enough for at most 20,000 set points");
    }
    let motion = &plan.trajectory;
    let mut knots = vec![0.0];
    let mut pieces = Vec::new();
    for (index, phase) in plan.phases.iter().enumerate() {
        // The last phase ends with the motion, whatever the rounding of its own end.
        let end = if index + 1 == plan.phases.len() { motion.duration() } else { phase.end };
        let start = knots[knots.len() - 1];
        let count = ((end - start) / period - LEAST_REST).ceil().max(1.0) as usize;
        for k in 0..count {
            let from = start + k as f64 * period;
            let to = if k + 1 == count { end } else { start + (k + 1) as f64 * period };
            pieces.extend((0..motion.dof()).map(|joint| {
                let ends = [after(motion, joint, from), before(motion, joint, to)];
                piece(interpolation, ends, to - from)
            }));
            knots.push(to);
        }
    }
    let trajectory = Trajectory::new(motion.dof(), knots, pieces)?;
    Ok(Plan { trajectory, ..plan })
}

/// Position, velocity and acceleration of a joint at `t`, at a knot those of what follows.
fn after(motion: &Trajectory, joint: usize, t: f64) -> [f64; 3] {
    state(motion, motion.piece_at(t), joint, t)
}

/// The same, at a knot those of what came before.
fn before(motion: &Trajectory, joint: usize, t: f64) -> [f64; 3] {
    // Phases end at knots to within rounding of sums.
    let rounding = 1e-9 * (1.0 + t);
    let piece = motion.knots().partition_point(|knot| *knot < t - rounding).max(1) - 1;
    state(motion, piece, joint, t)
}

fn state(motion: &Trajectory, piece: usize, joint: usize, t: f64) -> [f64; 3] {
    let [q, qd, qdd, _] = motion.piece(piece, joint).eval(t - motion.knots()[piece]);
    [q, qd, qdd]
}

fn piece(interpolation: Interpolation, [start, end]: [[f64; 3]; 2], duration: f64) -> Polynomial {
    let mean = (end[0] - start[0]) / duration;
    match interpolation {
        Interpolation::Linear => Polynomial::new([start[0], mean]),
        Interpolation::Cubic => {
            let square = (3.0 * mean - 2.0 * start[1] - end[1]) / duration;
            let cube = (start[1] + end[1] - 2.0 * mean) / (duration * duration);
            Polynomial::new([start[0], start[1], square, cube])
        }
        Interpolation::Quintic => Polynomial::quintic_hermite(start, end, duration),
    }
}

#[cfg(test)]
mod tests {
    use graspcheck_model::plan::{Holding, Phase};

    use super::*;

    /// Two joints: there in 1 s, back in 0.75 s, with a step of the velocity between.
    fn plan() -> Plan {
        let there = Polynomial::quintic_hermite([0.0; 3], [1.0, 0.2, 0.0], 1.0);
        let back = Polynomial::quintic_hermite([1.0, -0.1, 0.0], [0.0; 3], 0.75);
        let trajectory =
            Trajectory::new(2, vec![0.0, 1.0, 1.75], vec![there, there.plus(2.0), back, back.plus(2.0)])
                .unwrap();
        let phase =
            |name: &str, start, end| Phase { name: name.to_owned(), start, end, holding: Holding::Nothing };
        Plan {
            trajectory,
            opening: Trajectory::hold(&[0.0], 1.75).unwrap(),
            phases: vec![phase("there", 0.0, 1.0), phase("back", 1.0, 1.75)],
            grasp: None,
            paths: Vec::new(),
        }
    }

    fn with(period: f64, interpolation: Interpolation) -> Trajectory {
        interpolated(plan(), SetPoints { period, interpolation }).unwrap().trajectory
    }

    #[test]
    fn every_set_point_carries_what_its_interpolation_takes() {
        let planned = plan().trajectory;
        for (interpolation, order) in
            [(Interpolation::Linear, 0), (Interpolation::Cubic, 1), (Interpolation::Quintic, 2)]
        {
            let executed = with(0.1, interpolation);
            // Ten periods, seven and a half of one.
            assert_eq!(executed.piece_count(), 18);
            assert!((executed.duration() - 1.75).abs() < 1e-15);
            for &knot in executed.knots() {
                let (is, should) = (executed.eval(knot), planned.eval(knot));
                let pairs = [(&is.q, &should.q), (&is.qd, &should.qd), (&is.qdd, &should.qdd)];
                for (is, should) in &pairs[..=order] {
                    // At the very end of a motion the state is that of the last piece.
                    assert!(is.iter().zip(should.iter()).all(|(a, b)| (a - b).abs() < 1e-9), "{knot}");
                }
            }
            let first_jumps = executed.breaks().iter().filter(|at| at.order == order + 1).count();
            assert!(order == 2 || first_jumps > 10, "{interpolation:?}: {first_jumps}");
        }
        // The one jump of the plan is kept, on a knot.
        let quintic = with(0.1, Interpolation::Quintic);
        assert_eq!(quintic.breaks().len(), 1);
        let at = &quintic.breaks()[0];
        assert!((quintic.knots()[at.knot] - 1.0).abs() < 1e-12 && (at.jump[0] + 0.3).abs() < 1e-9);
    }

    /// The error of Hermite interpolation is of the order 2, 4, 6 of the period.
    #[test]
    fn the_error_falls_with_the_order_of_the_interpolation() {
        let planned = plan().trajectory;
        let error = |period, interpolation| {
            let executed = with(period, interpolation);
            (0..1750)
                .map(|k| f64::from(k) * 1e-3)
                .map(|t| (executed.eval(t).q[1] - planned.eval(t).q[1]).abs())
                .fold(0.0, f64::max)
        };
        for (interpolation, order) in [(Interpolation::Linear, 2), (Interpolation::Cubic, 4)] {
            let gain = error(0.05, interpolation) / error(0.025, interpolation);
            let expected = f64::from(1 << order);
            assert!((gain / expected - 1.0).abs() < 0.1, "{interpolation:?}: {gain}");
        }
        // Quintics give a quintic back.
        assert!(error(0.05, Interpolation::Quintic) < 1e-12);
    }

    #[test]
    fn a_period_that_makes_no_sense_is_an_error() {
        for period in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-6] {
            let points = SetPoints { period, interpolation: Interpolation::Cubic };
            assert!(matches!(interpolated(plan(), points), Err(PlanError::BadNumber { .. })), "{period}");
        }
        // A period longer than a phase: its ends alone.
        assert_eq!(with(10.0, Interpolation::Cubic).piece_count(), 2);
    }
}
