//! Fastest laws against another implementation: rsruckig, a Rust port of Ruckig (Berscheid and Kröger,
//! *Jerk-limited Real-time Trajectory Generation with Arbitrary Target States*, 2021).
//!
//! Each test draws its cases from a fixed seed. The other one fails where the distance is 2A³/J², the largest that
//! is covered without a phase of constant acceleration, and takes moves below 1e-8 for none: there the closed form
//! takes its place.

use graspcheck_model::{
    robot::JointLimits,
    task::{Sync, TimeLaw},
};
use graspcheck_planner::{
    joint_law::{JointLaw, RateLimits},
    joint_move::{Pacing, joint_move_by},
    time_scaling::ScalingError,
};
use rsruckig::prelude::{DataArrayOrVec, InputParameter, Ruckig, ThrowErrorHandler, Trajectory};

/// Durations are equal when they differ by less than this share. Ruckig accepts a profile that misses its end by
/// 1e-8, which moves a duration by as much.
const SAME: f64 = 1e-8;

/// Seeded numbers (SplitMix64).
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in `[low, high)`.
    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.next() >> 11) as f64 / (1_u64 << 53) as f64)
    }

    /// Uniform in its logarithm.
    fn magnitude(&mut self, low: f64, high: f64) -> f64 {
        self.within(low.ln(), high.ln()).exp()
    }

    fn limits(&mut self) -> RateLimits {
        RateLimits {
            velocity: self.magnitude(0.1, 20.0),
            acceleration: self.magnitude(0.1, 100.0),
            jerk: self.magnitude(1.0, 5000.0),
        }
    }
}

/// The duration that the other implementation finds for joints with `[position, velocity]` at both ends.
fn ruckig<const N: usize>(start: [[f64; 2]; N], end: [[f64; 2]; N], limits: [RateLimits; N]) -> Option<f64> {
    let of = |values: [f64; N]| DataArrayOrVec::Stack(values);
    let mut input = InputParameter::<N>::new(None);
    input.current_position = of(start.map(|state| state[0]));
    input.current_velocity = of(start.map(|state| state[1]));
    input.target_position = of(end.map(|state| state[0]));
    input.target_velocity = of(end.map(|state| state[1]));
    input.max_velocity = of(limits.map(|limits| limits.velocity));
    input.max_acceleration = of(limits.map(|limits| limits.acceleration));
    input.max_jerk = of(limits.map(|limits| limits.jerk));
    let mut found = Trajectory::<N>::new(None);
    Ruckig::<N, ThrowErrorHandler>::new(None, 0.001).calculate(&input, &mut found).ok()?;
    Some(found.get_duration())
}

/// The fastest law from velocity to velocity by another way than the code under test: over a fine grid of peak
/// velocities of both signs, every crossing of the distance, refined by bisection.
fn least_by_search([q0, v0]: [f64; 2], [q1, v1]: [f64; 2], limits: RateLimits) -> f64 {
    let RateLimits { velocity, acceleration, jerk } = limits;
    let time = |change: f64| {
        let change = change.abs();
        if change * jerk >= acceleration * acceleration {
            change / acceleration + acceleration / jerk
        } else {
            2.0 * (change / jerk).sqrt()
        }
    };
    let missing =
        |peak: f64| q1 - q0 - 0.5 * (v0 + peak) * time(peak - v0) - 0.5 * (v1 + peak) * time(peak - v1);
    let mut least = f64::INFINITY;
    for peak in [velocity, -velocity] {
        let cruise = missing(peak) / peak;
        if cruise >= 0.0 {
            least = least.min(time(peak - v0) + cruise + time(peak - v1));
        }
    }
    let cells = 4000;
    let place = |i: i32| velocity * f64::from(i) / f64::from(cells);
    let mut edges: Vec<f64> = (-cells..=cells).map(place).chain([v0, v1]).collect();
    edges.sort_by(f64::total_cmp);
    for pair in edges.windows(2) {
        let [mut low, mut high] = [pair[0], pair[1]];
        // Between the ends' velocities a stop of the acceleration only costs time.
        if missing(low) * missing(high) > 0.0 || (low >= v0.min(v1) && high <= v0.max(v1)) {
            continue;
        }
        let sign = missing(low);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if missing(middle) * sign > 0.0 { low = middle } else { high = middle }
        }
        least = least.min(time(low - v0) + time(low - v1));
    }
    least
}

/// The duration that the other implementation finds for one joint between `[position, velocity, acceleration]`, at
/// least the given one.
fn ruckig_between(start: [f64; 3], end: [f64; 3], limits: RateLimits, at_least: Option<f64>) -> Option<f64> {
    let of = |value: f64| DataArrayOrVec::Stack([value]);
    let mut input = InputParameter::<1>::new(None);
    input.current_position = of(start[0]);
    input.current_velocity = of(start[1]);
    input.current_acceleration = of(start[2]);
    input.target_position = of(end[0]);
    input.target_velocity = of(end[1]);
    input.target_acceleration = of(end[2]);
    input.max_velocity = of(limits.velocity);
    input.max_acceleration = of(limits.acceleration);
    input.max_jerk = of(limits.jerk);
    input.minimum_duration = at_least;
    let mut found = Trajectory::<1>::new(None);
    Ruckig::<1, ThrowErrorHandler>::new(None, 0.001).calculate(&input, &mut found).ok()?;
    Some(found.get_duration())
}

