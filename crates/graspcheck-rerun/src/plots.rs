//! The curves: joints, shares of the limits, clearance, tracking, gripper. Units are in the names, since no
//! viewer knows units.

use graspcheck_model::robot::JointKind;
use graspcheck_recording::{JointSeries, MonitorSample};
use rerun::{RecordingStream, RecordingStreamError, Scalars, SeriesLines, components::InterpolationMode};

use crate::{PALETTE, RED, Run, color, joint_units::arm_joints, times};

/// The least range of clearances that is shown, m.
const CLEARANCE_SHOWN: f64 = 0.02;

/// A plot shows clearances up to this many times the required one, and up to this many times the least one;
/// more would hide both.
const CLEARANCES_SHOWN: f64 = 5.0;

/// The largest share of a limit that is shown; one that is far beyond would flatten all others. The true one
/// is in the log and in the verdict.
const MOST_SHARE: f64 = 1.5;

/// Entries of the palette for joints, so that neighbours differ most.
const JOINT_COLORS: [usize; 8] = [0, 5, 3, 4, 2, 1, 6, 7];

/// Degrees in a radian.
const DEGREES: f64 = 180.0 / std::f64::consts::PI;

pub(crate) fn log(stream: &RecordingStream, run: &Run) -> Result<(), RecordingStreamError> {
    log_joints(stream, run)?;
    log_monitor(stream, run)
}

/// Whether the recording says how far bodies are apart.
pub(crate) fn has_clearance(run: &Run) -> bool {
    run.recording.monitor.iter().any(|sample| sample.clearance_margin_m.is_some())
}

/// One entity a quantity, with one curve for each joint of the arm.
fn log_joints(stream: &RecordingStream, run: &Run) -> Result<(), RecordingStreamError> {
    let measured = &run.recording.measured;
    let kinds = arm_joints(run.recording);
    // Without the document all joints are shown, in SI units.
    let joints: Vec<(usize, Option<JointKind>)> = measured
        .names
        .iter()
        .enumerate()
        .filter_map(|(joint, name)| match kinds.iter().find(|(known, _)| known == name) {
            Some((_, kind)) => Some((joint, Some(*kind))),
            None => kinds.is_empty().then_some((joint, None)),
        })
        .collect();
    if joints.is_empty() || measured.is_empty() {
        return Ok(());
    }
    let quantities = [
        ("joints/position", &measured.position, ["°", "mm", "rad or m"], [DEGREES, 1e3]),
        ("joints/velocity", &measured.velocity, ["°/s", "mm/s", "rad/s or m/s"], [DEGREES, 1e3]),
        ("joints/effort", &measured.effort, ["N·m", "N", "N·m or N"], [1.0, 1.0]),
    ];
    for (entity, values, [angular, linear, either], [per_radian, per_meter]) in quantities {
        let unit = |kind: Option<JointKind>| match kind {
            Some(JointKind::Revolute) => (angular, per_radian),
            Some(JointKind::Prismatic) => (linear, per_meter),
            None => (either, 1.0),
        };
        let names =
            joints.iter().map(|&(joint, kind)| format!("{} [{}]", measured.names[joint], unit(kind).0));
        let colors = JOINT_COLORS.into_iter().cycle().take(joints.len()).map(|entry| color(PALETTE[entry]));
        stream.log_static(entity, &SeriesLines::new().with_names(names).with_colors(colors))?;

        let JointSeries { names, time_ns, .. } = measured;
        let rows = values.chunks_exact(names.len());
        let scalars = rows.flat_map(|row| joints.iter().map(|&(joint, kind)| row[joint] * unit(kind).1));
        stream.send_columns(
            entity,
            [times(time_ns.iter().copied())],
            Scalars::update_fields().with_scalars(scalars).columns(vec![joints.len(); time_ns.len()])?,
        )?;
    }
    Ok(())
}

