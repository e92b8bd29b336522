//! The trapezoid of velocity: acceleration, cruise, deceleration (field words: LSPB, 2-1-2).
//!
//! Four numbers describe the symmetric one over a distance D: cruise velocity V, acceleration A, duration T
//! and blend time t_b. Any two give the others, by `V = A t_b` and `D = V (T - t_b)`:
//!
//! | given | follows | exists when |
//! |---|---|---|
//! | V, A as limits | `T = D/V + V/A` if `D ≥ V²/A`, else `T = 2 √(D/A)` with peak `√(DA)` | always |
//! | T, V | `t_b = T - D/V` | `D/T < V ≤ 2D/T` |
//! | T, A | `t_b = T/2 - √(T² - 4D/A)/2` | `A ≥ 4D/T²` |
//! | T, t_b | `V = D/(T - t_b)` | `t_b ≤ T/2` |
//! | V, t_b | `T = D/V + t_b` | `t_b ≤ D/V` |
//! | A, t_b | `V = A t_b`, `T = D/V + t_b` | `t_b ≤ √(D/A)` |
//!
//! `t_b = 0` would take infinite acceleration. The acceleration steps at the corners, where jerk is infinite.
//! Source: Siciliano et al., *Robotics*, section 4.2.1, and Biagiotti and Melchiorri, section 3.2.

use super::{
    Profile, ScalingError, TimeScaling,
    error::{check_distance_and_limits, positive},
};

impl TimeScaling {
    /// The law of least duration under limits on velocity and acceleration alone:
    /// `T = D/V + V/A` if `D ≥ V²/A`, else `2 √(D/A)`.
    ///
    /// ```
    /// use graspcheck_planner::time_scaling::TimeScaling;
    /// assert_eq!(TimeScaling::trapezoid(1.0, 0.5, 1.0)?.duration(), 2.5);
    /// # Ok::<(), graspcheck_planner::time_scaling::ScalingError>(())
    /// ```
    ///
    /// # Errors
    /// When an argument is not positive and finite.
    pub fn trapezoid(distance: f64, velocity: f64, acceleration: f64) -> Result<Self, ScalingError> {
        Self::asymmetric_trapezoid(distance, velocity, acceleration, acceleration)
    }

    /// The law of least duration under limits on velocity, acceleration and, another one, deceleration:
    /// `T = D/V + V/(2A) + V/(2B)`, with V lowered to `√(2DAB/(A + B))` if the distance is too short for it.
    ///
    /// ```
    /// use graspcheck_planner::time_scaling::TimeScaling;
    /// // Up to 1 in 1 s, down in 0.25 s: 0.625 of the distance, the rest in the cruise.
    /// let law = TimeScaling::asymmetric_trapezoid(1.0, 1.0, 1.0, 4.0)?;
    /// assert_eq!(law.duration(), 1.0 + 0.375 + 0.25);
    /// # Ok::<(), graspcheck_planner::time_scaling::ScalingError>(())
    /// ```
    ///
    /// # Errors
    /// When an argument is not positive and finite.
    pub fn asymmetric_trapezoid(
        distance: f64,
        velocity: f64,
        acceleration: f64,
        deceleration: f64,
    ) -> Result<Self, ScalingError> {
        check_distance_and_limits(distance, &[velocity, acceleration])?;
        positive("deceleration", deceleration)?;
        let [rise, fall] = [velocity / acceleration, velocity / deceleration];
        let cruise = distance / velocity - 0.5 * (rise + fall);
        let profile = if cruise >= 0.0 {
            Profile::Trapezoid { rise, cruise, fall }
        } else {
            // D = V (rise + fall)/2 with V = A rise = B fall.
            let sum = (1.0 + acceleration / deceleration) * acceleration;
            let rise = (2.0 * (distance / sum)).sqrt();
            Profile::Trapezoid { rise, cruise: 0.0, fall: rise * (acceleration / deceleration) }
        };
        let mut law = Self::within(profile, distance, [velocity, f64::INFINITY, f64::INFINITY])?;
        // The two limits belong to the two ends of the law.
        if let Profile::Trapezoid { rise, fall, .. } = law.profile {
            let [peak, ..] = law.peaks();
            let excess = (peak / rise / acceleration).max(peak / fall / deceleration);
            if excess > 1.0 {
                law = law.stretched_to(excess.sqrt() * law.duration)?;
            }
        }
        Ok(law)
    }

