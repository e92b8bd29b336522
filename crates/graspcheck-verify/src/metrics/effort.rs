//! What a motion costs: root mean square of effort, mechanical work.

use super::{Metric, Motion, of_joints, rms};
use crate::{evidence::Evidence, verdict::Unit};

/// Root mean square of the applied effort of every joint, and the work of all drives together.
pub(super) fn effort(evidence: &Evidence, motion: &Motion) -> Vec<Metric> {
    let mut all = of_joints(evidence, "executed.effort_rms", Unit::of_effort, |joint| {
        rms(&motion.measured[joint].effort)
    });
    let steps = motion.measured.first().map_or(0, |joint| joint.effort.len());
    // A drive that brakes turns work into heat; it does not give it to the others.
    let power = |k: usize| -> f64 {
        motion.measured.iter().map(|joint| (joint.effort[k] * joint.velocity[k]).max(0.0)).sum()
    };
    let sum: f64 = (0..steps).map(power).sum();
    let ends = if steps > 0 { 0.5 * (power(0) + power(steps - 1)) } else { 0.0 };
    let value = motion.dt * (sum - ends);
    all.push(Metric { name: "executed.energy", subject: None, value, unit: Unit::Joule });
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{fixture, metrics::metrics};

    #[test]
    fn work_is_effort_times_way() {
        let mut run = fixture::pick();
        let width = run.recording.measured.names.len();
        // 2 N·m at joint 0 against a motion at 0.5 rad/s, 3 N·m at joint 1 along one at 0.1 rad/s.
        let measured = &mut run.recording.measured;
        measured.effort.fill(0.0);
        measured.velocity.fill(0.0);
        for row in 0..measured.time_ns.len() {
            measured.effort[row * width] = -2.0;
            measured.velocity[row * width] = 0.5;
            measured.effort[row * width + 1] = 3.0;
            measured.velocity[row * width + 1] = 0.1;
        }
        let duration = (measured.time_ns.len() - 1) as f64 * fixture::DT;
        let recording = run.written();
        let metrics = metrics(&Evidence::from_recording(&recording).unwrap());
        let of = |name: &str| metrics.all.iter().find(|it| it.name == name).unwrap().value;
        assert!((of("executed.energy") - 0.3 * duration).abs() < 1e-9);
        assert!((of("executed.effort_rms") - 2.0).abs() < 1e-12);
    }
}
