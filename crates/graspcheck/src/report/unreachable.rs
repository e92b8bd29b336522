//! Why a scenario could not be run, with the table of candidates when no grasp can be reached.

use comfy_table::{ContentArrangement, Table, presets};
use graspcheck_model::{
    robot::{JointKind, RobotModel},
    task::Elbow,
};
use graspcheck_planner::{
    PlanError,
    candidate::{BranchChoice, Candidate, CandidateOutcome},
    error::NothingReachable,
};
use graspcheck_verify::Unit;

use super::{
    quantity::{Rounding, quantity},
    table::{FAILED, NAME},
};
use crate::{exit, run::RunError};

/// The exit code that says why a scenario could not be run.
#[must_use]
pub fn exit_code(error: &RunError) -> u8 {
    match error {
        RunError::Plan(_) => exit::NO_PLAN,
        RunError::Scene(_) | RunError::Sim(_) => exit::INVALID_FILE,
        RunError::Evidence(_) => exit::BUG,
    }
}

/// Why a scenario could not be run; with the table of candidates when no grasp can be reached.
#[must_use]
pub fn no_run(error: &RunError, robot: &RobotModel) -> String {
    match error {
        RunError::Plan(PlanError::Unreachable(nothing)) => unreachable(nothing, robot),
        other => format!("{FAILED}error{FAILED:#}: {other}\n"),
    }
}

fn length(value: f64) -> String {
    quantity(value, Unit::Meter, Rounding::Nearest)
}

fn position(value: f64, kind: JointKind) -> String {
    let unit = match kind {
        JointKind::Revolute => Unit::Radian,
        JointKind::Prismatic => Unit::Meter,
    };
    quantity(value, unit, Rounding::Nearest)
}

fn unreachable(nothing: &NothingReachable, robot: &RobotModel) -> String {
    let placing = nothing.wrist.is_some_and(|wrist| wrist.placing);
    let pose = if placing { &nothing.world_from_placed } else { &nothing.world_from_object };
    let at = pose.translation.vector;
    let mut text = format!(
        "{FAILED}UNREACHABLE{FAILED:#}  {NAME}{}{NAME:#} {} ({:.1}, {:.1}, {:.1}) mm: none of {} ways to hold it can be \
         reached\n\n",
        nothing.object,
        if placing { "placed at" } else { "at" },
        at.x * 1e3,
        at.y * 1e3,
        at.z * 1e3,
        nothing.candidates.len()
    );
    if let Some(wrist) = &nothing.wrist {
        text.push_str(&format!("  wrist      {} from the first axis\n", length(wrist.distance)));
        text.push_str(&format!(
            "  reachable  {} to {}\n",
            length(wrist.reach.inner),
            length(wrist.reach.outer)
        ));
    }
    text.push('\n');
    text.push_str(&table(&nothing.candidates, robot));
    if let Some(shift) = nothing.wrist.as_ref().and_then(|wrist| wrist.shift) {
        let to = at + shift;
        text.push_str(&format!(
            "\n  try  at_mm = [{:.1}, {:.1}, {:.1}]   the nearest place within reach, {} away\n",
            to.x * 1e3,
            to.y * 1e3,
            to.z * 1e3,
            length(shift.norm())
        ));
    }
    text
}

/// The candidates, nearest miss first: handle, branch, joint positions, how far planning got, and why no further.
fn table(candidates: &[Candidate], robot: &RobotModel) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_content_arrangement(ContentArrangement::Disabled);
    let joints = robot.joints.iter().map(|joint| joint.name.clone());
    table.add_row(
        ["", "handle", "branch"]
            .map(str::to_owned)
            .into_iter()
            .chain(joints)
            .chain(["stage".to_owned(), "rejected because".to_owned()]),
    );
    for candidate in candidates {
        let choice = candidate.place.as_ref().or(candidate.grasp.as_ref());
        let handle = if candidate.half_turn {
            format!("{}, half turn", candidate.handle)
        } else {
            candidate.handle.clone()
        };
        let mut row = vec![String::new(), handle, choice.map_or_else(|| "–".to_owned(), branch)];
        row.extend(robot.joints.iter().enumerate().map(|(k, joint)| {
            choice.map_or_else(|| "–".to_owned(), |choice| position(choice.q[k], joint.kind))
        }));
        row.push(candidate.stage.to_string());
        row.push(reason(&candidate.outcome, robot));
        table.add_row(row);
    }
    table.lines().map(|line| format!("{}\n", line.trim_end())).collect()
}

fn branch(choice: &BranchChoice) -> String {
    let elbow = match choice.elbow {
        Elbow::Left => "elbow left",
        Elbow::Right => "elbow right",
    };
    match choice.turn {
        0 => elbow.to_owned(),
        turn => format!("{elbow}, turn {turn:+}"),
    }
}

fn reason(outcome: &CandidateOutcome, robot: &RobotModel) -> String {
    match outcome {
        CandidateOutcome::Limit { joint, value, limit, excess } => {
            let kind = robot
                .joints
                .iter()
                .find(|other| other.name == *joint)
                .map_or(JointKind::Revolute, |j| j.kind);
            let side = if value > limit { "above" } else { "below" };
            format!("{joint} {} {side} {}", position(*excess, kind), position(*limit, kind))
        }
        other => other.to_string(),
    }
}
