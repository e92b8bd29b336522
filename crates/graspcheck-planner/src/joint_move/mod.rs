//! Moves in joint space from rest to rest (field word: PTP).
//!
//! Joints share either one law of time or only its end:
//!
//! - **Straight** ([`Sync::Straight`], field words: synchronised, phase synchronisation). One law, so that the
//!   path `q(s) = q₀ + (q₁ - q₀) s` is straight whatever the limits are. With s from 0 to 1 the limits of the
//!   joints limit the law to `V_s = min V_j/D_j`, and alike for acceleration and jerk, D_j being the distance of
//!   joint j. It can take longer than any joint would alone.
//! - **End times** ([`Sync::EndTimes`], field word: time synchronisation). Each joint has its own law; the slowest
//!   sets the duration T, and the laws of the others are stretched to exactly T. The path is not straight.
//!
//! With (V, A) = (0.6, 10) and (10, 1) and 1 rad for both, trapezoids take 1.7267 s and 2 s alone, 2 s with
//! matched end times, and 2.2667 s on the straight path (worked examples, section 3).

use graspcheck_model::{
    robot::JointLimits,
    task::{Sync, TimeLaw},
};
use graspcheck_motion::{Polynomial, Trajectory};

use crate::{
    joint_law::{JointLaw, together},
    time_scaling::{ScalingError, TimeScaling},
};

mod error;

pub use error::JointMoveError;

/// The least duration of a move that is given none, s: shorter ones, also those of length zero, are stretched to
/// it, so that they use less than their limits.
///
/// The reason: floats near 1000 s lie 1e-13 s apart, and the seven phases of a move must stay apart when
/// motions are joined. No control cycle is as short.
pub const SHORTEST_MOVE: f64 = 1e-6;

/// How fast a move goes, and by which law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pacing {
    /// Share of the limits that is used, 0 < share ≤ 1.
    pub share: f64,
    /// Exact duration, s: the same law stretched or compressed in time, also where that exceeds limits. Without
    /// one the move takes the least time.
    pub duration: Option<f64>,
    /// How position follows time.
    pub law: TimeLaw,
    /// What the joints have in common.
    pub sync: Sync,
}

impl Default for Pacing {
    /// The fastest S-curve along the straight line under the full limits.
    fn default() -> Self {
        Self { share: 1.0, duration: None, law: TimeLaw::default(), sync: Sync::default() }
    }
}

/// The straight move in joint space from rest at `from` to rest at `to`, rad or m, by an S-curve.
///
/// Without a `duration` it takes the least time under `share` of the velocity, acceleration and jerk limits
/// of every joint. With a `duration`, s, it is the same law in exactly this time, also where that exceeds
/// limits: it is for the checks to say so. Position limits are not looked at.
///
/// A move of length zero is a rest, as is one below the smallest normal float (2e-308). Moves shorter than
/// [`SHORTEST_MOVE`] are stretched to it unless a duration is asked for.
///
/// ```
/// use graspcheck_model::robot::JointLimits;
/// let limits = JointLimits {
///     position_min: -9.0, position_max: 9.0, velocity: 1.0, acceleration: 2.0, jerk: 10.0, effort: 1.0,
/// };
/// let motion = graspcheck_planner::joint_move(&[0.0], &[1.0], &[limits], 1.0, None)?;
/// assert!((motion.duration() - 1.7).abs() < 1e-12); // D/V + V/A + A/J
/// # Ok::<(), graspcheck_planner::joint_move::JointMoveError>(())
/// ```
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
    joint_move_by(from, to, limits, Pacing { share, duration, ..Pacing::default() })
}

/// As [`joint_move`], by any law of time and with the joints synchronised as asked.
///
/// A cubic keeps the jerk limit inside, a trapezoid knows none: the acceleration of both jumps.
///
/// ```
/// use graspcheck_model::{robot::JointLimits, task::{Sync, TimeLaw}};
/// use graspcheck_planner::joint_move::{Pacing, joint_move_by};
///
/// let limits = [(0.6, 10.0), (10.0, 1.0)].map(|(velocity, acceleration)| JointLimits {
///     position_min: -9.0, position_max: 9.0, velocity, acceleration, jerk: 100.0, effort: 1.0,
/// });
/// let duration = |sync| {
///     let pacing = Pacing { law: TimeLaw::Trapezoid, sync, ..Pacing::default() };
///     joint_move_by(&[0.0, 0.0], &[1.0, 1.0], &limits, pacing).map(|motion| motion.duration())
/// };
/// assert!((duration(Sync::Straight)? - 34.0 / 15.0).abs() < 1e-12);
/// assert!((duration(Sync::EndTimes)? - 2.0).abs() < 1e-12);
/// # Ok::<(), graspcheck_planner::joint_move::JointMoveError>(())
/// ```
///
/// # Errors
/// As [`joint_move`].
pub fn joint_move_by(
    from: &[f64],
    to: &[f64],
    limits: &[JointLimits],
    pacing: Pacing,
) -> Result<Trajectory, JointMoveError> {
    check(from, to, limits, pacing)?;
    let longest = from.iter().zip(to).fold(0.0, |longest: f64, (a, b)| longest.max((b - a).abs()));
    if longest < f64::MIN_POSITIVE {
        return Ok(Trajectory::hold(to, pacing.duration.unwrap_or(SHORTEST_MOVE))?);
    }
    match pacing.sync {
        Sync::Straight => straight(from, to, limits, longest, pacing),
        Sync::EndTimes => with_matched_ends(from, to, limits, pacing),
    }
}

