//! The verdict of a recording, from its JSON, and the table that shows it.

use std::{collections::BTreeMap, fmt::Write as _};

use graspcheck_recording::Diagnostic;
use serde::Deserialize;

/// How a check came out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Outcome {
    /// In the order in which a reader wants to see them.
    Fail,
    Inconclusive,
    Pass,
    NotRequested,
}

/// What one check found; values in SI units, times in s.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Check {
    pub(crate) check: String,
    pub(crate) outcome: Outcome,
    pub(crate) limit: Option<f64>,
    pub(crate) margin: Option<f64>,
    pub(crate) margin_is_share: bool,
    pub(crate) time: Option<f64>,
    pub(crate) violated: Option<[f64; 2]>,
    /// The same for people, with units, by name: `value`, `limit`, `margin`, `at`, `where`; from the
    /// diagnostics of the recording, so that all renderings read alike.
    #[serde(skip)]
    words: BTreeMap<String, String>,
}

/// The judgement of a run.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Verdict {
    pub(crate) outcome: Outcome,
    pub(crate) as_expected: bool,
    pub(crate) checks: Vec<Check>,
}

/// Rows of the table; the full one is in the terminal.
const MOST_ROWS: usize = 8;

impl Verdict {
    /// The verdict in `json`, with the words that the diagnostics have for each check.
    pub(crate) fn parse(json: &str, diagnostics: &[Diagnostic]) -> Result<Self, serde_json::Error> {
        let mut verdict: Self = serde_json::from_str(json)?;
        for check in &mut verdict.checks {
            if let Some(diagnostic) = diagnostics.iter().find(|diagnostic| diagnostic.name == check.check) {
                check.words = diagnostic.values.iter().cloned().collect();
            }
        }
        Ok(verdict)
    }

    /// The checks that count, failing ones first, then undecided ones, then passing ones with the least room.
    pub(crate) fn ranked(&self) -> Vec<&Check> {
        let mut checks: Vec<&Check> =
            self.checks.iter().filter(|check| check.outcome != Outcome::NotRequested).collect();
        checks.sort_by(|a, b| {
            let room = |check: &Check| check.room().unwrap_or(f64::INFINITY);
            a.outcome.cmp(&b.outcome).then(match a.outcome {
                Outcome::Pass => room(a).total_cmp(&room(b)),
                _ => std::cmp::Ordering::Equal,
            })
        });
        checks
    }

    /// The checks that fail.
    pub(crate) fn failing(&self) -> impl Iterator<Item = &Check> {
        self.checks.iter().filter(|check| check.outcome == Outcome::Fail)
    }

    /// The limit of the first of these checks that has one.
    pub(crate) fn limit(&self, names: &[&str]) -> Option<f64> {
        names.iter().find_map(|name| self.checks.iter().find(|check| check.check == *name)?.limit)
    }

    /// The first violation of all, s: from when to when.
    pub(crate) fn first_violation(&self) -> Option<[f64; 2]> {
        self.failing().filter_map(Check::interval).min_by(|a, b| a[0].total_cmp(&b[0]))
    }

    /// The verdict as Markdown: the answer, then a table.
    pub(crate) fn markdown(&self, scenario: &str) -> String {
        let ranked = self.ranked();
        let count = |outcome| ranked.iter().filter(|check| check.outcome == outcome).count();
        let word = match self.outcome {
            Outcome::Fail => "FAIL",
            Outcome::Pass => "PASS",
            Outcome::Inconclusive | Outcome::NotRequested => "INCONCLUSIVE",
        };
        let mut text = format!("# {word}  {}\n\n", escaped(scenario));
        let expected = if self.as_expected { "as expected" } else { "**not as expected**" };
        match self.outcome {
            Outcome::Fail => {
                _ = write!(text, "{} of {} checks failed, {expected}.", count(Outcome::Fail), ranked.len());
                if let Some([first, _]) = self.first_violation() {
                    _ = write!(text, " First: **{first:.3} s**");
                }
            }
            Outcome::Pass => _ = write!(text, "{} checks passed, {expected}.", ranked.len()),
            Outcome::Inconclusive | Outcome::NotRequested => {
                let undecided = count(Outcome::Inconclusive);
                _ = write!(text, "{undecided} of {} checks could not be decided.", ranked.len());
            }
        }
        text.push_str("\n\n| check | value | limit | margin | at | where |\n|---|---|---|---|---|---|\n");
        for check in ranked.iter().take(MOST_ROWS) {
            let name = match check.outcome {
                Outcome::Fail => format!("**{}**", escaped(&check.check)),
                Outcome::Inconclusive => format!("? {}", escaped(&check.check)),
                Outcome::Pass | Outcome::NotRequested => escaped(&check.check),
            };
            let cells = ["value", "limit", "margin", "at", "where"].map(|word| escaped(check.word(word)));
            _ = writeln!(text, "| {name} | {} |", cells.join(" | "));
        }
        if ranked.len() > MOST_ROWS {
            _ = write!(text, "\nand {} more that passed or have more room", ranked.len() - MOST_ROWS);
        }
        text
    }
}

