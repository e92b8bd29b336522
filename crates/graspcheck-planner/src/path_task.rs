//! Leading the tool along lines, screws, arcs, polylines and splines.
//!
//! Each path begins where the one before it ended and is a phase of its own, from rest to rest. The tool is proved to
//! stay within the tolerance of each; the plan keeps path and law, so that whoever reads it can prove it again.

use graspcheck_model::{
    Pose,
    object::Object,
    plan::{Holding, Plan, PlannedPath, TrackedPoint},
    robot::RobotModel,
    task::{Pace, PathCorner, PathSegment, PathShape, PathTask},
};
use graspcheck_proof::deviation::Deviation;
use nalgebra::{Unit, UnitQuaternion, Vector3};

use crate::{
    Planned,
    arm::Arm,
    error::PlanError,
    input::{check_joint_count, check_number},
    opening::idle,
    pace::{CheckedPace, PhaseNames},
    path::{
        PathError, ToolPath,
        arc::{ArcTurn, arc_about, arc_through},
        line::straight_line_turning,
        motion::along_path,
        rounded_polyline::{Corner, rounded_polyline},
        screw::screw_motion,
        spline::through_points,
    },
    sequence::Sequence,
    via_motion::spline_ends,
};

/// Plans the paths. An object that there is stays where it stands.
pub(crate) fn find(
    robot: &RobotModel,
    object: Option<&Object>,
    task: &PathTask,
    pace: &Pace,
) -> Result<Planned, PlanError> {
    let names: Vec<&str> = task.segments.iter().map(|segment| segment.name.as_str()).collect();
    if names.is_empty() {
        return Err(PlanError::NoSegment);
    }
    let pace = CheckedPace::new(pace, PhaseNames { all: &names, joint_moves: &[] })?;
    check_joint_count("start", &task.start, robot.dof())?;
    check_number("tolerance, m and rad", task.tolerance, task.tolerance > 0.0, "finite and positive")?;
    let tolerance = Deviation { position: task.tolerance, angle: task.tolerance };
    let arm = Arm::new(robot).map_err(PlanError::NoInverse)?;
    let holding = if object.is_some() { Holding::AtStart } else { Holding::Nothing };
    let mut sequence = Sequence::default();
    let mut q = task.start.clone();
    let mut paths = Vec::with_capacity(task.segments.len());
    for PathSegment { name, from_start, shape } in &task.segments {
        let world_from_tool = robot.world_from_tool(&q);
        let origin = if *from_start { world_from_tool.translation.vector } else { Vector3::zeros() };
        let path = tool_path(&world_from_tool, &origin, &up(robot), shape)
            .map_err(|error| PlanError::Path { phase: name.clone(), error })?;
        let found = along_path(&arm, &path, &q, pace.share(name), pace.duration(name), tolerance)
            .map_err(|error| PlanError::Along { phase: name.clone(), error })?;
        q = found.motion.eval(found.motion.duration()).q;
        sequence.add(name, &found.motion, holding)?;
        let phase = name.clone();
        let (point, law) = (TrackedPoint::Tool, found.law);
        paths.push(PlannedPath { phase, path, point, law, tolerance: task.tolerance });
    }
    let (trajectory, phases) = sequence.finish()?;
    let opening = idle(&robot.gripper, trajectory.duration())?;
    Ok(Planned::without_proof(Plan { trajectory, opening, phases, grasp: None, paths }))
}

/// The base's z axis in the world.
fn up(robot: &RobotModel) -> Unit<Vector3<f64>> {
    robot.world_from_base.rotation * Vector3::z_axis()
}

/// The path of this shape from where the tool is, with its points counted from `origin`.
fn tool_path(
    world_from_tool: &Pose,
    origin: &Vector3<f64>,
    up: &Unit<Vector3<f64>>,
    shape: &PathShape,
) -> Result<ToolPath, PathError> {
    let turned = |to: &Vector3<f64>, turn: f64| {
        let rotation = UnitQuaternion::from_axis_angle(up, turn) * world_from_tool.rotation;
        Pose::from_parts((to + origin).into(), rotation)
    };
    let arc_turn = |turns_along: bool| if turns_along { ArcTurn::Along } else { ArcTurn::Fixed };
    match shape {
        PathShape::Line { to, turn } => straight_line_turning(world_from_tool, &turned(to, *turn), up, *turn),
        PathShape::Screw { to, turn } => screw_motion(world_from_tool, &turned(to, *turn)),
        PathShape::ArcThrough { through, to, turns_along } => {
            arc_through(world_from_tool, &(through + origin), &(to + origin), arc_turn(*turns_along))
        }
        PathShape::ArcAbout { center, angle, turns_along } => {
            arc_about(world_from_tool, &(center + origin), up, *angle, arc_turn(*turns_along))
        }
        PathShape::Polyline { points, corner } => {
            let vertices: Vec<Pose> = std::iter::once(*world_from_tool)
                .chain(points.iter().map(|point| turned(point, 0.0)))
                .collect();
            let corner = match *corner {
                PathCorner::Sharp => Corner::Sharp,
                PathCorner::Arc(radius) => Corner::Arc { radius },
                PathCorner::Blend(tolerance) => Corner::Blend { tolerance },
            };
            rounded_polyline(&vertices, corner)
        }
        PathShape::Spline { points, turns, ends } => {
            let start = world_from_tool.translation.vector;
            let through = std::iter::once(start).chain(points.iter().map(|point| point + origin));
            let angles: Vec<f64> = std::iter::once(0.0).chain(turns.iter().copied()).collect();
            // x, y, z and the angle.
            let ends = spline_ends(*ends, &[0.0; 4]);
            through_points(&through.collect::<Vec<_>>(), &angles, &world_from_tool.rotation, up, &ends)
        }
    }
}
