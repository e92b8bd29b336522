//! How smooth a motion is where its pieces meet.
//!
//! A motion is of class Cⁿ when its first n derivatives are continuous. A drive can follow C1 only with a step of
//! torque, and C0 not at all. Jumps are measured at every knot, right minus left, and held against what rounding
//! can account for.
//!
//! ```
//! use graspcheck_motion::{ContinuityClass, Polynomial, Trajectory};
//!
//! // 20° → 80° → 25° in 5 s each by two cubics that meet at 10°/s: the acceleration jumps from −6.4 to −21.2°/s².
//! let pieces = vec![Polynomial::new([20.0, 0.0, 5.2, -0.56]), Polynomial::new([80.0, 10.0, -10.6, 1.28])];
//! let found = Trajectory::new(1, vec![0.0, 5.0, 10.0], pieces)?.continuity();
//! assert_eq!(found.class, ContinuityClass::C1);
//! let jump = found.jumps[0];
//! assert_eq!((jump.time, jump.joint, jump.order), (5.0, 0, 2));
//! assert!((jump.size + 14.8).abs() < 1e-12);
//! # Ok::<(), graspcheck_motion::TrajectoryError>(())
//! ```

use crate::polynomial::Polynomial;
use crate::trajectory::{Break, SMOOTH_TOLERANCE, Trajectory};

/// How many derivatives of a motion are continuous. The order is from rough to smooth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ContinuityClass {
    /// A position jumps.
    Discontinuous,
    /// Positions are continuous, a velocity jumps.
    C0,
    /// Velocities are continuous too, an acceleration jumps.
    C1,
    /// Accelerations are continuous too; jerks may step.
    C2,
}

/// A jump of one derivative of one joint at a knot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// When, s.
    pub time: f64,
    /// The joint that jumps.
    pub joint: usize,
    /// What jumps: 0 position, 1 velocity, 2 acceleration.
    pub order: usize,
    /// The limit from the right minus the limit from the left, SI units.
    pub size: f64,
}

/// The continuity class of a motion and every jump in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Continuity {
    /// The class of the roughest knot.
    pub class: ContinuityClass,
    /// All jumps by time, then joint, then order. A joint whose velocity jumps may have a jump of the
    /// acceleration at the same knot: both are listed.
    pub jumps: Vec<Jump>,
}

impl Trajectory {
    /// The continuity class of the motion inside `(0, duration)`, and every jump larger than
    /// [`SMOOTH_TOLERANCE`] allows.
    ///
    /// ```
    /// use graspcheck_motion::{ContinuityClass, Polynomial, Trajectory};
    /// // A trapezoid of velocity: its acceleration jumps where the cruise begins.
    /// let pieces = vec![Polynomial::new([0.0, 0.0, 1.0]), Polynomial::new([1.0, 2.0])];
    /// let found = Trajectory::new(1, vec![0.0, 1.0, 2.0], pieces)?.continuity();
    /// assert_eq!((found.class, found.jumps[0].size), (ContinuityClass::C1, -2.0));
    /// # Ok::<(), graspcheck_motion::TrajectoryError>(())
    /// ```
    #[must_use]
    pub fn continuity(&self) -> Continuity {
        let knots = Knots::new(self.dof(), self.knots(), self.pieces());
        let mut jumps = Vec::new();
        for found in self.breaks() {
            for (joint, step) in knots.steps(found.knot).enumerate() {
                let time = self.knots()[found.knot];
                jumps.extend((0..3).filter(|&order| step.jumps(order)).map(|order| Jump {
                    time,
                    joint,
                    order,
                    size: step.size[order],
                }));
            }
        }
        let class = match self.breaks().iter().map(|found| found.order).min() {
            Some(0) => ContinuityClass::Discontinuous,
            Some(1) => ContinuityClass::C0,
            Some(_) => ContinuityClass::C1,
            None => ContinuityClass::C2,
        };
        Continuity { class, jumps }
    }
}

