//! Straight moves in joint space (field word: PTP, synchronised).
//!
//! All joints share one law of time, so that the path `q(s) = q₀ + (q₁ - q₀) s` is straight whatever the
//! limits are. The law is the S-curve that keeps the limits of every joint; it can take longer than any
//! joint would alone.

use graspcheck_model::robot::JointLimits;
use graspcheck_motion::{Polynomial, Trajectory, TrajectoryError};

use crate::time_scaling::{ScalingError, TimeScaling};

/// The least duration of a move, s: shorter ones, also those of length zero, are stretched to it.
///
/// The reason: floats near 1000 s lie 1e-13 s apart, and the seven phases of a move must stay apart when
/// motions are joined. No control cycle is as short.
pub const SHORTEST_MOVE: f64 = 1e-6;

/// Why there is no straight move.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum JointMoveError {
    /// Start, end and limits are not of the same joints.
    #[error("a move needs a start, an end and limits for each joint, got {from}, {to} and {limits}")]
    JointCount {
        /// How many positions the start has.
        from: usize,
        /// How many positions the end has.
        to: usize,
        /// How many joints have limits.
        limits: usize,
    },
    /// A position is NaN or infinite, or start and end are too far apart for a float.
    #[error("joint {joint}: the move from {from} to {to} is not finite")]
    NotFinite {
        /// Index of the joint.
        joint: usize,
        /// Where it starts, rad or m.
        from: f64,
        /// Where it ends, rad or m.
        to: f64,
    },
    /// A limit is not a positive finite number.
    #[error("joint {joint}: {quantity} limit {value} must be a positive finite number")]
    Limit {
        /// Index of the joint.
        joint: usize,
        /// `velocity`, `acceleration` or `jerk`.
        quantity: &'static str,
        /// What was given, SI units.
        value: f64,
    },
    /// The share of the limits is not within (0, 1].
    #[error("share {share} of the limits must be above 0 and at most 1")]
    Share {
        /// What was given.
        share: f64,
    },
    /// The requested duration is not a positive finite number.
    #[error("duration {duration} s must be a positive finite number")]
    Duration {
        /// What was given, s.
        duration: f64,
    },
    /// There is no law of time.
    #[error(transparent)]
    Scaling(#[from] ScalingError),
    /// The pieces do not make a motion.
    #[error(transparent)]
    Trajectory(#[from] TrajectoryError),
}

/// The straight move in joint space from rest at `from` to rest at `to`, rad or m.
///
/// Without a `duration` it takes the least time under `share` of the velocity, acceleration and jerk limits
/// of every joint. With s from 0 to 1 those limit the common law to `V_s = min V_j/D_j`, and alike for
/// acceleration and jerk, D_j being the distance of joint j. With a `duration`, s, it is the same law in
/// exactly this time, also where that exceeds limits: it is for the checks to say so. Position limits are
/// not looked at.
///
/// A move of length zero is a rest, as is one below the smallest normal float (2e-308). Moves shorter than [`SHORTEST_MOVE`] are stretched to it unless a
/// duration is asked for.
///
/// # Errors
/// When the numbers of joints differ or are zero, a number is not finite, a limit or the duration is not
/// positive, or the share is not within (0, 1].
pub fn joint_move(
    from: &[f64],
    to: &[f64],
    limits: &[JointLimits],
    share: f64,
    duration: Option<f64>,
) -> Result<Trajectory, JointMoveError> {
    check(from, to, limits, share, duration)?;
    // The law runs over the longest distance of a joint rather than over 1, so that tiny moves are as well
    // scaled as large ones.
    let longest = from.iter().zip(to).fold(0.0, |longest: f64, (a, b)| longest.max((b - a).abs()));
    if longest < f64::MIN_POSITIVE {
        return Ok(Trajectory::hold(to, duration.unwrap_or(SHORTEST_MOVE))?);
    }
    let ratios: Vec<f64> = from.iter().zip(to).map(|(a, b)| (b - a) / longest).collect();
    let shared = |limit: fn(&JointLimits) -> f64| {
        let of_joint = |(joint, ratio): (&JointLimits, &f64)| share * limit(joint) / ratio.abs();
        // A joint that does not move gives infinity, which is no limit.
        limits.iter().zip(&ratios).map(of_joint).fold(f64::INFINITY, f64::min)
    };
    let mut law = TimeScaling::s_curve(
        longest,
        shared(|j| j.velocity),
        shared(|j| j.acceleration),
        shared(|j| j.jerk),
    )?;
    if duration.is_some() || law.duration() < SHORTEST_MOVE {
        law = law.stretched_to(duration.unwrap_or(SHORTEST_MOVE))?;
    }
    along_straight_line(from, to, &ratios, &law)
}

/// The law composed with the straight line, exactly: `q = q₀ + r s`, with the ratio r of a joint's distance
/// to the distance of the law.
fn along_straight_line(
    from: &[f64],
    to: &[f64],
    ratios: &[f64],
    law: &TimeScaling,
) -> Result<Trajectory, JointMoveError> {
    let pieces = law.pieces();
    let knots = pieces.iter().map(|(start, _)| *start).chain([law.duration()]).collect();
    let mut polynomials = Vec::with_capacity(pieces.len() * from.len());
    for (_, s) in &pieces {
        let s_start = s.coefficients()[0];
        for ((&from, &to), &ratio) in from.iter().zip(to).zip(ratios) {
            let mut q = s.coefficients().map(|c| ratio * c);
            // Counted from the nearer end, so that rounding moves neither.
            q[0] = if s_start < 0.5 * law.distance() {
                from + ratio * s_start
            } else {
                to + ratio * (s_start - law.distance())
            };
            polynomials.push(Polynomial::new(q));
        }
    }
    Ok(Trajectory::new(from.len(), knots, polynomials)?)
}

fn check(
    from: &[f64],
    to: &[f64],
    limits: &[JointLimits],
    share: f64,
    duration: Option<f64>,
) -> Result<(), JointMoveError> {
    if from.len() != to.len() || from.len() != limits.len() {
        return Err(JointMoveError::JointCount { from: from.len(), to: to.len(), limits: limits.len() });
    }
    for (joint, (&from, &to)) in from.iter().zip(to).enumerate() {
        if !(from.is_finite() && to.is_finite() && (to - from).is_finite()) {
            return Err(JointMoveError::NotFinite { joint, from, to });
        }
    }
    let is_positive = |value: f64| value > 0.0 && value.is_finite();
    for (joint, l) in limits.iter().enumerate() {
        for (quantity, value) in
            [("velocity", l.velocity), ("acceleration", l.acceleration), ("jerk", l.jerk)]
        {
            if !is_positive(value) {
                return Err(JointMoveError::Limit { joint, quantity, value });
            }
        }
    }
    if !(is_positive(share) && share <= 1.0) {
        return Err(JointMoveError::Share { share });
    }
    match duration {
        Some(duration) if !is_positive(duration) => Err(JointMoveError::Duration { duration }),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use graspcheck_motion::ContinuityClass;
    use proptest::prelude::*;

    use super::*;

    fn limits(velocity: f64, acceleration: f64, jerk: f64) -> JointLimits {
        JointLimits { position_min: -1e9, position_max: 1e9, velocity, acceleration, jerk, effort: 1.0 }
    }

    fn scara() -> [JointLimits; 4] {
        [
            limits(7.5, 60.0, 3000.0),
            limits(10.0, 100.0, 5000.0),
            limits(1.0, 15.0, 1000.0),
            limits(20.0, 200.0, 15_000.0),
        ]
    }

    /// The largest share of a limit that a motion uses, and the order of the derivative that does.
    fn utilisation(motion: &Trajectory, limits: &[JointLimits]) -> (f64, usize) {
        let mut worst = (0.0, 0);
        for (joint, l) in limits.iter().enumerate() {
            for (order, limit) in [(1, l.velocity), (2, l.acceleration), (3, l.jerk)] {
                let used = motion.peak(joint, order).value.abs() / limit;
                if used > worst.0 {
                    worst = (used, order);
                }
            }
        }
        worst
    }

    #[test]
    fn joints_share_one_law() {
        // Section 3 of the worked examples: (V, A) = (0.6, 10) and (10, 1), both 1 rad. With a jerk limit
        // that hardly matters the S-curve comes near the trapezoid's 2.2667 s.
        let limits = [limits(0.6, 10.0, 1e6), limits(10.0, 1.0, 1e6)];
        let motion = joint_move(&[0.0, 5.0], &[1.0, 4.0], &limits, 1.0, None).unwrap();
        assert!((motion.duration() - (1.0 / 0.6 + 0.6)).abs() < 1e-5, "{}", motion.duration());
        // Straight: the second joint mirrors the first at every instant.
        for i in 0..=100 {
            let state = motion.eval(motion.duration() * f64::from(i) / 100.0);
            assert!((state.q[0] - (5.0 - state.q[1])).abs() < 1e-14);
            assert!((state.qddd[0] + state.qddd[1]).abs() < 1e-6);
        }
    }

    #[test]
    fn a_share_slows_the_move() {
        let full = joint_move(&[0.0], &[1.0], &[limits(1.0, 2.0, 10.0)], 1.0, None).unwrap();
        assert!((full.duration() - 1.7).abs() < 1e-12);
        let half = joint_move(&[0.0], &[1.0], &[limits(1.0, 2.0, 10.0)], 0.5, None).unwrap();
        assert!((half.peak(0, 1).value - 0.5).abs() < 1e-12);
        assert!(half.duration() > full.duration());
    }

    #[test]
    fn a_duration_is_exact_and_may_exceed_limits() {
        let limits = scara();
        let to = [1.0, -0.5, -0.1, 2.0];
        let free = joint_move(&[0.0; 4], &to, &limits, 1.0, None).unwrap();
        let half = 0.5 * free.duration();
        let hurried = joint_move(&[0.0; 4], &to, &limits, 1.0, Some(half)).unwrap();
        assert_eq!(hurried.duration().to_bits(), half.to_bits());
        for (order, factor) in [(1, 2.0), (2, 4.0), (3, 8.0)] {
            let ratio = hurried.peak(0, order).value / free.peak(0, order).value;
            assert!((ratio - factor).abs() < 1e-9, "order {order}: {ratio}");
        }
        assert!(utilisation(&hurried, &limits).0 > 1.5);
    }

    #[test]
    fn no_move_is_a_rest() {
        let motion = joint_move(&[0.3, -2.0], &[0.3, -2.0], &[limits(1.0, 1.0, 1.0); 2], 1.0, None).unwrap();
        assert!(motion.duration() > 0.0);
        assert_eq!(motion.eval(0.5 * motion.duration()).q, [0.3, -2.0]);
        let rest = joint_move(&[0.3], &[0.3], &[limits(1.0, 1.0, 1.0)], 1.0, Some(0.7)).unwrap();
        assert!((rest.duration() - 0.7).abs() < 1e-15 && rest.peak(0, 1).value.abs() < 1e-300);
    }

    #[test]
    fn tiny_moves_work_and_can_follow_a_long_motion() {
        let limits = scara();
        let long = Trajectory::hold(&[0.0; 4], 3600.0).unwrap();
        for size in [1e-12, 1e-15, 1e-30, 1e-300, 5e-324] {
            let to = [size, -0.3 * size, 0.0, 2.0 * size];
            let motion = joint_move(&[0.0; 4], &to, &limits, 1.0, None).unwrap();
            assert!(motion.breaks().is_empty());
            assert!(utilisation(&motion, &limits).0 <= 1.0 + 1e-9);
            let end = motion.eval(motion.duration()).q;
            assert!(end.iter().zip(to).all(|(a, b)| (a - b).abs() <= 1e-12 * size), "{end:?} is not {to:?}");
            assert!(long.then(&motion).unwrap().breaks().is_empty());
        }
    }

    #[test]
    fn bad_input_is_an_error_that_names_the_joint() {
        let one = [limits(1.0, 1.0, 1.0)];
        let of = |from: f64, to: f64, share: f64, duration: Option<f64>| {
            joint_move(&[from], &[to], &one, share, duration).unwrap_err()
        };
        assert!(matches!(of(f64::NAN, 0.0, 1.0, None), JointMoveError::NotFinite { joint: 0, .. }));
        assert!(matches!(of(-1e308, 1e308, 1.0, None), JointMoveError::NotFinite { .. }));
        assert_eq!(of(0.0, 1.0, 1.5, None), JointMoveError::Share { share: 1.5 });
        assert!(matches!(of(0.0, 1.0, f64::NAN, None), JointMoveError::Share { .. }));
        assert_eq!(of(0.0, 1.0, 1.0, Some(0.0)), JointMoveError::Duration { duration: 0.0 });
        assert_eq!(
            joint_move(&[0.0; 2], &[1.0; 2], &[one[0], limits(1.0, -2.0, 1.0)], 1.0, None),
            Err(JointMoveError::Limit { joint: 1, quantity: "acceleration", value: -2.0 })
        );
        assert_eq!(
            joint_move(&[0.0], &[1.0, 2.0], &one, 1.0, None),
            Err(JointMoveError::JointCount { from: 1, to: 2, limits: 1 })
        );
        assert!(matches!(joint_move(&[], &[], &[], 1.0, None), Err(JointMoveError::Trajectory(_))));
    }

    proptest! {
        #[test]
        fn moves_keep_the_limits_reach_one_and_arrive(
            from in prop::array::uniform4(-3.0..3.0_f64),
            to in prop::array::uniform4(-3.0..3.0_f64),
            log_size in -6.0..0.0_f64,
            share in 0.05..1.0_f64,
        ) {
            let size = 10.0_f64.powf(log_size);
            let to: [f64; 4] = std::array::from_fn(|j| from[j] + size * (to[j] - from[j]));
            let limits = scara();
            let motion = joint_move(&from, &to, &limits, share, None).unwrap();
            prop_assert_eq!(motion.continuity().class, ContinuityClass::C2);
            let (used, _) = utilisation(&motion, &limits);
            prop_assert!((used / share - 1.0).abs() < 1e-9, "uses {used} of {share}");
            let (start, end) = (motion.eval(0.0), motion.eval(motion.duration()));
            for joint in 0..4 {
                prop_assert!((start.q[joint] - from[joint]).abs() < 1e-15);
                prop_assert!((end.q[joint] - to[joint]).abs() < 1e-14);
                prop_assert!(end.qd[joint].abs() < 1e-12 && end.qdd[joint].abs() < 1e-9);
                // Monotone: a straight move does not overshoot.
                let [low, high] = motion.position_range(joint, 0.0, motion.duration());
                prop_assert!(low >= from[joint].min(to[joint]) - 1e-14);
                prop_assert!(high <= from[joint].max(to[joint]) + 1e-14);
            }
        }
    }
}
