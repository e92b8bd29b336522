//! Steps per second: a SCARA that moves freely, and one that holds a cube between its fingers.
//!
//! Runs at 1 kHz, recorded in full; a run of 2701 steps in 270 ms is 10,000 steps per second. Building the
//! plant and its self-test are part of it.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use graspcheck_model::execution::Execution;

#[expect(dead_code, reason = "the tests use what the bench does not")]
#[path = "../src/fixtures.rs"]
mod fixtures;

fn benches(criterion: &mut Criterion) {
    let execution = fixtures::execution();
    let robot = fixtures::scara();
    let cell = fixtures::empty_cell(fixtures::GRAVITY);
    let plan = fixtures::move_plan(&[0.0, 0.0, -0.05, 0.0], &[(0.8, vec![1.1, 1.7, -0.25, 3.0])]);
    criterion.bench_function("1001 steps, contact-free, 4 substeps", |bencher| {
        bencher.iter(|| {
            let run = graspcheck_sim::simulate(&robot, &cell, None, &plan, &execution, &mut |_, _| {});
            black_box(run).expect("the plan is valid")
        });
    });

    let lift = fixtures::lift(10.0);
    for substeps in [2, 4] {
        let execution = Execution { substeps, ..execution.clone() };
        criterion.bench_function(&format!("2701 steps, in grasp, {substeps} substeps"), |bencher| {
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
}

criterion_group!(sim, benches);
criterion_main!(sim);
