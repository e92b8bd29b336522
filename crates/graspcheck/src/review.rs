//! A log judged again from its file alone, and held against what it says of itself.
//!
//! Three things must agree: the verdict that the log carries, the one that its streams and documents give now,
//! and its proofs with an independent checker ([`graspcheck_checker`]).

use std::fmt;

use graspcheck_checker::{CheckerError, Report};
use graspcheck_model::plan::Plan;
use graspcheck_recording::Recording;
use graspcheck_verify::{CheckResult, Evidence, EvidenceError, Outcome, Resolved, Verdict, judge};
use serde::Serialize;

use crate::{
    exit,
    limit_proofs::{self, LimitProof, LimitProofs, LimitQuantity},
    run::Run,
};

/// Numbers of two verdicts on one log differ by no more than this share: sines and cosines of another system's
/// mathematics do.
const SAME_SHARE: f64 = 1e-9;

/// A log, judged again.
#[derive(Debug)]
pub struct Review {
    /// The log with the verdict that it is given now, and its plan; candidates are not read.
    pub run: Run,
    /// What the run was asked to be.
    pub resolved: Resolved,
    /// What came out of checking its proofs; an error where there is nothing that can be checked.
    pub proofs: Result<Report, CheckerError>,
    /// Where the log does not say what is found now. None for an honest log.
    pub differences: Vec<Difference>,
}

/// One place at which a log says something else than is found.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Difference {
    /// What differs: the name of a check, `verdict` as a whole, or `proof`.
    pub of: String,
    /// In what; empty where `stored` and `found` say it.
    pub what: String,
    /// What the log says.
    pub stored: String,
    /// What is found.
    pub found: String,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { of, what, stored, found } = self;
        let space = if what.is_empty() { "" } else { " " };
        write!(f, "{of}: {what}{space}is {stored} in the log, found to be {found}")
    }
}

/// Judges a recording again, checks its proofs and compares.
///
/// # Errors
/// When its documents cannot be read or do not fit each other: then there is nothing to judge.
pub fn review(recording: Recording) -> Result<Review, EvidenceError> {
    let (verdict, plan, resolved) = {
        let evidence = Evidence::from_recording(&recording)?;
        (judge(&evidence), evidence.plan, evidence.resolved)
    };
    let proofs = graspcheck_checker::check(&recording);
    let mut differences = Vec::new();
    match recording.verdict.as_deref().map(Verdict::from_json) {
        Some(Ok(stored)) => {
            let is_of_this_version =
                recording.metadata.get("graspcheck").is_some_and(|it| it == env!("CARGO_PKG_VERSION"));
            differences.extend(between(&stored, &verdict, is_of_this_version));
        }
        Some(Err(error)) => differences.push(whole("verdict", error.to_string(), "a verdict")),
        None => differences.push(whole("verdict", "missing".to_owned(), "a verdict")),
    }
    differences.extend(of_proofs(&proofs, &verdict));
    differences.extend(of_efforts(&recording, &resolved, &plan));
    let run = Run { recording, verdict, plan, candidates: Vec::new() };
    Ok(Review { run, resolved, proofs, differences })
}

impl Review {
    /// The exit code: [`exit::DIFFERS`] before that of the verdict.
    #[must_use]
    pub fn code(&self) -> u8 {
        if self.differences.is_empty() { exit::of_verdict(&self.run.verdict) } else { exit::DIFFERS }
    }

    /// One line on the proofs: how many were validated by the checker.
    #[must_use]
    pub fn on_proofs(&self) -> String {
        let report = match &self.proofs {
            Ok(report) => report,
            Err(error) => return format!("proofs cannot be checked: {error}"),
        };
        let Report { pairs, leaves, sweeps, limits, unchecked_limits, undecided, findings, .. } = report;
        let of_them = if *sweeps > 0 { format!(", {sweeps} of them sweeps") } else { String::new() };
        let mut text = match findings.len() {
            0 => format!(
                "certificate of {pairs} pairs: {leaves} leaves{of_them}, {limits} limit proofs re-validated \
                 independently"
            ),
            1 => format!("certificate of {pairs} pairs: 1 statement in it is wrong"),
            wrong => format!("certificate of {pairs} pairs: {wrong} statements in it are wrong"),
        };
        if *unchecked_limits > 0 {
            text.push_str(&format!(
                "; {unchecked_limits} bounds on efforts are found again by the search alone"
            ));
        } else if *limits == 0 {
            text.push_str("; the log is older than proofs of limits");
        }
        if !undecided.is_empty() {
            text.push_str(&format!("; {} pairs are undecided", undecided.len()));
        }
        text
    }
}

fn whole(of: &str, stored: String, found: &str) -> Difference {
    Difference { of: of.to_owned(), what: String::new(), stored, found: found.to_owned() }
}

