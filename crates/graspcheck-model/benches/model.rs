//! How long kinematics and dynamics take. Goals on one core: inverse kinematics with all branches under
//! 300 ns, inverse dynamics of the SCARA under 400 ns.

#[path = "../tests/arms/mod.rs"]
mod arms;

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use graspcheck_model::{
    Pose,
    dynamics::{Dynamics, Workspace},
    inverse::InverseKinematics,
    numerical::NumericalInverse,
    task::Elbow,
    torque_bounds::TorqueBounds,
};
use graspcheck_motion::{Interval, Polynomial, Trajectory};
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
        bencher.iter(|| {
            inverse.visit(black_box(&pose), |name, q| {
                black_box((name, q));
            })
        });
    });
    criterion.bench_function("scara_inverse_collected", |bencher| {
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
        bencher.iter(|| {
            inverse.visit(black_box(&pose), |name, q| {
                black_box((name, q));
            })
        });
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

/// What a proof and a chain without closed form cost.
fn bounds(criterion: &mut Criterion) {
    let gravity = Vector3::new(0.0, 0.0, -9.81);
    let scara = Dynamics::new(&arms::scara(), gravity);
    let around = |x: f64| Interval::between(x - 0.01, x + 0.01);
    let (q, qd, qdd) = ([0.3, 0.9, -0.1, 2.0], [1.0, -2.0, 0.3, 4.0], [5.0, 6.0, -7.0, 8.0]);
    let (q, qd, qdd) = (q.map(around), qd.map(around), qdd.map(around));
    let (mut workspace, mut tau) = (Workspace::new(4), [Interval::ZERO; 4]);
    criterion.bench_function("scara_inverse_dynamics_of_intervals", |bencher| {
        bencher.iter(|| {
            scara.inverse_of(black_box(&q), black_box(&qd), black_box(&qdd), &mut workspace, &mut tau);
        });
    });
    let pieces =
        [1.0, -0.8, -0.1, 2.0].map(|end| Polynomial::quintic_hermite([0.0; 3], [end, 0.0, 0.0], 1.0));
    let motion = Trajectory::new(4, vec![0.0, 1.0], pieces.to_vec()).expect("one interval of four joints");
    let mut room = TorqueBounds::new(&scara, &motion);
    criterion.bench_function("scara_torque_bounds_over_a_stretch", |bencher| {
        bencher.iter(|| room.over(black_box(0.4), black_box(0.42))[0]);
    });
    let six = arms::six();
    let inverse = NumericalInverse::new(&six).expect("finite limits");
    let pose = six.world_from_tool(&[0.5, 0.3, 0.8, -0.4, 1.2, 0.4]);
    criterion.bench_function("six_joints_numerical_inverse", |bencher| {
        bencher.iter(|| inverse.solve(black_box(&pose), &[0.0; 6], 1));
    });
}

criterion_group!(benches, kinematics, dynamics, bounds);
criterion_main!(benches);
