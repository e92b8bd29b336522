//! Straight lines of the tool.
//!
//! The path goes from pose to pose, the position on a straight line and the orientation by the shortest
//! rotation, about an axis that stays the same:
//!
//! ```text
//! p(s) = p₀ + s (p₁ − p₀),   R(s) = exp(s·φ) R₀,   φ = log(R₁ R₀⁻¹),   s from 0 to 1
//! ```
//!
//! (worked examples, section 1, with the axis of rotation in the world frame). It is run through under an
//! S-curve s(t) whose shape comes from what the path asks of the joints per unit of s. The joint motion is
//! then stretched in time by the exact factor at which its tightest joint limit is just met.
//!
//! Where the joints move along a straight line of their own (the quill of a SCARA alone, or its wrist
//! alone) the motion is an exact joint move.
//!
//! Also called LIN.

use graspcheck_model::{
    Pose,
    inverse::LIMIT_TOLERANCE,
    robot::{JointLimits, RobotModel},
};
use graspcheck_motion::{Polynomial, Trajectory, TrajectoryError};
use nalgebra::{UnitQuaternion, Vector3, Vector6};

use crate::{
    arm::Arm,
    branch::{Branch, BranchFault, Located, SINE_MIN, ToolPath},
    differential::joint_rates,
    interpolation::{InterpolationError, Tolerance, ToolMotion, ToolState, interpolate},
    joint_move::{JointMoveError, joint_move},
    retime,
    time_scaling::{ScalingError, TimeScaling},
};

/// How near the joint polynomials of a line come to it.
///
/// The reason: a tenth of the repeatability of the arms that graspcheck is for, and a few hundredths of the
/// clearances that are asked for.
pub const LINE_TOLERANCE: Tolerance = Tolerance { position: 1e-5, angle: 1e-5 };

/// How far the tool may leave the line when the joints move on a straight line of their own, m or rad, and
/// the two still are the same: a thousand times the rounding of a chain of transforms of an arm of 8 m.
const SAME_LINE_TOLERANCE: f64 = 1e-12;

