//! The files that a scenario is made of, each read once.

use std::{
    fs,
    path::{Component, Path, PathBuf},
};

use crate::fault::{Fault, Faults, Place, Source};

/// Files read so far; the index of one is the `source` of a [`Place`].
#[derive(Debug, Default)]
pub(crate) struct Files {
    pub(crate) sources: Vec<Source>,
}

impl Files {
    /// Reads a file and returns its index. What stops it is a fault at `asked_by`, or in the file itself
    /// when nothing asked for it.
    pub(crate) fn read(&mut self, path: &Path, asked_by: Option<&Place>, faults: &Faults) -> Option<usize> {
        let shown = shown(path);
        let problem = match fs::read(path) {
            Ok(bytes) => match String::from_utf8(bytes) {
                Ok(text) => {
                    self.sources.push(Source { path: shown, text });
                    return Some(self.sources.len() - 1);
                }
                Err(error) => format!("it is not UTF-8 text after byte {}", error.utf8_error().valid_up_to()),
            },
            Err(error) => reason(&error),
        };
        let at = match asked_by {
            Some(place) => place.clone(),
            None => {
                self.sources.push(Source { path: shown.clone(), text: String::new() });
                Place { source: self.sources.len() - 1, span: 0..0 }
            }
        };
        faults.report(Fault::new("unreadable-file", &at, format!("cannot read {shown}: {problem}"), problem));
        None
    }
}

/// What an error of the file system says, without the number of the operating system's error.
pub(crate) fn reason(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => "no such file".to_owned(),
        std::io::ErrorKind::PermissionDenied => "permission denied".to_owned(),
        std::io::ErrorKind::IsADirectory => "it is a folder".to_owned(),
        kind => kind.to_string(),
    }
}

/// `path` relative to the folder of `file`, without `.` and, where they cancel, `..`.
pub(crate) fn beside(file: &Path, path: &str) -> PathBuf {
    let joined = file.parent().unwrap_or(Path::new("")).join(path);
    let mut result = PathBuf::new();
    for component in joined.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir if matches!(result.components().next_back(), Some(Component::Normal(_))) => {
                result.pop();
            }
            other => result.push(other),
        }
    }
    result
}

/// A path as shown to people, with forward slashes.
pub(crate) fn shown(path: &Path) -> String {
    path.display().to_string().replace('\\', "/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_cancel() {
        assert_eq!(beside(Path::new("a/b/x.toml"), "../_cells/y.toml"), Path::new("a/_cells/y.toml"));
        assert_eq!(beside(Path::new("x.toml"), "../y.toml"), Path::new("../y.toml"));
        assert_eq!(beside(Path::new("../a/x.toml"), "../../y.toml"), Path::new("../../y.toml"));
    }
}
