//! Everything that can be changed in the proofs of a log, and what must be found then.

use graspcheck_checker::Quantity;
use serde_json::{Value, json};

/// The proof of a pair, by the names of its bodies.
pub(crate) fn pair<'c>(certificate: &'c mut Value, a: &str, b: &str) -> &'c mut Value {
    let mut pairs = certificate["pairs"].as_array_mut().unwrap().iter_mut();
    pairs.find(|pair| pair["a"] == a && pair["b"] == b).unwrap_or_else(|| panic!("no pair {a} - {b}"))
}

/// The steps of the pair that is tampered with.
fn steps(certificate: &mut Value) -> &mut Vec<Value> {
    pair(certificate, "finger_left", "bench")["leaves"].as_array_mut().unwrap()
}

/// Its step with the largest loss: one in which it moves.
fn step(certificate: &mut Value) -> &mut Value {
    let loss = |leaf: &Value| leaf["loss"].as_f64().unwrap();
    steps(certificate).iter_mut().max_by(|x, y| loss(x).total_cmp(&loss(y))).unwrap()
}

/// What is claimed of the velocity of the shoulder.
fn velocity(limits: &mut Value) -> &mut Value {
    claim(limits, "shoulder", "velocity")
}

fn claim<'l>(limits: &'l mut Value, joint: &str, quantity: &str) -> &'l mut Value {
    let mut claims = limits["limits"].as_array_mut().unwrap().iter_mut();
    claims.find(|claim| claim["joint"] == joint && claim["quantity"] == quantity).unwrap()
}

pub(crate) fn list<'d>(document: &'d mut Value, name: &str) -> &'d mut Vec<Value> {
    document[name].as_array_mut().unwrap()
}

pub(crate) fn add(value: &mut Value, amount: f64) {
    *value = json!(value.as_f64().unwrap() + amount);
}

fn scale(value: &mut Value, factor: f64) {
    *value = json!(value.as_f64().unwrap() * factor);
}

fn twice(list: &mut Vec<Value>, index: usize) {
    list.insert(index, list[index].clone());
}

fn twice_where(list: &mut Vec<Value>, is_it: fn(&Value) -> bool) {
    let index = list.iter().position(is_it).unwrap();
    twice(list, index);
}

fn is_velocity(claim: &Value) -> bool {
    claim["joint"] == "shoulder" && claim["quantity"] == "velocity"
}

