//! Files of recordings: the same comes back, the same bytes come out, and nothing wrong gets in.

#![expect(clippy::unwrap_used, reason = "a failed unwrap is a failed test; helpers do not count as tests")]

mod sample;

use std::{fs, io, path::PathBuf};

use graspcheck_recording::{
    JointSeries, MarkerShape, PoseSeries, Recording, RecordingError, from_bytes, load, mcap, save, to_bytes,
};

/// A folder of its own for one test, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("graspcheck-recording-{}-{name}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.0).unwrap();
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn what_was_written_is_read() {
    let recording = sample::recording(300);
    assert_eq!(from_bytes(&to_bytes(&recording).unwrap()).unwrap(), recording);
    assert_eq!(from_bytes(&to_bytes(&Recording::default()).unwrap()).unwrap(), Recording::default());
}

#[test]
fn names_without_rows_are_read() {
    let recording = Recording {
        measured: JointSeries::new(vec!["shoulder".to_owned(), "elbow".to_owned()]),
        object: PoseSeries { frame: "world".to_owned(), child: "cube".to_owned(), ..PoseSeries::default() },
        verdict: Some(String::new()),
        ..Recording::default()
    };
    assert_eq!(from_bytes(&to_bytes(&recording).unwrap()).unwrap(), recording);
}

#[test]
fn the_same_recording_gives_the_same_bytes() {
    assert_eq!(to_bytes(&sample::recording(500)).unwrap(), to_bytes(&sample::recording(500)).unwrap());
}

#[test]
fn messages_are_in_order_of_time_with_frames_first() {
    let bytes = to_bytes(&sample::recording(50)).unwrap();
    let messages: Vec<(u64, String)> = ::mcap::MessageStream::new(&bytes)
        .unwrap()
        .map(|message| message.map(|message| (message.log_time, message.channel.topic.clone())).unwrap())
        .collect();
    assert!(messages.is_sorted_by_key(|(time_ns, _)| *time_ns));
    let first: Vec<&str> = messages.iter().take(5).map(|(_, topic)| topic.as_str()).collect();
    assert_eq!(first, ["/tf_static", "/tf", "/robot_description", "/scene/markers", "/joint_states"]);
    assert_eq!(messages.last().unwrap().1, "/verdict");
}

#[test]
fn any_flipped_byte_is_found() {
    let recording = sample::recording(3);
    let bytes = to_bytes(&recording).unwrap();
    for index in 0..bytes.len() {
        let mask = [0x01, 0x80, 0xff][index % 3];
        let mut damaged = bytes.clone();
        damaged[index] ^= mask;
        if let Ok(read) = from_bytes(&damaged) {
            panic!("byte {index} ^ {mask:#x} was not found; same recording: {}", read == recording);
        }
    }
}

#[test]
fn any_missing_end_is_found() {
    let bytes = to_bytes(&sample::recording(3)).unwrap();
    for length in 0..bytes.len() {
        let error = from_bytes(&bytes[..length]).unwrap_err();
        match error {
            RecordingError::NotMcap => assert!(length < 8),
            RecordingError::Truncated { length: said } => assert_eq!(said, length),
            other => panic!("{length}: {other}"),
        }
    }
    let longer = [&bytes[..], b"x"].concat();
    assert!(matches!(from_bytes(&longer), Err(RecordingError::Damaged { .. })));
}

#[test]
fn foreign_files_are_refused() {
    assert!(matches!(from_bytes(b""), Err(RecordingError::NotMcap)));
    assert!(matches!(from_bytes(b"PK\x03\x04 something else"), Err(RecordingError::NotMcap)));

    let mut other = ::mcap::Writer::new(io::Cursor::new(Vec::new())).unwrap();
    other.finish().unwrap();
    let error = from_bytes(&other.into_inner().into_inner()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "not a recording of this version of graspcheck: its profile is \"\", expected \"ros2\""
    );
}

