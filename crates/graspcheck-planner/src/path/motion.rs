//! The motion of the joints along a path of the tool: the law of time, the polynomials, and the proof that the
//! tool stays on the path.
//!
//! The tool stops where the path has no continuous curvature (a sharp corner, a line into an arc): a joint would
//! need an infinite or a stepping acceleration there. Between stops s(t) is an S-curve whose shape comes from what
//! the path asks of the joints, and the motion is then stretched in time by the exact factor at which its
//! tightest joint limit is just met.
//!
//! The proof is made for the finished polynomials, at the end, by the same function that a reviewer calls on
//! the recorded plan: [`prove_deviation`].

use graspcheck_model::{
    planar_path::PlanarPath,
    robot::{JointLimits, RobotModel},
    tool_path::ToolPath,
};
use graspcheck_motion::{Jet, Polynomial, Trajectory, TrajectoryError};
use graspcheck_proof::deviation::{
    Deviation, DeviationError, DeviationOutcome, PieceDeviation, prove_deviation,
};

use super::{
    FollowedPath,
    fit::{FitError, fit},
    followed::FollowError,
};
use crate::{
    arm::Arm,
    branch::Located,
    retime,
    time_scaling::{ScalingError, TimeScaling, error::positive},
};

/// How near the joint polynomials of a path come to it.
///
/// The reason: a tenth of the repeatability of the arms that graspcheck is for, and a few hundredths of the
/// clearances that are asked for.
pub const PATH_TOLERANCE: Deviation = Deviation { position: 1e-5, angle: 1e-5 };

/// Places between two stops at which the slopes of the path are looked at for the shape of the law.
const SHAPE_PLACES: u32 = 32;

/// Halvings that find the instant at which the law reaches a place, down to the spacing of floats.
const BISECTIONS: u32 = 60;

/// Share of a phase of the law next to whose ends no knot is put.
///
/// The reason: a shorter piece moves by nothing but rounding.
const SHORTEST_SHARE: f64 = 1e-9;

/// A motion of the joints along a path of the tool.
#[derive(Clone, Debug, PartialEq)]
pub struct PathMotion {
    /// The joints.
    pub motion: Trajectory,
    /// The path parameter over the same time, as a motion of one "joint".
    pub law: Trajectory,
    /// Proved bounds on the deviation of the tool from the path, over stretches that cover the motion.
    pub deviations: Vec<PieceDeviation>,
}

impl PathMotion {
    /// The proved bound on the deviation over the whole motion.
    #[must_use]
    pub fn deviation(&self) -> Deviation {
        self.deviations.iter().map(|piece| piece.bound).fold(Deviation::default(), Deviation::max)
    }
}