/// Two states within limits, from which and to which the velocity keeps its limit.
fn states(draw: &mut Draw, limits: RateLimits) -> [[f64; 3]; 2] {
    let mut state = |position: f64, time: f64| loop {
        let v = limits.velocity * draw.within(-1.0, 1.0);
        let a = limits.acceleration * draw.within(-1.0, 1.0);
        let reached = v + time * 0.5 * a * a.abs() / limits.jerk;
        if reached.abs() < 0.999 * limits.velocity {
            return [position, v, a];
        }
    };
    let start = state(0.5, 1.0);
    let mut end = state(0.5, -1.0);
    end[0] += draw.within(-1.0, 1.0).signum() * draw.magnitude(1e-3, 10.0);
    [start, end]
}

/// Checks that a law begins and ends as asked, is smooth, and keeps its limits.
fn assert_sound(law: &JointLaw, start: [f64; 3], end: [f64; 3], limits: RateLimits, case: &str) {
    let RateLimits { velocity, acceleration, jerk } = limits;
    // Knots are rounded to the spacing of floats near the end.
    let knots = 8.0 * f64::EPSILON * law.duration();
    let scales = [1.0 + end[0].abs(), velocity, acceleration];
    let rounding = [
        1e-11 * scales[0] + knots * velocity,
        1e-11 * scales[1] + knots * acceleration,
        1e-11 * scales[2] + knots * jerk,
    ];
    for (asked, found) in [(start, law.start()), (end, law.end())] {
        for ((asked, found), rounding) in asked.iter().zip(found).zip(rounding) {
            assert!((asked - found).abs() <= rounding, "{case}: {found} is not {asked}: {law:?}");
        }
    }
    for (order, (limit, rounding)) in
        [(velocity, rounding[1]), (acceleration, rounding[2]), (jerk, 1e-9 * jerk)].into_iter().enumerate()
    {
        let [low, high] = law.range(order + 1);
        let most = limit + rounding;
        assert!(low.value >= -most && high.value <= most, "{case}: order {order}: {low:?} {high:?}: {law:?}");
    }
    let motion = law.trajectory().expect("a motion");
    assert!(motion.breaks().is_empty(), "{case}: {:?}: {law:?}", motion.breaks());
}

/// Holds a duration against that of the other implementation, which must have found one.
fn assert_same(ours: f64, theirs: Option<f64>, case: impl Fn() -> String) {
    let same = theirs.is_some_and(|theirs| (ours - theirs).abs() <= SAME * theirs.max(ours));
    assert!(same, "{}: {ours} s, ruckig {theirs:?}", case());
}

#[test]
fn rest_to_rest() {
    let mut draw = Draw(1);
    for case in 0..10_000 {
        let limits = draw.limits();
        let from = draw.within(-3.0, 3.0);
        let to = from + draw.within(-1.0, 1.0).signum() * draw.magnitude(1e-4, 10.0);
        let law = JointLaw::s_curve([from, 0.0], [to, 0.0], limits).expect("sound input");
        let theirs = ruckig([[from, 0.0]], [[to, 0.0]], [limits]);
        assert_same(law.duration(), theirs, || format!("case {case}: {limits:?} {from} {to}"));
    }
}

#[test]
fn between_moving_ends() {
    let mut draw = Draw(2);
    for case in 0..10_000 {
        let limits = draw.limits();
        let share = |draw: &mut Draw| limits.velocity * draw.within(-1.0, 1.0);
        let start = [draw.within(-3.0, 3.0), share(&mut draw)];
        let distance = draw.within(-1.0, 1.0).signum() * draw.magnitude(1e-3, 10.0);
        let end = [start[0] + distance, if case % 3 == 0 { 0.0 } else { share(&mut draw) }];
        let law = JointLaw::s_curve(start, end, limits).expect("sound input");
        let theirs = ruckig([start], [end], [limits]);
        let name = || format!("case {case}: {limits:?} {start:?} {end:?}");
        assert_same(law.duration(), theirs, name);
        if case < 1000 {
            let least = least_by_search(start, end, limits);
            assert!((law.duration() / least - 1.0).abs() < SAME, "{}: search {least}", name());
        }
        let [low, high] = law.range(1);
        let most = limits.velocity * (1.0 + 1e-12);
        assert!(low.value >= -most && high.value <= most, "{}: {low:?} {high:?}", name());
    }
}

