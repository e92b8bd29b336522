//! The worked examples of time laws, from the public interface: every row of the section on time scalings (3)
//! and of the section on single segments (4). Angles are in degrees as there; the laws do not mind the unit.

use graspcheck_model::{
    robot::JointLimits,
    task::{Sync, TimeLaw},
};
use graspcheck_motion::{ContinuityClass, Trajectory};
use graspcheck_planner::{
    joint_law::{JointLaw, RateLimits},
    joint_move::{Pacing, joint_move_by},
    time_scaling::{Profile, ScalingError, TimeScaling},
};

/// For values that are exact but for rounding.
const EXACT: f64 = 1e-12;

/// For values that are given with six decimals.
const SIX_DECIMALS: f64 = 5.1e-7;

#[track_caller]
fn assert_near(value: f64, expected: f64, tolerance: f64) {
    assert!((value - expected).abs() <= tolerance * expected.abs().max(1.0), "{value} is not {expected}");
}

fn law(scaling: Result<TimeScaling, ScalingError>) -> TimeScaling {
    scaling.expect("the worked example exists")
}

/// The motion of a law and its largest velocity, acceleration and jerk, computed from the polynomials.
fn motion_and_peaks(scaling: &TimeScaling) -> (Trajectory, [f64; 3]) {
    let motion =
        JointLaw::along(0.0, scaling.distance(), scaling).expect("finite").trajectory().expect("a motion");
    let peaks = [1, 2, 3].map(|order| motion.peak(0, order).value.abs());
    (motion, peaks)
}

#[test]
fn section_3_table_of_peaks() {
    let (distance, duration) = (0.8, 0.5);
    let generous = [1e3, 1e4, 1e6];
    let polynomial_laws = [
        (TimeLaw::Cubic, [1.5, 6.0, 12.0], ContinuityClass::C1),
        (TimeLaw::Quintic, [15.0 / 8.0, 10.0 / 3.0_f64.sqrt(), 60.0], ContinuityClass::C2),
    ];
    for (kind, factors, with_rest) in polynomial_laws {
        let make = if kind == TimeLaw::Cubic { TimeScaling::cubic } else { TimeScaling::quintic };
        let scaling = law(make(distance, generous[0], generous[1], generous[2]));
        let scaling = scaling.stretched_to(duration).expect("a duration");
        let (motion, peaks) = motion_and_peaks(&scaling);
        for (k, power) in [1, 2, 3].into_iter().enumerate() {
            assert_near(peaks[k], factors[k] * distance / duration.powi(power), EXACT);
            assert_near(scaling.peaks()[k], peaks[k], EXACT);
        }
        let [_, velocity, ..] = scaling.eval(0.5 * duration);
        assert_near(velocity, peaks[0], EXACT);
        // Between rests the cubic jumps in acceleration: its jerk at the ends is infinite.
        let rest = Trajectory::hold(&[0.0], 1.0).expect("a rest");
        assert_eq!(rest.then(&motion).expect("one joint").continuity().class, with_rest);
    }
    let (motion, [v, a, _]) = motion_and_peaks(&law(TimeScaling::trapezoid(2.0, 1.5, 3.0)));
    assert_near(v, 1.5, EXACT);
    assert_near(a, 3.0, EXACT);
    assert_eq!(motion.continuity().class, ContinuityClass::C1);
    let (motion, peaks) = motion_and_peaks(&law(TimeScaling::s_curve(2.0, 1.5, 3.0, 20.0)));
    for (peak, limit) in peaks.into_iter().zip([1.5, 3.0, 20.0]) {
        assert_near(peak, limit, EXACT);
    }
    assert_eq!((motion.continuity().class, motion.piece_count()), (ContinuityClass::C2, 7));
}

#[test]
fn section_3_jerk_follows_the_chain_rule() {
    // Along q(s) = q₀ + c s the chain rule leaves q_s sddd alone.
    let scaling = law(TimeScaling::quintic(1.0, 1.0, 1.0, 1.0));
    let along = JointLaw::along(2.0, -1.0, &scaling).expect("finite");
    for share in [0.0, 0.2, 0.7, 1.0] {
        let t = share * scaling.duration();
        assert_near(along.eval(t)[3], -3.0 * scaling.eval(t)[3], EXACT);
    }
}

