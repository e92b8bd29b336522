//! One scalar polynomial in local time.
//!
//! The cubic and the quintic are the simplest laws between two states: four and six boundary values fix four and
//! six coefficients (Siciliano et al., *Robotics: Modelling, Planning and Control*, 4.2.1).
//!
//! ```
//! use graspcheck_motion::Polynomial;
//!
//! // From rest at 50° to rest at 80° in 3 s by the cubic 3s² − 2s³, in degrees: the peak velocity is 1.5 h/T.
//! let cubic = Polynomial::new([50.0, 0.0, 10.0, -20.0 / 9.0]);
//! let [q, qd, qdd, _] = cubic.eval(1.5);
//! assert!((q - 65.0).abs() < 1e-12 && (qd - 15.0).abs() < 1e-12 && qdd.abs() < 1e-12);
//!
//! // The quintic takes accelerations too: 15/8 h/T.
//! let quintic = Polynomial::quintic_hermite([50.0, 0.0, 0.0], [80.0, 0.0, 0.0], 3.0);
//! assert!((quintic.eval(1.5)[1] - 15.0 / 8.0 * 10.0).abs() < 1e-12);
//! assert_eq!(quintic.degree(), 5);
//!
//! // Derivatives, and the same motion seen from a later start.
//! assert!((cubic.derivative().eval(1.0)[0] - cubic.eval(1.0)[1]).abs() < 1e-12);
//! assert!((cubic.shifted(1.0).eval(0.5)[0] - cubic.eval(1.5)[0]).abs() < 1e-12);
//! ```

use serde::{Deserialize, Serialize};

/// The highest degree that a [`Polynomial`] can have.
pub const MAX_DEGREE: usize = 7;

/// A scalar polynomial `p(τ) = Σ cₖ τᵏ` of degree at most [`MAX_DEGREE`] in local time τ, seconds.
///
/// Coefficients stand in ascending order of power; missing ones are zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Polynomial {
    coefficients: [f64; MAX_DEGREE + 1],
}

impl Polynomial {
    /// The polynomial with these coefficients, ascending by power.
    ///
    /// More than eight of them do not compile.
    ///
    /// ```compile_fail
    /// let ninth = graspcheck_motion::Polynomial::new([0.0; 9]);
    /// ```
    #[inline]
    #[must_use]
    pub fn new<const N: usize>(coefficients: [f64; N]) -> Self {
        const { assert!(N <= MAX_DEGREE + 1, "a Polynomial has at most 8 coefficients") };
        let mut all = [0.0; MAX_DEGREE + 1];
        all[..N].copy_from_slice(&coefficients);
        Self { coefficients: all }
    }

    /// The polynomial that is `value` everywhere.
    #[must_use]
    pub fn constant(value: f64) -> Self {
        Self::new([value])
    }

    /// The quintic on `[0, duration]` with the given position, velocity and acceleration at both ends
    /// (Hermite interpolation of second order).
    ///
    /// `start` and `end` are `[q, qd, qdd]`; `duration` is positive, in seconds.
    ///
    /// ```
    /// // 0 to 1 in 2 s from rest to rest: half way at half time, 15/8 of the mean velocity.
    /// let swing = graspcheck_motion::Polynomial::quintic_hermite([0.0; 3], [1.0, 0.0, 0.0], 2.0);
    /// assert_eq!(swing.eval(1.0)[..3], [0.5, 15.0 / 16.0, 0.0]);
    /// ```
    #[must_use]
    pub fn quintic_hermite(start: [f64; 3], end: [f64; 3], duration: f64) -> Self {
        let h = duration;
        let dq = end[0] - start[0];
        let (v0, v1, a0, a1) = (start[1] * h, end[1] * h, start[2] * h * h, end[2] * h * h);
        let c3 = 10.0 * dq - 6.0 * v0 - 4.0 * v1 - 1.5 * a0 + 0.5 * a1;
        let c4 = -15.0 * dq + 8.0 * v0 + 7.0 * v1 + 1.5 * a0 - a1;
        let c5 = 6.0 * dq - 3.0 * (v0 + v1) - 0.5 * a0 + 0.5 * a1;
        let (h3, h4, h5) = (h.powi(3), h.powi(4), h.powi(5));
        Self::new([start[0], start[1], 0.5 * start[2], c3 / h3, c4 / h4, c5 / h5])
    }

