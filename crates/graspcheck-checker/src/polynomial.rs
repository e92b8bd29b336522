//! The value of a polynomial, and bounds on it over an interval.

/// Coefficients of a polynomial of degree 7 at most, ascending by power.
pub(crate) type Coefficients = [f64; 8];

/// Bounds are wider than the true range by at most this (rad or m), and by this share of what rounding is
/// relative to; a hundredth of what is allowed for rounding on an arm that reaches 8 m.
const TIGHT: f64 = 1e-13;

/// Halvings after which bounds are taken as they are: an interval then is no longer than rounding.
const MOST_HALVINGS: u32 = 60;

/// Entry `[i][k]` is `C(i, k) / C(7, k)`.
const TO_BERNSTEIN: [[f64; 8]; 8] = {
    let mut table = [[0.0; 8]; 8];
    let mut i = 0;
    while i < 8 {
        let mut k = 0;
        table[i][0] = 1.0;
        while k < i {
            table[i][k + 1] = table[i][k] * (i - k) as f64 / (7 - k) as f64;
            k += 1;
        }
        i += 1;
    }
    table
};

/// The value at `tau` (Horner).
pub(crate) fn value(coefficients: &Coefficients, tau: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * tau + c)
}

/// The coefficients of the derivative.
pub(crate) fn derivative(coefficients: &Coefficients) -> Coefficients {
    std::array::from_fn(|k| coefficients.get(k + 1).map_or(0.0, |next| (k + 1) as f64 * next))
}

/// The sum of the magnitudes of all terms on `[0, length]`: what rounding errors are relative to.
pub(crate) fn magnitude(coefficients: &Coefficients, length: f64) -> f64 {
    value(&coefficients.map(f64::abs), length)
}

/// Bounds on all values on `[from, to]`; they are tight to [`TIGHT`].
pub(crate) fn range(coefficients: &Coefficients, from: f64, to: f64) -> [f64; 2] {
    // The polynomial in the time that runs from 0 to 1 on the interval (Taylor shift and scaling) …
    let mut c = *coefficients;
    for start in 0..7 {
        for k in (start..7).rev() {
            c[k] += c[k + 1] * from;
        }
    }
    let mut power = 1.0;
    for c in &mut c {
        *c *= power;
        power *= to - from;
    }
    // … as a mean of control values: it stays between the least and the greatest, and begins and ends at the
    // first and last (Farouki, *The Bernstein polynomial basis*, CAGD 29, 2012).
    let control: Coefficients = std::array::from_fn(|i| (0..=i).map(|k| TO_BERNSTEIN[i][k] * c[k]).sum());
    let tight = TIGHT * (1.0 + 0.1 * c.iter().map(|c| c.abs()).sum::<f64>());
    let (first, last) = (control[0], control[7]);
    let low = highest(&control.map(|x| -x), (-first).max(-last), tight, MOST_HALVINGS);
    [-low, highest(&control, first.max(last), tight, MOST_HALVINGS)]
}

/// A bound from above on the polynomial with these control values, or `reached` where that is higher: a value
/// that it takes somewhere.
fn highest(control: &Coefficients, reached: f64, tight: f64, halvings: u32) -> f64 {
    let top = control.iter().copied().fold(reached, f64::max);
    let reached = reached.max(control[0]).max(control[7]);
    if top <= reached + tight || halvings == 0 {
        return top;
    }
    let [left, right] = halves(control);
    let left = highest(&left, reached, tight, halvings - 1);
    // Tight bounds of one half do not raise the other's.
    left.max(highest(&right, reached, tight, halvings - 1))
}

/// The control values of both halves (de Casteljau).
fn halves(control: &Coefficients) -> [Coefficients; 2] {
    let mut right = *control;
    let left = std::array::from_fn(|i| {
        let first = right[0];
        for k in 0..7 - i {
            right[k] = 0.5 * (right[k] + right[k + 1]);
        }
        first
    });
    [left, right]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn assert_range(coefficients: Coefficients, [from, to]: [f64; 2], expected: [f64; 2]) {
        let [low, high] = range(&coefficients, from, to);
        assert!(low <= expected[0] + 1e-13 && expected[0] - low < 1e-10, "{low} is not {}", expected[0]);
        assert!(high >= expected[1] - 1e-13 && high - expected[1] < 1e-10, "{high} is not {}", expected[1]);
    }

    #[test]
    fn ranges_are_those_of_closed_forms() {
        // τ (1 - τ)
        let hill = [0.0, 1.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        assert_range(hill, [0.0, 1.0], [0.0, 0.25]);
        assert_range(hill, [0.625, 2.0], [-2.0, 0.234_375]);
        // The Chebyshev polynomials of degree 5 and 7 reach ±1 many times.
        assert_range([0.0, 5.0, 0.0, -20.0, 0.0, 16.0, 0.0, 0.0], [-1.0, 1.0], [-1.0, 1.0]);
        assert_range([0.0, -7.0, 0.0, 56.0, 0.0, -112.0, 0.0, 64.0], [0.0, 1.0], [-1.0, 1.0]);
        // From rest to rest, and at rest.
        assert_range([1.0, 0.0, 0.0, 10.0, -15.0, 6.0, 0.0, 0.0], [0.0, 1.0], [1.0, 2.0]);
        assert_range([0.3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.2, 0.9], [0.3, 0.3]);
        assert_range(hill, [0.5, 0.5], [0.25, 0.25]);
    }

    #[test]
    fn derivatives_are_those_of_powers() {
        let all = derivative(&[5.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 2.0]);
        assert_eq!(all.map(|c| c as i32), [1, 2, 3, 4, 5, 6, 14, 0]);
    }

    #[test]
    fn magnitudes_do_not_cancel() {
        let sum = magnitude(&[1.0, -2.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0], 2.0);
        assert!((sum - 13.0).abs() < 1e-14, "{sum}");
    }

    proptest! {
        /// No value lies outside, and the bounds are reached to what the step of the samples explains.
        #[test]
        fn bounds_hold_and_are_reached(
            coefficients in proptest::array::uniform8(-3.0..3.0_f64), from in -1.0..1.0_f64, length in 0.0..1.0_f64,
        ) {
            let [low, high] = range(&coefficients, from, from + length);
            let samples: Vec<f64> =
                (0..=1000).map(|i| value(&coefficients, from + length * f64::from(i) / 1000.0)).collect();
            let least = samples.iter().copied().fold(f64::INFINITY, f64::min);
            let most = samples.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            prop_assert!(low <= least + 1e-12 && high >= most - 1e-12);
            // |p''| ≤ Σ k (k-1) 3 2^(k-2) < 8000 on [-2, 2]; a peak lies within half a step of a sample.
            let step = length / 1000.0;
            prop_assert!(least - low <= 1000.0 * step * step + 1e-11, "{} below {}", low, least);
            prop_assert!(high - most <= 1000.0 * step * step + 1e-11, "{} above {}", high, most);
        }
    }
}
