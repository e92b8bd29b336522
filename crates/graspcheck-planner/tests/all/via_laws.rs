//! Motions through points in joint space: section 5 of the worked examples, and the laws of every law.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

use std::f64::consts::PI;

use graspcheck_motion::{ContinuityClass, Polynomial, Trajectory};
use graspcheck_planner::via::{
    ViaError, ViaPoints, computed, imposed,
    spline::{self, SplineEnd, SplineEnds},
    virtual_points::{self, EndState, VirtualPointSpline},
};
use proptest::prelude::*;

fn points(times: &[f64], positions: &[f64]) -> ViaPoints {
    ViaPoints::new(times.to_vec(), positions.iter().map(|&q| vec![q]).collect()).unwrap()
}

/// Points of via-2 to via-4b.
fn turning() -> ViaPoints {
    points(&[0.0, 2.0, 3.0, 5.0], &[0.0, 2.0 * PI, 0.5 * PI, PI])
}

fn assert_near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-9, "{found} is not {expected}");
}

/// Holds the pieces of the only joint against polynomials in absolute time.
fn assert_pieces(motion: &Trajectory, expected: &[[f64; 4]]) {
    assert_eq!(motion.piece_count(), expected.len());
    for (k, coefficients) in expected.iter().enumerate() {
        let local = Polynomial::new(*coefficients).shifted(motion.knots()[k]);
        for (found, expected) in motion.piece(k, 0).coefficients().iter().zip(local.coefficients()) {
            assert!((found - expected).abs() < 1e-9, "piece {k}: {found} is not {expected}");
        }
    }
}

#[test]
fn via_1_two_cubics_with_a_given_velocity_between_them() {
    let points = points(&[0.0, 5.0, 10.0], &[20.0, 80.0, 25.0]);
    let motion = imposed::through(&points, &[vec![0.0], vec![10.0], vec![0.0]]).unwrap();
    let second = Polynomial::new([80.0, 10.0, -10.6, 1.28]).shifted(-5.0);
    let second: [f64; 4] = std::array::from_fn(|k| second.coefficients()[k]);
    assert_pieces(&motion, &[[20.0, 0.0, 5.2, -0.56], second]);
}

#[test]
fn via_2_imposed_velocities() {
    let motion = imposed::through(&turning(), &[0.0, PI, -PI, 0.0].map(|v| vec![v])).unwrap();
    let expected =
        [[0.0, 0.0, 1.0, -0.25], [-46.0, 59.0, -23.5, 3.0], [26.0, -155.0 / 8.0, 19.0 / 4.0, -3.0 / 8.0]];
    assert_pieces(&motion, &expected.map(|piece| piece.map(|c| c * PI)));
}

#[test]
fn via_3_computed_velocities() {
    let motion = computed::through(&turning(), &[0.0], &[0.0]).unwrap();
    let expected =
        [[0.0, 0.0, 1.5, -0.5], [-40.0, 54.0, -22.5, 3.0], [29.0 / 4.0, -45.0 / 8.0, 1.5, -1.0 / 8.0]];
    assert_pieces(&motion, &expected.map(|piece| piece.map(|c| c * PI)));
}

/// Holds virtual positions, and velocity and acceleration at 2 s and 3 s, against multiples of π.
fn assert_virtual(times: [f64; 2], positions: [f64; 2], states: [[f64; 2]; 2]) -> VirtualPointSpline {
    let rest = EndState::at_rest(1);
    let spline = virtual_points::through(&turning(), &rest, &rest, times).unwrap();
    for (found, expected) in spline.virtual_positions.iter().zip(positions) {
        assert_near(found[0], expected * PI);
    }
    for (t, [velocity, acceleration]) in [2.0, 3.0].into_iter().zip(states) {
        let state = spline.trajectory.eval(t);
        assert_near(state.qd[0], velocity * PI);
        assert_near(state.qdd[0], acceleration * PI);
    }
    let [start, end] = [0.0, 5.0].map(|t| spline.trajectory.eval(t));
    for value in [start.q[0], start.qd[0], start.qdd[0], end.q[0] - PI, end.qd[0], end.qdd[0]] {
        assert_near(value, 0.0);
    }
    assert_eq!(spline.trajectory.continuity().class, ContinuityClass::C2);
    spline
}

