//! The page of one run.

use graspcheck_model::plan::Plan;
use graspcheck_recording::Recording;
use graspcheck_verify::{CheckResult, Evidence, Outcome, Verdict, metrics::metrics};
use maud::{Markup, html};

use super::{
    document,
    picture::pictures,
    plots::{Plots, Quantity, seconds},
};
use crate::report::{self, Words, motion, sentence, word};

const CARD: [f64; 2] = [560.0, 190.0];
const STRIP: [f64; 2] = [1180.0, 190.0];
const CELL: [f64; 2] = [250.0, 120.0];

/// A passing run shows this many of its tightest checks.
const TIGHTEST: usize = 3;

/// A document longer than this, bytes, is not shown on the page; it is in the log.
const LONGEST_DOCUMENT: usize = 60_000;

/// The report of a run as a page of HTML, self-contained. `log` is the file name of the log beside it.
///
/// It is made from the evidence and the verdict alone; the same evidence gives the same bytes.
#[must_use]
pub fn page(evidence: &Evidence, verdict: &Verdict, log: &str) -> String {
    let plots = Plots { evidence, verdict };
    let cards = in_order(verdict);
    let is_decided = verdict.outcome == Outcome::Pass;
    let cards: Vec<&CheckResult> = match is_decided {
        true => cards.into_iter().filter(|it| it.outcome == Outcome::Pass).take(TIGHTEST).collect(),
        false => cards
            .into_iter()
            .filter(|it| matches!(it.outcome, Outcome::Fail | Outcome::Inconclusive))
            .collect(),
    };
    let failing = cards.iter().find(|it| it.outcome == Outcome::Fail).and_then(|it| it.time);
    let content = html! {
        header { (answer(evidence, verdict, log)) }
        main {
            section.cards { @for result in &cards { (card(&plots, result)) } }
            @let pictures = pictures(evidence, failing);
            @if !pictures.is_empty() {
                h2 { "Where" }
                section.pictures { @for picture in pictures { (picture) } }
            }
            h2 { "Checks" }
            (checks(verdict))
            h2 { "Whole motion" }
            (strips(&plots))
            h2 { "Joints" }
            (joints(&plots))
            h2 { "Metrics" }
            (measured(evidence))
            h2 { "More" }
            (more(evidence))
        }
    };
    document(&format!("{} {}", word_of(verdict), verdict.scenario), &content)
}

/// Failures first, then what is undecided, then what passes, the tightest first.
fn in_order(verdict: &Verdict) -> Vec<&CheckResult> {
    let rank = |outcome| match outcome {
        Outcome::Fail => 0,
        Outcome::Inconclusive => 1,
        Outcome::Pass => 2,
        Outcome::NotRequested => 3,
    };
    let room = |result: &CheckResult| result.margin_share().unwrap_or(f64::INFINITY);
    let mut results: Vec<&CheckResult> = verdict.checks.iter().collect();
    results.sort_by(|a, b| rank(a.outcome).cmp(&rank(b.outcome)).then(room(a).total_cmp(&room(b))));
    results
}

fn word_of(verdict: &Verdict) -> &'static str {
    match verdict.outcome {
        Outcome::Pass => "PASS",
        Outcome::Fail => "FAIL",
        Outcome::Inconclusive | Outcome::NotRequested => "INCONCLUSIVE",
    }
}

pub(super) fn class(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Pass => "passed",
        Outcome::Fail => "failed",
        Outcome::Inconclusive => "undecided",
        Outcome::NotRequested => "off",
    }
}

pub(super) fn mark(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Pass => "✓",
        Outcome::Fail => "✗",
        Outcome::Inconclusive => "?",
        Outcome::NotRequested => "–",
    }
}

fn answer(evidence: &Evidence, verdict: &Verdict, log: &str) -> Markup {
    let metadata = |key: &str| evidence.recording.metadata.get(key).map(String::as_str);
    let answer = report::plain(&report::last_line(verdict));
    let answer = answer.trim_start_matches(word_of(verdict)).trim_start();
    let starts = verdict.failed().filter_map(|result| result.violated.map(|[first, _]| first));
    let first = starts.reduce(f64::min);
    html! {
        p.answer {
            b.(class(verdict.outcome)) { (mark(verdict.outcome)) " " (word_of(verdict)) }
            (answer)
            @if let Some(t) = first { " · first violated at " (report::instant(t)) }
        }
        h1 { (verdict.scenario) }
        p.second {
            (evidence.resolved.title) " · " (evidence.resolved.robot.name) " · plan " (report::instant(evidence.plan.duration()))
            @match &evidence.resolved.execution {
                Some(execution) => { " · simulated at " (format!("{:.0} Hz", 1.0 / execution.dt)) }
                None => { " · not executed" }
            }
            @if let Some(seed) = metadata("seed") { " · seed " (seed) }
            " · " a href=(log) { (log) }
        }
    }
}

