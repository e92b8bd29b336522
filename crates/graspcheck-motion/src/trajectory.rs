//! The commanded motion of all joints: piecewise polynomials over common knots.
//!
//! ```
//! use graspcheck_motion::{Polynomial, Trajectory, TrajectoryError};
//!
//! // One joint swings by 1 rad in 2 s and then stays; the other stays throughout.
//! let swing = Polynomial::quintic_hermite([0.0; 3], [1.0, 0.0, 0.0], 2.0);
//! let still = Polynomial::constant(0.5);
//! let motion = Trajectory::new(2, vec![0.0, 2.0], vec![swing, still])?.then(&Trajectory::hold(&[1.0, 0.5], 1.0)?)?;
//! assert_eq!(motion.knots(), [0.0, 2.0, 3.0]);
//! assert!(motion.breaks().is_empty());
//! let state = motion.eval(1.0);
//! assert!((state.q[0] - 0.5).abs() < 1e-15 && (state.qd[0] - 15.0 / 16.0).abs() < 1e-15);
//!
//! // What cannot be a motion is no Trajectory: the error says where.
//! let error = Trajectory::new(1, vec![0.0, 2.0, 2.0], vec![swing, swing]).expect_err("no time passes");
//! assert_eq!(error.to_string(), "knot 2: time 2 s must be finite and later than the knot before it, at 2 s");
//! # Ok::<(), TrajectoryError>(())
//! ```

use serde::{Deserialize, Serialize};

use crate::continuity::find_breaks;
use crate::polynomial::Polynomial;

/// How far position, velocity or acceleration may differ on the two sides of a knot that counts as smooth,
/// relative to the largest magnitude that the quantity of this joint has at a knot (and at least 1 in SI
/// units). On top comes what the rounding of knots and of evaluation accounts for, which matters late in a
/// motion and on pieces of microseconds.
///
/// The reason: pieces are built by formulas of about ten operations, each with a rounding error of 1.1e-16 of
/// its terms. A thousand times their sum is more than rounding, and less than any drive can show.
pub const SMOOTH_TOLERANCE: f64 = 1e-9;

/// A knot at which position, velocity or acceleration jumps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Break {
    /// Index into [`Trajectory::knots`]; never the first or the last.
    pub knot: usize,
    /// The first derivative that jumps: 0 position, 1 velocity, 2 acceleration.
    pub order: usize,
    /// The jump of that derivative of each joint, right minus left, SI units.
    pub jump: Vec<f64>,
}

/// Why a [`Trajectory`] cannot be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TrajectoryError {
    /// There is no joint.
    #[error("a trajectory needs at least one joint")]
    NoJoint,
    /// Fewer than two knots.
    #[error("a trajectory needs at least two knots, got {count}")]
    TooFewKnots {
        /// How many were given.
        count: usize,
    },
    /// The first knot is not at time zero.
    #[error("knot 0: time {time} s must be 0 s")]
    StartNotZero {
        /// Its time, s.
        time: f64,
    },
    /// A knot does not come after the one before it, or is not finite.
    #[error("knot {index}: time {time} s must be finite and later than the knot before it, at {previous} s")]
    KnotsNotIncreasing {
        /// Its index.
        index: usize,
        /// Its time, s.
        time: f64,
        /// The time of the knot before it, s.
        previous: f64,
    },
    /// The number of polynomials does not fit.
    #[error("{knots} knots and {dof} joints need {expected} polynomials, got {count}")]
    WrongPieceCount {
        /// How many knots there are.
        knots: usize,
        /// How many joints there are.
        dof: usize,
        /// `(knots - 1) * dof`.
        expected: usize,
        /// How many were given.
        count: usize,
    },
    /// In a file, an interval does not have one polynomial for each joint.
    #[error("piece {piece}: {count} polynomials must be {dof}, one for each joint")]
    WrongJointCount {
        /// Index of the interval.
        piece: usize,
        /// How many joints there are.
        dof: usize,
        /// How many polynomials the interval has.
        count: usize,
    },
    /// A coefficient is NaN or infinite.
    #[error("piece {piece}, joint {joint}: a coefficient is not finite: {coefficients:?}")]
    NotFinite {
        /// Index of the interval.
        piece: usize,
        /// Index of the joint.
        joint: usize,
        /// All its coefficients, ascending.
        coefficients: Vec<f64>,
    },
    /// Two trajectories to be joined have different numbers of joints.
    #[error("a trajectory of {first} joints cannot be followed by one of {second} joints")]
    DofMismatch {
        /// Joints of the first.
        first: usize,
        /// Joints of the second.
        second: usize,
    },
}

