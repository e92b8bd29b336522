//! A path of the tool as a planar arm sees it, and the joint motion that follows it, with all derivatives.
//!
//! For the arms of [`crate::structure`] a pose of the tool is three things: where the wrist is in the plane, how
//! high the tool is, and how far it is turned about the base's z (ψ, literal: not wrapped). Inverse and forward
//! kinematics are short formulas in them, which are written here once over [`Jet`]s: the derivatives of the
//! joints by s, or in time, come out to any order and, over intervals, as bounds.
//!
//! With w the wrist as seen from axis 1, r = |w|, l₁ and l₂ the lengths and φ₂ the elbow's angle:
//!
//! ```text
//! cos φ₂ = (r² − l₁² − l₂²) / (2 l₁ l₂)            φ₂' = −(cos φ₂)' / sin φ₂
//! q₁' = (w × w') / r² − l₂ (l₂ + l₁ cos φ₂) / r² · φ₂'
//! q₂' = φ₂',   q_quill = height − height at zero,   q_last = ψ − q₁ − q₂
//! ```
//!
//! The first line is the law of cosines; the second is the rate of the direction to the wrist less that of
//! the angle between it and the upper arm (Siciliano et al., *Robotics: Modelling, Planning and Control*,
//! section 2.12, differentiated).

use graspcheck_motion::{Jet, Polynomial, Real, Scalar};
use nalgebra::{Unit, Vector2, Vector3};

use crate::{
    Pose,
    inverse::{POSE_TOLERANCE, Unreachable},
    plan::TrackedPoint,
    robot::{JointKind, RobotModel},
    structure::PlanarGeometry,
    task::Elbow,
    tool_path::{ArcCurve, PositionCurve, ToolPath},
};

/// The most joints that a planar arm has.
pub const PLANAR_JOINTS: usize = 4;

/// Rounding of the constants of an arm and a path (measured lengths, vectors turned into the base's frame), as
/// a share of the lengths they have: some hundred roundings, of which each is 1e-16.
const CONSTANT_ROUNDING: f64 = 1e-13;

/// How far the wrist may be outside the reach, relative to it: within rounding the arm counts as straight.
const REACH_TOLERANCE: f64 = 1e-12;

/// A path of the tool, or of the wrist, in the frame of a planar arm.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanarPath {
    geometry: PlanarGeometry,
    segments: Vec<PlanarSegment>,
    /// From the wrist to the tracked point at ψ = 0, m: the tool's origin, or the wrist itself.
    offset: Vector2<f64>,
    slack: Slack,
}

/// By how much the planar formulas can differ from the chain of transforms and the path in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slack {
    /// Of a position, m.
    pub position: f64,
    /// Of an angle, rad.
    pub angle: f64,
}

/// A stretch of the path with one formula.
#[derive(Clone, Debug, PartialEq)]
struct PlanarSegment {
    start: f64,
    end: f64,
    /// Of the tracked point: x and y from axis 1, z above the height at the zero position; base frame.
    position: PositionCurve,
    /// ψ, rad, of σ.
    turn: Polynomial,
}

/// What the path asks of the arm at a place.
#[derive(Clone, Copy, Debug)]
pub struct PlanarTarget<S, const N: usize> {
    /// From axis 1 to the wrist in the base's x-y plane, m.
    pub wrist: [Jet<S, N>; 2],
    /// Of the tool over its height at the zero position, m.
    pub rise: Jet<S, N>,
    /// ψ, rad.
    pub turn: Jet<S, N>,
}

/// Cosine and signed sine of the elbow's angle.
#[derive(Clone, Copy, Debug)]
pub struct ElbowAngle<S, const N: usize> {
    /// cos φ₂.
    pub cos: Jet<S, N>,
    /// sin φ₂, positive for the left elbow.
    pub sin: Jet<S, N>,
}

