//! Interval arithmetic against exact rational numbers, and against fixed-point series of 300 bits.

#![expect(clippy::float_cmp, reason = "ends that must be exact are asked for exactly")]

use std::cmp::Ordering;

use graspcheck_motion::{Dual, Interval, Scalar};
use num_bigint::BigInt;
use num_rational::BigRational;
use proptest::prelude::*;

/// The exact value of a finite float.
fn exact(value: f64) -> BigRational {
    BigRational::from_float(value).expect("a finite number")
}

/// Whether an interval holds an exact number.
fn holds(interval: Interval, value: &BigRational) -> bool {
    let above = interval.lower() == f64::NEG_INFINITY || exact(interval.lower()) <= *value;
    let below = interval.upper() == f64::INFINITY || *value <= exact(interval.upper());
    above && below
}

/// Numbers of all kinds: ordinary ones, small integers and their like, the smallest and the largest.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => -1e3..1e3_f64,
        2 => (-8..=8_i8).prop_map(f64::from),
        2 => (-320.0..308.0_f64, any::<bool>()).prop_map(|(log, minus)| {
            10.0_f64.powf(log) * if minus { -1.0 } else { 1.0 }
        }),
        1 => prop::sample::select(vec![
            0.0, -0.0, f64::MAX, f64::MIN, f64::MIN_POSITIVE, 5e-324, -5e-324, 1.0 + f64::EPSILON,
        ]),
    ]
}

/// An interval and a number inside it, at an end or anywhere between.
fn interval() -> impl Strategy<Value = (Interval, f64)> {
    (number(), number(), 0..=4_u8, 0.0..1.0_f64).prop_map(|(a, b, place, share)| {
        let (b, between) = (if place == 4 { a } else { b }, share * a + (1.0 - share) * b);
        let inside = match place {
            0 => a,
            1 => b,
            _ => between.clamp(a.min(b), a.max(b)),
        };
        (Interval::between(a, b), inside)
    })
}

