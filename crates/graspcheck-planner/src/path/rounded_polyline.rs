//! Polylines through poses of the tool, with sharp or rounded corners.
//!
//! Along an edge the tool moves as on a straight line ([`super::line`]); the path parameter is proportional to the
//! way (an edge on which it only turns counts [`TURN_RADIUS`] for each rad). A corner is one of [`Corner`]:
//!
//! - *sharp*: the motion stops there;
//! - an *arc* that touches both edges: the direction is continuous, the curvature jumps by 1/radius. With the
//!   change of direction φ and the radius r it takes `d = r tan(φ/2)` of each edge and misses the corner by
//!   `r (1/cos(φ/2) − 1)`;
//! - a *blend* of continuous curvature: the two straight motions overlap, the one fading out while the other
//!   fades in. With x from −d to d,
//!
//! ```text
//! p(x) = p_corner − t_in f(−x) + t_out f(x),   f'' = 3/(4d) (1 − x²/d²),   f = 3d/16 + x/2 + 3x²/(8d) − x⁴/(16d³)
//! ```
//!
//! where t are the velocities of the edges by x. f and f'' vanish at −d and f' rises from 0 to 1, so that position,
//! direction and curvature are continuous (class C2; the third derivative steps). The corner is missed by
//! `3d/16 |t_out − t_in|`. The orientation is blended in the same way, by turns about the axes of both edges.
//! (A symmetric quartic in place of the quintic of Macfarlane and Croft, "Jerk-bounded manipulator trajectory
//! planning", 2003; derived here.)
//!
//! ```
//! use graspcheck_planner::path::rounded_polyline::{Corner, rounded_polyline};
//! use nalgebra::{Isometry3, Vector3};
//!
//! let vertices = [[0.0, 0.0], [0.2, 0.0], [0.2, 0.2]].map(|[x, y]| Isometry3::translation(x, y, 0.0));
//! let path = rounded_polyline(&vertices, Corner::Blend { tolerance: 0.01 })?;
//! assert!(path.junctions().iter().all(|junction| junction.class == 2));
//! // In the middle of the path it is nearest to the corner, by exactly the tolerance.
//! let miss = path.pose(0.5).translation.vector - Vector3::new(0.2, 0.0, 0.0);
//! assert!((miss.norm() - 0.01).abs() < 1e-12);
//! # Ok::<(), graspcheck_planner::path::PathError>(())
//! ```

use graspcheck_model::{
    Pose,
    tool_path::{ArcCurve, OrientationCurve, PositionCurve, ToolPath, ToolSegment, Turn},
};
use graspcheck_motion::Polynomial;
use nalgebra::{Unit, UnitQuaternion, Vector3};

use super::{NOTHING, PathError, check_pose};

/// The way that a turn in place counts, m for each rad: about the size of a gripper.
pub const TURN_RADIUS: f64 = 0.1;

/// A change of direction within this of half a turn, rad, is a reversal, which no arc rounds.
const REVERSAL: f64 = 1e-6;

/// How corners are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Corner {
    /// Left as they are: continuous in position alone.
    Sharp,
    /// Rounded by an arc: continuous direction.
    Arc {
        /// Radius of the arc, m.
        radius: f64,
    },
    /// Rounded by an arc that misses the corner by a distance: continuous direction.
    ArcWithin {
        /// The distance, m.
        tolerance: f64,
    },
    /// Rounded by a blend: continuous curvature.
    Blend {
        /// By how much the corner is missed, m.
        tolerance: f64,
    },
}

impl Corner {
    /// How many derivatives by s are continuous at the ends of a corner.
    #[must_use]
    pub fn class(self) -> usize {
        match self {
            Self::Sharp => 0,
            Self::Arc { .. } | Self::ArcWithin { .. } => 1,
            Self::Blend { .. } => 2,
        }
    }

    /// Its size: radius or tolerance, m, with its name.
    fn size(self) -> Option<(&'static str, f64)> {
        match self {
            Self::Sharp => None,
            Self::Arc { radius } => Some(("radius, m,", radius)),
            Self::ArcWithin { tolerance } | Self::Blend { tolerance } => Some(("tolerance, m,", tolerance)),
        }
    }
}

