//! Through via points of the tool: C² splines of its position and its orientation.
//!
//! [`through_points`] turns the tool about one axis by literal angles, so that it can turn any number of times:
//!
//! ```text
//! p(s) = (x(s), y(s), z(s)),   R(s) = exp(n α(s)) R₀,   x, y, z, α cubic splines of s
//! ```
//!
//! This is SE(2), and what a SCARA can do. [`through_poses`] is for SE(3): the position is a natural cubic spline, and
//! the orientation one of [`orientation_spline`](super::orientation_spline), which turns about any axes from pose to
//! pose. Both have the parameter s from 0 to 1 in proportion to the straight ways between the points, a turn of 1 rad
//! counting as [`WAY_OF_A_TURN`] (chord length; Piegl and Tiller, *The NURBS Book*, 2nd edition, section 9.2.1). Who
//! has a parameter of their own, time for instance, uses [`through_coordinates`].
//!
//! Three derivatives by s are exact, and the first two are continuous, so that the tool need not stop at the points.
//!
//! ```
//! use graspcheck_planner::path::spline::through_poses;
//! use nalgebra::{Isometry3, Vector3};
//!
//! // Over a bump, leaning to one side and then to the other.
//! let pose = |x: f64, z: f64, lean: Vector3<f64>| Isometry3::new(Vector3::new(x, 0.0, z), lean);
//! let poses = [
//!     pose(0.3, 0.1, Vector3::zeros()),
//!     pose(0.4, 0.2, Vector3::x() * 0.5),
//!     pose(0.5, 0.1, Vector3::y() * 0.4),
//! ];
//! let path = through_poses(&poses)?;
//! assert_eq!(path.junctions()[0].class, 2); // at the middle pose, where s is 1/2 or so
//! let there = path.pose(path.junctions()[0].s);
//! assert!(there.rotation.angle_to(&poses[1].rotation) < 1e-12);
//! # Ok::<(), graspcheck_planner::path::PathError>(())
//! ```

use graspcheck_model::{
    Pose,
    tool_path::{OrientationCurve, PositionCurve, ToolPath, ToolSegment},
};
use graspcheck_motion::Trajectory;
use nalgebra::{Unit, UnitQuaternion, Vector3};

use super::{PathError, check_pose, joint_spline::shares, orientation_spline::OrientationSpline};
use crate::via::{
    ViaPoints,
    spline::{SplineEnd, SplineEnds, through},
};

/// The way that a turn of 1 rad counts as where points divide the path parameter, m.
///
/// The reason: a tool that turns in place must have a way, too; 0.1 m is the size of a hand.
pub const WAY_OF_A_TURN: f64 = 0.1;

/// The way from a point to another with a turn between them, m.
fn way(distance: f64, turn: f64) -> f64 {
    distance.hypot(WAY_OF_A_TURN * turn)
}

/// The C² path through `points` (m, world) on which the tool is turned by the literal `angles` (rad) about `axis`
/// (world) at them, counted from the orientation `world_from_tool`.
///
/// ```
/// use graspcheck_planner::{path::spline::through_points, via::spline::{SplineEnd, SplineEnds}};
/// use nalgebra::{UnitQuaternion, Vector3};
///
/// // A slalom with a turn and a half of the tool.
/// let points = [[0.3, 0.0, 0.1], [0.35, 0.05, 0.1], [0.4, 0.0, 0.1]].map(Vector3::from);
/// let ends = SplineEnds::both(SplineEnd::Natural);
/// let path =
///     through_points(&points, &[0.0, 3.0, 9.4], &UnitQuaternion::identity(), &Vector3::z_axis(), &ends)?;
/// assert!((path.pose(1.0).translation.vector - points[2]).norm() < 1e-15);
/// assert!((path.pose(1.0).rotation.angle() - (9.4 - std::f64::consts::TAU)).abs() < 1e-12);
/// # Ok::<(), graspcheck_planner::path::PathError>(())
/// ```
///
/// # Errors
/// When there are fewer than two points or not as many angles, two neighbours are the same, a number is not finite, or
/// the ends ask for what the points do not have.
pub fn through_points(
    points: &[Vector3<f64>],
    angles: &[f64],
    world_from_tool: &UnitQuaternion<f64>,
    axis: &Unit<Vector3<f64>>,
    ends: &SplineEnds,
) -> Result<ToolPath, PathError> {
    if angles.len() != points.len() {
        return Err(PathError::AngleCount { points: points.len(), angles: angles.len() });
    }
    let coordinates: Vec<Vec<f64>> =
        points.iter().zip(angles).map(|(point, angle)| vec![point.x, point.y, point.z, *angle]).collect();
    let ways = points.windows(2).zip(angles.windows(2));
    let places = shares(ways.map(|(point, angle)| way((point[1] - point[0]).norm(), angle[1] - angle[0])))?;
    let spline = through(&ViaPoints::new(places, coordinates)?, ends)?;
    through_coordinates(&spline, world_from_tool, axis)
}

/// The C² path through `poses` (world from tool): a natural spline of the position and one of the orientation, by the
/// shorter turn from each pose to the next. It moves and turns with the poses: all of them moved by one transform, the
/// path is moved by it.
///
/// # Errors
/// When there are fewer than two poses, two neighbours are the same, a number is not finite, or the turns are too large
/// for one spline.
pub fn through_poses(poses: &[Pose]) -> Result<ToolPath, PathError> {
    for pose in poses {
        check_pose(pose, "a pose")?;
    }
    let ways = poses.windows(2).map(|pair| {
        let distance = (pair[1].translation.vector - pair[0].translation.vector).norm();
        way(distance, pair[0].rotation.angle_to(&pair[1].rotation))
    });
    let places = shares(ways)?;
    let positions = poses.iter().map(|pose| pose.translation.vector.iter().copied().collect()).collect();
    let points = ViaPoints::new(places.clone(), positions)?;
    let position = through(&points, &SplineEnds::both(SplineEnd::Natural))?;
    let orientations: Vec<_> = poses.iter().map(|pose| pose.rotation).collect();
    let orientation = OrientationSpline::through(&places, &orientations)?;
    let segment = |piece: usize| ToolSegment {
        start: places[piece],
        end: places[piece + 1],
        position: PositionCurve::Polynomial([0, 1, 2].map(|axis| *position.piece(piece, axis))),
        orientation: orientation.curve(piece),
    };
    Ok(ToolPath::new((0..poses.len() - 1).map(segment).collect())?)
}

/// The path whose x, y, z (m) and angle (rad) about `axis` (world) are the four "joints" of `coordinates`, with
/// its time as path parameter. At angle 0 the orientation is `world_from_tool`.
///
/// ```
/// use graspcheck_motion::{Polynomial, Trajectory};
/// use graspcheck_planner::path::spline::through_coordinates;
/// use nalgebra::{UnitQuaternion, Vector3};
///
/// // x and y on a parabola, z fixed, the tool turning by 1 rad; one piece from 0 to 2.
/// let coordinates = Trajectory::new(4, vec![0.0, 2.0], vec![
///     Polynomial::new([0.3, 0.1]),
///     Polynomial::new([0.0, 0.0, 0.05]),
///     Polynomial::constant(0.1),
///     Polynomial::new([0.0, 0.5]),
/// ])?;
/// let path = through_coordinates(&coordinates, &UnitQuaternion::identity(), &Vector3::z_axis())?;
/// assert!((path.pose(2.0).translation.vector - Vector3::new(0.5, 0.2, 0.1)).norm() < 1e-15);
/// assert!((path.pose(1.0).rotation.angle() - 0.5).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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