    /// The law of least duration under a limit on acceleration alone, which it uses all the time (field word:
    /// bang-bang): `T = 2 √(D/A)`, with the peak velocity `√(DA)`.
    ///
    /// ```
    /// use graspcheck_planner::time_scaling::TimeScaling;
    /// let law = TimeScaling::bang_bang(1.0, 4.0)?;
    /// assert_eq!((law.duration(), law.peaks()[0]), (1.0, 2.0));
    /// # Ok::<(), graspcheck_planner::time_scaling::ScalingError>(())
    /// ```
    ///
    /// # Errors
    /// When an argument is not positive and finite.
    pub fn bang_bang(distance: f64, acceleration: f64) -> Result<Self, ScalingError> {
        positive("distance", distance)?;
        positive("acceleration", acceleration)?;
        let blend = (distance / acceleration).sqrt();
        let profile = Profile::Trapezoid { rise: blend, cruise: 0.0, fall: blend };
        Self::within(profile, distance, [f64::INFINITY, acceleration, f64::INFINITY])
    }

    /// The trapezoid of the given duration and cruise velocity: `t_b = T - D/V`.
    ///
    /// ```
    /// use graspcheck_planner::time_scaling::TimeScaling;
    /// // 40° to 120° in 4 s at 25°/s takes blends of 0.8 s and 31.25°/s².
    /// let law = TimeScaling::trapezoid_with_velocity(80.0, 4.0, 25.0)?;
    /// assert!((law.peaks()[1] - 31.25).abs() < 1e-12);
    /// # Ok::<(), graspcheck_planner::time_scaling::ScalingError>(())
    /// ```
    ///
    /// # Errors
    /// When an argument is not positive and finite, or not `D/T < V ≤ 2D/T`.
    pub fn trapezoid_with_velocity(
        distance: f64,
        duration: f64,
        velocity: f64,
    ) -> Result<Self, ScalingError> {
        check_distance_and_limits(distance, &[velocity])?;
        positive("duration", duration)?;
        let (least, most) = (distance / duration, 2.0 * distance / duration);
        if velocity <= least || velocity > most {
            return Err(ScalingError::VelocityDoesNotFit { distance, duration, velocity, least, most });
        }
        Self::with_blend(distance, duration, duration - distance / velocity)
    }

    /// The trapezoid of the given duration and acceleration: `t_b = T/2 - √(T² - 4D/A)/2`.
    ///
    /// ```
    /// use graspcheck_planner::time_scaling::TimeScaling;
    /// let law = TimeScaling::trapezoid_with_acceleration(80.0, 4.0, 20.0)?;
    /// assert_eq!(law.peaks()[0], 40.0); // the least acceleration leaves no cruise
    /// let error = TimeScaling::trapezoid_with_acceleration(80.0, 4.0, 19.0).unwrap_err();
    /// assert_eq!(error.to_string(), "distance 80 in 4 s: acceleration 19 must be at least 20");
    /// # Ok::<(), graspcheck_planner::time_scaling::ScalingError>(())
    /// ```
    ///
    /// # Errors
    /// When an argument is not positive and finite, or not `A ≥ 4D/T²`.
    pub fn trapezoid_with_acceleration(
        distance: f64,
        duration: f64,
        acceleration: f64,
    ) -> Result<Self, ScalingError> {
        positive("distance", distance)?;
        positive("duration", duration)?;
        positive("acceleration", acceleration)?;
        let least = 4.0 * distance / (duration * duration);
        if acceleration < least {
            return Err(ScalingError::AccelerationTooSmall { distance, duration, acceleration, least });
        }
        let cruise = (duration * duration - 4.0 * distance / acceleration).max(0.0).sqrt();
        // (T - c)/2 without cancellation, as (T² - c²)/4 = D/A.
        let blend = 2.0 * (distance / acceleration) / (duration + cruise);
        Self::new(Profile::Trapezoid { rise: blend, cruise, fall: blend }, distance, duration)
    }

