//! The checker confirms the certificates of real logs, and names what was changed in one.

#![expect(
    clippy::unwrap_used,
    clippy::panic,
    reason = "helpers of tests: a run that ends early fails the test"
)]

use std::{path::Path, sync::OnceLock};

use graspcheck::{Silent, load, run_scenario};
use graspcheck_checker::{CheckerError, Quantity, Report, check};
use graspcheck_recording::{Recording, from_bytes, to_bytes};
use serde_json::{Value, json};

/// The log of a scenario, as its file holds it.
fn log_of(scenario: &str) -> Recording {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios").join(scenario);
    let scenario = load(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let run =
        run_scenario(&scenario, &mut Silent).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    from_bytes(&to_bytes(&run.recording).unwrap()).unwrap()
}

fn pick() -> &'static Recording {
    static PICK: OnceLock<Recording> = OnceLock::new();
    PICK.get_or_init(|| log_of("scara/pick_cube.toml"))
}

fn collision() -> &'static Recording {
    static COLLISION: OnceLock<Recording> = OnceLock::new();
    COLLISION.get_or_init(|| log_of("negative/planned_collision.toml"))
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

/// Where a pair is in the certificate.
fn index_of(certificate: &Value, a: &str, b: &str) -> usize {
    let pairs = certificate["pairs"].as_array().unwrap();
    pairs
        .iter()
        .position(|pair| pair["a"] == a && pair["b"] == b)
        .unwrap_or_else(|| panic!("no pair {a} - {b}"))
}

/// What is found when the proof of one pair in the log of the pick is changed.
fn found_in_pair(a: &str, b: &str, change: impl FnOnce(&mut Value)) -> Report {
    let recording = edited(pick(), "certificate.json", |certificate| {
        let index = index_of(certificate, a, b);
        change(&mut certificate["pairs"][index]);
    });
    check(&recording).unwrap()
}

/// The step of a proof with the largest loss: one in which the pair moves.
fn moving_leaf(pair: &mut Value) -> &mut Value {
    let loss = |leaf: &Value| leaf["loss"].as_f64().unwrap();
    pair["leaves"].as_array_mut().unwrap().iter_mut().max_by(|x, y| loss(x).total_cmp(&loss(y))).unwrap()
}

fn add(value: &mut Value, amount: f64) {
    *value = json!(value.as_f64().unwrap() + amount);
}

fn quantities(report: &Report) -> Vec<Quantity> {
    report.findings.iter().map(|finding| finding.quantity).collect()
}

