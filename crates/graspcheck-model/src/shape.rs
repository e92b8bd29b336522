//! Convex solids, the only geometry that collides.

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

use crate::Pose;

/// A convex solid in its own frame, lengths in m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// A box centred on the origin, with these half lengths along x, y and z.
    Box {
        /// Half lengths, m.
        half_extents: Vector3<f64>,
    },
    /// A ball centred on the origin.
    Sphere {
        /// Radius, m.
        radius: f64,
    },
    /// A cylinder centred on the origin with its axis along **z** (as in URDF).
    Cylinder {
        /// Radius, m.
        radius: f64,
        /// Half of its length along z, m.
        half_length: f64,
    },
    /// All points within `radius` of a segment along z centred on the origin.
    Capsule {
        /// Radius, m.
        radius: f64,
        /// Half of the segment's length along z, m (the whole solid is longer by the radius at each end).
        half_length: f64,
    },
    /// The convex hull of these points.
    Hull {
        /// At least four points that do not lie in a plane, m.
        points: Vec<Point3<f64>>,
    },
}

/// A shape with a place in the frame of the body that carries it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlacedShape {
    /// From the shape's own frame to the frame of the body.
    pub body_from_shape: Pose,
    /// The solid.
    pub shape: Shape,
}
