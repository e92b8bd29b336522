//! Writes the Rerun file of a log that exists already: `rrd_from_mcap RUN.mcap OUT.rrd`.

use std::{env, error::Error, path::Path};

fn main() -> Result<(), Box<dyn Error>> {
    let mut paths = env::args_os().skip(1);
    let (Some(log), Some(out)) = (paths.next(), paths.next()) else {
        return Err("usage: rrd_from_mcap RUN.mcap OUT.rrd".into());
    };
    let recording = graspcheck_recording::load(Path::new(&log))?;
    let scenario = recording.metadata.get("scenario").map_or("", String::as_str);
    graspcheck_rerun::save(&recording, scenario, Path::new(&out))?;
    Ok(())
}
