//! Tests of laws between moving ends.

use graspcheck_motion::ContinuityClass;
use proptest::prelude::*;

use super::*;

fn limits(velocity: f64, acceleration: f64, jerk: f64) -> RateLimits {
    RateLimits { velocity, acceleration, jerk }
}

/// The largest magnitude of a derivative.
fn peak(law: &JointLaw, order: usize) -> f64 {
    let [low, high] = law.range(order);
    high.value.max(-low.value)
}

#[test]
fn moving_ends_in_every_direction() {
    let of = |start, end| JointLaw::s_curve(start, end, limits(2.0, 4.0, 16.0)).unwrap();
    // No way to go and no velocity to change.
    let none = of([0.3, 0.0], [0.3, 0.0]);
    assert_eq!((none.duration(), none.eval(0.0)[0], none.trajectory().is_err()), (0.0, 0.3, true));
    let none = of([0.3, 1.0], [0.3, 1.0]);
    assert_eq!((none.duration(), none.start()[1]), (0.0, 1.0));
    // The direct law: one change of velocity, from 2 to 0 in 2/4 + 4/16 s.
    let direct = of([0.0, 2.0], [0.75, 0.0]);
    assert_eq!((direct.duration(), direct.pieces().len()), (0.75, 3));
    // Too near to stop: it passes its end and comes back.
    let back = of([0.0, 2.0], [0.5, 0.0]);
    assert!(back.range(0)[1].value > 0.7 && back.duration() > 0.75, "{back:?}");
    // The start moves away from the goal.
    let turn = of([0.0, -2.0], [1.0, 0.0]);
    assert!(turn.range(0)[0].value < -0.7 && (turn.end()[0] - 1.0).abs() < 1e-15, "{turn:?}");
    // A cruise from limit to limit has one piece, and mirrors.
    for sign in [1.0, -1.0] {
        let cruise = of([0.0, 2.0 * sign], [3.0 * sign, 2.0 * sign]);
        assert_eq!((cruise.duration(), cruise.pieces().len()), (1.5, 1));
        let [q, qd, ..] = cruise.eval(0.75);
        assert!((q - 1.5 * sign).abs() < 1e-15 && (qd - 2.0 * sign).abs() < 1e-15, "{cruise:?}");
    }
}

#[test]
fn a_distance_that_is_direct_but_for_rounding_takes_no_way_round() {
    // Both ends move backwards; a distance larger by one rounding could only be met by a loop.
    let limits = limits(2.0, 4.0, 16.0);
    let change = 0.5 / 4.0 + 0.25;
    let covered: f64 = -1.25 * change;
    for from in [0.1_f64, 0.7, 3.3] {
        for to in [(from + covered).next_down(), from + covered, (from + covered).next_up()] {
            let law = JointLaw::s_curve([from, -1.5], [to, -1.0], limits).unwrap();
            assert!(law.duration() < 0.4, "{from} to {to}: {} s", law.duration());
            let law = JointLaw::trapezoid([from, -1.5], [from - 0.156_25, -1.0], 2.0, 4.0).unwrap();
            assert!(law.duration() < 0.13, "{} s", law.duration());
        }
    }
}

#[test]
fn a_tiny_change_of_a_large_velocity_keeps_the_jerk_limit() {
    for beyond in [1e-6, 1e-9, 1e-12, 1e-14] {
        let law = JointLaw::s_curve([0.0, 7.0], [1e-3 + beyond, 7.0], limits(10.0, 10.0, 30.0)).unwrap();
        assert!(peak(&law, 3) <= 30.0 * (1.0 + 1e-12), "{beyond}: {law:?}");
        assert!(peak(&law, 1) <= 10.0 && (law.duration() - 1e-3 / 7.0).abs() < 1e-4);
    }
}

