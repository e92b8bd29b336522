//! Convex solids: how far they reach, how far they are from an axis, how deep a point lies in them.

use serde::Deserialize;

use crate::{
    LARGEST,
    vector::{Pose, Vector},
};

/// Corners nearer than this to a plane, m, lie in it.
const IN_PLANE: f64 = 1e-12;

/// A convex solid, all lengths in m: the hull of some points, with a disc across z (of a cylinder) or a ball
/// (of a sphere or capsule) around each of them.
#[derive(Clone, Debug, Deserialize)]
#[serde(try_from = "Shape")]
pub(crate) struct Solid {
    points: Vec<Vector>,
    disc: f64,
    pub(crate) ball: f64,
    /// Whether its points are so near to its origin that rounding is far below what is allowed for it.
    is_small: bool,
}

/// How fast a point p of a solid, in its frame, moves along some direction with a joint:
/// `at_origin + gradient·p`; and how far the joint goes below and above.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slope {
    pub(crate) at_origin: f64,
    pub(crate) gradient: Vector,
    pub(crate) below: f64,
    pub(crate) above: f64,
}

impl Slope {
    fn most(&self, p: Vector) -> f64 {
        let speed = self.at_origin + self.gradient.dot(p);
        (speed * self.above).max(-speed * self.below)
    }
}

impl Solid {
    /// How much farther along `n`, of length 1 and in its frame, its points can get than the farthest one is,
    /// when each moves on by what all slopes together allow at most, m.
    ///
    /// What is added is convex in the point, so that corners suffice. Of a disc of radius r, across z, the points
    /// `r u` count for every u of length 1. Let w be the direction of n across z and x its share, and let the
    /// slopes add `m·r u` with m no longer than Λ across z. Then `r ‖x w + m‖` exceeds what `r w` gets, which is
    /// `r (x + m·w)`, by at most `r Λ²/(2x)` (the most over all m of length Λ), or by `2r (Λ - x)` where Λ > 2x. The centre
    /// gets there too, but for `r (x + Λ)`: that is less where n lies along z.
    pub(crate) fn advance(&self, n: Vector, slopes: &[Slope]) -> f64 {
        let farthest = |aside: Vector| {
            let at = |p: &Vector| {
                let p = *p + aside;
                n.dot(p) + slopes.iter().map(|slope| slope.most(p)).sum::<f64>()
            };
            self.points.iter().map(at).fold(f64::NEG_INFINITY, f64::max)
        };
        let still = self.points.iter().map(|p| n.dot(*p)).fold(f64::NEG_INFINITY, f64::max);
        if self.disc == 0.0 {
            return farthest(Vector::ZERO) - still;
        }
        let across = across_z(n);
        let tilt: f64 =
            slopes.iter().map(|slope| across_z(slope.gradient) * slope.below.max(slope.above)).sum();
        let from_center = farthest(Vector::ZERO) + self.disc * tilt - still;
        if across <= IN_PLANE {
            return from_center;
        }
        let Vector([x, y, _]) = n * (self.disc / across);
        let excess = if tilt <= 2.0 * across { 0.5 * tilt * tilt / across } else { 2.0 * (tilt - across) };
        let from_rim = farthest(Vector([x, y, 0.0])) + self.disc * (excess - across) - still;
        from_center.min(from_rim)
    }
}

/// A solid in a document; axes lie along z.
#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum Shape {
    Box { half_extents: Vector },
    Sphere { radius: f64 },
    Cylinder { radius: f64, half_length: f64 },
    Capsule { radius: f64, half_length: f64 },
    Hull { points: Vec<Vector> },
}

impl TryFrom<Shape> for Solid {
    type Error = String;

    fn try_from(shape: Shape) -> Result<Self, String> {
        let ends = |half_length: f64| [-half_length, half_length].map(|z| Vector([0.0, 0.0, z])).to_vec();
        let (lengths, points, disc, ball) = match shape {
            Shape::Box { half_extents: Vector([x, y, z]) } => {
                let corner = |i: usize| {
                    let sign = |bit: usize| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
                    Vector([sign(0) * x, sign(1) * y, sign(2) * z])
                };
                (vec![x, y, z], (0..8).map(corner).collect(), 0.0, 0.0)
            }
            Shape::Sphere { radius } => (vec![radius], vec![Vector::ZERO], 0.0, radius),
            Shape::Cylinder { radius, half_length } => {
                (vec![radius, half_length], ends(half_length), radius, 0.0)
            }
            Shape::Capsule { radius, half_length } => {
                (vec![radius, half_length], ends(half_length), 0.0, radius)
            }
            Shape::Hull { points } if has_volume(&points) => (vec![], points, 0.0, 0.0),
            Shape::Hull { .. } => return Err("the points of a hull lie in a plane".to_owned()),
        };
        match lengths.into_iter().find(|length| !(*length > 0.0 && *length < LARGEST)) {
            Some(length) => Err(format!("a length of {length} m is not positive and below {LARGEST} m")),
            None => {
                let is_small = points.iter().all(|p| p.is_within(LARGEST));
                Ok(Self { points, disc, ball, is_small })
            }
        }
    }
}

