//! How near an arm comes to a singular pose, and whether its elbow changes sides, proved over continuous time.
//!
//! **Two links.** The wrist of an arm with a closed form is singular where its elbow is straight or folded, and
//! nowhere else: its Jacobian has the determinant `l₁ l₂ sin φ₂`. The range of the elbow on a piece is exact, and so is
//! the least `|sin φ₂|` over it: zero if a multiple of π is inside, else that at one of its ends.
//!
//! **Any chain.** The measure is the least singular value of the tool's Jacobian, distances in units of the arm's
//! length. In the middle of a stretch it is computed; at another instant it is less by at most the norm of the
//! change of the Jacobian ([`JacobianBounds`]), and stretches are halved until it is known to a tolerance.
//!
//! The measure has no unit, is 0 in a singular pose, and not more than 1 for two links.

use std::f64::consts::PI;

use graspcheck_model::{
    chain::SerialChain, inverse::InverseKinematics, jacobian_bounds::JacobianBounds, robot::RobotModel,
};
use graspcheck_motion::Trajectory;

use crate::peak::{Bound, Bounded, Course, MOST_STEPS, find_peaks};

/// How near the bounds on the least singular value are brought to each other.
pub const SINGULAR_TOLERANCE: f64 = 1e-4;

/// Rounding of a decomposition into singular values, as a share of the largest.
const DECOMPOSITION_ROUNDING: f64 = 1e-12;

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// `|sin φ₂|` of the elbow of two links.
    Elbow,
    /// The least singular value of the Jacobian.
    SingularValue,
}

/// How near a motion comes to a singular pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestSingular {
    /// What is measured.
    pub measure: Measure,
    /// It is never less.
    pub lower: f64,
    /// At `time` it is at most this.
    pub upper: f64,
    /// When, s.
    pub time: f64,
    /// Whether the bounds are as near to each other as they should; if not, the search gave up.
    pub is_settled: bool,
}

/// How near a motion comes to a singular pose between two instants, s.
///
/// # Panics
/// When the robot has another number of joints than the motion or none, or not `0 ≤ start < end ≤ duration`.
#[must_use]
pub fn nearest_singular(robot: &RobotModel, motion: &Trajectory, [start, end]: [f64; 2]) -> NearestSingular {
    match InverseKinematics::new(robot) {
        Ok(inverse) => of_elbow(&inverse, motion, [start, end]),
        Err(_) => of_any_chain(robot, motion, [start, end]),
    }
}

/// The instant (s) at which the elbow of two links first goes straight or folds between two instants, if it does;
/// none also for an arm that has no such elbow.
///
/// # Panics
/// As [`nearest_singular`].
#[must_use]
pub fn elbow_changes_side(robot: &RobotModel, motion: &Trajectory, ends: [f64; 2]) -> Option<f64> {
    let inverse = InverseKinematics::new(robot).ok()?;
    let found = of_elbow(&inverse, motion, ends);
    (found.upper == 0.0).then_some(found.time)
}

fn of_elbow(inverse: &InverseKinematics, motion: &Trajectory, [start, end]: [f64; 2]) -> NearestSingular {
    let zero = inverse.geometry().elbow_zero;
    let [low, high] = motion.range_in(1, 0, start, end);
    let [lowest, highest] = [low, high].map(|extremum| extremum.value + zero);
    let multiple = PI * (lowest / PI).ceil();
    let (least, time) = if multiple <= highest {
        // Between the times of both extrema the elbow passes through the multiple of π.
        let (mut before, mut after) = (low.time, high.time);
        for _ in 0..BISECTIONS {
            let half = 0.5 * (before + after);
            if motion.eval(half).q[1] + zero < multiple { before = half } else { after = half }
        }
        (0.0, 0.5 * (before + after))
    } else {
        // The sine has no zero inside, so that its magnitude is least at an end.
        let ends = [(lowest.sin().abs(), low.time), (highest.sin().abs(), high.time)];
        if ends[0].0 <= ends[1].0 { ends[0] } else { ends[1] }
    };
    NearestSingular { measure: Measure::Elbow, lower: least, upper: least, time, is_settled: true }
}

/// Halvings that leave less of any time than a float can tell.
const BISECTIONS: usize = 60;

fn of_any_chain(robot: &RobotModel, motion: &Trajectory, [start, end]: [f64; 2]) -> NearestSingular {
    let chain = SerialChain::of(robot);
    let size = length(robot);
    let mut times: Vec<f64> =
        motion.knots().iter().copied().filter(|&knot| start < knot && knot < end).collect();
    times.insert(0, start);
    times.push(end);
    let courses: Vec<Course> = times.windows(2).map(|ends| Course { start: ends[0], end: ends[1] }).collect();
    let pieces = courses.iter().map(|course| motion.piece_at(0.5 * (course.start + course.end))).collect();
    // All columns of a Jacobian are at most this long: an axis of length 1 and a lever of the length of the arm.
    let largest = (2.0 * robot.dof() as f64).sqrt() * (1.0 + slide(robot, motion) / size).max(1.0 / size);
    let bounds = JacobianBounds::new(&chain, motion, size);
    let mut function = Distance { chain: &chain, motion, size, bounds, pieces, largest };
    let (peaks, is_settled) = find_peaks(&mut function, &courses, &[SINGULAR_TOLERANCE], MOST_STEPS);
    NearestSingular {
        measure: Measure::SingularValue,
        lower: (largest - peaks[0].upper).max(0.0),
        upper: largest - peaks[0].lower,
        time: peaks[0].time,
        is_settled,
    }
}