    /// The coefficients, ascending by power.
    #[must_use]
    pub fn coefficients(&self) -> &[f64; MAX_DEGREE + 1] {
        &self.coefficients
    }

    /// The highest power with a coefficient other than zero; 0 for a constant.
    #[must_use]
    pub fn degree(&self) -> usize {
        self.coefficients.iter().rposition(|c| *c != 0.0).unwrap_or(0)
    }

    /// Value and first three derivatives at local time `tau`: `[q, qd, qdd, qddd]`.
    ///
    /// ```
    /// // 1 + 2τ + 3τ² + 4τ³ at τ = 1.
    /// let p = graspcheck_motion::Polynomial::new([1.0, 2.0, 3.0, 4.0]);
    /// assert_eq!(p.eval(1.0), [10.0, 20.0, 30.0, 24.0]);
    /// ```
    #[inline]
    #[must_use]
    pub fn eval(&self, tau: f64) -> [f64; 4] {
        let [a, b, c, d, high @ ..] = self.coefficients;
        if high.iter().fold(false, |any, c| any | (*c != 0.0)) {
            return self.eval_any(tau);
        }
        // What Horner's scheme gives for a cubic, bit by bit, with half the work.
        let slope = d * tau + c;
        let curve = d * tau + slope;
        [(slope * tau + b) * tau + a, curve * tau + (slope * tau + b), 2.0 * (d * tau + curve), 6.0 * d]
    }

    /// As [`Polynomial::eval`], whatever the degree.
    fn eval_any(&self, tau: f64) -> [f64; 4] {
        let mut value = [0.0; 4];
        for &c in self.coefficients.iter().rev() {
            value[3] = value[3] * tau + value[2];
            value[2] = value[2] * tau + value[1];
            value[1] = value[1] * tau + value[0];
            value[0] = value[0] * tau + c;
        }
        // Horner's scheme carries the k-th derivative divided by k!.
        [value[0], value[1], 2.0 * value[2], 6.0 * value[3]]
    }

    /// Position, velocity and acceleration at local time 0.
    #[inline]
    pub(crate) fn start(&self) -> [f64; 3] {
        let [q, qd, half_qdd, ..] = self.coefficients;
        [q, qd, 2.0 * half_qdd]
    }

    /// The first derivative with respect to local time.
    #[must_use]
    pub fn derivative(&self) -> Self {
        self.derivative_of_order(1)
    }

    /// The derivative of the given order with respect to local time; each coefficient is rounded once.
    ///
    /// ```
    /// use graspcheck_motion::Polynomial;
    /// let p = Polynomial::new([1.0, 2.0, 3.0, 4.0]);
    /// assert_eq!(p.derivative_of_order(2), Polynomial::new([6.0, 24.0]));
    /// ```
    #[must_use]
    pub fn derivative_of_order(&self, order: usize) -> Self {
        match order {
            0 => *self,
            1 => self.derived::<1>(),
            2 => self.derived::<2>(),
            3 => self.derived::<3>(),
            4 => self.derived::<4>(),
            5 => self.derived::<5>(),
            6 => self.derived::<6>(),
            7 => self.derived::<7>(),
            _ => Self::default(),
        }
    }

    /// The K-th derivative; the order is a constant, so that nothing is looked up.
    fn derived<const K: usize>(&self) -> Self {
        let c = &self.coefficients;
        Self {
            coefficients: std::array::from_fn(|i| {
                if i + K <= MAX_DEGREE { FALLING_FACTORIALS[K][i] * c[i + K] } else { 0.0 }
            }),
        }
    }

    /// The coefficient of τⁱ in the derivative of the given order, rounded once.
    #[inline]
    pub(crate) fn derivative_coefficient(&self, order: usize, i: usize) -> f64 {
        match self.coefficients.get(order..).and_then(|coefficients| coefficients.get(i)) {
            Some(c) => FALLING_FACTORIALS[order][i] * c,
            None => 0.0,
        }
    }

    /// The same polynomial in the local time that starts `shift` seconds later: `p(τ + shift)`.
    ///
    /// ```
    /// use graspcheck_motion::Polynomial;
    /// // (τ + 2)² = 4 + 4τ + τ²
    /// assert_eq!(Polynomial::new([0.0, 0.0, 1.0]).shifted(2.0), Polynomial::new([4.0, 4.0, 1.0]));
    /// ```
    #[must_use]
    pub fn shifted(&self, shift: f64) -> Self {
        // Repeated synthetic division (Taylor shift).
        let mut c = self.coefficients;
        for start in 0..MAX_DEGREE {
            for k in (start..MAX_DEGREE).rev() {
                c[k] += c[k + 1] * shift;
            }
        }
        Self { coefficients: c }
    }