/// Position, velocity, acceleration and jerk of all joints at one instant, SI units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MotionState {
    /// Positions, rad or m.
    pub q: Vec<f64>,
    /// Velocities, rad/s or m/s.
    pub qd: Vec<f64>,
    /// Accelerations, rad/s² or m/s².
    pub qdd: Vec<f64>,
    /// Jerks, rad/s³ or m/s³.
    pub qddd: Vec<f64>,
}

impl MotionState {
    /// A state of `dof` zeros, to be filled by [`Trajectory::eval_into`].
    #[must_use]
    pub fn zeros(dof: usize) -> Self {
        Self { q: vec![0.0; dof], qd: vec![0.0; dof], qdd: vec![0.0; dof], qddd: vec![0.0; dof] }
    }
}

/// The commanded motion q(t) of all joints on `[0, duration]`.
///
/// A knot is *smooth* when position, velocity and acceleration are continuous there to
/// [`SMOOTH_TOLERANCE`] (jerk may step by a finite amount, and both one-sided values count), or a
/// [`Break`] that says which derivative jumps and by how much. The constructor measures; nobody declares.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "TrajectoryData", into = "TrajectoryData")]
pub struct Trajectory {
    dof: usize,
    knots: Vec<f64>,
    /// Piece-major: the polynomials of all joints on interval 0, then on interval 1, …
    pieces: Vec<Polynomial>,
    breaks: Vec<Break>,
}

/// The form of a [`Trajectory`] in files. Breaks are written for readers in other languages and found
/// again when read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct TrajectoryData {
    dof: usize,
    knots: Vec<f64>,
    /// `coefficients[piece][joint]`, ascending by power, in local time.
    coefficients: Vec<Vec<Polynomial>>,
    #[serde(default)]
    breaks: Vec<Break>,
}

impl From<Trajectory> for TrajectoryData {
    fn from(trajectory: Trajectory) -> Self {
        Self {
            coefficients: trajectory.pieces.chunks(trajectory.dof).map(<[Polynomial]>::to_vec).collect(),
            dof: trajectory.dof,
            knots: trajectory.knots,
            breaks: trajectory.breaks,
        }
    }
}

impl TryFrom<TrajectoryData> for Trajectory {
    type Error = TrajectoryError;

    fn try_from(data: TrajectoryData) -> Result<Self, TrajectoryError> {
        if let Some(piece) = data.coefficients.iter().position(|joints| joints.len() != data.dof) {
            let count = data.coefficients[piece].len();
            return Err(TrajectoryError::WrongJointCount { piece, dof: data.dof, count });
        }
        Self::new(data.dof, data.knots, data.coefficients.into_iter().flatten().collect())
    }
}

impl Trajectory {
    /// The motion with these pieces: `pieces[i * dof + j]` is joint `j` between `knots[i]` and
    /// `knots[i + 1]`, in the local time `t - knots[i]`.
    ///
    /// # Errors
    /// When there is no joint, there are fewer than two knots, the knots do not begin at 0 and increase,
    /// the number of pieces does not fit, or a coefficient is not finite.
    pub fn new(dof: usize, knots: Vec<f64>, pieces: Vec<Polynomial>) -> Result<Self, TrajectoryError> {
        if dof == 0 {
            return Err(TrajectoryError::NoJoint);
        }
        if knots.len() < 2 {
            return Err(TrajectoryError::TooFewKnots { count: knots.len() });
        }
        if knots[0] != 0.0 {
            return Err(TrajectoryError::StartNotZero { time: knots[0] });
        }
        for (index, pair) in knots.windows(2).enumerate() {
            if !(pair[1].is_finite() && pair[1] > pair[0]) {
                return Err(TrajectoryError::KnotsNotIncreasing {
                    index: index + 1,
                    time: pair[1],
                    previous: pair[0],
                });
            }
        }
        let expected = (knots.len() - 1) * dof;
        if pieces.len() != expected {
            return Err(TrajectoryError::WrongPieceCount {
                knots: knots.len(),
                dof,
                expected,
                count: pieces.len(),
            });
        }
        if let Some(index) = pieces.iter().position(|p| !p.is_finite()) {
            return Err(TrajectoryError::NotFinite {
                piece: index / dof,
                joint: index % dof,
                coefficients: pieces[index].coefficients().to_vec(),
            });
        }
        let breaks = find_breaks(dof, &knots, &pieces);
        Ok(Self { dof, knots, pieces, breaks })
    }

