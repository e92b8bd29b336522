//! The ways to grasp and place an object that planning looked at, and what became of each.

use graspcheck_model::{
    inverse::{Reach, Unreachable},
    task::Elbow,
};
use nalgebra::Vector3;

use crate::branch::BranchFault;

/// How far planning got with a candidate: the part of the motion that it failed at, in the order in which
/// they are tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// The grasp pose.
    Grasp,
    /// The straight move from the pre-grasp pose to the grasp pose.
    Descend,
    /// The straight move with the object away from where it stood.
    Lift,
    /// The pose that puts the object in its place.
    Place,
    /// The straight move to that pose.
    Lower,
    /// The straight move away from the placed object.
    Retreat,
    /// Everything can be reached: only time and clearance decide.
    Complete,
}

impl std::fmt::Display for Stage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Grasp => "grasp",
            Self::Descend => "descend",
            Self::Lift => "lift",
            Self::Place => "place",
            Self::Lower => "lower",
            Self::Retreat => "retreat",
            Self::Complete => "complete",
        })
    }
}

/// One solution of the inverse kinematics.
#[derive(Clone, Debug, PartialEq)]
pub struct BranchChoice {
    /// The branch of the elbow.
    pub elbow: Elbow,
    /// Whole turns of the last joint away from (−π, π].
    pub turn: i32,
    /// Joint positions, rad or m.
    pub q: Vec<f64>,
}

/// One way to grasp and place, and what became of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Name of the handle.
    pub handle: String,
    /// Whether the gripper is turned by half a turn about the handle's x axis.
    pub half_turn: bool,
    /// How the grasp pose is reached; none when it is not, or when the candidate failed at the place.
    pub grasp: Option<BranchChoice>,
    /// How the place pose is reached; none when it is not, or when the candidate failed before.
    pub place: Option<BranchChoice>,
    /// How far planning got.
    pub stage: Stage,
    /// Time that the arm moves, without closing and opening, s; none unless complete.
    pub moving: Option<f64>,
    /// What became of it.
    pub outcome: CandidateOutcome,
}

/// What became of a candidate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CandidateOutcome {
    /// It is the plan.
    #[error("chosen")]
    Chosen,
    /// It was not needed.
    #[error("{by:.3} s slower than the chosen one")]
    Slower {
        /// By how much longer the arm moves, s; zero up to rounding where both take the same time.
        by: f64,
    },
    /// It is proved to come too near somewhere.
    #[error("{a} - {b}: {distance:.4} m below {required:.4} m at t = {time:.3} s, {phase}")]
    TooNear {
        /// Name of one body.
        a: String,
        /// Name of the other.
        b: String,
        /// Their distance at that instant, m; negative when they overlap.
        distance: f64,
        /// What is required, m.
        required: f64,
        /// When, s; not the first nor the worst instant.
        time: f64,
        /// Name of the phase.
        phase: String,
    },
    /// Its clearance is neither proved nor refuted: the distance of a pair is too near to the required one.
    #[error("{a} - {b}: clearance neither proved nor refuted")]
    Undecided {
        /// Name of one body.
        a: String,
        /// Name of the other.
        b: String,
    },
    /// No joint positions reach the pose, whatever the limits.
    #[error("{0}")]
    OutOfReach(#[from] Unreachable),
    /// The pose breaks a position limit.
    #[error("joint {joint}: position {value:.6} exceeds {limit:.6} by {excess:.6}")]
    Limit {
        /// Name of the joint.
        joint: String,
        /// Its position, rad or m.
        value: f64,
        /// The limit, rad or m.
        limit: f64,
        /// By how much, rad or m; positive.
        excess: f64,
    },
    /// The straight move cannot be followed on this branch.
    #[error("at s = {at:.4}: {fault}")]
    Line {
        /// Path parameter from 0 to 1.
        at: f64,
        /// What is wrong there.
        fault: BranchFault,
    },
}

impl CandidateOutcome {
    /// Whether the motion cannot be made at all: a pose or a straight move is out of reach or beyond a limit.
    #[must_use]
    pub fn is_unreachable(&self) -> bool {
        matches!(self, Self::OutOfReach(_) | Self::Limit { .. } | Self::Line { .. })
    }
}

/// Where the wrist would have to be, and where it can be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WristReach {
    /// Whether this is about the place rather than the grasp.
    pub placing: bool,
    /// Distance of the wrist from axis 1, m.
    pub distance: f64,
    /// The distances that it can have.
    pub reach: Reach,
    /// The shortest move of the object, world frame, m, that brings the wrist within reach; none when it is
    /// within reach already.
    pub shift: Option<Vector3<f64>>,
}
