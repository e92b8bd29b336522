//! The checks, one file for each family.
//!
//! A check is a pure function of the evidence. It says what it found: a value against a limit, with time
//! and place; or why there is nothing to say. That becomes a [`CheckResult`] in one place, here, so that
//! no check can pass without a value.

mod branch;
mod clearance;
mod consistency;
mod contacts;
mod continuity;
mod deviation;
mod executed;
mod executed_clearance;
mod grip;
mod held;
mod limits;
mod opening;
mod place;
mod slip;
mod stability;
mod task;
mod tool;
mod torque;
mod utilisation;
mod via;

use crate::{
    evidence::Evidence,
    finding::{Finding, Gap},
    note::Note,
    verdict::{Basis, CheckResult, Outcome, Place, Unit},
};

/// One question about a recording.
#[derive(Clone, Copy)]
pub struct Check {
    /// Its stable name, e.g. `planned.jerk`: what it judges, then the quantity.
    pub name: &'static str,
    /// How its value is known.
    pub basis: Basis,
    find: fn(&Evidence<'_>) -> Result<Finding, Gap>,
}

/// All checks, in the order of a verdict.
pub const CHECKS: &[Check] = &[
    Check { name: "planned.task", basis: Basis::Exact, find: task::task },
    Check { name: "planned.position", basis: Basis::Exact, find: limits::position },
    Check { name: "planned.velocity", basis: Basis::Exact, find: limits::velocity },
    Check { name: "planned.acceleration", basis: Basis::Exact, find: limits::acceleration },
    Check { name: "planned.jerk", basis: Basis::Exact, find: limits::jerk },
    Check { name: "planned.torque", basis: Basis::Proved, find: torque::torque },
    Check { name: "planned.tool_speed", basis: Basis::Proved, find: tool::speed },
    Check { name: "planned.tool_acceleration", basis: Basis::Proved, find: tool::acceleration },
    Check { name: "planned.continuity", basis: Basis::Exact, find: continuity::continuity },
    Check { name: "planned.clearance", basis: Basis::Proved, find: clearance::clearance },
    Check { name: "planned.certificate", basis: Basis::Proved, find: clearance::certificate },
    Check { name: "planned.deviation", basis: Basis::Proved, find: deviation::deviation },
    Check { name: "planned.branch", basis: Basis::Proved, find: branch::branch },
    Check { name: "planned.singularity", basis: Basis::Proved, find: branch::singularity },
    Check { name: "planned.via", basis: Basis::Exact, find: via::via },
    Check { name: "planned.utilisation", basis: Basis::Exact, find: utilisation::planned },
    Check { name: "executed.position", basis: Basis::Measured, find: executed::position },
    Check { name: "executed.velocity", basis: Basis::Measured, find: executed::velocity },
    Check { name: "executed.torque", basis: Basis::Measured, find: executed::torque },
    Check { name: "executed.saturation", basis: Basis::Measured, find: executed::saturation },
    Check { name: "executed.stability", basis: Basis::Measured, find: stability::stability },
    Check { name: "executed.tracking", basis: Basis::Measured, find: executed::tracking },
    Check { name: "executed.clearance", basis: Basis::Proved, find: executed_clearance::clearance },
    Check { name: "executed.tube", basis: Basis::Proved, find: executed_clearance::tube },
    Check { name: "executed.contacts", basis: Basis::Measured, find: contacts::contacts },
    Check { name: "executed.opening", basis: Basis::Measured, find: opening::opening },
    Check { name: "executed.grip", basis: Basis::Measured, find: grip::grip },
    Check { name: "executed.slip", basis: Basis::Measured, find: slip::slip },
    Check { name: "executed.place", basis: Basis::Measured, find: place::place },
    Check { name: "executed.place_angle", basis: Basis::Measured, find: place::place_angle },
    Check { name: "executed.rest", basis: Basis::Measured, find: place::rest },
    Check { name: "executed.consistency", basis: Basis::Measured, find: consistency::consistency },
    Check { name: "executed.utilisation", basis: Basis::Measured, find: utilisation::executed },
];

impl std::fmt::Debug for Check {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Check").field("name", &self.name).field("basis", &self.basis).finish_non_exhaustive()
    }
}

impl Check {
    /// What the check finds in the evidence: a pure function of it.
    #[must_use]
    pub fn evaluate(&self, evidence: &Evidence<'_>) -> CheckResult {
        match (self.find)(evidence) {
            Ok(finding) => self.judged(finding),
            Err(Gap::NotRequested(note)) => self.without_value(Outcome::NotRequested, None, note),
            Err(Gap::Inconclusive { time, note }) => self.without_value(Outcome::Inconclusive, time, note),
            Err(Gap::Broken { time, note }) => self.without_value(Outcome::Fail, Some(time), note),
        }
    }

    fn judged(&self, finding: Finding) -> CheckResult {
        let Finding { value, limit, margin, time, .. } = finding;
        if !(value.is_finite() && limit.is_finite() && margin.is_finite()) {
            let note = Note::from(format!("the value is {value}, held against {limit}"));
            return CheckResult { place: finding.place, ..self.without_value(Outcome::Fail, time, note) };
        }
        CheckResult {
            check: self.name.to_owned(),
            outcome: if finding.passes { Outcome::Pass } else { Outcome::Fail },
            value: Some(value),
            limit: Some(limit),
            unit: finding.unit,
            margin: Some(margin),
            margin_is_share: finding.margin_is_share,
            value_is_bound: finding.value_is_bound,
            time,
            violated: finding.violated,
            place: finding.place,
            basis: self.basis,
            note: finding.note,
            stretch: finding.stretch,
        }
    }

    fn without_value(&self, outcome: Outcome, time: Option<f64>, note: Note) -> CheckResult {
        CheckResult {
            check: self.name.to_owned(),
            outcome,
            value: None,
            limit: None,
            unit: Unit::One,
            margin: None,
            margin_is_share: false,
            value_is_bound: false,
            time,
            violated: None,
            place: Place::default(),
            basis: self.basis,
            note,
            stretch: None,
        }
    }
}