#[test]
fn bad_input_says_what_would_do() {
    let sound = limits(1.0, 1.0, 1.0);
    let message = |law: Result<JointLaw, ScalingError>| law.unwrap_err().to_string();
    for (law, expected) in [
        (
            JointLaw::s_curve([0.0, -1.5], [1.0, 0.0], sound),
            "start velocity -1.5 is beyond the limit 1: raise the limit to 1.5, or brake before",
        ),
        (
            JointLaw::trapezoid([0.0, 0.0], [1.0, 2.0], 1.0, 1.0),
            "end velocity 2 is beyond the limit 1: raise the limit to 2, or brake before",
        ),
        (JointLaw::s_curve([f64::NAN, 0.0], [1.0, 0.0], sound), "start position NaN must be finite"),
        (JointLaw::s_curve([0.0, 0.0], [1.0, f64::INFINITY], sound), "end velocity inf must be finite"),
        (
            JointLaw::s_curve([0.0, 0.0], [1.0, 0.0], limits(1.0, 0.0, 1.0)),
            "acceleration 0 must be a positive finite number",
        ),
        (
            JointLaw::s_curve([0.0, 0.0], [1.0, 0.0], limits(1.0, 1.0, f64::INFINITY)),
            "jerk inf must be a positive finite number",
        ),
        (JointLaw::cubic([0.0, 0.0], [1.0, 0.0], -1.0), "duration -1 must be a positive finite number"),
        (JointLaw::quintic([0.0; 3], [1.0, 0.0, f64::NAN], 1.0), "end acceleration NaN must be finite"),
        (JointLaw::septic([0.0, 0.0, 0.0, f64::NAN], [0.0; 4], 1.0), "start jerk NaN must be finite"),
        (JointLaw::cubic([-1e308, 0.0], [1e308, 0.0], 1.0), "distance inf must be finite"),
        (JointLaw::rest(0.0, f64::NAN), "duration NaN must be a positive finite number"),
    ] {
        assert_eq!(message(law), expected);
    }
    assert!(matches!(
        JointLaw::quintic([0.0; 3], [1.0, 0.0, 0.0], 1e-80),
        Err(ScalingError::Overflow { distance: 1.0, .. })
    ));
}

#[test]
fn states_beyond_limits_say_what_would_do() {
    let sound = limits(1.0, 2.0, 10.0);
    let message = |law: Result<JointLaw, ScalingError>| law.unwrap_err().to_string();
    for (law, expected) in [
        (
            JointLaw::fastest([0.0, 0.0, -3.0], [1.0, 0.0, 0.0], sound),
            "start acceleration -3 is beyond the limit 2: raise the limit to 3, or lower the acceleration before",
        ),
        (
            JointLaw::fastest([0.0, 0.95, 2.0], [1.0, 0.0, 0.0], sound),
            "start velocity 0.95 with acceleration 2: the velocity reaches 1.15 with the greatest jerk, beyond the limit 1: \
             the acceleration may be at most 1.0000000000000004",
        ),
        (
            JointLaw::lasting([0.0; 3], [2.0, 0.0, 0.0], limits(1.0, 1.0, 1.0), 3.5),
            "duration 3.5 s cannot be met: the least duration is 4 s, the nearest is 4 s",
        ),
        (
            JointLaw::lasting([0.0; 3], [1.0, 0.0, 0.0], sound, f64::NAN),
            "duration NaN must be a positive finite number",
        ),
    ] {
        assert_eq!(message(law), expected);
    }
    // Backwards in time the end is a start: there an acceleration that has just slowed the joint came from beyond.
    assert!(JointLaw::fastest([0.0; 3], [1.0, 0.95, 2.0], sound).is_ok());
    assert!(matches!(
        JointLaw::fastest([0.0; 3], [1.0, 0.95, -2.0], sound),
        Err(ScalingError::BoundaryReach { end: "end", .. })
    ));
}