fn card(plots: &Plots, result: &CheckResult) -> Markup {
    html! {
        article class=(format!("card {}", class(result.outcome))) {
            h3 { (mark(result.outcome)) " " (motion(&result.check)) " " (word(&result.check)) }
            p { (sentence(result)) }
            @if let Some([first, last]) = result.violated.filter(|[first, last]| last > first) {
                p.second { (format!("from {first:.4} s to {last:.4} s")) }
            }
            @if let Some(plot) = plots.of_check(result, CARD) {
                p.second { (plot.title) }
                (plot.svg())
            }
        }
    }
}

fn checks(verdict: &Verdict) -> Markup {
    html! {
        div.wide { table {
            thead { tr {
                th scope="col" { "" }
                @for head in ["check", "motion", "worst", "limit", "margin", "at", "where", "known"] { th scope="col" { (head) } }
            } }
            tbody { @for result in in_order(verdict) {
                @let Words { value, limit, margin, at, place, by } = report::words(result);
                tr.(class(result.outcome)) {
                    td { (mark(result.outcome)) }
                    th scope="row" { (word(&result.check)) }
                    td { (motion(&result.check)) }
                    td { (value) } td { (limit) } td { (margin) }
                    td { @match result.time {
                        Some(t) => { a href="#whole" data-t=(t) { (at) } }
                        None => { (at) }
                    } }
                    td { (place) } td { (by) }
                }
            } }
        } }
    }
}

fn strips(plots: &Plots) -> Markup {
    let shares = plots.shares(plots.whole(), STRIP);
    html! {
        section id="whole" {
            p.second.key {
                (shares.title) ": "
                span.joint0 { "velocity" } span.joint2 { "acceleration" } span.joint3 { "jerk" } span.joint1 { "torque" }
            }
            (shares.svg())
            @if let Some(plot) = plots.clearance(plots.whole(), STRIP) {
                p.second { (plot.title) }
                (plot.svg())
            }
        }
    }
}

/// A row a joint: joints differ in unit.
fn joints(plots: &Plots) -> Markup {
    let evidence = plots.evidence;
    let made: Vec<Vec<_>> = (0..evidence.joints().len())
        .map(|joint| {
            Quantity::ALL.map(|quantity| plots.of_joint(joint, quantity, plots.whole(), CELL)).to_vec()
        })
        .collect();
    let shown: Vec<Quantity> = Quantity::ALL
        .into_iter()
        .enumerate()
        .filter(|(column, _)| made.iter().any(|row| row[*column].is_some()))
        .map(|(_, quantity)| quantity)
        .collect();
    html! {
        p.second { "Thin: planned. Broad: executed. Dashed: limit, where the curve comes near it." }
        div.wide { div.grid style=(format!("grid-template-columns:repeat({},minmax(170px,1fr))", shown.len())) {
            @for row in &made { @for plot in row.iter().flatten() {
                div { div.head { (plot.title) } (plot.svg()) }
            } }
        } }
    }
}

/// Numbers that judge nothing: a row for each, a column for each joint.
fn measured(evidence: &Evidence) -> Markup {
    let found = metrics(evidence);
    let joints: Vec<&str> = evidence.joints().iter().map(|joint| joint.name.as_str()).collect();
    let mut names: Vec<&str> = found.all.iter().map(|metric| metric.name).collect();
    names.dedup();
    let cell = |name: &str, subject: Option<&str>| {
        let metric = found.all.iter().find(|it| it.name == name && it.subject.as_deref() == subject);
        metric.map(|it| report::quantity(it.value, it.unit, report::Rounding::Nearest)).unwrap_or_default()
    };
    html! {
        div.wide { table {
            thead { tr {
                th scope="col" { "metric" }
                th scope="col" { "run or tool" }
                @for joint in &joints { th scope="col" { (joint) } }
            } }
            tbody { @for name in &names { tr {
                th scope="row" { (motion(name)) " " (word(name)) }
                td { (cell(name, None)) }
                @for joint in &joints { td { (cell(name, Some(joint))) } }
            } } }
        } }
        @if let Some(reason) = &found.unmeasured { p.second { "Of the execution: " (report::note(reason)) "." } }
    }
}

