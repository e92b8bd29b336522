//! A whole verdict: the page for a terminal and the block for a failing test.

use graspcheck_model::plan::Plan;
use graspcheck_verify::{CheckResult, Outcome, Resolved, Verdict};

use super::{
    candidates,
    cure::cure,
    quantity::{instant, margin},
    sentence::{motion, sentence, word},
    table::{DIM, FAILED, NAME, PASSED, UNDECIDED, checks, strip},
};
use crate::run::Run;

/// The name and title, the chosen grasp, the strip of phases, the table, one sentence for each failure, and the
/// last line; with all ways to do the task that were looked at where `every` one is asked for.
#[must_use]
pub fn page(run: &Run, resolved: &Resolved, every: bool) -> String {
    let Run { verdict, plan, candidates, .. } = run;
    let mut text = format!("{NAME}{}{NAME:#}   {}\n", verdict.scenario, resolved.title);
    if verdict.is_of_plan_alone() {
        text.push_str(&format!(
            "{UNDECIDED}plan only{UNDECIDED:#}   not executed: only the plan is judged\n"
        ));
    }
    let is_clear =
        verdict.checks.iter().all(|it| it.check != "planned.clearance" || it.outcome == Outcome::Pass);
    if let Some(choice) = candidates::choice(candidates, is_clear) {
        text.push_str(&format!("{DIM}grasp{DIM:#}   {choice}\n"));
    }
    text.push('\n');
    if every && !candidates.is_empty() {
        text.push_str(&candidates::table(candidates, &resolved.robot, true));
        text.push('\n');
    }
    text.push_str(&strip(&plan.phases, &verdict.checks));
    text.push('\n');
    text.push_str(&checks(verdict));
    text.push('\n');
    for result in of_outcome(verdict, Outcome::Fail) {
        text.push_str(&finding(result, FAILED, run, resolved));
    }
    for result in of_outcome(verdict, Outcome::Inconclusive) {
        text.push_str(&finding(result, UNDECIDED, run, resolved));
    }
    text.push_str(&last_line(verdict));
    if let Some(first) = first_violation(run) {
        text.push_str(&first);
    }
    text.push('\n');
    text
}

fn of_outcome(verdict: &Verdict, outcome: Outcome) -> impl Iterator<Item = &CheckResult> {
    verdict.checks.iter().filter(move |result| result.outcome == outcome)
}

fn finding(result: &CheckResult, style: anstyle::Style, run: &Run, resolved: &Resolved) -> String {
    let mut text = format!("{style}{}{style:#}  {}\n", result.check, sentence(result));
    for line in details(result, run, resolved) {
        text.push_str(&format!("{DIM}  {line}{DIM:#}\n"));
    }
    text.push('\n');
    text
}

/// When a failure began and how long it lasted, and what would cure it.
fn details(result: &CheckResult, run: &Run, resolved: &Resolved) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some([first, last]) = result.violated {
        let mut line = format!("first  at t = {first:.4} s, {}", phase_at(&run.plan, first));
        if last > first {
            line.push_str(&format!("; last at t = {last:.4} s, {:.1} ms later", (last - first) * 1e3));
        }
        if let Some(worst) = result.time.filter(|worst| *worst > first) {
            line.push_str(&format!("; worst at t = {worst:.4} s, {}", phase_at(&run.plan, worst)));
        }
        lines.push(line);
    }
    if let Some(cure) = cure(result, resolved, &run.plan) {
        lines.push(format!("try    {cure}"));
    }
    lines
}

/// The name of the phase at an instant, or that the plan has ended.
fn phase_at(plan: &Plan, t: f64) -> &str {
    if t > plan.duration() { "after the plan's end" } else { plan.phase_at(t).name.as_str() }
}

/// The check that is violated before all others: `; first at t = 2.104 s: executed.slip, lift`. None when only
/// one fails.
fn first_violation(run: &Run) -> Option<String> {
    let start = |result: &&CheckResult| result.violated.map_or(f64::INFINITY, |[first, _]| first);
    let first = run.verdict.failed().min_by(|a, b| start(a).total_cmp(&start(b)))?;
    let [t, _] = first.violated.filter(|_| run.verdict.failed().count() > 1)?;
    Some(format!("; first at t = {}: {}, {}", instant(t), first.check, phase_at(&run.plan, t)))
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
pub fn failure(run: &Run, resolved: &Resolved) -> String {
    let verdict = &run.verdict;
    let mut text = plain(&last_line(verdict));
    text.push_str(&first_violation(run).unwrap_or_default());
    text.push('\n');
    for result in verdict.checks.iter().filter(|r| matches!(r.outcome, Outcome::Fail | Outcome::Inconclusive))
    {
        text.push_str(&format!("\n  {}  {}", result.check, sentence(result)));
        for line in details(result, run, resolved) {
            text.push_str(&format!("\n    {line}"));
        }
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
