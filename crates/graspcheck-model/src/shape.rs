//! Convex solids, the only geometry that collides.
//!
//! ```
//! use graspcheck_model::shape::Shape;
//! use nalgebra::Vector3;
//!
//! let rod = Shape::Capsule { radius: 0.1, half_length: 0.5 };
//! // The point farthest along a direction, and the moments of a body of this shape.
//! assert!((rod.support(&Vector3::z()).z - 0.6).abs() < 1e-15);
//! assert!(rod.inertial(2.0).tensor[(0, 0)] > rod.inertial(2.0).tensor[(2, 2)]);
//! let nothing = Shape::Sphere { radius: -0.1 }.validate().expect_err("no ball");
//! assert!(nothing.to_string().contains("-0.1 m must be positive"));
//! ```

use std::f64::consts::PI;

use nalgebra::{Matrix3, Point3, Vector3};
use serde::{Deserialize, Serialize};

use crate::{Pose, convex_hull::ConvexHull, error::ModelError, inertia::Inertial};

/// A convex solid in its own frame, lengths in m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// A box centred on the origin, with these half lengths along x, y and z.
    Box {
        /// Half lengths, m.
        half_extents: Vector3<f64>,
    },
    /// A ball centred on the origin.
    Sphere {
        /// Radius, m.
        radius: f64,
    },
    /// A cylinder centred on the origin with its axis along **z** (as in URDF).
    Cylinder {
        /// Radius, m.
        radius: f64,
        /// Half of its length along z, m.
        half_length: f64,
    },
    /// All points within `radius` of a segment along z centred on the origin.
    Capsule {
        /// Radius, m.
        radius: f64,
        /// Half of the segment's length along z, m (the whole solid is longer by the radius at each end).
        half_length: f64,
    },
    /// The convex hull of these points.
    Hull {
        /// At least four points that do not lie in a plane, m.
        points: Vec<Point3<f64>>,
    },
}

/// A shape with a place in the frame of the body that carries it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlacedShape {
    /// From the shape's own frame to the frame of the body.
    pub body_from_shape: Pose,
    /// The solid.
    pub shape: Shape,
}

