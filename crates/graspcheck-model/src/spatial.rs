//! Vectors and rotations of any [`Scalar`]: the little linear algebra that kinematics and dynamics need when
//! they are computed with intervals or with rates.
//!
//! nalgebra stays the linear algebra of everything else. Its products multiply by one and add zero, which is
//! exact for floats and not free for intervals, and it has no product of a constant float matrix with a
//! vector of another kind; here constants stay floats.
//!
//! ```
//! use graspcheck_model::{Pose, spatial::{Frame, Vector}};
//! use graspcheck_motion::Dual;
//! use nalgebra::Vector3;
//!
//! // A point 2 m along x of a frame that is turned by 90° about z and stands at (1, 0, 0).
//! let pose = Pose::new(Vector3::x(), Vector3::z() * std::f64::consts::FRAC_PI_2);
//! let [x, y, z] = Frame::constant(&pose).apply(Vector([2.0, 0.0, 0.0])).0;
//! assert!((x - 1.0).abs() < 1e-15 && (y - 2.0).abs() < 1e-15 && z == 0.0);
//! // The same with a point that moves: its velocity turns along.
//! let along = Dual { value: 2.0, rate: 3.0 };
//! let moved = Frame::constant(&pose).apply(Vector::along(&Vector3::x(), along));
//! assert!((moved.0[1].rate - 3.0).abs() < 1e-15);
//! ```

use std::ops::{Add, AddAssign, Sub};

use graspcheck_motion::Scalar;
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

use crate::Pose;

/// Three coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vector<S>(pub [S; 3]);

impl<S: Scalar> Vector<S> {
    /// The vector of zeros.
    #[inline]
    #[must_use]
    pub fn zero() -> Self {
        Self([S::from(0.0); 3])
    }

    /// A vector that does not vary.
    #[inline]
    #[must_use]
    pub fn constant(value: &Vector3<f64>) -> Self {
        Self([S::from(value.x), S::from(value.y), S::from(value.z)])
    }

    /// A constant direction, or any constant vector, times a number.
    #[inline]
    #[must_use]
    pub fn along(direction: &Vector3<f64>, length: S) -> Self {
        Self([length.scaled(direction.x), length.scaled(direction.y), length.scaled(direction.z)])
    }

    /// The cross product `self × other`.
    #[inline]
    #[must_use]
    pub fn cross(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([b * z - c * y, c * x - a * z, a * y - b * x])
    }

    /// The cross product `self × other` with a constant.
    #[inline]
    #[must_use]
    pub fn cross_constant(self, other: &Vector3<f64>) -> Self {
        let [a, b, c] = self.0;
        let (x, y, z) = (other.x, other.y, other.z);
        Self([b.scaled(z) - c.scaled(y), c.scaled(x) - a.scaled(z), a.scaled(y) - b.scaled(x)])
    }

    /// The dot product with a constant.
    #[inline]
    #[must_use]
    pub fn dot_constant(self, other: &Vector3<f64>) -> S {
        self.0[0].scaled(other.x) + self.0[1].scaled(other.y) + self.0[2].scaled(other.z)
    }

    /// The vector times a constant.
    #[inline]
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Self(self.0.map(|x| x.scaled(factor)))
    }

    /// A constant matrix times this vector.
    #[inline]
    #[must_use]
    pub fn mapped(self, matrix: &Matrix3<f64>) -> Self {
        let [x, y, z] = self.0;
        Self(std::array::from_fn(|i| {
            x.scaled(matrix[(i, 0)]) + y.scaled(matrix[(i, 1)]) + z.scaled(matrix[(i, 2)])
        }))
    }
}

impl<S: Scalar> Add for Vector<S> {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([a + x, b + y, c + z])
    }
}

impl<S: Scalar> AddAssign for Vector<S> {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<S: Scalar> Sub for Vector<S> {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([a - x, b - y, c - z])
    }
}

