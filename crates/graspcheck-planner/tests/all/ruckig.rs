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
