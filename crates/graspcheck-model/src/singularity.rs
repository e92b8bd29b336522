//! How far an arm is from a singular pose, where it loses a direction of motion and a straight line asks for
//! unbounded joint speeds.
//!
//! For the arms with a closed form the distance has a formula. The wrist of two links moves with a Jacobian of
//! determinant `l₁ l₂ sin φ₂` (Siciliano et al., *Robotics: Modelling, Planning and Control*, 3.3): it is singular
//! when straight (φ₂ = 0, at the outer radius l₁ + l₂) and when folded (φ₂ = π, at the inner radius |l₁ − l₂|), and
//! nowhere else. [`InverseKinematics::singularity`] names the nearer of the two and gives the distance in three
//! measures.
//!
//! For any chain the singular values of the Jacobian tell: the smallest is the speed of the tool, at worst, for
//! joint speeds of norm 1, and their product is Yoshikawa's manipulability ("Manipulability of robotic
//! mechanisms", 1985). [`SerialChain::dexterity`] computes them; for the two families the product, with metres and
//! radians counted alike, is `l₁ l₂ |sin φ₂|` again.
//!
//! ```
//! use graspcheck_model::{chain::SerialChain, example, inverse::InverseKinematics, singularity::SingularPose};
//!
//! let robot = example::scara();
//! let q = [0.3, 0.1, -0.1, 0.0];
//! let near = InverseKinematics::new(&robot)?.singularity(&q);
//! assert_eq!(near.nearest, SingularPose::Straight);
//! assert_eq!(near.to_string(), "elbow 0.100000 rad from straight, wrist 0.000555 m from the edge of its reach");
//! let dexterity = SerialChain::of(&robot).dexterity(&q, 1.0);
//! assert!((dexterity.manipulability - near.determinant).abs() < 1e-15);
//! # Ok::<(), graspcheck_model::inverse::Unreachable>(())
//! ```

use std::{
    f64::consts::{PI, TAU},
    fmt,
};

use nalgebra::{DVector, Matrix6xX, Vector6};

use crate::{chain::SerialChain, inverse::InverseKinematics};

/// The poses in which an arm of two links loses a direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SingularPose {
    /// Stretched out: the wrist at its greatest distance from axis 1.
    Straight,
    /// The forearm back along the upper arm: the wrist at its least distance.
    Folded,
}

impl fmt::Display for SingularPose {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Straight => "straight",
            Self::Folded => "folded",
        })
    }
}

/// How far an arm with a closed form is from being singular.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Singularity {
    /// The singular pose that is nearer, by the elbow's angle.
    pub nearest: SingularPose,
    /// Angle of the elbow from it, rad; from 0 to π/2.
    pub angle: f64,
    /// Distance of the wrist from the circle on which it would be singular, m.
    pub wrist_distance: f64,
    /// `l₁ l₂ |sin φ₂|`, m²: the magnitude of the determinant of the wrist's Jacobian.
    pub determinant: f64,
}

impl fmt::Display for Singularity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let edge = match self.nearest {
            SingularPose::Straight => "the edge of its reach",
            SingularPose::Folded => "the inner hole",
        };
        let Self { nearest, angle, wrist_distance, .. } = self;
        write!(f, "elbow {angle:.6} rad from {nearest}, wrist {wrist_distance:.6} m from {edge}")
    }
}

/// How well any chain can move its tool, from the singular values of its Jacobian.
#[derive(Clone, Debug, PartialEq)]
pub struct Dexterity {
    /// All singular values, largest first: as many as there are joints, at most six.
    pub singular_values: Vec<f64>,
    /// Their product: √det(J Jᵀ) with six or more joints, √det(Jᵀ J) with fewer.
    pub manipulability: f64,
    /// The direction of the tool that is hardest to move, of length 1: three linear parts in units of `size` a
    /// second, three angular ones in rad/s, world frame.
    pub hardest: Vector6<f64>,
    /// The joint velocities of norm 1 that move the tool least, when there are at most six joints.
    pub idlest: DVector<f64>,
}

impl Dexterity {
    /// The least singular value; 0 in a singular pose.
    #[must_use]
    pub fn smallest(&self) -> f64 {
        self.singular_values.last().copied().unwrap_or(0.0)
    }
}

impl InverseKinematics {
    /// How far the arm is from a singular pose at joint positions `q`.
    ///
    /// # Panics
    /// When `q` has another length than the arm has joints.
    #[must_use]
    pub fn singularity(&self, q: &[f64]) -> Singularity {
        assert_eq!(q.len(), self.limits.len(), "positions for another number of joints");
        let (upper, fore) = (self.geometry().upper, self.geometry().fore);
        let elbow = q[1] + self.geometry().elbow_zero;
        let from_straight = (elbow - TAU * (elbow / TAU).round()).abs();
        let from_folded = PI - from_straight;
        let distance = self.distance_at(q[1]);
        // (l₁ + l₂)² − r² = 4 l₁ l₂ sin²(φ₂/2) and r² − (l₁ − l₂)² = 4 l₁ l₂ cos²(φ₂/2): nothing cancels.
        let (sin, cos) = (0.5 * elbow).sin_cos();
        let ratio = |square: f64, sum: f64| if sum > 0.0 { 4.0 * upper * fore * square / sum } else { 0.0 };
        let (nearest, angle, wrist_distance) = if from_straight <= from_folded {
            (SingularPose::Straight, from_straight, ratio(sin * sin, upper + fore + distance))
        } else {
            (SingularPose::Folded, from_folded, ratio(cos * cos, distance + (upper - fore).abs()))
        };
        Singularity { nearest, angle, wrist_distance, determinant: upper * fore * elbow.sin().abs() }
    }
}

impl SerialChain {
    /// The singular values of the tool's Jacobian at joint positions `q`, distances in units of `size` (m), which is
    /// how metres compare with radians: the length of the arm where the question is of its whole work space, 1 for
    /// plain SI numbers.
    ///
    /// # Panics
    /// When `q` has another length than the arm has joints, there is no joint, or `size` is not positive.
    #[must_use]
    pub fn dexterity(&self, q: &[f64], size: f64) -> Dexterity {
        assert!(size > 0.0, "a size of {size} m");
        let mut jacobian: Matrix6xX<f64> = self.jacobian(q);
        for mut column in jacobian.column_iter_mut() {
            column.fixed_rows_mut::<3>(0).unscale_mut(size);
        }
        let decomposed = jacobian.svd(true, true);
        let values = &decomposed.singular_values;
        let last = values.len() - 1;
        let left = decomposed.u.expect("it was asked for");
        let right = decomposed.v_t.expect("it was asked for");
        Dexterity {
            singular_values: values.iter().copied().collect(),
            manipulability: values.product(),
            hardest: left.column(last).into_owned(),
            idlest: right.row(last).transpose(),
        }
    }
}
