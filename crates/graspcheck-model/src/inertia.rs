//! Mass properties of rigid bodies.

use nalgebra::{Matrix3, Point3};
use serde::{Deserialize, Serialize};

/// Mass, centre of mass and inertia of a rigid body, all in the frame of that body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Inertial {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass, m.
    pub center: Point3<f64>,
    /// Inertia tensor about the centre of mass, axes parallel to the body's frame (a rotated inertial
    /// frame of a URDF has been rotated into it), kg·m².
    pub tensor: Matrix3<f64>,
}
