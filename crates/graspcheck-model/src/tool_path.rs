//! A path of the tool: where it goes, without saying when.
//!
//! A [`ToolPath`] leads through poses of the tool in the world as the path parameter s runs from its start to
//! its end, mostly from 0 to 1 in proportion to the way travelled. It is a row of segments; in each the
//! position follows a polynomial or a circular arc (with a pitch: a helix), and the orientation turns about
//! fixed axes, one after the other:
//!
//! ```text
//! p(σ) = Σ cₖ σᵏ                                  or  p(σ) = center + cos(ωσ) u + sin(ωσ) v + σ a
//! R(σ) = exp(nₘ αₘ(σ)) … exp(n₁ α₁(σ)) R₀,           σ = s − start of the segment, axes in the world frame
//! ```
//!
//! One turn makes lines, screws and arcs, two a rounded corner, three a spline of orientations.
//!
//! (Lynch and Park, *Modern Robotics*, 2017, section 9.2; exp is the rotation about an axis by an angle.)
//! Angles are literal: a turn of 720° is two turns. All derivatives by s come from the same formulas by
//! [`Jet`]s. The planner's module `path` makes lines, screws, arcs, rounded polylines and splines out of it.
//!
//! Symbols used as names: `p_s` is a derivative by s.

use graspcheck_motion::{Jet, Polynomial, Real, Scalar};
use nalgebra::{Unit, UnitQuaternion, Vector3, Vector6};
use serde::{Deserialize, Serialize};

use crate::Pose;

/// How far the end of a segment may be from the beginning of the next, m and rad: a thousand times the
/// rounding of a path of some metres.
pub const JUNCTION_TOLERANCE: f64 = 1e-9;

/// How far derivatives by s on both sides of a junction may differ, relative to the path's largest, and still
/// count as equal: they come from directions and lengths that are rounded.
const SMOOTH_TOLERANCE: f64 = 1e-9;

/// A path of the tool through poses in the world.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<ToolSegment>", into = "Vec<ToolSegment>")]
pub struct ToolPath {
    segments: Vec<ToolSegment>,
}

/// A stretch of a path with one formula.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ToolSegment {
    /// The path parameter at its beginning.
    pub start: f64,
    /// The path parameter at its end.
    pub end: f64,
    /// Where the tool's origin is.
    pub position: PositionCurve,
    /// How the tool is turned.
    pub orientation: OrientationCurve,
}

/// Position of the tool's origin along a segment, m, of σ, the path parameter since its start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PositionCurve {
    /// A polynomial for each of x, y and z.
    Polynomial([Polynomial; 3]),
    /// A circular arc; with a pitch a helix.
    Arc(ArcCurve),
}

/// The arc `center + cos(ωσ) toward + sin(ωσ) across + σ along`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ArcCurve {
    /// Center of the circle at σ = 0, m.
    pub center: Vector3<f64>,
    /// From the center to the beginning of the arc, m.
    pub toward: Vector3<f64>,
    /// The same a quarter turn later, m.
    pub across: Vector3<f64>,
    /// ω: the angle for each unit of s, rad.
    pub rate: f64,
    /// What the center moves for each unit of s, m; zero for an arc in a plane.
    pub along: Vector3<f64>,
}

/// Orientation along a segment: `R(σ) = exp(nₘ αₘ(σ)) … exp(n₁ α₁(σ)) R₀`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OrientationCurve {
    /// R₀, from the tool to the world.
    pub start: UnitQuaternion<f64>,
    /// The turns: the first is made first. Without any the tool stays as it is.
    pub turns: Vec<Turn>,
}

/// A turn about an axis that stays the same.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Turn {
    /// The axis in the world frame.
    pub axis: Unit<Vector3<f64>>,
    /// The angle, rad, of σ.
    pub angle: Polynomial,
}

/// A place on a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolPoint {
    /// From the tool to the world.
    pub world_from_tool: Pose,
    /// The first three derivatives by s of the position, m (rows 0–2), and the angular velocity by s with its
    /// first two derivatives, rad (rows 3–5), in the world frame.
    pub derivatives: [Vector6<f64>; 3],
}

