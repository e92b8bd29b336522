//! What the messages do not say: the names of series that may have no row, and the order of frames.
//!
//! It is the metadata record `layout`, next to `run` at the start of the file.

use std::collections::BTreeMap;

use crate::{FrameSeries, JointSeries, PoseSeries, Recording};

/// Name of the metadata record.
pub(super) const LAYOUT: &str = "layout";

/// Version of the form of the file: topics, messages and this record.
const SCHEMA: &str = "2";

/// The record of a recording.
pub(super) fn describe(recording: &Recording) -> BTreeMap<String, String> {
    let mut entries = BTreeMap::from([("schema".to_owned(), SCHEMA.to_owned())]);
    let joints = [("measured", &recording.measured), ("reference", &recording.reference)];
    for (series, joints) in joints {
        for (index, name) in joints.names.iter().enumerate() {
            entries.insert(format!("{series}.joint.{index}"), name.clone());
        }
    }
    let poses = [
        ("tool", &recording.tool),
        ("reference_tool", &recording.reference_tool),
        ("object", &recording.object),
    ];
    for (series, poses) in poses {
        entries.insert(format!("{series}.frame"), poses.frame.clone());
        entries.insert(format!("{series}.child"), poses.child.clone());
    }
    for (index, frame) in recording.frames.iter().enumerate() {
        entries.insert(format!("frame.{index}.parent"), frame.parent.clone());
        entries.insert(format!("frame.{index}.child"), frame.child.clone());
    }
    entries
}

/// A recording without rows, with the names that the record gives.
///
/// # Errors
/// Another schema, or a name that is missing.
pub(super) fn empty_recording(entries: &BTreeMap<String, String>) -> Result<Recording, String> {
    match entries.get("schema").map(String::as_str) {
        Some(SCHEMA) => {}
        Some(other) => return Err(format!("its layout has schema {other}, this version reads {SCHEMA}")),
        None => return Err("its metadata record `layout` has no schema".to_owned()),
    }
    let joints = |series: &str| {
        JointSeries::new(numbered(entries, &format!("{series}.joint."), "").cloned().collect())
    };
    let poses = |series: &str| -> Result<PoseSeries, String> {
        let entry = |key: &str| {
            let key = format!("{series}.{key}");
            entries.get(&key).cloned().ok_or(format!("its metadata record `layout` lacks {key}"))
        };
        Ok(PoseSeries { frame: entry("frame")?, child: entry("child")?, ..PoseSeries::default() })
    };
    let parents = numbered(entries, "frame.", ".parent");
    let children = numbered(entries, "frame.", ".child");
    let frames = parents.zip(children).map(|(parent, child)| FrameSeries {
        parent: parent.clone(),
        child: child.clone(),
        ..FrameSeries::default()
    });
    Ok(Recording {
        measured: joints("measured"),
        reference: joints("reference"),
        tool: poses("tool")?,
        reference_tool: poses("reference_tool")?,
        object: poses("object")?,
        frames: frames.collect(),
        ..Recording::default()
    })
}

/// The values of `prefix0suffix`, `prefix1suffix` … as far as they go.
fn numbered<'a>(
    entries: &'a BTreeMap<String, String>,
    prefix: &'a str,
    suffix: &'a str,
) -> impl Iterator<Item = &'a String> {
    (0..).map_while(move |index: usize| entries.get(&format!("{prefix}{index}{suffix}")))
}
