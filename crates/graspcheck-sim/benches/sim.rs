//! Steps per second: a SCARA that moves freely, and one that holds a cube between its fingers.
//!
//! Both simulate one second at 1 kHz with four substeps, recorded in full: a time of 100 ms is 10,000 steps
//! per second. Building the plant and its self-test are part of it.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};

#[expect(dead_code, reason = "the tests use what the bench does not")]
#[path = "../src/fixtures.rs"]
mod fixtures;

fn benches(criterion: &mut Criterion) {
    let execution = fixtures::execution();
    let robot = fixtures::scara();
    let cell = fixtures::empty_cell(fixtures::GRAVITY);
    let plan = fixtures::move_plan(&[0.0, 0.0, -0.05, 0.0], &[(0.8, vec![1.1, 1.7, -0.25, 3.0])]);
    criterion.bench_function("1001 steps, contact-free", |bencher| {
        bencher.iter(|| {
            let run = graspcheck_sim::simulate(&robot, &cell, None, &plan, &execution, &mut |_, _| {});
            black_box(run).expect("the plan is valid")
        });
    });

    let lift = fixtures::lift(10.0);
    criterion.bench_function("2701 steps, in grasp", |bencher| {
        bencher.iter(|| {
            let run = graspcheck_sim::simulate(
                &lift.robot,
                &lift.cell,
                Some(&lift.object),
                &lift.plan,
                &execution,
                &mut |_, _| {},
            );
            black_box(run).expect("the plan is valid")
        });
    });
}

criterion_group!(sim, benches);
criterion_main!(sim);