/// Where two segments meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Junction {
    /// The path parameter.
    pub s: f64,
    /// How many derivatives by s are continuous there: 0 at a corner, 1 where the direction is but not the
    /// curvature (a line into an arc), 2 where both are.
    pub class: usize,
}

/// Why segments are no path.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ToolPathError {
    /// There is no segment.
    #[error("path: has no segment; give at least one")]
    Empty,
    /// A number is NaN or infinite.
    #[error("path, segment {segment}: {quantity} is not finite")]
    NotFinite {
        /// Index of the segment.
        segment: usize,
        /// What is not.
        quantity: &'static str,
    },
    /// A segment has no length, or does not begin where the one before it ended.
    #[error("path, segment {segment}: runs from s = {start} to {end}; it must rise, from {expected}")]
    Range {
        /// Index of the segment.
        segment: usize,
        /// Where it begins.
        start: f64,
        /// Where it ends.
        end: f64,
        /// Where the segment before it ends, or its own start.
        expected: f64,
    },
    /// The tool jumps from a segment to the next.
    #[error(
        "path, segment {segment}: begins {distance:.3e} m and {angle:.3e} rad from where the one before it \
         ends, s = {s}"
    )]
    Jump {
        /// Index of the later segment.
        segment: usize,
        /// Where, of the path parameter.
        s: f64,
        /// m.
        distance: f64,
        /// rad.
        angle: f64,
    },
}

impl ToolPath {
    /// The path of these segments, one after the other.
    ///
    /// ```
    /// use graspcheck_model::tool_path::{OrientationCurve, PositionCurve, ToolPath, ToolSegment};
    /// use graspcheck_motion::Polynomial;
    /// use nalgebra::{UnitQuaternion, Vector3};
    /// // 0.2 m along x, the tool turning by 1 rad about z.
    /// let position = PositionCurve::Polynomial([
    ///     Polynomial::new([0.3, 0.2]),
    ///     Polynomial::constant(0.0),
    ///     Polynomial::constant(0.1),
    /// ]);
    /// let start = UnitQuaternion::identity();
    /// let orientation = OrientationCurve::turning(start, Vector3::z_axis(), Polynomial::new([0.0, 1.0]));
    /// let path = ToolPath::new(vec![ToolSegment { start: 0.0, end: 1.0, position, orientation }])?;
    /// let [first, second, _] = path.eval(0.5).derivatives;
    /// assert_eq!((first[0], first[5], second.norm()), (0.2, 1.0, 0.0));
    /// # Ok::<(), graspcheck_model::tool_path::ToolPathError>(())
    /// ```
    ///
    /// # Errors
    /// When there is none, a number is not finite, the ranges of s do not follow each other, or the tool
    /// would jump by more than [`JUNCTION_TOLERANCE`].
    pub fn new(segments: Vec<ToolSegment>) -> Result<Self, ToolPathError> {
        if segments.is_empty() {
            return Err(ToolPathError::Empty);
        }
        for (segment, found) in segments.iter().enumerate() {
            let ToolSegment { start, end, position, orientation } = found;
            let not_finite = |quantity| Err(ToolPathError::NotFinite { segment, quantity });
            if !(start.is_finite() && end.is_finite()) {
                return not_finite("the path parameter");
            }
            if !position.is_finite() {
                return not_finite("the position");
            }
            if !orientation.is_finite() {
                return not_finite("the orientation");
            }
            let expected = if segment == 0 { *start } else { segments[segment - 1].end };
            if start.to_bits() != expected.to_bits() || end <= start {
                return Err(ToolPathError::Range { segment, start: *start, end: *end, expected });
            }
        }
        for (index, two) in segments.windows(2).enumerate() {
            let s = two[1].start;
            let (before, after) = (two[0].pose(s), two[1].pose(s));
            let distance = (before.translation.vector - after.translation.vector).norm();
            let angle = before.rotation.angle_to(&after.rotation);
            if distance > JUNCTION_TOLERANCE || angle > JUNCTION_TOLERANCE {
                return Err(ToolPathError::Jump { segment: index + 1, s, distance, angle });
            }
        }
        Ok(Self { segments })
    }

    /// The segments, in order of s.
    #[must_use]
    pub fn segments(&self) -> &[ToolSegment] {
        &self.segments
    }

