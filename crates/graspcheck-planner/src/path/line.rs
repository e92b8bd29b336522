//! Straight lines of the tool (LIN): the origin on a straight line, the orientation about one axis.
//!
//! ```text
//! p(s) = p₀ + s (p₁ − p₀),   R(s) = exp(s φ) R₀,   φ = log(R₁ R₀⁻¹),   s from 0 to 1
//! ```
//!
//! (worked examples, section 1, with the axis in the world frame; the shortest rotation is the geodesic of
//! SO(3): Lynch and Park, *Modern Robotics*, 2017, section 9.2.1). Position and rotation are decoupled; for
//! both as one see [`super::screw`].
//!
//! In the plane (SE(2)) the angle can be the shortest one or literal: 3π/2 is three quarters of a turn and not a
//! quarter the other way.
//!
//! ```
//! use graspcheck_planner::path::line::{straight_line, straight_line_turning};
//! use nalgebra::{Isometry3, Vector3, Vector6};
//!
//! let from = Isometry3::translation(0.3, 0.0, 0.1);
//! let to = Isometry3::new(Vector3::new(0.3, 0.2, 0.1), Vector3::z() * 1.0);
//! let line = straight_line(&from, &to)?;
//! assert_eq!(line.eval(0.5).derivatives[0], Vector6::new(0.0, 0.2, 0.0, 0.0, 0.0, 1.0));
//!
//! // The same ends with a whole turn more.
//! let turning = straight_line_turning(&from, &to, &Vector3::z_axis(), 1.0 + std::f64::consts::TAU)?;
//! assert!((turning.eval(0.5).derivatives[0][5] - 7.283).abs() < 1e-3);
//! # Ok::<(), graspcheck_planner::path::PathError>(())
//! ```

use graspcheck_model::{
    Pose,
    tool_path::{JUNCTION_TOLERANCE, OrientationCurve, PositionCurve, ToolPath, ToolSegment},
};
use graspcheck_motion::Polynomial;
use nalgebra::{Unit, UnitQuaternion, Vector3};

use super::{NOTHING, PathError, check_pose};

/// The line between two poses of the tool, turning by the shortest way; of two equally short ways the one that
/// the logarithm of the rotation gives.
///
/// # Errors
/// When a pose is not finite, or both are the same up to rounding.
pub fn straight_line(world_from_start: &Pose, world_from_end: &Pose) -> Result<ToolPath, PathError> {
    check_pose(world_from_start, "the start")?;
    check_pose(world_from_end, "the end")?;
    let turn = (world_from_end.rotation * world_from_start.rotation.inverse()).scaled_axis();
    let (axis, angle) = if turn.norm() > NOTHING {
        (Unit::new_normalize(turn), turn.norm())
    } else {
        (Vector3::z_axis(), 0.0)
    };
    line(world_from_start, world_from_end, axis, angle)
}

/// The line between two poses of the tool, turning by the literal `angle` (rad) about an axis of the world: any
/// number of turns, either way.
///
/// # Errors
/// As [`straight_line`]; and when the angle does not lead to the orientation at the end, or the axis cannot.
pub fn straight_line_turning(
    world_from_start: &Pose,
    world_from_end: &Pose,
    axis: &Unit<Vector3<f64>>,
    angle: f64,
) -> Result<ToolPath, PathError> {
    check_pose(world_from_start, "the start")?;
    check_pose(world_from_end, "the end")?;
    if !(angle.is_finite() && axis.iter().all(|x| x.is_finite())) {
        return Err(PathError::NotFinite { quantity: "the turn" });
    }
    let rest = world_from_end.rotation
        * (UnitQuaternion::from_axis_angle(axis, angle) * world_from_start.rotation).inverse();
    let miss = rest.scaled_axis();
    let about_axis = miss.dot(axis);
    let lean = (miss - axis.into_inner() * about_axis).norm();
    if lean > JUNCTION_TOLERANCE {
        return Err(PathError::NotInPlane { angle: lean });
    }
    if about_axis.abs() > JUNCTION_TOLERANCE {
        return Err(PathError::WrongAngle { angle, miss: about_axis.abs(), nearest: angle + about_axis });
    }
    line(world_from_start, world_from_end, *axis, angle)
}

/// The line with this turn.
fn line(from: &Pose, to: &Pose, axis: Unit<Vector3<f64>>, angle: f64) -> Result<ToolPath, PathError> {
    let (start, way) = (from.translation.vector, to.translation.vector - from.translation.vector);
    if way.norm() <= NOTHING && angle.abs() <= NOTHING {
        return Err(PathError::NoLength { distance: way.norm(), angle: angle.abs() });
    }
    let position = [0, 1, 2].map(|axis| Polynomial::new([start[axis], way[axis]]));
    Ok(ToolPath::new(vec![ToolSegment {
        start: 0.0,
        end: 1.0,
        position: PositionCurve::Polynomial(position),
        orientation: OrientationCurve::turning(from.rotation, axis, Polynomial::new([0.0, angle])),
    }])?)
}
