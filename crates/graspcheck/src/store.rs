//! Where results are written, and how: finished under a temporary name, then renamed.

use std::path::{Path, PathBuf};

use graspcheck_recording::{Recording, RecordingError};

/// The files of one run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stored {
    /// The MCAP log.
    pub log: PathBuf,
    /// The Rerun recording; none when graspcheck is built without the feature `rerun`.
    pub rerun: Option<PathBuf>,
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

/// Writes the log, and with the feature `rerun` the Rerun recording beside it, into the folder of the
/// scenario under `root`: `run.mcap`, or `plan.mcap` for a recording without an execution, which does not take
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
    Ok(Stored { log, rerun })
}
