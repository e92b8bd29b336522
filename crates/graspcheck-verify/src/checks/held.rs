//! What the checks on a grasp share: the object, and when it is held.

use graspcheck_model::{object::Object, plan::Holding, task::PickAndPlace, task::Task};

use crate::{evidence::Evidence, finding::Gap};

/// The object of a task that grasps one.
pub(super) fn object<'e>(evidence: &'e Evidence<'_>) -> Result<&'e Object, Gap> {
    task(evidence)?;
    evidence
        .resolved
        .object
        .as_ref()
        .ok_or_else(|| Gap::inconclusive(None, "the task has no object to grasp"))
}

/// The task, when it grasps an object.
pub(super) fn task<'e>(evidence: &'e Evidence<'_>) -> Result<&'e PickAndPlace, Gap> {
    match &evidence.resolved.task {
        Task::PickAndPlace(task) => Ok(task),
        Task::CartesianVia(_) | Task::JointVia(_) | Task::JointSegments(_) | Task::Path(_) => {
            Err(Gap::not_requested("the task grasps nothing"))
        }
    }
}

/// When the object is held by the plan: from the start of the lift to the start of the release, s.
pub(super) fn stretch(evidence: &Evidence<'_>) -> Result<[f64; 2], Gap> {
    let mut held = evidence.plan.phases.iter().filter(|phase| phase.holding == Holding::Held);
    let first =
        held.next().ok_or_else(|| Gap::inconclusive(None, "no phase of the plan holds the object"))?;
    Ok([first.start, held.next_back().unwrap_or(first).end])
}
