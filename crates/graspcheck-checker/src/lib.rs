//! Validates the proofs that a recording carries, from the recording alone.
//!
//! A run proves for every pair of convex solids that they keep the required distance at every instant of the
//! plan, and of every joint that its position, velocity, acceleration and jerk stay within a bound. Its log
//! carries plan and proofs. [`check`] holds them against robot, cell, object and plan: whether every pair and
//! every limit that must be there is, whether each pair has steps from the start to the end of the plan, and
//! whether each step and each bound holds. Formulas stand here a second time, and the list of pairs and of
//! required distances too: nothing of the code that made the proofs is used, and no library but for reading JSON.
//!
//! **A step** is an interval of time, a direction n, a gap and a loss. At the middle of the interval the two
//! solids have a slab across n between them that is at least as wide as the gap; until its ends motion takes
//! no more from it than the loss; so they keep at least gap less loss, and that is at least what is required.
//! All three are computed here. That needs no search: finding a proof is hard, checking one is not.
//!
//! **A sweep** is an interval of time and a box that holds all of a moving solid. It stands in for a step of
//! every pair of that solid and one of the cell whose own box is far enough from it.
//!
//! **A violation** is an instant and a point of each solid; both are looked for in their solids.
//!
//! **A limit** has a bound, and an instant with the value that is met there. Bounds on efforts are not computed
//! here; the report says how many there are ([`Report::unchecked_limits`]).
//!
//! Units are SI and radians. A distance is positive apart and negative overlapping. Names of transforms
//! cancel: `world_from_solid = world_from_link * link_from_solid`.
//!
//! Reading order: `report`, `clearance` and `limits`, then what they compute with: `scene` (which pairs), `policy`
//! (how far apart), `sweep`, `motion` (where and how far it moves), `solid`, `closest`, `polynomial`, `vector`;
//! `documents` is what is read.

mod clearance;
mod closest;
mod demand;
mod documents;
mod error;
#[cfg(test)]
mod fixture;
mod limits;
mod motion;
mod policy;
mod polynomial;
mod report;
mod scene;
mod solid;
mod sweep;
mod vector;

pub use documents::Documents;
pub use error::CheckerError;
pub use report::{Finding, LimitName, LimitQuantity, PairName, Place, Quantity, Report};

use graspcheck_recording::Recording;

/// What is taken off every gap for rounding, m. Poses and supports of an arm that reaches 8 m are rounded by
/// less than 1e-13 m and joint ranges by less than 1e-12 rad; proofs take off twice as much, so that those
/// that hold by a hair are still confirmed.
pub const ROUNDING: f64 = 5e-10;

/// Coordinates (m) and joint positions (rad, m) that are not smaller than this are rounded too coarsely for
/// [`ROUNDING`]: with them nothing is confirmed.
pub const LARGEST: f64 = 1e4;

/// Validates the proofs of a recording against the robot, cell, object and plan in it.
///
/// # Errors
/// When a document is missing, cannot be decoded, has another form than this version knows, or contradicts
/// itself, so that there is nothing to check. A proof that is wrong is no error: the report says so.
pub fn check(recording: &Recording) -> Result<Report, CheckerError> {
    Ok(Documents::read(recording)?.check())
}

impl Documents {
    /// Validates the proofs. Findings come in the order of place and time.
    #[must_use]
    pub fn check(&self) -> Report {
        let mut report = Report::default();
        clearance::check(self, &mut report);
        if let Some(limits) = &self.limits {
            limits::check(self, limits, &mut report);
        }
        let by_start = |x: &Finding, y: &Finding| x.interval[0].total_cmp(&y.interval[0]);
        report.findings.sort_by(|x, y| x.place.cmp(&y.place).then_with(|| by_start(x, y)));
        report
    }
}