/// The polyline through these poses of the tool; all corners are made alike, s runs from 0 to 1.
///
/// Corners at which nothing changes (the same direction, the same turning) stay as they are.
///
/// # Errors
/// When there are fewer than two vertices, a number is not finite, two neighbours are the same, a radius or
/// tolerance is not positive, an arc cannot round a corner, or two corners overlap; then the largest that fits is
/// given.
pub fn rounded_polyline(vertices: &[Pose], corner: Corner) -> Result<ToolPath, PathError> {
    if vertices.len() < 2 {
        return Err(PathError::TooFewVertices { count: vertices.len() });
    }
    for vertex in vertices {
        check_pose(vertex, "a vertex")?;
    }
    if let Some((quantity, value)) = corner.size()
        && !(value > 0.0 && value.is_finite())
    {
        return Err(PathError::BadNumber { quantity, value, must: "finite and positive" });
    }
    let edges: Vec<Edge> =
        vertices.windows(2).map(|two| Edge::new(&two[0], &two[1])).collect::<Result<_, _>>()?;
    let mut cuts = vec![None];
    for (index, two) in edges.windows(2).enumerate() {
        cuts.push(Cut::new(index + 1, &two[0], &two[1], corner)?);
    }
    cuts.push(None);
    let reach = |cut: &Option<Cut>| cut.as_ref().map_or(0.0, |cut| cut.reach);
    for (index, edge) in edges.iter().enumerate() {
        let needed = reach(&cuts[index]) + reach(&cuts[index + 1]);
        if let Some((_, size)) = corner.size()
            && needed > edge.length * (1.0 + NOTHING)
        {
            let most = size * edge.length / needed;
            let missing = needed - edge.length;
            return Err(PathError::CornersOverlap {
                edge: index,
                length: edge.length,
                needed,
                most,
                missing,
            });
        }
    }
    let mut pieces = Vec::with_capacity(2 * edges.len());
    for (index, edge) in edges.iter().enumerate() {
        if let Some(cut) = &cuts[index] {
            pieces.push(cut.piece(&edges[index - 1], edge));
        }
        let (from, to) = (reach(&cuts[index]), edge.length - reach(&cuts[index + 1]));
        if to - from > NOTHING * edge.length {
            pieces.push(edge.piece(from, to));
        }
    }
    joined(pieces)
}

/// A stretch of the path with its length in the way travelled, of which its curves are functions.
struct Piece {
    length: f64,
    position: PositionCurve,
    orientation: OrientationCurve,
}

/// The pieces one after the other, with the path parameter from 0 to 1.
fn joined(pieces: Vec<Piece>) -> Result<ToolPath, PathError> {
    let total: f64 = pieces.iter().map(|piece| piece.length).sum();
    let count = pieces.len();
    let mut travelled = 0.0;
    let mut start = 0.0;
    let mut segments = Vec::with_capacity(count);
    for (index, piece) in pieces.into_iter().enumerate() {
        travelled += piece.length;
        let end = if index + 1 == count { 1.0 } else { travelled / total };
        let Piece { position, orientation, .. } = piece;
        let position = match position {
            PositionCurve::Polynomial(p) => PositionCurve::Polynomial(p.map(|p| by_share(&p, total))),
            PositionCurve::Arc(arc) => {
                PositionCurve::Arc(ArcCurve { rate: arc.rate * total, along: arc.along * total, ..arc })
            }
        };
        let turns = orientation.turns.into_iter();
        let turns = turns.map(|turn| Turn { angle: by_share(&turn.angle, total), ..turn }).collect();
        let orientation = OrientationCurve { start: orientation.start, turns };
        segments.push(ToolSegment { start, end, position, orientation });
        start = end;
    }
    Ok(ToolPath::new(segments)?)
}

/// A polynomial of the way as one of its share of the total.
fn by_share(polynomial: &Polynomial, total: f64) -> Polynomial {
    let mut coefficients = *polynomial.coefficients();
    let mut power = 1.0;
    for coefficient in &mut coefficients {
        *coefficient *= power;
        power *= total;
    }
    Polynomial::new(coefficients)
}

/// A straight edge.
struct Edge {
    from: Pose,
    /// The way: of the position, or [`TURN_RADIUS`] for each rad when there is none, m.
    length: f64,
    /// Velocity of the position by the way: a unit vector, or zero.
    direction: Vector3<f64>,
    /// Angular velocity by the way, rad/m.
    turning: Vector3<f64>,
}

