//! Arguments and dispatch.

mod list;
mod progress;
mod review;
mod run;
mod select;

use std::path::PathBuf;

use anstream::{ColorChoice, eprintln};
use clap::{Parser, Subcommand, ValueEnum};
use graspcheck::{exit, report::DIM};

const AFTER_HELP: &str = "\
Exit codes: 0 as expected, 1 a bug or unwritable output, 2 usage, 3 nothing selected,
            10 verdict not as expected, 11 inconclusive, 13 log differs from what is found,
            20 invalid file, 21 no plan, 30 unreadable recording

Start here:  graspcheck run scenarios/scara/pick_cube.toml";

/// Proves and simulates grasp motions of robot arms, and judges the recordings.
#[derive(Debug, Parser)]
#[command(version, after_help = AFTER_HELP, max_term_width = 100)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    command: Command,
    /// When to use colour
    #[arg(long, global = true, value_name = "WHEN", default_value = "auto", value_enum)]
    color: Color,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Plan, prove, simulate, record and judge scenarios
    Run(run::RunArguments),
    /// Judge logs again from their files alone, and check their proofs
    Review(review::ReviewArguments),
    /// Show scenarios
    List(list::ListArguments),
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Color {
    /// On a terminal, unless NO_COLOR is set
    Auto,
    /// Also into a pipe
    Always,
    /// Never
    Never,
}

/// Runs a command and returns its exit code.
pub(crate) fn execute(arguments: &Arguments) -> u8 {
    match arguments.color {
        Color::Auto => ColorChoice::Auto,
        Color::Always => ColorChoice::Always,
        Color::Never => ColorChoice::Never,
    }
    .write_global();
    let code = match &arguments.command {
        Command::Run(arguments) => run::execute(arguments),
        Command::Review(arguments) => review::execute(arguments),
        Command::List(arguments) => list::execute(arguments),
    };
    if code != exit::AS_EXPECTED {
        eprintln!("{DIM}exit {code}: {}{DIM:#}", exit::meaning(code));
    }
    code
}

/// Where scenarios are looked for by name.
fn default_root() -> PathBuf {
    PathBuf::from("scenarios")
}
