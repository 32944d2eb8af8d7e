//! Errors of sites.

use crate::message::Quoted;

/// Errors of sites: invalid coordinates and unknown names.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GeometryError {
    /// A coordinate outside its range.
    #[error("{what} of site {site:?} is {value} {unit}; allowed: {first} to {last} {unit}", site = Quoted::new(.site))]
    CoordinateOutOfRange {
        /// The site's name.
        site: String,
        /// Name of the coordinate.
        what: &'static str,
        /// The number given.
        value: f64,
        /// Unit of the coordinate.
        unit: &'static str,
        /// Smallest number allowed.
        first: f64,
        /// Largest number allowed.
        last: f64,
    },
    /// A site name that is not in the table.
    #[error("unknown site {name:?}: {}", near(nearest), name = Quoted::new(.name))]
    UnknownSite {
        /// Given name.
        name: String,
        /// Similar names in the table, nearest first; empty if there are none.
        nearest: Vec<String>,
    },
    /// A site name that fits several sites far from each other.
    #[error("site name {name:?} fits several sites: {}; specify one of them", sites.join(", "), name = Quoted::new(.name))]
    AmbiguousSite {
        /// Given name.
        name: String,
        /// Names of the sites.
        sites: Vec<String>,
    },
    /// An observatory code that is not in the table.
    #[error(
        "unknown MPC observatory code {code:?}; allowed: the {known} codes of the bundled table, or latitude, longitude and height", code = Quoted::new(.code)
    )]
    UnknownMpcCode {
        /// Given code.
        code: String,
        /// Number of codes in the table.
        known: usize,
    },
}

fn near(names: &[String]) -> String {
    if names.is_empty() {
        "no similar name in the bundled table; specify latitude, longitude and height instead".to_owned()
    } else {
        format!("similar names: {}", names.join(", "))
    }
}
