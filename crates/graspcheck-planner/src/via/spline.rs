//! Cubic splines: the acceleration is continuous, too.
//!
//! With the durations `hₖ` of the segments, their slopes `Δₖ = (qₖ₊₁ − qₖ)/hₖ` and the cubics of
//! [`imposed`](super::imposed), the acceleration is the same on both sides of inner point k when the
//! velocities fulfil
//!
//! ```text
//! hₖ vₖ₋₁ + 2(hₖ₋₁ + hₖ) vₖ + hₖ₋₁ vₖ₊₁ = 3(hₖ Δₖ₋₁ + hₖ₋₁ Δₖ)
//! ```
//!
//! These are two equations fewer than velocities; the ends add them ([`SplineEnds`]):
//!
//! | end | equation at the start, mirrored at the end |
//! |---|---|
//! | velocity given (clamped) | `v₀ = v` |
//! | acceleration given (natural: 0) | `2v₀ + v₁ = 3Δ₀ − a h₀/2` |
//! | not-a-knot: the jerk is continuous at the second point | `h₁v₀ + (h₀+h₁)v₁ = ((3h₀+2h₁)h₁Δ₀ + h₀²Δ₁)/(h₀+h₁)` |
//! | periodic: velocity and acceleration are the same at both ends | the first equation at point 0, its neighbour being the last but one |
//!
//! Eliminating from the first row on, the pivot of an inner row stays above `hₖ₋₁ + hₖ` and that of the last
//! row above 0 for all durations, so that no rows need be exchanged.
//!
//! Sources: de Boor, *A Practical Guide to Splines*, chapter IV; Biagiotti and Melchiorri, section 4.4.

use graspcheck_motion::Trajectory;

use super::{
    imposed::cubics,
    points::{Quantity, ViaError, ViaPoints, trajectory},
    tridiagonal::Tridiagonal,
};

/// What holds at both ends of a spline.
#[derive(Clone, Debug, PartialEq)]
pub enum SplineEnds {
    /// The motion can go round: it ends where it began, with the same velocity and acceleration.
    Periodic,
    /// Something of its own at each end.
    Each {
        /// At the first point.
        start: SplineEnd,
        /// At the last point.
        end: SplineEnd,
    },
}

/// What holds at one end of a spline; numbers are given for each joint.
#[derive(Clone, Debug, PartialEq)]
pub enum SplineEnd {
    /// The velocity, rad/s or m/s. Zeros make a start or stop at rest, with a step of acceleration.
    Velocity(Vec<f64>),
    /// The acceleration, rad/s² or m/s².
    Acceleration(Vec<f64>),
    /// No acceleration: of all interpolants the one of least mean square acceleration.
    Natural,
    /// The two pieces at this end are one cubic. Where there is one piece only it begins, or ends, with the
    /// slope of its line; two pieces that have this at both ends are one parabola.
    NotAKnot,
}

impl SplineEnds {
    /// The same at both ends.
    #[must_use]
    pub fn both(end: SplineEnd) -> Self {
        Self::Each { start: end.clone(), end }
    }

    /// These velocities at the start and at the end, rad/s or m/s.
    #[must_use]
    pub fn clamped(start: Vec<f64>, end: Vec<f64>) -> Self {
        Self::Each { start: SplineEnd::Velocity(start), end: SplineEnd::Velocity(end) }
    }
}

/// The motion through the points whose velocity and acceleration are continuous everywhere.
///
/// Time 0 is that of the first point. At its ends the motion has what `ends` says and no more: after a
/// clamped start at rest the acceleration begins with a step. To begin and end without one, see
/// [`virtual_points`](super::virtual_points).
///
/// ```
/// use graspcheck_planner::via::{ViaPoints, spline::{self, SplineEnd, SplineEnds}};
///
/// let points = ViaPoints::new(vec![0.0, 1.0, 3.0], vec![vec![0.0], vec![1.0], vec![0.5]])?;
/// let motion = spline::through(&points, &SplineEnds::both(SplineEnd::Natural))?;
/// assert!(motion.breaks().is_empty());
/// assert!(motion.eval(0.0).qdd[0].abs() < 1e-15 && motion.eval(3.0).qdd[0].abs() < 1e-15);
/// # Ok::<(), graspcheck_planner::via::ViaError>(())
/// ```
///
/// # Errors
/// When a velocity or acceleration at an end is not finite or not given for each joint, a periodic motion
/// does not end exactly where it began, or a coefficient overflows.
pub fn through(points: &ViaPoints, ends: &SplineEnds) -> Result<Trajectory, ViaError> {
    let durations = points.durations();
    let mut of_joints = Vec::with_capacity(points.dof());
    if let SplineEnds::Each { start, end } = ends {
        check_end(points, "start", start)?;
        check_end(points, "end", end)?;
    }
    for joint in 0..points.dof() {
        let positions = points.of_joint(joint);
        let spline = Spline::new(&durations, &positions);
        let velocities = match ends {
            SplineEnds::Periodic => {
                check_closed(joint, &positions)?;
                spline.periodic()
            }
            SplineEnds::Each { start, end } => spline.with_ends(joint, start, end),
        };
        of_joints.push(cubics(&durations, &positions, &velocities));
    }
    Ok(trajectory(points.times(), &of_joints)?)
}

