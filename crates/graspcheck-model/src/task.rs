//! What the robot is asked to do, and how fast.

use nalgebra::{Point2, Vector3};
use serde::{Deserialize, Serialize};

use crate::{
    Pose,
    via::{EndCondition, ViaLaw},
};

/// What the robot is asked to do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Task {
    /// Grasp an object, carry it and put it down.
    PickAndPlace(PickAndPlace),
    /// Pass Cartesian points of the wrist at given times (planar arms).
    CartesianVia(CartesianVia),
    /// Pass joint positions at given times.
    JointVia(JointVia),
    /// Move through joint positions one segment after the other.
    JointSegments(JointSegments),
    /// Lead the tool along lines, screws, arcs, polylines and splines.
    Path(PathTask),
}

/// Grasp the object at one of its handles, carry it and put it down.
///
/// Phases: `approach` (joint move to the pre-grasp pose), `descend` (straight), `close`, `lift`
/// (straight), `carry` (joint move), `lower` (straight), `open`, `retreat` (straight).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PickAndPlace {
    /// Where the arm starts, rad or m.
    pub start: Vec<f64>,
    /// Where the object must end.
    pub world_from_placed: Pose,
    /// How far before the handle the straight approach begins, along the handle's x axis, m.
    pub pregrasp_distance: f64,
    /// Straight move with the object from where it was grasped, world frame, m.
    pub departure: Vector3<f64>,
    /// The straight move that puts the object down begins this far from the place, world frame, m.
    pub arrival: Vector3<f64>,
    /// Straight move away after the release, against the tool's x axis, m.
    pub retreat_distance: f64,
    /// Force of each finger, N.
    pub grip_force: f64,
    /// How long the fingers are given to close, s.
    pub close_duration: f64,
    /// How long the fingers are given to open, s.
    pub open_duration: f64,
}

impl Task {
    /// Whether the law of the motion has steps of acceleration by nature.
    #[must_use]
    pub fn steps_acceleration(&self) -> bool {
        match self {
            Self::CartesianVia(CartesianVia { law, .. }) | Self::JointVia(JointVia { law, .. }) => {
                law.steps_acceleration()
            }
            Self::PickAndPlace(_) | Self::JointSegments(_) | Self::Path(_) => false,
        }
    }
}

/// Pass points of the plane with the wrist at given times. The first phase begins at 0; the arm rests at the
/// first point until its motion begins.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "CartesianViaInFile")]
pub struct CartesianVia {
    /// The points in order of time.
    pub points: Vec<ViaPoint>,
    /// How they are passed, in the coordinates x, y and theta.
    pub law: ViaLaw,
    /// Which elbow the arm keeps, `left` (positive elbow angle) or `right`.
    pub elbow: Elbow,
    /// How far the joint polynomials may leave the Cartesian motion, m and rad.
    pub tolerance: f64,
}

/// The form in files. Older ones have `blend`, the duration of all blends (s), in the place of the law.
#[derive(Deserialize)]
struct CartesianViaInFile {
    points: Vec<ViaPoint>,
    law: Option<ViaLaw>,
    blend: Option<f64>,
    elbow: Elbow,
    tolerance: f64,
}

impl TryFrom<CartesianViaInFile> for CartesianVia {
    type Error = &'static str;

    fn try_from(file: CartesianViaInFile) -> Result<Self, &'static str> {
        let CartesianViaInFile { points, law, blend, elbow, tolerance } = file;
        let of_blend = || blend.map(|blend| ViaLaw::blends_of(blend, points.len(), 3));
        let law = law.or_else(of_blend).ok_or("via points without a law")?;
        Ok(Self { points, law, elbow, tolerance })
    }
}

/// Pass joint positions at given times. The first phase begins at 0; the arm rests at the first point until
/// its motion begins.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointVia {
    /// The points in order of time.
    pub points: Vec<JointViaPoint>,
    /// How they are passed, in the coordinates of the joints.
    pub law: ViaLaw,
}

/// Joint positions that are passed at a given time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointViaPoint {
    /// When, s.
    pub t: f64,
    /// Where, rad or m.
    pub q: Vec<f64>,
}

/// A point that an arm in the plane passes at a given time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ViaPoint {
    /// When, s.
    pub t: f64,
    /// The wrist (end of link 2) in the base frame, m.
    pub wrist: Point2<f64>,
    /// Absolute angle of link 3 against the x axis, literal (not wrapped), rad.
    pub theta: f64,
}

/// The branch of the elbow: on which side of the straight arm the forearm lies, seen against the direction
/// of the axes. The arms of the assets are straight at position 0 of the second joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Elbow {
    /// The second joint is at or above the position in which the arm is straight.
    Left,
    /// The second joint is below that position.
    Right,
}

/// Move through joint positions one segment after the other. A segment whose `from` is not where the one
/// before it ended is a jump, which the continuity check names.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointSegments {
    /// In order of time.
    pub segments: Vec<JointSegment>,
}

/// A straight move in joint space, from rest to rest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointSegment {
    /// A name for the phase.
    pub name: String,
    /// Where it starts, rad or m.
    pub from: Vec<f64>,
    /// Where it ends, rad or m.
    pub to: Vec<f64>,
}

