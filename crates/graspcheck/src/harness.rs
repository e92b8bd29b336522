//! Scenario suites under `cargo test`: every scenario file is one named test.
//!
//! A suite of your own is a test target with `harness = false` and this as its whole source:
//!
//! ```no_run
//! fn main() -> std::process::ExitCode {
//!     graspcheck::harness::run("scenarios")
//! }
//! ```

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
};

use libtest_mimic::{Arguments, Failed, Trial};

use crate::{Silent, load, report, run_scenario, store};

/// Runs every scenario under `root` as one test and returns the exit code of the whole.
///
/// Tests are named by folder and file, `scara::pick_cube`, and understand the arguments of `cargo test`
/// and `cargo nextest`. Each writes its log under `target/graspcheck`. A folder without scenarios, or one
/// that cannot be read, is a failing test: an empty suite is not a passing one.
pub fn run(root: impl AsRef<Path>) -> ExitCode {
    let arguments = Arguments::from_args();
    let trials = trials(root.as_ref());
    libtest_mimic::run(&arguments, trials).exit_code()
}

fn trials(root: &Path) -> Vec<Trial> {
    let listed = match graspcheck_scenario::find(root) {
        Ok(listed) => listed,
        Err(error) => return vec![failing("suite", error.to_string())],
    };
    if listed.is_empty() {
        return vec![failing("suite", format!("{}: there is no scenario in this folder", root.display()))];
    }
    let workspace = workspace_of(root);
    let results = workspace.join("target").join("graspcheck");
    listed
        .into_iter()
        .map(|scenario| {
            let results = results.clone();
            Trial::test(scenario.name.clone(), move || judge(&scenario.path, &scenario.name, &results))
        })
        .collect()
}

fn failing(name: &str, message: String) -> Trial {
    Trial::test(name, move || Err(Failed::from(message)))
}

/// The nearest folder above the suite that has a `Cargo.lock`, else the current folder. Results go into its
/// `target/graspcheck`.
fn workspace_of(root: &Path) -> PathBuf {
    let root = root.canonicalize().unwrap_or_else(|_| root.to_owned());
    root.ancestors()
        .find(|folder| folder.join("Cargo.lock").is_file())
        .map(Path::to_owned)
        .unwrap_or_default()
}

fn judge(path: &Path, name: &str, results: &Path) -> Result<(), Failed> {
    let scenario = load(path).map_err(|error| report::faults(&error, false))?;
    let run = match run_scenario(&scenario, &mut Silent) {
        Ok(run) => run,
        Err(error) if report::is_expected(&error, &scenario.resolved.expect) => return Ok(()),
        Err(error) => return Err(report::plain(&report::no_run(&error, &scenario.resolved, false)).into()),
    };
    let stored = store::store(&run.recording, name, results).map_err(|error| error.to_string())?;
    if run.verdict.as_expected {
        return Ok(());
    }
    Err(Failed::from(format!(
        "{}\n\n  log     {}\n  again   cargo run -- run {name}",
        report::failure(&run, &scenario.resolved),
        stored.log.display(),
    )))
}
