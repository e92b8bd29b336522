//! From evidence to verdict.

use crate::{
    checks::CHECKS,
    evidence::Evidence,
    resolved::Expectation,
    verdict::{CheckResult, Outcome, VERDICT_SCHEMA, Verdict},
};

/// The verdict on a recording: every check of [`CHECKS`], in that order. Pure: the same evidence gives the
/// same verdict.
#[must_use]
pub fn judge(evidence: &Evidence<'_>) -> Verdict {
    let checks: Vec<CheckResult> = CHECKS.iter().map(|check| check.evaluate(evidence)).collect();
    let was_executed = evidence.resolved.execution.is_some();
    let (expect, left_out) = without_execution(&evidence.resolved.expect, &checks, was_executed);
    let nothing_left = !left_out.is_empty() && expect == Expectation::Fail(Vec::new());
    let outcome = match outcome_of(&checks) {
        Outcome::Pass if nothing_left => Outcome::Inconclusive,
        outcome => outcome,
    };
    Verdict {
        schema: VERDICT_SCHEMA,
        scenario: evidence.resolved.name.clone(),
        outcome,
        as_expected: is_expected(&checks, &expect),
        left_out,
        checks,
    }
}

/// What can be expected of a run, and the names of failures that cannot: those that mean only checks of the
/// execution, when there was none.
fn without_execution(
    expect: &Expectation,
    checks: &[CheckResult],
    was_executed: bool,
) -> (Expectation, Vec<String>) {
    let Expectation::Fail(names) = expect else { return (expect.clone(), Vec::new()) };
    if was_executed {
        return (expect.clone(), Vec::new());
    }
    let needs_execution = |name: &String| {
        let mut meant = checks.iter().filter(|result| is_meant_by(&result.check, name)).peekable();
        meant.peek().is_some() && meant.all(|result| result.check.starts_with("executed."))
    };
    let (left_out, left): (Vec<String>, Vec<String>) = names.iter().cloned().partition(needs_execution);
    (Expectation::Fail(left), left_out)
}

/// Whether a check is meant by a name in an expectation: its own, or its last word, so that `clearance`
/// stands for `planned.clearance`.
#[must_use]
pub fn is_meant_by(check: &str, expected: &str) -> bool {
    check == expected || check.split_once('.').is_some_and(|(_, word)| word == expected)
}

/// Fail if any fails, else inconclusive if any is or none was made, else pass.
fn outcome_of(checks: &[CheckResult]) -> Outcome {
    let any = |outcome| checks.iter().any(|result| result.outcome == outcome);
    if any(Outcome::Fail) {
        Outcome::Fail
    } else if any(Outcome::Inconclusive) || !any(Outcome::Pass) {
        Outcome::Inconclusive
    } else {
        Outcome::Pass
    }
}

