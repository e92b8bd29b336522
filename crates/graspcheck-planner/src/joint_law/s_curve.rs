//! The fastest law between moving ends that do not accelerate, under limits on velocity, acceleration and jerk.

use super::{JointLaw, RateLimits};
use crate::time_scaling::ScalingError;

impl JointLaw {
    /// The law of least duration between two positions with given velocities and no acceleration, under limits
    /// on the magnitudes of velocity, acceleration and jerk. It is the fastest there is, also where the textbook
    /// law (Biagiotti and Melchiorri, section 3.4) is not, which lowers the acceleration until a solution appears.
    ///
    /// Ends may move in either direction: a law that starts away from its goal turns round, one that cannot
    /// stop in time passes its end and comes back. Accelerations at the ends are zero; for others see
    /// [`JointLaw::fastest`]. Position limits are not looked at. A velocity at an end above the limit is an
    /// error: such a law would break the limit, and nothing brakes silently.
    ///
    /// ```
    /// use graspcheck_planner::joint_law::{JointLaw, RateLimits};
    /// let limits = RateLimits { velocity: 10.0, acceleration: 10.0, jerk: 30.0 };
    /// let law = JointLaw::s_curve([0.0, 7.0], [10.0, 0.0], limits)?;
    /// assert!((law.duration() - 1.780446).abs() < 5e-7); // the textbook law: 1.938369 s
    /// # Ok::<(), graspcheck_planner::time_scaling::ScalingError>(())
    /// ```
    ///
    /// # Errors
    /// When a state is not finite, a limit is not positive and finite, a velocity at an end is above the limit,
    /// or a coefficient overflows.
    pub fn s_curve(start: [f64; 2], end: [f64; 2], limits: RateLimits) -> Result<Self, ScalingError> {
        let still = |[q, v]: [f64; 2]| [q, v, 0.0];
        Self::fastest(still(start), still(end), limits)
    }
}