#[test]
fn section_3_cubic_between_velocities_from_another_time() {
    let ([q0, v0], [q1, v1], t) = ([1.0, -0.5], [3.0, 2.0], 1.5);
    let cubic = JointLaw::cubic([q0, v0], [q1, v1], t).expect("sound").starting_at(7.0).expect("finite");
    let (start, polynomial) = cubic.pieces().next().expect("one piece");
    let a2 = (3.0 * (q1 - q0) - (2.0 * v0 + v1) * t) / (t * t);
    let a3 = (2.0 * (q0 - q1) + (v0 + v1) * t) / (t * t * t);
    for (c, expected) in polynomial.coefficients().iter().zip([q0, v0, a2, a3]) {
        assert_near(*c, expected, EXACT);
    }
    assert_eq!((start, cubic.start_time(), cubic.end_time()), (7.0, 7.0, 8.5));
    // In absolute time it is the same polynomial.
    let absolute = polynomial.shifted(-7.0);
    assert_near(absolute.eval(8.0)[0], cubic.eval(8.0)[0], 1e-10);
}

#[test]
fn section_3_trapezoid_from_any_two() {
    // One trapezoid, D = 3, V = 1.5, A = 2.5, t_b = 0.6, T = 2.6, by all six pairs.
    let (d, v, a, blend, t) = (3.0, 1.5, 2.5, 0.6, 2.6);
    for scaling in [
        TimeScaling::trapezoid(d, v, a),
        TimeScaling::trapezoid_with_velocity(d, t, v),
        TimeScaling::trapezoid_with_acceleration(d, t, a),
        TimeScaling::trapezoid_with_blend(d, t, blend),
        TimeScaling::trapezoid_with_velocity_and_blend(d, v, blend),
        TimeScaling::trapezoid_with_acceleration_and_blend(d, a, blend),
    ] {
        let scaling = law(scaling);
        assert_near(scaling.duration(), t, EXACT);
        let Profile::Trapezoid { rise, fall, .. } = scaling.profile() else { panic!("{scaling:?}") };
        assert_near(rise, blend, EXACT);
        assert_near(fall, blend, EXACT);
        assert_near(scaling.peaks()[0], v, EXACT);
        assert_near(scaling.peaks()[1], a, EXACT);
        // Signs follow q₁ - q₀.
        let down = JointLaw::along(1.0, -2.0, &scaling).expect("finite");
        assert_near(down.eval(0.5 * t)[1], -v, EXACT);
        assert_near(down.start()[2], -a, EXACT);
    }
    // (V, A) with D < V²/A: no cruise, peak √(DA).
    let scaling = law(TimeScaling::trapezoid(0.5, 10.0, 2.0));
    assert_near(scaling.duration(), 1.0, EXACT);
    assert_near(scaling.peaks()[0], 1.0, EXACT);
    // (T, A) at A = 4D/T²: the peak velocity is twice D/T.
    let scaling = law(TimeScaling::trapezoid_with_acceleration(3.0, 2.0, 3.0));
    assert_near(scaling.peaks()[0], 3.0, EXACT);
    assert_eq!(scaling.pieces().len(), 2);
    // Bang-bang: T = 2 √(D/A).
    assert_near(law(TimeScaling::bang_bang(9.0, 4.0)).duration(), 3.0, EXACT);
}

#[test]
fn section_3_a_trapezoid_that_does_not_exist_says_what_would() {
    let message = |scaling: Result<TimeScaling, ScalingError>| scaling.expect_err("no such law").to_string();
    for (scaling, expected) in [
        (
            TimeScaling::trapezoid_with_velocity(3.0, 2.0, 1.5),
            "distance 3 in 2 s: cruise velocity 1.5 must be above 1.5 and at most 3",
        ),
        (
            TimeScaling::trapezoid_with_acceleration(3.0, 2.0, 2.0),
            "distance 3 in 2 s: acceleration 2 must be at least 3",
        ),
        (
            TimeScaling::trapezoid_with_blend(3.0, 2.0, 1.5),
            "distance 3, duration 2: blend time 1.5 s must be at most 1 s",
        ),
        (
            TimeScaling::trapezoid_with_velocity_and_blend(3.0, 2.0, 2.0),
            "distance 3, velocity 2: blend time 2 s must be at most 1.5 s",
        ),
        (
            TimeScaling::trapezoid_with_acceleration_and_blend(4.0, 1.0, 2.5),
            "distance 4, acceleration 1: blend time 2.5 s must be at most 2 s",
        ),
        (TimeScaling::bang_bang(3.0, 0.0), "acceleration 0 must be a positive finite number"),
        (TimeScaling::trapezoid_with_blend(3.0, -2.0, 1.0), "duration -2 must be a positive finite number"),
        (
            TimeScaling::asymmetric_trapezoid(3.0, 1.0, 1.0, f64::NAN),
            "deceleration NaN must be a positive finite number",
        ),
    ] {
        assert_eq!(message(scaling), expected);
    }
}

