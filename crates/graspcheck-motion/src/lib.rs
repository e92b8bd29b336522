//! Motions of joints over time, exact between samples.
//!
//! A [`Trajectory`] is the one representation of a commanded motion: common knots, and on each interval
//! one [`Polynomial`] of degree at most 7 per joint in local time. Whatever is executed is evaluated from
//! it and whatever is checked is computed from it, so that nothing hides between samples.
//!
//! Symbols used as names in this crate: `q qd qdd qddd` are position, velocity, acceleration and jerk of a
//! joint. Units are SI and radians: a revolute joint counts in rad, a prismatic one in m, time in s.
//!
//! Extrema are computed, not sampled, in two independent ways: exactly by the derivative chain
//! ([`extrema`], [`peaks`]) and as rounding-safe bounds from Bernstein coefficients ([`bernstein`]).
//!
//! Proofs compute with sets instead of samples: an [`Interval`] encloses every value that a formula takes over
//! a box, rounding included, and [`Trajectory::enclose`] says where a joint is throughout a stretch of time. A
//! formula written over [`Scalar`] serves floats, intervals and, with [`Dual`], derivatives alike.
//!
//! Reading order: [`polynomial`], [`trajectory`], [`continuity`], [`extrema`], [`peaks`], [`bernstein`]; then
//! [`interval`], [`scalar`], [`dual`], [`jet`], [`enclosure`].

pub mod bernstein;
pub mod continuity;
pub mod dual;
pub mod enclosure;
pub mod extrema;
pub mod interval;
pub mod jet;
pub mod peaks;
pub mod polynomial;
pub mod scalar;
pub mod trajectory;

pub use continuity::{Continuity, ContinuityClass, Jump};
pub use dual::Dual;
pub use enclosure::MotionBounds;
pub use extrema::Extremum;
pub use interval::{Interval, IntervalError};
pub use jet::{Jet, Real, taylor_model};
pub use peaks::Peak;
pub use polynomial::Polynomial;
pub use scalar::{Scalar, Signed};
pub use trajectory::{Break, MotionState, Trajectory, TrajectoryError};
