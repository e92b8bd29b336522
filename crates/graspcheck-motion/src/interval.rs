//! Interval arithmetic that is sound against rounding: what encloses the operands encloses the result.
//!
//! An [`Interval`] is a closed, non-empty set `[lower, upper]` of real numbers. Every operation returns an
//! interval that contains the exact result of every choice of numbers from its operands, *and* what the same
//! operation returns in `f64` for them. A formula evaluated with intervals therefore bounds both the
//! mathematics and the code that computes it with floats, which is what a proof about a program needs
//! (Moore, Kearfott, Cloud, *Introduction to Interval Analysis*, 2009, chapters 2 and 5).
//!
//! ```
//! use graspcheck_motion::Interval;
//!
//! let x = Interval::new(1.0, 2.0)?;
//! let y = x.square() - x; // x² - x is between 0 and 2 there
//! assert!(y.contains(0.0) && y.contains(2.0));
//! // Interval arithmetic does not see that both x are the same number: it answers [-1, 3].
//! assert_eq!(y, Interval::new(-1.0, 3.0)?.hull(y));
//! # Ok::<(), graspcheck_motion::IntervalError>(())
//! ```
//!
//! **Rounding.** Floats are rounded to nearest, so that the exact result lies between the two neighbours of
//! the computed one. Sums are exact about it: the error of a sum is itself a float (TwoSum; Knuth, *The Art
//! of Computer Programming* 2, section 4.2.2), and an end moves out by one unit in the last place only if
//! its error points outwards. Products, quotients and roots move out by one unit unless they are exactly
//! zero. Sine and cosine come from the mathematical library of the system; see [`Interval::sin_cos`].
//!
//! **What is not a number.** There is no empty interval and none with NaN. Where an operation has no
//! value, or an unbounded operand leaves it open (0 · ∞), the result is [`Interval::WHOLE`]: nothing is known,
//! and no bound can be proved from it. The only operation that can leave nothing, the
//! [intersection](Interval::intersection), returns an `Option`.

use std::{
    f64::consts::{FRAC_PI_2, TAU},
    fmt,
    ops::{Add, Div, Mul, Neg, Sub},
};

use serde::{Deserialize, Serialize};

/// How many units in the last place a sine or cosine moves outwards. The libraries of the common systems
/// state errors below one unit (the GNU C library's manual, "Known Maximum Errors in Math Functions"; musl
/// and the `libm` crate descend from FreeBSD's msun, which states the same). One such error at the end of
/// an interval and one at the point inside that must be contained make two; the rest is a reserve.
const TRIGONOMETRIC_UNITS: f64 = 4.0;

/// Arguments larger than this, rad, are not reduced: sine and cosine are then [-1, 1].
const LARGEST_ANGLE: f64 = 1e6;

/// Why two numbers are no interval.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "interval: from {lower} to {upper} is empty or not a number; give a lower end that is at most the upper one"
)]
pub struct IntervalError {
    /// The first number.
    pub lower: f64,
    /// The second number.
    pub upper: f64,
}

/// A closed, non-empty set `[lower, upper]` of real numbers; an infinite end means no bound on that side.
#[derive(Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "[f64; 2]", into = "[f64; 2]")]
pub struct Interval {
    lower: f64,
    upper: f64,
}

impl Interval {
    /// All real numbers: nothing is known.
    pub const WHOLE: Self = Self { lower: f64::NEG_INFINITY, upper: f64::INFINITY };
    /// The number 0.
    pub const ZERO: Self = Self { lower: 0.0, upper: 0.0 };
    /// What a sine can be.
    const UNIT: Self = Self { lower: -1.0, upper: 1.0 };