impl PlanarPath {
    /// The path of the tool in the frame of the arm.
    ///
    /// ```
    /// use graspcheck_model::{example, planar_path::PlanarPath, task::Elbow, tool_path::*};
    /// use graspcheck_motion::{Jet, Polynomial};
    /// // The tool of the planar arm stays at (7, 2) m and turns by 1 rad: wrist and joints move all the same.
    /// let robot = example::planar();
    /// let start = robot.world_from_tool(&[0.0, 0.5, -0.5]).rotation;
    /// let path = ToolPath::new(vec![ToolSegment {
    ///     start: 0.0,
    ///     end: 1.0,
    ///     position: PositionCurve::Polynomial([7.0, 2.0, 0.0].map(Polynomial::constant)),
    ///     orientation: OrientationCurve::turning(start, nalgebra::Vector3::z_axis(), Polynomial::new([0.0, 1.0])),
    /// }])?;
    /// let planar = PlanarPath::new(&robot, &path).map_err(|(_, bound)| bound)?;
    /// let q = planar.positions(&planar.target(0, Jet::constant(1.0)), Elbow::Left, &[0.0; 3], 0.0)?;
    /// assert!((q[..3].iter().sum::<f64>() - 1.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// The place s, and why, when the arm has no closed form, the path turns the tool about another axis than
    /// the arm can, or it leads out of the plane of an arm without a quill. Whether the wrist comes too far
    /// from axis 1 or too near is for whoever follows the path.
    pub fn new(robot: &RobotModel, path: &ToolPath) -> Result<Self, (f64, Unreachable)> {
        Self::tracking(robot, path, TrackedPoint::Tool)
    }

    /// The path of a point of the arm in its frame: where `path` has its position, there the point should be, and
    /// the tool is turned as `path` says.
    ///
    /// # Errors
    /// As [`PlanarPath::new`].
    pub fn tracking(
        robot: &RobotModel,
        path: &ToolPath,
        point: TrackedPoint,
    ) -> Result<Self, (f64, Unreachable)> {
        let geometry = geometry(robot).map_err(|bound| (path.start(), bound))?;
        let base_from_world = robot.world_from_base.inverse();
        let shoulder = Vector3::new(geometry.shoulder.x, geometry.shoulder.y, geometry.tool_height);
        let offset = match point {
            TrackedPoint::Tool => geometry.tool_offset,
            TrackedPoint::Wrist => Vector2::zeros(),
        };
        let (turn, lean) = turn_of(&geometry, &(base_from_world * path.pose(path.start())));
        if lean > POSE_TOLERANCE {
            return Err((path.start(), Unreachable::Tilted { angle: lean }));
        }
        let mut turned = turn;
        let mut tilt = lean;
        let mut segments = Vec::with_capacity(path.segments().len());
        for segment in path.segments() {
            let length = segment.end - segment.start;
            let mut coefficients = [0.0; 8];
            for turn in &segment.orientation.turns {
                let axis = base_from_world.rotation * turn.axis.into_inner();
                let sweep = turn.angle.plus(-turn.angle.coefficients()[0]);
                let swept = sweep.coefficients().iter().rev().fold(0.0, |sum, c| sum * length + c.abs());
                tilt += axis.xy().norm() * swept;
                if tilt > POSE_TOLERANCE {
                    return Err((segment.start, Unreachable::Tilted { angle: tilt }));
                }
                for (sum, c) in coefficients.iter_mut().zip(sweep.coefficients()) {
                    *sum += axis.z.signum() * c;
                }
            }
            coefficients[0] = turned;
            let turn = Polynomial::new(coefficients);
            turned = turn.eval(length)[0];
            let position = moved(&segment.position, &base_from_world, &shoulder);
            segments.push(PlanarSegment { start: segment.start, end: segment.end, position, turn });
        }
        let slack = slack(robot, &geometry, tilt, &segments);
        let path = Self { geometry, segments, offset, slack };
        if path.geometry.quill.is_none() {
            path.check_plane()?;
        }
        Ok(path)
    }

    /// The arm.
    #[must_use]
    pub fn geometry(&self) -> &PlanarGeometry {
        &self.geometry
    }

    /// The number of joints.
    #[must_use]
    pub fn dof(&self) -> usize {
        if self.geometry.quill.is_some() { 4 } else { 3 }
    }

    /// By how much the formulas here can differ from the chain of transforms and the path in space.
    #[must_use]
    pub fn slack(&self) -> Slack {
        self.slack
    }

    /// The number of segments.
    #[must_use]
    pub fn segment_count(&self) -> usize {
        self.segments.len()
    }

    /// The path parameter at both ends of a segment.
    ///
    /// # Panics
    /// When there is no such segment.
    #[must_use]
    pub fn segment(&self, segment: usize) -> [f64; 2] {
        let PlanarSegment { start, end, .. } = self.segments[segment];
        [start, end]
    }

    /// The path parameter at the beginning.
    #[must_use]
    pub fn start(&self) -> f64 {
        self.segment(0)[0]
    }

