//! A TOML file as an owned tree in which every key and value knows its place.

use std::{collections::BTreeMap, ops::Range};

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::fault::{Fault, Faults, Place};

/// A value and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Node {
    pub(crate) at: Place,
    pub(crate) value: Value,
}

/// The values of TOML that our files use.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    Bool(bool),
    Integer(i64),
    Float(f64),
    Text(String),
    /// Dates and times, which no key of ours takes.
    Date,
    Array(Vec<Node>),
    Table(Table),
}

/// Entries by key.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Table {
    /// The header or the braces; empty for the file itself.
    pub(crate) at: Place,
    pub(crate) entries: BTreeMap<String, Entry>,
}

/// A key with its value.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Entry {
    pub(crate) key_at: Place,
    pub(crate) node: Node,
}

impl Value {
    /// What kind of value it is, with its article, for messages.
    pub(crate) fn kind(&self) -> &'static str {
        match self {
            Self::Bool(_) => "true or false",
            Self::Integer(_) | Self::Float(_) => "a number",
            Self::Text(_) => "text",
            Self::Date => "a date",
            Self::Array(_) => "a list",
            Self::Table(_) => "a table",
        }
    }
}

impl Node {
    /// The `name` of a table in a named list.
    pub(crate) fn name(&self) -> Option<&str> {
        let Value::Table(table) = &self.value else { return None };
        match &table.entries.get("name")?.node.value {
            Value::Text(name) => Some(name),
            _ => None,
        }
    }
}

/// The tree of a TOML text. Syntax errors are reported; what could be read besides them is returned.
pub(crate) fn parse(text: &str, source: usize, faults: &Faults) -> Table {
    let (root, errors) = DeTable::parse_recoverable(text);
    for (span, message) in first_of_each_cascade(text, errors) {
        let at = Place { source, span };
        faults.report(Fault::new("syntax", &at, format!("not valid TOML: {message}"), "here"));
    }
    table(root.get_ref(), Place { source, span: 0..0 }, faults)
}

/// An unclosed bracket makes errors in every line after it: of a run of lines with errors only the first
/// tells something, except that the last may say what was left open.
fn first_of_each_cascade(text: &str, errors: Vec<toml::de::Error>) -> Vec<(Range<usize>, String)> {
    let mut errors: Vec<_> =
        errors.into_iter().map(|error| (error.span().unwrap_or(0..0), error.message().to_owned())).collect();
    errors.sort_by_key(|(span, _)| (span.start, span.end));
    let lines: Vec<&str> = text.lines().collect();
    let line_of = |byte: usize| text.get(..byte).unwrap_or(text).matches('\n').count();
    let mut kept: Vec<(Range<usize>, String)> = Vec::new();
    let mut last_line = 0;
    for (span, message) in errors {
        let line = line_of(span.start);
        let between = lines.get(last_line + 1..line).unwrap_or_default();
        let goes_on = between.iter().all(|line| line.trim().is_empty());
        last_line = line;
        match kept.last_mut() {
            Some((_, first)) if goes_on => {
                if message.starts_with("unclosed") {
                    *first = message;
                }
            }
            _ => kept.push((span, message)),
        }
    }
    kept
}

fn table(table: &DeTable<'_>, at: Place, faults: &Faults) -> Table {
    let source = at.source;
    let entries = table.iter().map(|(key, value)| {
        let key_at = Place { source, span: key.span() };
        (key.get_ref().to_string(), Entry { key_at, node: node(value, source, faults) })
    });
    let entries = entries.collect();
    Table { at, entries }
}

fn node(spanned: &Spanned<DeValue<'_>>, source: usize, faults: &Faults) -> Node {
    let at = Place { source, span: spanned.span() };
    let value = match spanned.get_ref() {
        DeValue::Boolean(value) => Value::Bool(*value),
        DeValue::String(text) => Value::Text(text.to_string()),
        DeValue::Datetime(_) => Value::Date,
        DeValue::Integer(digits) => match i64::from_str_radix(digits.as_str(), digits.radix()) {
            Ok(value) => Value::Integer(value),
            Err(_) => {
                faults.report(Fault::new(
                    "range",
                    &at,
                    "this whole number is too large",
                    "more than 64 bits",
                ));
                Value::Integer(0)
            }
        },
        // The grammar of TOML admits only what `f64` can parse; too large a number becomes infinite, which
        // the reader of the key refuses.
        DeValue::Float(digits) => Value::Float(digits.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Array(items) => Value::Array(items.iter().map(|item| node(item, source, faults)).collect()),
        DeValue::Table(inner) => Value::Table(table(inner, at.clone(), faults)),
    };
    Node { at, value }
}
