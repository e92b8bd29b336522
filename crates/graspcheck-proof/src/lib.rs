//! Continuous-time proofs of clearance and limits, kept as certificates.
//!
//! A [`Scene`] holds robot, cell and object as convex solids. [`Scene::certify`] proves for every pair of
//! them that a plan keeps the required distance *at every instant*, or finds an instant at which it does
//! not; [`Scene::minimum_margin`] brackets how much room is left. Nothing is sampled: at the middle of an
//! interval of time a slab between two solids is certified by support functions ([`gap`]), a bound on how
//! far motion can carry them (`displacement`) is taken off, and what does not suffice is halved.
//!
//! Three outcomes: free and violated are proofs; what is neither is *unknown* or *not checked*.
//!
//! Clearance is positive apart, zero touching, negative overlapping, in m.
//!
//! Reading order: [`solid`], [`gap`], `chain`, [`scene`], [`contact`], `stretch`, `displacement`,
//! `bounds`, `tree`, [`certify`], [`certificate`], [`minimum`], `peak`, [`torque`], [`tool_speed`], [`singular`], [`sample`],
//! [`hull`].

mod bounds;
mod carried;
pub mod certificate;
pub mod certify;
mod chain;
mod clearance_search;
pub mod contact;
pub mod deviation;
mod displacement;
mod error;
pub mod executed;
#[cfg(test)]
mod fixtures;
pub mod gap;
mod hermite;
pub mod hull;
pub mod logged_motion;
pub mod minimum;
mod peak;
mod range_tree;
pub mod sample;
pub mod scene;
pub mod singular;
pub mod slower;
pub mod solid;
mod stretch;
pub mod tool_speed;
pub mod torque;
pub mod tracking_tube;
mod tree;

pub use certificate::{
    Certificate, Doubt, Leaf, PairCertificate, PairVerdict, ProofOutcome, Sweep, Violation,
};
pub use clearance_search::{CourseClearance, CourseDoubt};
pub use contact::{Contact, RequiredPair};
pub use error::SceneError;
pub use hull::hull_triangles;
pub use logged_motion::{BodyState, JointLog, LoggedMotion, MotionLog, MotionLogError};
pub use minimum::MarginBounds;
pub use sample::Sampler;
pub use scene::Scene;
pub use singular::{Measure, NearestSingular, elbow_changes_side, nearest_singular};
pub use tool_speed::{ToolPeak, keeps_tool_limits, tool_peaks};
pub use torque::{TORQUE_TOLERANCE, TorqueLimits, TorquePeak, keep_torque_limits, torque_peaks};
pub use tracking_tube::TrackingTube;
