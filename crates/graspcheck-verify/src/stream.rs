//! Streams of a recording as checks read them: there, evenly timed, finite, over the whole plan.

use std::{collections::BTreeMap, ops::RangeInclusive};

use graspcheck_model::Pose;
use graspcheck_recording::{ContactSample, JointSeries, PoseSeries};
use nalgebra::{Quaternion, Translation3, UnitQuaternion, Vector3};

use crate::{
    evidence::{Evidence, NOT_EXECUTED},
    finding::Gap,
};

/// How far the length of a quaternion in a recording may be from 1: rounding of a product of rotations.
const UNIT_TOLERANCE: f64 = 1e-6;

/// How far two samples may be from one step apart, ns: times are rounded to a nanosecond.
const TIME_ROUNDING_NS: i64 = 1;

/// States of some joints over time.
pub(crate) struct JointStream<'a> {
    series: &'a JointSeries,
    /// Column of each joint.
    columns: Vec<usize>,
}

/// One row of a [`JointStream`] for one joint.
pub(crate) struct JointSample {
    /// Index of the joint: from base to tool, or of the finger.
    pub(crate) joint: usize,
    /// s.
    pub(crate) time: f64,
    pub(crate) position: f64,
    pub(crate) velocity: f64,
    pub(crate) effort: f64,
}

impl<'a> JointStream<'a> {
    /// Joint states that the robot measured, with the efforts that were applied.
    pub(crate) fn measured(evidence: &Evidence<'a>) -> Result<Self, Gap> {
        Self::new("measured", &evidence.recording.measured, &arm(evidence), evidence)
    }

    /// Joint states of the two fingers as measured; their index is that of the finger.
    pub(crate) fn measured_fingers(evidence: &Evidence<'a>) -> Result<Self, Gap> {
        let fingers = evidence.resolved.robot.gripper.fingers.each_ref();
        Self::new(
            "measured",
            &evidence.recording.measured,
            &fingers.map(|finger| finger.joint.as_str()),
            evidence,
        )
    }

    /// Joint states that were commanded, with the efforts that were asked for before they were limited.
    pub(crate) fn commanded(evidence: &Evidence<'a>) -> Result<Self, Gap> {
        Self::new("reference", &evidence.recording.reference, &arm(evidence), evidence)
    }

    /// What was commanded of the two fingers.
    pub(crate) fn commanded_fingers(evidence: &Evidence<'a>) -> Result<Self, Gap> {
        let fingers = evidence.resolved.robot.gripper.fingers.each_ref();
        let names = fingers.map(|finger| finger.joint.as_str());
        Self::new("reference", &evidence.recording.reference, &names, evidence)
    }

    fn new(
        stream: &'static str,
        series: &'a JointSeries,
        joints: &[&str],
        evidence: &Evidence<'_>,
    ) -> Result<Self, Gap> {
        timed(stream, &series.time_ns, evidence)?;
        let columns = joints
            .iter()
            .map(|joint| {
                series.names.iter().position(|name| name == joint).ok_or_else(|| {
                    Gap::inconclusive(None, format!("stream {stream} has no column for joint {joint}"))
                })
            })
            .collect::<Result<_, _>>()?;
        // Fingers count too: a simulation with one number that is not finite is not to be trusted.
        for (quantity, values) in
            [("position", &series.position), ("velocity", &series.velocity), ("effort", &series.effort)]
        {
            if let Some(index) = values.iter().position(|value| !value.is_finite()) {
                let (row, column) = (index / series.names.len(), index % series.names.len());
                let what = format!("{quantity} of joint {}", series.names[column]);
                return Err(not_finite(stream, &what, values[index], seconds(series.time_ns[row])));
            }
        }
        Ok(Self { series, columns })
    }

