//! Laws of one polynomial: cubic, quintic, and degree seven.
//!
//! With τ = t/T and the distance D:
//!
//! | law | s/D | peak velocity | peak acceleration | peak jerk |
//! |---|---|---|---|---|
//! | cubic | 3τ² - 2τ³ | 3/2 D/T | 6 D/T² | 12 D/T³ inside, infinite at the ends |
//! | quintic | 10τ³ - 15τ⁴ + 6τ⁵ | 15/8 D/T | 10/√3 D/T² | 60 D/T³ |
//! | septic | 35τ⁴ - 84τ⁵ + 70τ⁶ - 20τ⁷ | 35/16 D/T | 84√5/25 D/T² | 52.5 D/T³ |
//!
//! The factors C_v, C_a, C_j of the peaks give the least duration under limits,
//! `T = max(C_v D/V, √(C_a D/A), ∛(C_j D/J))`, and for several joints the largest of these.
//! Source: Biagiotti and Melchiorri, section 2.1; the peaks are the roots of the next derivative.

use super::{Profile, ScalingError, TimeScaling, error::check_distance_and_limits, slowdown};

impl TimeScaling {
    /// The cubic of least duration under limits on velocity, acceleration and the jerk inside:
    /// `T = max(3D/(2V), √(6D/A), ∛(12D/J))`. Its acceleration jumps by 6D/T² at both ends, where no jerk
    /// limit can hold.
    ///
    /// ```
    /// use graspcheck_planner::time_scaling::TimeScaling;
    /// // The acceleration decides: √(6 · 1 / 6) s.
    /// let law = TimeScaling::cubic(1.0, 2.0, 6.0, 100.0)?;
    /// assert_eq!((law.duration(), law.eval(0.5)), (1.0, [0.5, 1.5, 0.0, -12.0]));
    /// # Ok::<(), graspcheck_planner::time_scaling::ScalingError>(())
    /// ```
    ///
    /// # Errors
    /// When an argument is not positive and finite.
    pub fn cubic(distance: f64, velocity: f64, acceleration: f64, jerk: f64) -> Result<Self, ScalingError> {
        Self::of_fixed_shape(Profile::Cubic, distance, [velocity, acceleration, jerk])
    }

    /// The quintic of least duration under limits on velocity, acceleration and jerk:
    /// `T = max(15D/(8V), √(10D/(√3 A)), ∛(60D/J))`.
    ///
    /// ```
    /// use graspcheck_planner::time_scaling::TimeScaling;
    /// // The jerk decides: ∛(60 · 1 / 60) s.
    /// let law = TimeScaling::quintic(1.0, 2.0, 6.0, 60.0)?;
    /// assert_eq!((law.duration(), law.eval(0.0)), (1.0, [0.0, 0.0, 0.0, 60.0]));
    /// # Ok::<(), graspcheck_planner::time_scaling::ScalingError>(())
    /// ```
    ///
    /// # Errors
    /// When an argument is not positive and finite.
    pub fn quintic(distance: f64, velocity: f64, acceleration: f64, jerk: f64) -> Result<Self, ScalingError> {
        Self::of_fixed_shape(Profile::Quintic, distance, [velocity, acceleration, jerk])
    }

    /// The polynomial of degree seven of least duration under limits on velocity, acceleration and jerk:
    /// `T = max(35D/(16V), √(84√5 D/(25A)), ∛(52.5D/J))`. It starts and ends without jerk.
    ///
    /// ```
    /// use graspcheck_planner::time_scaling::TimeScaling;
    /// let law = TimeScaling::septic(1.0, 35.0 / 16.0, 100.0, 1000.0)?;
    /// assert_eq!((law.duration(), law.eval(0.0)), (1.0, [0.0; 4]));
    /// # Ok::<(), graspcheck_planner::time_scaling::ScalingError>(())
    /// ```
    ///
    /// # Errors
    /// When an argument is not positive and finite.
    pub fn septic(distance: f64, velocity: f64, acceleration: f64, jerk: f64) -> Result<Self, ScalingError> {
        Self::of_fixed_shape(Profile::Septic, distance, [velocity, acceleration, jerk])
    }

    fn of_fixed_shape(profile: Profile, distance: f64, limits: [f64; 3]) -> Result<Self, ScalingError> {
        check_distance_and_limits(distance, &limits)?;
        let duration = slowdown(profile.peaks(distance, 1.0), limits);
        Self::new(profile, distance, duration)
    }
}
