//! The task `path`: lines, screws, arcs and polylines of the tool.

use graspcheck_model::{
    robot::RobotModel,
    task::{PathCorner, PathSegment, PathShape, PathTask},
};
use nalgebra::Vector3;

use crate::{
    fault::Fault,
    quantity::Quantity,
    section::{Bound, Section, numbers, wrong_type},
    task::{PATH_TOLERANCE_DEFAULT, start_position},
    tree::Value,
};

/// The kind of a segment.
#[derive(Clone, Copy)]
enum Kind {
    Line,
    Screw,
    Arc,
    Polyline,
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
        let name = segment.required_text("name");
        if let Some((name, at)) = name {
            if names.iter().any(|other| other == name) {
                let title = format!("two segments are named `{name}`");
                segment.faults().report(Fault::new("name", at, title, "names are unique"));
            }
            names.push(name.to_owned());
        }
        let from_start = segment.word("points", &[("world", false), ("from_start", true)], Some(false));
        let kinds =
            [("line", Kind::Line), ("screw", Kind::Screw), ("arc", Kind::Arc), ("polyline", Kind::Polyline)];
        let shape = match segment.word("kind", &kinds, None) {
            Some(kind) => shape(&segment, kind),
            // Without a kind nobody knows which keys belong here.
            None => {
                segments.push(None);
                continue;
            }
        };
        segment.finish();
        let read = || Some(PathSegment { name: name?.0.to_owned(), from_start: from_start?, shape: shape? });
        segments.push(read());
    }
    if segments.is_empty() {
        let title = "a motion has at least one segment";
        section.faults().report(Fault::new("missing-key", section.place(), title, "add [[task.segment]]"));
        return (names, None);
    }
    let segments = segments.into_iter().collect::<Option<Vec<_>>>();
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
    }
}

/// Reads `points_mm`, a list of points.
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
