//! What can be wrong with a solid or its mass properties.

/// What can be wrong with a solid or its mass properties.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// The mass is not positive and finite.
    #[error("mass {mass} kg must be positive")]
    Mass {
        /// The mass, kg.
        mass: f64,
    },
    /// A number is NaN or infinite.
    #[error("a number is not finite")]
    NotFinite,
    /// The inertia tensor differs from its transpose.
    #[error("inertia tensor: entries across the diagonal differ by {difference:.3e} kg·m²")]
    TensorNotSymmetric {
        /// The largest difference, kg·m².
        difference: f64,
    },
    /// A principal moment is zero or negative.
    #[error("inertia tensor: principal moment {moment:.3e} kg·m² must be positive")]
    TensorNotPositive {
        /// The least principal moment, kg·m².
        moment: f64,
    },
    /// A principal moment exceeds the sum of the others, which no distribution of mass can give.
    #[error(
        "inertia tensor: principal moment {largest:.3e} kg·m² exceeds the sum {sum:.3e} kg·m² of the two others"
    )]
    TensorTriangle {
        /// The largest principal moment, kg·m².
        largest: f64,
        /// The sum of the two others, kg·m².
        sum: f64,
    },
    /// A dimension of a solid is not positive and finite.
    #[error("{what} {value} m must be positive")]
    Dimension {
        /// Which dimension.
        what: &'static str,
        /// Its value, m.
        value: f64,
    },
    /// The points span no solid.
    #[error("{count} points span no solid: they lie within {thickness:.3e} m of a plane, a line or a point")]
    FlatHull {
        /// How many points there are.
        count: usize,
        /// How thick the set is in its thinnest direction found, m.
        thickness: f64,
    },
}