#[test]
fn the_simplest_laws_between_accelerating_ends() {
    let sound = limits(10.0, 2.0, 4.0);
    // No way to go: no time.
    let none = JointLaw::fastest([0.3, 1.0, -1.0], [0.3, 1.0, -1.0], sound).unwrap();
    assert_eq!((none.duration(), none.pieces().len()), (0.0, 1));
    // One arc of jerk from -1 to 2 in 3/4 s, and the same backwards: v = v₀ + a t + J t²/2.
    for sign in [1.0, -1.0] {
        let t: f64 = 0.75;
        let end = [t - 0.5 * t * t + 4.0 / 6.0 * t.powi(3), 1.0 - t + 2.0 * t * t, 2.0];
        let law = JointLaw::fastest([0.0, sign, -sign], end.map(|x| sign * x), sound).unwrap();
        assert!((law.duration() - t).abs() < 1e-12, "{law:?}");
        let [low, high] = law.range(3);
        assert!((low.value - 4.0 * sign).abs() < 1e-9 && (high.value - 4.0 * sign).abs() < 1e-9, "{law:?}");
    }
    // A dip of the acceleration from 2 to 1 and back in 0.5 s, which gains 0.75 on the velocity.
    let covered = 2.0 * 0.25 + 0.5 * 2.0 * 0.0625 - 4.0 / 6.0 * 0.25_f64.powi(3);
    let velocity = 2.0 + 2.0 * 0.25 - 2.0 * 0.0625;
    let more = velocity * 0.25 + 0.5 * 0.0625 + 4.0 / 6.0 * 0.25_f64.powi(3);
    let law =
        JointLaw::fastest([0.0, 2.0, 2.0], [covered + more, 2.75, 2.0], limits(10.0, 3.0, 4.0)).unwrap();
    assert!((law.duration() - 0.5).abs() < 1e-12, "{law:?}");
    assert!((peak(&law, 2) - 2.0).abs() < 1e-12);
}

#[test]
fn an_exact_duration_from_rest_is_the_farthest_law_on_a_smaller_scale() {
    let sound = limits(1.0, 2.0, 10.0);
    let law = JointLaw::lasting([0.0; 3], [0.5, 0.0, 0.0], sound, 1.7).unwrap();
    for (order, limit) in [1.0, 2.0, 10.0].into_iter().enumerate() {
        assert!((peak(&law, order + 1) - 0.5 * limit).abs() < 1e-12, "{law:?}");
    }
    // At rest for a while.
    let law = JointLaw::lasting([0.2, 0.0, 0.0], [0.2, 0.0, 0.0], sound, 3.0).unwrap();
    assert!(peak(&law, 1) < 1e-15 && (law.duration() - 3.0).abs() < 1e-15);
}

#[test]
fn durations_between_moving_ends_have_gaps() {
    // Both ends go forwards; to lose time the joint must stop, turn round and come back.
    let sound = limits(1.0, 2.0, 10.0);
    let (start, end) = ([0.0, 0.5, 0.0], [0.1, 0.5, 0.0]);
    let possible = JointLaw::possible_durations(start, end, sound).unwrap();
    let [[least, until], [since, forever]] = possible[..] else { panic!("{possible:?}") };
    assert!(least < 0.2 && 0.2 < until && until < since && forever == f64::INFINITY, "{possible:?}");
    for duration in [least, 0.2, until, since, 2.0 * since, 1000.0] {
        let law = JointLaw::lasting(start, end, sound, duration).unwrap();
        assert!(peak(&law, 3) <= 10.0 * (1.0 + 1e-9) && (law.end()[0] - 0.1).abs() < 1e-15, "{law:?}");
    }
    for duration in [0.9 * least, 1.01 * until, 0.5 * (until + since), 0.99 * since] {
        let Err(ScalingError::DurationNotPossible { before, after, .. }) =
            JointLaw::lasting(start, end, sound, duration)
        else {
            panic!("{duration} s cannot be met")
        };
        assert_eq!((before, after), if duration < least { (None, least) } else { (Some(until), since) });
    }
}

#[test]
fn laws_of_other_times_make_no_motion() {
    let law = |duration: f64| JointLaw::cubic([0.0, 0.0], [1.0, 0.0], duration).unwrap();
    let error = together(&[law(1.0), law(2.0)]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "joint 1: its law from 0 s for 2 s must be from 0 s for 1 s, as that of joint 0"
    );
    assert!(matches!(
        together(&[law(1.0), law(1.0).starting_at(3.0).unwrap()]),
        Err(TogetherError::OtherTimes { joint: 1, start: 3.0, .. })
    ));
    assert_eq!(together(&[]), Err(TogetherError::Trajectory(TrajectoryError::NoJoint)));
}