#[test]
fn section_3_s_curve_durations() {
    for (distance, expected, tolerance) in [
        (1.0, 1.7, EXACT),
        (0.2, 0.1 * 2.0 + 2.0 * (0.01_f64 + 0.1).sqrt(), EXACT),
        (0.2, 0.863_325, SIX_DECIMALS),
        (0.16, 0.8, EXACT),
        (0.01, 4.0 * 0.0005_f64.cbrt(), EXACT),
        (0.01, 0.317_480, SIX_DECIMALS),
    ] {
        assert_near(law(TimeScaling::s_curve(distance, 1.0, 2.0, 10.0)).duration(), expected, tolerance);
    }
}

fn two_joints(jerk: f64) -> [JointLimits; 2] {
    [(0.6, 10.0), (10.0, 1.0)].map(|(velocity, acceleration)| JointLimits {
        position_min: -9.0,
        position_max: 9.0,
        velocity,
        acceleration,
        jerk,
        effort: 1.0,
    })
}

#[test]
fn section_3_several_joints() {
    let duration = |limits: &[JointLimits], law: TimeLaw, sync: Sync| {
        let (from, to) = (vec![0.0; limits.len()], vec![1.0; limits.len()]);
        let pacing = Pacing { law, sync, ..Pacing::default() };
        joint_move_by(&from, &to, limits, pacing).expect("a move").duration()
    };
    let limits = two_joints(1e3);
    let [one, other] = [[limits[0]], [limits[1]]];
    let trapezoid = TimeLaw::Trapezoid;
    assert_near(duration(&one, trapezoid, Sync::Straight), 1.0 / 0.6 + 0.06, EXACT);
    assert_near(duration(&other, trapezoid, Sync::Straight), 2.0, EXACT);
    assert_near(duration(&limits, trapezoid, Sync::Straight), 1.0 / 0.6 + 0.6, EXACT);
    assert_near(duration(&limits, trapezoid, Sync::EndTimes), 2.0, EXACT);
    // The S-curve tends to the trapezoid as the jerk limit grows.
    let s_curve = |jerk| duration(&two_joints(jerk), TimeLaw::SCurve, Sync::Straight) - (1.0 / 0.6 + 0.6);
    assert!(s_curve(1e2) > 0.0 && s_curve(1e6) < 2e-6, "{} {}", s_curve(1e2), s_curve(1e6));
    // Cubic and quintic: the largest of C_v D/V, √(C_a D/A), ∛(C_j D/J) over joints, straight or not.
    for (law, [cv, ca, cj]) in
        [(TimeLaw::Cubic, [1.5, 6.0, 12.0]), (TimeLaw::Quintic, [1.875, 10.0 / 3.0_f64.sqrt(), 60.0])]
    {
        for jerk in [1.0, 1e4] {
            let limits = two_joints(jerk);
            let of = |l: &JointLimits| {
                (cv / l.velocity).max((ca / l.acceleration).sqrt()).max((cj / l.jerk).cbrt())
            };
            let expected = of(&limits[0]).max(of(&limits[1]));
            assert_near(duration(&limits, law, Sync::Straight), expected, EXACT);
            assert_near(duration(&limits, law, Sync::EndTimes), expected, EXACT);
        }
    }
}

