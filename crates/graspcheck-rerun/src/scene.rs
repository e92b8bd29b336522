//! The scene: solids and lines of the markers, moved by their frames, and where violations are.

use std::collections::BTreeMap;

use graspcheck_recording::{ContactSample, Marker, MarkerShape, PoseSeries, Recording, recording::PoseRow};
use rerun::{
    Arrows3D, Boxes3D, Color, Cylinders3D, Ellipsoids3D, EntityPath, EntityPathPart, FillMode, LineStrips3D,
    Mesh3D, Points3D, Radius, RecordingStream, RecordingStreamError, Transform3D, ViewCoordinates,
    datatypes::Quaternion,
};

use crate::{
    RED, Run, color, nanoseconds, times,
    verdict::{Check, Outcome},
};

/// The root of the tree of frames.
const WORLD: &str = "world";

/// Points of a path beyond which only every second, third … is drawn.
const MOST_PATH_POINTS: usize = 2000;

/// By how much the red stretch of the path is longer than the violation on each side, s.
const STRETCH_PADDING: f64 = 0.012;

/// Between two arrows of a contact, ns.
const ARROW_PERIOD: i64 = 10_000_000;

/// Length of the arrow of a force, m/N.
const ARROW_SCALE: f64 = 0.01;

/// Green: forces and the tightest place of a run that passes.
const FORCE_AND_ROOM: u32 = 0x006f_c281;

/// The least force that has an arrow, N.
const LEAST_FORCE: f64 = 0.01;

pub(crate) fn log(stream: &RecordingStream, run: &Run) -> Result<(), RecordingStreamError> {
    stream.log_static(WORLD, &ViewCoordinates::RIGHT_HAND_Z_UP())?;
    let entities = frame_entities(run.recording);
    log_frames(stream, run.recording, &entities)?;
    log_markers(stream, run.recording, &entities)?;
    log_tool_path(stream, &run.recording.tool)?;
    log_contacts(stream, run)?;
    if let Some(verdict) = run.verdict {
        for check in verdict.failing() {
            log_failure(stream, run.recording, check)?;
        }
        let clearance = verdict.checks.iter().find(|check| check.check == "planned.clearance");
        if let Some(check) = clearance.filter(|_| verdict.outcome == Outcome::Pass) {
            let tightest = path([WORLD, "proof", "tightest"]);
            log_place(stream, run.recording, check, tightest, color(FORCE_AND_ROOM))?;
        }
    }
    Ok(())
}

/// The entity of each frame: `world/<namespace>/<frame>` for a frame in the world that markers are fixed to,
/// below its parent for others.
fn frame_entities(recording: &Recording) -> BTreeMap<&str, EntityPath> {
    let mut entities = BTreeMap::from([(WORLD, path([WORLD]))]);
    let namespace = |frame: &str| {
        let marker = recording.markers.iter().find(|marker| marker.frame == frame);
        marker.map_or("frame", |marker| &marker.namespace)
    };
    // A frame may stand before its parent; each round places at least one, or the rest has no root.
    let mut waiting: Vec<_> = recording.frames.iter().collect();
    loop {
        let before = waiting.len();
        waiting.retain(|frame| {
            let Some(parent) = entities.get(&*frame.parent) else { return true };
            let entity = match &*frame.parent {
                WORLD => below(&below(parent, namespace(&frame.child)), &frame.child),
                _ => below(parent, &frame.child),
            };
            entities.insert(&frame.child, entity);
            false
        });
        if waiting.len() == before {
            return entities;
        }
    }
}

fn log_frames(
    stream: &RecordingStream,
    recording: &Recording,
    entities: &BTreeMap<&str, EntityPath>,
) -> Result<(), RecordingStreamError> {
    for frame in &recording.frames {
        let Some(entity) = entities.get(&*frame.child) else { continue };
        if let ([_], [pose]) = (&*frame.time_ns, &*frame.pose) {
            let transform =
                Transform3D::new().with_translation(position(pose)).with_quaternion(quaternion(pose));
            stream.log_static(entity.clone(), &transform)?;
            continue;
        }
        let transforms = Transform3D::update_fields()
            .with_many_translation(frame.pose.iter().map(position))
            .with_many_quaternion(frame.pose.iter().map(quaternion));
        stream.send_columns(
            entity.clone(),
            [times(frame.time_ns.iter().copied())],
            transforms.columns_of_unit_batches()?,
        )?;
    }
    Ok(())
}

/// Each marker below its frame; one that is fixed to a frame without a place is left out.
fn log_markers(
    stream: &RecordingStream,
    recording: &Recording,
    entities: &BTreeMap<&str, EntityPath>,
) -> Result<(), RecordingStreamError> {
    let mut used: BTreeMap<EntityPath, usize> = BTreeMap::new();
    for marker in &recording.markers {
        let Some(frame) = entities.get(&*marker.frame) else { continue };
        // A link of several solids has one entity for each, and the link's own frame above them.
        let entity = match &*marker.frame {
            WORLD => below(&below(frame, &marker.namespace), &marker.name),
            name if name == marker.name => frame.clone(),
            _ => below(frame, &marker.name),
        };
        let number = used.entry(entity.clone()).or_default();
        *number += 1;
        let entity = if *number == 1 { entity } else { below(&entity, &number.to_string()) };
        log_marker(stream, entity, marker)?;
    }
    Ok(())
}

