//! Shapes as rapier has them, and how thin they are.

use graspcheck_model::{
    Pose,
    shape::{PlacedShape, Shape},
};
use nalgebra::{UnitQuaternion, Vector3};
use rapier3d::{
    geometry::{ConvexPolyhedron, SharedShape},
    math::Vector,
};

use crate::{convert, error::SimError};

/// Rapier's form of a shape and its pose in the body. Its cylinders stand along y, ours along z.
pub(crate) fn rapier_shape(body: &str, placed: &PlacedShape) -> Result<(Pose, SharedShape), SimError> {
    let body_from_shape = placed.body_from_shape;
    Ok(match &placed.shape {
        Shape::Box { half_extents } => {
            (body_from_shape, SharedShape::cuboid(half_extents.x, half_extents.y, half_extents.z))
        }
        Shape::Sphere { radius } => (body_from_shape, SharedShape::ball(*radius)),
        Shape::Cylinder { radius, half_length } => {
            let quarter = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
            (body_from_shape * quarter, SharedShape::cylinder(*half_length, *radius))
        }
        Shape::Capsule { radius, half_length } => {
            (body_from_shape, SharedShape::capsule_z(*half_length, *radius))
        }
        Shape::Hull { points } => {
            let vertices: Vec<Vector> = points.iter().map(convert::point_to_rapier).collect();
            let hull = SharedShape::convex_hull(&vertices)
                .ok_or_else(|| SimError::Hull { body: body.to_owned(), points: points.len() })?;
            (body_from_shape, hull)
        }
    })
}

/// The least width of a solid, m: the least distance of two parallel planes that hold it.
pub(crate) fn thickness(shape: &Shape, built: &SharedShape) -> f64 {
    match shape {
        Shape::Box { half_extents } => 2.0 * half_extents.min(),
        Shape::Sphere { radius } | Shape::Capsule { radius, .. } => 2.0 * radius,
        Shape::Cylinder { radius, half_length } => 2.0 * radius.min(*half_length),
        Shape::Hull { .. } => {
            let hull = built.as_convex_polyhedron().expect("a hull is built as a polyhedron");
            hull_thickness(hull)
        }
    }
}

/// The least width of a polyhedron. It is taken along the normal of a face or along a line that is
/// perpendicular to two edges (Houle and Toussaint, Computing the width of a set, 1988).
pub(crate) fn hull_thickness(hull: &ConvexPolyhedron) -> f64 {
    let points = hull.points();
    let edges: Vec<Vector> = hull
        .edges()
        .iter()
        .map(|edge| points[edge.vertices[1] as usize] - points[edge.vertices[0] as usize])
        .collect();
    let between_edges = edges
        .iter()
        .enumerate()
        .flat_map(|(index, edge)| edges[..index].iter().map(move |other| edge.cross(*other)))
        .filter_map(Vector::try_normalize);
    let normals = hull.faces().iter().map(|face| face.normal).chain(between_edges);
    normals
        .map(|normal| {
            let heights = points.iter().map(|point| normal.dot(*point));
            let [low, high] = heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], height| {
                [low.min(height), high.max(height)]
            });
            high - low
        })
        .fold(f64::INFINITY, f64::min)
}