    /// Positions of a joint, row by row.
    pub(crate) fn positions(&self, joint: usize) -> impl Iterator<Item = f64> + '_ {
        self.column(&self.series.position, joint)
    }

    /// Velocities of a joint, row by row.
    pub(crate) fn velocities(&self, joint: usize) -> impl Iterator<Item = f64> + '_ {
        self.column(&self.series.velocity, joint)
    }

    /// Efforts of a joint, row by row.
    pub(crate) fn efforts(&self, joint: usize) -> impl Iterator<Item = f64> + '_ {
        self.column(&self.series.effort, joint)
    }

    fn column<'c>(&self, values: &'c [f64], joint: usize) -> impl Iterator<Item = f64> + 'c {
        values.iter().skip(self.columns[joint]).step_by(self.series.names.len()).copied()
    }

    /// The times of the rows, ns.
    pub(crate) fn times(&self) -> &'a [i64] {
        &self.series.time_ns
    }

    /// All samples, in order of time and then of joints.
    pub(crate) fn samples(&self) -> impl Iterator<Item = JointSample> + '_ {
        (0..self.series.len()).flat_map(move |row| {
            self.columns.iter().enumerate().map(move |(joint, &column)| JointSample {
                joint,
                time: seconds(self.series.time_ns[row]),
                position: self.series.position_row(row)[column],
                velocity: self.series.velocity_row(row)[column],
                effort: self.series.effort_row(row)[column],
            })
        })
    }
}

/// The names of the arm's joints, base to tool.
fn arm<'e>(evidence: &'e Evidence<'_>) -> Vec<&'e str> {
    evidence.joints().iter().map(|joint| joint.name.as_str()).collect()
}

/// A pose and its twist at an instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PoseSample {
    /// ns.
    pub(crate) time_ns: i64,
    pub(crate) world_from_body: Pose,
    /// In the world, m/s.
    pub(crate) linear: Vector3<f64>,
    /// In the world, rad/s.
    pub(crate) angular: Vector3<f64>,
}

impl PoseSample {
    /// s.
    pub(crate) fn time(&self) -> f64 {
        seconds(self.time_ns)
    }
}

/// Measured poses of the tool frame.
pub(crate) fn tool(evidence: &Evidence<'_>) -> Result<Vec<PoseSample>, Gap> {
    poses("tool", &evidence.recording.tool, evidence)
}

/// Commanded poses of the tool frame.
pub(crate) fn reference_tool(evidence: &Evidence<'_>) -> Result<Vec<PoseSample>, Gap> {
    poses("reference_tool", &evidence.recording.reference_tool, evidence)
}

/// Measured poses of the object.
pub(crate) fn object(evidence: &Evidence<'_>) -> Result<Vec<PoseSample>, Gap> {
    poses("object", &evidence.recording.object, evidence)
}

fn poses(stream: &'static str, series: &PoseSeries, evidence: &Evidence<'_>) -> Result<Vec<PoseSample>, Gap> {
    timed(stream, &series.time_ns, evidence)?;
    if series.frame != "world" {
        let note = format!("stream {stream} is in the frame `{}`, not in `world`", series.frame);
        return Err(Gap::inconclusive(None, note));
    }
    let rows = series.time_ns.iter().zip(&series.pose).zip(&series.twist);
    rows.map(|((&time_ns, pose), twist)| {
        let broken = |what: &str, value: f64| not_finite(stream, what, value, seconds(time_ns));
        if let Some(value) = pose.iter().find(|value| !value.is_finite()) {
            return Err(broken("pose", *value));
        }
        if let Some(value) = twist.iter().find(|value| !value.is_finite()) {
            return Err(broken("twist", *value));
        }
        let [x, y, z, qx, qy, qz, qw] = *pose;
        let quaternion = Quaternion::new(qw, qx, qy, qz);
        if (quaternion.norm() - 1.0).abs() > UNIT_TOLERANCE {
            return Err(broken("length of the quaternion, which must be 1,", quaternion.norm()));
        }
        Ok(PoseSample {
            time_ns,
            world_from_body: Pose::from_parts(
                Translation3::new(x, y, z),
                UnitQuaternion::from_quaternion(quaternion),
            ),
            linear: Vector3::new(twist[0], twist[1], twist[2]),
            angular: Vector3::new(twist[3], twist[4], twist[5]),
        })
    })
    .collect()
}

