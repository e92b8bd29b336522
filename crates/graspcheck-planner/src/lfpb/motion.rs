//! Several coordinates that move by linear functions with parabolic blends at the same time.

use graspcheck_motion::{Polynomial, Trajectory, TrajectoryError};

use super::Lfpb;

/// Instants of different coordinates that differ by no more than this share of the motion are one.
///
/// The reason: where two coordinates change piece together, rounding leaves up to some 1e-15 between them.
const SAME_INSTANT: f64 = 1e-12;

/// The common motion of several coordinates, each with points and blends of its own.
///
/// A coordinate rests at its first position until its own motion begins, and at its last one after its own
/// end: with [`BlendEnds::Centred`](super::BlendEnds::Centred) both depend on its blends.
///
/// ```
/// use graspcheck_planner::lfpb::{Blend, BlendEnds, Lfpb, LfpbMotion, LfpbPoint};
///
/// // x and y of a wrist in m, through four points with blends of 0.5 s.
/// let coordinate = |positions: [f64; 4]| {
///     let point = |(t, q)| LfpbPoint::near(t, q, Blend::Duration(0.5));
///     let points: Vec<_> = [0.0, 2.0, 4.0, 7.0].into_iter().zip(positions).map(point).collect();
///     Lfpb::new(&points, BlendEnds::Inside)
/// };
/// let motion = LfpbMotion::new(vec![coordinate([-4.0, 0.0, 3.0, 4.0])?, coordinate([0.0, 3.0, 3.0, 0.0])?])?;
/// // Seven pieces, with a step of acceleration between each two.
/// assert_eq!((motion.trajectory().piece_count(), motion.trajectory().breaks().len()), (7, 6));
/// // The second point, (0, 3), is missed by (-11/224, -3/28) m.
/// let miss = motion.misses(1);
/// assert!((miss[0] + 11.0 / 224.0).abs() < 1e-12 && (miss[1] + 3.0 / 28.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct LfpbMotion {
    coordinates: Vec<Lfpb>,
    start: f64,
    trajectory: Trajectory,
}

impl LfpbMotion {
    /// The motion of these coordinates. It begins with the first that begins.
    ///
    /// # Errors
    /// When there is no coordinate.
    pub fn new(coordinates: Vec<Lfpb>) -> Result<Self, TrajectoryError> {
        let start = coordinates.iter().map(Lfpb::start).fold(f64::INFINITY, f64::min);
        let end = coordinates.iter().map(Lfpb::end).fold(f64::NEG_INFINITY, f64::max);
        let mut instants: Vec<f64> = coordinates
            .iter()
            .flat_map(|coordinate| {
                coordinate.pieces().iter().map(|(start, _)| *start).chain([coordinate.end()])
            })
            .filter(|t| t - start > SAME_INSTANT * (end - start) && end - t > SAME_INSTANT * (end - start))
            .chain([start, end])
            .collect();
        instants.sort_by(f64::total_cmp);
        instants.dedup_by(|later, kept| *later - *kept <= SAME_INSTANT * (end - start));
        let mut pieces = Vec::with_capacity((instants.len() - 1) * coordinates.len());
        for pair in instants.windows(2) {
            let middle = 0.5 * (pair[0] + pair[1]);
            pieces.extend(coordinates.iter().map(|coordinate| piece_at(coordinate, middle, pair[0])));
        }
        let knots = instants.iter().map(|t| t - start).collect();
        let trajectory = Trajectory::new(coordinates.len(), knots, pieces)?;
        Ok(Self { coordinates, start, trajectory })
    }

    /// The coordinates in the order in which they were given.
    #[must_use]
    pub fn coordinates(&self) -> &[Lfpb] {
        &self.coordinates
    }

    /// The time of the points at which the trajectory has its time 0, s.
    #[must_use]
    pub fn start(&self) -> f64 {
        self.start
    }

    /// The motion of all coordinates; each step of acceleration is a break that it declares.
    #[must_use]
    pub fn trajectory(&self) -> &Trajectory {
        &self.trajectory
    }

    /// How far each coordinate is from this point (counted from 0) at the point's time: position minus point.
    ///
    /// # Panics
    /// When there is no such point.
    #[must_use]
    pub fn misses(&self, point: usize) -> Vec<f64> {
        self.coordinates.iter().map(|coordinate| coordinate.misses()[point]).collect()
    }
}

/// The polynomial of a coordinate at the time `inside`, in the local time that is 0 at `from`.
fn piece_at(coordinate: &Lfpb, inside: f64, from: f64) -> Polynomial {
    let pieces = coordinate.pieces();
    if inside >= coordinate.end() {
        return Polynomial::constant(coordinate.eval(coordinate.end())[0]);
    }
    match pieces.partition_point(|(start, _)| *start <= inside) {
        0 => Polynomial::constant(coordinate.eval(coordinate.start())[0]),
        next => {
            let (start, polynomial) = pieces[next - 1];
            polynomial.shifted(from - start)
        }
    }
}