/// One statement about one pair is wrong, and that is what is found.
#[track_caller]
fn assert_found(report: &Report, quantity: Quantity, a: &str, b: &str) {
    assert!(!report.is_confirmed());
    let is_it = |finding: &&graspcheck_checker::Finding| finding.quantity == quantity;
    let finding = report.findings.iter().find(is_it);
    let finding = finding.unwrap_or_else(|| panic!("{quantity:?} is not in {:?}", report.findings));
    let pair = finding.pair.as_ref().unwrap();
    assert_eq!((pair.a.as_str(), pair.b.as_str()), (a, b));
    for other in &report.findings {
        let other = other.pair.as_ref().unwrap();
        assert_eq!((&other.a, &other.b), (&pair.a, &pair.b), "{:?}", report.findings);
    }
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
        assert!(report.leaves >= report.pairs - violated, "{scenario}: {report:?}");
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
fn a_changed_step_is_found() {
    let pair = ("finger_left", "bench");
    let found = |change: fn(&mut Value)| found_in_pair(pair.0, pair.1, |pair| change(moving_leaf(pair)));
    let wider = found(|leaf| add(&mut leaf["gap"], 2e-9));
    assert_found(&wider, Quantity::Gap, pair.0, pair.1);
    assert_eq!(wider.findings.len(), 1, "{:?}", wider.findings);
    let narrower = found(|leaf| leaf["gap"] = json!(0.0));
    assert_found(&narrower, Quantity::Clearance, pair.0, pair.1);
    let aside = found(|leaf| leaf["normal"] = json!([1.0, 0.0, 0.0]));
    assert_found(&aside, Quantity::Gap, pair.0, pair.1);
    let long = found(|leaf| add(&mut leaf["normal"][2], -0.001));
    assert_found(&long, Quantity::Normal, pair.0, pair.1);
    let still = found(|leaf| leaf["loss"] = json!(0.0));
    assert_found(&still, Quantity::Loss, pair.0, pair.1);
    let undemanding = found(|leaf| add(&mut leaf["required"], -1e-9));
    assert_found(&undemanding, Quantity::Required, pair.0, pair.1);
    let demanding = found(|leaf| add(&mut leaf["required"], 1e-9));
    assert_found(&demanding, Quantity::Required, pair.0, pair.1);
}

#[test]
fn steps_that_are_missing_overlap_or_straddle_are_found() {
    let pair = ("finger_left", "bench");
    let found = |change: fn(&mut Vec<Value>)| {
        found_in_pair(pair.0, pair.1, |pair| change(pair["leaves"].as_array_mut().unwrap()))
    };
    for (change, quantity) in [
        ((|leaves| _ = leaves.remove(3)) as fn(&mut Vec<Value>), Quantity::Start),
        (|leaves| _ = leaves.remove(0), Quantity::Start),
        (|leaves| _ = leaves.pop(), Quantity::End),
        (Vec::clear, Quantity::End),
        (|leaves| leaves.swap(1, 2), Quantity::Start),
        (|leaves| leaves.insert(2, leaves[2].clone()), Quantity::Start),
        (|leaves| leaves[2]["end"] = leaves[2]["start"].clone(), Quantity::Start),
    ] {
        assert_found(&found(change), quantity, pair.0, pair.1);
    }
    // The finger comes, closes and opens: each time something else is required, and a step that
    // reaches over is found whether its middle is before or after.
    for change in 0..3 {
        for first_ends in [true, false] {
            let straddling = found_in_pair("cube", "finger_left", |pair| {
                let leaves = pair["leaves"].as_array_mut().unwrap();
                let differs = |&i: &usize| leaves[i]["required"] != leaves[i - 1]["required"];
                let Some(second) = (1..leaves.len()).filter(differs).nth(change) else {
                    panic!("only {change} changes of what is required")
                };
                let removed = leaves.remove(if first_ends { second } else { second - 1 });
                let (kept, time) = if first_ends { (second - 1, "end") } else { (second - 1, "start") };
                leaves[kept][time] = removed[time].clone();
            });
            assert_found(&straddling, Quantity::Phase, "cube", "finger_left");
        }
    }
}

#[test]
fn pairs_that_are_missing_twice_there_or_turned_round_are_found() {
    let whole = |change: fn(&mut Vec<Value>)| {
        let recording = edited(pick(), "certificate.json", |certificate| {
            let index = index_of(certificate, "forearm", "bench");
            let pairs = certificate["pairs"].as_array_mut().unwrap();
            pairs.swap(0, index);
            change(pairs);
        });
        check(&recording).unwrap()
    };
    let missing = whole(|pairs| _ = pairs.remove(0));
    assert_found(&missing, Quantity::Occurrences, "forearm", "bench");
    assert_eq!((missing.findings[0].stated, missing.findings[0].recomputed), (0.0, 1.0));
    let twice = whole(|pairs| pairs.push(pairs[0].clone()));
    assert_found(&twice, Quantity::Occurrences, "forearm", "bench");
    assert!((twice.findings[0].stated - 2.0).abs() < 0.1, "{:?}", twice.findings);
    let none = whole(Vec::clear);
    assert_eq!(none.findings.len(), none.pairs);
    assert!(whole(|pairs| pairs.reverse()).is_confirmed(), "the order of pairs says nothing");
    let turned = whole(|pairs| {
        let pair = pairs[0].as_object_mut().unwrap();
        let (a, b) = (pair["a"].clone(), pair["b"].clone());
        pair.insert("a".to_owned(), b);
        pair.insert("b".to_owned(), a);
    });
    assert_eq!(quantities(&turned), [Quantity::Occurrences; 2], "{:?}", turned.findings);
}

#[test]
fn margins_and_durations_that_are_not_so_are_found() {
    let pair = ("finger_left", "bench");
    let report = found_in_pair(pair.0, pair.1, |pair| add(&mut pair["verdict"]["free"]["margin"], 1e-6));
    assert_found(&report, Quantity::Margin, pair.0, pair.1);
    let recording = edited(pick(), "certificate.json", |certificate| add(&mut certificate["duration"], 1e-9));
    assert_eq!(quantities(&check(&recording).unwrap()), [Quantity::Duration]);
    let undecided =
        found_in_pair(pair.0, pair.1, |pair| pair["verdict"] = json!({"not_checked": {"reason": ""}}));
    assert!(undecided.findings.is_empty() && !undecided.is_confirmed());
    assert_eq!(undecided.undecided.len(), 1);
}

#[test]
fn a_changed_scene_is_found() {
    let found = |change: fn(&mut Value)| check(&edited(pick(), "resolved.json", change)).unwrap();
    let widened = found(|resolved| {
        let contacts = resolved["robot"]["allowed_contacts"].as_array_mut().unwrap();
        contacts.push(json!({"a": "hand", "b": "base", "reason": "it never comes there"}));
    });
    assert_found(&widened, Quantity::Occurrences, "base", "hand");
    assert_eq!((widened.findings[0].stated, widened.findings[0].recomputed), (1.0, 0.0));
    for (change, expected) in [
        // The bench stands higher, the clearances are smaller, the arm is longer, the cube is larger, or stands
        // elsewhere, and there is one more body.
        (
            (|resolved| add(&mut resolved["cell"]["bodies"][0]["world_from_shape"]["translation"][2], 1e-5))
                as fn(&mut Value),
            Quantity::Gap,
        ),
        (|resolved| add(&mut resolved["cell"]["clearance"]["required"], -0.001), Quantity::Required),
        (
            |resolved| add(&mut resolved["robot"]["joints"][1]["parent_from_joint"]["translation"][0], 0.01),
            Quantity::Gap,
        ),
        (|resolved| add(&mut resolved["object"]["shape"]["box"]["half_extents"][0], 1e-4), Quantity::Gap),
        (
            |resolved| add(&mut resolved["object"]["world_from_object"]["translation"][2], 0.01),
            Quantity::Required,
        ),
        (
            |resolved| {
                let bodies = resolved["cell"]["bodies"].as_array_mut().unwrap();
                bodies.push(bodies[0].clone());
                let index = bodies.len() - 1;
                bodies[index]["name"] = json!("unseen");
            },
            Quantity::Occurrences,
        ),
    ] {
        let report = found(change);
        assert!(!report.is_confirmed() && quantities(&report).contains(&expected), "{:?}", report.findings);
    }
}

#[test]
fn a_changed_plan_is_found() {
    let found = |change: fn(&mut Value)| check(&edited(pick(), "plan.json", change)).unwrap();
    for (change, expected) in [
        // The quill goes lower in one piece, a joint turns faster, the fingers open less.
        (
            (|plan| add(&mut plan["trajectory"]["coefficients"][4][2][0], -1e-4)) as fn(&mut Value),
            Quantity::Gap,
        ),
        (|plan| add(&mut plan["trajectory"]["coefficients"][4][0][1], 0.5), Quantity::Loss),
        (|plan| add(&mut plan["grasp"]["width"], -1e-3), Quantity::Gap),
        (|plan| add(&mut plan["grasp"]["tool_from_object"]["translation"][1], 1e-5), Quantity::Gap),
    ] {
        let report = found(change);
        assert!(!report.is_confirmed() && quantities(&report).contains(&expected), "{:?}", report.findings);
    }
    // What is said to be held is not.
    let let_go = found(|plan| {
        let phases = plan["phases"].as_array_mut().unwrap();
        let carry = phases.iter_mut().find(|phase| phase["name"] == "carry").unwrap();
        carry["holding"] = json!("placed");
    });
    assert!(quantities(&let_go).contains(&Quantity::Required), "{:?}", let_go.findings);
}

#[test]
fn a_changed_violation_is_found() {
    let found = |change: fn(&mut Value)| {
        let recording = edited(collision(), "certificate.json", |certificate| {
            let index = index_of(certificate, "cube", "wall");
            change(&mut certificate["pairs"][index]["verdict"]["violated"]);
        });
        check(&recording).unwrap()
    };
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
        assert_found(&found(change), expected, "cube", "wall");
    }
}

#[test]
fn documents_that_cannot_be_trusted_are_refused() {
    for name in ["resolved.json", "plan.json", "certificate.json"] {
        let mut without = pick().clone();
        without.attachments.retain(|document| document.name != name);
        assert!(matches!(check(&without), Err(CheckerError::Missing { name: missing }) if missing == name));
        let newer = edited(pick(), name, |document| document["schema"] = json!(99));
        let error = check(&newer).unwrap_err();
        assert!(matches!(error, CheckerError::UnknownSchema { found: 99, .. }), "{error}");
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
