//! Rerun files of recordings: written as a whole, readable, or an error that leaves nothing.

#[path = "../../graspcheck-recording/tests/sample/mod.rs"]
mod sample;

use std::{fs, path::PathBuf};

use graspcheck_recording::Recording;
use graspcheck_rerun::{RerunError, save};

const VERDICT: &str = include_str!("verdict.json");

fn folder(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("graspcheck-rerun-{}-{name}", std::process::id()));
    fs::create_dir_all(&path).expect("the temporary folder can be written");
    path
}

#[test]
fn a_recording_becomes_a_complete_file() {
    let folder = folder("complete");
    let path = folder.join("run.rrd");
    let recording = Recording { verdict: Some(VERDICT.to_owned()), ..sample::recording(2000) };
    save(&recording, "sample::wall", &path).unwrap();
    save(&recording, "sample::wall", &path).unwrap();

    let bytes = fs::read(&path).unwrap();
    assert!(bytes.starts_with(b"RRF2"));
    assert!(bytes.len() > 100_000, "{} bytes", bytes.len());
    let names: Vec<_> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(names, ["run.rrd"]);
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_recording_without_anything_becomes_a_file() {
    let folder = folder("empty");
    save(&Recording::default(), "nothing", &folder.join("run.rrd")).unwrap();
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn what_cannot_be_written_leaves_nothing() {
    let folder = folder("nothing");
    let path = folder.join("run.rrd");
    let faulty = Recording { verdict: Some("{\"outcome\": \"maybe\"}".to_owned()), ..Recording::default() };
    let error = save(&faulty, "faulty", &path).unwrap_err();
    assert!(matches!(error, RerunError::Verdict(_)), "{error}");

    let error = save(&Recording::default(), "lost", &folder.join("missing/run.rrd")).unwrap_err();
    assert!(matches!(error, RerunError::Stream { .. }), "{error}");

    fs::create_dir_all(path.join("inside")).unwrap();
    let error = save(&Recording::default(), "taken", &path).unwrap_err();
    assert!(matches!(error, RerunError::File { .. }), "{error}");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
    fs::remove_dir_all(folder).unwrap();
}
