//! What every recording must keep, whether it was made or read: one value a row, times in order, finite
//! numbers, names that are unique where they are looked up.

use std::collections::BTreeSet;

use crate::{JointSeries, MarkerShape, PoseSeries, Recording, RecordingError};

/// The latest time that a ROS 2 stamp (seconds as `int32`) can say, ns.
pub(crate) const LATEST_NS: i64 = (i32::MAX as i64 + 1) * 1_000_000_000 - 1;

/// The attachment that repeats [`Recording::verdict`] for tools that read attachments.
pub(crate) const VERDICT_ATTACHMENT: &str = "verdict.json";

/// Checks everything that a file could not hold or a reader could not trust.
///
/// # Errors
/// The first fault, in the order of the fields of [`Recording`].
pub(crate) fn validate(recording: &Recording) -> Result<(), RecordingError> {
    attachments(recording)?;
    joints("measured", &recording.measured)?;
    joints("reference", &recording.reference)?;
    poses("tool", &recording.tool)?;
    poses("reference_tool", &recording.reference_tool)?;
    poses("object", &recording.object)?;
    contacts(recording)?;
    monitor(recording)?;
    frames(recording)?;
    markers(recording)?;
    repeating_times("events", recording.events.iter().map(|event| event.time_ns))
}

fn attachments(recording: &Recording) -> Result<(), RecordingError> {
    let mut names = BTreeSet::new();
    for attachment in &recording.attachments {
        if attachment.name == VERDICT_ATTACHMENT {
            return Err(RecordingError::ReservedAttachment(VERDICT_ATTACHMENT));
        }
        if !names.insert(&attachment.name) {
            return Err(RecordingError::RepeatedAttachment(attachment.name.clone()));
        }
    }
    Ok(())
}

fn joints(name: &str, series: &JointSeries) -> Result<(), RecordingError> {
    let expected = series.time_ns.len() * series.names.len();
    let columns =
        [("position", &series.position), ("velocity", &series.velocity), ("effort", &series.effort)];
    for (column, values) in columns {
        length(name, column, values.len(), expected)?;
    }
    increasing_times(name, &series.time_ns)?;
    let width = series.names.len().max(1);
    for (column, values) in columns {
        for (row, values) in values.chunks(width).enumerate() {
            finite(name, row, column, values)?;
        }
    }
    Ok(())
}

fn poses(name: &str, series: &PoseSeries) -> Result<(), RecordingError> {
    length(name, "pose", series.pose.len(), series.time_ns.len())?;
    length(name, "twist", series.twist.len(), series.time_ns.len())?;
    increasing_times(name, &series.time_ns)?;
    for (row, (pose, twist)) in series.pose.iter().zip(&series.twist).enumerate() {
        finite(name, row, "pose", pose)?;
        finite(name, row, "twist", twist)?;
    }
    Ok(())
}

fn contacts(recording: &Recording) -> Result<(), RecordingError> {
    const NAME: &str = "contacts";
    repeating_times(NAME, recording.contacts.iter().map(|contact| contact.time_ns))?;
    for (row, contact) in recording.contacts.iter().enumerate() {
        finite(NAME, row, "depth", &[contact.depth_m])?;
        finite(NAME, row, "normal force", &[contact.normal_force_n])?;
        finite(NAME, row, "point", &contact.point)?;
        finite(NAME, row, "normal", &contact.normal)?;
    }
    Ok(())
}

fn monitor(recording: &Recording) -> Result<(), RecordingError> {
    const NAME: &str = "monitor";
    let times: Vec<i64> = recording.monitor.iter().map(|sample| sample.time_ns).collect();
    increasing_times(NAME, &times)?;
    for (row, sample) in recording.monitor.iter().enumerate() {
        finite(NAME, row, "tool error", &[sample.tool_error_m, sample.tool_error_rad])?;
        finite(NAME, row, "velocity ratio", &[sample.velocity_ratio])?;
        finite(NAME, row, "acceleration ratio", &[sample.acceleration_ratio])?;
        finite(NAME, row, "jerk ratio", &[sample.jerk_ratio])?;
        finite(NAME, row, "torque ratio", &[sample.torque_ratio])?;
        finite(NAME, row, "grip force", &[sample.grip_force_n])?;
        finite(NAME, row, "opening", &[sample.opening_m])?;
        finite(NAME, row, "clearance margin", sample.clearance_margin_m.as_slice())?;
    }
    Ok(())
}

