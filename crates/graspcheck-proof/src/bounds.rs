//! Boxes along the axes of the world.

use nalgebra::Vector3;

use crate::solid::Placed;

/// A box along the axes of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    /// The least coordinates, m.
    pub(crate) low: Vector3<f64>,
    /// The largest coordinates, m.
    pub(crate) high: Vector3<f64>,
}

impl Bounds {
    /// The smallest box around a solid where it stands.
    pub(crate) fn of(solid: &Placed) -> Self {
        let reach = |axis: usize, sign: f64| {
            let mut n = Vector3::zeros();
            n[axis] = sign;
            sign * solid.reach(&n)
        };
        let center = solid.place.center;
        Self {
            low: Vector3::from_fn(|axis, _| center[axis] + reach(axis, -1.0)),
            high: Vector3::from_fn(|axis, _| center[axis] + reach(axis, 1.0)),
        }
    }

    /// The smallest box around both.
    pub(crate) fn joined(&self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    /// How far apart the boxes are, m; 0 when they touch or overlap. NaN where a number is.
    pub(crate) fn distance(&self, other: &Self) -> f64 {
        let apart = |axis: usize| {
            let (before, after) = (other.low[axis] - self.high[axis], self.low[axis] - other.high[axis]);
            let apart = if before > after { before } else { after };
            // A NaN stays one.
            if apart < 0.0 { 0.0 } else { apart }
        };
        (apart(0).powi(2) + apart(1).powi(2) + apart(2).powi(2)).sqrt()
    }

    /// The lengths of the edges, m.
    pub(crate) fn extent(&self) -> Vector3<f64> {
        self.high - self.low
    }
}

#[cfg(test)]
mod tests {
    use graspcheck_model::Pose;

    use super::*;
    use crate::solid::{Core, Place, Solid};

    #[test]
    fn a_turned_box_is_bounded_by_its_corners() {
        let solid = Solid::new(Core::Box { half_extents: Vector3::new(0.3, 0.1, 0.2) }, 0.01);
        let place = Place::from(&Pose::new(Vector3::new(1.0, 2.0, 3.0), Vector3::z() * 0.5));
        let bounds = Bounds::of(&Placed { solid: &solid, place });
        let (sin, cos) = 0.5_f64.sin_cos();
        let half = Vector3::new(0.3 * cos + 0.1 * sin, 0.3 * sin + 0.1 * cos, 0.2).add_scalar(0.01);
        assert!((bounds.low - (place.center - half)).norm() < 1e-15, "{bounds:?}");
        assert!((bounds.high - (place.center + half)).norm() < 1e-15, "{bounds:?}");
    }

    #[test]
    fn distances_are_those_of_the_nearest_corners_and_nan_is_kept() {
        let cube = |x: f64, y: f64, z: f64| {
            let low = Vector3::new(x, y, z);
            Bounds { low, high: low.add_scalar(1.0) }
        };
        let at_origin = cube(0.0, 0.0, 0.0);
        for (other, expected) in [
            (cube(4.0, 0.5, -0.5), 3.0),
            (cube(4.0, -5.0, 0.0), 5.0),
            (cube(3.0, 3.0, 2.0), 3.0),
            (cube(0.5, 0.5, 0.5), 0.0),
        ] {
            assert!((at_origin.distance(&other) - expected).abs() < 1e-15, "{other:?}");
            assert!((other.distance(&at_origin) - expected).abs() < 1e-15, "{other:?}");
        }
        assert!(at_origin.distance(&cube(f64::NAN, 5.0, 5.0)).is_nan());
    }
}
