//! How long proofs of clearance take: a 1 s SCARA move among seven obstacles.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use graspcheck_model::{Pose, plan::Plan, shape::Shape};
use graspcheck_proof::Scene;
use nalgebra::Vector3;

#[path = "../src/fixtures.rs"]
mod fixtures;

/// Four bodies of the arm and two fingers among seven obstacles.
fn scara_scene() -> (Scene, Plan) {
    let mut draw = fixtures::Draw(7);
    let mut bodies = vec![("table", fixtures::boxed(1.0, 1.0, 0.05), fixtures::at(0.0, 0.0, -0.05))];
    for name in ["bin", "wall", "camera", "feeder", "fixture"] {
        let angle = draw.between(-0.4, 2.9);
        let radius = draw.between(0.65, 0.8);
        let turn = Pose::new(
            Vector3::new(radius * angle.cos(), radius * angle.sin(), draw.between(0.02, 0.3)),
            Vector3::z() * draw.between(0.0, 3.0),
        );
        bodies.push((name, fixtures::boxed(0.05, 0.04, 0.1), turn));
    }
    bodies.push(("post", Shape::Cylinder { radius: 0.02, half_length: 0.05 }, fixtures::at(0.2, 0.4, 0.05)));
    let cell = fixtures::cell(0.002, bodies);
    let plan = fixtures::rest_to_rest(&[-0.3, 0.4, 0.0, 0.0], &[0.8, 2.1, -0.05, 3.0], 1.0);
    let scene = Scene::new(&fixtures::scara(), &cell, None).expect("the scene is well formed");
    (scene, plan)
}

fn proofs(criterion: &mut Criterion) {
    let (scene, plan) = scara_scene();
    let certificate = scene.certify(&plan);
    assert!(certificate.is_free(), "{:?}", certificate.violations().collect::<Vec<_>>());
    let label = format!("{} pairs, {} leaves", scene.pair_count(), certificate.leaf_count());
    criterion.bench_function(&format!("scara certify ({label})"), |bencher| {
        bencher.iter(|| black_box(&scene).certify(black_box(&plan)));
    });
    for tolerance in [1e-4, 1e-5, 1e-6] {
        criterion.bench_function(&format!("scara least margin to {tolerance} m"), |bencher| {
            bencher.iter(|| black_box(&scene).minimum_margin(black_box(&plan), tolerance));
        });
    }
    let mut sampler = scene.sampler(&plan).expect("the plan is complete");
    criterion.bench_function("scara sampled margin at one instant", |bencher| {
        bencher.iter(|| sampler.margin(0.3, black_box(&[0.1, 0.9, -0.01, 1.0]), 0.05, None));
    });
    criterion.bench_function("scara sampled margin at 1 kHz", |bencher| {
        bencher.iter(|| {
            (0..=1000)
                .filter_map(|ms| {
                    let t = f64::from(ms) / 1000.0;
                    sampler.margin(t, &plan.trajectory.eval(t).q, 0.05, None)
                })
                .fold(f64::INFINITY, f64::min)
        });
    });
}

criterion_group!(benches, proofs);
criterion_main!(benches);
