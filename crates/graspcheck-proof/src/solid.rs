//! One convex solid: a core and a ball around every point of it.
//!
//! Every shape of the model is `core ⊕ ball(radius)` (a Minkowski sum): a capsule is a segment and a ball, a
//! box is a box and a ball of radius zero. Cores have closed-form support functions, and the distance of two
//! solids is the distance of their cores less both radii. That keeps curved rims out of the search for
//! closest points, which is slow and inexact on them.

use graspcheck_model::{Pose, shape::Shape};
use nalgebra::{Matrix3, Point3, Vector3};
use parry3d::{math, shape::SupportMap};

use crate::hull::hull_triangles;

/// A convex solid in its own frame: all points within [`Solid::radius`] of its core.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    core: Core,
    radius: f64,
    bounding_radius: f64,
}

/// The core of a [`Solid`], lengths in m. It is compact, convex, and lies around the origin.
#[derive(Clone, Debug, PartialEq)]
pub enum Core {
    /// The origin.
    Point,
    /// A segment along z.
    Segment {
        /// Half of its length, m.
        half_length: f64,
    },
    /// A box along the axes.
    Box {
        /// Half lengths, m.
        half_extents: Vector3<f64>,
    },
    /// A cylinder with its axis along z.
    Cylinder {
        /// Radius, m.
        radius: f64,
        /// Half of its length, m.
        half_length: f64,
    },
    /// The convex hull of points.
    Points {
        /// The points, m; at least one.
        points: Vec<Vector3<f64>>,
        /// A point inside of the hull, m.
        inside: Vector3<f64>,
        /// A ball of this radius about it lies in the hull, m.
        inner_radius: f64,
    },
}

impl Solid {
    /// The solid of a shape, and where its origin stands in the frame of the shape, m: the middle of the
    /// bounding box of a hull, zero for all other shapes.
    ///
    /// # Errors
    /// Says in words what is wrong when a length is not finite or not positive, or a hull has fewer than
    /// four points.
    pub fn from_shape(shape: &Shape) -> Result<(Self, Vector3<f64>), String> {
        let length = |quantity: &str, value: f64| {
            if value.is_finite() && value > 0.0 {
                Ok(value)
            } else {
                Err(format!("{quantity} {value} m must be finite and positive"))
            }
        };
        let mut origin = Vector3::zeros();
        let (core, radius) = match shape {
            Shape::Box { half_extents } => {
                for (axis, half) in ["x", "y", "z"].iter().zip(half_extents) {
                    length(&format!("half length along {axis}"), *half)?;
                }
                (Core::Box { half_extents: *half_extents }, 0.0)
            }
            Shape::Sphere { radius } => (Core::Point, length("radius", *radius)?),
            Shape::Cylinder { radius, half_length } => {
                let (radius, half_length) =
                    (length("radius", *radius)?, length("half length", *half_length)?);
                (Core::Cylinder { radius, half_length }, 0.0)
            }
            Shape::Capsule { radius, half_length } => {
                let half_length = length("half length", *half_length)?;
                (Core::Segment { half_length }, length("radius", *radius)?)
            }
            Shape::Hull { points } => {
                if points.len() < 4 {
                    return Err(format!("a hull of {} points needs at least 4", points.len()));
                }
                if let Some(index) = points.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
                    return Err(format!("point {index} of the hull, {}, must be finite", points[index]));
                }
                let first = points[0].coords;
                let (low, high) = points
                    .iter()
                    .fold((first, first), |(low, high), p| (low.inf(&p.coords), high.sup(&p.coords)));
                origin = 0.5 * (low + high);
                let core = Core::hull(points.iter().map(|p| p.coords - origin).collect());
                (core.ok_or("the points of the hull must not lie in a plane")?, 0.0)
            }
        };
        Ok((Self::new(core, radius), origin))
    }

    /// All points within `radius` (m, not negative) of a core.
    #[must_use]
    pub fn new(core: Core, radius: f64) -> Self {
        let bounding_radius = core.bounding_radius() + radius;
        Self { core, radius, bounding_radius }
    }

    /// The core.
    #[must_use]
    pub fn core(&self) -> &Core {
        &self.core
    }

    /// How far the solid reaches beyond its core, m.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// The largest distance of a point of the solid from its origin, m.
    #[must_use]
    pub fn bounding_radius(&self) -> f64 {
        self.bounding_radius
    }

    /// A smaller solid that stays in this one when a ball of radius `depth` (m) is added to every point of
    /// it; none when this solid has no closed form for one.
    ///
    /// Lengths shrink by the depth. For a box `h(n) = Σ |nᵢ| hᵢ` falls by `depth Σ |nᵢ| ≥ depth`, for a
    /// cylinder likewise, so that adding the ball does not leave the solid. A hull K with a ball of radius r
    /// in it shrinks towards the ball's middle by the share `s = depth / r`: `(1 - s) K + s K = K`.
    #[must_use]
    pub fn eroded(&self, depth: f64) -> Option<Self> {
        if self.radius >= depth {
            return Some(Self::new(self.core.clone(), self.radius - depth));
        }
        let depth = depth - self.radius;
        match &self.core {
            Core::Box { half_extents } if half_extents.min() > depth => {
                let half_extents = half_extents.add_scalar(-depth);
                Some(Self::new(Core::Box { half_extents }, 0.0))
            }
            Core::Cylinder { radius, half_length } if radius.min(*half_length) > depth => {
                let core = Core::Cylinder { radius: radius - depth, half_length: half_length - depth };
                Some(Self::new(core, 0.0))
            }
            Core::Points { points, inside, inner_radius } if *inner_radius > depth => {
                let share = depth / inner_radius;
                let core = Core::Points {
                    points: points.iter().map(|p| p.lerp(inside, share)).collect(),
                    inside: *inside,
                    inner_radius: inner_radius - depth,
                };
                Some(Self::new(core, 0.0))
            }
            _ => None,
        }
    }
}

