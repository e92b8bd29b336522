//! The proof of clearance along an executed motion: at every instant of it, not at the rows of its log.
//!
//! The joints follow the cubic Hermite pieces of a [`LoggedMotion`]; a tree over the ranges of the pieces gives
//! the exact range of a joint on any interval, so that one step of the proof covers as many rows as the
//! distances allow. The object moves as it was logged, in the frame of what carries it in the phase of the plan
//! (`carried`): held, it is rigid in the hand up to how far it was measured to slip on the interval.
//!
//! What is required is what is required of the plan, by phase, but that bodies which may touch may be
//! [`DEPTH_LIMIT`] deep in each other, as executed contacts are.

use graspcheck_model::{
    Pose,
    object::Object,
    plan::{Holding, Plan},
    robot::JointKind,
};
use nalgebra::Vector3;

use crate::{
    carried::Carried,
    chain::Carrier,
    clearance_search::{CourseClearance, Leg, ObjectCourse, Question},
    contact::{DEPTH_LIMIT, Occasion, Requirement, Stage},
    logged_motion::{BodyState, LoggedMotion},
    scene::Scene,
    stretch::{Stretch, middle},
};

/// A phase of the plan as it was logged.
pub(crate) struct LoggedPhase {
    /// Index into the plan's phases.
    pub(crate) phase: usize,
    /// From when to when, s; the last phase lasts until the log ends.
    pub(crate) span: [f64; 2],
    pub(crate) object: Option<LoggedObject>,
}

/// The object against what carries it.
pub(crate) struct LoggedObject {
    carrier: Carrier,
    pub(crate) carried: Carried,
    /// Where the plan has it, in the carrier's frame.
    pub(crate) planned: Pose,
}

impl Scene {
    /// Proves that all pairs of solids keep what is required of them at every instant of an executed motion, or
    /// that one does not, and brackets the least margin of those that may not touch to a hundredth (at least
    /// 10 µm, at most 1 mm).
    ///
    /// # Errors
    /// Says in words what the plan or the log lacks.
    pub fn clearance_of(&self, plan: &Plan, motion: &LoggedMotion) -> Result<CourseClearance, String> {
        let phases = logged_phases(self, plan, motion)?;
        let mut legs = Vec::with_capacity(phases.len());
        for LoggedPhase { phase, span, object } in &phases {
            let mut stage = Stage::new(self, plan, Occasion::of(plan, *phase))?;
            // The fingers are where they were measured, whatever is between them.
            stage.opening_min = f64::NEG_INFINITY;
            let object = match (object, self.object_part) {
                (Some(LoggedObject { carrier, carried, .. }), Some(part)) => {
                    let mounted = carried.pose_at(middle(span[0], span[1]));
                    stage.stand_object(self, part, *carrier, mounted);
                    ObjectCourse::Logged { carrier: *carrier, motion: carried, mounted }
                }
                _ => ObjectCourse::Absent,
            };
            let stretch = Stretch::logged(motion, *span, *phase);
            legs.push(Leg { stretch, stage, phase: &plan.phases[*phase].name, object });
        }
        Ok(Question { scene: self, legs: &legs, demand: when_executed, fingers: Some(motion) }.answer())
    }
}

/// What is required of a pair in execution.
fn when_executed(requirement: &Requirement) -> Option<f64> {
    Some(if requirement.contact.is_some() { -DEPTH_LIMIT } else { requirement.required })
}

/// The phases of a plan as a motion goes through them, with the object in each.
pub(crate) fn logged_phases(
    scene: &Scene,
    plan: &Plan,
    motion: &LoggedMotion,
) -> Result<Vec<LoggedPhase>, String> {
    plan.check(scene.robot.dof()).map_err(|fault| format!("plan: {fault}"))?;
    if scene.object.is_some() && motion.object().is_empty() {
        return Err("log: the object is in no row".to_owned());
    }
    let [first, last] = motion.span();
    let mut phases = Vec::with_capacity(plan.phases.len());
    for (index, phase) in plan.phases.iter().enumerate() {
        let is_last = index + 1 == plan.phases.len();
        let start = if index == 0 { first } else { phase.start.max(first) };
        let span = [start, if is_last { last } else { phase.end.min(last) }];
        if span[0] >= span[1] {
            continue;
        }
        let object = match &scene.object {
            Some(object) => {
                let (carrier, planned) = planned_object(scene, object, plan, phase.holding)?;
                let radius = object.shape.extent_radius();
                let carried = carried(scene, motion, carrier, span, radius);
                Some(LoggedObject { carrier, carried, planned })
            }
            None => None,
        };
        phases.push(LoggedPhase { phase: index, span, object });
    }
    Ok(phases)
}

/// What carries the object, and where the plan has it there.
fn planned_object(
    scene: &Scene,
    object: &Object,
    plan: &Plan,
    holding: Holding,
) -> Result<(Carrier, Pose), String> {
    let grasp = plan.grasp.as_ref().ok_or_else(|| "plan: it moves the object but has no grasp".to_owned());
    Ok(match holding {
        Holding::Nothing | Holding::AtStart | Holding::Closing => (Carrier::World, object.world_from_object),
        Holding::Held => {
            let last = Carrier::Link(scene.robot.dof() - 1);
            (last, scene.robot.link_from_tool * grasp?.tool_from_object)
        }
        Holding::Opening | Holding::Placed => (Carrier::World, grasp?.world_from_placed),
    })
}

