//! What is wrong with a file, as plain data. Only the binary renders it.

use std::{fmt, ops::Range};

/// One thing that is wrong with one place in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// A stable word for this kind of fault, e.g. `unknown-key`.
    pub code: String,
    /// One line: place, quantity, value, limit.
    pub title: String,
    /// Index into [`LoadError::sources`].
    pub source: usize,
    /// Bytes of that source's text; empty at its start when the fault has no place in it.
    pub span: Range<usize>,
    /// A few words that stand under the marked text.
    pub label: String,
    /// What to change, where that is known.
    pub help: Option<Help>,
    /// Where the other half of a contradiction stands.
    pub second: Option<SecondPlace>,
}

/// What to change.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Help {
    /// A sentence.
    pub text: String,
    /// The text that would stand in place of the fault's span.
    pub replacement: Option<String>,
}

/// A second place that a fault refers to, e.g. where a limit comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SecondPlace {
    /// Index into [`LoadError::sources`].
    pub source: usize,
    /// Bytes of that source's text.
    pub span: Range<usize>,
    /// A few words that stand under the marked text.
    pub label: String,
}

/// A file that was read, for showing lines of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// Its path as shown to people: with forward slashes, relative when the first one was.
    pub path: String,
    /// Its text; empty when it could not be read.
    pub text: String,
}

/// All that is wrong with a scenario, its cell and its robot.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct LoadError {
    /// At least one, in the order of the sources and of the places in them.
    pub faults: Vec<Fault>,
    /// The files that were read; the first is the scenario.
    pub sources: Vec<Source>,
}

/// A byte range of one source.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Place {
    pub(crate) source: usize,
    pub(crate) span: Range<usize>,
}

impl Fault {
    pub(crate) fn new(
        code: &'static str,
        at: &Place,
        title: impl Into<String>,
        label: impl Into<String>,
    ) -> Self {
        Self {
            code: code.to_owned(),
            title: title.into(),
            source: at.source,
            span: at.span.clone(),
            label: label.into(),
            help: None,
            second: None,
        }
    }

    /// Says what to change, in words.
    pub(crate) fn help(mut self, text: impl Into<String>) -> Self {
        self.help = Some(Help { text: text.into(), replacement: None });
        self
    }

    /// Says what to write in place of the marked text.
    pub(crate) fn replace(mut self, text: impl Into<String>, replacement: impl Into<String>) -> Self {
        self.help = Some(Help { text: text.into(), replacement: Some(replacement.into()) });
        self
    }

    /// Gives advice that is no text to write.
    pub(crate) fn saying(mut self, text: impl Into<String>) -> Self {
        self.help = Some(Help { text: text.into(), replacement: None });
        self
    }

    /// Points to a second place.
    pub(crate) fn second(mut self, at: &Place, label: impl Into<String>) -> Self {
        self.second = Some(SecondPlace { source: at.source, span: at.span.clone(), label: label.into() });
        self
    }
}

impl fmt::Display for LoadError {
    /// One line for each fault: `path:line:column: title`.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, fault) in self.faults.iter().enumerate() {
            if index > 0 {
                writeln!(formatter)?;
            }
            let source = &self.sources[fault.source];
            let (line, column) = source.line_column(fault.span.start);
            write!(formatter, "{}:{line}:{column}: {}", source.path, fault.title)?;
        }
        Ok(())
    }
}

impl Source {
    /// Line and column of a byte of the text, both counted from 1; a column is a character.
    #[must_use]
    pub fn line_column(&self, byte: usize) -> (usize, usize) {
        let before = self.text.get(..byte).unwrap_or(&self.text);
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
    }
}

/// Collects faults, so that reading goes on after the first.
#[derive(Debug, Default)]
pub(crate) struct Faults {
    list: std::cell::RefCell<Vec<Fault>>,
}

impl Faults {
    pub(crate) fn report(&self, fault: Fault) {
        self.list.borrow_mut().push(fault);
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.list.borrow().is_empty()
    }

    /// Whether files were read in part only, so that what seems to be missing may stand in the rest.
    pub(crate) fn lack_a_part(&self) -> bool {
        let codes = ["syntax", "extends", "unreadable-file"];
        self.list.borrow().iter().any(|fault| codes.contains(&fault.code.as_str()))
    }

    /// All faults, ordered by source and place, each once.
    ///
    /// Where a file is not valid TOML, a key that seems to be missing may stand in a line that could not be
    /// read, and a value that contains the error is not what was meant: neither is reported.
    pub(crate) fn into_sorted(self) -> Vec<Fault> {
        let mut list = self.list.into_inner();
        let broken: Vec<(usize, usize)> = list
            .iter()
            .filter(|fault| fault.code == "syntax")
            .map(|fault| (fault.source, fault.span.start))
            .collect();
        list.retain(|fault| {
            let mut here =
                broken.iter().filter(|(source, _)| *source == fault.source).map(|(_, start)| start);
            match fault.code.as_str() {
                "syntax" => true,
                "missing-key" => here.next().is_none(),
                _ => !here.any(|start| fault.span.contains(start)),
            }
        });
        list.sort_by_key(|fault| (fault.source, fault.span.start, fault.span.end));
        list.dedup();
        list
    }
}
