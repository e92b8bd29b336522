//! `planned.task`: whether the plan does what the task asks, and whether its parts tell one story. A plan that stands
//! still keeps every limit; a proof about an object that jumps into the gripper proves nothing.

use graspcheck_model::{
    Pose,
    object::Object,
    plan::{Holding, Plan},
    task::{JointSegments, PickAndPlace, Task},
};

use crate::{
    evidence::Evidence,
    finding::{Finding, Gap},
    note::Note,
    verdict::Unit,
};

/// How far the plan may put something from where the task or another part of the plan has it, m and rad: twice what a
/// straight move may leave its line.
const SAME_PLACE: f64 = 2e-5;

/// How far a joint, a width or a force may be from what it must be, SI: rounding of sums.
const SAME_NUMBER: f64 = 1e-9;

/// The order in which a grasp goes.
const STORY: [Holding; 5] =
    [Holding::AtStart, Holding::Closing, Holding::Held, Holding::Opening, Holding::Placed];

/// How many things the plan does otherwise than the task asks; none may be. The note names the first.
pub(super) fn task(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    let faults = match &evidence.resolved.task {
        Task::PickAndPlace(task) => {
            let object = evidence.resolved.object.as_ref();
            let object = object.ok_or_else(|| Gap::inconclusive(None, "the task has no object to grasp"))?;
            of_grasp(evidence, task, object)
        }
        Task::JointSegments(task) => of_segments(evidence, task),
        Task::CartesianVia(_) | Task::JointVia(_) | Task::Path(_) => {
            return Err(Gap::not_requested("`planned.via` and `planned.deviation` judge such tasks"));
        }
    };
    let mut finding = Finding::at_most(faults.len() as f64, 0.0, Unit::Count);
    if let Some(Fault { time, what }) = faults.into_iter().next() {
        finding = finding.at(time).during(evidence.phase_name(time)).noted(what);
    }
    Ok(finding)
}

/// Something that is not as it was asked.
struct Fault {
    time: f64,
    what: Note,
}

/// All faults of a plan for a grasp.
fn of_grasp(evidence: &Evidence<'_>, task: &PickAndPlace, object: &Object) -> Vec<Fault> {
    let plan = &evidence.plan;
    let mut faults = Vec::new();
    at_joints(evidence, 0.0, &task.start, "the arm starts", &mut faults);
    let mut story: Vec<Holding> = plan.phases.iter().map(|phase| phase.holding).collect();
    story.dedup();
    let Some(grasp) = plan.grasp.as_ref().filter(|_| story == STORY) else {
        let what = Note::from("the plan does not approach, close, carry, open and leave, in this order");
        faults.push(Fault { time: 0.0, what });
        return faults;
    };
    match object.handles.iter().find(|handle| handle.name == grasp.handle) {
        Some(handle) if (handle.width - grasp.width).abs() > SAME_NUMBER => {
            let what = Note::from(format!("handle {} is ", handle.name))
                .quantity(handle.width, Unit::Meter)
                .and(" wide, the plan grips ")
                .quantity(grasp.width, Unit::Meter);
            faults.push(Fault { time: 0.0, what });
        }
        Some(_) => {}
        None => {
            let what = Note::from(format!("the object has no handle named {}", grasp.handle));
            faults.push(Fault { time: 0.0, what });
        }
    }
    if (grasp.force - task.grip_force).abs() > SAME_NUMBER * task.grip_force {
        let what = Note::from("the plan grips with ")
            .quantity(grasp.force, Unit::Newton)
            .and(" where the task asks for ")
            .quantity(task.grip_force, Unit::Newton);
        faults.push(Fault { time: 0.0, what });
    }
    for (a, b, what) in [
        (object.world_from_object, grasp.world_from_start, "the plan finds the object"),
        (task.world_from_placed, grasp.world_from_placed, "the plan puts the object"),
    ] {
        at_place(0.0, &a, &b, what, &mut faults);
    }
    // While the fingers close and open the object must be where the tool has it.
    for phase in &plan.phases {
        let stands = match phase.holding {
            Holding::Closing => object.world_from_object,
            Holding::Opening => task.world_from_placed,
            Holding::Nothing | Holding::AtStart | Holding::Held | Holding::Placed => continue,
        };
        for time in [phase.start, phase.end] {
            let held = world_from_tool(evidence, plan, time) * grasp.tool_from_object;
            at_place(time, &stands, &held, "the gripper has the object", &mut faults);
        }
    }
    faults
}

/// All faults of a plan for segments.
fn of_segments(evidence: &Evidence<'_>, task: &JointSegments) -> Vec<Fault> {
    let plan = &evidence.plan;
    let mut faults = Vec::new();
    let names = plan.phases.iter().map(|phase| &phase.name);
    if !names.eq(task.segments.iter().map(|segment| &segment.name)) {
        let what = Note::from("the phases of the plan are not the segments of the task");
        return vec![Fault { time: 0.0, what }];
    }
    for (phase, segment) in plan.phases.iter().zip(&task.segments) {
        at_joints(evidence, phase.start, &segment.from, "the segment starts", &mut faults);
        ends_at(evidence, phase.end, &segment.to, &mut faults);
    }
    faults
}

