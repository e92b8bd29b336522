//! Where results are written, and how: finished under a temporary name, then renamed.

use std::path::{Path, PathBuf};

use graspcheck_recording::{Recording, RecordingError};
use graspcheck_verify::{Evidence, EvidenceError, Verdict};

use crate::html;

/// The files of one run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stored {
    /// The MCAP log.
    pub log: PathBuf,
    /// The Rerun recording; none when graspcheck is built without the feature `rerun`.
    pub rerun: Option<PathBuf>,
    /// The report for a browser; none of a recording that was not judged.
    pub report: Option<PathBuf>,
}

/// Why results could not be written.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The folder cannot be made.
    #[error("{}: the folder cannot be made: {source}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The log cannot be written.
    #[error(transparent)]
    Log(#[from] RecordingError),
    /// What a report is made from is not in the recording.
    #[error(transparent)]
    Evidence(#[from] EvidenceError),
    /// The report cannot be written.
    #[error("{}: the report cannot be written: {source}", path.display())]
    Report {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The Rerun file cannot be written.
    #[cfg(feature = "rerun")]
    #[error(transparent)]
    Rerun(#[from] graspcheck_rerun::RerunError),
}

/// The folder of a scenario's results: `scara::pick_cube` under `root` is `root/scara/pick_cube`.
#[must_use]
pub fn folder(root: &Path, scenario: &str) -> PathBuf {
    scenario.split("::").fold(root.to_owned(), |path, part| path.join(part))
}

/// Writes the log, the report of its verdict, and with the feature `rerun` the Rerun recording beside it, into the
/// folder of the scenario under `root`: `run.mcap`, `run.html`, `run.rrd`; `plan.*` for a recording without an execution, which does not take
/// the place of one with it. A file of an earlier run is replaced as a whole, or not at all.
///
/// # Errors
/// When the folder cannot be made or a file cannot be written.
pub fn store(recording: &Recording, scenario: &str, root: &Path) -> Result<Stored, StoreError> {
    let folder = folder(root, scenario);
    std::fs::create_dir_all(&folder).map_err(|source| StoreError::Folder { path: folder.clone(), source })?;
    let name = if recording.measured.is_empty() { "plan" } else { "run" };
    let log = folder.join(format!("{name}.mcap"));
    graspcheck_recording::save(recording, &log)?;
    #[cfg(feature = "rerun")]
    let rerun = {
        let path = folder.join(format!("{name}.rrd"));
        graspcheck_rerun::save(recording, scenario, &path)?;
        Some(path)
    };
    #[cfg(not(feature = "rerun"))]
    let rerun = None;
    let report = match &recording.verdict {
        None => None,
        Some(verdict) => {
            let verdict = Verdict::from_json(verdict)?;
            let page = html::page(&Evidence::from_recording(recording)?, &verdict, &format!("{name}.mcap"));
            let path = folder.join(format!("{name}.html"));
            write(&path, page.as_bytes())
                .map_err(|source| StoreError::Report { path: path.clone(), source })?;
            Some(path)
        }
    };
    Ok(Stored { log, rerun, report })
}

/// Writes the index of a suite, `index.html`, into `root`, and returns its path.
///
/// # Errors
/// When the file cannot be written.
pub fn store_index(entries: &[html::Entry], root: &Path) -> Result<PathBuf, StoreError> {
    let path = root.join("index.html");
    write(&path, html::index(entries).as_bytes())
        .map_err(|source| StoreError::Report { path: path.clone(), source })?;
    Ok(path)
}

/// Writes a file under a temporary name and then gives it its own.
fn write(path: &Path, content: &[u8]) -> std::io::Result<()> {
    let temporary = path.with_extension("html.tmp");
    std::fs::write(&temporary, content)?;
    std::fs::rename(&temporary, path)
}