/// The knots at which position, velocity or acceleration differs on the two sides.
pub(crate) fn find_breaks(dof: usize, knots: &[f64], pieces: &[Polynomial]) -> Vec<Break> {
    let mut found = Vec::new();
    // Most motions are smooth, and the scales of their quantities need not be known to see it.
    let rough = (1..knots.len() - 1).filter(|&knot| !is_plainly_smooth(dof, knots, pieces, knot));
    let mut all = None;
    for knot in rough {
        let all = all.get_or_insert_with(|| Knots::new(dof, knots, pieces));
        let order = all.steps(knot).filter_map(|step| (0..3).find(|&order| step.jumps(order))).min();
        if let Some(order) = order {
            found.push(Break { knot, order, jump: all.steps(knot).map(|step| step.size[order]).collect() });
        }
    }
    found
}

/// Whether position, velocity and acceleration of every joint change at an inner knot by no more than
/// [`SMOOTH_TOLERANCE`] in SI units, which is the least that [`Step::tolerance`] is.
fn is_plainly_smooth(dof: usize, knots: &[f64], pieces: &[Polynomial], knot: usize) -> bool {
    let h = knots[knot] - knots[knot - 1];
    let (before, after) = (&pieces[(knot - 1) * dof..knot * dof], &pieces[knot * dof..(knot + 1) * dof]);
    before.iter().zip(after).all(|(before, after)| {
        let [q, qd, qdd, _] = before.eval(h);
        let right = after.start();
        let change = (right[0] - q).abs().max((right[1] - qd).abs()).max((right[2] - qdd).abs());
        // The greater of two numbers is never NaN if only one of them is.
        change <= SMOOTH_TOLERANCE && (q + qd + qdd).is_finite()
    })
}

/// The pieces of a motion, and what counts as rounding where they meet.
struct Knots<'a> {
    dof: usize,
    knots: &'a [f64],
    pieces: &'a [Polynomial],
    /// For each joint the largest position, velocity and acceleration at a knot, at least 1.
    scales: Vec<[f64; 3]>,
}

/// What changes at a knot for one joint: right minus left, and how much rounding can account for.
struct Step {
    size: [f64; 3],
    tolerance: [f64; 3],
}

impl Step {
    /// Whether this derivative jumps; a step that is not a number does.
    fn jumps(&self, order: usize) -> bool {
        self.size[order].abs() > self.tolerance[order] || self.size[order].is_nan()
    }
}

impl<'a> Knots<'a> {
    fn new(dof: usize, knots: &'a [f64], pieces: &'a [Polynomial]) -> Self {
        let mut scales = vec![[1.0_f64; 3]; dof];
        for (index, polynomial) in pieces.iter().enumerate() {
            let piece = index / dof;
            for values in [polynomial.eval(0.0), polynomial.eval(knots[piece + 1] - knots[piece])] {
                for (scale, value) in scales[index % dof].iter_mut().zip(values) {
                    *scale = scale.max(value.abs());
                }
            }
        }
        Self { dof, knots, pieces, scales }
    }

