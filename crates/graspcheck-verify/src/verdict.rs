//! The outcome of checks: one finding structure, of which terminal, test output, log and viewers are
//! renderings.

use graspcheck_model::robot::JointKind;
use serde::{Deserialize, Serialize};

use crate::{
    evidence::{EvidenceError, VERDICT_JSON, decode},
    note::Note,
};

/// Version of the form of the verdict's JSON.
pub const VERDICT_SCHEMA: u32 = 2;

/// How a check came out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// What was asked holds.
    Pass,
    /// It does not hold.
    Fail,
    /// It could not be decided, or nothing was there to look at. Never counted as a pass.
    Inconclusive,
    /// The run was not asked for what this check reads (for example, no execution); does not count.
    NotRequested,
}

/// How a value is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Basis {
    /// Closed-form extremum.
    Exact,
    /// A bound that holds at every instant.
    Proved,
    /// From the simulation's samples.
    Measured,
}

/// The SI unit of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Unit {
    /// No unit.
    One,
    /// A count of things, such as jumps.
    Count,
    /// Seconds.
    Second,
    /// A count of simulation steps.
    Steps,
    /// m.
    Meter,
    /// m/s.
    MeterPerSecond,
    /// m/s².
    MeterPerSecond2,
    /// m/s³.
    MeterPerSecond3,
    /// rad.
    Radian,
    /// rad/s.
    RadianPerSecond,
    /// rad/s².
    RadianPerSecond2,
    /// rad/s³.
    RadianPerSecond3,
    /// N.
    Newton,
    /// N·m.
    NewtonMeter,
    /// J.
    Joule,
}

impl Unit {
    /// The unit of the `order`-th derivative of a joint's position: 0 position, 1 velocity,
    /// 2 acceleration, 3 jerk.
    ///
    /// # Panics
    /// When `order` is above 3.
    #[must_use]
    pub fn of_derivative(kind: JointKind, order: usize) -> Self {
        const ANGULAR: [Unit; 4] =
            [Unit::Radian, Unit::RadianPerSecond, Unit::RadianPerSecond2, Unit::RadianPerSecond3];
        const LINEAR: [Unit; 4] =
            [Unit::Meter, Unit::MeterPerSecond, Unit::MeterPerSecond2, Unit::MeterPerSecond3];
        match kind {
            JointKind::Revolute => ANGULAR[order],
            JointKind::Prismatic => LINEAR[order],
        }
    }

    /// Its symbol; empty for what is counted.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        match self {
            Self::One | Self::Count => "",
            Self::Second => "s",
            Self::Steps => "steps",
            Self::Meter => "m",
            Self::MeterPerSecond => "m/s",
            Self::MeterPerSecond2 => "m/s²",
            Self::MeterPerSecond3 => "m/s³",
            Self::Radian => "rad",
            Self::RadianPerSecond => "rad/s",
            Self::RadianPerSecond2 => "rad/s²",
            Self::RadianPerSecond3 => "rad/s³",
            Self::Newton => "N",
            Self::NewtonMeter => "N·m",
            Self::Joule => "J",
        }
    }

    /// The unit of a joint's effort: N·m or N.
    #[must_use]
    pub fn of_effort(kind: JointKind) -> Self {
        match kind {
            JointKind::Revolute => Self::NewtonMeter,
            JointKind::Prismatic => Self::Newton,
        }
    }
}

/// Where something is worst.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Place {
    /// A joint, a tool, or a pair of bodies.
    pub subjects: Vec<String>,
    /// Name of the phase.
    pub phase: Option<String>,
}

/// What one check found. A value is given whether it passes or not.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CheckResult {
    /// Stable name, e.g. `planned.jerk`.
    pub check: String,
    /// How it came out.
    pub outcome: Outcome,
    /// The worst value, if there is one.
    pub value: Option<f64>,
    /// What it is held against.
    pub limit: Option<f64>,
    /// Unit of value and limit.
    pub unit: Unit,
    /// Room left: positive inside the limit, negative outside. A share of the limit for joint quantities,
    /// in `unit` for lengths, angles and counts; see `margin_is_share`.
    pub margin: Option<f64>,
    /// Whether `margin` is a share of the limit.
    pub margin_is_share: bool,
    /// Whether `value` is a bound on the true one (a lower bound for distances, an upper bound else)
    /// rather than a value that was met.
    pub value_is_bound: bool,
    /// When it is worst, s.
    pub time: Option<f64>,
    /// From when to when it is violated, s: first and last instant.
    pub violated: Option<[f64; 2]>,
    /// Where it is worst.
    pub place: Place,
    /// How the value is known.
    pub basis: Basis,
    /// What a table cannot say.
    pub note: Note,
    /// For a failure that a slower motion would cure: how many times as long the whole plan must be given so that
    /// it keeps this limit, more than 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stretch: Option<f64>,
}