/// What a law must do whatever it is: begin and end as asked, be smooth, and have derivatives that are those of
/// its position.
fn check_law(
    law: &JointLaw,
    start: &[f64],
    end: &[f64],
    class: ContinuityClass,
) -> Result<(), TestCaseError> {
    for (asked, found) in [(start, law.start()), (end, law.end())] {
        for (order, (asked, found)) in asked.iter().zip(found).enumerate() {
            let scale = peak(law, order).max(f64::MIN_POSITIVE);
            let knots = f64::EPSILON * law.duration() * if order < 3 { peak(law, order + 1) } else { 0.0 };
            prop_assert!(
                (asked - found).abs() <= 1e-11 * scale + 4.0 * knots,
                "{order}: {found} is not {asked}"
            );
        }
    }
    let motion = law.trajectory().unwrap();
    prop_assert!(motion.continuity().class >= class, "{:?}", motion.continuity());
    let ends = law.pieces().map(|(start, _)| start).skip(1).chain([law.end_time()]);
    for ((start, _), end) in law.pieces().zip(ends) {
        let (t, h) = (0.5 * (start + end), 0.25 * (end - start));
        let [before, at, after] = [t - h, t, t + h].map(|t| law.eval(t));
        // By Simpson's rule, which is exact for cubics, the change is the integral of the derivative.
        for order in 0..3 {
            let integral = (before[order + 1] + 4.0 * at[order + 1] + after[order + 1]) * h / 3.0;
            let scale = peak(law, order) + h * peak(law, order + 1);
            let knots = 8.0 * f64::EPSILON * law.duration() * peak(law, order + 1);
            prop_assert!(
                (after[order] - before[order] - integral).abs() <= 1e-11 * scale + knots,
                "order {order} at {t}"
            );
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn s_curves_between_moving_ends(
        logs in prop::array::uniform3(-1.0..2.0_f64),
        shares in prop::array::uniform2(-1.0..=1.0_f64),
        from in -3.0..3.0_f64,
        log_distance in -9.0..1.0_f64,
        backwards in any::<bool>(),
    ) {
        let [v, a, j] = logs.map(|log| 10.0_f64.powf(log));
        let distance = 10.0_f64.powf(log_distance) * if backwards { -1.0 } else { 1.0 };
        let (start, end) = ([from, shares[0] * v], [from + distance, shares[1] * v]);
        let law = JointLaw::s_curve(start, end, limits(v, a, j)).unwrap();
        let full = |state: [f64; 2]| [state[0], state[1], 0.0];
        check_law(&law, &full(start), &full(end), ContinuityClass::C2)?;
        for (limit, order) in [v, a, j].into_iter().zip(1..) {
            let knots = f64::EPSILON * law.duration() * if order < 3 { peak(&law, order + 1) } else { 0.0 };
            prop_assert!(peak(&law, order) <= limit * (1.0 + 1e-11) + knots, "order {order}: {} of {limit}", peak(&law, order));
        }
        // The jerk limit is reached wherever a velocity changes; then the acceleration or nothing more.
        if law.pieces().len() > 1 {
            prop_assert!(peak(&law, 3) >= j * (1.0 - 1e-9));
        }
        // The limits of acceleration and jerk halved, it cannot be faster.
        let slower = JointLaw::s_curve(start, end, limits(v, 0.5 * a, 0.5 * j)).unwrap();
        prop_assert!(slower.duration() >= law.duration() * (1.0 - 1e-9));
        // Backwards in time it is the same problem.
        let reversed = JointLaw::s_curve([end[0], -end[1]], [start[0], -start[1]], limits(v, a, j)).unwrap();
        prop_assert!((reversed.duration() - law.duration()).abs() <= 1e-9 * law.duration());
    }

    #[test]
    fn trapezoids_between_moving_ends(
        logs in prop::array::uniform2(-1.0..2.0_f64),
        shares in prop::array::uniform2(-1.0..=1.0_f64),
        distance in -3.0..3.0_f64,
    ) {
        let [v, a] = logs.map(|log| 10.0_f64.powf(log));
        let (start, end) = ([0.5, shares[0] * v], [0.5 + distance, shares[1] * v]);
        let law = JointLaw::trapezoid(start, end, v, a).unwrap();
        check_law(&law, &start, &end, ContinuityClass::C1)?;
        prop_assert!(peak(&law, 1) <= v * (1.0 + 1e-12));
        prop_assert!((peak(&law, 2) / a - 1.0).abs() < 1e-9 || law.pieces().len() == 1);
        // The S-curve tends to it as the jerk limit grows.
        let smooth = JointLaw::s_curve(start, end, limits(v, a, 1e6 * a / law.duration())).unwrap();
        prop_assert!(smooth.duration() >= law.duration() * (1.0 - 1e-9));
        prop_assert!(smooth.duration() <= law.duration() * (1.0 + 1e-4), "{} {}", smooth.duration(), law.duration());
    }

    #[test]
    fn polynomials_meet_their_ends(
        start in prop::array::uniform4(-3.0..3.0_f64),
        end in prop::array::uniform4(-3.0..3.0_f64),
        log_duration in -2.0..2.0_f64,
    ) {
        let duration = 10.0_f64.powf(log_duration);
        // What rounding is relative to: the terms of the position, which largely cancel.
        let terms = 3.0 * (1.0 + duration + duration.powi(2) + duration.powi(3));
        let ([q0, v0, a0, _], [q1, v1, a1, _]) = (start, end);
        let cubic = JointLaw::cubic([q0, v0], [q1, v1], duration).unwrap();
        let quintic = JointLaw::quintic([q0, v0, a0], [q1, v1, a1], duration).unwrap();
        let septic = JointLaw::septic(start, end, duration).unwrap();
        for (law, given) in [(cubic, 2), (quintic, 3), (septic, 4)] {
            let expected = [&start[..given], &end[..given]];
            for (found, expected) in [law.start(), law.end()].into_iter().zip(expected) {
                for (order, (found, expected)) in found.into_iter().zip(expected).enumerate() {
                    prop_assert!((found - expected).abs() <= 1e-11 * terms / duration.powi(order as i32));
                }
            }
            prop_assert_eq!(law.duration().to_bits(), duration.to_bits());
        }
    }

    #[test]
    fn laws_together_are_the_laws(
        distances in prop::array::uniform4(-3.0..3.0_f64),
        logs in prop::array::uniform4(-1.0..2.0_f64),
        share in 0.0..=1.0_f64,
    ) {
        let scalings: Vec<TimeScaling> = distances.iter().zip(logs).map(|(d, log)| {
            let limit = 10.0_f64.powf(log);
            TimeScaling::s_curve(d.abs().max(1e-6), limit, 3.0 * limit, 40.0 * limit).unwrap()
        }).collect();
        let slowest = scalings.iter().map(TimeScaling::duration).fold(0.0, f64::max);
        let laws: Vec<JointLaw> = scalings.iter().zip(distances).map(|(scaling, d)| {
            JointLaw::along(0.1, 0.1 + d, &scaling.stretched_to(slowest).unwrap()).unwrap()
        }).collect();
        let motion = together(&laws).unwrap();
        prop_assert_eq!(motion.continuity().class, ContinuityClass::C2);
        prop_assert_eq!(motion.duration().to_bits(), slowest.to_bits());
        let state = motion.eval(share * slowest);
        for (joint, law) in laws.iter().enumerate() {
            let [q, qd, qdd, _] = law.eval(share * slowest);
            prop_assert!((state.q[joint] - q).abs() < 1e-13);
            prop_assert!((state.qd[joint] - qd).abs() <= 1e-12 * peak(law, 1).max(1.0));
            prop_assert!((state.qdd[joint] - qdd).abs() <= 1e-11 * peak(law, 2).max(1.0));
        }
    }
}
