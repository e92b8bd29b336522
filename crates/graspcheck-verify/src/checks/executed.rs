//! `executed.position`, `executed.velocity`, `executed.torque`, `executed.saturation`,
//! `executed.tracking`: what the simulated robot did, against the limits of its joints and against the plan.

use graspcheck_motion::MotionState;

use crate::{
    evidence::Evidence,
    finding::{Finding, Gap, worst_by},
    stream::{self, JointStream, seconds},
    verdict::Unit,
};

/// The measured position that is nearest to, or farthest beyond, a limit of its joint, rad or m.
pub(super) fn position(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    let measured = JointStream::measured(evidence)?;
    let sides = measured.samples().flat_map(|sample| {
        let model = &evidence.joints()[sample.joint];
        let unit = Unit::of_derivative(model.kind, 0);
        [
            Finding::at_least(sample.position, model.limits.position_min, unit),
            Finding::at_most(sample.position, model.limits.position_max, unit),
        ]
        .map(|side| (sample.joint, side.at(sample.time)))
    });
    located(sides, evidence)
}

/// The measured velocity that uses the largest share of its joint's limit.
pub(super) fn velocity(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    let measured = JointStream::measured(evidence)?;
    let shares = measured.samples().map(|sample| {
        let model = &evidence.joints()[sample.joint];
        let unit = Unit::of_derivative(model.kind, 1);
        let share = Finding::at_most(sample.velocity.abs(), model.limits.velocity, unit).by_share();
        (sample.joint, share.at(sample.time))
    });
    located(shares, evidence)
}

/// The commanded effort, before it was limited, that uses the largest share of its joint's limit.
pub(super) fn torque(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    let commanded = JointStream::commanded(evidence)?;
    let shares = commanded.samples().map(|sample| {
        let model = &evidence.joints()[sample.joint];
        let share = Finding::at_most(sample.effort.abs(), model.limits.effort, Unit::of_effort(model.kind));
        (sample.joint, share.by_share().at(sample.time))
    });
    located(shares, evidence)
}

/// The worst of the samples, with joint, phase, and first and last violation of all joints.
fn located(samples: impl Iterator<Item = (usize, Finding)>, evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    let mut violated: Option<[f64; 2]> = None;
    let noted = samples.inspect(|(_, sample)| {
        if let (false, Some(time)) = (sample.passes, sample.time) {
            violated = Some(violated.map_or([time, time], |[first, _]| [first, time]));
        }
    });
    let (joint, mut worst) =
        worst_by(noted, |(_, sample)| -sample.margin).ok_or_else(|| Gap::inconclusive(None, "no sample"))?;
    worst.violated = violated;
    let phase = evidence.phase_name(worst.time.unwrap_or(0.0));
    Ok(worst.of([evidence.joints()[joint].name.as_str()]).during(phase))
}

/// How many steps asked a joint for more effort than its limit.
pub(super) fn saturation(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    stream::requested(evidence)?;
    let Some(limit) = evidence.resolved.checks.saturated_steps else {
        return Err(Gap::not_requested("the scenario sets no limit"));
    };
    let commanded = JointStream::commanded(evidence)?;
    let mut times: Vec<f64> = Vec::new();
    let mut joints: Vec<usize> = Vec::new();
    for sample in commanded.samples() {
        if sample.effort.abs() <= evidence.joints()[sample.joint].limits.effort {
            continue;
        }
        // Several joints of one step follow each other and count once.
        if times.last().is_none_or(|last| *last < sample.time) {
            times.push(sample.time);
        }
        if !joints.contains(&sample.joint) {
            joints.push(sample.joint);
        }
    }
    let mut finding = Finding::at_most(times.len() as f64, f64::from(limit), Unit::Steps);
    if let (Some(&first), Some(&last)) = (times.first(), times.last()) {
        joints.sort_unstable();
        finding = finding
            .at(first)
            .of(joints.into_iter().map(|joint| evidence.joints()[joint].name.as_str()))
            .during(evidence.phase_name(first));
        if !finding.passes {
            finding.violated = Some([first, last]);
        }
    }
    Ok(finding)
}