    /// The path parameter at the beginning.
    #[must_use]
    pub fn start(&self) -> f64 {
        self.segments[0].start
    }

    /// The path parameter at the end.
    #[must_use]
    pub fn end(&self) -> f64 {
        self.segments[self.segments.len() - 1].end
    }

    /// The segment that holds `s`; where two meet, the later one.
    fn segment_at(&self, s: f64) -> &ToolSegment {
        let index = self.segments.partition_point(|segment| segment.start <= s).max(1) - 1;
        &self.segments[index]
    }

    /// From the tool to the world at `s`.
    ///
    /// # Panics
    /// When `s` is outside the path.
    #[must_use]
    pub fn pose(&self, s: f64) -> Pose {
        self.check(s);
        self.segment_at(s).pose(s)
    }

    /// Pose and three derivatives by s; where two segments meet, those of the later one.
    ///
    /// # Panics
    /// When `s` is outside the path.
    #[must_use]
    pub fn eval(&self, s: f64) -> ToolPoint {
        self.check(s);
        self.segment_at(s).eval(s)
    }

    fn check(&self, s: f64) {
        assert!(
            (self.start()..=self.end()).contains(&s),
            "s = {s} is outside the path, which runs from {} to {}",
            self.start(),
            self.end()
        );
    }

    /// The places where segments meet, with the continuity there.
    #[must_use]
    pub fn junctions(&self) -> Vec<Junction> {
        let ends =
            self.segments.iter().flat_map(|segment| [segment.eval(segment.start), segment.eval(segment.end)]);
        let mut scale = [0.0_f64; 3];
        for point in ends {
            for (scale, derivative) in scale.iter_mut().zip(point.derivatives) {
                *scale = scale.max(derivative.norm());
            }
        }
        let junction = |two: &[ToolSegment]| {
            let s = two[1].start;
            let (before, after) = (two[0].eval(s), two[1].eval(s));
            let equal = |order: usize| {
                // A derivative of a straight segment is zero: the lower ones say what is small.
                let scale = scale[..=order].iter().fold(0.0, |largest: f64, scale| largest.max(*scale));
                let jump = (before.derivatives[order] - after.derivatives[order]).norm();
                jump <= SMOOTH_TOLERANCE * scale
            };
            let class = (0..2).take_while(|&order| equal(order)).count();
            Junction { s, class }
        };
        self.segments.windows(2).map(junction).collect()
    }
}

impl ToolSegment {
    /// From the tool to the world at `s`, by the formula of this segment.
    #[must_use]
    pub fn pose(&self, s: f64) -> Pose {
        let sigma = Jet::<f64, 1>::constant(s - self.start);
        let position = self.position.at(sigma).map(|coordinate| coordinate.value());
        Pose::from_parts(Vector3::from(position).into(), self.orientation.at(s - self.start))
    }

    /// Pose and three derivatives by s, by the formula of this segment.
    #[must_use]
    pub fn eval(&self, s: f64) -> ToolPoint {
        let position = self.position.at(Jet::<f64, 4>::variable(s - self.start)).map(|jet| jet.derivatives());
        let angular = self.orientation.angular_velocity(s - self.start);
        let derivatives = std::array::from_fn(|order| {
            let [x, y, z] = [0, 1, 2].map(|axis| position[axis][order + 1]);
            let turn = angular[order];
            Vector6::new(x, y, z, turn.x, turn.y, turn.z)
        });
        ToolPoint { world_from_tool: self.pose(s), derivatives }
    }
}

impl PositionCurve {
    /// The three coordinates at σ, m.
    #[must_use]
    pub fn at<S: Real, const N: usize>(&self, sigma: Jet<S, N>) -> [Jet<S, N>; 3] {
        match self {
            Self::Polynomial(coordinates) => {
                coordinates.each_ref().map(|polynomial| sigma.polynomial(polynomial))
            }
            Self::Arc(ArcCurve { center, toward, across, rate, along }) => {
                let (sin, cos) = sigma.scaled(*rate).sin_cos();
                [0, 1, 2].map(|axis| {
                    Jet::from(center[axis])
                        + cos.scaled(toward[axis])
                        + sin.scaled(across[axis])
                        + sigma.scaled(along[axis])
                })
            }
        }
    }

