//! The cell: bodies, gravity, required clearances.

use graspcheck_model::cell::{CellBody, ClearanceRule, PairRule};
use nalgebra::Vector3;

use crate::{
    fault::{Fault, Place},
    quantity::Quantity,
    section::{Bound, Section},
    shape::{shape, upright_pose},
};

/// Standard acceleration of free fall, m/s² (3rd General Conference on Weights and Measures, 1901).
pub const STANDARD_GRAVITY: f64 = 9.80665;

/// The clearance that every pair must keep when the scenario does not say, m. Five times the accuracy with
/// which a cell of this size is usually set up.
pub const CLEARANCE_DEFAULT: f64 = 0.005;

/// A body, with the place of its name.
pub(crate) struct PlacedBody<'a> {
    pub(crate) body: CellBody,
    pub(crate) name_at: &'a Place,
}

/// Reads `[[cell.body]]`; none when one of them has a fault.
pub(crate) fn bodies<'a>(scenario: &Section<'a>) -> Option<Vec<PlacedBody<'a>>> {
    let Some(cell) = scenario.section("cell", "a cell") else { return Some(Vec::new()) };
    let read: Vec<_> = cell.sections("body", "a body of the cell").into_iter().map(body).collect();
    cell.finish();
    read.into_iter().collect()
}

fn body(section: Section<'_>) -> Option<PlacedBody<'_>> {
    let name = section.required_text("name");
    let shape = shape(&section);
    let world_from_shape = upright_pose(&section);
    // Read by the merging of files; here it only remains when it is false.
    let kept = section.flag("remove", false);
    section.finish();
    kept?;
    let (name, name_at) = name?;
    let body = CellBody { name: name.to_owned(), shape: shape?, world_from_shape: world_from_shape? };
    Some(PlacedBody { body, name_at })
}

/// Reads `gravity = "down"` or `gravity_m_s2 = [x, y, z]`, m/s² in the world.
pub(crate) fn gravity(scenario: &Section<'_>) -> Option<Vector3<f64>> {
    let words = [
        ("down", -Vector3::z()),
        ("table_plane", -Vector3::z()),
        ("vertical_plane", -Vector3::y()),
        ("none", Vector3::zeros()),
    ];
    let vector = scenario.entry("gravity_m_s2");
    let word = scenario.entry("gravity");
    if let (Some(vector), Some(word)) = (vector, word) {
        let fault = Fault::new("two-units", &vector.key_at, "gravity is given twice", "keep one of them");
        scenario.faults().report(fault.second(&word.key_at, "the other one"));
        return None;
    }
    match vector {
        Some(entry) => crate::section::numbers("gravity_m_s2", &entry.node, scenario.faults())
            .map(|g: [f64; 3]| g.into()),
        None => scenario.word("gravity", &words, Some(-Vector3::z())).map(|g| g * STANDARD_GRAVITY),
    }
}

/// A clearance rule, with the places of the names in it.
pub(crate) struct PlacedRule<'a> {
    pub(crate) rule: ClearanceRule,
    pub(crate) names: Vec<(&'a str, &'a Place)>,
}

/// The rule when the scenario has none.
pub(crate) fn default_clearance() -> PlacedRule<'static> {
    PlacedRule { rule: ClearanceRule { required: CLEARANCE_DEFAULT, pairs: Vec::new() }, names: Vec::new() }
}

/// Reads `[check.clearance]`.
pub(crate) fn clearance(section: Section<'_>) -> Option<PlacedRule<'_>> {
    let required = section.measure_or("required", Quantity::Length, Bound::NotNegative, CLEARANCE_DEFAULT);
    let mut names = Vec::new();
    let mut pairs = Vec::new();
    for pair in section.sections("pairs", "a pair") {
        let (a, b) = (pair.required_text("a"), pair.required_text("b"));
        let distance = pair.required_measure("required", Quantity::Length, Bound::NotNegative);
        let reason = pair.required_text("reason");
        pair.finish();
        names.extend(a.into_iter().chain(b));
        let rule = || {
            let ((a, _), (b, _), (reason, _)) = (a?, b?, reason?);
            Some(PairRule {
                a: a.to_owned(),
                b: b.to_owned(),
                required: distance?,
                reason: reason.to_owned(),
            })
        };
        pairs.push(rule());
    }
    section.finish();
    let pairs = pairs.into_iter().collect::<Option<Vec<_>>>()?;
    Some(PlacedRule { rule: ClearanceRule { required: required?, pairs }, names })
}
