//! Bounds on a polynomial from its Bernstein coefficients, safe against rounding.
//!
//! On `[0, h]` a polynomial `Σ cₖ τᵏ` of degree n is a convex combination of its Bernstein coefficients
//! `bᵢ = Σ_{k≤i} C(i,k)/C(n,k) cₖ hᵏ`, so that it lies between the least and the greatest of them; `b₀` and
//! `bₙ` are its values at the ends (Farouki, "The Bernstein polynomial basis: a centennial retrospective",
//! 2012, section 3). Halving the interval by de Casteljau's scheme brings the bounds together
//! quadratically. No root is computed: this is the second way to the same statement as [`crate::extrema`],
//! and the cheaper one when there is room below the limit.
//!
//! **Rounding.** Let m be the degree of the derivative of order k, and u = ε/2. Forming `cᵢ hⁱ / C(m,i)` takes
//! at most m + 3 roundings and summing m, which is an error of (2m + 3) u Σ|cᵢ hⁱ|. [`Polynomial::eval`],
//! for which the bound shall hold too, rounds each term at most 2(m + k) + 2 times. Together that is less
//! than (2m + k + 3) ε Σ|cᵢ hⁱ| by one u, which is more than the terms of second order. Each halving adds at most m u
//! times the largest coefficient bᵢ.
//!
//! On a stretch that begins at a ≠ 0, [`enclose`] first moves the local time by a. The Taylor shift rounds each
//! of its terms at most 2n times, which is n ε times the derivative of order k of `Σ |cᵢ| τⁱ` at τ = |a| + h;
//! call that M. The sums above are at most M too. Everything together is less than (3n + 3) ε M, and one ε M
//! more covers terms of second order and the rounding of M itself.
//!
//! ```
//! use graspcheck_motion::bernstein::{Proof, bounds, proves_within};
//! use graspcheck_motion::Polynomial;
//!
//! // 3τ² − 2τ³ on one second: the velocity peaks at 1.5, its Bernstein coefficients are 0, 3, 0.
//! let p = Polynomial::new([0.0, 0.0, 3.0, -2.0]);
//! let [_, upper] = bounds(&p, 1, 1.0);
//! assert!((upper - 3.0).abs() < 1e-12);
//! // Halving brings the bound as near to the peak as the proof needs.
//! assert_eq!(proves_within(&p, 1, 1.0, -0.1, 1.500_001), Proof::Within);
//! assert!(matches!(proves_within(&p, 1, 1.0, -0.1, 1.499_999), Proof::Outside { .. }));
//! ```

use crate::interval::Interval;
use crate::polynomial::{MAX_DEGREE, Polynomial};

/// The outcome of [`proves_within`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Proof {
    /// The derivative is within the limits on the whole interval.
    Within,
    /// It is outside at this instant.
    Outside {
        /// Local time, s.
        tau: f64,
    },
    /// Its extremum is so near to a limit that rounding decides, evaluation overflows, or a limit is NaN.
    Undecided,
}

/// How often an interval is halved before a proof gives up: to a width of about 1e-12 of the whole.
const MAX_HALVINGS: u32 = 40;

/// Binds the Bernstein form of a derivative to a name and evaluates an expression with it. The number of
/// coefficients is a constant in each arm, so that every loop over them is unrolled.
macro_rules! with_form {
    ($polynomial:expr, $order:expr, $h:expr, $form:ident => $then:expr) => {
        match $polynomial.degree().saturating_sub($order) {
            0 => with_form!(@arm 1, $polynomial, $order, $h, $form, $then),
            1 => with_form!(@arm 2, $polynomial, $order, $h, $form, $then),
            2 => with_form!(@arm 3, $polynomial, $order, $h, $form, $then),
            3 => with_form!(@arm 4, $polynomial, $order, $h, $form, $then),
            4 => with_form!(@arm 5, $polynomial, $order, $h, $form, $then),
            5 => with_form!(@arm 6, $polynomial, $order, $h, $form, $then),
            6 => with_form!(@arm 7, $polynomial, $order, $h, $form, $then),
            _ => with_form!(@arm 8, $polynomial, $order, $h, $form, $then),
        }
    };
    (@arm $count:literal, $polynomial:expr, $order:expr, $h:expr, $form:ident, $then:expr) => {{
        let $form = Form::<$count>::new($polynomial, $order, $h);
        $then
    }};
}

/// A lower and an upper bound on the derivative of the given order on `[0, h]`, in the derivative's unit.
///
/// The bounds hold for the exact values of the polynomial with these coefficients and for what
/// [`Polynomial::eval`] computes. They are NaN, or the infinite interval, when `h` or a product overflows.
///
/// ```
/// use graspcheck_motion::{Polynomial, bernstein};
/// // The coefficients of 3τ² - 2τ³ on [0, 1] are 0, 0, 1, 1: here the bounds are the range.
/// let [low, high] = bernstein::bounds(&Polynomial::new([0.0, 0.0, 3.0, -2.0]), 0, 1.0);
/// assert!(low <= 0.0 && low > -1e-12 && high >= 1.0 && high < 1.0 + 1e-12);
/// ```
#[must_use]
pub fn bounds(polynomial: &Polynomial, order: usize, h: f64) -> [f64; 2] {
    with_form!(polynomial, order, h, form => {
        let [low, high] = form.hull();
        [low - form.slack, high + form.slack]
    })
}

