//! Bad pixels from the companion planes of a frame: masks, variances and errors.

use crate::error::Error;
use crate::images::{CompanionPlane, FrameFile, Header, Plane, PlaneKind};

/// Mask planes of Rubin's pipelines (`MP_` keywords) whose pixels have no valid light. Planes of detected sources,
/// cosmic rays and streaks also mark the streaks that are measured, and are not used.
const BAD_PLANES: [&str; 6] = ["MP_BAD", "MP_SAT", "MP_NO_DATA", "MP_EDGE", "MP_SUSPECT", "MP_UNMASKEDNAN"];

/// Largest fraction of bad pixels of a plane whose meaning is not stated. In a plane with more, 1 may mark good pixels.
const LARGEST_SHARE: f64 = 0.5;

/// Keyword of a mask that states that all values other than 0 mark bad pixels, as in the masks of arrays in memory.
const EXPLICIT: &str = "BADPIX";

/// Sets the bad pixels of a chip to NaN, as its companion planes state them. Returns what was used of each plane, for
/// example "HDU 2 (MASK): 120 bad pixels (MP_BAD, MP_SAT)".
///
/// # Errors
/// A plane that cannot be read.
pub(super) fn remove_bad_pixels(
    file: &FrameFile,
    hdu: usize,
    companions: &[CompanionPlane],
    plane: &mut Plane,
) -> Result<Vec<String>, Error> {
    let mut used = Vec::new();
    for companion in companions.iter().filter(|companion| companion.of == Some(hdu)) {
        let Some(rule) = Rule::from_header(companion.kind, file.header(companion.hdu)?) else { continue };
        let values = file.read_plane(companion.hdu)?;
        let bad: Vec<bool> = values.values().iter().map(|value| rule.is_bad(*value)).collect();
        let count = bad.iter().filter(|is_bad| **is_bad).count();
        let name = format!("HDU {} ({})", companion.hdu, companion.name);
        // A mask with other numbers than 0 and 1 has bits of unknown meaning.
        let is_boolean = || values.values().iter().all(|value| *value == 0.0 || *value == 1.0);
        let is_stated = matches!(rule, Rule::Bits(..) | Rule::NotZero { is_stated: true });
        if matches!(rule, Rule::NotZero { is_stated: false }) && !is_boolean() {
            used.push(format!("{name} is not used: its bits are not described by MP_ keywords"));
        } else if !is_stated && count as f64 > LARGEST_SHARE * bad.len() as f64 {
            used.push(format!("{name} is not used: {count} of {} pixels would be bad", bad.len()));
        } else {
            let pixels = plane.values_mut().iter_mut().zip(bad);
            pixels.filter(|(_, is_bad)| *is_bad).for_each(|(pixel, _)| *pixel = f32::NAN);
            used.push(format!("{name}: {count} bad pixels{}", rule.words()));
        }
    }
    Ok(used)
}

/// Condition for a bad pixel.
enum Rule {
    /// One of these bits is set; with the names of their planes.
    Bits(u32, String),
    /// The value is not 0; `is_stated` if the header states that this marks bad pixels.
    NotZero { is_stated: bool },
    /// The value is not a finite number above 0: a variance, an inverse variance, an error or a weight.
    NotPositive,
}

impl Rule {
    fn from_header(kind: PlaneKind, header: &Header) -> Option<Self> {
        let bit =
            |keyword: &&str| header.integer(keyword).and_then(|bit| u32::try_from(bit).ok()).filter(|bit| *bit < 24);
        match kind {
            PlaneKind::Mask if header.cards().iter().any(|card| card.keyword().starts_with("MP_")) => {
                let planes: Vec<&str> = BAD_PLANES.into_iter().filter(|keyword| bit(keyword).is_some()).collect();
                let bits = planes.iter().filter_map(bit).fold(0, |bits, bit| bits | (1 << bit));
                let planes =
                    if planes.is_empty() { "no MP_ plane of bad pixels".to_owned() } else { planes.join(", ") };
                Some(Self::Bits(bits, planes))
            }
            PlaneKind::Mask => Some(Self::NotZero { is_stated: header.logical(EXPLICIT) == Some(true) }),
            PlaneKind::Variance | PlaneKind::InverseVariance | PlaneKind::Error | PlaneKind::Weight => {
                Some(Self::NotPositive)
            }
            PlaneKind::Other => None,
        }
    }

    fn is_bad(&self, value: f32) -> bool {
        match self {
            // Values of masks are integers below 2²⁴, which are exact in single precision.
            Self::Bits(bits, _) => value > 0.0 && (value as u32 & bits) != 0,
            Self::NotZero { .. } => value != 0.0,
            Self::NotPositive => !value.is_finite() || value <= 0.0,
        }
    }

    fn words(&self) -> String {
        match self {
            Self::Bits(_, planes) => format!(" ({planes})"),
            Self::NotZero { .. } => String::new(),
            Self::NotPositive => " (not a finite number above 0)".to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_bad(kind: PlaneKind, value: f32) -> bool {
        Rule::from_header(kind, &Header::default()).unwrap().is_bad(value)
    }

    #[test]
    fn pixels_without_information_are_bad() {
        for kind in [PlaneKind::Variance, PlaneKind::InverseVariance, PlaneKind::Error, PlaneKind::Weight] {
            for value in [0.0, -1.0, f32::NAN, f32::INFINITY] {
                assert!(is_bad(kind, value), "{kind:?} {value}");
            }
            assert!(!is_bad(kind, 1e-6), "{kind:?}");
        }
    }
}
