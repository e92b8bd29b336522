//! How long planning a move of four joints from rest to rest takes, beside rsruckig in the same run.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use graspcheck_model::{
    robot::JointLimits,
    task::{Sync, TimeLaw},
};
use graspcheck_motion::MotionState;
use graspcheck_planner::{
    joint_law::{JointLaw, RateLimits},
    joint_move::{Pacing, joint_move_by},
};
use rsruckig::prelude::{
    DataArrayOrVec, InputParameter, Ruckig, Synchronization, ThrowErrorHandler, Trajectory,
};

const FROM: [f64; 4] = [-0.3, 1.3, -0.1, 7.0];
const TO: [f64; 4] = [0.9, -0.4, -0.25, 4.0];

const LIMITS: [RateLimits; 4] = [
    RateLimits { velocity: 7.5, acceleration: 60.0, jerk: 3000.0 },
    RateLimits { velocity: 10.0, acceleration: 100.0, jerk: 5000.0 },
    RateLimits { velocity: 1.0, acceleration: 15.0, jerk: 1000.0 },
    RateLimits { velocity: 20.0, acceleration: 200.0, jerk: 15_000.0 },
];

fn joint_limits() -> [JointLimits; 4] {
    LIMITS.map(|RateLimits { velocity, acceleration, jerk }| JointLimits {
        position_min: -99.0,
        position_max: 99.0,
        velocity,
        acceleration,
        jerk,
        effort: 1.0,
    })
}

fn ruckig_input(synchronization: Synchronization) -> InputParameter<4> {
    let of = |values: [f64; 4]| DataArrayOrVec::Stack(values);
    let mut input = InputParameter::<4>::new(None);
    input.synchronization = synchronization;
    input.current_position = of(FROM);
    input.target_position = of(TO);
    input.max_velocity = of(LIMITS.map(|limits| limits.velocity));
    input.max_acceleration = of(LIMITS.map(|limits| limits.acceleration));
    input.max_jerk = of(LIMITS.map(|limits| limits.jerk));
    input
}

fn four_joints(criterion: &mut Criterion) {
    let limits = joint_limits();
    for (name, sync, theirs) in [
        ("straight", Sync::Straight, Synchronization::Phase),
        ("matched ends", Sync::EndTimes, Synchronization::Time),
    ] {
        let pacing = Pacing { law: TimeLaw::SCurve, sync, ..Pacing::default() };
        criterion.bench_function(&format!("plan 4 joints, {name}"), |bencher| {
            bencher
                .iter(|| joint_move_by(black_box(&FROM), black_box(&TO), &limits, pacing).expect("a move"));
        });
        let input = ruckig_input(theirs);
        let mut found = Trajectory::<4>::new(None);
        let mut generator = Ruckig::<4, ThrowErrorHandler>::new(None, 0.001);
        criterion.bench_function(&format!("plan 4 joints, {name}, rsruckig"), |bencher| {
            bencher.iter(|| generator.calculate(black_box(&input), &mut found).expect("a move"));
        });
    }
}

fn four_laws(criterion: &mut Criterion) {
    criterion.bench_function("4 laws, no trajectory", |bencher| {
        bencher.iter(|| {
            for joint in 0..4 {
                let ends = [FROM, TO].map(|q| [black_box(q[joint]), 0.0]);
                black_box(JointLaw::s_curve(ends[0], ends[1], LIMITS[joint]).expect("a law"));
            }
        });
    });
    criterion.bench_function("1 law between moving ends", |bencher| {
        let limits = RateLimits { velocity: 10.0, acceleration: 10.0, jerk: 30.0 };
        bencher.iter(|| JointLaw::s_curve([0.0, black_box(7.0)], [10.0, 0.0], limits).expect("a law"));
    });
    let (start, end) = ([0.0, 6.0, 2.0], [10.0, 1.0, -3.0]);
    let limits = RateLimits { velocity: 10.0, acceleration: 10.0, jerk: 30.0 };
    criterion.bench_function("1 law between accelerating ends", |bencher| {
        bencher.iter(|| JointLaw::fastest(black_box(start), end, limits).expect("a law"));
    });
    criterion.bench_function("1 law of exact duration between accelerating ends", |bencher| {
        bencher.iter(|| JointLaw::lasting(black_box(start), end, limits, 3.0).expect("a law"));
    });
}

fn evaluation(criterion: &mut Criterion) {
    let motion = joint_move_by(&FROM, &TO, &joint_limits(), Pacing::default()).expect("a move");
    let mut state = MotionState::zeros(4);
    let t = 0.4 * motion.duration();
    criterion.bench_function("eval 4 joints", |bencher| {
        bencher.iter(|| {
            motion.eval_into(black_box(t), &mut state);
            black_box(&state);
        });
    });
    let input = ruckig_input(Synchronization::Phase);
    let mut found = Trajectory::<4>::new(None);
    Ruckig::<4, ThrowErrorHandler>::new(None, 0.001).calculate(&input, &mut found).expect("a move");
    let zeros = || DataArrayOrVec::Stack([0.0; 4]);
    let (mut q, mut qd, mut qdd, mut qddd) = (zeros(), zeros(), zeros(), zeros());
    criterion.bench_function("eval 4 joints, rsruckig", |bencher| {
        bencher.iter(|| {
            found.at_time(
                black_box(t),
                &mut Some(&mut q),
                &mut Some(&mut qd),
                &mut Some(&mut qdd),
                &mut Some(&mut qddd),
                &mut None,
            );
            black_box((&q, &qd, &qdd, &qddd));
        });
    });
}

criterion_group!(benches, four_joints, four_laws, evaluation);
criterion_main!(benches);
