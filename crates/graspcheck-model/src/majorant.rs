//! How fast what an arm carries can change, from the rates of its joints alone.
//!
//! A *majorant* of a quantity x over a stretch of time has as coefficient k a number that `‖x⁽ᵏ⁾‖/k!` never exceeds
//! there. By Leibniz' rule the majorant of a product is the product of the majorants, also for cross products and
//! for products with matrices, whose norms are at most the products of the norms. So majorants go through a formula
//! like Taylor series ([`Jet`]), but with one number where those have three or nine, and no direction is ever asked
//! for: a stretch of an arm of six joints takes some hundreds of nanoseconds.
//!
//! What is fixed in a link that turns with ω changes by `u̇ = ω × u`, hence `(k + 1) uₖ₊₁ = Σᵢ ωᵢ uₖ₋ᵢ`.
//!
//! The bounds are rough, so that they serve for the *remainder* of an interpolation, which is of third order in the
//! length of the stretch: see [`interpolated`].

use graspcheck_motion::{Interval, Jet, Polynomial, Scalar};
use nalgebra::Vector3;

use crate::{hinge::Hinge, robot::JointKind};

/// How many coefficients are carried: accelerations with their third derivatives come from positions with their
/// fifth. A derivative loses the last coefficient, which is never asked for then.
pub(crate) const MAJORANTS: usize = 6;

/// See the module. All coefficients are at least 0.
pub(crate) type Majorant = Jet<f64, MAJORANTS>;

/// Majorants are sums and products of at most a few hundred numbers, none negative, so that each is rounded by a
/// share far below this.
pub(crate) const MAJORANT_ROUNDING: f64 = 1e-12;

/// A coefficient that is shifted in time has gone through at most 14 roundings.
const SHIFT_ROUNDING: f64 = 16.0 * f64::EPSILON;

/// The largest value of `|(t − a)(t − m)(t − b)|` for t between a and b with middle m, over the cube of half their
/// distance: `2/(3√3)`, rounded up.
const CUBIC: f64 = 0.384_900_2;

/// A joint's polynomial in the middle of a stretch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointStretch {
    /// Of the position.
    pub(crate) position: Majorant,
    /// The velocity in the middle.
    pub(crate) velocity: f64,
}

impl JointStretch {
    /// Between two local times, s; `terms` are the [`terms`] of the whole piece.
    #[inline]
    pub(crate) fn new(polynomial: &Polynomial, [from, to]: [f64; 2], terms: &Majorant) -> Self {
        let shifted = polynomial.shifted(0.5 * (from + to));
        // The middle is rounded, and so is the half.
        let half = 0.5 * (to - from) + 4.0 * f64::EPSILON * to.abs();
        let position = self::terms(&shifted, half) + terms.scaled(SHIFT_ROUNDING);
        Self { position, velocity: shifted.coefficients()[1] }
    }
}

/// The Taylor coefficients of `Σ |cₖ| τᵏ` at `length`: the magnitudes of the terms of which a polynomial and its
/// derivatives consist on a piece of that length, which is what their rounding errors are relative to.
#[inline]
pub(crate) fn terms(polynomial: &Polynomial, length: f64) -> Majorant {
    let magnitudes = Polynomial::new(polynomial.coefficients().map(f64::abs)).shifted(length);
    Majorant { coefficients: std::array::from_fn(|k| magnitudes.coefficients()[k]) }
}

/// Of a unit vector that is fixed in a body whose angular velocity has the majorant `turn`.
#[inline]
fn carried(turn: &Majorant) -> Majorant {
    let mut unit = [0.0; MAJORANTS];
    unit[0] = 1.0;
    for k in 0..MAJORANTS - 1 {
        let sum: f64 = (0..=k).map(|i| turn.coefficients[i] * unit[k - i]).sum();
        unit[k + 1] = sum / (k + 1) as f64;
    }
    Majorant { coefficients: unit }
}

/// How many roundings a quantity can have gone through for each joint, and some more: a vector is turned, crossed and
/// added to at most a few times a joint outwards and inwards, with about ten roundings each.
const ROUNDINGS: f64 = 256.0;

/// Majorants over a whole piece that lasts `length`, into `positions`; the [`terms`] of its joints, and the share of a sum
/// of magnitudes by which floats can be off.
///
/// A sum of products is off by the number of roundings times the sum of the magnitudes, and by what its factors are
/// off: a position, a velocity or an acceleration by [`SHIFT_ROUNDING`] of its terms, of which a product has fewer than
/// two a joint and four more; a rotation by the sum of the errors of the angles, outwards and inwards.
#[cold]
pub(crate) fn of_piece(
    polynomials: &[Polynomial],
    length: f64,
    positions: &mut [Majorant],
) -> (Box<[Majorant]>, f64) {
    let all: Box<[Majorant]> = polynomials.iter().map(|polynomial| terms(polynomial, length)).collect();
    let [mut largest_share, mut angles] = [0.0_f64; 2];
    for ((position, polynomial), terms) in positions.iter_mut().zip(polynomials).zip(&all) {
        *position = JointStretch::new(polynomial, [0.0, length], terms).position;
        for (term, value) in terms.coefficients.iter().zip(&position.coefficients).take(3) {
            if *term > 0.0 {
                largest_share = largest_share.max(term / value);
            }
        }
        angles += terms.coefficients[0];
    }
    let dof = polynomials.len() as f64;
    let of_factors = SHIFT_ROUNDING * ((2.0 * dof + 4.0) * largest_share + 2.0 * angles);
    (all, ROUNDINGS * dof * f64::EPSILON + of_factors)
}

