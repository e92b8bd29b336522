//! Why a scenario could not be run, with the table of candidates when no grasp can be reached.

use graspcheck_planner::{PlanError, error::NothingReachable};
use graspcheck_verify::{Resolved, Unit};

use super::{
    candidates,
    quantity::{Rounding, quantity},
    table::{FAILED, NAME},
};
use crate::{
    exit,
    nearby::{self, Nearby},
    run::RunError,
};

/// The exit code that says why a scenario could not be run.
#[must_use]
pub fn exit_code(error: &RunError) -> u8 {
    match error {
        RunError::Plan(_) => exit::NO_PLAN,
        RunError::Scene(_) | RunError::Sim(_) => exit::INVALID_FILE,
        RunError::Evidence(_) => exit::BUG,
    }
}

/// Why a scenario could not be run; with the table of candidates when no grasp can be reached, grouped or
/// `every` one of them, and with a place that can be reached, for which planning is tried here.
#[must_use]
pub fn no_run(error: &RunError, resolved: &Resolved, every: bool) -> String {
    match error {
        RunError::Plan(PlanError::Unreachable(nothing)) => unreachable(nothing, resolved, every),
        other => format!("{FAILED}error{FAILED:#}: {other}\n"),
    }
}

fn length(value: f64) -> String {
    quantity(value, Unit::Meter, Rounding::Nearest)
}

fn unreachable(nothing: &NothingReachable, resolved: &Resolved, every: bool) -> String {
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
    text.push_str(&candidates::table(&nothing.candidates, &resolved.robot, every));
    text.push('\n');
    let places = nearby::places(resolved, nothing);
    if places.is_empty() {
        text.push_str(
            "  try  another place or another handle: none of the places nearby that were tried has a plan\n",
        );
    }
    for (index, place) in places.iter().enumerate() {
        text.push_str(&suggestion(place, index == 0));
    }
    text
}

fn suggestion(Nearby { placing, at, moved }: &Nearby, first: bool) -> String {
    let word = if first { "try" } else { "and" };
    let key = if *placing { "place = { at_mm" } else { "at_mm" };
    let end = if *placing { ", … }" } else { "" };
    let [x, y, z] = [at.x, at.y, at.z].map(|value| {
        // As it would be written: no more digits than it has.
        format!("{}", (value * 1e7).round() / 1e4)
    });
    let what = if *placing { "the place" } else { "the object" };
    format!(
        "  {word}  {key} = [{x}, {y}, {z}]{end}   moves {what} by {}; planned and proved clear\n",
        length(*moved)
    )
}
