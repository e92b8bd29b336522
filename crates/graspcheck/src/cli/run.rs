//! `graspcheck run`: the whole pipeline on one scenario or on a suite.

use std::{
    path::PathBuf,
    sync::{
        Mutex,
        atomic::{AtomicUsize, Ordering},
    },
    thread,
};

use anstream::{eprint, eprintln, print, println};
use graspcheck::{
    Observer, Run, Scenario, Silent, exit, html, load,
    report::{self, DIM, FAILED, NAME, PASSED, UNDECIDED},
    run_scenario, store,
    store::Stored,
};
use graspcheck_verify::Outcome;

use super::{
    progress::Progress,
    select::{Selected, Unselected, select},
};

const EXAMPLES: &str = "\
Examples:
  graspcheck run scenarios/scara/pick_cube.toml    one scenario, with its table of checks
  graspcheck run scenarios                         the whole library
  graspcheck run scara::                           one suite";

/// Plan, prove, simulate, record and judge scenarios.
#[derive(clap::Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct RunArguments {
    /// Files, folders, or names such as scara::pick_cube; a prefix selects many
    #[arg(value_name = "SCENARIO", required = true)]
    scenarios: Vec<String>,
    /// Threads for a suite; the default is one for each core
    #[arg(short = 'j', long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// Plan and prove only: nothing is executed, and only the plan is judged
    #[arg(long)]
    no_simulate: bool,
    /// Print what is not as expected and the last line; twice: print nothing
    #[arg(short, long, action = clap::ArgAction::Count)]
    quiet: u8,
    /// List every way to do the task that planning looked at
    #[arg(short, long)]
    verbose: bool,
    /// Where to write
    #[arg(long, value_name = "DIR", env = "GRASPCHECK_OUT", default_value = "target/graspcheck")]
    out: PathBuf,
}

pub(super) fn execute(arguments: &RunArguments) -> u8 {
    let selected = match select(&arguments.scenarios) {
        Ok(selected) => selected,
        Err(Unselected { message, code }) => {
            eprintln!("error: {message}");
            return code;
        }
    };
    match selected.as_slice() {
        [one] => one_scenario(one, arguments),
        many => suite(many, arguments),
    }
}

/// One scenario that came to its end, or why it did not.
type Ended = Result<(Scenario, Run, Stored), NotRun>;

/// Why a scenario did not come to its end.
struct NotRun {
    /// The exit code; that of success where no motion exists and none is expected.
    code: u8,
    /// The whole of it.
    text: String,
    /// The answer in one line, where there is one.
    line: Option<String>,
}

impl NotRun {
    fn new(code: u8, text: String) -> Self {
        Self { code, text, line: None }
    }
}

fn carry_out(selected: &Selected, arguments: &RunArguments, observer: &mut dyn Observer) -> Ended {
    let mut scenario = load(&selected.path)
        .map_err(|error| NotRun::new(exit::INVALID_FILE, report::faults(&error, true)))?;
    if arguments.no_simulate {
        scenario.resolved.execution = None;
    }
    let run = run_scenario(&scenario, observer).map_err(|error| NotRun {
        code: report::exit_code(&error, &scenario.resolved.expect),
        text: report::no_run(&error, &scenario.resolved, arguments.verbose),
        line: report::no_motion_line(&error, &scenario.resolved.expect),
    })?;
    let stored = store::store(&run.recording, &scenario.resolved.name, &arguments.out)
        .map_err(|error| NotRun::new(exit::BUG, format!("error: {error}\n")))?;
    Ok((scenario, run, stored))
}

fn code_of(run: &Run) -> u8 {
    exit::of_verdict(&run.verdict)
}

