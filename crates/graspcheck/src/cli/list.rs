//! `graspcheck list`: the scenarios of a folder.

use std::path::PathBuf;

use anstream::{eprintln, println};
use graspcheck::{
    exit,
    report::{DIM, NAME},
};

use super::{
    default_root,
    select::{Unselected, below},
};

/// Show scenarios.
#[derive(clap::Args, Debug)]
pub(super) struct ListArguments {
    /// Folder to look in
    #[arg(value_name = "FOLDER", default_value_os_t = default_root())]
    root: PathBuf,
}

pub(super) fn execute(arguments: &ListArguments) -> u8 {
    let listed = match below(&arguments.root) {
        Ok(listed) => listed,
        Err(Unselected { message, code }) => {
            eprintln!("error: {message}");
            return code;
        }
    };
    let width = listed.iter().map(|found| found.name.len()).max().unwrap_or(0);
    for found in &listed {
        println!("{NAME}{:width$}{NAME:#}  {}", found.name, found.title);
    }
    let plural = if listed.len() == 1 { "" } else { "s" };
    eprintln!("{DIM}{} scenario{plural} in {}{DIM:#}", listed.len(), arguments.root.display());
    exit::AS_EXPECTED
}
