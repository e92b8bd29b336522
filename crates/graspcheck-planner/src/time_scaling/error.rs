//! Why there is no law of time.

/// Why there is no law of time. Each says the value, the limit and what would do.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ScalingError {
    /// A distance, limit or duration is not a positive finite number.
    #[error("{quantity} {value} must be a positive finite number")]
    NotPositive {
        /// Which: `distance`, `velocity`, …
        quantity: &'static str,
        /// What was given.
        value: f64,
    },
    /// A position, velocity, acceleration, jerk or time at an end of a law is NaN or infinite, or two positions
    /// are too far apart for a float.
    #[error("{quantity} {value} must be finite")]
    NotFinite {
        /// Which: `start position`, `end velocity`, …
        quantity: &'static str,
        /// What was given.
        value: f64,
    },
    /// The distance cannot be covered in this time with this cruise velocity.
    #[error(
        "distance {distance} in {duration} s: cruise velocity {velocity} must be above {least} and at most {most}"
    )]
    VelocityDoesNotFit {
        /// Distance to cover.
        distance: f64,
        /// In which time, s.
        duration: f64,
        /// Cruise velocity that was given.
        velocity: f64,
        /// D/T, which takes infinite acceleration.
        least: f64,
        /// 2D/T, which leaves no cruise.
        most: f64,
    },
    /// The distance cannot be covered in this time with so small an acceleration.
    #[error("distance {distance} in {duration} s: acceleration {acceleration} must be at least {least}")]
    AccelerationTooSmall {
        /// Distance to cover.
        distance: f64,
        /// In which time, s.
        duration: f64,
        /// Acceleration that was given.
        acceleration: f64,
        /// 4D/T², which leaves no cruise.
        least: f64,
    },
    /// Two blends take longer than the motion, or cover more than the distance.
    #[error("distance {distance}, {quantity} {value}: blend time {blend} s must be at most {most} s")]
    BlendTooLong {
        /// Distance to cover.
        distance: f64,
        /// What is given beside the blend time: `duration`, `velocity` or `acceleration`.
        quantity: &'static str,
        /// Its value.
        value: f64,
        /// Blend time that was given, s.
        blend: f64,
        /// T/2, D/V or √(D/A), which leave no cruise.
        most: f64,
    },
    /// A velocity at an end of a law is above the limit on velocity.
    #[error("{end} velocity {velocity} is beyond the limit {limit}: raise the limit to {velocity_abs}, or brake before", velocity_abs = .velocity.abs())]
    BoundaryVelocity {
        /// `start` or `end`.
        end: &'static str,
        /// The velocity there.
        velocity: f64,
        /// The limit on its magnitude.
        limit: f64,
    },
    /// An acceleration at an end of a law is above the limit on acceleration.
    #[error("{end} acceleration {acceleration} is beyond the limit {limit}: raise the limit to {acceleration_abs}, or lower the acceleration before", acceleration_abs = .acceleration.abs())]
    BoundaryAcceleration {
        /// `start` or `end`.
        end: &'static str,
        /// The acceleration there.
        acceleration: f64,
        /// The limit on its magnitude.
        limit: f64,
    },
    /// From the state at the start, or to that at the end, the velocity passes its limit whatever the law does.
    #[error(
        "{end} velocity {velocity} with acceleration {acceleration}: the velocity reaches {reached} with the greatest jerk, beyond the limit {limit}: the acceleration may be at most {most}"
    )]
    BoundaryReach {
        /// `start` or `end`.
        end: &'static str,
        /// The velocity there.
        velocity: f64,
        /// The acceleration there.
        acceleration: f64,
        /// The velocity after the start, or before the end, at which the acceleration is zero at the earliest.
        reached: f64,
        /// The limit on its magnitude.
        limit: f64,
        /// The largest acceleration at this velocity that keeps the limit.
        most: f64,
    },
    /// No law under the limits takes this long; between moving ends durations have gaps.
    #[error("duration {duration} s cannot be met: the least duration is {least} s, the nearest {}", nearest(*.before, *.after))]
    DurationNotPossible {
        /// What was asked for, s.
        duration: f64,
        /// The least duration of all, s.
        least: f64,
        /// The next shorter duration that can be met, s, if there is one.
        before: Option<f64>,
        /// The next longer duration that can be met, s.
        after: f64,
    },
    /// The numbers are so far apart that a coefficient of the law overflows.
    #[error("distance {distance} in {duration} s: a coefficient of the law overflows")]
    Overflow {
        /// Distance to cover.
        distance: f64,
        /// In which time, s.
        duration: f64,
    },
}

/// The durations beside one that cannot be met, in words.
fn nearest(before: Option<f64>, after: f64) -> String {
    match before {
        Some(before) => format!("are {before} s and {after} s"),
        None => format!("is {after} s"),
    }
}

/// Checks that a quantity is positive and finite.
pub(crate) fn positive(quantity: &'static str, value: f64) -> Result<(), ScalingError> {
    if value > 0.0 && value.is_finite() { Ok(()) } else { Err(ScalingError::NotPositive { quantity, value }) }
}

/// Checks that a quantity is finite.
pub(crate) fn finite(quantity: &'static str, value: f64) -> Result<(), ScalingError> {
    if value.is_finite() { Ok(()) } else { Err(ScalingError::NotFinite { quantity, value }) }
}

/// Checks a distance and limits on velocity, acceleration and jerk, in this order; later ones may be left out.
pub(super) fn check_distance_and_limits(distance: f64, limits: &[f64]) -> Result<(), ScalingError> {
    positive("distance", distance)?;
    let names = ["velocity", "acceleration", "jerk"];
    limits.iter().zip(names).try_for_each(|(&limit, name)| positive(name, limit))
}
