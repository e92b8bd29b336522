//! The judge: every claim of a certificate and of the least margin, held against distances of its own.

use std::collections::BTreeSet;

use graspcheck_model::robot::RobotModel;
use graspcheck_proof::{
    Leaf, MarginBounds, PairCertificate, PairVerdict, Scene, Violation,
    contact::{APPROACH_MARGIN, DEPTH_LIMIT, SUPPORT_OVERLAP},
};
use nalgebra::Vector3;

use super::{
    distance::{Distance, distance_above},
    motion::{Bodies, Carrier, Moment},
    random::Case,
    solid::Placed,
};

/// Samples a second.
pub const RATE: f64 = 1e4;
/// Rounding of places and distances on an arm of 8 m, m: far less than the nanometre that every proof leaves.
const ROUNDING: f64 = 1e-10;
/// How exactly a witness point must lie in its solid, and the two as far apart as is said, m.
const WITNESS: f64 = 1e-8;
/// To how much the least margin is brought, m.
const TOLERANCE: f64 = 1e-4;
/// The bounds of the judge's own distance are this near, m, or the sample is counted as vague.
const VAGUE: f64 = 1e-7;
/// Samples that share one bound on the speeds.
const WINDOW: usize = 32;

/// What came out of one or many scenes.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    pub scenes: u64,
    pub held: u64,
    pub free: u64,
    pub violated: u64,
    pub unknown: u64,
    pub not_checked: u64,
    /// Scenes with an unknown pair.
    pub unknown_scenes: u64,
    pub free_scenes: u64,
    pub violated_scenes: u64,
    pub leaves: u64,
    /// Samples of a pair that the speed bound left to be looked at, and those that it excluded.
    pub looked_at: u64,
    pub excluded: u64,
    /// Distances that the judge knows no better than [`VAGUE`].
    pub vague: u64,
    /// Least margins that were bracketed to [`TOLERANCE`], and that were not.
    pub bracketed: u64,
    pub loose: u64,
    /// Claims that are not true, in words.
    pub contradictions: Vec<String>,
}

impl Tally {
    pub fn add(&mut self, other: Self) {
        self.scenes += other.scenes;
        self.held += other.held;
        self.free += other.free;
        self.violated += other.violated;
        self.unknown += other.unknown;
        self.not_checked += other.not_checked;
        self.unknown_scenes += other.unknown_scenes;
        self.free_scenes += other.free_scenes;
        self.violated_scenes += other.violated_scenes;
        self.leaves += other.leaves;
        self.looked_at += other.looked_at;
        self.excluded += other.excluded;
        self.vague += other.vague;
        self.bracketed += other.bracketed;
        self.loose += other.loose;
        self.contradictions.extend(other.contradictions);
    }
}

/// Proves a case and judges the proofs. `label` stands in front of every contradiction. With `of_hits` the least margin
/// is judged of scenes with a hit, too, which takes most of the time: the depths of overlaps are searched for.
pub fn judge(label: &str, case: &Case, of_hits: bool) -> Tally {
    let scene = Scene::new(&case.robot, &case.cell, case.object.as_ref()).unwrap();
    let certificate = scene.certify(&case.plan);
    let wanted = of_hits || certificate.is_free();
    let least = wanted.then(|| scene.minimum_margin(&case.plan, TOLERANCE)).flatten();
    let bodies = case.bodies();
    let mut judge = Judge::new(label, case, &bodies);
    judge.pairs_are(&certificate.pairs);
    for pair in &certificate.pairs {
        judge.pair(pair, least.as_ref());
    }
    if wanted {
        judge.least(&certificate.pairs, least.as_ref());
    }
    let mut tally = judge.tally;
    tally.scenes = 1;
    tally.held = u64::from(case.object.is_some());
    tally.unknown_scenes = u64::from(tally.unknown > 0);
    tally.free_scenes = u64::from(certificate.is_free());
    tally.violated_scenes = u64::from(tally.violated > 0);
    tally
}

struct Judge<'c> {
    label: &'c str,
    case: &'c Case,
    bodies: &'c Bodies<'c>,
    /// The places at every sample that was looked at.
    moments: Vec<Option<Moment>>,
    /// For every window of samples the bounds on the speeds.
    speeds: Vec<Vec<f64>>,
    duration: f64,
    tally: Tally,
}

impl<'c> Judge<'c> {
    fn new(label: &'c str, case: &'c Case, bodies: &'c Bodies<'c>) -> Self {
        let duration = case.plan.duration();
        let samples = (duration * RATE) as usize + 1;
        let time = |sample: usize| sample as f64 / RATE;
        let speeds = (0..samples.div_ceil(WINDOW))
            .map(|window| bodies.speeds(time(window * WINDOW), time((window + 1) * WINDOW).min(duration)));
        Self {
            label,
            case,
            bodies,
            speeds: speeds.collect(),
            moments: (0..samples).map(|_| None).collect(),
            duration,
            tally: Tally::default(),
        }
    }

