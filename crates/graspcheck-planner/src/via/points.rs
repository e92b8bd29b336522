//! Points in joint space with the times at which they are due.

use graspcheck_motion::{Polynomial, Trajectory, TrajectoryError};

/// Why there is no motion through points. Points are counted from 1, joints from 0.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ViaError {
    /// Fewer than two points.
    #[error("a motion needs at least two points, got {count}")]
    TooFewPoints {
        /// How many were given.
        count: usize,
    },
    /// There is not one entry for each point.
    #[error("{count} {quantity} for {points} points; give one for each point")]
    PointCount {
        /// What was counted: `times`, `velocities`.
        quantity: &'static str,
        /// How many there are.
        count: usize,
        /// How many points there are.
        points: usize,
    },
    /// An entry does not have one number for each joint, or the first point has none.
    #[error("{place}: {count} {quantity} for {dof} joints; give one for each joint, and at least one")]
    JointCount {
        /// Where: `point 3`, `start`, `end`.
        place: String,
        /// What was counted: `positions`, `velocities`, `accelerations`.
        quantity: &'static str,
        /// How many there are.
        count: usize,
        /// How many the first point has.
        dof: usize,
    },
    /// A number is NaN or infinite.
    #[error("{place}: {quantity} {value} must be finite")]
    NotFinite {
        /// Where: `point 3`, `point 3, joint 0`, `start, joint 1`.
        place: String,
        /// `time`, `position`, `velocity` or `acceleration`.
        quantity: &'static str,
        /// What was given.
        value: f64,
    },
    /// A point does not come after the one before it.
    #[error("point {point}: time {time} s must be later than that of the point before it, {previous} s")]
    TimesNotIncreasing {
        /// Number of the point.
        point: usize,
        /// Its time, s.
        time: f64,
        /// The time of the point before it, s.
        previous: f64,
    },
    /// A periodic motion does not end where it began.
    #[error(
        "point {point}, joint {joint}: position {last} must be the first one, {first}, in a periodic motion; \
         it is off by {difference}"
    )]
    NotClosed {
        /// Number of the last point.
        point: usize,
        /// Index of the joint.
        joint: usize,
        /// First position, rad or m.
        first: f64,
        /// Last position, rad or m.
        last: f64,
        /// Last minus first, rad or m.
        difference: f64,
    },
    /// A virtual point does not lie inside the segment that it divides.
    #[error("{which} virtual point: time {time} s must be later than {after} s and earlier than {before} s")]
    VirtualTime {
        /// `first` or `second`.
        which: &'static str,
        /// What was given, s.
        time: f64,
        /// Where its range begins, s.
        after: f64,
        /// Where its range ends, s.
        before: f64,
    },
    /// The polynomials are not a trajectory: the numbers are so far apart that a coefficient overflows.
    #[error(transparent)]
    Trajectory(#[from] TrajectoryError),
}

/// Positions of all joints (rad or m) at increasing times (s); the first time need not be 0.
#[derive(Clone, Debug, PartialEq)]
pub struct ViaPoints {
    times: Vec<f64>,
    positions: Vec<Vec<f64>>,
}

impl ViaPoints {
    /// The points `positions[k]` at `times[k]`, s, each with one position for each joint.
    ///
    /// ```
    /// use graspcheck_planner::via::{ViaError, ViaPoints};
    /// let points = ViaPoints::new(vec![0.0, 2.0], vec![vec![0.1, 0.2], vec![0.5, 0.0]])?;
    /// assert_eq!((points.len(), points.dof()), (2, 2));
    /// let error = ViaPoints::new(vec![0.0, 0.0], vec![vec![0.1], vec![0.5]]).unwrap_err();
    /// assert!(matches!(error, ViaError::TimesNotIncreasing { point: 2, .. }));
    /// # Ok::<(), ViaError>(())
    /// ```
    ///
    /// # Errors
    /// When there are fewer than two points, not as many times, a point has another number of joints than the
    /// first or none, a number is not finite, or the times do not increase.
    pub fn new(times: Vec<f64>, positions: Vec<Vec<f64>>) -> Result<Self, ViaError> {
        if positions.len() < 2 {
            return Err(ViaError::TooFewPoints { count: positions.len() });
        }
        let points = Self { times, positions };
        if points.times.len() != points.len() {
            return Err(ViaError::PointCount {
                quantity: "times",
                count: points.times.len(),
                points: points.len(),
            });
        }
        for (k, (&time, positions)) in points.times.iter().zip(&points.positions).enumerate() {
            let place = format!("point {}", k + 1);
            if !time.is_finite() {
                return Err(ViaError::NotFinite { place, quantity: "time", value: time });
            }
            points.check_joints(&place, Quantity::Position, positions)?;
        }
        for (k, pair) in points.times.windows(2).enumerate() {
            if pair[1] <= pair[0] {
                let [previous, time] = [pair[0], pair[1]];
                return Err(ViaError::TimesNotIncreasing { point: k + 2, time, previous });
            }
        }
        Ok(points)
    }

