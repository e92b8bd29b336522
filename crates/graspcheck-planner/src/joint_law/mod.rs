//! Laws of one joint from one state to another: signed, from any time on, with moving ends.
//!
//! Symbols used as names: `q qd qdd qddd` are position, velocity, acceleration and jerk of the joint. States
//! are written `[q, qd, …]`, rad or m and s.
//!
//! | law | ends given by | duration |
//! |---|---|---|
//! | [`JointLaw::cubic`] | position, velocity | given |
//! | [`JointLaw::quintic`] | position, velocity, acceleration | given |
//! | [`JointLaw::septic`] | position, velocity, acceleration, jerk | given |
//! | [`JointLaw::trapezoid`] | position, velocity | the least under V, A |
//! | [`JointLaw::s_curve`] | position, velocity; no acceleration | the least under V, A, J |
//! | [`JointLaw::fastest`] | position, velocity, acceleration | the least under V, A, J |
//! | [`JointLaw::lasting`] | position, velocity, acceleration | given, under V, A, J |
//! | [`JointLaw::along`] | positions, at rest | that of any [`TimeScaling`] |
//!
//! The laws of several joints that end together become one motion by [`together`].

use graspcheck_motion::{Peak, Polynomial, Trajectory, TrajectoryError};

use crate::time_scaling::{
    ScalingError, TimeScaling,
    error::{finite, positive},
    pieces::Pieces,
};

mod extremal;
mod fastest;
mod lasting;
mod polynomial;
mod s_curve;
mod together;
mod trapezoid;
mod turned;

pub use together::{TogetherError, together};

/// Limits on the magnitude of velocity, acceleration and jerk of one joint, in rad or m and s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateLimits {
    /// On velocity, rad/s or m/s.
    pub velocity: f64,
    /// On acceleration, rad/s² or m/s².
    pub acceleration: f64,
    /// On jerk, rad/s³ or m/s³.
    pub jerk: f64,
}

/// How one joint moves on `[start_time, start_time + duration]`.
#[derive(Clone, Debug, PartialEq)]
pub struct JointLaw {
    start_time: f64,
    duration: f64,
    pieces: Pieces,
}

impl JointLaw {
    /// From rest at `from` to rest at `to`, rad or m, along a law of time: `q = q₀ + (q₁ - q₀) s/D`. The signs of
    /// velocity and acceleration follow from that of `q₁ - q₀`.
    ///
    /// ```
    /// use graspcheck_planner::{joint_law::JointLaw, time_scaling::TimeScaling};
    /// // Downwards by 2 with blends of 1 s at velocity -1.
    /// let law = JointLaw::along(5.0, 3.0, &TimeScaling::trapezoid_with_blend(2.0, 3.0, 1.0)?)?;
    /// assert_eq!(law.eval(1.5), [4.0, -1.0, 0.0, 0.0]);
    /// assert_eq!(law.end(), [3.0, 0.0, 1.0, 0.0]);
    /// # Ok::<(), graspcheck_planner::time_scaling::ScalingError>(())
    /// ```
    ///
    /// # Errors
    /// When a position is not finite, or a coefficient overflows.
    pub fn along(from: f64, to: f64, scaling: &TimeScaling) -> Result<Self, ScalingError> {
        let distance = distance_between(from, to)?;
        let pieces = scaling.profile().pieces(from, to, scaling.duration());
        Self::new(distance, scaling.duration(), pieces)
    }

    /// At rest at `q`, rad or m, for `duration`, s.
    ///
    /// ```
    /// use graspcheck_planner::joint_law::JointLaw;
    /// assert_eq!(JointLaw::rest(0.7, 2.0)?.eval(1.0), [0.7, 0.0, 0.0, 0.0]);
    /// # Ok::<(), graspcheck_planner::time_scaling::ScalingError>(())
    /// ```
    ///
    /// # Errors
    /// When `q` is not finite, or `duration` is not positive and finite.
    pub fn rest(q: f64, duration: f64) -> Result<Self, ScalingError> {
        finite("position", q)?;
        positive("duration", duration)?;
        Self::new(0.0, duration, Pieces::one(Polynomial::constant(q)))
    }

    /// The same law from another time on, s. Its polynomials stay in their local time, so that nothing is lost
    /// far from 0; `polynomial.shifted(-start_time)` is a piece in absolute time.
    ///
    /// ```
    /// use graspcheck_planner::joint_law::JointLaw;
    /// let law = JointLaw::cubic([50.0, 0.0], [80.0, 0.0], 3.0)?.starting_at(100.0)?;
    /// assert_eq!(law.eval(101.5)[..2], [65.0, 15.0]);
    /// # Ok::<(), graspcheck_planner::time_scaling::ScalingError>(())
    /// ```
    ///
    /// # Errors
    /// When the time is not finite.
    pub fn starting_at(mut self, start_time: f64) -> Result<Self, ScalingError> {
        finite("start time", start_time)?;
        finite("end time", start_time + self.duration)?;
        self.start_time = start_time;
        Ok(self)
    }

    /// When it begins, s; 0 unless said otherwise.
    #[must_use]
    pub fn start_time(&self) -> f64 {
        self.start_time
    }

    /// When it ends, s.
    #[must_use]
    pub fn end_time(&self) -> f64 {
        self.start_time + self.duration
    }

    /// How long it takes, s; 0 when the states at both ends are the same.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// `[q, qd, qdd, qddd]` at the beginning.
    #[must_use]
    pub fn start(&self) -> [f64; 4] {
        self.pieces.eval(0.0)
    }

