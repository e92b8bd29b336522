//! Laws of extrema, violations and bounds, held against dense sampling with local refinement.

use graspcheck_motion::bernstein::{self, Proof};
use graspcheck_motion::{Extremum, MotionBounds, Polynomial, Trajectory};
use proptest::prelude::*;

/// Terms of comparable size on `[0, h]`, and some of them missing.
fn any_polynomial() -> impl Strategy<Value = (Polynomial, f64)> {
    let term = prop_oneof![4 => -1.0..1.0_f64, 1 => Just(0.0)];
    (prop::array::uniform8(term), 0..=7_usize, -3.0..1.0_f64).prop_map(|(terms, degree, log_h)| {
        let h = 10.0_f64.powf(log_h);
        let mut coefficients = [0.0; 8];
        for (k, c) in coefficients.iter_mut().enumerate().take(degree + 1) {
            *c = terms[k] / h.powi(k as i32);
        }
        (Polynomial::new(coefficients), h)
    })
}

/// `scale Π (τ - rᵢ)` with roots on a coarse grid of `[0, h]`, so that double and triple ones, and roots
/// at the ends, are common.
fn polynomial_with_multiple_roots() -> impl Strategy<Value = (Polynomial, f64)> {
    (prop::collection::vec(0..=4_u8, 1..=7), prop::sample::select(vec![0.25, 1.0, 3.0])).prop_map(
        |(roots, h)| {
            let mut coefficients = [0.0; 8];
            coefficients[0] = 1.0;
            for (degree, root) in roots.iter().enumerate() {
                let root = f64::from(*root) / 4.0 * h;
                for k in (0..=degree).rev() {
                    coefficients[k + 1] += coefficients[k];
                    coefficients[k] *= -root;
                }
            }
            (Polynomial::new(coefficients), h)
        },
    )
}

fn polynomial() -> impl Strategy<Value = (Polynomial, f64)> {
    prop_oneof![any_polynomial(), polynomial_with_multiple_roots()]
}

/// The magnitude that the terms of a derivative reach on `[0, h]`: rounding is relative to it. Never zero.
fn magnitude(p: &Polynomial, order: usize, h: f64) -> f64 {
    Polynomial::new(p.coefficients().map(f64::abs)).eval(h)[order] + 1e-200
}

/// The greatest value on `[a, b]` by dense sampling and ternary search around the best samples.
fn sampled_maximum(f: impl Fn(f64) -> f64, a: f64, b: f64) -> f64 {
    const SAMPLES: usize = 400;
    let at = |i: usize| a + (b - a) * i.min(SAMPLES) as f64 / SAMPLES as f64;
    let mut best = f64::NEG_INFINITY;
    for i in 0..=SAMPLES {
        let (mut low, mut high) = (at(i.saturating_sub(1)), at(i + 1));
        best = best.max(f(at(i)));
        if f(at(i)) < f(low) || f(at(i)) < f(high) {
            continue;
        }
        for _ in 0..60 {
            let third = (high - low) / 3.0;
            if f(low + third) < f(high - third) { low += third } else { high -= third }
        }
        best = best.max(f(0.5 * (low + high)));
    }
    best
}

