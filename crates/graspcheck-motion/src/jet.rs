//! Truncated Taylor series: a quantity with all its derivatives up to an order, through any formula.
//!
//! A [`Jet`] holds the first `N` coefficients of `f(x + d) = c₀ + c₁ d + c₂ d² + …`; the k-th derivative is
//! `k! cₖ`. Sum, product, quotient, root, sine and cosine follow from those of the operands by recurrences
//! (Griewank, Walther, *Evaluating Derivatives*, 2008, table 13.2), so that a formula that is written once
//! gives velocity, acceleration and jerk without anybody differentiating it.
//!
//! ```
//! use graspcheck_motion::{Jet, Scalar};
//!
//! // sin(x²) at x = 0.5, with three derivatives.
//! let x = Jet::<f64, 4>::variable(0.5);
//! let [value, first, second, _] = x.square().sin_cos().0.derivatives();
//! assert!((value - 0.25_f64.sin()).abs() < 1e-15);
//! assert!((first - 0.25_f64.cos()).abs() < 1e-15);
//! assert!((second - (2.0 * 0.25_f64.cos() - 0.25_f64.sin())).abs() < 1e-15);
//! ```
//!
//! **Taylor models.** Over an interval X with middle m, `f(m + d) = Σₖ₍<n₎ cₖ dᵏ + cₙ dⁿ` with the cₖ of the jet
//! at m and *some* cₙ out of the jet over the whole of X (Lagrange's remainder, component by component for
//! vectors). [`taylor_model`] joins the two: a polynomial with interval coefficients that contains the
//! function everywhere on X, rounding included, and whose width shrinks with the n-th power of the length
//! (Makino, Berz, "Taylor models and other validated functional inclusion methods", 2003).

use std::{
    array,
    ops::{Add, Div, Mul, Neg, Sub},
};

use crate::{Interval, Polynomial, Scalar, polynomial::MAX_DEGREE};

/// A [`Scalar`] that can be divided by and has a root.
pub trait Real: Scalar + Div<Output = Self> {
    /// The square root; NaN for a negative float, see [`Interval::sqrt`] for intervals.
    #[must_use]
    fn sqrt(self) -> Self;

    /// The number divided by a constant other than zero.
    #[inline]
    #[must_use]
    fn over(self, divisor: f64) -> Self {
        self / Self::from(divisor)
    }
}

impl Real for f64 {
    #[inline]
    fn sqrt(self) -> Self {
        self.sqrt()
    }
}

impl Real for Interval {
    #[inline]
    fn sqrt(self) -> Self {
        self.sqrt()
    }
}

/// The first `N` Taylor coefficients of a quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet<S, const N: usize> {
    /// Coefficient k is the k-th derivative divided by k!.
    pub coefficients: [S; N],
}

impl<S: Scalar, const N: usize> Jet<S, N> {
    /// A constant: all derivatives are zero.
    #[must_use]
    pub fn constant(value: S) -> Self {
        let mut coefficients = [S::from(0.0); N];
        coefficients[0] = value;
        Self { coefficients }
    }

    /// The variable itself at `value`: its first derivative is 1.
    #[must_use]
    pub fn variable(value: S) -> Self {
        let mut jet = Self::constant(value);
        if N > 1 {
            jet.coefficients[1] = S::from(1.0);
        }
        jet
    }

    /// The value.
    #[inline]
    #[must_use]
    pub fn value(&self) -> S {
        self.coefficients[0]
    }

    /// The value and its derivatives, in order.
    ///
    /// ```
    /// use graspcheck_motion::Jet;
    /// // x³ at 2: 8, 12, 12, 6.
    /// let x = Jet::<f64, 4>::variable(2.0);
    /// assert_eq!((x * x * x).derivatives(), [8.0, 12.0, 12.0, 6.0]);
    /// ```
    #[must_use]
    pub fn derivatives(&self) -> [S; N] {
        let mut factorial = 1.0;
        array::from_fn(|k| {
            factorial *= k.max(1) as f64;
            self.coefficients[k].scaled(factorial)
        })
    }

    /// A polynomial of the variable whose value is `at`: [`Jet::polynomial`] of [`Jet::variable`], at a cost
    /// that is linear in `N`.
    ///
    /// ```
    /// use graspcheck_motion::{Jet, Polynomial};
    /// let jet = Jet::<f64, 3>::of_polynomial(&Polynomial::new([1.0, 2.0, 3.0]), 1.0);
    /// assert_eq!(jet.derivatives(), [6.0, 8.0, 6.0]);
    /// ```
    #[must_use]
    pub fn of_polynomial(polynomial: &Polynomial, at: S) -> Self {
        let mut value = Self::constant(S::from(0.0));
        for &coefficient in polynomial.coefficients()[..=polynomial.degree()].iter().rev() {
            for k in (1..N.min(MAX_DEGREE + 1)).rev() {
                value.coefficients[k] = value.coefficients[k] * at + value.coefficients[k - 1];
            }
            value.coefficients[0] = value.coefficients[0] * at + S::from(coefficient);
        }
        value
    }

