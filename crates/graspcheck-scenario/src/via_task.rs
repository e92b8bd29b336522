//! Via points: for the wrist of a planar arm (`kind = "via"`) and for the joints (`kind = "joint_via"`).

use graspcheck_model::{
    robot::{Joint, JointKind, RobotModel},
    task::{CartesianVia, Elbow, JointVia, JointViaPoint, ViaPoint},
    via::{Blend, BlendEnds, EndCondition, ParabolicBlends, PointBlends, ViaLaw},
};
use nalgebra::Point2;

use crate::{
    fault::Fault,
    quantity::Quantity,
    robot_file::wrong_kind,
    section::{Bound, Section},
    task::PATH_TOLERANCE_DEFAULT,
};

/// The law of a motion through points, as the word in the file.
#[derive(Clone, Copy, PartialEq)]
enum Method {
    Lfpb,
    Imposed,
    Computed,
    Spline,
    VirtualPoints,
}

const METHODS: [(&str, Method); 5] = [
    ("lfpb", Method::Lfpb),
    ("imposed_velocities", Method::Imposed),
    ("computed_velocities", Method::Computed),
    ("spline", Method::Spline),
    ("virtual_points", Method::VirtualPoints),
];

/// The keys of a point that belong to some methods only.
const OF_METHODS: [&str; 8] = [
    "blend_s",
    "met_within_s",
    "velocity",
    "wrist_velocity_mm_s",
    "theta_velocity_deg_s",
    "acceleration",
    "wrist_acceleration_m_s2",
    "theta_acceleration_deg_s2",
];

/// A point with what the method asks of it; what could not be read is none.
struct Point<'a> {
    section: Section<'a>,
    t: Option<f64>,
    position: Option<Vec<f64>>,
    velocity: Option<Vec<f64>>,
    blends: Option<PointBlends>,
}