#[test]
fn via_4_continuous_acceleration_from_rest_to_rest() {
    let spline = assert_virtual(
        [0.5, 4.5],
        [1441.0 / 10400.0, 9709.0 / 10400.0],
        [[-141.0 / 325.0, -1629.0 / 325.0], [-366.0 / 325.0, 1179.0 / 325.0]],
    );
    let first = spline.trajectory.piece(0, 0).coefficients();
    for (found, expected) in first.iter().zip([0.0, 0.0, 0.0, 1441.0 / 1300.0 * PI]) {
        assert_near(*found, expected);
    }
}

#[test]
fn via_4b_the_same_with_virtual_points_nearer_to_the_inner_ones() {
    assert_virtual(
        [1.5, 3.5],
        [2655.0 / 2464.0, 1591.0 / 2464.0],
        [[39.0 / 77.0, -729.0 / 77.0], [-60.0 / 77.0, 531.0 / 77.0]],
    );
}

#[test]
fn a_cubic_with_the_velocities_of_cubic_1_overshoots_both_ends() {
    let motion = imposed::through(&points(&[0.0, 1.0], &[10.0, 40.0]), &[vec![-50.0], vec![-50.0]]).unwrap();
    let [lowest, highest] = motion.position_range(0, 0.0, 1.0);
    assert!((lowest - 7.178_872).abs() < 1e-6 && (highest - 42.821_128).abs() < 1e-6);
}

#[test]
fn the_rule_of_signs_takes_a_mean_only_between_slopes_of_one_sign() {
    // Slopes 1, 3, 0, -1, -2, 4.
    let points = points(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0], &[0.0, 1.0, 4.0, 4.0, 3.0, 1.0, 5.0]);
    let velocities = computed::velocities(&points, &[0.5], &[0.25]).unwrap();
    let expected = [0.5, 2.0, 0.0, 0.0, -1.5, 0.0, 0.25];
    assert_eq!(velocities, expected.map(|v| vec![v]).to_vec());
}

#[test]
fn bad_input_is_named_by_every_law() {
    let points = turning();
    let message = |error: ViaError| error.to_string();
    assert_eq!(
        message(imposed::through(&points, &[vec![0.0]]).unwrap_err()),
        "1 velocities for 4 points; give one for each point"
    );
    assert_eq!(
        message(imposed::through(&points, &[vec![0.0], vec![0.0], vec![], vec![0.0]]).unwrap_err()),
        "point 3: 0 velocities for 1 joints; give one for each joint, and at least one"
    );
    assert_eq!(
        message(computed::through(&points, &[f64::NAN], &[0.0]).unwrap_err()),
        "start, joint 0: velocity NaN must be finite"
    );
    let bad_end =
        SplineEnds::Each { start: SplineEnd::Natural, end: SplineEnd::Acceleration(vec![f64::INFINITY]) };
    assert_eq!(
        message(spline::through(&points, &bad_end).unwrap_err()),
        "end, joint 0: acceleration inf must be finite"
    );
    assert!(matches!(
        spline::through(&points, &SplineEnds::Periodic),
        Err(ViaError::NotClosed { point: 4, joint: 0, difference, .. }) if (difference - PI).abs() < 1e-15
    ));
    let rest = EndState::at_rest(1);
    for (times, which) in [([0.0, 4.5], "first"), ([2.0, 4.5], "first"), ([0.5, 3.0], "second")] {
        let error = virtual_points::through(&points, &rest, &rest, times).unwrap_err();
        assert!(matches!(error, ViaError::VirtualTime { which: found, .. } if found == which), "{error}");
    }
    assert_eq!(
        message(virtual_points::through(&points, &rest, &rest, [0.5, f64::NAN]).unwrap_err()),
        "second virtual point: time NaN s must be later than 3 s and earlier than 5 s"
    );
    assert!(matches!(
        virtual_points::through(&points, &rest, &EndState::at_rest(2), [0.5, 4.5]),
        Err(ViaError::JointCount { count: 2, dof: 1, .. })
    ));
    let far = ViaPoints::new(vec![0.0, 1e-9], vec![vec![-1e305], vec![1e305]]).unwrap();
    assert!(matches!(imposed::through(&far, &[vec![0.0], vec![0.0]]), Err(ViaError::Trajectory(_))));
}