/// The number of floats from one number to the other.
fn steps(a: f64, b: f64) -> u64 {
    let order =
        |x: f64| if x.is_sign_negative() { -((x.to_bits() << 1 >> 1) as i64) } else { x.to_bits() as i64 };
    order(a).abs_diff(order(b))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn sums_products_and_quotients_hold_the_exact_ones((a, x) in interval(), (b, y) in interval()) {
        prop_assert!(holds(a + b, &(exact(x) + exact(y))), "{a} + {b}");
        prop_assert!(holds(a - b, &(exact(x) - exact(y))), "{a} - {b}");
        prop_assert!(holds(a * b, &(exact(x) * exact(y))), "{a} * {b} = {}", a * b);
        prop_assert!(holds(a * y, &(exact(x) * exact(y))), "{a} * {y} = {}", a * y);
        prop_assert!(holds(-a, &-exact(x)));
        prop_assert!(holds(a.square(), &(exact(x) * exact(x))), "{a}²");
        prop_assert!(a.square().lower() >= 0.0 && holds(a.abs(), &exact(x.abs())));
        if y != 0.0 {
            prop_assert!(holds(a / b, &(exact(x) / exact(y))), "{a} / {b}");
        }
        // What floats compute is inside too, infinite or not.
        for (interval, float) in [(a + b, x + y), (a - b, x - y), (a * b, x * y), (a.square(), x * x)] {
            prop_assert!(interval.contains(float), "{interval} does not hold {float}");
        }
        if y != 0.0 {
            prop_assert!((a / b).contains(x / y), "{a} / {b}");
        }
    }

    #[test]
    fn operations_on_single_numbers_are_as_tight_as_floats_allow(x in number(), y in number()) {
        let (a, b) = (Interval::point(x), Interval::point(y));
        for (interval, units) in [(a + b, 1), (a - b, 1), (a * b, 2), (a * y, 2), (a.square(), 2)] {
            prop_assert!(steps(interval.lower(), interval.upper()) <= units, "{interval:?}");
        }
        if y != 0.0 {
            prop_assert!(steps((a / b).lower(), (a / b).upper()) <= 2);
        }
        prop_assert!(steps(a.abs().sqrt().lower(), a.abs().sqrt().upper()) <= 2);
        // An exact sum stays a single number.
        prop_assert_eq!(a + Interval::ZERO, a);
        prop_assert_eq!(a - a, Interval::ZERO);
        prop_assert_eq!(a * Interval::ZERO, Interval::ZERO);
    }

    #[test]
    fn a_product_is_the_hull_of_products_of_the_ends((a, _) in interval(), (b, _) in interval()) {
        let ends = [a.lower(), a.upper()].map(|x| [b.lower(), b.upper()].map(|y| exact(x) * exact(y)));
        let [least, greatest] = [ends.iter().flatten().min(), ends.iter().flatten().max()];
        let product = a * b;
        // Two units in the last place further in, something is lost.
        let [lower, upper] = [product.lower().next_up().next_up(), product.upper().next_down().next_down()];
        if product.lower() != 0.0 && lower.is_finite() {
            prop_assert!(exact(lower) > *least.expect("four"), "{product}");
        }
        if product.upper() != 0.0 && upper.is_finite() {
            prop_assert!(exact(upper) < *greatest.expect("four"), "{product}");
        }
    }

    #[test]
    fn roots_hold_the_exact_ones((a, x) in interval()) {
        let (a, x) = (a.abs(), x.abs());
        let root = a.sqrt();
        prop_assert!(root.lower() >= 0.0 && root.contains(x.sqrt()));
        prop_assert!(exact(root.lower()).pow(2) <= exact(x) && exact(x) <= exact(root.upper()).pow(2));
    }

    #[test]
    fn powers_hold_the_exact_ones(
        (a, share) in (-4.0..4.0_f64, -4.0..4.0_f64).prop_flat_map(|(a, b)| {
            (Just(Interval::between(a, b)), 0.0..=1.0_f64)
        }),
        exponent in -7..=9_i32,
    ) {
        let x = (a.lower() + share * (a.upper() - a.lower())).clamp(a.lower(), a.upper());
        prop_assume!(x != 0.0);
        prop_assert!(holds(a.powi(exponent), &exact(x).pow(exponent)), "{a}^{exponent}");
        if exponent > 0 {
            // The power of an end, or zero, and no more.
            let ends = [exact(a.lower()).pow(exponent), exact(a.upper()).pow(exponent)];
            let greatest = if ends[0] < ends[1] { &ends[1] } else { &ends[0] };
            let room = exact(1.0 + 1e-14);
            if *greatest > exact(0.0) {
                prop_assert!(exact(a.powi(exponent).upper()) <= greatest * &room);
            }
        }
    }

    #[test]
    fn sine_and_cosine_hold_the_exact_ones(
        middle in prop_oneof![-20.0..20.0_f64, (-12..=12_i8).prop_map(|k| f64::from(k) * std::f64::consts::FRAC_PI_2)],
        log_width in -17.0..1.0_f64,
        share in 0.0..=1.0_f64,
    ) {
        let width = 10.0_f64.powf(log_width);
        let a = Interval::between(middle - 0.5 * width, middle + 0.5 * width);
        let x = (a.lower() + share * (a.upper() - a.lower())).clamp(a.lower(), a.upper());
        let (sin, cos) = a.sin_cos();
        let (exact_sin, exact_cos) = series(x);
        prop_assert!(holds(sin, &exact_sin) && sin.contains(x.sin()), "sin {a} = {sin}, at {x}");
        prop_assert!(holds(cos, &exact_cos) && cos.contains(x.cos()), "cos {a} = {cos}, at {x}");
        // Both have slopes of at most 1.
        prop_assert!(sin.width() <= width + 1e-14 && cos.width() <= width + 1e-14, "{sin} {cos}");
    }

    #[test]
    fn a_larger_box_gives_a_larger_result((a, x) in interval(), (b, y) in interval(), (c, _) in interval()) {
        let (small_a, small_b) = (Interval::point(x), Interval::point(y));
        prop_assert!((small_a + small_b).is_within(a + b));
        prop_assert!((small_a * small_b).is_within(a * b));
        prop_assert!(small_a.square().is_within(a.square()) && small_a.is_within(a.hull(c)));
        if let Some(both) = a.intersection(c) {
            prop_assert!(both.is_within(a) && both.is_within(c));
        }
    }

    #[test]
    fn hostile_input_never_panics(
        ends in prop::array::uniform4(prop::num::f64::ANY),
        exponent in any::<i32>(),
    ) {
        let [a, b] = [Interval::between(ends[0], ends[1]), Interval::between(ends[2], ends[3])];
        for result in [
            a + b, a - b, a * b, a / b, -a, a * ends[2], a.square(), a.sqrt(), a.abs(), a.sin(), a.cos(),
            a.powi(exponent), a.hull(b), Interval::point(ends[0]), Interval::point(a.middle()),
        ] {
            prop_assert!(result.lower() <= result.upper(), "{result:?}");
            prop_assert!(result.lower() < f64::INFINITY && result.upper() > f64::NEG_INFINITY, "{result:?}");
            prop_assert!(result.width() >= 0.0 && result.magnitude() >= result.mignitude());
        }
        prop_assert!(a.contains(a.middle()));
    }

    #[test]
    fn rates_are_slopes(x in -3.0..3.0_f64, y in -3.0..3.0_f64) {
        let f = |x: Dual<f64>| {
            let (sin, cos) = x.sin_cos();
            sin * cos.square() - x.scaled(0.3) * sin + Dual::from(y)
        };
        let at = |offset: f64| f(Dual { value: x + offset, rate: 1.0 });
        let slope = (at(1e-6).value - at(-1e-6).value) / 2e-6;
        prop_assert!((at(0.0).rate - slope).abs() < 1e-8);
    }
}

