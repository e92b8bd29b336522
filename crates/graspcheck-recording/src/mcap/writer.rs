//! From a recording to the bytes of a file.

use std::{
    borrow::Cow,
    collections::BTreeMap,
    io::{Seek, Write},
};

use ::mcap::{WriteOptions, records::MessageHeader, write::Metadata};
use serde::Serialize;

use super::{
    MAX_CHUNK, RUN, WORLD, cdr,
    layout::{self, LAYOUT},
    messages::{
        CompressedImage, Contact, DiagnosticArray, DiagnosticStatus, Header, JointState, Log, Marker,
        MarkerArray, MeshFile, Monitor, PoseStamped, StringMessage, TfMessage, Time, TransformStamped,
        TwistStamped, schema,
    },
    topic::Topic,
};
use crate::{
    Attachment, JointSeries, Level, MarkerShape, PoseSeries, Recording, RecordingError,
    validate::{VERDICT_ATTACHMENT, validate},
};

/// Content of a chunk before it is compressed, bytes: what a killed run can lose at most.
const CHUNK_SIZE: u64 = 256 * 1024;

/// Writes a recording as an MCAP file.
///
/// The same recording gives the same bytes. Messages are in order of time, and in a fixed order of topics
/// at equal times; the documents come first, so that they survive a run that is killed.
///
/// # Errors
/// A fault of the recording (see [`RecordingError`]) or of the output.
pub fn write(recording: &Recording, out: impl Write + Seek) -> Result<(), RecordingError> {
    validate(recording)?;
    let mut file = FileWriter::begin(out)?;
    file.metadata(RUN, recording.metadata.clone())?;
    file.metadata(LAYOUT, layout::describe(recording))?;
    for attachment in &recording.attachments {
        file.attach(attachment)?;
    }
    for (time_ns, topic, row) in schedule(recording) {
        write_row(&mut file, recording, time_ns, topic, row)?;
    }
    if let Some(verdict) = &recording.verdict {
        file.attach(&Attachment {
            name: VERDICT_ATTACHMENT.to_owned(),
            media_type: "application/json".to_owned(),
            data: verdict.clone().into_bytes(),
        })?;
    }
    file.finish()
}

/// Every message to be written: its time, topic and row, in order.
fn schedule(recording: &Recording) -> Vec<(i64, Topic, usize)> {
    let mut messages = Vec::new();
    let mut add = |topic: Topic, times: &mut dyn Iterator<Item = i64>| {
        messages.extend(times.enumerate().map(|(row, time_ns)| (time_ns, topic, row)));
    };
    let (fixed, moving): (Vec<_>, Vec<_>) =
        recording.frames.iter().partition(|frame| frame.time_ns.len() == 1);
    for (topic, frames) in [(Topic::StaticFrames, fixed), (Topic::Frames, moving)] {
        let mut times: Vec<i64> = frames.iter().flat_map(|frame| frame.time_ns.iter().copied()).collect();
        times.sort_unstable();
        times.dedup();
        add(topic, &mut times.into_iter());
    }
    if !recording.robot_description.is_empty() {
        add(Topic::RobotDescription, &mut [0].into_iter());
    }
    if !recording.markers.is_empty() {
        add(Topic::Markers, &mut [0].into_iter());
    }
    add(Topic::Measured, &mut recording.measured.time_ns.iter().copied());
    add(Topic::Reference, &mut recording.reference.time_ns.iter().copied());
    let poses = [
        (Topic::ToolPose, Topic::ToolTwist, &recording.tool),
        (Topic::ReferenceToolPose, Topic::ReferenceToolTwist, &recording.reference_tool),
        (Topic::ObjectPose, Topic::ObjectTwist, &recording.object),
    ];
    for (pose, twist, series) in poses {
        add(pose, &mut series.time_ns.iter().copied());
        add(twist, &mut series.time_ns.iter().copied());
    }
    add(Topic::Contacts, &mut recording.contacts.iter().map(|contact| contact.time_ns));
    add(Topic::Monitor, &mut recording.monitor.iter().map(|sample| sample.time_ns));
    add(Topic::Events, &mut recording.events.iter().map(|event| event.time_ns));

    let end_ns = messages.iter().map(|(time_ns, ..)| *time_ns).max().unwrap_or(0);
    if !recording.diagnostics.is_empty() {
        messages.push((end_ns, Topic::Diagnostics, 0));
    }
    if recording.verdict.is_some() {
        messages.push((end_ns, Topic::Verdict, 0));
    }
    messages.sort_unstable();
    messages
}