/// One law for all joints. It runs over the longest distance of a joint rather than over 1, so that tiny moves
/// are as well scaled as large ones.
fn straight(
    from: &[f64],
    to: &[f64],
    limits: &[JointLimits],
    longest: f64,
    Pacing { share, duration, law, .. }: Pacing,
) -> Result<Trajectory, JointMoveError> {
    let mut shared = [f64::INFINITY; 3];
    for ((a, b), limits) in from.iter().zip(to).zip(limits) {
        // Infinity for a joint that does not move: no limit.
        let scale = share * (longest / (b - a).abs());
        let own = [limits.velocity, limits.acceleration, limits.jerk];
        shared = std::array::from_fn(|order| shared[order].min(scale * own[order]));
    }
    let mut scaling = scaling(law, longest, shared)?;
    if duration.is_some() || scaling.duration() < SHORTEST_MOVE {
        scaling = scaling.stretched_to(duration.unwrap_or(SHORTEST_MOVE))?;
    }
    along_straight_line(from, to, &scaling)
}

/// Each joint by its own law, all in the time of the slowest.
fn with_matched_ends(
    from: &[f64],
    to: &[f64],
    limits: &[JointLimits],
    Pacing { share, duration, law, .. }: Pacing,
) -> Result<Trajectory, JointMoveError> {
    let mut slowest = SHORTEST_MOVE;
    let mut scalings = Vec::with_capacity(from.len());
    for ((a, b), limits) in from.iter().zip(to).zip(limits) {
        let distance = (b - a).abs();
        let own = [limits.velocity, limits.acceleration, limits.jerk].map(|limit| share * limit);
        let scaling = if distance < f64::MIN_POSITIVE { None } else { Some(scaling(law, distance, own)?) };
        slowest = scaling.as_ref().map_or(slowest, |scaling| slowest.max(scaling.duration()));
        scalings.push(scaling);
    }
    let duration = duration.unwrap_or(slowest);
    let mut laws = Vec::with_capacity(from.len());
    for ((&from, &to), scaling) in from.iter().zip(to).zip(&scalings) {
        laws.push(match scaling {
            Some(scaling) => JointLaw::along(from, to, &scaling.stretched_to(duration)?)?,
            None => JointLaw::rest(to, duration)?,
        });
    }
    Ok(together(&laws)?)
}

/// The fastest law of a kind over a distance, under limits on velocity, acceleration and jerk.
///
/// # Errors
/// When a number is not positive and finite, or a coefficient overflows.
pub(crate) fn scaling(
    law: TimeLaw,
    distance: f64,
    [velocity, acceleration, jerk]: [f64; 3],
) -> Result<TimeScaling, ScalingError> {
    match law {
        TimeLaw::SCurve => TimeScaling::s_curve(distance, velocity, acceleration, jerk),
        TimeLaw::Quintic => TimeScaling::quintic(distance, velocity, acceleration, jerk),
        TimeLaw::Cubic => TimeScaling::cubic(distance, velocity, acceleration, jerk),
        TimeLaw::Trapezoid => TimeScaling::trapezoid(distance, velocity, acceleration),
    }
}

/// The law composed with the straight line, exactly: `q = q₀ + r s`, with the ratio r of a joint's distance
/// to the distance of the law.
fn along_straight_line(from: &[f64], to: &[f64], law: &TimeScaling) -> Result<Trajectory, JointMoveError> {
    let pieces = law.pieces_in_place();
    let ratios: Vec<f64> = from.iter().zip(to).map(|(from, to)| (to - from) / law.distance()).collect();
    let mut knots = Vec::with_capacity(pieces.starts().len() + 1);
    let mut polynomials = Vec::with_capacity(pieces.starts().len() * from.len());
    for (start, s) in pieces.iter() {
        knots.push(start);
        let s_start = s.coefficients()[0];
        for ((&from, &to), &ratio) in from.iter().zip(to).zip(&ratios) {
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
    knots.push(law.duration());
    Ok(Trajectory::new(from.len(), knots, polynomials)?)
}

fn check(
    from: &[f64],
    to: &[f64],
    limits: &[JointLimits],
    Pacing { share, duration, .. }: Pacing,
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