/// Whether the checks came out as expected: all pass, or exactly the named ones fail. An undecided check
/// is never as expected.
fn is_expected(checks: &[CheckResult], expect: &Expectation) -> bool {
    let outcome = outcome_of(checks);
    match expect {
        Expectation::Pass => outcome == Outcome::Pass,
        Expectation::Fail(names) => {
            let failed = || checks.iter().filter(|result| result.outcome == Outcome::Fail);
            outcome == Outcome::Fail
                && checks.iter().all(|result| result.outcome != Outcome::Inconclusive)
                && failed().all(|result| names.iter().any(|name| is_meant_by(&result.check, name)))
                && names.iter().all(|name| failed().any(|result| is_meant_by(&result.check, name)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{self, Run, contact, ns_of};

    fn outcome(verdict: &Verdict, name: &str) -> Outcome {
        verdict.checks.iter().find(|result| result.check == name).unwrap().outcome
    }

    fn expecting(mut run: Run, names: &[&str]) -> Verdict {
        run.resolved.expect = Expectation::Fail(names.iter().map(|&name| name.to_owned()).collect());
        run.judged()
    }

    #[test]
    fn a_good_run_passes_and_every_check_that_was_made_has_a_value() {
        let verdict = fixture::pick().judged();
        assert_eq!(verdict.outcome, Outcome::Pass, "{:#?}", verdict.failed().collect::<Vec<_>>());
        assert!(verdict.as_expected);
        let names: Vec<&str> = verdict.checks.iter().map(|result| result.check.as_str()).collect();
        assert_eq!(names, CHECKS.iter().map(|check| check.name).collect::<Vec<_>>());
        for result in verdict.checks.iter().filter(|result| result.outcome == Outcome::Pass) {
            assert!(
                result.value.is_some() && result.limit.is_some() && result.margin.is_some(),
                "{result:?}"
            );
        }
    }

    #[test]
    fn judging_is_pure() {
        let run = fixture::pick();
        assert_eq!(run.judged(), run.judged());
    }

    #[test]
    fn no_number_that_is_not_finite_passes_wherever_it_stands() {
        let clean = fixture::pick();
        let certificate = clean.proved();
        let last = clean.recording.measured.len() - 1;
        let spoiled = |spoil: &dyn Fn(&mut graspcheck_recording::Recording)| {
            let mut run = fixture::pick();
            run.certificate = Some(certificate.clone());
            spoil(&mut run.recording);
            run.judged().outcome
        };
        for bad in [f64::NAN, f64::NEG_INFINITY] {
            for row in [0, last] {
                for column in 0..4 {
                    let at = 4 * row + column;
                    assert_eq!(spoiled(&|log| log.measured.position[at] = bad), Outcome::Fail);
                    assert_eq!(spoiled(&|log| log.measured.velocity[at] = bad), Outcome::Fail);
                    assert_eq!(spoiled(&|log| log.measured.effort[at] = bad), Outcome::Fail);
                    assert_eq!(spoiled(&|log| log.reference.effort[at] = bad), Outcome::Fail);
                }
                for column in 0..6 {
                    assert_eq!(spoiled(&|log| log.tool.pose[row][column] = bad), Outcome::Fail);
                    assert_eq!(spoiled(&|log| log.object.twist[row][column] = bad), Outcome::Fail);
                }
                assert_eq!(spoiled(&|log| log.contacts[row].depth_m = bad), Outcome::Fail);
                assert_eq!(spoiled(&|log| log.contacts[row].normal_force_n = bad), Outcome::Fail);
            }
        }
    }

    #[test]
    fn a_plan_alone_is_judged_without_what_was_not_executed() {
        let mut run = fixture::pick();
        run.resolved.execution = None;
        run.recording = Default::default();
        let verdict = run.judged();
        assert_eq!(verdict.outcome, Outcome::Pass);
        for result in verdict.checks.iter().filter(|result| result.check.starts_with("executed")) {
            assert_eq!(result.outcome, Outcome::NotRequested, "{result:?}");
        }
    }

    fn of_the_plan_alone(mut run: Run, names: &[&str]) -> Verdict {
        run.resolved.execution = None;
        run.recording = Default::default();
        expecting(run, names)
    }

    #[test]
    fn without_an_execution_only_failures_of_the_plan_are_expected() {
        let broken = || {
            let mut run = fixture::pick();
            run.resolved.robot.joints[1].limits.jerk = 1.0;
            run
        };
        let verdict = of_the_plan_alone(broken(), &["jerk", "slip", "executed.place"]);
        assert_eq!((verdict.outcome, verdict.as_expected), (Outcome::Fail, true));
        assert_eq!(verdict.left_out, ["slip", "executed.place"]);
        let verdict = of_the_plan_alone(fixture::pick(), &["planned.jerk", "slip"]);
        assert_eq!((verdict.outcome, verdict.as_expected), (Outcome::Pass, false));
        // `velocity` means the planned one, too, and that was judged.
        assert!(of_the_plan_alone(fixture::pick(), &["velocity"]).left_out.is_empty());
        // What the plan was not asked for is not excused by the missing execution.
        assert!(of_the_plan_alone(fixture::pick(), &["via"]).left_out.is_empty());
        assert!(expecting(fixture::pick(), &["slip"]).left_out.is_empty());
    }

    #[test]
    fn when_no_expected_failure_was_looked_for_there_is_no_judgement() {
        let verdict = of_the_plan_alone(fixture::pick(), &["slip", "place"]);
        assert_eq!((verdict.outcome, verdict.as_expected), (Outcome::Inconclusive, false));
        assert!(verdict.is_not_judged());
        let mut run = fixture::pick();
        run.resolved.robot.joints[1].limits.jerk = 1.0;
        let verdict = of_the_plan_alone(run, &["slip"]);
        assert_eq!((verdict.outcome, verdict.as_expected), (Outcome::Fail, false));
        assert!(!verdict.is_not_judged());
        let mut lost = fixture::pick();
        lost.recording = Default::default();
        assert!(!lost.judged().is_not_judged(), "what should be there and is not is inconclusive");
    }

    #[test]
    fn a_run_that_lost_its_streams_is_inconclusive_and_never_as_expected() {
        let mut run = fixture::pick();
        run.recording = Default::default();
        let verdict = run.judged();
        assert_eq!((verdict.outcome, verdict.as_expected), (Outcome::Inconclusive, false));
        run.resolved.robot.joints[1].limits.jerk = 1.0;
        let verdict = expecting(run, &["planned.jerk"]);
        assert_eq!((verdict.outcome, verdict.as_expected), (Outcome::Fail, false));
    }

    #[test]
    fn exactly_the_named_checks_must_fail() {
        let broken = || {
            let mut run = fixture::pick();
            run.resolved.robot.joints[1].limits.jerk = 1.0;
            run.touch(contact(ns_of(4.0), "palm", "table", 0.0, 3.0));
            run
        };
        assert!(!broken().judged().as_expected);
        assert!(expecting(broken(), &["planned.jerk", "executed.contacts"]).as_expected);
        assert!(expecting(broken(), &["jerk", "contacts"]).as_expected);
        assert!(!expecting(broken(), &["planned.jerk"]).as_expected, "one fails that is not named");
        assert!(!expecting(broken(), &["jerk", "contacts", "slip"]).as_expected, "one is named that passes");
        assert!(!expecting(broken(), &["jerk", "contacts", "planned.jer"]).as_expected);
    }

    #[test]
    fn a_run_that_must_fail_and_passes_is_not_as_expected() {
        let verdict = expecting(fixture::pick(), &["clearance"]);
        assert_eq!((verdict.outcome, verdict.as_expected), (Outcome::Pass, false));
        assert!(!expecting(fixture::pick(), &[]).as_expected);
    }

    #[test]
    fn a_word_stands_for_both_motions() {
        assert!(is_meant_by("planned.clearance", "clearance"));
        assert!(is_meant_by("executed.clearance", "clearance"));
        assert!(is_meant_by("planned.clearance", "planned.clearance"));
        assert!(!is_meant_by("planned.clearance", "planned"));
        assert!(!is_meant_by("planned.clearance", "executed.clearance"));
    }

    #[test]
    fn nothing_made_is_inconclusive() {
        assert_eq!(outcome_of(&[]), Outcome::Inconclusive);
        let mut none = fixture::pick().judged().checks;
        none.retain(|result| result.outcome == Outcome::NotRequested);
        assert!(!none.is_empty());
        assert_eq!(outcome_of(&none), Outcome::Inconclusive);
    }

    #[test]
    fn checks_of_blends_are_made_where_they_apply() {
        let verdict = fixture::blends().judged();
        assert_eq!(outcome(&verdict, "planned.continuity"), Outcome::Pass);
        assert_eq!(outcome(&verdict, "planned.via"), Outcome::Pass);
        assert_eq!(outcome(&verdict, "executed.grip"), Outcome::NotRequested);
    }
}