impl Edge {
    fn new(from: &Pose, to: &Pose) -> Result<Self, PathError> {
        let way = to.translation.vector - from.translation.vector;
        let turn = (to.rotation * from.rotation.inverse()).scaled_axis();
        let length = if way.norm() > NOTHING { way.norm() } else { TURN_RADIUS * turn.norm() };
        if length <= NOTHING {
            return Err(PathError::NoLength { distance: way.norm(), angle: turn.norm() });
        }
        Ok(Self { from: *from, length, direction: way / length, turning: turn / length })
    }

    /// Position and orientation when it has been followed for some of its way.
    fn at(&self, way: f64) -> (Vector3<f64>, UnitQuaternion<f64>) {
        let turn = UnitQuaternion::from_scaled_axis(self.turning * way);
        (self.from.translation.vector + self.direction * way, turn * self.from.rotation)
    }

    fn piece(&self, from: f64, to: f64) -> Piece {
        let (start, rotation) = self.at(from);
        let position = [0, 1, 2].map(|axis| Polynomial::new([start[axis], self.direction[axis]]));
        let (axis, rate) = axis_of(&self.turning);
        let angle = Polynomial::new([0.0, rate]);
        let orientation = OrientationCurve::turning(rotation, axis, angle);
        Piece { length: to - from, position: PositionCurve::Polynomial(position), orientation }
    }
}

/// Axis and size of an angular velocity; any axis for zero.
fn axis_of(turning: &Vector3<f64>) -> (Unit<Vector3<f64>>, f64) {
    Unit::try_new_and_get(*turning, NOTHING).unwrap_or((Vector3::z_axis(), 0.0))
}

/// What is cut off around a corner.
struct Cut {
    /// Of each of both edges, m.
    reach: f64,
    /// For an arc its radius, m, and the change of direction, rad.
    arc: Option<(f64, f64)>,
}

impl Cut {
    /// The cut at a corner; none where the corner stays as it is.
    fn new(index: usize, before: &Edge, after: &Edge, corner: Corner) -> Result<Option<Self>, PathError> {
        let bend = (after.direction - before.direction).norm();
        let twist = (after.turning - before.turning).norm();
        if bend <= NOTHING && twist * TURN_RADIUS <= NOTHING {
            return Ok(None);
        }
        // A turn in place has no direction, and no arc leads into it.
        let moving = before.direction != Vector3::zeros() && after.direction != Vector3::zeros();
        let turn =
            before.direction.cross(&after.direction).norm().atan2(before.direction.dot(&after.direction));
        let half = 0.5 * turn;
        let arc = |radius: f64| {
            let rounds = moving && turn > NOTHING && turn < std::f64::consts::PI - REVERSAL;
            let cut = Self { reach: radius * half.tan(), arc: Some((radius, turn)) };
            if rounds { Ok(Some(cut)) } else { Err(PathError::NoArc { corner: index, turn }) }
        };
        match corner {
            Corner::Sharp => Ok(None),
            Corner::Arc { radius } => arc(radius),
            Corner::ArcWithin { tolerance } => {
                // 1/cos h − 1 = 2 sin²(h/2) / cos h, which does not cancel.
                let miss = 2.0 * (0.5 * half).sin().powi(2) / half.cos();
                if miss > 0.0 { arc(tolerance / miss) } else { Err(PathError::NoArc { corner: index, turn }) }
            }
            // Where only the turning changes, the blend is as long as at a reversal.
            Corner::Blend { tolerance } => {
                let bend = if bend > NOTHING { bend } else { 2.0 };
                Ok(Some(Self { reach: 16.0 / 3.0 * tolerance / bend, arc: None }))
            }
        }
    }