fn log_marker(
    stream: &RecordingStream,
    entity: EntityPath,
    marker: &Marker,
) -> Result<(), RecordingStreamError> {
    let center = position(&marker.pose);
    let rotation = quaternion(&marker.pose);
    let color = marker_color(marker);
    match &marker.shape {
        MarkerShape::Box { size } => stream.log_static(
            entity,
            &Boxes3D::from_centers_and_sizes([center], [size.map(|length| length as f32)])
                .with_quaternions([rotation])
                .with_colors([color])
                .with_fill_mode(FillMode::Solid),
        ),
        MarkerShape::Sphere { radius } => stream.log_static(
            entity,
            &Ellipsoids3D::from_centers_and_radii([center], [*radius as f32])
                .with_colors([color])
                .with_fill_mode(FillMode::Solid),
        ),
        MarkerShape::Cylinder { radius, length } => stream.log_static(
            entity,
            &Cylinders3D::from_lengths_and_radii([*length as f32], [*radius as f32])
                .with_centers([center])
                .with_quaternions([rotation])
                .with_colors([color])
                .with_fill_mode(FillMode::Solid),
        ),
        MarkerShape::Triangles { points } => {
            let corners: Vec<[f32; 3]> = points.iter().map(|point| moved(&marker.pose, point)).collect();
            let normals: Vec<[f32; 3]> =
                corners.chunks_exact(3).flat_map(|corners| [normal(corners); 3]).collect();
            stream.log_static(
                entity,
                &Mesh3D::new(corners).with_vertex_normals(normals).with_albedo_factor(color.0),
            )
        }
        MarkerShape::Line { points, .. } => {
            let points = points.iter().map(|point| moved(&marker.pose, point));
            stream.log_static(entity, &line(points, 1.5, color))
        }
    }
}

/// The executed path, white over the planned one.
fn log_tool_path(stream: &RecordingStream, tool: &PoseSeries) -> Result<(), RecordingStreamError> {
    if tool.pose.len() < 2 {
        return Ok(());
    }
    let stride = tool.pose.len().div_ceil(MOST_PATH_POINTS);
    let points = tool.pose.iter().step_by(stride).chain(tool.pose.last()).map(position);
    stream.log_static("world/run/tool_path", &line(points, 1.0, color(0x00ff_ffff)))
}

/// The normal force of each pair at its deepest point, every 10 ms.
fn log_contacts(stream: &RecordingStream, run: &Run) -> Result<(), RecordingStreamError> {
    let mut pairs: BTreeMap<(&str, &str), BTreeMap<i64, &ContactSample>> = BTreeMap::new();
    for contact in &run.recording.contacts {
        if contact.normal_force_n >= LEAST_FORCE {
            let rows = pairs.entry((&contact.body_a, &contact.body_b)).or_default();
            rows.entry(contact.time_ns / ARROW_PERIOD).or_insert(contact);
        }
    }
    for ((a, b), rows) in pairs {
        // A step without contact has no arrow, or the last one would stay.
        let steps: Vec<i64> = (0..=run.end_ns / ARROW_PERIOD).collect();
        let vector = |contact: &ContactSample| {
            contact.normal.map(|axis| (axis * contact.normal_force_n * ARROW_SCALE) as f32)
        };
        let arrows = Arrows3D::update_fields()
            .with_vectors(rows.values().map(|contact| vector(contact)))
            .with_origins(rows.values().map(|contact| contact.point.map(|axis| axis as f32)));
        let lengths = steps.iter().map(|step| usize::from(rows.contains_key(step)));
        let entity = below(&path([WORLD, "contact"]), &format!("{a} - {b}"));
        stream.log_static(
            entity.clone(),
            &Arrows3D::update_fields()
                .with_colors([color(0x006f_c281)])
                .with_radii([Radius::new_ui_points(1.5)]),
        )?;
        stream.send_columns(
            entity,
            [times(steps.iter().map(|step| step * ARROW_PERIOD))],
            arrows.columns(lengths)?,
        )?;
    }
    Ok(())
}

/// Where a check is violated: the place of the tool with the value, and the stretch of its path.
fn log_failure(
    stream: &RecordingStream,
    recording: &Recording,
    check: &Check,
) -> Result<(), RecordingStreamError> {
    let tool = judged_tool(recording, check);
    let Some([first, last]) = check.interval().filter(|_| !tool.pose.is_empty()) else { return Ok(()) };
    let entity = below(&path([WORLD, "fail"]), &check.check);
    let stretch = &tool.pose[row_at(tool, first - STRETCH_PADDING)..=row_at(tool, last + STRETCH_PADDING)];
    if stretch.len() > 1 {
        let points = stretch.iter().map(position);
        stream.log_static(below(&entity, "tool_path"), &line(points, 3.0, color(RED)))?;
    }
    log_place(stream, recording, check, below(&entity, "place"), color(RED))
}

