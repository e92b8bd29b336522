//! What stands around the robot, and how far it must keep away from it.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::{Pose, shape::Shape};

/// Everything that does not move, and the gravity it stands in.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    /// Gravity in the world frame, m/s².
    pub gravity: Vector3<f64>,
    /// The bodies of the cell.
    pub bodies: Vec<CellBody>,
    /// How far pairs of bodies must keep apart.
    pub clearance: ClearanceRule,
}

/// A fixed convex body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CellBody {
    /// Its name, unique among all bodies of a scene.
    pub name: String,
    /// The solid.
    pub shape: Shape,
    /// From the shape's own frame to the world.
    pub world_from_shape: Pose,
}

/// The distance that bodies must keep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClearanceRule {
    /// For every pair that is not named below and not allowed to touch, m.
    pub required: f64,
    /// Pairs with a distance of their own.
    pub pairs: Vec<PairRule>,
}

/// The distance that one pair must keep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PairRule {
    /// Name of one body, or `gripper` for the last link and both fingers, or `robot` for all its links.
    pub a: String,
    /// Name of the other.
    pub b: String,
    /// The distance, m.
    pub required: f64,
    /// Why it differs.
    pub reason: String,
}
