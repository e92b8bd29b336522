//! Mass properties of rigid bodies.
//!
//! ```
//! use graspcheck_model::{Pose, inertia::Inertial, shape::Shape};
//! use nalgebra::Vector3;
//!
//! // Two balls of 1 kg and 0.1 m, 1 m apart: 2·(2/5 m r²) along the line, and 2·m·(1/2)² more across it.
//! let ball = Shape::Sphere { radius: 0.1 }.inertial(1.0);
//! let beside = ball.transformed(&Pose::new(Vector3::x(), Vector3::zeros()));
//! let both = Inertial::combine(&[ball, beside]);
//! assert_eq!((both.mass, both.center.x), (2.0, 0.5));
//! assert!((both.tensor[(0, 0)] - 0.008).abs() < 1e-15 && (both.tensor[(1, 1)] - 0.508).abs() < 1e-15);
//! assert!(both.validate().is_ok());
//! ```

use nalgebra::{Matrix3, Point3, Vector3};
use serde::{Deserialize, Serialize};

use crate::{Pose, error::ModelError};

/// How far the moments of inertia may break the triangle inequality, and the tensor its symmetry, relative
/// to the largest moment: numbers in files are rounded to about six digits, and a flat plate meets the
/// inequality with equality.
pub const INERTIA_TOLERANCE: f64 = 1e-6;

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

impl Inertial {
    /// No mass at all: what a body contributes that is not there.
    #[must_use]
    pub fn massless() -> Self {
        Self { mass: 0.0, center: Point3::origin(), tensor: Matrix3::zeros() }
    }

    /// The same body with its mass properties given in frame a, when `self` gives them in frame b.
    #[must_use]
    pub fn transformed(&self, a_from_b: &Pose) -> Self {
        let rotation = a_from_b.rotation.to_rotation_matrix();
        Self {
            mass: self.mass,
            center: a_from_b * self.center,
            tensor: rotation.matrix() * self.tensor * rotation.matrix().transpose(),
        }
    }

    /// The mass properties of all `parts` as one rigid body; all are given in the same frame.
    #[must_use]
    pub fn combine(parts: &[Self]) -> Self {
        let mass: f64 = parts.iter().map(|part| part.mass).sum();
        if mass == 0.0 {
            return Self::massless();
        }
        let moment: Vector3<f64> = parts.iter().map(|part| part.center.coords * part.mass).sum();
        let center = Point3::from(moment / mass);
        let tensor = parts.iter().map(|part| part.tensor_about(&center)).sum();
        Self { mass, center, tensor }
    }

    /// The inertia tensor about another point, axes parallel to the body's frame (the parallel axis
    /// theorem of Huygens and Steiner), kg·m².
    #[must_use]
    pub fn tensor_about(&self, point: &Point3<f64>) -> Matrix3<f64> {
        let d = self.center - point;
        self.tensor + (Matrix3::identity() * d.norm_squared() - d * d.transpose()) * self.mass
    }

    /// Nothing, when a rigid body with these mass properties can exist: the mass is positive, the tensor
    /// symmetric and positive definite, and no principal moment exceeds the sum of the two others.
    ///
    /// # Errors
    /// The first of these that does not hold, with its value.
    pub fn validate(&self) -> Result<(), ModelError> {
        if !(self.mass > 0.0 && self.mass.is_finite()) {
            return Err(ModelError::Mass { mass: self.mass });
        }
        if !self.center.iter().chain(self.tensor.iter()).all(|value| value.is_finite()) {
            return Err(ModelError::NotFinite);
        }
        let skew = (self.tensor - self.tensor.transpose()).amax();
        if skew > INERTIA_TOLERANCE * self.tensor.amax() {
            return Err(ModelError::TensorNotSymmetric { difference: skew });
        }
        let mut moments: [f64; 3] = self.tensor.symmetric_eigenvalues().into();
        moments.sort_by(f64::total_cmp);
        let [least, middle, largest] = moments;
        if least <= 0.0 {
            return Err(ModelError::TensorNotPositive { moment: least });
        }
        if largest - (least + middle) > INERTIA_TOLERANCE * largest {
            return Err(ModelError::TensorTriangle { largest, sum: least + middle });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{UnitQuaternion, Vector3};

    use super::*;
    use crate::shape::Shape;

    fn with_moments(x: f64, y: f64, z: f64) -> Inertial {
        Inertial {
            mass: 1.0,
            center: Point3::origin(),
            tensor: Matrix3::from_diagonal(&Vector3::new(x, y, z)),
        }
    }

    #[test]
    fn two_half_boxes_make_the_whole_box_in_any_frame() {
        let half = Shape::Box { half_extents: Vector3::new(0.1, 0.2, 0.15) }.inertial(1.0);
        let whole = Shape::Box { half_extents: Vector3::new(0.2, 0.2, 0.15) }.inertial(2.0);
        let placed = Pose::from_parts(
            Vector3::new(1.0, -2.0, 0.5).into(),
            UnitQuaternion::from_euler_angles(0.3, -0.7, 1.9),
        );
        let side = |x: f64| half.transformed(&(placed * nalgebra::Translation3::new(x, 0.0, 0.0)));
        let combined = Inertial::combine(&[side(-0.1), side(0.1)]);
        let expected = whole.transformed(&placed);
        assert!((combined.tensor - expected.tensor).amax() < 1e-14);
        assert!((combined.center - expected.center).norm() < 1e-14);
        assert!((combined.mass - 2.0).abs() < 1e-15);
    }

    #[test]
    fn combining_nothing_or_adding_nothing_changes_nothing() {
        assert_eq!(Inertial::combine(&[]), Inertial::massless());
        let part = with_moments(1.0, 2.0, 2.5);
        assert_eq!(Inertial::combine(&[part.clone(), Inertial::massless()]), part);
    }

    #[test]
    fn impossible_bodies_are_refused_and_a_flat_plate_is_not() {
        assert!(with_moments(1.0, 1.0, 2.0).validate().is_ok());
        assert!(matches!(with_moments(1.0, 1.0, 2.1).validate(), Err(ModelError::TensorTriangle { .. })));
        assert!(matches!(with_moments(1.0, -1.0, 1.0).validate(), Err(ModelError::TensorNotPositive { .. })));
        let mut skew = with_moments(1.0, 1.0, 1.0);
        skew.tensor[(0, 1)] = 0.1;
        assert!(matches!(skew.validate(), Err(ModelError::TensorNotSymmetric { .. })));
        let weightless = Inertial { mass: 0.0, ..with_moments(1.0, 1.0, 1.0) };
        assert_eq!(weightless.validate(), Err(ModelError::Mass { mass: 0.0 }));
        let unknown = Inertial { mass: f64::NAN, ..with_moments(1.0, 1.0, 1.0) };
        assert!(matches!(unknown.validate(), Err(ModelError::Mass { .. })));
    }
}
