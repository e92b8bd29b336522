//! Accuracy and repeatability of poses and paths over repetitions, by ISO 9283:1998.
//!
//! In a simulation that is deterministic, repetitions differ by what is drawn at random: each needs a seed of its own.
//! For an arm that moves in a plane the test plane of the standard is that plane.
//!
//! ```
//! use graspcheck_verify::metrics::iso9283::Positions;
//! use nalgebra::Vector3;
//!
//! // Two visits, 2 mm apart, around a point 3 mm beside the commanded one.
//! let attained = [Vector3::new(0.003, 0.001, 0.0), Vector3::new(0.003, -0.001, 0.0)];
//! let found = Positions::of(&Vector3::zeros(), &attained).expect("two visits");
//! assert!((found.accuracy - 0.003).abs() < 1e-15);
//! // Both are 1 mm from their middle: no spread of the distances.
//! assert!((found.repeatability - 0.001).abs() < 1e-15);
//! ```

use nalgebra::Vector3;

/// Accuracy and repeatability of a position, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Positions {
    /// AP: distance of the barycentre of the attained positions from the commanded one.
    pub accuracy: f64,
    /// RP: `l̄ + 3 S`, where `l` are the distances of the attained positions from their barycentre, `l̄` their mean and
    /// `S` their standard deviation, `√(Σ (l - l̄)² / (n - 1))`.
    pub repeatability: f64,
}

impl Positions {
    /// Of the positions attained by repeated visits of a commanded one, in one frame, m. None of fewer than two visits,
    /// for which there is no spread. The standard asks for 30.
    #[must_use]
    pub fn of(commanded: &Vector3<f64>, attained: &[Vector3<f64>]) -> Option<Self> {
        if attained.len() < 2 {
            return None;
        }
        let count = attained.len() as f64;
        let barycentre = attained.iter().sum::<Vector3<f64>>() / count;
        let distances: Vec<f64> = attained.iter().map(|point| (point - barycentre).norm()).collect();
        let mean = distances.iter().sum::<f64>() / count;
        let variance = distances.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / (count - 1.0);
        Some(Self { accuracy: (barycentre - commanded).norm(), repeatability: mean + 3.0 * variance.sqrt() })
    }
}

/// Accuracy and repeatability of a path, m: the worst of its points.
///
/// `attained[r][i]` is where repetition r passes point i of the commanded path. The standard pairs points by planes across
/// the path; with streams of equal times, point i is that of step i, and what is late counts as off.
///
/// None of fewer than two repetitions, of no points, or when a repetition has another number of points.
#[must_use]
pub fn path(commanded: &[Vector3<f64>], attained: &[Vec<Vector3<f64>>]) -> Option<Positions> {
    if commanded.is_empty() || attained.iter().any(|run| run.len() != commanded.len()) {
        return None;
    }
    let of_point = |(index, point): (usize, &Vector3<f64>)| {
        let visits: Vec<Vector3<f64>> = attained.iter().map(|run| run[index]).collect();
        Positions::of(point, &visits)
    };
    let points: Option<Vec<Positions>> = commanded.iter().enumerate().map(of_point).collect();
    points?.into_iter().reduce(|worst, next| Positions {
        accuracy: worst.accuracy.max(next.accuracy),
        repeatability: worst.repeatability.max(next.repeatability),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spread_of_distances_counts_three_times() {
        // Distances from the barycentre 0: 1, 1, 2, 2; mean 1.5, standard deviation √(1/3).
        let attained = [1.0, -1.0, 2.0, -2.0].map(|x| Vector3::new(x, 0.0, 0.0));
        let found = Positions::of(&Vector3::new(0.0, 0.0, 4.0), &attained).unwrap();
        assert!((found.accuracy - 4.0).abs() < 1e-15);
        assert!((found.repeatability - (1.5 + 3.0 * (1.0_f64 / 3.0).sqrt())).abs() < 1e-12);
        assert_eq!(Positions::of(&Vector3::zeros(), &attained[..1]), None);
    }

    #[test]
    fn a_path_is_as_good_as_its_worst_point() {
        let line: Vec<_> = (0..5).map(|k| Vector3::new(f64::from(k), 0.0, 0.0)).collect();
        let beside = |by: f64| -> Vec<_> {
            line.iter().map(|p| p + Vector3::new(0.0, if p.x > 2.5 { by } else { 0.0 }, 0.0)).collect()
        };
        let found = path(&line, &[beside(0.1), beside(0.3)]).unwrap();
        assert!((found.accuracy - 0.2).abs() < 1e-12 && (found.repeatability - 0.1).abs() < 1e-12);
        assert_eq!(path(&line, &[beside(0.0), vec![Vector3::zeros()]]), None);
    }
}