/// What the checker finds wrong, and where its result and the verdict contradict each other.
fn of_proofs(proofs: &Result<Report, CheckerError>, verdict: &Verdict) -> Vec<Difference> {
    let report = match proofs {
        Ok(report) => report,
        Err(error) => return vec![whole("proof", error.to_string(), "a proof that can be checked")],
    };
    let finding = |finding: &graspcheck_checker::Finding| {
        let [start, end] = finding.interval;
        let during = if start < end { format!("{start} … {end} s") } else { format!("{start} s") };
        Difference {
            of: "proof".to_owned(),
            what: format!("{}, t = {during}: {}", finding.place, finding.quantity.name()),
            stored: finding.stated.to_string(),
            found: finding.recomputed.to_string(),
        }
    };
    let mut differences: Vec<Difference> = report.findings.iter().map(finding).collect();
    let clearance = verdict.checks.iter().find(|result| result.check == "planned.clearance");
    let is_clear = clearance.is_some_and(|result| result.outcome == Outcome::Pass);
    if is_clear && !(report.violated.is_empty() && report.undecided.is_empty()) {
        let stored = format!("{} violated and {} undecided", report.violated.len(), report.undecided.len());
        differences.push(whole("proof", stored, "clear, by planned.clearance"));
    }
    differences
}

/// Where the bounds on efforts in `limits.json` are not those that are found again. The checker does not validate
/// them; a document that cannot be decoded it names itself.
fn of_efforts(recording: &Recording, resolved: &Resolved, plan: &Plan) -> Vec<Difference> {
    let document = recording.attachment(limit_proofs::LIMITS_JSON);
    let stored = document.and_then(|it| serde_json::from_slice::<LimitProofs>(&it.data).ok());
    let Some(stored) = stored else { return Vec::new() };
    let efforts = |proofs: LimitProofs| {
        proofs.limits.into_iter().filter(|proof| proof.quantity == LimitQuantity::Effort).collect::<Vec<_>>()
    };
    let (stored, found) = (efforts(stored), efforts(limit_proofs::of(resolved, plan)));
    if stored.len() != found.len() {
        let count = |proofs: &[LimitProof]| format!("{} bounds on efforts", proofs.len());
        return vec![whole("proof", count(&stored), &count(&found))];
    }
    let mut differences = Vec::new();
    for (then, now) in stored.iter().zip(&found) {
        let numbers = [
            ("limit", then.limit, now.limit),
            ("bound", then.bound, now.bound),
            ("peak", then.peak, now.peak),
            ("time", then.time, now.time),
        ];
        let joint = |name: &str| format!("effort of joint {name}");
        if then.joint != now.joint {
            differences.push(whole("proof", joint(&then.joint), &joint(&now.joint)));
        }
        for (what, then, found) in numbers {
            if (then - found).abs() > SAME_SHARE * (1.0 + found.abs()) || then.is_nan() {
                differences.push(Difference {
                    of: "proof".to_owned(),
                    what: format!("{}: {what}", joint(&now.joint)),
                    stored: then.to_string(),
                    found: found.to_string(),
                });
            }
        }
    }
    differences
}

/// Where two verdicts differ. Checks that a stored one lacks count only when it was made by this version.
fn between(stored: &Verdict, found: &Verdict, is_of_this_version: bool) -> Vec<Difference> {
    let mut differences = Vec::new();
    let mut compare = |of: &str, what: &str, stored: String, found: String| {
        if stored != found {
            differences.push(Difference { of: of.to_owned(), what: what.to_owned(), stored, found });
        }
    };
    compare("verdict", "scenario", stored.scenario.clone(), found.scenario.clone());
    compare("verdict", "outcome", word(&stored.outcome), word(&found.outcome));
    compare("verdict", "as expected", stored.as_expected.to_string(), found.as_expected.to_string());
    compare("verdict", "what is left out", stored.left_out.join(", "), found.left_out.join(", "));
    for now in &found.checks {
        let mut then = stored.checks.iter().filter(|result| result.check == now.check);
        match (then.next(), then.next()) {
            (Some(then), None) => of_check(then, now, &mut compare),
            (None, _) if is_of_this_version => {
                compare(&now.check, "", "missing".to_owned(), word(&now.outcome));
            }
            (None, _) => {}
            (Some(_), Some(_)) => compare(&now.check, "", "twice".to_owned(), "once".to_owned()),
        }
    }
    for then in &stored.checks {
        if !found.checks.iter().any(|result| result.check == then.check) {
            compare(&then.check, "", word(&then.outcome), "no check".to_owned());
        }
    }
    differences
}