impl Check {
    /// Room left as a share of the limit; none without a margin or with a limit of 0.
    fn room(&self) -> Option<f64> {
        let margin = self.margin?;
        if self.margin_is_share {
            return Some(margin);
        }
        self.limit.filter(|limit| *limit != 0.0).map(|limit| margin / limit.abs())
    }

    /// A value in words; `–` when the diagnostics have none.
    pub(crate) fn word(&self, name: &str) -> &str {
        self.words.get(name).map_or("–", String::as_str)
    }

    /// When it is violated, s; the instant of its worst value when no interval is known.
    pub(crate) fn interval(&self) -> Option<[f64; 2]> {
        self.violated.or(self.time.map(|time| [time, time]))
    }
}

/// Text that Markdown shows as it is.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '\\' | '`' | '*' | '_' | '[' | ']' | '<' | '>' | '|' | '#' => escaped.extend(['\\', letter]),
            '\n' | '\r' => escaped.push(' '),
            letter => escaped.push(letter),
        }
    }
    escaped
}

#[cfg(test)]
pub(crate) mod tests {
    use graspcheck_recording::Level;

    use super::*;

    /// Two failing checks, one undecided, two passing, one that was not requested.
    pub(crate) const JSON: &str = include_str!("../tests/verdict.json");

    fn words(name: &str, cells: [&str; 5]) -> Diagnostic {
        let names = ["value", "limit", "margin", "at", "where"];
        Diagnostic {
            name: name.to_owned(),
            level: Level::Info,
            message: String::new(),
            values: names.into_iter().zip(cells).map(|(k, v)| (k.to_owned(), v.to_owned())).collect(),
        }
    }

    #[test]
    fn the_table_has_failures_first_and_what_was_not_requested_never() {
        let diagnostics = [
            words("planned.jerk", ["41505 °/s³", "40000 °/s³", "-3.8 %", "1.529 s", "shoulder, carry"]),
            words("planned.clearance", ["4.07 mm", "5.00 mm", "-0.93 mm", "1.770 s", "cube - wall_1, lower"]),
            words("planned.velocity", ["540 mm/s", "600 mm/s", "+10.0 %", "0.150 s", "quill, approach"]),
        ];
        let markdown = Verdict::parse(JSON, &diagnostics).unwrap().markdown("scara::pick_over_wall");
        let expected = "\
# FAIL  scara::pick\\_over\\_wall

2 of 6 checks failed, as expected. First: **1.529 s**

| check | value | limit | margin | at | where |
|---|---|---|---|---|---|
| **planned.jerk** | 41505 °/s³ | 40000 °/s³ | -3.8 % | 1.529 s | shoulder, carry |
| **planned.clearance** | 4.07 mm | 5.00 mm | -0.93 mm | 1.770 s | cube - wall\\_1, lower |
| ? executed.clearance | – | – | – | – | – |
| planned.acceleration | – | – | – | – | – |
| planned.velocity | 540 mm/s | 600 mm/s | +10.0 % | 0.150 s | quill, approach |
| planned.torque | – | – | – | – | – |
";
        assert_eq!(markdown, expected);
    }

    #[test]
    fn the_first_violation_is_the_earliest() {
        assert_eq!(Verdict::parse(JSON, &[]).unwrap().first_violation(), Some([1.5287, 1.719]));
    }
}
