//! Laws of several joints as one motion.

use graspcheck_motion::{Trajectory, TrajectoryError};

use super::JointLaw;

/// Knots of two joints that are this share of the duration apart, or less, are one knot: they differ by rounding.
const SAME_KNOT: f64 = 16.0 * f64::EPSILON;

/// Why laws do not make one motion.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TogetherError {
    /// A law begins or lasts other than the first.
    #[error(
        "joint {joint}: its law from {start} s for {duration} s must be from {first_start} s for {first_duration} s, as that of joint 0"
    )]
    OtherTimes {
        /// Index of the joint.
        joint: usize,
        /// When its law begins, s.
        start: f64,
        /// How long its law lasts, s.
        duration: f64,
        /// When that of joint 0 begins, s.
        first_start: f64,
        /// How long that of joint 0 lasts, s.
        first_duration: f64,
    },
    /// There is no joint, or the duration is 0.
    #[error(transparent)]
    Trajectory(#[from] TrajectoryError),
}

/// The motion in which each joint follows its law. All laws begin and end together; the motion begins at 0.
///
/// Where a joint has no knot of its own its polynomial is carried on to the next one, exactly but for rounding.
///
/// ```
/// use graspcheck_planner::joint_law::{JointLaw, together};
/// let laws = [
///     JointLaw::cubic([0.0, 0.0], [1.0, 0.0], 2.0)?,
///     JointLaw::quintic([3.0, 0.0, 0.0], [-1.0, 0.5, 0.0], 2.0)?,
/// ];
/// let motion = together(&laws)?;
/// assert_eq!((motion.dof(), motion.duration(), motion.eval(1.0).q[0]), (2, 2.0, 0.5));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// When a law begins or lasts other than the first, there is none, or their duration is 0.
pub fn together(laws: &[JointLaw]) -> Result<Trajectory, TogetherError> {
    let Some(first) = laws.first() else { return Err(TrajectoryError::NoJoint.into()) };
    for (joint, law) in laws.iter().enumerate() {
        let same = |a: f64, b: f64| a.to_bits() == b.to_bits();
        if !same(law.start_time, first.start_time) || !same(law.duration, first.duration) {
            return Err(TogetherError::OtherTimes {
                joint,
                start: law.start_time,
                duration: law.duration,
                first_start: first.start_time,
                first_duration: first.duration,
            });
        }
    }
    let same_knot = SAME_KNOT * first.duration;
    // Where each law is: the index of its piece.
    let mut at = vec![0; laws.len()];
    let most = laws.iter().map(|law| law.pieces_in_place().starts().len()).sum::<usize>();
    let mut knots = Vec::with_capacity(most + 1);
    let mut pieces = Vec::with_capacity(most * laws.len());
    let mut start = 0.0;
    while start < f64::INFINITY {
        knots.push(start);
        let mut next = f64::INFINITY;
        for (law, at) in laws.iter().zip(&mut at) {
            let law = law.pieces_in_place();
            // A knot that is merged with this one may lie a little later.
            while law.next_start(*at) <= start + same_knot {
                *at += 1;
            }
            next = next.min(law.next_start(*at));
            let into = start - law.starts()[*at];
            law.push_from(*at, if into <= same_knot { 0.0 } else { into }, &mut pieces);
        }
        start = next;
    }
    knots.push(first.duration);
    Ok(Trajectory::new(laws.len(), knots, pieces)?)
}