impl Core {
    /// The convex hull of points (m); none when they lie in a plane.
    #[must_use]
    pub fn hull(points: Vec<Vector3<f64>>) -> Option<Self> {
        let corners: Vec<Point3<f64>> = points.iter().map(|p| Point3::from(*p)).collect();
        let triangles = hull_triangles(&corners);
        let inside = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
        let inner_radius = triangles
            .iter()
            .map(|[p, q, r]| {
                let n = (q - p).cross(&(r - p));
                (p.coords - inside).dot(&n) / n.norm()
            })
            .fold(f64::INFINITY, f64::min);
        let is_solid = !triangles.is_empty() && inner_radius > 0.0;
        is_solid.then_some(Self::Points { points, inside, inner_radius })
    }

    /// The largest distance of a point of the core from its origin, m.
    #[must_use]
    pub fn bounding_radius(&self) -> f64 {
        match self {
            Self::Point => 0.0,
            Self::Segment { half_length } => *half_length,
            Self::Box { half_extents } => half_extents.norm(),
            Self::Cylinder { radius, half_length } => radius.hypot(*half_length),
            Self::Points { points, .. } => points.iter().map(Vector3::norm).fold(0.0, f64::max),
        }
    }

    /// A bound on the distance of any point of the core from the line through its origin along `axis` (of
    /// length 1, in the solid's frame), m. It is reached, except by cylinders oblique to the axis.
    #[must_use]
    pub fn radial_extent(&self, axis: &Vector3<f64>) -> f64 {
        let across = |p: &Vector3<f64>| p.cross(axis).norm();
        match self {
            Self::Point => 0.0,
            Self::Segment { half_length } => across(&(Vector3::z() * *half_length)),
            Self::Box { half_extents: h } => [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]]
                .iter()
                .map(|[x, y]| across(&Vector3::new(x * h.x, y * h.y, h.z)))
                .fold(0.0, f64::max),
            Self::Cylinder { radius, half_length } => radius + across(&(Vector3::z() * *half_length)),
            Self::Points { points, .. } => points.iter().map(across).fold(0.0, f64::max),
        }
    }

    /// The point of the core that lies farthest along `direction` (any length, in the solid's frame), m.
    #[must_use]
    pub fn support(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        match self {
            Self::Point => Vector3::zeros(),
            Self::Segment { half_length } => Vector3::z() * half_length.copysign(direction.z),
            Self::Box { half_extents } => half_extents.zip_map(direction, f64::copysign),
            Self::Cylinder { radius, half_length } => {
                let across = across_z(direction);
                let scale = if across > 0.0 { radius / across } else { 0.0 };
                Vector3::new(scale * direction.x, scale * direction.y, half_length.copysign(direction.z))
            }
            Self::Points { points, .. } => {
                let mut best = (f64::NEG_INFINITY, Vector3::zeros());
                for point in points {
                    let along = point.dot(direction);
                    if along > best.0 {
                        best = (along, *point);
                    }
                }
                best.1
            }
        }
    }

    /// The point of the core that is nearest to a point (in the solid's frame), m; for a hull a point
    /// inside of it, a stand-in.
    #[must_use]
    pub fn nearest(&self, point: &Vector3<f64>) -> Vector3<f64> {
        match self {
            Self::Point => Vector3::zeros(),
            Self::Points { inside, .. } => *inside,
            Self::Segment { half_length } => Vector3::z() * point.z.clamp(-half_length, *half_length),
            Self::Box { half_extents } => point.zip_map(half_extents, |x, half| x.clamp(-half, half)),
            Self::Cylinder { radius, half_length } => {
                let scale = (radius / across_z(point)).min(1.0);
                Vector3::new(scale * point.x, scale * point.y, point.z.clamp(-half_length, *half_length))
            }
        }
    }

    /// The support function `max n·p` over the points p of the core, m, for a direction n of length 1 in
    /// the solid's frame.
    #[must_use]
    pub fn reach(&self, n: &Vector3<f64>) -> f64 {
        match self {
            Self::Point => 0.0,
            Self::Segment { half_length } => half_length * n.z.abs(),
            Self::Box { half_extents } => n.abs().dot(half_extents),
            Self::Cylinder { radius, half_length } => radius * across_z(n) + half_length * n.z.abs(),
            Self::Points { points, .. } => points.iter().map(|p| p.dot(n)).fold(f64::NEG_INFINITY, f64::max),
        }
    }
}

