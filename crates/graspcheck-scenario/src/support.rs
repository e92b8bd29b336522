//! Whether the object stands on something at the start: nothing floats, and nothing is inside another body.
//!
//! Something bears the object when it lies below it, along gravity, within [`SUPPORT_REACH`], as the proof of
//! clearance sees it. Without gravity nothing needs to.

use graspcheck_model::{Pose, cell::CellBody, object::Object, robot::RobotModel, shape::Shape};
use graspcheck_proof::{
    contact::{SUPPORT_OVERLAP, SUPPORT_REACH},
    gap,
    solid::{Place, Placed, Solid},
};
use nalgebra::{Translation3, Vector3};

/// Nearer than this the object counts as having landed when it is let down, m.
const LANDED: f64 = 1e-6;

/// Steps of letting it down; each goes as far as nothing can be in the way.
const STEPS: usize = 400;

/// What is wrong with where the object stands.
#[derive(Clone, Debug, PartialEq)]
pub enum Unsupported {
    /// It overlaps a body.
    Inside {
        /// Name of the body.
        body: String,
        /// How deep, m.
        depth: f64,
    },
    /// It would fall onto a body.
    Above {
        /// Name of the body.
        body: String,
        /// How far, m.
        fall: f64,
    },
    /// It would fall, and nothing is below it.
    Nothing,
}

/// A solid that stands still.
struct Standing<'a> {
    name: &'a str,
    solid: Solid,
    place: Place,
}

impl<'a> Standing<'a> {
    /// None for a shape that is no solid, which is a fault by itself.
    fn new(name: &'a str, shape: &Shape, world_from_shape: &Pose) -> Option<Self> {
        let (solid, origin) = Solid::from_shape(shape).ok()?;
        let place = Place::from(&(world_from_shape * Translation3::from(origin)));
        Some(Self { name, solid, place })
    }

    fn placed(&self) -> Placed<'_> {
        Placed { solid: &self.solid, place: self.place }
    }

    fn moved(&self, by: &Vector3<f64>) -> Placed<'_> {
        let place = Place { center: self.place.center + by, ..self.place };
        Placed { solid: &self.solid, place }
    }
}

/// What is wrong with where `object` stands among the bodies of a cell and the base of the robot, under
/// `gravity` (m/s², in the world); none when something bears it or there is no gravity.
#[must_use]
pub fn unsupported(
    object: &Object,
    bodies: &[&CellBody],
    robot: Option<&RobotModel>,
    gravity: &Vector3<f64>,
) -> Option<Unsupported> {
    let object = Standing::new(&object.name, &object.shape, &object.world_from_object)?;
    let cell =
        bodies.iter().filter_map(|body| Standing::new(&body.name, &body.shape, &body.world_from_shape));
    let base = robot.into_iter().flat_map(|robot| {
        robot.base.shapes.iter().filter_map(|placed| {
            Standing::new(&robot.base.name, &placed.shape, &(robot.world_from_base * placed.body_from_shape))
        })
    });
    let others: Vec<Standing<'_>> = cell.chain(base).collect();
    for other in &others {
        if gap::overlap_of_at_least(&object.placed(), &other.placed(), SUPPORT_OVERLAP).is_some() {
            let known = gap::separation(&object.placed(), &other.placed(), None, gap::FINEST_TOLERANCE);
            let depth = known.map_or(SUPPORT_OVERLAP, |known| -known.lower);
            return Some(Unsupported::Inside { body: other.name.to_owned(), depth });
        }
    }
    let down = gravity.try_normalize(0.0)?;
    let falls = others.iter().filter_map(|other| Some((other, fall(&object, other, &down)?)));
    match falls.min_by(|(_, a), (_, b)| a.total_cmp(b)) {
        Some((_, fall)) if fall <= SUPPORT_REACH => None,
        Some((other, fall)) => Some(Unsupported::Above { body: other.name.to_owned(), fall }),
        None => Some(Unsupported::Nothing),
    }
}

