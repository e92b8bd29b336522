//! One polynomial through given states at both ends (Hermite interpolation).

use graspcheck_motion::Polynomial;

use super::{JointLaw, check_ends};
use crate::time_scaling::{ScalingError, error::positive, pieces::Pieces};

impl JointLaw {
    /// The cubic through position and velocity at both ends, in `duration`, s:
    /// `a₂ = (3Δq - (2v₀ + v₁)T)/T²`, `a₃ = (-2Δq + (v₀ + v₁)T)/T³`. Its acceleration jumps at the ends.
    ///
    /// ```
    /// use graspcheck_planner::joint_law::JointLaw;
    /// let law = JointLaw::cubic([10.0, -50.0], [40.0, -50.0], 1.0)?;
    /// let (_, polynomial) = law.pieces().next().expect("one piece");
    /// assert_eq!(polynomial.coefficients()[..4], [10.0, -50.0, 240.0, -160.0]);
    /// # Ok::<(), graspcheck_planner::time_scaling::ScalingError>(())
    /// ```
    ///
    /// # Errors
    /// When a state is not finite, the duration is not positive and finite, or a coefficient overflows.
    pub fn cubic(start: [f64; 2], end: [f64; 2], duration: f64) -> Result<Self, ScalingError> {
        check_ends(start, end)?;
        positive("duration", duration)?;
        let [[q0, v0], [q1, v1]] = [start, end];
        let h = duration;
        let (dq, v0h, v1h) = (q1 - q0, v0 * h, v1 * h);
        let c2 = 3.0 * dq - 2.0 * v0h - v1h;
        let c3 = -2.0 * dq + v0h + v1h;
        Self::of_one(dq, duration, Polynomial::new([q0, v0, c2 / (h * h), c3 / (h * h * h)]))
    }

    /// The quintic through position, velocity and acceleration at both ends, in `duration`, s.
    ///
    /// ```
    /// use graspcheck_planner::joint_law::JointLaw;
    /// // 0° to 75° in 3 s from rest to rest, with 10°/s² at both ends.
    /// let law = JointLaw::quintic([0.0, 0.0, 10.0], [75.0, 0.0, 10.0], 3.0)?;
    /// let (_, polynomial) = law.pieces().next().expect("one piece");
    /// let expected = [0.0, 0.0, 5.0, 220.0 / 9.0, -40.0 / 3.0, 50.0 / 27.0];
    /// for (c, e) in polynomial.coefficients().iter().zip(expected) {
    ///     assert!((c - e).abs() < 1e-13);
    /// }
    /// # Ok::<(), graspcheck_planner::time_scaling::ScalingError>(())
    /// ```
    ///
    /// # Errors
    /// When a state is not finite, the duration is not positive and finite, or a coefficient overflows.
    pub fn quintic(start: [f64; 3], end: [f64; 3], duration: f64) -> Result<Self, ScalingError> {
        check_ends(start, end)?;
        positive("duration", duration)?;
        Self::of_one(end[0] - start[0], duration, Polynomial::quintic_hermite(start, end, duration))
    }

    /// The polynomial of degree seven through position, velocity, acceleration and jerk at both ends, in
    /// `duration`, s.
    ///
    /// ```
    /// use graspcheck_planner::joint_law::JointLaw;
    /// let law = JointLaw::septic([0.0; 4], [1.0, 0.0, 0.0, 0.0], 1.0)?;
    /// let (_, polynomial) = law.pieces().next().expect("one piece");
    /// assert_eq!(*polynomial.coefficients(), [0.0, 0.0, 0.0, 0.0, 35.0, -84.0, 70.0, -20.0]);
    /// # Ok::<(), graspcheck_planner::time_scaling::ScalingError>(())
    /// ```
    ///
    /// # Errors
    /// When a state is not finite, the duration is not positive and finite, or a coefficient overflows.
    pub fn septic(start: [f64; 4], end: [f64; 4], duration: f64) -> Result<Self, ScalingError> {
        check_ends(start, end)?;
        positive("duration", duration)?;
        let h = duration;
        let [q0, v0, a0, j0] = start;
        let [q1, v1, a1, j1] = end;
        // What the cubic of the start leaves at the end, for h = 1.
        let q = q1 - q0 - ((j0 * h / 6.0 + 0.5 * a0) * h + v0) * h;
        let v = (v1 - v0 - (0.5 * j0 * h + a0) * h) * h;
        let a = (a1 - a0 - j0 * h) * h * h;
        let j = (j1 - j0) * h * h * h;
        let c4 = 35.0 * q - 15.0 * v + 2.5 * a - j / 6.0;
        let c5 = -84.0 * q + 39.0 * v - 7.0 * a + 0.5 * j;
        let c6 = 70.0 * q - 34.0 * v + 6.5 * a - 0.5 * j;
        let c7 = -20.0 * q + 10.0 * v - 2.0 * a + j / 6.0;
        let of_degree = |c: f64, degree: i32| c / h.powi(degree);
        let coefficients = [
            q0,
            v0,
            0.5 * a0,
            j0 / 6.0,
            of_degree(c4, 4),
            of_degree(c5, 5),
            of_degree(c6, 6),
            of_degree(c7, 7),
        ];
        Self::of_one(q1 - q0, duration, Polynomial::new(coefficients))
    }

    fn of_one(distance: f64, duration: f64, polynomial: Polynomial) -> Result<Self, ScalingError> {
        Self::new(distance, duration, Pieces::one(polynomial))
    }
}
