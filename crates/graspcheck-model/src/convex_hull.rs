//! The convex hull of points in space, as triangles.
//!
//! Incremental: a tetrahedron grows by one point at a time; the faces that see the new point are replaced
//! by the cone from it over their horizon (de Berg et al., *Computational Geometry*, chapter 11, without
//! the conflict graph: meshes of robot links are small).
//!
//! ```
//! use graspcheck_model::convex_hull::ConvexHull;
//! use nalgebra::Point3;
//!
//! // A tetrahedron with a point inside, which is no corner of the hull. Its volume is 1/6.
//! let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.1, 0.1, 0.1]];
//! let hull = ConvexHull::of(&corners.map(Point3::from))?;
//! assert_eq!(hull.faces.len(), 4);
//! let (volume, center, _) = hull.volume_properties();
//! assert!((volume - 1.0 / 6.0).abs() < 1e-15 && (center.x - 0.25).abs() < 1e-15);
//! # Ok::<(), graspcheck_model::error::ModelError>(())
//! ```

use std::collections::BTreeSet;

use nalgebra::{Matrix3, Point3, Vector3};

use crate::error::ModelError;

/// A point this far outside a face, relative to the size of the point set, still counts as lying on it.
/// It is far above the rounding of the test (1e-15) and far below what any mesh means to say.
const FACE_TOLERANCE: f64 = 1e-11;

/// The convex hull of a set of points.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvexHull {
    /// Its corners, m.
    pub points: Vec<Point3<f64>>,
    /// Its triangles as indices into `points`, counterclockwise when seen from outside.
    pub faces: Vec<[usize; 3]>,
}

/// A triangle of the hull while it grows.
struct Face {
    corners: [usize; 3],
    normal: Vector3<f64>,
    offset: f64,
}

impl Face {
    fn new(points: &[Point3<f64>], corners: [usize; 3]) -> Self {
        let [a, b, c] = corners.map(|corner| points[corner]);
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vector3::zeros);
        Self { corners, normal, offset: normal.dot(&a.coords) }
    }

    fn height(&self, point: &Point3<f64>) -> f64 {
        self.normal.dot(&point.coords) - self.offset
    }

    fn edges(&self) -> [(usize, usize); 3] {
        let [a, b, c] = self.corners;
        [(a, b), (b, c), (c, a)]
    }
}

impl ConvexHull {
    /// The convex hull of `points`. Points that lie within 1e-11 of the set's size of it are not its corners.
    ///
    /// # Errors
    /// When a coordinate is not finite, or the points lie in a plane.
    pub fn of(points: &[Point3<f64>]) -> Result<Self, ModelError> {
        if !points.iter().flat_map(Point3::iter).all(|value| value.is_finite()) {
            return Err(ModelError::NotFinite);
        }
        let (corners, tolerance) = first_tetrahedron(points)?;
        let [a, b, c, d] = corners;
        let mut faces: Vec<Face> =
            [[a, b, c], [a, d, b], [b, d, c], [c, d, a]].map(|corners| Face::new(points, corners)).into();
        for (index, point) in points.iter().enumerate() {
            let (seen, unseen): (Vec<Face>, Vec<Face>) =
                faces.into_iter().partition(|face| face.height(point) > tolerance);
            faces = unseen;
            let edges: BTreeSet<(usize, usize)> = seen.iter().flat_map(Face::edges).collect();
            let horizon = edges.iter().filter(|&&(from, to)| !edges.contains(&(to, from)));
            faces.extend(horizon.map(|&(from, to)| Face::new(points, [from, to, index])));
        }
        let used: BTreeSet<usize> = faces.iter().flat_map(|face| face.corners).collect();
        let used: Vec<usize> = used.into_iter().collect();
        let renumbered = |corner: usize| used.partition_point(|&index| index < corner);
        Ok(Self {
            points: used.iter().map(|&index| points[index]).collect(),
            faces: faces.iter().map(|face| face.corners.map(renumbered)).collect(),
        })
    }

