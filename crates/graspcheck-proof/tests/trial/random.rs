//! Random scenes: an arm, obstacles near its way, a motion of several polynomials, sometimes with a held object.

use graspcheck_model::{
    Pose,
    cell::{Cell, CellBody, PairRule},
    object::Object,
    plan::{Grasp, Holding, Phase, Plan},
    robot::{JointKind, RobotModel},
    shape::Shape,
};
use graspcheck_motion::{Polynomial, Trajectory};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::{
    arms::{self, Arm},
    distance::{distance, distance_above},
    fixtures::{self, Draw},
    motion::{Bodies, Carrier, Moment},
    solid::{Placed, Solid},
};

/// A scene and a motion in it.
#[derive(Clone, Debug)]
pub struct Case {
    pub robot: RobotModel,
    pub cell: Cell,
    pub object: Option<Object>,
    pub plan: Plan,
}

impl Case {
    pub fn bodies(&self) -> Bodies<'_> {
        Bodies::new(&self.robot, &self.cell, self.object.as_ref(), &self.plan)
    }

    /// Whether two bodies may touch at any time: by an allowed contact, or as the object and a finger that holds it.
    pub fn may_touch(&self, a: &str, b: &str) -> bool {
        let is = |x: &str, y: &str| (a == x && b == y) || (a == y && b == x);
        let object = self.object.as_ref().map_or("", |object| &object.name);
        self.robot.allowed_contacts.iter().any(|contact| is(&contact.a, &contact.b))
            || self.robot.gripper.fingers.iter().any(|finger| is(object, &finger.link.name))
    }

    /// The case of this arm and number; the same number is the same case, everywhere.
    pub fn random(arm: Arm, seed: u64) -> Self {
        let mut draw = Draw(seed.wrapping_mul(0x2545_f491_4f6c_dd1d) ^ arm as u64);
        for _ in 0..4 {
            draw.between(0.0, 1.0);
        }
        let mut case = Self::of_the_arm_alone(arm, &mut draw);
        for _ in 0..TRIES {
            if happens(&mut draw, AS_IT_COMES) || Glimpses::of(&case.bodies()).robot_is_clear(&case) {
                break;
            }
            case = Self::of_the_arm_alone(arm, &mut draw);
        }
        case.cell = case.random_cell(arm, &mut draw);
        case
    }

    /// An arm in an empty cell that moves, with or without an object in its gripper.
    pub fn of_the_arm_alone(arm: Arm, draw: &mut Draw) -> Self {
        let robot = arm.robot(draw);
        let held = happens(draw, 0.3);
        let trajectory = trajectory(&robot, arm, draw);
        let duration = trajectory.duration();
        let scale = arm.scale();
        let (object, grasp, opening, holding) = if held {
            let width = draw.between(0.3, 0.9) * robot.gripper.opening_max.min(0.05 * scale);
            let (object, grasp) = held_object(&robot, width, scale, draw);
            let opening = Trajectory::hold(&[width], duration).unwrap();
            (Some(object), Some(grasp), opening, Holding::Held)
        } else {
            let [from, to] = [0, 1].map(|_| draw.between(0.0, 1.0) * robot.gripper.opening_max);
            let piece = Polynomial::quintic_hermite([from, 0.0, 0.0], [to, 0.0, 0.0], duration);
            (None, None, Trajectory::new(1, vec![0.0, duration], vec![piece]).unwrap(), Holding::Nothing)
        };
        let phase = Phase { name: "move".to_owned(), start: 0.0, end: duration, holding };
        let plan = Plan { trajectory, opening, phases: vec![phase], grasp, paths: Vec::new() };
        Self { robot, cell: fixtures::cell(0.0, Vec::new()), object, plan }
    }

    /// Obstacles beside solids of the arm where they are at random times.
    fn random_cell(&self, arm: Arm, draw: &mut Draw) -> Cell {
        let scale = arm.scale();
        // Now and then so many, and farther off, that sweeps are worth their while.
        let is_full = happens(draw, FULL_CELLS);
        let (count, farthest) = if is_full { (30, 0.4) } else { (3 + draw.between(0.0, 4.0) as usize, 0.12) };
        let bodies = self.bodies();
        let glimpses = Glimpses::of(&bodies);
        let mut cell = fixtures::cell(0.0, Vec::new());
        for index in 0..count {
            let mut obstacle = random_obstacle(&bodies, scale, farthest, draw);
            for _ in 0..TRIES {
                if happens(draw, AS_IT_COMES) || glimpses.is_clear_of(&obstacle) {
                    break;
                }
                obstacle = random_obstacle(&bodies, scale, farthest, draw);
            }
            obstacle.name = format!("obstacle_{index}");
            cell.bodies.push(obstacle);
        }
        if happens(draw, 0.5) {
            cell.clearance.required = 0.002 * scale;
        }
        if happens(draw, 0.5) {
            // A rule of its own, about as far as the two come: it is kept or broken by little.
            let moving = bodies.parts.iter().filter(|part| part.carrier != Carrier::World);
            let moving: Vec<&str> = moving.map(|part| part.body.as_str()).collect();
            let body = moving[draw.between(0.0, moving.len() as f64) as usize];
            let least = glimpses.least(&cell.bodies[0], |name| name == body);
            cell.clearance.pairs.push(PairRule {
                a: body.to_owned(),
                b: cell.bodies[0].name.clone(),
                required: least.max(0.0) * draw.between(0.98, 1.0),
                reason: "a trial".to_owned(),
            });
        }
        cell
    }
}

