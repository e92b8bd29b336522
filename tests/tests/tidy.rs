//! What no compiler holds about the files of this repository.

#![expect(clippy::unwrap_used, reason = "helpers of tests: a file that cannot be read fails the test")]

use std::{
    fs,
    path::{Path, PathBuf},
};

/// Files of more than [`LONGEST`] lines that are one thing all the same, each with why.
const LONG: &[(&str, &str)] = &[];

/// A source file with more lines than this before its unit tests is asked whether it holds two things.
const LONGEST: usize = 600;

/// Folders that are not ours or not source.
const SKIPPED: &[&str] = &["target", ".git", ".venv", "__pycache__"];

/// What a text file may end in; others are not read.
const TEXT: &[&str] = &["rs", "toml", "md", "py", "txt", "json", "urdf", "snap", "yml", "yaml"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

/// The text files of the repository, sorted: path from its root, and content.
fn texts() -> Vec<(String, String)> {
    let mut found = Vec::new();
    let mut folders = vec![root()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_str().unwrap();
            if path.is_dir() {
                if !SKIPPED.contains(&name) {
                    folders.push(path);
                }
                continue;
            }
            let is_text = path.extension().is_some_and(|end| TEXT.iter().any(|text| end == *text));
            if is_text || folder.ends_with(".ci") {
                let short = path.strip_prefix(root()).unwrap().to_str().unwrap().replace('\\', "/");
                found.push((short, fs::read_to_string(&path).unwrap()));
            }
        }
    }
    found.sort();
    assert!(found.len() > 50, "only {} files were found", found.len());
    found
}

fn is_rust(path: &str) -> bool {
    path.ends_with(".rs")
}

/// Every line of `texts` in which `is_fault` finds one, as `path:line: text`.
fn lines_with(texts: &[(String, String)], is_fault: impl Fn(&str, &str) -> bool) -> Vec<String> {
    let lines = texts.iter().flat_map(|(path, text)| text.lines().enumerate().map(move |line| (path, line)));
    lines
        .filter(|(path, (_, line))| is_fault(path, line))
        .map(|(path, (index, line))| format!("{path}:{}: {}", index + 1, line.trim()))
        .collect()
}

fn assert_none(faults: &[String], what: &str) {
    assert!(faults.is_empty(), "{what}:\n  {}\n", faults.join("\n  "));
}

#[test]
fn no_file_names_a_folder_of_somebodys_machine() {
    let homes = ["root", "home", "work", "Users", "mnt"].map(|folder| format!("/{folder}/"));
    // `a/home/b` is a path inside something else; a machine's begins after a space, a quote or a bracket.
    let begins = |line: &str, home: &str| {
        line.match_indices(home).any(|(at, _)| {
            line[..at]
                .chars()
                .next_back()
                .is_none_or(|before| !(before.is_alphanumeric() || "._-*)}".contains(before)))
        })
    };
    // Somebody who is nobody, in examples.
    let nobody = ["/ho", "me/me/"].concat();
    let faults = lines_with(&texts(), |_, line| {
        let line = line.replace(&nobody, "");
        homes.iter().any(|home| begins(&line, home))
    });
    assert_none(&faults, "paths of a machine");
}

#[test]
fn no_test_is_ignored_and_nothing_is_left_to_do() {
    // In two parts, so that this file does not find itself.
    let marks =
        [["#[ign", "ore"], ["to", "do!("], ["unimpl", "emented!("], ["FIX", "ME"]].map(|mark| mark.concat());
    let faults =
        lines_with(&texts(), |path, line| is_rust(path) && marks.iter().any(|mark| line.contains(mark)));
    assert_none(&faults, "left for later");
}

#[test]
fn an_order_that_depends_on_a_hash_is_used_nowhere() {
    let names = ["Hash", "FxHash"].iter().flat_map(|hash| [format!("{hash}Map"), format!("{hash}Set")]);
    let names: Vec<String> = names.collect();
    let faults = lines_with(&texts(), |path, line| {
        is_rust(path) && !line.trim_start().starts_with("//") && names.iter().any(|name| line.contains(name))
    });
    assert_none(&faults, "use BTreeMap, BTreeSet or a Vec");
}

#[test]
fn every_crate_and_every_file_of_a_crate_begins_with_its_docs() {
    let undocumented: Vec<String> = texts()
        .into_iter()
        .filter(|(path, text)| is_rust(path) && !text.starts_with("//!"))
        .map(|(path, _)| path)
        .collect();
    assert_none(&undocumented, "does not begin with `//!`");
}

#[test]
fn long_files_are_long_for_a_reason() {
    let texts = texts();
    let length = |text: &str| text.lines().take_while(|line| *line != "mod tests {").count();
    let is_long = |text: &str| length(text) > LONGEST;
    let unexplained: Vec<String> = texts
        .iter()
        .filter(|(path, text)| is_rust(path) && is_long(text) && !LONG.iter().any(|(long, _)| long == path))
        .map(|(path, text)| format!("{path} has {} lines", length(text)))
        .collect();
    assert_none(&unexplained, "does it hold two things?");
    for (path, _) in LONG {
        let still = texts.iter().any(|(found, text)| found == path && is_long(text));
        assert!(still, "{path} is no longer long: take it from the list");
    }
}

#[test]
fn decisions_are_numbered_and_say_what_a_decision_must() {
    let decisions: Vec<(String, String)> =
        texts().into_iter().filter(|(path, _)| path.starts_with("docs/decisions/0")).collect();
    assert!(!decisions.is_empty());
    for (index, (path, text)) in decisions.iter().enumerate() {
        assert!(
            path.starts_with(&format!("docs/decisions/{:04}-", index + 1)),
            "{path}: numbers have a hole"
        );
        for part in ["Context", "Decision", "Because", "Costs", "Reopen when"] {
            assert!(text.contains(&format!("**{part}.**")), "{path}: no **{part}.**");
        }
    }
}
