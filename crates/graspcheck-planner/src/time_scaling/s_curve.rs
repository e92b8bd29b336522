//! The S-curve from rest to rest: seven phases of constant jerk (field words: double S, seven segments).
//!
//! With limits V, A, J on velocity, acceleration and jerk, the acceleration grows for t_j, stays for t_c and
//! falls for t_j; after a cruise the same backwards. Where a limit is not reached, its phase is not there:
//!
//! | reached | phases | when |
//! |---|---|---|
//! | J, A, V | 7 | `VJ > A²` and `D > V t_a` |
//! | J, V | 5: no constant acceleration | `VJ ≤ A²` and `D > V t_a` |
//! | J, A | 6: no cruise | `2A³/J² < D ≤ V t_a` |
//! | J | 4 | `D ≤ 2A³/J²` and `D ≤ V t_a` |
//!
//! where `t_a = V/A + A/J` if `VJ ≥ A²`, else `2 √(V/J)`. For non-zero velocities at the ends see
//! [`crate::joint_law::JointLaw::s_curve`]. Source: Biagiotti and Melchiorri, section 3.4.

use super::{Profile, ScalingError, TimeScaling, error::check_distance_and_limits, pieces::VelocityChange};

impl TimeScaling {
    /// The law of least duration under limits on velocity, acceleration and jerk: seven phases, fewer where
    /// a limit is not reached.
    ///
    /// With `t_j = A/J, t_a = V/A + t_j` if `VJ ≥ A²`, else `t_j = √(V/J), t_a = 2 t_j`:
    /// if `D/V ≥ t_a` then `T = D/V + t_a`; else if `D ≥ 2A³/J²` then `T = t_j + 2 √(t_j²/4 + D/A)`; else
    /// `T = 4 ∛(D/(2J))`.
    ///
    /// ```
    /// use graspcheck_planner::time_scaling::TimeScaling;
    /// let law = TimeScaling::s_curve(1.0, 1.0, 2.0, 10.0)?;
    /// assert!((law.duration() - 1.7).abs() < 1e-15);
    /// assert_eq!(law.pieces().len(), 7);
    /// # Ok::<(), graspcheck_planner::time_scaling::ScalingError>(())
    /// ```
    ///
    /// # Errors
    /// When an argument is not positive and finite.
    pub fn s_curve(distance: f64, velocity: f64, acceleration: f64, jerk: f64) -> Result<Self, ScalingError> {
        check_distance_and_limits(distance, &[velocity, acceleration, jerk])?;
        let ramp = acceleration / jerk;
        let VelocityChange { jerk: t_j, acceleration: t_c, .. } =
            VelocityChange::fastest(velocity, acceleration, jerk);
        let cruise = distance / velocity - (2.0 * t_j + t_c);
        let profile = if cruise >= 0.0 {
            Profile::SCurve { jerk: t_j, acceleration: t_c, cruise }
        } else if distance / acceleration >= 2.0 * ramp * ramp {
            // x (x + t_j) = D/A for x = t_j + t_c; this form of the root does not cancel.
            let strokes = distance / acceleration;
            let x = strokes / (0.5 * ramp + (0.25 * ramp * ramp + strokes).sqrt());
            Profile::SCurve { jerk: ramp, acceleration: (x - ramp).max(0.0), cruise: 0.0 }
        } else {
            Profile::SCurve { jerk: (0.5 * distance / jerk).cbrt(), acceleration: 0.0, cruise: 0.0 }
        };
        Self::within(profile, distance, [velocity, acceleration, jerk])
    }
}
