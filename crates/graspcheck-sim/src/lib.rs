//! Executes a plan on a rapier multibody: plant, controller, gripper, step loop.
//!
//! [`simulate`] takes robot, cell, object and plan as data and returns a [`Recording`] of what happened.
//! The plant is independent of the controller: joint torques go in, joint positions come out, and a torque
//! that the motors cannot give shows as saturation and as tracking error. The object is held by friction
//! between pads and faces, never by a weld.
//!
//! Trust in the plant is not assumed: before the first step the built multibody is compared with the
//! model's own dynamics (mass matrix and bias forces at several states), and the run is refused when they
//! differ ([`SimError::ModelMismatch`]).
//!
//! What a row of the recording means: row k is the state at `t = k·dt`, *before* step k, with the efforts
//! that act during that step and the contact forces that the step needed. Times are integer nanoseconds.
//!
//! Bodies of the robot touch each other as they touch everything else, and that is recorded. Only pairs in
//! the robot's allowed contacts pass through each other: links that overlap at their joint would otherwise
//! push themselves apart.
//!
//! Frames: W world, B base, L links, T tool, O object. Symbols: `q`, `qd`, `qdd` joint positions,
//! velocities, accelerations (rad or m). In arrays of joints the arm comes first, then the two fingers.
//!
//! Reading order: [`error`], then the private modules `validate`, `builder` and `plant` (robot, cell and object as
//! rapier bodies), `self_test`, `encoders`, `controller`, `drives`, `gripper`, `reality` (what is not as declared),
//! `contacts`, `stride`, `guard`, `recorder`, `run`.

mod arc;
mod builder;
mod clock;
mod contacts;
mod controller;
mod convert;
mod drives;
mod encoders;
pub mod error;
mod exact;
pub mod fidelity;
#[cfg(test)]
mod fixtures;
mod gripper;
mod guard;
mod mass;
mod plant;
mod random;
mod reality;
mod recorder;
pub mod reintegration;
mod run;
mod self_test;
mod solid;
mod stride;
mod tool;
mod validate;

#[cfg(doc)]
use graspcheck_recording::Recording;

pub use error::SimError;
pub use guard::START_DEPTH_MAX;
pub use recorder::phase_events;
pub use run::simulate;

/// The physics that runs below, with its version: its semantics move in patch releases, so baselines carry
/// it.
pub const PHYSICS: &str = "rapier3d-f64 0.36.1";

#[cfg(test)]
mod tests {
    #[test]
    fn the_named_physics_is_the_pinned_one() {
        let manifest = include_str!("../../../Cargo.toml");
        let version = super::PHYSICS.strip_prefix("rapier3d-f64 ").unwrap();
        let pinned = format!(r#"rapier3d = {{ package = "rapier3d-f64", version = "={version}" }}"#);
        assert!(manifest.contains(&pinned), "{pinned}");
    }
}