/// The length of a vector across z. Directions have a length near 1, so that nothing can overflow.
fn across_z(v: &Vector3<f64>) -> f64 {
    (v.x * v.x + v.y * v.y).sqrt()
}

/// Farther from the world's origin than this, m, rounding is no longer far below [`GAP_SLACK`](crate::gap::GAP_SLACK), and nothing
/// is certified.
pub const LARGEST_COORDINATE: f64 = 1e4;

/// A solid at a place in the world.
#[derive(Clone, Copy, Debug)]
pub struct Placed<'a> {
    /// The solid.
    pub solid: &'a Solid,
    /// Where it is.
    pub place: Place,
}

/// A place in the world: rotation and origin of a solid's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// From the solid's frame to the world.
    pub rotation: Matrix3<f64>,
    /// The solid's origin in the world, m.
    pub center: Vector3<f64>,
}

impl From<&Pose> for Place {
    fn from(world_from_solid: &Pose) -> Self {
        Self {
            rotation: world_from_solid.rotation.to_rotation_matrix().into_inner(),
            center: world_from_solid.translation.vector,
        }
    }
}

impl Place {
    /// Where something is that has a place in the frame of this one.
    #[must_use]
    pub fn then(&self, inner: &Self) -> Self {
        Self { rotation: self.rotation * inner.rotation, center: self.center + self.rotation * inner.center }
    }
}

impl Placed<'_> {
    /// Whether all of it is nearer to the world's origin than [`LARGEST_COORDINATE`].
    #[must_use]
    pub fn is_near(&self) -> bool {
        self.place.center.amax() + self.solid.bounding_radius() < LARGEST_COORDINATE
    }

    /// How far the solid reaches from its origin along a direction n of length 1 in the world, m: its
    /// support function less `n·center`.
    #[must_use]
    pub fn reach(&self, n: &Vector3<f64>) -> f64 {
        self.solid.core.reach(&self.place.rotation.tr_mul(n)) + self.solid.radius
    }

    /// The point of the core that is nearest to a point in the world, m; for a hull a
    /// point inside of it.
    #[must_use]
    pub fn core_nearest(&self, point: &Vector3<f64>) -> Vector3<f64> {
        let local = self.place.rotation.tr_mul(&(point - self.place.center));
        self.place.center + self.place.rotation * self.solid.core.nearest(&local)
    }

    /// The point of the core that lies farthest along a direction in the world, m.
    #[must_use]
    pub fn core_support(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        self.place.center
            + self.place.rotation * self.solid.core.support(&self.place.rotation.tr_mul(direction))
    }
}

