//! What every release keeps: the same scenario gives the same bytes, and a log alone gives the same verdict.

#![expect(
    clippy::unwrap_used,
    clippy::panic,
    reason = "helpers of tests: a run that ends early fails the test"
)]

use std::{path::Path, thread};

use graspcheck::{Run, Silent, load, run_scenario};
use graspcheck_proof::Scene;
use graspcheck_recording::{JointSeries, PoseSeries, Recording, from_bytes, to_bytes};
use graspcheck_verify::{
    CERTIFICATE_JSON, Evidence, Expectation, Outcome, PLAN_JSON, RESOLVED_JSON, Verdict, judge,
};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};

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

/// What the recording says after it was written and read again.
fn reviewed(recording: &Recording) -> Verdict {
    judge(&Evidence::from_recording(&from_bytes(&to_bytes(recording).unwrap()).unwrap()).unwrap())
}

/// A recording with one of its JSON documents edited.
fn edited(recording: &Recording, name: &str, edit: impl FnOnce(&mut serde_json::Value)) -> Recording {
    let mut recording = recording.clone();
    let document = recording.attachments.iter_mut().find(|document| document.name == name).unwrap();
    let mut content = serde_json::from_slice(&document.data).unwrap();
    edit(&mut content);
    document.data = serde_json::to_vec(&content).unwrap();
    recording
}

fn add(number: &mut serde_json::Value, difference: f64) {
    *number = (number.as_f64().unwrap() + difference).into();
}

fn failed(verdict: &Verdict) -> Vec<&str> {
    verdict.failed().map(|result| result.check.as_str()).collect()
}

#[test]
fn a_proof_that_was_edited_fails_and_nothing_else_does() {
    let recording = run(SCENARIOS[0]).recording;
    let edits: [fn(&mut serde_json::Value); 4] = [
        |certificate| add(&mut certificate["pairs"][3]["leaves"][0]["gap"], 1e-6),
        |certificate| add(&mut certificate["duration"], 1e-3),
        |certificate| certificate["pairs"][0]["a"] = "another".into(),
        |certificate| drop(certificate["pairs"].as_array_mut().unwrap().pop()),
    ];
    for (index, edit) in edits.into_iter().enumerate() {
        let verdict = reviewed(&edited(&recording, CERTIFICATE_JSON, edit));
        assert_eq!(failed(&verdict), ["planned.certificate"], "edit {index}");
    }
}

#[test]
fn a_plan_that_was_edited_is_not_the_one_that_was_proved_and_executed() {
    let recording = run(SCENARIOS[0]).recording;
    // The quill 5 mm lower, all the time.
    let verdict = reviewed(&edited(&recording, PLAN_JSON, |plan| {
        for piece in plan["trajectory"]["coefficients"].as_array_mut().unwrap() {
            let quill = &mut piece[2];
            add(&mut quill[0], -0.005);
        }
    }));
    let failed = failed(&verdict);
    for check in ["planned.certificate", "executed.tracking"] {
        assert!(failed.contains(&check), "{failed:?}");
    }
    // A phase that begins 10 ms later: another instant from which contact is allowed.
    let verdict = reviewed(&edited(&recording, PLAN_JSON, |plan| {
        add(&mut plan["phases"][1]["end"], 0.01);
        add(&mut plan["phases"][2]["start"], 0.01);
    }));
    assert!(verdict.failed().any(|result| result.check == "planned.certificate"));
}

