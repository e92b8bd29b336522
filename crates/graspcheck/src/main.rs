//! The command line of graspcheck: a thin layer over the library. Results go to standard output,
//! everything else to standard error.

mod cli;

use std::{panic::catch_unwind, process::ExitCode};

use clap::Parser;
use graspcheck::exit;

fn main() -> ExitCode {
    let arguments = cli::Arguments::parse();
    // A panic is a bug; it has printed its message by the time it arrives here.
    let code = catch_unwind(|| cli::execute(&arguments)).unwrap_or(exit::BUG);
    ExitCode::from(code)
}
