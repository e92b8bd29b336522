//! How long it takes to prove that a rest-to-rest move of 1 s keeps its torque limits, and its tool the speed and
//! acceleration that are allowed, when the limits are 1.1 times what is reached.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use graspcheck_model::{example, plan::Plan, robot::RobotModel};
use graspcheck_proof::{TORQUE_TOLERANCE, TorqueLimits, keep_torque_limits, torque_peaks};
use nalgebra::Vector3;

#[path = "../src/fixtures.rs"]
#[expect(dead_code, reason = "the tests need more robots and cells than this bench")]
mod fixtures;

/// An arm, its gravity in the base frame, and a move of 1 s.
fn moves() -> [(&'static str, RobotModel, Vector3<f64>, Plan); 3] {
    let (down, along) = (Vector3::new(0.0, 0.0, -9.81), Vector3::new(0.0, -9.81, 0.0));
    let scara = fixtures::rest_to_rest(&[-0.3, 0.4, 0.0, 0.0], &[0.8, 2.1, -0.05, 3.0], 1.0);
    let planar = fixtures::rest_to_rest(&[0.2, 0.5, -0.4], &[1.2, -0.6, 0.5], 1.0);
    let six =
        fixtures::rest_to_rest(&[0.3, -0.4, 0.8, 0.2, -0.5, 0.4], &[-0.7, 0.5, 0.1, 1.2, 0.6, -1.0], 1.0);
    [
        ("scara", fixtures::scara(), down, scara),
        ("planar rrr", example::planar(), along, planar),
        ("six axes", fixtures::six_axes(), down, six),
    ]
}

fn torques(criterion: &mut Criterion) {
    for (name, mut robot, gravity, plan) in moves() {
        // Every joint's limit is 1.1 times its own peak.
        for peak in torque_peaks(&robot, gravity, None, &plan, 1e-6).expect("the plan fits") {
            robot.joints[peak.joint].limits.effort = 1.1 * peak.upper;
        }
        let kept = keep_torque_limits(&robot, gravity, None, &plan, 1.0);
        assert_eq!(kept, Ok(TorqueLimits::Kept));
        criterion.bench_function(&format!("{name}: torque limits kept, 1.1 of the peak"), |bencher| {
            bencher.iter(|| keep_torque_limits(black_box(&robot), gravity, None, black_box(&plan), 1.0));
        });
        criterion.bench_function(&format!("{name}: torque limits broken, 0.9 of the peak"), |bencher| {
            bencher
                .iter(|| keep_torque_limits(black_box(&robot), gravity, None, black_box(&plan), 0.9 / 1.1));
        });
        criterion.bench_function(
            &format!("{name}: torque peaks to {TORQUE_TOLERANCE} of the limit"),
            |bencher| {
                bencher.iter(|| {
                    torque_peaks(black_box(&robot), gravity, None, black_box(&plan), TORQUE_TOLERANCE)
                });
            },
        );
    }
}

criterion_group!(benches, torques);
criterion_main!(benches);
