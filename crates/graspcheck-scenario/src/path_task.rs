//! The task `path`: lines, screws, arcs, polylines and splines of the tool.

use graspcheck_model::{
    robot::RobotModel,
    task::{PathCorner, PathSegment, PathShape, PathTask},
    via::EndCondition,
};
use nalgebra::Vector3;

use crate::{
    fault::Fault,
    quantity::Quantity,
    section::{Bound, Section, number, numbers, wrong_type},
    task::{PATH_TOLERANCE_DEFAULT, at_least_one, segment_name, start_position},
    tree::Value,
};

/// The kind of a segment.
#[derive(Clone, Copy)]
enum Kind {
    Line,
    Screw,
    Arc,
    Polyline,
    Spline,
}

/// How corners are made.
#[derive(Clone, Copy)]
enum Corner {
    Sharp,
    Arc,
    Blend,
}

/// Reads the task; the names of its phases are known even where the rest has faults.
pub(crate) fn path(section: &Section<'_>, robot: Option<&RobotModel>) -> (Vec<String>, Option<PathTask>) {
    let start = start_position(section, robot);
    let tolerance =
        section.measure_or("path_tolerance", Quantity::Length, Bound::Positive, PATH_TOLERANCE_DEFAULT);
    let mut names: Vec<String> = Vec::new();
    let mut segments: Vec<Option<PathSegment>> = Vec::new();
    for segment in section.sections("segment", "a segment") {
        let name = segment_name(&segment, &mut names);
        let from_start = segment.word("points", &[("world", false), ("from_start", true)], Some(false));
        let kinds = [
            ("line", Kind::Line),
            ("screw", Kind::Screw),
            ("arc", Kind::Arc),
            ("polyline", Kind::Polyline),
            ("spline", Kind::Spline),
        ];
        let shape = match segment.word("kind", &kinds, None) {
            Some(kind) => shape(&segment, kind),
            // Without a kind nobody knows which keys belong here.
            None => {
                segments.push(None);
                continue;
            }
        };
        segment.finish();
        let read = || Some(PathSegment { name: name?, from_start: from_start?, shape: shape? });
        segments.push(read());
    }
    let segments = at_least_one(section, segments);
    let read = || Some(PathTask { start: start?, tolerance: tolerance?, segments: segments? });
    (names, read())
}

/// Reads where a segment leads.
fn shape(segment: &Section<'_>, kind: Kind) -> Option<PathShape> {
    match kind {
        Kind::Line | Kind::Screw => {
            let to = segment.required_vector("to", Quantity::Length);
            let turn = segment.measure_or("turn", Quantity::Angle, Bound::Any, 0.0);
            let (to, turn) = (to?, turn?);
            Some(match kind {
                Kind::Line => PathShape::Line { to, turn },
                _ => PathShape::Screw { to, turn },
            })
        }
        Kind::Arc => {
            let turns_along = segment.word("turn", &[("fixed", false), ("along", true)], Some(false));
            if segment.mentions("center") {
                let center = segment.required_vector("center", Quantity::Length);
                let angle = segment.required_measure("angle", Quantity::Angle, Bound::Any);
                Some(PathShape::ArcAbout { center: center?, angle: angle?, turns_along: turns_along? })
            } else {
                let through = segment.required_vector("through", Quantity::Length);
                let to = segment.required_vector("to", Quantity::Length);
                Some(PathShape::ArcThrough { through: through?, to: to?, turns_along: turns_along? })
            }
        }
        Kind::Polyline => {
            let points = points(segment);
            let corners = [("sharp", Corner::Sharp), ("arc", Corner::Arc), ("blend", Corner::Blend)];
            let corner = match segment.word("corner", &corners, Some(Corner::Sharp)) {
                Some(Corner::Sharp) => Some(PathCorner::Sharp),
                Some(Corner::Arc) => {
                    let radius = segment.required_measure("corner_radius", Quantity::Length, Bound::Positive);
                    radius.map(PathCorner::Arc)
                }
                Some(Corner::Blend) => {
                    let miss =
                        segment.required_measure("corner_tolerance", Quantity::Length, Bound::Positive);
                    miss.map(PathCorner::Blend)
                }
                None => None,
            };
            Some(PathShape::Polyline { points: points?, corner: corner? })
        }
        Kind::Spline => {
            let points = points(segment);
            let turns = match segment.mentions("turn") {
                true => turns(segment, points.as_ref().map(Vec::len)),
                false => points.as_ref().map(|points| vec![0.0; points.len()]),
            };
            let words = [
                ("natural", EndCondition::Natural),
                ("not_a_knot", EndCondition::NotAKnot),
                ("periodic", EndCondition::Periodic),
            ];
            let ends = segment.word("spline_ends", &words, Some(EndCondition::Natural));
            Some(PathShape::Spline { points: points?, turns: turns?, ends: ends? })
        }
    }
}

/// Reads `turn_deg`, a list of an angle for each of so many points.
fn turns(segment: &Section<'_>, count: Option<usize>) -> Option<Vec<f64>> {
    let (key, entry, to_si) = segment.with_unit("turn", Quantity::Angle)?;
    let Value::Array(nodes) = &entry.node.value else {
        wrong_type(&key, &entry.node, "a list of angles", segment.faults());
        return None;
    };
    if count.is_some_and(|count| count != nodes.len()) {
        let title = format!("{key} has {} angles for {} points", nodes.len(), count.unwrap_or(0));
        let fault = Fault::new("range", &entry.node.at, title, "give one for each point of `at`");
        segment.faults().report(fault);
        return None;
    }
    nodes.iter().map(|node| number(&key, node, Bound::Any, segment.faults()).map(to_si)).collect()
}

/// Reads `at_mm`, a list of points.
fn points(segment: &Section<'_>) -> Option<Vec<Vector3<f64>>> {
    if !segment.mentions("at") {
        segment.missing(&Quantity::Length.key("at"));
    }
    let (key, entry, to_si) = segment.with_unit("at", Quantity::Length)?;
    let Value::Array(nodes) = &entry.node.value else {
        wrong_type(&key, &entry.node, "a list of points", segment.faults());
        return None;
    };
    if nodes.is_empty() {
        let title = format!("{key} has no point");
        segment.faults().report(Fault::new("range", &entry.node.at, title, "add [x, y, z]"));
        return None;
    }
    let read =
        |node| numbers(&key, node, segment.faults()).map(|point: [f64; 3]| Vector3::from(point.map(to_si)));
    nodes.iter().map(read).collect()
}
