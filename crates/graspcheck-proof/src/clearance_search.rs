//! The least margin over courses that are not a plan alone, between certified bounds, and whether all that
//! may touch keeps its depth: best-first branch and bound over pairs and time, as in [`minimum`](crate::minimum),
//! with an object that is known up to a deviation.
//!
//! With the object mounted where it is in the middle of an interval, and a bound δ on how far any of its
//! points is from there at any time of it, `gap - loss - δ - required` bounds the margin of its pairs from
//! below, and `distance + δ - required` that of the middle from above.

use std::{cmp::Ordering, collections::BinaryHeap};

use graspcheck_model::Pose;
use nalgebra::Vector3;

use crate::{
    carried::Carried,
    certificate::ProofOutcome,
    certify::SHORTEST_INTERVAL,
    chain::Carrier,
    contact::{Requirement, Stage},
    displacement::Moment,
    gap::{GAP_SLACK, first_normal, gap, overlap_of_at_least, separation},
    logged_motion::LoggedMotion,
    minimum::{MARGIN_TOLERANCE, MarginBounds},
    scene::{Kind, Scene},
    stretch::{Stretch, middle},
};

/// How near the bounds of the least margin are brought to each other, as a share of it: a third digit decides
/// nothing.
const MARGIN_SHARE: f64 = 0.01;

/// The same for margins so wide that their share would be coarser still, and for the depth of a violation, m.
const COARSE_TOLERANCE: f64 = 1e-3;

/// How many pairs and intervals are looked at before the search gives up undecided: some 0.2 s.
const MOST_LOOKS: usize = 100_000;

/// How many more are looked at once a violation is found, to come near to the worst.
const AFTER_VIOLATION: usize = 3_000;

/// An object that is this near, m, to where the stretch has it mounted is not mounted anew: less than any
/// margin that is worth a look.
const NEAR_ENOUGH: f64 = 1e-5;

/// Nor is one that is farther, but by no more than this share of a margin that is not yet decided.
const SHARE_OF_MARGIN: f64 = 0.1;

/// A stretch of the course, and what is there.
pub(crate) struct Leg<'c> {
    pub(crate) stretch: Stretch<'c>,
    /// The object is mounted where it is in the middle of the stretch, or where the plan has it.
    pub(crate) stage: Stage,
    /// Name of the phase.
    pub(crate) phase: &'c str,
    pub(crate) object: ObjectCourse<'c>,
}

/// How the object moves against what carries it.
pub(crate) enum ObjectCourse<'c> {
    /// There is none.
    Absent,
    /// It stays this near, m, to where it is mounted, and no more is known.
    Within(f64),
    /// Known at any time.
    Logged {
        carrier: Carrier,
        motion: &'c Carried,
        /// Where it is mounted, in the carrier's frame.
        mounted: Pose,
    },
}

/// What is required of a pair on a leg.
#[derive(Clone, Copy)]
struct Demand {
    required: f64,
    /// A pair that may touch or that stands still in the plan has no margin that counts; it only must not be
    /// nearer.
    only_sign: bool,
    /// Not judged on this leg.
    left_out: bool,
    first_joint: usize,
    of_object: bool,
    of_finger: bool,
}

/// What a course is searched for.
pub(crate) struct Question<'q> {
    pub(crate) scene: &'q Scene,
    pub(crate) legs: &'q [Leg<'q>],
    /// What is required, or nothing where the pair is not judged, by what the plan's policy requires.
    pub(crate) demand: fn(&Requirement) -> Option<f64>,
    /// The motion of the fingers, where they may differ from half of the opening.
    pub(crate) fingers: Option<&'q LoggedMotion>,
}

/// What a search over a course found.
#[derive(Clone, Debug, PartialEq)]
pub struct CourseClearance {
    /// Free: every pair that is judged keeps what is required at every instant. Violated: one does not.
    /// Unknown: neither could be shown. Not checked: a distance could not be computed, or there is no pair.
    pub outcome: ProofOutcome,
    /// Bounds of the least margin of pairs that may not touch, or of one that is too deep; none when no pair
    /// counts or a distance could not be computed.
    pub least: Option<MarginBounds>,
    /// What could not be decided, when the outcome is unknown.
    pub doubt: Option<CourseDoubt>,
    /// Pairs of solids that were judged on some stretch.
    pub pairs: usize,
    /// Looks at a pair on an interval.
    pub looks: usize,
}

