//! The proofs as a user of the crate sees them.

#[path = "../trial/mod.rs"]
mod trial;

mod campaign;
mod distance;
mod limits_and_torque;
mod metamorphic;
mod thin_and_grazing;
