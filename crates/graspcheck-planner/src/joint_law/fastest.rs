//! The fastest law between two states under limits on velocity, acceleration and jerk.

use super::{
    JointLaw, RateLimits, check_ends,
    extremal::{Extreme, Farthest},
};
use crate::time_scaling::{ScalingError, TimeScaling, error::positive};

impl JointLaw {
    /// The law of least duration between two states `[position, velocity, acceleration]`, under limits on the
    /// magnitudes of velocity, acceleration and jerk: an S-curve whose ends move and accelerate.
    ///
    /// The fastest law to a distance is the farthest in its time, or that of the other direction. Both families are known
    /// in closed form but for one number, `J D = Σ ψ(xᵢ)(Wᵢ + v_p)/2 - Wᵢ bᵢ - bᵢ³/(6J)`, and all of its solutions are
    /// compared: see the derivation in this crate's `joint_law/extremal.rs`. Source of the problem: Kröger, *On-Line
    /// Trajectory Generation in Robotic Systems*, 2010, type IV.
    ///
    /// ```
    /// use graspcheck_planner::joint_law::{JointLaw, RateLimits};
    /// let limits = RateLimits { velocity: 1.0, acceleration: 2.0, jerk: 10.0 };
    /// let law = JointLaw::fastest([0.0, 0.2, 1.0], [1.0, 0.0, 0.0], limits)?;
    /// assert_eq!(law.start()[..3], [0.0, 0.2, 1.0]);
    /// assert_eq!(law.end()[0], 1.0);
    /// assert!(law.duration() < 1.7); // which it takes from rest
    /// # Ok::<(), graspcheck_planner::time_scaling::ScalingError>(())
    /// ```
    ///
    /// # Errors
    /// When a number is not finite, a limit is not positive, a state is beyond a limit or, with the greatest jerk,
    /// leads beyond the limit of velocity or comes from beyond it, or a coefficient overflows.
    pub fn fastest(start: [f64; 3], end: [f64; 3], limits: RateLimits) -> Result<Self, ScalingError> {
        check(start, end, limits)?;
        let distance = end[0] - start[0];
        if [start, end].iter().all(|[_, v, a]| *v == 0.0 && *a == 0.0) && distance != 0.0 {
            let RateLimits { velocity, acceleration, jerk } = limits;
            let scaling = TimeScaling::s_curve(distance.abs(), velocity, acceleration, jerk)?;
            return Self::along(start[0], end[0], &scaling);
        }
        let mut best: Option<(Farthest, Extreme)> = None;
        for sign in [1.0, -1.0] {
            let laws = Farthest::new(sign, start, end, limits);
            laws.covering(sign * distance, |law| {
                if best.is_none_or(|(_, best)| law.duration < best.duration) {
                    best = Some((laws, law));
                }
            });
        }
        // One of both families goes on for ever, by cruises, and covers what is asked: none is found only where
        // numbers overflow.
        let Some((laws, law)) = best else {
            return Err(ScalingError::Overflow { distance: distance.abs(), duration: f64::INFINITY });
        };
        Self::new(distance, law.duration, laws.pieces(law, end[0]))
    }
}

/// Checks limits and the states at both ends.
pub(super) fn check(start: [f64; 3], end: [f64; 3], limits: RateLimits) -> Result<(), ScalingError> {
    /// A state that just keeps a limit may be beyond it by rounding.
    const ROUNDING: f64 = 8.0 * f64::EPSILON;

    check_ends(start, end)?;
    let RateLimits { velocity, acceleration, jerk } = limits;
    for (name, limit) in [("velocity", velocity), ("acceleration", acceleration), ("jerk", jerk)] {
        positive(name, limit)?;
    }
    for (name, [_, v, a], time) in [("start", start, 1.0), ("end", end, -1.0)] {
        if v.abs() > velocity {
            return Err(ScalingError::BoundaryVelocity { end: name, velocity: v, limit: velocity });
        }
        if a.abs() > acceleration {
            return Err(ScalingError::BoundaryAcceleration {
                end: name,
                acceleration: a,
                limit: acceleration,
            });
        }
        // After the start, or before the end, the velocity goes on to this before the acceleration is zero.
        let reached = v + time * 0.5 * a * a.abs() / jerk;
        if reached.abs() > velocity * (1.0 + ROUNDING) {
            return Err(ScalingError::BoundaryReach {
                end: name,
                velocity: v,
                acceleration: a,
                reached,
                limit: velocity,
                most: (2.0 * jerk * (velocity - v.abs())).sqrt(),
            });
        }
    }
    Ok(())
}
