//! Standard magnitudes by object, read from the table for the program QuickSat (`qs.mag`).
//!
//! Mike McCants' intrinsic magnitude is for 1000 km and full phase. Here it is converted to half phase, as
//! Heavens-Above does: 2.5 log10 2 = 0.75 mag. For HST and Envisat, Heavens-Above's magnitudes are 0.7 mag fainter than
//! those of the list. The magnitudes of the list are for the brightest likely aspect; McCants' page on the definitions
//! gives a mean aspect that is 0.7 mag fainter, which Heavens-Above does not apply. Merged lists in circulation add 1.0
//! or 1.5 mag. Rows without a magnitude are skipped. Magnitudes of the list are from -2.0 to 10.0, without 0.0.
//! Placeholders such as 99.9 in other lists are no magnitudes, and are counted.
//!
//! Columns: 1-5 NORAD id, 34-37 magnitude; the rest are names, sizes and radar cross section.

use std::collections::{BTreeMap, BTreeSet};

use super::magnitude::StandardMagnitude;
use crate::error::Error;

/// Offset from full phase to half phase: 2.5 log10 2 mag.
const QUICKSAT_TO_HALF_LIT_MAG: f64 = 0.752_574_989_159_953;

/// Magnitudes in the table that are possible: those of the list, with a margin. A magnitude of exactly 0 is a
/// placeholder.
const POSSIBLE_MAG: std::ops::RangeInclusive<f64> = -5.0..=16.0;

/// Magnitudes at 1000 km and a phase angle of 90°, by NORAD catalogue number.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StandardMagnitudes {
    half_lit: BTreeMap<u32, StandardMagnitude>,
    /// Objects whose magnitude is a placeholder.
    placeholders: Vec<u32>,
}

impl StandardMagnitudes {
    /// Reads a `qs.mag` table; magnitudes are converted to half phase.
    ///
    /// # Errors
    /// No line has a NORAD number and a magnitude.
    pub fn from_qs_mag(text: &str) -> Result<Self, Error> {
        let rows = text.lines().filter_map(|line| {
            let id: u32 = line.get(0..5)?.trim().parse().ok()?;
            let end = line.len().min(37);
            let intrinsic: f64 = line.get(33..end)?.trim().parse().ok()?;
            // The first and the last line are headers (00001 and 99999) that have no number in this column.
            (id > 0 && intrinsic.is_finite()).then_some((id, intrinsic))
        });
        let (possible, placeholders): (Vec<_>, Vec<_>) =
            rows.partition(|(_, intrinsic)| POSSIBLE_MAG.contains(intrinsic) && *intrinsic != 0.0);
        let half_lit: BTreeMap<u32, StandardMagnitude> = possible
            .into_iter()
            .map(|(id, intrinsic)| (id, StandardMagnitude(intrinsic + QUICKSAT_TO_HALF_LIT_MAG)))
            .collect();
        let placeholders: BTreeSet<u32> =
            placeholders.into_iter().map(|(id, _)| id).filter(|id| !half_lit.contains_key(id)).collect();
        let placeholders: Vec<u32> = placeholders.into_iter().collect();
        if half_lit.is_empty() && placeholders.is_empty() {
            return Err(Error::format(format!("none of {} lines is a row of a qs.mag table", text.lines().count()))
                .allowing("a NORAD id in columns 1-5 and a magnitude in columns 34-37"));
        }
        Ok(Self { half_lit, placeholders })
    }

    /// Returns the magnitude at 1000 km and a phase angle of 90°; `None` if the object is not listed.
    pub fn get(&self, norad_id: u32) -> Option<StandardMagnitude> {
        self.half_lit.get(&norad_id).copied()
    }

    /// Returns the objects whose magnitude is a placeholder (0, or outside -5 to 16), and is not used.
    #[doc(hidden)]
    pub fn placeholders(&self) -> &[u32] {
        &self.placeholders
    }

    /// Returns the number of objects.
    pub fn len(&self) -> usize {
        self.half_lit.len()
    }

    /// Returns true for an empty table.
    pub fn is_empty(&self) -> bool {
        self.half_lit.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROWS: &str = "\
00001 d Desig...  Name.......... Mag.  Sz1 Sz2 Sz3 RCS Comments 39732\r
00011   59 1A     Vanguard 2      7.5  0.5 0.0 0.0 .37\r
00127   61 15M    Trans 4A RkDbM                   .35\r
25544   98 67A    ISS            -2.0              348\r
39084   13 8A     Landsat 8                        7.8\r
";

    #[test]
    fn verif_rows_are_read_and_converted_to_half_phase() {
        let table = StandardMagnitudes::from_qs_mag(ROWS).unwrap();
        assert_eq!(table.len(), 2);
        assert!((table.get(11).unwrap().0 - 8.2526).abs() < 1e-4);
        assert!((table.get(25544).unwrap().0 - -1.2474).abs() < 1e-4);
        assert_eq!(table.get(39084), None);
    }

    #[test]
    fn placeholders_are_no_magnitudes() {
        let with = |magnitude: &str| {
            StandardMagnitudes::from_qs_mag(&format!("33333   08 42A    OBJ            {magnitude}\n")).unwrap()
        };
        for text in ["99.9", "98.909", " 0.0", "-99."] {
            let table = with(text);
            assert_eq!((table.get(33333), table.placeholders()), (None, &[33333][..]), "{text}");
        }
        for text in ["10.0", "-0.5", "15.9"] {
            assert!(with(text).get(33333).is_some(), "{text}");
        }
    }

    #[test]
    fn verif_other_text_is_rejected() {
        let error = StandardMagnitudes::from_qs_mag("a,b,c\n1,2,3\n").unwrap_err();
        assert!(error.to_string().starts_with("none of 2 lines is a row of a qs.mag table"), "{error}");
        assert!(error.to_string().contains("qs.mag"));
        assert!(StandardMagnitudes::from_qs_mag("").is_err());
    }
}