fn write_row<W: Write + Seek>(
    file: &mut FileWriter<W>,
    recording: &Recording,
    time_ns: i64,
    topic: Topic,
    row: usize,
) -> Result<(), RecordingError> {
    match topic {
        Topic::StaticFrames | Topic::Frames => {
            file.message(topic, time_ns, &transforms(recording, time_ns, topic))
        }
        Topic::RobotDescription => {
            file.message(topic, time_ns, &StringMessage { data: (&*recording.robot_description).into() })
        }
        Topic::Markers => file.message(topic, time_ns, &markers(recording)),
        Topic::Measured => file.message(topic, time_ns, &joint_state(&recording.measured, row)),
        Topic::Reference => file.message(topic, time_ns, &joint_state(&recording.reference, row)),
        Topic::ToolPose => file.message(topic, time_ns, &pose(&recording.tool, row)),
        Topic::ToolTwist => file.message(topic, time_ns, &twist(&recording.tool, row)),
        Topic::ReferenceToolPose => file.message(topic, time_ns, &pose(&recording.reference_tool, row)),
        Topic::ReferenceToolTwist => file.message(topic, time_ns, &twist(&recording.reference_tool, row)),
        Topic::ObjectPose => file.message(topic, time_ns, &pose(&recording.object, row)),
        Topic::ObjectTwist => file.message(topic, time_ns, &twist(&recording.object, row)),
        Topic::Contacts => file.message(topic, time_ns, &contact(recording, row)),
        Topic::Monitor => file.message(topic, time_ns, &monitor(recording, row)),
        Topic::Events => file.message(topic, time_ns, &log(recording, row)),
        Topic::Diagnostics => file.message(topic, time_ns, &diagnostics(recording, time_ns)),
        Topic::Verdict => {
            let data = recording.verdict.as_deref().unwrap_or_default().into();
            file.message(topic, time_ns, &StringMessage { data })
        }
    }
}

fn header(time_ns: i64, frame_id: &str) -> Header<'_> {
    Header { stamp: Time::from_ns(time_ns), frame_id: frame_id.into() }
}

fn joint_state(series: &JointSeries, row: usize) -> JointState<'_> {
    JointState {
        header: header(series.time_ns[row], ""),
        name: Cow::Borrowed(&series.names),
        position: Cow::Borrowed(series.position_row(row)),
        velocity: Cow::Borrowed(series.velocity_row(row)),
        effort: Cow::Borrowed(series.effort_row(row)),
    }
}

fn pose(series: &PoseSeries, row: usize) -> PoseStamped<'_> {
    PoseStamped { header: header(series.time_ns[row], &series.frame), pose: series.pose[row] }
}

fn twist(series: &PoseSeries, row: usize) -> TwistStamped<'_> {
    TwistStamped { header: header(series.time_ns[row], &series.frame), twist: series.twist[row] }
}

/// The frames that have a row at this time, in the order of the recording.
fn transforms(recording: &Recording, time_ns: i64, topic: Topic) -> TfMessage<'_> {
    let fixed = topic == Topic::StaticFrames;
    let frames = recording.frames.iter().filter(|frame| (frame.time_ns.len() == 1) == fixed);
    let transforms = frames.filter_map(|frame| {
        let row = frame.time_ns.binary_search(&time_ns).ok()?;
        Some(TransformStamped {
            header: header(time_ns, &frame.parent),
            child_frame_id: (&*frame.child).into(),
            transform: frame.pose[row],
        })
    });
    TfMessage { transforms: transforms.collect() }
}

