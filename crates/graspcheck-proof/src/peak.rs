//! The largest magnitude that a quantity takes over a motion, or the proof that it keeps a limit.
//!
//! Both halve stretches of time. On each, the quantity is known at both ends and in the middle, and a bound holds
//! throughout; see [`Bounded`]. [`find_peaks`] takes the stretch with the largest bound first, until no bound exceeds
//! what some instant is known to take by more than a tolerance. [`keep_limits`] only asks whether a bound is at most
//! the limit, which takes far fewer stretches; and it goes as deep as rounding allows.
//!
//! A stretch has two *courses* where either of two things may be the case on it, such as an object that may weigh on
//! the fingers or not.

use std::{cmp::Ordering, collections::BinaryHeap};

/// A stretch shorter than this, s, is halved no more: it would decide nothing that rounding does not.
const SHORTEST_STRETCH: f64 = 1e-9;

/// Stretches that are looked at before a search gives up: about a hundred times what a hard case takes.
pub(crate) const MOST_STEPS: usize = 100_000;

/// Quantities that can be bounded over stretches of time.
pub(crate) trait Bounded {
    /// How many quantities there are.
    fn count(&self) -> usize;

    /// How many numbers [`Bounded::sample`] writes.
    fn sample_size(&self) -> usize;

    /// Computes what bounds need to know of an instant (s) of a course.
    fn sample(&mut self, course: usize, time: f64, sample: &mut [f64]);

    /// Bounds every quantity's magnitude between two instants (s) of a course, from its samples at the first, in the
    /// middle and at the last.
    fn bound(&mut self, course: usize, ends: [f64; 2], samples: [&[f64]; 3], bounds: &mut [Bound]);
}

/// Bounds on the magnitude of a quantity on a stretch of time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Bound {
    /// It is never more.
    pub(crate) most: f64,
    /// In the middle it is at least this.
    pub(crate) attained: f64,
    /// What of `most` a shorter stretch would not reduce.
    pub(crate) undecided: f64,
}

/// A stretch of time on which all is smooth, s.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Course {
    pub(crate) start: f64,
    pub(crate) end: f64,
}

/// The largest magnitude of one quantity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct FoundPeak {
    /// At `time` it is at least this.
    pub(crate) lower: f64,
    /// It is never more.
    pub(crate) upper: f64,
    pub(crate) time: f64,
    /// The course in which it is.
    pub(crate) course: usize,
}

/// What [`keep_limits`] has found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kept {
    /// No quantity exceeds its limit at any instant.
    Always,
    /// One does.
    Not {
        quantity: usize,
        course: usize,
        time: f64,
        /// At least this.
        value: f64,
    },
    /// One comes too near to its limit to tell.
    Unknown { quantity: usize, course: usize, time: f64 },
}

/// Samples at the ends and in the middle of a stretch, in one row.
struct Samples {
    size: usize,
    rows: Vec<f64>,
}

impl Samples {
    fn get(&self, row: usize) -> &[f64] {
        &self.rows[row * self.size..(row + 1) * self.size]
    }

    /// A new row for an instant.
    fn take(&mut self, function: &mut impl Bounded, course: usize, time: f64) -> usize {
        let row = self.rows.len() / self.size;
        self.rows.resize(self.rows.len() + self.size, 0.0);
        function.sample(course, time, &mut self.rows[row * self.size..]);
        row
    }

    /// Forgets all rows from one on.
    fn forget_from(&mut self, row: usize) {
        self.rows.truncate(row * self.size);
    }
}

/// A stretch with the rows of its samples.
#[derive(Clone, Copy)]
struct Part {
    course: usize,
    start: f64,
    end: f64,
    rows: [usize; 3],
}

impl Part {
    fn whole(function: &mut impl Bounded, samples: &mut Samples, course: usize, of: Course) -> Self {
        let Course { start, end } = of;
        let rows = [start, middle(start, end), end].map(|time| samples.take(function, course, time));
        Self { course, start, end, rows }
    }

    fn middle(&self) -> f64 {
        middle(self.start, self.end)
    }

    fn is_shortest(&self) -> bool {
        self.end - self.start < SHORTEST_STRETCH
    }

    fn bound(&self, function: &mut impl Bounded, samples: &Samples, bounds: &mut [Bound]) {
        function.bound(self.course, [self.start, self.end], self.rows.map(|row| samples.get(row)), bounds);
    }

    /// Both halves; the later one first.
    fn halves(&self, function: &mut impl Bounded, samples: &mut Samples) -> [Self; 2] {
        let [first, middle_row, last] = self.rows;
        let half = self.middle();
        let mut part = |start: f64, end: f64, from: usize, to: usize| {
            let row = samples.take(function, self.course, middle(start, end));
            Self { course: self.course, start, end, rows: [from, row, to] }
        };
        [part(half, self.end, middle_row, last), part(self.start, half, first, middle_row)]
    }
}

