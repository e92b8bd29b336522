//! Joint polynomials for a motion of the tool: quintic pieces in time through exact positions, velocities
//! and accelerations.
//!
//! A motion that is given for the tool has no polynomial form in the joints. It is interpolated in time:
//! at every knot the inverse kinematics gives the positions, the Jacobian and its rate the velocities and
//! accelerations (one-sided where the law of the motion has a corner), and a quintic joins two knots.
//! Pieces are bisected until they are near enough to the motion, which is **measured at seven interior
//! places of each piece**, not proved between them.

use graspcheck_model::{Pose, inverse::Unreachable};
use graspcheck_motion::{Polynomial, Trajectory, TrajectoryError};
use nalgebra::Vector6;

use crate::{
    arm::Arm,
    branch::{Branch, BranchFault, Located, SINE_MIN},
    differential::joint_rates,
};

/// How far joint polynomials may differ from the motion in velocity, as a share of the joint's peak.
pub const VELOCITY_TOLERANCE: f64 = 1e-3;

/// The same for acceleration.
pub const ACCELERATION_TOLERANCE: f64 = 1e-3;

/// The same for jerk, which is compared as the mean over an eighth of a piece.
pub const JERK_TOLERANCE: f64 = 1e-2;

/// Peaks below this share of the largest of all joints (each relative to its limit) are raised to it before
/// they are compared with.
///
/// The reason: a joint that hardly moves need not move exactly, and one that stands still moves by rounding.
const PEAK_FLOOR: f64 = 1e-3;

/// Parts into which a piece is divided by the places where it is compared.
const PARTS: usize = 8;

/// Bisections after which pieces are so short (1/4096 of a phase of the law) that more would not help.
const DEPTH_MAX: usize = 12;

/// How near joint polynomials must come to a motion of the tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Distance of the tool's origin, m.
    pub position: f64,
    /// Angle of the tool, rad.
    pub angle: f64,
}

/// What the tool is to do at one instant, in the world frame.
pub(crate) struct ToolState {
    pub(crate) world_from_tool: Pose,
    /// Linear then angular velocity, m/s and rad/s.
    pub(crate) twist: Vector6<f64>,
    /// Linear then angular acceleration, m/s² and rad/s².
    pub(crate) twist_rate: Vector6<f64>,
}

/// A timed motion of the tool that is smooth between knots.
pub(crate) trait ToolMotion {
    /// Where the law changes, from 0 to the end, s.
    fn knots(&self) -> &[f64];
    /// The place on the path at time `t` of the interval `piece`; what a [`Branch`] is indexed by.
    fn place(&self, piece: usize, t: f64) -> f64;
    /// The tool at time `t` under the law of the interval `piece`.
    fn state(&self, piece: usize, t: f64) -> ToolState;
}

/// Position, velocity and acceleration of each joint.
type JointStates = Vec<[f64; 3]>;

/// A stretch of time with the exact states at its ends and at equal distances between them.
struct Piece {
    /// Index of the law's interval.
    law: usize,
    start: f64,
    end: f64,
    states: Vec<JointStates>,
    depth: usize,
}

impl Piece {
    fn duration(&self) -> f64 {
        self.end - self.start
    }

    fn time(&self, part: usize) -> f64 {
        self.start + self.duration() * part as f64 / PARTS as f64
    }

    /// The quintic of a joint through the states at both ends.
    fn quintic(&self, joint: usize) -> Polynomial {
        Polynomial::quintic_hermite(self.states[0][joint], self.states[PARTS][joint], self.duration())
    }
}

/// The joint trajectory that gives the tool `motion` on the branch that was followed.
///
/// # Errors
/// When the arm is singular somewhere, or the tolerance is not met by pieces of any length.
pub(crate) fn interpolate(
    arm: &Arm,
    motion: &dyn ToolMotion,
    branch: &Branch,
    tolerance: Tolerance,
) -> Result<Trajectory, InterpolationError> {
    let fit = Fit { arm, motion, branch, tolerance };
    let law_knots = motion.knots();
    let mut todo = Vec::new();
    for (law, ends) in law_knots.windows(2).enumerate() {
        todo.push(fit.piece(law, ends[0], ends[1], 0)?);
    }
    let peaks = fit.peaks(&todo);
    // The earliest piece is taken from the end of the list.
    todo.reverse();
    let mut knots = vec![law_knots[0]];
    let mut polynomials = Vec::new();
    while let Some(piece) = todo.pop() {
        let quintics: Vec<Polynomial> = (0..arm.robot.dof()).map(|joint| piece.quintic(joint)).collect();
        match fit.compare(&piece, &quintics, &peaks) {
            Comparison::Near => {
                knots.push(piece.end);
                polynomials.extend(quintics);
            }
            Comparison::Far { deviation, tolerance } if piece.depth >= DEPTH_MAX => {
                let length = piece.duration();
                let fault = BranchFault::NotConverging { length, deviation, tolerance };
                return Err(Located { at: motion.place(piece.law, piece.start), fault }.into());
            }
            Comparison::Far { .. } => {
                let middle = piece.time(PARTS / 2);
                todo.push(fit.piece(piece.law, middle, piece.end, piece.depth + 1)?);
                todo.push(fit.piece(piece.law, piece.start, middle, piece.depth + 1)?);
            }
        }
    }
    Ok(Trajectory::new(arm.robot.dof(), knots, polynomials)?)
}

