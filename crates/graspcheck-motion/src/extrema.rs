//! Exact extrema of a polynomial and of its derivatives on an interval.
//!
//! The method is the derivative chain. Let m be the degree of p. Its m-th derivative is constant. Between
//! two neighbouring roots of p⁽ᵏ⁺¹⁾ the derivative p⁽ᵏ⁾ is monotone, so that it has there at most one
//! root, which a change of sign reveals. Descending from k = m, each step evaluates p⁽ᵏ⁾ at the roots of
//! p⁽ᵏ⁺¹⁾ and at both ends: the least and the greatest of these values are the extrema of p⁽ᵏ⁾, and the
//! changes of sign among them enclose its roots, which the next step needs. Nothing is sampled.
//!
//! A value that rounding alone could have made counts as zero at the very point where it was found. Had
//! the true root been beside it, the derivative would be within rounding of zero all the way there, and
//! the extremum would not differ by more than that.
//!
//! ```
//! use graspcheck_motion::Polynomial;
//!
//! // A cubic from 10° to 40° in 1 s with −50°/s at both ends leaves the interval [10°, 40°] on both sides.
//! let p = Polynomial::new([10.0, -50.0, 240.0, -160.0]);
//! let [low, high] = p.range(0, 0.0, 1.0);
//! assert!((low.value - 7.178_872).abs() < 1e-6 && (low.tau - 0.118_119).abs() < 1e-6);
//! assert!((high.value - 42.821_128).abs() < 1e-6 && (high.tau - 0.881_881).abs() < 1e-6);
//! // Velocity, acceleration and jerk in one go: the velocity peaks at 70°/s in the middle.
//! let [velocity, acceleration, jerk] = p.rate_ranges(0.0, 1.0);
//! assert_eq!((velocity[1].value, velocity[1].tau), (70.0, 0.5));
//! assert_eq!((acceleration[1].value, jerk[0].value), (480.0, -960.0));
//! ```

use crate::polynomial::{MAX_DEGREE, Polynomial};

/// The least or greatest value that a derivative takes on an interval.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extremum {
    /// The value, in the unit of the derivative (rad, rad/s, … or m, m/s, …).
    pub value: f64,
    /// Where it is taken, local time, s; the earliest place among those that were compared.
    pub tau: f64,
}

/// The most points that a [`Monotone`] has: both ends and the roots of a derivative between them.
const MAX_POINTS: usize = MAX_DEGREE + 1;

/// One derivative of a polynomial on an interval, cut into stretches on which it is monotone.
pub(crate) struct Monotone {
    /// The derivative.
    pub(crate) function: Polynomial,
    count: usize,
    taus: [f64; MAX_POINTS],
    values: [f64; MAX_POINTS],
}

impl Monotone {
    /// The points in order of time, each with the value there; the derivative is monotone between them.
    pub(crate) fn points(&self) -> impl Iterator<Item = Extremum> {
        let pairs = self.taus[..self.count].iter().zip(&self.values[..self.count]);
        pairs.map(|(&tau, &value)| Extremum { value, tau })
    }

    /// The least and the greatest value; NaN when a value is.
    fn range(&self) -> [Extremum; 2] {
        let first = Extremum { value: self.values[0], tau: self.taus[0] };
        let mut range = [first, first];
        for point in self.points() {
            if point.value.is_nan() {
                return [point, point];
            }
            if point.value < range[0].value {
                range[0] = point;
            }
            if point.value > range[1].value {
                range[1] = point;
            }
        }
        range
    }
}

impl Polynomial {
    /// The least and the greatest value of the `order`-th derivative on `[a, b]`, in this order, exact to
    /// rounding. Order 0 is the polynomial itself, 1 the velocity, 2 the acceleration, 3 the jerk; higher
    /// orders are computed just so.
    ///
    /// `a` and `b` are local times in s; either may be the smaller. When an end, or a value on the way, is
    /// NaN, so is the result: no comparison with a limit then holds.
    ///
    /// ```
    /// // τ - τ² on two seconds: highest at 0.5, lowest at the end.
    /// let [low, high] = graspcheck_motion::Polynomial::new([0.0, 1.0, -1.0]).range(0, 0.0, 2.0);
    /// assert_eq!((high.value, high.tau, low.value, low.tau), (0.25, 0.5, -2.0, 2.0));
    /// ```
    #[must_use]
    pub fn range(&self, order: usize, a: f64, b: f64) -> [Extremum; 2] {
        self.monotone(order, a, b).range()
    }

