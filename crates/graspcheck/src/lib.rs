//! graspcheck plans a grasp motion, proves its limits and its clearance at every instant, executes it on a
//! simulated arm, records everything and judges the recording.
//!
//! [`run_scenario`] is the whole pipeline on one scenario; [`harness::run`] makes a test of every scenario
//! in a folder; [`report`] holds the renderings for people. The binary of the same name is a thin layer
//! over this library: only it prints, exits and reads the environment.
//!
//! ```no_run
//! let scenario = graspcheck::load(std::path::Path::new("scenarios/scara/pick_cube.toml"))?;
//! let run = graspcheck::run_scenario(&scenario, &mut graspcheck::Silent)?;
//! assert!(run.verdict.as_expected, "{}", graspcheck::report::failure(&run, &scenario.resolved));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod candidates;
pub mod exit;
pub mod harness;
pub mod html;
pub mod limit_proofs;
mod markers;
pub mod nearby;
pub mod report;
pub mod review;
pub mod run;
pub mod store;

pub use graspcheck_scenario::{Scenario, load};
pub use run::{Observer, Run, RunError, Silent, Stage, run_scenario};