/// Why a motion of the tool cannot be turned into joint polynomials.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum InterpolationError {
    /// The arm cannot follow at some place.
    #[error("{}", .0.fault)]
    Located(Located),
    /// The polynomials are not a trajectory.
    #[error(transparent)]
    Trajectory(#[from] TrajectoryError),
}

impl From<Located> for InterpolationError {
    fn from(located: Located) -> Self {
        Self::Located(located)
    }
}

/// Whether a piece is near enough to the motion.
enum Comparison {
    Near,
    /// Not: the first measure that is too large, and what it is held against.
    Far {
        deviation: f64,
        tolerance: f64,
    },
}

/// What a piece is fitted to.
struct Fit<'a> {
    arm: &'a Arm<'a>,
    motion: &'a dyn ToolMotion,
    branch: &'a Branch,
    tolerance: Tolerance,
}

impl Fit<'_> {
    fn piece(&self, law: usize, start: f64, end: f64, depth: usize) -> Result<Piece, Located> {
        let mut piece = Piece { law, start, end, states: Vec::with_capacity(PARTS + 1), depth };
        for part in 0..=PARTS {
            // The last time is the end itself, not the end up to rounding.
            let t = if part == PARTS { end } else { piece.time(part) };
            let states = self.joint_states(law, t)?;
            piece.states.push(states);
        }
        Ok(piece)
    }

    /// Exact position, velocity and acceleration of the joints at `t`.
    fn joint_states(&self, law: usize, t: f64) -> Result<JointStates, Located> {
        let place = self.motion.place(law, t);
        let tool = self.motion.state(law, t);
        let q = self.arm.solve_near(&tool.world_from_tool, &self.branch.near(place)).map_err(
            |bound: Unreachable| Located {
                at: place,
                fault: BranchFault::OutOfReach { until: place, bound },
            },
        )?;
        let jacobian = self.arm.robot.tool_jacobian(&q);
        let (qd, qdd) = joint_rates(&jacobian, &tool.twist, &tool.twist_rate).ok_or_else(|| {
            let sine = self.arm.sine_of_elbow(&q);
            Located { at: place, fault: BranchFault::NearSingular { sine, least: SINE_MIN } }
        })?;
        Ok((0..q.len()).map(|joint| [q[joint], qd[joint], qdd[joint]]).collect())
    }

    /// Peaks of velocity, acceleration and jerk of each joint, from the states of all pieces.
    fn peaks(&self, pieces: &[Piece]) -> Vec<[f64; 3]> {
        let mut peaks = vec![[0.0_f64; 3]; self.arm.robot.dof()];
        for piece in pieces {
            let part = piece.duration() / PARTS as f64;
            for (k, states) in piece.states.iter().enumerate() {
                for (joint, peak) in peaks.iter_mut().enumerate() {
                    peak[0] = peak[0].max(states[joint][1].abs());
                    peak[1] = peak[1].max(states[joint][2].abs());
                    if k > 0 {
                        let jerk = (states[joint][2] - piece.states[k - 1][joint][2]) / part;
                        peak[2] = peak[2].max(jerk.abs());
                    }
                }
            }
        }
        for order in 0..3 {
            let limit = |joint: usize| {
                let limits = &self.arm.robot.joints[joint].limits;
                [limits.velocity, limits.acceleration, limits.jerk][order]
            };
            let largest = (0..peaks.len()).map(|j| peaks[j][order] / limit(j)).fold(0.0, f64::max);
            for (joint, peak) in peaks.iter_mut().enumerate() {
                peak[order] = peak[order].max(PEAK_FLOOR * largest * limit(joint));
            }
        }
        peaks
    }

    /// Compares a piece with the motion at its interior places.
    fn compare(&self, piece: &Piece, quintics: &[Polynomial], peaks: &[[f64; 3]]) -> Comparison {
        let part = piece.duration() / PARTS as f64;
        let mut q = vec![0.0; quintics.len()];
        let mut error_before = vec![0.0; quintics.len()];
        let mut first_far = Comparison::Near;
        let mut hold = |deviation: f64, tolerance: f64| {
            // NaN is not near either.
            let near = deviation <= tolerance;
            if !near && matches!(first_far, Comparison::Near) {
                first_far = Comparison::Far { deviation, tolerance };
            }
        };
        for k in 1..=PARTS {
            let tau = part * k as f64;
            for (joint, quintic) in quintics.iter().enumerate() {
                let [position, velocity, acceleration, _] = quintic.eval(tau);
                let [_, exact_velocity, exact_acceleration] = piece.states[k][joint];
                q[joint] = position;
                let error = acceleration - exact_acceleration;
                let [velocity_peak, acceleration_peak, jerk_peak] = peaks[joint];
                hold((velocity - exact_velocity).abs(), VELOCITY_TOLERANCE * velocity_peak);
                hold(error.abs(), ACCELERATION_TOLERANCE * acceleration_peak);
                hold((error - error_before[joint]).abs() / part, JERK_TOLERANCE * jerk_peak);
                error_before[joint] = error;
            }
            if k < PARTS {
                let wanted = self.motion.state(piece.law, piece.time(k)).world_from_tool;
                let got = self.arm.robot.world_from_tool(&q);
                hold((got.translation.vector - wanted.translation.vector).norm(), self.tolerance.position);
                hold(got.rotation.angle_to(&wanted.rotation), self.tolerance.angle);
            }
        }
        first_far
    }
}