fn assert_near(a: f64, b: f64, tolerance: f64, what: &str) {
    assert!((a - b).abs() <= tolerance, "{what}: {a} and {b} differ by {:e} > {tolerance:e}", a - b);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn extrema_are_those_that_sampling_finds((p, h) in polynomial(), from in 0.0..0.6_f64, width in 0.0..1.0_f64) {
        let (a, b) = (from * h, (from + width * (1.0 - from)) * h);
        for order in 0..4 {
            let [low, high] = p.range(order, a, b);
            let scale = magnitude(&p, order, h);
            let value = |tau: f64| p.eval(tau)[order];
            assert_near(high.value, sampled_maximum(value, a, b), 1e-9 * scale, "maximum");
            assert_near(-low.value, sampled_maximum(|tau| -value(tau), a, b), 1e-9 * scale, "minimum");
            for Extremum { value: extremum, tau } in [low, high] {
                prop_assert!((a..=b).contains(&tau), "{tau} is outside [{a}, {b}]");
                assert_near(extremum, value(tau), 1e-13 * scale, "value at its time");
            }
            for i in 0..=1000 {
                let sample = value(a + (b - a) * f64::from(i) / 1000.0);
                prop_assert!(low.value - 1e-13 * scale <= sample && sample <= high.value + 1e-13 * scale);
            }
        }
    }

    #[test]
    fn one_chain_gives_the_ranges_of_all_orders((p, h) in polynomial()) {
        for (order, range) in p.ranges(0.0, h).into_iter().enumerate() {
            prop_assert_eq!(range, p.range(order, 0.0, h));
        }
        for (range, order) in p.rate_ranges(0.0, h).into_iter().zip(1..) {
            prop_assert_eq!(range, p.range(order, 0.0, h));
        }
    }

    #[test]
    fn splitting_an_interval_changes_no_extremum((p, h) in polynomial(), share in 0.0..1.0_f64) {
        let middle = share * h;
        for order in 0..4 {
            let scale = 1e-12 * magnitude(&p, order, h);
            let [low, high] = p.range(order, 0.0, h);
            let [first, second] = [p.range(order, 0.0, middle), p.range(order, middle, h)];
            assert_near(low.value, first[0].value.min(second[0].value), scale, "minimum");
            assert_near(high.value, first[1].value.max(second[1].value), scale, "maximum");
        }
    }

    #[test]
    fn shifting_time_changes_no_extremum((p, h) in polynomial(), share in 0.0..1.0_f64) {
        let shift = share * h;
        for order in 0..4 {
            let scale = 1e-11 * magnitude(&p, order, h);
            let direct = p.range(order, shift, h);
            let shifted = p.shifted(shift).range(order, 0.0, h - shift);
            for (a, b) in direct.into_iter().zip(shifted) {
                assert_near(a.value, b.value, scale, "extremum");
            }
        }
    }

    #[test]
    fn bernstein_bounds_enclose_the_range((p, h) in polynomial()) {
        for order in 0..4 {
            let [low, high] = p.range(order, 0.0, h);
            let [lower, upper] = bernstein::bounds(&p, order, h);
            // No tolerance: the bounds are safe against rounding.
            prop_assert!(lower <= low.value && high.value <= upper, "[{lower}, {upper}] {low:?} {high:?}");
        }
    }

    #[test]
    fn enclosures_hold_the_range_and_what_is_evaluated(
        (p, h) in polynomial(), from in -0.3..0.9_f64, log_width in -6.0..0.0_f64,
    ) {
        let (a, width) = (from * h, 10.0_f64.powf(log_width) * (1.0 - from) * h);
        let bounds = p.enclose(a, a + width);
        prop_assert_eq!(bounds, p.enclose(a + width, a));
        for (order, bound) in bounds.into_iter().enumerate() {
            let [low, high] = p.range(order, a, a + width);
            prop_assert!(bound.contains(low.value) && bound.contains(high.value), "{bound} {low:?} {high:?}");
            for i in 0..=50 {
                let value = p.eval(a + width * f64::from(i) / 50.0)[order];
                prop_assert!(bound.contains(value), "order {order}: {bound} does not hold {value}");
            }
            // The excess is of second order: at most (n - 1)/2 · width² · max |second derivative|, halves of
            // which go to each side, and some units of rounding.
            let curvature = Polynomial::new(p.coefficients().map(f64::abs)).derivative_of_order(order + 2);
            let second = curvature.eval(a.abs() + width)[0] * width * width;
            let excess = bound.width() - (high.value - low.value);
            let rounding = 60.0 * f64::EPSILON * magnitude(&p, order, h.max(a.abs() + width));
            prop_assert!(excess <= 4.0 * second + rounding + 1e-300, "{excess} {second}");
        }
    }

    #[test]
    fn a_motion_is_enclosed_across_its_knots(
        (p, h) in polynomial(), q in any_polynomial(), shares in (0.0..=1.0_f64, 0.0..=1.0_f64), at in 0.0..=1.0_f64,
    ) {
        let motion = Trajectory::new(1, vec![0.0, h, h + q.1], vec![p, q.0]).expect("valid");
        let [t0, t1] = [shares.0.min(shares.1), shares.0.max(shares.1)].map(|share| share * motion.duration());
        let t = (t0 + at * (t1 - t0)).clamp(t0, t1);
        prop_assume!(t < t1 || !motion.knots().contains(&t1));
        let mut bounds = MotionBounds::zeros(1);
        motion.enclose_into(t0, t1, &mut bounds);
        let state = motion.eval(t);
        prop_assert!(bounds.q[0].contains(state.q[0]) && bounds.qd[0].contains(state.qd[0]));
        prop_assert!(bounds.qdd[0].contains(state.qdd[0]) && bounds.qddd[0].contains(state.qddd[0]));
    }

    #[test]
    fn proofs_agree_with_extrema((p, h) in polynomial(), room in -0.5..0.5_f64) {
        for order in 0..4 {
            let [low, high] = p.range(order, 0.0, h);
            let scale = magnitude(&p, order, h);
            let (lower, upper) = (low.value - room * scale, high.value + room * scale);
            match bernstein::proves_within(&p, order, h, lower, upper) {
                Proof::Within => prop_assert!(room >= 0.0),
                Proof::Outside { tau } => {
                    let value = p.eval(tau)[order];
                    prop_assert!(value < lower || value > upper, "{value} at {tau} is in [{lower}, {upper}]");
                }
                Proof::Undecided => prop_assert!(room.abs() < 1e-12, "{room}"),
            }
            // At the extremum itself rounding decides, and only there.
            let exact = bernstein::proves_within(&p, order, h, low.value, high.value);
            prop_assert!(!matches!(exact, Proof::Outside { .. }), "{exact:?}");
            let wider = 1e-12 * scale;
            prop_assert_eq!(
                bernstein::proves_within(&p, order, h, low.value - wider, high.value + wider),
                Proof::Within
            );
        }
    }

    #[test]
    fn violations_are_where_samples_are_outside(
        (p, h) in polynomial(),
        q in any_polynomial(),
        shares in (-1.2..1.2_f64, -1.2..1.2_f64),
        order in 0..4_usize,
    ) {
        let second = q.1;
        let motion = Trajectory::new(1, vec![0.0, h, h + second], vec![p, q.0]).expect("valid");
        let [a, b] = motion.range_in(0, order, 0.0, motion.duration());
        let middle = 0.5 * (a.value + b.value);
        let half = 0.5 * (b.value - a.value);
        let (lower, upper) = (middle + half * shares.0.min(shares.1), middle + half * shares.0.max(shares.1));
        let found = motion.exceeds(0, order, lower, upper);
        for pair in found.windows(2) {
            prop_assert!(pair[0][1] < pair[1][0], "{:?} are not apart", pair);
        }
        let peak = motion.peak(0, order).value.abs();
        prop_assert_eq!(peak.total_cmp(&a.value.abs().max(b.value.abs())), std::cmp::Ordering::Equal);
        let noise = 1e-9 * (magnitude(&p, order, h) + magnitude(&q.0, order, second));
        for i in 0..1000 {
            let t = motion.duration() * (f64::from(i) + 0.5) / 1000.0;
            let state = motion.eval(t);
            let value = [state.q[0], state.qd[0], state.qdd[0], state.qddd[0]][order];
            let listed = found.iter().any(|[from, to]| (*from..=*to).contains(&t));
            if value < lower - noise || value > upper + noise {
                prop_assert!(listed, "{value} at {t} s is outside [{lower}, {upper}] and not in {found:?}");
            }
            if value > lower + noise && value < upper - noise {
                prop_assert!(!listed, "{value} at {t} s is within [{lower}, {upper}] and in {found:?}");
            }
        }
    }

    #[test]
    fn hostile_input_never_panics(
        coefficients in prop::array::uniform8(prop::num::f64::ANY),
        a in prop::num::f64::ANY,
        b in prop::num::f64::ANY,
        limits in (prop::num::f64::ANY, prop::num::f64::ANY),
    ) {
        let p = Polynomial::new(coefficients);
        for order in (0..10).chain([usize::MAX]) {
            let [low, high] = p.range(order, a, b);
            // Either an honest order or NaN, which no limit admits.
            prop_assert!(low.value <= high.value || (low.value.is_nan() && high.value.is_nan()));
            let _ = bernstein::bounds(&p, order, a);
            let [q, ..] = p.enclose(a, b);
            prop_assert!(q.lower() <= q.upper());
            let _ = bernstein::proves_within(&p, order, b, limits.0, limits.1);
        }
        if let Ok(motion) = Trajectory::new(1, vec![0.0, a], vec![p]) {
            let _ = motion.continuity();
            for order in 0..4 {
                let _ = motion.peak(0, order);
                let _ = motion.exceeds(0, order, limits.0, limits.1);
            }
        }
    }
}