    fn is_finite(&self) -> bool {
        match self {
            Self::Polynomial(coordinates) => coordinates.iter().all(Polynomial::is_finite),
            Self::Arc(ArcCurve { center, toward, across, rate, along }) => {
                let vectors = [center, toward, across, along];
                rate.is_finite() && vectors.into_iter().flatten().all(|value| value.is_finite())
            }
        }
    }
}

impl OrientationCurve {
    /// One that stays as it is.
    #[must_use]
    pub fn fixed(start: UnitQuaternion<f64>) -> Self {
        Self { start, turns: Vec::new() }
    }

    /// A turn about one axis in the world frame.
    #[must_use]
    pub fn turning(start: UnitQuaternion<f64>, axis: Unit<Vector3<f64>>, angle: Polynomial) -> Self {
        Self { start, turns: vec![Turn { axis, angle }] }
    }

    /// From the tool to the world at σ.
    #[must_use]
    pub fn at(&self, sigma: f64) -> UnitQuaternion<f64> {
        self.turns.iter().fold(self.start, |so_far, turn| {
            UnitQuaternion::from_axis_angle(&turn.axis, turn.angle.eval(sigma)[0]) * so_far
        })
    }

    /// ω with its first two derivatives, rad for each unit of s, s² and s³: that of the first turn is n₁ α₁', and
    /// every turn after it adds its own and turns what was there, `ω ← n α' + exp(n α) ω`.
    fn angular_velocity(&self, sigma: f64) -> [Vector3<f64>; 3] {
        let mut velocity = [Jet::<f64, 4>::from(0.0); 3];
        for Turn { axis, angle } in &self.turns {
            let angle = Jet::<f64, 4>::of_polynomial(angle, sigma);
            let (sin, cos) = angle.sin_cos();
            let [x, y, z] = velocity;
            let along = x.scaled(axis.x) + y.scaled(axis.y) + z.scaled(axis.z);
            let across = [
                z.scaled(axis.y) - y.scaled(axis.z),
                x.scaled(axis.z) - z.scaled(axis.x),
                y.scaled(axis.x) - x.scaled(axis.y),
            ];
            // Rodrigues: v turned about n by α is v∥ + cos α (v − v∥) + sin α n × v.
            velocity = std::array::from_fn(|k| {
                let parallel = along.scaled(axis[k]);
                parallel
                    + cos * (velocity[k] - parallel)
                    + sin * across[k]
                    + angle.derivative().scaled(axis[k])
            });
        }
        let derivatives = velocity.map(|coordinate| coordinate.derivatives());
        std::array::from_fn(|order| Vector3::from([0, 1, 2].map(|k| derivatives[k][order])))
    }

    fn is_finite(&self) -> bool {
        let turn = |turn: &Turn| turn.angle.is_finite() && turn.axis.iter().all(|value| value.is_finite());
        self.turns.iter().all(turn) && self.start.coords.iter().all(|value| value.is_finite())
    }
}

impl TryFrom<Vec<ToolSegment>> for ToolPath {
    type Error = ToolPathError;

    fn try_from(segments: Vec<ToolSegment>) -> Result<Self, ToolPathError> {
        Self::new(segments)
    }
}