    /// As [`Polynomial::range`] for position, velocity, acceleration and jerk at once: entry `k` belongs to
    /// the `k`-th derivative. It takes no longer than the range of the position alone.
    ///
    /// ```
    /// let p = graspcheck_motion::Polynomial::new([0.0, 0.0, 3.0, -2.0]);
    /// let [q, qd, qdd, qddd] = p.ranges(0.0, 1.0);
    /// assert_eq!([q, qd, qdd, qddd].map(|range| range[1].value), [1.0, 1.5, 6.0, -12.0]);
    /// ```
    #[must_use]
    pub fn ranges(&self, a: f64, b: f64) -> [[Extremum; 2]; 4] {
        self.ranges_from::<4>(0, a, b)
    }

    /// As [`Polynomial::range`] for velocity, acceleration and jerk at once, in this order: what limits are
    /// held against. It takes no longer than the range of the velocity alone.
    ///
    /// ```
    /// let p = graspcheck_motion::Polynomial::new([0.0, 0.0, 3.0, -2.0]);
    /// assert_eq!(p.rate_ranges(0.0, 1.0).map(|[low, _]| low.value), [0.0, -6.0, -12.0]);
    /// ```
    #[must_use]
    pub fn rate_ranges(&self, a: f64, b: f64) -> [[Extremum; 2]; 3] {
        self.ranges_from::<3>(1, a, b)
    }

    /// The ranges of N derivatives, from the one of order `lowest` up.
    #[inline]
    fn ranges_from<const N: usize>(&self, lowest: usize, a: f64, b: f64) -> [[Extremum; 2]; N] {
        // Derivatives above the degree are zero, and the chain does not visit them.
        let mut ranges = [[Extremum { value: 0.0, tau: a.min(b) }; 2]; N];
        self.descend(lowest, a, b, |order, monotone| {
            if let Some(range) = ranges.get_mut(order - lowest) {
                *range = monotone.range();
            }
        });
        ranges
    }

    /// The `order`-th derivative on `[a, b]`, cut into monotone stretches.
    pub(crate) fn monotone(&self, order: usize, a: f64, b: f64) -> Monotone {
        self.descend(order, a, b, |_, _| ())
    }

    /// Goes down the chain from the derivative that is constant to the one of order `lowest`, shows each to
    /// `visit`, and returns the last.
    #[inline]
    fn descend(&self, lowest: usize, a: f64, b: f64, mut visit: impl FnMut(usize, &Monotone)) -> Monotone {
        let ends = if a.is_nan() || b.is_nan() { [f64::NAN; 2] } else { [a.min(b), a.max(b)] };
        let top = self.degree();
        let mut order = top.max(lowest);
        let mut taus = [ends[0]; MAX_POINTS];
        taus[1] = ends[1];
        let mut count = 2;
        loop {
            let function = self.derivative_of_order(order);
            let degree = top.saturating_sub(order);
            let mut monotone = Monotone { function, count, taus, values: [0.0; MAX_POINTS] };
            for (value, &tau) in monotone.values.iter_mut().zip(&taus[..count]) {
                *value = function.value(degree, tau);
            }
            visit(order, &monotone);
            if order == lowest {
                return monotone;
            }
            count = cut_at_roots(&monotone, degree, &mut taus);
            order -= 1;
        }
    }

    /// The value of a polynomial of this degree at `tau`.
    #[inline]
    pub(crate) fn value(&self, degree: usize, tau: f64) -> f64 {
        if degree <= 3 {
            let [a, b, c, d, ..] = *self.coefficients();
            return ((d * tau + c) * tau + b) * tau + a;
        }
        self.coefficients()[..=degree].iter().rev().fold(0.0, |value, c| value * tau + c)
    }
}

/// The ends of the interval and between them the roots of a function: writes them to `taus` in order and
/// returns how many they are.
#[inline]
fn cut_at_roots(monotone: &Monotone, degree: usize, taus: &mut [f64; MAX_POINTS]) -> usize {
    let Monotone { function, count, taus: points, values } = monotone;
    let last = count - 1;
    let noise = rounding_error(function, degree, points[0].abs().max(points[last].abs()));
    let is_zero = |value: f64| value.abs() <= noise;
    let mut found = 1;
    for i in 0..last {
        if i > 0 && is_zero(values[i]) {
            taus[found] = points[i];
            found += 1;
        }
        let opposite = (values[i] < 0.0) != (values[i + 1] < 0.0);
        if opposite && !is_zero(values[i]) && !is_zero(values[i + 1]) {
            taus[found] = root_between(
                function,
                degree,
                Extremum { value: values[i], tau: points[i] },
                Extremum { value: values[i + 1], tau: points[i + 1] },
            );
            found += 1;
        }
    }
    taus[found] = points[last];
    found + 1
}

