//! The outcome of checks: one finding structure, of which terminal, test output, log and viewers are
//! renderings.

use serde::{Deserialize, Serialize};

/// Version of the form of the verdict's JSON.
pub const VERDICT_SCHEMA: u32 = 1;

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
    /// One sentence: place, quantity, value, verb, limit, time. SI in machine output, degrees and
    /// millimetres are a matter of rendering; this is for what a table cannot say.
    pub note: String,
}

/// The judgement of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// [`VERDICT_SCHEMA`] when it was written.
    pub schema: u32,
    /// Name of the scenario.
    pub scenario: String,
    /// Fail if any check fails, else inconclusive if any is, else pass.
    pub outcome: Outcome,
    /// Whether the outcome, and the set of failed checks, is what the scenario expects.
    pub as_expected: bool,
    /// All checks, in a fixed order: planned ones, then executed ones.
    pub checks: Vec<CheckResult>,
}