fn one_scenario(selected: &Selected, arguments: &RunArguments) -> u8 {
    let mut progress = Progress::new();
    let ended = if arguments.quiet > 0 {
        carry_out(selected, arguments, &mut Silent)
    } else {
        carry_out(selected, arguments, &mut progress)
    };
    let (scenario, run, stored) = match ended {
        Ok(ended) => ended,
        Err(NotRun { code, text, line }) => {
            match line.filter(|_| code == exit::AS_EXPECTED) {
                Some(line) if arguments.quiet == 1 => println!("{NAME}{}{NAME:#}  {line}", selected.name),
                Some(_) if arguments.quiet == 0 => print!("{text}"),
                None if arguments.quiet < 2 => eprint!("{text}"),
                _ => {}
            }
            return code;
        }
    };
    let code = code_of(&run);
    if arguments.quiet == 0 {
        let size = std::fs::metadata(&stored.log).map_or(0, |metadata| metadata.len());
        progress.line("Recorded", &format!("{:.1} MB of log", size as f64 / 1e6));
        eprintln!();
    }
    if arguments.quiet == 1 && code == exit::AS_EXPECTED {
        println!("{NAME}{}{NAME:#}  {}", run.verdict.scenario, report::last_line(&run.verdict));
    } else if arguments.quiet < 2 {
        print!("{}", report::page(&run, &scenario.resolved, arguments.verbose));
        eprintln!("  log    {}", stored.log.display());
        if let Some(page) = &stored.report {
            eprintln!("  report {}", page.display());
        }
        if let Some(rerun) = &stored.rerun {
            eprintln!("  rerun  {}", rerun.display());
        }
    }
    code
}

fn suite(selected: &[Selected], arguments: &RunArguments) -> u8 {
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let threads = arguments.threads.map_or(cores, usize::from).min(selected.len());
    let next = AtomicUsize::new(0);
    let finished = AtomicUsize::new(0);
    let results: Vec<Mutex<Option<Ended>>> = selected.iter().map(|_| Mutex::new(None)).collect();
    if arguments.quiet == 0 {
        eprintln!("{DIM}Running {} scenarios on {threads} threads{DIM:#}", selected.len());
    }
    thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                while let Some((index, scenario)) =
                    Some(next.fetch_add(1, Ordering::Relaxed)).and_then(|k| Some((k, selected.get(k)?)))
                {
                    let ended = carry_out(scenario, arguments, &mut Silent);
                    let count = finished.fetch_add(1, Ordering::Relaxed) + 1;
                    if arguments.quiet == 0 {
                        eprintln!("{}", line(scenario, &ended, count, selected.len()));
                    }
                    if let Ok(mut slot) = results[index].lock() {
                        *slot = Some(ended);
                    }
                }
            });
        }
    });
    let ended: Vec<Ended> = results
        .into_iter()
        .map(|slot| match slot.into_inner() {
            Ok(Some(ended)) => ended,
            _ => Err(NotRun::new(exit::BUG, "error: the run was lost in a panic\n".to_owned())),
        })
        .collect();
    summary(selected, &ended, arguments)
}

fn line(scenario: &Selected, ended: &Ended, count: usize, of: usize) -> String {
    let (style, word, detail) = match ended {
        Ok((_, run, _)) => {
            let code = code_of(run);
            let style = match code {
                exit::AS_EXPECTED => PASSED,
                exit::INCONCLUSIVE => UNDECIDED,
                _ => FAILED,
            };
            let word = match code {
                exit::AS_EXPECTED => "ok",
                _ if run.verdict.is_not_judged() => "-",
                exit::INCONCLUSIVE => "?",
                _ => "FAIL",
            };
            (style, word, report::last_line(&run.verdict))
        }
        Err(NotRun { code: exit::AS_EXPECTED, line: Some(line), .. }) => (PASSED, "ok", line.clone()),
        Err(NotRun { code, .. }) => (FAILED, "ERROR", exit::meaning(*code).to_owned()),
    };
    format!("{style}{word:>5}{style:#} ({count:>2}/{of}) {NAME}{}{NAME:#}  {detail}", scenario.name)
}

