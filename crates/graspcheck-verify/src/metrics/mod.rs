//! Numbers about a motion: how smooth, how exact, how fast and how costly it is. They judge nothing; reports show them,
//! and comparisons of two runs are made of them.
//!
//! | metric | of | definition |
//! |---|---|---|
//! | `planned.duration` | plan | from the first to the last instant, s |
//! | `planned.jerk_peak`, `.jerk_rms` | joint | largest magnitude, and √(1/T ∫ j² dt), exact |
//! | `executed.jerk_peak`, `.jerk_rms` | joint | the same of the measured motion: second derivative of the measured velocity by a parabola fitted to [`jerk::HALF_WINDOW`] samples on both sides (Savitzky and Golay, *Analytical Chemistry* 36, 1964) |
//! | `executed.joint_error_max`, `.joint_error_rms` | joint | measured less commanded position at equal times |
//! | `executed.tool_error_max`, `.tool_error_rms` | tool | distance of the measured from the commanded tool at equal times |
//! | `executed.path_error_max` | tool | distance of the measured tool from the commanded *path*, whenever the command is there; after ISO 9283, path accuracy |
//! | `executed.overshoot` | joint | how far a joint goes beyond its goal in its last direction of motion, after the plan has ended |
//! | `executed.settling` | tool | how long after the plan's end the tool comes into [`settling::BAND`] of where it is commanded, and stays; none when it does not |
//! | `executed.cycle` | run | duration of the plan and settling |
//! | `executed.effort_rms` | joint | √(1/T ∫ τ² dt), what heats a motor |
//! | `executed.energy` | run | ∫ Σ max(τ q̇, 0) dt: mechanical work of drives that do not recover any |
//!
//! Integrals over samples are by the trapezoidal rule. What repetitions of a motion have in common is in [`iso9283`].

pub mod effort;
pub mod iso9283;
pub mod jerk;
pub mod settling;
pub mod tracking;

use crate::{evidence::Evidence, finding::Gap, note::Note, stream, verdict::Unit};

/// One number about a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Metric {
    /// Stable name, e.g. `executed.jerk_rms`.
    pub name: &'static str,
    /// The joint it is about; none for tool and run.
    pub subject: Option<String>,
    /// In `unit`.
    pub value: f64,
    /// SI unit.
    pub unit: Unit,
}

/// The numbers about a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Metrics {
    /// In a fixed order: of the plan, then of the execution.
    pub all: Vec<Metric>,
    /// Why there are none of the execution; none when there are.
    pub unmeasured: Option<Note>,
}

/// All metrics of a run. Of an execution that was not asked for, or whose streams are incomplete or not finite,
/// there are none, and it is said why.
#[must_use]
pub fn metrics(evidence: &Evidence) -> Metrics {
    let mut all = vec![Metric {
        name: "planned.duration",
        subject: None,
        value: evidence.plan.duration(),
        unit: Unit::Second,
    }];
    all.extend(jerk::planned(evidence));
    match executed(evidence) {
        Ok(executed) => {
            all.extend(executed);
            Metrics { all, unmeasured: None }
        }
        Err(Gap::NotRequested(note) | Gap::Inconclusive { note, .. } | Gap::Broken { note, .. }) => {
            Metrics { all, unmeasured: Some(note) }
        }
    }
}

fn executed(evidence: &Evidence) -> Result<Vec<Metric>, Gap> {
    let motion = Motion::of(evidence)?;
    let mut all = jerk::executed(evidence, &motion);
    all.extend(tracking::joints(evidence, &motion));
    all.extend(tracking::tool(&motion));
    all.extend(settling::settling(evidence, &motion));
    all.extend(effort::effort(evidence, &motion));
    Ok(all)
}

/// The streams that metrics read: complete, finite, of one length.
struct Motion {
    /// Step, s.
    dt: f64,
    /// Of each joint of the arm, one value a step.
    measured: Vec<Samples>,
    commanded: Vec<Samples>,
    tool: Vec<stream::PoseSample>,
    commanded_tool: Vec<stream::PoseSample>,
}

/// The state of a joint, one value a step.
#[derive(Default)]
struct Samples {
    position: Vec<f64>,
    velocity: Vec<f64>,
    effort: Vec<f64>,
}