    fn piece(&self, before: &Edge, after: &Edge) -> Piece {
        let corner = after.from;
        let reach = self.reach;
        let (length, fading_out, fading_in, position) = match self.arc {
            None => {
                // f of x = σ − d, and f(−x) = f(x) − x.
                let d = reach;
                let f =
                    Polynomial::new([3.0 * d / 16.0, 0.5, 3.0 / (8.0 * d), 0.0, -1.0 / (16.0 * d.powi(3))]);
                let fading_in = f.shifted(-d);
                let mut c = *fading_in.coefficients();
                c[0] += d;
                c[1] -= 1.0;
                let fading_out = Polynomial::new(c);
                let position = [0, 1, 2].map(|axis| {
                    let start = corner.translation.vector[axis];
                    let (t_in, t_out) = (before.direction[axis], after.direction[axis]);
                    let sum = fading_in.coefficients().iter().zip(fading_out.coefficients());
                    let mut c = [0.0; 8];
                    for (c, (rise, fall)) in c.iter_mut().zip(sum) {
                        *c = t_out * rise - t_in * fall;
                    }
                    Polynomial::new(c).plus(start)
                });
                (2.0 * d, fading_out, fading_in, PositionCurve::Polynomial(position))
            }
            Some((radius, turn)) => {
                let start = corner.translation.vector - before.direction * reach;
                let toward_center =
                    (after.direction - before.direction * before.direction.dot(&after.direction)).normalize();
                let arc = ArcCurve {
                    center: start + toward_center * radius,
                    toward: -toward_center * radius,
                    across: before.direction * radius,
                    rate: 1.0 / radius,
                    along: Vector3::zeros(),
                };
                let length = radius * turn;
                // The rotation that both edges would make on what is cut off, faded by cubics of the same
                // end values and slopes.
                let fading_in = Polynomial::new([
                    0.0,
                    0.0,
                    (3.0 * reach - length) / length.powi(2),
                    (length - 2.0 * reach) / length.powi(3),
                ]);
                let fading_out = Polynomial::new([
                    reach,
                    -1.0,
                    (2.0 * length - 3.0 * reach) / length.powi(2),
                    (2.0 * reach - length) / length.powi(3),
                ]);
                (length, fading_out, fading_in, PositionCurve::Arc(arc))
            }
        };
        let ((in_axis, in_rate), (out_axis, out_rate)) = (axis_of(&before.turning), axis_of(&after.turning));
        let times = |polynomial: &Polynomial, factor: f64| {
            Polynomial::new(polynomial.coefficients().map(|c| factor * c))
        };
        // R = exp(out · fading in) exp(−in · fading out) R_corner.
        let turns = vec![
            Turn { axis: in_axis, angle: times(&fading_out, -in_rate) },
            Turn { axis: out_axis, angle: times(&fading_in, out_rate) },
        ];
        let orientation = OrientationCurve { start: corner.rotation, turns };
        Piece { length, position, orientation }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vertices() -> Vec<Pose> {
        let vertex = |x: f64, y: f64, z: f64, yaw: f64| {
            Pose::from_parts(
                Vector3::new(x, y, z).into(),
                UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw),
            )
        };
        vec![
            vertex(0.0, 0.0, 0.0, 0.0),
            vertex(0.3, 0.0, 0.0, 0.4),
            vertex(0.3, 0.2, 0.1, -0.5),
            vertex(0.0, 0.2, 0.1, -0.5),
        ]
    }

