//! Linear functions with parabolic blends: accelerations or blend times, points that must be met, what is
//! too much and the least change that would do, and the laws of all of it.

use graspcheck_motion::ContinuityClass;
use graspcheck_planner::lfpb::{
    Blend, BlendEnds, Lfpb, LfpbError, LfpbMotion, LfpbPoint, Met, Place, Remedy,
};
use proptest::prelude::*;

fn assert_near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-9, "{found} is not {expected}");
}

fn assert_all_near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (found, expected) in found.iter().zip(expected) {
        assert_near(*found, *expected);
    }
}

/// x of the RRR example of section 6 of the worked examples.
const TIMES: [f64; 4] = [0.0, 2.0, 4.0, 7.0];
const X: [f64; 4] = [-4.0, 0.0, 3.0, 4.0];
const THETA: [f64; 4] = [90.0, 45.0, 30.0, 0.0];

#[test]
fn accelerations_of_the_rrr_example_give_back_its_blend_times() {
    for positions in [X, [0.0, 3.0, 3.0, 0.0], THETA] {
        let by_time = Lfpb::with_blend_times(&TIMES, &positions, &[0.5; 4], BlendEnds::Inside).unwrap();
        let magnitudes: Vec<f64> = by_time.accelerations().iter().map(|a| a.abs()).collect();
        let by_force = Lfpb::with_accelerations(&TIMES, &positions, &magnitudes, BlendEnds::Inside).unwrap();
        assert_all_near(by_force.blend_times(), &[0.5; 4]);
        assert_all_near(by_force.velocities(), by_time.velocities());
        assert_all_near(by_force.accelerations(), by_time.accelerations());
        assert_all_near(by_force.misses(), by_time.misses());
    }
}

#[test]
fn formulas_of_the_ends_and_of_inner_points_hold() {
    // Section 6: t_1 = t_d - sqrt(t_d² - 2Δ/a), t_n = t_d - sqrt(t_d² + 2Δ/a) with signs, t_k = Δv/a.
    let motion = Lfpb::with_accelerations(&TIMES, &X, &[5.0, 4.0, 3.0, 2.0], BlendEnds::Inside).unwrap();
    let first = 2.0 - (4.0_f64 - 2.0 * 4.0 / 5.0).sqrt();
    let last = 3.0 - (9.0_f64 + 2.0 * 1.0 / -2.0).sqrt();
    let velocities = [4.0 / (2.0 - first / 2.0), 1.5, 1.0 / (3.0 - last / 2.0)];
    assert_all_near(motion.velocities(), &velocities);
    let inner = [(velocities[0] - 1.5) / 4.0, (1.5 - velocities[2]) / 3.0];
    assert_all_near(motion.blend_times(), &[first, inner[0], inner[1], last]);
    assert_all_near(motion.accelerations(), &[5.0, -4.0, -3.0, -2.0]);
}

#[test]
fn blend_times_and_accelerations_mix_at_will() {
    // lspb-1 and lspb-2 of the worked examples, each with one end by time and one by acceleration.
    for (blend, acceleration, velocity) in
        [(0.8, 31.25, 25.0), (1.105_572_809_000_084, 25.0, 27.639_320_225_002_102)]
    {
        let blends = [Blend::Duration(blend), Blend::Acceleration(acceleration)];
        for [first, second] in [blends, [blends[1], blends[0]]] {
            let points = [LfpbPoint::near(0.0, 40.0, first), LfpbPoint::near(4.0, 120.0, second)];
            let motion = Lfpb::new(&points, BlendEnds::Inside).unwrap();
            assert_all_near(motion.velocities(), &[velocity]);
            assert_all_near(motion.blend_times(), &[blend; 2]);
            assert_all_near(motion.accelerations(), &[acceleration, -acceleration]);
        }
    }
    // 20°/s² at both ends leave no line: twice the mean velocity.
    let least = Lfpb::with_accelerations(&[0.0, 4.0], &[40.0, 120.0], &[20.0; 2], BlendEnds::Inside).unwrap();
    assert_all_near(least.velocities(), &[40.0]);
    assert_eq!(least.pieces().len(), 2);
}

