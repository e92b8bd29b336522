//! Writes a synthetic recording of two seconds for trying readers: `sample_recording OUT.mcap`.

#[path = "../tests/sample/mod.rs"]
mod sample;

use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args_os().nth(1).ok_or("usage: sample_recording OUT.mcap")?;
    graspcheck_recording::save(&sample::recording(2000), Path::new(&path))?;
    Ok(())
}