impl From<ToolPath> for Vec<ToolSegment> {
    fn from(path: ToolPath) -> Self {
        path.segments
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A helix with three turns about different axes.
    fn winding() -> ToolSegment {
        let arc = ArcCurve {
            center: Vector3::new(0.1, 0.2, 0.3),
            toward: Vector3::new(0.5, 0.0, 0.0),
            across: Vector3::new(0.0, 0.3, 0.4),
            rate: 1.7,
            along: Vector3::new(0.0, -0.08, 0.06),
        };
        let turn = |axis: Vector3<f64>, angle| Turn { axis: Unit::new_normalize(axis), angle };
        let turns = vec![
            turn(Vector3::new(1.0, 2.0, 0.5), Polynomial::new([0.0, 0.8, -0.3, 0.2])),
            turn(Vector3::new(-1.0, 0.3, 0.7), Polynomial::new([0.1, -0.4, 0.6])),
            turn(Vector3::new(0.2, 0.9, -0.4), Polynomial::new([-0.2, 0.5, 0.1, -0.3])),
        ];
        let start = UnitQuaternion::from_euler_angles(0.3, -0.2, 0.9);
        let orientation = OrientationCurve { start, turns };
        ToolSegment { start: 0.5, end: 2.0, position: PositionCurve::Arc(arc), orientation }
    }

    #[test]
    fn derivatives_are_those_of_the_pose() {
        let path = ToolPath::new(vec![winding()]).unwrap();
        let step = 1e-5;
        for k in 0..=10 {
            let s = 0.6 + 0.13 * f64::from(k);
            let (before, after) = (path.eval(s - step), path.eval(s + step));
            let here = path.eval(s);
            let linear = (after.world_from_tool.translation.vector
                - before.world_from_tool.translation.vector)
                / (2.0 * step);
            let turn = after.world_from_tool.rotation * before.world_from_tool.rotation.inverse();
            let angular = turn.scaled_axis() / (2.0 * step);
            assert!((here.derivatives[0].fixed_rows::<3>(0) - linear).norm() < 1e-8);
            assert!((here.derivatives[0].fixed_rows::<3>(3) - angular).norm() < 1e-8);
            for order in 0..2 {
                let difference = (after.derivatives[order] - before.derivatives[order]) / (2.0 * step);
                let found = here.derivatives[order + 1];
                assert!((found - difference).norm() < 1e-7, "order {order}: {found} is not {difference}");
            }
        }
    }

    #[test]
    fn a_segment_cut_in_two_meets_itself_smoothly() {
        let whole = winding();
        let middle = 1.1;
        let shifted = |curve: &OrientationCurve| OrientationCurve {
            turns: curve
                .turns
                .iter()
                .map(|turn| Turn { angle: turn.angle.shifted(middle - whole.start), ..*turn })
                .collect(),
            ..curve.clone()
        };
        let PositionCurve::Arc(arc) = &whole.position else { unreachable!() };
        let angle = arc.rate * (middle - whole.start);
        let later = ArcCurve {
            center: arc.center + arc.along * (middle - whole.start),
            toward: arc.toward * angle.cos() + arc.across * angle.sin(),
            across: arc.across * angle.cos() - arc.toward * angle.sin(),
            ..arc.clone()
        };
        let first = ToolSegment { end: middle, ..whole.clone() };
        let second = ToolSegment {
            start: middle,
            end: 2.0,
            position: PositionCurve::Arc(later),
            orientation: shifted(&whole.orientation),
        };
        let path = ToolPath::new(vec![first.clone(), second.clone()]).unwrap();
        assert_eq!(path.junctions(), vec![Junction { s: middle, class: 2 }]);
        // The same arc with another pitch bends off.
        let mut bent = second.clone();
        if let PositionCurve::Arc(arc) = &mut bent.position {
            arc.along *= 1.5;
        }
        let path = ToolPath::new(vec![first.clone(), bent]).unwrap();
        assert_eq!(path.junctions(), vec![Junction { s: middle, class: 0 }]);
        // Moved aside it is no path.
        let mut aside = second;
        if let PositionCurve::Arc(arc) = &mut aside.position {
            arc.center.x += 0.1;
        }
        let Err(ToolPathError::Jump { segment: 1, distance, .. }) = ToolPath::new(vec![first, aside]) else {
            panic!("it jumps by 0.1 m")
        };
        assert!((distance - 0.1).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_path_is_an_error() {
        assert_eq!(ToolPath::new(vec![]), Err(ToolPathError::Empty));
        let mut segment = winding();
        segment.end = segment.start;
        assert!(matches!(ToolPath::new(vec![segment]), Err(ToolPathError::Range { segment: 0, .. })));
        let mut segment = winding();
        segment.orientation.turns[1].angle = Polynomial::constant(f64::NAN);
        let error = ToolPath::new(vec![segment]);
        assert_eq!(error, Err(ToolPathError::NotFinite { segment: 0, quantity: "the orientation" }));
        let mut segment = winding();
        segment.position = PositionCurve::Polynomial([Polynomial::constant(f64::INFINITY); 3]);
        let error = ToolPath::new(vec![segment]);
        assert_eq!(error, Err(ToolPathError::NotFinite { segment: 0, quantity: "the position" }));
    }
}