    /// The interval from `lower` to `upper`.
    ///
    /// # Errors
    /// When `lower` exceeds `upper`, either is NaN, or no real number is between them (both +∞ or both −∞).
    ///
    /// ```
    /// use graspcheck_motion::Interval;
    /// assert!(Interval::new(-1.0, 2.0).is_ok_and(|x| x.contains(0.0)));
    /// assert!(Interval::new(2.0, -1.0).is_err());
    /// assert!(Interval::new(f64::NAN, 0.0).is_err());
    /// ```
    pub fn new(lower: f64, upper: f64) -> Result<Self, IntervalError> {
        if lower <= upper && lower < f64::INFINITY && upper > f64::NEG_INFINITY {
            Ok(Self { lower, upper })
        } else {
            Err(IntervalError { lower, upper })
        }
    }

    /// The one number `value`. NaN gives [`Interval::WHOLE`], ±∞ all numbers beyond the largest float.
    #[inline]
    #[must_use]
    pub fn point(value: f64) -> Self {
        Self::between(value, value)
    }

    /// The smallest interval that holds both numbers, in whichever order; [`Interval::WHOLE`] if one is NaN.
    ///
    /// ```
    /// use graspcheck_motion::Interval;
    /// assert_eq!(Interval::between(3.0, -1.0), Interval::new(-1.0, 3.0)?);
    /// # Ok::<(), graspcheck_motion::IntervalError>(())
    /// ```
    #[inline]
    #[must_use]
    pub fn between(a: f64, b: f64) -> Self {
        if a.is_nan() || b.is_nan() {
            return Self::WHOLE;
        }
        Self { lower: a.min(b).min(f64::MAX), upper: a.max(b).max(f64::MIN) }
    }

    /// The lower end; −∞ if there is none.
    #[inline]
    #[must_use]
    pub fn lower(self) -> f64 {
        self.lower
    }

    /// The upper end; +∞ if there is none.
    #[inline]
    #[must_use]
    pub fn upper(self) -> f64 {
        self.upper
    }

    /// A float inside, as near to the middle as rounding allows; 0 for [`Interval::WHOLE`].
    #[must_use]
    pub fn middle(self) -> f64 {
        let middle = 0.5 * self.lower + 0.5 * self.upper;
        if middle.is_nan() { 0.0 } else { middle.clamp(self.lower.max(f64::MIN), self.upper.min(f64::MAX)) }
    }

    /// An upper bound on the distance between the ends; never negative, +∞ if unbounded.
    #[must_use]
    pub fn width(self) -> f64 {
        add_up(self.upper, -self.lower)
    }

    /// The largest magnitude of a number inside.
    ///
    /// ```
    /// use graspcheck_motion::Interval;
    /// assert_eq!(Interval::between(-3.0, 2.0).magnitude(), 3.0);
    /// ```
    #[inline]
    #[must_use]
    pub fn magnitude(self) -> f64 {
        self.lower.abs().max(self.upper.abs())
    }

    /// The least magnitude of a number inside: 0 if 0 is.
    ///
    /// ```
    /// use graspcheck_motion::Interval;
    /// assert_eq!(Interval::between(-3.0, -2.0).mignitude(), 2.0);
    /// assert_eq!(Interval::between(-3.0, 2.0).mignitude(), 0.0);
    /// ```
    #[must_use]
    pub fn mignitude(self) -> f64 {
        self.lower.max(-self.upper).max(0.0)
    }

    /// Whether `value` is inside; false for NaN.
    #[inline]
    #[must_use]
    pub fn contains(self, value: f64) -> bool {
        self.lower <= value && value <= self.upper
    }

    /// Whether every number inside is in `other` too.
    #[must_use]
    pub fn is_within(self, other: Self) -> bool {
        other.lower <= self.lower && self.upper <= other.upper
    }

    /// The smallest interval that holds both.
    #[must_use]
    pub fn hull(self, other: Self) -> Self {
        Self { lower: self.lower.min(other.lower), upper: self.upper.max(other.upper) }
    }

