//! From a task to a plan.

use graspcheck_model::{
    cell::Cell,
    object::Object,
    plan::Plan,
    robot::RobotModel,
    task::{Pace, Task},
};
use graspcheck_proof::Certificate;

use crate::{
    candidate::Candidate, cartesian_via, error::PlanError, joint_segments, joint_via, path_task,
    pick_and_place, set_points,
};

/// A plan with what planning found out on the way.
#[derive(Clone, Debug, PartialEq)]
pub struct Planned {
    /// The plan.
    pub plan: Plan,
    /// The certificate of the plan, where planning needed one to choose; it need not be made again.
    pub certificate: Option<Certificate>,
    /// All ways to do the task that were looked at: the chosen one, then those that can be reached from the
    /// fastest to the slowest, then those that cannot. Empty when the task leaves nothing to choose.
    pub candidates: Vec<Candidate>,
}

impl Planned {
    /// The plan of a task that leaves nothing to choose.
    pub(crate) fn without_proof(plan: Plan) -> Self {
        Self { plan, certificate: None, candidates: Vec::new() }
    }
}

/// The plan for a task: what is executed and what is checked.
///
/// A pick is planned on the fastest of its candidates that is proved clear of collision, or on the fastest
/// of all when none is: the checks then say what is too near. Via points are planned at the times that they
/// are given, joint segments as they are given. Where the pace declares set points, the plan is what the
/// controller makes of them. Whether the plan keeps limits is for the checks to say.
///
/// # Errors
/// When the task makes no sense for this robot and object, or cannot be reached: see [`PlanError`].
pub fn plan(
    robot: &RobotModel,
    cell: &Cell,
    object: Option<&Object>,
    task: &Task,
    pace: &Pace,
) -> Result<Plan, PlanError> {
    find(robot, cell, object, task, pace).map(|planned| planned.plan)
}

/// As [`plan`], with the certificate and the candidates.
///
/// # Errors
/// As [`plan`].
pub fn find(
    robot: &RobotModel,
    cell: &Cell,
    object: Option<&Object>,
    task: &Task,
    pace: &Pace,
) -> Result<Planned, PlanError> {
    let planned = match task {
        Task::PickAndPlace(task) => {
            pick_and_place::find(robot, cell, object.ok_or(PlanError::NoObject)?, task, pace)
        }
        Task::CartesianVia(task) => cartesian_via::find(robot, object, task, pace),
        Task::JointVia(task) => joint_via::find(robot, object, task, pace),
        Task::JointSegments(task) => joint_segments::find(robot, object, task, pace),
        Task::Path(task) => path_task::find(robot, object, task, pace),
    }?;
    let Some(points) = pace.set_points else { return Ok(planned) };
    // What was proved on the way was another motion.
    let plan = set_points::interpolated(planned.plan, points)?;
    Ok(Planned { plan, certificate: None, ..planned })
}
