//! A recording as a Rerun file with a blueprint: the scene that moves, the limits as plots, phases and
//! checks as lanes, the verdict as a table.
//!
//! Everything is read from the [`Recording`]: markers and frames give the scene, joint series and monitor
//! the plots, the verdict's JSON the lanes, and with the diagnostics' words the table. What a recording lacks is left out.
//!
//! | entity | holds |
//! |---|---|
//! | `world/<namespace>/<name>` | solids and lines of the markers, moved by their frames |
//! | `world/run/tool_path` | where the tool went |
//! | `world/contact/<pair>` | force at the deepest point, 0.1 m for 10 N |
//! | `world/fail/<check>/…` | stretch and place of a violation, at any position of the cursor |
//! | `state/phase`, `state/verdict/<check>` | lanes |
//! | `plot/…`, `joints/…` | curves; units are in the names |
//! | `events`, `verdict` | log and table |
//!
//! A file is not reproducible byte by byte, since Rerun gives its rows random numbers; two files of one
//! recording are equal under `rerun rrd compare --unordered`.
//!
//! Reading order: [`save`], `scene`, `plots`, `lanes`, `verdict`, `layout`.

mod joint_units;
mod lanes;
mod layout;
mod plots;
mod scene;
mod verdict;

use std::{
    ffi::OsString,
    fs, io,
    path::{Path, PathBuf},
};

use graspcheck_recording::Recording;
use rerun::{RecordingStream, RecordingStreamBuilder, RecordingStreamError, TimeCell, TimeColumn};

use verdict::Verdict;

/// Name of the application, under which a viewer keeps its layout.
const APPLICATION: &str = "graspcheck";

/// Name of the timeline: nanoseconds of simulated time from 0.
const TIMELINE: &str = "sim_time";

/// Why a Rerun file could not be written.
#[derive(Debug, thiserror::Error)]
pub enum RerunError {
    /// The file could not be created, moved or completed.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// Rerun refused the data or its output.
    #[error("{}: {source}", path.display())]
    Stream {
        /// The file.
        path: PathBuf,
        /// What Rerun said.
        source: Box<RecordingStreamError>,
    },
    /// The verdict of the recording is not what this version reads.
    #[error("recording: its verdict is not one that this version reads: {0}")]
    Verdict(serde_json::Error),
}

/// Writes `recording` for the Rerun viewer; `scenario` is its name there. What stood at `path` is replaced
/// only when the new file is complete; until then it is `<path>.tmp`, which is removed if anything fails.
///
/// # Errors
/// When the verdict cannot be read, or the file cannot be written.
pub fn save(recording: &Recording, scenario: &str, path: &Path) -> Result<(), RerunError> {
    let verdict = recording
        .verdict
        .as_deref()
        .map(|json| Verdict::parse(json, &recording.diagnostics))
        .transpose()
        .map_err(RerunError::Verdict)?;
    let run = Run { recording, verdict: verdict.as_ref(), end_ns: end(recording) };

    let mut temporary = OsString::from(path);
    temporary.push(".tmp");
    let temporary = PathBuf::from(temporary);
    let saved = write(&run, scenario, &temporary).and_then(|()| {
        let at_path = |source| RerunError::File { path: path.to_owned(), source };
        fs::rename(&temporary, path).map_err(at_path)
    });
    if saved.is_err() {
        // The first fault is the one to report.
        let _ = fs::remove_file(&temporary);
    }
    saved
}

fn write(run: &Run, scenario: &str, path: &Path) -> Result<(), RerunError> {
    let refused = |source| RerunError::Stream { path: path.to_owned(), source: Box::new(source) };
    let stream = RecordingStreamBuilder::new(APPLICATION)
        // The environment variable RERUN=off would leave an empty file without a word.
        .enabled(true)
        // The default blueprint alone is ignored by the web viewer.
        .with_blueprint(layout::blueprint(run))
        .save(path)
        .map_err(refused)?;
    log_everything(&stream, run, scenario).map_err(refused)?;
    stream.flush_blocking().map_err(|error| RerunError::File {
        path: path.to_owned(),
        source: io::Error::other(error.to_string()),
    })
}

fn log_everything(stream: &RecordingStream, run: &Run, scenario: &str) -> Result<(), RecordingStreamError> {
    // No wall clock reaches a recording.
    stream.set_log_time_enabled(false);
    stream.set_log_tick_enabled(false);
    stream.send_recording_name(scenario)?;
    scene::log(stream, run)?;
    plots::log(stream, run)?;
    lanes::log(stream, run)?;
    if let Some(verdict) = run.verdict {
        stream.log_static("verdict", &rerun::TextDocument::from_markdown(verdict.markdown(scenario)))?;
    }
    Ok(())
}

/// What is written.
struct Run<'a> {
    recording: &'a Recording,
    verdict: Option<&'a Verdict>,
    /// The last time of all series, ns.
    end_ns: i64,
}

fn end(recording: &Recording) -> i64 {
    let series = [
        recording.measured.time_ns.last(),
        recording.reference.time_ns.last(),
        recording.tool.time_ns.last(),
        recording.reference_tool.time_ns.last(),
        recording.object.time_ns.last(),
    ];
    let events = recording.events.last().map(|event| event.time_ns);
    let monitor = recording.monitor.last().map(|sample| sample.time_ns);
    series.into_iter().flatten().copied().chain(events).chain(monitor).max().unwrap_or(0)
}

/// Seconds as nanoseconds, to the nearest.
fn nanoseconds(seconds: f64) -> i64 {
    (seconds * 1e9).round() as i64
}

/// The column of times of a chunk, ns.
fn times(time_ns: impl IntoIterator<Item = i64>) -> TimeColumn {
    TimeColumn::new_duration_nanos(TIMELINE, time_ns)
}

/// Moves the stream's clock for the rows that follow.
fn set_time(stream: &RecordingStream, time_ns: i64) {
    stream.set_time(TIMELINE, TimeCell::from_duration_nanos(time_ns));
}

/// A colour without transparency, from 0xRRGGBB.
fn color(rgb: u32) -> rerun::Color {
    rerun::Color::from_u32((rgb << 8) | 0xff)
}

/// Violated, and the limits in plots.
const RED: u32 = 0x00d5_3028;

/// Colours that people with any kind of colour vision can tell apart (Okabe and Ito).
const PALETTE: [u32; 8] =
    [0x0056_b4e9, 0x0000_72b2, 0x00f0_e442, 0x0000_9e73, 0x00cc_79a7, 0x00e6_9f00, 0x00d5_5e00, 0x0099_9999];
