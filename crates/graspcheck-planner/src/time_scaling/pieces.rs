//! The polynomials of a law, and the change of velocity of which most laws are made.

use graspcheck_motion::Polynomial;

/// Most pieces that a law has: two S-curves of seven phases, of which it is a mixture.
const MOST: usize = 13;

/// The polynomials of a law in order of time, held in place: making and copying a law allocates nothing. It is one
/// polynomial of any degree, or several cubics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pieces {
    count: usize,
    starts: [f64; MOST],
    /// Coefficients of τ⁰ to τ³ of each piece.
    low: [Cubic; MOST],
    /// Coefficients of τ⁴ to τ⁷; zero unless there is one piece alone.
    high: [f64; 4],
}

/// Coefficients of τ⁰ to τ³.
type Cubic = [f64; 4];

/// A stretch of constant jerk: how long it lasts, s, and the jerk.
pub(crate) type JerkPhase = (f64, f64);

impl Pieces {
    /// One polynomial from time 0 on.
    pub(crate) fn one(polynomial: Polynomial) -> Self {
        let [low, high] = split(&polynomial);
        let mut pieces = Self::none();
        pieces.push(0.0, low);
        pieces.high = high;
        pieces
    }

    fn none() -> Self {
        Self { count: 0, starts: [0.0; MOST], low: [[0.0; 4]; MOST], high: [0.0; 4] }
    }

    fn push(&mut self, start: f64, cubic: Cubic) {
        self.starts[self.count] = start;
        self.low[self.count] = cubic;
        self.count += 1;
    }

    /// A change of velocity, a cruise, and another change of velocity, which last `duration` together.
    ///
    /// `start` and `end` are `[position, velocity]`, `velocity` is that of the cruise; the second change is the
    /// one that leads back from the end to the cruise. Built from both ends, so that the law starts and ends
    /// where it should to the last bit, and rounding shows only where the two halves meet.
    pub(crate) fn between(
        [q0, v0]: [f64; 2],
        rise: VelocityChange,
        (cruise, velocity): (f64, f64),
        fall: VelocityChange,
        [q1, v1]: [f64; 2],
        duration: f64,
    ) -> Self {
        let forwards = rise.phases([q0, v0]);
        let [_, _, last] = forwards;
        let middle = (cruise, [value(&last.1, last.0), velocity, 0.0, 0.0]);
        let forwards = [forwards[0], forwards[1], forwards[2], middle];
        Self::from_both_ends(&forwards, &fall.times(-1.0).phases([q1, -v1]), [q0, v0, 0.0], duration)
    }

    /// Phases of constant jerk, a cruise at constant velocity, and phases of constant jerk, which last `duration`
    /// together. Those after the cruise are listed from the end back, each with the jerk that it has in the order
    /// of time. `start` and `end` are `[position, velocity, acceleration]`.
    pub(crate) fn of_jerks(
        start: [f64; 3],
        rise: [JerkPhase; 3],
        (cruise, velocity): (f64, f64),
        fall: [JerkPhase; 3],
        [q1, v1, a1]: [f64; 3],
        duration: f64,
    ) -> Self {
        let [first, second, third] = cubics(start, rise);
        let middle = (cruise, [value(&third.1, third.0), velocity, 0.0, 0.0]);
        // Backwards in time velocity and jerk change their sign.
        let backwards = cubics([q1, -v1, a1], fall.map(|(length, jerk)| (length, -jerk)));
        Self::from_both_ends(&[first, second, third, middle], &backwards, start, duration)
    }

    /// Cubics with their lengths, from the start on and from the end back, the latter in the time that runs back.
    fn from_both_ends(
        forwards: &[(f64, Cubic)],
        backwards: &[(f64, Cubic)],
        [q, qd, qdd]: [f64; 3],
        duration: f64,
    ) -> Self {
        // A phase this short does not move the law by more than rounding does, and its knots might coincide.
        let shortest = 4.0 * f64::EPSILON * duration;
        let mut pieces = Self::none();
        let mut t = 0.0;
        for &(length, cubic) in forwards.iter().filter(|(length, _)| *length > shortest) {
            pieces.push(t, cubic);
            t += length;
        }
        let mut starts = [0.0; MOST];
        let mut left = 0.0;
        for (start, (length, _)) in starts.iter_mut().zip(backwards) {
            left += if *length > shortest { *length } else { 0.0 };
            *start = duration - left;
        }
        for (&start, (length, cubic)) in starts.iter().zip(backwards).rev() {
            if *length > shortest {
                let [q, qd, qdd, qddd] = cubic_at(cubic, *length);
                // Without a phase before it the first of them begins at 0, whatever rounding says.
                let start = if pieces.count == 0 { 0.0 } else { start };
                pieces.push(start, [q, -qd, 0.5 * qdd, -qddd / 6.0]);
            }
        }
        if pieces.count == 0 {
            pieces.push(0.0, [q, qd, 0.5 * qdd, 0.0]);
        }
        pieces
    }

