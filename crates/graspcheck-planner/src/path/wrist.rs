//! The path of a planar arm's wrist: x, y and theta as polynomials of a common parameter, often the time itself.
//!
//! ```text
//! p(s) = T_WB (x(s), y(s), h),   R(s) = R_WB exp(z (θ(s) − θ₀)) R_BT(0)
//! ```
//!
//! h is the height of the tool over the base, θ₀ the angle of the last link at the zero position. The angle is
//! literal. Such a path tracks [`TrackedPoint::Wrist`](graspcheck_model::plan::TrackedPoint::Wrist), the end of the
//! second link; the last link only turns about it.
//!
//! ```
//! use graspcheck_model::example;
//! use graspcheck_motion::{Polynomial, Trajectory};
//! use graspcheck_planner::path::wrist::wrist_path;
//!
//! // x from 4 to 5 m in one second, y at 3 m, theta turning by a quarter.
//! let quarter = std::f64::consts::FRAC_PI_2;
//! let [x, y, theta] = [[4.0, 1.0], [3.0, 0.0], [0.0, quarter]].map(Polynomial::new);
//! let coordinates = Trajectory::new(3, vec![0.0, 1.0], vec![x, y, theta])?;
//! let path = wrist_path(&example::planar(), &coordinates)?;
//! assert_eq!(path.pose(1.0).translation.vector.xy(), nalgebra::Vector2::new(5.0, 3.0));
//! assert!((path.pose(1.0).rotation.angle() - quarter).abs() < 1e-15);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use graspcheck_model::{
    inverse::Unreachable,
    robot::RobotModel,
    structure::PlanarGeometry,
    tool_path::{OrientationCurve, PositionCurve, ToolPath, ToolSegment},
};
use graspcheck_motion::{Polynomial, Trajectory};
use nalgebra::{UnitQuaternion, Vector3};

use super::PathError;

/// Why there is no path of the wrist.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WristPathError {
    /// The arm has no such wrist.
    #[error(transparent)]
    NoWrist(#[from] Unreachable),
    /// The polynomials make no path.
    #[error(transparent)]
    Path(#[from] PathError),
}

/// The path of the wrist whose x, y (m, base frame) and angle theta of the last link (rad, literal) are the three
/// "joints" of `coordinates`, with its time as path parameter.
///
/// # Errors
/// When the arm is no planar R-R-R, there are not three coordinates, or one of them jumps.
pub fn wrist_path(robot: &RobotModel, coordinates: &Trajectory) -> Result<ToolPath, WristPathError> {
    let no_wrist = |reason| Unreachable::NoClosedForm { robot: robot.name.clone(), reason };
    let geometry = PlanarGeometry::of(robot).map_err(no_wrist)?;
    if geometry.quill.is_some() {
        return Err(no_wrist("it is not a planar R-R-R arm".to_owned()).into());
    }
    let must = "3: x, y and theta";
    if coordinates.dof() != 3 {
        let value = coordinates.dof() as f64;
        return Err(PathError::BadNumber { quantity: "number of coordinates", value, must }.into());
    }
    let world_from_base = robot.world_from_base;
    let [east, north, up] =
        [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()].map(|axis| world_from_base.rotation * axis);
    let origin = world_from_base.translation.vector + up.into_inner() * geometry.tool_height;
    let at_zero_angle = UnitQuaternion::from_axis_angle(&up, -geometry.tool_angle_zero())
        * world_from_base.rotation
        * geometry.base_from_tool_zero;
    let knots = coordinates.knots();
    let segment = |piece: usize| {
        let [x, y, theta] = [0, 1, 2].map(|k| coordinates.piece(piece, k));
        let position = [0, 1, 2].map(|axis| {
            let (x, y) = (x.coefficients(), y.coefficients());
            let turned = std::array::from_fn::<f64, 8, _>(|k| east[axis] * x[k] + north[axis] * y[k]);
            Polynomial::new(turned).plus(origin[axis])
        });
        ToolSegment {
            start: knots[piece],
            end: knots[piece + 1],
            position: PositionCurve::Polynomial(position),
            orientation: OrientationCurve::turning(at_zero_angle, up, *theta),
        }
    };
    let segments = (0..coordinates.piece_count()).map(segment).collect();
    Ok(ToolPath::new(segments).map_err(PathError::from)?)
}