    /// The path parameter at the end.
    #[must_use]
    pub fn end(&self) -> f64 {
        self.segment(self.segment_count() - 1)[1]
    }

    /// The segment that holds `s`; where two meet, the later one; the first or last beyond the ends.
    #[must_use]
    pub fn segment_at(&self, s: f64) -> usize {
        self.segments.partition_point(|segment| segment.start <= s).max(1) - 1
    }

    /// The tracked point (the tool's origin, or the wrist): x and y from axis 1 and the rise, m, where the path
    /// parameter is `s`, by the formula of a segment.
    #[must_use]
    pub fn point<S: Real, const N: usize>(&self, segment: usize, s: Jet<S, N>) -> [Jet<S, N>; 3] {
        let PlanarSegment { start, position, .. } = &self.segments[segment];
        position.at(s - Jet::from(*start))
    }

    /// ψ where the path parameter is `s`, rad, by the formula of a segment.
    #[must_use]
    pub fn turn<S: Real, const N: usize>(&self, segment: usize, s: Jet<S, N>) -> Jet<S, N> {
        let PlanarSegment { start, turn, .. } = &self.segments[segment];
        (s - Jet::from(*start)).polynomial(turn)
    }

    /// What the path asks of the arm where the path parameter is `s`, by the formula of a segment. With s as a
    /// variable the derivatives are those by s, with s(t) those in time.
    #[must_use]
    pub fn target<S: Real, const N: usize>(&self, segment: usize, s: Jet<S, N>) -> PlanarTarget<S, N> {
        let [x, y, rise] = self.point(segment, s);
        let turn = self.turn(segment, s);
        let [dx, dy] = self.offset_at(turn);
        PlanarTarget { wrist: [x - dx, y - dy], rise, turn }
    }

    /// Tracked point and ψ of the arm at joint positions `q`; the opposite of following the path. Joints that
    /// the arm does not have are not looked at.
    #[must_use]
    pub fn forward<S: Real, const N: usize>(
        &self,
        q: &[Jet<S, N>; PLANAR_JOINTS],
    ) -> ([Jet<S, N>; 3], Jet<S, N>) {
        let PlanarGeometry { upper, fore, shoulder_zero, elbow_zero, quill, .. } = self.geometry;
        let upper_angle = q[0] + Jet::from(shoulder_zero);
        let (sin_upper, cos_upper) = upper_angle.sin_cos();
        let (sin_fore, cos_fore) = (upper_angle + q[1] + Jet::from(elbow_zero)).sin_cos();
        let turn = q[0] + q[1] + q[self.dof() - 1];
        let [dx, dy] = self.offset_at(turn);
        let rise = quill.map_or(Jet::from(0.0), |quill| q[quill]);
        let x = cos_upper.scaled(upper) + cos_fore.scaled(fore) + dx;
        let y = sin_upper.scaled(upper) + sin_fore.scaled(fore) + dy;
        ([x, y, rise], turn)
    }

    /// From the wrist to the tracked point when the tool is turned by ψ, m.
    fn offset_at<S: Real, const N: usize>(&self, turn: Jet<S, N>) -> [Jet<S, N>; 2] {
        let [x, y] = <[f64; 2]>::from(self.offset);
        if x == 0.0 && y == 0.0 {
            return [Jet::from(0.0); 2];
        }
        let (sin, cos) = turn.sin_cos();
        [cos.scaled(x) - sin.scaled(y), sin.scaled(x) + cos.scaled(y)]
    }

    /// Positions of the joints on an elbow's branch, in the turns nearest to `near` where the path leaves them
    /// open; the last joint follows from the literal ψ and `whole_turns` (see [`PlanarPath::whole_turns`]).
    ///
    /// # Errors
    /// When the wrist is out of reach.
    pub fn positions(
        &self,
        target: &PlanarTarget<f64, 1>,
        elbow: Elbow,
        near: &[f64],
        whole_turns: f64,
    ) -> Result<[f64; PLANAR_JOINTS], Unreachable> {
        let wrist = Vector2::from(target.wrist.map(|coordinate| coordinate.value()));
        let [q1, q2] = shoulder_and_elbow(&self.geometry, &wrist, elbow)?;
        let nearest = |angle: f64, near: f64| {
            angle + std::f64::consts::TAU * ((near - angle) / std::f64::consts::TAU).round()
        };
        let mut q = [0.0; PLANAR_JOINTS];
        q[0] = nearest(q1, near[0]);
        q[1] = nearest(q2, near[1]);
        if let Some(quill) = self.geometry.quill {
            q[quill] = target.rise.value();
        }
        q[self.dof() - 1] = target.turn.value() + std::f64::consts::TAU * whole_turns - q[0] - q[1];
        Ok(q)
    }

