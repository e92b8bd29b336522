//! How smooth a motion is: peak and root mean square of jerk, planned and executed.

use super::{Metric, Motion, largest, of_joints, rms};
use crate::{evidence::Evidence, verdict::Unit};

/// Samples on each side of the one at which the jerk of a measured motion is found. With one on each side, at 1 kHz, the
/// rounding of the log would be all that one sees; what changes within this window is smeared.
pub const HALF_WINDOW: usize = 5;

/// Peak and root mean square of the planned jerk of every joint, exact.
pub(super) fn planned(evidence: &Evidence) -> Vec<Metric> {
    let motion = &evidence.plan.trajectory;
    let unit = |kind| Unit::of_derivative(kind, 3);
    let mut all = of_joints(evidence, "planned.jerk_peak", unit, |joint| motion.peak(joint, 3).value.abs());
    all.extend(of_joints(evidence, "planned.jerk_rms", unit, |joint| {
        let pieces = motion.knots().windows(2).enumerate();
        let integral: f64 = pieces
            .map(|(piece, ends)| {
                let jerk = third_derivative(motion.piece(piece, joint).coefficients());
                integral_of_square(&jerk, ends[1] - ends[0])
            })
            .sum();
        (integral / motion.duration()).sqrt()
    }));
    all
}

/// Peak and root mean square of the jerk of every measured joint; 0 of a motion shorter than the window.
pub(super) fn executed(evidence: &Evidence, motion: &Motion) -> Vec<Metric> {
    let jerks: Vec<Vec<f64>> =
        motion.measured.iter().map(|joint| second_derivative(&joint.velocity, motion.dt)).collect();
    let unit = |kind| Unit::of_derivative(kind, 3);
    let mut all =
        of_joints(evidence, "executed.jerk_peak", unit, |joint| largest(jerks[joint].iter().copied()));
    all.extend(of_joints(evidence, "executed.jerk_rms", unit, |joint| rms(&jerks[joint])));
    all
}

/// The coefficients of the third derivative of a polynomial, both ascending.
fn third_derivative(coefficients: &[f64]) -> Vec<f64> {
    let factor = |k: usize| (k * (k - 1) * (k - 2)) as f64;
    coefficients.iter().enumerate().skip(3).map(|(k, c)| factor(k) * c).collect()
}

/// ∫ p² from 0 to h.
fn integral_of_square(p: &[f64], h: f64) -> f64 {
    let mut sum = 0.0;
    for (i, a) in p.iter().enumerate() {
        for (j, b) in p.iter().enumerate() {
            let power = i + j + 1;
            // A polynomial of degree 4 has powers up to 9.
            sum += a * b * h.powi(power as i32) / power as f64;
        }
    }
    sum
}

/// The second derivative of samples at steps of `dt`, s, at those with a whole window around: of the parabola with the
/// least squared distance from the window's samples, `30 Σ (3k² - m(m+1)) y_k / (m (m+1) (4m²-1) (2m+3) dt²)`.
fn second_derivative(samples: &[f64], dt: f64) -> Vec<f64> {
    let m = HALF_WINDOW as f64;
    let divisor = m * (m + 1.0) * (4.0 * m * m - 1.0) * (2.0 * m + 3.0) * dt * dt;
    let weight = |k: usize| {
        let k = k as f64 - m;
        30.0 * (3.0 * k * k - m * (m + 1.0)) / divisor
    };
    samples
        .windows(2 * HALF_WINDOW + 1)
        .map(|window| window.iter().enumerate().map(|(k, y)| weight(k) * y).sum())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_has_its_second_derivative_exactly() {
        let dt = 0.01;
        let samples: Vec<f64> = (0..40).map(|k| (f64::from(k) * dt).powi(3)).collect();
        for (k, found) in second_derivative(&samples, dt).iter().enumerate() {
            let t = (k + HALF_WINDOW) as f64 * dt;
            assert!((found - 6.0 * t).abs() < 1e-9, "at {t}: {found}");
        }
        assert!(second_derivative(&samples[..10], dt).is_empty());
    }

    #[test]
    fn the_integral_of_a_square_is_exact() {
        // ∫ (1 + 2t)² from 0 to 3 = [(1 + 2t)³ / 6] = 57.
        assert!((integral_of_square(&[1.0, 2.0], 3.0) - 57.0).abs() < 1e-12);
        assert_eq!(third_derivative(&[1.0, 1.0, 1.0, 2.0, 3.0]), [12.0, 72.0]);
    }
}