/// A bound on the error of Horner's scheme for a polynomial of this degree anywhere in `|τ| ≤ radius`:
/// 2m u Σ |cₖ| |τ|ᵏ with the unit roundoff u = ε/2 (Higham, *Accuracy and Stability of Numerical
/// Algorithms*, section 5.1), and 2u more for coefficients and radius that are rounded themselves.
#[inline]
fn rounding_error(function: &Polynomial, degree: usize, radius: f64) -> f64 {
    let [a, b, c, d, e, high @ ..] = *function.coefficients();
    let square = radius * radius;
    let mut sum = (a.abs() + b.abs() * radius) + square * ((c.abs() + d.abs() * radius) + square * e.abs());
    if degree > 4 {
        let [f, g, h] = high.map(f64::abs);
        sum += (f * radius + square * (g + h * radius)) * square * square;
    }
    (degree + 1) as f64 * f64::EPSILON * sum
}

/// The root of a function of this degree that is monotone between two points at which it has values of
/// opposite sign: in closed form up to degree 2, else by Halley's method kept inside the bracket.
#[inline]
pub(crate) fn root_between(function: &Polynomial, degree: usize, start: Extremum, end: Extremum) -> f64 {
    let root = match degree {
        0 | 1 => start.tau - start.value * ((end.tau - start.tau) / (end.value - start.value)),
        2 => quadratic_root(function, start, end),
        // The number of coefficients is a constant, so that every loop over them is unrolled.
        3 | 4 => halley_root::<5>(function, start, end),
        5 => halley_root::<6>(function, start, end),
        _ => halley_root::<{ MAX_DEGREE + 1 }>(function, start, end),
    };
    // Rounding may push it out by one unit in the last place.
    root.max(start.tau).min(end.tau)
}

/// With `f(start + x) = f₀ + d x + c x²`, monotone up to the root, the root is `-2 f₀ / (d ± √(d² - 4 c f₀))`
/// with the sign of the slope: two terms of the same sign, so that nothing cancels.
#[inline]
fn quadratic_root(function: &Polynomial, start: Extremum, end: Extremum) -> f64 {
    let [_, c1, c2, ..] = *function.coefficients();
    let slope = c1 + 2.0 * c2 * start.tau;
    let root = (slope * slope - 4.0 * c2 * start.value).max(0.0).sqrt();
    let denominator = slope + root.copysign(end.value - start.value);
    start.tau - 2.0 * start.value / denominator
}

/// Halley's method, which takes the curvature into account, with bisection as its safeguard (as for Newton's method
/// in Press et al., *Numerical Recipes*, section 9.4). N is the number of coefficients that count.
fn halley_root<const N: usize>(function: &Polynomial, start: Extremum, end: Extremum) -> f64 {
    /// The method cubes the error: after a step this small, relative to the bracket, what is left is below
    /// rounding.
    const LAST_STEP: f64 = 1e-6;
    /// Bisection alone meets the spacing of floats within as many steps as a float has bits.
    const MAX_STEPS: usize = 128;

    /// A root is taken when the sign changes within this share of the bracket beyond it: where slope and value are
    /// small the method makes small steps far from any root.
    const SIGN_CHANGES: f64 = 1e-9;

    let last_step = LAST_STEP * (end.tau - start.tau);
    let slack = SIGN_CHANGES * (end.tau - start.tau);
    let rising = start.value < 0.0;
    let [mut low, mut high] = [start.tau, end.tau];
    // Where the chord is zero: nearer than the middle, also where the slope is zero at both ends.
    let chord = low - start.value * ((high - low) / (end.value - start.value));
    let mut tau = if chord > low && chord < high { chord } else { 0.5 * (low + high) };
    let mut step_before = high - low;
    for _ in 0..MAX_STEPS {
        let [value, slope, half_curvature] = value_slope_curvature::<N>(function, tau);
        if (value < 0.0) == rising {
            low = tau;
        } else {
            high = tau;
        }
        let halley = tau - value * slope / (slope * slope - value * half_curvature);
        // At the root itself the step is zero. False for NaN as well, which a slope of zero makes.
        let converges = halley >= low && halley <= high && (halley - tau).abs() <= 0.5 * step_before;
        let mut next = if converges { halley } else { 0.5 * (low + high) };
        let step = (next - tau).abs();
        if value == 0.0 || (step == 0.0 && !converges) {
            break;
        }
        if converges && step <= last_step {
            let is_below = (value < 0.0) == rising;
            let away = slack.max(4.0 * step);
            let beyond = if is_below { next + away } else { next - away };
            let is_outside = beyond <= low || beyond >= high;
            if is_outside || (function.eval(beyond)[0] < 0.0) != (value < 0.0) {
                return next;
            }
            *(if is_below { &mut low } else { &mut high }) = beyond;
            next = 0.5 * (low + high);
        }
        step_before = (next - tau).abs();
        tau = next;
    }
    tau
}

