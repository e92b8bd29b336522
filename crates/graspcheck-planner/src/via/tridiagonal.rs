//! Systems of equations in which each unknown meets only its neighbours.

/// A matrix with three diagonals; row k is `lower[k] x[k-1] + diagonal[k] x[k] + upper[k] x[k+1]`. The first
/// `lower` and the last `upper` are not used.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tridiagonal {
    lower: Vec<f64>,
    diagonal: Vec<f64>,
    upper: Vec<f64>,
}

impl Tridiagonal {
    /// Adds a row below the others.
    pub(crate) fn push(&mut self, [lower, diagonal, upper]: [f64; 3]) {
        self.lower.push(lower);
        self.diagonal.push(diagonal);
        self.upper.push(upper);
    }

    /// The solution for this right-hand side, by elimination without exchange of rows (Thomas): in time
    /// proportional to the number of rows, where the dense solvers of nalgebra take its cube.
    ///
    /// No pivot may vanish. In the systems of splines none does, whatever the durations: see the rows in
    /// `spline` and `virtual_points`.
    ///
    /// # Panics
    /// When the lengths differ.
    pub(crate) fn solve(&self, right: &[f64]) -> Vec<f64> {
        assert_eq!(right.len(), self.diagonal.len(), "one right-hand side for each row");
        let mut solution = Vec::with_capacity(right.len());
        // `x[k] = solution[k] - ratios[k] x[k+1]`.
        let mut ratios = Vec::with_capacity(right.len());
        let (mut before, mut ratio) = (0.0, 0.0);
        for (k, value) in right.iter().enumerate() {
            let lower = if k == 0 { 0.0 } else { self.lower[k] };
            let pivot = self.diagonal[k] - lower * ratio;
            before = (value - lower * before) / pivot;
            ratio = self.upper[k] / pivot;
            solution.push(before);
            ratios.push(ratio);
        }
        for k in (1..right.len()).rev() {
            solution[k - 1] -= ratios[k - 1] * solution[k];
        }
        solution
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn solution_is_that_of_a_dense_solver(
            rows in prop::collection::vec((-1.0..1.0_f64, 2.1..5.0_f64, -1.0..1.0_f64, -9.0..9.0_f64), 1..12),
        ) {
            let mut system = Tridiagonal::default();
            let mut dense = DMatrix::zeros(rows.len(), rows.len());
            for (k, &(lower, diagonal, upper, _)) in rows.iter().enumerate() {
                system.push([lower, diagonal, upper]);
                dense[(k, k)] = diagonal;
                if k > 0 {
                    dense[(k, k - 1)] = lower;
                }
                if k + 1 < rows.len() {
                    dense[(k, k + 1)] = upper;
                }
            }
            let right: Vec<f64> = rows.iter().map(|row| row.3).collect();
            let expected = dense.lu().solve(&DVector::from_column_slice(&right)).unwrap();
            for (found, expected) in system.solve(&right).iter().zip(expected.iter()) {
                prop_assert!((found - expected).abs() < 1e-12);
            }
        }
    }
}
