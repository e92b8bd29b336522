//! Cubic splines under every end condition against scipy: `tests/oracles/splines.py` wrote the numbers.

#![expect(clippy::panic, reason = "a word that the oracle does not have fails the test")]

use graspcheck_planner::via::{
    ViaPoints,
    spline::{self, SplineEnd, SplineEnds},
};
use serde_json::Value;

/// Largest difference, as a share of the largest value of the derivative in its case: both sides solve a
/// well-conditioned system, then divide by durations of 0.1 s or more up to three times.
const TOLERANCE: f64 = 1e-9;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|x| x.as_f64().expect("of numbers")).collect()
}

fn lists(value: &Value) -> Vec<Vec<f64>> {
    value.as_array().expect("a list").iter().map(numbers).collect()
}

fn end(value: &Value) -> SplineEnd {
    match value["kind"].as_str().expect("a word") {
        "velocity" => SplineEnd::Velocity(numbers(&value["values"])),
        "acceleration" => SplineEnd::Acceleration(numbers(&value["values"])),
        "natural" => SplineEnd::Natural,
        "not_a_knot" => SplineEnd::NotAKnot,
        other => panic!("{other} is not an end condition"),
    }
}

#[test]
fn splines_are_those_of_scipy_under_every_end_condition() {
    let oracle: Value =
        serde_json::from_str(include_str!("../../../../tests/oracles/splines.json")).expect("JSON");
    let cases = oracle["cases"].as_array().expect("cases");
    assert_eq!(cases.len(), 5 * (4 * 4 + 1));
    for case in cases {
        let ends = match case["start"]["kind"].as_str() {
            Some("periodic") => SplineEnds::Periodic,
            _ => SplineEnds::Each { start: end(&case["start"]), end: end(&case["end"]) },
        };
        let times = numbers(&case["times"]);
        let points = ViaPoints::new(times.clone(), lists(&case["positions"])).unwrap();
        let motion = spline::through(&points, &ends).unwrap();
        assert!(motion.breaks().is_empty(), "{ends:?}: {:?}", motion.breaks());
        let values: Vec<Vec<Vec<f64>>> =
            case["values"].as_array().expect("a list").iter().map(lists).collect();
        assert_eq!(values.len(), times.len() - 1);
        for order in 0..4 {
            let all = values.iter().flat_map(|at_place| &at_place[order]);
            let scale = all.fold(1.0, |scale: f64, value| scale.max(value.abs()));
            for (&t, expected) in numbers(&case["at"]).iter().zip(&values) {
                let state = motion.eval(t - times[0]);
                let found = [&state.q, &state.qd, &state.qdd, &state.qddd][order];
                for (a, b) in found.iter().zip(&expected[order]) {
                    let difference = (a - b).abs() / scale;
                    assert!(
                        difference < TOLERANCE,
                        "{ends:?}, {} points, derivative {order} at {t} s: {a} is not {b}",
                        times.len()
                    );
                }
            }
        }
    }
}
