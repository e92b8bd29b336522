//! A plan that is given more time.

use graspcheck_model::plan::Plan;
use graspcheck_motion::{Polynomial, Trajectory, TrajectoryError};

/// The plan along the same way in `stretch` times the time: velocities go as 1/k, accelerations as 1/k², jerks as 1/k³.
/// Paths are left out.
///
/// # Errors
/// When `stretch` is not positive, or a time overflows.
pub fn stretched(plan: &Plan, stretch: f64) -> Result<Plan, TrajectoryError> {
    let mut slower = plan.clone();
    slower.trajectory = stretched_motion(&plan.trajectory, stretch)?;
    slower.opening = stretched_motion(&plan.opening, stretch)?;
    for phase in &mut slower.phases {
        (phase.start, phase.end) = (stretch * phase.start, stretch * phase.end);
    }
    slower.paths.clear();
    Ok(slower)
}

fn stretched_motion(motion: &Trajectory, stretch: f64) -> Result<Trajectory, TrajectoryError> {
    // p(τ / k)
    let slower = |polynomial: &Polynomial| {
        let mut power = 1.0;
        Polynomial::new(polynomial.coefficients().map(|coefficient| {
            let slower = coefficient / power;
            power *= stretch;
            slower
        }))
    };
    let pieces = (0..motion.piece_count()).flat_map(|piece| motion.piece_of_all(piece)).map(slower);
    let knots = motion.knots().iter().map(|knot| stretch * knot).collect();
    Trajectory::new(motion.dof(), knots, pieces.collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures;

    #[test]
    fn rates_go_with_powers_of_the_stretch() {
        let plan = fixtures::rest_to_rest(&[0.0, 1.0], &[1.0, -0.5], 0.8);
        let slower = stretched(&plan, 3.0).unwrap();
        assert!((slower.duration() - 2.4).abs() < 1e-12 && (slower.phases[0].end - 2.4).abs() < 1e-12);
        let (then, now) = (plan.trajectory.eval(0.3), slower.trajectory.eval(0.9));
        for joint in 0..2 {
            assert!((then.q[joint] - now.q[joint]).abs() < 1e-12);
            assert!((then.qd[joint] - 3.0 * now.qd[joint]).abs() < 1e-12);
            assert!((then.qdd[joint] - 9.0 * now.qdd[joint]).abs() < 1e-11);
        }
        assert!(stretched(&plan, 0.0).is_err());
    }
}
