//! `[check.NAME]` and what must come out.

use graspcheck_model::plan::NoMotion;
use graspcheck_verify::{CHECKS, CheckLimits, Expectation, ToolLimits, is_meant_by};

use crate::{
    cell::{PlacedRule, clearance, default_clearance},
    fault::{Fault, Place},
    quantity::Quantity,
    section::{Bound, Section, text, wrong_type},
    suggest::nearest,
    task::Kind,
    tree::Value,
};

/// The tables that may stand under `[check]`.
const NAMES: [&str; 13] = [
    "clearance",
    "deviation",
    "tracking",
    "slip",
    "place",
    "saturation",
    "via_miss",
    "utilisation",
    "tool_speed",
    "tool_acceleration",
    "continuity",
    "branch",
    "singularity",
];

/// Reads `[check]`. A check without a table is not requested, except clearance, which has a default.
pub(crate) fn checks<'a>(
    scenario: &Section<'a>,
    kind: Option<Kind>,
) -> Option<(CheckLimits, PlacedRule<'a>)> {
    let mut limits = CheckLimits::default();
    let mut rule = Some(default_clearance());
    let Some(section) = scenario.section("check", "the checks") else { return Some((limits, rule?)) };
    let mut complete = true;
    for (name, at, check) in section.named_sections("a check") {
        needs_its_task(name, at, kind, &check);
        match name {
            "clearance" => {
                rule = clearance(check);
                continue;
            }
            "tracking" => complete &= length(&check, &mut limits.tracking),
            "slip" => complete &= length(&check, &mut limits.slip),
            "deviation" => complete &= length(&check, &mut limits.deviation),
            "via_miss" => {
                complete &= length(&check, &mut limits.via_miss);
                limits.via_miss_angle = angle(&check);
            }
            "place" => {
                complete &= length(&check, &mut limits.place);
                limits.place_angle = angle(&check);
            }
            "saturation" => match check.required("max_steps") {
                Some(_) => {
                    let steps = check.whole("max_steps", 0, i64::from(u32::MAX));
                    limits.saturated_steps = steps.and_then(|steps| u32::try_from(steps).ok());
                    complete &= limits.saturated_steps.is_some();
                }
                None => complete = false,
            },
            "utilisation" => {
                limits.utilisation_min = check.required_measure("min", Quantity::Share, Bound::UpToOne);
                complete &= limits.utilisation_min.is_some();
            }
            "tool_speed" => complete &= tool(&check, Quantity::Speed, &mut limits),
            "tool_acceleration" => complete &= tool(&check, Quantity::LinearAcceleration, &mut limits),
            "continuity" => {
                let step = check.required_measure("acceleration_step_max", Quantity::Share, Bound::Positive);
                limits.acceleration_step = step;
                complete &= step.is_some();
            }
            "branch" => match check.flag("throughout", true) {
                Some(throughout) => limits.branch_throughout = throughout,
                None => complete = false,
            },
            "singularity" => {
                limits.singularity_min = check.required_plain("min", Bound::UpToOne);
                complete &= limits.singularity_min.is_some();
            }
            _ => {
                unknown(name, at, &check);
                continue;
            }
        }
        check.finish();
    }
    section.finish();
    complete.then_some((limits, rule?))
}

/// Reads `max_mm_s` or `max_m_s2` and `phases = [{ phase, max_mm_s }]`, of which one must be there.
fn tool(check: &Section<'_>, quantity: Quantity, limits: &mut CheckLimits) -> bool {
    let phases = check.sections("phases", "a phase");
    let all = if phases.is_empty() || check.mentions("max") {
        let Some(all) = check.required_measure("max", quantity, Bound::Positive) else { return false };
        Some(all)
    } else {
        None
    };
    let is_speed = matches!(quantity, Quantity::Speed);
    *(if is_speed { &mut limits.tool_speed } else { &mut limits.tool_acceleration }) = all;
    let mut complete = true;
    for phase in phases {
        let name = phase.required_text("phase");
        let max = phase.required_measure("max", quantity, Bound::Positive);
        phase.finish();
        let (Some((name, _)), Some(max)) = (name, max) else {
            complete = false;
            continue;
        };
        let (speed, acceleration) = if is_speed { (Some(max), None) } else { (None, Some(max)) };
        match limits.tool_in_phases.iter_mut().find(|own| own.phase == name) {
            Some(own) if is_speed => own.speed = speed,
            Some(own) => own.acceleration = acceleration,
            None => limits.tool_in_phases.push(ToolLimits { phase: name.to_owned(), speed, acceleration }),
        }
    }
    complete
}

