//! Paths, time scalings, via points and the grasp planner.
//!
//! A *path* is geometry, a *time scaling* is a law of time along it, a *trajectory* is both: this crate
//! makes the third from the first two. [`plan`] turns a task into the motion that is executed and checked.
//!
//! What follows a straight line of the tool is planned for the tool ([`cartesian`]) and turned into joint
//! polynomials through the inverse kinematics ([`branch`], [`path`]); everything else is planned
//! in the joints, exactly ([`mod@joint_move`]). Units are SI and radians, frames as in [`graspcheck_model`].
//!
//! Symbols used as names: `q qd qdd qddd` are position, velocity, acceleration and jerk of the joints,
//! `s sd sdd sddd` the path parameter and its derivatives in time, `q_s` a derivative by s.
//!
//! Reading order: [`time_scaling`], [`joint_law`], [`mod@joint_move`], [`via`], [`lfpb`], [`branch`], [`path`],
//! [`cartesian`], [`retime`], [`pick_and_place`], [`candidate`], [`error`].

mod arm;
pub mod branch;
pub mod candidate;
pub mod cartesian;
mod cartesian_via;
pub mod error;
mod input;
pub mod joint_law;
pub mod joint_move;
mod joint_segments;
mod joint_via;
pub mod lfpb;
pub mod opening;
pub mod pace;
pub mod path;
mod path_task;
pub mod pick_and_place;
mod planned;
pub mod retime;
mod sequence;
pub mod set_points;
mod stop;
pub mod time_scaling;
pub mod via;
mod via_motion;

#[cfg(test)]
#[path = "../tests/robots/mod.rs"]
mod robots;

pub use candidate::{Candidate, CandidateOutcome};
pub use cartesian::line;
pub use error::{NothingReachable, PlanError};
pub use joint_move::joint_move;
pub use planned::{Planned, find, plan};
pub use via_motion::ViaMotionError;