#[test]
fn a_point_that_must_be_met_lies_on_a_line_between_pseudo_via_points() {
    let blend = Blend::Duration(0.5);
    let mut points: Vec<LfpbPoint> =
        TIMES.into_iter().zip(X).map(|(t, x)| LfpbPoint::near(t, x, blend)).collect();
    points[1] = LfpbPoint::met(2.0, 0.0, blend, 0.4);
    let motion = Lfpb::new(&points, BlendEnds::Inside).unwrap();
    assert_eq!(
        motion.places(),
        [Place::Point(1), Place::Before(2), Place::After(2), Place::Point(3), Place::Point(4)]
    );
    // The rule of signs: the mean of 4/2 and 3/2.
    assert_near(motion.velocities()[1], 1.75);
    for (t, q) in [(2.0, 0.0), (1.9, -0.175), (2.1, 0.175)] {
        let [position, velocity, acceleration, _] = motion.eval(t);
        assert_all_near(&[position, velocity, acceleration], &[q, 1.75, 0.0]);
    }
    assert_near(motion.misses()[1], 0.0);
    assert!(motion.misses()[2].abs() > 0.01, "the next point is still passed near");

    points[1].met = Some(Met { bracket: 0.4, velocity: Some(3.0) });
    let motion = Lfpb::new(&points, BlendEnds::Inside).unwrap();
    assert_all_near(&motion.eval(2.0)[..3], &[0.0, 3.0, 0.0]);

    // Where the slopes differ in sign the joint rests at the point.
    points[1] = LfpbPoint::met(2.0, 9.0, blend, 0.4);
    let motion = Lfpb::new(&points, BlendEnds::Inside).unwrap();
    assert_all_near(&motion.eval(2.0)[..3], &[9.0, 0.0, 0.0]);
}

#[test]
fn points_that_cannot_be_met_say_why() {
    let blend = Blend::Duration(0.5);
    let error = |change: &dyn Fn(&mut Vec<LfpbPoint>)| {
        let mut points: Vec<LfpbPoint> =
            TIMES.into_iter().zip(X).map(|(t, x)| LfpbPoint::near(t, x, blend)).collect();
        change(&mut points);
        Lfpb::new(&points, BlendEnds::Inside).unwrap_err().to_string()
    };
    let meet = |point: &mut LfpbPoint, bracket| point.met = Some(Met { bracket, velocity: None });
    assert_eq!(
        error(&|points| meet(&mut points[0], 0.1)),
        "point 1: an end cannot lie between pseudo via points; it is met as it is when the blends of the ends \
         lie inside"
    );
    assert_eq!(
        error(&|points| meet(&mut points[2], 2.5)),
        "point 3: bracket 2.5 s must be less than 2 s, or its pseudo via point passes point 2"
    );
    assert_eq!(
        error(&|points| {
            meet(&mut points[1], 1.5);
            meet(&mut points[2], 0.5);
        }),
        "point 3: bracket 0.5 s must be less than 0.5 s, or its pseudo via point passes the pseudo via point \
         after point 2"
    );
    assert_eq!(
        error(&|points| meet(&mut points[1], f64::NAN)),
        "point 2: bracket NaN must be a positive finite number"
    );
    assert_eq!(
        error(&|points| points[1].met = Some(Met { bracket: 0.5, velocity: Some(f64::INFINITY) })),
        "point 2: velocity inf must be finite"
    );
    // Blends of 0.5 s about pseudo via points 0.4 s apart.
    assert_eq!(
        error(&|points| meet(&mut points[1], 0.125)),
        "segment from the pseudo via point before point 2 to the pseudo via point after point 2: its blends \
         take 0.5 s of the 0.25 s from 1.875 s to 2.125 s, 0.25 s too much; no change of one blend alone would \
         do: give the segment more time"
    );
}

/// Blends that both fit between the pseudo via points, one of them beyond the middle, where the point is.
#[test]
fn a_blend_that_bends_the_line_at_the_point_is_too_long() {
    let end = |time, position| LfpbPoint::near(time, position, Blend::Duration(0.2));
    let points = |acceleration| {
        let met = LfpbPoint::met(2.0, 1.0, Blend::Acceleration(acceleration), 0.3);
        [end(0.0, 0.0), met, end(4.0, 1.0)]
    };
    let error = Lfpb::new(&points(0.55), BlendEnds::Inside).unwrap_err();
    let LfpbError::BlendsOverlap { remedies, .. } = &error else { panic!("{error}") };
    let Some(Remedy { blend: Blend::Acceleration(least), .. }) = remedies.first() else { panic!("{error}") };
    let motion = Lfpb::new(&points(*least), BlendEnds::Inside).unwrap();
    assert!((motion.eval(2.0)[0] - 1.0).abs() < 1e-12);
}

