//! `planned.continuity`: no joint jumps in position or velocity, and acceleration steps only where the
//! task is made of such steps.
//!
//! A jump of position or velocity cannot be executed. A step of acceleration Δa is an impulse of jerk: the
//! jerk has no finite value there, so `planned.jerk` cannot judge it and this check holds Δa itself against
//! a limit. A motion by parabolic blends, or by cubics through points (the tasks `cartesian_via` and
//! `joint_via`, except by virtual points), steps by nature, and is allowed twice the joint's acceleration
//! limit: the step from full braking to full acceleration. Every other task is planned with continuous
//! acceleration and is allowed no step. A scenario may set the share of the acceleration limit itself.
//!
//! The note says of what class the motion is: Cⁿ when its first n derivatives are continuous.
//!
//! The robot stands still before and after the plan, so a plan that begins or ends in motion jumps there.

use graspcheck_motion::trajectory::SMOOTH_TOLERANCE;

use crate::{
    evidence::Evidence,
    finding::{Finding, Gap, worst_by},
    verdict::Unit,
};

/// How many times a joint's acceleration limit its acceleration may step by in a motion whose law has such
/// steps: from one limit to the other.
const LARGEST_STEP: f64 = 2.0;

const ORDER_NAMES: [&str; 3] = ["position", "velocity", "acceleration"];

/// The class of a motion whose first jump is of the given order.
const CLASS_NAMES: [&str; 3] = ["the motion is not continuous", "class C0", "class C1"];

/// A jump of one joint.
pub(super) struct Jump {
    pub(super) joint: usize,
    pub(super) time: f64,
    /// Which derivative jumps first: 0 position, 1 velocity, 2 acceleration.
    order: usize,
    /// Magnitude, SI units.
    pub(super) size: f64,
    /// What it is held against.
    limit: f64,
}

impl Jump {
    /// How bad it is: a jump of position is worse than any of velocity, and so on; among acceleration
    /// steps the share of the limit counts.
    fn rank(&self) -> (usize, f64) {
        let size = if self.limit > 0.0 { self.size / self.limit } else { self.size };
        (2 - self.order, size)
    }
}

/// The worst jump of any joint; a plan without one passes with 0 jumps.
pub(super) fn continuity(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    let jumps = jumps(evidence);
    let count = jumps.len();
    let share = step_share(evidence);
    let Some(worst_order) = jumps.iter().map(|jump| jump.order).min() else {
        return Ok(Finding::at_most(0.0, 0.0, Unit::Count)
            .noted("class C2: position, velocity and acceleration are continuous, from rest to rest"));
    };
    let of_that_order = jumps.into_iter().filter(|jump| jump.order == worst_order);
    let worst = worst_by(of_that_order, |jump| jump.rank().1).expect("a jump has the least order of all");

    let joint = &evidence.joints()[worst.joint];
    let quantity = ORDER_NAMES[worst.order];
    let mut finding = Finding::at_most(worst.size, worst.limit, Unit::of_derivative(joint.kind, worst.order));
    if worst.limit > 0.0 {
        finding = finding.by_share().slower(worst.order);
    }
    let class = CLASS_NAMES[worst.order];
    let note = match (worst.order, share) {
        (2, Some(share)) => format!(
            "{class}: {count} steps of acceleration, impulses of jerk, which may be {share} times the \
             acceleration limit"
        ),
        (2, None) => {
            format!(
                "{class}: the acceleration steps, an impulse of jerk; {count} in all, and none is declared"
            )
        }
        _ => format!("{class}: the {quantity} jumps, {count} jumps in all"),
    };
    if !finding.passes {
        finding.violated = Some([worst.time, worst.time]);
    }
    Ok(finding.at(worst.time).of([joint.name.as_str()]).during(evidence.phase_name(worst.time)).noted(note))
}

