//! Mass properties as rapier has them, without what it makes of them.

use graspcheck_model::inertia::Inertial;
use nalgebra::{Rotation3, UnitQuaternion};
use rapier3d::{dynamics::MassProperties, math::Pose as RapierPose};

use crate::convert;

/// Mass properties of a shape that has none: mass comes from the inertial data alone.
///
/// Rapier moves them into the body's frame and adds them to the body's. Where the outcome of that move is
/// zero to the bit, which it is for shapes that are not turned, the sum is left out; otherwise the body's
/// principal axes are computed again, see [`mass_properties`].
pub(crate) fn massless(body_from_collider: &RapierPose) -> MassProperties {
    let collider_from_body = body_from_collider.inverse();
    MassProperties {
        local_com: collider_from_body.translation,
        principal_inertia_local_frame: collider_from_body.rotation,
        ..MassProperties::default()
    }
}

/// Mass properties with principal axes of our own. Those of `MassProperties::with_inertia_matrix` are wrong
/// for small bodies: glamx 0.3.1 takes x for the first axis when products of differences of principal
/// inertias are below 1e-10 kg²·m⁴ (seen on a finger of 2.9, 11 and 13 mg·m²).
pub(crate) fn mass_properties(inertial: &Inertial) -> MassProperties {
    let eigen = inertial.tensor.symmetric_eigen();
    let mut axes = eigen.eigenvectors;
    if axes.determinant() < 0.0 {
        axes.column_mut(2).neg_mut();
    }
    let body_from_principal = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    MassProperties::with_principal_inertia_frame(
        convert::point_to_rapier(&inertial.center),
        inertial.mass,
        convert::vector_to_rapier(&eigen.eigenvalues),
        convert::rotation_to_rapier(&body_from_principal),
    )
}
