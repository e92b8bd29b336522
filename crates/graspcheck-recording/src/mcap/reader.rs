//! From the bytes of a file to a recording, trusting nothing.
//!
//! A first pass looks at the records without decoding them: magic bytes, checksums of data and summary,
//! nothing missing, nothing after the end. Only then the content is read, each chunk after its checksum.
//! No length in the file is believed before memory is asked for it.

use std::collections::BTreeMap;

use ::mcap::{
    MAGIC, McapError, parse_record,
    records::{Record, op},
    sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions},
};

use super::{
    MAX_CHUNK, RUN, WORLD, cdr,
    layout::{self, LAYOUT},
    messages::{
        Contact, DiagnosticArray, Header, JointState, Log, Marker, MarkerArray, Monitor, PoseStamped,
        StringMessage, TfMessage, Time, TwistStamped,
    },
    topic::Topic,
};
use crate::{
    Attachment, ContactSample, Diagnostic, Event, JointSeries, Level, MarkerShape, MonitorSample, PoseSeries,
    Recording, RecordingError,
    validate::{VERDICT_ATTACHMENT, validate},
};

/// The recording in the bytes of an MCAP file.
///
/// # Errors
/// [`RecordingError::NotMcap`], [`RecordingError::Truncated`], [`RecordingError::Damaged`] for what is not
/// an intact MCAP file; [`RecordingError::Foreign`], [`RecordingError::Message`] and the faults of a
/// recording for an intact file that graspcheck has not written so.
pub fn read(bytes: &[u8]) -> Result<Recording, RecordingError> {
    if !bytes.starts_with(MAGIC) {
        return Err(RecordingError::NotMcap);
    }
    check_structure(bytes)?;
    let mut content = Content::default();
    for_each_record(bytes, false, |opcode, body| content.record(opcode, body))?;
    content.finish()
}

/// What stops the reading of a record.
enum Stop {
    Mcap(McapError),
    Content(RecordingError),
}

impl From<McapError> for Stop {
    fn from(error: McapError) -> Self {
        Self::Mcap(error)
    }
}

/// Checks the checksums of data and summary section and that chunks are of the kind that we write.
fn check_structure(bytes: &[u8]) -> Result<(), RecordingError> {
    for_each_record(bytes, true, |opcode, body| {
        if opcode == op::CHUNK
            && let Record::Chunk { header, data } = parse_record(opcode, body)?
        {
            // The reader of uncompressed chunks trusts the lengths in them.
            if header.compression != "zstd" {
                return Err(McapError::UnsupportedCompression(header.compression).into());
            }
            if header.compressed_size != data.len() as u64 {
                return Err(McapError::BadChunkLength {
                    header: header.compressed_size,
                    available: data.len() as u64,
                }
                .into());
            }
        }
        Ok(())
    })
}

/// Calls `visit` with opcode and body of each record, with whole chunks or with what is in them.
fn for_each_record(
    bytes: &[u8],
    whole_chunks: bool,
    mut visit: impl FnMut(u8, &[u8]) -> Result<(), Stop>,
) -> Result<(), RecordingError> {
    let options = LinearReaderOptions::default()
        .with_emit_chunks(whole_chunks)
        .with_check_finishes_after_end_magic(true)
        .with_prevalidate_chunk_crcs(true)
        .with_validate_data_section_crc(true)
        .with_validate_summary_section_crc(true)
        .with_record_length_limit(MAX_CHUNK);
    let mut reader = LinearReader::new_with_options(options);
    let mut rest = bytes;
    while let Some(event) = reader.next_event() {
        let offset = bytes.len() - rest.len();
        let stopped = match event {
            Ok(LinearReadEvent::ReadRequest(wanted)) => {
                let (given, left) = rest.split_at(wanted.min(rest.len()));
                // Asked for no more than there is, so that a length that lies gets no memory.
                reader.insert(given.len()).copy_from_slice(given);
                reader.notify_read(given.len());
                rest = left;
                Ok(())
            }
            Ok(LinearReadEvent::Record { opcode, data }) => visit(opcode, data),
            Err(error) => Err(Stop::Mcap(error)),
        };
        match stopped {
            Ok(()) => {}
            Err(Stop::Content(error)) => return Err(error),
            Err(Stop::Mcap(McapError::UnexpectedEof)) => {
                return Err(RecordingError::Truncated { length: bytes.len() });
            }
            Err(Stop::Mcap(source)) => return Err(RecordingError::Damaged { offset, source }),
        }
    }
    Ok(())
}

