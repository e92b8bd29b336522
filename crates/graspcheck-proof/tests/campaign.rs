//! Random scenes, proved and sampled at 10 kHz: no proof may contradict a sample.
//!
//! The samples use parry's own shapes and closest points and the model's forward kinematics, so that they
//! share nothing with the proof but the plan. `GRASPCHECK_CAMPAIGN_SCENES` sets how many scenes there are.

use graspcheck_model::{Pose, cell::Cell, plan::Plan, robot::RobotModel, shape::Shape};
use graspcheck_proof::{PairVerdict, Scene};
use parry3d::{
    math,
    query::{ClosestPoints, closest_points},
    shape::{Ball, Cuboid, Shape as ParryShape},
};

#[path = "../src/fixtures.rs"]
mod fixtures;
use fixtures::Draw;

/// What parry's search may leave of the distance to a curved body, m.
const SAMPLE_ERROR: f64 = 1e-6;

struct Case {
    robot: RobotModel,
    cell: Cell,
    plan: Plan,
}

/// A SCARA with boxes for links among four boxes and balls, moving for 0.2 s.
fn random_case(seed: u64) -> Case {
    let mut draw = Draw(seed);
    let mut robot = fixtures::scara();
    robot.links[2] = fixtures::link("quill_rod", vec![]);
    let names = ["first", "second", "third", "fourth"];
    let bodies = names.map(|name| {
        let (angle, radius) = (draw.between(-3.0, 3.0), draw.between(0.3, 0.8));
        let place =
            nalgebra::Vector3::new(radius * angle.cos(), radius * angle.sin(), draw.between(0.2, 0.5));
        let tilted = draw.between(0.0, 1.0) < 0.5;
        let turn = nalgebra::Vector3::new(
            if tilted { draw.between(-1.0, 1.0) } else { 0.0 },
            if tilted { draw.between(-1.0, 1.0) } else { 0.0 },
            draw.between(-3.0, 3.0),
        );
        let mut half = || draw.between(0.002, 0.08);
        let solid = fixtures::boxed(half(), half(), half());
        let ball = Shape::Sphere { radius: half() };
        (name, if draw.between(0.0, 1.0) < 0.3 { ball } else { solid }, Pose::new(place, turn))
    });
    let required = if draw.between(0.0, 1.0) < 0.5 { 0.0 } else { 0.005 };
    let cell = fixtures::cell(required, bodies.to_vec());
    let from =
        [draw.between(-1.5, 1.5), draw.between(-2.0, 2.0), draw.between(-0.1, 0.1), draw.between(-3.0, 3.0)];
    let to = std::array::from_fn::<f64, 4, _>(|joint| {
        from[joint] + draw.between(-1.0, 1.0) * [0.8, 1.2, 0.1, 2.0][joint]
    });
    Case { robot, cell, plan: fixtures::rest_to_rest(&from, &to, 0.2) }
}

fn parry_shape(shape: &Shape) -> Box<dyn ParryShape> {
    match shape {
        Shape::Box { half_extents: h } => Box::new(Cuboid::new(math::Vector::new(h.x, h.y, h.z))),
        Shape::Sphere { radius } => Box::new(Ball::new(*radius)),
        other => unreachable!("no such shape in these scenes: {other:?}"),
    }
}

fn parry_pose(pose: &Pose) -> math::Pose {
    let (t, r) = (pose.translation.vector, pose.rotation.scaled_axis());
    math::Pose::new(math::Vector::new(t.x, t.y, t.z), math::Vector::new(r.x, r.y, r.z))
}

/// Distances of named bodies at an instant, zero where they overlap.
struct Samples<'c> {
    case: &'c Case,
    obstacles: Vec<(math::Pose, Box<dyn ParryShape>)>,
}

impl<'c> Samples<'c> {
    fn new(case: &'c Case) -> Self {
        let obstacle = |body: &graspcheck_model::cell::CellBody| {
            (parry_pose(&body.world_from_shape), parry_shape(&body.shape))
        };
        Self { case, obstacles: case.cell.bodies.iter().map(obstacle).collect() }
    }

    fn solid(&self, name: &str, links: &[Pose]) -> (math::Pose, Box<dyn ParryShape>) {
        let robot = &self.case.robot;
        if let Some(index) = robot.links.iter().position(|link| link.name == name) {
            let placed = &robot.links[index].shapes[0];
            return (parry_pose(&(links[index] * placed.body_from_shape)), parry_shape(&placed.shape));
        }
        let finger = robot
            .gripper
            .fingers
            .iter()
            .find(|finger| finger.link.name == name)
            .expect("all other bodies are fingers");
        let placed = &finger.link.shapes[0];
        let opened = Pose::translation(0.0, finger.axis.y * 0.025, 0.0);
        let world_from_finger = links[links.len() - 1] * finger.link_from_finger * opened;
        (parry_pose(&(world_from_finger * placed.body_from_shape)), parry_shape(&placed.shape))
    }