/// Whether some tetrahedron of the points is thicker than [`IN_PLANE`].
fn has_volume(points: &[Vector]) -> bool {
    let Some(&first) = points.first() else { return false };
    let farthest = |measure: &dyn Fn(Vector) -> f64| {
        let measured = points.iter().map(|&p| (measure(p - first), p - first));
        measured.fold((0.0, Vector::ZERO), |best, one| if one.0 > best.0 { one } else { best })
    };
    let (_, along) = farthest(&|p| p.length());
    let (_, aside) = farthest(&|p| p.cross(along).length());
    let across = along.cross(aside);
    farthest(&|p| p.dot(across).abs()).0 > IN_PLANE * across.length()
}

/// A solid at a place in the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed<'s> {
    pub(crate) solid: &'s Solid,
    pub(crate) world_from_solid: Pose,
}

impl Placed<'_> {
    /// The support function `max n·p` over the points p of the solid, m, for n of length 1.
    pub(crate) fn reach(&self, n: Vector) -> f64 {
        let local = self.world_from_solid.vector_back(n);
        let along = self.solid.points.iter().map(|p| p.dot(local)).fold(f64::NEG_INFINITY, f64::max);
        along + self.solid.disc * across_z(local) + self.solid.ball + n.dot(self.world_from_solid.origin)
    }

    /// The point that lies farthest along `n` (of any length) when the ball is left away, m.
    pub(crate) fn farthest(&self, n: Vector) -> Vector {
        let local = self.world_from_solid.vector_back(n);
        let further = |best: Vector, p: &Vector| if p.dot(local) > best.dot(local) { *p } else { best };
        let point = self.solid.points.iter().fold(self.solid.points[0], further);
        let across = across_z(local);
        let scale = if across > 0.0 { self.solid.disc / across } else { 0.0 };
        let Vector([x, y, _]) = local * scale;
        self.world_from_solid.point(point + Vector([x, y, 0.0]))
    }

    /// A bound on the distance of the solid's points from a line with a direction of length 1, m: exact, but for
    /// cylinders askew to it. The ball is left away: it looks the same however it is turned, so that it reaches
    /// as far beyond its centre as before.
    pub(crate) fn distance_from_line(&self, origin: Vector, axis: Vector) -> f64 {
        let Solid { points, disc, .. } = self.solid;
        let axis = self.world_from_solid.vector_back(axis);
        let origin = self.world_from_solid.vector_back(origin - self.world_from_solid.origin);
        let square = |p: &Vector| {
            let across = (*p - origin).cross(axis);
            across.dot(across)
        };
        let of_points = points.iter().map(square).fold(0.0, f64::max).sqrt();
        if *disc == 0.0 {
            return of_points;
        }
        // Each point of a rim is as far from the middle as its disc is wide and high.
        let all_round = square(&Vector::ZERO).sqrt() + points[0].length().hypot(*disc);
        (of_points + disc).min(all_round)
    }

    /// The smallest box along the axes of the world around it: least and largest coordinates, m.
    pub(crate) fn bounds(&self) -> [Vector; 2] {
        [-1.0, 1.0].map(|sign| Vector([0, 1, 2].map(|i| sign * self.reach(Vector::unit(i) * sign))))
    }

    /// How deep a point of the world lies in the solid, m: a ball of this radius about it stays inside.
    /// Negative outside.
    pub(crate) fn depth(&self, point: Vector) -> f64 {
        let Vector([x, y, z]) = self.world_from_solid.vector_back(point - self.world_from_solid.origin);
        let Solid { points, disc, ball, .. } = self.solid;
        let half_length = points[points.len() - 1].0[2];
        if *disc > 0.0 {
            (disc - x.hypot(y)).min(half_length - z.abs())
        } else if *ball > 0.0 {
            ball - Vector([x, y, z - z.clamp(-half_length, half_length)]).length()
        } else {
            depth_in_hull(points, Vector([x, y, z]))
        }
    }

    /// Whether all of it is so near to the world's origin that rounding is far below what is allowed for it.
    pub(crate) fn is_near(&self) -> bool {
        self.solid.is_small && self.world_from_solid.origin.is_within(LARGEST)
    }
}

