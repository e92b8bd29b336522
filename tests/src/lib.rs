//! Scenario suites and tests that span crates; everything is under `tests/`:
//!
//! - `scenarios`: every file under `scenarios/` is one test, named by folder and file.
//! - `contract`: the same scenario gives the same bytes, and a log gives the same verdict offline.
//! - `dependencies`: which crate may use which, and what only one may know.
//! - `tidy`: what no compiler holds: crate docs, long files, paths of somebody's machine.
//!
//! `readers/` holds readers of our logs that are not ours, in Python; `.ci/run` runs them on the logs that
//! `scenarios` wrote.