    /// `[q, qd, qdd, qddd]` at the end.
    #[must_use]
    pub fn end(&self) -> [f64; 4] {
        self.pieces.eval(self.duration)
    }

    /// `[q, qd, qdd, qddd]` at `t`, s; where a piece meets the next, the limit from the right.
    ///
    /// # Panics
    /// When `t` is outside `[start_time, end_time]`.
    #[must_use]
    pub fn eval(&self, t: f64) -> [f64; 4] {
        assert!(
            (self.start_time..=self.end_time()).contains(&t),
            "t = {t} s is outside the law, which lasts from {} s to {} s",
            self.start_time,
            self.end_time()
        );
        // The end time is rounded, and may lie later than the end by that.
        self.pieces.eval((t - self.start_time).min(self.duration))
    }

    /// When each piece begins, s, and its polynomial in the local time that is 0 there.
    ///
    /// ```
    /// use graspcheck_planner::{joint_law::JointLaw, time_scaling::TimeScaling};
    /// // Up for 1 s, down for 1 s: each piece counts its own time.
    /// let law = JointLaw::along(0.0, 1.0, &TimeScaling::bang_bang(1.0, 1.0)?)?;
    /// let pieces: Vec<_> = law.pieces().map(|(start, p)| (start, p.eval(0.0)[1])).collect();
    /// assert_eq!(pieces, [(0.0, 0.0), (1.0, 1.0)]);
    /// # Ok::<(), graspcheck_planner::time_scaling::ScalingError>(())
    /// ```
    pub fn pieces(&self) -> impl ExactSizeIterator<Item = (f64, Polynomial)> {
        self.pieces.iter().map(|(start, polynomial)| (self.start_time + start, polynomial))
    }

    /// The least and the greatest value of position (order 0), velocity (1), acceleration (2) or jerk (3) and
    /// when they are first taken, exactly: from the roots of the next derivative.
    ///
    /// ```
    /// use graspcheck_planner::joint_law::JointLaw;
    /// // A cubic overshoots its ends when they move.
    /// let [low, high] = JointLaw::cubic([10.0, -50.0], [40.0, -50.0], 1.0)?.range(0);
    /// assert!((low.value - 7.178872).abs() < 5e-7 && (low.time - 0.118119).abs() < 5e-7);
    /// assert!((high.value - 42.821128).abs() < 5e-7 && (high.time - 0.881881).abs() < 5e-7);
    /// # Ok::<(), graspcheck_planner::time_scaling::ScalingError>(())
    /// ```
    ///
    /// # Panics
    /// When `order` is above 3.
    #[must_use]
    pub fn range(&self, order: usize) -> [Peak; 2] {
        let mut found: Option<[Peak; 2]> = None;
        let ends = self.pieces.starts()[1..].iter().copied().chain([self.duration]);
        for ((start, polynomial), end) in self.pieces.iter().zip(ends) {
            let [low, high] = polynomial
                .range(order, 0.0, end - start)
                .map(|extremum| Peak { value: extremum.value, time: self.start_time + start + extremum.tau });
            let [lowest, highest] = found.get_or_insert([low, high]);
            if low.value < lowest.value {
                *lowest = low;
            }
            if high.value > highest.value {
                *highest = high;
            }
        }
        found.expect("a law has a piece")
    }

    /// The motion of one joint by this law; it begins at 0, as every trajectory does.
    ///
    /// ```
    /// use graspcheck_planner::joint_law::JointLaw;
    /// let motion = JointLaw::cubic([0.0, 0.0], [1.0, 0.0], 2.0)?.trajectory()?;
    /// assert_eq!((motion.duration(), motion.peak(0, 1).value), (2.0, 0.75));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// When the duration is 0.
    pub fn trajectory(&self) -> Result<Trajectory, TrajectoryError> {
        let knots = self.pieces.starts().iter().copied().chain([self.duration]).collect();
        Trajectory::new(1, knots, self.pieces.iter().map(|(_, polynomial)| polynomial).collect())
    }

    /// The pieces in the time that is 0 at the beginning.
    fn pieces_in_place(&self) -> &Pieces {
        &self.pieces
    }

    /// The law of these pieces, which cover `distance`.
    fn new(distance: f64, duration: f64, pieces: Pieces) -> Result<Self, ScalingError> {
        if duration.is_finite() && pieces.is_finite() {
            Ok(Self { start_time: 0.0, duration, pieces })
        } else {
            Err(ScalingError::Overflow { distance: distance.abs(), duration })
        }
    }
}

/// How far it is from one position to another, with its sign.
fn distance_between(from: f64, to: f64) -> Result<f64, ScalingError> {
    finite("start position", from)?;
    finite("end position", to)?;
    finite("distance", to - from)?;
    Ok(to - from)
}

/// Checks the states at both ends, whose numbers are named in order.
fn check_ends<const N: usize>(start: [f64; N], end: [f64; N]) -> Result<(), ScalingError> {
    let names = [
        ["start position", "start velocity", "start acceleration", "start jerk"],
        ["end position", "end velocity", "end acceleration", "end jerk"],
    ];
    for (state, names) in [start, end].into_iter().zip(names) {
        for (value, name) in state.into_iter().zip(names) {
            finite(name, value)?;
        }
    }
    distance_between(start[0], end[0]).map(drop)
}

#[cfg(test)]
mod tests;
