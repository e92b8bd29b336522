//! Peaks, ranges and violations of a motion, exact between its knots.
//!
//! ```
//! use graspcheck_motion::{Polynomial, Trajectory};
//!
//! // 1 rad in 2 s, rest to rest: a quintic peaks at 15/8 h/T, 10/√3 h/T² and 60 h/T³.
//! let swing = Polynomial::quintic_hermite([0.0; 3], [1.0, 0.0, 0.0], 2.0);
//! let motion = Trajectory::new(1, vec![0.0, 2.0], vec![swing])?;
//! let peak = motion.peak(0, 1);
//! assert!((peak.value - 15.0 / 16.0).abs() < 1e-12 && (peak.time - 1.0).abs() < 1e-12);
//! assert!((motion.peak(0, 2).value.abs() - 2.5 / 3.0_f64.sqrt()).abs() < 1e-12);
//! assert!((motion.peak(0, 3).value - 7.5).abs() < 1e-12);
//! // Where the velocity is above 0.9 rad/s: an interval around the middle, not a sample.
//! let [[from, to]] = motion.exceeds(0, 1, -0.9, 0.9)[..] else { panic!("one interval") };
//! assert!((motion.eval(from).qd[0] - 0.9).abs() < 1e-12 && (from + to - 2.0).abs() < 1e-12);
//! # Ok::<(), graspcheck_motion::TrajectoryError>(())
//! ```

use crate::extrema::{Extremum, root_between};
use crate::polynomial::Polynomial;
use crate::trajectory::Trajectory;

/// The value of largest magnitude that a joint's position, velocity, acceleration or jerk takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// The value with its sign, SI units.
    pub value: f64,
    /// When it is taken, s; the earliest instant if several are equal.
    pub time: f64,
}

impl Trajectory {
    /// The peak of a joint's derivative over the whole motion: order 0 position, 1 velocity,
    /// 2 acceleration, 3 jerk. At a knot both one-sided values count.
    ///
    /// NaN when coefficients are so large that evaluation overflows: no comparison with a limit then holds.
    ///
    /// ```
    /// use graspcheck_motion::{Polynomial, Trajectory};
    /// let pieces = vec![Polynomial::new([0.0, 0.0, 1.0]), Polynomial::new([1.0, 2.0, -2.0])];
    /// let motion = Trajectory::new(1, vec![0.0, 1.0, 2.0], pieces)?;
    /// // The deceleration, -4 from 1 s on, is larger than the acceleration of 2.
    /// let peak = motion.peak(0, 2);
    /// assert_eq!((peak.value, peak.time), (-4.0, 1.0));
    /// # Ok::<(), graspcheck_motion::TrajectoryError>(())
    /// ```
    ///
    /// # Panics
    /// When `joint` is out of range.
    #[must_use]
    pub fn peak(&self, joint: usize, order: usize) -> Peak {
        self.peaks_in(joint, order, 0.0, self.duration())
    }

    /// As [`Trajectory::peak`] on the stretch from `t0` to `t1`, s: at `t0` the limit from the right
    /// counts, at `t1` the limit from the left, at knots between them both.
    ///
    /// ```
    /// use graspcheck_motion::{Polynomial, Trajectory};
    /// let pieces = vec![Polynomial::new([0.0, 0.0, 1.0]), Polynomial::new([1.0, 2.0, -2.0])];
    /// let motion = Trajectory::new(1, vec![0.0, 1.0, 2.0], pieces)?;
    /// assert_eq!(motion.peaks_in(0, 2, 0.0, 1.0).value, 2.0); // from the left at 1 s
    /// assert_eq!(motion.peaks_in(0, 2, 1.0, 1.0).value, -4.0); // from the right
    /// # Ok::<(), graspcheck_motion::TrajectoryError>(())
    /// ```
    ///
    /// # Panics
    /// When `joint` is out of range, or not `0 ≤ t0 ≤ t1 ≤ duration`.
    #[must_use]
    pub fn peaks_in(&self, joint: usize, order: usize, t0: f64, t1: f64) -> Peak {
        let mut peak = Peak { value: 0.0, time: t0 };
        for stretch in self.stretches(joint, t0, t1) {
            let [mut low, mut high] = stretch.polynomial.range(order, stretch.from, stretch.to);
            if high.tau < low.tau {
                (low, high) = (high, low);
            }
            for extremum in [low, high] {
                if extremum.value.is_nan() {
                    return Peak { value: f64::NAN, time: stretch.time(extremum.tau) };
                }
                if extremum.value.abs() > peak.value.abs() {
                    peak = Peak { value: extremum.value, time: stretch.time(extremum.tau) };
                }
            }
        }
        peak
    }

