//! `planned.via`: how far the plan passes from the points that it is asked to pass near.
//!
//! A Cartesian point is missed by the wrist and by the angle of the last link, a point of the joints by the tool: by
//! how far it is from where those joint positions put it, and how much it is turned against that.
//!
//! The times of the points are on the clock of the task. Where the pace asks for another duration of the motion, they
//! are stretched by the same factor, which follows from the task alone: nothing is believed of the plan.

use graspcheck_model::{
    inverse::PlanarWrist,
    robot::{Family, RobotModel},
    task::{CartesianVia, JointVia, Pace, Task},
    via::ViaLaw,
};

use crate::{
    evidence::Evidence,
    finding::{Finding, Gap, worst_by},
    verdict::Unit,
};

/// The only phase of a motion through points.
const PHASE: &str = "via";

/// Rounding of the time at which the last point is due, as a share of the plan.
const SAME_TIME: f64 = 1e-9;

/// The largest share of a limit by which a point is missed at its time: a distance (m) or an angle (rad).
pub(super) fn via(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    let resolved = &evidence.resolved;
    let (times, positions, law, subject) = match &resolved.task {
        Task::CartesianVia(CartesianVia { points, law, .. }) => {
            let times: Vec<f64> = points.iter().map(|point| point.t).collect();
            let positions = points.iter().map(|point| vec![point.wrist.x, point.wrist.y, point.theta]);
            (times, positions.collect::<Vec<_>>(), law, "wrist")
        }
        Task::JointVia(JointVia { points, law }) => {
            let times = points.iter().map(|point| point.t).collect();
            (times, points.iter().map(|point| point.q.clone()).collect(), law, "tool")
        }
        _ => return Err(Gap::not_requested("the task has no via points")),
    };
    let limits = [resolved.checks.via_miss, resolved.checks.via_miss_angle];
    if limits == [None, None] {
        return Err(Gap::not_requested("the scenario sets no limit"));
    }
    let robot = &resolved.robot;
    let is_wrist = matches!(resolved.task, Task::CartesianVia(_));
    if is_wrist && !matches!(robot.family, Family::PlanarRrr { .. }) {
        return Err(Gap::inconclusive(None, "only a planar arm has the wrist that via points are given for"));
    }
    let factor = stretch(&resolved.pace, law, &times, &positions);
    let trajectory = &evidence.plan.trajectory;
    let mut findings = Vec::with_capacity(2 * times.len());
    for (time, position) in times.iter().zip(&positions) {
        let due = time * factor;
        let end = trajectory.duration();
        if !(0.0..=end * (1.0 + SAME_TIME)).contains(&due) {
            let note = format!("the via point at {due} s is outside the plan, which ends at {end} s");
            return Err(Gap::inconclusive(Some(due), note));
        }
        let q = trajectory.eval(due.min(end)).q;
        let (distance, angle) =
            if is_wrist { wrist_miss(robot, &q, position)? } else { tool_miss(robot, &q, position)? };
        for (value, limit, unit) in [(distance, limits[0], Unit::Meter), (angle, limits[1], Unit::Radian)] {
            let Some(limit) = limit else { continue };
            findings.push(Finding::at_most(value, limit, unit).at(due));
        }
    }
    // A distance and an angle compare by their shares.
    let worst = worst_by(findings, |finding| finding.value / finding.limit)
        .ok_or_else(|| Gap::inconclusive(None, "the task has no via point"))?;
    let phase = evidence.phase_name(worst.time.unwrap_or(0.0));
    Ok(worst.of([subject]).during(phase))
}

/// What the pace multiplies all times by.
fn stretch(pace: &Pace, law: &ViaLaw, times: &[f64], positions: &[Vec<f64>]) -> f64 {
    let asked = pace.phases.iter().find(|phase| phase.phase == PHASE).and_then(|phase| phase.duration);
    let (Some(duration), Some(last)) = (asked, times.last()) else { return 1.0 };
    duration / (last + law.overrun(times, positions))
}

/// How far the wrist is from a point, m, and the last link from its angle, rad.
fn wrist_miss(robot: &RobotModel, q: &[f64], point: &[f64]) -> Result<(f64, f64), Gap> {
    let PlanarWrist { position, theta } =
        robot.planar_wrist(q).map_err(|bound| Gap::inconclusive(None, bound.to_string()))?;
    let turn = theta - point[2];
    let whole = std::f64::consts::TAU * (turn / std::f64::consts::TAU).round();
    Ok(((position.x - point[0]).hypot(position.y - point[1]), (turn - whole).abs()))
}

/// How far the tool is from where the joint positions of a point put it, m, and how much it is turned, rad.
fn tool_miss(robot: &RobotModel, q: &[f64], point: &[f64]) -> Result<(f64, f64), Gap> {
    if point.len() != robot.dof() {
        return Err(Gap::inconclusive(None, "a via point is one of another arm"));
    }
    let (found, wanted) = (robot.world_from_tool(q), robot.world_from_tool(point));
    let distance = (found.translation.vector - wanted.translation.vector).norm();
    Ok((distance, found.rotation.angle_to(&wanted.rotation)))
}