#[test]
fn four_joints_with_matched_ends() {
    let mut draw = Draw(3);
    for case in 0..10_000 {
        let limits: [RateLimits; 4] = std::array::from_fn(|_| draw.limits());
        let from: [f64; 4] = std::array::from_fn(|_| draw.within(-3.0, 3.0));
        let to = from.map(|from| from + draw.within(-1.0, 1.0).signum() * draw.magnitude(1e-3, 10.0));
        let joints = limits.map(|RateLimits { velocity, acceleration, jerk }| JointLimits {
            position_min: -99.0,
            position_max: 99.0,
            velocity,
            acceleration,
            jerk,
            effort: 1.0,
        });
        let pacing = Pacing { law: TimeLaw::SCurve, sync: Sync::EndTimes, ..Pacing::default() };
        let motion = joint_move_by(&from, &to, &joints, pacing).expect("sound input");
        let at_rest = |q: [f64; 4]| q.map(|q| [q, 0.0]);
        let theirs = ruckig(at_rest(from), at_rest(to), limits);
        assert_same(motion.duration(), theirs, || format!("case {case}: {limits:?} {from:?} {to:?}"));
    }
}

#[test]
fn where_the_other_one_fails_the_closed_form_holds() {
    let mut draw = Draw(4);
    let mut failures = 0;
    for case in 0..10_000 {
        let RateLimits { acceleration, jerk, .. } = draw.limits();
        // The peak velocity is A²/J, which the limit allows.
        let velocity = acceleration * acceleration / jerk * draw.within(1.001, 3.0);
        let limits = RateLimits { velocity, acceleration, jerk };
        let distance = 2.0 * acceleration.powi(3) / (jerk * jerk);
        let law = JointLaw::s_curve([0.0, 0.0], [distance, 0.0], limits).expect("sound input");
        let expected = 4.0 * acceleration / jerk;
        assert!(
            (law.duration() / expected - 1.0).abs() < 1e-12,
            "case {case}: {limits:?}: {}",
            law.duration()
        );
        // It takes the shortest moves for none.
        match ruckig([[0.0, 0.0]], [[distance, 0.0]], [limits]).filter(|_| distance > 1e-8) {
            Some(theirs) => assert_same(law.duration(), Some(theirs), || format!("case {case}: {limits:?}")),
            None => failures += 1,
        }
    }
    assert!(failures > 0, "the other implementation has learned it: this exclusion can go");
}

#[test]
fn between_states_in_motion() {
    let mut draw = Draw(5);
    let (mut same, mut failures, mut slower) = (0, 0, 0);
    for case in 0..20_000 {
        let limits = draw.limits();
        let [start, mut end] = states(&mut draw, limits);
        if case % 4 == 0 {
            end = [end[0], 0.0, 0.0];
        }
        let name = format!("case {case}: {limits:?} {start:?} {end:?}");
        let law = JointLaw::fastest(start, end, limits).expect("sound input");
        assert_sound(&law, start, end, limits, &name);
        match ruckig_between(start, end, limits, None) {
            None => failures += 1,
            Some(theirs) if theirs > law.duration() * (1.0 + SAME) => slower += 1,
            // What the other one finds can be no faster: a law that is sound and as fast as any is the fastest.
            Some(theirs) => {
                assert!(
                    theirs >= law.duration() * (1.0 - SAME),
                    "{name}: {} s, ruckig {theirs} s",
                    law.duration()
                );
                same += 1;
            }
        }
    }
    assert!(same > 19_900, "{same} the same, {failures} failures, {slower} slower");
}

#[test]
fn exact_durations_between_states_in_motion() {
    let mut draw = Draw(6);
    let (mut same, mut failures, mut later, mut gaps) = (0, 0, 0, 0);
    for case in 0..20_000 {
        let limits = draw.limits();
        let [start, end] = states(&mut draw, limits);
        let possible = JointLaw::possible_durations(start, end, limits).expect("sound input");
        let fastest = JointLaw::fastest(start, end, limits).expect("sound input").duration();
        let name = format!("case {case}: {limits:?} {start:?} {end:?} {possible:?}");
        assert!((possible[0][0] / fastest - 1.0).abs() < SAME, "{name}: {fastest}");
        gaps += possible.len() - 1;
        let duration = fastest * draw.magnitude(1.0001, 5.0);
        let law = JointLaw::lasting(start, end, limits, duration);
        let expected = match &law {
            Ok(law) => {
                assert_sound(law, start, end, limits, &name);
                assert!(law.duration().to_bits() == duration.to_bits());
                duration
            }
            Err(ScalingError::DurationNotPossible { after, .. }) => *after,
            Err(other) => panic!("{name}: {other}"),
        };
        // What the error names can be met.
        let later_law = JointLaw::lasting(start, end, limits, expected * (1.0 + 1e-9));
        assert!(later_law.is_ok(), "{name}: {duration}: {later_law:?}");
        match ruckig_between(start, end, limits, Some(duration)) {
            None => failures += 1,
            Some(theirs) if theirs > expected * (1.0 + SAME) => later += 1,
            Some(theirs) => {
                assert!(
                    theirs >= expected * (1.0 - SAME),
                    "{name}: {duration}: {expected} s, ruckig {theirs} s"
                );
                same += 1;
            }
        }
    }
    assert!(same > 19_000 && gaps > 100, "{same} the same, {failures} failures, {later} later, {gaps} gaps");
}