/// The sum of the lengths of an arm's links, m: the unit of distances in its Jacobian.
fn length(robot: &RobotModel) -> f64 {
    let joints = robot.joints.iter().skip(1).map(|joint| joint.parent_from_joint.translation.vector.norm());
    let length = joints.sum::<f64>() + robot.link_from_tool.translation.vector.norm();
    if length > 0.0 { length } else { 1.0 }
}

/// The largest distances of all prismatic joints from 0 in a motion, m.
fn slide(robot: &RobotModel, motion: &Trajectory) -> f64 {
    let of_joint = |joint: usize| {
        let [low, high] = motion.range_in(joint, 0, 0.0, motion.duration());
        low.value.abs().max(high.value.abs())
    };
    let slides = |joint: &usize| robot.joints[*joint].kind == graspcheck_model::robot::JointKind::Prismatic;
    (0..robot.dof()).filter(slides).map(of_joint).sum()
}

/// By how much the least singular value is below the largest that can be: its peak is the nearest to a singular pose.
struct Distance<'a> {
    chain: &'a SerialChain,
    motion: &'a Trajectory,
    size: f64,
    bounds: JacobianBounds<'a>,
    pieces: Vec<usize>,
    largest: f64,
}

impl Bounded for Distance<'_> {
    fn count(&self) -> usize {
        1
    }

    fn sample_size(&self) -> usize {
        1
    }

    fn sample(&mut self, course: usize, time: f64, sample: &mut [f64]) {
        let piece = self.pieces[course];
        let local = time - self.motion.knots()[piece];
        let q: Vec<f64> = self.motion.piece_of_all(piece).iter().map(|p| p.eval(local)[0]).collect();
        sample[0] = self.chain.dexterity(&q, self.size).smallest();
    }

    fn bound(&mut self, course: usize, ends: [f64; 2], samples: [&[f64]; 3], bounds: &mut [Bound]) {
        let least = samples[1][0];
        let slack = DECOMPOSITION_ROUNDING * self.largest;
        let change = self.bounds.change(self.pieces[course], ends);
        bounds[0] = Bound {
            most: self.largest - (least - change - slack),
            attained: self.largest - (least + slack),
            undecided: 0.0,
        };
    }
}

#[cfg(test)]
mod tests {
    use graspcheck_model::example;

    use super::*;
    use crate::fixtures::{self, Draw};

    #[test]
    fn the_elbow_of_two_links_is_known_exactly() {
        let robot = example::planar();
        // From 0.3 to 1.4 rad and back to 0.8: the least sine is that of 0.3.
        let there = fixtures::rest_to_rest(&[0.0, 0.3, 0.0], &[1.0, 1.4, 0.0], 1.0).trajectory;
        let back = fixtures::rest_to_rest(&[1.0, 1.4, 0.0], &[0.0, 0.8, 0.0], 1.0).trajectory;
        let motion = there.then(&back).unwrap();
        let found = nearest_singular(&robot, &motion, [0.0, 2.0]);
        assert_eq!((found.measure, found.time), (Measure::Elbow, 0.0));
        assert!((found.lower - 0.3_f64.sin()).abs() < 1e-15 && found.upper - found.lower <= 0.0);
        let found = nearest_singular(&robot, &motion, [1.0, 2.0]);
        assert!((found.lower - 0.8_f64.sin()).abs() < 1e-12 && (found.time - 2.0).abs() < 1e-9, "{found:?}");
        assert_eq!(elbow_changes_side(&robot, &motion, [0.0, 2.0]), None);
    }

    #[test]
    fn an_elbow_that_goes_straight_or_folds_between_its_ends_is_found_with_the_time() {
        let robot = example::planar();
        for (from, to) in [(0.5, -0.5), (-0.5, 0.5), (2.9, 3.4), (-3.4, -2.9)] {
            let motion = fixtures::rest_to_rest(&[0.0, from, 0.0], &[0.0, to, 0.0], 1.0).trajectory;
            let time = elbow_changes_side(&robot, &motion, [0.0, 1.0]).unwrap();
            let elbow = motion.eval(time).q[1];
            assert!((elbow / PI - (elbow / PI).round()).abs() < 1e-9, "{elbow} at {time}");
        }
        // It comes to 1 mrad of straight between two instants, and turns back.
        let [down, up] = [[0.5, 0.001], [0.001, 0.5]]
            .map(|[from, to]| fixtures::rest_to_rest(&[0.0, from, 0.0], &[0.0, to, 0.0], 1.0).trajectory);
        let motion = down.then(&up).unwrap();
        let found = nearest_singular(&robot, &motion, [0.0, 2.0]);
        assert!((found.lower - 0.001).abs() < 1e-9 && (found.time - 1.0).abs() < 1e-4, "{found:?}");
    }

    #[test]
    fn the_least_singular_value_of_a_chain_is_below_every_sample_and_near_one() {
        let mut draw = Draw(8);
        let robot = fixtures::six_axes();
        let chain = SerialChain::of(&robot);
        for _ in 0..3 {
            let mut ends = || (0..6).map(|_| draw.between(-1.2, 1.2)).collect::<Vec<f64>>();
            let motion = fixtures::rest_to_rest(&ends(), &ends(), 1.0).trajectory;
            let found = nearest_singular(&robot, &motion, [0.0, 1.0]);
            assert_eq!(found.measure, Measure::SingularValue);
            assert!(found.is_settled && found.upper - found.lower <= SINGULAR_TOLERANCE + 1e-12, "{found:?}");
            let sampled = (0..=1000)
                .map(|i| chain.dexterity(&motion.eval(f64::from(i) / 1000.0).q, length(&robot)).smallest());
            let sampled = sampled.fold(f64::INFINITY, f64::min);
            assert!(found.lower <= sampled && sampled <= found.upper + 1e-3, "{sampled} {found:?}");
        }
    }
}
