//! Through via points of the tool: splines of its position and of one angle.
//!
//! The coordinates x, y, z and the angle about an axis are piecewise polynomials of a common parameter, as a
//! spline through via points gives them; their knots become segments of the path, their continuity its
//! continuity:
//!
//! ```text
//! p(s) = (x(s), y(s), z(s)),   R(s) = exp(n α(s)) R₀
//! ```
//!
//! Angles are literal, so that a tool can turn any number of times. Orientations that turn about different axes
//! from point to point need another construction and are not made here.
//!
//! ```
//! use graspcheck_motion::{Polynomial, Trajectory};
//! use graspcheck_planner::path::spline::through_coordinates;
//! use nalgebra::{UnitQuaternion, Vector3};
//!
//! // x and y on a parabola, z fixed, the tool turning by 1 rad; one piece from 0 to 2.
//! let coordinates = Trajectory::new(4, vec![0.0, 2.0], vec![
//!     Polynomial::new([0.3, 0.1]),
//!     Polynomial::new([0.0, 0.0, 0.05]),
//!     Polynomial::constant(0.1),
//!     Polynomial::new([0.0, 0.5]),
//! ])?;
//! let path = through_coordinates(&coordinates, &UnitQuaternion::identity(), &Vector3::z_axis())?;
//! assert!((path.pose(2.0).translation.vector - Vector3::new(0.5, 0.2, 0.1)).norm() < 1e-15);
//! assert!((path.pose(1.0).rotation.angle() - 0.5).abs() < 1e-15);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use graspcheck_model::tool_path::{OrientationCurve, PositionCurve, ToolPath, ToolSegment};
use graspcheck_motion::Trajectory;
use nalgebra::{Unit, UnitQuaternion, Vector3};

use super::PathError;

/// The path whose x, y, z (m) and angle (rad) about `axis` (world) are the four "joints" of `coordinates`, with
/// its time as path parameter. At angle 0 the orientation is `world_from_tool`.
///
/// # Errors
/// When there are not four coordinates, a number is not finite, or a coordinate jumps.
pub fn through_coordinates(
    coordinates: &Trajectory,
    world_from_tool: &UnitQuaternion<f64>,
    axis: &Unit<Vector3<f64>>,
) -> Result<ToolPath, PathError> {
    if coordinates.dof() != 4 {
        return Err(PathError::BadNumber {
            quantity: "number of coordinates",
            value: coordinates.dof() as f64,
            must: "4: x, y, z and the angle",
        });
    }
    let knots = coordinates.knots();
    let segments = (0..coordinates.piece_count()).map(|piece| {
        let [x, y, z, angle] = [0, 1, 2, 3].map(|coordinate| *coordinates.piece(piece, coordinate));
        ToolSegment {
            start: knots[piece],
            end: knots[piece + 1],
            position: PositionCurve::Polynomial([x, y, z]),
            orientation: OrientationCurve::turning(*world_from_tool, *axis, angle),
        }
    });
    Ok(ToolPath::new(segments.collect())?)
}