    /// What both have in common; `None` when that is nothing.
    ///
    /// ```
    /// use graspcheck_motion::Interval;
    /// let [a, b] = [Interval::between(0.0, 2.0), Interval::between(1.0, 3.0)];
    /// assert_eq!(a.intersection(b), Some(Interval::between(1.0, 2.0)));
    /// assert_eq!(a.intersection(Interval::point(2.5)), None);
    /// ```
    #[must_use]
    pub fn intersection(self, other: Self) -> Option<Self> {
        Self::new(self.lower.max(other.lower), self.upper.min(other.upper)).ok()
    }

    /// This interval with both ends moved out by `distance`.
    ///
    /// ```
    /// use graspcheck_motion::Interval;
    /// let x = Interval::between(1.0, 2.0).widened(0.5);
    /// assert_eq!((x.lower(), x.upper(), x.middle(), x.width()), (0.5, 2.5, 1.5, 2.0));
    /// ```
    ///
    /// # Panics
    /// When `distance` is negative or NaN.
    #[must_use]
    pub fn widened(self, distance: f64) -> Self {
        assert!(distance >= 0.0, "an interval cannot be widened by {distance}");
        Self { lower: add_down(self.lower, -distance), upper: add_up(self.upper, distance) }
    }

    /// The square: never negative, and tighter than `x * x` where 0 is inside.
    ///
    /// ```
    /// use graspcheck_motion::Interval;
    /// assert_eq!(Interval::between(-1.0, 2.0).square().lower(), 0.0);
    /// ```
    #[inline]
    #[must_use]
    pub fn square(self) -> Self {
        let [least, greatest] = [self.mignitude(), self.magnitude()];
        Self {
            lower: if least == 0.0 { 0.0 } else { (least * least).next_down().max(0.0) },
            upper: if greatest == 0.0 { 0.0 } else { (greatest * greatest).next_up() },
        }
    }

    /// The power with an integer exponent, exact to rounding: odd powers rise, even ones fall up to 0 and rise
    /// from there. `x⁰` is 1 also for 0, as for `f64`; a negative exponent divides 1 by the power.
    ///
    /// It contains the exact powers. What `f64::powi` returns it need not contain: the precision of that is
    /// not promised.
    ///
    /// ```
    /// use graspcheck_motion::Interval;
    /// let x = Interval::between(-1.0, 2.0);
    /// assert!(x.powi(3).contains(-1.0) && x.powi(3).contains(8.0) && !x.powi(3).contains(-1.001));
    /// assert_eq!(x.powi(4).lower(), 0.0);
    /// ```
    #[must_use]
    pub fn powi(self, exponent: i32) -> Self {
        let power = |value: f64| {
            let (mut result, mut square) = (Self::point(1.0), Self::point(value));
            let mut left = exponent.unsigned_abs();
            while left > 0 {
                if left % 2 == 1 {
                    result = result * square;
                }
                left /= 2;
                if left > 0 {
                    square = square.square();
                }
            }
            result
        };
        let [from, to] =
            if exponent % 2 == 0 { [self.mignitude(), self.magnitude()] } else { [self.lower, self.upper] };
        let positive = Self { lower: power(from).lower, upper: power(to).upper };
        if exponent < 0 { Self::point(1.0) / positive } else { positive }
    }

    /// The square root of what is not negative inside; [`Interval::WHOLE`] when all of it is negative.
    ///
    /// The part below zero is left out: it is there because of overestimation, or the formula is wrong.
    ///
    /// ```
    /// use graspcheck_motion::Interval;
    /// let root = Interval::between(-1.0, 4.0).sqrt();
    /// assert!(root.lower() == 0.0 && root.contains(2.0) && root.upper() < 2.000_001);
    /// ```
    #[must_use]
    pub fn sqrt(self) -> Self {
        if self.upper < 0.0 {
            return Self::WHOLE;
        }
        let [lower, upper] = [self.lower.max(0.0).sqrt(), self.upper.sqrt()];
        Self {
            lower: if lower == 0.0 { 0.0 } else { lower.next_down() },
            upper: if upper == 0.0 { 0.0 } else { upper.next_up() },
        }
    }