#[test]
fn an_acceleration_that_is_too_small_says_the_least_that_would_do() {
    let points = |first: Blend, second: Blend| {
        let point = |(k, &(t, q, blend)): (usize, &(f64, f64, Blend))| {
            assert!(k < 3);
            LfpbPoint::near(t, q, blend)
        };
        let end = Blend::Duration(0.2);
        [(0.0, 0.0, first), (2.0, 3.0, second), (4.0, 3.0, end)]
            .iter()
            .enumerate()
            .map(point)
            .collect::<Vec<_>>()
    };
    // No root: 2·3/2² = 1.5 would make a blend of the whole segment, of which the next takes 0.25 s.
    let slow = points(Blend::Acceleration(1.2), Blend::Duration(0.5));
    let error = Lfpb::new(&slow, BlendEnds::Inside).unwrap_err();
    let LfpbError::AccelerationTooSmall { place: Place::Point(1), remedies, .. } = &error else {
        panic!("{error}")
    };
    let [Remedy { place: Place::Point(1), blend: Blend::Acceleration(least) }] = remedies[..] else {
        panic!("{error}")
    };
    assert_near(least, 6.0 / (4.0 - 0.25 * 0.25));
    assert_eq!(
        error.to_string(),
        format!(
            "point 1: acceleration 1.2 is too small for a distance of 3 in 2 s; raise the acceleration at \
             point 1 to at least {least}"
        )
    );
    // An inner blend that reaches beyond the point after it: Δv = 3/1.9, 2 s less 0.2 s on either side.
    let weak = points(Blend::Duration(0.2), Blend::Acceleration(0.4));
    let error = Lfpb::new(&weak, BlendEnds::Inside).unwrap_err();
    let LfpbError::BlendsOverlap { from: Place::Point(1), needed, available, remedies, .. } = &error else {
        panic!("{error}")
    };
    assert_all_near(&[*needed, *available], &[0.2 + 0.5 * (3.0 / 1.9) / 0.4, 2.0]);
    let [first, second] = remedies[..] else { panic!("{error}") };
    assert_eq!((first.place, second.place), (Place::Point(1), Place::Point(2)));
    let Blend::Acceleration(least) = second.blend else { panic!("{second:?}") };
    assert_near(least, (3.0 / 1.9) / 3.6);
}

#[test]
fn numbers_that_are_none_are_named() {
    let of = |accelerations: [f64; 2]| {
        Lfpb::with_accelerations(&[0.0, 1.0], &[1.0, 2.0], &accelerations, BlendEnds::Inside).unwrap_err()
    };
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = of([9.0, bad]);
        assert!(
            matches!(error, LfpbError::NotPositive { point: 2, quantity: "blend acceleration", .. }),
            "{error}"
        );
    }
    let error = of([1e20, 9.0]);
    assert!(matches!(error, LfpbError::BlendTooShort { place: Place::Point(1), .. }), "{error}");
}

#[test]
fn points_on_one_line_need_no_blend_between_them() {
    // In thirds, so that slopes differ by rounding.
    let times: Vec<f64> = (0..7).map(|k| f64::from(k) / 3.0).collect();
    let positions: Vec<f64> = (0..7).map(|k| 0.1 * f64::from(k)).collect();
    let motion =
        Lfpb::with_accelerations(&times[1..], &positions[1..], &[5.0; 6], BlendEnds::Centred).unwrap();
    assert!(motion.blend_times()[1..5].iter().all(|&blend| blend == 0.0), "{:?}", motion.blend_times());
    let motion = LfpbMotion::new(vec![motion]).unwrap();
    assert_eq!(motion.trajectory().breaks().len(), 2, "one after the first blend, one before the last");
}

#[test]
fn a_coordinate_that_rests_or_moves_by_1e_12_is_a_motion() {
    for distance in [0.0, 1e-12, 1e-17] {
        let positions = [0.5, 0.5 + distance, 0.5];
        for ends in [BlendEnds::Inside, BlendEnds::Centred] {
            let motion = Lfpb::with_accelerations(&[0.0, 1.0, 2.0], &positions, &[1.0; 3], ends).unwrap();
            assert!((motion.eval(1.0)[0] - 0.5).abs() < 2e-12);
            assert!(LfpbMotion::new(vec![motion]).unwrap().trajectory().breaks().is_empty());
        }
    }
}

