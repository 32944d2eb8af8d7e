//! Errors of the identification of a streak.

use crate::error::{Error, ErrorKind};

/// Both ends are at the same position.
pub(super) fn no_line(separation_arcsec: f64) -> Error {
    let sentence = format!("both ends of the streak are at the same position ({separation_arcsec:.3} arcsec apart)");
    Error::new(ErrorKind::Invalid, sentence).allowing("more than 0.01 arcsec")
}
