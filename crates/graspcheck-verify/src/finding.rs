//! What a check has found, before it becomes a [`CheckResult`](crate::CheckResult).

use crate::{
    note::Note,
    verdict::{Place, Unit},
};

/// A relative excess over a limit that is rounding: a motion planned to *reach* a limit comes out of about
/// a hundred operations, each with an error of 1.1e-16, on numbers that cancel by a few digits.
pub(crate) const ROUNDING: f64 = 1e-9;

/// A value held against a limit.
#[derive(Clone, Debug)]
pub(crate) struct Finding {
    pub(crate) passes: bool,
    pub(crate) value: f64,
    pub(crate) limit: f64,
    pub(crate) unit: Unit,
    pub(crate) margin: f64,
    pub(crate) margin_is_share: bool,
    pub(crate) value_is_bound: bool,
    pub(crate) time: Option<f64>,
    pub(crate) violated: Option<[f64; 2]>,
    pub(crate) place: Place,
    pub(crate) note: Note,
    /// How many times as long the whole motion must be given for the limit to be kept.
    pub(crate) stretch: Option<f64>,
}

impl Finding {
    fn new(passes: bool, value: f64, limit: f64, unit: Unit, margin: f64) -> Self {
        Self {
            passes,
            value,
            limit,
            unit,
            margin,
            margin_is_share: false,
            value_is_bound: false,
            time: None,
            violated: None,
            place: Place::default(),
            note: Note::default(),
            stretch: None,
        }
    }

    /// `value` must be at most `limit`; the margin is in their unit. NaN does not pass.
    pub(crate) fn at_most(value: f64, limit: f64, unit: Unit) -> Self {
        let passes = value <= limit + ROUNDING * limit.abs();
        Self::new(passes, value, limit, unit, limit - value)
    }

    /// `value` must be at least `limit`; the margin is in their unit. NaN does not pass.
    pub(crate) fn at_least(value: f64, limit: f64, unit: Unit) -> Self {
        let passes = value >= limit - ROUNDING * limit.abs();
        Self::new(passes, value, limit, unit, value - limit)
    }

    /// The same with its margin as a share of the limit; as it is when the limit is 0.
    pub(crate) fn by_share(mut self) -> Self {
        if self.limit != 0.0 {
            self.margin /= self.limit.abs();
            self.margin_is_share = true;
        }
        self
    }

    /// The worst of samples `(time, value)`, each of which must be at most `limit`, with the first and the
    /// last instant at which one is not; none of no samples.
    pub(crate) fn worst_at_most(samples: &[(f64, f64)], limit: f64, unit: Unit) -> Option<Self> {
        let &(time, value) = worst_by(samples, |sample| sample.1)?;
        let mut finding = Self::at_most(value, limit, unit).at(time);
        let mut beyond = samples.iter().filter(|(_, value)| !Self::at_most(*value, limit, unit).passes);
        if let Some(&(first, _)) = beyond.next() {
            finding.violated = Some([first, beyond.next_back().map_or(first, |&(last, _)| last)]);
        }
        Some(finding)
    }

    /// The same with the stretch of time that would cure it, when it fails: a derivative of the given order goes as
    /// 1/kᵒʳᵈᵉʳ when the whole motion is given k times as long.
    pub(crate) fn slower(mut self, order: usize) -> Self {
        let stretch = (self.value / self.limit).powf(1.0 / order as f64);
        self.stretch = (!self.passes && stretch.is_finite()).then_some(stretch);
        self
    }

    pub(crate) fn at(mut self, time: f64) -> Self {
        self.time = Some(time);
        self
    }

    pub(crate) fn of<S: Into<String>>(mut self, subjects: impl IntoIterator<Item = S>) -> Self {
        self.place.subjects = subjects.into_iter().map(Into::into).collect();
        self
    }

    pub(crate) fn during(mut self, phase: impl Into<String>) -> Self {
        self.place.phase = Some(phase.into());
        self
    }

    pub(crate) fn noted(mut self, note: impl Into<Note>) -> Self {
        self.note = note.into();
        self
    }
}

/// Why a check has no value to hold against a limit.
#[derive(Clone, Debug)]
pub(crate) enum Gap {
    /// The run was not asked for what the check reads.
    NotRequested(Note),
    /// What the check reads is missing, incomplete or undecided.
    Inconclusive {
        /// Where the trouble begins, s.
        time: Option<f64>,
        /// What is missing.
        note: Note,
    },
    /// What the check reads is there and cannot be: a simulation that is not finite has failed.
    Broken {
        /// Where the trouble begins, s.
        time: f64,
        /// What is wrong.
        note: Note,
    },
}

impl Gap {
    pub(crate) fn not_requested(note: impl Into<Note>) -> Self {
        Self::NotRequested(note.into())
    }

    pub(crate) fn inconclusive(time: Option<f64>, note: impl Into<Note>) -> Self {
        Self::Inconclusive { time, note: note.into() }
    }
}

/// The items that have the largest key, the first of them on a tie; none of no items.
///
/// A NaN counts as larger than every number, so that it is found rather than passed over.
pub(crate) fn worst_by<T>(items: impl IntoIterator<Item = T>, key: impl Fn(&T) -> f64) -> Option<T> {
    let rank = |item: &T| match key(item) {
        k if k.is_nan() => f64::INFINITY,
        k => k,
    };
    items.into_iter().reduce(|worst, next| if rank(&next) > rank(&worst) { next } else { worst })
}
