//! Cubics through points with velocities computed from the slopes beside each point.
//!
//! With the slope `vₖ = (qₖ − qₖ₋₁)/(tₖ − tₖ₋₁)` of each segment, the velocity at an inner point is
//!
//! ```text
//! 0                  where the slopes before and after the point differ in sign, or one of them is 0
//! (vₖ + vₖ₊₁)/2      elsewhere
//! ```
//!
//! so that a joint turns round at the point itself and rests where the points rest (worked examples, section
//! 5; Biagiotti and Melchiorri, section 4.3, *heuristic computation of the velocities*). The acceleration
//! jumps at inner points.

use graspcheck_model::via::velocity_by_signs;
use graspcheck_motion::Trajectory;

use super::{
    imposed,
    points::{Quantity, ViaError, ViaPoints},
};

/// The velocities of the rule at the inner points, with `start` and `end` at the ends (one for each joint,
/// rad/s or m/s): `velocities[k][joint]`, as [`imposed::through`] takes them.
///
/// # Errors
/// When `start` or `end` does not have one finite velocity for each joint.
pub fn velocities(points: &ViaPoints, start: &[f64], end: &[f64]) -> Result<Vec<Vec<f64>>, ViaError> {
    points.check_joints("start", Quantity::Velocity, start)?;
    points.check_joints("end", Quantity::Velocity, end)?;
    let slopes: Vec<Vec<f64>> = points
        .durations()
        .iter()
        .zip(points.positions().windows(2))
        .map(|(duration, pair)| pair[0].iter().zip(&pair[1]).map(|(a, b)| (b - a) / duration).collect())
        .collect();
    let inner = slopes.windows(2).map(|pair| {
        pair[0].iter().zip(&pair[1]).map(|(&before, &after)| velocity_by_signs(before, after)).collect()
    });
    Ok([start.to_vec()].into_iter().chain(inner).chain([end.to_vec()]).collect())
}

/// The motion through the points with the velocities of the rule at inner points and `start` and `end` at the
/// ends (one for each joint, rad/s or m/s).
///
/// ```
/// use std::f64::consts::PI;
/// use graspcheck_planner::via::{ViaPoints, computed};
///
/// // Up, down and up again: the joint turns round at both inner points.
/// let positions = [0.0, 2.0 * PI, 0.5 * PI, PI].map(|q| vec![q]).to_vec();
/// let points = ViaPoints::new(vec![0.0, 2.0, 3.0, 5.0], positions)?;
/// let motion = computed::through(&points, &[0.0], &[0.0])?;
/// assert_eq!((motion.eval(2.0).qd[0], motion.eval(3.0).qd[0]), (0.0, 0.0));
/// # Ok::<(), graspcheck_planner::via::ViaError>(())
/// ```
///
/// # Errors
/// When `start` or `end` does not have one finite velocity for each joint, or a coefficient overflows.
pub fn through(points: &ViaPoints, start: &[f64], end: &[f64]) -> Result<Trajectory, ViaError> {
    imposed::through(points, &velocities(points, start, end)?)
}
