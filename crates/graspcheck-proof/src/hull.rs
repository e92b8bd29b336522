//! The surface of a convex hull, for drawing; no proof uses it.

use nalgebra::Point3;
use parry3d::{math::Vector, transformation::try_convex_hull};

/// The triangles of the convex hull of points (m), seen from outside anticlockwise; empty when the points
/// lie in a plane or are not finite.
#[must_use]
pub fn hull_triangles(points: &[Point3<f64>]) -> Vec<[Point3<f64>; 3]> {
    if points.len() < 4 || points.iter().any(|p| p.iter().any(|x| !x.is_finite())) {
        return Vec::new();
    }
    let points: Vec<Vector> = points.iter().map(|p| Vector::new(p.x, p.y, p.z)).collect();
    let Ok((corners, triangles)) = try_convex_hull(&points) else { return Vec::new() };
    let corner = |index: u32| {
        let p = corners[index as usize];
        Point3::new(p.x, p.y, p.z)
    };
    triangles.into_iter().map(|triangle| triangle.map(corner)).collect()
}
