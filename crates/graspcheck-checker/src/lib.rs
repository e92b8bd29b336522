//! Validates the proof of clearance that a recording carries, from the recording alone.
//!
//! A run proves for every pair of convex solids that they keep the required distance at every instant of the
//! plan, and its log carries plan and proof. [`check`] holds the proof against robot, cell, object and plan:
//! whether every pair that must be there is, whether each has steps from the start to the end of the plan,
//! and whether each step holds. Formulas stand here a second time, and the list of pairs and of required
//! distances too: nothing of the code that made the proof is used, and no library but for reading JSON.
//!
//! **A step** is an interval of time, a direction n, a gap and a loss. At the middle of the interval the two
//! solids have a slab across n between them that is at least as wide as the gap; until its ends motion takes
//! no more from it than the loss; so they keep at least gap less loss, and that is at least what is required.
//! All three are computed here. That needs no search: finding a proof is hard, checking one is not.
//!
//! **A violation** is an instant and a point of each solid; both are looked for in their solids.
//!
//! Units are SI and radians. A distance is positive apart and negative overlapping. Names of transforms
//! cancel: `world_from_solid = world_from_link * link_from_solid`.
//!
//! Reading order: `report`, `check`, then what it computes with: `scene` (which pairs), `policy` (how far
//! apart), `motion` (where and how far it moves), `solid`, `closest`, `polynomial`, `vector`; `documents` is
//! what is read.

mod check;
mod closest;
mod documents;
mod error;
#[cfg(test)]
mod fixture;
mod motion;
mod policy;
mod polynomial;
mod report;
mod scene;
mod solid;
mod vector;

pub use error::CheckerError;
pub use report::{Finding, PairName, Quantity, Report};

use graspcheck_recording::Recording;

/// What is taken off every gap for rounding, m. Poses and supports of an arm that reaches 8 m are rounded by
/// less than 1e-13 m and joint ranges by less than 1e-12 rad; proofs take off twice as much, so that those
/// that hold by a hair are still confirmed.
pub const ROUNDING: f64 = 5e-10;

/// Coordinates (m) and joint positions (rad, m) that are not smaller than this are rounded too coarsely for
/// [`ROUNDING`]: with them nothing is confirmed.
pub const LARGEST: f64 = 1e4;

/// Validates the certificate of a recording against the robot, cell, object and plan in it.
///
/// # Errors
/// When a document is missing, cannot be decoded, has another form than this version knows, or contradicts
/// itself, so that there is nothing to check. A certificate that is wrong is no error: the report says so.
pub fn check(recording: &Recording) -> Result<Report, CheckerError> {
    Ok(check::certificate(&documents::Documents::read(recording)?))
}