/// The arm where it must be at a time, from the right.
fn at_joints(evidence: &Evidence<'_>, time: f64, asked: &[f64], what: &str, faults: &mut Vec<Fault>) {
    let trajectory = &evidence.plan.trajectory;
    let found = trajectory.eval(time.clamp(0.0, trajectory.duration())).q;
    same_joints(evidence, time, asked, &found, what, faults);
}

/// The arm where it must be at the end of a phase, from the left: the next phase may begin elsewhere.
fn ends_at(evidence: &Evidence<'_>, time: f64, asked: &[f64], faults: &mut Vec<Fault>) {
    let trajectory = &evidence.plan.trajectory;
    let knots = trajectory.knots();
    let piece =
        knots.partition_point(|knot| *knot < time - SAME_NUMBER).clamp(1, trajectory.piece_count()) - 1;
    let value = |joint: usize| trajectory.piece(piece, joint).eval(time - knots[piece])[0];
    let found: Vec<f64> = (0..trajectory.dof()).map(value).collect();
    same_joints(evidence, time, asked, &found, "the segment ends", faults);
}

fn same_joints(
    evidence: &Evidence<'_>,
    time: f64,
    asked: &[f64],
    found: &[f64],
    what: &str,
    faults: &mut Vec<Fault>,
) {
    for (joint, (asked, found)) in evidence.joints().iter().zip(asked.iter().zip(found)) {
        // A comparison with NaN is false, which is a fault.
        let same = (asked - found).abs() <= SAME_NUMBER * (1.0 + asked.abs());
        if !same {
            let unit = Unit::of_derivative(joint.kind, 0);
            let what = Note::from(format!("{what} with {} at ", joint.name))
                .quantity(*found, unit)
                .and(", not at ")
                .quantity(*asked, unit);
            faults.push(Fault { time, what });
        }
    }
}

fn world_from_tool(evidence: &Evidence<'_>, plan: &Plan, time: f64) -> Pose {
    let time = time.clamp(0.0, plan.duration());
    evidence.resolved.robot.world_from_tool(&plan.trajectory.eval(time).q)
}

fn at_place(time: f64, asked: &Pose, found: &Pose, what: &str, faults: &mut Vec<Fault>) {
    let off = asked.inverse() * found;
    let (distance, angle) = (off.translation.vector.norm(), off.rotation.angle());
    // A comparison with NaN is false, which is a fault.
    if distance <= SAME_PLACE && angle <= SAME_PLACE {
        return;
    }
    let what = Note::from(format!("{what} "))
        .quantity(distance, Unit::Meter)
        .and(" and ")
        .quantity(angle, Unit::Radian)
        .and(" from where it must be");
    faults.push(Fault { time, what });
}

#[cfg(test)]
mod tests {
    use graspcheck_model::{Pose, plan::Holding};
    use nalgebra::Translation3;

    use crate::{
        Outcome,
        fixture::{self, Run},
    };

    fn fails(change: impl FnOnce(&mut Run), word: &str) {
        let mut run = fixture::pick();
        change(&mut run);
        let result = run.check("planned.task");
        assert_eq!(result.outcome, Outcome::Fail, "{word}: {result:?}");
        assert!(result.note.to_string().contains(word), "{word}: {}", result.note);
    }

    #[test]
    fn a_plan_that_does_the_task_passes() {
        let result = fixture::pick().check("planned.task");
        assert_eq!((result.outcome, result.value), (Outcome::Pass, Some(0.0)), "{}", result.note);
    }

    #[test]
    fn a_plan_that_does_something_else_says_what() {
        let moved = |pose: &Pose| Translation3::new(0.001, 0.0, 0.0) * pose;
        fails(|run| run.plan.grasp = None, "in this order");
        fails(|run| run.plan.phases[3].holding = Holding::AtStart, "in this order");
        fails(
            |run| {
                let grasp = run.plan.grasp.as_mut().unwrap();
                grasp.tool_from_object = moved(&grasp.tool_from_object);
            },
            "the gripper has the object",
        );
        fails(
            |run| {
                let grasp = run.plan.grasp.as_mut().unwrap();
                grasp.world_from_placed = moved(&grasp.world_from_placed);
            },
            "the plan puts the object",
        );
        fails(
            |run| {
                let object = run.resolved.object.as_mut().unwrap();
                object.world_from_object = moved(&object.world_from_object);
            },
            "the plan finds the object",
        );
        fails(|run| run.plan.grasp.as_mut().unwrap().width += 0.001, "wide");
        fails(|run| run.plan.grasp.as_mut().unwrap().force *= 2.0, "N where the task asks for");
        fails(|run| run.plan.grasp.as_mut().unwrap().handle = "none".to_owned(), "no handle named none");
        fails(
            |run| {
                let graspcheck_model::task::Task::PickAndPlace(task) = &mut run.resolved.task else {
                    unreachable!("the fixture picks")
                };
                task.start[0] += 0.1;
            },
            "the arm starts",
        );
    }
}