/// What is not as expected, in order of names, then the counts.
fn summary(selected: &[Selected], ended: &[Ended], arguments: &RunArguments) -> u8 {
    for (scenario, ended) in selected.iter().zip(ended) {
        match ended {
            Ok((loaded, run, _)) => {
                let is_good = run.verdict.as_expected || run.verdict.is_not_judged();
                if !is_good && arguments.quiet < 2 {
                    println!("\n{}", report::page(run, &loaded.resolved, arguments.verbose));
                }
            }
            Err(NotRun { code: exit::AS_EXPECTED, .. }) => {}
            Err(NotRun { text, .. }) => {
                if arguments.quiet < 2 {
                    eprintln!("\n{NAME}{}{NAME:#}\n{text}", scenario.name);
                }
            }
        }
    }
    let counts = Counts::of(ended);
    if arguments.quiet < 2 {
        println!("\nSummary  {}", counts.sentence(arguments.no_simulate));
    }
    let entries: Vec<html::Entry> =
        selected.iter().zip(ended).map(|(scenario, ended)| entry(scenario, ended, arguments)).collect();
    match store::store_index(&entries, &arguments.out) {
        Ok(index) => {
            if arguments.quiet < 2 {
                eprintln!("{DIM}  results  {}{DIM:#}", index.display());
            }
            counts.code()
        }
        Err(error) => {
            eprintln!("{FAILED}error{FAILED:#}: {error}");
            exit::BUG
        }
    }
}

/// What the index says about one scenario.
fn entry(scenario: &Selected, ended: &Ended, arguments: &RunArguments) -> html::Entry {
    let result = match ended {
        Ok((_, run, stored)) => {
            let page = stored.report.as_deref().unwrap_or(&stored.log);
            let beside = page.strip_prefix(&arguments.out).unwrap_or(page);
            Ok((run.verdict.clone(), beside.display().to_string()))
        }
        Err(NotRun { code, line, .. }) => {
            Err(line.as_deref().map_or_else(|| exit::meaning(*code).to_owned(), report::plain))
        }
    };
    let as_expected = match ended {
        Ok((_, run, _)) => run.verdict.as_expected,
        Err(NotRun { code, .. }) => *code == exit::AS_EXPECTED,
    };
    html::Entry { name: scenario.name.clone(), result, as_expected }
}

/// How a suite came out.
struct Counts {
    /// Codes of the scenarios that were judged or did not come to their end.
    codes: Vec<u8>,
    /// Scenarios that fail as they must.
    negative: usize,
    /// Scenarios whose expected failures were all left out with the execution.
    not_judged: usize,
}

impl Counts {
    fn of(ended: &[Ended]) -> Self {
        let mut counts = Self { codes: Vec::with_capacity(ended.len()), negative: 0, not_judged: 0 };
        for ended in ended {
            match ended {
                Ok((_, run, _)) if run.verdict.is_not_judged() => counts.not_judged += 1,
                Ok((_, run, _)) => {
                    counts.codes.push(code_of(run));
                    counts.negative +=
                        usize::from(run.verdict.as_expected && run.verdict.outcome == Outcome::Fail);
                }
                Err(NotRun { code, .. }) => {
                    counts.codes.push(*code);
                    counts.negative += usize::from(*code == exit::AS_EXPECTED);
                }
            }
        }
        counts
    }

    fn sentence(&self, plans_only: bool) -> String {
        let all = self.codes.len() + self.not_judged;
        let as_expected = self.codes.iter().filter(|code| **code == exit::AS_EXPECTED).count();
        let not = self.codes.len() - as_expected;
        let plural = if all == 1 { "" } else { "s" };
        let what = if plans_only { ", plans only, nothing was executed" } else { "" };
        let mut text = format!(
            "{all} scenario{plural}{what}: {as_expected} as expected ({} of them fail on purpose), {not} not",
            self.negative
        );
        if self.not_judged > 0 {
            text.push_str(&format!(", {} not judged: they must fail in execution", self.not_judged));
        }
        text
    }

    /// A scenario that was not judged counts in a suite as it does alone.
    fn code(&self) -> u8 {
        let not_judged = (self.not_judged > 0).then_some(exit::INCONCLUSIVE);
        exit::worst(&self.codes.iter().copied().chain(not_judged).collect::<Vec<u8>>())
    }
}