    /// The coefficients from the first on: the derivative of the quantity. The last one is lost and is zero.
    ///
    /// ```
    /// use graspcheck_motion::Jet;
    /// let x = Jet::<f64, 4>::variable(2.0);
    /// assert_eq!((x * x).derivative().derivatives(), [4.0, 2.0, 0.0, 0.0]); // 2x
    /// ```
    #[must_use]
    pub fn derivative(&self) -> Self {
        let coefficients = array::from_fn(|k| {
            if k + 1 < N { self.coefficients[k + 1].scaled((k + 1) as f64) } else { S::from(0.0) }
        });
        Self { coefficients }
    }
}

impl<S: Real, const N: usize> Jet<S, N> {
    /// A polynomial of this quantity, by Horner's scheme.
    ///
    /// ```
    /// use graspcheck_motion::{Jet, Polynomial};
    /// // (x²)² + 1 at 1: 2, 4, 12.
    /// let x = Jet::<f64, 3>::variable(1.0);
    /// let found = (x * x).polynomial(&Polynomial::new([1.0, 0.0, 1.0]));
    /// assert_eq!(found.derivatives(), [2.0, 4.0, 12.0]);
    /// ```
    #[must_use]
    pub fn polynomial(self, polynomial: &Polynomial) -> Self {
        let degree = polynomial.degree();
        let coefficients = polynomial.coefficients();
        // The first product is one with a constant.
        let mut value = Self::from(coefficients[degree]);
        for (step, &coefficient) in coefficients[..degree].iter().rev().enumerate() {
            value = if step == 0 { self.scaled(coefficients[degree]) } else { value * self };
            value.coefficients[0] = value.coefficients[0] + S::from(coefficient);
        }
        value
    }

    /// The quantity whose derivative is this one and whose value is `value`: the last coefficient is lost.
    ///
    /// ```
    /// use graspcheck_motion::Jet;
    /// // The integral of 2x is x² and 5 more.
    /// let x = Jet::<f64, 3>::variable(3.0);
    /// assert_eq!((x + x).integral(14.0).derivatives(), [14.0, 6.0, 2.0]);
    /// ```
    #[must_use]
    pub fn integral(&self, value: S) -> Self {
        let coefficients =
            array::from_fn(|k| if k == 0 { value } else { self.coefficients[k - 1].over(k as f64) });
        Self { coefficients }
    }

    /// The square root; its value must not be zero.
    #[must_use]
    pub fn sqrt(self) -> Self {
        let mut root = Self::constant(self.coefficients[0].sqrt());
        let double = root.coefficients[0].scaled(2.0);
        for k in 1..N {
            let mut rest = self.coefficients[k];
            for j in 1..k {
                rest = rest - root.coefficients[j] * root.coefficients[k - j];
            }
            root.coefficients[k] = rest / double;
        }
        root
    }
}

/// The polynomial in `d` from −r to r, r half the width of X, that contains a quantity over X: the
/// coefficients of its jet at the middle of X, the last of its jet over the whole of X.
///
/// ```
/// use graspcheck_motion::{Interval, Jet, taylor_model};
/// // x² on [0, 2]: (1 + d)² for d in [-1, 1], in which every coefficient is an interval.
/// let square = |x: Interval| { let x = Jet::<Interval, 3>::variable(x); x * x };
/// let model = taylor_model(&square(Interval::point(1.0)), &square(Interval::between(0.0, 2.0)));
/// assert!(model[0].contains(1.0) && model[1].contains(2.0) && model[2].contains(1.0));
/// ```
#[must_use]
pub fn taylor_model<const N: usize>(
    at_middle: &Jet<Interval, N>,
    over_all: &Jet<Interval, N>,
) -> [Interval; N] {
    let mut model = at_middle.coefficients;
    model[N - 1] = over_all.coefficients[N - 1];
    model
}

impl<S: Scalar, const N: usize> From<f64> for Jet<S, N> {
    fn from(value: f64) -> Self {
        Self::constant(S::from(value))
    }
}

impl<S: Scalar, const N: usize> Add for Jet<S, N> {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        Self { coefficients: array::from_fn(|k| self.coefficients[k] + other.coefficients[k]) }
    }
}

impl<S: Scalar, const N: usize> Sub for Jet<S, N> {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        Self { coefficients: array::from_fn(|k| self.coefficients[k] - other.coefficients[k]) }
    }
}

impl<S: Scalar, const N: usize> Neg for Jet<S, N> {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self { coefficients: self.coefficients.map(|c| -c) }
    }
}

impl<S: Scalar, const N: usize> Mul for Jet<S, N> {
    type Output = Self;

    /// Cauchy's product.
    #[inline]
    fn mul(self, other: Self) -> Self {
        let coefficients = array::from_fn(|k| {
            let mut sum = self.coefficients[0] * other.coefficients[k];
            for j in 1..=k {
                sum = sum + self.coefficients[j] * other.coefficients[k - j];
            }
            sum
        });
        Self { coefficients }
    }
}