/// The judgement of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// [`VERDICT_SCHEMA`] when it was written.
    pub schema: u32,
    /// Name of the scenario.
    pub scenario: String,
    /// Fail if any check fails, else inconclusive if any is, else pass. A run that must fail and was not
    /// asked for anything that must fail is inconclusive, too.
    pub outcome: Outcome,
    /// Whether the outcome, and the set of failed checks, is what the scenario expects.
    pub as_expected: bool,
    /// Failures that the scenario expects and that do not count, since they are of the execution and the run
    /// was not executed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<String>,
    /// All checks, in a fixed order: planned ones, then executed ones.
    pub checks: Vec<CheckResult>,
}

impl CheckResult {
    /// The room left as a share of the limit, which compares checks of different units: 0.1 is 10 %.
    /// None without a margin, or when the limit is 0.
    #[must_use]
    pub fn margin_share(&self) -> Option<f64> {
        let margin = self.margin?;
        if self.margin_is_share {
            return Some(margin);
        }
        self.limit.filter(|limit| *limit != 0.0).map(|limit| margin / limit.abs())
    }
}

impl Verdict {
    /// The verdict as a JSON document; equal verdicts give equal bytes.
    #[must_use]
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("a tree of structs, strings and numbers has a JSON form")
    }

    /// The verdict that [`Verdict::to_json`] wrote.
    ///
    /// # Errors
    /// When `text` is not such a document, or is of a form that this library does not know.
    pub fn from_json(text: &str) -> Result<Self, EvidenceError> {
        decode(VERDICT_JSON, text.as_bytes(), VERDICT_SCHEMA)
    }

    /// Whether the run was not executed: the checks on the execution were left out.
    #[must_use]
    pub fn is_of_plan_alone(&self) -> bool {
        let mut executed = self.checks.iter().filter(|result| result.check.starts_with("executed."));
        executed.all(|result| result.outcome == Outcome::NotRequested)
    }

    /// Whether there is no judgement, since all that must fail is of the execution and the run was not
    /// executed.
    #[must_use]
    pub fn is_not_judged(&self) -> bool {
        self.outcome == Outcome::Inconclusive
            && !self.left_out.is_empty()
            && self.checks.iter().all(|result| result.outcome != Outcome::Inconclusive)
    }

    /// The checks that fail, in the verdict's order.
    pub fn failed(&self) -> impl Iterator<Item = &CheckResult> {
        self.checks.iter().filter(|result| result.outcome == Outcome::Fail)
    }

    /// The passing check with the least room as a share of its limit ([`CheckResult::margin_share`]);
    /// none when no passing check has a limit other than 0.
    #[must_use]
    pub fn tightest(&self) -> Option<&CheckResult> {
        let room = |result: &CheckResult| result.margin_share().unwrap_or(f64::INFINITY);
        self.checks
            .iter()
            .filter(|result| result.outcome == Outcome::Pass && result.margin_share().is_some())
            .min_by(|a, b| room(a).total_cmp(&room(b)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;

    #[test]
    fn a_verdict_comes_back_from_its_json() {
        let verdict = fixture::pick().judged();
        assert_eq!(Verdict::from_json(&verdict.to_json()).unwrap(), verdict);
        assert_eq!(verdict.to_json(), verdict.to_json());
    }

    #[test]
    fn what_is_no_verdict_is_an_error() {
        assert!(matches!(
            Verdict::from_json("{}"),
            Err(EvidenceError::Undecodable { name: VERDICT_JSON, .. })
        ));
        let future = fixture::pick().judged().to_json().replacen("\"schema\": 2", "\"schema\": 3", 1);
        assert!(matches!(Verdict::from_json(&future), Err(EvidenceError::UnknownSchema { found: 3, .. })));
    }

    #[test]
    fn the_tightest_check_has_the_least_room_for_its_limit() {
        let mut run = fixture::pick();
        run.resolved.robot.joints[1].limits.jerk = 30.5;
        let verdict = run.judged();
        let tightest = verdict.tightest().unwrap();
        assert_eq!(tightest.check, "planned.jerk");
        assert!((tightest.margin_share().unwrap() - 0.5 / 30.5).abs() < 1e-9);
        assert_eq!(verdict.failed().count(), 0);
    }

    #[test]
    fn a_length_is_compared_as_a_share_of_its_limit() {
        let verdict = fixture::pick().judged();
        let place = verdict.checks.iter().find(|result| result.check == "executed.place").unwrap();
        assert!((place.margin_share().unwrap() - 1.0).abs() < 1e-9, "{place:?}");
        let saturation = verdict.checks.iter().find(|result| result.check == "executed.saturation").unwrap();
        assert_eq!((saturation.margin, saturation.margin_share()), (Some(0.0), None));
    }

    #[test]
    fn units_follow_the_kind_of_a_joint() {
        assert_eq!(Unit::of_derivative(JointKind::Revolute, 3), Unit::RadianPerSecond3);
        assert_eq!(Unit::of_derivative(JointKind::Prismatic, 0), Unit::Meter);
        assert_eq!(Unit::of_effort(JointKind::Prismatic), Unit::Newton);
        assert_eq!(Unit::of_effort(JointKind::Revolute), Unit::NewtonMeter);
    }
}