    fn miss(path: &ToolPath, corner: &Pose) -> f64 {
        (0..=100_000)
            .map(|k| {
                let at = path.pose(f64::from(k) / 100_000.0).translation.vector;
                (at - corner.translation.vector).norm()
            })
            .fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn corners_are_missed_by_the_tolerance_with_the_continuity_that_is_said() {
        let vertices = vertices();
        for corner in [Corner::Blend { tolerance: 0.004 }, Corner::ArcWithin { tolerance: 0.004 }] {
            let path = rounded_polyline(&vertices, corner).unwrap();
            let junctions = path.junctions();
            assert_eq!(junctions.len(), 4, "{corner:?}");
            assert!(junctions.iter().all(|junction| junction.class == corner.class()), "{junctions:?}");
            for vertex in &vertices[1..3] {
                let miss = miss(&path, vertex);
                assert!((miss - 0.004).abs() < 1e-8, "{corner:?}: {miss}");
            }
            for (s, vertex) in [(0.0, &vertices[0]), (1.0, &vertices[3])] {
                let pose = path.pose(s);
                assert!((pose.translation.vector - vertex.translation.vector).norm() < 1e-12);
                assert!(pose.rotation.angle_to(&vertex.rotation) < 1e-12);
            }
        }
        let sharp = rounded_polyline(&vertices, Corner::Sharp).unwrap();
        assert!(sharp.junctions().iter().all(|junction| junction.class == 0));
        assert!(miss(&sharp, &vertices[1]) < 1e-5);
    }

    #[test]
    fn an_arc_has_its_radius() {
        let path = rounded_polyline(&vertices(), Corner::Arc { radius: 0.05 }).unwrap();
        for segment in path.segments() {
            if let PositionCurve::Arc(arc) = &segment.position {
                assert!((arc.toward.norm() - 0.05).abs() < 1e-15);
                // The speed by s is the same on arcs and edges.
                let middle = path.eval(0.5 * (segment.start + segment.end));
                let speed = middle.derivatives[0].fixed_rows::<3>(0).norm();
                assert!((speed - path.eval(0.0).derivatives[0].fixed_rows::<3>(0).norm()).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_corner_that_is_too_large_names_the_largest_that_fits() {
        let vertices = vertices();
        for corner in [Corner::Blend { tolerance: 0.1 }, Corner::Arc { radius: 0.4 }] {
            let Err(PathError::CornersOverlap { edge, length, needed, most, missing }) =
                rounded_polyline(&vertices, corner)
            else {
                panic!("{corner:?} does not fit")
            };
            assert!((needed - length - missing).abs() < 1e-15, "edge {edge}");
            let with = |size: f64| match corner {
                Corner::Arc { .. } => Corner::Arc { radius: size },
                _ => Corner::Blend { tolerance: size },
            };
            assert!(rounded_polyline(&vertices[edge..edge + 2], with(most)).is_ok());
            let near = rounded_polyline(&vertices, with(most * 1.000_001));
            assert!(matches!(near, Err(PathError::CornersOverlap { .. })), "{near:?}");
        }
    }

    #[test]
    fn straight_through_is_no_corner_and_a_reversal_has_a_blend_only() {
        let at = |x: f64| Pose::translation(x, 0.0, 0.0);
        let path = rounded_polyline(&[at(0.0), at(0.1), at(0.3)], Corner::Arc { radius: 0.01 }).unwrap();
        assert!(path.junctions().iter().all(|junction| junction.class == 2));
        let back = [at(0.0), at(0.1), at(0.0)];
        assert!(matches!(
            rounded_polyline(&back, Corner::Arc { radius: 0.01 }),
            Err(PathError::NoArc { corner: 1, .. })
        ));
        let path = rounded_polyline(&back, Corner::Blend { tolerance: 0.01 }).unwrap();
        assert!(path.junctions().iter().all(|junction| junction.class == 2));
        assert!((miss(&path, &back[1]) - 0.01).abs() < 1e-8);
    }

    #[test]
    fn a_turn_in_place_can_be_blended() {
        let still = Pose::translation(0.1, 0.0, 0.0);
        let turned = Pose::from_parts(still.translation, UnitQuaternion::from_euler_angles(0.0, 0.0, 1.0));
        let vertices = [Pose::translation(0.0, 0.0, 0.0), still, turned];
        let path = rounded_polyline(&vertices, Corner::Blend { tolerance: 0.005 }).unwrap();
        assert!(path.junctions().iter().all(|junction| junction.class == 2), "{:?}", path.junctions());
        assert!(path.pose(1.0).rotation.angle_to(&turned.rotation) < 1e-12);
        let arc = rounded_polyline(&vertices, Corner::Arc { radius: 0.01 });
        assert!(matches!(arc, Err(PathError::NoArc { corner: 1, .. })), "{arc:?}");
    }

    #[test]
    fn bad_input_is_an_error() {
        let [a, b] = [Pose::identity(), Pose::translation(0.1, 0.0, 0.0)];
        let blend = Corner::Blend { tolerance: 0.01 };
        assert_eq!(rounded_polyline(&[a], blend), Err(PathError::TooFewVertices { count: 1 }));
        assert!(matches!(rounded_polyline(&[a, b, b], blend), Err(PathError::NoLength { .. })));
        for size in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let found = rounded_polyline(&[a, b], Corner::Arc { radius: size });
            assert!(matches!(found, Err(PathError::BadNumber { .. })), "{size}");
        }
        let nan = Pose::translation(f64::NAN, 0.0, 0.0);
        assert_eq!(rounded_polyline(&[a, nan], blend), Err(PathError::NotFinite { quantity: "a vertex" }));
    }
}
