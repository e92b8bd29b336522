//! The judge's distance, and the proof's, against a convex program of scipy and MuJoCo:
//! `tests/oracles/distances.py` wrote the numbers.

use graspcheck_model::{Pose, shape::Shape};
use graspcheck_proof::{
    gap,
    solid::{Place, Placed as ProvedPlace, Solid as ProvedSolid},
};
use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use serde_json::Value;

use crate::trial::{
    distance::distance,
    solid::{Placed, Solid},
};

/// The stored distances are enclosed to this, m.
const STORED: f64 = 1e-7;
/// Both bounds are rounded, m.
const ROUNDING: f64 = 1e-12;

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

fn vector(value: &Value) -> Vector3<f64> {
    Vector3::from_fn(|row, _| number(&value[row]))
}

fn shape_and_pose(value: &Value) -> (Shape, Pose) {
    let (radius, half_length) = (|| number(&value["radius"]), || number(&value["half_length"]));
    let shape = match value["kind"].as_str().expect("a kind") {
        "box" => Shape::Box { half_extents: vector(&value["half_extents"]) },
        "sphere" => Shape::Sphere { radius: radius() },
        "capsule" => Shape::Capsule { radius: radius(), half_length: half_length() },
        "cylinder" => Shape::Cylinder { radius: radius(), half_length: half_length() },
        "hull" => {
            let points = value["points"].as_array().expect("corners");
            Shape::Hull { points: points.iter().map(|point| Point3::from(vector(point))).collect() }
        }
        other => unreachable!("there is no kind {other}"),
    };
    let [w, x, y, z] = [0, 1, 2, 3].map(|index| number(&value["quaternion"][index]));
    let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
    (shape, Isometry3::from_parts(vector(&value["position"]).into(), turn))
}

#[test]
fn distances_equal_those_of_a_convex_program() {
    let oracle: Value = serde_json::from_str(include_str!("../../../../tests/oracles/distances.json"))
        .expect("the oracle is JSON");
    let pairs = oracle["pairs"].as_array().expect("it has pairs");
    assert!(pairs.len() >= 300, "{} pairs", pairs.len());
    for pair in pairs {
        let stored = number(&pair["distance"]);
        let [(shape_a, pose_a), (shape_b, pose_b)] = ["a", "b"].map(|name| shape_and_pose(&pair[name]));
        let (a, b) = (Solid::of(&shape_a), Solid::of(&shape_b));
        let (a, b) = (Placed::new(&a, &pose_a), Placed::new(&b, &pose_b));
        for known in [distance(&a, &b), distance(&b, &a)] {
            let encloses = known.lower <= known.upper + ROUNDING
                && (known.lower - stored).abs() < STORED
                && (known.upper - stored).abs() < STORED;
            assert!(encloses, "{known:?}, not {stored} m: {pair}");
        }
        // The proof's bounds need not meet, but are bounds.
        let prove = |shape: &Shape, pose: &Pose| {
            let (solid, origin) = ProvedSolid::from_shape(shape).expect("a solid");
            (solid, Place::from(&(pose * Translation3::from(origin))))
        };
        let ((solid_a, place_a), (solid_b, place_b)) = (prove(&shape_a, &pose_a), prove(&shape_b, &pose_b));
        let a = ProvedPlace { solid: &solid_a, place: place_a };
        let b = ProvedPlace { solid: &solid_b, place: place_b };
        let known = gap::separation(&a, &b, None, STORED).expect("the search ends");
        let encloses = known.lower <= stored + STORED && stored <= known.upper + STORED;
        assert!(encloses && known.upper - known.lower < 1e-5, "{known:?}, not {stored} m: {pair}");
    }
}

/// The depth of a common point is one: no slab between the solids is less negative.
#[test]
fn overlaps_are_no_deeper_than_any_slab_allows() {
    let boxed = |x, y, z| Solid::of(&Shape::Box { half_extents: Vector3::new(x, y, z) });
    let (a, b) = (boxed(0.3, 0.2, 0.1), boxed(0.1, 0.1, 0.1));
    for (offset, deepest) in [(0.35, -0.05), (0.39, -0.01), (0.3999, -0.0001)] {
        let (a, b) =
            (Placed::new(&a, &Pose::identity()), Placed::new(&b, &Pose::translation(offset, 0.0, 0.0)));
        let known = distance(&a, &b);
        assert!(known.upper >= deepest - 1e-12 && known.upper <= 0.0, "{known:?}, not {deepest}");
    }
}