fn middle(start: f64, end: f64) -> f64 {
    0.5 * (start + end)
}

/// Whether every quantity keeps its limit at every instant of all courses.
pub(crate) fn keep_limits(function: &mut impl Bounded, courses: &[Course], limits: &[f64]) -> Kept {
    let mut bounds = vec![Bound::default(); function.count()];
    let mut samples = Samples { size: function.sample_size(), rows: Vec::new() };
    let mut todo: Vec<Part> = Vec::new();
    let mut unknown = None;
    let mut steps = 0;
    for (course, &of) in courses.iter().enumerate() {
        samples.forget_from(0);
        todo.push(Part::whole(function, &mut samples, course, of));
        while let Some(part) = todo.pop() {
            // Depth first: what was sampled after this part's middle belongs to parts that are done.
            samples.forget_from(1 + part.rows.into_iter().max().unwrap_or(0));
            steps += 1;
            part.bound(function, &samples, &mut bounds);
            let mut open = None;
            for (quantity, (bound, &limit)) in bounds.iter().zip(limits).enumerate() {
                if bound.attained > limit {
                    let (value, time) = (bound.attained, part.middle());
                    return Kept::Not { quantity, course, time, value };
                }
                // A bound that is not a number is open.
                if bound.most > limit || bound.most.is_nan() {
                    open = Some((quantity, bound.most - bound.undecided > limit));
                }
            }
            let Some((quantity, shorter_helps)) = open else { continue };
            if steps >= MOST_STEPS {
                return Kept::Unknown { quantity, course, time: part.middle() };
            }
            if part.is_shortest() || !shorter_helps {
                // Another instant may still exceed the limit beyond doubt.
                unknown.get_or_insert(Kept::Unknown { quantity, course, time: part.middle() });
            } else {
                todo.extend(part.halves(function, &mut samples));
            }
        }
    }
    unknown.unwrap_or(Kept::Always)
}

/// A stretch in the queue: the one with the largest excess is taken first, of several the earliest.
struct Queued {
    /// How far a bound exceeds what some instant is known to take, in units of the tolerance.
    excess: f64,
    part: Part,
    /// The row of its bounds.
    bounds: usize,
}

impl Ord for Queued {
    fn cmp(&self, other: &Self) -> Ordering {
        self.excess.total_cmp(&other.excess).then_with(|| other.part.start.total_cmp(&self.part.start))
    }
}

impl PartialOrd for Queued {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Queued {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Queued {}

/// The search for peaks.
struct Search<'a, F> {
    function: &'a mut F,
    tolerances: &'a [f64],
    samples: Samples,
    /// Rows of bounds, one for each stretch.
    bounds: Vec<Bound>,
    peaks: Vec<FoundPeak>,
}

impl<F: Bounded> Search<'_, F> {
    /// Bounds a part; what it attains counts for the peaks. A part of another one is bounded by that, too.
    fn look(&mut self, part: Part, of: Option<usize>) -> Queued {
        let count = self.tolerances.len();
        let bounds = self.bounds.len() / count;
        self.bounds.resize(self.bounds.len() + count, Bound::default());
        part.bound(self.function, &self.samples, &mut self.bounds[bounds * count..]);
        for (quantity, peak) in self.peaks.iter_mut().enumerate() {
            let above = of.map_or(f64::INFINITY, |row| self.bounds[row * count + quantity].most);
            let bound = &mut self.bounds[bounds * count + quantity];
            // Also where one of them is not a number.
            bound.most = if bound.most < above { bound.most } else { above };
            if bound.attained > peak.lower {
                let (lower, time, course) = (bound.attained, part.middle(), part.course);
                *peak = FoundPeak { lower, time, course, ..*peak };
            }
        }
        Queued { excess: self.excess(bounds), part, bounds }
    }

    fn of_row(&self, row: usize) -> &[Bound] {
        &self.bounds[row * self.tolerances.len()..(row + 1) * self.tolerances.len()]
    }

    /// How far the bounds of a row exceed the peaks that are known, in units of the tolerances.
    fn excess(&self, row: usize) -> f64 {
        let of_quantity = |((bound, peak), tolerance): ((&Bound, &FoundPeak), &f64)| {
            (bound.most - bound.undecided - peak.lower) / tolerance
        };
        let all = self.of_row(row).iter().zip(&self.peaks).zip(self.tolerances);
        all.map(of_quantity).fold(0.0, |a, b| if b <= a { a } else { b })
    }

    /// The bounds of a row count for the peaks as they are.
    fn settle(&mut self, row: usize) {
        let count = self.tolerances.len();
        for (peak, bound) in self.peaks.iter_mut().zip(&self.bounds[row * count..]) {
            peak.upper = if bound.most <= peak.upper { peak.upper } else { bound.most };
        }
    }
}