/// A file of another writer that has our records and then one message, intact as far as MCAP goes.
fn forged(topic: &str, message_type: &str, data: &[u8], compression: Option<::mcap::Compression>) -> Vec<u8> {
    let mut own = ::mcap::WriteOptions::new()
        .profile("ros2")
        .compression(compression)
        .create(io::Cursor::new(Vec::new()))
        .unwrap();
    let mut layout = std::collections::BTreeMap::from([("schema".to_owned(), "2".to_owned())]);
    for series in ["tool", "reference_tool", "object"] {
        for key in ["frame", "child"] {
            layout.insert(format!("{series}.{key}"), String::new());
        }
    }
    for (name, metadata) in [("run", Default::default()), ("layout", layout)] {
        own.write_metadata(&::mcap::write::Metadata { name: name.to_owned(), metadata }).unwrap();
    }
    let schema = own.add_schema(message_type, "ros2msg", b"").unwrap();
    let channel = own.add_channel(schema, topic, "cdr", &Default::default()).unwrap();
    let header =
        ::mcap::records::MessageHeader { channel_id: channel, sequence: 0, log_time: 5, publish_time: 5 };
    own.write_to_known_channel(&header, data).unwrap();
    own.finish().unwrap();
    own.into_inner().into_inner()
}

#[test]
fn forged_messages_are_named() {
    const ZSTD: Option<::mcap::Compression> = Some(::mcap::Compression::Zstd);
    let error = |bytes: &[u8]| from_bytes(bytes).unwrap_err().to_string();
    assert_eq!(
        error(&forged(
            "/robot_description",
            "std_msgs/msg/String",
            &[0, 1, 0, 0, 0xff, 0xff, 0xff, 0x7f],
            ZSTD
        )),
        "topic /robot_description: message 0 at t = 0.000000005 s: unexpected end of input"
    );
    assert_eq!(
        error(&forged("/camera", "std_msgs/msg/String", &[], ZSTD)),
        "not a recording of this version of graspcheck: it has no topic /camera"
    );
    assert!(error(&forged("/verdict", "std_msgs/msg/Int8", &[], ZSTD)).contains("holds std_msgs/msg/Int8"));
    // A pose without its twist, stamped 5 ns in the frame "".
    let pose = [&[0, 1, 0, 0, 0, 0, 0, 0, 5, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0][..], &[0; 56]].concat();
    assert_eq!(
        error(&forged("/tcp/pose", "geometry_msgs/msg/PoseStamped", &pose, ZSTD)),
        "series tool: twist has 0 values, expected 1"
    );
    let unpacked = forged("/verdict", "std_msgs/msg/String", &[0, 1, 0, 0], None);
    assert!(error(&unpacked).contains("Unsupported compression format ``"), "{}", error(&unpacked));
}

#[test]
fn an_attachment_whose_lengths_lie_is_an_error() {
    let mut own = ::mcap::WriteOptions::new()
        .profile("ros2")
        .calculate_data_section_crc(false)
        .calculate_attachment_crcs(false)
        .create(io::Cursor::new(Vec::new()))
        .unwrap();
    let data = b"{}"[..].into();
    let (name, media_type) = ("plan.json".to_owned(), "application/json".to_owned());
    own.attach(&::mcap::Attachment { log_time: 0, create_time: 0, name, media_type, data }).unwrap();
    own.finish().unwrap();
    let bytes = own.into_inner().into_inner();
    let media_type_at = bytes.windows(16).position(|text| text == b"application/json").unwrap();
    for length in 0..=255 {
        let mut lying = bytes.clone();
        lying[media_type_at - 4] = length;
        assert!(matches!(
            from_bytes(&lying),
            Err(RecordingError::Damaged { .. } | RecordingError::Foreign(_))
        ));
    }
}

