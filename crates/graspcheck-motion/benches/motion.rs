//! How long the operations of a control or proof step take: evaluation of four joints, exact peaks and a
//! Bernstein proof of one piece of one joint.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use graspcheck_motion::{Interval, MotionBounds, MotionState, Polynomial, Trajectory, bernstein};

/// A general quintic of one second: no root at an end.
fn general() -> Polynomial {
    Polynomial::quintic_hermite([0.1, 0.4, -1.5], [1.3, -0.2, 2.0], 1.0)
}

fn rest_to_rest() -> Polynomial {
    Polynomial::quintic_hermite([0.1, 0.0, 0.0], [1.3, 0.0, 0.0], 1.0)
}

/// Six pieces of four joints.
fn motion() -> Trajectory {
    let knots = (0..=6).map(|k| f64::from(k) * 0.5).collect();
    let pieces = (0..24).map(|i| if i % 2 == 0 { general() } else { rest_to_rest() }).collect();
    Trajectory::new(4, knots, pieces).expect("six intervals of four joints")
}

fn evaluation(criterion: &mut Criterion) {
    let motion = motion();
    let mut state = MotionState::zeros(4);
    criterion.bench_function("eval 4 joints", |bencher| {
        bencher.iter(|| {
            motion.eval_into(black_box(1.234), &mut state);
            black_box(&state);
        });
    });
}

fn peaks(criterion: &mut Criterion) {
    for (name, polynomial) in [("general", general()), ("rest to rest", rest_to_rest())] {
        criterion.bench_function(&format!("peaks v a j, {name} quintic"), |bencher| {
            bencher.iter(|| black_box(black_box(&polynomial).rate_ranges(0.0, black_box(1.0))));
        });
        criterion.bench_function(&format!("position range, {name} quintic"), |bencher| {
            bencher.iter(|| black_box(black_box(&polynomial).range(0, 0.0, black_box(1.0))));
        });
    }
}

fn proofs(criterion: &mut Criterion) {
    let polynomial = general();
    for (name, share) in [("5 % room", 1.05), ("0.1 % room", 1.001)] {
        let limits = [1, 2, 3].map(|order| {
            let [low, high] = polynomial.range(order, 0.0, 1.0);
            share * high.value.max(-low.value)
        });
        criterion.bench_function(&format!("Bernstein proof v a j, {name}"), |bencher| {
            bencher.iter(|| {
                for (limit, order) in limits.into_iter().zip(1..) {
                    let polynomial = black_box(&polynomial);
                    black_box(bernstein::proves_within(polynomial, order, black_box(1.0), -limit, limit));
                }
            });
        });
    }
}

fn enclosures(criterion: &mut Criterion) {
    let polynomial = general();
    criterion.bench_function("enclosure of q v a j over a stretch", |bencher| {
        bencher.iter(|| black_box(&polynomial).enclose(black_box(0.3), black_box(0.35)));
    });
    let (motion, mut bounds) = (motion(), MotionBounds::zeros(4));
    criterion.bench_function("enclosure of 4 joints", |bencher| {
        bencher.iter(|| {
            motion.enclose_into(black_box(1.2), black_box(1.25), &mut bounds);
            black_box(&bounds);
        });
    });
    let (x, y) = (Interval::between(0.3, 0.4), Interval::between(-0.1, 0.2));
    criterion.bench_function("interval product and sum", |bencher| {
        bencher.iter(|| black_box(x) * black_box(y) + black_box(x));
    });
    criterion.bench_function("interval sine and cosine", |bencher| bencher.iter(|| black_box(x).sin_cos()));
}

criterion_group!(benches, evaluation, peaks, proofs, enclosures);
criterion_main!(benches);
