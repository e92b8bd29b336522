//! The motion as a picture: poses of the arm at equal travel of the tool, the cell, and the failing pose.

use graspcheck_model::{Pose, shape::Shape};
use graspcheck_recording::PoseSeries;
use graspcheck_verify::Evidence;
use maud::{Markup, html};
use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};

use super::plot::{number, round_step};

/// Poses that are drawn, about; more become a blot.
const POSES: f64 = 28.0;

/// Directions in which the outline of a solid is found: with 36 the outline of a circle is off by 0.4 %.
const DIRECTIONS: usize = 36;

/// A tool path thinner than this across a picture has no need of another one, m.
const FLAT: f64 = 1e-3;

const WIDTH: f64 = 560.0;
const HEIGHT: f64 = 420.0;

/// Where arm and object are at an instant.
struct Instant {
    t: f64,
    /// From the base over every joint to the tool.
    arm: Vec<Point3<f64>>,
    object: Option<Pose>,
}

/// What a picture looks at.
struct View {
    name: String,
    right: Vector3<f64>,
    up: Vector3<f64>,
}

/// One picture of a planar motion, two of any other; none of a plan in which the tool stands still. `failing` is
/// the instant, s, at which something fails.
pub(super) fn pictures(evidence: &Evidence, failing: Option<f64>) -> Vec<Markup> {
    let instants = instants(evidence);
    let tool: Vec<Point3<f64>> = instants.iter().filter_map(|it| it.arm.last().copied()).collect();
    let travel: f64 = tool.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
    if travel <= 0.0 {
        return Vec::new();
    }
    let step = round_step(travel / POSES);
    let views = views(evidence, &tool);
    views.iter().map(|view| picture(evidence, view, &instants, step, failing)).collect()
}

/// From above, and where the tool moves up and down by itself also from the side.
fn views(evidence: &Evidence, tool: &[Point3<f64>]) -> Vec<View> {
    let robot = &evidence.resolved.robot;
    let base = robot.world_from_base.rotation;
    let axis = robot
        .joints
        .first()
        .map_or(Vector3::z(), |joint| base * (joint.parent_from_joint.rotation * joint.axis.into_inner()));
    let extent = |direction: &Vector3<f64>| {
        let along = tool.iter().map(|point| point.coords.dot(direction));
        let [low, high] = along
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [f64::min(low, v), f64::max(high, v)]);
        high - low
    };
    // The picture plane of the first axis, with up against gravity where that lies in it.
    let gravity = evidence.resolved.cell.gravity;
    let across = |v: Vector3<f64>| v - axis * v.dot(&axis);
    let up = [-gravity, Vector3::y(), Vector3::x()].into_iter().map(across).find(|up| up.norm() > 1e-6);
    let up = up.unwrap_or_else(Vector3::y).normalize();
    let right = up.cross(&axis);
    let [x, y] = [&right, &up].map(direction);
    let along = if axis.dot(&gravity) < 0.0 && across(gravity).norm() < 1e-6 {
        "from above"
    } else {
        "along the first axis"
    };
    let mut views = vec![View { name: format!("{along} ({x} right, {y} up)"), right, up }];
    if extent(&axis) > FLAT {
        let side = if extent(&right) >= extent(&up) { right } else { up };
        let name = format!("from the side ({} right, {} up)", direction(&side), direction(&axis));
        views.push(View { name, right: side, up: axis });
    }
    views
}

/// The name of a direction of the world, such as `x` or `-y`; `oblique` for any other.
fn direction(of: &Vector3<f64>) -> &'static str {
    let named = [
        (Vector3::x(), "x"),
        (Vector3::y(), "y"),
        (Vector3::z(), "z"),
        (-Vector3::x(), "-x"),
        (-Vector3::y(), "-y"),
        (-Vector3::z(), "-z"),
    ];
    named.into_iter().find(|(axis, _)| (of - axis).norm() < 1e-6).map_or("oblique", |(_, name)| name)
}

/// Every recorded step, or a thousand instants of a plan that was not executed.
fn instants(evidence: &Evidence) -> Vec<Instant> {
    let robot = &evidence.resolved.robot;
    let dof = robot.dof();
    let arm = |q: &[f64]| {
        let links = robot.forward(q);
        let mut points = vec![Point3::from(robot.world_from_base.translation.vector)];
        points.extend(links.iter().map(|pose| Point3::from(pose.translation.vector)));
        points.push(Point3::from(robot.world_from_tool(q).translation.vector));
        points
    };
    let recording = evidence.recording;
    if recording.measured.is_empty() {
        let duration = evidence.plan.trajectory.duration();
        return (0..=1000)
            .map(|k| (duration * f64::from(k) / 1000.0).min(duration))
            .map(|t| Instant { t, arm: arm(&evidence.plan.trajectory.eval(t).q), object: None })
            .collect();
    }
    let is_finite = |row: &usize| recording.measured.position_row(*row).iter().all(|q| q.is_finite());
    (0..recording.measured.len())
        .filter(is_finite)
        .map(|row| Instant {
            t: super::plots::seconds(recording.measured.time_ns[row]),
            arm: arm(&recording.measured.position_row(row)[..dof]),
            object: pose_row(&recording.object, row),
        })
        .collect()
}

