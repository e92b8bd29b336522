//! Convex solids as the judge sees them: support functions, and how deep a point lies inside.

use graspcheck_model::{Pose, shape::Shape};
use nalgebra::{Matrix3, Vector3};

/// The hull's face planes are met by its corners to this, m.
const ON_A_FACE: f64 = 1e-12;

/// All points within `radius` of a core, in the solid's own frame.
#[derive(Clone, Debug)]
pub struct Solid {
    pub core: Core,
    pub radius: f64,
}

#[derive(Clone, Debug)]
pub enum Core {
    Point,
    /// Along z, this long on both sides.
    Segment(f64),
    /// Half lengths.
    Box(Vector3<f64>),
    /// About z: radius and half length.
    Cylinder(f64, f64),
    /// Corners, and planes `n·p ≤ offset` of the faces.
    Hull(Vec<Vector3<f64>>, Vec<(Vector3<f64>, f64)>),
}

impl Solid {
    pub fn of(shape: &Shape) -> Self {
        let (core, radius) = match shape {
            Shape::Box { half_extents } => (Core::Box(*half_extents), 0.0),
            Shape::Sphere { radius } => (Core::Point, *radius),
            Shape::Cylinder { radius, half_length } => (Core::Cylinder(*radius, *half_length), 0.0),
            Shape::Capsule { radius, half_length } => (Core::Segment(*half_length), *radius),
            Shape::Hull { points } => {
                let points: Vec<Vector3<f64>> = points.iter().map(|p| p.coords).collect();
                let faces = faces(&points);
                (Core::Hull(points, faces), 0.0)
            }
        };
        Self { core, radius }
    }

    /// The largest distance of a point from the origin, m.
    pub fn reach(&self) -> f64 {
        let core = match &self.core {
            Core::Point => 0.0,
            Core::Segment(half) => *half,
            Core::Box(half) => half.norm(),
            Core::Cylinder(radius, half) => radius.hypot(*half),
            Core::Hull(points, _) => points.iter().map(Vector3::norm).fold(0.0, f64::max),
        };
        core + self.radius
    }

    /// The radius of a ball about `p` that lies in the solid, m; negative, and no less than minus the distance to it,
    /// when `p` is outside.
    pub fn depth(&self, p: &Vector3<f64>) -> f64 {
        match &self.core {
            Core::Point => self.radius - p.norm(),
            Core::Segment(half) => self.radius - (p - Vector3::new(0.0, 0.0, p.z.clamp(-half, *half))).norm(),
            Core::Box(half) => (half - p.abs()).min(),
            Core::Cylinder(radius, half) => (radius - p.x.hypot(p.y)).min(half - p.z.abs()),
            Core::Hull(_, faces) => {
                faces.iter().map(|(n, offset)| offset - n.dot(p)).fold(f64::INFINITY, f64::min)
            }
        }
    }
}

/// The planes through three corners that have all others on one side.
fn faces(points: &[Vector3<f64>]) -> Vec<(Vector3<f64>, f64)> {
    let mut found = Vec::new();
    for (i, a) in points.iter().enumerate() {
        for (j, b) in points.iter().enumerate().skip(i + 1) {
            for c in &points[j + 1..] {
                let Some(n) = (b - a).cross(&(c - a)).try_normalize(1e-12) else { continue };
                for n in [n, -n] {
                    let offset = n.dot(a);
                    if points.iter().all(|p| n.dot(p) <= offset + ON_A_FACE) {
                        found.push((n, offset));
                    }
                }
            }
        }
    }
    found
}

/// A solid somewhere in the world.
#[derive(Clone, Copy, Debug)]
pub struct Placed<'s> {
    pub solid: &'s Solid,
    pub turn: Matrix3<f64>,
    pub origin: Vector3<f64>,
}

impl<'s> Placed<'s> {
    pub fn new(solid: &'s Solid, pose: &Pose) -> Self {
        let turn = pose.rotation.to_rotation_matrix().into_inner();
        Self { solid, turn, origin: pose.translation.vector }
    }

    /// The point of the core that lies farthest along `direction`, both in the world.
    pub fn support(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        let d = self.turn.tr_mul(direction);
        let sign = |x: f64| if x < 0.0 { -1.0 } else { 1.0 };
        let local = match &self.solid.core {
            Core::Point => Vector3::zeros(),
            Core::Segment(half) => Vector3::new(0.0, 0.0, half * sign(d.z)),
            Core::Box(half) => Vector3::new(half.x * sign(d.x), half.y * sign(d.y), half.z * sign(d.z)),
            Core::Cylinder(radius, half) => {
                let across = d.x.hypot(d.y);
                let share = if across > 0.0 { radius / across } else { 0.0 };
                Vector3::new(share * d.x, share * d.y, half * sign(d.z))
            }
            Core::Hull(points, _) => {
                let mut farthest = (f64::NEG_INFINITY, Vector3::zeros());
                for point in points {
                    let along = point.dot(&d);
                    if along > farthest.0 {
                        farthest = (along, *point);
                    }
                }
                farthest.1
            }
        };
        self.origin + self.turn * local
    }

    /// The least and the largest coordinates of the solid in the world.
    pub fn bounds(&self) -> [Vector3<f64>; 2] {
        let reach = |axis: usize, sign: f64| {
            let direction = Vector3::from_fn(|row, _| if row == axis { sign } else { 0.0 });
            self.support(&direction)[axis] + sign * self.solid.radius
        };
        [-1.0, 1.0].map(|sign| Vector3::from_fn(|axis, _| reach(axis, sign)))
    }

    /// [`Solid::depth`] of a point of the world.
    pub fn depth(&self, p: &Vector3<f64>) -> f64 {
        self.solid.depth(&self.turn.tr_mul(&(p - self.origin)))
    }
}