impl Motion {
    fn of(evidence: &Evidence) -> Result<Self, Gap> {
        stream::requested(evidence)?;
        let dt = evidence.resolved.execution.as_ref().map_or(f64::NAN, |execution| execution.dt);
        let columns = |stream: &stream::JointStream| {
            let mut joints: Vec<Samples> = Vec::new();
            joints.resize_with(evidence.joints().len(), Samples::default);
            for sample in stream.samples() {
                let joint = &mut joints[sample.joint];
                joint.position.push(sample.position);
                joint.velocity.push(sample.velocity);
                joint.effort.push(sample.effort);
            }
            joints
        };
        let motion = Self {
            dt,
            measured: columns(&stream::JointStream::measured(evidence)?),
            commanded: columns(&stream::JointStream::commanded(evidence)?),
            tool: stream::tool(evidence)?,
            commanded_tool: stream::reference_tool(evidence)?,
        };
        let steps = motion.tool.len();
        let lengths = motion.measured.iter().chain(&motion.commanded).map(|samples| samples.position.len());
        if lengths.chain([motion.commanded_tool.len()]).any(|length| length != steps) {
            return Err(Gap::inconclusive(None, "the streams have different numbers of rows"));
        }
        Ok(motion)
    }
}

/// A metric for each joint of the arm, in order.
fn of_joints(
    evidence: &Evidence,
    name: &'static str,
    unit: impl Fn(graspcheck_model::robot::JointKind) -> Unit,
    value: impl Fn(usize) -> f64,
) -> Vec<Metric> {
    let joints = evidence.joints().iter().enumerate();
    joints
        .map(|(index, joint)| Metric {
            name,
            subject: Some(joint.name.clone()),
            value: value(index),
            unit: unit(joint.kind),
        })
        .collect()
}

/// The largest magnitude; 0 of nothing.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |most, value| f64::max(most, value.abs()))
}

/// The root of the mean of squares over time, of values at equal steps, by the trapezoidal rule.
fn rms(values: &[f64]) -> f64 {
    match values {
        [] => 0.0,
        [only] => only.abs(),
        [first, .., last] => {
            let sum: f64 = values.iter().map(|value| value * value).sum();
            let inner = sum - 0.5 * (first * first + last * last);
            (inner.max(0.0) / (values.len() - 1) as f64).sqrt()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;

    fn of(run: &fixture::Run) -> Metrics {
        let recording = run.written();
        metrics(&Evidence::from_recording(&recording).unwrap())
    }

    fn value(metrics: &Metrics, name: &str, subject: Option<&str>) -> f64 {
        let found = metrics.all.iter().find(|it| it.name == name && it.subject.as_deref() == subject);
        found.unwrap_or_else(|| panic!("no {name} of {subject:?}: {metrics:?}")).value
    }

    #[test]
    fn a_perfect_execution_has_no_errors_and_the_jerk_of_the_plan() {
        let run = fixture::pick();
        let metrics = of(&run);
        assert_eq!(metrics.unmeasured, None);
        for name in ["executed.tool_error_max", "executed.path_error_max", "executed.settling"] {
            assert!(value(&metrics, name, None).abs() < 1e-9, "{name}");
        }
        for joint in run.resolved.robot.joints.iter().map(|joint| joint.name.as_str()) {
            let [planned, executed] =
                ["planned.jerk_rms", "executed.jerk_rms"].map(|name| value(&metrics, name, Some(joint)));
            // Eleven samples at 10 ms smear what changes in a tenth of a second.
            assert!((executed - planned).abs() < 0.2 * planned + 1e-9, "{joint}: {planned}, {executed}");
            assert!(value(&metrics, "executed.overshoot", Some(joint)).abs() < 1e-9);
        }
        assert!((value(&metrics, "executed.cycle", None) - run.plan.duration()).abs() < 1e-9);
    }

    #[test]
    fn a_plan_alone_has_metrics_of_the_plan_and_says_why() {
        let mut run = fixture::pick();
        run.resolved.execution = None;
        let metrics = of(&run);
        assert!(metrics.all.iter().all(|metric| metric.name.starts_with("planned.")));
        assert!(metrics.unmeasured.is_some());
    }

    #[test]
    fn what_is_late_is_off_in_time_and_not_off_the_path() {
        let mut run = fixture::pick();
        // The tool is where it was commanded to be five samples ago.
        let commanded = run.recording.reference_tool.pose.clone();
        for (k, pose) in run.recording.tool.pose.iter_mut().enumerate() {
            *pose = commanded[k.saturating_sub(5)];
        }
        let metrics = of(&run);
        assert!(value(&metrics, "executed.tool_error_max", None) > 1e-3);
        assert!(value(&metrics, "executed.path_error_max", None) < 1e-12);
    }

    #[test]
    fn the_root_mean_square_of_a_sine_is_its_amplitude_by_the_root_of_two() {
        let sine: Vec<f64> =
            (0..=1000).map(|k| (f64::from(k) * 0.001 * std::f64::consts::TAU).sin()).collect();
        assert!((rms(&sine) - 0.5_f64.sqrt()).abs() < 1e-9);
    }
}
