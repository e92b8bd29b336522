//! Robot, cell, object, task and plan as data, with the kinematics and dynamics of serial arms.
//!
//! Everything here is constant data that says what is; state (joint positions, poses) is passed in. Units
//! are SI and radians, unmarked: a prismatic joint counts in m, N, a revolute one in rad, N·m.
//!
//! Frames: W world, B base, L1…Ln links (the frame of link k is the frame of joint k, at its child side),
//! T tool, O object, H handle. A transform `a_from_b` maps coordinates in b to coordinates in a, so that
//! names cancel: `world_from_tool = world_from_base * base_from_tool`.
//!
//! The tool frame T sits between the finger pads: its **x axis points out of the gripper** (the direction
//! in which it approaches), its **y axis is the direction in which the fingers close**. A handle H on an
//! object has its x axis pointing towards the object; the object is grasped when T and H coincide.
//!
//! Reading order. The data: [`shape`], [`inertia`], [`robot`], [`cell`], [`object`], [`task`], [`plan`],
//! [`execution`]. What is computed from it: [`kinematics`], [`structure`] and [`inverse`], [`dynamics`].
//! Where a robot comes from: [`urdf`] and [`settings`], put together by [`assemble`].
//!
//! Each number has two ways to it. Poses come from quaternions ([`kinematics`]), from closed forms ([`structure`]) and
//! from a product of matrices for any arm ([`chain`]). Joint positions come from closed forms with all branches
//! ([`inverse`]; [`reach`] says why there are none) and from a search for any arm ([`numerical`]). [`singularity`] has a
//! formula and singular values. Torques at an instant ([`dynamics`]) are one recursion
//! over different numbers ([`spatial`]); [`torque_bounds`] and [`tool_bounds`] bound what a motion takes and how fast its
//! tool is over a stretch of time.

pub mod assemble;
pub mod cell;
pub mod chain;
pub mod convex_hull;
pub mod dynamics;
pub mod error;
pub mod example;
pub mod execution;
mod gripper;
mod hinge;
pub mod inertia;
pub mod inverse;
pub mod jacobian_bounds;
pub mod kinematics;
mod majorant;
pub mod numerical;
pub mod object;
pub mod plan;
pub mod planar_path;
pub mod reach;
pub mod robot;
pub mod settings;
pub mod shape;
pub mod singularity;
pub mod spatial;
pub mod structure;
pub mod task;
pub mod tool_bounds;
pub mod tool_path;
pub mod torque_bounds;
pub mod urdf;
pub mod via;

/// A rigid transform; the name of a variable says between which frames.
pub type Pose = nalgebra::Isometry3<f64>;
