//! Checks that read a recording and judge it.
//!
//! [`Resolved`] is what a run was asked to be, carried by the recording as `resolved.json`; together with
//! `plan.json` and the streams it becomes the evidence that checks read. A check is a pure function of the
//! evidence: no clock, no file, no live object. A failing verdict is a result, not an error.
//!
//! Reading order: [`resolved`], [`verdict`].

pub mod resolved;
pub mod verdict;

pub use resolved::{CheckLimits, Expectation, Resolved};
pub use verdict::{Basis, CheckResult, Outcome, Place, Unit, Verdict};
