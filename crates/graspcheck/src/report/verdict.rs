//! A whole verdict: the page for a terminal and the block for a failing test.

use graspcheck_model::plan::Phase;
use graspcheck_verify::{CheckResult, Outcome, Verdict};

use super::{
    quantity::margin,
    sentence::{motion, sentence, word},
    table::{DIM, FAILED, NAME, PASSED, UNDECIDED, checks, strip},
};

/// The name and title, the strip of phases, the table, one sentence for each failure, and the last line.
#[must_use]
pub fn page(verdict: &Verdict, title: &str, phases: &[Phase]) -> String {
    let mut text = format!("{NAME}{}{NAME:#}   {title}\n\n", verdict.scenario);
    text.push_str(&strip(phases, &verdict.checks));
    text.push('\n');
    text.push_str(&checks(&verdict.checks));
    text.push('\n');
    for result in of_outcome(verdict, Outcome::Fail) {
        text.push_str(&finding(result, FAILED));
    }
    for result in of_outcome(verdict, Outcome::Inconclusive) {
        text.push_str(&finding(result, UNDECIDED));
    }
    text.push_str(&last_line(verdict));
    text.push('\n');
    text
}

fn of_outcome(verdict: &Verdict, outcome: Outcome) -> impl Iterator<Item = &CheckResult> {
    verdict.checks.iter().filter(move |result| result.outcome == outcome)
}

fn finding(result: &CheckResult, style: anstyle::Style) -> String {
    let mut text = format!("{style}{}{style:#}  {}\n", result.check, sentence(result));
    if let Some([first, last]) = result.violated {
        text.push_str(&format!(
            "{DIM}  violated  from t = {first:.4} s to {last:.4} s ({:.1} ms){DIM:#}\n",
            (last - first) * 1e3
        ));
    }
    text.push('\n');
    text
}

/// The answer in one line: outcome, how many checks, and the tightest one.
#[must_use]
pub fn last_line(verdict: &Verdict) -> String {
    let judged = verdict.checks.iter().filter(|result| result.outcome != Outcome::NotRequested).count();
    let failed: Vec<&str> = of_outcome(verdict, Outcome::Fail).map(|result| result.check.as_str()).collect();
    let undecided = of_outcome(verdict, Outcome::Inconclusive).count();
    let expected = if verdict.as_expected { ", as expected" } else { ", not as expected" };
    match verdict.outcome {
        Outcome::Pass => {
            let tightest = verdict
                .checks
                .iter()
                .filter(|result| result.outcome == Outcome::Pass && result.margin_is_share)
                .filter_map(|result| result.margin.map(|m| (m, result)))
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .map(|(m, result)| {
                    format!(
                        "; tightest: {} {} at {}",
                        motion(&result.check),
                        word(&result.check),
                        margin(m, true, result.unit)
                    )
                })
                .unwrap_or_default();
            let note = if verdict.as_expected { "" } else { ", but it must fail" };
            let style = if verdict.as_expected { PASSED } else { FAILED };
            format!("{style}PASS{style:#}  {judged} checks{note}{tightest}")
        }
        Outcome::Fail => {
            let style = if verdict.as_expected { PASSED } else { FAILED };
            format!(
                "{style}FAIL{style:#}  {} of {judged} checks{expected}: {}",
                failed.len(),
                failed.join(", ")
            )
        }
        Outcome::Inconclusive | Outcome::NotRequested => {
            format!(
                "{UNDECIDED}INCONCLUSIVE{UNDECIDED:#}  {undecided} of {judged} checks could not be decided"
            )
        }
    }
}

/// A text without its colours.
#[must_use]
pub fn plain(text: &str) -> String {
    anstream::adapter::strip_str(text).to_string()
}

/// The text of a failing test: no colour, what failed in sentences, and what passed in one line.
#[must_use]
pub fn failure(verdict: &Verdict) -> String {
    let mut text = plain(&last_line(verdict));
    text.push('\n');
    for result in verdict.checks.iter().filter(|r| matches!(r.outcome, Outcome::Fail | Outcome::Inconclusive))
    {
        text.push_str(&format!("\n  {}  {}", result.check, sentence(result)));
    }
    let passed: Vec<String> = of_outcome(verdict, Outcome::Pass)
        .map(|result| match result.margin {
            Some(m) => format!("{} {}", result.check, margin(m, result.margin_is_share, result.unit)),
            None => result.check.clone(),
        })
        .collect();
    if !passed.is_empty() {
        text.push_str(&format!("\n  passed  {}", passed.join(", ")));
    }
    text
}
