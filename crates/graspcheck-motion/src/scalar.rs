//! What a formula is computed with: floats, intervals, or either with a rate of change.
//!
//! A formula that is written once over [`Scalar`] computes a number with `f64`, encloses all its values over
//! a box with [`Interval`], and gives its derivative with [`Dual`]. A proof that uses the interval then bounds
//! the very code that the tests compare with other software.
//!
//! ```
//! use graspcheck_motion::{Dual, Interval, Scalar};
//!
//! /// Height of the end of a link of length 2 m at an angle (rad).
//! fn height<S: Scalar>(angle: S) -> S {
//!     angle.sin_cos().0.scaled(2.0)
//! }
//!
//! assert!((height(0.5) - 2.0 * 0.5_f64.sin()).abs() < 1e-15);
//! let all = height(Interval::between(0.4, 0.6));
//! assert!(all.contains(height(0.4)) && all.contains(height(0.6)) && all.width() < 0.37);
//! let rate = height(Dual { value: 0.5, rate: 3.0 }).rate; // the angle grows by 3 rad/s
//! assert!((rate - 6.0 * 0.5_f64.cos()).abs() < 1e-15);
//! ```

use std::{
    fmt::Debug,
    ops::{Add, Mul, Neg, Sub},
};

use crate::{dual::Dual, interval::Interval};

/// A number as kinematics and dynamics need it: sums, products, sine and cosine.
pub trait Scalar:
    Copy + Debug + From<f64> + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self>
{
    /// The number times a constant.
    #[must_use]
    fn scaled(self, factor: f64) -> Self;

    /// The number times itself; tighter than the product where that matters.
    #[must_use]
    fn square(self) -> Self;

    /// Sine and cosine of an angle, rad.
    #[must_use]
    fn sin_cos(self) -> (Self, Self);
}

/// A [`Scalar`] that has a sign, as dry friction needs it. Not for [`Dual`]: the sign has no rate where it
/// changes.
pub trait Signed: Scalar {
    /// −1, 0 or 1 with the sign of the number; all that occur inside, and between them, for an interval.
    #[must_use]
    fn sign(self) -> Self;
}

impl Scalar for f64 {
    #[inline]
    fn scaled(self, factor: f64) -> Self {
        self * factor
    }

    #[inline]
    fn square(self) -> Self {
        self * self
    }

    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        self.sin_cos()
    }
}

impl Signed for f64 {
    #[inline]
    fn sign(self) -> Self {
        if self == 0.0 { 0.0 } else { self.signum() }
    }
}

impl Scalar for Interval {
    #[inline]
    fn scaled(self, factor: f64) -> Self {
        self * factor
    }

    #[inline]
    fn square(self) -> Self {
        self.square()
    }

    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        self.sin_cos()
    }
}

impl Signed for Interval {
    fn sign(self) -> Self {
        Self::between(self.lower().sign(), self.upper().sign())
    }
}

impl<S: Scalar> Scalar for Dual<S> {
    #[inline]
    fn scaled(self, factor: f64) -> Self {
        Self { value: self.value.scaled(factor), rate: self.rate.scaled(factor) }
    }

    #[inline]
    fn square(self) -> Self {
        Self { value: self.value.square(), rate: (self.value * self.rate).scaled(2.0) }
    }

    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.value.sin_cos();
        (Self { value: sin, rate: cos * self.rate }, Self { value: cos, rate: -(sin * self.rate) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sign_over_an_interval_is_every_sign_in_it() {
        assert_eq!(Interval::between(-2.0, 3.0).sign(), Interval::between(-1.0, 1.0));
        assert_eq!(Interval::between(0.0, 3.0).sign(), Interval::between(0.0, 1.0));
        assert_eq!(Interval::between(-2.0, -1.0).sign(), Interval::point(-1.0));
        assert_eq!(
            [3.0.sign(), (-2.0).sign(), 0.0.sign()].map(f64::to_bits),
            [1.0, -1.0, 0.0].map(f64::to_bits)
        );
    }
}
