//! A thin wire that the outermost edge of each arm meets for less than 0.2 ms, between two samples of 1 kHz; and the same
//! wire 50 µm in its way or beside it.

use graspcheck_model::{Pose, robot::RobotModel, shape::Shape};
use graspcheck_proof::{MarginBounds, ProofOutcome, Scene};
use nalgebra::Vector3;

use crate::trial::{
    arms,
    distance::distance,
    fixtures,
    motion::{Bodies, Carrier},
    random::Case,
    solid::Core,
};

/// Radius of the wire, m.
const WIRE: f64 = 1e-4;
/// When the edge passes the wire, s: halfway between two samples of 1 kHz.
const PASS: f64 = 0.1505;

/// An arm bent so that an edge of its gripper points outwards, and how far the shoulder turns in how long, rad and s.
struct Swing {
    robot: RobotModel,
    bent: &'static [f64],
    stroke: f64,
    duration: f64,
}

/// At 7.5 rad/s and at 1.5 rad/s: the limits of the two shoulders.
fn swings() -> [Swing; 2] {
    [
        Swing { robot: arms::scara(), bent: &[0.0, -0.1, -0.36], stroke: 1.2, duration: 0.3 },
        Swing { robot: arms::rrr(), bent: &[0.0, 0.8], stroke: 0.24, duration: 0.3 },
    ]
}

/// The shoulder's swing, with an upright wire `beside` (m) the outermost edge where it passes.
fn passing(swing: &Swing, beside: f64) -> Case {
    let at = |shoulder: f64| [&[shoulder], swing.bent].concat();
    let (from, to) = (at(-0.5 * swing.stroke), at(0.5 * swing.stroke));
    let plan = fixtures::rest_to_rest(&from, &to, swing.duration);
    let mut case = Case { robot: swing.robot.clone(), cell: fixtures::cell(0.0, vec![]), object: None, plan };
    let edge = outermost_edge(&case.bodies());
    let out = Vector3::new(edge.x, edge.y, 0.0);
    let place = out * (1.0 + (beside + WIRE) / out.norm()) + Vector3::z() * edge.z;
    let wire = Shape::Cylinder { radius: WIRE, half_length: 0.005 };
    case.cell = fixtures::cell(0.0, vec![("wire", wire, Pose::translation(place.x, place.y, place.z))]);
    case
}

/// The middle of the upright edge that is farthest from the shoulder's axis as it passes.
fn outermost_edge(bodies: &Bodies) -> Vector3<f64> {
    let moment = bodies.at(PASS);
    let moving = (0..bodies.parts.len()).filter(|part| bodies.parts[*part].carrier != Carrier::World);
    let edges = moving.flat_map(|part| {
        let placed = bodies.placed(part, &moment);
        let half = match &placed.solid.core {
            Core::Box(half) => *half,
            _ => Vector3::zeros(),
        };
        [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]]
            .map(|[x, y]| placed.origin + placed.turn * Vector3::new(x * half.x, y * half.y, 0.0))
    });
    edges.max_by(|a, b| a.xy().norm().total_cmp(&b.xy().norm())).expect("the arm has boxes")
}

/// The least distance of the wire and any link at an instant, by the judge.
fn to_the_wire(case: &Case, bodies: &Bodies, t: f64) -> f64 {
    let moment = bodies.at(t);
    let wire = bodies.placed(bodies.part("wire", 0).expect("it is there"), &moment);
    let links = (0..bodies.parts.len()).filter(|part| bodies.parts[*part].body != "wire");
    let distances = links.map(|part| distance(&bodies.placed(part, &moment), &wire).upper);
    assert!(case.plan.duration() >= t);
    distances.fold(f64::INFINITY, f64::min)
}

/// When the judge sees the wire touched first and last, by steps of 1 µs around the pass, s.
fn touch(case: &Case) -> Option<[f64; 2]> {
    let bodies = case.bodies();
    let times = (-1000..=1000).map(|step| PASS + 1e-6 * f64::from(step));
    let touching: Vec<f64> = times.filter(|t| to_the_wire(case, &bodies, *t) <= 0.0).collect();
    Some([*touching.first()?, *touching.last()?])
}

fn least(scene: &Scene, case: &Case) -> MarginBounds {
    scene.minimum_margin(&case.plan, 1e-6).expect("pairs are judged")
}

#[test]
fn a_wire_met_for_less_than_a_fifth_of_a_millisecond_is_found() {
    for swing in swings() {
        let case = passing(&swing, -1e-4);
        let [first, last] = touch(&case).expect("the wire is met");
        assert!(last > first && last - first < 0.2e-3, "{first} s to {last} s");

        let scene = Scene::new(&case.robot, &case.cell, None).unwrap();
        let mut sampler = scene.sampler(&case.plan).unwrap();
        let bodies = case.bodies();
        let milliseconds = (case.plan.duration() * 1e3).round() as u32;
        for sample in 0..=milliseconds {
            let t = f64::from(sample) / 1e3;
            let margin = sampler.margin(t, &case.plan.trajectory.eval(t).q, 0.05, None).unwrap();
            assert!(margin > 0.0 && to_the_wire(&case, &bodies, t) > 0.0, "met by the sample at {t} s");
        }

        let certificate = scene.certify(&case.plan);
        assert_eq!(certificate.outcome(), ProofOutcome::Violated, "{}", case.robot.name);
        for (pair, violation) in certificate.violations() {
            assert_eq!(pair.b, "wire");
            let met = first - 1e-6..=last + 1e-6;
            assert!(met.contains(&violation.time), "{violation:?}, but it is met from {first} s to {last} s");
        }
        assert!(least(&scene, &case).upper < 0.0);
    }
}

#[test]
fn fifty_micrometres_beside_are_told_from_fifty_in_the_way() {
    for swing in swings() {
        for beside in [5e-5, -5e-5] {
            let case = passing(&swing, beside);
            let scene = Scene::new(&case.robot, &case.cell, None).unwrap();
            let certificate = scene.certify(&case.plan);
            let least = least(&scene, &case);
            assert_eq!(touch(&case).is_none(), beside > 0.0);
            if beside > 0.0 {
                assert_eq!(certificate.outcome(), ProofOutcome::Free, "{}", case.robot.name);
                let encloses = least.lower <= beside + 1e-9 && beside <= least.upper + 1e-9;
                assert!(encloses && least.upper - least.lower <= 1e-6, "{least:?}");
                assert!((least.time - PASS).abs() < 1e-3, "{least:?}");
            } else {
                assert_eq!(certificate.outcome(), ProofOutcome::Violated, "{}", case.robot.name);
                assert!(least.upper < 0.0 && least.lower < 0.0, "{least:?}");
            }
        }
    }
}