fn more(evidence: &Evidence) -> Markup {
    let recording = evidence.recording;
    let leaves: usize = evidence.certificate.leaf_count();
    html! {
        details { summary { "Phases and events" } (phases(&evidence.plan)) (events(recording)) }
        details { summary { "Proof of clearance" }
            p { (evidence.certificate.pairs.len()) " pairs of solids, " (leaves) " leaves; in the log as certificate.json." }
        }
        details { summary { "Versions and seed" } div.wide { table { tbody {
            @for (key, value) in &recording.metadata { tr { th scope="row" { (key) } td { (value) } } }
        } } } }
        @for attachment in &recording.attachments {
            @let name = attachment.name.as_str();
            @if attachment.data.len() <= LONGEST_DOCUMENT && name != "plan.json" && name != "certificate.json" {
                @if let Ok(text) = std::str::from_utf8(&attachment.data) {
                    details { summary { (name) } pre { (text) } }
                }
            }
        }
        details { summary { "How to read this page" }
            p { "Planned checks are proved over the whole continuous motion: “exact” is a closed-form extremum, “proved” a bound that \
                 holds at every instant. “Measured” is a value at the samples of the simulation. Grey bands are phases, red bands \
                 with a mark on top are stretches in which a limit is violated. Point at a plot to read all values at that time." }
        }
    }
}

fn phases(plan: &Plan) -> Markup {
    html! {
        table {
            thead { tr { @for head in ["phase", "from", "to", "lasts"] { th scope="col" { (head) } } } }
            tbody { @for phase in &plan.phases { tr {
                th scope="row" { (phase.name) }
                td { (report::instant(phase.start)) } td { (report::instant(phase.end)) }
                td { (report::instant(phase.end - phase.start)) }
            } } }
        }
    }
}

fn events(recording: &Recording) -> Markup {
    let told = recording.events.iter().filter(|event| event.source != "phase");
    html! {
        ul { @for event in told {
            li { (report::instant(seconds(event.time_ns))) " " (event.source) ": " (event.message) }
        } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Silent,
        html::{Entry, index},
        load, run_scenario,
    };

    /// A test fails above this, bytes; pages have about 200 kB.
    const BUDGET: usize = 400_000;

    fn run(scenario: &str) -> crate::Run {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios");
        let scenario = load(&root.join(scenario)).expect("a good file");
        run_scenario(&scenario, &mut Silent).expect("it runs")
    }

    fn page_of(run: &crate::Run) -> String {
        page(&Evidence::from_recording(&run.recording).expect("it is complete"), &run.verdict, "run.mcap")
    }

    #[test]
    fn a_failing_run_has_a_card_for_each_failure_and_shows_where() {
        let run = run("negative/velocity_limit.toml");
        let text = page_of(&run);
        assert_eq!(text.matches("class=\"card failed\"").count(), run.verdict.failed().count());
        assert!(text.contains("first violated at"), "the instant comes first");
        assert!(text.contains("polyline class=\"failing\""), "the failing pose is drawn");
        assert!(text.contains("rect class=\"violated\""));
        assert!(text.len() < BUDGET, "{} bytes", text.len());
    }

    #[test]
    fn a_passing_run_shows_its_tightest_checks_and_sends_no_request() {
        let run = run("scara/pick_cube.toml");
        let text = page_of(&run);
        assert_eq!(text.matches("class=\"card passed\"").count(), TIGHTEST);
        for foreign in ["http:", "https:", "src=", "@import", "url("] {
            assert!(!text.contains(foreign), "{foreign}");
        }
        assert_eq!(text, page_of(&run), "the same evidence gives the same bytes");
        assert!(text.len() < BUDGET, "{} bytes", text.len());
        let check = &run.verdict.checks[0];
        assert!(text.contains(&format!("<th scope=\"row\">{}</th>", word(&check.check))));
    }

    #[test]
    fn names_are_escaped_and_failures_lead_the_index() {
        let mut verdict = run("scara/laws_of_time.toml").verdict;
        let good = Entry {
            name: "a::good".to_owned(),
            result: Ok((verdict.clone(), "good.html".to_owned())),
            as_expected: verdict.as_expected,
        };
        verdict.as_expected = false;
        let bad = Entry {
            name: "z::<bad>".to_owned(),
            result: Ok((verdict, "bad.html".to_owned())),
            as_expected: false,
        };
        let lost =
            Entry { name: "y::lost".to_owned(), result: Err("no plan".to_owned()), as_expected: false };
        let text = index(&[good, bad, lost]);
        let at = |what: &str| text.find(what).unwrap_or(usize::MAX);
        assert!(at("z::&lt;bad&gt;") < at("a::good") && at("y::lost") < at("a::good"));
        assert!(text.contains("2 not as expected"), "{text}");
    }
}