/// The value, the first derivative, and half the second of a polynomial of N coefficients.
#[inline]
fn value_slope_curvature<const N: usize>(function: &Polynomial, tau: f64) -> [f64; 3] {
    if N <= 5 {
        // By pairs (Estrin's scheme): the sums do not wait for each other.
        let [a, b, c, d, e, ..] = *function.coefficients();
        let square = tau * tau;
        let value = (a + b * tau) + square * ((c + d * tau) + square * e);
        let slope = (b + 2.0 * c * tau) + square * (3.0 * d + 4.0 * e * tau);
        return [value, slope, (c + 3.0 * d * tau) + 6.0 * e * square];
    }
    let [mut value, mut slope, mut half_curvature] = [0.0; 3];
    for &c in function.coefficients()[..N].iter().rev() {
        half_curvature = half_curvature * tau + slope;
        slope = slope * tau + value;
        value = value * tau + c;
    }
    [value, slope, half_curvature]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_extremum(found: Extremum, value: f64, tau: f64, tolerance: f64) {
        assert!((found.value - value).abs() <= tolerance, "{found:?} is not {value}");
        assert!((found.tau - tau).abs() <= tolerance, "{found:?} is not at {tau}");
    }

    /// At the chord's point the slope is nearly zero, and so is Halley's step.
    #[test]
    fn a_small_step_is_no_root() {
        let quintic = Polynomial::new([0.0, -1.0, 0.0, 0.0, 0.0, 1000.0]);
        let [low, _] = quintic.range(0, 0.0, 4.0);
        let at = 5000.0_f64.powf(-0.25);
        assert!((low.tau - at).abs() < 1e-9, "{low:?}");
        assert!((low.value + 0.8 * at).abs() < 1e-12, "{low:?}");
        // Sizes far apart on one piece: no sample is below the least value.
        for k in 0..60 {
            let [a, b] = [10.0_f64.powi(k % 7 - 3), 10.0_f64.powi(k % 5 - 1)];
            let septic = Polynomial::new([0.0, -a, 0.3 * b, 0.0, -b, 0.0, 0.0, 10.0 * a * b]);
            let [low, high] = septic.range(0, 0.0, 3.0);
            for step in 0..=3000 {
                let value = septic.eval(f64::from(step) * 1e-3)[0];
                let slack = 1e-12 * (1.0 + high.value.abs());
                assert!(value >= low.value - slack && value <= high.value + slack, "{k}: {value}, {low:?}");
            }
        }
    }

    #[test]
    fn a_cubic_overshoots_its_end_points() {
        // cubic-1 of the worked examples: 10° -> 40° in 1 s with -50°/s at both ends.
        let [low, high] = Polynomial::new([10.0, -50.0, 240.0, -160.0]).range(0, 0.0, 1.0);
        assert_extremum(low, 7.178_872, 0.118_119, 5e-7);
        assert_extremum(high, 42.821_128, 0.881_881, 5e-7);
        // Exactly: the velocity's roots are 1/2 ± √(7/48), the extrema 25 ± 160 (7/48)^(3/2) ⋅ 2.
        let root = (7.0_f64 / 48.0).sqrt();
        assert_extremum(low, 25.0 - 320.0 * root.powi(3), 0.5 - root, 1e-13);
    }

    #[test]
    fn peaks_of_a_cubic_from_rest_to_rest() {
        // cubic-2: 50° -> 80° in 3 s; peak velocity 3D/(2T) at T/2, peak acceleration 6D/T² at both ends.
        let p = Polynomial::new([50.0, 0.0, 10.0, -20.0 / 9.0]);
        let [position, velocity, acceleration, jerk] = p.ranges(0.0, 3.0);
        assert_extremum(position[0], 50.0, 0.0, 1e-13);
        assert_extremum(position[1], 80.0, 3.0, 1e-13);
        assert_extremum(velocity[0], 0.0, 0.0, 1e-13);
        assert_extremum(velocity[1], 15.0, 1.5, 1e-13);
        assert_extremum(acceleration[0], -20.0, 3.0, 1e-13);
        assert_extremum(acceleration[1], 20.0, 0.0, 1e-13);
        assert_extremum(jerk[0], -40.0 / 3.0, 0.0, 1e-13);
    }

    #[test]
    fn peaks_of_a_quintic_from_rest_to_rest() {
        // Section 3 of the worked examples: 15D/(8T), 10D/(√3 T²), 60D/T³, with roots at the very ends.
        let (stroke, duration) = (0.7, 0.4);
        let p = Polynomial::quintic_hermite([0.0; 3], [stroke, 0.0, 0.0], duration);
        let [position, velocity, acceleration, jerk] = p.ranges(0.0, duration);
        assert_extremum(position[0], 0.0, 0.0, 1e-12);
        assert_extremum(position[1], stroke, duration, 1e-6);
        assert_extremum(velocity[1], 1.875 * stroke / duration, 0.5 * duration, 1e-12);
        let peak = 10.0 / 3.0_f64.sqrt() * stroke / duration.powi(2);
        let early = duration * (0.5 - 3.0_f64.sqrt() / 6.0);
        assert_extremum(acceleration[1], peak, early, 1e-11);
        assert_extremum(acceleration[0], -peak, duration - early, 1e-11);
        assert_extremum(jerk[1], 60.0 * stroke / duration.powi(3), 0.0, 1e-10);
    }

    #[test]
    fn peaks_of_a_quintic_that_accelerates_at_its_ends() {
        // quintic-1: 5τ² + 220/9 τ³ - 40/3 τ⁴ + 50/27 τ⁵ on 3 s. The jerk 440/3 - 320τ + 1000/9 τ² has its
        // roots at (36 ± √471)/25.
        let p = Polynomial::new([0.0, 0.0, 5.0, 220.0 / 9.0, -40.0 / 3.0, 50.0 / 27.0]);
        let roots = [-1.0, 1.0].map(|sign: f64| (36.0 + sign * 471.0_f64.sqrt()) / 25.0);
        let [low, high] = p.range(2, 0.0, 3.0);
        assert_extremum(high, p.eval(roots[0])[2], roots[0], 1e-12);
        assert_extremum(low, p.eval(roots[1])[2], roots[1], 1e-12);
        // It starts and ends with 10°/s², not extremal.
        assert!(high.value > 10.0 && low.value < 10.0);
    }

    #[test]
    fn every_degree_up_to_seven_alternates_between_its_extrema() {
        // Chebyshev polynomials on [-1, 1] take ±1 at cos(kπ/n) and nothing beyond.
        let mut before = Polynomial::constant(1.0);
        let mut current = Polynomial::new([0.0, 1.0]);
        for degree in 1..=MAX_DEGREE {
            let monotone = current.monotone(0, -1.0, 1.0);
            assert_eq!(monotone.count, degree + 1, "degree {degree}");
            for (i, point) in monotone.points().enumerate() {
                let k = degree - i;
                let tau = (k as f64 * std::f64::consts::PI / degree as f64).cos();
                assert_extremum(point, if k % 2 == 0 { 1.0 } else { -1.0 }, tau, 1e-12);
            }
            let mut next = [0.0; MAX_DEGREE + 1];
            for (k, c) in next.iter_mut().enumerate() {
                let double = if k > 0 { 2.0 * current.coefficients()[k - 1] } else { 0.0 };
                *c = double - before.coefficients()[k];
            }
            (before, current) = (current, Polynomial::new(next));
        }
    }

    #[test]
    fn an_interval_may_be_a_point_or_reversed() {
        let p = Polynomial::new([1.0, 2.0, 3.0]);
        let [low, high] = p.range(0, 0.5, 0.5);
        assert_eq!(low, high);
        assert_extremum(low, 2.75, 0.5, 0.0);
        assert_eq!(p.range(0, 1.0, -1.0), p.range(0, -1.0, 1.0));
        assert_extremum(p.range(0, 1.0, -1.0)[0], 2.0 / 3.0, -1.0 / 3.0, 1e-15);
    }

    #[test]
    fn what_is_not_a_number_has_no_range() {
        // The coefficient of the velocity overflows, and at τ = 0 it is infinity times zero.
        let overflowing = Polynomial::new([0.0, 0.0, 1e308]);
        for range in [overflowing.range(1, 0.0, 1.0), Polynomial::new([1.0, 2.0]).range(0, 0.0, f64::NAN)] {
            assert!(range.iter().all(|extremum| extremum.value.is_nan()), "{range:?}");
        }
    }
}