/// What is said of an edited stream, and how it is edited.
type Edit = (&'static str, fn(&mut Recording));

/// A channel of the execution, how a log loses it, and the checks that read it.
type Loss = (&'static str, fn(&mut Recording), &'static [&'static str]);

/// A check reads the measured states also to know that the run went on.
const LOSSES: [Loss; 7] = [
    (
        "measured",
        |log| log.measured = JointSeries::new(std::mem::take(&mut log.measured.names)),
        &["position", "velocity", "opening", "contacts", "grip", "clearance", "tube", "consistency"],
    ),
    (
        "reference",
        |log| log.reference = JointSeries::new(std::mem::take(&mut log.reference.names)),
        &["torque", "saturation", "stability", "consistency"],
    ),
    ("tool", |log| log.tool = without_rows(&log.tool), &["tracking", "slip", "consistency"]),
    ("reference_tool", |log| log.reference_tool = without_rows(&log.reference_tool), &["consistency"]),
    (
        "object",
        |log| log.object = without_rows(&log.object),
        &["grip", "slip", "place", "place_angle", "rest", "clearance", "tube", "consistency"],
    ),
    ("contacts", |log| log.contacts.clear(), &["contacts", "grip", "consistency"]),
    ("monitor", |log| log.monitor.clear(), &["contacts", "grip", "consistency"]),
];

fn without_rows(series: &PoseSeries) -> PoseSeries {
    PoseSeries { frame: series.frame.clone(), child: series.child.clone(), ..PoseSeries::default() }
}

#[test]
fn a_log_that_lost_a_channel_is_undecided_wherever_that_channel_is_read() {
    let run = run(SCENARIOS[0]);
    for (channel, lose, readers) in LOSSES {
        let mut log = run.recording.clone();
        lose(&mut log);
        let verdict = reviewed(&log);
        for (result, complete) in verdict.checks.iter().zip(&run.verdict.checks) {
            let reads = result.check.strip_prefix("executed.").is_some_and(|word| readers.contains(&word));
            if reads {
                assert_eq!(result.outcome, Outcome::Inconclusive, "{channel}: {}", result.check);
            } else {
                assert_eq!(result, complete, "{channel}");
            }
        }
        assert!(!verdict.as_expected, "{channel}");
    }
    let read: Vec<&str> = LOSSES.iter().flat_map(|(.., readers)| readers.iter().copied()).collect();
    for result in run.verdict.checks.iter().filter(|result| result.outcome == Outcome::Pass) {
        let Some(word) = result.check.strip_prefix("executed.") else { continue };
        assert!(read.contains(&word), "{}: no channel is lost that it reads", result.check);
    }
}

/// Whoever wants a log to tell another story edits a stream; another one then contradicts it.
#[test]
fn a_stream_that_was_edited_contradicts_another() {
    let recording = run(SCENARIOS[0]).recording;
    assert!(!failed(&reviewed(&recording)).contains(&"executed.consistency"));
    let edits: [Edit; 10] = [
        ("a peak torque is lowered", |log| {
            for effort in &mut log.reference.effort {
                *effort = effort.clamp(-40.0, 40.0);
            }
        }),
        ("a peak velocity is lowered", |log| {
            for velocity in &mut log.measured.velocity {
                *velocity = velocity.clamp(-0.1, 0.1);
            }
        }),
        ("the tool is where it should be", |log| log.tool.pose = log.reference_tool.pose.clone()),
        ("so are the joints", |log| log.measured.position = log.reference.position.clone()),
        ("the object is put a millimetre aside", |log| {
            for pose in &mut log.object.pose {
                pose[0] += 1e-3;
            }
        }),
        ("the object does not slip from 2.5 s on", |log| {
            let row = log.object.time_ns.partition_point(|ns| *ns < 2_500_000_000);
            log.object.pose[row][2] += 3e-4;
        }),
        ("the object rests at the end", |log| {
            let last = log.object.pose.len() - 1;
            log.object.pose[last][0] += 1e-3;
        }),
        ("the object slips back slowly", |log| {
            let first = log.object.time_ns.partition_point(|ns| *ns < 3_000_000_000);
            for (step, pose) in log.object.pose[first..].iter_mut().enumerate() {
                pose[0] += 9e-5 * (step.min(100) as f64);
            }
        }),
        ("a contact is lighter", |log| {
            for contact in &mut log.contacts {
                contact.normal_force_n *= 0.5;
            }
        }),
        ("the plan was another", |log| {
            for position in &mut log.reference.position {
                *position += 1e-5;
            }
        }),
    ];
    for (story, edit) in edits {
        let mut log = recording.clone();
        edit(&mut log);
        let verdict = reviewed(&log);
        assert!(failed(&verdict).contains(&"executed.consistency"), "{story}: {:?}", failed(&verdict));
    }
}

/// The proof says what sampling cannot see, and never the contrary of what it can.
#[test]
fn no_sample_of_an_executed_motion_is_nearer_than_its_proved_clearance() {
    let mut scenarios = Vec::new();
    for suite in ["scara", "rrr", "worked_examples"] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios").join(suite);
        let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|file| file.unwrap().path()).collect();
        files.sort();
        scenarios.extend(files.into_iter().filter(|file| file.extension().is_some_and(|end| end == "toml")));
    }
    let mut count = 0;
    for path in scenarios {
        let scenario = load(&path).unwrap();
        let resolved = &scenario.resolved;
        if resolved.execution.is_none() || resolved.expect != Expectation::Pass {
            continue;
        }
        let run = run_scenario(&scenario, &mut Silent).unwrap();
        let log = &run.recording;
        let result = run.verdict.checks.iter().find(|result| result.check == "executed.clearance").unwrap();
        let proved = result.margin.unwrap();
        let scene = Scene::new(&resolved.robot, &resolved.cell, resolved.object.as_ref()).unwrap();
        let mut sampler = scene.sampler(&run.plan).unwrap();
        let dof = resolved.robot.joints.len();
        let mut least = f64::INFINITY;
        for row in 0..log.measured.len() {
            let (arm, fingers) = log.measured.position_row(row).split_at(dof);
            let time = (log.measured.time_ns[row] as f64 / 1e9).min(run.plan.duration());
            let object = log.object.pose.get(row).map(|[x, y, z, qx, qy, qz, qw]| {
                let rotation = UnitQuaternion::from_quaternion(Quaternion::new(*qw, *qx, *qy, *qz));
                Isometry3::from_parts(Translation3::new(*x, *y, *z), rotation)
            });
            let margin = sampler.margin(time, arm, fingers.iter().sum(), object.as_ref());
            least = least.min(margin.unwrap_or(f64::INFINITY));
        }
        // The sampler rounds down by a micrometre at most.
        assert!(least + 1e-6 >= proved, "{}: sampled {least}, proved {proved}", path.display());
        assert!(least - proved < 1.2e-3, "{}: sampled {least}, proved only {proved}", path.display());
        count += 1;
    }
    assert!(count > 5, "only {count} scenarios were looked at");
}