fn check_end(points: &ViaPoints, place: &str, end: &SplineEnd) -> Result<(), ViaError> {
    match end {
        SplineEnd::Velocity(values) => points.check_joints(place, Quantity::Velocity, values),
        SplineEnd::Acceleration(values) => points.check_joints(place, Quantity::Acceleration, values),
        SplineEnd::Natural | SplineEnd::NotAKnot => Ok(()),
    }
}

#[expect(clippy::float_cmp, reason = "a motion that goes round must close exactly, and whoever gives it can")]
fn check_closed(joint: usize, positions: &[f64]) -> Result<(), ViaError> {
    let [first, last] = [positions[0], positions[positions.len() - 1]];
    if first == last {
        return Ok(());
    }
    Err(ViaError::NotClosed { point: positions.len(), joint, first, last, difference: last - first })
}

/// The equations of one joint.
struct Spline<'a> {
    durations: &'a [f64],
    slopes: Vec<f64>,
}

/// A row `[lower, diagonal, upper]` and its right-hand side.
type Row = ([f64; 3], f64);

impl<'a> Spline<'a> {
    fn new(durations: &'a [f64], positions: &[f64]) -> Self {
        let slope = |(pair, duration): (&[f64], &f64)| (pair[1] - pair[0]) / duration;
        Self { durations, slopes: positions.windows(2).zip(durations).map(slope).collect() }
    }

    /// Continuity of acceleration between a segment and the next, which follows it.
    fn row(&self, segment: usize, next: usize) -> Row {
        let [before, after] = [self.durations[segment], self.durations[next]];
        let right = 3.0 * (after * self.slopes[segment] + before * self.slopes[next]);
        ([after, 2.0 * (before + after), before], right)
    }

    fn with_ends(&self, joint: usize, start: &SplineEnd, end: &SplineEnd) -> Vec<f64> {
        let segments = self.durations.len();
        let mut system = Tridiagonal::default();
        let mut right = Vec::with_capacity(segments + 1);
        let mut push = |(row, value): Row| {
            system.push(row);
            right.push(value);
        };
        let parabola = segments == 2 && [start, end] == [&SplineEnd::NotAKnot; 2];
        let forward = |k: usize| (self.durations[k], self.slopes[k]);
        let backward = |k: usize| forward(segments - 1 - k);
        let ([diagonal, beside], value) = end_row(joint, start, segments, parabola, 1.0, &forward);
        push(([0.0, diagonal, beside], value));
        for k in 1..segments {
            push(self.row(k - 1, k));
        }
        let ([diagonal, beside], value) = end_row(joint, end, segments, parabola, -1.0, &backward);
        push(([beside, diagonal, 0.0], value));
        system.solve(&right)
    }

    /// The first velocity is kept apart: all others are `at_zero + v₀ rate`, and its own equation gives v₀.
    fn periodic(&self) -> Vec<f64> {
        let last = self.durations.len() - 1;
        let ([lower, diagonal, upper], right) = self.row(last, 0);
        let mut system = Tridiagonal::default();
        let mut at_zero = vec![0.0; last];
        let mut rate = vec![0.0; last];
        for k in 1..=last {
            let (row, value) = self.row(k - 1, k);
            system.push(row);
            at_zero[k - 1] = value;
            if k == 1 {
                rate[k - 1] -= row[0];
            }
            if k == last {
                rate[k - 1] -= row[2];
            }
        }
        let [at_zero, rate] = [system.solve(&at_zero), system.solve(&rate)];
        // Next to point 0 are points 1 and `last`; with one segment both are point 0 itself.
        let (next, previous) = match (rate.first(), rate.last()) {
            (Some(&next), Some(&previous)) => ([at_zero[0], next], [at_zero[last - 1], previous]),
            _ => ([0.0, 1.0], [0.0, 1.0]),
        };
        let first = (right - lower * previous[0] - upper * next[0])
            / (diagonal + lower * previous[1] + upper * next[1]);
        let others = at_zero.iter().zip(&rate).map(|(value, rate)| value + first * rate);
        [first].into_iter().chain(others).chain([first]).collect()
    }
}

/// The equation at an end: factors of the velocity there and of the one beside it, and the right-hand side.
/// `segment` gives duration and slope of the segments counted from this end; `inward` is 1 at the start and
/// -1 at the end.
fn end_row(
    joint: usize,
    end: &SplineEnd,
    segments: usize,
    parabola: bool,
    inward: f64,
    segment: &dyn Fn(usize) -> (f64, f64),
) -> ([f64; 2], f64) {
    let (duration, slope) = segment(0);
    let acceleration = |a: f64| ([2.0, 1.0], 3.0 * slope - 0.5 * inward * a * duration);
    match end {
        SplineEnd::Velocity(velocities) => ([1.0, 0.0], velocities[joint]),
        SplineEnd::Acceleration(accelerations) => acceleration(accelerations[joint]),
        SplineEnd::Natural => acceleration(0.0),
        SplineEnd::NotAKnot if segments == 1 => ([1.0, 0.0], slope),
        // The mean of both velocities of a parabola is its slope.
        SplineEnd::NotAKnot if parabola => ([1.0, 1.0], 2.0 * slope),
        SplineEnd::NotAKnot => {
            let (next, next_slope) = segment(1);
            let both = duration + next;
            let right = (3.0 * duration + 2.0 * next) * next * slope + duration * duration * next_slope;
            ([next, both], right / both)
        }
    }
}