    /// When the points are due, s.
    #[must_use]
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// The points: `positions()[k][joint]`, rad or m.
    #[must_use]
    pub fn positions(&self) -> &[Vec<f64>] {
        &self.positions
    }

    /// How many points there are; at least two.
    #[expect(clippy::len_without_is_empty, reason = "there are at least two")]
    #[must_use]
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// How many joints there are; at least one.
    #[must_use]
    pub fn dof(&self) -> usize {
        self.positions[0].len()
    }

    /// How long each segment between two points takes, s.
    pub(super) fn durations(&self) -> Vec<f64> {
        self.times.windows(2).map(|pair| pair[1] - pair[0]).collect()
    }

    /// The position of one joint at all points.
    pub(super) fn of_joint(&self, joint: usize) -> Vec<f64> {
        self.positions.iter().map(|positions| positions[joint]).collect()
    }

    /// Checks that there is one finite number for each joint.
    pub(crate) fn check_joints(
        &self,
        place: &str,
        quantity: Quantity,
        values: &[f64],
    ) -> Result<(), ViaError> {
        let [one, many] = quantity.words();
        if values.len() != self.dof() || values.is_empty() {
            let (place, count, dof) = (place.to_owned(), values.len(), self.dof());
            return Err(ViaError::JointCount { place, quantity: many, count, dof });
        }
        match values.iter().position(|value| !value.is_finite()) {
            Some(joint) => Err(ViaError::NotFinite {
                place: format!("{place}, joint {joint}"),
                quantity: one,
                value: values[joint],
            }),
            None => Ok(()),
        }
    }
}

/// What is given for each joint.
#[derive(Clone, Copy)]
pub(crate) enum Quantity {
    Position,
    Velocity,
    Acceleration,
}

impl Quantity {
    /// Singular and plural.
    fn words(self) -> [&'static str; 2] {
        match self {
            Self::Position => ["position", "positions"],
            Self::Velocity => ["velocity", "velocities"],
            Self::Acceleration => ["acceleration", "accelerations"],
        }
    }
}

/// The trajectory over `times`, moved to begin at 0, of pieces that are given joint by joint.
pub(super) fn trajectory(
    times: &[f64],
    of_joints: &[Vec<Polynomial>],
) -> Result<Trajectory, TrajectoryError> {
    let knots = times.iter().map(|t| t - times[0]).collect();
    let segments = 0..times.len() - 1;
    let pieces = segments.flat_map(|k| of_joints.iter().map(move |pieces| pieces[k])).collect();
    Trajectory::new(of_joints.len(), knots, pieces)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(times: &[f64], positions: &[&[f64]]) -> String {
        let positions = positions.iter().map(|point| point.to_vec()).collect();
        ViaPoints::new(times.to_vec(), positions).unwrap_err().to_string()
    }

    #[test]
    fn bad_input_names_the_place_the_value_and_what_must_be() {
        assert_eq!(error(&[], &[]), "a motion needs at least two points, got 0");
        assert_eq!(error(&[0.0], &[&[1.0]]), "a motion needs at least two points, got 1");
        assert_eq!(error(&[0.0], &[&[1.0], &[2.0]]), "1 times for 2 points; give one for each point");
        assert_eq!(
            error(&[0.0, 1.0], &[&[1.0, 2.0], &[2.0]]),
            "point 2: 1 positions for 2 joints; give one for each joint, and at least one"
        );
        assert_eq!(
            error(&[0.0, 1.0], &[&[], &[]]),
            "point 1: 0 positions for 0 joints; give one for each joint, and at least one"
        );
        assert_eq!(
            error(&[0.0, 1.0], &[&[1.0, 2.0], &[2.0, f64::NAN]]),
            "point 2, joint 1: position NaN must be finite"
        );
        assert_eq!(error(&[f64::INFINITY, 1.0], &[&[1.0], &[2.0]]), "point 1: time inf must be finite");
        // A duplicate and a step back.
        for time in [1.0, 0.5] {
            assert_eq!(
                error(&[0.0, 1.0, time], &[&[1.0], &[2.0], &[3.0]]),
                format!("point 3: time {time} s must be later than that of the point before it, 1 s")
            );
        }
    }
}