fn frames(recording: &Recording) -> Result<(), RecordingError> {
    let mut children = BTreeSet::new();
    for frame in &recording.frames {
        if !children.insert(&frame.child) {
            return Err(RecordingError::RepeatedFrame(frame.child.clone()));
        }
        let name = format!("frame {}", frame.child);
        length(&name, "pose", frame.pose.len(), frame.time_ns.len())?;
        increasing_times(&name, &frame.time_ns)?;
        for (row, pose) in frame.pose.iter().enumerate() {
            finite(&name, row, "pose", pose)?;
        }
    }
    Ok(())
}

fn markers(recording: &Recording) -> Result<(), RecordingError> {
    for (row, marker) in recording.markers.iter().enumerate() {
        finite("markers", row, "pose", &marker.pose)?;
        finite("markers", row, "color", &marker.color.map(f64::from))?;
        match &marker.shape {
            MarkerShape::Box { size } => finite("markers", row, "size", size)?,
            // The file holds diameters.
            MarkerShape::Sphere { radius } => finite("markers", row, "diameter", &[2.0 * radius])?,
            MarkerShape::Cylinder { radius, length } => {
                finite("markers", row, "diameter", &[2.0 * radius])?;
                finite("markers", row, "length", &[*length])?;
            }
            MarkerShape::Triangles { points } => {
                if !points.len().is_multiple_of(3) {
                    return Err(RecordingError::MarkerPoints {
                        marker: marker.name.clone(),
                        shape: "triangles",
                        found: points.len(),
                        expected: "three a triangle",
                    });
                }
                finite("markers", row, "points", points.as_flattened())?;
            }
            MarkerShape::Line { points, width } => {
                if points.len() < 2 {
                    return Err(RecordingError::MarkerPoints {
                        marker: marker.name.clone(),
                        shape: "line",
                        found: points.len(),
                        expected: "at least two",
                    });
                }
                finite("markers", row, "points", points.as_flattened())?;
                finite("markers", row, "width", &[*width])?;
            }
        }
    }
    Ok(())
}

fn length(series: &str, column: &'static str, found: usize, expected: usize) -> Result<(), RecordingError> {
    if found == expected {
        return Ok(());
    }
    Err(RecordingError::Length { series: series.to_owned(), column, found, expected })
}

fn finite(series: &str, row: usize, column: &'static str, values: &[f64]) -> Result<(), RecordingError> {
    match values.iter().find(|value| !value.is_finite()) {
        None => Ok(()),
        Some(&value) => Err(RecordingError::NotFinite { series: series.to_owned(), row, column, value }),
    }
}

/// A state has one value at an instant: times strictly increase.
fn increasing_times(series: &str, times: &[i64]) -> Result<(), RecordingError> {
    repeating_times(series, times.iter().copied())?;
    match times.windows(2).position(|pair| pair[0] == pair[1]) {
        None => Ok(()),
        Some(row) => Err(RecordingError::Order {
            series: series.to_owned(),
            row: row + 1,
            time_ns: times[row + 1],
            previous_ns: times[row],
        }),
    }
}

/// Several things may happen at one instant: times do not decrease.
fn repeating_times(series: &str, times: impl Iterator<Item = i64>) -> Result<(), RecordingError> {
    let mut previous_ns = 0;
    for (row, time_ns) in times.enumerate() {
        let series = || series.to_owned();
        if !(0..=LATEST_NS).contains(&time_ns) {
            return Err(RecordingError::TimeRange { series: series(), row, time_ns, limit_ns: LATEST_NS });
        }
        if time_ns < previous_ns {
            return Err(RecordingError::Order { series: series(), row, time_ns, previous_ns });
        }
        previous_ns = time_ns;
    }
    Ok(())
}