#[test]
fn faults_of_a_recording_are_named_before_anything_is_written() {
    let fault = |change: &dyn Fn(&mut Recording)| {
        let mut recording = sample::recording(3);
        change(&mut recording);
        to_bytes(&recording).unwrap_err().to_string()
    };
    assert_eq!(
        fault(&|r| r.measured.velocity[3] = f64::NAN),
        "series measured: row 1: velocity is NaN, expected a finite number"
    );
    assert_eq!(
        fault(&|r| r.tool.time_ns[0] = -1),
        "series tool: row 0: time -1 ns is outside 0 … 2147483647999999999 ns, which a stamp can hold"
    );
    assert_eq!(
        fault(&|r| r.monitor[2].time_ns = 1_000_000),
        "series monitor: row 2: time 1000000 ns does not follow 1000000 ns; sort the rows by time"
    );
    assert_eq!(
        fault(&|r| r.events.reverse()),
        "series events: row 2: time 0 ns does not follow 1000000 ns; sort the rows by time"
    );
    assert_eq!(
        fault(&|r| r.reference.effort.truncate(5)),
        "series reference: effort has 5 values, expected 6"
    );
    assert_eq!(
        fault(&|r| r.frames[2].child = "base".to_owned()),
        "frame base: it is given twice; a frame has one parent and one series"
    );
    assert_eq!(
        fault(&|r| r.attachments[1].name = "resolved.json".to_owned()),
        "attachment resolved.json: it is given twice; rename one of them"
    );
    assert_eq!(
        fault(&|r| r.attachments[1].name = "verdict.json".to_owned()),
        "attachment verdict.json: this name is kept for the verdict; set `Recording::verdict` instead"
    );
    assert_eq!(
        fault(&|r| r.markers[4].shape = MarkerShape::Line { points: vec![[0.0; 3]], width: 0.1 }),
        "marker tool path: line has 1 points, expected at least two"
    );
    assert_eq!(
        fault(&|r| r.markers[2].shape = MarkerShape::Sphere { radius: f64::MAX }),
        "series markers: row 2: diameter is inf, expected a finite number"
    );
    assert_eq!(
        fault(&|r| r.attachments[0].data = vec![0; 64 << 20]),
        "attachment resolved.json: 67108893 bytes exceed 66584576 bytes; split it or leave it out"
    );
}

#[test]
fn a_file_is_replaced_at_once_and_only_by_a_complete_one() {
    let folder = Folder::new("replace");
    let path = folder.0.join("run.mcap");
    save(&sample::recording(3), &path).unwrap();
    save(&sample::recording(4), &path).unwrap();
    assert_eq!(load(&path).unwrap(), sample::recording(4));

    let mut faulty = sample::recording(3);
    faulty.tool.pose[0][0] = f64::INFINITY;
    save(&faulty, &path).unwrap_err();
    assert_eq!(load(&path).unwrap(), sample::recording(4));
    assert_eq!(folder.names(), ["run.mcap"]);
}

#[test]
fn a_place_that_cannot_be_written_leaves_nothing() {
    let folder = Folder::new("place");
    // The name is taken by a folder, so that the last step fails.
    fs::create_dir_all(folder.0.join("run.mcap/inside")).unwrap();
    let error = save(&sample::recording(3), &folder.0.join("run.mcap")).unwrap_err();
    assert!(matches!(error, RecordingError::File { .. }), "{error}");
    assert_eq!(folder.names(), ["run.mcap"]);
    assert!(save(&sample::recording(3), &folder.0.join("missing/run.mcap")).is_err());
    assert!(matches!(load(&folder.0.join("none.mcap")), Err(RecordingError::File { .. })));
}

/// An output that is full after a number of bytes.
struct Full {
    inner: io::Cursor<Vec<u8>>,
    room: usize,
}

impl io::Write for Full {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.inner.get_ref().len() + bytes.len() > self.room {
            return Err(io::Error::new(io::ErrorKind::StorageFull, "no space left"));
        }
        self.inner.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl io::Seek for Full {
    fn seek(&mut self, to: io::SeekFrom) -> io::Result<u64> {
        self.inner.seek(to)
    }
}

#[test]
fn a_full_disk_is_an_error_wherever_it_strikes() {
    let recording = sample::recording(100);
    let length = to_bytes(&recording).unwrap().len();
    for room in (0..length).step_by(997) {
        let full = Full { inner: io::Cursor::new(Vec::new()), room };
        assert!(matches!(mcap::write(&recording, full), Err(RecordingError::Write(_))), "{room}");
    }
}
