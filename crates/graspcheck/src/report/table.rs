//! The table of checks and the strip of phases, for a terminal of 100 columns.

use anstyle::{AnsiColor, Style};
use comfy_table::{CellAlignment, ContentArrangement, Table, presets};
use graspcheck_model::plan::Phase;
use graspcheck_verify::{Basis, CheckResult, Outcome, Verdict};

use super::{
    quantity::{against, instant, quantity},
    sentence::{is_lower_limit, motion, room, rounding, subject, word},
};

/// A failing row or word.
pub const FAILED: Style = AnsiColor::Red.on_default();
/// A passing word.
pub const PASSED: Style = AnsiColor::Green.on_default();
/// An undecided row or word.
pub const UNDECIDED: Style = AnsiColor::Yellow.on_default();
/// Secondary text.
pub const DIM: Style = Style::new().dimmed();
/// A scenario's name.
pub const NAME: Style = AnsiColor::Cyan.on_default();

/// Columns of the strip of phases.
const STRIP_WIDTH: usize = 96;

fn mark(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Pass => "",
        Outcome::Fail => "FAIL",
        Outcome::Inconclusive => "?",
        Outcome::NotRequested => "-",
    }
}

fn basis(result: &CheckResult) -> &'static str {
    match (result.outcome, result.basis) {
        (Outcome::NotRequested, _) => "not requested",
        (Outcome::Inconclusive, _) => "undecided",
        (_, Basis::Exact) => "exact",
        (_, Basis::Proved) => "proved",
        (_, Basis::Measured) => "measured",
    }
}

/// A finding as the words of a row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Words {
    /// The worst value, with `≥` or `≤` when it is a bound.
    pub value: String,
    /// What it is held against.
    pub limit: String,
    /// The room left, with its sign.
    pub margin: String,
    /// When it is worst.
    pub at: String,
    /// Where, and in which phase.
    pub place: String,
    /// How it is known.
    pub by: &'static str,
}

/// The words of a finding; `–` for what it does not have.
#[must_use]
pub fn words(result: &CheckResult) -> Words {
    let dash = || "–".to_owned();
    let (value, limit) = match (result.value, result.limit) {
        (Some(value), Some(limit)) => against(value, limit, result.unit, rounding(result)),
        (Some(value), None) => (quantity(value, result.unit, rounding(result)), dash()),
        (None, Some(limit)) => (dash(), quantity(limit, result.unit, super::Rounding::Nearest)),
        (None, None) => (dash(), dash()),
    };
    let sign = match (result.value_is_bound && result.value.is_some(), is_lower_limit(result)) {
        (false, _) => "",
        (true, true) => "≥ ",
        (true, false) => "≤ ",
    };
    let place = match &result.place.phase {
        Some(phase) if result.place.subjects.is_empty() => phase.clone(),
        Some(phase) => format!("{}, {phase}", subject(result)),
        None => subject(result),
    };
    Words {
        value: format!("{sign}{value}"),
        limit,
        margin: room(result).unwrap_or_else(dash),
        at: result.time.map_or_else(dash, instant),
        place,
        by: basis(result),
    }
}

/// The checks as a table, planned ones before executed ones, with styles for a terminal. Of a run that was
/// not executed one row stands for all checks of the execution.
#[must_use]
pub fn checks(verdict: &Verdict) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_content_arrangement(ContentArrangement::Disabled);
    table.add_row(["", "check", "worst", "limit", "margin", "at", "where", "by"]);
    let mut styles = vec![DIM];
    let mut current = "";
    let plan_alone = verdict.is_of_plan_alone();
    for result in &verdict.checks {
        if motion(&result.check) != current {
            current = motion(&result.check);
            table.add_row(["", current]);
            styles.push(DIM);
            if current == "executed" && plan_alone {
                table.add_row(["-", "all checks", "–", "–", "–", "–", "–", "not executed"]);
                styles.push(DIM);
            }
        }
        if current == "executed" && plan_alone {
            continue;
        }
        let Words { value, limit, margin, at, place, by } = words(result);
        table.add_row([mark(result.outcome), &word(&result.check), &value, &limit, &margin, &at, &place, by]);
        styles.push(match result.outcome {
            Outcome::Fail => FAILED,
            Outcome::Inconclusive => UNDECIDED,
            Outcome::NotRequested => DIM,
            Outcome::Pass => Style::new(),
        });
    }
    for column in 0..8 {
        if let Some(column) = table.column_mut(column) {
            column.set_padding((0, 2));
            column.set_cell_alignment(CellAlignment::Left);
        }
    }
    table.lines().zip(styles).map(|(line, style)| format!("{style}{}{style:#}\n", line.trim_end())).collect()
}

/// The phases on a ruler of time, and below it a mark where each violation begins.
#[must_use]
pub fn strip(phases: &[Phase], results: &[CheckResult]) -> String {
    let Some(end) = phases.last().map(|phase| phase.end).filter(|end| *end > 0.0) else {
        return String::new();
    };
    let column = |t: f64| ((t / end * STRIP_WIDTH as f64).round() as usize).min(STRIP_WIDTH);
    let mut lane: Vec<char> = vec!['─'; STRIP_WIDTH + 1];
    for phase in phases {
        let (from, to) = (column(phase.start), column(phase.end));
        lane[from] = '├';
        // The name, as much of it as has room.
        for (slot, letter) in lane[(from + 1).min(to)..to].iter_mut().zip(phase.name.chars()) {
            *slot = letter;
        }
    }
    lane[STRIP_WIDTH] = '┤';
    let end_label = instant(end);
    let ruler: String = format!("0.0{end_label:>width$}", width = STRIP_WIDTH - 2);
    let mut text = format!("  {ruler}\n  {}\n", lane.into_iter().collect::<String>());
    let mut failing: Vec<(usize, String)> = results
        .iter()
        .filter(|result| result.outcome == Outcome::Fail)
        .filter_map(|result| {
            let t = result.violated.map(|[first, _]| first).or(result.time)?;
            Some((column(t.min(end)), format!("▲ {}", word(&result.check))))
        })
        .collect();
    failing.sort();
    // Marks that would overlap go to further lines.
    while !failing.is_empty() {
        let mut line = String::new();
        failing.retain(|(at, mark)| {
            let room = line.chars().count() <= *at;
            if room {
                line = format!("{line:at$}{mark} ");
            }
            !room
        });
        text.push_str(&format!("  {FAILED}{}{FAILED:#}\n", line.trim_end()));
    }
    text
}
