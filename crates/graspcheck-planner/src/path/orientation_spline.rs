//! A C² spline of orientations: a cumulative cubic B-spline of rotations that passes through its points.
//!
//! Between the places tₖ and tₖ₊₁ the orientation is a product of three turns about fixed axes,
//!
//! ```text
//! R(t) = Cₖ₋₁ exp(β₁(t) Ωₖ) exp(β₂(t) Ωₖ₊₁) exp(β₃(t) Ωₖ₊₂),    Ωⱼ = log(Cⱼ₋₁⁻¹ Cⱼ)
//! ```
//!
//! with the sums βᵢ of the cubic B-splines of the knots: β₁ = 1 − Nₖ₋₁, β₂ = Nₖ₊₁ + Nₖ₊₂, β₃ = Nₖ₊₂ (Kim, Kim and Shin,
//! *A General Construction Scheme for Unit Quaternion Curves with Simple High Order Derivatives*, SIGGRAPH 1995; the
//! basis for unequal knots from de Boor, *A Practical Guide to Splines*, chapter IX). The angles are polynomials, so
//! all derivatives are exact, and the curve does not depend on the frame. About one axis the turns commute and this *is*
//! the natural cubic spline of the angle.
//!
//! The control orientations Cⱼ are such that the curve is at the given orientation at every place. For small turns the
//! errors obey a system with three diagonals, that of the B-splines' values; it is solved for corrections until there is
//! nothing to correct. The ends are natural: the angular acceleration is zero there, with C₋₁ and Cₙ₊₁ on the geodesics
//! through the last two,
//!
//! ```text
//! Ω₀ = ρ Ω₁,   ρ = 3 h₀ / (2 h₀ + h₁)          h: the lengths between the places
//! ```

use graspcheck_model::tool_path::{OrientationCurve, Turn};
use graspcheck_motion::Polynomial;
use nalgebra::{Unit, UnitQuaternion, Vector3};

use super::{NOTHING, PathError};
use crate::via::tridiagonal::Tridiagonal;

/// How far the curve may be from an orientation that it passes, rad: some hundred roundings of a unit quaternion.
const MET: f64 = 1e-13;

/// Corrections after which a spline is given up. Each leaves a share of the error that grows with the turns between
/// neighbours; where control orientations would have to be half a turn apart there is no such curve.
const CORRECTIONS_MAX: usize = 200;

/// A C² curve through orientations at given places.
#[derive(Clone, Debug, PartialEq)]
pub struct OrientationSpline {
    /// Lengths between the places, with two more at either end.
    lengths: Vec<f64>,
    /// C₋₁ to Cₙ₊₁.
    controls: Vec<UnitQuaternion<f64>>,
}

impl OrientationSpline {
    /// The curve that has `orientations[k]` at `places[k]` of the parameter, by the shorter turn from each to the next.
    ///
    /// ```
    /// use graspcheck_planner::path::orientation_spline::OrientationSpline;
    /// use nalgebra::{UnitQuaternion, Vector3};
    ///
    /// let about = |axis: Vector3<f64>| UnitQuaternion::new(axis);
    /// let orientations = [Vector3::zeros(), Vector3::x(), Vector3::y()].map(about);
    /// let spline = OrientationSpline::through(&[0.0, 0.4, 1.0], &orientations)?;
    /// // The second piece begins at the second orientation.
    /// assert!(spline.curve(1).at(0.0).angle_to(&orientations[1]) < 1e-12);
    /// # Ok::<(), graspcheck_planner::path::PathError>(())
    /// ```
    ///
    /// # Errors
    /// When there are not as many places as orientations, fewer than two, or the places do not rise; or when the turns
    /// are too large for a spline: more points between them help.
    pub fn through(places: &[f64], orientations: &[UnitQuaternion<f64>]) -> Result<Self, PathError> {
        let count = orientations.len();
        if count < 2 || places.len() != count {
            return Err(PathError::PlaceCount { places: places.len(), orientations: count });
        }
        let between: Vec<f64> = places.windows(2).map(|pair| pair[1] - pair[0]).collect();
        if let Some(k) = between.iter().position(|length| !(*length > 0.0 && length.is_finite())) {
            return Err(PathError::SamePoint { point: k + 2, way: between[k] });
        }
        let (first, last) = (between[0], between[count - 2]);
        let lengths = [vec![first; 2], between, vec![last; 2]].concat();
        let mut spline = Self { lengths, controls: Vec::new() };
        spline.control(orientations);
        let system = spline.system(count);
        let mut inner = orientations.to_vec();
        for _ in 0..CORRECTIONS_MAX {
            let errors: Vec<Vector3<f64>> = (1..count - 1)
                .map(|k| (spline.curve(k).at(0.0).inverse() * orientations[k]).scaled_axis())
                .collect();
            if errors.iter().all(|error| error.norm() <= MET) {
                return Ok(spline);
            }
            let corrections = [0, 1, 2]
                .map(|axis| system.solve(&errors.iter().map(|error| error[axis]).collect::<Vec<_>>()));
            for (k, control) in inner[1..count - 1].iter_mut().enumerate() {
                let [x, y, z] = [0, 1, 2].map(|axis: usize| corrections[axis][k]);
                *control *= UnitQuaternion::new(Vector3::new(x, y, z));
                control.renormalize();
            }
            spline.control(&inner);
        }
        let turn = |pair: &[UnitQuaternion<f64>]| pair[0].angle_to(&pair[1]);
        Err(PathError::TurnsTooLarge { largest: orientations.windows(2).map(turn).fold(0.0, f64::max) })
    }