fn markers(recording: &Recording) -> MarkerArray<'_> {
    let markers = recording.markers.iter().zip(0..).map(|(marker, id)| {
        let no_points: &[[f64; 3]] = &[];
        let (kind, scale, points) = match &marker.shape {
            MarkerShape::Box { size } => (Marker::CUBE, *size, no_points),
            MarkerShape::Sphere { radius } => (Marker::SPHERE, [2.0 * radius; 3], no_points),
            MarkerShape::Cylinder { radius, length } => {
                (Marker::CYLINDER, [2.0 * radius, 2.0 * radius, *length], no_points)
            }
            MarkerShape::Triangles { points } => (Marker::TRIANGLE_LIST, [1.0; 3], &points[..]),
            MarkerShape::Line { points, width } => (Marker::LINE_STRIP, [*width, 0.0, 0.0], &points[..]),
        };
        Marker {
            header: header(0, &marker.frame),
            ns: (&*marker.namespace).into(),
            id,
            kind,
            action: 0,
            pose: marker.pose,
            scale,
            color: marker.color,
            lifetime: Time::default(),
            // The marker moves with its frame.
            frame_locked: true,
            points: points.into(),
            colors: Vec::new(),
            texture_resource: "".into(),
            texture: CompressedImage { header: header(0, ""), format: "".into(), data: Vec::new() },
            uv_coordinates: Vec::new(),
            text: (&*marker.name).into(),
            mesh_resource: "".into(),
            mesh_file: MeshFile { filename: "".into(), data: Vec::new() },
            mesh_use_embedded_materials: false,
        }
    });
    MarkerArray { markers: markers.collect() }
}

fn contact(recording: &Recording, row: usize) -> Contact<'_> {
    let contact = &recording.contacts[row];
    Contact {
        header: header(contact.time_ns, WORLD),
        body_a: (&*contact.body_a).into(),
        body_b: (&*contact.body_b).into(),
        depth_m: contact.depth_m,
        normal_force_n: contact.normal_force_n,
        point: contact.point,
        normal: contact.normal,
    }
}

fn monitor(recording: &Recording, row: usize) -> Monitor<'_> {
    let sample = &recording.monitor[row];
    Monitor {
        header: header(sample.time_ns, ""),
        phase: sample.phase,
        tool_error_m: sample.tool_error_m,
        tool_error_rad: sample.tool_error_rad,
        velocity_ratio: sample.velocity_ratio,
        acceleration_ratio: sample.acceleration_ratio,
        jerk_ratio: sample.jerk_ratio,
        torque_ratio: sample.torque_ratio,
        saturated_joints: sample.saturated_joints,
        grip_force_n: sample.grip_force_n,
        opening_m: sample.opening_m,
        clearance_margin_m: sample.clearance_margin_m.as_slice().into(),
        contacts: sample.contacts,
    }
}

fn log(recording: &Recording, row: usize) -> Log<'_> {
    let event = &recording.events[row];
    Log {
        stamp: Time::from_ns(event.time_ns),
        level: match event.level {
            Level::Info => 20,
            Level::Warn => 30,
            Level::Error => 40,
        },
        name: (&*event.source).into(),
        msg: (&*event.message).into(),
        file: "".into(),
        function: "".into(),
        line: 0,
    }
}

fn diagnostics(recording: &Recording, time_ns: i64) -> DiagnosticArray<'_> {
    let status = recording.diagnostics.iter().map(|diagnostic| DiagnosticStatus {
        level: match diagnostic.level {
            Level::Info => 0,
            Level::Warn => 1,
            Level::Error => 2,
        },
        name: (&*diagnostic.name).into(),
        message: (&*diagnostic.message).into(),
        hardware_id: "".into(),
        values: Cow::Borrowed(&diagnostic.values),
    });
    DiagnosticArray { header: header(time_ns, ""), status: status.collect() }
}