impl Vector<f64> {
    /// The same vector for nalgebra.
    #[must_use]
    pub fn to_vector3(self) -> Vector3<f64> {
        Vector3::from(self.0)
    }
}

/// A rotation matrix, by rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotation<S>(pub [Vector<S>; 3]);

impl<S: Scalar> Rotation<S> {
    /// A rotation that does not vary.
    #[must_use]
    pub fn constant(matrix: &Matrix3<f64>) -> Self {
        Self(std::array::from_fn(|i| Vector(std::array::from_fn(|j| S::from(matrix[(i, j)])))))
    }

    /// Turns a vector: `a_from_b * v_b = v_a`.
    #[inline]
    #[must_use]
    pub fn turn(&self, vector: Vector<S>) -> Vector<S> {
        let [x, y, z] = vector.0;
        Vector(self.0.map(|Vector([a, b, c])| a * x + b * y + c * z))
    }

    /// Turns a vector back: `a_from_b⁻¹ * v_a = v_b`.
    #[inline]
    #[must_use]
    pub fn turn_back(&self, vector: Vector<S>) -> Vector<S> {
        let ([Vector(a), Vector(b), Vector(c)], [x, y, z]) = (self.0, vector.0);
        Vector(std::array::from_fn(|i| a[i] * x + b[i] * y + c[i] * z))
    }

    /// The product of two rotations: `a_from_b * b_from_c = a_from_c`.
    #[inline]
    #[must_use]
    pub fn then(&self, other: &Self) -> Self {
        Self(self.0.map(|row| other.turn_back(row)))
    }
}

/// A rigid transform `a_from_b`: it maps coordinates in b to coordinates in a.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame<S> {
    /// The axes of b in a.
    pub rotation: Rotation<S>,
    /// The origin of b in a, m.
    pub origin: Vector<S>,
}

impl<S: Scalar> Frame<S> {
    /// A transform that does not vary.
    #[must_use]
    pub fn constant(pose: &Pose) -> Self {
        Self {
            rotation: Rotation::constant(pose.rotation.to_rotation_matrix().matrix()),
            origin: Vector::constant(&pose.translation.vector),
        }
    }

    /// The product of two transforms: `a_from_b * b_from_c = a_from_c`.
    #[inline]
    #[must_use]
    pub fn then(&self, other: &Self) -> Self {
        Self { rotation: self.rotation.then(&other.rotation), origin: self.apply(other.origin) }
    }

    /// A point of b in the coordinates of a.
    #[inline]
    #[must_use]
    pub fn apply(&self, point: Vector<S>) -> Vector<S> {
        self.origin + self.rotation.turn(point)
    }
}

impl Frame<f64> {
    /// The same transform as one that does not vary, of another kind of numbers.
    #[inline]
    #[must_use]
    pub fn lifted<S: Scalar>(&self) -> Frame<S> {
        let lift = |Vector(v): Vector<f64>| Vector(v.map(S::from));
        Frame { rotation: Rotation(self.rotation.0.map(lift)), origin: lift(self.origin) }
    }

    /// The same transform as a pose.
    ///
    /// ```
    /// use graspcheck_model::{Pose, spatial::Frame};
    /// use nalgebra::Vector3;
    /// let world_from_tool = Pose::new(Vector3::new(0.1, 0.2, 0.3), Vector3::new(0.0, 0.0, 1.0));
    /// let back = Frame::constant(&world_from_tool).to_pose();
    /// assert!((back.to_homogeneous() - world_from_tool.to_homogeneous()).amax() < 1e-15);
    /// ```
    #[must_use]
    pub fn to_pose(&self) -> Pose {
        let rows = self.rotation.0.map(|row| row.to_vector3().transpose());
        let matrix = Rotation3::from_matrix_unchecked(Matrix3::from_rows(&rows));
        Pose::from_parts(self.origin.to_vector3().into(), UnitQuaternion::from_rotation_matrix(&matrix))
    }
}
