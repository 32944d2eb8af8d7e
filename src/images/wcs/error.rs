//! Errors of world coordinates.

/// Errors of world coordinates in a header.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WcsError {
    /// No axes of right ascension and declination.
    #[error(
        "no world coordinates: CTYPE1 is {ctype1:?} and CTYPE2 is {ctype2:?}; expected one RA---xxx and one DEC--xxx"
    )]
    NoCelestialAxes {
        /// Text of CTYPE1, empty if it is missing.
        ctype1: String,
        /// Text of CTYPE2.
        ctype2: String,
    },
    /// Unsupported projection.
    #[error("unsupported projection {code:?} of {keyword}; allowed: {}", super::header_terms::KNOWN_PROJECTIONS)]
    Projection {
        /// Keyword of the projection.
        keyword: String,
        /// The code.
        code: String,
    },
    /// A required keyword is missing.
    #[error("missing keyword {keyword} of the world coordinates")]
    Missing {
        /// Name of the keyword.
        keyword: String,
    },
    /// A keyword has an invalid value.
    #[error("{keyword} is {value}; allowed: {allowed}")]
    Value {
        /// The keyword.
        keyword: String,
        /// Given value.
        value: String,
        /// Allowed values.
        allowed: &'static str,
    },
    /// A matrix that maps the frame onto a line or a point.
    #[error("the matrix of pixels to degrees [[{}, {}], [{}, {}]] has no inverse (CDi_j, or PCi_j with CDELTi)", .0[0][0], .0[0][1], .0[1][0], .0[1][1])]
    Singular(
        /// The matrix, degrees a pixel.
        [[f64; 2]; 2],
    ),
    /// Unsupported reference system.
    #[error(
        "unsupported reference system {system}; allowed: ICRS, or FK5 of equinox 2000, which is taken as ICRS (they differ by 0.02 arcsec)"
    )]
    ReferenceSystem {
        /// RADESYS and EQUINOX of the header.
        system: String,
    },
    /// A distortion that folds the frame over itself.
    #[error(
        "the distortion ({kind}) folds the frame over itself: several pixels would have the same position on the sky"
    )]
    Folded {
        /// SIP, TPV, TNX, ZPX.
        kind: &'static str,
    },
}