/// How far the object falls along `down` (of length 1) until it lands on `other`, m; none when it misses it.
///
/// By conservative advancement: the object can always go as far as the distance to the other one.
fn fall(object: &Standing<'_>, other: &Standing<'_>, down: &Vector3<f64>) -> Option<f64> {
    let extent = object.solid.bounding_radius() + other.solid.bounding_radius();
    let ahead = (other.place.center - object.place.center).dot(down);
    let mut fallen = 0.0;
    for _ in 0..STEPS {
        let here = object.moved(&(fallen * down));
        let apart = gap::separation(&here, &other.placed(), None, gap::FINEST_TOLERANCE)?;
        if apart.upper <= LANDED {
            // What it only grazes on its way does not bear it.
            return (gap::gap(&here, &other.placed(), down) >= -SUPPORT_REACH).then_some(fallen);
        }
        fallen += apart.lower.max(LANDED / 2.0);
        if fallen > ahead + extent {
            return None;
        }
    }
    Some(fallen)
}

#[cfg(test)]
mod tests {
    use graspcheck_model::object::Object;

    use super::*;

    fn cube(at: [f64; 3]) -> Object {
        Object {
            name: "cube".into(),
            shape: Shape::Box { half_extents: Vector3::repeat(0.015) },
            mass: 0.1,
            friction: 0.5,
            world_from_object: Pose::translation(at[0], at[1], at[2]),
            handles: Vec::new(),
        }
    }

    fn body(name: &str, shape: Shape, at: [f64; 3]) -> CellBody {
        CellBody { name: name.into(), shape, world_from_shape: Pose::translation(at[0], at[1], at[2]) }
    }

    fn bench() -> CellBody {
        body("bench", Shape::Box { half_extents: Vector3::new(0.2, 0.3, 0.01) }, [0.3, 0.0, -0.01])
    }

    fn found(object: &Object, cell: &[CellBody], gravity: Vector3<f64>) -> Option<Unsupported> {
        unsupported(object, &cell.iter().collect::<Vec<_>>(), None, &gravity)
    }

    const DOWN: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

    #[test]
    fn what_stands_on_a_body_is_supported_and_what_floats_is_not() {
        assert_eq!(found(&cube([0.3, 0.1, 0.015]), &[bench()], DOWN), None);
        assert_eq!(found(&cube([0.3, 0.1, 0.016]), &[bench()], DOWN), None);
        let Some(Unsupported::Above { body, fall }) = found(&cube([0.3, 0.1, 0.027]), &[bench()], DOWN)
        else {
            panic!("it floats");
        };
        assert_eq!(body, "bench");
        assert!((fall - 0.012).abs() < 2e-6, "{fall}");
        assert_eq!(found(&cube([0.3, 0.4, 0.015]), &[bench()], DOWN), Some(Unsupported::Nothing));
    }

    #[test]
    fn what_overlaps_is_named_with_its_depth() {
        let Some(Unsupported::Inside { body, depth }) = found(&cube([0.3, 0.1, 0.01]), &[bench()], DOWN)
        else {
            panic!("it is inside");
        };
        assert_eq!(body, "bench");
        assert!((depth - 0.005).abs() < 1e-6, "{depth}");
    }

    #[test]
    fn support_is_needed_along_gravity_and_without_gravity_none() {
        let floating = cube([0.3, 0.1, 0.2]);
        assert_eq!(found(&floating, &[bench()], Vector3::zeros()), None);
        // A wall beside the cube bears it under gravity across.
        let wall = body("wall", Shape::Box { half_extents: Vector3::new(0.1, 0.01, 0.1) }, [0.3, 0.075, 0.2]);
        assert_eq!(found(&floating, std::slice::from_ref(&wall), Vector3::new(0.0, -9.81, 0.0)), None);
        assert_eq!(found(&floating, &[wall], DOWN), Some(Unsupported::Nothing));
    }

    #[test]
    fn a_body_that_is_touched_from_the_side_does_not_bear() {
        let post = body("post", Shape::Box { half_extents: Vector3::repeat(0.01) }, [0.325, 0.1, 0.2]);
        match found(&cube([0.3, 0.1, 0.2]), &[post, bench()], DOWN) {
            Some(Unsupported::Above { body, fall }) => {
                assert_eq!(body, "bench");
                assert!((fall - 0.185).abs() < 1e-5, "{fall}");
            }
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn round_things_land_on_round_things() {
        let mut ball = cube([0.0, 0.0, 0.1]);
        ball.shape = Shape::Sphere { radius: 0.02 };
        let post = body("post", Shape::Sphere { radius: 0.03 }, [0.0, 0.0, 0.0]);
        match found(&ball, &[post], DOWN) {
            Some(Unsupported::Above { fall, .. }) => assert!((fall - 0.05).abs() < 1e-5, "{fall}"),
            other => panic!("{other:?}"),
        }
    }
}
