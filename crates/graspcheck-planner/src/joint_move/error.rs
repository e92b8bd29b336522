//! Why there is no joint move.

use graspcheck_motion::TrajectoryError;

use crate::{joint_law::TogetherError, time_scaling::ScalingError};

/// Why there is no move.
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
    /// The laws of the joints do not make a motion.
    #[error(transparent)]
    Together(#[from] TogetherError),
    /// The pieces do not make a motion.
    #[error(transparent)]
    Trajectory(#[from] TrajectoryError),
}