/// How often a scene or an obstacle is drawn again because it collides.
const TRIES: usize = 12;
/// The share of cells with thirty obstacles.
const FULL_CELLS: f64 = 0.06;
/// The share of those that are taken as they come.
const AS_IT_COMES: f64 = 0.04;

fn happens(draw: &mut Draw, share: f64) -> bool {
    draw.between(0.0, 1.0) < share
}

/// The scene at a few instants, to make scenes that are not all full of collisions.
struct Glimpses<'b> {
    bodies: &'b Bodies<'b>,
    moments: Vec<Moment>,
}

impl<'b> Glimpses<'b> {
    fn of(bodies: &'b Bodies<'b>) -> Self {
        const COUNT: u32 = 40;
        let time = |index: u32| bodies.duration() * f64::from(index) / f64::from(COUNT);
        Self { bodies, moments: (0..=COUNT).map(|index| bodies.at(time(index))).collect() }
    }

    /// The least distance of an obstacle and the bodies with such a name that was seen, m.
    fn least(&self, obstacle: &CellBody, counts: impl Fn(&str) -> bool) -> f64 {
        let solid = Solid::of(&obstacle.shape);
        let obstacle = Placed::new(&solid, &obstacle.world_from_shape);
        let parts = (0..self.bodies.parts.len()).filter(|part| counts(&self.bodies.parts[*part].body));
        let distances = parts.flat_map(|part| {
            let place = move |moment| distance(&self.bodies.placed(part, moment), &obstacle).upper;
            self.moments.iter().map(place)
        });
        distances.fold(f64::INFINITY, f64::min)
    }

    /// Whether no solid of the arm was seen to touch an obstacle.
    fn is_clear_of(&self, obstacle: &CellBody) -> bool {
        let solid = Solid::of(&obstacle.shape);
        let obstacle = Placed::new(&solid, &obstacle.world_from_shape);
        self.moments.iter().all(|moment| {
            let mut parts = 0..self.bodies.parts.len();
            parts.all(|part| are_apart(&self.bodies.placed(part, moment), &obstacle))
        })
    }

    /// Whether links that may not touch were apart.
    fn robot_is_clear(&self, case: &Case) -> bool {
        let parts = &self.bodies.parts;
        (0..parts.len()).all(|a| {
            (0..a).all(|b| {
                let (part_a, part_b) = (&parts[a], &parts[b]);
                part_a.carrier == part_b.carrier
                    || case.may_touch(&part_a.body, &part_b.body)
                    || self.moments.iter().all(|moment| {
                        are_apart(&self.bodies.placed(a, moment), &self.bodies.placed(b, moment))
                    })
            })
        })
    }
}

fn are_apart(a: &Placed, b: &Placed) -> bool {
    let between = (a.origin - b.origin).norm() - a.solid.reach() - b.solid.reach();
    between > 0.0 || distance_above(a, b, 0.0).lower > 0.0
}

/// An obstacle without a name beside a solid of the arm.
fn random_obstacle(bodies: &Bodies, scale: f64, farthest: f64, draw: &mut Draw) -> CellBody {
    let moving: Vec<usize> =
        (0..bodies.parts.len()).filter(|part| bodies.parts[*part].carrier != Carrier::World).collect();
    let near = moving[draw.between(0.0, moving.len() as f64) as usize];
    let moment = bodies.at(draw.between(0.0, bodies.duration()));
    let solid = bodies.placed(near, &moment);
    let towards = arms::direction(draw);
    let shape = arms::solid(draw, 0.01 * scale, 0.09 * scale);
    // From the middle of the solid outwards: some overlap, some touch, most are beside.
    let surface = solid.support(&towards) - solid.origin;
    let beside = draw.between(-0.02, farthest) * scale;
    let center = solid.origin + surface + towards * (beside + extent(&shape));
    let turn = if happens(draw, 0.4) {
        UnitQuaternion::from_euler_angles(0.0, 0.0, draw.between(-3.0, 3.0))
    } else {
        arms::rotation(draw)
    };
    CellBody { name: String::new(), shape, world_from_shape: Isometry3::from_parts(center.into(), turn) }
}

