//! The polynomials of a law, and the change of velocity of which most laws are made.

use graspcheck_motion::Polynomial;

/// Most pieces that a law has: the seven phases of an S-curve.
const MOST: usize = 7;

/// The polynomials of a law in order of time, held in place: making and copying a law allocates nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pieces {
    count: usize,
    starts: [f64; MOST],
    polynomials: [Polynomial; MOST],
}

impl Pieces {
    /// One polynomial from time 0 on.
    pub(crate) fn one(polynomial: Polynomial) -> Self {
        let mut pieces = Self::none();
        pieces.push(0.0, polynomial);
        pieces
    }

    fn none() -> Self {
        Self { count: 0, starts: [0.0; MOST], polynomials: [Polynomial::default(); MOST] }
    }

    fn push(&mut self, start: f64, polynomial: Polynomial) {
        self.starts[self.count] = start;
        self.polynomials[self.count] = polynomial;
        self.count += 1;
    }

    /// A change of velocity, a cruise, and another change of velocity, which last `duration` together.
    ///
    /// `start` and `end` are `[position, velocity]`, `velocity` is that of the cruise; the second change is the
    /// one that leads back from the end to the cruise. Built from both ends, so that the law starts and ends
    /// where it should to the last bit, and rounding shows only where the two halves meet.
    pub(crate) fn between(
        start: [f64; 2],
        rise: VelocityChange,
        (cruise, velocity): (f64, f64),
        fall: VelocityChange,
        [q1, v1]: [f64; 2],
        duration: f64,
    ) -> Self {
        // A phase this short does not move the law by more than rounding does, and its knots might coincide.
        let shortest = 4.0 * f64::EPSILON * duration;
        let mut pieces = Self::none();
        let (mut t, mut covered) = (0.0, start[0]);
        for (length, polynomial) in rise.phases(start) {
            if length > shortest {
                pieces.push(t, polynomial);
                t += length;
                covered = polynomial.position(length);
            }
        }
        if cruise > shortest {
            pieces.push(t, Polynomial::new([covered, velocity]));
        }
        // The fall runs backwards from the end, where all odd derivatives change their sign.
        let mut left = 0.0;
        let mut backwards = [(0.0, Polynomial::default()); 3];
        let mut count = 0;
        for (length, polynomial) in fall.times(-1.0).phases([q1, -v1]) {
            if length > shortest {
                left += length;
                let [q, qd, qdd, qddd] = polynomial.cubic_at(length);
                backwards[count] = (duration - left, Polynomial::new([q, -qd, 0.5 * qdd, -qddd / 6.0]));
                count += 1;
            }
        }
        for &(start, polynomial) in backwards[..count].iter().rev() {
            // Without a rise and a cruise the first of them begins at 0, whatever rounding says.
            pieces.push(if pieces.count == 0 { 0.0 } else { start }, polynomial);
        }
        if pieces.count == 0 {
            pieces.push(0.0, Polynomial::new(start));
        }
        pieces
    }

    /// When each piece begins, and its polynomial in the local time that is 0 there.
    pub(crate) fn iter(&self) -> impl ExactSizeIterator<Item = (f64, &Polynomial)> {
        self.starts[..self.count].iter().copied().zip(&self.polynomials[..self.count])
    }

    /// When each piece begins; the first at 0.
    pub(crate) fn starts(&self) -> &[f64] {
        &self.starts[..self.count]
    }

    /// Value and first three derivatives at `t`; where pieces meet, those of the later one.
    pub(crate) fn eval(&self, t: f64) -> [f64; 4] {
        let piece = self.index_at(t);
        self.polynomials[piece].eval(t - self.starts[piece])
    }

    /// The index of the piece that holds `t`.
    pub(crate) fn index_at(&self, t: f64) -> usize {
        self.starts[1..self.count].iter().take_while(|start| **start <= t).count()
    }

    /// The polynomial of a piece.
    pub(crate) fn polynomial(&self, index: usize) -> &Polynomial {
        &self.polynomials[index]
    }

    /// Each polynomial changed.
    pub(crate) fn map(&self, change: impl Fn(&Polynomial) -> Polynomial) -> Self {
        let mut changed = *self;
        for polynomial in &mut changed.polynomials[..self.count] {
            *polynomial = change(polynomial);
        }
        changed
    }

    /// Whether every number is finite.
    pub(crate) fn is_finite(&self) -> bool {
        self.iter().all(|(start, polynomial)| start.is_finite() && polynomial.is_finite())
    }
}

/// A change of velocity: the acceleration grows, stays, and falls as it grew.
///
/// Size and lengths of the phases are kept side by side, so that a small change of a large velocity has the
/// acceleration that it should.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct VelocityChange {
    /// The velocity after it minus the one before.
    pub(crate) change: f64,
    /// How long each of the two phases of constant jerk lasts, s; 0 where the acceleration steps.
    pub(crate) jerk: f64,
    /// How long the phase of constant acceleration lasts, s.
    pub(crate) acceleration: f64,
}

impl VelocityChange {
    /// The fastest change of velocity by `change ≥ 0` under limits on acceleration and jerk:
    /// `t_j = A/J, t_c = Δv/A - t_j` if `Δv J ≥ A²`, else `t_j = √(Δv/J), t_c = 0`.
    pub(crate) fn fastest(change: f64, acceleration: f64, jerk: f64) -> Self {
        let full = acceleration / jerk;
        let constant = change / acceleration - full;
        if constant >= 0.0 {
            Self { change, jerk: full, acceleration: constant }
        } else {
            Self { change, jerk: (change / jerk).sqrt(), acceleration: 0.0 }
        }
    }

    /// How long it takes, s.
    pub(crate) fn duration(self) -> f64 {
        2.0 * self.jerk + self.acceleration
    }

    /// In the same time a change that is `factor` times as large.
    pub(crate) fn times(self, factor: f64) -> Self {
        Self { change: factor * self.change, ..self }
    }

    /// The phases from a position and velocity on, with their lengths; those of length 0 mean nothing.
    fn phases(self, [q, qd]: [f64; 2]) -> [(f64, Polynomial); 3] {
        let Self { change, jerk: t_j, acceleration: t_c } = self;
        let acceleration = if change == 0.0 { 0.0 } else { change / (t_j + t_c) };
        let sixth = if t_j > 0.0 { acceleration / t_j / 6.0 } else { 0.0 };
        let first = Polynomial::new([q, qd, 0.0, sixth]);
        let [q, qd, ..] = first.cubic_at(t_j);
        let second = Polynomial::new([q, qd, 0.5 * acceleration]);
        let [q, qd, ..] = second.cubic_at(t_c);
        let third = Polynomial::new([q, qd, 0.5 * acceleration, -sixth]);
        [(t_j, first), (t_c, second), (t_j, third)]
    }
}

/// Evaluation of what is known to be a cubic, several times as fast as for any degree.
trait Cubic {
    /// The value.
    fn position(&self, tau: f64) -> f64;
    /// The value and three derivatives.
    fn cubic_at(&self, tau: f64) -> [f64; 4];
}

impl Cubic for Polynomial {
    fn position(&self, tau: f64) -> f64 {
        let [a, b, c, d, ..] = *self.coefficients();
        ((d * tau + c) * tau + b) * tau + a
    }

    fn cubic_at(&self, tau: f64) -> [f64; 4] {
        let [_, b, c, d, ..] = *self.coefficients();
        [self.position(tau), (3.0 * d * tau + 2.0 * c) * tau + b, 6.0 * d * tau + 2.0 * c, 6.0 * d]
    }
}