impl<S: Real, const N: usize> Div for Jet<S, N> {
    type Output = Self;

    /// The quotient; the value of the divisor must not be zero.
    #[inline]
    fn div(self, other: Self) -> Self {
        let mut quotient = Self::constant(self.coefficients[0] / other.coefficients[0]);
        for k in 1..N {
            let mut rest = self.coefficients[k];
            for j in 1..=k {
                rest = rest - other.coefficients[j] * quotient.coefficients[k - j];
            }
            quotient.coefficients[k] = rest / other.coefficients[0];
        }
        quotient
    }
}

impl<S: Real, const N: usize> Scalar for Jet<S, N> {
    #[inline]
    fn scaled(self, factor: f64) -> Self {
        Self { coefficients: self.coefficients.map(|c| c.scaled(factor)) }
    }

    #[inline]
    fn square(self) -> Self {
        let mut square = self * self;
        square.coefficients[0] = self.coefficients[0].square();
        square
    }

    /// From `k sₖ = Σ j aⱼ cₖ₋ⱼ` and `k cₖ = −Σ j aⱼ sₖ₋ⱼ`.
    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.coefficients[0].sin_cos();
        let (mut sin, mut cos) = (Self::constant(sin), Self::constant(cos));
        let slope: [S; N] = array::from_fn(|j| self.coefficients[j].scaled(j as f64));
        for k in 1..N {
            let mut sin_sum = slope[k] * cos.coefficients[0];
            let mut cos_sum = slope[k] * sin.coefficients[0];
            for (j, &slope) in slope.iter().enumerate().take(k).skip(1) {
                sin_sum = sin_sum + slope * cos.coefficients[k - j];
                cos_sum = cos_sum + slope * sin.coefficients[k - j];
            }
            sin.coefficients[k] = sin_sum.over(k as f64);
            cos.coefficients[k] = -cos_sum.over(k as f64);
        }
        (sin, cos)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A formula with everything in it, of a float or a jet.
    fn formula<const N: usize>(x: Jet<f64, N>) -> Jet<f64, N> {
        let (sin, cos) = (x * x + x.scaled(0.3)).sin_cos();
        (sin + Jet::from(2.5)) / (cos.square() + Jet::from(1.2)).sqrt() - x
    }

    proptest! {
        #[test]
        fn coefficients_are_those_of_the_shifted_function(x in -1.5..1.5_f64, d in -0.01..0.01_f64) {
            // The series at x, evaluated at d, is the function at x + d.
            let series = formula(Jet::<f64, 9>::variable(x)).coefficients;
            let sum = series.iter().rev().fold(0.0, |sum, c| sum * d + c);
            let value = formula(Jet::<f64, 1>::variable(x + d)).value();
            prop_assert!((sum - value).abs() < 1e-10, "{sum} is not {value}");
        }

        #[test]
        fn a_taylor_model_contains_the_function(middle in -1.5..1.5_f64, half in 0.001..0.3_f64, share in -1.0..1.0_f64) {
            fn sine_of_square<const N: usize>(x: Jet<Interval, N>) -> Jet<Interval, N> {
                x.square().sin_cos().0
            }
            let over_all = Interval::between(middle - half, middle + half);
            let model = taylor_model(
                &sine_of_square(Jet::<Interval, 8>::variable(Interval::point(middle))),
                &sine_of_square(Jet::<Interval, 8>::variable(over_all)),
            );
            let d = share * half;
            let range = model.iter().rev().fold(Interval::ZERO, |sum, &c| sum * d + c);
            let value = (middle + d).powi(2).sin();
            prop_assert!(range.widened(1e-15).contains(value), "{range} without {value}");
            prop_assert!(range.width() < 4.0 * (half * 4.0).powi(7) + 1e-12, "{range}");
        }
    }

    #[test]
    fn polynomials_of_the_variable_and_of_a_jet_agree() {
        let p = Polynomial::new([1.0, -2.0, 3.0, 0.5, -0.25, 0.125, 0.7, -0.3]);
        let direct = Jet::<f64, 5>::of_polynomial(&p, 0.7);
        let composed = Jet::<f64, 5>::variable(0.7).polynomial(&p);
        let [value, first, second, third] = p.eval(0.7);
        for (jet, name) in [(direct, "direct"), (composed, "composed")] {
            let found = jet.derivatives();
            for (a, b) in found.into_iter().zip([value, first, second, third]) {
                assert!((a - b).abs() < 1e-12, "{name}: {a} is not {b}");
            }
        }
        assert_eq!(Jet::<f64, 3>::variable(2.0).polynomial(&Polynomial::constant(4.0)), Jet::from(4.0));
    }

    #[test]
    fn an_integral_undoes_a_derivative() {
        let jet = formula(Jet::<f64, 6>::variable(0.4));
        let back = jet.derivative().integral(jet.value());
        for (a, b) in back.coefficients.into_iter().zip(jet.coefficients) {
            assert!((a - b).abs() < 1e-14);
        }
    }
}
