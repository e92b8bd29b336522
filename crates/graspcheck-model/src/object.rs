//! What is grasped.

use serde::{Deserialize, Serialize};

use crate::{Pose, shape::Shape};

/// A rigid object of uniform density that can be grasped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Object {
    /// Its name, unique among all bodies of a scene.
    pub name: String,
    /// The solid, in the object's frame (its origin is the centre of a box).
    pub shape: Shape,
    /// Mass, kg.
    pub mass: f64,
    /// Coefficient of friction against fingers and cell.
    pub friction: f64,
    /// Where it stands at the start.
    pub world_from_object: Pose,
    /// Where the gripper may hold it.
    pub handles: Vec<Handle>,
}

/// A place where the gripper may hold an object: frame H, its x axis pointing towards the object (the
/// direction of approach), its y axis the direction in which the fingers close.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Handle {
    /// Its name.
    pub name: String,
    /// From the handle's frame to the object's.
    pub object_from_handle: Pose,
    /// Distance between the two faces that the pads touch, m.
    pub width: f64,
    /// Whether the gripper may also hold it turned by half a turn about the handle's x axis.
    pub half_turn: bool,
}
