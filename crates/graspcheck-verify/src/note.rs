//! What a table cannot say about a finding: a sentence whose numbers keep their units, so that every rendering
//! shows them as it shows all others.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::verdict::Unit;

/// A sentence of words and quantities. Its [`Display`](fmt::Display) form has SI units.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Note {
    /// In the order in which they are read.
    pub parts: Vec<NotePart>,
}

/// A part of a [`Note`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NotePart {
    /// Words, with the spaces around them.
    Words(String),
    /// A number with its unit.
    Quantity {
        /// The number, SI.
        value: f64,
        /// Its unit.
        unit: Unit,
    },
}

impl Note {
    /// Whether it says nothing.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.parts.is_empty()
    }

    /// The note with words at its end.
    #[must_use]
    pub fn and(mut self, words: impl Into<String>) -> Self {
        self.parts.push(NotePart::Words(words.into()));
        self
    }

    /// The note with a quantity at its end, SI; one that is not finite is kept as a word, for JSON has no such
    /// number.
    #[must_use]
    pub fn quantity(mut self, value: f64, unit: Unit) -> Self {
        if !value.is_finite() {
            return self.and(format!("{value}"));
        }
        self.parts.push(NotePart::Quantity { value, unit });
        self
    }

    /// The note with a vector at its end, the same unit for its three coordinates.
    #[must_use]
    pub fn vector(self, [x, y, z]: [f64; 3], unit: Unit) -> Self {
        let all = self.and("(").quantity(x, unit).and(", ").quantity(y, unit);
        all.and(", ").quantity(z, unit).and(")")
    }
}

impl From<&str> for Note {
    fn from(words: &str) -> Self {
        Self::default().and(words)
    }
}

impl From<String> for Note {
    fn from(words: String) -> Self {
        Self::default().and(words)
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.parts.iter().try_for_each(|part| match part {
            NotePart::Words(words) => f.write_str(words),
            NotePart::Quantity { value, unit } => match unit.symbol() {
                "" => write!(f, "{value}"),
                symbol => write!(f, "{value} {symbol}"),
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_note_reads_as_a_sentence_in_si_units() {
        let note =
            Note::from("depth ").quantity(1e-4, Unit::Meter).and(", ").quantity(f64::NAN, Unit::Newton);
        assert_eq!(note.to_string(), "depth 0.0001 m, NaN");
        let place = Note::default().vector([1.0, 0.5, 0.0], Unit::Meter);
        assert_eq!(place.to_string(), "(1 m, 0.5 m, 0 m)");
    }

    #[test]
    fn json_keeps_words_and_quantities() {
        let note = Note::from("at ").quantity(0.25, Unit::Second).and(" {}");
        let json = serde_json::to_string(&note).unwrap();
        assert_eq!(json, r#"[{"words":"at "},{"quantity":{"value":0.25,"unit":"second"}},{"words":" {}"}]"#);
        assert_eq!(serde_json::from_str::<Note>(&json).unwrap(), note);
    }
}
