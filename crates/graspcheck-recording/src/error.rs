//! What can be wrong with a recording, in memory or as a file.

use std::{io, path::PathBuf};

/// Why a recording could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// The file could not be created, written, moved or read.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// The MCAP writer could not write to its output.
    #[error("recording: it cannot be written: {0}")]
    Write(#[source] ::mcap::McapError),

    /// A column of a series does not have one value for each row (and joint).
    #[error("series {series}: {column} has {found} values, expected {expected}")]
    Length {
        /// The series.
        series: String,
        /// The column.
        column: &'static str,
        /// Values found.
        found: usize,
        /// Values that belong there.
        expected: usize,
    },
    /// A time is negative or later than a ROS 2 stamp can say.
    #[error(
        "series {series}: row {row}: time {time_ns} ns is outside 0 … {limit_ns} ns, which a stamp can hold"
    )]
    TimeRange {
        /// The series.
        series: String,
        /// Its row.
        row: usize,
        /// The time, ns.
        time_ns: i64,
        /// The latest time, ns.
        limit_ns: i64,
    },
    /// Rows are not in order of time.
    #[error(
        "series {series}: row {row}: time {time_ns} ns does not follow {previous_ns} ns; sort the rows by time"
    )]
    Order {
        /// The series.
        series: String,
        /// The row that comes too late.
        row: usize,
        /// Its time, ns.
        time_ns: i64,
        /// The time of the row before, ns.
        previous_ns: i64,
    },
    /// A number is infinite or not a number. No check could be trusted on it: `NaN > limit` is false.
    #[error("series {series}: row {row}: {column} is {value}, expected a finite number")]
    NotFinite {
        /// The series.
        series: String,
        /// Its row.
        row: usize,
        /// The column.
        column: &'static str,
        /// The value.
        value: f64,
    },
    /// A line with fewer than two points, or triangles with points left over.
    #[error("marker {marker}: {shape} has {found} points, expected {expected}")]
    MarkerPoints {
        /// Name of the marker.
        marker: String,
        /// `line` or `triangles`.
        shape: &'static str,
        /// Points found.
        found: usize,
        /// Points that it may have.
        expected: &'static str,
    },
    /// Two frames have the same name, so the tree of frames is none.
    #[error("frame {0}: it is given twice; a frame has one parent and one series")]
    RepeatedFrame(String),
    /// Two attachments have the same name, so that a reader would miss one.
    #[error("attachment {0}: it is given twice; rename one of them")]
    RepeatedAttachment(String),
    /// An attachment has a name that the file uses for the verdict.
    #[error("attachment {0}: this name is kept for the verdict; set `Recording::verdict` instead")]
    ReservedAttachment(&'static str),
    /// A message or attachment that readers would refuse.
    #[error("{what}: {length} bytes exceed {limit} bytes; split it or leave it out")]
    TooLarge {
        /// Which topic or attachment.
        what: String,
        /// Its size, bytes.
        length: usize,
        /// What a reader accepts, bytes.
        limit: usize,
    },

    /// The bytes do not begin as MCAP files do.
    #[error("not an MCAP file: it does not start with the MCAP magic bytes")]
    NotMcap,
    /// The file ends too early.
    #[error(
        "cut off after {length} bytes: the end of the file is missing; the run was killed or the copy is incomplete"
    )]
    Truncated {
        /// Length of the file, bytes.
        length: usize,
    },
    /// The structure of the file or a checksum is wrong.
    #[error("damaged before byte {offset}: {source}")]
    Damaged {
        /// Where reading stopped, bytes from the start.
        offset: usize,
        /// What was wrong.
        source: ::mcap::McapError,
    },
    /// An intact MCAP file that graspcheck has not written, or another version of it.
    #[error("not a recording of this version of graspcheck: {0}")]
    Foreign(String),
    /// A message cannot be decoded or contradicts the others.
    #[error("topic {topic}: message {index} at t = {} s: {fault}", *.time_ns as f64 * 1e-9)]
    Message {
        /// The topic.
        topic: &'static str,
        /// Its number on that topic, from 0.
        index: usize,
        /// Its log time, ns.
        time_ns: u64,
        /// What is wrong.
        fault: String,
    },
}
