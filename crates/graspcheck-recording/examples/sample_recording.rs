//! Writes a synthetic recording of two seconds, for trying readers: `sample_recording OUT.mcap [DUMP.json]`.
//! The dump holds the joint states to the last bit, for `tests/readers/read_mcap.py --joint-states`.

#[path = "../tests/sample/mod.rs"]
mod sample;

use std::{env, error::Error, fs, path::Path};

use graspcheck_recording::JointSeries;

fn main() -> Result<(), Box<dyn Error>> {
    let mut paths = env::args_os().skip(1);
    let path = paths.next().ok_or("usage: sample_recording OUT.mcap [DUMP.json]")?;
    let recording = sample::recording(2000);
    graspcheck_recording::save(&recording, Path::new(&path))?;
    if let Some(path) = paths.next() {
        let (measured, reference) = (json(&recording.measured), json(&recording.reference));
        fs::write(path, format!("{{\"measured\": {measured}, \"reference\": {reference}}}\n"))?;
    }
    Ok(())
}

/// Debug output of finite numbers and plain names is JSON, and as exact as need be.
fn json(series: &JointSeries) -> String {
    let JointSeries { names, time_ns, position, velocity, effort } = series;
    format!(
        "{{\"names\": {names:?}, \"time_ns\": {time_ns:?}, \"position\": {position:?}, \
         \"velocity\": {velocity:?}, \"effort\": {effort:?}}}"
    )
}
