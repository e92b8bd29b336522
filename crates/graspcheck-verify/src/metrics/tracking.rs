//! How exactly a motion follows its command: at equal times, and whenever.

use nalgebra::Vector3;

use super::{Metric, Motion, largest, of_joints, rms};
use crate::{evidence::Evidence, verdict::Unit};

/// The command is looked for this long before and after an instant, s: a motion that is later than that has left its
/// path where the path meets itself.
const WINDOW: f64 = 0.25;

/// Measured less commanded position of every joint at equal times: largest magnitude and root mean square.
pub(super) fn joints(evidence: &Evidence, motion: &Motion) -> Vec<Metric> {
    let errors: Vec<Vec<f64>> = motion
        .measured
        .iter()
        .zip(&motion.commanded)
        .map(|(measured, commanded)| {
            measured.position.iter().zip(&commanded.position).map(|(a, b)| a - b).collect()
        })
        .collect();
    let unit = |kind| Unit::of_derivative(kind, 0);
    let mut all =
        of_joints(evidence, "executed.joint_error_max", unit, |joint| largest(errors[joint].iter().copied()));
    all.extend(of_joints(evidence, "executed.joint_error_rms", unit, |joint| rms(&errors[joint])));
    all
}

/// Distance of the tool from where it is commanded at equal times, and from the path of the command, m.
pub(super) fn tool(motion: &Motion) -> Vec<Metric> {
    let places = |poses: &[crate::stream::PoseSample]| -> Vec<Vector3<f64>> {
        poses.iter().map(|sample| sample.world_from_body.translation.vector).collect()
    };
    let (measured, commanded) = (places(&motion.tool), places(&motion.commanded_tool));
    let errors: Vec<f64> = measured.iter().zip(&commanded).map(|(a, b)| (a - b).norm()).collect();
    // A window that is a fraction of a step long still has the steps next to it.
    let reach = (WINDOW / motion.dt).ceil().max(1.0) as usize;
    let metric = |name, value| Metric { name, subject: None, value, unit: Unit::Meter };
    vec![
        metric("executed.tool_error_max", largest(errors.iter().copied())),
        metric("executed.tool_error_rms", rms(&errors)),
        metric("executed.path_error_max", farthest_from_path(&measured, &commanded, reach)),
    ]
}

/// The largest distance of a point from the polyline of those commands whose index differs by at most `reach`.
fn farthest_from_path(points: &[Vector3<f64>], commands: &[Vector3<f64>], reach: usize) -> f64 {
    let distance = |(index, point): (usize, &Vector3<f64>)| {
        let window = &commands[index.saturating_sub(reach)..(index + reach + 1).min(commands.len())];
        let alone = window.first().map_or(f64::INFINITY, |only| (point - only).norm());
        window.windows(2).map(|ends| distance_to_segment(point, ends)).fold(alone, f64::min)
    };
    points.iter().enumerate().map(distance).fold(0.0, f64::max)
}

fn distance_to_segment(point: &Vector3<f64>, ends: &[Vector3<f64>]) -> f64 {
    let along = ends[1] - ends[0];
    let length = along.norm_squared();
    let share = if length > 0.0 { ((point - ends[0]).dot(&along) / length).clamp(0.0, 1.0) } else { 0.0 };
    (point - ends[0] - along * share).norm()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distance_from_a_path_is_across_it() {
        let path: Vec<_> = (0..=10).map(|k| Vector3::new(f64::from(k), 0.0, 0.0)).collect();
        let beside: Vec<_> = path.iter().map(|p| p + Vector3::new(0.3, 0.04, 0.03)).take(10).collect();
        assert!((farthest_from_path(&beside, &path, 2) - 0.05).abs() < 1e-12);
        // Beyond the end it is from the end.
        assert!((farthest_from_path(&[Vector3::new(13.0, 4.0, 0.0)], &path, 20) - 5.0).abs() < 1e-12);
    }
}
