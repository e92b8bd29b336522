//! One coordinate of a logged motion: cubic Hermite pieces through the logged positions and velocities.

/// The cubic between two rows of a log, in local time from 0 to its length.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HermitePiece {
    coefficients: [f64; 4],
    length: f64,
}

impl HermitePiece {
    /// The cubic on `[0, length]` (s) with these positions and velocities at its ends.
    pub(crate) fn new(positions: [f64; 2], velocities: [f64; 2], length: f64) -> Self {
        let slope = (positions[1] - positions[0]) / length;
        let curve = (3.0 * slope - 2.0 * velocities[0] - velocities[1]) / length;
        let twist = (velocities[0] + velocities[1] - 2.0 * slope) / (length * length);
        Self { coefficients: [positions[0], velocities[0], curve, twist], length }
    }

    /// The value at a local time, s.
    pub(crate) fn value(&self, tau: f64) -> f64 {
        let [a, b, c, d] = self.coefficients;
        ((d * tau + c) * tau + b) * tau + a
    }

    /// The rate of change at a local time, s.
    pub(crate) fn rate(&self, tau: f64) -> f64 {
        let [_, b, c, d] = self.coefficients;
        (3.0 * d * tau + 2.0 * c) * tau + b
    }

    /// The least and the largest value on the whole piece.
    pub(crate) fn whole_range(&self) -> [f64; 2] {
        self.range(0.0, self.length)
    }

    /// The least and the largest value between two local times, exact to rounding: those at the ends and at
    /// the roots of the rate between them.
    pub(crate) fn range(&self, from: f64, to: f64) -> [f64; 2] {
        let (start, end) = (self.value(from), self.value(to));
        let mut range = [start.min(end), start.max(end)];
        let [_, b, c, d] = self.coefficients;
        // 3 d τ² + 2 c τ + b = 0, by the form that cancels nothing.
        let under = c * c - 3.0 * d * b;
        if under > 0.0 {
            let q = -(c + under.sqrt().copysign(c));
            for root in [q / (3.0 * d), b / q] {
                if root > from && root < to {
                    let value = self.value(root);
                    range = [range[0].min(value), range[1].max(value)];
                }
            }
        }
        range
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "the ends of a range are places that are met exactly")]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn ends_are_met_and_nothing_lies_outside_the_range(
            positions: [f64; 2], velocities: [f64; 2], from in 0.0..0.5_f64, to in 0.5..1.0_f64
        ) {
            let bounded = |x: f64| if x.is_finite() { x % 10.0 } else { 1.0 };
            let (positions, velocities) = (positions.map(bounded), velocities.map(bounded));
            let piece = HermitePiece::new(positions, velocities, 0.7);
            for (end, tau) in [(0, 0.0), (1, 0.7)] {
                prop_assert!((piece.value(tau) - positions[end]).abs() < 1e-12);
                prop_assert!((piece.rate(tau) - velocities[end]).abs() < 1e-11);
            }
            let [low, high] = piece.range(from, to);
            let mut found = [f64::INFINITY, f64::NEG_INFINITY];
            for step in 0..=200 {
                let value = piece.value(from + (to - from) * f64::from(step) / 200.0);
                prop_assert!(low - 1e-12 <= value && value <= high + 1e-12);
                found = [found[0].min(value), found[1].max(value)];
            }
            // No wider than what is there: a parabola's tip is missed by a 400th of the interval at most.
            prop_assert!(found[0] - low < 1e-2 && high - found[1] < 1e-2);
        }
    }

    #[test]
    fn a_turning_point_between_the_rows_counts() {
        // Out and back between two rows with the same position: 1 - (2τ - 1)² of height 1 in the middle.
        let piece = HermitePiece::new([0.0, 0.0], [4.0, -4.0], 1.0);
        assert_eq!(piece.whole_range(), [0.0, 1.0]);
    }
}