    /// The trapezoid of the given duration and blend time: `V = D/(T - t_b)`.
    ///
    /// ```
    /// use graspcheck_planner::time_scaling::TimeScaling;
    /// assert_eq!(TimeScaling::trapezoid_with_blend(3.0, 4.0, 1.0)?.peaks(), [1.0, 1.0, 0.0]);
    /// # Ok::<(), graspcheck_planner::time_scaling::ScalingError>(())
    /// ```
    ///
    /// # Errors
    /// When an argument is not positive and finite, or not `t_b ≤ T/2`.
    pub fn trapezoid_with_blend(distance: f64, duration: f64, blend: f64) -> Result<Self, ScalingError> {
        positive("distance", distance)?;
        positive("duration", duration)?;
        at_most(distance, ("duration", duration), blend, 0.5 * duration)?;
        Self::with_blend(distance, duration, blend)
    }

    /// The trapezoid of the given cruise velocity and blend time: `T = D/V + t_b`.
    ///
    /// ```
    /// use graspcheck_planner::time_scaling::TimeScaling;
    /// assert_eq!(TimeScaling::trapezoid_with_velocity_and_blend(3.0, 1.0, 0.5)?.duration(), 3.5);
    /// # Ok::<(), graspcheck_planner::time_scaling::ScalingError>(())
    /// ```
    ///
    /// # Errors
    /// When an argument is not positive and finite, or not `t_b ≤ D/V`.
    pub fn trapezoid_with_velocity_and_blend(
        distance: f64,
        velocity: f64,
        blend: f64,
    ) -> Result<Self, ScalingError> {
        check_distance_and_limits(distance, &[velocity])?;
        at_most(distance, ("velocity", velocity), blend, distance / velocity)?;
        let cruise = distance / velocity - blend;
        Self::within_velocity(Profile::Trapezoid { rise: blend, cruise, fall: blend }, distance, velocity)
    }

    /// The trapezoid of the given acceleration and blend time: `V = A t_b`, `T = D/V + t_b`.
    ///
    /// ```
    /// use graspcheck_planner::time_scaling::TimeScaling;
    /// let law = TimeScaling::trapezoid_with_acceleration_and_blend(3.0, 2.0, 0.5)?;
    /// assert_eq!((law.duration(), law.peaks()[0]), (3.5, 1.0));
    /// # Ok::<(), graspcheck_planner::time_scaling::ScalingError>(())
    /// ```
    ///
    /// # Errors
    /// When an argument is not positive and finite, or not `t_b ≤ √(D/A)`.
    pub fn trapezoid_with_acceleration_and_blend(
        distance: f64,
        acceleration: f64,
        blend: f64,
    ) -> Result<Self, ScalingError> {
        positive("distance", distance)?;
        positive("acceleration", acceleration)?;
        at_most(distance, ("acceleration", acceleration), blend, (distance / acceleration).sqrt())?;
        let velocity = acceleration * blend;
        let cruise = (distance / velocity - blend).max(0.0);
        Self::within_velocity(Profile::Trapezoid { rise: blend, cruise, fall: blend }, distance, velocity)
    }

    fn with_blend(distance: f64, duration: f64, blend: f64) -> Result<Self, ScalingError> {
        let cruise = (duration - 2.0 * blend).max(0.0);
        Self::new(Profile::Trapezoid { rise: blend, cruise, fall: blend }, distance, duration)
    }

    fn within_velocity(profile: Profile, distance: f64, velocity: f64) -> Result<Self, ScalingError> {
        Self::within(profile, distance, [velocity, f64::INFINITY, f64::INFINITY])
    }
}

/// Checks that a blend time is positive, finite and at most `most`; `given` is what is given beside it.
fn at_most(
    distance: f64,
    (quantity, value): (&'static str, f64),
    blend: f64,
    most: f64,
) -> Result<(), ScalingError> {
    positive("blend time", blend)?;
    if blend <= most {
        Ok(())
    } else {
        Err(ScalingError::BlendTooLong { distance, quantity, value, blend, most })
    }
}