/// The core as parry sees it. Both solids of a query stand in the world already, so that the pose between
/// them is the identity and is not looked at.
impl SupportMap for Placed<'_> {
    fn local_support_point(&self, direction: math::Vector) -> math::Vector {
        let point = self.core_support(&Vector3::new(direction.x, direction.y, direction.z));
        math::Vector::new(point.x, point.y, point.z)
    }

    fn support_point(&self, _identity: &math::Pose, direction: math::Vector) -> math::Vector {
        self.local_support_point(direction)
    }

    fn support_point_toward(&self, _identity: &math::Pose, direction: math::Vector) -> math::Vector {
        self.local_support_point(direction)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::fixtures::Draw;

    pub(crate) fn cores(draw: &mut Draw) -> [Core; 5] {
        let mut length = || draw.between(0.02, 0.3);
        let mut points = vec![Vector3::zeros(); 8];
        points.iter_mut().for_each(|p| *p = Vector3::new(length(), length(), length()));
        [
            Core::Point,
            Core::Segment { half_length: length() },
            Core::Box { half_extents: Vector3::new(length(), length(), length()) },
            Core::Cylinder { radius: length(), half_length: length() },
            Core::hull(points).unwrap(),
        ]
    }

    /// A random point of a core, by a description of the core that knows no support function.
    pub(crate) fn point_of(core: &Core, draw: &mut Draw) -> Vector3<f64> {
        let mut share = || draw.between(-1.0, 1.0);
        match core {
            Core::Point => Vector3::zeros(),
            Core::Segment { half_length } => Vector3::z() * (half_length * share()),
            Core::Box { half_extents } => half_extents.map(|half| half * share()),
            Core::Cylinder { radius, half_length } => {
                let (turn, out) = (std::f64::consts::PI * share(), radius * share());
                Vector3::new(out * turn.cos(), out * turn.sin(), half_length * share())
            }
            Core::Points { points, .. } => {
                let weights: Vec<f64> = points.iter().map(|_| share().abs().powi(4)).collect();
                let sum: f64 = weights.iter().sum();
                points.iter().zip(weights).map(|(p, w)| p * (w / sum)).sum()
            }
        }
    }

    #[test]
    fn no_point_reaches_farther_than_the_support_function() {
        let mut draw = Draw(1);
        for _ in 0..200 {
            for core in cores(&mut draw) {
                let n = Vector3::from_fn(|_, _| draw.between(-1.0, 1.0)).normalize();
                let reach = core.reach(&n);
                assert!((core.support(&n).dot(&n) - reach).abs() < 1e-12, "{core:?}");
                for _ in 0..50 {
                    assert!(point_of(&core, &mut draw).dot(&n) <= reach + 1e-12, "{core:?}");
                }
            }
        }
    }

    #[test]
    fn no_point_lies_outside_the_bounding_radius_or_the_radial_extent() {
        let mut draw = Draw(2);
        for _ in 0..200 {
            for core in cores(&mut draw) {
                let axis = Vector3::from_fn(|_, _| draw.between(-1.0, 1.0)).normalize();
                for _ in 0..50 {
                    let p = point_of(&core, &mut draw);
                    assert!(p.norm() <= core.bounding_radius() + 1e-12);
                    assert!(p.cross(&axis).norm() <= core.radial_extent(&axis) + 1e-12);
                }
            }
        }
    }

    #[test]
    fn a_cylinder_about_the_axis_extends_by_its_radius() {
        let rod = Core::Cylinder { radius: 0.01, half_length: 1.0 };
        assert!((rod.radial_extent(&Vector3::z()) - 0.01).abs() < 1e-15);
    }

    #[test]
    fn an_eroded_solid_and_the_ball_stay_inside() {
        let mut draw = Draw(3);
        for _ in 0..200 {
            for core in cores(&mut draw) {
                let solid = Solid::new(core, draw.between(0.0, 0.05));
                let depth = draw.between(0.0, 0.1);
                let Some(smaller) = solid.eroded(depth) else { continue };
                let n = Vector3::from_fn(|_, _| draw.between(-1.0, 1.0)).normalize();
                let reach = |solid: &Solid| solid.core().reach(&n) + solid.radius();
                assert!(reach(&smaller) + depth <= reach(&solid) + 1e-12, "{solid:?}");
            }
        }
    }

    #[test]
    fn a_hull_is_centred_and_bad_shapes_are_named() {
        let points = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 6.0]];
        let points = points.map(Point3::from).to_vec();
        let (solid, origin) = Solid::from_shape(&Shape::Hull { points }).unwrap();
        assert_eq!(origin, Vector3::new(1.0, 2.0, 3.0));
        assert!((solid.core().reach(&Vector3::x()) - 1.0).abs() < 1e-15);
        let Core::Points { inside, inner_radius, .. } = solid.core() else { panic!("{solid:?}") };
        // The face through three corners is x/2 + y/4 + z/6 = 1; the others are the planes of the axes.
        let corner_mean = inside + origin;
        assert_eq!(corner_mean, Vector3::new(0.5, 1.0, 1.5));
        let to_face = 0.25 / (0.25_f64 + 1.0 / 16.0 + 1.0 / 36.0).sqrt();
        assert!((inner_radius - to_face.min(0.5)).abs() < 1e-12, "{inner_radius}");
        let plane = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
        let points = plane.map(|[x, y]| Point3::new(x, y, x + y)).to_vec();
        let fault = Solid::from_shape(&Shape::Hull { points }).unwrap_err();
        assert_eq!(fault, "the points of the hull must not lie in a plane");
        let flat = Shape::Cylinder { radius: 0.1, half_length: 0.0 };
        assert_eq!(Solid::from_shape(&flat), Err("half length 0 m must be finite and positive".to_owned()));
        let nan = Shape::Sphere { radius: f64::NAN };
        assert_eq!(Solid::from_shape(&nan), Err("radius NaN m must be finite and positive".to_owned()));
    }
}