/// Sine and cosine by their Taylor series in fixed point with 300 binary digits: exact to 1e-70 for |x| < 21.
fn series(x: f64) -> (BigRational, BigRational) {
    const DIGITS: u32 = 300;
    let one = BigInt::from(1) << DIGITS;
    let x = (exact(x) * BigRational::from(one.clone())).to_integer();
    let (mut sums, mut term) = ([BigInt::from(0), BigInt::from(0)], one.clone());
    for n in 0..160_u32 {
        let sum = &mut sums[usize::from(n % 2 == 1)];
        if n % 4 < 2 {
            *sum += &term;
        } else {
            *sum -= &term;
        }
        term = ((term * &x) >> DIGITS) / (n + 1);
    }
    let [cos, sin] = sums.map(|sum| BigRational::new(sum, one.clone()));
    (sin, cos)
}

#[test]
fn the_series_is_a_sine() {
    let (sin, cos) = series(std::f64::consts::PI);
    // π rounded to a float is 1.2246467991473531772e-16 below π.
    assert!((sin - exact(1.224_646_799_147_353_2e-16)).cmp(&exact(1e-31)) == Ordering::Less);
    assert!(cos + exact(1.0) < exact(1e-31));
}

#[test]
fn extrema_inside_are_seen_and_those_outside_are_not() {
    use std::f64::consts::{FRAC_PI_2, PI, TAU};
    let near = 1e-3;
    for k in -3..=3 {
        let top = f64::from(k) * TAU;
        assert_eq!(Interval::between(top - near, top + near).cos().upper(), 1.0);
        assert_eq!(Interval::between(top + FRAC_PI_2 - near, top + FRAC_PI_2 + near).sin().upper(), 1.0);
        assert_eq!(Interval::between(top + PI - near, top + PI + near).cos().lower(), -1.0);
        assert_eq!(Interval::between(top - FRAC_PI_2 - near, top - FRAC_PI_2 + near).sin().lower(), -1.0);
        assert!(Interval::between(top + near, top + 2.0 * near).cos().upper() < 1.0 - 0.4 * near * near);
        assert!(Interval::between(top + PI + near, top + PI + 2.0 * near).cos().lower() > -1.0);
    }
    let anything = Interval::between(-1.0, 1.0);
    assert_eq!(Interval::between(0.3, 0.3 + TAU).sin_cos(), (anything, anything));
    assert_eq!(Interval::point(1e7).sin(), anything, "not reduced");
}

#[test]
fn what_has_no_value_is_the_whole_line() {
    let zero = Interval::between(-1.0, 1.0);
    for undefined in [
        Interval::point(1.0) / zero,
        Interval::ZERO * Interval::WHOLE,
        Interval::between(-2.0, -1.0).sqrt(),
        Interval::point(f64::NAN),
        Interval::between(0.0, f64::NAN),
        zero.powi(-1),
        Interval::WHOLE - Interval::WHOLE,
    ] {
        assert_eq!(undefined, Interval::WHOLE);
    }
    // An overflow has a bound on one side.
    let large = Interval::point(f64::MAX) + Interval::point(f64::MAX);
    assert_eq!((large.lower(), large.upper()), (f64::MAX, f64::INFINITY));
    for (lower, upper) in [(1.0, 0.0), (f64::NAN, 1.0), (0.0, f64::NAN), (f64::INFINITY, f64::INFINITY)] {
        let error = Interval::new(lower, upper).expect_err("no interval");
        assert!(error.to_string().starts_with("interval: from "), "{error}");
    }
}
