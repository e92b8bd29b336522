//! Recordings as MCAP files.
//!
//! Messages are ROS 2 interfaces in CDR with their definitions in the file (profile `ros2`), so that Rerun,
//! Foxglove, Lichtblick, PlotJuggler and the readers of PyPI and npm open it without configuration. Log
//! time, publish time and header stamp are the same simulated nanoseconds.
//!
//! | topic | message | when |
//! |---|---|---|
//! | `/joint_states`, `/reference/joint_states` | `sensor_msgs/JointState` | every row: measured; commanded |
//! | `/tcp/pose`, `/reference/tcp/pose`, `/object/pose` | `geometry_msgs/PoseStamped` | every row |
//! | `/tcp/twist`, `/reference/tcp/twist`, `/object/twist` | `geometry_msgs/TwistStamped` | every row |
//! | `/contacts` | `graspcheck_msgs/Contact` | every contact in every step |
//! | `/checks/monitor` | `graspcheck_msgs/Monitor` | every step |
//! | `/tf`, `/tf_static` | `tf2_msgs/TFMessage` | frames with several rows; with one |
//! | `/robot_description` | `std_msgs/String` | once, URDF |
//! | `/scene/markers` | `visualization_msgs/MarkerArray` | once |
//! | `/rosout` | `rcl_interfaces/Log` | events |
//! | `/diagnostics` | `diagnostic_msgs/DiagnosticArray` | at the end, one status a check |
//! | `/verdict` | `std_msgs/String` | at the end, JSON |
//!
//! Metadata records `run` ([`Recording::metadata`]) and `layout` (names without rows) come first, then the
//! attachments; the verdict is repeated as the last attachment `verdict.json`.
//!
//! Reading order: `topic`, `messages`, `layout`, `writer`, `reader`.

mod cdr;
mod layout;
mod messages;
mod reader;
mod topic;
mod writer;

use std::{
    ffi::OsString,
    fs::{self, File},
    io::{BufWriter, Cursor, Write},
    path::{Path, PathBuf},
};

pub use reader::read;
pub use writer::write;

use crate::{Recording, RecordingError};

/// Name of the metadata record with [`Recording::metadata`].
const RUN: &str = "run";

/// The root of the tree of frames.
const WORLD: &str = "world";

/// The longest record, and the longest content of a chunk, that a reader asks memory for, bytes.
const MAX_CHUNK: usize = 64 * 1024 * 1024;

/// The bytes of the MCAP file of a recording. [`read`] gives the same recording back.
///
/// # Errors
/// As [`write()`].
pub fn to_bytes(recording: &Recording) -> Result<Vec<u8>, RecordingError> {
    let mut bytes = Cursor::new(Vec::new());
    write(recording, &mut bytes)?;
    Ok(bytes.into_inner())
}

/// Writes a recording to a file. What was there is replaced only when the new file is complete and on the
/// disk; until then it is `<path>.tmp`, which is removed if anything fails.
///
/// # Errors
/// As [`write()`], or when the file cannot be created, written or moved.
pub fn save(recording: &Recording, path: &Path) -> Result<(), RecordingError> {
    let mut temporary = OsString::from(path);
    temporary.push(".tmp");
    let temporary = PathBuf::from(temporary);
    let saved = save_new(recording, &temporary)
        .and_then(|()| fs::rename(&temporary, path).map_err(|source| at(path, source)));
    if saved.is_err() {
        // The first fault is the one to report; that nothing was there to be removed is none.
        let _ = fs::remove_file(&temporary);
    }
    saved
}

fn save_new(recording: &Recording, path: &Path) -> Result<(), RecordingError> {
    let file = File::create(path).map_err(|source| at(path, source))?;
    let mut buffered = BufWriter::new(file);
    write(recording, &mut buffered)?;
    buffered.flush().map_err(|source| at(path, source))?;
    buffered.get_ref().sync_all().map_err(|source| at(path, source))
}

/// The recording in a file.
///
/// # Errors
/// As [`read`], or when the file cannot be read.
pub fn load(path: &Path) -> Result<Recording, RecordingError> {
    read(&fs::read(path).map_err(|source| at(path, source))?)
}

fn at(path: &Path, source: std::io::Error) -> RecordingError {
    RecordingError::File { path: path.to_owned(), source }
}