impl Shape {
    /// Nothing, when this is a solid: every dimension is positive and finite, a hull does not lie in a plane.
    ///
    /// # Errors
    /// The first dimension that is not, or why the hull is flat.
    pub fn validate(&self) -> Result<(), ModelError> {
        let dimensions: &[(&'static str, f64)] = match self {
            Self::Box { half_extents: h } => {
                &[("half length along x", h.x), ("half length along y", h.y), ("half length along z", h.z)]
            }
            Self::Sphere { radius } => &[("radius", *radius)],
            Self::Cylinder { radius, half_length } | Self::Capsule { radius, half_length } => {
                &[("radius", *radius), ("half length", *half_length)]
            }
            Self::Hull { points } => return ConvexHull::of(points).map(|_| ()),
        };
        match dimensions.iter().find(|(_, value)| !(*value > 0.0 && value.is_finite())) {
            Some(&(what, value)) => Err(ModelError::Dimension { what, value }),
            None => Ok(()),
        }
    }

    /// Mass properties of this solid with `mass` (kg) spread evenly, in the shape's own frame.
    ///
    /// # Panics
    /// When the shape is a hull that [`Shape::validate`] refuses.
    #[must_use]
    pub fn inertial(&self, mass: f64) -> Inertial {
        let (center, moments) = match self {
            Self::Box { half_extents: h } => {
                let square = h.component_mul(h);
                let moments = Vector3::new(square.y + square.z, square.z + square.x, square.x + square.y);
                (Point3::origin(), Matrix3::from_diagonal(&(moments / 3.0)))
            }
            Self::Sphere { radius } => (Point3::origin(), Matrix3::identity() * (0.4 * radius * radius)),
            Self::Cylinder { radius, half_length } => {
                let across = radius * radius / 4.0 + half_length * half_length / 3.0;
                let moments = Vector3::new(across, across, radius * radius / 2.0);
                (Point3::origin(), Matrix3::from_diagonal(&moments))
            }
            Self::Capsule { radius: r, half_length: h } => {
                // A cylinder and two half balls, whose centres of mass are 3/8 of the radius beyond its ends.
                let (cylinder, ball) = (2.0 * PI * r * r * h, 4.0 / 3.0 * PI * r.powi(3));
                let share = cylinder / (cylinder + ball);
                let across = share * (r * r / 4.0 + h * h / 3.0)
                    + (1.0 - share) * (0.4 * r * r + h * h + 0.75 * h * r);
                let along = share * r * r / 2.0 + (1.0 - share) * 0.4 * r * r;
                (Point3::origin(), Matrix3::from_diagonal(&Vector3::new(across, across, along)))
            }
            Self::Hull { points } => {
                let hull = ConvexHull::of(points).expect("a hull that was validated spans a solid");
                let (volume, center, tensor) = hull.volume_properties();
                (center, tensor / volume)
            }
        };
        Inertial { mass, center, tensor: moments * mass }
    }

    /// Radius of the smallest ball about the origin of the shape's own frame that holds the shape, m.
    #[must_use]
    pub fn extent_radius(&self) -> f64 {
        match self {
            Self::Box { half_extents } => half_extents.norm(),
            Self::Sphere { radius } => *radius,
            Self::Cylinder { radius, half_length } => radius.hypot(*half_length),
            Self::Capsule { radius, half_length } => radius + half_length,
            Self::Hull { points } => points.iter().map(|point| point.coords.norm()).fold(0.0, f64::max),
        }
    }

    /// The point of the shape that lies farthest along `direction`, both in the shape's own frame, m. The
    /// length of `direction` does not matter; where several points are farthest it is one of them.
    #[must_use]
    pub fn support(&self, direction: &Vector3<f64>) -> Point3<f64> {
        let end = |half_length: f64| Vector3::new(0.0, 0.0, half_length.copysign(direction.z));
        match self {
            Self::Box { half_extents } => Point3::from(half_extents.zip_map(direction, f64::copysign)),
            Self::Sphere { radius } => {
                Point3::from(direction.try_normalize(0.0).unwrap_or_else(Vector3::zeros) * *radius)
            }
            Self::Cylinder { radius, half_length } => {
                let across = Vector3::new(direction.x, direction.y, 0.0);
                let rim = across.try_normalize(0.0).unwrap_or_else(Vector3::zeros) * *radius;
                Point3::from(rim + end(*half_length))
            }
            Self::Capsule { radius, half_length } => {
                let outward = direction.try_normalize(0.0).unwrap_or_else(Vector3::zeros) * *radius;
                Point3::from(outward + end(*half_length))
            }
            Self::Hull { points } => points
                .iter()
                .copied()
                .max_by(|a, b| direction.dot(&a.coords).total_cmp(&direction.dot(&b.coords)))
                .unwrap_or_else(Point3::origin),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mass properties by summing small cubes whose centres lie inside the shape.
    fn by_voxels(mass: f64, half: f64, inside: impl Fn(&Point3<f64>) -> bool) -> Inertial {
        const CELLS: usize = 120;
        let cell = 2.0 * half / CELLS as f64;
        let at = |i: usize| -half + (i as f64 + 0.5) * cell;
        let (mut count, mut second) = (0.0, Matrix3::zeros());
        for i in 0..CELLS {
            for j in 0..CELLS {
                for k in 0..CELLS {
                    let point = Point3::new(at(i), at(j), at(k));
                    if inside(&point) {
                        count += 1.0;
                        second += point.coords * point.coords.transpose();
                    }
                }
            }
        }
        let second: Matrix3<f64> = second * (mass / count);
        Inertial { mass, center: Point3::origin(), tensor: Matrix3::identity() * second.trace() - second }
    }

    type Inside = Box<dyn Fn(&Point3<f64>) -> bool>;

    #[test]
    fn closed_forms_agree_with_sums_over_small_cubes() {
        let (r, h) = (0.3, 0.49);
        let cases: [(Shape, Inside); 4] = [
            (
                Shape::Box { half_extents: Vector3::new(0.21, 0.42, 0.7) },
                Box::new(|p| p.x.abs() < 0.21 && p.y.abs() < 0.42 && p.z.abs() < 0.7),
            ),
            (Shape::Sphere { radius: r }, Box::new(move |p| p.coords.norm() < r)),
            (
                Shape::Cylinder { radius: r, half_length: h },
                Box::new(move |p| p.coords.xy().norm() < r && p.z.abs() < h),
            ),
            (
                Shape::Capsule { radius: r, half_length: h },
                Box::new(move |p| (p.coords - Vector3::new(0.0, 0.0, p.z.clamp(-h, h))).norm() < r),
            ),
        ];
        for (shape, inside) in cases {
            let exact = shape.inertial(2.0);
            let summed = by_voxels(2.0, 0.84, inside);
            let error = (exact.tensor - summed.tensor).amax() / exact.tensor.amax();
            assert!(error < 0.01, "{shape:?}: {error}\n{}\n{}", exact.tensor, summed.tensor);
            exact.validate().unwrap();
        }
    }

    #[test]
    fn a_hull_of_a_box_has_the_inertia_of_the_box() {
        let half_extents = Vector3::new(0.1, 0.2, 0.3);
        let solid = Shape::Box { half_extents };
        let points = (0..8)
            .map(|corner| {
                let sign = |bit: usize| if corner >> bit & 1 == 0 { -1.0 } else { 1.0 };
                Point3::from(half_extents.component_mul(&Vector3::new(sign(0), sign(1), sign(2))))
            })
            .collect();
        let hull = Shape::Hull { points };
        let (a, b) = (solid.inertial(3.0), hull.inertial(3.0));
        assert!((a.tensor - b.tensor).amax() < 1e-15 && (a.center - b.center).norm() < 1e-15);
        assert!((solid.extent_radius() - hull.extent_radius()).abs() < 1e-15);
    }

    #[test]
    fn a_support_point_is_on_the_surface_and_no_other_is_farther() {
        let direction = Vector3::new(0.3, -0.5, 0.8);
        let capsule = Shape::Capsule { radius: 0.1, half_length: 0.4 };
        let reached = direction.dot(&capsule.support(&direction).coords);
        // h(d) = r |d| + h |d_z|.
        assert!((reached - (0.1 * direction.norm() + 0.4 * 0.8)).abs() < 1e-15);
        let cylinder = Shape::Cylinder { radius: 0.1, half_length: 0.4 };
        let reached = direction.dot(&cylinder.support(&direction).coords);
        assert!((reached - (0.1 * 0.3_f64.hypot(0.5) + 0.4 * 0.8)).abs() < 1e-15);
    }

    #[test]
    fn a_dimension_that_is_not_positive_is_named() {
        let flat = Shape::Box { half_extents: Vector3::new(0.1, 0.0, 0.3) };
        assert_eq!(flat.validate(), Err(ModelError::Dimension { what: "half length along y", value: 0.0 }));
        let endless = Shape::Sphere { radius: f64::INFINITY };
        assert_eq!(endless.validate(), Err(ModelError::Dimension { what: "radius", value: f64::INFINITY }));
    }
}
