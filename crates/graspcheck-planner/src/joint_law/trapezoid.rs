//! The fastest law between moving ends under limits on velocity and acceleration.

use super::{JointLaw, check_ends, turned::Turned};
use crate::time_scaling::{
    ScalingError,
    error::positive,
    pieces::{Pieces, VelocityChange},
};

impl JointLaw {
    /// The law of least duration between two positions with given velocities, under limits on the magnitudes of
    /// velocity and acceleration: the peak velocity is `√(AD + (v₀² + v₁²)/2)`, or V with a cruise.
    ///
    /// Ends may move in either direction: a law that starts away from its goal turns round, one that cannot
    /// stop in time passes its end and comes back. With all signs changed where the peak is below both ends.
    ///
    /// ```
    /// use graspcheck_planner::joint_law::JointLaw;
    /// // Brakes 0.5 beyond, and comes back by 0.5 in 2 √0.5 s.
    /// let law = JointLaw::trapezoid([0.0, 1.0], [0.0, 0.0], 10.0, 1.0)?;
    /// assert!((law.duration() - (1.0 + 2.0_f64.sqrt())).abs() < 1e-15);
    /// # Ok::<(), graspcheck_planner::time_scaling::ScalingError>(())
    /// ```
    ///
    /// # Errors
    /// When a state is not finite, a limit is not positive and finite, a velocity at an end is above the limit,
    /// or a coefficient overflows.
    pub fn trapezoid(
        start: [f64; 2],
        end: [f64; 2],
        velocity: f64,
        acceleration: f64,
    ) -> Result<Self, ScalingError> {
        check_ends(start, end)?;
        positive("velocity", velocity)?;
        positive("acceleration", acceleration)?;
        check_boundary_velocities(start[1], end[1], velocity)?;
        let distance = end[0] - start[0];
        let direct = (end[1] - start[1]).abs() / acceleration;
        let turned = Turned::new(start, end, direct);
        let [v0, v1] = turned.velocities;
        let signed = turned.sign * distance;
        let peak = (acceleration * signed + 0.5 * (v0 * v0 + v1 * v1)).max(0.0).sqrt();
        // With nothing to cover beyond it the law is direct; its peak is the faster end, also where rounding
        // or a negative velocity would say otherwise.
        let peak = if turned.beyond > 0.0 { peak.max(v0).max(v1) } else { v0.max(v1) };
        let peak = peak.min(velocity);
        let [rise, fall] = [peak - v0, peak - v1].map(|change| VelocityChange {
            change,
            jerk: 0.0,
            acceleration: change / acceleration,
        });
        let covered = 0.5 * ((v0 + peak) * rise.acceleration + (v1 + peak) * fall.acceleration);
        let cruise = if peak < velocity { 0.0 } else { ((signed - covered) / velocity).max(0.0) };
        let duration = rise.acceleration + cruise + fall.acceleration;
        let [rise, fall] = [rise, fall].map(|change| change.times(turned.sign));
        let cruise = (cruise, turned.sign * peak);
        Self::new(distance, duration, Pieces::between(start, rise, cruise, fall, end, duration))
    }
}

/// Checks that the velocities at both ends are within the limit. A law that begins too fast would have to break
/// the limit, whatever it did: it is for the caller to brake before, or to raise the limit.
pub(super) fn check_boundary_velocities(start: f64, end: f64, limit: f64) -> Result<(), ScalingError> {
    for (end, velocity) in [("start", start), ("end", end)] {
        if velocity.abs() > limit {
            return Err(ScalingError::BoundaryVelocity { end, velocity, limit });
        }
    }
    Ok(())
}
