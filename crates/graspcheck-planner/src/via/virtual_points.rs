//! Cubic splines with velocity *and* acceleration given at both ends, by two virtual points.
//!
//! A spline through N points leaves two conditions open, and a start and stop without a step of acceleration
//! ask four. So the first and the last segment are each divided by a virtual point: its time is stated, its
//! position comes out. With the accelerations `aₖ` at all points, the virtual ones included, and the
//! durations `hₖ` between them, the velocity is continuous when
//!
//! ```text
//! hₖ₋₁ aₖ₋₁ + 2(hₖ₋₁ + hₖ) aₖ + hₖ aₖ₊₁ = 6((qₖ₊₁ − qₖ)/hₖ − (qₖ − qₖ₋₁)/hₖ₋₁)
//! ```
//!
//! The first piece gives the position of the first virtual point by its acceleration,
//!
//! ```text
//! q₁ = q₀ + v₀ h₀ + a₀ h₀²/3 + a₁ h₀²/6
//! ```
//!
//! and the last piece that of the second. Put in, they leave a system with three diagonals for the
//! accelerations at the inner points.
//!
//! The nearer a virtual point is to its end, the larger is the jerk of the short piece; the nearer it is to
//! the next point, the larger are the accelerations (worked examples via-4 and via-4b). Half-way or
//! earlier is a good start.
//!
//! Source: Biagiotti and Melchiorri, section 4.4.4; Siciliano et al., section 4.2.2 (*virtual points*).

use graspcheck_motion::{Polynomial, Trajectory};

use super::{
    points::{Quantity, ViaError, ViaPoints, trajectory},
    tridiagonal::Tridiagonal,
};

/// Velocity and acceleration of all joints at an end.
#[derive(Clone, Debug, PartialEq)]
pub struct EndState {
    /// Velocity of each joint, rad/s or m/s.
    pub velocity: Vec<f64>,
    /// Acceleration of each joint, rad/s² or m/s².
    pub acceleration: Vec<f64>,
}

impl EndState {
    /// Neither velocity nor acceleration, for `dof` joints.
    #[must_use]
    pub fn at_rest(dof: usize) -> Self {
        Self { velocity: vec![0.0; dof], acceleration: vec![0.0; dof] }
    }
}

/// A spline with its virtual points.
#[derive(Clone, Debug, PartialEq)]
pub struct VirtualPointSpline {
    /// The motion. Its knots are the points and the virtual points; time 0 is that of the first point.
    pub trajectory: Trajectory,
    /// Positions of all joints at the first and at the second virtual point, rad or m.
    pub virtual_positions: [Vec<f64>; 2],
}

/// The motion through the points with continuous acceleration that begins and ends with these states, by
/// virtual points at these times, s: the first inside the first segment, the second inside the last.
///
/// ```
/// use std::f64::consts::PI;
/// use graspcheck_planner::via::{ViaPoints, virtual_points::{self, EndState}};
///
/// let positions = [0.0, 2.0 * PI, 0.5 * PI, PI].map(|q| vec![q]).to_vec();
/// let points = ViaPoints::new(vec![0.0, 2.0, 3.0, 5.0], positions)?;
/// let rest = EndState::at_rest(1);
/// let spline = virtual_points::through(&points, &rest, &rest, [0.5, 4.5])?;
/// assert!((spline.virtual_positions[0][0] - 1441.0 * PI / 10400.0).abs() < 1e-12);
/// assert!(spline.trajectory.breaks().is_empty());
/// let start = spline.trajectory.eval(0.0);
/// assert_eq!((start.qd[0], start.qdd[0]), (0.0, 0.0));
/// # Ok::<(), graspcheck_planner::via::ViaError>(())
/// ```
///
/// # Errors
/// When an end state does not have one finite velocity and acceleration for each joint, a virtual point is
/// not inside its segment (or, with two points, the second not after the first), or a coefficient overflows.
pub fn through(
    points: &ViaPoints,
    start: &EndState,
    end: &EndState,
    virtual_times: [f64; 2],
) -> Result<VirtualPointSpline, ViaError> {
    for (place, state) in [("start", start), ("end", end)] {
        points.check_joints(place, Quantity::Velocity, &state.velocity)?;
        points.check_joints(place, Quantity::Acceleration, &state.acceleration)?;
    }
    let times = with_virtual_times(points.times(), virtual_times)?;
    let durations: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mut of_joints = Vec::with_capacity(points.dof());
    let mut virtual_positions = [Vec::new(), Vec::new()];
    for joint in 0..points.dof() {
        let of_end = |state: &EndState| [state.velocity[joint], state.acceleration[joint]];
        let spline = solve(&durations, &points.of_joint(joint), of_end(start), of_end(end));
        let last = spline.positions.len() - 2;
        virtual_positions[0].push(spline.positions[1]);
        virtual_positions[1].push(spline.positions[last]);
        of_joints.push(spline.pieces(&durations, start.velocity[joint]));
    }
    Ok(VirtualPointSpline { trajectory: trajectory(&times, &of_joints)?, virtual_positions })
}

