//! Paths: where the motion leads, without saying when.
//!
//! A path of the joints q(s) has three derivatives by its parameter s ([`Path`]); with a law of time s(t) it is a
//! motion:
//!
//! ```text
//! qd   = q_s sd
//! qdd  = q_s sdd + q_ss sd²
//! qddd = q_s sddd + 3 q_ss sd sdd + q_sss sd³
//! ```
//!
//! (worked examples, sections 1 and 3; Biagiotti and Melchiorri, *Trajectory Planning for Automatic Machines and
//! Robots*, chapter 8). A path of the tool ([`ToolPath`]) leads through poses; it becomes one of the joints by
//! staying on one branch of the inverse kinematics ([`FollowedPath`]).
//!
//! | path | module | continuity by s |
//! |---|---|---|
//! | straight in the joints | [`joint_line`] | all derivatives |
//! | straight for the tool, turning by the shortest way or a literal angle | [`mod@line`] | all derivatives |
//! | screw | [`screw`] | all derivatives |
//! | circular arc | [`arc`] | all derivatives |
//! | polyline with rounded corners | [`rounded_polyline`] | direction (arcs) or curvature (blends) |
//! | through joint positions | [`joint_spline`] | bend |
//! | through points or poses of the tool | [`spline`], [`orientation_spline`] | curvature |
//! | of the wrist of a planar arm | [`wrist`] | that of its coordinates |
//!
//! Reading order: [`joint_line`], [`mod@line`], [`screw`], [`arc`], [`rounded_polyline`], [`joint_spline`], [`spline`],
//! [`followed`], [`motion`].

pub mod arc;
pub(crate) mod fit;
pub mod followed;
pub mod joint_line;
pub mod joint_spline;
pub mod line;
pub mod motion;
pub mod orientation_spline;
pub mod rounded_polyline;
pub mod screw;
pub mod spline;
pub mod wrist;

pub use followed::{FollowError, FollowedPath};
pub use graspcheck_model::tool_path::{Junction, ToolPath, ToolPoint};
pub use joint_line::JointLine;
pub use joint_spline::JointSpline;
pub use motion::{PathMotion, along};

/// A place on a path of the joints, with three derivatives by the path parameter.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PathPoint {
    /// Joint positions, rad or m.
    pub q: Vec<f64>,
    /// First derivative by s.
    pub q_s: Vec<f64>,
    /// Second derivative by s.
    pub q_ss: Vec<f64>,
    /// Third derivative by s.
    pub q_sss: Vec<f64>,
}

/// A path of the joints.
pub trait Path {
    /// The number of joints.
    fn dof(&self) -> usize;

    /// The path parameter at both ends.
    fn range(&self) -> [f64; 2];

    /// The joints at `s`; where formulas meet, those of the later one.
    ///
    /// # Panics
    /// When `s` is outside the range.
    fn eval(&self, s: f64) -> PathPoint;
}

/// A size below which a way or an angle counts as none, m and rad: the rounding of poses of some metres.
const NOTHING: f64 = 1e-12;

