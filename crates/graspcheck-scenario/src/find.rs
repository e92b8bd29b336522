//! Which scenarios there are, and what they are called.

use std::{
    ffi::OsStr,
    fs, io,
    path::{Component, Path, PathBuf, absolute},
};

use crate::{
    fault::Faults,
    tree::{self, Value},
};

/// A scenario file that was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Listed {
    /// Its name, as [`name_of`] gives it.
    pub name: String,
    /// Where it is.
    pub path: PathBuf,
    /// Its `title`; empty when it has none that can be read.
    pub title: String,
}

/// Keys at the top of TOML files that are not scenarios: of a robot, of a Rust package and of a workspace.
const OF_OTHER_FILES: [&str; 3] = ["urdf", "package", "workspace"];

/// All scenarios at or below `root`, sorted by name: every `*.toml` except baselines (`*.baseline.toml`), files
/// in folders that start with `_`, which hold files to extend, and files of robots. A `root` that is a file is
/// the only one.
///
/// # Errors
/// When `root` or a folder below it cannot be read.
pub fn find(root: &Path) -> io::Result<Vec<Listed>> {
    let mut found = Vec::new();
    if root.is_dir() {
        if !holds_files_to_extend(root) {
            walk(root, &mut found)?;
        } else {
            fs::read_dir(root)?;
        }
    } else {
        let (listed, _) = listed(root.to_path_buf())?;
        if !root.parent().is_some_and(holds_files_to_extend) {
            found.push(listed);
        }
    }
    found.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(found)
}

/// Whether the name of a folder begins with `_`: its files are there to be extended, and are no scenarios.
#[must_use]
pub fn holds_files_to_extend(folder: &Path) -> bool {
    let folder = absolute(folder).unwrap_or_else(|_| folder.to_path_buf());
    folder.file_name().and_then(OsStr::to_str).is_some_and(|name| name.starts_with('_'))
}

fn walk(folder: &Path, found: &mut Vec<Listed>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let Some(name) = path.file_name().and_then(OsStr::to_str) else { continue };
        if path.is_dir() {
            if !name.starts_with(['_', '.']) {
                walk(&path, found)?;
            }
        } else if name.ends_with(".toml") && !name.ends_with(".baseline.toml") {
            let (listed, is_other) = listed(path)?;
            if !is_other {
                found.push(listed);
            }
        }
    }
    Ok(())
}

/// The file as it is listed, and whether it is known to be no scenario. A file in which nothing can be read
/// counts as one, so that its faults are shown.
fn listed(path: PathBuf) -> io::Result<(Listed, bool)> {
    let text = String::from_utf8_lossy(&fs::read(&path)?).into_owned();
    let table = tree::parse(&text, 0, &Faults::default());
    let title = match table.entries.get("title").map(|entry| &entry.node.value) {
        Some(Value::Text(title)) => title.clone(),
        _ => String::new(),
    };
    let is_other = OF_OTHER_FILES.iter().any(|key| table.entries.contains_key(*key));
    Ok((Listed { name: name_of(&path), path, title }, is_other))
}

/// The name of the scenario at `path`, e.g. `scara::pick_cube`: the folders after the last one that is called
/// `scenarios` and the file's name without its ending, joined by `::`. Without such a folder, the file's
/// folder counts.
#[must_use]
pub fn name_of(path: &Path) -> String {
    let path = absolute(path).unwrap_or_else(|_| path.to_path_buf()).with_extension("");
    let words: Vec<String> = path
        .components()
        .filter_map(|component| match component {
            Component::Normal(word) => Some(word.to_string_lossy().into_owned()),
            _ => None,
        })
        .collect();
    let start = match words.iter().rposition(|word| word == "scenarios") {
        Some(root) if root + 1 < words.len() => root + 1,
        _ => words.len().saturating_sub(2),
    };
    words[start..].join("::")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_start_below_scenarios() {
        assert_eq!(name_of(Path::new("scenarios/scara/pick_cube.toml")), "scara::pick_cube");
        assert_eq!(name_of(Path::new("/home/me/scenarios/own/deep/a.toml")), "own::deep::a");
        assert_eq!(name_of(Path::new("/home/me/cells/left/pick.toml")), "left::pick");
    }
}