/// How far two axes may be from parallel and count as such: the rounding of a product of rotations.
const PARALLEL: f64 = 16.0 * f64::EPSILON;

/// Whether all axes of an arm are parallel. Its links then move in planes across them, where only what is across
/// the axes counts, and along them by prismatic joints alone.
pub(crate) fn is_planar<'h>(hinges: impl IntoIterator<Item = &'h Hinge>) -> bool {
    let mut before: Option<Vector3<f64>> = None;
    hinges.into_iter().all(|hinge| {
        let axis = hinge.parent_from_joint * hinge.axis;
        before.replace(hinge.axis).is_none_or(|before| axis.cross(&before).norm() <= PARALLEL)
    })
}

/// A joint as far as majorants ask for it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointReach {
    pub(crate) kind: JointKind,
    /// Distance of the link's origin at position 0 from the parent's, m; in a planar arm across the axes.
    offset: f64,
    /// Whether the arm is planar.
    pub(crate) planar: bool,
}

impl JointReach {
    /// Of one of the joints of an arm that is planar, or not.
    pub(crate) fn of(hinge: &Hinge, planar: bool) -> Self {
        let axis = hinge.parent_from_joint * hinge.axis;
        let offset = if planar { hinge.origin.cross(&axis).norm() } else { hinge.origin.norm() };
        Self { kind: hinge.kind, offset, planar }
    }
}

/// Majorants of what is fixed in a link, and of what leads to it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Link {
    /// Of the joint's axis, which is fixed in the link before; in a planar arm it stands still.
    pub(crate) axis: Majorant,
    /// From the origin of the link before to this one's.
    pub(crate) arm: Majorant,
    /// Of the angular velocity.
    pub(crate) turn: Majorant,
    /// Of a unit vector that is fixed in this link; in a planar arm, of one across the axes.
    pub(crate) unit: Majorant,
}

impl Link {
    /// The base, which stands still.
    pub(crate) fn base() -> Self {
        let [zero, one] = [0.0, 1.0].map(Majorant::constant);
        Self { axis: one, arm: zero, turn: zero, unit: one }
    }

    /// The link behind this one's next joint, of whose position the majorant is `q`.
    #[inline]
    pub(crate) fn next(&self, joint: JointReach, q: &Majorant) -> Self {
        let axis = if joint.planar { Majorant::constant(1.0) } else { self.unit };
        let arm = self.unit.scaled(joint.offset);
        match (joint.kind, joint.planar) {
            (JointKind::Revolute, planar) => {
                let rate = q.derivative();
                let turn = self.turn + if planar { rate } else { rate * axis };
                Self { axis, arm, turn, unit: carried(&turn) }
            }
            (JointKind::Prismatic, true) => Self { axis, arm, turn: self.turn, unit: self.unit },
            (JointKind::Prismatic, false) => {
                Self { axis, arm: arm + axis * *q, turn: self.turn, unit: self.unit }
            }
        }
    }
}

/// Bounds on a function between `a` and `b` from its values at both ends and in the middle, and a bound `third` on
/// the magnitude of its third derivative over 3!; `half` is half the distance of `a` and `b`.
///
/// The parabola through the three points is off by at most `third · |(t − a)(t − m)(t − b)|`, and lies between the
/// least and the greatest of its Bernstein coefficients.
#[must_use]
pub(crate) fn interpolated([a, middle, b]: [f64; 3], third: f64, half: f64) -> Interval {
    let bend = 2.0 * middle - 0.5 * (a + b);
    Interval::between(a.min(b).min(bend), a.max(b).max(bend)).widened(remainder(third, half))
}

/// As [`interpolated`] for a vector: a bound on its length.
#[must_use]
pub(crate) fn longest([a, middle, b]: [Vector3<f64>; 3], third: f64, half: f64) -> f64 {
    let bend = middle * 2.0 - (a + b) * 0.5;
    let square = a.norm_squared().max(b.norm_squared()).max(bend.norm_squared());
    square.sqrt() * (1.0 + 8.0 * f64::EPSILON) + remainder(third, half)
}

/// By how much the parabola can be off; more than any number when that is not one.
fn remainder(third: f64, half: f64) -> f64 {
    let remainder = CUBIC * third * half * half * half * (1.0 + MAJORANT_ROUNDING);
    if remainder.is_nan() { f64::INFINITY } else { remainder }
}