/// By how many times the joint's acceleration limit an acceleration may step; none when it must not.
fn step_share(evidence: &Evidence<'_>) -> Option<f64> {
    let by_nature = evidence.resolved.task.steps_acceleration().then_some(LARGEST_STEP);
    evidence.resolved.checks.acceleration_step.or(by_nature)
}

/// Where an acceleration steps the most, as a share of the joint's limit: the size of an impulse of jerk.
pub(super) fn largest_acceleration_step(evidence: &Evidence<'_>) -> Option<Jump> {
    let steps = jumps(evidence).into_iter().filter(|jump| jump.order == 2);
    worst_by(steps, |step| step.size / evidence.joints()[step.joint].limits.acceleration)
}

/// All jumps, inside the motion and at its ends.
fn jumps(evidence: &Evidence<'_>) -> Vec<Jump> {
    let trajectory = &evidence.plan.trajectory;
    let share = step_share(evidence);
    let mut found = Vec::new();
    let mut enter = |joint: usize, time: f64, order: usize, jump: f64| {
        // A NaN is a jump too.
        let tolerance = SMOOTH_TOLERANCE * trajectory.peak(joint, order).value.abs().max(1.0);
        if jump.abs() <= tolerance {
            return;
        }
        let limit = match share {
            Some(share) if order == 2 => share * evidence.joints()[joint].limits.acceleration,
            _ => 0.0,
        };
        found.push(Jump { joint, time, order, size: jump.abs(), limit });
    };
    let last = trajectory.piece_count() - 1;
    let length = trajectory.knots()[last + 1] - trajectory.knots()[last];
    for joint in 0..trajectory.dof() {
        // Before the plan and after it every joint is at rest.
        let [_, velocity, acceleration, _] = trajectory.piece(0, joint).eval(0.0);
        enter(joint, 0.0, 1, velocity);
        enter(joint, 0.0, 2, acceleration);
        let [_, velocity, acceleration, _] = trajectory.piece(last, joint).eval(length);
        enter(joint, trajectory.duration(), 1, -velocity);
        enter(joint, trajectory.duration(), 2, -acceleration);
    }
    for at in trajectory.breaks() {
        for (joint, jump) in at.jump.iter().enumerate() {
            enter(joint, trajectory.knots()[at.knot], at.order, *jump);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use graspcheck_motion::{Polynomial, Trajectory};

    use crate::{
        Outcome, Unit,
        fixture::{self, Run, rest_to_rest},
    };

    /// The pick with its first two phases, 1 s each, replaced for the joint `lift`.
    fn with_lift(first: Polynomial, second: Polynomial) -> Run {
        let mut run = fixture::pick();
        let old = &run.plan.trajectory;
        let mut pieces: Vec<Polynomial> =
            (0..old.piece_count()).flat_map(|k| old.piece_of_all(k).to_vec()).collect();
        (pieces[0], pieces[2]) = (first, second);
        run.plan.trajectory = Trajectory::new(2, old.knots().to_vec(), pieces).unwrap();
        run
    }

    #[test]
    fn a_smooth_plan_passes_with_no_jump() {
        let result = fixture::pick().check("planned.continuity");
        assert_eq!((result.outcome, result.value, result.margin), (Outcome::Pass, Some(0.0), Some(0.0)));
    }

    #[test]
    fn a_jump_of_position_fails_with_size_and_time() {
        let result =
            with_lift(rest_to_rest(0.2, 0.1, 1.0), rest_to_rest(0.13, 0.02, 1.0)).check("planned.continuity");
        assert_eq!((result.outcome, result.unit), (Outcome::Fail, Unit::Meter));
        assert!((result.value.unwrap() - 0.03).abs() < 1e-12);
        assert_eq!((result.time, result.violated), (Some(1.0), Some([1.0, 1.0])));
        assert_eq!(result.place.subjects, ["lift"]);
    }

    #[test]
    fn a_jump_of_velocity_fails() {
        let first = Polynomial::quintic_hermite([0.2, 0.0, 0.0], [0.1, -0.3, 0.0], 1.0);
        let result = with_lift(first, rest_to_rest(0.1, 0.02, 1.0)).check("planned.continuity");
        assert_eq!((result.outcome, result.unit), (Outcome::Fail, Unit::MeterPerSecond));
        assert!((result.value.unwrap() - 0.3).abs() < 1e-12);
    }

    #[test]
    fn a_step_of_acceleration_fails_where_none_is_declared() {
        let first = Polynomial::quintic_hermite([0.2, 0.0, 0.0], [0.1, 0.0, 0.5], 1.0);
        let result = with_lift(first, rest_to_rest(0.1, 0.02, 1.0)).check("planned.continuity");
        assert_eq!((result.outcome, result.unit), (Outcome::Fail, Unit::MeterPerSecond2));
        assert!(result.note.to_string().contains("impulse of jerk"), "{}", result.note);
    }

    #[test]
    fn a_declared_step_is_held_against_its_own_limit() {
        // A step of 0.5 m/s² where the joint may accelerate by some limit: 0.4 and 0.6 of it.
        let first = Polynomial::quintic_hermite([0.2, 0.0, 0.0], [0.1, 0.0, 0.5], 1.0);
        let mut run = with_lift(first, rest_to_rest(0.1, 0.02, 1.0));
        run.resolved.robot.joints[0].limits.acceleration = 1.0;
        for (share, outcome) in [(0.6, Outcome::Pass), (0.4, Outcome::Fail)] {
            run.resolved.checks.acceleration_step = Some(share);
            let result = run.check("planned.continuity");
            assert_eq!((result.outcome, result.limit), (outcome, Some(share)), "{result:?}");
            assert!((result.value.unwrap() - 0.5).abs() < 1e-9);
            assert!(result.note.to_string().contains("class C1"), "{}", result.note);
        }
        // A step goes as 1/k².
        let stretch = run.check("planned.continuity").stretch.unwrap();
        assert!((stretch * stretch - 0.5 / 0.4).abs() < 1e-9, "{stretch}");
    }

    #[test]
    fn a_plan_that_begins_or_ends_in_motion_jumps_there() {
        let begins = Polynomial::quintic_hermite([0.2, 0.1, 0.0], [0.1, 0.0, 0.0], 1.0);
        let result = with_lift(begins, rest_to_rest(0.1, 0.02, 1.0)).check("planned.continuity");
        assert_eq!((result.outcome, result.time), (Outcome::Fail, Some(0.0)));

        let mut run = fixture::pick();
        let old = &run.plan.trajectory;
        let mut pieces: Vec<Polynomial> =
            (0..old.piece_count()).flat_map(|k| old.piece_of_all(k).to_vec()).collect();
        let last = pieces.len() - 2;
        pieces[last] = Polynomial::quintic_hermite([0.02, 0.0, 0.0], [0.15, 0.2, 0.0], 1.0);
        run.plan.trajectory = Trajectory::new(2, old.knots().to_vec(), pieces).unwrap();
        let result = run.check("planned.continuity");
        assert_eq!((result.outcome, result.unit), (Outcome::Fail, Unit::MeterPerSecond));
        assert_eq!(result.time, Some(run.plan.duration()));
    }

    #[test]
    fn parabolic_blends_may_step_by_twice_the_acceleration_limit_and_no_more() {
        // Steps of 1 rad/s² at both ends of both blends.
        let mut run = fixture::blends();
        run.resolved.robot.joints[0].limits.acceleration = 0.5;
        let result = run.check("planned.continuity");
        assert_eq!((result.outcome, result.value, result.limit), (Outcome::Pass, Some(1.0), Some(1.0)));
        assert_eq!((result.margin, result.margin_is_share), (Some(0.0), true));
        assert_eq!(result.unit, Unit::RadianPerSecond2);

        run.resolved.robot.joints[0].limits.acceleration = 0.49;
        assert_eq!(run.check("planned.continuity").outcome, Outcome::Fail);
    }
}