    /// The least and the greatest position of a joint between `t0` and `t1`, rad or m.
    ///
    /// ```
    /// use graspcheck_motion::{Polynomial, Trajectory};
    /// let pieces = vec![Polynomial::new([0.0, 0.0, 1.0]), Polynomial::new([1.0, 2.0, -2.0])];
    /// let motion = Trajectory::new(1, vec![0.0, 1.0, 2.0], pieces)?;
    /// // 1 + 2τ - 2τ² rises to 1.5 at 1.5 s and falls to 1.
    /// assert_eq!(motion.position_range(0, 0.0, 2.0), [0.0, 1.5]);
    /// # Ok::<(), graspcheck_motion::TrajectoryError>(())
    /// ```
    ///
    /// # Panics
    /// When `joint` is out of range, or not `0 ≤ t0 ≤ t1 ≤ duration`.
    #[must_use]
    pub fn position_range(&self, joint: usize, t0: f64, t1: f64) -> [f64; 2] {
        let [low, high] = self.range_in(joint, 0, t0, t1);
        [low.value, high.value]
    }

    /// The least and the greatest value of a joint's derivative between `t0` and `t1`, each with the time at
    /// which it is taken, s. One-sided values count as in [`Trajectory::peaks_in`].
    ///
    /// ```
    /// use graspcheck_motion::{Polynomial, Trajectory};
    /// let pieces = vec![Polynomial::new([0.0, 0.0, 1.0]), Polynomial::new([1.0, 2.0, -2.0])];
    /// let motion = Trajectory::new(1, vec![0.0, 1.0, 2.0], pieces)?;
    /// let [low, high] = motion.range_in(0, 1, 0.0, 2.0);
    /// assert_eq!((low.value, low.time, high.value, high.time), (-2.0, 2.0, 2.0, 1.0));
    /// # Ok::<(), graspcheck_motion::TrajectoryError>(())
    /// ```
    ///
    /// # Panics
    /// When `joint` is out of range, or not `0 ≤ t0 ≤ t1 ≤ duration`.
    #[must_use]
    pub fn range_in(&self, joint: usize, order: usize, t0: f64, t1: f64) -> [Peak; 2] {
        let mut low = Peak { value: f64::INFINITY, time: t0 };
        let mut high = Peak { value: f64::NEG_INFINITY, time: t0 };
        for stretch in self.stretches(joint, t0, t1) {
            let [least, greatest] = stretch.polynomial.range(order, stretch.from, stretch.to);
            if least.value.is_nan() {
                return [Peak { value: f64::NAN, time: stretch.time(least.tau) }; 2];
            }
            if least.value < low.value {
                low = Peak { value: least.value, time: stretch.time(least.tau) };
            }
            if greatest.value > high.value {
                high = Peak { value: greatest.value, time: stretch.time(greatest.tau) };
            }
        }
        [low, high]
    }