/// The object against its carrier, over the rows around a span of time.
fn carried(scene: &Scene, motion: &LoggedMotion, carrier: Carrier, span: [f64; 2], radius: f64) -> Carried {
    let rows = motion.piece_at(span[0])..=motion.piece_at(span[1]) + 1;
    let mut hand = Hand::new(scene);
    let states = rows.clone().map(|row| {
        let object = motion.object()[row];
        match carrier {
            Carrier::World => object,
            Carrier::Link(_) | Carrier::Finger(_) => relative(&object, &hand.at(motion, row)),
        }
    });
    Carried::new(motion.times()[rows.clone()].to_vec(), states.collect(), radius)
}

/// A body's pose and velocity as seen from another one, in the frame of that.
fn relative(body: &BodyState, from: &BodyState) -> BodyState {
    let (here, there) = (&from.world_from_body, &body.world_from_body);
    let arm = there.translation.vector - here.translation.vector;
    let linear = body.linear - from.linear - from.angular.cross(&arm);
    BodyState {
        world_from_body: here.inverse() * there,
        linear: here.rotation.inverse() * linear,
        angular: here.rotation.inverse() * (body.angular - from.angular),
    }
}

/// The last link of the arm, row by row.
struct Hand<'s> {
    scene: &'s Scene,
    q: Vec<f64>,
    qd: Vec<f64>,
    world_from_link: Vec<Pose>,
}

impl<'s> Hand<'s> {
    fn new(scene: &'s Scene) -> Self {
        let dof = scene.robot.dof();
        Self { scene, q: vec![0.0; dof], qd: vec![0.0; dof], world_from_link: vec![Pose::identity(); dof] }
    }

    /// Its pose and velocity in a row.
    fn at(&mut self, motion: &LoggedMotion, row: usize) -> BodyState {
        motion.arm_row(row, &mut self.q, &mut self.qd);
        self.scene.robot.forward_into(&self.q, &mut self.world_from_link);
        let world_from_body = self.world_from_link[self.q.len() - 1];
        let (mut linear, mut angular) = (Vector3::zeros(), Vector3::zeros());
        let joints = self.scene.robot.joints.iter().zip(&self.world_from_link).zip(&self.qd);
        for ((joint, link), speed) in joints {
            let axis = link.rotation * joint.axis.into_inner() * *speed;
            match joint.kind {
                JointKind::Revolute => {
                    let arm = world_from_body.translation.vector - link.translation.vector;
                    linear += axis.cross(&arm);
                    angular += axis;
                }
                JointKind::Prismatic => linear += axis,
            }
        }
        BodyState { world_from_body, linear, angular }
    }
}

#[cfg(test)]
mod tests {
    use graspcheck_model::shape::Shape;

    use super::*;
    use crate::{
        certificate::ProofOutcome,
        fixtures::{self, at, boxed},
        logged_motion::{JointLog, MotionLog},
    };

    /// What a perfect robot logs of a plan every `dt` s, off by `error` in every joint.
    fn logged(scene: &Scene, plan: &Plan, dt: f64, error: f64) -> LoggedMotion {
        let rows = (plan.duration() / dt).round() as usize;
        let times: Vec<f64> = (0..=rows).map(|row| (row as f64 * dt).min(plan.duration())).collect();
        let states: Vec<_> = times.iter().map(|time| plan.trajectory.eval(*time)).collect();
        let arm = (0..scene.robot.dof()).map(|joint| JointLog {
            position: states.iter().map(|state| state.q[joint] + error).collect(),
            velocity: states.iter().map(|state| state.qd[joint]).collect(),
        });
        let finger = || JointLog {
            position: times.iter().map(|time| 0.5 * plan.opening.eval(*time).q[0]).collect(),
            velocity: vec![0.0; times.len()],
        };
        let log = MotionLog { arm: arm.collect(), fingers: [finger(), finger()], times, object: Vec::new() };
        LoggedMotion::new(&scene.robot, log).unwrap()
    }

    fn scara_past_a_wall() -> (Scene, Plan) {
        let wall = ("wall", boxed(0.05, 0.02, 0.3), at(0.6, 0.45, 0.0));
        let table = ("table", boxed(1.0, 1.0, 0.05), at(0.0, 0.0, -0.5));
        let scene = Scene::new(&fixtures::scara(), &fixtures::cell(0.002, vec![wall, table]), None).unwrap();
        (scene, fixtures::rest_to_rest(&[-0.8, 0.4, 0.0, 0.0], &[0.1, 1.1, -0.05, 3.0], 1.0))
    }

