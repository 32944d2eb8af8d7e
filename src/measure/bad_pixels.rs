//! Bad pixels and noise from the companion planes of a frame: masks, variances and errors.

use super::background::Background;
use super::noise::AGREEMENT;
use crate::error::Error;
use crate::images::{CompanionPlane, FrameFile, Header, Plane, PlaneKind};
use crate::math::quantile::median;

/// Mask planes of Rubin's pipelines (`MP_` keywords) whose pixels have no valid light. Planes of detected sources,
/// cosmic rays and streaks also mark the streaks that are measured, and are not used.
const BAD_PLANES: [&str; 6] = ["MP_BAD", "MP_SAT", "MP_NO_DATA", "MP_EDGE", "MP_SUSPECT", "MP_UNMASKEDNAN"];

/// Largest fraction of bad pixels of a mask whose meaning is not stated. In a mask with more, 1 may mark good pixels.
const LARGEST_SHARE: f64 = 0.5;

/// Keyword of a mask that states that all values other than 0 mark bad pixels, as in the masks of arrays in memory.
const EXPLICIT: &str = "BADPIX";

/// Rows of a plane that are read at once.
const ROWS: usize = 256;
/// Distance of the pixels whose noise is compared with the scatter of the sky, along rows and columns.
const NOISE_STEP: usize = 7;
/// Largest ratio of the noise of a plane to the scatter of the sky that the correlation of pixels explains, as in
/// resampled frames.
const MOST_CORRELATION: f64 = 3.0;

/// What the companion planes of a chip state.
#[derive(Debug, Default)]
pub(super) struct StatedPixels {
    /// What was used of each plane, for example "HDU 2 (MASK): 120 bad pixels (MP_BAD, MP_SAT)".
    pub used: Vec<String>,
    /// Noise of the first plane that states it.
    pub noise: Option<StatedNoise>,
}

/// Noise of pixels by a variance, an inverse variance or an error.
#[derive(Debug)]
pub(super) struct StatedNoise {
    /// Index of the plane in `used`.
    pub plane: usize,
    /// Row, column and noise (one sigma) of some good pixels.
    pub pixels: Vec<(usize, usize, f32)>,
}

/// Sets the bad pixels of a chip to NaN, as its companion planes state them, and returns what was used of the planes.
///
/// # Errors
/// A plane that cannot be read.
pub(super) fn remove_bad_pixels(
    file: &FrameFile,
    hdu: usize,
    companions: &[CompanionPlane],
    plane: &mut Plane,
) -> Result<StatedPixels, Error> {
    let mut stated = StatedPixels::default();
    for companion in companions.iter().filter(|companion| companion.of == Some(hdu)) {
        // The primary HDU of a compressed file is empty.
        let headers = [file.header(companion.hdu)?, file.header(hdu)?, file.header(0)?];
        let Some(rule) = Rule::from_headers(companion, &headers) else { continue };
        let [rows, columns] = file.image_size(companion.hdu)?;
        let (mut bad, mut is_boolean, mut pixels) = (Vec::with_capacity(rows * columns), true, Vec::new());
        for first in (0..rows).step_by(ROWS) {
            for value in file.read_rows(companion.hdu, first..(first + ROWS).min(rows))? {
                let (row, column) = (bad.len() / columns, bad.len() % columns);
                let is_bad = rule.is_bad(value);
                bad.push(is_bad);
                is_boolean &= value == 0.0 || value == 1.0;
                if !is_bad && row % NOISE_STEP == 0 && column % NOISE_STEP == 0 {
                    pixels.extend(noise(companion.kind, value).map(|sigma| (row, column, sigma)));
                }
            }
        }
        let count = bad.iter().filter(|is_bad| **is_bad).count();
        let name = format!("HDU {} ({})", companion.hdu, companion.name);
        // A mask with other numbers than 0 and 1 has bits of unknown meaning. In other planes only good pixels have
        // values.
        let (is_unclear, most) = match rule {
            Rule::Bits(..) | Rule::NotZero { is_stated: true } => (false, 1.0),
            Rule::NotZero { is_stated: false } => (!is_boolean, LARGEST_SHARE),
            Rule::NotPositive => (false, (bad.len() - 1) as f64 / bad.len() as f64),
        };
        if is_unclear {
            stated.used.push(format!(
                "{name} is not used: its bits are described neither by MP_ keywords nor by TELESCOP and INSTRUME of an \
                 instrument whose bits are known ({})",
                KNOWN_BITS.map(|known| known.name).join(", ")
            ));
        } else if count as f64 > most * bad.len() as f64 {
            stated.used.push(format!("{name} is not used: {count} of {} pixels would be bad", bad.len()));
        } else {
            let all = plane.values_mut().iter_mut().zip(bad);
            all.filter(|(_, is_bad)| *is_bad).for_each(|(pixel, _)| *pixel = f32::NAN);
            if stated.noise.is_none() && !pixels.is_empty() {
                stated.noise = Some(StatedNoise { plane: stated.used.len(), pixels });
            }
            stated.used.push(format!("{name}: {count} bad pixels{}", rule.words()));
        }
    }
    Ok(stated)
}

