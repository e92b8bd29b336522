//! The index of a suite: every scenario with its answer, and the margins of all checks of all scenarios.

use std::collections::BTreeSet;

use graspcheck_verify::{CheckResult, Outcome, Verdict};
use maud::{Markup, html};

use super::{
    document,
    page::{class, mark},
};
use crate::report::{self, motion, word};

/// A margin below this share of its limit is near.
const TIGHT: f64 = 0.1;

/// A scenario of a suite: its verdict, and its report relative to the index, or why it was not run.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Name of the scenario.
    pub name: String,
    /// What came out.
    pub result: Result<(Verdict, String), String>,
    /// Whether that is what the scenario expects.
    pub as_expected: bool,
}

/// The index of a suite as a page of HTML: what is not as expected first, then the tightest first.
#[must_use]
pub fn index(entries: &[Entry]) -> String {
    let mut entries: Vec<&Entry> = entries.iter().collect();
    entries.sort_by(|a, b| rank(a).cmp(&rank(b)).then(room(a).total_cmp(&room(b))).then(a.name.cmp(&b.name)));
    let count = |of: usize| entries.iter().filter(|entry| rank(entry) == of).count();
    let content = html! {
        header {
            h1 { (entries.len()) " scenarios" }
            p { (count(2)) " as expected · "
                span.failed[count(0) > 0] { (count(0)) " not as expected" } " · " (count(1)) " inconclusive" }
        }
        main {
            h2 { "Scenarios" }
            div.wide { table {
                thead { tr { @for head in ["", "scenario", "worst check", "value", "limit", "margin"] { th scope="col" { (head) } } } }
                tbody { @for entry in &entries { (row(entry)) } }
            } }
            h2 { "Room left, every scenario × every check" }
            p.second { "In percent of the limit where there is one; ✓ holds, ✗ fails, – not asked. Bold: below 10 %." }
            (matrix(&entries))
        }
    };
    document(&format!("{} scenarios", entries.len()), &content)
}

/// 0 not as expected, 1 inconclusive, 2 as expected.
fn rank(entry: &Entry) -> usize {
    match &entry.result {
        Ok((verdict, _)) if verdict.outcome == Outcome::Inconclusive => 1,
        _ if entry.as_expected => 2,
        _ => 0,
    }
}

/// The check that a scenario is listed with: one that fails, else the tightest.
fn told(verdict: &Verdict) -> Option<&CheckResult> {
    let undecided = verdict.checks.iter().find(|result| result.outcome == Outcome::Inconclusive);
    verdict.failed().next().or(undecided).or_else(|| verdict.tightest())
}

fn room(entry: &Entry) -> f64 {
    let verdict = entry.result.as_ref().ok().map(|(verdict, _)| verdict);
    verdict.and_then(told).and_then(CheckResult::margin_share).unwrap_or(f64::INFINITY)
}

fn row(entry: &Entry) -> Markup {
    let class = ["failed", "undecided", ""][rank(entry)];
    let sign = ["✗", "?", "✓"][rank(entry)];
    html! {
        tr.(class) {
            td { (sign) }
            @match &entry.result {
                Err(reason) => { th scope="row" { (entry.name) } td colspan="4" { (reason) } }
                Ok((verdict, page)) => {
                    th scope="row" { a href=(page) { (entry.name) } }
                    @match told(verdict) {
                        None => { td colspan="4" { "" } }
                        Some(result) => {
                            @let words = report::words(result);
                            td { (motion(&result.check)) " " (word(&result.check))
                                @if result.outcome == Outcome::Fail && verdict.as_expected { " (must fail)" } }
                            td { (words.value) } td { (words.limit) } td { (words.margin) }
                        }
                    }
                }
            }
        }
    }
}

fn matrix(entries: &[&Entry]) -> Markup {
    let verdicts =
        || entries.iter().filter_map(|entry| entry.result.as_ref().ok().map(|(verdict, _)| (entry, verdict)));
    // In the order of the verdict with the most checks; what others add comes after.
    let mut checks: Vec<&str> = Vec::new();
    let mut seen = BTreeSet::new();
    for (_, verdict) in verdicts() {
        for result in &verdict.checks {
            if result.outcome != Outcome::NotRequested && seen.insert(result.check.as_str()) {
                checks.push(&result.check);
            }
        }
    }
    checks.sort_by_key(|check| (motion(check) != "planned", *check));
    html! {
        div.wide { table.matrix {
            thead { tr { th scope="col" { "" } @for check in &checks { th scope="col" title=(check) { (word(check)) } } } }
            tbody { @for (entry, verdict) in verdicts() { tr {
                th scope="row" { (entry.name) }
                @for check in &checks {
                    (cell(verdict.checks.iter().find(|result| result.check == *check)))
                }
            } } }
        } }
    }
}

fn cell(result: Option<&CheckResult>) -> Markup {
    let Some(result) = result.filter(|result| result.outcome != Outcome::NotRequested) else {
        return html! { td.second { "–" } };
    };
    let share = result.margin_share();
    let text =
        share.map_or_else(|| mark(result.outcome).to_owned(), |share| format!("{:+.0}", 100.0 * share));
    let class = match (result.outcome, share) {
        (Outcome::Pass, Some(share)) if share < TIGHT => "tight",
        (Outcome::Pass, _) => "",
        (outcome, _) => class(outcome),
    };
    html! { td.(class) { (text) } }
}
