//! From the words on the command line to scenario files.

use std::path::{Path, PathBuf};

use super::default_root;

/// A scenario to run.
#[derive(Clone, Debug)]
pub(super) struct Selected {
    /// Its name, e.g. `scara::pick_cube`.
    pub(super) name: String,
    /// Its file.
    pub(super) path: PathBuf,
}

/// The scenarios that the words name: files, folders, or names and prefixes of names under `scenarios`.
///
/// # Errors
/// A sentence when a folder cannot be read or a word names nothing.
pub(super) fn select(words: &[String]) -> Result<Vec<Selected>, String> {
    let mut selected: Vec<Selected> = Vec::new();
    for word in words {
        let path = Path::new(word);
        let found = if path.is_dir() {
            below(path)?
        } else if path.is_file() || path.extension().is_some_and(|extension| extension == "toml") {
            // A file that is missing is named by the loader, which says so like any other fault.
            vec![Selected { name: graspcheck_scenario::name_of(path), path: path.to_owned() }]
        } else {
            let named: Vec<Selected> = below(&default_root())?
                .into_iter()
                .filter(|scenario| scenario.name.starts_with(word.as_str()))
                .collect();
            if named.is_empty() {
                return Err(format!("{word}: no such file, folder or scenario; see graspcheck list"));
            }
            named
        };
        for scenario in found {
            if !selected.iter().any(|other| other.path == scenario.path) {
                selected.push(scenario);
            }
        }
    }
    Ok(selected)
}

/// All scenarios in a folder, sorted by name.
///
/// # Errors
/// A sentence when the folder cannot be read.
pub(super) fn below(root: &Path) -> Result<Vec<Selected>, String> {
    let listed = graspcheck_scenario::find(root).map_err(|error| error.to_string())?;
    Ok(listed.into_iter().map(|found| Selected { name: found.name, path: found.path }).collect())
}