/// What is done, to which document, and what must be found where. Findings at other places are allowed only where
/// the change concerns many of them: then the place ends in `…`.
pub(crate) type Tampering = (&'static str, &'static str, fn(&mut Value), Quantity, &'static str);

pub(crate) const CERTIFICATE: &str = "certificate.json";
pub(crate) const RESOLVED: &str = "resolved.json";
pub(crate) const PLAN: &str = "plan.json";
pub(crate) const LIMITS: &str = "limits.json";

const STEP: &str = "finger_left[0] - bench[0]";
const VELOCITY: &str = "velocity of shoulder";

pub(crate) const OF_THE_PICK: &[Tampering] = &[
    // Each number of a step.
    ("a gap 2 nm wider", CERTIFICATE, |c| add(&mut step(c)["gap"], 2e-9), Quantity::Gap, STEP),
    ("no gap", CERTIFICATE, |c| step(c)["gap"] = json!(0.0), Quantity::Clearance, STEP),
    ("another normal", CERTIFICATE, |c| step(c)["normal"] = json!([1.0, 0.0, 0.0]), Quantity::Gap, STEP),
    ("a shorter normal", CERTIFICATE, |c| add(&mut step(c)["normal"][2], 0.001), Quantity::Normal, STEP),
    ("no loss", CERTIFICATE, |c| step(c)["loss"] = json!(0.0), Quantity::Loss, STEP),
    ("less required", CERTIFICATE, |c| add(&mut step(c)["required"], -1e-9), Quantity::Required, STEP),
    ("more required", CERTIFICATE, |c| add(&mut step(c)["required"], 1e-9), Quantity::Required, STEP),
    ("a later start", CERTIFICATE, |c| add(&mut step(c)["start"], 1e-9), Quantity::Start, STEP),
    ("a later end", CERTIFICATE, |c| add(&mut step(c)["end"], 1e-9), Quantity::Start, STEP),
    (
        "a step of no length",
        CERTIFICATE,
        |c| step(c)["end"] = step(c)["start"].clone(),
        Quantity::Start,
        STEP,
    ),
    // Steps.
    ("a step less", CERTIFICATE, |c| drop(steps(c).remove(3)), Quantity::Start, STEP),
    ("no first step", CERTIFICATE, |c| drop(steps(c).remove(0)), Quantity::Start, STEP),
    ("no last step", CERTIFICATE, |c| drop(steps(c).pop()), Quantity::End, STEP),
    ("no step", CERTIFICATE, |c| steps(c).clear(), Quantity::End, STEP),
    ("two steps exchanged", CERTIFICATE, |c| steps(c).swap(1, 2), Quantity::Start, STEP),
    ("a step twice", CERTIFICATE, |c| twice(steps(c), 2), Quantity::Start, STEP),
    // Pairs and the whole.
    (
        "a larger margin",
        CERTIFICATE,
        |c| add(&mut pair(c, "finger_left", "bench")["verdict"]["free"]["margin"], 1e-6),
        Quantity::Margin,
        STEP,
    ),
    (
        "a pair less",
        CERTIFICATE,
        |c| list(c, "pairs").retain(|pair| pair["a"] != "finger_left" || pair["b"] != "bench"),
        Quantity::Occurrences,
        STEP,
    ),
    (
        "a pair twice",
        CERTIFICATE,
        |c| twice_where(list(c, "pairs"), |pair| pair["a"] == "finger_left" && pair["b"] == "bench"),
        Quantity::Occurrences,
        STEP,
    ),
    (
        "another part",
        CERTIFICATE,
        |c| pair(c, "finger_left", "bench")["part_a"] = json!(7),
        Quantity::Occurrences,
        "finger_left[7] - bench[0] …",
    ),
    (
        "another body",
        CERTIFICATE,
        |c| pair(c, "finger_left", "bench")["b"] = json!("nobody"),
        Quantity::Occurrences,
        "finger_left[0] - nobody[0] …",
    ),
    ("fewer pairs", CERTIFICATE, |c| c["pair_count"] = json!(1), Quantity::PairCount, "the whole"),
    ("a longer proof", CERTIFICATE, |c| add(&mut c["duration"], 1e-9), Quantity::Duration, "the whole"),
    // What is allowed and required.
    (
        "a contact more is allowed",
        RESOLVED,
        |r| {
            list(&mut r["robot"], "allowed_contacts")
                .push(json!({"a": "hand", "b": "base", "reason": "never"}));
        },
        Quantity::Occurrences,
        "base[0] - hand[0] …",
    ),
    (
        "less is required of all",
        RESOLVED,
        |r| add(&mut r["cell"]["clearance"]["required"], -0.001),
        Quantity::Required,
        "forearm[0] - bench[0] …",
    ),
    (
        "less is required by a rule",
        RESOLVED,
        |r| add(&mut r["cell"]["clearance"]["pairs"][0]["required"], -0.001),
        Quantity::Required,
        "finger_left[0] - bench[0] …",
    ),
    (
        "a rule for one pair",
        RESOLVED,
        |r| {
            let rule = json!({"a": "finger_left", "b": "bench", "required": 0.001, "reason": "it is near"});
            list(&mut r["cell"]["clearance"], "pairs").push(rule);
        },
        Quantity::Required,
        STEP,
    ),
    // Robot, cell and object.
    (
        "a longer link",
        RESOLVED,
        |r| add(&mut r["robot"]["joints"][1]["parent_from_joint"]["translation"][0], 0.01),
        Quantity::Gap,
        "…",
    ),
    (
        "the base stands lower",
        RESOLVED,
        |r| add(&mut r["robot"]["world_from_base"]["translation"][2], -1e-6),
        Quantity::Gap,
        "finger_left[0] - bench[0] …",
    ),
    (
        "the bench stands higher",
        RESOLVED,
        |r| add(&mut r["cell"]["bodies"][0]["world_from_shape"]["translation"][2], 1e-6),
        Quantity::Gap,
        "finger_left[0] - bench[0] …",
    ),
    (
        "the cube is larger",
        RESOLVED,
        |r| add(&mut r["object"]["shape"]["box"]["half_extents"][0], 1e-4),
        Quantity::Gap,
        "cube[0] - finger_left[0] …",
    ),
    (
        "the cube starts higher",
        RESOLVED,
        |r| add(&mut r["object"]["world_from_object"]["translation"][2], 0.01),
        Quantity::Required,
        "cube[0] - bench[0] …",
    ),
    (
        "a body more",
        RESOLVED,
        |r| {
            let mut unseen = r["cell"]["bodies"][0].clone();
            unseen["name"] = json!("unseen");
            list(&mut r["cell"], "bodies").push(unseen);
        },
        Quantity::Occurrences,
        "finger_left[0] - unseen[0] …",
    ),
    // The plan.
    (
        "the quill goes lower",
        PLAN,
        |p| add(&mut p["trajectory"]["coefficients"][4][2][0], -1e-4),
        Quantity::Gap,
        "finger_left[0] - bench[0] …",
    ),
    (
        "the shoulder turns faster",
        PLAN,
        |p| add(&mut p["trajectory"]["coefficients"][4][0][1], 0.5),
        Quantity::Loss,
        "…",
    ),
    (
        "a piece jerks",
        PLAN,
        |p| add(&mut p["trajectory"]["coefficients"][4][0][3], 1e4),
        Quantity::Bound,
        "jerk of shoulder …",
    ),
    (
        "the fingers stop earlier",
        PLAN,
        |p| add(&mut p["grasp"]["width"], -1e-3),
        Quantity::Gap,
        "cube[0] - finger_left[0] …",
    ),
    (
        "the cube is held elsewhere",
        PLAN,
        |p| add(&mut p["grasp"]["tool_from_object"]["translation"][1], 1e-5),
        Quantity::Gap,
        "cube[0] - finger_left[0] …",
    ),
    (
        "what is carried is not held",
        PLAN,
        |p| {
            let mut phases = list(p, "phases").iter_mut();
            phases.find(|phase| phase["name"] == "carry").unwrap()["holding"] = json!("placed");
        },
        Quantity::Required,
        "cube[0] - finger_left[0] …",
    ),
    // Limits.
    ("a larger limit", LIMITS, |l| scale(&mut velocity(l)["limit"], 1.01), Quantity::Limit, VELOCITY),
    (
        "a larger limit of the robot",
        RESOLVED,
        |r| scale(&mut r["robot"]["joints"][0]["limits"]["velocity"], 1.01),
        Quantity::Limit,
        VELOCITY,
    ),
    (
        "a larger limit of an effort",
        RESOLVED,
        |r| scale(&mut r["robot"]["joints"][2]["limits"]["effort"], 1.01),
        Quantity::Limit,
        "effort of quill",
    ),
    ("a lower bound", LIMITS, |l| scale(&mut velocity(l)["bound"], 1.0 - 1e-9), Quantity::Bound, VELOCITY),
    (
        "a least position that is undercut",
        LIMITS,
        |l| add(&mut claim(l, "quill", "position_min")["bound"], 1e-9),
        Quantity::Bound,
        "least position of quill",
    ),
    (
        "a largest position that is exceeded",
        LIMITS,
        |l| add(&mut claim(l, "wrist", "position_max")["bound"], -1e-9),
        Quantity::Bound,
        "largest position of wrist",
    ),
    ("a higher peak", LIMITS, |l| scale(&mut velocity(l)["peak"], 1.0 + 1e-9), Quantity::Peak, VELOCITY),
    ("a lower peak", LIMITS, |l| scale(&mut velocity(l)["peak"], 1.0 - 1e-9), Quantity::Peak, VELOCITY),
    ("a peak at rest", LIMITS, |l| velocity(l)["time"] = json!(0.0), Quantity::Peak, VELOCITY),
    ("a peak after the end", LIMITS, |l| velocity(l)["time"] = json!(60.0), Quantity::Duration, VELOCITY),
    (
        "an effort that is met above its bound",
        LIMITS,
        |l| scale(&mut claim(l, "quill", "effort")["peak"], 2.0),
        Quantity::Peak,
        "effort of quill",
    ),
    (
        "a limit less",
        LIMITS,
        |l| list(l, "limits").retain(|claim| !is_velocity(claim)),
        Quantity::Occurrences,
        VELOCITY,
    ),
    (
        "an effort less",
        LIMITS,
        |l| list(l, "limits").retain(|claim| claim["joint"] != "quill" || claim["quantity"] != "effort"),
        Quantity::Occurrences,
        "effort of quill",
    ),
    (
        "a limit twice",
        LIMITS,
        |l| twice_where(list(l, "limits"), is_velocity),
        Quantity::Occurrences,
        VELOCITY,
    ),
    (
        "a limit of nobody",
        LIMITS,
        |l| velocity(l)["joint"] = json!("nobody"),
        Quantity::Occurrences,
        "velocity of nobody …",
    ),
    (
        "a jump that is none",
        LIMITS,
        |l| list(l, "breaks").push(json!({"joint": "quill", "order": 2, "time": 0.0, "size": 1.0})),
        Quantity::Occurrences,
        "jump of derivative 2 of quill",
    ),
    ("another end", LIMITS, |l| add(&mut l["duration"], 1e-9), Quantity::Duration, "the whole"),
];

pub(crate) const OF_THE_STEPPED_PLAN: &[Tampering] = &[
    (
        "a jump less",
        LIMITS,
        |l| drop(list(l, "breaks").remove(0)),
        Quantity::Occurrences,
        "jump of derivative 2 of shoulder",
    ),
    (
        "a smaller jump",
        LIMITS,
        |l| scale(&mut l["breaks"][0]["size"], 0.999),
        Quantity::Jump,
        "jump of derivative 2 of shoulder",
    ),
    (
        "a later jump",
        LIMITS,
        |l| add(&mut l["breaks"][0]["time"], 1e-6),
        Quantity::Occurrences,
        "jump of derivative 2 of shoulder",
    ),
];

/// The sweep that is tampered with: the first of the forearm.
fn sweep(certificate: &mut Value) -> &mut Value {
    let mut sweeps = list(certificate, "sweeps").iter_mut();
    sweeps.find(|sweep| sweep["body"] == "forearm" && sweep["part"] == 0).unwrap()
}

const SWEEP: &str = "sweep of forearm[0]";

pub(crate) const OF_THE_CROWDED_PICK: &[Tampering] = &[
    ("a lower side", CERTIFICATE, |c| add(&mut sweep(c)["max"][2], -2e-9), Quantity::Box, SWEEP),
    ("a side farther in", CERTIFICATE, |c| add(&mut sweep(c)["min"][0], 2e-9), Quantity::Box, SWEEP),
    (
        "a box turned round",
        CERTIFICATE,
        |c| sweep(c)["max"] = json!([-9.0, -9.0, -9.0]),
        Quantity::Box,
        SWEEP,
    ),
    (
        "a sweep less",
        CERTIFICATE,
        |c| {
            let index = list(c, "sweeps").iter().position(|sweep| sweep["body"] == "forearm").unwrap();
            list(c, "sweeps").remove(index);
        },
        Quantity::Occurrences,
        "forearm[0] - post_20[0] …",
    ),
    ("no sweep", CERTIFICATE, |c| list(c, "sweeps").clear(), Quantity::Occurrences, "hand[0] - post_20[0] …"),
    (
        "a sweep twice",
        CERTIFICATE,
        |c| twice_where(list(c, "sweeps"), |sweep| sweep["body"] == "forearm"),
        Quantity::Start,
        SWEEP,
    ),
    (
        "a shorter sweep",
        CERTIFICATE,
        |c| add(&mut sweep(c)["end"], -1e-6),
        Quantity::Occurrences,
        "forearm[0] - post_20[0] …",
    ),
    (
        "a longer sweep",
        CERTIFICATE,
        |c| add(&mut sweep(c)["end"], 1.0),
        Quantity::Box,
        "sweep of forearm[0] …",
    ),
    (
        "a sweep of nothing",
        CERTIFICATE,
        |c| sweep(c)["body"] = json!("post_20"),
        Quantity::Occurrences,
        "sweep of post_20[0] …",
    ),
    (
        "a post stands in the way",
        RESOLVED,
        |r| {
            let mut bodies = list(&mut r["cell"], "bodies").iter_mut();
            let post = bodies.find(|body| body["name"] == "post_20").unwrap();
            post["world_from_shape"]["translation"] = json!([0.3, 0.0, 0.2]);
        },
        Quantity::Occurrences,
        "hand[1] - post_20[0] …",
    ),
    ("fewer pairs", CERTIFICATE, |c| c["pair_count"] = json!(1), Quantity::PairCount, "the whole"),
];