/// How deep a point lies in the hull of some points: below each plane through three of them that has no
/// point above.
fn depth_in_hull(points: &[Vector], inside: Vector) -> f64 {
    let mut depth = f64::INFINITY;
    for (i, &p) in points.iter().enumerate() {
        for (j, &q) in points.iter().enumerate().skip(i + 1) {
            for &r in points.iter().skip(j + 1) {
                let n = (q - p).cross(r - p);
                let length = n.length();
                if length <= IN_PLANE * IN_PLANE {
                    continue;
                }
                for n in [n * (1.0 / length), n * (-1.0 / length)] {
                    if points.iter().all(|s| n.dot(*s - p) <= IN_PLANE) {
                        depth = depth.min(n.dot(p - inside));
                    }
                }
            }
        }
    }
    depth
}

/// The length of a vector across z.
fn across_z(Vector([x, y, _]): Vector) -> f64 {
    (x * x + y * y).sqrt()
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::fixture::{boxed, pose, read};

    fn solids() -> Vec<Solid> {
        let corners: Vec<[f64; 3]> = (0..8)
            .map(|i| [0, 1, 2].map(|bit| [0.1, 0.2, 0.3][bit] * if i >> bit & 1 == 0 { -1.0 } else { 1.0 }))
            .collect();
        [
            boxed(0.1, 0.2, 0.3),
            json!({"hull": {"points": corners}}),
            json!({"sphere": {"radius": 0.1}}),
            json!({"cylinder": {"radius": 0.1, "half_length": 0.3}}),
            json!({"capsule": {"radius": 0.1, "half_length": 0.3}}),
        ]
        .map(read)
        .into()
    }

    const N: Vector = Vector([2.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0]);

    #[test]
    fn supports_are_those_of_closed_forms_at_any_place() {
        let across = (1.0_f64 - 4.0 / 9.0).sqrt();
        let boxed = (0.2 + 0.2 + 0.6) / 3.0;
        let expected = [boxed, boxed, 0.1, 0.1 * across + 0.2, 0.1 + 0.2];
        let place: Pose = read(pose([0.4, -0.5, 0.6], [0.0, 0.6, 0.8], 1.1));
        for (solid, expected) in solids().iter().zip(expected) {
            let placed = Placed { solid, world_from_solid: place };
            let n = place.vector(N);
            assert!((placed.reach(n) - n.dot(place.origin) - expected).abs() < 1e-15, "{solid:?}");
            // The farthest point is as far as the support, less the ball.
            assert!(
                (placed.farthest(n * 3.0).dot(n) + solid.ball - placed.reach(n)).abs() < 1e-15,
                "{solid:?}"
            );
        }
    }

    #[test]
    fn distances_from_a_line_are_those_of_closed_forms() {
        let line = (Vector([1.0, 0.0, 5.0]), Vector([0.0, 0.0, 1.0]));
        let corner = 1.1_f64.hypot(0.2);
        for (solid, expected) in solids().iter().zip([corner, corner, 1.0, 1.1, 1.0]) {
            let placed = Placed { solid, world_from_solid: Pose::IDENTITY };
            assert!((placed.distance_from_line(line.0, line.1) - expected).abs() < 1e-15, "{solid:?}");
        }
    }

    #[test]
    fn depths_are_those_of_closed_forms() {
        let place: Pose = read(pose([0.4, -0.5, 0.6], [0.0, 0.6, 0.8], 1.1));
        let depths = |p: [f64; 3]| {
            solids()
                .iter()
                .map(|solid| Placed { solid, world_from_solid: place }.depth(place.point(Vector(p))))
                .collect::<Vec<_>>()
        };
        for (point, expected) in [
            ([0.0, 0.0, 0.0], [0.1, 0.1, 0.1, 0.1, 0.1]),
            ([0.03, 0.04, 0.28], [0.02, 0.02, 0.1 - 0.0809_f64.sqrt(), 0.02, 0.05]),
            ([0.0, 0.15, 0.0], [0.05, 0.05, -0.05, -0.05, -0.05]),
            ([0.0, 0.0, 0.35], [-0.05, -0.05, -0.25, -0.05, 0.05]),
        ] {
            for (depth, expected) in depths(point).iter().zip(expected) {
                assert!((depth - expected).abs() < 1e-12, "{point:?}: {:?}", depths(point));
            }
        }
    }

    #[test]
    fn what_is_no_solid_is_refused() {
        let square = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.0, 1.0, 1.0]];
        for shape in [
            boxed(0.1, 0.0, 0.1),
            json!({"sphere": {"radius": -0.1}}),
            json!({"capsule": {"radius": 0.1, "half_length": 2e4}}),
            json!({"hull": {"points": []}}),
            json!({"hull": {"points": square}}),
            json!({"torus": {"radius": 0.1}}),
        ] {
            assert!(serde_json::from_value::<Solid>(shape.clone()).is_err(), "{shape}");
        }
    }
}