/// Compares the noise that a plane states with the scatter of the sky, sets the ratio if it can be used, and returns a
/// sentence about it; `None` without pixels that have a sky.
///
/// Noise in another unit differs by any factor. In resampled frames the pixels scatter by less than their noise,
/// because neighbouring ones are correlated: the control fits include this, and where there is no space for them the
/// plane is the better measure.
pub(super) fn compare_noise(stated: &StatedNoise, background: &mut Background) -> Option<String> {
    let ratios = stated.pixels.iter();
    let ratios: Vec<f64> =
        ratios.filter_map(|(row, column, sigma)| Some(f64::from(*sigma) / background.noise(*row, *column)?)).collect();
    if ratios.is_empty() {
        return None;
    }
    let ratio = median(ratios);
    let is_used = (AGREEMENT.recip()..=MOST_CORRELATION).contains(&ratio);
    background.stated_ratio = is_used.then_some(ratio);
    Some(if !is_used {
        format!("its noise is {ratio:.2} times the scatter of the sky and is not used: that of the sky is")
    } else if ratio > AGREEMENT {
        format!(
            "its noise is {ratio:.2} times the scatter of the sky, which resampled pixels have: it is used for streaks \
             without space for fits beside them, otherwise the scatter of these fits"
        )
    } else {
        "its noise is a lower limit of the errors".to_owned()
    })
}

/// Returns the noise (one sigma) that a plane states with a value above 0; `None` for planes without noise.
fn noise(kind: PlaneKind, value: f64) -> Option<f32> {
    match kind {
        PlaneKind::Variance => Some(value.sqrt() as f32),
        PlaneKind::InverseVariance => Some(value.sqrt().recip() as f32),
        PlaneKind::Error => Some(value as f32),
        PlaneKind::Mask | PlaneKind::Weight | PlaneKind::Other => None,
    }
}

/// Instrument with the bits of its masks that mark pixels without valid light.
#[derive(Copy, Clone)]
struct KnownBits {
    name: &'static str,
    /// TELESCOP; empty for any.
    telescope: &'static str,
    /// Beginning of INSTRUME; empty for any.
    instrument: &'static str,
    /// Part of the name of the plane.
    plane: &'static str,
    bits: u64,
    words: &'static str,
}

/// Bits of cosmic rays, streaks and detected sources, and of pixels with a valid calibration, are left out.
const KNOWN_BITS: [KnownBits; 5] = {
    // ACS Data Handbook (2022), table 3.4; WFC3 Data Handbook (2024), table 3.3: decoding error, filled, bad, hot, bad
    // in bias or reference, full well, bad in flat or blob. 2048 is saturation of the converter in ACS and WFC3/UVIS,
    // and valid light in WFC3/IR; saturated pixels have 256 too.
    const HST: u64 = 1 | 2 | 4 | 16 | 128 | 256 | 512;
    const HST_WORDS: &str = "bits 1, 2, 4, 16, 128, 256, 512";
    [
        KnownBits { name: "HST ACS", telescope: "HST", instrument: "ACS", plane: "DQ", bits: HST, words: HST_WORDS },
        KnownBits { name: "HST WFC3", telescope: "HST", instrument: "WFC3", plane: "DQ", bits: HST, words: HST_WORDS },
        // jwst.datamodels.dqflags
        KnownBits {
            name: "JWST",
            telescope: "JWST",
            instrument: "",
            plane: "DQ",
            bits: 1 | 2,
            words: "DO_NOT_USE, SATURATED",
        },
        // Morganson et al. (2018, PASP 130, 074501), table 9
        KnownBits {
            name: "DES",
            telescope: "",
            instrument: "DECAM",
            plane: "MSK",
            bits: 1 | 2 | 8 | 64 | 128 | 512 | 2048,
            words: "BPM, SATURATE, BADAMP, TRAIL, EDGEBLEED, EDGE, SUSPECT",
        },
        // ZTF Science Data System explanatory supplement, section 10.3
        KnownBits {
            name: "ZTF",
            telescope: "",
            instrument: "ZTF",
            plane: "",
            bits: 1 << 2 | 1 << 3 | 1 << 4 | 1 << 8 | 1 << 9 | 1 << 10,
            words: "low and high response, noisy, saturated, dead, no value",
        },
    ]
};

