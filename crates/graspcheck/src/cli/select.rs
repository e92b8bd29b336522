//! From the words on the command line to scenario files.

use std::path::{Path, PathBuf};

use graspcheck::exit;
use graspcheck_scenario::Listed;

use super::default_root;

/// A scenario to run.
#[derive(Clone, Debug)]
pub(super) struct Selected {
    /// Its name, e.g. `scara::pick_cube`.
    pub(super) name: String,
    /// Its file.
    pub(super) path: PathBuf,
}

/// Why nothing can be run or listed.
#[derive(Debug)]
pub(super) struct Unselected {
    /// A sentence.
    pub(super) message: String,
    /// The exit code.
    pub(super) code: u8,
}

impl Unselected {
    fn nothing(message: String) -> Self {
        Self { message, code: exit::NOTHING_SELECTED }
    }
}

/// The scenarios that the words name: files, folders, or names and prefixes of names under `scenarios`.
///
/// # Errors
/// When a word names nothing, a folder holds no scenario, or one cannot be read.
pub(super) fn select(words: &[String]) -> Result<Vec<Selected>, Unselected> {
    let mut selected: Vec<Selected> = Vec::new();
    for word in words {
        let path = Path::new(word);
        let found = if path.exists() {
            below(path)?
        } else {
            let root = default_root();
            let named = if root.is_dir() { below(&root)? } else { Vec::new() };
            let named: Vec<Listed> =
                named.into_iter().filter(|scenario| scenario.name.starts_with(word.as_str())).collect();
            if named.is_empty() {
                return Err(no_such(word));
            }
            named
        };
        for Listed { name, path, .. } in found {
            if !selected.iter().any(|other| other.path == path) {
                selected.push(Selected { name, path });
            }
        }
    }
    Ok(selected)
}

/// All scenarios in a folder, sorted by name; the one in a file.
///
/// # Errors
/// When it is not there, cannot be read, or holds no scenario.
pub(super) fn below(root: &Path) -> Result<Vec<Listed>, Unselected> {
    if !root.exists() {
        return Err(no_such(&root.display().to_string()));
    }
    let found = graspcheck_scenario::find(root).map_err(|error| Unselected {
        message: format!("{}: cannot be read: {error}", root.display()),
        code: exit::INVALID_FILE,
    })?;
    if !found.is_empty() {
        return Ok(found);
    }
    let folder = if root.is_dir() { Some(root) } else { root.parent() };
    let why = if folder.is_some_and(graspcheck_scenario::holds_files_to_extend) {
        "; a folder whose name begins with `_` holds files to extend"
    } else {
        ""
    };
    Err(Unselected::nothing(format!("{}: there is no scenario here{why}", root.display())))
}

fn no_such(word: &str) -> Unselected {
    Unselected::nothing(format!("{word}: no such file, folder or scenario; see graspcheck list"))
}