    /// The intervals `[from, to]`, s, in which a joint's derivative is below `lower` or above `upper`, in
    /// order of time, exact to rounding. Neighbours that touch are one interval. Empty means that the limits
    /// hold at every instant; a value equal to a limit is inside, so that rounding decides for a motion that
    /// follows its limit: widen the limits by the tolerance with which they are to be held.
    ///
    /// Where evaluation overflows the derivative counts as outside; so does everything when not
    /// `lower ≤ upper`.
    ///
    /// ```
    /// use graspcheck_motion::{Polynomial, Trajectory};
    /// let pieces = vec![Polynomial::new([0.0, 0.0, 1.0]), Polynomial::new([1.0, 2.0, -2.0])];
    /// let motion = Trajectory::new(1, vec![0.0, 1.0, 2.0], pieces)?;
    /// // The velocity is 2t up to 1 s, then 2 - 4τ: above 1 from 0.5 s to 1.25 s, never below -3.
    /// assert_eq!(motion.exceeds(0, 1, -3.0, 1.0), [[0.5, 1.25]]);
    /// # Ok::<(), graspcheck_motion::TrajectoryError>(())
    /// ```
    ///
    /// # Panics
    /// When `joint` is out of range.
    #[must_use]
    pub fn exceeds(&self, joint: usize, order: usize, lower: f64, upper: f64) -> Vec<[f64; 2]> {
        let can_hold = lower <= upper;
        let mut intervals: Vec<[f64; 2]> = Vec::new();
        for stretch in self.stretches(joint, 0.0, self.duration()) {
            let monotone = stretch.polynomial.monotone(order, stretch.from, stretch.to);
            let mut points = monotone.points();
            let Some(mut start) = points.next() else { continue };
            for end in points {
                let parts = if can_hold {
                    outside(&monotone.function, start, end, lower, upper)
                } else {
                    [Some([start.tau, end.tau]), None]
                };
                for [from, to] in parts.into_iter().flatten() {
                    let [from, to] = [stretch.time(from), stretch.time(to)];
                    match intervals.last_mut() {
                        Some(last) if from <= last[1] => last[1] = last[1].max(to),
                        _ => intervals.push([from, to]),
                    }
                }
                start = end;
            }
        }
        intervals
    }

    /// The parts of a joint's pieces that lie between `t0` and `t1`.
    pub(crate) fn stretches(&self, joint: usize, t0: f64, t1: f64) -> impl Iterator<Item = Stretch<'_>> {
        assert!(joint < self.dof(), "joint {joint} of {}", self.dof());
        assert!(
            0.0 <= t0 && t0 <= t1 && t1 <= self.duration(),
            "the stretch from {t0} s to {t1} s is outside the motion, which lasts from 0 s to {} s",
            self.duration()
        );
        let knots = self.knots();
        let first = self.piece_at(t0);
        let last = first.max(knots.partition_point(|&knot| knot < t1).saturating_sub(1));
        (first..=last).map(move |piece| {
            let [start, end] = [knots[piece], knots[piece + 1]];
            Stretch {
                polynomial: self.piece(piece, joint),
                start,
                end,
                from: if piece == first { t0 - start } else { 0.0 },
                to: if piece == last { t1 - start } else { end - start },
            }
        })
    }
}

/// A part of one piece of one joint.
pub(crate) struct Stretch<'a> {
    pub(crate) polynomial: &'a Polynomial,
    /// When the whole piece begins and ends, s.
    start: f64,
    end: f64,
    /// The part of it, local time, s.
    pub(crate) from: f64,
    pub(crate) to: f64,
}

impl Stretch<'_> {
    /// Time of the motion at local time `tau`; never past the piece's end, where rounding could lead.
    fn time(&self, tau: f64) -> f64 {
        (self.start + tau).min(self.end)
    }
}

/// The parts of a stretch from `start` to `end`, on which `function` is monotone, in which it is outside
/// `[lower, upper]`: at most one at each end.
fn outside(
    function: &Polynomial,
    start: Extremum,
    end: Extremum,
    lower: f64,
    upper: f64,
) -> [Option<[f64; 2]>; 2] {
    let crossing = |limit: f64| {
        let above = |point: Extremum| Extremum { value: point.value - limit, tau: point.tau };
        root_between(&function.plus(-limit), function.degree(), above(start), above(end))
    };
    let side = |point: Extremum| match point.value {
        value if value > upper => Side::Above,
        value if value < lower => Side::Below,
        value if value.is_nan() => Side::Unknown,
        _ => Side::Inside,
    };
    let whole = Some([start.tau, end.tau]);
    let until = |limit: f64| Some([start.tau, crossing(limit)]);
    let since = |limit: f64| Some([crossing(limit), end.tau]);
    match (side(start), side(end)) {
        (Side::Inside, Side::Inside) => [None, None],
        (Side::Above, Side::Inside) => [until(upper), None],
        (Side::Below, Side::Inside) => [until(lower), None],
        (Side::Inside, Side::Above) => [None, since(upper)],
        (Side::Inside, Side::Below) => [None, since(lower)],
        (Side::Below, Side::Above) => [until(lower), since(upper)],
        (Side::Above, Side::Below) => [until(upper), since(lower)],
        (Side::Above, Side::Above) | (Side::Below, Side::Below) | (Side::Unknown, _) | (_, Side::Unknown) => {
            [whole, None]
        }
    }
}

