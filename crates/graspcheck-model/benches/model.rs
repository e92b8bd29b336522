//! How long kinematics and dynamics take. Goals on one core: inverse kinematics with all branches under
//! 300 ns, inverse dynamics of the SCARA under 400 ns.

#[path = "../tests/arms/mod.rs"]
mod arms;

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use graspcheck_model::{Pose, dynamics::Dynamics, inverse::InverseKinematics, task::Elbow};
use nalgebra::Vector3;

fn kinematics(criterion: &mut Criterion) {
    let (robot, q) = (arms::scara(), [0.3, 0.9, -0.1, 2.0]);
    let pose = robot.world_from_tool(&q);
    let inverse = InverseKinematics::new(&robot).expect("a SCARA");
    let mut links = [Pose::identity(); 4];
    criterion.bench_function("scara_forward_all_links", |bencher| {
        bencher.iter(|| robot.forward_into(black_box(&q), &mut links));
    });
    criterion.bench_function("scara_inverse_all_branches_and_turns", |bencher| {
        bencher.iter(|| inverse.solve(black_box(&pose)));
    });
    criterion.bench_function("scara_inverse_one_branch", |bencher| {
        let mut found = [0.0; 4];
        bencher.iter(|| inverse.solve_near(black_box(&pose), Elbow::Left, &q, &mut found));
    });
    criterion.bench_function("scara_inverse_measured_each_time", |bencher| {
        bencher.iter(|| robot.inverse(black_box(&pose)));
    });
    let (planar, q) = (arms::rrr(), [0.3, 0.9, 0.4]);
    let pose = planar.world_from_tool(&q);
    let inverse = InverseKinematics::new(&planar).expect("a planar arm");
    criterion.bench_function("rrr_inverse_all_branches_and_turns", |bencher| {
        bencher.iter(|| inverse.solve(black_box(&pose)));
    });
    criterion.bench_function("rrr_tool_jacobian", |bencher| {
        bencher.iter(|| planar.tool_jacobian(black_box(&q)));
    });
}

fn dynamics(criterion: &mut Criterion) {
    let gravity = Vector3::new(0.0, 0.0, -9.81);
    let mut scara = Dynamics::new(&arms::scara(), gravity);
    let (q, qd, qdd) = ([0.3, 0.9, -0.1, 2.0], [1.0, -2.0, 0.3, 4.0], [5.0, 6.0, -7.0, 8.0]);
    let mut tau = [0.0; 4];
    criterion.bench_function("scara_inverse_dynamics", |bencher| {
        bencher.iter(|| scara.inverse(black_box(&q), black_box(&qd), black_box(&qdd), &mut tau));
    });
    criterion.bench_function("scara_mass_matrix", |bencher| {
        bencher.iter(|| scara.mass_matrix(black_box(&q)));
    });
}

criterion_group!(benches, kinematics, dynamics);
criterion_main!(benches);