#[test]
fn section_3_a_start_in_motion() {
    let limits = RateLimits { velocity: 10.0, acceleration: 10.0, jerk: 30.0 };
    let law = JointLaw::s_curve([0.0, 7.0], [10.0, 0.0], limits).expect("a law");
    assert_near(law.duration(), 1.780_446, SIX_DECIMALS);
    for (value, expected) in law.end().into_iter().zip([10.0, 0.0, 0.0]) {
        assert_near(value, expected, EXACT);
    }
}

#[test]
fn section_4_cubic_1() {
    let law = JointLaw::cubic([10.0, -50.0], [40.0, -50.0], 1.0).expect("sound");
    let (_, polynomial) = law.pieces().next().expect("one piece");
    assert_eq!(polynomial.coefficients()[..4], [10.0, -50.0, 240.0, -160.0]);
    let [low, high] = law.range(0);
    for (value, expected) in
        [(low.value, 7.178_872), (low.time, 0.118_119), (high.value, 42.821_128), (high.time, 0.881_881)]
    {
        assert!((value - expected).abs() < SIX_DECIMALS, "{value} is not {expected}");
    }
    // The same from another time on.
    let [later, _] = law.starting_at(50.0).expect("finite").range(0);
    assert_near(later.time, 50.0 + low.time, EXACT);
}

#[test]
fn section_4_cubic_2() {
    let law = JointLaw::cubic([50.0, 0.0], [80.0, 0.0], 3.0).expect("sound");
    let (_, polynomial) = law.pieces().next().expect("one piece");
    for (c, expected) in polynomial.coefficients().iter().zip([50.0, 0.0, 10.0, -20.0 / 9.0]) {
        assert_near(*c, expected, EXACT);
    }
    for (t, expected) in [
        (1.0, [50.0 + 70.0 / 9.0, 40.0 / 3.0, 20.0 / 3.0]),
        (2.0, [650.0 / 9.0, 40.0 / 3.0, -20.0 / 3.0]),
        (3.0, [80.0, 0.0, -20.0]),
    ] {
        for (value, expected) in law.eval(t).into_iter().zip(expected) {
            assert_near(value, expected, EXACT);
        }
    }
    // Rest to rest in the time that its peaks allow is the same law.
    let scaling = TimeScaling::cubic(30.0, 15.0, 100.0, 1e4).expect("sound");
    assert_near(scaling.duration(), 3.0, EXACT);
    let same = JointLaw::along(50.0, 80.0, &scaling).expect("finite");
    assert_near(same.eval(1.0)[0], law.eval(1.0)[0], EXACT);
}

#[test]
fn section_4_lspb_1_and_2() {
    let blend_of = |scaling: &TimeScaling| match scaling.profile() {
        Profile::Trapezoid { rise, .. } => rise,
        other => panic!("{other:?}"),
    };
    let scaling = law(TimeScaling::trapezoid_with_velocity(80.0, 4.0, 25.0));
    assert_near(blend_of(&scaling), 0.8, EXACT);
    assert_near(scaling.peaks()[1], 31.25, EXACT);
    let scaling = law(TimeScaling::trapezoid_with_acceleration(80.0, 4.0, 25.0));
    let blend = 2.0 - 0.5 * (16.0_f64 - 12.8).sqrt();
    assert_near(blend_of(&scaling), blend, EXACT);
    assert_near(blend, 1.105_573, SIX_DECIMALS);
    assert_near(scaling.peaks()[0], 25.0 * blend, EXACT);
    assert!((scaling.peaks()[0] - 27.639_320).abs() < SIX_DECIMALS);
    let scaling = law(TimeScaling::trapezoid_with_acceleration(80.0, 4.0, 20.0));
    assert_near(scaling.peaks()[0], 40.0, EXACT);
    let joint = JointLaw::along(40.0, 120.0, &scaling).expect("finite");
    assert_eq!((joint.start()[0], joint.end()[0]), (40.0, 120.0));
}

#[test]
fn section_4_quintic_1() {
    let law = JointLaw::quintic([0.0, 0.0, 10.0], [75.0, 0.0, 10.0], 3.0).expect("sound");
    let (_, polynomial) = law.pieces().next().expect("one piece");
    let expected = [0.0, 0.0, 5.0, 220.0 / 9.0, -40.0 / 3.0, 50.0 / 27.0];
    for (c, expected) in polynomial.coefficients().iter().zip(expected) {
        assert_near(*c, expected, EXACT);
    }
}