    /// Takes C₀ to Cₙ; the natural ends give one more before and after them.
    fn control(&mut self, inner: &[UnitQuaternion<f64>]) {
        let [first, last] = self.end_ratios();
        let count = inner.len();
        let beyond = |end: &UnitQuaternion<f64>, next: &UnitQuaternion<f64>, ratio: f64| {
            end * UnitQuaternion::new(-ratio * (end.inverse() * next).scaled_axis())
        };
        let before = beyond(&inner[0], &inner[1], first);
        let after = beyond(&inner[count - 1], &inner[count - 2], last);
        self.controls.clear();
        self.controls.push(before);
        self.controls.extend_from_slice(inner);
        self.controls.push(after);
    }

    /// ρ at the start and at the end.
    fn end_ratios(&self) -> [f64; 2] {
        let h = &self.lengths;
        let last = h.len() - 3;
        [[h[2], h[3]], [h[last], h[last - 1]]].map(|[end, next]| 3.0 * end / (2.0 * end + next))
    }

    /// What a small turn of each inner control orientation does at each inner place: Nₖ₋₁, Nₖ and Nₖ₊₁ at tₖ. All
    /// are positive and add up to one. The ends are met by their own controls, which are not corrected.
    fn system(&self, count: usize) -> Tridiagonal {
        let mut system = Tridiagonal::default();
        for k in 1..count - 1 {
            let [first, second, _] = self.weights(k);
            let (before, after) = (1.0 - first.coefficients()[0], second.coefficients()[0]);
            system.push([before, 1.0 - before - after, after]);
        }
        system
    }

    /// β₁, β₂ and β₃ on a piece, of the parameter since its start.
    fn weights(&self, piece: usize) -> [Polynomial; 3] {
        let [a2, a, h, b, b2] = std::array::from_fn(|k| self.lengths[piece + k]);
        // 1 − (h − x)³/((a₂ + a + h)(a + h) h)
        let fall = 1.0 / ((a2 + a + h) * (a + h) * h);
        let first = [1.0 - fall * h * h * h, 3.0 * fall * h * h, -3.0 * fall * h, fall];
        // β₂' is the quadratic B-spline over a, h and b, times 3/(a + h + b).
        let (left, right) = (1.0 / ((a + h) * h), 1.0 / ((h + b) * h));
        let rate = 3.0 / (a + h + b);
        let at_start = a * a / ((a + h + b) * (a + h));
        let second = [
            at_start,
            rate * a * h * left,
            0.5 * rate * ((h - a) * left + (h + b) * right),
            -rate * (left + right) / 3.0,
        ];
        let third = [0.0, 0.0, 0.0, 1.0 / ((h + b + b2) * (h + b) * h)];
        [first, second, third].map(Polynomial::new)
    }

    /// The curve from `places[piece]` to the next place.
    ///
    /// # Panics
    /// When there is no such piece.
    #[must_use]
    pub fn curve(&self, piece: usize) -> OrientationCurve {
        let start = self.controls[piece];
        let weights = self.weights(piece);
        let turn = |k: usize| {
            let [from, to] = [self.controls[piece + k], self.controls[piece + k + 1]];
            let step = (from.inverse() * to).scaled_axis();
            let angle = step.norm();
            // What does not turn has no axis.
            let axis = if angle > NOTHING { Unit::new_normalize(start * step) } else { Vector3::z_axis() };
            Turn { axis, angle: Polynomial::new(weights[k].coefficients().map(|c| angle * c)) }
        };
        // In the world frame what stands last in the product is made first.
        OrientationCurve { start, turns: [2, 1, 0].map(turn).to_vec() }
    }
}
