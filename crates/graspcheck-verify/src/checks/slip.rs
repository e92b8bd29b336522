//! `executed.slip`: how far the object moves in the gripper while it is held.

use crate::{
    checks::held,
    evidence::Evidence,
    finding::{Finding, Gap},
    note::Note,
    stream,
    verdict::Unit,
};

/// The farthest that any point of the object moves against the tool between the start of the lift and the
/// start of the release, m.
///
/// With D the motion of the object in the tool frame since the start of the lift, a displacement of its
/// origin by d together with a rotation by θ, no point within r of the origin moves farther than
/// d + 2 r sin(θ/2); the value is that bound. A slip that only turns the object is thus seen too.
pub(super) fn slip(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    stream::requested(evidence)?;
    let Some(limit) = evidence.resolved.checks.slip else {
        return Err(Gap::not_requested("the scenario sets no limit"));
    };
    let (object, [lift, release]) = (held::object(evidence)?, held::stretch(evidence)?);
    let (tool_poses, object_poses) = (stream::tool(evidence)?, stream::object(evidence)?);
    let radius = object.shape.extent_radius();

    let mut at_lift = None;
    let mut slips = Vec::new();
    let mut turned: f64 = 0.0;
    let mut tools = tool_poses.iter();
    for sample in object_poses.iter().filter(|sample| (lift..=release).contains(&sample.time())) {
        let Some(tool) = tools.by_ref().find(|tool| tool.time_ns >= sample.time_ns) else { break };
        if tool.time_ns != sample.time_ns {
            let note = format!("streams tool and object have no common sample at t = {} s", sample.time());
            return Err(Gap::inconclusive(Some(sample.time()), note));
        }
        let tool_from_object = tool.world_from_body.inverse() * sample.world_from_body;
        let start = *at_lift.get_or_insert(tool_from_object);
        let displacement = (tool_from_object.translation.vector - start.translation.vector).norm();
        let angle = start.rotation.angle_to(&tool_from_object.rotation);
        slips.push((sample.time(), displacement + 2.0 * radius * (0.5 * angle).sin()));
        turned = turned.max(angle);
    }
    let mut finding = Finding::worst_at_most(&slips, limit, Unit::Meter)
        .ok_or_else(|| Gap::inconclusive(Some(lift), "no sample of the object while it is held"))?;
    finding.value_is_bound = true;
    let phase = evidence.phase_name(finding.time.unwrap_or(lift));
    Ok(finding
        .of([object.name.as_str(), "gripper"])
        .during(phase)
        .noted(Note::from("it turned in the gripper by at most ").quantity(turned, Unit::Radian)))
}

#[cfg(test)]
mod tests {
    use graspcheck_model::Pose;
    use nalgebra::{Translation3, UnitQuaternion, Vector3};

    use crate::{
        Outcome,
        fixture::{self, LIFT, OPEN, Run, row},
    };

    /// The pick with the object moved in its own frame by `object_from_slipped` from a time on.
    fn slipped(object_from_slipped: &Pose, from: f64) -> Run {
        let mut run = fixture::pick();
        for row_index in run.rows_from(from) {
            let [x, y, z, qx, qy, qz, qw] = run.recording.object.pose[row_index];
            let rotation = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(qw, qx, qy, qz));
            let world_from_object = Pose::from_parts(Translation3::new(x, y, z), rotation);
            run.recording.object.pose[row_index] = row(&(world_from_object * object_from_slipped));
        }
        run
    }

    #[test]
    fn an_object_that_follows_the_tool_does_not_slip() {
        let result = fixture::pick().check("executed.slip");
        assert_eq!(result.outcome, Outcome::Pass, "{result:?}");
        // Rounding of the quaternion's angle, times the radius of the cube.
        assert!(result.value.unwrap() < 1e-8, "{result:?}");
        assert!(result.margin.unwrap() > 0.0);
    }

    #[test]
    fn a_displacement_and_a_turn_are_both_slips() {
        let down = slipped(&Pose::translation(0.0, 0.0, -6e-4), 4.0).check("executed.slip");
        assert_eq!(down.outcome, Outcome::Fail);
        assert!((down.value.unwrap() - 6e-4).abs() < 1e-8, "{down:?}");
        assert!((down.violated.unwrap()[0] - 4.0).abs() < 1e-9, "{down:?}");

        // About the axis of the pads, through the origin of the cube: its corners move by 0.02 √3 θ at most.
        let turn = Pose::from_parts(
            Translation3::identity(),
            UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 0.02),
        );
        let turned = slipped(&turn, 4.0).check("executed.slip");
        assert_eq!(turned.outcome, Outcome::Fail);
        assert!((turned.value.unwrap() - 0.02 * 3.0_f64.sqrt() * 0.02).abs() < 1e-7, "{turned:?}");
    }

    #[test]
    fn what_happens_before_the_lift_and_after_the_release_does_not_count() {
        let away = Pose::translation(0.1, 0.0, 0.0);
        assert_eq!(slipped(&away, OPEN + 0.1).check("executed.slip").outcome, Outcome::Pass);
        // Moved from before the lift on, it is held where it is.
        assert_eq!(slipped(&away, LIFT - 0.5).check("executed.slip").outcome, Outcome::Pass);
        assert_eq!(slipped(&away, LIFT + 0.1).check("executed.slip").outcome, Outcome::Fail);
    }

    #[test]
    fn samples_that_are_missing_or_do_not_meet_are_undecided() {
        let mut run = fixture::pick();
        run.recording.tool = Default::default();
        assert_eq!(run.check("executed.slip").outcome, Outcome::Inconclusive);
        let mut run = fixture::pick();
        for time_ns in &mut run.recording.object.time_ns {
            *time_ns += 1000;
        }
        assert_eq!(run.check("executed.slip").outcome, Outcome::Inconclusive);
        let mut run = fixture::pick();
        run.recording.object.frame = "base".into();
        assert_eq!(run.check("executed.slip").outcome, Outcome::Inconclusive);
        let mut run = fixture::pick();
        run.recording.object.pose[10][0] = f64::NAN;
        assert_eq!(run.check("executed.slip").outcome, Outcome::Fail);
    }
}
