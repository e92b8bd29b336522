//! Scenario and robot files: TOML to typed data, with every fault reported.
//!
//! [`load`] reads a scenario, the cell files that it extends, the robot that it names and the robot's URDF,
//! and returns either a [`Scenario`] in SI units or every fault of all these files at once. A [`Fault`] is
//! plain data (file, bytes, title, label, help); only the binary renders it. [`find`] lists scenarios.
//!
//! The language: units stand in the key from a closed list (`quill_mm`, `yaw_deg`, `duration_s`), so no
//! number is without one; unknown keys are errors; degrees and millimetres end here. `scenarios/README.md`
//! describes every key; defaults are the public constants of this crate, and [`Resolved`] holds them written
//! out.
//!
//! Robots: `robot = "scara"` is the folder `assets/robots/scara` below the nearest folder above the scenario
//! that has it; for a relative path, folders above the working directory count, too.
//!
//! How it works: `tree` turns TOML into an owned tree in which every key and value knows its place,
//! `extends` merges trees, `section` reads one table key by key and remembers which keys were asked for, and
//! the modules named after tables say which keys these are. Reading never stops at a fault: a reader
//! returns none, reports, and its caller goes on with the next key.
//!
//! [`Resolved`]: graspcheck_verify::Resolved

mod cell;
mod checks;
mod execution;
mod extends;
mod fault;
mod files;
mod find;
mod imperfections;
mod motion;
mod object;
mod path_task;
mod quantity;
mod robot;
mod robot_file;
mod scenario;
mod scene;
mod section;
mod shape;
mod suggest;
mod support;
mod task;
mod tree;
mod via_task;

pub use cell::{CLEARANCE_DEFAULT, STANDARD_GRAVITY};
pub use execution::{
    BANDWIDTH_DEFAULT, CONTACT_DEFAULT, DAMPING_RATIO_DEFAULT, SETTLE_DEFAULT, STEP_DEFAULT, SUBSTEPS_DEFAULT,
};
pub use fault::{Fault, Help, LoadError, SecondPlace, Source};
pub use find::{Listed, find, holds_files_to_extend, name_of};
pub use motion::{GRIP_DURATION_DEFAULT, SHARE_DEFAULT};
pub use robot_file::ROBOT_SCHEMA;
pub use scenario::{Provenance, SCENARIO_SCHEMA, Scenario, load};
pub use support::{Unsupported, unsupported};
pub use task::{PATH_TOLERANCE_DEFAULT, PREGRASP_DEFAULT};