    fn contradict(&mut self, what: &str) {
        self.tally.contradictions.push(format!("{}: {what}", self.label));
    }

    /// No pair is missing: every link against the cell, links that may not touch against each other, the object
    /// against all.
    fn pairs_are(&mut self, pairs: &[PairCertificate]) {
        let robot = &self.case.robot;
        let is_cell = |body: &str| self.case.cell.bodies.iter().any(|obstacle| obstacle.name == body);
        let parts = &self.bodies.parts;
        let mut expected: BTreeSet<[(&str, usize); 2]> = BTreeSet::new();
        for a in parts {
            for b in parts {
                let ordered = (&a.body, a.index) < (&b.body, b.index);
                if ordered
                    && a.body != b.body
                    && !(is_cell(&a.body) && is_cell(&b.body))
                    && !may_touch(robot, &a.body, &b.body)
                {
                    expected.insert([(a.body.as_str(), a.index), (b.body.as_str(), b.index)]);
                }
            }
        }
        let given = pairs.iter().map(|pair| {
            let mut ends = [(pair.a.as_str(), pair.part_a), (pair.b.as_str(), pair.part_b)];
            ends.sort_unstable();
            ends
        });
        let given: BTreeSet<[(&str, usize); 2]> = given.collect();
        if given != expected || given.len() != pairs.len() {
            let missing: Vec<_> =
                expected.symmetric_difference(&given).map(|pair| format!("{pair:?}")).collect();
            self.contradict(&format!("{} pairs, not {}: {missing:?}", pairs.len(), expected.len()));
        }
    }

    /// The distance that must be kept, m.
    fn required(&self, a: &str, b: &str) -> f64 {
        let is = |x: &str, y: &str| (a == x && b == y) || (a == y && b == x);
        let robot = &self.case.robot;
        let is_cell = |body: &str| self.case.cell.bodies.iter().any(|obstacle| obstacle.name == body);
        let object = self.case.object.as_ref().map_or("", |object| &object.name);
        let hand = &robot.links[robot.dof() - 1].name;
        let rules = &self.case.cell.clearance;
        let fingers = &robot.gripper.fingers;
        if is_cell(b) && a == robot.base.name || is_cell(a) && b == robot.base.name {
            -SUPPORT_OVERLAP
        } else if fingers.iter().any(|finger| is(object, &finger.link.name)) {
            -DEPTH_LIMIT
        } else if let Some(rule) = rules.pairs.iter().find(|rule| is(&rule.a, &rule.b)) {
            rule.required
        } else if is(object, hand) {
            APPROACH_MARGIN
        } else {
            rules.required
        }
    }

    /// The distance at an instant, to [`VAGUE`] or better.
    fn distance_at(&mut self, a: usize, b: usize, moment: &Moment) -> Distance {
        self.distance_above(a, b, moment, f64::INFINITY)
    }

    /// The distance at an instant, less exactly the farther it is above `claimed`.
    fn distance_above(&mut self, a: usize, b: usize, moment: &Moment, claimed: f64) -> Distance {
        let (a, b) = (self.bodies.placed(a, moment), self.bodies.placed(b, moment));
        let known = distance_above(&a, &b, claimed);
        if known.upper > 0.0 && known.lower < claimed && known.upper - known.lower > VAGUE {
            self.tally.vague += 1;
        }
        known
    }