    /// Whole turns that the sum of the revolute joints at `q` has more than ψ of the path at `s`.
    #[must_use]
    pub fn whole_turns(&self, s: f64, q: &[f64]) -> f64 {
        let turn = self.turn(self.segment_at(s), Jet::<f64, 1>::constant(s)).value();
        ((q[0] + q[1] + q[self.dof() - 1] - turn) / std::f64::consts::TAU).round()
    }

    /// Positions of the joints with all derivatives that `target` has, from the positions themselves. The
    /// elbow must not be straight or folded.
    #[must_use]
    pub fn joints<S: Real, const N: usize>(
        &self,
        target: &PlanarTarget<S, N>,
        elbow: &ElbowAngle<S, N>,
        positions: &[S; PLANAR_JOINTS],
    ) -> [Jet<S, N>; PLANAR_JOINTS] {
        let PlanarGeometry { upper, fore, quill, .. } = self.geometry;
        let [x, y] = target.wrist;
        let square = x * x + y * y;
        let elbow_rate = -(elbow.cos.derivative() / elbow.sin);
        let direction_rate = (x * y.derivative() - y * x.derivative()) / square;
        let share = (elbow.cos.scaled(upper * fore) + Jet::from(fore * fore)) / square;
        let shoulder_rate = direction_rate - share * elbow_rate;
        let mut q = [Jet::from(0.0); PLANAR_JOINTS];
        q[0] = shoulder_rate.integral(positions[0]);
        q[1] = elbow_rate.integral(positions[1]);
        if let Some(quill) = quill {
            q[quill] = target.rise;
            q[quill].coefficients[0] = positions[quill];
        }
        let last = self.dof() - 1;
        q[last] = target.turn - q[0] - q[1];
        q[last].coefficients[0] = positions[last];
        q
    }

    /// The elbow's angle that a target asks for; the sine is NaN (or bounds nothing) out of reach.
    #[must_use]
    pub fn elbow_angle<S: Real, const N: usize>(
        &self,
        target: &PlanarTarget<S, N>,
        elbow: Elbow,
    ) -> ElbowAngle<S, N> {
        let cos = self.elbow_cosine(target);
        let sin = (Jet::from(1.0) - cos.square()).sqrt();
        ElbowAngle { cos, sin: if elbow == Elbow::Left { sin } else { -sin } }
    }

    /// cos φ₂ that a target asks for; beyond ±1 out of reach.
    #[must_use]
    pub fn elbow_cosine<S: Real, const N: usize>(&self, target: &PlanarTarget<S, N>) -> Jet<S, N> {
        let PlanarGeometry { upper, fore, .. } = self.geometry;
        let [x, y] = target.wrist;
        (x.square() + y.square() - Jet::from(upper * upper + fore * fore)).scaled(0.5 / (upper * fore))
    }

    /// Checks that an arm without a quill is not asked to leave its plane.
    fn check_plane(&self) -> Result<(), (f64, Unreachable)> {
        for segment in &self.segments {
            let length = segment.end - segment.start;
            let (offset, swing) = match &segment.position {
                PositionCurve::Polynomial([_, _, z]) => {
                    let [c0, rest @ ..] = z.coefficients();
                    (*c0, rest.iter().rev().fold(0.0, |sum, c| (sum + c.abs()) * length))
                }
                PositionCurve::Arc(arc) => {
                    (arc.center.z, arc.toward.z.abs() + arc.across.z.abs() + length * arc.along.z.abs())
                }
            };
            if offset.abs() + swing > POSE_TOLERANCE {
                let offset = if offset.abs() > POSE_TOLERANCE { offset } else { offset + swing };
                return Err((segment.start, Unreachable::OutOfPlane { offset }));
            }
        }
        Ok(())
    }
}

/// The geometry of a planar arm.
fn geometry(robot: &RobotModel) -> Result<PlanarGeometry, Unreachable> {
    PlanarGeometry::of(robot)
        .map_err(|reason| Unreachable::NoClosedForm { robot: robot.name.clone(), reason })
}