/// Lead the tool along one path after the other, from rest to rest, each a phase of its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PathTask {
    /// Where the arm starts, rad or m: this chooses the branch and the turns too.
    pub start: Vec<f64>,
    /// How far the joint polynomials may take the tool from its path, m and rad; proved.
    pub tolerance: f64,
    /// In order of time.
    pub segments: Vec<PathSegment>,
}

/// A path that begins where the tool is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PathSegment {
    /// A name for the phase.
    pub name: String,
    /// Whether points are counted from where the tool is when the path begins, along the world's axes; else from the
    /// world's origin.
    pub from_start: bool,
    /// Where it leads.
    pub shape: PathShape,
}

/// Where a path of the tool leads. Points are along the world's axes, m; the tool turns about the base's z axis by
/// literal angles, rad.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PathShape {
    /// On a straight line.
    Line {
        /// To where.
        to: Vector3<f64>,
        /// By how much the tool turns on the way.
        turn: f64,
    },
    /// On a screw: the shortest one to the pose at the end.
    Screw {
        /// To where.
        to: Vector3<f64>,
        /// By how much the tool is turned at the end; between −π and π.
        turn: f64,
    },
    /// On a circular arc through a point.
    ArcThrough {
        /// A point on the way.
        through: Vector3<f64>,
        /// To where.
        to: Vector3<f64>,
        /// Whether the tool turns with the arc; else it keeps its orientation.
        turns_along: bool,
    },
    /// On a circular arc about a line along the base's z axis.
    ArcAbout {
        /// A point on that line.
        center: Vector3<f64>,
        /// By how much: positive against the clock as seen from above.
        angle: f64,
        /// Whether the tool turns with the arc; else it keeps its orientation.
        turns_along: bool,
    },
    /// Straight from point to point, with the orientation kept.
    Polyline {
        /// The points after the one where the tool is.
        points: Vec<Vector3<f64>>,
        /// How the corners are made.
        corner: PathCorner,
    },
    /// On a cubic spline, with continuous curvature: the tool need not stop at its points.
    Spline {
        /// The points after the one where the tool is.
        points: Vec<Vector3<f64>>,
        /// By how much the tool is turned at each of them, counted from where the path begins.
        turns: Vec<f64>,
        /// What holds at its ends, of the derivatives by the path parameter.
        ends: EndCondition,
    },
}

/// How the corners of a polyline are made.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PathCorner {
    /// The tool stops.
    Sharp,
    /// Rounded by an arc of this radius, m; the tool stops where it begins and ends, as the curvature jumps there.
    Arc(f64),
    /// Rounded with continuous curvature, missing the corner by this distance, m.
    Blend(f64),
}

/// How fast the arm moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pace {
    /// Share of the velocity, acceleration and jerk limits that is used, 0 < share ≤ 1.
    pub share: f64,
    /// How position follows time in joint moves.
    #[serde(default)]
    pub law: TimeLaw,
    /// What the joints of a joint move have in common.
    #[serde(default)]
    pub sync: Sync,
    /// Phases that differ.
    pub phases: Vec<PhasePace>,
    /// What the controller makes of the motion, where it does not follow the plan's own polynomials.
    #[serde(default)]
    pub set_points: Option<SetPoints>,
}

/// A motion that reaches the controller as set points, between which the controller interpolates.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SetPoints {
    /// Time from one set point to the next, s.
    pub period: f64,
    /// How the controller interpolates.
    pub interpolation: Interpolation,
}

/// How a controller interpolates between two set points, by what each of them carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Interpolation {
    /// Positions alone: straight lines. The velocity jumps at every set point.
    Linear,
    /// Positions and velocities: cubics. The acceleration jumps.
    Cubic,
    /// Positions, velocities and accelerations: quintics. The jerk jumps.
    Quintic,
}

/// How fast the arm moves in one phase.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PhasePace {
    /// Name of the phase.
    pub phase: String,
    /// Share of the limits, where it differs.
    pub share: Option<f64>,
    /// Exact duration, s: the same law, stretched or compressed in time, even past the limits.
    pub duration: Option<f64>,
    /// How position follows time, where it differs; for joint moves alone.
    #[serde(default)]
    pub law: Option<TimeLaw>,
    /// What the joints have in common, where it differs; for joint moves alone.
    #[serde(default)]
    pub sync: Option<Sync>,
}

/// How position follows time between two states of rest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TimeLaw {
    /// Seven phases of constant jerk: the fastest under limits on velocity, acceleration and jerk.
    #[default]
    SCurve,
    /// One polynomial of degree five: keeps the same limits, and has no jumps of acceleration either.
    Quintic,
    /// One polynomial of degree three: its acceleration jumps at both ends.
    Cubic,
    /// Constant acceleration, cruise, constant deceleration: its acceleration jumps at every corner, and no
    /// jerk limit is looked at.
    Trapezoid,
}

/// What the joints of a move have in common.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sync {
    /// One law of time, so that the path is straight in joint space.
    #[default]
    Straight,
    /// The end: each joint has its own law, and the path is not straight. The slowest joint sets the time.
    EndTimes,
}
