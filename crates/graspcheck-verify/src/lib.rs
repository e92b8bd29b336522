//! Checks that read a recording and judge it.
//!
//! [`Resolved`] is what a run was asked to be, carried by the recording as `resolved.json`; together with
//! `plan.json`, `certificate.json` and the streams it becomes the [`Evidence`] that checks read. A check is
//! a pure function of the evidence: no clock, no file, no live object. So a log gives the same verdict
//! wherever and whenever it is judged. A failing verdict is a result, not an error.
//!
//! There are three outcomes. What cannot be decided, or was promised and is not there, is *inconclusive*
//! and never counts as a pass. What the run was not asked for is *not requested* and does not count.
//!
//! | check | holds when |
//! |---|---|
//! | `planned.task` | the plan does what the task asks, and its parts tell one story |
//! | `planned.position`, `.velocity`, `.acceleration`, `.jerk` | every joint is within its limit at every instant, by exact extrema |
//! | `planned.continuity` | no joint jumps; acceleration steps only in motions with parabolic blends, by at most twice its limit |
//! | `planned.clearance` | every pair of bodies keeps the distance it must, proved again here for every instant |
//! | `planned.certificate` | the proof that travelled with the log is the proof that is found here |
//! | `planned.torque` | no joint takes more than its effort limit, with what is held |
//! | `planned.deviation` | the tool stays within the tolerance of the paths on which it is led, proved again here for every instant |
//! | `planned.via` | the wrist passes near each via point at its time |
//! | `planned.utilisation` | the plan uses the share of velocity and acceleration that the scenario claims |
//! | `executed.position`, `.velocity` | the measured joints are within their limits |
//! | `executed.torque`, `.saturation` | the controller asks for no more effort than there is |
//! | `executed.tracking` | the tool is where the plan has it, at equal times |
//! | `executed.clearance` | every pair keeps its distance along the executed motion, between rows, too |
//! | `executed.tube` | the plan stays free within the measured tracking error |
//! | `executed.consistency` | the streams of the log do not contradict each other |
//! | `executed.contacts` | nothing touches that may not, and nothing deeper than it may |
//! | `executed.grip` | the fingers press before the lift begins |
//! | `executed.slip` | the object stays in the gripper from lift to release |
//! | `executed.place`, `.place_angle`, `.rest` | the object ends where it belongs, at rest |
//! | `executed.utilisation` | the execution uses the share of torque that the scenario claims |
//!
//! Reading order: [`resolved`], [`evidence`], [`checks`], [`judge()`], [`verdict`], [`note`]. Numbers that judge nothing:
//! [`metrics`].

pub mod checks;
pub mod evidence;
mod finding;
#[cfg(test)]
mod fixture;
mod judge;
mod logged;
pub mod metrics;
pub mod note;
pub mod resolved;
mod stream;
pub mod verdict;

pub use checks::{CHECKS, Check};
pub use evidence::{
    CERTIFICATE_JSON, Evidence, EvidenceError, NOT_EXECUTED, PLAN_JSON, RESOLVED_JSON, VERDICT_JSON, attach,
};
pub use judge::{is_meant_by, judge};
pub use note::{Note, NotePart};
pub use resolved::{CheckLimits, Expectation, Resolved, ToolLimits};
pub use verdict::{Basis, CheckResult, Outcome, Place, Unit, Verdict};
