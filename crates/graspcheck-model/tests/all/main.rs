//! All integration tests of the model in one program: one link instead of eight.

#[path = "../arms/mod.rs"]
mod arms;
mod assemble;
mod dynamics;
mod generic;
mod inverse;
mod kinematics;
mod numerical;
mod reach;
mod urdf;
