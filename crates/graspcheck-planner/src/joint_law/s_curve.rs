//! The fastest law between moving ends under limits on velocity, acceleration and jerk.

use super::{JointLaw, RateLimits, check_ends, faster::Turned, trapezoid::check_boundary_velocities};
use crate::time_scaling::{
    ScalingError, TimeScaling,
    error::positive,
    pieces::{Pieces, VelocityChange},
};

impl JointLaw {
    /// The law of least duration between two positions with given velocities and no acceleration, under limits
    /// on the magnitudes of velocity, acceleration and jerk. It is the fastest there is, also where the textbook
    /// law is not: see the derivation in this crate's `joint_law/faster.rs`.
    ///
    /// Ends may move in either direction: a law that starts away from its goal turns round, one that cannot
    /// stop in time passes its end and comes back. Accelerations at the ends are zero; for others use
    /// [`JointLaw::quintic`]. Position limits are not looked at. A velocity at an end above the limit is an
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
        check_ends(start, end)?;
        let RateLimits { velocity, acceleration, jerk } = limits;
        for (name, limit) in [("velocity", velocity), ("acceleration", acceleration), ("jerk", jerk)] {
            positive(name, limit)?;
        }
        check_boundary_velocities(start[1], end[1], velocity)?;
        let distance = end[0] - start[0];
        if start[1] == 0.0 && end[1] == 0.0 && distance != 0.0 {
            let scaling = TimeScaling::s_curve(distance.abs(), velocity, acceleration, jerk)?;
            return Self::along(start[0], end[0], &scaling);
        }
        let fastest = |change: f64| VelocityChange::fastest(change, acceleration, jerk);
        let direct = fastest((end[1] - start[1]).abs()).duration();
        let turned = Turned::new(start, end, direct);
        let [v0, v1] = turned.velocities;
        let faster_end = v0.max(v1);
        let ends = Ends { gaps: [faster_end - v0, faster_end - v1], velocities: [v0, v1], limits };
        let (rise, cruise) = ends.rise(turned.sign * distance, turned.beyond, velocity - faster_end);
        let changes = ends.gaps.map(|gap| fastest(gap + rise));
        let duration = changes[0].duration() + cruise + changes[1].duration();
        let cruise = (cruise, turned.sign * (faster_end + rise));
        let [rise, fall] = changes.map(|change| change.times(turned.sign));
        Self::new(distance, duration, Pieces::between(start, rise, cruise, fall, end, duration))
    }
}

/// The two changes of velocity, whose size is counted from the faster end.
struct Ends {
    /// How much slower each end is than the faster one.
    gaps: [f64; 2],
    velocities: [f64; 2],
    limits: RateLimits,
}

impl Ends {
    /// How far the peak velocity is above the faster end, and how long the cruise lasts, s.
    fn rise(&self, distance: f64, beyond: f64, most: f64) -> (f64, f64) {
        if beyond <= 0.0 {
            return (0.0, 0.0);
        }
        let most = most.max(0.0);
        let [covered, _] = self.covered(most.sqrt());
        if covered <= distance {
            return (most, (distance - covered) / self.limits.velocity);
        }
        // Newton's method on the root of the rise, in which the distance is smooth, inside a bracket at whose
        // lower end too little is covered and at whose upper end too much.
        let (mut low, mut high) = (0.0, most.sqrt());
        let mut root = high;
        for _ in 0..MOST_STEPS {
            let [covered, slope] = self.covered(root);
            let excess = covered - distance;
            if excess > 0.0 {
                high = root;
            } else {
                low = root;
            }
            let newton = root - excess / slope;
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            if (next - root).abs() <= 2.0 * f64::EPSILON * root {
                break;
            }
            root = next;
        }
        (root * root, 0.0)
    }

    /// The distance that both changes cover when the rise is `root²`, and its derivative by the root.
    fn covered(&self, root: f64) -> [f64; 2] {
        let RateLimits { acceleration, jerk, .. } = self.limits;
        let mut sum = [0.0; 2];
        for (gap, v) in self.gaps.into_iter().zip(self.velocities) {
            let change = root * root + gap;
            let mean = v + 0.5 * change;
            let by_change = if change * jerk >= acceleration * acceleration {
                sum[0] += mean * (change / acceleration + acceleration / jerk);
                (v + change + 0.5 * acceleration * acceleration / jerk) / acceleration * root
            } else {
                // root / √change, also at 0 / 0.
                let share = if gap > 0.0 { root / change.sqrt() } else { 1.0 };
                sum[0] += mean * 2.0 * (change / jerk).sqrt();
                (v + 1.5 * change) / jerk.sqrt() * share
            };
            sum[1] += 2.0 * by_change;
        }
        sum
    }
}

/// Bisection alone needs about 60 steps from an end of the bracket to the last bit; Newton's method takes five.
const MOST_STEPS: usize = 200;