/// Two to eight points of two joints, from a time that is not 0.
fn any_points() -> impl Strategy<Value = ViaPoints> {
    let point = (0.2..2.0_f64, prop::array::uniform2(-3.0..3.0_f64));
    (-5.0..5.0_f64, prop::collection::vec(point, 2..8)).prop_map(|(start, points)| {
        let mut time = start;
        let (times, positions) = points
            .into_iter()
            .map(|(duration, positions)| {
                time += duration;
                (time, positions.to_vec())
            })
            .unzip();
        ViaPoints::new(times, positions).unwrap()
    })
}

fn any_pair() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(-2.0..2.0_f64, 2)
}

fn any_end() -> impl Strategy<Value = SplineEnd> {
    prop_oneof![
        any_pair().prop_map(SplineEnd::Velocity),
        any_pair().prop_map(SplineEnd::Acceleration),
        Just(SplineEnd::Natural),
        Just(SplineEnd::NotAKnot),
    ]
}

/// A law with its numbers.
#[derive(Clone, Debug)]
enum Law {
    Imposed(Vec<Vec<f64>>),
    Computed([Vec<f64>; 2]),
    Spline(SplineEnds),
    /// Shares of the first and of the last segment at which the virtual points lie.
    Virtual([EndState; 2], [f64; 2]),
}

fn any_law() -> impl Strategy<Value = Law> {
    let state = || (any_pair(), any_pair());
    prop_oneof![
        prop::collection::vec(any_pair(), 8).prop_map(Law::Imposed),
        [any_pair(), any_pair()].prop_map(Law::Computed),
        (any_end(), any_end()).prop_map(|(start, end)| Law::Spline(SplineEnds::Each { start, end })),
        Just(Law::Spline(SplineEnds::Periodic)),
        ([state(), state()], 0.2..0.45_f64, 0.55..0.8_f64).prop_map(|(states, first, second)| {
            let state = |(velocity, acceleration)| EndState { velocity, acceleration };
            Law::Virtual(states.map(state), [first, second])
        }),
    ]
}

impl Law {
    /// The points as the law can take them: a periodic motion ends where it began.
    fn points(&self, points: &ViaPoints) -> ViaPoints {
        let mut positions = points.positions().to_vec();
        if matches!(self, Self::Spline(SplineEnds::Periodic)) {
            let last = positions.len() - 1;
            positions[last] = positions[0].clone();
        }
        ViaPoints::new(points.times().to_vec(), positions).unwrap()
    }

    fn through(&self, points: &ViaPoints) -> Trajectory {
        let times = points.times();
        match self {
            Self::Imposed(velocities) => imposed::through(points, &velocities[..points.len()]),
            Self::Computed([start, end]) => computed::through(points, start, end),
            Self::Spline(ends) => spline::through(points, ends),
            Self::Virtual([start, end], [first, second]) => {
                let last = times.len() - 1;
                let virtual_times = [
                    times[0] + first * (times[1] - times[0]),
                    times[last - 1] + second * (times[last] - times[last - 1]),
                ];
                virtual_points::through(points, start, end, virtual_times).map(|spline| spline.trajectory)
            }
        }
        .unwrap()
    }

