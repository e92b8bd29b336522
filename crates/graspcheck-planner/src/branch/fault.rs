//! Why a branch of the inverse kinematics cannot be followed along a path.

use graspcheck_model::{inverse::Unreachable, plan::NoMotion, task::Elbow};

use crate::error::elbow_word;

/// Where along a path a branch cannot be followed, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct Located {
    /// The place: the path parameter s (0 to 1 along a path of the tool), the time of a timed motion, s.
    pub at: f64,
    /// What is wrong there.
    pub fault: BranchFault,
}

impl Located {
    /// The same fault of a path with places 0 to 1, as whoever follows it from the other end counts places.
    pub(crate) fn seen_from_other_end(self) -> Self {
        match self.fault {
            BranchFault::OutOfReach { until, bound } => {
                Self { at: 1.0 - until, fault: BranchFault::OutOfReach { until: 1.0 - self.at, bound } }
            }
            // Seen from there the end is where the path begins.
            BranchFault::OtherBranch { joint, value, limit, .. } => {
                let excess = (value - limit).abs();
                Self {
                    at: 1.0 - self.at,
                    fault: BranchFault::Limit { joint, value, limit, excess, hole: None },
                }
            }
            fault => Self { at: 1.0 - self.at, fault },
        }
    }
}

/// What following a path asks of the joints at a place.
#[derive(Clone, Debug, PartialEq)]
pub struct Demand {
    /// Name of the joint that moves most, in share of its velocity limit.
    pub fastest: String,
    /// How much it moves for each metre of the wrist's way, rad or m; positive.
    pub slope: f64,
    /// The speed of the wrist at which that joint meets its velocity limit, m/s.
    pub speed: f64,
    /// The largest second derivative of a joint by the wrist's way, rad/m² or 1/m; positive.
    pub bend: f64,
}

/// Why a branch of the inverse kinematics cannot be followed along a path.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BranchFault {
    /// The path leaves the workspace.
    #[error(
        "the tool is out of reach up to {until:.4}: {bound}; move the path, or go around by a joint move"
    )]
    OutOfReach {
        /// Where the path is in reach again, or its end.
        until: f64,
        /// The bound that is exceeded, where it is exceeded most.
        bound: Unreachable,
    },
    /// A joint meets a position limit.
    #[error(
        "joint {joint}: the path asks for {value:.6}, beyond {limit:.6} by {excess:.6}{}; use another branch \
         or turn, or shorten the path", hole_sentence(*.hole)
    )]
    Limit {
        /// Name of the joint.
        joint: String,
        /// The farthest that the path asks for, rad or m.
        value: f64,
        /// The limit, rad or m.
        limit: f64,
        /// How far beyond, rad or m.
        excess: f64,
        /// For the elbow: the radius of the hole (or the outer reach) that this limit leaves around axis 1, m.
        hole: Option<f64>,
    },
    /// The end of the path is reachable, but not on the branch on which the path begins.
    #[error(
        "joint {joint}: the path asks for {value:.6}, beyond {limit:.6}, while its end can be reached on elbow \
         {} in {}; no continuous joint motion follows the path, use a joint move",
        elbow_word(*.elbow), turn_word(*.same_elbow)
    )]
    OtherBranch {
        /// Name of the joint whose limit ends the branch.
        joint: String,
        /// The farthest that the path asks for, rad or m.
        value: f64,
        /// The limit, rad or m.
        limit: f64,
        /// The branch on which the end of the path can be reached.
        elbow: Elbow,
        /// Whether that is the branch on which the path begins, in another turn of a joint.
        same_elbow: bool,
    },
    /// The path comes too near to a singularity.
    #[error(
        "|sin elbow| {sine:.4} below {least:.4}: the arm is nearly straight or folded; joint {} would turn \
         {:.3} rad/m of the wrist's way (its limit at {:.3} m/s) and bend by {:.3} rad/m²; move the path, or use \
         a joint move", .demand.fastest, .demand.slope, .demand.speed, .demand.bend
    )]
    NearSingular {
        /// The least |sin elbow| on the path.
        sine: f64,
        /// [`SINE_MIN`](super::SINE_MIN).
        least: f64,
        /// What the joints would have to do there.
        demand: Demand,
    },
    /// The path touches the singular circle, where the branches meet.
    #[error(
        "the arm is straight or folded in this one place and goes on on the other elbow branch, the elbow \
         turning {slope:.6} rad/m; move the path away from the singular circle, or use a joint move"
    )]
    BranchChange {
        /// How fast the elbow passes the singularity, rad for each metre of the wrist's way; positive.
        slope: f64,
    },
    /// Quintic pieces do not come near enough to the path.
    #[error(
        "pieces of {length:.3e} s still leave the path by {deviation:.3e} (m, rad or a share of a peak), more \
         than {tolerance:.3e}; raise the tolerance or smooth the path"
    )]
    NotConverging {
        /// Length of the shortest piece, s.
        length: f64,
        /// Its deviation: m, rad, or that of a derivative.
        deviation: f64,
        /// What is allowed.
        tolerance: f64,
    },
}

impl BranchFault {
    /// Which of the ways to fail of section 7 of the worked examples this is; none where only the fit does not
    /// converge.
    #[must_use]
    pub fn no_motion(&self) -> Option<NoMotion> {
        match self {
            Self::OutOfReach { .. } | Self::Limit { .. } => Some(NoMotion::Unreachable),
            Self::NearSingular { .. } => Some(NoMotion::NearSingular),
            Self::OtherBranch { .. } => Some(NoMotion::Branch),
            Self::BranchChange { .. } => Some(NoMotion::BranchChange),
            Self::NotConverging { .. } => None,
        }
    }
}

/// The hole that an elbow's limit leaves, as part of a message.
fn hole_sentence(hole: Option<f64>) -> String {
    hole.map_or_else(String::new, |radius| {
        format!(" (the limit keeps the wrist at {radius:.6} m from axis 1, whatever the other joints do)")
    })
}

/// `the same turn`, as a message needs it.
fn turn_word(same_elbow: bool) -> &'static str {
    if same_elbow { "another turn" } else { "some turn" }
}
