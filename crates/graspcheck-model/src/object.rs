//! What is grasped.
//!
//! ```
//! use graspcheck_model::{Pose, object::{Handle, Object}, shape::Shape};
//! use nalgebra::{UnitQuaternion, Vector3};
//!
//! // A cube of 40 mm, held from above: x of the handle points down, its y is the direction of closing.
//! let down = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), std::f64::consts::FRAC_PI_2);
//! let top = Handle {
//!     name: "top".to_owned(),
//!     object_from_handle: Pose::from_parts(Vector3::zeros().into(), down),
//!     width: 0.04,
//!     half_turn: true,
//! };
//! let approach = top.object_from_handle * Vector3::x();
//! assert!((approach + Vector3::z()).norm() < 1e-15);
//! let cube = Object {
//!     name: "cube".to_owned(),
//!     shape: Shape::Box { half_extents: Vector3::repeat(0.02) },
//!     mass: 0.1,
//!     friction: 0.8,
//!     world_from_object: Pose::translation(0.3, 0.1, 0.02),
//!     handles: vec![top],
//! };
//! assert!((cube.shape.inertial(cube.mass).tensor[(2, 2)] - 0.1 * 0.04 * 0.04 / 6.0).abs() < 1e-15);
//! ```

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
