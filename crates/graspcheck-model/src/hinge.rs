//! The motion of one joint, prepared for any [`Scalar`]: what kinematics and dynamics share.

use graspcheck_motion::Scalar;
use nalgebra::{Matrix3, Vector3};

use crate::{
    robot::{Joint, JointKind},
    spatial::{Frame, Rotation, Vector},
};

/// A joint as the constants of its transform.
///
/// A revolute joint turns by Rodrigues' formula, `R(q) = R₀ (1 + sin q K + (1 − cos q) K²)` with the cross
/// matrix K of its axis (Siciliano et al., *Robotics: Modelling, Planning and Control*, 2.5); the products with
/// R₀ are made once.
#[derive(Clone, Debug)]
pub(crate) struct Hinge {
    pub(crate) kind: JointKind,
    /// The axis in the joint's frame.
    pub(crate) axis: Vector3<f64>,
    /// Rotation of the joint's frame at position 0 into the parent's: R₀.
    pub(crate) parent_from_joint: Matrix3<f64>,
    /// R₀ K.
    with_sin: Matrix3<f64>,
    /// R₀ K².
    with_versine: Matrix3<f64>,
    /// Origin of the joint's frame at position 0 in the parent's frame, m.
    pub(crate) origin: Vector3<f64>,
    /// The axis of a prismatic joint in the parent's frame; zero for a revolute one.
    slide: Vector3<f64>,
}

impl Hinge {
    pub(crate) fn new(joint: &Joint) -> Self {
        let parent_from_joint = joint.parent_from_joint.rotation.to_rotation_matrix().into_inner();
        let axis = joint.axis.into_inner();
        let cross = axis.cross_matrix();
        Self {
            kind: joint.kind,
            axis,
            parent_from_joint,
            with_sin: parent_from_joint * cross,
            with_versine: parent_from_joint * cross * cross,
            origin: joint.parent_from_joint.translation.vector,
            slide: match joint.kind {
                JointKind::Revolute => Vector3::zeros(),
                JointKind::Prismatic => parent_from_joint * axis,
            },
        }
    }

    /// From the frame of the link behind the joint at position `q` to the frame of the link before it.
    // Left to itself the compiler calls it from the recursion of the dynamics, which then takes a third longer.
    #[inline(always)]
    pub(crate) fn parent_from_link<S: Scalar>(&self, q: S) -> Frame<S> {
        match self.kind {
            JointKind::Revolute => {
                let (sin, cos) = q.sin_cos();
                let versine = S::from(1.0) - cos;
                let entry = |i, j| {
                    S::from(self.parent_from_joint[(i, j)])
                        + sin.scaled(self.with_sin[(i, j)])
                        + versine.scaled(self.with_versine[(i, j)])
                };
                let row = |i| Vector([entry(i, 0), entry(i, 1), entry(i, 2)]);
                Frame { rotation: Rotation([row(0), row(1), row(2)]), origin: Vector::constant(&self.origin) }
            }
            JointKind::Prismatic => Frame {
                rotation: Rotation::constant(&self.parent_from_joint),
                origin: Vector::constant(&self.origin) + Vector::along(&self.slide, q),
            },
        }
    }
}