fn of_check(then: &CheckResult, now: &CheckResult, compare: &mut impl FnMut(&str, &str, String, String)) {
    let check = &now.check;
    compare(check, "outcome", word(&then.outcome), word(&now.outcome));
    compare(check, "unit", word(&then.unit), word(&now.unit));
    compare(check, "basis", word(&then.basis), word(&now.basis));
    compare(check, "place", word(&then.place), word(&now.place));
    let edges = |result: &CheckResult| result.violated.map_or([None; 2], |edges| edges.map(Some));
    let ([first, last], [first_now, last_now]) = (edges(then), edges(now));
    for (what, then, now) in [
        ("value", then.value, now.value),
        ("limit", then.limit, now.limit),
        ("margin", then.margin, now.margin),
        ("time", then.time, now.time),
        ("first violation", first, first_now),
        ("last violation", last, last_now),
    ] {
        let is_same = match (then, now) {
            (Some(then), Some(now)) => (then - now).abs() <= SAME_SHARE * (1.0 + now.abs()),
            (then, now) => then.is_none() && now.is_none(),
        };
        if !is_same {
            let number = |it: Option<f64>| it.map_or("none".to_owned(), |it| it.to_string());
            compare(check, what, number(then), number(now));
        }
    }
}

/// A value as the verdict's JSON has it, without quotes.
fn word(value: &impl Serialize) -> String {
    let text = serde_json::to_string(value).expect("structs, strings and numbers have a JSON form");
    text.trim_matches('"').to_owned()
}

#[cfg(test)]
mod tests {
    use graspcheck_verify::{Basis, Note, Place, Unit};

    use super::*;

    fn verdict() -> Verdict {
        let check = |name: &str, value: f64| CheckResult {
            check: name.to_owned(),
            outcome: Outcome::Pass,
            value: Some(value),
            limit: Some(2.0),
            unit: Unit::Meter,
            margin: Some(2.0 - value),
            margin_is_share: false,
            value_is_bound: false,
            time: Some(0.5),
            violated: None,
            place: Place { subjects: vec!["arm".to_owned()], phase: None },
            basis: Basis::Exact,
            note: Note::default(),
            stretch: None,
        };
        Verdict {
            schema: 2,
            scenario: "one".to_owned(),
            outcome: Outcome::Pass,
            as_expected: true,
            left_out: Vec::new(),
            checks: vec![check("planned.a", 1.0), check("planned.b", 1.5)],
        }
    }

    /// What is different when the stored verdict is changed, as `check: what`.
    fn found(change: impl FnOnce(&mut Verdict)) -> Vec<String> {
        let mut stored = verdict();
        change(&mut stored);
        let differences = between(&stored, &verdict(), true);
        differences.iter().map(|it| format!("{}: {}", it.of, it.what)).collect()
    }

    #[test]
    fn each_part_of_a_verdict_that_differs_is_named() {
        assert_eq!(found(|_| ()), [""; 0]);
        assert_eq!(found(|it| it.checks[0].value = Some(1.0 + 1e-10)), [""; 0]);
        assert_eq!(found(|it| it.checks[0].value = Some(1.0 + 1e-8)), ["planned.a: value"]);
        assert_eq!(found(|it| it.checks[1].value = None), ["planned.b: value"]);
        assert_eq!(found(|it| it.checks[1].limit = Some(2.1)), ["planned.b: limit"]);
        assert_eq!(found(|it| it.checks[1].margin = Some(f64::NAN)), ["planned.b: margin"]);
        assert_eq!(found(|it| it.checks[1].time = Some(0.6)), ["planned.b: time"]);
        assert_eq!(found(|it| it.checks[1].unit = Unit::Radian), ["planned.b: unit"]);
        assert_eq!(found(|it| it.checks[1].place.subjects.clear()), ["planned.b: place"]);
        assert_eq!(found(|it| it.checks[1].outcome = Outcome::Fail), ["planned.b: outcome"]);
        assert_eq!(
            found(|it| it.checks[1].violated = Some([0.1, 0.2])),
            ["planned.b: first violation", "planned.b: last violation"]
        );
        assert_eq!(found(|it| it.outcome = Outcome::Fail), ["verdict: outcome"]);
        assert_eq!(found(|it| it.as_expected = false), ["verdict: as expected"]);
        assert_eq!(found(|it| it.left_out.push("slip".to_owned())), ["verdict: what is left out"]);
        assert_eq!(found(|it| drop(it.checks.pop())), ["planned.b: "]);
        assert_eq!(found(|it| it.checks.push(it.checks[0].clone())), ["planned.a: "]);
        assert_eq!(found(|it| it.checks[0].check = "c".to_owned()), ["planned.a: ", "c: "]);
    }

    #[test]
    fn an_older_verdict_may_lack_a_check() {
        let mut stored = verdict();
        stored.checks.pop();
        assert!(between(&stored, &verdict(), false).is_empty());
    }
}
