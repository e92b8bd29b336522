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
    let mut text = format!("{NAME}{}{NAME:#}   {title}\n", verdict.scenario);
    if verdict.is_of_plan_alone() {
        text.push_str(&format!(
            "{UNDECIDED}plan only{UNDECIDED:#}   not executed: only the plan is judged\n"
        ));
    }
    text.push('\n');
    text.push_str(&strip(phases, &verdict.checks));
    text.push('\n');
    text.push_str(&checks(verdict));
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
    let failed: Vec<&str> = verdict.failed().map(|result| result.check.as_str()).collect();
    let undecided = of_outcome(verdict, Outcome::Inconclusive).count();
    let style = if verdict.as_expected { PASSED } else { FAILED };
    let checks = checks_made(verdict);
    let mut text = match verdict.outcome {
        Outcome::Pass => {
            let note = if verdict.as_expected { "" } else { ", but it must fail" };
            format!("{style}PASS{style:#}  {checks}{note}{}", tightest(verdict))
        }
        Outcome::Fail => {
            let expected = if verdict.as_expected { "as expected" } else { "not as expected" };
            format!("{style}FAIL{style:#}  {} of {checks}, {expected}: {}", failed.len(), failed.join(", "))
        }
        Outcome::Inconclusive | Outcome::NotRequested if verdict.is_not_judged() => {
            format!(
                "{UNDECIDED}NOT JUDGED{UNDECIDED:#}  {checks} pass, but none that must fail was made: {}",
                verdict.left_out.join(", ")
            )
        }
        Outcome::Inconclusive | Outcome::NotRequested => {
            format!("{UNDECIDED}INCONCLUSIVE{UNDECIDED:#}  {undecided} of {checks} could not be decided")
        }
    };
    if verdict.is_of_plan_alone() {
        text.push_str("; not executed");
        if !verdict.left_out.is_empty() && !verdict.is_not_judged() {
            text.push_str(&format!(
                ", so failures that are expected there do not count: {}",
                verdict.left_out.join(", ")
            ));
        }
    }
    text
}

/// How many checks were made, and on what: `18 checks`, or `7 checks of the plan`.
fn checks_made(verdict: &Verdict) -> String {
    let judged = verdict.checks.iter().filter(|result| result.outcome != Outcome::NotRequested).count();
    let plural = if judged == 1 { "" } else { "s" };
    let of_what = if verdict.is_of_plan_alone() { " of the plan" } else { "" };
    format!("{judged} check{plural}{of_what}")
}

/// The passing check with the least room for its limit: `; tightest: executed grip at +17.9 %`. A margin that
/// is no share is shown in its unit, too.
fn tightest(verdict: &Verdict) -> String {
    let Some((result, share)) = verdict.tightest().and_then(|result| Some((result, result.margin_share()?)))
    else {
        return String::new();
    };
    let (motion, word) = (motion(&result.check), word(&result.check));
    let share = margin(share, true, result.unit);
    match result.margin {
        Some(room) if !result.margin_is_share => {
            let room = margin(room, false, result.unit);
            format!("; tightest: {motion} {word} at {room}, {share} of its limit")
        }
        _ => format!("; tightest: {motion} {word} at {share}"),
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
