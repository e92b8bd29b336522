//! What must not change a proof does not, and what must change it does so as it must.

use std::collections::BTreeMap;

use graspcheck_model::Pose;
use graspcheck_proof::{MarginBounds, PairVerdict, Scene};
use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;

use crate::trial::{arms::Arm, random::Case, relations};

/// To how much the least margin is brought, m.
const TOLERANCE: f64 = 1e-5;
/// What changed coordinates, or the coefficients of a shifted polynomial, may change a distance by rounding, m.
const ROUNDING: f64 = 1e-9;

/// The proof's search may leave that much of the distance of round bodies, m.
const ROUND_BODIES: f64 = 3e-5;

/// The two solids of a pair, each by body and index, the smaller one first.
type Ends = [(String, usize); 2];

/// What is proved of a case: every pair that is not free, and the least margin of a case that is.
struct Proved {
    not_free: BTreeMap<Ends, &'static str>,
    least: Option<MarginBounds>,
}

fn proved(case: &Case) -> Proved {
    let scene = Scene::new(&case.robot, &case.cell, case.object.as_ref()).expect("a scene");
    let certificate = scene.certify(&case.plan);
    let not_free = certificate.pairs.iter().filter_map(|pair| {
        let verdict = match pair.verdict {
            PairVerdict::Free { .. } => return None,
            PairVerdict::Violated(_) => "violated",
            PairVerdict::Unknown(_) => "unknown",
            PairVerdict::NotChecked { .. } => "not checked",
        };
        let mut ends = [(pair.a.clone(), pair.part_a), (pair.b.clone(), pair.part_b)];
        ends.sort();
        Some((ends, verdict))
    });
    let least = certificate.is_free().then(|| scene.minimum_margin(&case.plan, TOLERANCE).expect("pairs"));
    Proved { not_free: not_free.collect(), least }
}

/// The same verdict of every pair, and brackets of one and the same least margin.
fn assert_same(case: &Case, other: &Case) {
    let (of_case, of_other) = (proved(case), proved(other));
    assert_eq!(of_case.not_free, of_other.not_free);
    if let (Some(least), Some(other)) = (of_case.least, of_other.least) {
        let meet = least.lower <= other.upper + ROUNDING && other.lower <= least.upper + ROUNDING;
        assert!(meet, "{least:?} and {other:?}");
        let narrow = |it: &MarginBounds| it.upper - it.lower <= TOLERANCE + ROUND_BODIES;
        assert!(narrow(&least) && narrow(&other), "{least:?} and {other:?}");
    }
}

/// The arm and number of a case.
fn case() -> impl Strategy<Value = (Arm, u64)> {
    (prop_oneof![Just(Arm::Scara), Just(Arm::Rrr), Just(Arm::Chain)], 0_u64..1_000_000)
}

proptest! {
    // Another number is another case, not a simpler one: there is nothing to shrink.
    #![proptest_config(ProptestConfig { cases: 16, max_shrink_iters: 0, ..ProptestConfig::default() })]

    #[test]
    fn the_place_of_robot_and_cell_together_does_not_matter(
        (arm, seed) in case(), yaw in -3.0_f64..3.0, x in -2.0_f64..2.0, tilt in prop_oneof![Just(0.0), -1.0_f64..1.0],
    ) {
        let turned: Pose = Isometry3::new(Vector3::new(x, -0.3, 0.1), Vector3::new(tilt, 0.5 * tilt, yaw));
        let case = Case::random(arm, seed);
        assert_same(&case, &relations::moved(&case, &turned));
    }

    #[test]
    fn the_mirror_image_is_proved_alike((arm, seed) in case()) {
        let case = Case::random(arm, seed);
        assert_same(&case, &relations::mirrored(&case));
    }

    #[test]
    fn the_order_of_obstacles_and_names_does_not_matter((arm, seed) in case()) {
        let case = Case::random(arm, seed);
        assert_same(&case, &relations::reordered(&case));
    }

    #[test]
    fn a_knot_where_nothing_changes_changes_nothing((arm, seed) in case(), share in 0.001_f64..0.999) {
        let case = Case::random(arm, seed);
        assert_same(&case, &relations::split(&case, share));
    }

    #[test]
    fn the_pace_does_not_matter((arm, seed) in case(), factor in 0.1_f64..10.0) {
        let case = Case::random(arm, seed);
        assert_same(&case, &relations::slowed(&case, factor));
    }

    #[test]
    fn the_way_back_is_as_free_as_the_way((arm, seed) in case()) {
        let case = Case::random(arm, seed);
        assert_same(&case, &relations::reversed(&case));
    }

    #[test]
    fn a_larger_obstacle_takes_what_it_grows((arm, seed) in case(), by in 1e-5_f64..5e-4, which in 0_usize..3) {
        let case = Case::random(arm, seed);
        let Some((larger, most)) = relations::inflated(&case, which, by) else { return Ok(()) };
        let (before, after) = (proved(&case), proved(&larger));
        let name = &case.cell.bodies[which].name;
        for (ends, verdict) in &before.not_free {
            prop_assert_eq!(after.not_free.get(ends), Some(verdict), "what collides still does");
        }
        for ends in after.not_free.keys().filter(|ends| !before.not_free.contains_key(*ends)) {
            prop_assert!(ends.iter().any(|(body, _)| body == name), "{:?} did not change", ends);
        }
        let (Some(before), Some(after)) = (before.least, after.least) else { return Ok(()) };
        prop_assert!(after.lower <= before.upper + ROUNDING, "{before:?}, then {after:?}");
        prop_assert!(after.upper >= before.lower - most * by - ROUNDING, "{before:?}, then {after:?}");
        if before.a == *name || before.b == *name {
            prop_assert!(after.lower <= before.upper - by + ROUNDING, "{before:?}, then {after:?}");
        }
    }
}
