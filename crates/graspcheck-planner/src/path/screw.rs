//! The screw: the tool turns about an axis in space and slides along it, both in proportion to s.
//!
//! Every change of pose is a screw (Chasles). With the twist `ξ = log(T₁ T₀⁻¹)` the path is
//!
//! ```text
//! T(s) = exp(s ξ) T₀,   s from 0 to 1
//! ```
//!
//! (Lynch and Park, *Modern Robotics*, 2017, sections 3.3.3 and 9.2.1): the tool's origin runs along a helix about
//! the screw's axis. Without a rotation it is a straight line; see [`super::line`] for the path whose origin stays
//! on a straight line while the tool turns.
//!
//! ```
//! use graspcheck_planner::path::screw::screw_motion;
//! use nalgebra::{Isometry3, Vector3};
//!
//! // Half a turn about an axis 0.1 m away, and 0.2 m up: half of it is a quarter turn and 0.1 m up.
//! let from = Isometry3::translation(0.1, 0.0, 0.0);
//! let to = Isometry3::new(Vector3::new(-0.1, 0.0, 0.2), Vector3::z() * 3.141592653589793);
//! let middle = screw_motion(&from, &to)?.pose(0.5);
//! assert!((middle.translation.vector - Vector3::new(0.0, 0.1, 0.1)).norm() < 1e-12);
//! # Ok::<(), graspcheck_planner::path::PathError>(())
//! ```

use graspcheck_model::{
    Pose,
    tool_path::{ArcCurve, OrientationCurve, PositionCurve, ToolPath, ToolSegment},
};
use graspcheck_motion::Polynomial;
use nalgebra::{Unit, Vector3};

use super::{PathError, check_pose, line::straight_line};

/// A rotation below this angle, rad, makes a screw whose axis is so far away that rounding would move it by more
/// than the arm is long; the path is then a straight line, from which it differs by an eighth of the angle times
/// its length.
const ANGLE_MIN: f64 = 1e-9;

/// The screw between two poses of the tool, by the shortest rotation.
///
/// # Errors
/// When a pose is not finite, or both are the same up to rounding.
pub fn screw_motion(world_from_start: &Pose, world_from_end: &Pose) -> Result<ToolPath, PathError> {
    check_pose(world_from_start, "the start")?;
    check_pose(world_from_end, "the end")?;
    let turn = (world_from_end.rotation * world_from_start.rotation.inverse()).scaled_axis();
    let angle = turn.norm();
    if angle < ANGLE_MIN {
        return straight_line(world_from_start, world_from_end);
    }
    let axis = Unit::new_normalize(turn);
    let (start, end) = (world_from_start.translation.vector, world_from_end.translation.vector);
    let slide = axis.dot(&(end - start));
    // In the plane across the axis a chord c under the angle θ: the center is at c/2 + (n × c) / (2 tan(θ/2)).
    let chord = end - start - axis.into_inner() * slide;
    let to_center = 0.5 * chord + axis.cross(&chord) * (0.5 / (0.5 * angle).tan());
    let toward: Vector3<f64> = -to_center;
    let arc = ArcCurve {
        center: start + to_center,
        toward,
        across: axis.cross(&toward),
        rate: angle,
        along: axis.into_inner() * slide,
    };
    let orientation =
        OrientationCurve::turning(world_from_start.rotation, axis, Polynomial::new([0.0, angle]));
    let position = PositionCurve::Arc(arc);
    Ok(ToolPath::new(vec![ToolSegment { start: 0.0, end: 1.0, position, orientation }])?)
}