/// What has been read so far.
#[derive(Default)]
struct Content {
    /// Profile of the file and the library that wrote it.
    profile: String,
    run: Option<BTreeMap<String, String>>,
    /// From the metadata record `layout` on.
    recording: Option<Recording>,
    /// Message types by number, as the schemas name them.
    schemas: BTreeMap<u16, (String, String)>,
    channels: BTreeMap<u16, Topic>,
    /// How many messages each topic had.
    counts: [usize; Topic::ALL.len()],
    verdict_attachment: Option<Vec<u8>>,
    /// From the statistics record.
    promised_messages: Option<u64>,
}

impl Content {
    fn record(&mut self, opcode: u8, body: &[u8]) -> Result<(), Stop> {
        if opcode == op::ATTACHMENT {
            check_attachment(body)?;
        }
        match parse_record(opcode, body)? {
            Record::Header(header) => self.profile = header.profile,
            Record::Metadata(record) if record.name == RUN => self.run = Some(record.metadata),
            Record::Metadata(record) if record.name == LAYOUT => {
                let recording = layout::empty_recording(&record.metadata).map_err(foreign)?;
                self.recording = Some(recording);
            }
            Record::Attachment { header, data, .. } => {
                if header.name == VERDICT_ATTACHMENT {
                    self.verdict_attachment = Some(data.into_owned());
                } else {
                    self.recording()?.attachments.push(Attachment {
                        name: header.name,
                        media_type: header.media_type,
                        data: data.into_owned(),
                    });
                }
            }
            Record::Schema { header, .. } => {
                self.schemas.insert(header.id, (header.name, header.encoding));
            }
            Record::Channel(channel) => self.channel(&channel)?,
            Record::Message { header, data } => {
                let Some(&topic) = self.channels.get(&header.channel_id) else {
                    return Err(McapError::UnknownChannel(header.sequence, header.channel_id).into());
                };
                let index = self.counts[topic as usize];
                self.counts[topic as usize] += 1;
                let recording = self.recording()?;
                let result = if header.publish_time == header.log_time {
                    read_message(recording, topic, header.log_time, index, &data)
                } else {
                    Err(format!("publish time {} ns is not the log time", header.publish_time))
                };
                result.map_err(|fault| {
                    let time_ns = header.log_time;
                    Stop::Content(RecordingError::Message { topic: topic.name(), index, time_ns, fault })
                })?;
            }
            Record::Statistics(statistics) => self.promised_messages = Some(statistics.message_count),
            _ => {}
        }
        Ok(())
    }

    fn channel(&mut self, channel: &::mcap::records::Channel) -> Result<(), Stop> {
        let topic = Topic::named(&channel.topic)
            .ok_or_else(|| foreign(format!("it has no topic {}", channel.topic)))?;
        let (message_type, encoding) = self
            .schemas
            .get(&channel.schema_id)
            .ok_or_else(|| McapError::UnknownSchema(channel.topic.clone(), channel.schema_id))?;
        if message_type != topic.message_type() || encoding != "ros2msg" || channel.message_encoding != "cdr"
        {
            return Err(foreign(format!(
                "topic {} holds {message_type} as {encoding} and {}, expected {} as ros2msg and cdr",
                channel.topic,
                channel.message_encoding,
                topic.message_type()
            )));
        }
        self.channels.insert(channel.id, topic);
        Ok(())
    }

    fn recording(&mut self) -> Result<&mut Recording, Stop> {
        self.recording
            .as_mut()
            .ok_or_else(|| foreign("its metadata record `layout` does not come first".to_owned()))
    }

    fn finish(self) -> Result<Recording, RecordingError> {
        let foreign = |what: &str| RecordingError::Foreign(what.to_owned());
        if self.profile != "ros2" {
            return Err(RecordingError::Foreign(format!(
                "its profile is {:?}, expected \"ros2\"",
                self.profile
            )));
        }
        let mut recording = self.recording.ok_or_else(|| foreign("it has no metadata record `layout`"))?;
        recording.metadata = self.run.ok_or_else(|| foreign("it has no metadata record `run`"))?;
        let messages: usize = self.counts.iter().sum();
        if self.promised_messages != Some(messages as u64) {
            return Err(RecordingError::Foreign(format!(
                "its statistics promise {:?} messages, it has {messages}",
                self.promised_messages
            )));
        }
        let poses = [
            ("tool", &recording.tool, Topic::ToolTwist),
            ("reference_tool", &recording.reference_tool, Topic::ReferenceToolTwist),
            ("object", &recording.object, Topic::ObjectTwist),
        ];
        for (series, poses, twist) in poses {
            if self.counts[twist as usize] != poses.time_ns.len() {
                return Err(RecordingError::Length {
                    series: series.to_owned(),
                    column: "twist",
                    found: self.counts[twist as usize],
                    expected: poses.time_ns.len(),
                });
            }
        }
        if self.verdict_attachment.as_deref() != recording.verdict.as_ref().map(String::as_bytes) {
            return Err(foreign("its attachment verdict.json is not what its topic /verdict says"));
        }
        validate(&recording)?;
        Ok(recording)
    }
}

