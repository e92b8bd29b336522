//! A motion or samples as points for a plot: the least and the greatest value in every column of pixels, so that
//! no peak is lost and the size does not depend on the length of a run.

use graspcheck_motion::Trajectory;

/// The points of a joint's derivative in `[from, to]`, times and values of both extremes of each of `columns`
/// parts, exact. Jumps at knots come out as vertical lines.
pub(super) fn of_motion(
    motion: &Trajectory,
    [joint, order]: [usize; 2],
    [from, to]: [f64; 2],
    columns: usize,
) -> Vec<[f64; 2]> {
    let to = to.min(motion.duration());
    let from = from.clamp(0.0, to);
    let edge = |k: usize| from + (to - from) * k as f64 / columns as f64;
    let mut points = Vec::with_capacity(2 * columns);
    for k in 0..columns {
        // The last edge is the end itself, not what rounding makes of it.
        let end = if k + 1 == columns { to } else { edge(k + 1) };
        let mut ends = motion.range_in(joint, order, edge(k), end).map(|peak| [peak.time, peak.value]);
        ends.sort_by(|a, b| a[0].total_cmp(&b[0]));
        points.extend(ends);
    }
    points
}

/// The points of samples `(time, value)` in `[from, to]`: the extremes of each of `columns` parts, in order of
/// time.
pub(super) fn of_samples(
    samples: impl Iterator<Item = (f64, f64)>,
    [from, to]: [f64; 2],
    columns: usize,
) -> Vec<[f64; 2]> {
    let mut points: Vec<[f64; 2]> = Vec::new();
    let mut column: Option<(usize, [[f64; 2]; 2])> = None;
    let mut close = |ends: [[f64; 2]; 2]| {
        let [low, high] = ends;
        let (first, last) = if low[0] <= high[0] { (low, high) } else { (high, low) };
        points.push(first);
        if last[0] > first[0] {
            points.push(last);
        }
    };
    for (t, value) in samples.filter(|(t, value)| *t >= from && *t <= to && value.is_finite()) {
        let at = ((t - from) / (to - from) * columns as f64) as usize;
        match &mut column {
            Some((of, [low, high])) if *of == at => {
                if value < low[1] {
                    *low = [t, value];
                }
                if value > high[1] {
                    *high = [t, value];
                }
            }
            _ => {
                if let Some((_, ends)) = column.take() {
                    close(ends);
                }
                column = Some((at, [[t, value]; 2]));
            }
        }
    }
    if let Some((_, ends)) = column {
        close(ends);
    }
    points
}

#[cfg(test)]
mod tests {
    use graspcheck_motion::Polynomial;

    use super::*;

    #[test]
    fn no_peak_is_lost() {
        // One sample in a thousand sticks out.
        let samples = (0..1000).map(|k| (f64::from(k) * 1e-3, if k == 437 { 5.0 } else { 0.0 }));
        let points = of_samples(samples, [0.0, 1.0], 20);
        assert!(points.len() <= 40);
        assert!(points.contains(&[437.0 * 1e-3, 5.0]));
        assert!(points.windows(2).all(|pair| pair[0][0] < pair[1][0]));
    }

    #[test]
    fn the_peak_of_a_motion_is_exact() {
        let swing = Polynomial::quintic_hermite([0.0; 3], [1.0, 0.0, 0.0], 1.0);
        let motion = Trajectory::new(1, vec![0.0, 1.0], vec![swing]).unwrap();
        let points = of_motion(&motion, [0, 1], [0.0, 1.0], 7);
        let peak = points.iter().map(|point| point[1]).fold(0.0, f64::max);
        assert!((peak - 1.875).abs() < 1e-12, "{peak}");
        assert!(points.windows(2).all(|pair| pair[0][0] <= pair[1][0]));
    }
}
