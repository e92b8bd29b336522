//! Cubics through points with given velocities.
//!
//! Each piece is the one cubic from position and velocity at a point to those at the next; with T the time
//! between them and t from 0 to T (worked examples, section 3):
//!
//! ```text
//! q(t) = q₀ + v₀ t + (3(q₁ − q₀) − (2v₀ + v₁)T)/T² t² + (2(q₀ − q₁) + (v₀ + v₁)T)/T³ t³
//! ```
//!
//! Position and velocity are continuous; the acceleration jumps at inner points.

use graspcheck_motion::{Polynomial, Trajectory};

use super::points::{Quantity, ViaError, ViaPoints, trajectory};

/// The cubic on `[0, duration]` from `[position, velocity]` at its start to those at its end (Hermite
/// interpolation of first order); `duration` is positive, s.
///
/// ```
/// use graspcheck_planner::via::imposed::cubic;
///
/// // 10 -> 40 in 1 s, at -50 per s at both ends: 10 - 50 t + 240 t² - 160 t³, which overshoots both ends.
/// let q = cubic([10.0, -50.0], [40.0, -50.0], 1.0);
/// assert_eq!(q.coefficients()[..4], [10.0, -50.0, 240.0, -160.0]);
/// ```
#[must_use]
pub fn cubic(start: [f64; 2], end: [f64; 2], duration: f64) -> Polynomial {
    let [q0, v0] = start;
    let [q1, v1] = end;
    // Divided step by step, so that the square or cube of a short duration does not underflow.
    let slope = (q1 - q0) / duration;
    let square = (3.0 * slope - (2.0 * v0 + v1)) / duration;
    let cube = ((v0 + v1) - 2.0 * slope) / duration / duration;
    Polynomial::new([q0, v0, square, cube])
}

/// The motion through the points with these velocities, `velocities[k][joint]` at point k, rad/s or m/s.
///
/// Time 0 is that of the first point. The acceleration jumps at inner points, and the trajectory says by how
/// much.
///
/// ```
/// use graspcheck_planner::via::{ViaPoints, imposed};
///
/// // 20° -> 80° in 5 s -> 25° in 5 s, from rest to rest, at 10°/s through the middle.
/// let points = ViaPoints::new(vec![0.0, 5.0, 10.0], vec![vec![20.0], vec![80.0], vec![25.0]])?;
/// let motion = imposed::through(&points, &[vec![0.0], vec![10.0], vec![0.0]])?;
/// let state = motion.eval(5.0);
/// assert_eq!((state.q[0], state.qd[0]), (80.0, 10.0));
/// // 20 + 5.2 t² - 0.56 t³, then 80 + 10 t - 10.6 t² + 1.28 t³: the acceleration steps.
/// let [step] = motion.breaks() else { panic!("one inner point") };
/// assert_eq!(step.order, 2);
/// assert!((step.jump[0] - (-21.2 - (10.4 - 3.36 * 5.0))).abs() < 1e-12);
/// # Ok::<(), graspcheck_planner::via::ViaError>(())
/// ```
///
/// # Errors
/// When there is not one finite velocity for each joint at each point, or a coefficient overflows.
pub fn through(points: &ViaPoints, velocities: &[Vec<f64>]) -> Result<Trajectory, ViaError> {
    if velocities.len() != points.len() {
        return Err(ViaError::PointCount {
            quantity: "velocities",
            count: velocities.len(),
            points: points.len(),
        });
    }
    for (k, velocities) in velocities.iter().enumerate() {
        points.check_joints(&format!("point {}", k + 1), Quantity::Velocity, velocities)?;
    }
    let of_joint = |joint| {
        let velocities: Vec<f64> = velocities.iter().map(|velocities| velocities[joint]).collect();
        cubics(&points.durations(), &points.of_joint(joint), &velocities)
    };
    let of_joints: Vec<_> = (0..points.dof()).map(of_joint).collect();
    Ok(trajectory(points.times(), &of_joints)?)
}

/// The cubics of one joint through `positions` with `velocities`.
pub(super) fn cubics(durations: &[f64], positions: &[f64], velocities: &[f64]) -> Vec<Polynomial> {
    let state = |k: usize| [positions[k], velocities[k]];
    durations.iter().enumerate().map(|(k, &duration)| cubic(state(k), state(k + 1), duration)).collect()
}