/// Why a straight line of the tool cannot be planned.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LineError {
    /// A branch of the inverse kinematics cannot be followed along the line.
    #[error("line at s = {at:.6}: {fault}")]
    Branch {
        /// Path parameter from 0 to 1.
        at: f64,
        /// What is wrong there.
        fault: BranchFault,
    },
    /// The arm has no inverse kinematics.
    #[error("line: {0}")]
    NoInverse(#[from] graspcheck_model::inverse::Unreachable),
    /// There is no law of time under the limits.
    #[error("line: {0}")]
    Scaling(#[from] ScalingError),
    /// The line is a joint move that cannot be planned.
    #[error("line: {0}")]
    JointMove(#[from] JointMoveError),
    /// The polynomials are not a trajectory.
    #[error("line: {0}")]
    Trajectory(#[from] TrajectoryError),
}

impl From<Located> for LineError {
    fn from(Located { at, fault }: Located) -> Self {
        Self::Branch { at, fault }
    }
}

impl From<InterpolationError> for LineError {
    fn from(error: InterpolationError) -> Self {
        match error {
            InterpolationError::Located(located) => located.into(),
            InterpolationError::Trajectory(error) => error.into(),
        }
    }
}

/// A straight path of the tool from pose to pose.
#[derive(Clone, Debug, PartialEq)]
pub struct StraightLine {
    world_from_start: Pose,
    displacement: Vector3<f64>,
    rotation: Vector3<f64>,
}

impl StraightLine {
    /// The line between two poses of the tool.
    #[must_use]
    pub fn new(world_from_start: &Pose, world_from_end: &Pose) -> Self {
        Self {
            world_from_start: *world_from_start,
            displacement: world_from_end.translation.vector - world_from_start.translation.vector,
            rotation: (world_from_end.rotation * world_from_start.rotation.inverse()).scaled_axis(),
        }
    }

    /// From the tool to the world at the path parameter `s`, 0 to 1.
    #[must_use]
    pub fn pose(&self, s: f64) -> Pose {
        let rotation = UnitQuaternion::from_scaled_axis(self.rotation * s) * self.world_from_start.rotation;
        Pose::from_parts((self.world_from_start.translation.vector + self.displacement * s).into(), rotation)
    }

    /// Derivative of the pose by s: linear (m) and angular (rad) in the world frame, the same everywhere.
    fn tangent(&self) -> Vector6<f64> {
        let mut tangent = Vector6::zeros();
        tangent.fixed_rows_mut::<3>(0).copy_from(&self.displacement);
        tangent.fixed_rows_mut::<3>(3).copy_from(&self.rotation);
        tangent
    }
}

/// A straight line under a law of time.
struct TimedLine<'a> {
    line: &'a StraightLine,
    knots: Vec<f64>,
    /// s(t) on each interval between knots, in local time.
    law: Vec<Polynomial>,
}

impl<'a> TimedLine<'a> {
    fn new(line: &'a StraightLine, scaling: &TimeScaling) -> Self {
        let (mut knots, law): (Vec<f64>, Vec<Polynomial>) = scaling.pieces().into_iter().unzip();
        knots.push(scaling.duration());
        Self { line, knots, law }
    }

    fn law_at(&self, piece: usize, t: f64) -> [f64; 4] {
        self.law[piece].eval(t - self.knots[piece])
    }
}

impl ToolMotion for TimedLine<'_> {
    fn knots(&self) -> &[f64] {
        &self.knots
    }

    fn place(&self, piece: usize, t: f64) -> f64 {
        self.law_at(piece, t)[0]
    }

    fn state(&self, piece: usize, t: f64) -> ToolState {
        let [s, sd, sdd, _] = self.law_at(piece, t);
        let tangent = self.line.tangent();
        ToolState { world_from_tool: self.line.pose(s), twist: tangent * sd, twist_rate: tangent * sdd }
    }
}

/// The joint motion, from rest at `from` to rest, in which the tool goes on a straight line from where it
/// is to `world_from_goal`.
///
/// `share` of the joints' limits of velocity, acceleration and jerk is used (0 < share ≤ 1), and the tightest
/// of them is met from below to 1e-9. With a `duration` (s) the same motion is stretched or compressed to
/// last exactly that, even past the limits.
///
/// The polynomials differ from the line by no more than [`LINE_TOLERANCE`] at the places at which they are
/// compared, seven between any two knots.
///
/// # Errors
/// Where and why the branch of `from` cannot be followed; or the arm has no closed-form inverse
/// kinematics; or the limits, the share or the duration are not positive.
///
/// # Panics
/// When `from` has another length than the arm has joints.
pub fn line(
    robot: &RobotModel,
    from: &[f64],
    world_from_goal: &Pose,
    share: f64,
    duration: Option<f64>,
) -> Result<Trajectory, LineError> {
    line_of(&Arm::new(robot)?, from, world_from_goal, share, duration)
}

/// As [`line`], for an arm that is measured already.
pub(crate) fn line_of(
    arm: &Arm,
    from: &[f64],
    world_from_goal: &Pose,
    share: f64,
    duration: Option<f64>,
) -> Result<Trajectory, LineError> {
    let limits: Vec<JointLimits> = arm.robot.joints.iter().map(|joint| joint.limits).collect();
    let line = StraightLine::new(&arm.robot.world_from_tool(from), world_from_goal);
    if let Some(to) = straight_in_joints(arm, &line, from) {
        check_joint_line(arm, from, &to)?;
        return Ok(joint_move(from, &to, &limits, share, duration)?);
    }
    let pose = |s: f64| line.pose(s);
    let branch = ToolPath::new(arm, 0.0, 1.0, &pose).follow(from)?;
    let [velocity, acceleration, jerk] = path_limits(arm, &line, &branch, share)?;
    let scaling = TimeScaling::s_curve(1.0, velocity, acceleration, jerk)?;
    let motion = interpolate(arm, &TimedLine::new(&line, &scaling), &branch, LINE_TOLERANCE)?;
    Ok(match duration {
        Some(duration) => retime::lasting(&motion, duration)?,
        None => retime::stretched(&motion, retime::least_factor(&motion, &limits, share))?,
    })
}

/// Joint positions at the beginning of the straight line that begins with the tool at `world_from_start`
/// and ends in `to`, on the same branch.
///
/// # Errors
/// Where and why the branch cannot be followed, as seen from the beginning.
pub(crate) fn start_of_line(arm: &Arm, world_from_start: &Pose, to: &[f64]) -> Result<Vec<f64>, LineError> {
    let backwards = StraightLine::new(&arm.robot.world_from_tool(to), world_from_start);
    if let Some(from) = straight_in_joints(arm, &backwards, to) {
        check_joint_line(arm, &from, to)?;
        return Ok(from);
    }
    let pose = |s: f64| backwards.pose(s);
    let branch = ToolPath::new(arm, 0.0, 1.0, &pose).follow(to).map_err(Located::seen_from_other_end)?;
    Ok(branch.end().to_vec())
}

/// The joint positions at the end of the line, if the joints reach them on a straight line of their own.
/// Joints that do not move keep their positions to the last digit.
fn straight_in_joints(arm: &Arm, line: &StraightLine, from: &[f64]) -> Option<Vec<f64>> {
    const INTERIOR: u32 = 5;
    let mut to = arm.solve_near(&line.pose(1.0), from).ok()?;
    for (end, start) in to.iter_mut().zip(from) {
        if (*end - start).abs() <= SAME_LINE_TOLERANCE {
            *end = *start;
        }
    }
    let mut q = vec![0.0; from.len()];
    for k in 1..=INTERIOR + 1 {
        let s = f64::from(k) / f64::from(INTERIOR + 1);
        for (joint, value) in q.iter_mut().enumerate() {
            *value = from[joint] + s * (to[joint] - from[joint]);
        }
        let (got, wanted) = (arm.robot.world_from_tool(&q), line.pose(s));
        let distance = (got.translation.vector - wanted.translation.vector).norm();
        if distance.max(got.rotation.angle_to(&wanted.rotation)) > SAME_LINE_TOLERANCE {
            return None;
        }
    }
    Some(to)
}

/// Checks the limits along a straight line in joint space, whose ends are its extremes.
fn check_joint_line(arm: &Arm, from: &[f64], to: &[f64]) -> Result<(), LineError> {
    for (joint, (&start, &end)) in from.iter().zip(to).enumerate() {
        let value = if arm.excess(joint, start) > arm.excess(joint, end) { start } else { end };
        if arm.excess(joint, value) > LIMIT_TOLERANCE {
            let limits = &arm.robot.joints[joint].limits;
            let limit = if value > limits.position_max { limits.position_max } else { limits.position_min };
            let at = if arm.excess(joint, start) > 0.0 { 0.0 } else { (limit - start) / (end - start) };
            return Err(LineError::Branch { at, fault: arm.limit_fault(joint, value) });
        }
    }
    Ok(())
}

/// Limits of ds/dt, d²s/dt² and d³s/dt³ from what the path asks of the joints per unit of s. The curvature
/// of the path is left out: this gives the law its shape, the exact factor its duration.
fn path_limits(arm: &Arm, line: &StraightLine, branch: &Branch, share: f64) -> Result<[f64; 3], LineError> {
    let tangent = line.tangent();
    let mut steepest = vec![0.0_f64; arm.robot.dof()];
    for (at, q) in branch.samples() {
        let jacobian = arm.robot.tool_jacobian(q);
        let (q_s, _) = joint_rates(&jacobian, &tangent, &Vector6::zeros()).ok_or_else(|| {
            let fault = BranchFault::NearSingular { sine: arm.sine_of_elbow(q), least: SINE_MIN };
            LineError::Branch { at, fault }
        })?;
        for (most, slope) in steepest.iter_mut().zip(q_s.iter()) {
            *most = most.max(slope.abs());
        }
    }
    let least = |limit: fn(&JointLimits) -> f64| {
        let joints = arm.robot.joints.iter().zip(&steepest);
        joints.map(|(joint, slope)| share * limit(&joint.limits) / slope).fold(f64::INFINITY, f64::min)
    };
    Ok([least(|l| l.velocity), least(|l| l.acceleration), least(|l| l.jerk)])
}