    /// The magnitudes of the numbers inside.
    #[must_use]
    pub fn abs(self) -> Self {
        Self { lower: self.mignitude(), upper: self.magnitude() }
    }

    /// Sine and cosine of angles in rad.
    ///
    /// Inside `[a, b]` the cosine takes 1 when a multiple of 2π is inside, −1 when an odd multiple of π is,
    /// and else is between its values at the ends; the sine is the cosine a quarter turn earlier. Whether a
    /// multiple is inside is asked with more room than rounding takes: where that claims an extremum that is
    /// just outside, the bound is off by a second-order quantity, below 1e-24 for an angle of one turn.
    ///
    /// Values at the ends move outwards by four units in the last place. The library's error must be below
    /// one and a half of them, which all common ones state by a margin.
    ///
    /// ```
    /// use std::f64::consts::PI;
    /// use graspcheck_motion::Interval;
    /// let (sin, cos) = Interval::between(0.5, 2.0).sin_cos();
    /// assert_eq!(sin.upper(), 1.0); // π/2 is inside
    /// assert!(sin.contains(0.5_f64.sin()) && !sin.contains(0.47));
    /// assert!(cos.contains(2.0_f64.cos()) && cos.contains((PI / 3.0).cos()) && !cos.contains(0.9));
    /// ```
    #[must_use]
    pub fn sin_cos(self) -> (Self, Self) {
        let Self { lower, upper } = self;
        if self.magnitude() > LARGEST_ANGLE || upper - lower >= TAU {
            return (Self::UNIT, Self::UNIT);
        }
        let (sin_lower, cos_lower) = lower.sin_cos();
        #[expect(clippy::float_cmp, reason = "only the very same number spares its evaluation")]
        let (sin_upper, cos_upper) = if lower == upper { (sin_lower, cos_lower) } else { upper.sin_cos() };
        // Quarter turns; the division, π and the end of the interval are each rounded once.
        let slack = 4.0 * f64::EPSILON * (1.0 + self.magnitude());
        let [first, last] = [lower / FRAC_PI_2 - slack, upper / FRAC_PI_2 + slack];
        // Whether a multiple of four quarters, and `quarter` more, is inside.
        let passes = |quarter: f64| ((first - quarter) / 4.0).ceil() <= ((last - quarter) / 4.0).floor();
        let range = |a: f64, b: f64, highest: f64, lowest: f64| {
            let out = TRIGONOMETRIC_UNITS * f64::EPSILON;
            let [low, high] = if a < b { [a, b] } else { [b, a] };
            Self {
                lower: if passes(lowest) { -1.0 } else { (low - out * low.abs()).max(-1.0) },
                upper: if passes(highest) { 1.0 } else { (high + out * high.abs()).min(1.0) },
            }
        };
        (range(sin_lower, sin_upper, 1.0, 3.0), range(cos_lower, cos_upper, 0.0, 2.0))
    }

    /// The sine of angles in rad; see [`Interval::sin_cos`].
    #[must_use]
    pub fn sin(self) -> Self {
        self.sin_cos().0
    }

    /// The cosine of angles in rad; see [`Interval::sin_cos`].
    #[must_use]
    pub fn cos(self) -> Self {
        self.sin_cos().1
    }
}

/// The sum, not more than exact.
#[inline]
fn add_down(a: f64, b: f64) -> f64 {
    let (sum, error) = two_sum(a, b);
    // An overflow leaves an error that is not a number.
    if error >= 0.0 { sum } else { sum.next_down() }
}

/// The sum, not less than exact.
#[inline]
fn add_up(a: f64, b: f64) -> f64 {
    let (sum, error) = two_sum(a, b);
    if error <= 0.0 { sum } else { sum.next_up() }
}

/// The rounded sum and what it lacks to the exact one (TwoSum).
#[inline]
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let of_b = sum - a;
    (sum, (a - (sum - of_b)) + (b - of_b))
}