/// The times of the points with those of the virtual points between them.
fn with_virtual_times(times: &[f64], [first, second]: [f64; 2]) -> Result<Vec<f64>, ViaError> {
    let last = times.len() - 1;
    let check = |which, time: f64, after: f64, before: f64| {
        if time > after && time < before {
            Ok(())
        } else {
            Err(ViaError::VirtualTime { which, time, after, before })
        }
    };
    check("first", first, times[0], times[1])?;
    let after = if last == 1 { first } else { times[last - 1] };
    check("second", second, after, times[last])?;
    let inner = &times[1..last];
    Ok([times[0], first].iter().chain(inner).chain(&[second, times[last]]).copied().collect())
}

/// Positions and accelerations of one joint at all points, the virtual ones included.
struct Solved {
    positions: Vec<f64>,
    accelerations: Vec<f64>,
}

/// Solves for one joint. The durations are those between all points, `given` are the positions of the given
/// ones, an end is its velocity and acceleration.
fn solve(durations: &[f64], given: &[f64], start: [f64; 2], end: [f64; 2]) -> Solved {
    let last = durations.len();
    let h = |k: usize| durations[k];
    let [first_h, last_h] = [h(0), h(last - 1)];
    // A virtual position is `known + unknown acceleration · factor`; beyond its end time runs backwards.
    let known = |q: f64, [v, a]: [f64; 2], h: f64| q + v * h + a * h * h / 3.0;
    let factor = |h: f64| h * h / 6.0;
    let mut positions = vec![given[0], known(given[0], start, first_h)];
    positions.extend(&given[1..given.len() - 1]);
    let q_last = given[given.len() - 1];
    positions.extend([known(q_last, end, -last_h), q_last]);

    let mut system = Tridiagonal::default();
    let mut right = Vec::with_capacity(last - 1);
    for k in 1..last {
        let mut row = [h(k - 1), 2.0 * (h(k - 1) + h(k)), h(k)];
        let slope = |k: usize| (positions[k + 1] - positions[k]) / h(k);
        let mut value = 6.0 * (slope(k) - slope(k - 1));
        // The unknown parts of the virtual positions, moved to the left; both with two points.
        for (at, factor) in [(1, factor(first_h)), (last - 1, factor(last_h))] {
            if k == at {
                row[1] += 6.0 * factor * (1.0 / h(k) + 1.0 / h(k - 1));
            } else if k == at + 1 {
                row[0] -= 6.0 * factor / h(k - 1);
            } else if k + 1 == at {
                row[2] -= 6.0 * factor / h(k);
            }
        }
        if k == 1 {
            value -= row[0] * start[1];
        }
        if k == last - 1 {
            value -= row[2] * end[1];
        }
        system.push(row);
        right.push(value);
    }
    let inner = system.solve(&right);
    positions[1] += inner[0] * factor(first_h);
    positions[last - 1] += inner[last - 2] * factor(last_h);
    Solved { positions, accelerations: [start[1]].into_iter().chain(inner).chain([end[1]]).collect() }
}

impl Solved {
    /// The cubics; the first begins with exactly this velocity.
    fn pieces(&self, durations: &[f64], start_velocity: f64) -> Vec<Polynomial> {
        let piece = |(k, &h): (usize, &f64)| {
            let [a0, a1] = [self.accelerations[k], self.accelerations[k + 1]];
            let slope = (self.positions[k + 1] - self.positions[k]) / h;
            let velocity = if k == 0 { start_velocity } else { slope - h * (2.0 * a0 + a1) / 6.0 };
            Polynomial::new([self.positions[k], velocity, 0.5 * a0, (a1 - a0) / (6.0 * h)])
        };
        durations.iter().enumerate().map(piece).collect()
    }
}
