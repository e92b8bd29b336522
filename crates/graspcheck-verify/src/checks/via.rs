//! `planned.via`: how far the plan passes from the Cartesian points that it is asked to pass near.

use graspcheck_model::{robot::Family, task::Task};

use crate::{
    evidence::Evidence,
    finding::{Finding, Gap, worst_by},
    verdict::Unit,
};

/// The largest distance between a via point and the wrist at the point's time, m.
pub(super) fn via(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    let Task::CartesianVia(task) = &evidence.resolved.task else {
        return Err(Gap::not_requested("the task has no via points"));
    };
    let Some(limit) = evidence.resolved.checks.via_miss else {
        return Err(Gap::not_requested("the scenario sets no limit"));
    };
    let robot = &evidence.resolved.robot;
    if !matches!(robot.family, Family::PlanarRrr { .. }) {
        return Err(Gap::inconclusive(None, "only a planar arm has the wrist that via points are given for"));
    }
    let trajectory = &evidence.plan.trajectory;
    let mut misses = Vec::with_capacity(task.points.len());
    for point in &task.points {
        if !(0.0..=trajectory.duration()).contains(&point.t) {
            let note = format!(
                "the via point at {} s is outside the plan, which ends at {} s",
                point.t,
                trajectory.duration()
            );
            return Err(Gap::inconclusive(Some(point.t), note));
        }
        let base_from_wrist =
            robot.world_from_base.inverse() * robot.world_from_wrist(&trajectory.eval(point.t).q);
        let wrist = base_from_wrist.translation.vector.xy();
        misses.push((point.t, (wrist - point.wrist.coords).norm()));
    }
    let (time, miss) = worst_by(misses, |(_, miss)| *miss)
        .ok_or_else(|| Gap::inconclusive(None, "the task has no via point"))?;
    Ok(Finding::at_most(miss, limit, Unit::Meter).at(time).of(["wrist"]).during(evidence.phase_name(time)))
}

#[cfg(test)]
mod tests {
    use graspcheck_model::{robot::Family, task::Task};

    use crate::{
        Outcome,
        fixture::{self, Run},
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

    #[test]
    fn it_is_not_requested_without_via_points_or_without_a_limit() {
        assert_eq!(fixture::pick().check("planned.via").outcome, Outcome::NotRequested);
        let mut run = fixture::blends();
        run.resolved.checks.via_miss = None;
        assert_eq!(run.check("planned.via").outcome, Outcome::NotRequested);
    }
}