/// The largest distance between the measured tool and where the plan has it at the same time, m. The plan
/// is evaluated here, not taken from the recording's reference.
pub(super) fn tracking(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    stream::requested(evidence)?;
    let Some(limit) = evidence.resolved.checks.tracking else {
        return Err(Gap::not_requested("the scenario sets no limit"));
    };
    let robot = &evidence.resolved.robot;
    let mut planned = MotionState::zeros(robot.dof());
    let distances: Vec<(f64, f64)> = stream::tool(evidence)?
        .iter()
        .map(|tool| {
            evidence.plan.trajectory.eval_held(seconds(tool.time_ns), &mut planned);
            let world_from_planned = robot.world_from_tool(&planned.q);
            let apart = tool.world_from_body.translation.vector - world_from_planned.translation.vector;
            (tool.time(), apart.norm())
        })
        .collect();
    let finding = Finding::worst_at_most(&distances, limit, Unit::Meter)
        .ok_or_else(|| Gap::inconclusive(None, "no sample"))?;
    let phase = evidence.phase_name(finding.time.unwrap_or(0.0));
    Ok(finding.of(["tool"]).during(phase))
}

#[cfg(test)]
mod tests {
    use graspcheck_recording::JointSeries;

    use crate::{
        Outcome, Unit,
        fixture::{self, DT, Run},
    };

    /// Changes a run at a row.
    type Spoil = fn(&mut Run, usize);

    const STREAM_CHECKS: [&str; 5] = [
        "executed.position",
        "executed.velocity",
        "executed.torque",
        "executed.saturation",
        "executed.tracking",
    ];

    #[test]
    fn a_perfect_execution_passes_with_margins() {
        let run = fixture::pick();
        for name in STREAM_CHECKS {
            let result = run.check(name);
            assert_eq!(result.outcome, Outcome::Pass, "{result:?}");
            assert!(
                result.value.is_some() && result.margin.is_some_and(|margin| margin >= 0.0),
                "{result:?}"
            );
        }
        assert!(run.check("executed.tracking").value.unwrap() < 1e-12);
    }

    #[test]
    fn one_sample_beyond_a_limit_fails_with_joint_and_time() {
        let row = fixture::pick().rows_from(4.0).start;
        let spoil: [(&str, Spoil); 3] = [
            ("executed.position", |run, row| run.recording.measured.position[4 * row + 1] = -1.01),
            ("executed.velocity", |run, row| run.recording.measured.velocity[4 * row + 1] = -1.01),
            ("executed.torque", |run, row| run.recording.reference.effort[4 * row + 1] = -51.0),
        ];
        for (name, change) in spoil {
            let mut run = fixture::pick();
            change(&mut run, row);
            let result = run.check(name);
            assert_eq!((result.outcome, result.time), (Outcome::Fail, Some(4.0)), "{result:?}");
            assert_eq!(result.violated, Some([4.0, 4.0]));
            assert_eq!(result.place.subjects, ["turn"]);
            assert_eq!(result.place.phase.as_deref(), Some("carry"));
            assert!(result.margin.unwrap() < 0.0);
        }
    }

    #[test]
    fn efforts_are_newtons_on_a_prismatic_joint() {
        let result = fixture::pick().check("executed.torque");
        assert_eq!((result.unit, result.value), (Unit::Newton, Some(10.0)));
    }

    #[test]
    fn a_value_at_its_limit_holds() {
        let mut run = fixture::pick();
        run.recording.measured.velocity[40] = 1.0;
        run.recording.reference.effort[40] = 50.0;
        for name in ["executed.velocity", "executed.torque", "executed.saturation"] {
            assert_eq!(run.check(name).outcome, Outcome::Pass, "{name}");
        }
    }

    #[test]
    fn steps_with_a_limited_command_are_counted_once_each() {
        let mut run = fixture::pick();
        run.resolved.checks.saturated_steps = Some(1);
        // Both joints in one step.
        run.recording.reference.effort[400] = 60.0;
        run.recording.reference.effort[401] = 60.0;
        let result = run.check("executed.saturation");
        assert_eq!((result.outcome, result.value, result.unit), (Outcome::Pass, Some(1.0), Unit::Steps));
        assert_eq!(result.place.subjects, ["lift", "turn"]);
        run.recording.reference.effort[404] = -60.0;
        let result = run.check("executed.saturation");
        assert_eq!((result.outcome, result.value), (Outcome::Fail, Some(2.0)));
        assert_eq!(result.violated, Some([1.0, 1.01]));
    }

    #[test]
    fn a_tool_that_is_off_fails_for_as_long_as_it_is() {
        let mut run = fixture::pick();
        for row in run.rows_from(4.0).take(11) {
            run.recording.tool.pose[row][0] += 0.002;
        }
        let result = run.check("executed.tracking");
        assert_eq!(result.outcome, Outcome::Fail);
        assert!((result.value.unwrap() - 0.002).abs() < 1e-9);
        assert_eq!(result.violated, Some([4.0, 4.1]));
    }