    fn distance(&self, a: &str, b: &str, t: f64) -> f64 {
        let links = self.case.robot.forward(&self.case.plan.trajectory.eval(t).q);
        let (pose_a, shape_a) = self.solid(a, &links);
        let other;
        let (pose_b, shape_b) = match self.case.cell.bodies.iter().position(|body| body.name == b) {
            Some(index) => &self.obstacles[index],
            None => {
                other = self.solid(b, &links);
                &other
            }
        };
        match closest_points(&pose_a, &*shape_a, pose_b, &**shape_b, f64::MAX)
            .expect("boxes and balls are supported")
        {
            ClosestPoints::WithinMargin(p, q) => (q - p).length(),
            ClosestPoints::Intersecting => 0.0,
            ClosestPoints::Disjoint => unreachable!("no limit was set"),
        }
    }
}

#[test]
fn no_proof_contradicts_a_sample() {
    let scenes: u64 = std::env::var("GRASPCHECK_CAMPAIGN_SCENES")
        .map_or(150, |count| count.parse().expect("GRASPCHECK_CAMPAIGN_SCENES is a number"));
    let (mut free, mut violated) = (0_u32, 0_u32);
    for seed in 0..scenes {
        let case = random_case(seed);
        let required = case.cell.clearance.required;
        let scene = Scene::new(&case.robot, &case.cell, None).unwrap();
        let samples = Samples::new(&case);
        let steps = 2000;
        let time = |step: i32| case.plan.duration() * f64::from(step) / f64::from(steps);
        for pair in &scene.certify(&case.plan).pairs {
            match &pair.verdict {
                PairVerdict::Free { margin } => {
                    free += 1;
                    // Far pairs are proved in one step, and looked at less often.
                    let stride = if pair.leaves.len() == 1 { 100 } else { 1 };
                    for step in (0..=steps).step_by(stride) {
                        let distance = samples.distance(&pair.a, &pair.b, time(step));
                        assert!(
                            distance >= required + margin - SAMPLE_ERROR,
                            "seed {seed}: {} - {} is {distance} m at {} s, but was proved {} m",
                            pair.a,
                            pair.b,
                            time(step),
                            required + margin
                        );
                    }
                }
                PairVerdict::Violated(violation) => {
                    violated += 1;
                    let distance = samples.distance(&pair.a, &pair.b, violation.time);
                    assert!(
                        distance <= violation.distance.max(0.0) + SAMPLE_ERROR
                            && violation.distance < required,
                        "seed {seed}: {} - {} is {distance} m at {} s, but was said to be {} m",
                        pair.a,
                        pair.b,
                        violation.time,
                        violation.distance
                    );
                }
                other => panic!("seed {seed}: {} - {}: {other:?}", pair.a, pair.b),
            }
        }
    }
    assert!(free > 20 * u32::try_from(scenes).unwrap() / 2, "{free} free");
    assert!(violated > u32::try_from(scenes).unwrap() / 2, "{violated} violated");
}

#[test]
fn the_least_margin_encloses_every_sample() {
    for seed in 1000..1040 {
        let case = random_case(seed);
        let scene = Scene::new(&case.robot, &case.cell, None).unwrap();
        let least = scene.minimum_margin(&case.plan, 1e-4).unwrap();
        let samples = Samples::new(&case);
        let at_time = samples.distance(&least.a, &least.b, least.time) - least.required;
        assert!(
            at_time <= least.upper.max(-least.required) + SAMPLE_ERROR,
            "seed {seed}: {at_time} {least:?}"
        );
        assert!(least.lower <= least.upper, "seed {seed}: {least:?}");
        let overlaps = least.upper + least.required <= 0.0;
        assert!(overlaps || least.upper - least.lower <= 1e-4, "seed {seed}: {least:?}");
        let mut sampler = scene.sampler(&case.plan).unwrap();
        for step in 0..=200 {
            let t = case.plan.duration() * f64::from(step) / 200.0;
            let q = case.plan.trajectory.eval(t).q;
            let margin = sampler.margin(t, &q, 0.05, None).unwrap();
            assert!(margin >= least.lower - SAMPLE_ERROR, "seed {seed}: {margin} at {t} s, {least:?}");
            assert_eq!(
                scene.margin_at(&case.plan, t, &q, 0.05, None).map(|m| (m - margin).abs() < 1e-6),
                Some(true)
            );
        }
    }
}