/// Where a value lies with respect to a lower and an upper limit.
#[derive(Clone, Copy)]
enum Side {
    Below,
    Inside,
    Above,
    /// Not a number.
    Unknown,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// via-1 of the worked examples: 20° -> 80° -> 25°, 5 s each, through the middle at 10°/s; the
    /// acceleration jumps there.
    fn via() -> Trajectory {
        let pieces =
            vec![Polynomial::new([20.0, 0.0, 5.2, -0.56]), Polynomial::new([80.0, 10.0, -10.6, 1.28])];
        Trajectory::new(1, vec![0.0, 5.0, 10.0], pieces).unwrap()
    }

    #[test]
    fn a_peak_has_a_sign_and_both_sides_of_a_knot_count() {
        let motion = via();
        // Acceleration 10.4 - 3.36t ends at -6.4; -21.2 + 7.68τ begins at -21.2 and ends at 17.2.
        assert_eq!(motion.peak(0, 2), Peak { value: -21.2, time: 5.0 });
        let left = motion.peaks_in(0, 2, 4.0, 5.0);
        assert!((left.value + 6.4).abs() < 1e-12 && (left.time - 5.0).abs() < 1e-15, "{left:?}");
        // The overshoot past 80°: 10 - 21.2τ + 3.84τ² = 0.
        let tau = (21.2 - (21.2_f64.powi(2) - 153.6).sqrt()) / 7.68;
        let peak = motion.peak(0, 0);
        assert!((peak.time - 5.0 - tau).abs() < 1e-12, "{peak:?}");
        let [low, high] = motion.position_range(0, 0.0, 10.0);
        assert!((low - 20.0).abs() < 1e-15 && (high - peak.value).abs() < 1e-15, "[{low}, {high}]");
    }

    #[test]
    fn a_stretch_within_one_piece_sees_nothing_else() {
        let motion = via();
        let [low, high] = motion.position_range(0, 1.0, 2.0);
        assert!((low - motion.eval(1.0).q[0]).abs() < 1e-12);
        assert!((high - motion.eval(2.0).q[0]).abs() < 1e-12);
        let instant = motion.peaks_in(0, 2, 5.0, 5.0);
        assert_eq!(instant, Peak { value: -21.2, time: 5.0 }, "from the right");
    }

    #[test]
    fn violations_are_exact_intervals() {
        let motion = via();
        // |acceleration| > 10: 10.4 - 3.36t until 0.4/3.36; then -21.2 + 7.68τ < -10 until 11.2/7.68 and
        // > 10 from 31.2/7.68.
        let found = motion.exceeds(0, 2, -10.0, 10.0);
        let expected = [[0.0, 0.4 / 3.36], [5.0, 5.0 + 11.2 / 7.68], [5.0 + 31.2 / 7.68, 10.0]];
        assert_eq!(found.len(), 3, "{found:?}");
        for (a, b) in found.iter().flatten().zip(expected.iter().flatten()) {
            assert!((a - b).abs() < 1e-12, "{found:?} is not {expected:?}");
        }
        assert!(motion.exceeds(0, 2, -21.2, 17.200_001).is_empty());
        assert_eq!(motion.exceeds(0, 2, 1.0, f64::NAN), vec![[0.0, 10.0]], "no limit, nothing is inside");
    }

    #[test]
    fn violations_on_both_sides_of_a_knot_are_one_interval() {
        let motion = via();
        let found = motion.exceeds(0, 0, f64::NEG_INFINITY, 79.0);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0][0] < 5.0 && found[0][1] > 5.0);
        for t in found[0] {
            assert!((motion.eval(t).q[0] - 79.0).abs() < 1e-11, "{found:?}");
        }
    }

    #[test]
    fn a_peak_at_the_end_can_be_evaluated() {
        // 0.3 + (0.9 - 0.3) is one unit in the last place above 0.9.
        let pieces = vec![Polynomial::constant(0.0), Polynomial::new([0.0, 1.0])];
        let motion = Trajectory::new(1, vec![0.0, 0.3, 0.9], pieces).unwrap();
        let peak = motion.peak(0, 0);
        assert!(peak.time <= motion.duration());
        assert!((motion.eval(peak.time).q[0] - peak.value).abs() < 1e-15);
    }
}
