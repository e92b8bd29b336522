//! The checker confirms the certificates of real logs, and names what was changed in one.

#![expect(
    clippy::unwrap_used,
    clippy::panic,
    reason = "helpers of tests: a run that ends early fails the test"
)]

mod tampering;

use std::{path::Path, sync::OnceLock};

use graspcheck::{Scenario, Silent, load, run_scenario};
use graspcheck_checker::{CheckerError, Quantity, check};
use graspcheck_model::{Pose, cell::CellBody, shape::Shape};
use graspcheck_recording::{Recording, from_bytes, to_bytes};
use nalgebra::Vector3;
use serde_json::{Value, json};
use tampering::{
    CERTIFICATE, LIMITS, OF_THE_CROWDED_PICK, OF_THE_PICK, OF_THE_STEPPED_PLAN, PLAN, RESOLVED, Tampering,
    add, list, pair,
};

fn scenario(name: &str) -> Scenario {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios").join(name);
    let mut scenario = load(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    // Proofs are of the plan; nothing of the execution is in them.
    scenario.resolved.execution = None;
    scenario
}

/// The log of a scenario's plan, as its file holds it.
fn log(scenario: &Scenario) -> Recording {
    let run = run_scenario(scenario, &mut Silent).unwrap_or_else(|error| panic!("{error}"));
    from_bytes(&to_bytes(&run.recording).unwrap()).unwrap()
}

fn log_of(name: &str) -> Recording {
    log(&scenario(name))
}

fn pick() -> &'static Recording {
    static PICK: OnceLock<Recording> = OnceLock::new();
    PICK.get_or_init(|| log_of("scara/pick_cube.toml"))
}

fn collision() -> &'static Recording {
    static COLLISION: OnceLock<Recording> = OnceLock::new();
    COLLISION.get_or_init(|| log_of("negative/planned_collision.toml"))
}

/// A pick over a wall between forty posts: so many that most pairs are proved by sweeps.
fn crowded() -> &'static Recording {
    static CROWDED: OnceLock<Recording> = OnceLock::new();
    CROWDED.get_or_init(|| {
        let mut scenario = scenario("scara/pick_cube.toml");
        scenario.resolved.cell.bodies.extend((0..40).map(|i| {
            let angle = std::f64::consts::TAU * f64::from(i) / 40.0;
            let at = Vector3::new(1.1 * angle.cos(), 1.1 * angle.sin(), 0.2);
            let shape = Shape::Cylinder { radius: 0.02, half_length: 0.2 };
            CellBody { name: format!("post_{i}"), shape, world_from_shape: Pose::new(at, Vector3::zeros()) }
        }));
        log(&scenario)
    })
}

/// A plan with steps of acceleration.
fn stepped() -> &'static Recording {
    static STEPPED: OnceLock<Recording> = OnceLock::new();
    STEPPED.get_or_init(|| log_of("negative/trapezoid.toml"))
}

/// A recording with the bytes of one of its documents changed.
fn rewritten(recording: &Recording, name: &str, change: impl FnOnce(&mut Vec<u8>)) -> Recording {
    let mut recording = recording.clone();
    change(&mut recording.attachments.iter_mut().find(|document| document.name == name).unwrap().data);
    recording
}

/// A recording with one of its documents changed.
fn edited(recording: &Recording, name: &str, change: impl FnOnce(&mut Value)) -> Recording {
    rewritten(recording, name, |data| {
        let mut document = serde_json::from_slice(data).unwrap();
        change(&mut document);
        let changed = serde_json::to_vec(&document).unwrap();
        assert_ne!(serde_json::from_slice::<Value>(data).unwrap(), document, "{name}: nothing was changed");
        *data = changed;
    })
}

/// What is not as it should be after each tampering.
fn faults(original: &Recording, tamperings: &[Tampering]) -> Vec<String> {
    let fault = |(what, name, change, quantity, place): &Tampering| {
        let report = match check(&edited(original, name, change)) {
            Ok(report) => report,
            Err(error) => return Some(format!("{what}: {error}")),
        };
        let (place, others) = match place.strip_suffix('…') {
            Some(place) => (place.trim(), true),
            None => (*place, false),
        };
        let is_there = |finding: &&graspcheck_checker::Finding| {
            finding.place.to_string() == place || (others && place.is_empty())
        };
        let is_named = report.findings.iter().filter(is_there).any(|finding| finding.quantity == *quantity);
        let is_alone = others || report.findings.iter().all(|finding| is_there(&finding));
        let found: Vec<String> = report.findings.iter().take(6).map(ToString::to_string).collect();
        (!is_named || !is_alone || report.is_confirmed()).then(|| format!("{what}: {found:#?}"))
    };
    tamperings.iter().filter_map(fault).collect()
}

#[test]
fn every_tampering_is_named_with_its_place() {
    for (original, tamperings) in
        [(pick(), OF_THE_PICK), (stepped(), OF_THE_STEPPED_PLAN), (crowded(), OF_THE_CROWDED_PICK)]
    {
        let report = check(original).unwrap();
        assert!(report.is_confirmed(), "{:#?}", report.findings);
        let faults = faults(original, tamperings);
        assert!(faults.is_empty(), "{}", faults.join("\n"));
    }
}