fn log_monitor(stream: &RecordingStream, run: &Run) -> Result<(), RecordingStreamError> {
    if run.recording.monitor.is_empty() {
        return Ok(());
    }
    let share = |entity, name, rgb, steps, value: fn(&MonitorSample) -> f64| {
        log_curve(stream, run, entity, name, rgb, steps, &|sample| {
            Some(100.0 * value(sample).min(MOST_SHARE))
        })
    };
    share("plot/share/velocity", "velocity", PALETTE[0], false, |sample| sample.velocity_ratio)?;
    share("plot/share/acceleration", "acceleration", PALETTE[3], false, |sample| sample.acceleration_ratio)?;
    share("plot/share/jerk", "jerk", PALETTE[4], true, |sample| sample.jerk_ratio)?;
    share("plot/share/torque", "torque", PALETTE[5], false, |sample| sample.torque_ratio)?;
    log_limit(stream, run, "plot/share/limit", 100.0)?;

    let limit = |names: &[&str]| run.verdict.and_then(|verdict| verdict.limit(names));
    log_curve(stream, run, "plot/tracking/tool", "tool", PALETTE[0], false, &|sample| {
        Some(1e3 * sample.tool_error_m)
    })?;
    if let Some(limit) = limit(&["executed.tracking"]) {
        log_limit(stream, run, "plot/tracking/limit", 1e3 * limit)?;
    }
    if has_clearance(run) {
        let margins = run.recording.monitor.iter().filter_map(|sample| sample.clearance_margin_m);
        let least = margins.fold(f64::INFINITY, f64::min);
        let required = limit(&["planned.clearance"]).unwrap_or(0.0);
        let most = (CLEARANCES_SHOWN * required.max(least)).max(CLEARANCE_SHOWN);
        log_curve(stream, run, "plot/clearance/margin", "room", PALETTE[0], false, &|sample| {
            sample.clearance_margin_m.map(|margin| 1e3 * margin.min(most))
        })?;
        log_limit(stream, run, "plot/clearance/limit", 0.0)?;
    }
    log_curve(stream, run, "plot/gripper/opening", "opening [mm]", PALETTE[0], false, &|sample| {
        Some(1e3 * sample.opening_m)
    })?;
    log_curve(stream, run, "plot/gripper/force", "force [N]", PALETTE[5], false, &|sample| {
        Some(sample.grip_force_n)
    })
}

/// One curve over the monitor samples that have a value.
fn log_curve(
    stream: &RecordingStream,
    run: &Run,
    entity: &str,
    name: &str,
    rgb: u32,
    steps: bool,
    value: &dyn Fn(&MonitorSample) -> Option<f64>,
) -> Result<(), RecordingStreamError> {
    // A jerk holds until the next sample.
    let mode = if steps { InterpolationMode::StepAfter } else { InterpolationMode::Linear };
    let look = SeriesLines::new().with_names([name]).with_colors([color(rgb)]).with_interpolation_mode(mode);
    stream.log_static(entity, &look)?;
    let monitor = &run.recording.monitor;
    let known = monitor.iter().filter_map(|sample| Some((sample.time_ns, value(sample)?)));
    let (stamps, values): (Vec<i64>, Vec<f64>) = known.unzip();
    stream.send_columns(
        entity,
        [times(stamps)],
        Scalars::update_fields().with_scalars(values).columns_of_unit_batches()?,
    )
}

/// A limit as a thin red line over the whole run.
fn log_limit(
    stream: &RecordingStream,
    run: &Run,
    entity: &str,
    value: f64,
) -> Result<(), RecordingStreamError> {
    let look = SeriesLines::new().with_names(["limit"]).with_colors([color(RED)]).with_widths([1.0]);
    stream.log_static(entity, &look)?;
    stream.send_columns(
        entity,
        [times([0, run.end_ns.max(1)])],
        Scalars::update_fields().with_scalars([value, value]).columns_of_unit_batches()?,
    )
}