/// Points 2 s to 4 s apart, with blends that fit; inner ones may have to be met.
fn any_points() -> impl Strategy<Value = Vec<LfpbPoint>> {
    let blend = prop_oneof![
        (0.01..0.3_f64).prop_map(Blend::Duration),
        (50.0..200.0_f64).prop_map(Blend::Acceleration),
    ];
    let met = prop::option::of((0.2..0.45_f64, prop::option::of(-3.0..3.0_f64)));
    let point = (2.0..4.0_f64, -3.0..3.0_f64, blend, met);
    (-5.0..5.0_f64, prop::collection::vec(point, 2..7)).prop_map(|(start, points)| {
        let mut time = start;
        let last = points.len() - 1;
        let one = |(k, (duration, position, blend, met))| {
            time += duration;
            let met = if k == 0 || k == last { None } else { met };
            let met = met.map(|(bracket, velocity)| Met { bracket, velocity });
            LfpbPoint { time, position, blend, met }
        };
        points.into_iter().enumerate().map(one).collect()
    })
}

/// The same points with blends that need not fit.
fn any_tight_points() -> impl Strategy<Value = Vec<LfpbPoint>> {
    let blend =
        prop_oneof![(0.1..4.0_f64).prop_map(Blend::Duration), (0.1..6.0_f64).prop_map(Blend::Acceleration),];
    (any_points(), prop::collection::vec(blend, 7)).prop_map(|(points, blends)| {
        points.into_iter().zip(blends).map(|(point, blend)| LfpbPoint { blend, ..point }).collect()
    })
}

fn any_ends() -> impl Strategy<Value = BlendEnds> {
    prop_oneof![Just(BlendEnds::Inside), Just(BlendEnds::Centred)]
}