/// Reads `max_mm`, which must be there.
fn length(check: &Section<'_>, limit: &mut Option<f64>) -> bool {
    *limit = check.required_measure("max", Quantity::Length, Bound::Positive);
    limit.is_some()
}

/// Reads `max_deg`, which may be left out beside `max_mm`.
fn angle(check: &Section<'_>) -> Option<f64> {
    let is_given = Quantity::Angle.keys("max").any(|(key, _)| check.has(&key));
    if is_given { check.measure("max", Quantity::Angle, Bound::Positive) } else { None }
}

fn unknown(name: &str, at: &Place, check: &Section<'_>) {
    let fault = Fault::new("unknown-check", at, format!("unknown check `{name}`"), "not a check");
    check.faults().report(match nearest(name, NAMES.into_iter()) {
        Some(near) => fault.replace(format!("did you mean `{near}`?"), near),
        None => fault.help(format!("the checks are {}", NAMES.join(", "))),
    });
}

/// Reports a check that would find nothing to look at.
fn needs_its_task(name: &str, at: &Place, kind: Option<Kind>, check: &Section<'_>) {
    let Some(kind) = kind else { return };
    let (needed, what): (&[Kind], &str) = match name {
        "slip" | "place" => (&[Kind::PickAndPlace], "an object that is carried"),
        "via_miss" => (&[Kind::Via, Kind::JointVia], "via points"),
        "deviation" => (&[Kind::PickAndPlace, Kind::Via, Kind::Path], "paths of the tool"),
        _ => return,
    };
    if !needed.contains(&kind) {
        let title = format!("check `{name}` needs {what}, this task has none");
        check.faults().report(Fault::new("check-of-task", at, title, "remove it"));
    }
}

/// Reads `expect = "pass"` or `expect_fail = ["planned.velocity"]`.
pub(crate) fn expectation(scenario: &Section<'_>) -> Option<Expectation> {
    let pass = scenario.word("expect", &[("pass", ())], Some(()));
    let Some(entry) = scenario.entry("expect_fail") else { return pass.map(|()| Expectation::Pass) };
    if let Some(pass) = scenario.entry("expect") {
        let fault =
            Fault::new("two-units", &entry.key_at, "a scenario is expected to pass or to fail", "keep one");
        scenario.faults().report(fault.second(&pass.key_at, "the other one"));
    }
    let Value::Array(nodes) = &entry.node.value else {
        wrong_type("expect_fail", &entry.node, "a list of checks", scenario.faults());
        return None;
    };
    if nodes.is_empty() {
        let title = "expect_fail names no check";
        scenario.faults().report(Fault::new("range", &entry.node.at, title, "write expect = \"pass\""));
    }
    let named = |node| {
        let (name, at) = text("expect_fail", node, scenario.faults())?;
        let is_no_motion = NoMotion::ALL.iter().any(|reason| reason.name() == name);
        if is_no_motion && nodes.len() > 1 {
            let title = format!("`{name}` leaves no plan on which a check could fail");
            scenario.faults().report(Fault::new("no-plan", at, title, "expect nothing else"));
        }
        if is_no_motion || CHECKS.iter().any(|check| is_meant_by(check.name, name)) {
            return Some(name.to_owned());
        }
        let words =
            CHECKS.iter().flat_map(|check| [Some(check.name), check.name.split('.').nth(1)]).flatten();
        let words = words.chain(NoMotion::ALL.iter().map(|reason| reason.name()));
        let fault = Fault::new("unknown-check", at, format!("unknown check `{name}`"), "not a check");
        scenario.faults().report(match nearest(name, words) {
            Some(near) => fault.replace(format!("did you mean \"{near}\"?"), format!("\"{near}\"")),
            None => fault,
        });
        None
    };
    let names: Vec<_> = nodes.iter().map(named).collect();
    names.into_iter().collect::<Option<Vec<_>>>().map(Expectation::Fail)
}