#[test]
fn sweeps_stand_in_for_the_steps_of_pairs_that_are_far() {
    let report = check(crowded()).unwrap();
    let certificate: Value =
        serde_json::from_slice(&crowded().attachment(CERTIFICATE).unwrap().data).unwrap();
    let listed = certificate["pairs"].as_array().unwrap().len();
    assert!(report.sweeps > 0 && listed < report.pairs / 2, "{listed} of {} pairs are listed", report.pairs);
}

#[test]
fn all_limits_are_validated_and_efforts_are_counted_apart() {
    let report = check(pick()).unwrap();
    assert_eq!((report.limits, report.unchecked_limits), (4 * 5, 4));
    assert!(report.exceeded.is_empty());
    let exceeded = check(&log_of("negative/velocity_limit.toml")).unwrap().exceeded;
    assert!(exceeded.iter().any(|it| it.to_string() == "velocity of shoulder"), "{exceeded:?}");
}

#[test]
fn a_log_without_efforts_says_why() {
    let without = |reason: Value| {
        let limits = |limits: &mut Value| {
            list(limits, "limits").retain(|claim| claim["quantity"] != "effort");
            limits["effort_unproved"] = reason;
        };
        check(&edited(pick(), LIMITS, limits)).unwrap()
    };
    assert!(without(json!("the fingers differ in mass")).findings.is_empty());
    assert_eq!(without(Value::Null).findings.len(), 4);
}

/// A log that was written before limits were proved and sweeps made.
#[test]
fn an_older_log_is_read() {
    let mut older = edited(pick(), CERTIFICATE, |certificate| {
        certificate["schema"] = json!(1);
        let certificate = certificate.as_object_mut().unwrap();
        certificate.remove("pair_count");
        certificate.remove("sweeps");
    });
    older.attachments.retain(|document| document.name != LIMITS);
    let report = check(&older).unwrap();
    assert!(report.is_confirmed() && report.limits == 0, "{:?}", report.findings);
}

#[test]
fn a_step_over_a_change_of_what_is_required_is_found() {
    // The finger comes, closes and opens: each time something else is required, and a step that reaches over is
    // found whether its middle is before or after.
    for change in 0..3 {
        for first_ends in [true, false] {
            let straddling = edited(pick(), CERTIFICATE, |certificate| {
                let leaves = list(pair(certificate, "cube", "finger_left"), "leaves");
                let differs = |&i: &usize| leaves[i]["required"] != leaves[i - 1]["required"];
                let second = (1..leaves.len()).filter(differs).nth(change).unwrap();
                let removed = leaves.remove(if first_ends { second } else { second - 1 });
                let (kept, time) = if first_ends { (second - 1, "end") } else { (second - 1, "start") };
                leaves[kept][time] = removed[time].clone();
            });
            let findings = check(&straddling).unwrap().findings;
            let is_it = |finding: &graspcheck_checker::Finding| {
                finding.quantity == Quantity::Phase && finding.place.to_string() == "cube[0] - finger_left[0]"
            };
            assert!(findings.iter().any(is_it), "{findings:?}");
        }
    }
}

#[test]
fn the_order_of_pairs_says_nothing_and_what_is_undecided_is_not_confirmed() {
    assert!(check(&edited(pick(), CERTIFICATE, |c| list(c, "pairs").reverse())).unwrap().is_confirmed());
    let undecided = check(&edited(pick(), CERTIFICATE, |c| {
        pair(c, "finger_left", "bench")["verdict"] = json!({"not_checked": {"reason": ""}});
    }))
    .unwrap();
    assert!(undecided.findings.is_empty() && !undecided.is_confirmed());
    assert_eq!(undecided.undecided.len(), 1);
    let turned = check(&edited(pick(), CERTIFICATE, |c| {
        let pair = pair(c, "forearm", "bench").as_object_mut().unwrap();
        pair.insert("a".to_owned(), json!("bench"));
        pair.insert("b".to_owned(), json!("forearm"));
    }))
    .unwrap();
    let quantities: Vec<Quantity> = turned.findings.iter().map(|finding| finding.quantity).collect();
    assert_eq!(quantities, [Quantity::Occurrences; 2], "{:?}", turned.findings);
}

#[test]
fn certificates_of_real_logs_are_confirmed() {
    for (scenario, violated) in [
        ("scara/pick_cube.toml", 0),
        ("scara/pick_over_wall.toml", 0),
        ("rrr/pedestal_to_pedestal.toml", 0),
        ("rrr/shelf_top_down.toml", 0),
        ("worked_examples/lfpb_cartesian.toml", 0),
        ("negative/dragged.toml", 1),
        ("negative/beside_the_middle.toml", 1),
        ("negative/carried_too_low.toml", 1),
        ("negative/joint_jump.toml", 0),
    ] {
        let report = check(&log_of(scenario)).unwrap();
        let findings: Vec<String> = report.findings.iter().take(5).map(ToString::to_string).collect();
        assert!(report.is_confirmed(), "{scenario}: {findings:#?}");
        assert!(report.leaves >= report.pairs - violated && report.limits > 0, "{scenario}: {report:?}");
        assert_eq!(report.violated.len(), violated, "{scenario}");
    }
}

