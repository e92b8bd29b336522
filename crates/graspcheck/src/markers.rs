//! The solids and lines of a run as markers, so that every viewer shows the scene from the log alone.

use graspcheck_model::{
    Pose,
    plan::Plan,
    shape::{PlacedShape, Shape},
};
use graspcheck_motion::MotionState;
use graspcheck_recording::{Marker, MarkerShape};
use graspcheck_verify::Resolved;
use nalgebra::{Point3, Translation3, UnitQuaternion};

type Color = [f32; 4];

/// Colour has a meaning: what moves by itself is grey, what is grasped is amber.
const LINK: Color = [0.75, 0.76, 0.78, 1.0];
const GRIPPER: Color = [0.25, 0.27, 0.30, 1.0];
const BASE: Color = [0.45, 0.47, 0.50, 1.0];
const CELL: Color = [0.55, 0.46, 0.38, 1.0];
const OBJECT: Color = [0.95, 0.65, 0.10, 1.0];

/// The colours of the phases along the planned path, repeated when there are more phases.
const PHASES: [Color; 8] = [
    [0.35, 0.71, 0.91, 1.0],
    [0.00, 0.45, 0.70, 1.0],
    [0.94, 0.89, 0.26, 1.0],
    [0.00, 0.62, 0.45, 1.0],
    [0.80, 0.47, 0.65, 1.0],
    [0.34, 0.55, 0.80, 1.0],
    [0.90, 0.62, 0.00, 1.0],
    [0.60, 0.60, 0.60, 1.0],
];

/// Seconds between points of the planned path; a polyline for the eye, nothing is judged by it.
const PATH_STEP: f64 = 0.01;

/// Markers of the cell, the robot, the object and the planned path of the tool.
pub(crate) fn of_run(resolved: &Resolved, plan: &Plan) -> Vec<Marker> {
    let mut markers = Vec::new();
    for body in &resolved.cell.bodies {
        solid(&mut markers, "cell", &body.name, "world", &body.world_from_shape, &body.shape, CELL);
    }
    let robot = &resolved.robot;
    body(&mut markers, "robot", &robot.base.name, &robot.base.shapes, BASE);
    for (k, link) in robot.links.iter().enumerate() {
        let color = if k + 1 == robot.links.len() { GRIPPER } else { LINK };
        body(&mut markers, "robot", &link.name, &link.shapes, color);
    }
    for finger in &robot.gripper.fingers {
        body(&mut markers, "robot", &finger.link.name, &finger.link.shapes, GRIPPER);
    }
    if let Some(object) = &resolved.object {
        solid(&mut markers, "object", &object.name, &object.name, &Pose::identity(), &object.shape, OBJECT);
    }
    for (k, phase) in plan.phases.iter().enumerate() {
        let points = tool_path(resolved, plan, phase.start, phase.end);
        if points.len() > 1 {
            markers.push(Marker {
                namespace: "plan".to_owned(),
                name: phase.name.clone(),
                frame: "world".to_owned(),
                pose: row(&Pose::identity()),
                shape: MarkerShape::Line { points, width: 0.002 },
                color: PHASES[k % PHASES.len()],
            });
        }
    }
    markers
}

/// Points of the planned tool path; one point only where the tool rests.
fn tool_path(resolved: &Resolved, plan: &Plan, start: f64, end: f64) -> Vec<[f64; 3]> {
    let mut state = MotionState::zeros(resolved.robot.dof());
    let steps = ((end - start) / PATH_STEP).ceil().max(1.0) as usize;
    let mut points: Vec<[f64; 3]> = Vec::with_capacity(steps + 1);
    for k in 0..=steps {
        let t = start + (end - start) * k as f64 / steps as f64;
        plan.trajectory.eval_held(t, &mut state);
        let point = resolved.robot.world_from_tool(&state.q).translation.vector;
        let point = [point.x, point.y, point.z];
        if points.last() != Some(&point) {
            points.push(point);
        }
    }
    points
}

fn body(markers: &mut Vec<Marker>, namespace: &str, name: &str, shapes: &[PlacedShape], color: Color) {
    for placed in shapes {
        solid(markers, namespace, name, name, &placed.body_from_shape, &placed.shape, color);
    }
}

fn solid(
    markers: &mut Vec<Marker>,
    namespace: &str,
    name: &str,
    frame: &str,
    frame_from_shape: &Pose,
    shape: &Shape,
    color: Color,
) {
    let mut add = |pose: &Pose, shape: MarkerShape| {
        markers.push(Marker {
            namespace: namespace.to_owned(),
            name: name.to_owned(),
            frame: frame.to_owned(),
            pose: row(pose),
            shape,
            color,
        });
    };
    match shape {
        Shape::Box { half_extents } => {
            let size = [2.0 * half_extents.x, 2.0 * half_extents.y, 2.0 * half_extents.z];
            add(frame_from_shape, MarkerShape::Box { size });
        }
        Shape::Sphere { radius } => add(frame_from_shape, MarkerShape::Sphere { radius: *radius }),
        Shape::Cylinder { radius, half_length } => {
            add(frame_from_shape, MarkerShape::Cylinder { radius: *radius, length: 2.0 * half_length });
        }
        Shape::Capsule { radius, half_length } => {
            add(frame_from_shape, MarkerShape::Cylinder { radius: *radius, length: 2.0 * half_length });
            for end in [-*half_length, *half_length] {
                let shape_from_end =
                    Pose::from_parts(Translation3::new(0.0, 0.0, end), UnitQuaternion::identity());
                add(&(frame_from_shape * shape_from_end), MarkerShape::Sphere { radius: *radius });
            }
        }
        Shape::Hull { points } => {
            let corner = |p: &Point3<f64>| [p.x, p.y, p.z];
            let points =
                graspcheck_proof::hull_triangles(points).iter().flatten().map(corner).collect::<Vec<_>>();
            add(frame_from_shape, MarkerShape::Triangles { points });
        }
    }
}

fn row(pose: &Pose) -> [f64; 7] {
    let (p, q) = (pose.translation.vector, pose.rotation.coords);
    [p.x, p.y, p.z, q.x, q.y, q.z, q.w]
}