/// About how far a shape reaches from its middle, m.
fn extent(shape: &Shape) -> f64 {
    match shape {
        Shape::Box { half_extents } => half_extents.min(),
        Shape::Sphere { radius } => *radius,
        Shape::Cylinder { radius, half_length } => radius.min(*half_length),
        Shape::Capsule { radius, .. } => *radius,
        Shape::Hull { points } => 0.6 * points[0].coords.norm(),
    }
}

/// One to five quintics through random points with random speeds and accelerations; some with a bump, so that the
/// joint turns back within the piece.
pub fn trajectory(robot: &RobotModel, arm: Arm, draw: &mut Draw) -> Trajectory {
    let pieces = 1 + draw.between(0.0, 5.0) as usize;
    let pace = if arm == Arm::Rrr { 2.0 } else { 1.0 };
    let mut knots = vec![0.0];
    for piece in 0..pieces {
        knots.push(knots[piece] + draw.between(0.06, 0.3) * pace);
    }
    let mut polynomials = vec![Polynomial::constant(0.0); pieces * robot.dof()];
    for joint in 0..robot.dof() {
        let (low, high) = range(robot, joint);
        let stroke = high - low;
        let mut state = [draw.between(low, high), 0.0, 0.0];
        for piece in 0..pieces {
            let h = knots[piece + 1] - knots[piece];
            let last = piece + 1 == pieces;
            let rest = last || draw.between(0.0, 1.0) < 0.3;
            let target = (state[0] + draw.between(-0.3, 0.3) * stroke).clamp(low, high);
            let speed = if rest { 0.0 } else { draw.between(-0.4, 0.4) * stroke / h };
            let acceleration = if rest { 0.0 } else { draw.between(-1.0, 1.0) * stroke / (h * h) };
            let next = [target, speed, acceleration];
            let mut polynomial = Polynomial::quintic_hermite(state, next, h);
            if draw.between(0.0, 1.0) < 0.3 {
                polynomial = with_bump(&polynomial, draw.between(-0.15, 0.15) * stroke, h);
            }
            polynomials[piece * robot.dof() + joint] = polynomial;
            state = next;
        }
    }
    Trajectory::new(robot.dof(), knots, polynomials).unwrap()
}

/// `64 c (τ/h)³ (1 - τ/h)³` more: a bump of height `c` with position, speed and acceleration zero at both ends.
fn with_bump(polynomial: &Polynomial, height: f64, h: f64) -> Polynomial {
    let mut all = *polynomial.coefficients();
    for (power, share) in [(3, 64.0), (4, -192.0), (5, 192.0), (6, -64.0)] {
        all[power] += height * share / h.powi(power as i32);
    }
    Polynomial::new(all)
}

/// Where a joint may be in these trials.
fn range(robot: &RobotModel, joint: usize) -> (f64, f64) {
    let limits = &robot.joints[joint].limits;
    match robot.joints[joint].kind {
        JointKind::Revolute => (limits.position_min.max(-2.0), limits.position_max.min(2.0)),
        JointKind::Prismatic => (limits.position_min.max(-0.2), limits.position_max.min(0.2)),
    }
}

/// A box between the pads, as wide as they are apart.
fn held_object(robot: &RobotModel, width: f64, scale: f64, draw: &mut Draw) -> (Object, Grasp) {
    let half_extents =
        Vector3::new(draw.between(0.006, 0.014) * scale, 0.5 * width, draw.between(0.008, 0.03) * scale);
    let object = Object {
        name: "object".to_owned(),
        shape: Shape::Box { half_extents },
        mass: 0.3 * scale,
        friction: 0.8,
        world_from_object: Pose::identity(),
        handles: Vec::new(),
    };
    let along = Translation3::new(draw.between(0.0, 0.004) * scale, 0.0, draw.between(-0.005, 0.005) * scale);
    let grasp = Grasp {
        handle: "sides".to_owned(),
        tool_from_object: along.into(),
        width,
        opening: robot.gripper.opening_max,
        force: 10.0,
        world_from_start: Pose::identity(),
        world_from_placed: Pose::identity(),
    };
    (object, grasp)
}