/// The contacts of an executed plan. There may be none: whether some are missing is for
/// [`contacts_are_all_there`] to tell.
pub(crate) fn contacts<'a>(evidence: &Evidence<'a>) -> Result<&'a [ContactSample], Gap> {
    timed("measured", &evidence.recording.measured.time_ns, evidence)?;
    let contacts = &evidence.recording.contacts;
    for contact in contacts {
        for (quantity, value) in [("depth", contact.depth_m), ("force", contact.normal_force_n)] {
            if !value.is_finite() {
                let what = format!("{quantity} between {} and {}", contact.body_a, contact.body_b);
                return Err(not_finite("contacts", &what, value, seconds(contact.time_ns)));
            }
        }
    }
    Ok(contacts)
}

/// Whether every contact of the steps in `window`, s, is there: the monitor says how many each step had.
pub(crate) fn contacts_are_all_there(
    evidence: &Evidence<'_>,
    window: RangeInclusive<f64>,
) -> Result<(), Gap> {
    let monitor = &evidence.recording.monitor;
    let times: Vec<i64> = monitor.iter().map(|sample| sample.time_ns).collect();
    timed("monitor", &times, evidence)?;
    let mut there: BTreeMap<i64, u32> = times.into_iter().map(|time_ns| (time_ns, 0)).collect();
    for contact in &evidence.recording.contacts {
        *there.entry(contact.time_ns).or_default() += 1;
    }
    let promised: BTreeMap<i64, u32> =
        monitor.iter().map(|sample| (sample.time_ns, sample.contacts)).collect();
    for (time_ns, count) in there.into_iter().filter(|(time_ns, _)| window.contains(&seconds(*time_ns))) {
        let promised = promised.get(&time_ns).copied().unwrap_or(0);
        if count != promised {
            let time = seconds(time_ns);
            let note =
                format!("stream contacts has {count} rows at t = {time} s, the monitor says {promised}");
            return Err(Gap::inconclusive(Some(time), note));
        }
    }
    Ok(())
}

/// Whether the run was asked to execute the plan.
pub(crate) fn requested(evidence: &Evidence<'_>) -> Result<(), Gap> {
    match evidence.resolved.execution {
        Some(_) => Ok(()),
        None => Err(Gap::not_requested("the plan was not executed")),
    }
}

/// Whether a stream is there, begins with the plan, goes on step by step, and lasts until the plan's end.
pub(crate) fn timed(stream: &'static str, time_ns: &[i64], evidence: &Evidence<'_>) -> Result<(), Gap> {
    let Some(execution) = &evidence.resolved.execution else {
        return requested(evidence);
    };
    let (Some(&first), Some(&last)) = (time_ns.first(), time_ns.last()) else {
        let note = match evidence.recording.metadata.get(NOT_EXECUTED) {
            Some(reason) => format!("the plan was not executed: {reason}"),
            None => format!("stream {stream} is empty, though the plan was executed"),
        };
        return Err(Gap::inconclusive(None, note));
    };
    let step_ns = execution.dt * 1e9;
    if !(0..=step_ns.ceil() as i64).contains(&first) {
        let note = format!("stream {stream} begins at {} s, not with the plan", seconds(first));
        return Err(Gap::inconclusive(Some(0.0), note));
    }
    for pair in time_ns.windows(2) {
        // A difference that does not fit, as of times made up to do harm, is not a step.
        let step = pair[1].checked_sub(pair[0]).map_or(f64::INFINITY, |step| step as f64);
        if (step - step_ns).abs() > TIME_ROUNDING_NS as f64 {
            let (before, after) = (seconds(pair[0]), seconds(pair[1]));
            let note = format!(
                "stream {stream} goes from {before} s to {after} s, which is not a step of {} s",
                execution.dt
            );
            return Err(Gap::inconclusive(Some(before), note));
        }
    }
    let end = evidence.plan.duration() + execution.settle;
    if seconds(last) < end - execution.dt {
        let note = format!("stream {stream} ends at {} s, before the run does at {end} s", seconds(last));
        return Err(Gap::inconclusive(Some(seconds(last)), note));
    }
    Ok(())
}

/// The time in s.
pub(crate) fn seconds(time_ns: i64) -> f64 {
    time_ns as f64 / 1e9
}

fn not_finite(stream: &'static str, what: &str, value: f64, time: f64) -> Gap {
    Gap::Broken { time, note: format!("stream {stream}: {what} is {value} at t = {time} s").into() }
}
