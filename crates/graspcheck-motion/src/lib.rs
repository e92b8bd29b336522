//! Motions of joints over time, exact between samples.
//!
//! A [`Trajectory`] is the one representation of a commanded motion: common knots, and on each interval
//! one [`Polynomial`] of degree at most 7 per joint in local time. Whatever is executed is evaluated from
//! it and whatever is checked is computed from it, so that nothing hides between samples.
//!
//! Symbols used as names in this crate: `q qd qdd qddd` are position, velocity, acceleration and jerk of a
//! joint. Units are SI and radians: a revolute joint counts in rad, a prismatic one in m, time in s.
//!
//! Reading order: [`polynomial`], [`trajectory`].

pub mod polynomial;
pub mod trajectory;

pub use polynomial::Polynomial;
pub use trajectory::{Break, MotionState, Trajectory, TrajectoryError};
