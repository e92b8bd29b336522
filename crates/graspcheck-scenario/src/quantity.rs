//! Units, which stand in the key: `duration_s`, `clearance_mm`, `jerk_max_deg_s3`.
//!
//! The list is closed. The first unit of a quantity is the one that messages propose.

/// What a number measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    Length,
    Angle,
    Time,
    Mass,
    Inertia,
    Force,
    Frequency,
    Share,
    Speed,
    AngularSpeed,
    AngularAcceleration,
    LinearAcceleration,
    AngularJerk,
    LinearJerk,
}

/// A unit as the end of a key.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Unit {
    /// The end of the key after an underscore.
    pub(crate) suffix: &'static str,
    /// To SI units. Divides where it can, since 15 / 1000 is the number nearest to 0.015 and 15 · 0.001
    /// need not be.
    pub(crate) to_si: fn(f64) -> f64,
}

impl Quantity {
    pub(crate) const ALL: [Self; 14] = [
        Self::Length,
        Self::Angle,
        Self::Time,
        Self::Mass,
        Self::Inertia,
        Self::Force,
        Self::Frequency,
        Self::Share,
        Self::Speed,
        Self::AngularSpeed,
        Self::AngularAcceleration,
        Self::LinearAcceleration,
        Self::AngularJerk,
        Self::LinearJerk,
    ];

    /// The quantity with its article.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Length => "a length",
            Self::Angle => "an angle",
            Self::Time => "a time",
            Self::Mass => "a mass",
            Self::Inertia => "a moment of inertia",
            Self::Force => "a force",
            Self::Frequency => "a frequency",
            Self::Share => "a share",
            Self::Speed => "a speed",
            Self::AngularSpeed => "an angular speed",
            Self::AngularAcceleration => "an angular acceleration",
            Self::LinearAcceleration => "an acceleration",
            Self::AngularJerk => "an angular jerk",
            Self::LinearJerk => "a jerk",
        }
    }

    /// Its units, the usual one first.
    pub(crate) fn units(self) -> &'static [Unit] {
        match self {
            Self::Length => &[Unit { suffix: "mm", to_si: thousandth }, Unit { suffix: "m", to_si: same }],
            Self::Angle => {
                &[Unit { suffix: "deg", to_si: f64::to_radians }, Unit { suffix: "rad", to_si: same }]
            }
            Self::Time => &[Unit { suffix: "s", to_si: same }, Unit { suffix: "ms", to_si: thousandth }],
            Self::Mass => &[Unit { suffix: "kg", to_si: same }, Unit { suffix: "g", to_si: thousandth }],
            Self::Inertia => &[Unit { suffix: "kg_m2", to_si: same }],
            Self::Force => &[Unit { suffix: "n", to_si: same }],
            Self::Frequency => &[Unit { suffix: "hz", to_si: same }],
            Self::Share => &[Unit { suffix: "percent", to_si: hundredth }],
            Self::Speed => &[Unit { suffix: "mm_s", to_si: thousandth }, Unit { suffix: "m_s", to_si: same }],
            Self::AngularSpeed => {
                &[Unit { suffix: "deg_s", to_si: f64::to_radians }, Unit { suffix: "rad_s", to_si: same }]
            }
            Self::AngularAcceleration => {
                &[Unit { suffix: "deg_s2", to_si: f64::to_radians }, Unit { suffix: "rad_s2", to_si: same }]
            }
            Self::LinearAcceleration => {
                &[Unit { suffix: "m_s2", to_si: same }, Unit { suffix: "mm_s2", to_si: thousandth }]
            }
            Self::AngularJerk => {
                &[Unit { suffix: "deg_s3", to_si: f64::to_radians }, Unit { suffix: "rad_s3", to_si: same }]
            }
            Self::LinearJerk => {
                &[Unit { suffix: "m_s3", to_si: same }, Unit { suffix: "mm_s3", to_si: thousandth }]
            }
        }
    }

    /// `stem` with the usual unit, e.g. `duration_s`.
    pub(crate) fn key(self, stem: &str) -> String {
        format!("{stem}_{}", self.units()[0].suffix)
    }

    /// Every key under which the quantity may stand.
    pub(crate) fn keys(self, stem: &str) -> impl Iterator<Item = (String, Unit)> + '_ {
        let stem = stem.to_owned();
        self.units().iter().map(move |unit| (format!("{stem}_{}", unit.suffix), *unit))
    }

    /// The quantity that a key's ending measures when the key starts with `stem`.
    pub(crate) fn of_key(stem: &str, key: &str) -> Option<Self> {
        let suffix = key.strip_prefix(stem)?.strip_prefix('_')?;
        Self::ALL.into_iter().find(|quantity| quantity.units().iter().any(|unit| unit.suffix == suffix))
    }
}

fn same(value: f64) -> f64 {
    value
}

fn thousandth(value: f64) -> f64 {
    value / 1000.0
}

fn hundredth(value: f64) -> f64 {
    value / 100.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_ending_belongs_to_two_quantities() {
        let mut endings: Vec<_> =
            Quantity::ALL.iter().flat_map(|q| q.units()).map(|unit| unit.suffix).collect();
        endings.sort_unstable();
        let count = endings.len();
        endings.dedup();
        assert_eq!(endings.len(), count);
    }

    #[test]
    fn the_ending_tells_the_quantity() {
        assert_eq!(Quantity::of_key("quill", "quill_deg"), Some(Quantity::Angle));
        assert_eq!(Quantity::of_key("jerk_max", "jerk_max_m_s3"), Some(Quantity::LinearJerk));
        assert_eq!(Quantity::of_key("quill", "quill"), None);
        assert_eq!(Quantity::of_key("quill", "quill_inch"), None);
        assert_eq!(Quantity::of_key("quill", "quills_mm"), None);
    }

    #[test]
    fn converts_to_the_nearest_number_in_si() {
        let millimetre = Quantity::Length.units()[0];
        assert_eq!((millimetre.to_si)(15.0).to_bits(), 0.015_f64.to_bits());
        let degree = Quantity::Angle.units()[0];
        assert_eq!((degree.to_si)(180.0).to_bits(), std::f64::consts::PI.to_bits());
    }
}