    fn pair(&mut self, pair: &PairCertificate, least: Option<&MarginBounds>) {
        let name = format!("{} {} - {} {}", pair.a, pair.part_a, pair.b, pair.part_b);
        let (Some(a), Some(b)) =
            (self.bodies.part(&pair.a, pair.part_a), self.bodies.part(&pair.b, pair.part_b))
        else {
            return self.contradict(&format!("{name}: there is no such pair"));
        };
        let required = self.required(&pair.a, &pair.b);
        for leaf in &pair.leaves {
            self.leaf(&name, [a, b], leaf, required);
        }
        self.tally.leaves += pair.leaves.len() as u64;
        match &pair.verdict {
            PairVerdict::Free { margin } => {
                self.tally.free += 1;
                self.covers(&name, &pair.leaves);
                let leaf = pair
                    .leaves
                    .iter()
                    .map(|leaf| leaf.gap - leaf.loss - required)
                    .fold(f64::INFINITY, f64::min);
                if leaf < *margin {
                    self.contradict(&format!(
                        "{name}: a leaf shows a margin of {leaf} m, but {margin} m is claimed"
                    ));
                }
            }
            PairVerdict::Violated(violation) => {
                self.tally.violated += 1;
                self.violation(&name, [a, b], violation, required);
            }
            PairVerdict::Unknown(doubt) => {
                self.tally.unknown += 1;
                let [from, to] = doubt.interval;
                let moment = self.bodies.at(0.5 * (from + to));
                let known = self.distance_at(a, b, &moment);
                let [low, high] = doubt.distance;
                if known.upper < low - ROUNDING || known.lower > high + ROUNDING {
                    self.contradict(&format!("{name}: {known:?} is said to be in {:?}", doubt.distance));
                }
            }
            PairVerdict::NotChecked { .. } => self.tally.not_checked += 1,
        }
        // Margins of single pairs are held against the leaves' instants already.
        let free = matches!(pair.verdict, PairVerdict::Free { .. }).then_some(required);
        let least = least.filter(|_| self.counts(a, b)).map(|least| required + least.lower);
        if let Some(claimed) = free.into_iter().chain(least).reduce(f64::max) {
            let what = if free == Some(claimed) { "it is free" } else { "the least margin is known" };
            self.samples(&name, [a, b], claimed, what);
        }
    }

    /// The leaves of a free pair leave no instant out.
    fn covers(&mut self, name: &str, leaves: &[Leaf]) {
        let mut reached = 0.0;
        let mut without_gap = true;
        for leaf in leaves {
            without_gap &= leaf.start <= reached && leaf.end > leaf.start;
            reached = leaf.end;
        }
        if !without_gap || reached < self.duration {
            self.contradict(&format!("{name}: free, but the leaves do not cover the motion"));
        }
    }

    /// At its middle, at its ends and at every sample within, the pair is as far apart as a leaf says.
    fn leaf(&mut self, name: &str, [a, b]: [usize; 2], leaf: &Leaf, required: f64) {
        if leaf.required.to_bits() != required.to_bits() || leaf.gap - leaf.loss < required {
            self.contradict(&format!("{name}: {leaf:?} does not show {required} m"));
        }
        let middle = 0.5 * (leaf.start + leaf.end);
        let quarter = 0.25 * (leaf.end - leaf.start);
        let kept = leaf.gap - leaf.loss;
        let instants = [
            (middle, leaf.gap),
            (leaf.start, kept),
            (leaf.end, kept),
            (middle - quarter, kept),
            (middle + quarter, kept),
        ];
        for (t, claimed) in instants {
            let moment = self.bodies.at(t);
            let known = self.distance_above(a, b, &moment, claimed);
            if known.upper < claimed - ROUNDING {
                self.contradict(&format!("{name}: {} m at {t} s, but {leaf:?}", known.upper));
            }
        }
    }

    /// No sample of a pair is nearer than claimed. Samples that the speed bound shows to be farther are passed over.
    fn samples(&mut self, name: &str, [a, b]: [usize; 2], claimed: f64, what: &str) {
        let bodies = self.bodies;
        let rates: Vec<f64> = self.speeds.iter().map(|speeds| bodies.approach(a, b, speeds)).collect();
        let last = self.moments.len() - 1;
        let mut sample = 0;
        loop {
            let moment = self.moments[sample].take().unwrap_or_else(|| bodies.at(sample as f64 / RATE));
            let known = self.distance_above(a, b, &moment, claimed);
            self.moments[sample] = Some(moment);
            self.tally.looked_at += 1;
            if known.upper < claimed - ROUNDING {
                let t = sample as f64 / RATE;
                return self.contradict(&format!(
                    "{name}: {} m at sample {t} s, but {what}: {claimed} m",
                    known.upper
                ));
            }
            // As far as what is left of the distance lasts at the largest speed of every window on the way.
            let mut left = known.lower - claimed;
            let mut farther = sample;
            while left > 0.0 && farther < last {
                let window = farther / WINDOW;
                let steps = ((window + 1) * WINDOW - farther).min(last - farther);
                let way = rates[window] / RATE;
                if left > way * steps as f64 {
                    left -= way * steps as f64;
                    farther += steps;
                } else {
                    farther += (left / way) as usize;
                    break;
                }
            }
            if farther == last {
                self.tally.excluded += (last - sample) as u64;
                return;
            }
            self.tally.excluded += (farther - sample) as u64;
            sample = farther.max(sample) + 1;
            if sample > last {
                return;
            }
        }
    }

