//! Checking proofs beside finding them: the search for a certificate, its validation, and with the documents
//! decoded from JSON.

use std::{hint::black_box, path::Path};

use criterion::{Criterion, criterion_group, criterion_main};
use graspcheck::{Silent, limit_proofs, load, run_scenario};
use graspcheck_checker::Documents;
use graspcheck_proof::Scene;

fn checker(criterion: &mut Criterion) {
    for name in ["scara/pick_cube.toml", "rrr/pedestal_to_pedestal.toml"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios").join(name);
        let mut scenario = load(&path).expect("the scenario is valid");
        scenario.resolved.execution = None;
        let run = run_scenario(&scenario, &mut Silent).expect("the scenario runs");
        let resolved = &scenario.resolved;
        let scene =
            Scene::new(&resolved.robot, &resolved.cell, resolved.object.as_ref()).expect("it is a scene");
        let documents = Documents::read(&run.recording).expect("the log is whole");
        let report = documents.check();
        assert!(report.is_confirmed(), "{:?}", report.findings);

        let label = format!("{name}, {} pairs, {} leaves", report.pairs, report.leaves);
        let mut group = criterion.benchmark_group(label);
        group.bench_function("search for the certificate", |bencher| {
            bencher.iter(|| scene.certify(black_box(&run.plan)));
        });
        group.bench_function("validate certificate and limits", |bencher| {
            bencher.iter(|| black_box(&documents).check());
        });
        group.bench_function("decode and validate", |bencher| {
            bencher.iter(|| graspcheck_checker::check(black_box(&run.recording)).expect("the log is whole"));
        });
        group.bench_function("find the proofs of limits", |bencher| {
            bencher.iter(|| limit_proofs::of(black_box(resolved), &run.plan));
        });
        group.finish();
    }
}

criterion_group!(benches, checker);
criterion_main!(benches);