fn foreign(what: String) -> Stop {
    Stop::Content(RecordingError::Foreign(what))
}

/// Checks that the texts before an attachment's data leave room for its checksum. The parser takes four
/// bytes off the end before it looks.
fn check_attachment(body: &[u8]) -> Result<(), McapError> {
    // Two times, name, media type, length of the data; the data; the checksum.
    let mut needed: u64 = 8 + 8;
    for _ in ["name", "media type"] {
        let length = usize::try_from(needed).ok().and_then(|at| body.get(at..)?.first_chunk());
        needed += 4 + length.map_or(u64::MAX / 4, |bytes| u64::from(u32::from_le_bytes(*bytes)));
    }
    needed += 8 + 4;
    let available = body.len() as u64;
    if needed > available {
        return Err(McapError::BadAttachmentLength { header: needed, available });
    }
    Ok(())
}

/// Adds one message to the recording.
fn read_message(
    recording: &mut Recording,
    topic: Topic,
    log_time: u64,
    index: usize,
    data: &[u8],
) -> Result<(), String> {
    let time_ns = i64::try_from(log_time).map_err(|_| "its time is later than a stamp can say".to_owned())?;
    match topic {
        Topic::StaticFrames | Topic::Frames => transforms(recording, time_ns, cdr::decode(data)?),
        Topic::RobotDescription => {
            once(index)?;
            recording.robot_description = cdr::decode::<StringMessage>(data)?.data.into_owned();
            Ok(())
        }
        Topic::Markers => {
            once(index)?;
            let array: MarkerArray = cdr::decode(data)?;
            recording.markers = array.markers.into_iter().map(marker).collect::<Result<_, _>>()?;
            Ok(())
        }
        Topic::Measured => joint_state(&mut recording.measured, time_ns, cdr::decode(data)?),
        Topic::Reference => joint_state(&mut recording.reference, time_ns, cdr::decode(data)?),
        Topic::ToolPose => pose(&mut recording.tool, time_ns, data),
        Topic::ToolTwist => twist(&mut recording.tool, time_ns, index, data),
        Topic::ReferenceToolPose => pose(&mut recording.reference_tool, time_ns, data),
        Topic::ReferenceToolTwist => twist(&mut recording.reference_tool, time_ns, index, data),
        Topic::ObjectPose => pose(&mut recording.object, time_ns, data),
        Topic::ObjectTwist => twist(&mut recording.object, time_ns, index, data),
        Topic::Contacts => contact(recording, time_ns, cdr::decode(data)?),
        Topic::Monitor => monitor(recording, time_ns, &cdr::decode(data)?),
        Topic::Events => log(recording, time_ns, cdr::decode(data)?),
        Topic::Diagnostics => {
            once(index)?;
            diagnostics(recording, time_ns, cdr::decode(data)?)
        }
        Topic::Verdict => {
            once(index)?;
            recording.verdict = Some(cdr::decode::<StringMessage>(data)?.data.into_owned());
            Ok(())
        }
    }
}

fn once(index: usize) -> Result<(), String> {
    if index > 0 { Err("this topic has one message".to_owned()) } else { Ok(()) }
}

fn check_stamp(stamp: Time, time_ns: i64) -> Result<(), String> {
    match stamp.to_ns() {
        Some(stamp_ns) if stamp_ns == time_ns => Ok(()),
        _ => Err(format!("its stamp of {} s and {} ns is not its log time", stamp.sec, stamp.nanosec)),
    }
}

fn check_header(header: &Header, time_ns: i64, frame: &str) -> Result<(), String> {
    check_stamp(header.stamp, time_ns)?;
    if header.frame_id != frame {
        return Err(format!("its frame is {:?}, expected {frame:?}", header.frame_id));
    }
    Ok(())
}

fn joint_state(series: &mut JointSeries, time_ns: i64, message: JointState) -> Result<(), String> {
    check_header(&message.header, time_ns, "")?;
    if *message.name != *series.names {
        return Err(format!("its joints are {:?}, expected {:?}", message.name, series.names));
    }
    let columns = [
        ("position", message.position, &mut series.position),
        ("velocity", message.velocity, &mut series.velocity),
        ("effort", message.effort, &mut series.effort),
    ];
    for (name, values, column) in columns {
        if values.len() != series.names.len() {
            return Err(format!("{name} has {} values for {} joints", values.len(), series.names.len()));
        }
        column.extend_from_slice(&values);
    }
    series.time_ns.push(time_ns);
    Ok(())
}