/// Where the tool is when a check is worst, with the value; short, since long labels cover the scene.
fn log_place(
    stream: &RecordingStream,
    recording: &Recording,
    check: &Check,
    entity: EntityPath,
    color: Color,
) -> Result<(), RecordingStreamError> {
    let tool = judged_tool(recording, check);
    let Some(time) = check.time.filter(|_| !tool.pose.is_empty()) else { return Ok(()) };
    let place = Points3D::new([position(&tool.pose[row_at(tool, time)])])
        .with_radii([Radius::new_ui_points(6.0)])
        .with_colors([color])
        .with_labels([check.word("value").to_owned()]);
    stream.log_static(entity, &place)
}

/// The path that a check judges: a plan is judged where it was planned.
fn judged_tool<'a>(recording: &'a Recording, check: &Check) -> &'a PoseSeries {
    if check.check.starts_with("planned") && !recording.reference_tool.pose.is_empty() {
        &recording.reference_tool
    } else {
        &recording.tool
    }
}

/// The first row at or after a time in s, or the last row; the series is not empty.
fn row_at(tool: &PoseSeries, time: f64) -> usize {
    tool.time_ns.partition_point(|&at| at < nanoseconds(time)).min(tool.pose.len() - 1)
}

fn path<'a>(parts: impl IntoIterator<Item = &'a str>) -> EntityPath {
    parts.into_iter().map(EntityPathPart::new).collect::<Vec<_>>().into()
}

fn below(entity: &EntityPath, name: &str) -> EntityPath {
    entity.join(&path([name]))
}

fn line(points: impl IntoIterator<Item = [f32; 3]>, ui_points: f32, color: Color) -> LineStrips3D {
    LineStrips3D::new([points.into_iter().collect::<Vec<_>>()])
        .with_radii([Radius::new_ui_points(ui_points)])
        .with_colors([color])
}

fn position(pose: &PoseRow) -> [f32; 3] {
    [pose[0] as f32, pose[1] as f32, pose[2] as f32]
}

fn quaternion(pose: &PoseRow) -> Quaternion {
    Quaternion::from_xyzw([pose[3] as f32, pose[4] as f32, pose[5] as f32, pose[6] as f32])
}

/// A point that is given in the frame of `pose`: p + 2 w (u × x) + 2 u × (u × x), with u the vector part.
fn moved(pose: &PoseRow, point: &[f64; 3]) -> [f32; 3] {
    let u = [pose[3], pose[4], pose[5]];
    let once = cross(u, *point);
    let twice = cross(u, once);
    std::array::from_fn(|axis| (pose[axis] + point[axis] + 2.0 * (pose[6] * once[axis] + twice[axis])) as f32)
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The unit normal of a triangle; zero when it has no area.
fn normal(corners: &[[f32; 3]]) -> [f32; 3] {
    let edge = |to: usize| std::array::from_fn(|axis| f64::from(corners[to][axis] - corners[0][axis]));
    let normal = cross(edge(1), edge(2));
    let length = normal.iter().map(|axis| axis * axis).sum::<f64>().sqrt();
    if length > 0.0 { normal.map(|axis| (axis / length) as f32) } else { [0.0; 3] }
}

pub(crate) fn marker_color(marker: &Marker) -> Color {
    let [red, green, blue, alpha] = marker.color.map(|share| (share.clamp(0.0, 1.0) * 255.0).round() as u8);
    Color::from_unmultiplied_rgba(red, green, blue, alpha)
}

#[cfg(test)]
mod tests {
    use graspcheck_recording::FrameSeries;

    use super::*;

    #[test]
    fn a_point_is_turned_and_moved() {
        // A quarter turn about z takes x to y.
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let pose = [1.0, 2.0, 3.0, 0.0, 0.0, half, half];
        let point = moved(&pose, &[0.5, 0.0, 0.25]);
        let expected = [1.0, 2.5, 3.25];
        assert!(point.iter().zip(expected).all(|(a, b): (&f32, f32)| (a - b).abs() < 1e-6), "{point:?}");
    }

    #[test]
    fn frames_have_entities_below_their_parents_in_any_order() {
        let frame = |parent: &str, child: &str| FrameSeries {
            parent: parent.to_owned(),
            child: child.to_owned(),
            ..FrameSeries::default()
        };
        let recording = Recording {
            frames: vec![frame("link 1", "link 2"), frame("world", "link 1"), frame("nowhere", "lost")],
            markers: vec![Marker {
                namespace: "robot".to_owned(),
                name: "link 1".to_owned(),
                frame: "link 1".to_owned(),
                pose: [0.0; 7],
                shape: MarkerShape::Sphere { radius: 1.0 },
                color: [0.0; 4],
            }],
            ..Recording::default()
        };
        let entities = frame_entities(&recording);
        assert_eq!(entities["link 2"], path(["world", "robot", "link 1", "link 2"]));
        assert_eq!(entities.get("lost"), None);
    }
}