/// Condition for a bad pixel.
enum Rule {
    /// One of these bits is set; with their names.
    Bits(u64, String),
    /// The value is not 0; `is_stated` if the header states that this marks bad pixels.
    NotZero { is_stated: bool },
    /// The value is not a finite number above 0: a variance, an inverse variance, an error or a weight.
    NotPositive,
}

impl Rule {
    /// Returns the rule of a plane with these headers: its own, that of the chip, and that of the file.
    fn from_headers(plane: &CompanionPlane, headers: &[&Header]) -> Option<Self> {
        let own = headers[0];
        let bit = |keyword: &&str| own.integer(keyword).and_then(|bit| u32::try_from(bit).ok()).filter(|bit| *bit < 53);
        let text = |keyword: &str| {
            headers.iter().find_map(|header| header.text(keyword)).unwrap_or_default().to_ascii_uppercase()
        };
        let is_known = |known: &KnownBits| {
            (known.telescope.is_empty() || text("TELESCOP") == known.telescope)
                && text("INSTRUME").starts_with(known.instrument)
                && plane.name.contains(known.plane)
        };
        match plane.kind {
            PlaneKind::Mask if own.cards().iter().any(|card| card.keyword().starts_with("MP_")) => {
                let planes: Vec<&str> = BAD_PLANES.into_iter().filter(|keyword| bit(keyword).is_some()).collect();
                let bits = planes.iter().filter_map(bit).fold(0, |bits, bit| bits | (1 << bit));
                let planes =
                    if planes.is_empty() { "no MP_ plane of bad pixels".to_owned() } else { planes.join(", ") };
                Some(Self::Bits(bits, planes))
            }
            PlaneKind::Mask if own.logical(EXPLICIT) == Some(true) => Some(Self::NotZero { is_stated: true }),
            PlaneKind::Mask => Some(match KNOWN_BITS.iter().find(|known| is_known(known)) {
                Some(known) => Self::Bits(known.bits, format!("{}: {}", known.name, known.words)),
                None => Self::NotZero { is_stated: false },
            }),
            PlaneKind::Variance | PlaneKind::InverseVariance | PlaneKind::Error | PlaneKind::Weight => {
                Some(Self::NotPositive)
            }
            PlaneKind::Other => None,
        }
    }

    fn is_bad(&self, value: f64) -> bool {
        match self {
            // Values of masks are integers below 2⁵³, which are exact in double precision.
            Self::Bits(bits, _) => value > 0.0 && (value as u64 & bits) != 0,
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

    fn rule(name: &str, kind: PlaneKind, cards: &str) -> Rule {
        let plane = CompanionPlane { hdu: 1, name: name.to_owned(), of: Some(0), kind, card: None };
        Rule::from_headers(&plane, &[&Header::default(), &Header::from_text(cards)]).unwrap()
    }

    #[test]
    fn pixels_without_information_are_bad() {
        for kind in [PlaneKind::Variance, PlaneKind::InverseVariance, PlaneKind::Error, PlaneKind::Weight] {
            let rule = rule("A", kind, "");
            for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
                assert!(rule.is_bad(value), "{kind:?} {value}");
            }
            assert!(!rule.is_bad(1e-6), "{kind:?}");
        }
    }

    #[test]
    fn bits_of_known_instruments() {
        for (name, cards, bad, good) in [
            ("DQ", "TELESCOP= 'HST'\nINSTRUME= 'WFC3'\n", 16u64 | 8192, 64u64 | 8192 | 16384),
            ("DQ", "TELESCOP= 'HST     '\nINSTRUME= 'ACS'\n", 256, 32 | 4096),
            // REFERENCE_PIXEL, 2³¹, with DO_NOT_USE and with JUMP_DET.
            ("DQ", "TELESCOP= 'JWST'\n", 1 | 1 << 31, 4 | 1 << 31),
            ("MSK", "INSTRUME= 'DECam'\n", 512, 16 | 1024),
            ("MASK", "INSTRUME= 'ZTF/MOSAIC'\n", 1 << 8, 1 | 2),
        ] {
            let rule = rule(name, PlaneKind::Mask, cards);
            assert!(rule.is_bad(bad as f64) && !rule.is_bad(good as f64), "{cards}");
        }
        for cards in ["", "TELESCOP= 'HST'\nINSTRUME= 'WFPC2'\n", "INSTRUME= 'DECam'\n"] {
            assert!(matches!(rule("DQ", PlaneKind::Mask, cards), Rule::NotZero { is_stated: false }), "{cards}");
        }
    }
}