    /// The law for the same points run through backwards.
    fn reversed(&self, count: usize) -> Self {
        let minus = |values: &Vec<f64>| -> Vec<f64> { values.iter().map(|value| -value).collect() };
        let end = |end: &SplineEnd| match end {
            SplineEnd::Velocity(velocities) => SplineEnd::Velocity(minus(velocities)),
            other => other.clone(),
        };
        let state = |state: &EndState| EndState {
            velocity: minus(&state.velocity),
            acceleration: state.acceleration.clone(),
        };
        match self {
            Self::Imposed(velocities) => Self::Imposed(velocities[..count].iter().rev().map(minus).collect()),
            Self::Computed([first, last]) => Self::Computed([minus(last), minus(first)]),
            Self::Spline(SplineEnds::Periodic) => self.clone(),
            Self::Spline(SplineEnds::Each { start, end: last }) => {
                Self::Spline(SplineEnds::Each { start: end(last), end: end(start) })
            }
            Self::Virtual([start, last], [first, second]) => {
                Self::Virtual([state(last), state(start)], [1.0 - second, 1.0 - first])
            }
        }
    }
}

/// Whether two numbers are the same up to rounding of quantities of this size.
fn same(a: f64, b: f64, scale: f64) -> bool {
    (a - b).abs() < 1e-9 * scale.max(1.0)
}

fn assert_same_motion(a: &Trajectory, b: &Trajectory, time_in_b: impl Fn(f64) -> f64, reverse: bool) {
    for k in 0..=50 {
        // Between knots, where the limits from both sides are the same.
        let t = a.duration() * (f64::from(k) + 0.123) / 51.0;
        let (at_a, at_b) = (a.eval(t), b.eval(time_in_b(t)));
        let sign = if reverse { -1.0 } else { 1.0 };
        for joint in 0..a.dof() {
            let scale = a.peak(joint, 2).value.abs();
            assert!(same(at_a.q[joint], at_b.q[joint], scale), "position at {t}");
            assert!(same(at_a.qd[joint], sign * at_b.qd[joint], scale), "velocity at {t}");
            assert!(same(at_a.qdd[joint], at_b.qdd[joint], scale), "acceleration at {t}");
        }
    }
}