    /// All joints at rest at `q` for `duration` seconds.
    ///
    /// ```
    /// let rest = graspcheck_motion::Trajectory::hold(&[0.1, 0.2], 3.0)?;
    /// assert_eq!((rest.dof(), rest.duration(), rest.eval(1.5).q), (2, 3.0, vec![0.1, 0.2]));
    /// # Ok::<(), graspcheck_motion::TrajectoryError>(())
    /// ```
    ///
    /// # Errors
    /// When `q` is empty or not finite, or `duration` is not positive.
    pub fn hold(q: &[f64], duration: f64) -> Result<Self, TrajectoryError> {
        Self::new(q.len(), vec![0.0, duration], q.iter().map(|&value| Polynomial::constant(value)).collect())
    }

    /// This motion and then `next`, moved in time to begin where this one ends. Where the two do not
    /// fit together the joint is a [`Break`].
    ///
    /// ```
    /// use graspcheck_motion::{Polynomial, Trajectory};
    /// // Joined where they do not fit, two motions have a break that says by how much.
    /// let ramp = Trajectory::new(1, vec![0.0, 1.0], vec![Polynomial::new([0.0, 2.0])])?;
    /// let joined = ramp.then(&Trajectory::hold(&[2.0], 1.0)?)?;
    /// assert_eq!((joined.breaks()[0].order, joined.breaks()[0].jump[0]), (1, -2.0));
    /// # Ok::<(), graspcheck_motion::TrajectoryError>(())
    /// ```
    ///
    /// # Errors
    /// When the numbers of joints differ.
    pub fn then(&self, next: &Self) -> Result<Self, TrajectoryError> {
        if self.dof != next.dof {
            return Err(TrajectoryError::DofMismatch { first: self.dof, second: next.dof });
        }
        let offset = self.duration();
        let knots = self.knots.iter().copied().chain(next.knots[1..].iter().map(|t| offset + t)).collect();
        let pieces = self.pieces.iter().chain(&next.pieces).copied().collect();
        Self::new(self.dof, knots, pieces)
    }

    /// The number of joints.
    #[must_use]
    pub fn dof(&self) -> usize {
        self.dof
    }

