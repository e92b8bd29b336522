//! `graspcheck review`: logs judged again from their files alone.

use std::path::{Path, PathBuf};

use anstream::{eprintln, print, println};
use graspcheck::{
    exit,
    report::{self, DIM, FAILED, NAME, PASSED, UNDECIDED},
    review::{Difference, Review, review},
};
use graspcheck_verify::Verdict;
use serde::Serialize;

const EXAMPLES: &str = "\
Examples:
  graspcheck review target/graspcheck/scara/pick_cube/run.mcap    one log, with its table of checks
  graspcheck review */*/run.mcap                                  many, one line each
  graspcheck review run.mcap --json                               for programs";

/// How many differences of one log are printed; JSON has all.
const MOST_SHOWN: usize = 10;

/// Judge logs again from their files alone, check their proofs, and compare with the verdicts in them.
#[derive(clap::Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct ReviewArguments {
    /// Logs that graspcheck wrote
    #[arg(value_name = "LOG", required = true)]
    logs: Vec<PathBuf>,
    /// Print one JSON array with an object for each log, and nothing else
    #[arg(long)]
    json: bool,
}

pub(super) fn execute(arguments: &ReviewArguments) -> u8 {
    let mut codes = Vec::with_capacity(arguments.logs.len());
    let mut documents = Vec::new();
    for log in &arguments.logs {
        let reviewed = of_file(log);
        codes.push(reviewed.as_ref().map_or(exit::UNREADABLE_RECORDING, Review::code));
        match (&reviewed, arguments.json) {
            (reviewed, true) => documents.push(Document::of(log, reviewed).to_json()),
            (Err(error), false) => eprintln!("error: {}: {error}", log.display()),
            (Ok(review), false) if arguments.logs.len() == 1 => {
                print!("{}", report::page(&review.run, &review.resolved, false));
                print!("{}", agreement(review));
            }
            (Ok(review), false) => print!("{}", line(log, review)),
        }
    }
    if arguments.json {
        println!("[{}]", documents.join(",\n"));
    }
    exit::worst(&codes)
}

/// What one log comes to, or why it cannot be read.
fn of_file(log: &Path) -> Result<Review, String> {
    let bytes = std::fs::read(log).map_err(|error| error.to_string())?;
    let recording = graspcheck_recording::from_bytes(&bytes).map_err(|error| error.to_string())?;
    review(recording).map_err(|error| error.to_string())
}

/// Whether the log says what is found, and what the checker says.
fn agreement(review: &Review) -> String {
    let mut text = match review.differences.len() {
        0 => format!("{PASSED}log{PASSED:#}    the verdict in the log is this one\n"),
        count => format!("{FAILED}log{FAILED:#}    says something else in {count} places\n"),
    };
    text.push_str(&differences(&review.differences, "       "));
    let style = match &review.proofs {
        Ok(report) if !report.findings.is_empty() => FAILED,
        Err(_) => FAILED,
        Ok(report) if !report.is_confirmed() => UNDECIDED,
        Ok(_) => PASSED,
    };
    text.push_str(&format!("{style}proof{style:#}  {}\n", review.on_proofs()));
    text
}

fn differences(differences: &[Difference], indent: &str) -> String {
    let shown = differences.iter().take(MOST_SHOWN);
    let mut text: String = shown.map(|it| format!("{indent}{it}\n")).collect();
    if differences.len() > MOST_SHOWN {
        text.push_str(&format!("{DIM}{indent}and {} more{DIM:#}\n", differences.len() - MOST_SHOWN));
    }
    text
}

/// One of many logs.
fn line(log: &Path, review: &Review) -> String {
    let (style, word) = match review.code() {
        exit::AS_EXPECTED => (PASSED, "ok"),
        exit::INCONCLUSIVE => (UNDECIDED, "?"),
        exit::DIFFERS => (FAILED, "DIFF"),
        _ => (FAILED, "FAIL"),
    };
    let verdict = report::last_line(&review.run.verdict);
    let mut text = format!("{style}{word:>5}{style:#}  {NAME}{}{NAME:#}  {verdict}\n", log.display());
    text.push_str(&differences(&review.differences, "         "));
    text
}

/// One log in JSON.
#[derive(Serialize)]
struct Document<'r> {
    log: String,
    code: u8,
    /// Why it cannot be read; then nothing else is there.
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<&'r str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    verdict: Option<&'r Verdict>,
    differences: &'r [Difference],
    #[serde(skip_serializing_if = "Option::is_none")]
    proofs: Option<Proofs>,
}

/// What the independent checker says.
#[derive(Serialize)]
struct Proofs {
    confirmed: bool,
    pairs: usize,
    leaves: usize,
    sweeps: usize,
    limits: usize,
    unchecked_limits: usize,
    violated: Vec<String>,
    undecided: Vec<String>,
}

impl<'r> Document<'r> {
    fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("structs, strings and numbers have a JSON form")
    }

    fn of(log: &Path, reviewed: &'r Result<Review, String>) -> Self {
        let log = log.display().to_string();
        let review = match reviewed {
            Ok(review) => review,
            Err(error) => {
                let code = exit::UNREADABLE_RECORDING;
                return Self { log, code, error: Some(error), verdict: None, differences: &[], proofs: None };
            }
        };
        let names = |pairs: &[graspcheck_checker::PairName]| pairs.iter().map(ToString::to_string).collect();
        let proofs = review.proofs.as_ref().ok().map(|report| Proofs {
            confirmed: report.is_confirmed(),
            pairs: report.pairs,
            leaves: report.leaves,
            sweeps: report.sweeps,
            limits: report.limits,
            unchecked_limits: report.unchecked_limits,
            violated: names(&report.violated),
            undecided: names(&report.undecided),
        });
        let verdict = Some(&review.run.verdict);
        Self { log, code: review.code(), error: None, verdict, differences: &review.differences, proofs }
    }
}