#[test]
fn a_proved_collision_is_confirmed_and_what_is_undecided_is_said() {
    let report = check(collision()).unwrap();
    assert!(report.is_confirmed(), "{:?}", report.findings);
    let names: Vec<String> = report.violated.iter().map(ToString::to_string).collect();
    assert_eq!(names, ["cube[0] - wall[0]"]);
    let undecided: Vec<&str> = report.undecided.iter().map(|pair| pair.a.as_str()).collect();
    assert_eq!(undecided, ["finger_left", "finger_right"]);
}

#[test]
fn a_changed_violation_is_found() {
    for (change, expected) in [
        ((|violation| violation["time"] = json!(0.1)) as fn(&mut Value), Quantity::Phase),
        (|violation| violation["time"] = json!(-1.0), Quantity::Phase),
        (|violation| violation["phase"] = json!("approach"), Quantity::Phase),
        (|violation| add(&mut violation["points"][0][2], 0.2), Quantity::Witness),
        (|violation| add(&mut violation["points"][1][0], 0.5), Quantity::Witness),
        (|violation| add(&mut violation["required"], 1e-6), Quantity::Required),
        (|violation| violation["distance"] = json!(0.01), Quantity::Violation),
        (|violation| violation["distance"] = json!(-0.05), Quantity::WitnessDistance),
    ] {
        let tampered =
            edited(collision(), CERTIFICATE, |c| change(&mut pair(c, "cube", "wall")["verdict"]["violated"]));
        let findings = check(&tampered).unwrap().findings;
        assert!(findings.iter().any(|finding| finding.quantity == expected), "{findings:?}");
        assert!(
            findings.iter().all(|finding| finding.place.to_string() == "cube[0] - wall[0]"),
            "{findings:?}"
        );
    }
}

#[test]
fn documents_that_cannot_be_trusted_are_refused() {
    for name in [RESOLVED, PLAN, CERTIFICATE, LIMITS] {
        let mut without = pick().clone();
        without.attachments.retain(|document| document.name != name);
        assert!(matches!(check(&without), Err(CheckerError::Missing { name: missing }) if missing == name));
        let newer = edited(pick(), name, |document| document["schema"] = json!(99));
        let error = check(&newer).unwrap_err();
        assert!(matches!(error, CheckerError::UnknownSchema { found: 99, .. }), "{error}");
        let none = edited(pick(), name, |document| document["schema"] = json!(0));
        assert!(matches!(check(&none).unwrap_err(), CheckerError::UnknownSchema { found: 0, .. }));
    }
    // JSON has no NaN: it is refused as a word, as nothing and as a number that is too large.
    let gap = ["NaN", "null", "1e999"].map(|number| {
        let change = |data: &mut Vec<u8>| {
            let text = String::from_utf8(data.clone()).unwrap();
            let (before, after) = text.split_once("\"gap\":").unwrap();
            let (_, after) = after.split_once(',').unwrap();
            *data = format!("{before}\"gap\":{number},{after}").into_bytes();
        };
        check(&rewritten(pick(), "certificate.json", change)).unwrap_err()
    });
    assert!(gap.iter().all(|error| matches!(error, CheckerError::Undecodable { .. })), "{gap:?}");
    for (name, change) in [
        ("resolved.json", (|r| r["cell"]["clearance"]["required"] = json!(-0.01)) as fn(&mut Value)),
        ("resolved.json", |r| r["cell"]["bodies"][0]["name"] = json!("cube")),
        ("resolved.json", |r| r["robot"]["links"] = json!([])),
        ("resolved.json", |r| r["robot"]["allowed_contacts"][0]["a"] = json!("nobody")),
        ("plan.json", |p| p["grasp"] = Value::Null),
        ("plan.json", |p| p["phases"][1]["end"] = json!(0.0)),
        ("plan.json", |p| p["trajectory"]["knots"][1] = json!(0.0)),
        // The plan lasts longer than its phases.
        ("plan.json", |p| {
            let last = p["trajectory"]["knots"].as_array().unwrap().len() - 1;
            add(&mut p["trajectory"]["knots"][last], 0.1);
        }),
        ("plan.json", |p| p["trajectory"]["coefficients"][0][0][7] = json!(1e30)),
    ] {
        let error = check(&edited(pick(), name, change)).unwrap_err();
        assert!(matches!(error, CheckerError::Unsound { .. }), "{error}");
    }
    for change in [
        (|r| r["robot"]["joints"][0]["axis"][2] = json!(1.01)) as fn(&mut Value),
        |r| r["robot"]["world_from_base"]["rotation"] = json!([0.0, 0.0, 0.0, 1.1]),
        |r| r["object"]["shape"] = json!({"sphere": {"radius": -1.0}}),
    ] {
        let error = check(&edited(pick(), "resolved.json", change)).unwrap_err();
        assert!(matches!(error, CheckerError::Undecodable { .. }), "{error}");
    }
}
