//! The main job: a pick of four seconds, planned, proved, simulated at 1 kHz, judged and recorded.

use std::{hint::black_box, path::Path};

use criterion::{Criterion, criterion_group, criterion_main};
use graspcheck::{Scenario, Silent, load, run_scenario, store};
use graspcheck_model::plan::Plan;
use graspcheck_proof::Scene;

fn scenario() -> Scenario {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/scara/pick_cube.toml");
    load(&path).expect("the scenario is valid")
}

fn plan(scenario: &Scenario) -> Plan {
    let resolved = &scenario.resolved;
    let object = resolved.object.as_ref();
    graspcheck_planner::plan(&resolved.robot, &resolved.cell, object, &resolved.task, &resolved.pace)
        .expect("the pick can be planned")
}

fn pick(criterion: &mut Criterion) {
    let scenario = scenario();
    let resolved = &scenario.resolved;
    let scene = Scene::new(&resolved.robot, &resolved.cell, resolved.object.as_ref()).expect("it is a scene");
    let planned = plan(&scenario);
    let run = run_scenario(&scenario, &mut Silent).expect("the scenario runs");
    let root = Path::new(env!("CARGO_TARGET_TMPDIR")).join("bench");

    let mut group = criterion.benchmark_group("pick_cube");
    group.sample_size(10);
    group.bench_function("plan and prove all candidates", |bencher| {
        bencher.iter(|| plan(black_box(&scenario)));
    });
    group.bench_function("prove clearance of the plan", |bencher| {
        bencher.iter(|| scene.certify(black_box(&planned)));
    });
    group.bench_function("plan, prove, simulate, judge", |bencher| {
        bencher.iter(|| run_scenario(black_box(&scenario), &mut Silent).expect("the scenario runs"));
    });
    group.bench_function("write the log", |bencher| {
        bencher
            .iter(|| graspcheck_recording::to_bytes(black_box(&run.recording)).expect("it can be written"));
    });
    group.bench_function("whole job with all files", |bencher| {
        bencher.iter(|| {
            let run = run_scenario(black_box(&scenario), &mut Silent).expect("the scenario runs");
            store::store(&run.recording, "bench::pick_cube", &root).expect("it can be written")
        });
    });
    group.finish();
}

criterion_group!(benches, pick);
criterion_main!(benches);
