//! Why a scenario could not be run, with the table of candidates when no grasp can be reached.

use graspcheck_model::plan::NoMotion;
use graspcheck_planner::{PlanError, error::NothingReachable};
use graspcheck_verify::{Expectation, Resolved, Unit};

use super::{
    candidates,
    quantity::{Rounding, quantity},
    table::{FAILED, NAME, PASSED},
};
use crate::{
    exit,
    nearby::{self, Nearby},
    run::RunError,
};

/// Which of the ways in which no motion can exist kept a scenario from being run; none when something else did.
fn no_motion(error: &RunError) -> Option<NoMotion> {
    match error {
        RunError::Plan(error) => error.no_motion(),
        _ => None,
    }
}

/// Whether a scenario could not be run for the very reason that it expects.
#[must_use]
pub fn is_expected(error: &RunError, expect: &Expectation) -> bool {
    let Expectation::Fail(names) = expect else { return false };
    no_motion(error).is_some_and(|reason| names == &[reason.name()])
}

/// The exit code that says why a scenario could not be run; that of success where it expects so.
#[must_use]
pub fn exit_code(error: &RunError, expect: &Expectation) -> u8 {
    match error {
        _ if is_expected(error, expect) => exit::AS_EXPECTED,
        RunError::Plan(_) => exit::NO_PLAN,
        RunError::Scene(_) | RunError::Sim(_) => exit::INVALID_FILE,
        RunError::Evidence(_) => exit::BUG,
    }
}

/// Why a scenario could not be run; with the table of candidates when no grasp can be reached, grouped or
/// `every` one of them, and, where that is not expected, with a place that can be reached, for which planning is tried
/// here. The last line says whether it is expected.
#[must_use]
pub fn no_run(error: &RunError, resolved: &Resolved, every: bool) -> String {
    let mut text = match error {
        RunError::Plan(PlanError::Unreachable(nothing)) => {
            let suggests = !is_expected(error, &resolved.expect);
            unreachable(nothing, resolved, every, suggests)
        }
        other if is_expected(error, &resolved.expect) => {
            format!("{NAME}{}{NAME:#}   {}\n\n{other}\n\n", resolved.name, resolved.title)
        }
        other => format!("{FAILED}error{FAILED:#}: {other}\n"),
    };
    if let Some(line) = no_motion_line(error, &resolved.expect) {
        text.push_str(&line);
        text.push('\n');
    }
    text
}

/// The answer in one line where there is no motion: which way to fail it is, and whether that is expected. None when
/// a scenario could not be run for another reason.
#[must_use]
pub fn no_motion_line(error: &RunError, expect: &Expectation) -> Option<String> {
    let reason = no_motion(error)?.name();
    Some(match expect {
        _ if is_expected(error, expect) => {
            format!("{PASSED}NO PLAN{PASSED:#}  nothing to check, as expected: {reason}")
        }
        Expectation::Pass => {
            format!("{FAILED}NO PLAN{FAILED:#}  nothing to check, not as expected: {reason}")
        }
        Expectation::Fail(names) => {
            let names = names.join(", ");
            format!("{FAILED}NO PLAN{FAILED:#}  nothing to check, not as expected: {reason}, not {names}")
        }
    })
}

fn length(value: f64) -> String {
    quantity(value, Unit::Meter, Rounding::Nearest)
}

fn unreachable(nothing: &NothingReachable, resolved: &Resolved, every: bool, suggests: bool) -> String {
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
    if !suggests {
        return text;
    }
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