    /// The time at which the motion ends, s. It begins at 0.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.knots[self.knots.len() - 1]
    }

    /// The times at which pieces begin and end, s: the first is 0, the last is the duration.
    #[must_use]
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// The inner knots at which position, velocity or acceleration jumps, in order of time.
    #[must_use]
    pub fn breaks(&self) -> &[Break] {
        &self.breaks
    }

    /// The number of intervals between knots.
    #[must_use]
    pub fn piece_count(&self) -> usize {
        self.knots.len() - 1
    }

    /// The polynomial of a joint on an interval, in the local time that is 0 at `knots()[piece]`.
    ///
    /// # Panics
    /// When `piece` or `joint` is out of range.
    #[must_use]
    pub fn piece(&self, piece: usize, joint: usize) -> &Polynomial {
        assert!(joint < self.dof, "joint {joint} of {}", self.dof);
        &self.pieces[piece * self.dof + joint]
    }

    /// All polynomials: those of all joints on the first interval, then on the second, …
    pub(crate) fn pieces(&self) -> &[Polynomial] {
        &self.pieces
    }

    /// The polynomials of all joints on an interval.
    ///
    /// # Panics
    /// When `piece` is out of range.
    #[must_use]
    pub fn piece_of_all(&self, piece: usize) -> &[Polynomial] {
        &self.pieces[piece * self.dof..(piece + 1) * self.dof]
    }

    /// The interval that holds time `t`; at a knot the one that begins there, at the end the last.
    ///
    /// # Panics
    /// When `t` is outside `[0, duration]`.
    #[must_use]
    pub fn piece_at(&self, t: f64) -> usize {
        assert!(
            (0.0..=self.duration()).contains(&t),
            "t = {t} s is outside the motion, which lasts from 0 s to {} s",
            self.duration()
        );
        self.knots.partition_point(|&knot| knot <= t).clamp(1, self.piece_count()) - 1
    }

    /// The state of all joints at `t`; at a break the limit from the right.
    ///
    /// # Panics
    /// When `t` is outside `[0, duration]`. Use [`Trajectory::eval_held`] where a motion holds its end.
    #[must_use]
    pub fn eval(&self, t: f64) -> MotionState {
        let mut state = MotionState::zeros(self.dof);
        self.eval_into(t, &mut state);
        state
    }

    /// As [`Trajectory::eval`], into a state that is there already; allocates nothing.
    ///
    /// # Panics
    /// When `t` is outside `[0, duration]` or `state` was made for another number of joints.
    pub fn eval_into(&self, t: f64, state: &mut MotionState) {
        assert_eq!(state.q.len(), self.dof, "the state has another number of joints");
        let piece = self.piece_at(t);
        let tau = t - self.knots[piece];
        for (joint, polynomial) in self.piece_of_all(piece).iter().enumerate() {
            let [q, qd, qdd, qddd] = polynomial.eval(tau);
            state.q[joint] = q;
            state.qd[joint] = qd;
            state.qdd[joint] = qdd;
            state.qddd[joint] = qddd;
        }
    }

    /// As [`Trajectory::eval_into`] for any `t` at or after 0: after the end the last position is held
    /// at rest.
    ///
    /// ```
    /// use graspcheck_motion::{MotionState, Polynomial, Trajectory};
    /// let ramp = Trajectory::new(1, vec![0.0, 1.0], vec![Polynomial::new([0.0, 2.0])])?;
    /// let mut state = MotionState::zeros(1);
    /// ramp.eval_held(5.0, &mut state);
    /// assert_eq!((state.q[0], state.qd[0]), (2.0, 0.0));
    /// # Ok::<(), graspcheck_motion::TrajectoryError>(())
    /// ```
    ///
    /// # Panics
    /// When `t` is negative or not a number, or `state` was made for another number of joints.
    pub fn eval_held(&self, t: f64, state: &mut MotionState) {
        let ended = t > self.duration();
        self.eval_into(if ended { self.duration() } else { t }, state);
        if ended {
            state.qd.fill(0.0);
            state.qdd.fill(0.0);
            state.qddd.fill(0.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(from: f64, to: f64, duration: f64) -> Trajectory {
        let p = Polynomial::quintic_hermite([from, 0.0, 0.0], [to, 0.0, 0.0], duration);
        Trajectory::new(1, vec![0.0, duration], vec![p]).unwrap()
    }

    #[test]
    fn joined_motions_that_fit_have_no_break() {
        let joined = ramp(0.0, 1.0, 0.7).then(&ramp(1.0, -2.0, 1.3)).unwrap();
        assert!(joined.breaks().is_empty(), "{:?}", joined.breaks());
        assert!((joined.duration() - 2.0).abs() < 1e-15);
        assert!((joined.eval(0.7).q[0] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_jump_of_position_is_a_break_with_its_size() {
        let joined = ramp(0.0, 1.0, 0.7).then(&ramp(1.5, 2.0, 1.0)).unwrap();
        assert_eq!(joined.breaks().len(), 1);
        let found = &joined.breaks()[0];
        assert_eq!((found.knot, found.order), (1, 0));
        assert!((found.jump[0] - 0.5).abs() < 1e-12);
    }

    #[test]
    fn a_break_is_evaluated_from_the_right_and_the_end_from_the_left() {
        let joined = ramp(0.0, 1.0, 1.0).then(&ramp(3.0, 4.0, 1.0)).unwrap();
        assert!((joined.eval(1.0).q[0] - 3.0).abs() < 1e-12);
        assert!((joined.eval(2.0).q[0] - 4.0).abs() < 1e-12);
    }

    #[test]
    fn bad_input_is_an_error_that_names_the_place() {
        let p = Polynomial::constant(0.0);
        assert_eq!(Trajectory::new(0, vec![0.0, 1.0], vec![]), Err(TrajectoryError::NoJoint));
        assert_eq!(
            Trajectory::new(1, vec![0.0, 1.0, 1.0], vec![p, p]),
            Err(TrajectoryError::KnotsNotIncreasing { index: 2, time: 1.0, previous: 1.0 })
        );
        assert!(matches!(
            Trajectory::new(1, vec![0.0, 1.0], vec![Polynomial::constant(f64::NAN)]),
            Err(TrajectoryError::NotFinite { piece: 0, joint: 0, .. })
        ));
        assert!(matches!(Trajectory::hold(&[0.0], -1.0), Err(TrajectoryError::KnotsNotIncreasing { .. })));
    }

    #[test]
    fn after_the_end_the_last_position_is_held_at_rest() {
        let moving = Trajectory::new(1, vec![0.0, 2.0], vec![Polynomial::new([1.0, 3.0, 0.5])]).unwrap();
        let mut state = MotionState::zeros(1);
        moving.eval_held(5.0, &mut state);
        assert_eq!(state, MotionState { q: vec![9.0], qd: vec![0.0], qdd: vec![0.0], qddd: vec![0.0] });
        moving.eval_held(2.0, &mut state);
        assert_eq!(state.qd, [5.0], "at the end itself it still moves");
    }
}