/// A pair on an interval of time that could not be decided.
#[derive(Clone, Debug, PartialEq)]
pub struct CourseDoubt {
    /// Name of one body.
    pub a: String,
    /// Name of the other.
    pub b: String,
    /// Name of the phase.
    pub phase: String,
    /// From when to when, s.
    pub interval: [f64; 2],
    /// The pair has at least this margin there, m; negative.
    pub margin: f64,
}

/// A pair on an interval, ordered so that the lowest bound is taken first.
#[derive(Clone, Copy)]
struct Candidate {
    lower: f64,
    pair: usize,
    leg: usize,
    start: f64,
    end: f64,
    normal: Vector3<f64>,
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        // Ties are broken by place, so that the search takes the same way everywhere.
        let place = |c: &Self| (c.pair, c.leg);
        other
            .lower
            .total_cmp(&self.lower)
            .then_with(|| place(other).cmp(&place(self)))
            .then_with(|| other.start.total_cmp(&self.start))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Candidate {}

/// The instant with the least upper bound so far.
struct Witness {
    upper: f64,
    time: f64,
    pair: usize,
    leg: usize,
    required: f64,
    points: [Vector3<f64>; 2],
}

struct Search<'q> {
    question: &'q Question<'q>,
    demands: Vec<Demand>,
    heap: BinaryHeap<Candidate>,
    best: Option<Witness>,
    /// The least bound of what needs no further look.
    settled: f64,
    looks: usize,
    /// The first that could not be decided.
    doubt: Option<Candidate>,
}

/// The scene in the middle of an interval.
struct Setting<'m> {
    moment: Moment<'m>,
    stage: &'m Stage,
    /// How far the object may be from where it is mounted, m.
    deviation: f64,
}

impl Question<'_> {
    /// The answer.
    pub(crate) fn answer(&self) -> CourseClearance {
        let nothing = |looks| CourseClearance {
            outcome: ProofOutcome::NotChecked,
            least: None,
            doubt: None,
            pairs: 0,
            looks,
        };
        let mut search = Search {
            question: self,
            demands: self.legs.iter().flat_map(|leg| self.demands(leg)).collect(),
            heap: BinaryHeap::new(),
            best: None,
            settled: f64::INFINITY,
            looks: 0,
            doubt: None,
        };
        let count = self.scene.pairs.len();
        let is_judged =
            |pair: &usize| search.demands.iter().skip(*pair).step_by(count).any(|one| !one.left_out);
        let pairs = (0..count).filter(is_judged).count();
        match search.run() {
            Some(()) if pairs > 0 => search.found(pairs),
            _ => nothing(search.looks),
        }
    }

    fn demands<'d>(&'d self, leg: &'d Leg<'_>) -> impl Iterator<Item = Demand> + 'd {
        self.scene.pairs.iter().map(|pair| {
            let requirement = leg.stage.requirement(self.scene, pair);
            let required = (self.demand)(&requirement);
            let bodies = &self.scene.body_pairs[pair.bodies];
            let kinds = [bodies.a, bodies.b].map(|body| self.scene.bodies[body].kind);
            Demand {
                required: required.unwrap_or(0.0),
                only_sign: requirement.contact.is_some() || requirement.fixed,
                left_out: required.is_none(),
                first_joint: requirement.first_joint,
                of_object: kinds.contains(&Kind::Object),
                of_finger: kinds.iter().any(|kind| matches!(kind, Kind::Finger(_))),
            }
        })
    }
}

