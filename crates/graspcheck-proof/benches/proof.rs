//! How long proofs of clearance take: a 1 s SCARA move among seven boxes, against sampling it at 1 kHz with the
//! same code for the distance of two solids; a larger scene; and cells of many bodies.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use graspcheck_model::{Pose, plan::Plan, robot::RobotModel, shape::Shape};
use graspcheck_proof::{
    Scene,
    gap::{FINEST_TOLERANCE, separation},
    solid::{Place, Placed, Solid},
};
use nalgebra::Vector3;

#[path = "../src/fixtures.rs"]
#[expect(dead_code, reason = "the tests need more robots than this bench")]
mod fixtures;

type Obstacle = (String, Shape, Pose);

struct Case {
    robot: RobotModel,
    obstacles: Vec<Obstacle>,
    plan: Plan,
    scene: Scene,
}

impl Case {
    fn new(robot: RobotModel, required: f64, obstacles: Vec<Obstacle>) -> Self {
        let bodies = obstacles.iter().map(|(name, shape, place)| (name.as_str(), shape.clone(), *place));
        let cell = fixtures::cell(required, bodies.collect());
        let scene = Scene::new(&robot, &cell, None).expect("the scene is well formed");
        let plan = fixtures::rest_to_rest(&[-0.3, 0.4, 0.0, 0.0], &[0.8, 2.1, -0.05, 3.0], 1.0);
        Self { robot, obstacles, plan, scene }
    }

    /// Every pair of a link and an obstacle at every millisecond, as it is done everywhere: the least distance, m.
    fn sampled(&self) -> f64 {
        let solid = |shape: &Shape| Solid::from_shape(shape).expect("the shape is a solid").0;
        let links: Vec<(Pose, Solid)> = (self.robot.links.iter())
            .map(|link| (link.shapes[0].body_from_shape, solid(&link.shapes[0].shape)))
            .collect();
        let obstacles: Vec<(Place, Solid)> =
            self.obstacles.iter().map(|(_, shape, place)| (Place::from(place), solid(shape))).collect();
        let mut hints = vec![None; links.len() * obstacles.len()];
        let mut world_from_link = vec![Pose::identity(); self.robot.dof()];
        let mut least = f64::INFINITY;
        for step in 0..=1000 {
            let q = self.plan.trajectory.eval(f64::from(step) * 1e-3).q;
            self.robot.forward_into(&q, &mut world_from_link);
            let mut hints = hints.iter_mut();
            for (world_from_link, (link_from_solid, solid)) in world_from_link.iter().zip(&links) {
                let link = Placed { solid, place: Place::from(&(world_from_link * link_from_solid)) };
                for ((place, solid), hint) in obstacles.iter().zip(&mut hints) {
                    let obstacle = Placed { solid, place: *place };
                    let found = separation(&link, &obstacle, hint.as_ref(), FINEST_TOLERANCE)
                        .expect("the distance can be computed");
                    *hint = Some(found.normal);
                    least = least.min(found.upper);
                }
            }
        }
        least
    }
}

fn boxes_around(draw: &mut fixtures::Draw, names: &[&str]) -> Vec<Obstacle> {
    let some_box = |name: &&str| {
        let angle = draw.between(-0.4, 2.9);
        let radius = draw.between(0.65, 0.8);
        let turn = Pose::new(
            Vector3::new(radius * angle.cos(), radius * angle.sin(), draw.between(0.02, 0.3)),
            Vector3::z() * draw.between(0.0, 3.0),
        );
        ((*name).to_owned(), fixtures::boxed(0.05, 0.04, 0.1), turn)
    };
    names.iter().map(some_box).collect()
}

fn table() -> Obstacle {
    ("table".to_owned(), fixtures::boxed(1.0, 1.0, 0.05), fixtures::at(0.0, 0.0, -0.05))
}

/// Four bodies of the arm among seven boxes: 28 pairs. The least distance is some millimetres.
fn four_bodies() -> Case {
    let mut robot = fixtures::scara();
    robot.gripper.fingers.iter_mut().for_each(|finger| finger.link.shapes.clear());
    // The arm's bodies are judged against the boxes only.
    let names: Vec<String> = robot.links.iter().map(|link| link.name.clone()).collect();
    for (a, b) in [(0, 2), (0, 3), (1, 3)] {
        let mut contact = robot.allowed_contacts[0].clone();
        (contact.a, contact.b) = (names[a].clone(), names[b].clone());
        robot.allowed_contacts.push(contact);
    }
    let mut obstacles = vec![table()];
    obstacles.extend(boxes_around(&mut fixtures::Draw(7), &["bin", "wall", "camera", "feeder", "fixture"]));
    let turn = Pose::new(Vector3::new(0.335, 0.355, 0.074), Vector3::z() * 0.4);
    obstacles.push(("post".to_owned(), fixtures::boxed(0.03, 0.04, 0.074), turn));
    Case::new(robot, 0.0, obstacles)
}