fn pose(series: &mut PoseSeries, time_ns: i64, data: &[u8]) -> Result<(), String> {
    let message: PoseStamped = cdr::decode(data)?;
    check_header(&message.header, time_ns, &series.frame)?;
    series.time_ns.push(time_ns);
    series.pose.push(message.pose);
    Ok(())
}

/// A twist follows the pose of the same instant.
fn twist(series: &mut PoseSeries, time_ns: i64, index: usize, data: &[u8]) -> Result<(), String> {
    let message: TwistStamped = cdr::decode(data)?;
    check_header(&message.header, time_ns, &series.frame)?;
    if series.time_ns.get(index) != Some(&time_ns) {
        return Err("no pose has this time".to_owned());
    }
    series.twist.push(message.twist);
    Ok(())
}

fn transforms(recording: &mut Recording, time_ns: i64, message: TfMessage) -> Result<(), String> {
    for transform in message.transforms {
        let child = &*transform.child_frame_id;
        let frame = recording
            .frames
            .iter_mut()
            .find(|frame| frame.child == child)
            .ok_or_else(|| format!("the layout has no frame {child:?}"))?;
        check_header(&transform.header, time_ns, &frame.parent)?;
        frame.time_ns.push(time_ns);
        frame.pose.push(transform.transform);
    }
    Ok(())
}

fn marker(message: Marker) -> Result<crate::Marker, String> {
    check_stamp(message.header.stamp, 0)?;
    let [x, y, z] = message.scale;
    let points = message.points.into_owned();
    let shape = match message.kind {
        Marker::CUBE => MarkerShape::Box { size: message.scale },
        Marker::SPHERE => MarkerShape::Sphere { radius: x / 2.0 },
        Marker::CYLINDER => MarkerShape::Cylinder { radius: y / 2.0, length: z },
        Marker::TRIANGLE_LIST => MarkerShape::Triangles { points },
        Marker::LINE_STRIP => MarkerShape::Line { points, width: x },
        other => return Err(format!("marker {:?} has type {other}", message.text)),
    };
    Ok(crate::Marker {
        namespace: message.ns.into_owned(),
        name: message.text.into_owned(),
        frame: message.header.frame_id.into_owned(),
        pose: message.pose,
        shape,
        color: message.color,
    })
}

fn contact(recording: &mut Recording, time_ns: i64, message: Contact) -> Result<(), String> {
    check_header(&message.header, time_ns, WORLD)?;
    recording.contacts.push(ContactSample {
        time_ns,
        body_a: message.body_a.into_owned(),
        body_b: message.body_b.into_owned(),
        depth_m: message.depth_m,
        normal_force_n: message.normal_force_n,
        point: message.point,
        normal: message.normal,
    });
    Ok(())
}

fn monitor(recording: &mut Recording, time_ns: i64, message: &Monitor) -> Result<(), String> {
    check_header(&message.header, time_ns, "")?;
    let clearance_margin_m = match *message.clearance_margin_m {
        [] => None,
        [margin] => Some(margin),
        _ => return Err("clearance_margin_m has more than one value".to_owned()),
    };
    recording.monitor.push(MonitorSample {
        time_ns,
        phase: message.phase,
        tool_error_m: message.tool_error_m,
        tool_error_rad: message.tool_error_rad,
        velocity_ratio: message.velocity_ratio,
        acceleration_ratio: message.acceleration_ratio,
        jerk_ratio: message.jerk_ratio,
        torque_ratio: message.torque_ratio,
        saturated_joints: message.saturated_joints,
        grip_force_n: message.grip_force_n,
        opening_m: message.opening_m,
        clearance_margin_m,
        contacts: message.contacts,
    });
    Ok(())
}

fn log(recording: &mut Recording, time_ns: i64, message: Log) -> Result<(), String> {
    check_stamp(message.stamp, time_ns)?;
    recording.events.push(Event {
        time_ns,
        level: match message.level {
            20 => Level::Info,
            30 => Level::Warn,
            40 => Level::Error,
            other => return Err(format!("its level is {other}, expected 20, 30 or 40")),
        },
        source: message.name.into_owned(),
        message: message.msg.into_owned(),
    });
    Ok(())
}

fn diagnostics(recording: &mut Recording, time_ns: i64, message: DiagnosticArray) -> Result<(), String> {
    check_header(&message.header, time_ns, "")?;
    for status in message.status {
        recording.diagnostics.push(Diagnostic {
            name: status.name.into_owned(),
            level: match status.level {
                0 => Level::Info,
                1 => Level::Warn,
                2 => Level::Error,
                other => {
                    return Err(format!("status {:?} has level {other}, expected 0, 1 or 2", status.message));
                }
            },
            message: status.message.into_owned(),
            values: status.values.into_owned(),
        });
    }
    Ok(())
}
