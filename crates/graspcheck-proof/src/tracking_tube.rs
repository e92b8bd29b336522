//! The tracking tube: what clearance the plan has left when the arm may be anywhere within the measured
//! tracking error of it.
//!
//! On each stretch of the plan `ē_j = sup |q_j - q_j,ref|` is the error of joint j there, at every instant: on a
//! piece of length h between two rows (or a knot of the plan) the error is the difference of a cubic and a
//! polynomial p. The cubic Hermite interpolant of p is nearer to p than `h⁴ / 384 · max |p⁗|`, and what is left
//! is a cubic, which lies within its four Bézier points.
//!
//! Widened by ē_j on either side, the ranges of the joints hold every motion of the tube, so that the bounds on
//! displacement hold for it: to first order they take `Λ = Σ ρ_jk ē_j` from the distance of link k, or less where
//! the error moves it past the obstacle rather than towards it. Fingers and object count with how far they were
//! from where the plan has them.

use graspcheck_model::plan::Plan;
use graspcheck_motion::Polynomial;

use crate::{
    clearance_search::{CourseClearance, Leg, ObjectCourse, Question},
    contact::{Occasion, Requirement, Stage},
    executed::logged_phases,
    hermite::HermitePiece,
    logged_motion::LoggedMotion,
    scene::Scene,
    stretch::{Around, middle, stretches},
};

/// Where the pads come to their stop within such a time, s, both what they are commanded and where they stop
/// count: at finger speeds of 0.1 m/s that makes 0.1 mm.
const SHORTEST_STOP: f64 = 1e-3;

/// The clearance of the plan within the tracking tube.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackingTube {
    /// Margins of the pairs that may not touch, above touching: a distance less what tracking can take from it.
    /// Violated means that it may take all of it.
    pub clearance: CourseClearance,
    /// The largest tracking error of each arm joint, rad or m.
    pub errors: Vec<f64>,
}

impl Scene {
    /// The clearance that a plan has left when all joints may be as far from it as the executed motion was at
    /// any instant of the same stretch, until the plan ends.
    ///
    /// # Errors
    /// Says in words what the plan or the log lacks.
    pub fn tracking_tube(&self, plan: &Plan, motion: &LoggedMotion) -> Result<TrackingTube, String> {
        let phases = logged_phases(self, plan, motion)?;
        let dof = self.robot.dof();
        let mut errors = vec![0.0_f64; dof];
        let mut legs = Vec::new();
        for stretch in stretches(plan, dof)? {
            let span = [stretch.start, stretch.end];
            let name = &plan.phases[stretch.phase].name;
            let Some(logged) = phases.iter().find(|logged| logged.phase == stretch.phase) else {
                return Err(format!("log: phase {name} is in no row"));
            };
            let mut stage = Stage::new(self, plan, Occasion::of(plan, stretch.phase))?;
            let arm: Vec<f64> = (0..dof).map(|joint| arm_error(plan, motion, joint, span)).collect();
            for (all, error) in errors.iter_mut().zip(&arm) {
                *all = all.max(*error);
            }
            let opening = 2.0 * finger_error(plan, motion, stage.opening_min, span);
            let object = match &logged.object {
                Some(object) => {
                    ObjectCourse::Within(object.carried.deviation(&object.planned, span[0], span[1]))
                }
                None => ObjectCourse::Absent,
            };
            let around = Around { arm, opening, opening_min: stage.opening_min };
            // The tube says how far the pads go beyond where they stop.
            stage.opening_min = f64::NEG_INFINITY;
            legs.push(Leg { stretch: stretch.around(around), stage, phase: name, object });
        }
        let clearance = Question { scene: self, legs: &legs, demand: in_a_tube, fingers: None }.answer();
        Ok(TrackingTube { clearance, errors })
    }
}

/// What is required of a pair in a tube: what may touch or stands still is not judged, all else must not touch.
fn in_a_tube(requirement: &Requirement) -> Option<f64> {
    let is_judged = requirement.contact.is_none() && !requirement.fixed;
    is_judged.then_some(requirement.required.min(0.0))
}

/// The largest error of an arm joint between two instants, rad or m.
fn arm_error(plan: &Plan, motion: &LoggedMotion, joint: usize, span: [f64; 2]) -> f64 {
    let trajectory = &plan.trajectory;
    let piece = trajectory.piece_at(middle(span[0], span[1]));
    let polynomial = trajectory.piece(piece, joint);
    error(polynomial, trajectory.knots()[piece], motion, span, |row| motion.arm_piece(joint, row))
}

/// The largest error of either finger, m, against half of the opening, which stops at `least`.
fn finger_error(plan: &Plan, motion: &LoggedMotion, least: f64, span: [f64; 2]) -> f64 {
    let opening = &plan.opening;
    let piece = opening.piece_at(middle(span[0], span[1]));
    let zero = opening.knots()[piece];
    let polynomial = opening.piece(piece, 0);
    let [low, high] = polynomial.range(0, span[0] - zero, span[1] - zero).map(|extremum| extremum.value);
    if low < least && high > least && span[1] - span[0] > SHORTEST_STOP {
        // The pads come to their stop, or leave it, somewhere between.
        let half = middle(span[0], span[1]);
        let [before, after] = [[span[0], half], [half, span[1]]];
        return finger_error(plan, motion, least, before).max(finger_error(plan, motion, least, after));
    }
    let moving = Polynomial::new(polynomial.coefficients().map(|coefficient| 0.5 * coefficient));
    let stopped = Polynomial::constant(0.5 * least);
    let targets = [(high > least).then_some(moving), (low < least).then_some(stopped)];
    let errors = targets.iter().flatten().flat_map(|target| {
        (0..2).map(|finger| error(target, zero, motion, span, |row| motion.finger_piece(finger, row)))
    });
    errors.fold(0.0, f64::max)
}

/// The largest difference of a polynomial, whose local time begins at `zero`, and the cubics of a log.
fn error(
    polynomial: &Polynomial,
    zero: f64,
    motion: &LoggedMotion,
    [start, end]: [f64; 2],
    cubic: impl Fn(usize) -> HermitePiece,
) -> f64 {
    let [first, last] = motion.span();
    let (start, end) = (start.max(first), end.min(last));
    if start >= end {
        return 0.0;
    }
    let fourth = polynomial.derivative_of_order(4).range(0, start - zero, end - zero);
    let fourth = fourth.map(|extremum| extremum.value.abs()).into_iter().fold(0.0, f64::max);
    let times = motion.times();
    let mut most = 0.0_f64;
    for row in motion.piece_at(start)..=motion.piece_at(end) {
        let (from, to) = (times[row].max(start), times[row + 1].min(end));
        let h = to - from;
        if h <= 0.0 {
            continue;
        }
        let logged = cubic(row);
        let off = |time: f64| {
            let [planned, rate, ..] = polynomial.eval(time - zero);
            let tau = time - times[row];
            (logged.value(tau) - planned, logged.rate(tau) - rate)
        };
        let ((a, rate_a), (b, rate_b)) = (off(from), off(to));
        let points = [a, a + h * rate_a / 3.0, b - h * rate_b / 3.0, b];
        let within = points.iter().fold(0.0, |most: f64, point| most.max(point.abs()));
        most = most.max(within + h.powi(4) / 384.0 * fourth);
    }
    most
}