/// The base, four bodies of the arm and two fingers among seven obstacles, each by 2 mm at least.
fn whole_arm() -> Case {
    let mut obstacles = vec![table()];
    obstacles.extend(boxes_around(&mut fixtures::Draw(7), &["bin", "wall", "camera", "feeder", "fixture"]));
    let post = Shape::Cylinder { radius: 0.02, half_length: 0.05 };
    obstacles.push(("post".to_owned(), post, fixtures::at(0.2, 0.4, 0.05)));
    Case::new(fixtures::scara(), 0.002, obstacles)
}

/// A table and small boxes all around in the arm's room, in and out of its reach, without those in its way.
fn crowded(count: usize) -> Case {
    let mut draw = fixtures::Draw(11);
    let mut some_box = |index: usize| {
        let place = fixtures::at(draw.between(-1.0, 1.0), draw.between(-1.0, 1.0), draw.between(0.02, 0.6));
        (format!("box_{index}"), fixtures::boxed(0.01, 0.01, 0.02), place)
    };
    let mut obstacles = vec![table()];
    // At most a third of them is in the way.
    obstacles.extend((1..count + count / 2).map(&mut some_box));
    let all = Case::new(fixtures::scara(), 0.002, obstacles.clone());
    let certificate = all.scene.certify(&all.plan);
    let hit: Vec<&str> = certificate.violations().map(|(pair, _)| pair.b.as_str()).collect();
    obstacles.retain(|(name, ..)| !hit.contains(&name.as_str()));
    obstacles.truncate(count);
    Case::new(fixtures::scara(), 0.002, obstacles)
}

fn proofs(criterion: &mut Criterion) {
    for (name, case) in [("scara", four_bodies()), ("whole arm", whole_arm())] {
        let Case { scene, plan, .. } = &case;
        let certificate = scene.certify(plan);
        assert!(certificate.is_free(), "{:?}", certificate.violations().collect::<Vec<_>>());
        let label = format!("{} pairs, {} leaves", scene.pair_count(), certificate.leaf_count());
        criterion.bench_function(&format!("{name}: certify ({label})"), |bencher| {
            bencher.iter(|| black_box(scene).certify(black_box(plan)));
        });
        for tolerance in [1e-4, 1e-5, 1e-6] {
            let least = scene.minimum_margin(plan, tolerance).expect("pairs count");
            let found = format!("{:.3} mm", 1e3 * (least.upper + least.required));
            criterion.bench_function(
                &format!("{name}: least margin to {tolerance} m ({found})"),
                |bencher| {
                    bencher.iter(|| black_box(scene).minimum_margin(black_box(plan), tolerance));
                },
            );
        }
    }
    let case = four_bodies();
    let label = format!("28 pairs, {:.3} mm", 1e3 * case.sampled());
    criterion.bench_function(&format!("scara: all pairs sampled at 1 kHz ({label})"), |bencher| {
        bencher.iter(|| black_box(&case).sampled());
    });
    let Case { scene, plan, .. } = &case;
    let mut sampler = scene.sampler(plan).expect("the plan is complete");
    criterion.bench_function("scara: sampler at 1 kHz", |bencher| {
        bencher.iter(|| {
            (0..=1000)
                .filter_map(|ms| {
                    let t = f64::from(ms) / 1000.0;
                    sampler.margin(t, &plan.trajectory.eval(t).q, 0.05, None)
                })
                .fold(f64::INFINITY, f64::min)
        });
    });
}

fn many_bodies(criterion: &mut Criterion) {
    for count in [10, 100, 1000] {
        let Case { scene, plan, .. } = &crowded(count);
        let certificate = scene.certify(plan);
        assert!(certificate.is_free(), "{:?}", certificate.violations().collect::<Vec<_>>());
        let label = format!(
            "{} pairs, {} listed, {} sweeps, {} leaves",
            scene.pair_count(),
            certificate.pairs.len(),
            certificate.sweeps.len(),
            certificate.leaf_count() - certificate.sweeps.len()
        );
        criterion.bench_function(&format!("{count} bodies: certify ({label})"), |bencher| {
            bencher.iter(|| black_box(scene).certify(black_box(plan)));
        });
        criterion.bench_function(&format!("{count} bodies: least margin to 1e-5 m"), |bencher| {
            bencher.iter(|| black_box(scene).minimum_margin(black_box(plan), 1e-5));
        });
    }
}

criterion_group!(benches, proofs, many_bodies);
criterion_main!(benches);