    /// This polynomial with `value` added: `p(τ) + value`.
    #[must_use]
    pub fn plus(&self, value: f64) -> Self {
        let mut raised = *self;
        raised.coefficients[0] += value;
        raised
    }

    /// The polynomial of the coefficients' magnitudes `Σ |cₖ| τᵏ`: what rounding errors are relative to.
    pub(crate) fn magnitudes(&self) -> Self {
        Self { coefficients: self.coefficients.map(f64::abs) }
    }

    /// Whether every coefficient is finite.
    #[inline]
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.coefficients.iter().fold(true, |finite, c| finite & c.is_finite())
    }
}

/// Entry `[k][i]` is (i + k)! / i!, the factor of τⁱ in the k-th derivative of τⁱ⁺ᵏ.
const FALLING_FACTORIALS: [[f64; MAX_DEGREE + 1]; MAX_DEGREE + 1] = {
    let mut table = [[1.0; MAX_DEGREE + 1]; MAX_DEGREE + 1];
    let mut k = 1;
    while k <= MAX_DEGREE {
        let mut i = 0;
        while i <= MAX_DEGREE {
            table[k][i] = table[k - 1][i] * (i + k) as f64;
            i += 1;
        }
        k += 1;
    }
    table
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn evaluates_value_and_three_derivatives() {
        // cubic-2 of the worked examples: 50° -> 80° in 3 s, in degrees.
        let p = Polynomial::new([50.0, 0.0, 10.0, -20.0 / 9.0]);
        let [q, qd, qdd, qddd] = p.eval(1.0);
        assert!((q - 57.777_777_777_777_78).abs() < 1e-12);
        assert!((qd - 13.333_333_333_333_334).abs() < 1e-12);
        assert!((qdd - 6.666_666_666_666_667).abs() < 1e-12);
        assert!((qddd + 40.0 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn the_short_way_for_cubics_gives_the_same_bits() {
        let cubic = [0.3, -1.7, 2.9, 11.3];
        let [a, b, c, d] = cubic;
        for tau in [0.0, 1e-9, 0.3, -2.7, 1e5] {
            let long = Polynomial::new([a, b, c, d]).eval_any(tau);
            assert_eq!(Polynomial::new(cubic).eval(tau).map(f64::to_bits), long.map(f64::to_bits));
        }
    }

    #[test]
    fn quintic_hermite_meets_both_ends() {
        // quintic-1 of the worked examples: 0 -> 75° in 3 s, accelerations of 10°/s² at both ends.
        let p = Polynomial::quintic_hermite([0.0, 0.0, 10.0], [75.0, 0.0, 10.0], 3.0);
        let c = p.coefficients();
        for (k, expected) in [0.0, 0.0, 5.0, 220.0 / 9.0, -40.0 / 3.0, 50.0 / 27.0].into_iter().enumerate() {
            assert!((c[k] - expected).abs() < 1e-12, "a{k} = {} is not {expected}", c[k]);
        }
    }

    #[test]
    fn derivatives_of_every_order() {
        let p = Polynomial::new([1.0, -2.0, 3.0, 0.5, -0.25, 0.125, 0.7, -0.3]);
        let mut repeated = p;
        for order in 0..=MAX_DEGREE + 1 {
            let direct = p.derivative_of_order(order);
            for (a, b) in direct.coefficients().iter().zip(repeated.coefficients()) {
                assert!((a - b).abs() <= 1e-12 * b.abs(), "order {order}: {direct:?} is not {repeated:?}");
            }
            repeated = repeated.derivative();
        }
        assert_eq!(Polynomial::new([0.0, 0.0, 0.0, 5.0]).derivative_of_order(3), Polynomial::constant(30.0));
    }

    #[test]
    fn shifted_equals_evaluation_later() {
        let p = Polynomial::new([1.0, -2.0, 3.0, 0.5, -0.25, 0.125, 0.7, -0.3]);
        let later = p.shifted(0.3).eval(0.4);
        let direct = p.eval(0.7);
        for (a, b) in later.into_iter().zip(direct) {
            assert!((a - b).abs() < 1e-13);
        }
    }
}
