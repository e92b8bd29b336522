//! How a motion comes to rest: overshoot, settling, cycle time.

use super::{Metric, Motion, of_joints};
use crate::{evidence::Evidence, verdict::Unit};

/// The tool has settled within this distance of where it is commanded, m: what assembly by robots asks for.
pub const BAND: f64 = 1e-4;

/// A joint that moves less than this in the plan, rad or m, has no last direction.
const STILL: f64 = 1e-9;

/// Overshoot of every joint, settling of the tool, and the cycle time. What does not settle has neither of the latter.
pub(super) fn settling(evidence: &Evidence, motion: &Motion) -> Vec<Metric> {
    let end = evidence.plan.duration();
    let after = motion.tool.partition_point(|sample| sample.time() < end);
    let unit = |kind| Unit::of_derivative(kind, 0);
    let mut all = of_joints(evidence, "executed.overshoot", unit, |joint| {
        let goal = evidence.plan.trajectory.eval(evidence.plan.trajectory.duration()).q[joint];
        let direction = last_direction(&motion.commanded[joint].position[..after]);
        let beyond = motion.measured[joint].position[after..].iter().map(|q| direction * (q - goal));
        beyond.fold(0.0, f64::max)
    });
    let outside = |k: &usize| {
        let [tool, commanded] = [&motion.tool[*k], &motion.commanded_tool[*k]];
        (tool.world_from_body.translation.vector - commanded.world_from_body.translation.vector).norm() > BAND
    };
    let steps = motion.tool.len();
    let settled = match (after..steps).rev().find(outside) {
        None => Some(0.0),
        // Outside to the last: it may settle later, or never.
        Some(last) if last + 1 == steps => None,
        Some(last) => Some(motion.tool[last + 1].time() - end),
    };
    if let Some(settling) = settled {
        for (name, value) in [("executed.settling", settling), ("executed.cycle", end + settling)] {
            all.push(Metric { name, subject: None, value, unit: Unit::Second });
        }
    }
    all
}

/// 1 where the position grew last, -1 where it fell; 0 where it never moved.
fn last_direction(positions: &[f64]) -> f64 {
    let steps = positions.windows(2).rev().map(|pair| pair[1] - pair[0]);
    steps.into_iter().find(|step| step.abs() > STILL).map_or(0.0, f64::signum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{fixture, metrics::metrics};

    /// The run goes on at rest for ten steps.
    fn resting() -> fixture::Run {
        let mut run = fixture::pick();
        run.resolved.execution.as_mut().unwrap().settle = 10.0 * fixture::DT;
        for _ in 0..10 {
            let recording = &mut run.recording;
            let last = recording.measured.time_ns[recording.measured.len() - 1] + fixture::ns_of(fixture::DT);
            for series in [&mut recording.measured, &mut recording.reference] {
                let width = series.names.len();
                series.time_ns.push(last);
                for values in [&mut series.position, &mut series.velocity, &mut series.effort] {
                    values.extend_from_within(values.len() - width..);
                }
            }
            for series in [&mut recording.tool, &mut recording.reference_tool] {
                series.time_ns.push(last);
                series.pose.extend_from_within(series.pose.len() - 1..);
                series.twist.extend_from_within(series.twist.len() - 1..);
            }
        }
        run
    }

    #[test]
    fn a_motion_that_swings_out_overshoots_and_settles_late() {
        let mut run = resting();
        let rows = run.rows_from(run.plan.duration());
        // The tool is 1 mm off for the first four steps after the end; joint 1 goes beyond its goal by 0.02.
        let (first, width) = (rows.start, run.recording.measured.names.len());
        for row in first..first + 4 {
            run.recording.tool.pose[row][0] += 1e-3;
        }
        let joint = 1;
        let position = &mut run.recording.measured.position[(first + 2) * width + joint];
        let before = run.recording.reference.position[(first - 40) * width + joint];
        *position += 0.02 * (*position - before).signum();
        let recording = run.written();
        let metrics = metrics(&Evidence::from_recording(&recording).unwrap());
        let of = |name: &str, subject: Option<&str>| {
            metrics.all.iter().find(|it| it.name == name && it.subject.as_deref() == subject).unwrap().value
        };
        assert!((of("executed.settling", None) - 4.0 * fixture::DT).abs() < 1e-6);
        let name = run.resolved.robot.joints[joint].name.clone();
        assert!((of("executed.overshoot", Some(&name)) - 0.02).abs() < 1e-9);
    }

    #[test]
    fn what_never_settles_has_no_settling_time() {
        let mut run = fixture::pick();
        for pose in &mut run.recording.tool.pose {
            pose[0] += 1e-3;
        }
        let recording = run.written();
        let metrics = metrics(&Evidence::from_recording(&recording).unwrap());
        assert!(metrics.all.iter().all(|metric| metric.name != "executed.settling"));
    }

    #[test]
    fn the_last_direction_is_that_of_the_last_step_that_moves() {
        let directions = [vec![0.0, 1.0, 0.5, 0.5], vec![2.0, 2.0], vec![], vec![0.0, 1e-3]];
        let found: Vec<i32> = directions.iter().map(|it| last_direction(it) as i32).collect();
        assert_eq!(found, [-1, 0, 0, 1]);
    }
}