    #[test]
    fn tracking_is_against_the_plan_and_not_against_a_recorded_reference() {
        let mut run = fixture::pick();
        for row in run.rows_from(0.0) {
            run.recording.tool.pose[row][0] += 0.002;
            run.recording.reference_tool.pose[row][0] += 0.002;
        }
        assert_eq!(run.check("executed.tracking").outcome, Outcome::Fail);
    }

    #[test]
    fn what_was_promised_and_is_not_there_is_undecided() {
        let mut run = fixture::pick();
        run.recording.measured = JointSeries::default();
        run.recording.reference = JointSeries::new(run.recording.reference.names);
        run.recording.tool = Default::default();
        for name in STREAM_CHECKS {
            let result = run.check(name);
            assert_eq!(result.outcome, Outcome::Inconclusive, "{result:?}");
            assert!(result.note.to_string().contains("is empty"), "{}", result.note);
        }
        let mut run = fixture::pick();
        run.recording.measured.names[0] = "another".into();
        assert_eq!(run.check("executed.position").outcome, Outcome::Inconclusive);
    }

    #[test]
    fn a_run_without_execution_is_not_asked() {
        let mut run = fixture::pick();
        run.resolved.execution = None;
        run.recording = Default::default();
        for name in STREAM_CHECKS {
            assert_eq!(run.check(name).outcome, Outcome::NotRequested);
        }
    }

    #[test]
    fn a_check_without_a_limit_is_not_asked() {
        let mut run = fixture::pick();
        run.resolved.checks = Default::default();
        assert_eq!(run.check("executed.tracking").outcome, Outcome::NotRequested);
        assert_eq!(run.check("executed.saturation").outcome, Outcome::NotRequested);
    }

    #[test]
    fn a_sample_that_is_not_finite_fails_with_its_time() {
        let spoil: [(&str, Spoil); 6] = [
            ("executed.position", |run, row| run.recording.measured.position[4 * row + 1] = f64::NAN),
            ("executed.velocity", |run, row| run.recording.measured.velocity[4 * row] = f64::INFINITY),
            ("executed.torque", |run, row| run.recording.reference.effort[4 * row] = f64::NAN),
            ("executed.saturation", |run, row| run.recording.reference.effort[4 * row] = f64::NAN),
            ("executed.tracking", |run, row| run.recording.tool.pose[row][2] = f64::NAN),
            ("executed.tracking", |run, row| run.recording.tool.pose[row][6] = 0.0),
        ];
        for (name, change) in spoil {
            let mut run = fixture::pick();
            change(&mut run, 50);
            let result = run.check(name);
            assert_eq!((result.outcome, result.time), (Outcome::Fail, Some(0.5)), "{result:?}");
            assert_eq!(result.value, None);
        }
    }

    #[test]
    fn a_hole_in_time_an_early_end_or_a_late_start_is_undecided_with_its_time() {
        let mut hole = fixture::pick();
        for row in hole.rows_from(2.0) {
            hole.recording.measured.time_ns[row] += fixture::ns_of(DT);
        }
        let result = hole.check("executed.velocity");
        assert_eq!((result.outcome, result.time), (Outcome::Inconclusive, Some(1.99)));

        let mut backwards = fixture::pick();
        backwards.recording.measured.time_ns[100] = i64::MIN;
        assert_eq!(backwards.check("executed.velocity").outcome, Outcome::Inconclusive);

        let mut short = fixture::pick();
        let series = &mut short.recording.measured;
        series.time_ns.truncate(200);
        for column in [&mut series.position, &mut series.velocity, &mut series.effort] {
            column.truncate(800);
        }
        let result = short.check("executed.velocity");
        assert_eq!((result.outcome, result.time), (Outcome::Inconclusive, Some(1.99)));

        let mut unsettled = fixture::pick();
        unsettled.resolved.execution.as_mut().unwrap().settle = 0.5;
        assert_eq!(unsettled.check("executed.velocity").outcome, Outcome::Inconclusive);

        let mut late = fixture::pick();
        for time_ns in &mut late.recording.measured.time_ns {
            *time_ns += fixture::ns_of(1.0);
        }
        assert_eq!(late.check("executed.velocity").outcome, Outcome::Inconclusive);
    }
}