/// The largest magnitude of every quantity over all courses, to tolerances in its unit; `most_steps` stretches are
/// looked at. Returned with whether the tolerances are met, but for what is undecided; the bounds hold in any case.
pub(crate) fn find_peaks<F: Bounded>(
    function: &mut F,
    courses: &[Course],
    tolerances: &[f64],
    most_steps: usize,
) -> (Vec<FoundPeak>, bool) {
    let peaks = vec![FoundPeak::default(); tolerances.len()];
    let samples = Samples { size: function.sample_size(), rows: Vec::new() };
    let mut search = Search { function, tolerances, samples, bounds: Vec::new(), peaks };
    let mut queue = BinaryHeap::with_capacity(4 * courses.len());
    for (course, &of) in courses.iter().enumerate() {
        let part = Part::whole(search.function, &mut search.samples, course, of);
        let queued = search.look(part, None);
        queue.push(queued);
    }
    let (mut steps, mut is_settled) = (courses.len(), true);
    while let Some(Queued { part, bounds, .. }) = queue.pop() {
        // What was found since counts: the excess may be less than it was.
        let excess = search.excess(bounds);
        let is_open = excess > 1.0 || excess.is_nan();
        if is_open && !part.is_shortest() && steps < most_steps {
            for half in part.halves(search.function, &mut search.samples) {
                let queued = search.look(half, Some(bounds));
                queue.push(queued);
            }
            steps += 2;
        } else {
            is_settled &= !is_open || part.is_shortest();
            search.settle(bounds);
        }
    }
    (search.peaks, is_settled)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// cos(20 t) and 3 t, known to be what they are from the middle and their largest rates; and how often they were
    /// asked for.
    struct Wave {
        bounded: usize,
    }

    impl Bounded for Wave {
        fn count(&self) -> usize {
            2
        }

        fn sample_size(&self) -> usize {
            2
        }

        fn sample(&mut self, _: usize, time: f64, sample: &mut [f64]) {
            sample.copy_from_slice(&[(20.0 * time).cos(), 3.0 * time]);
        }

        fn bound(&mut self, _: usize, [start, end]: [f64; 2], samples: [&[f64]; 3], bounds: &mut [Bound]) {
            self.bounded += 1;
            for (quantity, rate) in [20.0, 3.0].into_iter().enumerate() {
                let attained = samples[1][quantity].abs();
                let most = attained + rate * 0.5 * (end - start) * (1.0 + 1e-12);
                bounds[quantity] = Bound { most, attained, undecided: 0.0 };
            }
        }
    }

    const COURSES: [Course; 2] = [Course { start: 0.1, end: 0.5 }, Course { start: 0.5, end: 0.8 }];

    #[test]
    fn peaks_are_found_to_the_tolerance_with_their_times() {
        let (peaks, is_settled) = find_peaks(&mut Wave { bounded: 0 }, &COURSES, &[1e-6, 1e-6], MOST_STEPS);
        assert!(is_settled);
        for (peak, truth) in peaks.iter().zip([1.0, 2.4]) {
            assert!(
                peak.lower <= truth + 1e-12 && truth <= peak.upper && peak.upper - peak.lower <= 1e-6,
                "{peak:?}"
            );
        }
        // cos(20 t) is −1 at π/20 and 3π/20, 1 at 2π/20 and 4π/20.
        let quarter = std::f64::consts::PI / 20.0;
        assert!((peaks[0].time / quarter - (peaks[0].time / quarter).round()).abs() < 1e-2, "{peaks:?}");
        assert!((peaks[1].time - 0.8).abs() < 1e-5 && peaks[1].course == 1);
    }

    #[test]
    fn bounds_hold_when_the_steps_are_used_up() {
        let (peaks, is_settled) = find_peaks(&mut Wave { bounded: 0 }, &COURSES, &[1e-9, 1e-9], 8);
        assert!(!is_settled);
        assert!(peaks[0].upper >= 1.0 && peaks[1].upper >= 2.4 && peaks[0].lower <= 1.0, "{peaks:?}");
    }

    #[test]
    fn a_limit_is_kept_or_not_with_fewer_steps_than_the_peak_takes() {
        let mut wave = Wave { bounded: 0 };
        find_peaks(&mut wave, &COURSES, &[1e-3, 1e-3], MOST_STEPS);
        let for_peaks = std::mem::take(&mut wave.bounded);
        assert_eq!(keep_limits(&mut wave, &COURSES, &[1.1, 2.5]), Kept::Always);
        assert!(wave.bounded < for_peaks / 4, "{} of {for_peaks}", wave.bounded);
        let Kept::Not { quantity, course, time, value } = keep_limits(&mut wave, &COURSES, &[1.1, 2.39])
        else {
            panic!("3 t reaches 2.4");
        };
        assert_eq!((quantity, course), (1, 1));
        assert!(value > 2.39 && (value - 3.0 * time).abs() < 1e-12);
        // So near to the limit that rounding decides.
        assert!(matches!(
            keep_limits(&mut wave, &COURSES, &[1.1, 2.4 - 1e-12]),
            Kept::Unknown { quantity: 1, .. }
        ));
    }
}
