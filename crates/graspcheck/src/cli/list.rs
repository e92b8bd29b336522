//! `graspcheck list`: the scenarios of a folder.

use std::path::PathBuf;

use anstream::{eprintln, println};
use graspcheck::{
    exit,
    report::{DIM, NAME},
};

use super::default_root;

/// Show scenarios.
#[derive(clap::Args, Debug)]
pub(super) struct ListArguments {
    /// Folder to look in
    #[arg(value_name = "FOLDER", default_value_os_t = default_root())]
    root: PathBuf,
}

pub(super) fn execute(arguments: &ListArguments) -> u8 {
    let listed = match graspcheck_scenario::find(&arguments.root) {
        Ok(listed) => listed,
        Err(error) => {
            eprintln!("error: {error}");
            return exit::INVALID_FILE;
        }
    };
    let width = listed.iter().map(|found| found.name.len()).max().unwrap_or(0);
    for found in &listed {
        println!("{NAME}{:width$}{NAME:#}  {}", found.name, found.title);
    }
    eprintln!("{DIM}{} scenarios in {}{DIM:#}", listed.len(), arguments.root.display());
    if listed.is_empty() { exit::NOTHING_SELECTED } else { exit::AS_EXPECTED }
}