fn pose_row(series: &PoseSeries, row: usize) -> Option<Pose> {
    let [x, y, z, i, j, k, w] = *series.pose.get(row)?;
    let turn = UnitQuaternion::try_new(Quaternion::new(w, i, j, k), 1e-9)?;
    Some(Isometry3::from_parts(Translation3::new(x, y, z), turn))
}

fn picture(
    evidence: &Evidence,
    view: &View,
    instants: &[Instant],
    step: f64,
    failing: Option<f64>,
) -> Markup {
    let flat = |point: &Point3<f64>| [point.coords.dot(&view.right), point.coords.dot(&view.up)];
    let object = evidence.resolved.object.as_ref();
    let worst =
        failing.and_then(|t| instants.iter().min_by(|a, b| (a.t - t).abs().total_cmp(&(b.t - t).abs())));
    let poses = at_equal_travel(instants, step);
    let points = poses.iter().flat_map(|instant| &instant.arm).map(flat);
    let [mut low, mut high] = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    for point in points {
        for axis in 0..2 {
            low[axis] = low[axis].min(point[axis]);
            high[axis] = high[axis].max(point[axis]);
        }
    }
    let scale = 0.86 * f64::min(WIDTH / (high[0] - low[0]).max(1e-3), HEIGHT / (high[1] - low[1]).max(1e-3));
    let place = |[x, y]: [f64; 2]| {
        let at = |v: f64, low: f64, high: f64| scale * (v - 0.5 * (low + high));
        [0.5 * WIDTH + at(x, low[0], high[0]), 0.5 * HEIGHT - at(y, low[1], high[1])]
    };
    let line = |points: &[Point3<f64>]| text(points.iter().map(|point| place(flat(point))));
    let outline = |shape: &Shape, pose: &Pose| {
        text(outline(shape, pose, view).into_iter().map(|point| place(flat(&point))))
    };
    let tool: Vec<Point3<f64>> = instants.iter().filter_map(|it| it.arm.last().copied()).collect();
    let tool = thinned(&tool, 1.5 / scale);
    html! {
        figure {
            figcaption { (view.name) " · every " (number(1e3 * step)) " mm of the tool's travel" }
            svg.picture viewBox=(format!("0 0 {WIDTH} {HEIGHT}")) role="img" {
                title { "the motion " (view.name) }
                @for body in &evidence.resolved.cell.bodies {
                    polygon.body points=(outline(&body.shape, &body.world_from_shape)) { title { (body.name) } }
                }
                @for instant in &poses {
                    polyline.arm points=(line(&instant.arm)) {}
                    @if let (Some(object), Some(pose)) = (object, &instant.object) {
                        polygon.object points=(outline(&object.shape, pose)) {}
                    }
                }
                polyline.tool points=(line(&tool)) {}
                @if let Some(instant) = worst {
                    polyline.failing points=(line(&instant.arm)) {}
                    @if let (Some(object), Some(pose)) = (object, &instant.object) {
                        polygon.failing points=(outline(&object.shape, pose)) {}
                    }
                    @if let Some([x, y]) = instant.arm.last().map(|tool| place(flat(tool))) {
                        text.failing x=(format!("{:.1}", (x + 8.0).min(WIDTH - 60.0))) y=(format!("{:.1}", y - 6.0)) {
                            (format!("{:.3} s", instant.t))
                        }
                    }
                }
            }
        }
    }
}

fn text(points: impl Iterator<Item = [f64; 2]>) -> String {
    points.map(|[x, y]| format!("{x:.1},{y:.1}")).collect::<Vec<_>>().join(" ")
}

/// The first instant, and then one whenever the tool has travelled by `step`, m.
fn at_equal_travel(instants: &[Instant], step: f64) -> Vec<&Instant> {
    let mut chosen: Vec<&Instant> = Vec::new();
    let (mut since, mut before): (f64, Option<&Instant>) = (step, None);
    for instant in instants {
        if let Some(before) = before
            && let (Some(a), Some(b)) = (before.arm.last(), instant.arm.last())
        {
            since += (b - a).norm();
        }
        if since >= step {
            chosen.push(instant);
            since = 0.0;
        }
        before = Some(instant);
    }
    chosen
}

/// Points that are at least `distance` apart, and the last.
fn thinned(points: &[Point3<f64>], distance: f64) -> Vec<Point3<f64>> {
    let mut kept: Vec<Point3<f64>> = Vec::new();
    for point in points {
        if kept.last().is_none_or(|last| (point - last).norm() >= distance) {
            kept.push(*point);
        }
    }
    kept.extend(points.last());
    kept
}

/// The points of a solid that are outermost in the picture, around it.
fn outline(shape: &Shape, world_from_shape: &Pose, view: &View) -> Vec<Point3<f64>> {
    let mut points: Vec<Point3<f64>> = Vec::new();
    for k in 0..DIRECTIONS {
        // Half a step aside, so that no direction is along an edge of a box that stands straight.
        let angle = std::f64::consts::TAU * (k as f64 + 0.5) / DIRECTIONS as f64;
        let direction = view.right * angle.cos() + view.up * angle.sin();
        let point = world_from_shape * shape.support(&(world_from_shape.rotation.inverse() * direction));
        if points.last().is_none_or(|last| (point - last).norm() > 1e-9) {
            points.push(point);
        }
    }
    points
}
