//! Joint polynomials for a path of the tool under a law of time: quintic pieces through exact positions,
//! velocities and accelerations.
//!
//! A path of the tool has no polynomial form in the joints. It is interpolated in time: at every knot the
//! inverse kinematics gives the positions, and its derivatives with those of the law the velocities,
//! accelerations and jerks (one-sided where the law has a corner); a quintic joins two knots. Pieces are
//! halved until the deviation of the tool from the path is **proved** to be within the tolerance
//! ([`graspcheck_proof::deviation`]), and until velocity, acceleration and jerk, compared with the exact ones at
//! nine places of each piece, are near. That is a rule for choosing knots and proves nothing: limits are held against
//! the quintics themselves (docs/decisions/0016).

use graspcheck_model::planar_path::PLANAR_JOINTS;
use graspcheck_motion::{Jet, Polynomial, Trajectory, TrajectoryError};
use graspcheck_proof::deviation::{Deviation, piece_deviation};

use super::FollowedPath;
use crate::{
    arm::Arm,
    branch::{BranchFault, Located},
};

/// How far joint polynomials may differ from the motion in velocity, acceleration and jerk, as a share of the
/// joint's peak.
const DERIVATIVE_TOLERANCES: [f64; 3] = [1e-3, 1e-3, 1e-2];

/// Peaks below this share of the largest of all joints (each relative to its limit) are raised to it before
/// they are compared with.
///
/// The reason: a joint that hardly moves need not move exactly, and one that stands still moves by rounding.
const PEAK_FLOOR: f64 = 1e-3;

/// Share of the tolerance of the deviation that pieces are held to.
///
/// The reason: the finished motion is stretched in time, which rounds its coefficients, and proved anew.
const TOLERANCE_SHARE: f64 = 0.999;

/// Parts into which a piece is divided by the places where it is compared.
const PARTS: usize = 8;

/// Halvings after which pieces are so short (1/4096 of a phase of the law) that more would not help.
const DEPTH_MAX: usize = 12;

/// Position, velocity, acceleration and jerk of each joint.
type States = [[f64; 4]; PLANAR_JOINTS];

/// A stretch of time with the exact states at its ends and at equal distances between them.
struct Piece {
    /// Index of the law's interval.
    law: usize,
    /// Index of the path's segment.
    segment: usize,
    start: f64,
    end: f64,
    states: [States; PARTS + 1],
    /// Positions at s = 0 and slopes by s, where the joints move in proportion to s: then the law's own polynomials
    /// serve, exactly.
    affine: Option<[[f64; 2]; PLANAR_JOINTS]>,
    depth: usize,
}

impl Piece {
    fn duration(&self) -> f64 {
        self.end - self.start
    }

    fn time(&self, part: usize) -> f64 {
        // The last time is the end itself, not the end up to rounding.
        if part == PARTS { self.end } else { self.start + self.duration() * part as f64 / PARTS as f64 }
    }

    /// The polynomials of all joints: quintics through the states at both ends.
    fn polynomials(&self, law: &Polynomial, law_start: f64) -> [Polynomial; PLANAR_JOINTS] {
        if let Some(affine) = self.affine {
            let s = law.shifted(self.start - law_start);
            return affine
                .map(|[at_zero, slope]| Polynomial::new(s.coefficients().map(|c| slope * c)).plus(at_zero));
        }
        let [start, end] = [&self.states[0], &self.states[PARTS]];
        std::array::from_fn(|joint| {
            let [from, to] = [start[joint], end[joint]];
            Polynomial::quintic_hermite([from[0], from[1], from[2]], [to[0], to[1], to[2]], self.duration())
        })
    }
}

/// What pieces are fitted to.
struct Fit<'a> {
    arm: &'a Arm<'a>,
    path: &'a FollowedPath,
    law: &'a Trajectory,
    tolerance: Deviation,
}

/// Why a path under a law cannot be turned into joint polynomials.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum FitError {
    /// Pieces do not come near enough at some place.
    #[error("{}", .0.fault)]
    Located(Located),
    /// The polynomials are not a trajectory.
    #[error(transparent)]
    Trajectory(#[from] TrajectoryError),
}

/// The joint trajectory along `path` with the path parameter of `law` (a motion of one "joint" whose knots include
/// the instants at which the path changes its formula).
///
/// # Errors
/// When the tolerance is not met by pieces of any length.
pub(crate) fn fit(
    arm: &Arm,
    path: &FollowedPath,
    law: &Trajectory,
    tolerance: Deviation,
) -> Result<Trajectory, FitError> {
    let tolerance = Deviation {
        position: TOLERANCE_SHARE * tolerance.position,
        angle: TOLERANCE_SHARE * tolerance.angle,
    };
    let fit = Fit { arm, path, law, tolerance };
    let knots = law.knots();
    let mut todo: Vec<Piece> = (0..law.piece_count()).map(|k| fit.piece(k, knots[k], knots[k + 1])).collect();
    let peaks = fit.peaks(&todo);
    // The earliest piece is taken from the end of the list.
    todo.reverse();
    let dof = arm.robot.dof();
    let mut knots = Vec::with_capacity(2 * todo.len() + 1);
    knots.push(0.0);
    let mut polynomials = Vec::with_capacity(2 * dof * todo.len());
    while let Some(piece) = todo.pop() {
        let found = piece.polynomials(law.piece(piece.law, 0), law.knots()[piece.law]);
        match fit.compare(&piece, &found, &peaks) {
            None => {
                knots.push(piece.end);
                polynomials.extend_from_slice(&found[..dof]);
            }
            Some((deviation, tolerance)) if piece.depth >= DEPTH_MAX => {
                let length = piece.duration();
                let fault = BranchFault::NotConverging { length, deviation, tolerance };
                let at = fit.place(piece.law, piece.start).value();
                return Err(FitError::Located(Located { at, fault }));
            }
            Some(_) => {
                let [first, second] = fit.halves(&piece);
                todo.push(second);
                todo.push(first);
            }
        }
    }
    Ok(Trajectory::new(dof, knots, polynomials)?)
}