    /// The steps of all joints at an inner knot.
    fn steps(&self, knot: usize) -> impl Iterator<Item = Step> {
        /// A quintic through given states sums terms such as `q₁ - q₀` and `v h`, which nearly cancel, with
        /// factors of several hundred in all. On a short piece its acceleration is wrong by this times v/h.
        const ROUNDING: f64 = 1000.0 * f64::EPSILON;

        let [start, end] = [self.knots[knot - 1], self.knots[knot]];
        // Both knots are rounded to the spacing of floats, which late in a motion shows in the next
        // derivative.
        let time_error = 2.0 * f64::EPSILON * end;
        (0..self.dof).map(move |joint| {
            let before = &self.pieces[(knot - 1) * self.dof + joint];
            let left = before.eval(end - start);
            let right = self.pieces[knot * self.dof + joint].eval(0.0);
            let terms = before.magnitudes().eval(end - start);
            let change = terms[1] * (end - start);
            Step {
                size: std::array::from_fn(|order| right[order] - left[order]),
                tolerance: std::array::from_fn(|order| {
                    SMOOTH_TOLERANCE * self.scales[joint][order]
                        + ROUNDING * terms[order].max(change / (end - start).powi(order as i32))
                        + time_error * left[order + 1].abs()
                }),
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motion(pieces: Vec<Polynomial>, dof: usize) -> Trajectory {
        let knots = (0..=pieces.len() / dof).map(|k| k as f64).collect();
        Trajectory::new(dof, knots, pieces).unwrap()
    }

    #[test]
    fn a_step_of_jerk_is_smooth() {
        // t³/6, then the same state with the jerk reversed.
        let pieces = vec![
            Polynomial::new([0.0, 0.0, 0.0, 1.0 / 6.0]),
            Polynomial::new([1.0 / 6.0, 0.5, 0.5, -1.0 / 6.0]),
        ];
        let found = motion(pieces, 1).continuity();
        assert_eq!(found, Continuity { class: ContinuityClass::C2, jumps: vec![] });
    }

    #[test]
    fn each_class_is_told_from_the_next() {
        let ramp = Polynomial::new([0.0, 1.0, 1.0]);
        for (next, class, order, size) in [
            (Polynomial::new([2.5, 3.0, 1.0]), ContinuityClass::Discontinuous, 0, 0.5),
            (Polynomial::new([2.0, -1.0, 1.0]), ContinuityClass::C0, 1, -4.0),
            (Polynomial::new([2.0, 3.0, -0.5]), ContinuityClass::C1, 2, -3.0),
        ] {
            let found = motion(vec![ramp, next], 1).continuity();
            assert_eq!(found.class, class);
            assert_eq!(found.jumps, vec![Jump { time: 1.0, joint: 0, order, size }]);
        }
        assert!(ContinuityClass::Discontinuous < ContinuityClass::C2);
    }

    #[test]
    fn a_joint_does_not_hide_the_jump_of_another() {
        // At 1 s the first joint's velocity jumps, the second joint's acceleration.
        let pieces = vec![
            Polynomial::new([0.0, 1.0]),
            Polynomial::new([0.0, 0.0, 1.0]),
            Polynomial::new([1.0, 3.0]),
            Polynomial::new([1.0, 2.0, 0.5]),
        ];
        let motion = motion(pieces, 2);
        assert_eq!(motion.breaks(), [Break { knot: 1, order: 1, jump: vec![2.0, 0.0] }]);
        let found = motion.continuity();
        assert_eq!(found.class, ContinuityClass::C0);
        assert_eq!(
            found.jumps,
            vec![
                Jump { time: 1.0, joint: 0, order: 1, size: 2.0 },
                Jump { time: 1.0, joint: 1, order: 2, size: -1.0 },
            ]
        );
    }

    #[test]
    fn the_rounding_of_late_knots_is_no_break() {
        // Jerk up, jerk down for 5 µs each after an hour of rest, where floats are 4.5e-13 s apart.
        let (h, jerk) = (5e-6, 15_000.0);
        let up = Polynomial::new([0.0, 0.0, 0.0, jerk / 6.0]);
        let [q, qd, qdd, _] = up.eval(h);
        let down = Polynomial::new([q, qd, 0.5 * qdd, -jerk / 6.0]);
        let [q, qd, ..] = down.eval(h);
        let after = Polynomial::new([q, qd]);
        let bump = Trajectory::new(1, vec![0.0, h, 2.0 * h, 1.0], vec![up, down, after]).unwrap();
        let late = Trajectory::hold(&[0.0], 3600.0).unwrap().then(&bump).unwrap();
        assert!(late.breaks().is_empty(), "{:?}", late.breaks());
    }

    #[test]
    fn short_pieces_that_fit_have_no_break() {
        // A sine by quintic pieces of 0.2 µs: the terms of the acceleration at a knot are a hundred million
        // times larger than the acceleration.
        let h = 2e-7;
        let state = |i: usize| {
            let (sin, cos) = (i as f64 * h + 1.0).sin_cos();
            [sin, cos, -sin]
        };
        let knots: Vec<f64> = (0..=50).map(|i| f64::from(i) * h).collect();
        let pieces = (0..50).map(|i| Polynomial::quintic_hermite(state(i), state(i + 1), h)).collect();
        let motion = Trajectory::new(1, knots, pieces).unwrap();
        assert!(motion.breaks().is_empty(), "{:?}", motion.breaks());
    }
}
