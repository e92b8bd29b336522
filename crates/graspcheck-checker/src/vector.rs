//! Vectors and rigid transforms: just the arithmetic that is needed here.

use std::ops::{Add, Mul, Neg, Sub};

use serde::Deserialize;

/// How far the length of a rotation or a direction in a document may be from 1: rounding, and no more.
pub(crate) const UNIT_TOLERANCE: f64 = 1e-12;

/// A vector or a point; m where it is a length.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
pub(crate) struct Vector(pub(crate) [f64; 3]);

impl Vector {
    pub(crate) const ZERO: Self = Self([0.0; 3]);

    /// Along an axis of the frame.
    pub(crate) fn unit(axis: usize) -> Self {
        let mut unit = Self::ZERO;
        unit.0[axis] = 1.0;
        unit
    }

    pub(crate) fn dot(self, other: Self) -> f64 {
        self.0[0] * other.0[0] + self.0[1] * other.0[1] + self.0[2] * other.0[2]
    }

    pub(crate) fn cross(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([b * z - c * y, c * x - a * z, a * y - b * x])
    }

    pub(crate) fn length(self) -> f64 {
        self.dot(self).sqrt()
    }

    /// Whether every coordinate is smaller than `bound`; not where one is NaN.
    pub(crate) fn is_within(self, bound: f64) -> bool {
        self.0.iter().all(|x| x.abs() < bound)
    }
}

impl Add for Vector {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self([self.0[0] + other.0[0], self.0[1] + other.0[1], self.0[2] + other.0[2]])
    }
}

impl Sub for Vector {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Neg for Vector {
    type Output = Self;
    fn neg(self) -> Self {
        Self(self.0.map(|x| -x))
    }
}

impl Mul<f64> for Vector {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self(self.0.map(|x| x * factor))
    }
}

/// A direction of length 1.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(try_from = "Vector")]
pub(crate) struct Direction(pub(crate) Vector);

impl TryFrom<Vector> for Direction {
    type Error = String;

    fn try_from(vector: Vector) -> Result<Self, String> {
        is_one(vector.length())
            .then_some(Self(vector))
            .ok_or_else(|| format!("direction {vector:?}: its length is not 1"))
    }
}

/// A rigid transform: a rotation by its columns, then a shift. `a_from_b.point(p)` is p of b, in a.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(try_from = "PoseForm")]
pub(crate) struct Pose {
    columns: [Vector; 3],
    pub(crate) origin: Vector,
}

/// A pose in a document; the rotation is the quaternion `[x, y, z, w]`.
#[derive(Deserialize)]
struct PoseForm {
    rotation: [f64; 4],
    translation: Vector,
}

impl TryFrom<PoseForm> for Pose {
    type Error = String;

    fn try_from(form: PoseForm) -> Result<Self, String> {
        let [x, y, z, w] = form.rotation;
        if !is_one((x * x + y * y + z * z + w * w).sqrt()) {
            return Err(format!("rotation {:?}: the length of the quaternion is not 1", form.rotation));
        }
        let columns = [
            Vector([1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)]),
            Vector([2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)]),
            Vector([2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)]),
        ];
        Ok(Self { columns, origin: form.translation })
    }
}

fn is_one(length: f64) -> bool {
    (length - 1.0).abs() <= UNIT_TOLERANCE
}

impl Pose {
    pub(crate) const IDENTITY: Self = Self::shift(Vector::ZERO);

    /// A shift without a rotation.
    pub(crate) const fn shift(origin: Vector) -> Self {
        Self { columns: [Vector([1.0, 0.0, 0.0]), Vector([0.0, 1.0, 0.0]), Vector([0.0, 0.0, 1.0])], origin }
    }

    /// The rotation by an angle (rad) about an axis through the origin (Rodrigues).
    pub(crate) fn turn(axis: Direction, angle: f64) -> Self {
        let (Direction(a), (sin, cos)) = (axis, angle.sin_cos());
        let turned = |v: Vector| v * cos + a.cross(v) * sin + a * (a.dot(v) * (1.0 - cos));
        Self { columns: Self::IDENTITY.columns.map(turned), origin: Vector::ZERO }
    }

    /// A vector, turned.
    pub(crate) fn vector(&self, v: Vector) -> Vector {
        self.columns[0] * v.0[0] + self.columns[1] * v.0[1] + self.columns[2] * v.0[2]
    }

    /// A point, turned and shifted.
    pub(crate) fn point(&self, p: Vector) -> Vector {
        self.vector(p) + self.origin
    }

    /// A vector, turned back.
    pub(crate) fn vector_back(&self, v: Vector) -> Vector {
        Vector(self.columns.map(|column| column.dot(v)))
    }
}

impl Mul for Pose {
    type Output = Self;
    fn mul(self, inner: Self) -> Self {
        Self { columns: inner.columns.map(|column| self.vector(column)), origin: self.point(inner.origin) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{pose, read};

    #[test]
    fn a_quaternion_and_a_turn_about_the_same_axis_agree() {
        let axis = [2.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0];
        for angle in [0.0, 0.3, -1.7, 3.0, 9.0] {
            let read: Pose = read(pose([0.1, 0.2, 0.3], axis, angle));
            let built = Pose::shift(Vector([0.1, 0.2, 0.3])) * Pose::turn(Direction(Vector(axis)), angle);
            for v in [Vector([1.0, 0.0, 0.0]), Vector([0.3, -2.0, 0.5])] {
                assert!((read.point(v) - built.point(v)).length() < 1e-14, "{angle}");
                assert!((read.vector_back(read.vector(v)) - v).length() < 1e-14);
            }
        }
    }

    #[test]
    fn a_quarter_turn_about_z_takes_x_to_y_and_transforms_are_applied_from_the_right() {
        let quarter = Pose::turn(Direction(Vector([0.0, 0.0, 1.0])), std::f64::consts::FRAC_PI_2);
        assert!((quarter.vector(Vector([1.0, 0.0, 0.0])) - Vector([0.0, 1.0, 0.0])).length() < 1e-15);
        let aside = Pose::shift(Vector([1.0, 0.0, 0.0]));
        assert!(((quarter * aside).origin - Vector([0.0, 1.0, 0.0])).length() < 1e-15);
        assert!(((aside * quarter).origin - Vector([1.0, 0.0, 0.0])).length() < 1e-15);
    }

    #[test]
    fn what_has_another_length_than_1_is_refused() {
        let turned = serde_json::json!({"translation": [0.0, 0.0, 0.0], "rotation": [0.0, 0.0, 1e-5, 1.0]});
        assert!(serde_json::from_value::<Pose>(turned).is_err());
        assert!(serde_json::from_value::<Direction>(serde_json::json!([0.0, 1e-5, 1.0])).is_err());
        assert!(!Vector([0.0, f64::NAN, 0.0]).is_within(1.0) && !Vector([0.0, 0.0, -1.0]).is_within(1.0));
    }
}