/// What a point has in the coordinates of its task.
trait Coordinates {
    /// Position, rad or m.
    fn position(&self, point: &Section<'_>) -> Option<Vec<f64>>;
    /// Whether a velocity is given.
    fn has_velocity(&self, point: &Section<'_>) -> bool;
    /// Velocity.
    fn velocity(&self, point: &Section<'_>) -> Option<Vec<f64>>;
    /// Whether accelerations of the blend are given.
    fn has_accelerations(&self, point: &Section<'_>) -> bool;
    /// Accelerations of the blend.
    fn accelerations(&self, point: &Section<'_>) -> Option<Vec<f64>>;
    /// How many there are.
    fn count(&self) -> usize;
}

/// x, y and theta.
struct Wrist;

impl Coordinates for Wrist {
    fn position(&self, point: &Section<'_>) -> Option<Vec<f64>> {
        let wrist: Option<[f64; 2]> = point.required_measures("wrist", Quantity::Length);
        let theta = point.required_measure("theta", Quantity::Angle, Bound::Any);
        let ([x, y], theta) = (wrist?, theta?);
        Some(vec![x, y, theta])
    }

    fn has_velocity(&self, point: &Section<'_>) -> bool {
        point.mentions("wrist_velocity") || point.mentions("theta_velocity")
    }

    fn velocity(&self, point: &Section<'_>) -> Option<Vec<f64>> {
        let wrist: Option<[f64; 2]> = point.required_measures("wrist_velocity", Quantity::Speed);
        let theta = point.required_measure("theta_velocity", Quantity::AngularSpeed, Bound::Any);
        let ([x, y], theta) = (wrist?, theta?);
        Some(vec![x, y, theta])
    }

    fn has_accelerations(&self, point: &Section<'_>) -> bool {
        point.mentions("wrist_acceleration") || point.mentions("theta_acceleration")
    }

    fn accelerations(&self, point: &Section<'_>) -> Option<Vec<f64>> {
        let wrist: Option<[f64; 2]> =
            point.required_measures("wrist_acceleration", Quantity::LinearAcceleration);
        let theta =
            point.required_measure("theta_acceleration", Quantity::AngularAcceleration, Bound::Positive);
        let ([x, y], theta) = (wrist?, theta?);
        Some(vec![x, y, theta])
    }

    fn count(&self) -> usize {
        3
    }
}

/// The joints of an arm, if it is known.
struct Joints<'a>(Option<&'a [Joint]>);

impl Joints<'_> {
    /// One number for each joint; the unit follows the joint's kind.
    fn of_each(
        &self,
        section: Section<'_>,
        angular: Quantity,
        linear: Quantity,
        bound: Bound,
    ) -> Option<Vec<f64>> {
        let read: Vec<Option<f64>> = self
            .0?
            .iter()
            .map(|joint| {
                let slides = joint.kind == JointKind::Prismatic;
                let quantity = if slides { linear } else { angular };
                if wrong_kind(&section, &joint.name, slides, &joint.name, quantity) {
                    return None;
                }
                section.required_measure(&joint.name, quantity, bound)
            })
            .collect();
        section.finish();
        read.into_iter().collect()
    }
}

impl Coordinates for Joints<'_> {
    fn position(&self, point: &Section<'_>) -> Option<Vec<f64>> {
        let at = point.required_section("at", "joint positions")?;
        self.of_each(at, Quantity::Angle, Quantity::Length, Bound::Any)
    }

    fn has_velocity(&self, point: &Section<'_>) -> bool {
        point.has("velocity")
    }

    fn velocity(&self, point: &Section<'_>) -> Option<Vec<f64>> {
        let velocity = point.required_section("velocity", "joint velocities")?;
        self.of_each(velocity, Quantity::AngularSpeed, Quantity::Speed, Bound::Any)
    }

    fn has_accelerations(&self, point: &Section<'_>) -> bool {
        point.has("acceleration")
    }

    fn accelerations(&self, point: &Section<'_>) -> Option<Vec<f64>> {
        let acceleration = point.required_section("acceleration", "joint accelerations")?;
        let (angular, linear) = (Quantity::AngularAcceleration, Quantity::LinearAcceleration);
        self.of_each(acceleration, angular, linear, Bound::Positive)
    }

    fn count(&self) -> usize {
        self.0.map_or(0, <[Joint]>::len)
    }
}

/// Reads `kind = "via"`.
pub(crate) fn of_wrist(section: &Section<'_>) -> Option<CartesianVia> {
    let elbow = section.word("elbow", &[("left", Elbow::Left), ("right", Elbow::Right)], None);
    let tolerance =
        section.measure_or("path_tolerance", Quantity::Length, Bound::Positive, PATH_TOLERANCE_DEFAULT);
    let (points, law) = motion(section, &Wrist, Some(Method::Lfpb))?;
    let points = points
        .into_iter()
        .map(|(t, q)| ViaPoint { t, wrist: Point2::new(q[0], q[1]), theta: q[2] })
        .collect();
    Some(CartesianVia { points, law, elbow: elbow?, tolerance: tolerance? })
}

/// Reads `kind = "joint_via"`. The points can only be read where the robot is known.
pub(crate) fn of_joints(section: &Section<'_>, robot: Option<&RobotModel>) -> Option<JointVia> {
    let joints = Joints(robot.map(|robot| robot.joints.as_slice()));
    let (points, law) = motion(section, &joints, None)?;
    Some(JointVia { points: points.into_iter().map(|(t, q)| JointViaPoint { t, q }).collect(), law })
}

/// Times and positions.
type Timed = Vec<(f64, Vec<f64>)>;

fn motion(
    section: &Section<'_>,
    coordinates: &dyn Coordinates,
    default: Option<Method>,
) -> Option<(Timed, ViaLaw)> {
    let method = section.word("method", &METHODS, default);
    let blend = match method {
        Some(Method::Lfpb) => section.measure("blend", Quantity::Time, Bound::Positive),
        _ => None,
    };
    let points = points(section, coordinates, method, blend);
    if method.is_none() {
        // Nobody knows which of these belong here.
        for key in ["blend_s", "ends", "spline_ends", "virtual_s"] {
            section.ask(key);
        }
        for point in &points {
            OF_METHODS.iter().for_each(|key| point.section.ask(key));
        }
    }
    let law = method.and_then(|method| law(section, method, &points));
    report_order(&points);
    let read = points
        .into_iter()
        .map(|point| {
            point.section.finish();
            Some((point.t?, point.position?))
        })
        // Every point is read to its end, whatever is wrong with one before.
        .collect::<Vec<_>>();
    Some((read.into_iter().collect::<Option<_>>()?, law?))
}

fn points<'a>(
    section: &Section<'a>,
    coordinates: &dyn Coordinates,
    method: Option<Method>,
    blend: Option<f64>,
) -> Vec<Point<'a>> {
    let sections = section.sections("via", "a via point");
    let count = sections.len();
    if count < 2 {
        let title = format!("a motion has at least two via points, this has {count}");
        section.faults().report(Fault::new("missing-key", section.place(), title, "add [[task.via]]"));
    }
    let one = |(k, point): (usize, Section<'a>)| {
        let is_end = k == 0 || k + 1 == count;
        let t = point.required_measure("t", Quantity::Time, Bound::NotNegative);
        let position = coordinates.position(&point);
        let velocity = match method {
            // At the ends it may be left out: then the motion begins or ends at rest.
            Some(Method::Imposed) if is_end && !coordinates.has_velocity(&point) => {
                Some(vec![0.0; coordinates.count()])
            }
            Some(Method::Imposed) => coordinates.velocity(&point),
            _ => None,
        };
        let blends = match method {
            Some(Method::Lfpb) => blends(&point, coordinates, blend, is_end),
            _ => None,
        };
        Point { section: point, t, position, velocity, blends }
    };
    sections.into_iter().enumerate().map(one).collect()
}

