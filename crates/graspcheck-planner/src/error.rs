//! Why there is no plan.

use graspcheck_model::{Pose, inverse::Unreachable, plan::NoMotion, task::Elbow};
use graspcheck_motion::TrajectoryError;
use graspcheck_proof::SceneError;

use crate::{
    branch::BranchFault,
    candidate::{Candidate, WristReach},
    cartesian::LineError,
    joint_move::JointMoveError,
    opening::GripError,
    pace::PaceError,
    path::{PathError, followed::FollowError, motion::AlongError},
    via_motion::ViaMotionError,
};

/// Why there is no plan.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// The task moves an object and there is none.
    #[error("task pick_and_place: there is no object; add one to the scenario")]
    NoObject,
    /// The object has no handle.
    #[error("object {object}: has no handle; add one that says where the gripper may hold it")]
    NoHandle {
        /// Name of the object.
        object: String,
    },
    /// Joint positions are given for another number of joints.
    #[error("{place}: {count} joint positions for an arm of {dof} joints")]
    JointCount {
        /// What gives them, e.g. `start`.
        place: String,
        /// How many there are.
        count: usize,
        /// How many the arm has.
        dof: usize,
    },
    /// A number of the task is not finite, or has the wrong sign.
    #[error("{place}: {value} must be {must}")]
    BadNumber {
        /// What the number is, with its unit.
        place: String,
        /// The number.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// A task of segments has none.
    #[error("task: there is no segment; add one")]
    NoSegment,
    /// The pace makes no sense.
    #[error("pace: {0}")]
    Pace(#[from] PaceError),
    /// The gripper cannot grasp as asked.
    #[error("gripper: {0}")]
    Grip(#[from] GripError),
    /// The arm has no closed-form inverse kinematics, which the task needs.
    #[error("{0}")]
    NoInverse(Unreachable),
    /// No way to grasp and place the object can be reached.
    #[error("{0}")]
    Unreachable(Box<NothingReachable>),
    /// A joint move cannot be planned.
    #[error("phase {phase}: {error}")]
    JointMove {
        /// Name of the phase.
        phase: String,
        /// Why.
        #[source]
        error: JointMoveError,
    },
    /// A straight line cannot be planned, for a reason that no other candidate would mend.
    #[error("phase {phase}: {error}")]
    Line {
        /// Name of the phase.
        phase: String,
        /// Why.
        #[source]
        error: LineError,
    },
    /// A segment of a path task is no path.
    #[error("phase {phase}: {error}")]
    Path {
        /// Name of the phase.
        phase: String,
        /// Why.
        #[source]
        error: PathError,
    },
    /// There is no motion along a path.
    #[error("phase {phase}: {error}")]
    Along {
        /// Name of the phase.
        phase: String,
        /// Why, and where.
        #[source]
        error: AlongError,
    },
    /// The law of a task's via points does not fit them.
    #[error("task {task}: {error}")]
    ViaMotion {
        /// The task.
        task: &'static str,
        /// Why.
        #[source]
        error: Box<ViaMotionError>,
    },
    /// The arm cannot follow the motion through the via points on the branch that is asked for.
    #[error("task cartesian_via, elbow {}: at t = {at:.6} s: {fault}", elbow_word(*.elbow))]
    Via {
        /// The branch that was asked for.
        elbow: Elbow,
        /// When, s: of all starting turns the one that gets farthest.
        at: f64,
        /// Why.
        fault: BranchFault,
    },
    /// The first via point has no legal joint positions on the branch that is asked for.
    #[error("task cartesian_via, elbow {}: via point 0 at t = 0 s: {reason}", elbow_word(*.elbow))]
    ViaStart {
        /// The branch that was asked for.
        elbow: Elbow,
        /// The limit, its value and the excess.
        reason: BranchFault,
    },
    /// The polynomials are not a trajectory.
    #[error("{0}")]
    Trajectory(#[from] TrajectoryError),
    /// The bodies cannot be built.
    #[error("{0}")]
    Scene(#[from] SceneError),
}

impl PlanError {
    /// Which of the ways in which no motion can exist this is: what a scenario that must fail in planning names. None
    /// for input that makes no sense.
    ///
    /// ```
    /// use graspcheck_model::{plan::NoMotion, task::Elbow};
    /// use graspcheck_planner::{PlanError, branch::BranchFault};
    ///
    /// let fault = BranchFault::BranchChange { slope: 0.3 };
    /// let error = PlanError::Via { elbow: Elbow::Left, at: 1.5, fault };
    /// assert_eq!(error.no_motion(), Some(NoMotion::BranchChange));
    /// assert_eq!(PlanError::NoSegment.no_motion(), None);
    /// ```
    #[must_use]
    pub fn no_motion(&self) -> Option<NoMotion> {
        match self {
            Self::Unreachable(_) => Some(NoMotion::Unreachable),
            Self::Line { error: LineError::Branch { fault, .. }, .. }
            | Self::Along { error: AlongError::Follow(FollowError::Branch { fault, .. }), .. }
            | Self::Via { fault, .. }
            | Self::ViaStart { reason: fault, .. } => fault.no_motion(),
            _ => None,
        }
    }
}

/// `left` or `right`.
pub(crate) fn elbow_word(elbow: Elbow) -> &'static str {
    match elbow {
        Elbow::Left => "left",
        Elbow::Right => "right",
    }
}

/// That no way to grasp and place an object can be reached: all of them, with the reasons.
#[derive(Clone, Debug, PartialEq)]
pub struct NothingReachable {
    /// Name of the object.
    pub object: String,
    /// Where it stands.
    pub world_from_object: Pose,
    /// Where it should be put.
    pub world_from_placed: Pose,
    /// Where the wrist would have to be and where it can be, of the handle that is nearest to reach.
    pub wrist: Option<WristReach>,
    /// All candidates, the nearest miss first.
    pub candidates: Vec<Candidate>,
}

impl std::fmt::Display for NothingReachable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let placing = self.wrist.is_some_and(|wrist| wrist.placing);
        let pose = if placing { &self.world_from_placed } else { &self.world_from_object };
        let at = pose.translation.vector;
        let word = if placing { "placed at" } else { "at" };
        let count = self.candidates.len();
        write!(f, "object {} {word} ({:.4}, {:.4}, {:.4}) m: ", self.object, at.x, at.y, at.z)?;
        write!(f, "none of {count} candidates can be reached")?;
        if let Some(nearest) = self.candidates.first() {
            write!(f, "; nearest: handle {}, {}: {}", nearest.handle, nearest.stage, nearest.outcome)?;
        }
        if let Some(WristReach { distance, reach, shift, .. }) = &self.wrist {
            write!(f, "; the wrist would be {distance:.4} m from axis 1, ")?;
            write!(f, "reachable are {:.4} m to {:.4} m", reach.inner, reach.outer)?;
            if let Some(shift) = shift {
                let to = at + shift;
                write!(f, "; try ({:.4}, {:.4}, {:.4}) m, {:.4} m away", to.x, to.y, to.z, shift.norm())?;
            }
        }
        Ok(())
    }
}