proptest! {
    #[test]
    fn every_point_is_missed_by_exactly_what_is_stated(points in any_points(), ends in any_ends()) {
        let motion = Lfpb::new(&points, ends).unwrap();
        let last = points.len() - 1;
        for (k, point) in points.iter().enumerate() {
            let found = motion.eval(point.time)[0] - point.position;
            prop_assert!((found - motion.misses()[k]).abs() < 1e-9, "point {}: {found}", k + 1);
            let is_end_inside = ends == BlendEnds::Inside && (k == 0 || k == last);
            if point.met.is_some() || is_end_inside {
                prop_assert_eq!(motion.misses()[k].to_bits(), 0.0_f64.to_bits());
            }
            if let Some(Met { velocity: Some(velocity), .. }) = point.met {
                prop_assert!((motion.eval(point.time)[1] - velocity).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn lines_and_blends_are_what_was_given(points in any_points(), ends in any_ends()) {
        let motion = Lfpb::new(&points, ends).unwrap();
        for (k, place) in motion.places().iter().enumerate() {
            let (Place::Point(number) | Place::Before(number) | Place::After(number)) = *place;
            match points[number - 1].blend {
                Blend::Duration(duration) => prop_assert!((motion.blend_times()[k] - duration).abs() < 1e-12),
                Blend::Acceleration(magnitude) if motion.blend_times()[k] > 1e-6 => {
                    let found = motion.accelerations()[k].abs();
                    prop_assert!((found - magnitude).abs() < 1e-6 * magnitude, "{found} is not {magnitude}");
                }
                Blend::Acceleration(_) => {}
            }
        }
        let trajectory = LfpbMotion::new(vec![motion.clone()]).unwrap();
        let continuity = trajectory.trajectory().continuity();
        prop_assert!(continuity.class >= ContinuityClass::C1, "{:?}", continuity.jumps);
        // From rest to rest, at the first and the last point when the ends lie inside.
        let [start, end] = [motion.start(), motion.end()].map(|t| motion.eval(t));
        prop_assert!(start[1].abs() < 1e-12 && end[1].abs() < 1e-9);
        prop_assert!((start[0] - points[0].position).abs() < 1e-12);
        prop_assert!((end[0] - points[points.len() - 1].position).abs() < 1e-9);
        let outside = if ends == BlendEnds::Centred { 0.5 } else { 0.0 };
        let blends = motion.blend_times();
        prop_assert!((motion.start() - points[0].time + outside * blends[0]).abs() < 1e-12);
        prop_assert!((motion.end() - points[points.len() - 1].time - outside * blends[blends.len() - 1]).abs() < 1e-12);
    }

    #[test]
    fn a_remedy_does_and_a_thousandth_less_does_not(points in any_tight_points(), ends in any_ends()) {
        let Err(error) = Lfpb::new(&points, ends) else { return Ok(()) };
        let (LfpbError::BlendsOverlap { remedies, .. } | LfpbError::AccelerationTooSmall { remedies, .. }) = &error
        else {
            panic!("{error}")
        };
        // Where it fails: places of the segment, or the end whose acceleration is too small.
        let failing = |error: &LfpbError| match error {
            LfpbError::BlendsOverlap { from, to, .. } => Some((*from, *to)),
            LfpbError::AccelerationTooSmall { place, .. } => Some((*place, *place)),
            _ => None,
        };
        for remedy in remedies {
            // The blend of a pseudo via point is that of its point, whose other blend changes with it.
            let Place::Point(number) = remedy.place else { continue };
            let with = |share: f64| {
                let mut changed = points.clone();
                changed[number - 1].blend = match remedy.blend {
                    Blend::Duration(longest) => Blend::Duration(longest / share),
                    Blend::Acceleration(least) => Blend::Acceleration(least * share),
                };
                Lfpb::new(&changed, ends)
            };
            // Something else may be too much, too.
            let after = with(1.0);
            prop_assert_ne!(after.as_ref().err().and_then(failing), failing(&error), "{}: {:?}", remedy, after);
            prop_assert!(with(0.999).is_err(), "{} is not the least: {:?}", remedy, error);
        }
    }

    #[test]
    fn backwards_and_later_it_is_the_same_motion(
        points in any_points(),
        ends in any_ends(),
        shift in -50.0..50.0_f64,
    ) {
        let motion = Lfpb::new(&points, ends).unwrap();
        let later: Vec<_> = points.iter().map(|p| LfpbPoint { time: p.time + shift, ..*p }).collect();
        let later = Lfpb::new(&later, ends).unwrap();
        let backwards: Vec<_> = points
            .iter()
            .rev()
            .map(|p| {
                let met = p.met.map(|met| Met { velocity: met.velocity.map(|v| -v), ..met });
                LfpbPoint { time: -p.time, met, ..*p }
            })
            .collect();
        let backwards = Lfpb::new(&backwards, ends).unwrap();
        for k in 0..=40 {
            let t = motion.start() + (motion.end() - motion.start()) * (f64::from(k) + 0.37) / 41.0;
            let [q, qd, ..] = motion.eval(t);
            let [later_q, later_qd, ..] = later.eval(t + shift);
            let [back_q, back_qd, ..] = backwards.eval(-t);
            prop_assert!((q - later_q).abs() < 1e-9 && (qd - later_qd).abs() < 1e-6);
            prop_assert!((q - back_q).abs() < 1e-9 && (qd + back_qd).abs() < 1e-6);
        }
    }

    #[test]
    fn several_coordinates_move_as_each_does_alone(
        points in any_points(),
        others in prop::collection::vec((-3.0..3.0_f64, 0.01..0.3_f64), 7),
        ends in any_ends(),
    ) {
        let second: Vec<LfpbPoint> = points
            .iter()
            .zip(others)
            .map(|(p, (position, blend))| LfpbPoint::near(p.time, position, Blend::Duration(blend)))
            .collect();
        let alone = [&points, &second].map(|points| Lfpb::new(points, ends).unwrap());
        let motion = LfpbMotion::new(alone.to_vec()).unwrap();
        prop_assert!(motion.trajectory().continuity().class >= ContinuityClass::C1);
        for k in 0..=60 {
            let t = motion.trajectory().duration() * (f64::from(k) + 0.21) / 61.0;
            let state = motion.trajectory().eval(t);
            for (joint, coordinate) in alone.iter().enumerate() {
                // At rest before its own start and after its own end.
                let own = (t + motion.start()).clamp(coordinate.start(), coordinate.end());
                prop_assert!((state.q[joint] - coordinate.eval(own)[0]).abs() < 1e-9);
                let rests = own.to_bits() != (t + motion.start()).to_bits();
                let velocity = if rests { 0.0 } else { coordinate.eval(own)[1] };
                prop_assert!((state.qd[joint] - velocity).abs() < 1e-6, "at {t} s");
            }
        }
    }
}