/// The blends at a point: by accelerations, by a duration, or by the duration of all.
fn blends(
    point: &Section<'_>,
    coordinates: &dyn Coordinates,
    default: Option<f64>,
    is_end: bool,
) -> Option<PointBlends> {
    let has_met = point.mentions("met_within");
    let met = point.measure_at("met_within", Quantity::Time, Bound::Positive);
    if let (Some((_, at)), true) = (met, is_end) {
        let title = "the first and the last via point cannot lie between pseudo via points";
        let label = "leave it out: with `ends = \"inside\"` they are met as they are";
        point.faults().report(Fault::new("met-end", at, title, label));
        return None;
    }
    let velocity = match coordinates.has_velocity(point) {
        true => Some(coordinates.velocity(point)),
        false => None,
    };
    if velocity.is_some() && !has_met {
        let title = "a velocity belongs to a via point that is met";
        let label = "add `met_within_s`, or leave the velocity out";
        point.faults().report(Fault::new("not-met", point.place(), title, label));
    }
    let blends = if coordinates.has_accelerations(point) {
        if point.mentions("blend") {
            point.measure("blend", Quantity::Time, Bound::Positive);
            let title = "a via point has either a blend time or accelerations";
            let label = "the blend time follows from the accelerations";
            point.faults().report(Fault::new("two-blends", point.place(), title, label));
        }
        coordinates.accelerations(point)?.into_iter().map(Blend::Acceleration).collect()
    } else {
        let duration = match point.measure("blend", Quantity::Time, Bound::Positive) {
            None if !point.mentions("blend") && default.is_some() => default,
            None if !point.mentions("blend") => {
                point.missing(&Quantity::Time.key("blend"));
                None
            }
            given => given,
        };
        vec![Blend::Duration(duration?); coordinates.count()]
    };
    if met.is_some() != has_met || velocity.is_some() && !has_met {
        return None;
    }
    // A velocity that could not be read is none, which was reported.
    let velocity = match velocity {
        Some(velocity) => Some(velocity?),
        None => None,
    };
    Some(PointBlends { blends, met: met.map(|(bracket, _)| bracket), velocity })
}

/// Reports every point that does not come after the one before it.
fn report_order(points: &[Point<'_>]) {
    for (k, pair) in points.windows(2).enumerate() {
        let (Some(previous), Some(t)) = (pair[0].t, pair[1].t) else { continue };
        if t <= previous {
            let title = format!("via point {}: t = {t} s is not after {previous} s", k + 2);
            let section = &pair[1].section;
            let fault = Fault::new("range", section.place(), title, "points stand in order of time");
            section.faults().report(fault);
        }
    }
}

fn law(section: &Section<'_>, method: Method, points: &[Point<'_>]) -> Option<ViaLaw> {
    match method {
        Method::Computed => Some(ViaLaw::ComputedVelocities),
        Method::Imposed => points
            .iter()
            .map(|point| point.velocity.clone())
            .collect::<Option<_>>()
            .map(ViaLaw::ImposedVelocities),
        Method::Lfpb => {
            let ends = section.word(
                "ends",
                &[("inside", BlendEnds::Inside), ("centred", BlendEnds::Centred)],
                Some(BlendEnds::Inside),
            );
            let points = points.iter().map(|point| point.blends.clone()).collect::<Option<_>>();
            Some(ViaLaw::ParabolicBlends(ParabolicBlends { points: points?, ends: ends? }))
        }
        Method::Spline => {
            let words = [
                ("at_rest", EndCondition::AtRest),
                ("natural", EndCondition::Natural),
                ("not_a_knot", EndCondition::NotAKnot),
                ("periodic", EndCondition::Periodic),
            ];
            let condition = section.word("spline_ends", &words, None)?;
            if condition == EndCondition::Periodic {
                report_open(points);
            }
            Some(ViaLaw::Spline(condition))
        }
        Method::VirtualPoints => {
            let times: [f64; 2] = section.required_measures("virtual", Quantity::Time)?;
            report_virtual(section, times, points);
            Some(ViaLaw::VirtualPoints(times))
        }
    }
}

/// Reports a periodic motion that does not end where it began.
fn report_open(points: &[Point<'_>]) {
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return };
    if let (Some(start), Some(end)) = (&first.position, &last.position)
        && start != end
    {
        let title = "a periodic motion ends where it begins, this one does not";
        let fault =
            Fault::new("range", last.section.place(), title, "repeat the positions of the first point");
        last.section.faults().report(fault.second(first.section.place(), "it begins here"));
    }
}

/// Reports a virtual point outside its segment.
fn report_virtual(section: &Section<'_>, times: [f64; 2], points: &[Point<'_>]) {
    let due: Option<Vec<f64>> = points.iter().map(|point| point.t).collect();
    let Some(due) = due.filter(|due| due.len() >= 2) else { return };
    let last = due.len() - 1;
    let after = if last == 1 { times[0] } else { due[last - 1] };
    for (word, time, from, to) in
        [("first", times[0], due[0], due[1]), ("second", times[1], after, due[last])]
    {
        if !(time > from && time < to) {
            let title =
                format!("the {word} virtual point is due at {time} s, not between {from} s and {to} s");
            let at = section.place_of("virtual", Quantity::Time).unwrap_or(section.place());
            let label = "one lies in the first segment, one in the last";
            section.faults().report(Fault::new("range", at, title, label));
        }
    }
}
