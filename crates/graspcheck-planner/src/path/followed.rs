//! A path of the tool as one of the joints: on one branch, in the nearest turns, with three derivatives.
//!
//! ```
//! use graspcheck_model::example;
//! use graspcheck_planner::path::{FollowedPath, Path, line::straight_line};
//! use nalgebra::Isometry3;
//!
//! let (robot, from) = (example::scara(), [0.3, 1.0, -0.2, 2.0]);
//! let start = robot.world_from_tool(&from);
//! let line = straight_line(&start, &(Isometry3::translation(-0.03, 0.05, 0.0) * start))?;
//! let path = FollowedPath::new(&robot, &line, &from)?;
//! // Half way the tool is half way, and the slopes of the joints carry it on along the line.
//! let middle = path.eval(0.5);
//! let tool = robot.world_from_tool(&middle.q).translation.vector;
//! assert!((tool - start.translation.vector - nalgebra::Vector3::new(-0.015, 0.025, 0.0)).norm() < 1e-12);
//! let next: Vec<f64> = middle.q.iter().zip(&middle.q_s).map(|(q, slope)| q + 1e-6 * slope).collect();
//! let moved = robot.world_from_tool(&next).translation.vector - tool;
//! assert!((moved / 1e-6 - nalgebra::Vector3::new(-0.03, 0.05, 0.0)).norm() < 1e-6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use graspcheck_model::{
    inverse::Unreachable, planar_path::PlanarPath, robot::RobotModel, tool_path::ToolPath,
};
use graspcheck_motion::Jet;

use super::{Path, PathPoint};
use crate::{
    arm::Arm,
    branch::{Branch, BranchFault, Located, Tracker},
};

/// Why a path of the tool cannot be followed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FollowError {
    /// A place at which the branch ends.
    #[error("path at s = {at:.6}: {fault}")]
    Branch {
        /// The path parameter.
        at: f64,
        /// Why.
        fault: BranchFault,
    },
    /// The arm has no closed-form inverse kinematics.
    #[error("path: {0}")]
    NoInverse(#[from] Unreachable),
    /// Joint positions for another arm.
    #[error("path: {count} joint positions for an arm of {dof} joints; give one for each joint")]
    JointCount {
        /// How many there are.
        count: usize,
        /// How many the arm has.
        dof: usize,
    },
    /// The joint positions do not put the tool where the path begins.
    #[error(
        "path: the joint positions put the tool {distance:.3e} m and {angle:.3e} rad from where it begins; start \
         from a solution of the inverse kinematics there"
    )]
    NotAtStart {
        /// m.
        distance: f64,
        /// rad.
        angle: f64,
    },
}

impl From<Located> for FollowError {
    fn from(Located { at, fault }: Located) -> Self {
        Self::Branch { at, fault }
    }
}

/// How far the tool may be from the beginning of a path at the joint positions with which it is followed, m and
/// rad: what poses and solutions of them are rounded by.
const START_TOLERANCE: f64 = 1e-8;

/// A path of the tool, followed on one branch of the inverse kinematics.
#[derive(Clone, Debug)]
pub struct FollowedPath {
    pub(crate) planar: PlanarPath,
    pub(crate) branch: Branch,
}

impl FollowedPath {
    /// Follows a path of the tool on the branch of `from`, joint positions (rad or m) at its beginning.
    ///
    /// # Errors
    /// The first place at which the branch cannot be followed and why, or what is wrong with `from`.
    pub fn new(robot: &RobotModel, path: &ToolPath, from: &[f64]) -> Result<Self, FollowError> {
        Self::of_arm(&Arm::new(robot)?, path, from)
    }

    /// As [`FollowedPath::new`], for an arm that is measured already.
    pub(crate) fn of_arm(arm: &Arm, path: &ToolPath, from: &[f64]) -> Result<Self, FollowError> {
        if from.len() != arm.robot.dof() {
            return Err(FollowError::JointCount { count: from.len(), dof: arm.robot.dof() });
        }
        let (here, start) = (arm.robot.world_from_tool(from), path.pose(path.start()));
        let distance = (here.translation.vector - start.translation.vector).norm();
        let angle = here.rotation.angle_to(&start.rotation);
        // NaN is not at the start either.
        let is_at_start = distance <= START_TOLERANCE && angle <= START_TOLERANCE;
        if !is_at_start {
            return Err(FollowError::NotAtStart { distance, angle });
        }
        let planar = PlanarPath::new(arm.robot, path).map_err(|(at, bound)| Located {
            at,
            fault: BranchFault::OutOfReach { until: path.end(), bound },
        })?;
        let branch = Tracker::new(arm, &planar).follow(from)?;
        Ok(Self { planar, branch })
    }

    /// Joint positions at the end of the path, rad or m.
    #[must_use]
    pub fn end(&self) -> &[f64] {
        &self.branch.end()[..self.planar.dof()]
    }

    /// The joints at a place with derivatives, by the formula of a segment.
    pub(crate) fn joints<const N: usize>(
        &self,
        segment: usize,
        s: Jet<f64, N>,
    ) -> [Jet<f64, N>; graspcheck_model::planar_path::PLANAR_JOINTS] {
        self.branch.joints(&self.planar, segment, s).expect("every place of a followed path is in reach")
    }
}

impl Path for FollowedPath {
    fn dof(&self) -> usize {
        self.planar.dof()
    }

    fn range(&self) -> [f64; 2] {
        [self.planar.start(), self.planar.end()]
    }

    fn eval(&self, s: f64) -> PathPoint {
        let [start, end] = self.range();
        assert!((start..=end).contains(&s), "s = {s} is outside the path, which runs from {start} to {end}");
        let joints = self.joints(self.planar.segment_at(s), Jet::<f64, 4>::variable(s));
        let of_order = |order: usize| joints[..self.dof()].iter().map(|q| q.derivatives()[order]).collect();
        PathPoint { q: of_order(0), q_s: of_order(1), q_ss: of_order(2), q_sss: of_order(3) }
    }
}
