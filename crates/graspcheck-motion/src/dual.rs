//! Numbers with their rate of change: derivatives of a formula, exact to rounding.
//!
//! A [`Dual`] carries a value and its derivative with respect to one variable through a formula by the rules
//! of sum, product and chain (forward-mode automatic differentiation; Griewank, Walther, *Evaluating
//! Derivatives*, 2008, chapter 3). With time as the variable the rate of a torque follows from positions,
//! velocities, accelerations and jerks; over intervals it gives the mean-value form of
//! [`Dual::mean_value`].
//!
//! ```
//! use graspcheck_motion::Dual;
//! let x = Dual { value: 3.0, rate: 1.0 };
//! assert_eq!((x * x - x).rate, 5.0); // d(x² - x)/dx = 2x - 1
//! ```

use std::ops::{Add, Mul, Neg, Sub};

use crate::{Interval, Scalar};

/// A value and its rate of change with respect to one variable that the user chooses, such as time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dual<S> {
    /// The value.
    pub value: S,
    /// Its derivative.
    pub rate: S,
}

impl Dual<Interval> {
    /// Bounds on a quantity over a time of the given half width, s, from its value at the middle of that time
    /// and this enclosure of it over the whole: the value at another instant differs by at most the half width
    /// times the largest rate (mean-value theorem), so that the excess shrinks with the square of the time.
    /// Both bounds hold, so that what they have in common does.
    ///
    /// The quantity must be continuous over the time, with a derivative but for finitely many instants. The
    /// bounds hold for the exact quantity; what floats compute for it is off by their rounding error, which the
    /// enclosure alone would have covered.
    ///
    /// ```
    /// use graspcheck_motion::{Dual, Interval};
    /// // t - t² for t in [0.4, 0.6]: from 0.24 to 0.25.
    /// let product = |t: Dual<Interval>| t - t * t;
    /// let at = |t| Dual { value: t, rate: Interval::point(1.0) };
    /// let whole = product(at(Interval::between(0.4, 0.6)));
    /// assert!(whole.value.width() > 0.39);
    /// let middle = product(at(Interval::point(0.5))).value;
    /// assert!(whole.mean_value(middle, 0.1).width() < 0.041);
    /// ```
    #[must_use]
    pub fn mean_value(self, at_middle: Interval, half_width: f64) -> Interval {
        let change = Interval::between(-half_width, half_width) * self.rate;
        let from_middle = at_middle + change;
        // They have the value at the middle in common; were it lost, the enclosure alone still holds.
        from_middle.intersection(self.value).unwrap_or(self.value)
    }
}

impl<S: Scalar> From<f64> for Dual<S> {
    /// A constant: its rate is zero.
    fn from(value: f64) -> Self {
        Self { value: S::from(value), rate: S::from(0.0) }
    }
}

impl<S: Scalar> Add for Dual<S> {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        Self { value: self.value + other.value, rate: self.rate + other.rate }
    }
}

impl<S: Scalar> Sub for Dual<S> {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        Self { value: self.value - other.value, rate: self.rate - other.rate }
    }
}

impl<S: Scalar> Neg for Dual<S> {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self { value: -self.value, rate: -self.rate }
    }
}

impl<S: Scalar> Mul for Dual<S> {
    type Output = Self;

    #[inline]
    fn mul(self, other: Self) -> Self {
        Self { value: self.value * other.value, rate: self.value * other.rate + self.rate * other.value }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_follow_the_rules_of_sum_product_and_chain() {
        // f = sin(x) cos(x) - 3x² at 0.7: f' = cos 2x - 6x.
        let x = Dual { value: 0.7_f64, rate: 1.0 };
        let (sin, cos) = x.sin_cos();
        let f = sin * cos - x.square().scaled(3.0) + Dual::from(5.0);
        assert!((f.rate - (1.4_f64.cos() - 4.2)).abs() < 1e-15);
        assert!((f.value - (0.5 * 1.4_f64.sin() - 3.0 * 0.49 + 5.0)).abs() < 1e-15);
        assert_eq!((-x).rate.to_bits(), (-1.0_f64).to_bits());
    }
}