/// Why there is no such path.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PathError {
    /// A number is NaN or infinite.
    #[error("path: {quantity} is not finite")]
    NotFinite {
        /// Which.
        quantity: &'static str,
    },
    /// Positions of two lengths.
    #[error("path: {from} joint positions at its start and {to} at its end; give one for each joint")]
    JointCount {
        /// At the start.
        from: usize,
        /// At the end.
        to: usize,
    },
    /// Start and end are the same, and so is everything between.
    #[error(
        "path: has no length: the tool moves {distance:.3e} m and turns {angle:.3e} rad; leave it out, or move its end"
    )]
    NoLength {
        /// m.
        distance: f64,
        /// rad.
        angle: f64,
    },
    /// An angle in the plane is given for poses that are turned about other axes.
    #[error(
        "path: leans {angle:.3e} rad from the plane in which the tool should turn; give a pose in the plane"
    )]
    NotInPlane {
        /// rad.
        angle: f64,
    },
    /// A literal angle does not lead to the orientation at the end.
    #[error(
        "path: a turn of {angle} rad ends {miss} rad from the orientation at the end; the nearest that fits is \
         {nearest} rad"
    )]
    WrongAngle {
        /// What was given, rad.
        angle: f64,
        /// By how much it misses, rad.
        miss: f64,
        /// The nearest angle that does not, rad.
        nearest: f64,
    },
    /// Three points of an arc are on one line.
    #[error(
        "arc: its three points are on a line up to {height:.3e} m, of {needed:.3e} m needed; move the middle \
         point away from the line between the others, or use a straight line"
    )]
    Collinear {
        /// Height of the middle point over the line through the others, m.
        height: f64,
        /// The least height that makes an arc, m.
        needed: f64,
    },
    /// A radius, a tolerance, a pitch axis or a normal has no size.
    #[error("path: {quantity} {value} must be {must}")]
    BadNumber {
        /// Which.
        quantity: &'static str,
        /// What was given.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// A polyline has too few vertices.
    #[error("polyline: has {count} vertices; give at least two")]
    TooFewVertices {
        /// How many there are.
        count: usize,
    },
    /// The tool turns back on itself, or turns in place, where an arc should round the corner.
    #[error(
        "polyline, corner {corner}: no arc rounds a corner of {turn:.6} rad; use a blend of continuous \
         curvature, or leave the corner sharp"
    )]
    NoArc {
        /// Index of the vertex.
        corner: usize,
        /// By how much the direction changes, rad.
        turn: f64,
    },
    /// The rounded corners at both ends of an edge overlap.
    #[error(
        "polyline, edge {edge}: its corners take {needed:.6} m of its {length:.6} m; the largest rounding that \
         fits is {most:.6} m, or lengthen the edge by {missing:.6} m"
    )]
    CornersOverlap {
        /// Index of the edge: from this vertex to the next.
        edge: usize,
        /// Length of the edge, m.
        length: f64,
        /// What both corners take, m.
        needed: f64,
        /// The largest tolerance (or radius) for which they fit, m.
        most: f64,
        /// How much longer the edge would have to be, m.
        missing: f64,
    },
    /// Two neighbours of a spline are the same, or its places do not rise.
    #[error("spline, point {point}: is {way:.3e} (m or rad) from the point before it; leave one of them out")]
    SamePoint {
        /// Number of the point, from 1.
        point: usize,
        /// m or rad.
        way: f64,
    },
    /// There is not one angle for each point of a spline.
    #[error("spline: {angles} angles for {points} points; give one for each point")]
    AngleCount {
        /// How many points.
        points: usize,
        /// How many angles.
        angles: usize,
    },
    /// There is not one place for each orientation of a spline, or fewer than two.
    #[error("spline: {places} places for {orientations} orientations; give one for each, and at least two")]
    PlaceCount {
        /// How many places.
        places: usize,
        /// How many orientations.
        orientations: usize,
    },
    /// A spline of orientations does not settle.
    #[error(
        "spline: turns by up to {largest:.3} rad from a pose to the next, too much for one curve; put poses between them"
    )]
    TurnsTooLarge {
        /// rad.
        largest: f64,
    },
    /// The points of a spline make no sense.
    #[error("spline: {0}")]
    Points(#[from] crate::via::ViaError),
    /// The segments make no path.
    #[error(transparent)]
    ToolPath(#[from] graspcheck_model::tool_path::ToolPathError),
}

/// Checks that a pose is finite.
fn check_pose(pose: &graspcheck_model::Pose, quantity: &'static str) -> Result<(), PathError> {
    let finite = pose.translation.vector.iter().chain(pose.rotation.coords.iter()).all(|x| x.is_finite());
    if finite { Ok(()) } else { Err(PathError::NotFinite { quantity }) }
}
