//! Why a recording cannot be checked at all.

/// Why a recording cannot be checked at all. What can be checked, and is wrong, is a [`crate::Finding`].
#[derive(Debug, thiserror::Error)]
pub enum CheckerError {
    /// A document is not in the recording.
    #[error("{name}: the recording has no such attachment; it was not made by a run of graspcheck")]
    Missing {
        /// Its name.
        name: &'static str,
    },
    /// A document cannot be decoded: it is not JSON, lacks a field, or holds a solid, rotation or direction
    /// that is none.
    #[error("{name}: the document cannot be read: {source}")]
    Undecodable {
        /// Its name.
        name: &'static str,
        /// What is wrong, with line and column.
        source: serde_json::Error,
    },
    /// A document has a form that this checker does not know.
    #[error(
        "{name}: schema {found} is unknown, this checker reads 1 to {known}; use that of the run's version"
    )]
    UnknownSchema {
        /// Its name.
        name: &'static str,
        /// Its schema number.
        found: u32,
        /// The newest that is known.
        known: u32,
    },
    /// A document contradicts itself or the others, so that nothing is said that could be checked.
    #[error("{name}: {what}")]
    Unsound {
        /// The document.
        name: &'static str,
        /// What is wrong with it.
        what: String,
    },
}
