//! Trials of the proofs: random scenes, and an independent judge of what is proved of them.
//!
//! The judge shares nothing with the proof but the data it judges: shapes, chain, polynomials and certificate. It has
//! its own support functions and distances ([`distance`], [`solid`]), kinematics and speeds ([`motion`]).

#![allow(dead_code, reason = "the tests and the example each use some of these")]
#![allow(unreachable_pub, reason = "shared by a test program and an example, neither of which is a library")]
#![allow(clippy::unwrap_used, reason = "a trial that cannot be built ends the program")]

#[path = "../../src/fixtures.rs"]
pub mod fixtures;

pub mod arms;
pub mod distance;
pub mod forces;
pub mod judge;
pub mod motion;
pub mod random;
pub mod relations;
pub mod solid;
