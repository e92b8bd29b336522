//! Joint moves one after the other.
//!
//! A segment that begins elsewhere than where the one before it ended is left as it is: the trajectory
//! declares the jump as a break and the checks name it. Planning does not repair it.

use graspcheck_model::{
    object::Object,
    plan::{Holding, Plan},
    robot::{JointLimits, RobotModel},
    task::{JointSegment, JointSegments, Pace},
};

use crate::{
    Planned,
    error::PlanError,
    input::check_joint_count,
    joint_move::joint_move_by,
    opening::idle,
    pace::{CheckedPace, PhaseNames},
    sequence::Sequence,
};

/// Plans the segments. An object that there is stays where it stands.
pub(crate) fn find(
    robot: &RobotModel,
    object: Option<&Object>,
    task: &JointSegments,
    pace: &Pace,
) -> Result<Planned, PlanError> {
    let names: Vec<&str> = task.segments.iter().map(|segment| segment.name.as_str()).collect();
    if names.is_empty() {
        return Err(PlanError::NoSegment);
    }
    let pace = CheckedPace::new(pace, PhaseNames { all: &names, joint_moves: &names })?;
    let limits: Vec<JointLimits> = robot.joints.iter().map(|joint| joint.limits).collect();
    let holding = if object.is_some() { Holding::AtStart } else { Holding::Nothing };
    let mut sequence = Sequence::default();
    for JointSegment { name, from, to } in &task.segments {
        check_joint_count(&format!("segment {name}, from"), from, robot.dof())?;
        check_joint_count(&format!("segment {name}, to"), to, robot.dof())?;
        let motion = joint_move_by(from, to, &limits, pace.pacing(name))
            .map_err(|error| PlanError::JointMove { phase: name.clone(), error })?;
        sequence.add(name, &motion, holding)?;
    }
    let (trajectory, phases) = sequence.finish()?;
    let opening = idle(&robot.gripper, trajectory.duration())?;
    Ok(Planned::without_proof(Plan { trajectory, opening, phases, grasp: None, paths: Vec::new() }))
}