/// Bounds on position, velocity, acceleration and jerk over the local times from `a` to `b` (s, in whichever
/// order): entry k belongs to the derivative of order k.
///
/// They hold for the exact values and for what [`Polynomial::eval`] computes there. On a short stretch they
/// exceed the true range by a share that shrinks with its length: each bound is off by at most a constant
/// times the square of the length, and by rounding. [`Interval::WHOLE`] where `a` or `b` is not finite or a
/// product overflows.
///
/// ```
/// use graspcheck_motion::{bernstein, Polynomial};
/// let p = Polynomial::new([0.0, 0.0, 3.0, -2.0]); // 3τ² - 2τ³, velocity 6τ - 6τ²
/// let [q, qd, _, qddd] = bernstein::enclose(&p, 0.4, 0.6);
/// assert!(q.contains(0.352) && q.contains(0.648) && q.width() < 0.296 + 1e-12);
/// assert!(qd.contains(1.5) && qd.upper() < 1.57); // the peak at 0.5 is inside
/// assert!(qddd.contains(-12.0) && qddd.width() < 1e-12);
/// ```
#[must_use]
pub fn enclose(polynomial: &Polynomial, a: f64, b: f64) -> [Interval; 4] {
    let [from, to] = if a < b { [a, b] } else { [b, a] };
    // At least the distance, also when that is rounded.
    let h = (Interval::point(to) - Interval::point(from)).upper();
    let degree = polynomial.degree();
    let shifted = polynomial.shifted(from);
    let magnitudes = polynomial.magnitudes().eval(from.abs() + h);
    std::array::from_fn(|order| {
        let [low, high] = with_form!(&shifted, order, h, form => form.hull());
        let slack = (3 * degree + 4) as f64 * f64::EPSILON * magnitudes[order] + f64::MIN_POSITIVE;
        Interval::between(low - slack, high + slack)
    })
}

/// Whether the derivative of the given order stays within `[lower, upper]` on `[0, h]`, proved by
/// subdivision. `Within` and `Outside` are proofs, also against rounding.
///
/// ```
/// use graspcheck_motion::{Polynomial, bernstein::{Proof, proves_within}};
/// let p = Polynomial::new([0.0, 1.0, -1.0]); // τ - τ², at most 1/4
/// assert_eq!(proves_within(&p, 0, 1.0, -0.1, 0.26), Proof::Within);
/// assert!(matches!(proves_within(&p, 0, 1.0, -0.1, 0.24), Proof::Outside { .. }));
/// ```
#[must_use]
pub fn proves_within(polynomial: &Polynomial, order: usize, h: f64, lower: f64, upper: f64) -> Proof {
    if lower.is_nan() || upper.is_nan() {
        return Proof::Undecided;
    }
    with_form!(polynomial, order, h, form => form.prove(lower, upper, [0.0, h], 0))
}

/// A polynomial of N Bernstein coefficients, degree N - 1, on some interval.
#[derive(Clone, Copy)]
struct Form<const N: usize> {
    coefficients: [f64; N],
    /// How far rounding may have moved them.
    slack: f64,
}

impl<const N: usize> Form<N> {
    /// The form of the derivative on `[0, h]`; its degree must be below N.
    #[inline]
    fn new(polynomial: &Polynomial, order: usize, h: f64) -> Self {
        let mut b = [0.0; N];
        let mut power = 1.0;
        let mut sum = 0.0;
        for (i, b) in b.iter_mut().enumerate() {
            let term = polynomial.derivative_coefficient(order, i) * power;
            sum += term.abs();
            *b = term * INVERSE_BINOMIALS[N - 1][i];
            power *= h;
        }
        // The binomial transform by repeated sums of neighbours.
        for pass in 1..N {
            for i in (pass..N).rev() {
                b[i] += b[i - 1];
            }
        }
        let slack = ((2 * (N - 1) + 3) as f64 + order as f64) * f64::EPSILON * sum + f64::MIN_POSITIVE;
        Self { coefficients: b, slack }
    }

    /// The least and the greatest coefficient; NaN when one is.
    #[inline]
    fn hull(&self) -> [f64; 2] {
        let first = self.coefficients[0];
        self.coefficients[1..].iter().fold([first, first], |[low, high], &b| {
            if b.is_nan() { [b, b] } else { [if b < low { b } else { low }, if b > high { b } else { high }] }
        })
    }

