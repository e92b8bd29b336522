//! An executed motion as a log has it, made continuous: cubic Hermite pieces through the logged positions and
//! velocities of arm, fingers and object.
//!
//! This is what "the executed motion at every instant" means. What the machine did between two rows differs
//! from it by terms of third order in the step, which no log can tell.

use graspcheck_model::{Pose, robot::RobotModel};
use nalgebra::Vector3;

use crate::{hermite::HermitePiece, range_tree::RangeTree, stretch::Range};

/// The rows of a log that the proof reads, as they come.
#[derive(Clone, Debug, Default)]
pub struct MotionLog {
    /// When, s, rising.
    pub times: Vec<f64>,
    /// For each joint of the arm, from base to tool.
    pub arm: Vec<JointLog>,
    /// For each finger.
    pub fingers: [JointLog; 2],
    /// Of the object, when there is one.
    pub object: Vec<BodyState>,
}

/// The rows of one joint.
#[derive(Clone, Debug, Default)]
pub struct JointLog {
    /// rad or m.
    pub position: Vec<f64>,
    /// rad/s or m/s.
    pub velocity: Vec<f64>,
}

/// Pose and velocity of a body at an instant.
#[derive(Clone, Copy, Debug)]
pub struct BodyState {
    /// Where it is.
    pub world_from_body: Pose,
    /// Velocity of its origin in the world, m/s.
    pub linear: Vector3<f64>,
    /// Angular velocity in the world, rad/s.
    pub angular: Vector3<f64>,
}

/// Why rows of a log are no motion.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MotionLogError {
    /// There are fewer than two rows.
    #[error("log: {rows} rows make no motion, at least 2 do")]
    TooFew {
        /// How many there are.
        rows: usize,
    },
    /// A time is not later than the one before, or not finite.
    #[error("log: row {row} at {time} s must be later than the row before, at {before} s")]
    Order {
        /// Index of the row.
        row: usize,
        /// Its time, s.
        time: f64,
        /// The time of the row before, s.
        before: f64,
    },
    /// A column is too short or too long.
    #[error("log: {column} has {found} values, {expected} are needed")]
    Ragged {
        /// What the column is of.
        column: String,
        /// How many values there are.
        found: usize,
        /// How many there must be.
        expected: usize,
    },
    /// A number is NaN or infinite.
    #[error("log: {column} is not finite in row {row}")]
    NotFinite {
        /// What the column is of.
        column: String,
        /// Index of the row.
        row: usize,
    },
}

/// A motion along cubic Hermite pieces through the rows of a log.
#[derive(Clone, Debug)]
pub struct LoggedMotion {
    times: Vec<f64>,
    arm: Vec<Coordinate>,
    fingers: [Coordinate; 2],
    object: Vec<BodyState>,
}

/// A joint, with the ranges of all its pieces.
#[derive(Clone, Debug)]
struct Coordinate {
    log: JointLog,
    ranges: RangeTree,
}

impl LoggedMotion {
    /// The motion that a log of this robot describes.
    ///
    /// # Errors
    /// When there are fewer than two rows, times do not rise, or a column has another length or a number that
    /// is not finite.
    pub fn new(robot: &RobotModel, log: MotionLog) -> Result<Self, MotionLogError> {
        let MotionLog { times, arm, fingers, object } = log;
        let rows = times.len();
        if rows < 2 {
            return Err(MotionLogError::TooFew { rows });
        }
        for (row, pair) in (1..).zip(times.windows(2)) {
            // Written so that a NaN is out of order.
            if !(pair[1] > pair[0] && pair[1].is_finite() && pair[0].is_finite()) {
                return Err(MotionLogError::Order { row, time: pair[1], before: pair[0] });
            }
        }
        let full = |column: &str, found: usize, expected: usize| {
            let column = column.to_owned();
            if found == expected { Ok(()) } else { Err(MotionLogError::Ragged { column, found, expected }) }
        };
        full("the arm's joints", arm.len(), robot.dof())?;
        let finger_names = robot.gripper.fingers.iter().map(|finger| &finger.joint);
        let names = robot.joints.iter().map(|joint| &joint.name).chain(finger_names);
        for (name, joint) in names.zip(arm.iter().chain(&fingers)) {
            for values in [&joint.position, &joint.velocity] {
                full(name, values.len(), rows)?;
                if let Some(row) = values.iter().position(|value| !value.is_finite()) {
                    return Err(MotionLogError::NotFinite { column: name.clone(), row });
                }
            }
        }
        if !object.is_empty() {
            full("the object", object.len(), rows)?;
        }
        let is_finite = |state: &BodyState| {
            let pose = state.world_from_body.to_homogeneous();
            pose.iter().chain(&state.linear).chain(&state.angular).all(|number| number.is_finite())
        };
        if let Some(row) = object.iter().position(|state| !is_finite(state)) {
            return Err(MotionLogError::NotFinite { column: "the object".to_owned(), row });
        }
        let coordinate = |log: JointLog| Coordinate::new(&times, log);
        let (arm, fingers) = (arm.into_iter().map(coordinate).collect(), fingers.map(coordinate));
        Ok(Self { arm, fingers, object, times })
    }

