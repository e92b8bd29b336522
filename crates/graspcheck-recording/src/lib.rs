//! The recording of a run: what every check, report and viewer reads.
//!
//! A [`Recording`] holds the streams of one run and the attachments that let it be judged again from the
//! file alone. This crate knows nothing of robots, physics or checks; it moves numbers with names.
//!
//! Units are SI. Time is integer nanoseconds of simulated time, 0 at the start of the run. Poses are in
//! the frame that the series names, as position and unit quaternion `[x, y, z, qx, qy, qz, qw]`.
//!
//! Reading order: [`recording`], then [`mcap`].

mod error;
pub mod mcap;
pub mod recording;
mod validate;

pub use error::RecordingError;
pub use mcap::{load, read as from_bytes, save, to_bytes};
pub use recording::{
    Attachment, ContactSample, Diagnostic, Event, FrameSeries, JointSeries, Level, Marker, MarkerShape,
    MonitorSample, PoseSeries, Recording,
};