    fn prove(&self, lower: f64, upper: f64, [from, to]: [f64; 2], halvings: u32) -> Proof {
        let [low, high] = self.hull();
        if low - self.slack >= lower && high + self.slack <= upper {
            return Proof::Within;
        }
        for (value, tau) in [(self.coefficients[0], from), (self.coefficients[N - 1], to)] {
            if value + self.slack < lower || value - self.slack > upper {
                return Proof::Outside { tau };
            }
        }
        let may_be_better = low + self.slack < high - self.slack;
        if halvings == MAX_HALVINGS || !may_be_better {
            return Proof::Undecided;
        }
        let middle = 0.5 * (from + to);
        let [first, second] = self.halved(low.abs().max(high.abs()));
        // A violation in the second half outranks doubt in the first.
        match first.prove(lower, upper, [from, middle], halvings + 1) {
            Proof::Within => second.prove(lower, upper, [middle, to], halvings + 1),
            outside @ Proof::Outside { .. } => outside,
            Proof::Undecided => match second.prove(lower, upper, [middle, to], halvings + 1) {
                outside @ Proof::Outside { .. } => outside,
                Proof::Within | Proof::Undecided => Proof::Undecided,
            },
        }
    }

    /// The same polynomial on the two halves of the interval (de Casteljau); `largest` is the largest
    /// magnitude of a coefficient.
    #[inline]
    fn halved(&self, largest: f64) -> [Self; 2] {
        let mut first = *self;
        first.slack += 0.5 * (N - 1) as f64 * f64::EPSILON * largest;
        let mut second = first;
        for pass in 1..N {
            for i in 0..N - pass {
                second.coefficients[i] = 0.5 * (second.coefficients[i] + second.coefficients[i + 1]);
            }
            first.coefficients[pass] = second.coefficients[0];
        }
        [first, second]
    }
}

/// Entry `[n][k]` is 1 / C(n, k), rounded once.
const INVERSE_BINOMIALS: [[f64; MAX_DEGREE + 1]; MAX_DEGREE + 1] = {
    let mut table = [[1.0; MAX_DEGREE + 1]; MAX_DEGREE + 1];
    let mut n = 2;
    while n <= MAX_DEGREE {
        let mut choose = 1;
        let mut k = 1;
        while k < n {
            // C(n, k) = C(n, k - 1) (n - k + 1) / k, exact in integers.
            choose = choose * (n - k + 1) / k;
            table[n][k] = 1.0 / choose as f64;
            k += 1;
        }
        n += 1;
    }
    table
};

#[cfg(test)]
mod tests {
    use super::*;

    /// quintic-1 of the worked examples, 3 s.
    const QUINTIC: [f64; 6] = [0.0, 0.0, 5.0, 220.0 / 9.0, -40.0 / 3.0, 50.0 / 27.0];

    #[test]
    fn coefficients_of_a_cubic() {
        // 10 - 50t + 240t² - 160t³ (cubic-1) on [0, 1]: b = 10, 10 - 50/3, 10 - 100/3 + 80, 40.
        let form = Form::<4>::new(&Polynomial::new([10.0, -50.0, 240.0, -160.0]), 0, 1.0);
        for (b, expected) in form.coefficients.iter().zip([10.0, -20.0 / 3.0, 170.0 / 3.0, 40.0]) {
            assert!((b - expected).abs() < 1e-13, "{b} is not {expected}");
        }
    }

    #[test]
    fn halves_meet_and_keep_the_ends() {
        let p = Polynomial::new(QUINTIC);
        let [first, second] = Form::<5>::new(&p, 1, 3.0).halved(100.0);
        for (value, tau) in [
            (first.coefficients[0], 0.0),
            (first.coefficients[4], 1.5),
            (second.coefficients[0], 1.5),
            (second.coefficients[4], 3.0),
        ] {
            assert!((value - p.eval(tau)[1]).abs() < 1e-12);
        }
    }

    #[test]
    fn a_limit_just_above_the_peak_is_proved_and_one_just_below_refuted() {
        let p = Polynomial::new(QUINTIC);
        for order in 0..4 {
            let [low, high] = p.range(order, 0.0, 3.0);
            let gap = 1e-11 * (high.value - low.value);
            let within = proves_within(&p, order, 3.0, low.value - gap, high.value + gap);
            assert_eq!(within, Proof::Within, "order {order}");
            for (lower, upper) in [(low.value + gap, high.value), (low.value, high.value - gap)] {
                match proves_within(&p, order, 3.0, lower, upper) {
                    Proof::Outside { tau } => {
                        let value = p.eval(tau)[order];
                        assert!(value < lower || value > upper, "order {order}: {value} at {tau}");
                    }
                    other => panic!("order {order}: {other:?}"),
                }
            }
        }
    }

    #[test]
    fn rounding_at_the_limit_is_neither_proved_nor_refuted() {
        // Cruising at 0.1 rad/s exactly at its limit.
        let cruise = Polynomial::new([0.3, 0.1]);
        assert_eq!(proves_within(&cruise, 1, 2.0, -0.1, 0.1), Proof::Undecided);
        assert_eq!(proves_within(&cruise, 1, 2.0, -0.1 - 1e-15, 0.1 + 1e-15), Proof::Within);
        assert_eq!(proves_within(&cruise, 1, 2.0, f64::NAN, 0.2), Proof::Undecided);
        assert_eq!(proves_within(&cruise, 1, 2.0, 0.2, 0.0), Proof::Outside { tau: 0.0 });
    }
}