proptest! {
    #[test]
    fn points_are_met_and_derivatives_are_consistent(points in any_points(), law in any_law()) {
        let points = law.points(&points);
        let motion = law.through(&points);
        let start = points.times()[0];
        prop_assert!(same(motion.duration(), points.times()[points.len() - 1] - start, 1.0));
        for (&time, positions) in points.times().iter().zip(points.positions()) {
            let state = motion.eval((time - start).min(motion.duration()));
            for (found, expected) in state.q.iter().zip(positions) {
                prop_assert!(same(*found, *expected, 1.0), "{found} is not {expected} at {time} s");
            }
        }
        // Differences inside a piece are derivatives up to the third of a cubic, exactly central.
        for piece in 0..motion.piece_count() {
            let [from, to] = [motion.knots()[piece], motion.knots()[piece + 1]];
            let (middle, step) = (0.5 * (from + to), 0.25 * (to - from));
            let [before, at, after] = [middle - step, middle, middle + step].map(|t| motion.eval(t));
            for joint in 0..2 {
                let jerk = at.qddd[joint];
                let velocity = (after.q[joint] - before.q[joint]) / (2.0 * step) - jerk * step * step / 6.0;
                let scale = 1.0 + jerk.abs();
                prop_assert!(same(velocity, at.qd[joint], scale));
                prop_assert!(same((after.qd[joint] - before.qd[joint]) / (2.0 * step), at.qdd[joint], scale / step));
                prop_assert!(same((after.qdd[joint] - before.qdd[joint]) / (2.0 * step), jerk, scale / step));
            }
        }
    }

    #[test]
    fn continuity_is_as_constructed(points in any_points(), law in any_law()) {
        let motion = law.through(&law.points(&points));
        let continuity = motion.continuity();
        match law {
            Law::Imposed(_) | Law::Computed(_) => {
                prop_assert!(continuity.class >= ContinuityClass::C1);
                prop_assert!(continuity.jumps.iter().all(|jump| jump.order == 2));
            }
            Law::Spline(_) | Law::Virtual(..) => prop_assert_eq!(continuity.class, ContinuityClass::C2),
        }
    }

    #[test]
    fn end_conditions_hold(points in any_points(), law in any_law()) {
        let points = law.points(&points);
        let motion = law.through(&points);
        let [first, last] = [0.0, motion.duration()].map(|t| motion.eval(t));
        let all_same = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| same(*a, *b, 1e3));
        match &law {
            Law::Imposed(velocities) => {
                prop_assert!(all_same(&first.qd, &velocities[0]));
                prop_assert!(all_same(&last.qd, &velocities[points.len() - 1]));
            }
            Law::Computed([start, end]) => {
                prop_assert!(all_same(&first.qd, start) && all_same(&last.qd, end));
            }
            Law::Virtual([start, end], _) => {
                prop_assert_eq!((&first.qd, &first.qdd), (&start.velocity, &start.acceleration));
                prop_assert!(all_same(&last.qd, &end.velocity) && all_same(&last.qdd, &end.acceleration));
            }
            Law::Spline(SplineEnds::Periodic) => {
                prop_assert!(all_same(&first.qd, &last.qd) && all_same(&first.qdd, &last.qdd));
            }
            Law::Spline(SplineEnds::Each { start, end }) => {
                let pieces = motion.piece_count();
                let beside = [1, pieces.saturating_sub(2)].map(|k| motion.eval(motion.knots()[k]));
                for (end, at_end, inner) in [(start, &first, &beside[0]), (end, &last, &beside[1])] {
                    match end {
                        SplineEnd::Velocity(velocities) => prop_assert!(all_same(&at_end.qd, velocities)),
                        SplineEnd::Acceleration(values) => prop_assert!(all_same(&at_end.qdd, values)),
                        SplineEnd::Natural => prop_assert!(all_same(&at_end.qdd, &[0.0; 2])),
                        // The jerk does not step at the neighbour.
                        SplineEnd::NotAKnot if pieces > 1 => {
                            prop_assert!(all_same(&at_end.qddd, &inner.qddd));
                        }
                        SplineEnd::NotAKnot => {}
                    }
                }
            }
        }
    }

    #[test]
    fn a_shift_in_time_changes_nothing(points in any_points(), law in any_law(), shift in -100.0..100.0_f64) {
        let points = law.points(&points);
        let times = points.times().iter().map(|t| t + shift).collect();
        let later = ViaPoints::new(times, points.positions().to_vec()).unwrap();
        let (a, b) = (law.through(&points), law.through(&later));
        assert_same_motion(&a, &b, |t| t.min(b.duration()), false);
    }

    #[test]
    fn backwards_is_the_motion_of_the_reversed_points(points in any_points(), law in any_law()) {
        let points = law.points(&points);
        let times = points.times().iter().rev().map(|t| -t).collect();
        let positions = points.positions().iter().rev().cloned().collect();
        let reversed = ViaPoints::new(times, positions).unwrap();
        let (a, b) = (law.through(&points), law.reversed(points.len()).through(&reversed));
        assert_same_motion(&a, &b, |t| b.duration() - t, true);
    }

    /// Of all motions through the points the natural spline has the least mean square acceleration.
    #[test]
    fn the_natural_spline_bends_least(points in any_points(), law in any_law()) {
        let points = law.points(&points);
        let natural = spline::through(&points, &SplineEnds::both(SplineEnd::Natural)).unwrap();
        let other = law.through(&points);
        for joint in 0..2 {
            prop_assert!(bending(&natural, joint) <= bending(&other, joint) * (1.0 + 1e-9) + 1e-12);
        }
    }
}

/// The integral of the squared acceleration, which is linear on each piece.
fn bending(motion: &Trajectory, joint: usize) -> f64 {
    let of_piece = |k: usize| {
        let duration = motion.knots()[k + 1] - motion.knots()[k];
        let [a, b] = [0.0, duration].map(|tau| motion.piece(k, joint).eval(tau)[2]);
        duration * (a * a + a * b + b * b) / 3.0
    };
    (0..motion.piece_count()).map(of_piece).sum()
}