/// An MCAP file that is being written, one record after the other; memory does not grow with its length.
struct FileWriter<W: Write + Seek> {
    mcap: ::mcap::Writer<W>,
    /// Number of the channel and of its next message, once a topic has been used.
    channels: [Option<(u16, u32)>; Topic::ALL.len()],
    /// The encoded message, kept to be filled again.
    bytes: Vec<u8>,
}

impl<W: Write + Seek> FileWriter<W> {
    fn begin(out: W) -> Result<Self, RecordingError> {
        let mcap = WriteOptions::new()
            .profile("ros2")
            .library(concat!("graspcheck ", env!("CARGO_PKG_VERSION")))
            .chunk_size(Some(CHUNK_SIZE))
            // With threads the bytes would depend on how many there are.
            .compression_threads(0)
            // PlotJuggler finds schemas and channels through them.
            .emit_summary_offsets(true)
            .create(out)
            .map_err(RecordingError::Write)?;
        Ok(Self { mcap, channels: [None; Topic::ALL.len()], bytes: Vec::new() })
    }

    fn metadata(&mut self, name: &str, metadata: BTreeMap<String, String>) -> Result<(), RecordingError> {
        let length = metadata.iter().map(|(key, value)| key.len() + value.len() + 8).sum();
        fits(format!("metadata record {name}"), length)?;
        self.mcap.write_metadata(&Metadata { name: name.to_owned(), metadata }).map_err(RecordingError::Write)
    }

    fn attach(&mut self, attachment: &Attachment) -> Result<(), RecordingError> {
        let Attachment { name, media_type, data } = attachment;
        fits(format!("attachment {name}"), data.len() + name.len() + media_type.len())?;
        self.mcap
            .attach(&::mcap::Attachment {
                // No wall clock reaches a recording.
                log_time: 0,
                create_time: 0,
                name: name.clone(),
                media_type: media_type.clone(),
                data: Cow::Borrowed(data),
            })
            .map_err(RecordingError::Write)
    }

    fn message(
        &mut self,
        topic: Topic,
        time_ns: i64,
        message: &impl Serialize,
    ) -> Result<(), RecordingError> {
        cdr::encode(message, &mut self.bytes);
        fits(format!("topic {}: one message", topic.name()), self.bytes.len())?;
        let (channel_id, sequence) = self.channel(topic)?;
        let time = u64::try_from(time_ns).expect("validated: not negative");
        let header = MessageHeader { channel_id, sequence, log_time: time, publish_time: time };
        self.mcap.write_to_known_channel(&header, &self.bytes).map_err(RecordingError::Write)
    }

    /// The channel of a topic and the number of its next message; a topic that is never used has none.
    fn channel(&mut self, topic: Topic) -> Result<(u16, u32), RecordingError> {
        let slot = &mut self.channels[topic as usize];
        let (id, sequence) = match *slot {
            Some(channel) => channel,
            None => {
                let message_type = topic.message_type();
                let schema_id = self
                    .mcap
                    .add_schema(message_type, "ros2msg", schema(message_type).as_bytes())
                    .map_err(RecordingError::Write)?;
                let metadata =
                    BTreeMap::from([("offered_qos_profiles".to_owned(), topic.quality_of_service())]);
                let id = self
                    .mcap
                    .add_channel(schema_id, topic.name(), "cdr", &metadata)
                    .map_err(RecordingError::Write)?;
                (id, 0)
            }
        };
        *slot = Some((id, sequence.wrapping_add(1)));
        Ok((id, sequence))
    }

    fn finish(mut self) -> Result<(), RecordingError> {
        self.mcap.finish().map(|_summary| ()).map_err(RecordingError::Write)
    }
}

/// Refuses what [`super::read`] would refuse.
fn fits(what: String, length: usize) -> Result<(), RecordingError> {
    // A chunk holds at least one message; it may already hold others, and schemas and channels.
    let limit = MAX_CHUNK - 2 * CHUNK_SIZE as usize;
    if length > limit {
        return Err(RecordingError::TooLarge { what, length, limit });
    }
    Ok(())
}