/// Positions of shoulder and elbow, not in any particular turn, from the half-angle form of the law of cosines.
fn shoulder_and_elbow(
    geometry: &PlanarGeometry,
    wrist: &Vector2<f64>,
    elbow: Elbow,
) -> Result<[f64; 2], Unreachable> {
    let PlanarGeometry { upper, fore, shoulder_zero, elbow_zero, .. } = *geometry;
    let (reach, hole, distance) = (upper + fore, (upper - fore).abs(), wrist.norm());
    if distance - reach > REACH_TOLERANCE * reach {
        return Err(Unreachable::TooFar { distance, reach, excess: distance - reach });
    }
    if hole - distance > REACH_TOLERANCE * reach {
        return Err(Unreachable::TooNear { distance, hole, shortfall: hole - distance });
    }
    let from_straight = ((reach - distance).max(0.0) * (reach + distance)).sqrt();
    let from_folded = ((distance - hole).max(0.0) * (distance + hole)).sqrt();
    let bend = 2.0 * from_straight.atan2(from_folded);
    let bend = if elbow == Elbow::Left { bend } else { -bend };
    let seen = Vector2::new(upper + fore * bend.cos(), fore * bend.sin());
    let shoulder = seen.perp(wrist).atan2(seen.dot(wrist));
    Ok([shoulder - shoulder_zero, bend - elbow_zero])
}

/// ψ of a pose, in (−2π, 2π], and how far it leans from what the arm can do, rad.
fn turn_of(geometry: &PlanarGeometry, base_from_tool: &Pose) -> (f64, f64) {
    let [i, j, k, w] =
        <[f64; 4]>::from((base_from_tool.rotation * geometry.base_from_tool_zero.inverse()).coords);
    (2.0 * k.atan2(w), 2.0 * i.hypot(j).atan2(k.hypot(w)))
}

/// A curve of the world in the base's frame, counted from `origin` there.
fn moved(curve: &PositionCurve, base_from_world: &Pose, origin: &Vector3<f64>) -> PositionCurve {
    let rotation = base_from_world.rotation;
    let shift = base_from_world.translation.vector - origin;
    match curve {
        PositionCurve::Polynomial(coordinates) => {
            let mut rows = [[0.0; 8]; 3];
            for power in 0..8 {
                let mut vector =
                    rotation * Vector3::from(coordinates.each_ref().map(|p| p.coefficients()[power]));
                if power == 0 {
                    vector += shift;
                }
                for (row, value) in rows.iter_mut().zip(&vector) {
                    row[power] = *value;
                }
            }
            PositionCurve::Polynomial(rows.map(Polynomial::new))
        }
        PositionCurve::Arc(ArcCurve { center, toward, across, rate, along }) => {
            PositionCurve::Arc(ArcCurve {
                center: rotation * center + shift,
                toward: rotation * toward,
                across: rotation * across,
                rate: *rate,
                along: rotation * along,
            })
        }
    }
}

/// How far the arm's axes lean from the base's z times what they carry, the tilt of the path, and rounding.
fn slack(robot: &RobotModel, geometry: &PlanarGeometry, tilt: f64, segments: &[PlanarSegment]) -> Slack {
    let lean = |axis: &Vector3<f64>| axis.xy().norm();
    let mut base_from_link = Pose::identity();
    let mut leans = 0.0;
    let mut chain = robot.link_from_tool.translation.vector.norm();
    for joint in &robot.joints {
        base_from_link *= joint.parent_from_joint;
        leans += lean(&(base_from_link.rotation * Unit::into_inner(joint.axis)));
        chain += joint.parent_from_joint.translation.vector.norm();
        if joint.kind == JointKind::Prismatic {
            chain += joint.limits.position_max.abs().max(joint.limits.position_min.abs());
        }
    }
    let extent = |segment: &PlanarSegment| match &segment.position {
        PositionCurve::Polynomial(coordinates) => coordinates
            .iter()
            .map(|p| {
                let length = segment.end - segment.start;
                p.coefficients().iter().rev().fold(0.0, |sum, c| sum * length + c.abs())
            })
            .sum::<f64>(),
        PositionCurve::Arc(arc) => {
            arc.center.norm() + arc.toward.norm() + arc.along.norm() * (segment.end - segment.start)
        }
    };
    let size = segments.iter().map(extent).fold(geometry.upper + geometry.fore + chain, f64::max);
    // A rotation about a leaning axis is off by at most twice the lean, times what hangs on it.
    Slack {
        position: 2.0 * leans * chain + CONSTANT_ROUNDING * size,
        angle: 2.0 * leans + tilt + CONSTANT_ROUNDING,
    }
}