    /// Volume (m³), centroid (m), and the tensor of inertia about the centroid of a body of unit density
    /// (m⁵): sums over the tetrahedra that the faces span with the first corner. Over a tetrahedron with
    /// corners 0, a, b, c: ∫ x xᵀ dV = det(a, b, c)/120 · (aaᵀ + bbᵀ + ccᵀ + ssᵀ), s = a + b + c.
    #[must_use]
    pub fn volume_properties(&self) -> (f64, Point3<f64>, Matrix3<f64>) {
        let origin = self.points[0];
        let (mut volume, mut moment, mut second) = (0.0, Vector3::zeros(), Matrix3::zeros());
        for face in &self.faces {
            let [a, b, c] = face.map(|corner| self.points[corner] - origin);
            let determinant = a.dot(&b.cross(&c));
            let sum = a + b + c;
            volume += determinant / 6.0;
            moment += sum * (determinant / 24.0);
            second += (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose())
                * (determinant / 120.0);
        }
        let center = moment / volume;
        let central = second - center * center.transpose() * volume;
        (volume, origin + center, Matrix3::identity() * central.trace() - central)
    }
}

/// Four points that span a solid, seen from outside counterclockwise as (a, b, c) with d behind, and the
/// absolute tolerance.
fn first_tetrahedron(points: &[Point3<f64>]) -> Result<([usize; 4], f64), ModelError> {
    let farthest = |measure: &dyn Fn(&Point3<f64>) -> f64| -> (usize, f64) {
        points.iter().enumerate().fold((0, 0.0), |best, (index, point)| {
            let value = measure(point);
            if value > best.1 { (index, value) } else { best }
        })
    };
    let count = points.len();
    let first = points.first().ok_or(ModelError::FlatHull { count, thickness: 0.0 })?;
    let (a, _) = farthest(&|point| (point - first).norm());
    let (b, size) = farthest(&|point| (point - points[a]).norm());
    let tolerance = FACE_TOLERANCE * size;
    let along = (points[b] - points[a]).try_normalize(0.0).unwrap_or_else(Vector3::zeros);
    let (c, width) = farthest(&|point| (point - points[a]).cross(&along).norm());
    let face = Face::new(points, [a, b, c]);
    let (d, thickness) = farthest(&|point| face.height(point).abs());
    if size <= 0.0 || width <= tolerance || thickness <= tolerance {
        return Err(ModelError::FlatHull { count, thickness });
    }
    let corners = if face.height(&points[d]) > 0.0 { [a, c, b, d] } else { [a, b, c, d] };
    Ok((corners, tolerance))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(nx: usize, ny: usize, nz: usize) -> Vec<Point3<f64>> {
        let mut points = Vec::new();
        for i in 0..=nx {
            for j in 0..=ny {
                for k in 0..=nz {
                    points.push(Point3::new(
                        i as f64 / nx as f64,
                        2.0 * j as f64 / ny as f64,
                        3.0 * k as f64 / nz as f64,
                    ));
                }
            }
        }
        points
    }

    #[test]
    fn a_grid_of_points_is_its_box() {
        let hull = ConvexHull::of(&grid(3, 4, 5)).unwrap();
        let (volume, center, tensor) = hull.volume_properties();
        assert!((volume - 6.0).abs() < 1e-12, "{volume}");
        assert!((center - Point3::new(0.5, 1.0, 1.5)).norm() < 1e-12, "{center}");
        // Unit density: mass 6 kg, Ixx = m (ly² + lz²)/12.
        let expected = Matrix3::from_diagonal(&Vector3::new(6.5, 5.0, 2.5));
        assert!((tensor - expected).amax() < 1e-12, "{tensor}");
    }

    #[test]
    fn every_point_is_inside_and_the_surface_is_closed() {
        // Points on and in a ball, from a fixed linear congruential sequence.
        let mut state = 7_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 * 2.0 - 1.0
        };
        let points: Vec<Point3<f64>> = (0..300).map(|_| Point3::new(next(), next(), next())).collect();
        let hull = ConvexHull::of(&points).unwrap();
        // Euler: a closed triangulated sphere has F = 2 V − 4.
        assert_eq!(hull.faces.len(), 2 * hull.points.len() - 4);
        for face in &hull.faces {
            let face = Face::new(&hull.points, *face);
            for point in &points {
                assert!(face.height(point) < 1e-10, "{point} is {} outside", face.height(point));
            }
        }
    }

    #[test]
    fn points_in_a_plane_span_no_solid() {
        let flat: Vec<Point3<f64>> = grid(3, 3, 1).into_iter().filter(|point| point.z == 0.0).collect();
        assert!(matches!(ConvexHull::of(&flat), Err(ModelError::FlatHull { count: 16, .. })));
        assert!(matches!(ConvexHull::of(&[]), Err(ModelError::FlatHull { count: 0, .. })));
        assert!(matches!(ConvexHull::of(&[Point3::new(f64::NAN, 0.0, 0.0)]), Err(ModelError::NotFinite)));
    }
}
