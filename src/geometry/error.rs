//! What can go wrong with a place on the Earth.

/// Errors of this module.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GeometryError {
    /// A coordinate outside of its range.
    #[error("{what} {value} {unit} of site {site:?} is not between {first} and {last}")]
    CoordinateOutOfRange {
        /// The site's name.
        site: String,
        /// Which coordinate.
        what: &'static str,
        /// The number given.
        value: f64,
        /// Its unit.
        unit: &'static str,
        /// Smallest number allowed.
        first: f64,
        /// Largest number allowed.
        last: f64,
    },
    /// A name that the table does not hold.
    #[error("unknown site {name:?}; {}", near(nearest))]
    UnknownSite {
        /// Requested value.
        name: String,
        /// Names in the table that look like it, nearest first; none where nothing does.
        nearest: Vec<String>,
    },
    /// An observatory code that the table does not hold.
    #[error(
        "unknown MPC observatory code {code:?}; the bundled table knows {known} codes, any other place can be given by latitude, longitude and height"
    )]
    UnknownMpcCode {
        /// Requested value.
        code: String,
        /// How many codes the table knows.
        known: usize,
    },
}

fn near(names: &[String]) -> String {
    if names.is_empty() { "no known name is near it".to_owned() } else { format!("near it: {}", names.join(", ")) }
}