    /// When it begins and ends, s.
    #[must_use]
    pub fn span(&self) -> [f64; 2] {
        [self.times[0], self.times[self.times.len() - 1]]
    }

    /// The times of the rows, s.
    pub(crate) fn times(&self) -> &[f64] {
        &self.times
    }

    /// The object at each row; empty without one.
    pub(crate) fn object(&self) -> &[BodyState] {
        &self.object
    }

    /// The positions of the arm in a row.
    pub(crate) fn arm_row(&self, row: usize, position: &mut [f64], velocity: &mut [f64]) {
        for (joint, coordinate) in self.arm.iter().enumerate() {
            position[joint] = coordinate.log.position[row];
            velocity[joint] = coordinate.log.velocity[row];
        }
    }

    /// The index of the piece at a time, s, that lies in the motion's span.
    pub(crate) fn piece_at(&self, time: f64) -> usize {
        piece_at(&self.times, time)
    }

    /// The cubic of an arm joint on a piece, in time local to it.
    pub(crate) fn arm_piece(&self, joint: usize, piece: usize) -> HermitePiece {
        self.arm[joint].piece(&self.times, piece)
    }

    /// The same of a finger.
    pub(crate) fn finger_piece(&self, finger: usize, piece: usize) -> HermitePiece {
        self.fingers[finger].piece(&self.times, piece)
    }

    /// Position of an arm joint in the middle of an interval (s), and its range there, exact to rounding.
    pub(crate) fn arm(&self, joint: usize, start: f64, end: f64) -> Range {
        let coordinate = &self.arm[joint];
        around(coordinate.value(&self.times, 0.5 * (start + end)), coordinate.range(&self.times, start, end))
    }

    /// The opening likewise, such that half of the range holds both fingers, even where they differ.
    pub(crate) fn opening(&self, start: f64, end: f64) -> Range {
        let [a, b] = self.fingers.each_ref().map(|finger| finger.range(&self.times, start, end));
        let middle = 0.5 * (start + end);
        let reference = self.fingers.iter().map(|finger| finger.value(&self.times, middle)).sum();
        around(reference, [2.0 * a[0].min(b[0]), 2.0 * a[1].max(b[1])])
    }

    /// How far each finger is at a time (s) from where half of the opening has it, m.
    pub(crate) fn asymmetry(&self, time: f64) -> f64 {
        let [a, b] = self.fingers.each_ref().map(|finger| finger.value(&self.times, time));
        0.5 * (a - b).abs()
    }
}

/// The index of the interval of some rising times that holds one, the first or last for what is outside.
pub(crate) fn piece_at(times: &[f64], time: f64) -> usize {
    times.partition_point(|&row| row <= time).clamp(1, times.len() - 1) - 1
}

fn around(reference: f64, [low, high]: [f64; 2]) -> Range {
    Range { reference, below: (reference - low).max(0.0), above: (high - reference).max(0.0) }
}

impl Coordinate {
    fn new(times: &[f64], log: JointLog) -> Self {
        let ranges = RangeTree::new((0..times.len() - 1).map(|piece| log.piece(times, piece).whole_range()));
        Self { log, ranges }
    }

    fn piece(&self, times: &[f64], piece: usize) -> HermitePiece {
        self.log.piece(times, piece)
    }

    fn value(&self, times: &[f64], time: f64) -> f64 {
        let piece = piece_at(times, time);
        self.piece(times, piece).value(time - times[piece])
    }

    /// The least and the largest value between two instants, s.
    fn range(&self, times: &[f64], start: f64, end: f64) -> [f64; 2] {
        let (first, last) = (piece_at(times, start), piece_at(times, end));
        let part = |piece: usize, from: f64, to: f64| {
            self.piece(times, piece).range(from - times[piece], to - times[piece])
        };
        if first == last {
            return part(first, start, end);
        }
        let parts = [part(first, start, times[first + 1]), part(last, times[last], end)];
        parts.iter().fold(self.ranges.union_of(first + 1, last), |all, part| {
            [all[0].min(part[0]), all[1].max(part[1])]
        })
    }
}

impl JointLog {
    fn piece(&self, times: &[f64], piece: usize) -> HermitePiece {
        let ends = |values: &[f64]| [values[piece], values[piece + 1]];
        HermitePiece::new(ends(&self.position), ends(&self.velocity), times[piece + 1] - times[piece])
    }
}
