//! Why a header gives no places on the sky.

/// A header whose pixels cannot be placed on the sky.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WcsError {
    /// No axis with right ascension and declination.
    #[error(
        "no world coordinates: CTYPE1 is {ctype1:?} and CTYPE2 {ctype2:?}; one RA---xxx and one DEC--xxx are needed"
    )]
    NoCelestialAxes {
        /// Text of CTYPE1, empty where it is missing.
        ctype1: String,
        /// Text of CTYPE2.
        ctype2: String,
    },
    /// A projection that is not read.
    #[error("projection {code:?} of {keyword} is not read; known are {}", super::header_terms::KNOWN_PROJECTIONS)]
    Projection {
        /// Its keyword.
        keyword: String,
        /// The code.
        code: String,
    },
    /// A keyword that must be there.
    #[error("world coordinates without {keyword}")]
    Missing {
        /// Its name.
        keyword: String,
    },
    /// A value that makes no sense.
    #[error("{keyword} is {value}: {allowed}")]
    Value {
        /// The keyword.
        keyword: String,
        /// What stands there.
        value: String,
        /// What may stand there.
        allowed: &'static str,
    },
    /// A matrix that maps the frame onto a line or a point.
    #[error("the matrix of pixels to degrees [[{}, {}], [{}, {}]] has no inverse (CDi_j, or PCi_j with CDELTi)", .0[0][0], .0[0][1], .0[1][0], .0[1][1])]
    Singular(
        /// The matrix, degrees a pixel.
        [[f64; 2]; 2],
    ),
    /// Axes of the sky that are not those of ICRS.
    #[error(
        "places in {system} are not read: ICRS is needed, or FK5 of equinox 2000, which is taken as ICRS (they differ by 0.02 arcsec)"
    )]
    ReferenceSystem {
        /// What the header says: RADESYS and EQUINOX.
        system: String,
    },
    /// A distortion that folds the frame over itself.
    #[error("the distortion ({kind}) folds the frame over itself: its coefficients are no map of pixels to the sky")]
    Folded {
        /// SIP, TPV, TNX, ZPX.
        kind: &'static str,
    },
}
