//! Circular arcs of the tool's origin (CIRC), through three points or about a center.
//!
//! ```text
//! p(s) = c + cos(θ s) u + sin(θ s) n × u,   u = p₀ − c,   s from 0 to 1
//! ```
//!
//! (Siciliano et al., *Robotics: Modelling, Planning and Control*, section 4.3.1). Through three points the center
//! is that of the circle through them; with `a = p₁ − p₀`, `b = p₂ − p₀`:
//!
//! ```text
//! c = p₀ + (|b|² (a × b) × a + |a|² b × (a × b)) / (2 |a × b|²)
//! ```
//!
//! The tool keeps its orientation, turns by the shortest way to another, or turns with the arc.
//!
//! ```
//! use graspcheck_planner::path::arc::{ArcTurn, arc_through};
//! use nalgebra::{Isometry3, Vector3};
//!
//! let from = Isometry3::translation(1.0, 0.0, 0.0);
//! let arc = arc_through(&from, &Vector3::new(0.0, 1.0, 0.0), &Vector3::new(-1.0, 0.0, 0.0), ArcTurn::Along)?;
//! let middle = arc.pose(0.5);
//! assert!((middle.translation.vector - Vector3::y()).norm() < 1e-12);
//! assert!((middle.rotation.angle() - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
//! # Ok::<(), graspcheck_planner::path::PathError>(())
//! ```

use graspcheck_model::{
    Pose,
    tool_path::{ArcCurve, OrientationCurve, PositionCurve, ToolPath, ToolSegment},
};
use graspcheck_motion::Polynomial;
use nalgebra::{Unit, UnitQuaternion, Vector3};

use super::{NOTHING, PathError, check_pose};

/// The least height of the middle point over the line through the others, as a share of their distance.
///
/// The reason: the center moves by the rounding of the points divided by it, so that an arc as flat as this is
/// still met to 1e-10 of its size, and it differs from a straight line by a millionth.
const FLATNESS_MIN: f64 = 1e-6;

/// How the tool turns on an arc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ArcTurn {
    /// It keeps its orientation.
    Fixed,
    /// It turns with the arc, about the arc's axis.
    Along,
    /// It turns by the shortest way to this orientation (from the tool to the world).
    To(UnitQuaternion<f64>),
}

/// The arc that begins at a pose of the tool and leads through a point to another (world frame, m).
///
/// # Errors
/// When a number is not finite, or the points are on one line, or two of them are the same.
pub fn arc_through(
    world_from_start: &Pose,
    through: &Vector3<f64>,
    end: &Vector3<f64>,
    turn: ArcTurn,
) -> Result<ToolPath, PathError> {
    check_pose(world_from_start, "the start")?;
    if !through.iter().chain(end.iter()).all(|x| x.is_finite()) {
        return Err(PathError::NotFinite { quantity: "a point of the arc" });
    }
    let start = world_from_start.translation.vector;
    let (a, b) = (through - start, end - start);
    let normal = a.cross(&b);
    let longest = a.norm().max(b.norm()).max((a - b).norm());
    let (height, needed) = (normal.norm() / longest.max(f64::MIN_POSITIVE), FLATNESS_MIN * longest);
    if longest <= NOTHING || height <= needed {
        return Err(PathError::Collinear { height, needed: needed.max(NOTHING) });
    }
    let center = start
        + (normal.cross(&a) * b.norm_squared() + b.cross(&normal) * a.norm_squared())
            / (2.0 * normal.norm_squared());
    let axis = Unit::new_normalize(normal);
    let toward = start - center;
    let to_end = end - center;
    // The middle point is on the way when the arc turns about a × b, by the angle from start to end, 0 to 2π.
    let angle = toward.cross(&to_end).dot(&axis).atan2(toward.dot(&to_end)).rem_euclid(std::f64::consts::TAU);
    arc(world_from_start, &center, &axis, angle, turn)
}

/// The arc from a pose of the tool about a center (world frame, m) and an axis, by a literal angle (rad) that may
/// be negative, or more than a turn. What the start is above the plane of the center stays.
///
/// # Errors
/// When a number is not finite, the angle is zero, or the start is on the axis.
pub fn arc_about(
    world_from_start: &Pose,
    center: &Vector3<f64>,
    axis: &Unit<Vector3<f64>>,
    angle: f64,
    turn: ArcTurn,
) -> Result<ToolPath, PathError> {
    check_pose(world_from_start, "the start")?;
    if !(angle.is_finite() && center.iter().chain(axis.iter()).all(|x| x.is_finite())) {
        return Err(PathError::NotFinite { quantity: "center, axis or angle of the arc" });
    }
    let out = world_from_start.translation.vector - center;
    let center = center + axis.into_inner() * axis.dot(&out);
    let radius = (world_from_start.translation.vector - center).norm();
    if radius <= NOTHING {
        let must = "above zero: the start must not be on the axis";
        return Err(PathError::BadNumber { quantity: "radius, m,", value: radius, must });
    }
    if radius * angle.abs() <= NOTHING {
        return Err(PathError::NoLength { distance: radius * angle.abs(), angle: angle.abs() });
    }
    arc(world_from_start, &center, axis, angle, turn)
}

/// The arc about a center in its plane.
fn arc(
    world_from_start: &Pose,
    center: &Vector3<f64>,
    axis: &Unit<Vector3<f64>>,
    angle: f64,
    turn: ArcTurn,
) -> Result<ToolPath, PathError> {
    let toward = world_from_start.translation.vector - center;
    let curve = ArcCurve {
        center: *center,
        toward,
        across: axis.cross(&toward),
        rate: angle,
        along: Vector3::zeros(),
    };
    let rotation = world_from_start.rotation;
    let orientation = match turn {
        ArcTurn::Fixed => OrientationCurve::fixed(rotation),
        ArcTurn::Along => OrientationCurve::turning(rotation, *axis, Polynomial::new([0.0, angle])),
        ArcTurn::To(end) => {
            if !end.coords.iter().all(|x| x.is_finite()) {
                return Err(PathError::NotFinite { quantity: "the orientation at the end of the arc" });
            }
            let turn = (end * rotation.inverse()).scaled_axis();
            match Unit::try_new(turn, NOTHING) {
                Some(axis) => OrientationCurve::turning(rotation, axis, Polynomial::new([0.0, turn.norm()])),
                None => OrientationCurve::fixed(rotation),
            }
        }
    };
    let position = PositionCurve::Arc(curve);
    Ok(ToolPath::new(vec![ToolSegment { start: 0.0, end: 1.0, position, orientation }])?)
}