    #[test]
    fn a_perfect_execution_has_the_margin_of_its_plan_in_far_fewer_looks_than_rows() {
        let (scene, plan) = scara_past_a_wall();
        let planned = scene.minimum_margin(&plan, 1e-5).unwrap();
        let found = scene.clearance_of(&plan, &logged(&scene, &plan, 1e-3, 0.0)).unwrap();
        let least = found.least.clone().unwrap();
        assert_eq!(found.outcome == ProofOutcome::Free, planned.lower >= 0.0, "{found:?} {planned:?}");
        assert!(
            least.lower <= planned.upper + 1e-8 && planned.lower <= least.upper + 1e-8,
            "{least:?} {planned:?}"
        );
        assert!(least.upper - least.lower <= 1.01e-3, "{least:?}");
        assert!(found.looks < 1000 * found.pairs / 20, "{} looks at {} pairs", found.looks, found.pairs);
    }

    /// A ball of 1 cm on an arm of 1 m without thickness that turns about z, and one obstacle.
    fn ball_on_an_arm(obstacle: (&str, Shape, Pose)) -> Scene {
        let joint = fixtures::joint("pivot", JointKind::Revolute, Pose::identity(), Vector3::z());
        let tip = fixtures::link("tip", vec![(at(1.0, 0.0, 0.0), Shape::Sphere { radius: 0.01 })]);
        let mut robot = fixtures::robot(vec![joint], vec![tip]);
        for finger in &mut robot.gripper.fingers {
            finger.link.shapes.clear();
        }
        Scene::new(&robot, &fixtures::cell(0.0, vec![obstacle]), None).unwrap()
    }

    #[test]
    fn a_rod_between_two_rows_is_hit() {
        let turn: f64 = 0.021;
        let rod = Shape::Cylinder { radius: 0.001, half_length: 0.5 };
        let scene = ball_on_an_arm(("rod", rod, at(turn.cos(), turn.sin(), 0.0)));
        // At 75 m/s rows are 75 mm apart; ball and rod are 22 mm wide.
        let plan = fixtures::rest_to_rest(&[-1.0], &[1.0], 0.05);
        let motion = logged(&scene, &plan, 1e-3, 0.0);
        let mut sampler = scene.sampler(&plan).unwrap();
        for row in 0..motion.times().len() {
            let mut state = ([0.0], [0.0]);
            motion.arm_row(row, &mut state.0, &mut state.1);
            assert!(
                sampler.margin(motion.times()[row], &state.0, 0.05, None).unwrap() > 0.0,
                "row {row} meets it"
            );
        }
        let found = scene.clearance_of(&plan, &motion).unwrap();
        assert_eq!(found.outcome, ProofOutcome::Violated, "{found:?}");
    }

    #[test]
    fn the_tube_takes_what_an_error_can_move_the_arm() {
        // A ball comes to rest at 1 rad, 10 mm before another one at 1.03 rad.
        let ball = || Shape::Sphere { radius: 0.01 };
        let turn: f64 = 1.03;
        let scene = ball_on_an_arm(("ball", ball(), at(turn.cos(), turn.sin(), 0.0)));
        let plan = fixtures::rest_to_rest(&[-1.0], &[1.0], 1.0);
        let planned = 2.0 * 0.015_f64.sin() - 0.02;
        for (error, expected) in [(0.0, planned), (1e-3, planned - 1e-3), (-2e-3, planned - 2e-3)] {
            let tube = scene.tracking_tube(&plan, &logged(&scene, &plan, 1e-3, error)).unwrap();
            assert!((tube.errors[0] - f64::abs(error)).abs() < 1e-8, "{tube:?}");
            let found = tube.clearance.least.as_ref().unwrap().lower;
            assert!(found <= expected + 1e-6 && found > expected - 1.2e-4, "{found} {expected}");
        }
        let tube = scene.tracking_tube(&plan, &logged(&scene, &plan, 1e-3, 0.011)).unwrap();
        assert_eq!(tube.clearance.outcome, ProofOutcome::Violated, "{tube:?}");
    }

    #[test]
    fn rows_that_are_no_motion_are_refused() {
        let (scene, _) = scara_past_a_wall();
        let robot = &scene.robot;
        let column = |rows: usize| JointLog { position: vec![0.0; rows], velocity: vec![0.0; rows] };
        let log = |times: Vec<f64>| MotionLog {
            arm: (0..4).map(|_| column(times.len())).collect(),
            fingers: [column(times.len()), column(times.len())],
            times,
            object: Vec::new(),
        };
        assert!(LoggedMotion::new(robot, log(vec![0.0, 1.0])).is_ok());
        for times in [vec![], vec![0.0], vec![0.0, 0.0], vec![0.0, f64::NAN], vec![1.0, 0.5]] {
            assert!(LoggedMotion::new(robot, log(times)).is_err());
        }
        let mut short = log(vec![0.0, 1.0]);
        short.arm[1].velocity.pop();
        assert!(
            LoggedMotion::new(robot, short).unwrap_err().to_string().contains("has 1 values, 2 are needed")
        );
        let mut broken = log(vec![0.0, 1.0]);
        broken.fingers[0].position[1] = f64::INFINITY;
        assert!(LoggedMotion::new(robot, broken).is_err());
    }
}