#[cfg(test)]
mod tests {
    use graspcheck_model::{
        robot::Family,
        task::{JointVia, JointViaPoint, PhasePace, Task},
        via::ViaLaw,
    };

    use crate::{
        Outcome,
        fixture::{self, Run},
        verdict::Unit,
    };

    fn blends_past(move_middle: f64) -> Run {
        let mut run = fixture::blends();
        let Task::CartesianVia(task) = &mut run.resolved.task else { panic!("the task has via points") };
        task.points[1].wrist.x += move_middle;
        run
    }

    #[test]
    fn points_that_are_met_pass_and_a_missed_one_fails_with_its_distance_and_time() {
        let met = blends_past(0.0).check("planned.via");
        assert_eq!(met.outcome, Outcome::Pass);
        assert!(met.value.unwrap() < 1e-12, "{met:?}");

        let missed = blends_past(0.0012).check("planned.via");
        assert_eq!((missed.outcome, missed.time), (Outcome::Fail, Some(1.5)));
        assert!((missed.value.unwrap() - 0.0012).abs() < 1e-12);

        assert_eq!(blends_past(0.0009).check("planned.via").outcome, Outcome::Pass);
    }

    #[test]
    fn a_point_after_the_end_or_an_arm_without_a_wrist_is_undecided() {
        let mut late = blends_past(0.0);
        let Task::CartesianVia(task) = &mut late.resolved.task else { panic!("the task has via points") };
        task.points[2].t = 3.5;
        assert_eq!(late.check("planned.via").outcome, Outcome::Inconclusive);

        let mut none = blends_past(0.0);
        let Task::CartesianVia(task) = &mut none.resolved.task else { panic!("the task has via points") };
        task.points.clear();
        assert_eq!(none.check("planned.via").outcome, Outcome::Inconclusive);

        let mut other = blends_past(0.0);
        other.resolved.robot.family = Family::General;
        assert_eq!(other.check("planned.via").outcome, Outcome::Inconclusive);
    }

    /// Points of the joints on the motion of [`fixture::blends`], the middle one moved by this at the shoulder, rad.
    fn of_joints(move_middle: f64) -> Run {
        let mut run = fixture::blends();
        let at = |t: f64| JointViaPoint { t, q: run.plan.trajectory.eval(t).q };
        let mut points = [0.0, 1.5, 3.0].map(at).to_vec();
        points[1].q[0] += move_middle;
        let law = ViaLaw::blends_of(1.0, points.len(), 3);
        run.resolved.task = Task::JointVia(JointVia { points, law });
        run.resolved.checks.via_miss_angle = Some(0.1);
        run
    }

    #[test]
    fn a_point_of_the_joints_is_missed_by_the_tool_and_by_its_turn() {
        assert_eq!(of_joints(0.0).check("planned.via").outcome, Outcome::Pass);
        let mut missed = of_joints(0.2);
        missed.resolved.checks.via_miss = Some(0.2);
        let missed = missed.check("planned.via");
        assert_eq!((missed.outcome, missed.unit, missed.time), (Outcome::Fail, Unit::Radian, Some(1.5)));
        assert!((missed.value.unwrap() - 0.2).abs() < 1e-12);
        let far = of_joints(0.2).check("planned.via");
        assert_eq!((far.outcome, far.unit), (Outcome::Fail, Unit::Meter));
        assert_eq!(far.place.subjects, ["tool"]);
    }

    #[test]
    fn times_are_stretched_with_the_motion() {
        let stretched = |mut run: Run, duration: f64| {
            let pace = PhasePace { phase: "via".into(), duration: Some(duration), ..PhasePace::default() };
            run.resolved.pace.phases = vec![pace];
            run.check("planned.via").outcome
        };
        // The motion lasts 3 s as it is: points asked for in half the time are elsewhere then.
        assert_eq!(stretched(of_joints(0.0), 3.0), Outcome::Pass);
        assert_eq!(stretched(of_joints(0.0), 1.5), Outcome::Fail);
        // The same points on a clock of twice the speed.
        let mut slow = of_joints(0.0);
        let Task::JointVia(task) = &mut slow.resolved.task else { panic!("the task has via points") };
        for point in &mut task.points {
            point.t *= 0.5;
        }
        assert_eq!(stretched(slow, 3.0), Outcome::Pass);
    }

    #[test]
    fn it_is_not_requested_without_via_points_or_without_a_limit() {
        assert_eq!(fixture::pick().check("planned.via").outcome, Outcome::NotRequested);
        let mut run = fixture::blends();
        run.resolved.checks.via_miss = None;
        assert_eq!(run.check("planned.via").outcome, Outcome::NotRequested);
    }
}
