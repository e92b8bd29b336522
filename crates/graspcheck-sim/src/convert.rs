//! Between nalgebra, which is our linear algebra, and glam, which is rapier's.

use graspcheck_model::Pose;
use nalgebra::{Point3, UnitQuaternion, Vector3};
use rapier3d::math::{Pose as RapierPose, Rotation, Vector};

pub(crate) fn to_rapier(pose: &Pose) -> RapierPose {
    (*pose).into()
}

pub(crate) fn from_rapier(pose: &RapierPose) -> Pose {
    (*pose).into()
}

pub(crate) fn vector_to_rapier(vector: &Vector3<f64>) -> Vector {
    (*vector).into()
}

pub(crate) fn point_to_rapier(point: &Point3<f64>) -> Vector {
    (*point).into()
}

pub(crate) fn vector_from_rapier(vector: Vector) -> Vector3<f64> {
    vector.into()
}

pub(crate) fn rotation_to_rapier(rotation: &UnitQuaternion<f64>) -> Rotation {
    (*rotation).into()
}
