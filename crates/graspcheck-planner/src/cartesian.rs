//! Straight lines of the tool, from where it is to a pose (LIN).
//!
//! The path is that of [`mod@crate::path::line`], the motion along it that of [`crate::path::motion`]: an S-curve
//! that meets the tightest joint limit, proved to stay within [`PATH_TOLERANCE`] of the line at every instant.

use graspcheck_model::{Pose, robot::RobotModel};

use crate::{
    arm::Arm,
    branch::{BranchFault, Located},
    path::{
        FollowedPath, PathError, ToolPath,
        followed::FollowError,
        line::straight_line,
        motion::{AlongError, PATH_TOLERANCE, PathMotion, along_path},
    },
};

/// Why a straight line of the tool cannot be planned.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LineError {
    /// A branch of the inverse kinematics cannot be followed along the line.
    #[error("line at s = {at:.6}: {fault}")]
    Branch {
        /// Path parameter from 0 to 1.
        at: f64,
        /// What is wrong there.
        fault: BranchFault,
    },
    /// There is no such line.
    #[error("line: {0}")]
    Path(#[from] PathError),
    /// There is no motion along the line.
    #[error("line: {0}")]
    Along(AlongError),
}

impl From<Located> for LineError {
    fn from(Located { at, fault }: Located) -> Self {
        Self::Branch { at, fault }
    }
}

impl From<FollowError> for LineError {
    fn from(error: FollowError) -> Self {
        AlongError::from(error).into()
    }
}

impl From<AlongError> for LineError {
    fn from(error: AlongError) -> Self {
        match error {
            AlongError::Follow(FollowError::Branch { at, fault }) => Self::Branch { at, fault },
            other => Self::Along(other),
        }
    }
}

/// The joint motion, from rest at `from` to rest, in which the tool goes on a straight line from where it
/// is to `world_from_goal`, with the proof that it does.
///
/// `share` of the joints' limits of velocity, acceleration and jerk is used (0 < share ≤ 1), and the tightest
/// of them is met from below to 1e-9. With a `duration` (s) the same motion is stretched or compressed to
/// last exactly that, even past the limits.
///
/// ```
/// use graspcheck_model::example;
/// use nalgebra::Isometry3;
///
/// let (robot, from) = (example::scara(), [-0.5, 1.2, -0.1, 3.0]);
/// let down = Isometry3::translation(0.0, 0.0, -0.05) * robot.world_from_tool(&from);
/// let found = graspcheck_planner::line(&robot, &from, &down, 1.0, None)?;
/// // Straight down is a motion of the quill alone, exactly.
/// let end = found.motion.eval(found.motion.duration());
/// assert!((end.q[2] + 0.15).abs() < 1e-12 && end.q[0] == from[0]);
/// # Ok::<(), graspcheck_planner::cartesian::LineError>(())
/// ```
///
/// # Errors
/// Where and why the branch of `from` cannot be followed; or the arm has no closed-form inverse
/// kinematics; or the limits, the share or the duration are not positive; or the line has no length.
///
/// # Panics
/// When `from` has another length than the arm has joints.
pub fn line(
    robot: &RobotModel,
    from: &[f64],
    world_from_goal: &Pose,
    share: f64,
    duration: Option<f64>,
) -> Result<PathMotion, LineError> {
    line_of(&Arm::new(robot).map_err(FollowError::from)?, from, world_from_goal, share, duration)
        .map(|(_, found)| found)
}

/// As [`line`], for an arm that is measured already; with the path.
pub(crate) fn line_of(
    arm: &Arm,
    from: &[f64],
    world_from_goal: &Pose,
    share: f64,
    duration: Option<f64>,
) -> Result<(ToolPath, PathMotion), LineError> {
    let path = straight_line(&arm.robot.world_from_tool(from), world_from_goal)?;
    let found = along_path(arm, &path, from, share, duration, PATH_TOLERANCE)?;
    Ok((path, found))
}

/// Joint positions at the beginning of the straight line that begins with the tool at `world_from_start`
/// and ends in `to`, on the same branch.
///
/// # Errors
/// Where and why the branch cannot be followed, as seen from the beginning.
pub(crate) fn start_of_line(arm: &Arm, world_from_start: &Pose, to: &[f64]) -> Result<Vec<f64>, LineError> {
    let backwards = straight_line(&arm.robot.world_from_tool(to), world_from_start)?;
    match FollowedPath::of_arm(arm, &backwards, to) {
        Ok(followed) => Ok(followed.end().to_vec()),
        Err(FollowError::Branch { at, fault }) => Err(Located { at, fault }.seen_from_other_end().into()),
        Err(other) => Err(other.into()),
    }
}
