//! The same path under the same law, slower or faster.
//!
//! When a motion takes `factor` times as long, its velocities are divided by the factor, its accelerations
//! by the square and its jerks by the cube. So the factor at which the tightest limit is just met follows
//! from the peaks of the motion, without another search.

use graspcheck_model::robot::JointLimits;
use graspcheck_motion::{Polynomial, Trajectory, TrajectoryError};

/// How far below its limit the tightest quantity is kept by [`least_factor`], as a share of the time.
///
/// The reason: the peaks of the stretched polynomials are computed anew by whoever checks them, with
/// rounding errors of about 1e-13; a motion that meets its limit must not be found beyond it.
pub const MARGIN: f64 = 1e-10;

/// The smallest factor by which the duration of `motion` must be multiplied so that every joint keeps
/// `share` of its limits of velocity, acceleration and jerk (below 1 when the motion is slower than
/// need be); 0 when nothing moves.
///
/// ```
/// use graspcheck_model::robot::JointLimits;
/// use graspcheck_motion::{Polynomial, Trajectory};
/// use graspcheck_planner::retime::least_factor;
/// let swing = Polynomial::quintic_hermite([0.0; 3], [1.0, 0.0, 0.0], 1.0);
/// let motion = Trajectory::new(1, vec![0.0, 1.0], vec![swing])?;
/// // It peaks at 15/8; three quarters of 5 allow it to be twice as fast.
/// let limits = JointLimits {
///     position_min: -9.0, position_max: 9.0, velocity: 5.0, acceleration: 1e3, jerk: 1e4, effort: 1.0,
/// };
/// assert!((least_factor(&motion, &[limits], 0.75) - 0.5).abs() < 1e-9);
/// # Ok::<(), graspcheck_motion::TrajectoryError>(())
/// ```
///
/// # Panics
/// When there are fewer limits than joints.
#[must_use]
pub fn least_factor(motion: &Trajectory, limits: &[JointLimits], share: f64) -> f64 {
    let mut factor: f64 = 0.0;
    for (joint, limit) in limits.iter().enumerate().take(motion.dof()) {
        for (order, bound) in [(1, limit.velocity), (2, limit.acceleration), (3, limit.jerk)] {
            let ratio = motion.peak(joint, order).value.abs() / (share * bound);
            factor = factor.max(ratio.powf(1.0 / order as f64));
        }
    }
    factor * (1.0 + MARGIN)
}

/// `motion` with all times multiplied by `factor`.
///
/// ```
/// use graspcheck_motion::{Polynomial, Trajectory};
/// use graspcheck_planner::retime::stretched;
/// let swing = Polynomial::quintic_hermite([0.0; 3], [1.0, 0.0, 0.0], 1.0);
/// let motion = Trajectory::new(1, vec![0.0, 1.0], vec![swing])?;
/// // Twice as long: half the velocity, a quarter of the acceleration, an eighth of the jerk.
/// let slow = stretched(&motion, 2.0)?;
/// assert_eq!((slow.duration(), slow.eval(1.0).qd[0]), (2.0, 15.0 / 16.0));
/// assert_eq!(slow.eval(0.0).qddd[0], 60.0 / 8.0);
/// # Ok::<(), graspcheck_motion::TrajectoryError>(())
/// ```
///
/// # Errors
/// When the factor is not positive or so extreme that knots or coefficients are no longer finite.
pub fn stretched(motion: &Trajectory, factor: f64) -> Result<Trajectory, TrajectoryError> {
    retimed(motion, factor, motion.knots().iter().map(|t| t * factor).collect())
}

/// `motion` stretched or compressed so that it lasts exactly `duration` seconds.
///
/// ```
/// use graspcheck_motion::{Polynomial, Trajectory};
/// use graspcheck_planner::retime::lasting;
/// let swing = Polynomial::quintic_hermite([0.0; 3], [1.0, 0.0, 0.0], 1.0);
/// let motion = Trajectory::new(1, vec![0.0, 1.0], vec![swing])?;
/// let motion = lasting(&motion, 0.3)?;
/// assert_eq!(motion.duration(), 0.3);
/// assert!((motion.eval(0.3).q[0] - 1.0).abs() < 1e-15);
/// # Ok::<(), graspcheck_motion::TrajectoryError>(())
/// ```
///
/// # Errors
/// When the duration is not positive or not finite.
pub fn lasting(motion: &Trajectory, duration: f64) -> Result<Trajectory, TrajectoryError> {
    let factor = duration / motion.duration();
    let mut knots: Vec<f64> = motion.knots().iter().map(|t| t * factor).collect();
    if let Some(last) = knots.last_mut() {
        *last = duration;
    }
    retimed(motion, factor, knots)
}

fn retimed(motion: &Trajectory, factor: f64, knots: Vec<f64>) -> Result<Trajectory, TrajectoryError> {
    let pieces = (0..motion.piece_count())
        .flat_map(|piece| motion.piece_of_all(piece))
        .map(|polynomial| {
            let mut coefficients = *polynomial.coefficients();
            let mut divisor = 1.0;
            for coefficient in &mut coefficients {
                *coefficient /= divisor;
                divisor *= factor;
            }
            Polynomial::new(coefficients)
        })
        .collect();
    Trajectory::new(motion.dof(), knots, pieces)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limits(velocity: f64, acceleration: f64, jerk: f64) -> JointLimits {
        JointLimits { position_min: -1.0, position_max: 1.0, velocity, acceleration, jerk, effort: 1.0 }
    }

    /// A quintic from 0 to 1 in one second: peaks 15/8, 10/√3 and 60 (worked examples, section 3).
    fn quintic() -> Trajectory {
        let polynomial = Polynomial::quintic_hermite([0.0; 3], [1.0, 0.0, 0.0], 1.0);
        Trajectory::new(1, vec![0.0, 1.0], vec![polynomial]).unwrap()
    }

    #[test]
    fn factor_follows_each_limit_by_its_power() {
        let loose = 1e9;
        for (limit, expected) in [
            (limits(0.5, loose, loose), 15.0 / 8.0 / 0.5),
            (limits(loose, 2.0, loose), (10.0 / 3.0_f64.sqrt() / 2.0).sqrt()),
            (limits(loose, loose, 7.0), (60.0 / 7.0_f64).cbrt()),
        ] {
            let factor = least_factor(&quintic(), &[limit], 1.0);
            assert!((factor / expected - 1.0).abs() < 1e-9, "{factor} is not {expected}");
            assert!(factor > expected, "the limit must be met from below");
        }
    }

    #[test]
    fn stretched_motion_meets_the_tightest_limit_from_below() {
        let limit = limits(0.3, 2.0, 40.0);
        let factor = least_factor(&quintic(), &[limit], 0.8);
        let slower = stretched(&quintic(), factor).unwrap();
        let ratio = slower.peak(0, 1).value / (0.8 * limit.velocity);
        assert!(ratio <= 1.0 && ratio > 1.0 - 1e-9, "{ratio}");
        assert!((slower.eval(slower.duration()).q[0] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn lasting_is_exact() {
        let motion = lasting(&quintic(), 0.41).unwrap();
        assert!(motion.duration().to_bits() == 0.41_f64.to_bits());
        assert!((motion.peak(0, 1).value - 15.0 / 8.0 / 0.41).abs() < 1e-12);
        assert!(lasting(&quintic(), 0.0).is_err());
    }
}
