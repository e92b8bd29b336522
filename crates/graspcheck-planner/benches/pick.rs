//! How long planning takes: a full pick with its proof, a pick that no candidate clears, via points, a line.

#[path = "../tests/robots/mod.rs"]
mod robots;

use criterion::{Criterion, criterion_group, criterion_main};
use graspcheck_model::task::Task;
use graspcheck_planner::{find, line};
use robots::{bench_with_wall, cell, pace, pose, rrr, rrr_pick, scara, scara_pick};

fn picks(criterion: &mut Criterion) {
    let (object, task) = scara_pick();
    let task = Task::PickAndPlace(task);
    let (robot, pace) = (scara(), pace(0.9));
    let bench = bench_with_wall();
    criterion.bench_function("scara pick over a wall", |b| {
        b.iter(|| find(&robot, &bench, Some(&object), &task, &pace).expect("a plan"));
    });
    let blocked = cell(0.002, &[("wall", [0.6, 0.02, 0.5], [0.5, 0.0, 0.25])]);
    criterion.bench_function("scara pick that nothing clears", |b| {
        b.iter(|| find(&robot, &blocked, Some(&object), &task, &pace).expect("a plan"));
    });
    let (object, task) = rrr_pick(0.4);
    let task = Task::PickAndPlace(task);
    let robot = rrr();
    let empty = cell(0.02, &[]);
    criterion.bench_function("rrr pick in the plane", |b| {
        b.iter(|| find(&robot, &empty, Some(&object), &task, &pace).expect("a plan"));
    });
}

fn lines(criterion: &mut Criterion) {
    let robot = scara();
    let from = [-0.3, 1.3, -0.1, 7.0];
    let goal = pose([0.0, 0.1, 0.0], [0.0; 3]) * robot.world_from_tool(&from);
    criterion.bench_function("scara line of 0.1 m", |b| {
        b.iter(|| line(&robot, &from, &goal, 0.9, None).expect("a line"));
    });
}

criterion_group!(benches, picks, lines);
criterion_main!(benches);