impl Add for Interval {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        Self { lower: add_down(self.lower, other.lower), upper: add_up(self.upper, other.upper) }
    }
}

impl Sub for Interval {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Neg for Interval {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self { lower: -self.upper, upper: -self.lower }
    }
}

impl Mul for Interval {
    type Output = Self;

    #[inline]
    fn mul(self, other: Self) -> Self {
        let [a, b, c, d] = [
            self.lower * other.lower,
            self.lower * other.upper,
            self.upper * other.lower,
            self.upper * other.upper,
        ];
        Self::of_products([a, b, c, d], self, other)
    }
}

impl Mul<f64> for Interval {
    type Output = Self;

    /// The product with a number, at half the cost of the product with [`Interval::point`].
    #[inline]
    fn mul(self, factor: f64) -> Self {
        let [a, b] = [self.lower * factor, self.upper * factor];
        Self::of_products([a, b, a, b], self, Self { lower: factor, upper: factor })
    }
}

impl Div for Interval {
    type Output = Self;

    /// The quotients; [`Interval::WHOLE`] when 0 is in the divisor.
    #[inline]
    fn div(self, other: Self) -> Self {
        if other.contains(0.0) {
            return Self::WHOLE;
        }
        let [a, b, c, d] = [
            self.lower / other.lower,
            self.lower / other.upper,
            self.upper / other.lower,
            self.upper / other.upper,
        ];
        Self::of_products([a, b, c, d], self, other)
    }
}

impl Interval {
    /// The outward rounded hull of the products (or quotients) of the ends of `a` and `b`.
    ///
    /// An end that comes out as zero is exact when no product has the sign that lies beyond it: else it may
    /// have been too small for a float.
    #[inline]
    fn of_products([p, q, r, s]: [f64; 4], a: Self, b: Self) -> Self {
        // Zero times infinity, or products without bound on both sides.
        if ((p + q) + (r + s)).is_nan() {
            return Self::WHOLE;
        }
        if a == Self::ZERO || b == Self::ZERO {
            return Self::ZERO;
        }
        let least = less(less(p, q), less(r, s));
        let greatest = greater(greater(p, q), greater(r, s));
        let exact_below = least == 0.0 && a.is_on_one_side_with(b);
        let exact_above = greatest == 0.0 && a.is_on_one_side_with(-b);
        Self {
            lower: if exact_below { 0.0 } else { least.next_down() },
            upper: if exact_above { 0.0 } else { greatest.next_up() },
        }
    }

    /// Whether no number of this interval and number of the other have opposite signs.
    #[inline]
    fn is_on_one_side_with(self, other: Self) -> bool {
        (self.lower >= 0.0 && other.lower >= 0.0) || (self.upper <= 0.0 && other.upper <= 0.0)
    }
}

/// The smaller of two numbers neither of which is NaN: one instruction, where `f64::min` takes several.
#[inline]
fn less(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The larger of two numbers neither of which is NaN.
#[inline]
fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

impl From<f64> for Interval {
    fn from(value: f64) -> Self {
        Self::point(value)
    }
}

impl TryFrom<[f64; 2]> for Interval {
    type Error = IntervalError;

    fn try_from([lower, upper]: [f64; 2]) -> Result<Self, IntervalError> {
        Self::new(lower, upper)
    }
}

impl From<Interval> for [f64; 2] {
    fn from(interval: Interval) -> Self {
        [interval.lower, interval.upper]
    }
}

impl fmt::Display for Interval {
    /// `[lower, upper]`, each with as many digits as the formatter asks for.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("[")?;
        fmt::Display::fmt(&self.lower, f)?;
        f.write_str(", ")?;
        fmt::Display::fmt(&self.upper, f)?;
        f.write_str("]")
    }
}

impl fmt::Debug for Interval {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "[{:?}, {:?}]", self.lower, self.upper)
    }
}