    /// The mixture `(1 - share) a + share b` of two laws of the same duration, both of them cubics, that ends at a
    /// position that the mixture has but for rounding.
    pub(crate) fn mixed(a: &Self, b: &Self, share: f64, end: f64, duration: f64) -> Self {
        let shortest = 4.0 * f64::EPSILON * duration;
        let mut pieces = Self::none();
        let (mut i, mut j) = (0, 0);
        let mut t = 0.0;
        loop {
            let [a_now, b_now] = [(a, i), (b, j)].map(|(of, at)| shifted(&of.low[at], t - of.starts[at]));
            pieces.push(t, std::array::from_fn(|k| (1.0 - share) * a_now[k] + share * b_now[k]));
            let next = a.next_start(i).min(b.next_start(j));
            if next == f64::INFINITY {
                break;
            }
            i += usize::from(a.next_start(i) <= next + shortest);
            j += usize::from(b.next_start(j) <= next + shortest);
            t = next;
        }
        // What rounding left shows in the middle, not at the end.
        let missing = end - pieces.eval(duration)[0];
        for (start, cubic) in pieces.starts.iter().zip(&mut pieces.low).take(pieces.count) {
            cubic[0] += if *start > 0.5 * duration || pieces.count == 1 { missing } else { 0.0 };
        }
        pieces
    }

    /// When the piece after this one begins; infinity after the last.
    pub(crate) fn next_start(&self, piece: usize) -> f64 {
        if piece + 1 < self.count { self.starts[piece + 1] } else { f64::INFINITY }
    }

    /// When each piece begins, and its polynomial in the local time that is 0 there.
    pub(crate) fn iter(&self) -> impl ExactSizeIterator<Item = (f64, Polynomial)> {
        (0..self.count).map(|piece| (self.starts[piece], self.polynomial(piece)))
    }

    /// When each piece begins; the first at 0.
    pub(crate) fn starts(&self) -> &[f64] {
        &self.starts[..self.count]
    }

    /// Value and first three derivatives at `t`; where pieces meet, those of the later one.
    pub(crate) fn eval(&self, t: f64) -> [f64; 4] {
        let piece = self.index_at(t);
        self.polynomial(piece).eval(t - self.starts[piece])
    }

    /// The index of the piece that holds `t`.
    fn index_at(&self, t: f64) -> usize {
        self.starts[1..self.count].iter().take_while(|start| **start <= t).count()
    }

    /// The polynomial of a piece.
    pub(crate) fn polynomial(&self, piece: usize) -> Polynomial {
        let ([a, b, c, d], [e, f, g, h]) = (self.low[piece], self.high);
        Polynomial::new([a, b, c, d, e, f, g, h])
    }

    /// Adds the polynomial of a piece in the local time that is 0 at `into` of its own; for 0 the very same.
    #[inline]
    pub(crate) fn push_from(&self, piece: usize, into: f64, to: &mut Vec<Polynomial>) {
        // One push each: a polynomial that is made in two ways and kept in one place takes twice the time.
        if self.high.iter().all(|c| *c == 0.0) {
            to.push(Polynomial::new(shifted(&self.low[piece], into)));
        } else {
            to.push(self.polynomial(piece).shifted(into));
        }
    }

    /// Whether every number is finite.
    pub(crate) fn is_finite(&self) -> bool {
        let low = self.low[..self.count].iter().flatten();
        low.chain(&self.high).chain(self.starts()).fold(true, |finite, number| finite & number.is_finite())
    }
}

/// The coefficients of τ⁰ to τ³, and those of higher powers.
fn split(polynomial: &Polynomial) -> [[f64; 4]; 2] {
    let [a, b, c, d, e, f, g, h] = *polynomial.coefficients();
    [[a, b, c, d], [e, f, g, h]]
}

/// Phases of constant jerk one after the other, each with its length and its cubic.
fn cubics<const N: usize>(mut state: [f64; 3], phases: [JerkPhase; N]) -> [(f64, Cubic); N] {
    phases.map(|(length, jerk)| {
        let cubic = [state[0], state[1], 0.5 * state[2], jerk / 6.0];
        let [q, qd, qdd, _] = cubic_at(&cubic, length);
        state = [q, qd, qdd];
        (length, cubic)
    })
}

fn value([a, b, c, d]: &Cubic, tau: f64) -> f64 {
    ((d * tau + c) * tau + b) * tau + a
}

/// The value and three derivatives.
fn cubic_at(cubic: &Cubic, tau: f64) -> [f64; 4] {
    let [_, b, c, d] = *cubic;
    [value(cubic, tau), (3.0 * d * tau + 2.0 * c) * tau + b, 6.0 * d * tau + 2.0 * c, 6.0 * d]
}

/// The cubic in the local time that is 0 at `shift` of its own.
fn shifted(cubic: &Cubic, shift: f64) -> Cubic {
    let [_, b, c, d] = *cubic;
    [value(cubic, shift), (3.0 * d * shift + 2.0 * c) * shift + b, 3.0 * d * shift + c, d]
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

    /// In the same time a change that is `factor` times as large.
    pub(crate) fn times(self, factor: f64) -> Self {
        Self { change: factor * self.change, ..self }
    }

    /// The phases from a position and velocity on, with their lengths; those of length 0 mean nothing.
    fn phases(self, [q, qd]: [f64; 2]) -> [(f64, Cubic); 3] {
        let Self { change, jerk: t_j, acceleration: t_c } = self;
        let acceleration = if change == 0.0 { 0.0 } else { change / (t_j + t_c) };
        let sixth = if t_j > 0.0 { acceleration / t_j / 6.0 } else { 0.0 };
        let first = [q, qd, 0.0, sixth];
        let [q, qd, ..] = cubic_at(&first, t_j);
        let second = [q, qd, 0.5 * acceleration, 0.0];
        let [q, qd, ..] = cubic_at(&second, t_c);
        let third = [q, qd, 0.5 * acceleration, -sixth];
        [(t_j, first), (t_c, second), (t_j, third)]
    }
}