    /// A violation is one: its points lie in the solids, as near as it says, and that is nearer than required.
    fn violation(&mut self, name: &str, [a, b]: [usize; 2], violation: &Violation, required: f64) {
        let moment = self.bodies.at(violation.time);
        let known = self.distance_at(a, b, &moment);
        let said = violation.distance;
        let [on_a, on_b] = violation.points.map(Vector3::from);
        let (a, b) = (self.bodies.placed(a, &moment), self.bodies.placed(b, &moment));
        let (depth_a, depth_b) = (a.depth(&on_a), b.depth(&on_b));
        // A depth is shown with the slack on top, so that one exactly as large as may be is a violation, too.
        let nearer = said < required || (said < 0.0 && depth_a + depth_b > -required);
        let shown = if said >= 0.0 {
            depth_a >= -WITNESS && depth_b >= -WITNESS && ((on_b - on_a).norm() - said).abs() <= WITNESS
        } else {
            depth_a + depth_b >= -said - WITNESS || self.overlaps_by(&a, &b, [on_a, on_b], said)
        };
        let is_one =
            nearer && known.lower <= said + ROUNDING && violation.required.to_bits() == required.to_bits();
        if !(shown && is_one && (0.0..=self.duration).contains(&violation.time)) {
            self.contradict(&format!("{name}: {known:?}, depths {depth_a} and {depth_b}, but {violation:?}"));
        }
    }

    /// The cores are so near, or meet, that with their radii the solids overlap by this much.
    fn overlaps_by(&self, a: &Placed, b: &Placed, [on_a, on_b]: [Vector3<f64>; 2], said: f64) -> bool {
        let Some(back) = (on_a - on_b).try_normalize(0.0) else { return false };
        let (core_a, core_b) = (on_a - back * a.solid.radius, on_b + back * b.solid.radius);
        a.depth(&core_a) >= a.solid.radius - WITNESS
            && b.depth(&core_b) >= b.solid.radius - WITNESS
            && (core_b - core_a).norm() - a.solid.radius - b.solid.radius <= said + WITNESS
    }

    /// The bracket is one, and agrees with the certificate.
    fn least(&mut self, pairs: &[PairCertificate], least: Option<&MarginBounds>) {
        let Some(least) = least else {
            if self.tally.not_checked == 0 {
                self.contradict("all pairs were checked, but there is no least margin");
            }
            return;
        };
        let moment = self.bodies.at(least.time);
        let required = self.required(&least.a, &least.b);
        let parts = |body: &str| -> Vec<usize> {
            let parts = self.bodies.parts.iter().enumerate();
            parts.filter(|(_, part)| part.body == body).map(|(index, _)| index).collect()
        };
        let mut there = f64::INFINITY;
        for a in parts(&least.a) {
            for b in parts(&least.b) {
                there = there.min(self.distance_at(a, b, &moment).lower - required);
            }
        }
        if there > least.upper + ROUNDING
            || least.lower > least.upper
            || least.required.to_bits() != required.to_bits()
        {
            self.contradict(&format!("the least margin is {there} m there, but {least:?}"));
        }
        if least.upper - least.lower <= TOLERANCE {
            self.tally.bracketed += 1;
        } else {
            self.tally.loose += 1;
            // Only the depth of an overlap may stay open.
            if least.upper + least.required > WITNESS {
                self.contradict(&format!("the least margin was not found: {least:?}"));
            }
        }
        let mut free = f64::INFINITY;
        for pair in pairs {
            let [a, b] = [(&pair.a, pair.part_a), (&pair.b, pair.part_b)]
                .map(|(body, index)| self.bodies.part(body, index));
            let (Some(a), Some(b)) = (a, b) else { continue };
            if !self.counts(a, b) {
                continue;
            }
            match &pair.verdict {
                PairVerdict::Free { margin } => free = free.min(*margin),
                PairVerdict::Violated(violation) => {
                    free = f64::NEG_INFINITY;
                    if least.lower > violation.distance - violation.required {
                        self.contradict(&format!("{least:?} is above {violation:?}"));
                    }
                }
                _ => free = f64::NEG_INFINITY,
            }
        }
        if least.upper < free - ROUNDING {
            self.contradict(&format!("every pair keeps a margin of {free} m, but {least:?}"));
        }
    }

    /// Whether the least margin counts the pair: it may not touch, and one of the two moves.
    fn counts(&self, a: usize, b: usize) -> bool {
        let [part_a, part_b] = [a, b].map(|part| &self.bodies.parts[part]);
        let stands = part_a.carrier == Carrier::World && part_b.carrier == Carrier::World;
        self.required(&part_a.body, &part_b.body) >= 0.0 && !stands
    }
}

/// Whether two bodies of the robot may touch at any time.
fn may_touch(robot: &RobotModel, a: &str, b: &str) -> bool {
    let allowed = &robot.allowed_contacts;
    allowed.iter().any(|contact| (contact.a == a && contact.b == b) || (contact.a == b && contact.b == a))
}
