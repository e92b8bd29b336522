//! Robots, cells and plans for tests, as the documents that they come from.

#![expect(clippy::needless_pass_by_value, reason = "documents are put together from their parts")]

use serde::de::DeserializeOwned;
use serde_json::{Value, json};

/// A document, or a part of one, from its JSON.
pub(crate) fn read<T: DeserializeOwned>(value: Value) -> T {
    serde_json::from_value(value).expect("the fixture is well formed")
}

/// A pose turned by `angle` (rad) about an axis of length 1.
pub(crate) fn pose(translation: [f64; 3], axis: [f64; 3], angle: f64) -> Value {
    let (sin, cos) = (0.5 * angle).sin_cos();
    json!({"translation": translation, "rotation": [axis[0] * sin, axis[1] * sin, axis[2] * sin, cos]})
}

pub(crate) fn at(x: f64, y: f64, z: f64) -> Value {
    pose([x, y, z], [0.0, 0.0, 1.0], 0.0)
}

pub(crate) fn boxed(x: f64, y: f64, z: f64) -> Value {
    json!({"box": {"half_extents": [x, y, z]}})
}

pub(crate) fn link(name: &str, shapes: &[(Value, Value)]) -> Value {
    let placed = |(place, shape): &(Value, Value)| json!({"body_from_shape": place, "shape": shape});
    json!({"name": name, "shapes": shapes.iter().map(placed).collect::<Vec<_>>()})
}

pub(crate) fn joint(kind: &str, parent_from_joint: Value, axis: [f64; 3]) -> Value {
    let limits = json!({
        "position_min": -1.0, "position_max": 1.0, "velocity": 2.0, "acceleration": 10.0, "jerk": 100.0, "effort": 50.0,
    });
    json!({"kind": kind, "parent_from_joint": parent_from_joint, "axis": axis, "limits": limits})
}

/// A robot whose fingers are small boxes that open along y, 50 mm below the last link.
pub(crate) fn robot(joints: Vec<Value>, links: Vec<Value>) -> Value {
    let finger = |name, sign: f64| {
        let shape = (at(0.0, 0.005 * sign, 0.0), boxed(0.005, 0.005, 0.02));
        json!({"link": link(name, &[shape]), "link_from_finger": at(0.0, 0.0, -0.05), "axis": [0.0, sign, 0.0]})
    };
    let named = |(i, mut joint): (usize, Value)| {
        joint["name"] = json!(format!("joint {i}"));
        joint
    };
    json!({
        "world_from_base": at(0.0, 0.0, 0.0),
        "base": link("base", &[(at(-1.0, 0.0, 0.0), boxed(0.1, 0.1, 0.1))]),
        "joints": joints.into_iter().enumerate().map(named).collect::<Vec<_>>(),
        "links": links,
        "link_from_tool": at(0.0, 0.0, -0.05),
        "gripper": {"fingers": [finger("left", 1.0), finger("right", -1.0)]},
        "allowed_contacts": [],
    })
}

/// Slides along x, y and z, a box as the hand, a table under it and a cube on that; 2 mm are required.
pub(crate) fn gantry() -> Value {
    let slide = |axis| joint("prismatic", at(0.0, 0.0, 0.0), axis);
    let joints = vec![slide([1.0, 0.0, 0.0]), slide([0.0, 1.0, 0.0]), slide([0.0, 0.0, 1.0])];
    let hand = link("hand", &[(at(0.0, 0.0, 0.0), boxed(0.03, 0.05, 0.01))]);
    let table = json!({
        "name": "table", "shape": boxed(0.5, 0.5, 0.05), "world_from_shape": at(0.0, 0.0, -0.05),
    });
    json!({
        "schema": 1,
        "robot": robot(joints, vec![link("bridge", &[]), link("carriage", &[]), hand]),
        "cell": {
            "gravity": [0.0, 0.0, -9.8],
            "bodies": [table],
            "clearance": {"required": 0.002, "pairs": []},
        },
        "object": {"name": "cube", "shape": boxed(0.02, 0.02, 0.02), "world_from_object": at(0.0, 0.0, 0.02)},
    })
}

/// A trajectory of one piece over 1 s.
pub(crate) fn one_piece(joints: &[[f64; 8]]) -> Value {
    json!({"knots": [0.0, 1.0], "coefficients": [joints]})
}

/// The eight coefficients of a motion from rest to rest over 1 s, of degree 5.
pub(crate) fn rest_to_rest(from: f64, to: f64) -> [f64; 8] {
    let way = to - from;
    [from, 0.0, 0.0, 10.0 * way, -15.0 * way, 6.0 * way, 0.0, 0.0]
}

/// The gantry at rest over the cube, in phases of 1 s with these holdings; the cube goes to x = 0.2 m.
pub(crate) fn plan(holdings: &[&str]) -> Value {
    let duration = holdings.len() as f64;
    let phase = |(i, holding): (usize, &&str)| json!({"name": format!("phase {i}"), "start": i as f64, "end": i as f64 + 1.0, "holding": holding});
    let still = |joints: &[[f64; 8]]| json!({"knots": [0.0, duration], "coefficients": [joints]});
    json!({
        "schema": 1,
        "trajectory": still(&[[0.0; 8], [0.0; 8], [0.2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]]),
        "opening": still(&[[0.05, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]]),
        "phases": holdings.iter().enumerate().map(phase).collect::<Vec<_>>(),
        "grasp": {
            "tool_from_object": at(0.0, 0.0, 0.0), "width": 0.04, "world_from_placed": at(0.2, 0.0, 0.021),
        },
    })
}