/// Why there is no motion along a path.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AlongError {
    /// The path cannot be followed.
    #[error(transparent)]
    Follow(#[from] FollowError),
    /// There is no law of time under the limits.
    #[error("path: {0}")]
    Scaling(#[from] ScalingError),
    /// The share of the limits is not within (0, 1], or a tolerance is not positive.
    #[error("path: {quantity} {value} must be {must}")]
    BadNumber {
        /// Which.
        quantity: &'static str,
        /// What was given.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// The polynomials are not a trajectory.
    #[error("path: {0}")]
    Trajectory(#[from] TrajectoryError),
    /// Motion and path do not belong together.
    #[error("path: {0}")]
    Deviation(#[from] DeviationError),
    /// The finished motion is not proved to be on the path, although all of its pieces were.
    #[error("path: the motion could not be proved to stay within {tolerance:.3e} of it; raise the tolerance")]
    NotProved {
        /// The tolerance, m or rad.
        tolerance: f64,
    },
}

impl From<Located> for AlongError {
    fn from(located: Located) -> Self {
        Self::Follow(located.into())
    }
}

impl From<FitError> for AlongError {
    fn from(error: FitError) -> Self {
        match error {
            FitError::Located(located) => located.into(),
            FitError::Trajectory(error) => error.into(),
        }
    }
}

/// The joint motion along a path of the tool, from rest at `from` (joint positions at its beginning, rad or m) to
/// rest at its end.
///
/// `share` of the joints' limits of velocity, acceleration and jerk is used (0 < share ≤ 1); between any two stops
/// the tightest of them is met from below to 1e-9. With a `duration` (s) the same motion is stretched or compressed
/// to last exactly that, even past the limits. The tool is proved to stay within `tolerance` of the path.
///
/// # Errors
/// Where and why the path cannot be followed; or the arm has no closed-form inverse kinematics; or limits, share,
/// duration or tolerance are not positive.
///
/// ```
/// use graspcheck_model::example;
/// use graspcheck_planner::path::{along, line::straight_line, motion::PATH_TOLERANCE};
/// use nalgebra::Isometry3;
///
/// let (robot, from) = (example::scara(), [-0.5, 1.2, -0.1, 3.0]);
/// let start = robot.world_from_tool(&from);
/// let line = straight_line(&start, &(Isometry3::translation(0.0, 0.1, 0.0) * start))?;
/// let found = along(&robot, &line, &from, 1.0, None, PATH_TOLERANCE)?;
/// assert!(found.deviation().position < 1e-5);
/// let end = robot.world_from_tool(&found.motion.eval(found.motion.duration()).q);
/// assert!((end.translation.y - start.translation.y - 0.1).abs() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn along(
    robot: &RobotModel,
    path: &ToolPath,
    from: &[f64],
    share: f64,
    duration: Option<f64>,
    tolerance: Deviation,
) -> Result<PathMotion, AlongError> {
    along_path(&Arm::new(robot).map_err(FollowError::from)?, path, from, share, duration, tolerance)
}

/// As [`along`], for an arm that is measured already.
pub(crate) fn along_path(
    arm: &Arm,
    path: &ToolPath,
    from: &[f64],
    share: f64,
    duration: Option<f64>,
    tolerance: Deviation,
) -> Result<PathMotion, AlongError> {
    let is_share = share > 0.0 && share <= 1.0;
    if !is_share {
        let (quantity, must) = ("share of the limits", "above 0 and at most 1");
        return Err(AlongError::BadNumber { quantity, value: share, must });
    }
    for value in [tolerance.position, tolerance.angle] {
        let is_positive = value > 0.0 && value.is_finite();
        if !is_positive {
            let (quantity, must) = ("tolerance (m or rad)", "finite and positive");
            return Err(AlongError::BadNumber { quantity, value, must });
        }
    }
    let followed = FollowedPath::of_arm(arm, path, from)?;
    let limits: Vec<JointLimits> = arm.robot.joints.iter().map(|joint| joint.limits).collect();
    let mut whole: Option<(Trajectory, Trajectory)> = None;
    let stops = path.junctions().into_iter().filter(|junction| junction.class < 2).map(|junction| junction.s);
    let mut start = path.start();
    for end in stops.chain([path.end()]) {
        let law = s_curve(arm, &followed, start, end, share)?;
        let motion = fit(arm, &followed, &law, tolerance)?;
        let factor = retime::least_factor(&motion, &limits, share);
        let (motion, law) = (retime::stretched(&motion, factor)?, retime::stretched(&law, factor)?);
        whole = Some(match whole {
            None => (motion, law),
            Some((before, law_before)) => (before.then(&motion)?, law_before.then(&law)?),
        });
        start = end;
    }
    let (mut motion, mut law) = whole.expect("a path has at least one segment");
    if let Some(duration) = duration {
        motion = retime::lasting(&motion, duration)?;
        law = retime::lasting(&law, duration)?;
    }
    proved(&followed.planar, motion, law, tolerance)
}

/// The motion with its proof.
fn proved(
    path: &PlanarPath,
    motion: Trajectory,
    law: Trajectory,
    tolerance: Deviation,
) -> Result<PathMotion, AlongError> {
    match prove_deviation(path, &law, &motion, tolerance)? {
        DeviationOutcome::Within(deviations) => Ok(PathMotion { motion, law, deviations }),
        DeviationOutcome::Exceeds { .. } | DeviationOutcome::Unknown(_) => {
            Err(AlongError::NotProved { tolerance: tolerance.position.min(tolerance.angle) })
        }
    }
}

/// The S-curve of s from a place to another, from rest to rest, with knots where the path changes its formula. Its
/// limits come from the slopes of the joints: this gives the law its shape, the exact factor its duration.
fn s_curve(
    arm: &Arm,
    path: &FollowedPath,
    start: f64,
    end: f64,
    share: f64,
) -> Result<Trajectory, AlongError> {
    // The least of several numbers would pass over one that is not a number.
    for limits in arm.robot.joints.iter().map(|joint| &joint.limits) {
        for (name, limit) in
            [("velocity", limits.velocity), ("acceleration", limits.acceleration), ("jerk", limits.jerk)]
        {
            positive(name, limit)?;
        }
    }
    let mut least = [f64::INFINITY; 3];
    for k in 0..=SHAPE_PLACES {
        let s = start + (end - start) * f64::from(k) / f64::from(SHAPE_PLACES);
        let joints = path.joints(path.planar.segment_at(s), Jet::<f64, 3>::variable(s));
        for (joint, q) in arm.robot.joints.iter().zip(&joints) {
            let [_, slope, bend] = q.derivatives();
            let limits = &joint.limits;
            // What a speed along the path costs in acceleration where the path bends counts too.
            least[0] = least[0]
                .min(share * limits.velocity / slope.abs())
                .min((share * limits.acceleration / bend.abs()).sqrt());
            least[1] = least[1].min(share * limits.acceleration / slope.abs());
            least[2] = least[2].min(share * limits.jerk / slope.abs());
        }
    }
    let scaling = TimeScaling::s_curve(end - start, least[0], least[1], least[2])?;
    let mut knots = Vec::new();
    let mut pieces = Vec::new();
    let law: Vec<(f64, Polynomial)> = scaling.pieces().collect();
    let ends = law.iter().skip(1).map(|(start, _)| *start).chain([scaling.duration()]);
    let places: Vec<f64> = (1..path.planar.segment_count()).map(|k| path.planar.segment(k)[0]).collect();
    for ((from, s), to) in law.iter().zip(ends) {
        let s = s.plus(start);
        knots.push(*from);
        pieces.push(s);
        let edge = SHORTEST_SHARE * (to - from);
        for &place in &places {
            // s never falls, so that a place is reached in one phase alone.
            let (mut before, mut after) = (0.0, to - from);
            if !(s.eval(before)[0] < place && place < s.eval(after)[0]) {
                continue;
            }
            for _ in 0..BISECTIONS {
                let middle = 0.5 * (before + after);
                if s.eval(middle)[0] < place {
                    before = middle;
                } else {
                    after = middle;
                }
            }
            if edge < after && after < to - from - edge {
                knots.push(from + after);
                pieces.push(s.shifted(after));
            }
        }
    }
    knots.push(scaling.duration());
    Ok(Trajectory::new(1, knots, pieces)?)
}