impl Fit<'_> {
    /// The path parameter at a time of one interval of the law, with three derivatives in time.
    fn place(&self, law: usize, t: f64) -> Jet<f64, 4> {
        Jet::of_polynomial(self.law.piece(law, 0), t - self.law.knots()[law])
    }

    /// Exact states of the joints at `t`.
    fn states(&self, law: usize, segment: usize, t: f64) -> States {
        self.path.joints(segment, self.place(law, t)).map(|q| q.derivatives())
    }

    /// Positions at s = 0 and slopes, where the joints move in proportion to s all along a segment: a path is a
    /// polynomial of degree 7 at most, so that six derivatives that vanish say so.
    fn affine(&self, segment: usize) -> Option<[[f64; 2]; PLANAR_JOINTS]> {
        let [start, end] = self.path.planar.segment(segment);
        let middle = 0.5 * (start + end);
        let joints = self.path.joints(segment, Jet::<f64, 8>::variable(middle));
        let straight = joints.iter().all(|q| q.coefficients[2..].iter().all(|&c| c == 0.0));
        straight.then(|| joints.map(|q| [q.coefficients[0] - q.coefficients[1] * middle, q.coefficients[1]]))
    }

    /// A whole interval of the law.
    fn piece(&self, law: usize, start: f64, end: f64) -> Piece {
        let segment = self.path.planar.segment_at(self.place(law, 0.5 * (start + end)).value());
        let affine = self.affine(segment);
        let states = [States::default(); PARTS + 1];
        let mut piece = Piece { law, segment, start, end, states, affine, depth: 0 };
        for part in 0..=PARTS {
            piece.states[part] = self.states(law, segment, piece.time(part));
        }
        piece
    }

    /// Both halves of a piece, with what it knows already.
    fn halves(&self, piece: &Piece) -> [Piece; 2] {
        let middle = piece.time(PARTS / 2);
        [0, 1].map(|half| {
            let (start, end) = if half == 0 { (piece.start, middle) } else { (middle, piece.end) };
            let mut new = Piece {
                start,
                end,
                states: [States::default(); PARTS + 1],
                depth: piece.depth + 1,
                ..*piece
            };
            for part in 0..=PARTS {
                new.states[part] = if part % 2 == 0 {
                    piece.states[half * PARTS / 2 + part / 2]
                } else {
                    self.states(piece.law, piece.segment, new.time(part))
                };
            }
            new
        })
    }

    /// Peaks of velocity, acceleration and jerk of each joint, from the states of all pieces.
    fn peaks(&self, pieces: &[Piece]) -> [[f64; 3]; PLANAR_JOINTS] {
        let mut peaks = [[0.0_f64; 3]; PLANAR_JOINTS];
        for states in pieces.iter().flat_map(|piece| &piece.states) {
            for (peak, state) in peaks.iter_mut().zip(states) {
                for (peak, value) in peak.iter_mut().zip(&state[1..]) {
                    *peak = peak.max(value.abs());
                }
            }
        }
        for order in 0..3 {
            let limit = |joint: usize| {
                let limits = &self.arm.robot.joints[joint].limits;
                [limits.velocity, limits.acceleration, limits.jerk][order]
            };
            let joints = 0..self.arm.robot.dof();
            let largest = joints.clone().map(|j| peaks[j][order] / limit(j)).fold(0.0, f64::max);
            for joint in joints {
                peaks[joint][order] = peaks[joint][order].max(PEAK_FLOOR * largest * limit(joint));
            }
        }
        peaks
    }

    /// What of a piece is too far from the motion, and what it is held against; none when it is near. NaN is far.
    fn compare(
        &self,
        piece: &Piece,
        polynomials: &[Polynomial; PLANAR_JOINTS],
        peaks: &[[f64; 3]; PLANAR_JOINTS],
    ) -> Option<(f64, f64)> {
        let dof = self.arm.robot.dof();
        for part in 0..=PARTS {
            let tau = piece.time(part) - piece.start;
            for (joint, polynomial) in polynomials.iter().enumerate().take(dof) {
                let found = polynomial.eval(tau);
                for order in 0..3 {
                    let error = (found[order + 1] - piece.states[part][joint][order + 1]).abs();
                    let allowed = DERIVATIVE_TOLERANCES[order] * peaks[joint][order];
                    let is_near = error <= allowed;
                    if !is_near {
                        return Some((error, allowed));
                    }
                }
            }
        }
        let before = piece.start - self.law.knots()[piece.law];
        let law = self.law.piece(piece.law, 0);
        let (joints, duration) = (&polynomials[..dof], piece.duration());
        let planar = &self.path.planar;
        let bound = piece_deviation(planar, piece.segment, law, before, joints, duration, self.tolerance);
        if bound.is_within(self.tolerance) {
            None
        } else if bound.position <= self.tolerance.position {
            Some((bound.angle, self.tolerance.angle))
        } else {
            Some((bound.position, self.tolerance.position))
        }
    }
}