impl Search<'_> {
    /// Searches to the end. None when a distance cannot be computed.
    fn run(&mut self) -> Option<()> {
        let question = self.question;
        for (index, leg) in question.legs.iter().enumerate() {
            let mut moment = Moment::new(question.scene, &leg.stage);
            moment.set(&leg.stage, &leg.stretch, leg.stretch.start, leg.stretch.end);
            let mut whole = Setting { moment, stage: &leg.stage, deviation: 0.0 };
            for pair in 0..question.scene.pairs.len() {
                let root = Candidate {
                    lower: f64::NEG_INFINITY,
                    pair,
                    leg: index,
                    start: leg.stretch.start,
                    end: leg.stretch.end,
                    normal: Vector3::zeros(),
                };
                self.look(&root, &mut whole)?;
            }
        }
        let first = question.legs.first()?;
        let moment = Moment::new(question.scene, &first.stage);
        let mut setting = Setting { moment, stage: &first.stage, deviation: 0.0 };
        let mut violated_at = None;
        while let Some(candidate) = self.heap.pop() {
            let upper = self.best.as_ref().map_or(f64::INFINITY, |best| best.upper);
            if upper < 0.0 {
                violated_at.get_or_insert(self.looks);
            }
            let is_decided = candidate.lower >= 0.0 || upper < 0.0;
            let is_enough = candidate.lower >= upper - self.tolerance() && is_decided;
            let most = violated_at.map_or(MOST_LOOKS, |looks: usize| looks + AFTER_VIOLATION);
            if is_enough || self.looks > most {
                self.settle(&candidate);
                break;
            }
            if candidate.end - candidate.start < SHORTEST_INTERVAL {
                self.settle(&candidate);
                continue;
            }
            let leg = &question.legs[candidate.leg];
            let half = middle(candidate.start, candidate.end);
            for [start, end] in [[candidate.start, half], [half, candidate.end]] {
                setting.stage = &leg.stage;
                setting.moment.set(&leg.stage, &leg.stretch, start, end);
                self.look(&Candidate { start, end, ..candidate }, &mut setting)?;
            }
        }
        Some(())
    }

    /// A pair on an interval needs no further look, or gets none.
    fn settle(&mut self, candidate: &Candidate) {
        if candidate.lower < 0.0 {
            self.doubt.get_or_insert(*candidate);
        }
        self.settled = self.settled.min(candidate.lower);
    }

    /// How near the bounds are brought to each other, m.
    fn tolerance(&self) -> f64 {
        match &self.best {
            Some(best) if best.upper >= 0.0 => {
                (MARGIN_SHARE * best.upper).clamp(MARGIN_TOLERANCE, COARSE_TOLERANCE)
            }
            _ => COARSE_TOLERANCE,
        }
    }

    /// Looks at a pair on an interval, in whose middle the moment stands. None when the distance cannot be
    /// computed.
    fn look<'m>(&mut self, at: &Candidate, setting: &mut Setting<'m>) -> Option<()>
    where
        Self: 'm,
    {
        let scene = self.question.scene;
        let leg = &self.question.legs[at.leg];
        let demand = self.demands[at.leg * scene.pairs.len() + at.pair];
        if demand.left_out {
            return Some(());
        }
        setting.deviation = match &leg.object {
            ObjectCourse::Within(deviation) if demand.of_object => *deviation,
            ObjectCourse::Logged { carrier, motion, mounted } if demand.of_object => {
                let deviation = motion.deviation(mounted, at.start, at.end);
                let most = NEAR_ENOUGH.max(0.25 * self.tolerance());
                if deviation > (SHARE_OF_MARGIN * at.lower.abs()).clamp(NEAR_ENOUGH, most) {
                    let pose = motion.pose_at(middle(at.start, at.end));
                    let mut stage = leg.stage.clone();
                    stage.stand_object(scene, scene.object_part?, *carrier, pose);
                    let mut moment = Moment::new(scene, &stage);
                    moment.set(&stage, &leg.stretch, at.start, at.end);
                    let deviation = motion.deviation(&pose, at.start, at.end);
                    return self.judge(at, &demand, &mut Setting { moment, stage: &stage, deviation });
                }
                deviation
            }
            _ => 0.0,
        };
        self.judge(at, &demand, setting)
    }

    /// Bounds the margin of a pair on an interval.
    fn judge(&mut self, at: &Candidate, demand: &Demand, setting: &mut Setting<'_>) -> Option<()> {
        self.looks += 1;
        let Setting { moment, deviation, .. } = setting;
        let pair = self.question.scene.pairs[at.pair];
        let [a, b] = moment.placed(pair);
        // A pair that may touch is looked at only until it is known not to be too deep.
        let enough = match &self.best {
            _ if demand.only_sign => 0.0,
            Some(best) => best.upper - self.tolerance(),
            None => f64::INFINITY,
        };
        let hint = if at.normal == Vector3::zeros() { first_normal(&a, &b) } else { at.normal };
        let by_hint = gap(&a, &b, &hint) - moment.loss(pair, demand.first_joint, &hint, 0.0) - *deviation;
        let by_hint = (by_hint - demand.required).max(at.lower);
        if by_hint >= enough {
            self.settle_good(by_hint, demand);
            return Some(());
        }
        let known = separation(&a, &b, Some(&hint), 0.25 * self.tolerance())?;
        let loss = moment.loss(pair, demand.first_joint, &known.normal, 0.0);
        let lower = (known.lower - loss - *deviation - demand.required).max(by_hint);
        if demand.only_sign && lower >= 0.0 {
            return Some(());
        }
        let (mut upper, mut points) = (known.upper, known.points);
        // The cores overlap: how deep must be shown.
        if known.upper <= GAP_SLACK && known.upper - known.lower > MARGIN_TOLERANCE {
            let depths = [-known.lower - MARGIN_TOLERANCE, -demand.required + *deviation + GAP_SLACK];
            for depth in depths.into_iter().filter(|depth| *depth > 0.0) {
                if let Some(common) = overlap_of_at_least(&a, &b, depth) {
                    (upper, points) = (-depth, [common; 2]);
                    break;
                }
            }
        }
        let time = middle(at.start, at.end);
        let beyond = self.beyond(at, demand, setting, &known.normal);
        let upper = upper + GAP_SLACK + beyond - demand.required;
        let counts = !demand.only_sign || upper < 0.0;
        if counts && self.best.as_ref().is_none_or(|best| upper < best.upper) {
            self.best =
                Some(Witness { upper, time, pair: at.pair, leg: at.leg, required: demand.required, points });
        }
        self.heap.push(Candidate { lower, normal: known.normal, ..*at });
        Some(())
    }

    fn settle_good(&mut self, lower: f64, demand: &Demand) {
        if !demand.only_sign {
            self.settled = self.settled.min(lower);
        }
    }

    /// What must be added to a distance in the middle of an interval for the bound to hold: how far object and
    /// fingers may be from where they are mounted. In a tube, what its lower bound lacks at that instant
    /// instead, so that the search ends when nothing can be gained by a shorter interval.
    fn beyond(
        &self,
        at: &Candidate,
        demand: &Demand,
        setting: &mut Setting<'_>,
        normal: &Vector3<f64>,
    ) -> f64 {
        let time = middle(at.start, at.end);
        let stretch = &self.question.legs[at.leg].stretch;
        if stretch.is_tube() {
            let pair = self.question.scene.pairs[at.pair];
            setting.moment.set(setting.stage, stretch, time, time);
            setting.moment.placed(pair);
            return -setting.deviation - setting.moment.loss(pair, demand.first_joint, normal, 0.0);
        }
        let fingers = self.question.fingers.filter(|_| demand.of_finger);
        setting.deviation + fingers.map_or(0.0, |motion| motion.asymmetry(time))
    }

    fn found(self, pairs: usize) -> CourseClearance {
        let question = self.question;
        let names = |pair: usize| {
            let bodies = &question.scene.body_pairs[question.scene.pairs[pair].bodies];
            [bodies.a, bodies.b].map(|body| question.scene.bodies[body].name.clone())
        };
        let outcome = match (&self.best, &self.doubt) {
            (Some(best), _) if best.upper < 0.0 => ProofOutcome::Violated,
            (_, Some(_)) => ProofOutcome::Unknown,
            _ => ProofOutcome::Free,
        };
        let doubt = self.doubt.filter(|_| outcome == ProofOutcome::Unknown).map(|candidate| {
            let [a, b] = names(candidate.pair);
            let phase = question.legs[candidate.leg].phase;
            let (interval, margin) = ([candidate.start, candidate.end], candidate.lower);
            CourseDoubt { a, b, phase: phase.to_owned(), interval, margin }
        });
        let settled = self.settled;
        let least = self.best.map(|best| {
            let [a, b] = names(best.pair);
            MarginBounds {
                lower: settled.min(best.upper),
                upper: best.upper,
                time: best.time,
                a,
                b,
                required: best.required,
                phase: question.legs[best.leg].phase.to_owned(),
                points: best.points.map(Into::into),
            }
        });
        CourseClearance { outcome, least, doubt, pairs, looks: self.looks }
    }
}
