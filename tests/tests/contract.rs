//! What every release keeps: the same scenario gives the same bytes, and a log alone gives the same verdict.

#![expect(
    clippy::unwrap_used,
    clippy::panic,
    reason = "helpers of tests: a run that ends early fails the test"
)]

use std::{path::Path, thread};

use graspcheck::{Run, Silent, load, run_scenario};
use graspcheck_recording::{from_bytes, to_bytes};
use graspcheck_verify::{Evidence, Outcome, RESOLVED_JSON, Verdict, judge};

/// One scenario of each arm, and one that must fail.
const SCENARIOS: [&str; 3] =
    ["scara/pick_cube.toml", "rrr/pedestal_to_pedestal.toml", "negative/planned_collision.toml"];

fn run(scenario: &str) -> Run {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios").join(scenario);
    let scenario = load(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    run_scenario(&scenario, &mut Silent).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn log_of(scenario: &str) -> Vec<u8> {
    to_bytes(&run(scenario).recording).unwrap()
}

#[test]
fn the_same_scenario_gives_the_same_bytes_on_any_number_of_threads() {
    for scenario in SCENARIOS {
        let alone = log_of(scenario);
        let [one, other] = thread::scope(|scope| {
            [scope.spawn(|| log_of(scenario)), scope.spawn(|| log_of(scenario))]
                .map(|run| run.join().unwrap())
        });
        assert!(alone == one && one == other, "{scenario}: the bytes of three runs differ");
    }
}

#[test]
fn a_log_alone_gives_the_verdict_that_it_carries() {
    for scenario in SCENARIOS {
        let run = run(scenario);
        let recording = from_bytes(&to_bytes(&run.recording).unwrap()).unwrap();
        assert_eq!(recording, run.recording, "{scenario}: the log does not come back");
        let judged = judge(&Evidence::from_recording(&recording).unwrap());
        assert_eq!(judged, run.verdict, "{scenario}");
        let carried = Verdict::from_json(recording.verdict.as_deref().unwrap()).unwrap();
        assert_eq!(carried, judged, "{scenario}: the log carries another verdict");
    }
}

#[test]
fn a_log_whose_limits_were_changed_gives_another_verdict() {
    let mut recording = run(SCENARIOS[0]).recording;
    let document = recording.attachments.iter_mut().find(|document| document.name == RESOLVED_JSON).unwrap();
    let mut resolved: graspcheck_verify::Resolved = serde_json::from_slice(&document.data).unwrap();
    for joint in &mut resolved.robot.joints {
        joint.limits.velocity *= 0.1;
    }
    document.data = serde_json::to_vec(&resolved).unwrap();
    let verdict = judge(&Evidence::from_recording(&recording).unwrap());
    assert_eq!(verdict.outcome, Outcome::Fail);
    let failed: Vec<&str> = verdict.failed().map(|result| result.check.as_str()).collect();
    assert_eq!(failed, ["planned.velocity", "executed.velocity"]);
}
