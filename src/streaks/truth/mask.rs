//! Masks of streaks: runs of pixels, and the bit planes that mark them.

use std::collections::BTreeMap;

use super::super::drawn::DrawnStreak;
use super::noise_map::NoiseMap;
use crate::error::Error;
use crate::images::AddedLight;

/// Fraction of the brightest pixel of a streak below which light is not marked as injected, because it is too faint to
/// be measured.
const FAINTEST_SHARE: f32 = 1e-4;

/// Fraction of the brightest pixel of a streak above which pixels of a frame without noise are marked as streak.
pub(in crate::streaks) const SHARE_WITHOUT_NOISE: f32 = 0.1;

/// Run of adjacent pixels in one row of a mask.
#[derive(Clone, Debug, PartialEq)]
pub struct MaskSpan {
    /// Row, counted from 0.
    pub row: usize,
    /// Column of the first pixel, counted from 0.
    pub first_column: usize,
    /// Mask values of the first pixel and of those to its right.
    pub values: Vec<i32>,
}

/// Returns the mask of a chip as runs of pixels, in the order of rows and columns. Pixels outside the runs are 0.
///
/// `INJECTED` marks pixels with more than 10⁻⁴ of the light of a streak's brightest pixel. `STREAK` and `INJECTED` mark
/// pixels in which the light of all streaks together exceeds `noise`, the standard deviation of the frame's pixels near
/// them. In a frame without noise they mark pixels above a tenth of a streak's brightest pixel.
pub fn mask_spans(
    streaks: &[&DrawnStreak<'_>],
    columns: usize,
    planes: &MaskPlanes,
    noise: &NoiseMap,
) -> Vec<MaskSpan> {
    let is_noisy = noise.is_noisy();
    let peaks: Vec<f32> = streaks
        .iter()
        .map(|streak| streak.patch.iter().flat_map(|span| span.values.iter().copied()).fold(0.0, f32::max))
        .collect();
    let rows = streaks.iter().flat_map(|streak| streak.patch.iter().map(|span| span.row));
    let mut rows: Vec<usize> = rows.collect();
    rows.sort_unstable();
    rows.dedup();
    let mut light = vec![0.0f32; columns];
    let mut values = vec![0i32; columns];
    rows.into_iter()
        .flat_map(|row| {
            let (mut first, mut end) = (columns, 0);
            for (streak, &peak) in streaks.iter().zip(&peaks) {
                let span = streak.patch.row(row);
                let threshold = if is_noisy { f32::INFINITY } else { SHARE_WITHOUT_NOISE * peak };
                for (column, &value) in (span.first_column..).zip(span.values) {
                    light[column] += value;
                    if value > FAINTEST_SHARE * peak {
                        values[column] |= planes.value(value > threshold);
                    }
                }
                if !span.values.is_empty() {
                    (first, end) = (first.min(span.first_column), end.max(span.first_column + span.values.len()));
                }
            }
            for column in first..end {
                if is_noisy && light[column] > noise.at(row, column) {
                    values[column] = planes.value(true);
                }
            }
            let mut spans = Vec::new();
            if first < end {
                let mut first_column = first;
                for run in values[first..end].chunk_by(|a, b| (*a != 0) == (*b != 0)) {
                    if run[0] != 0 {
                        spans.push(MaskSpan { row, first_column, values: run.to_vec() });
                    }
                    first_column += run.len();
                }
                light[first..end].fill(0.0);
                values[first..end].fill(0);
            }
            spans
        })
        .collect()
}

/// Returns the mask of light that a detector moved outside the streaks, such as bled columns and ghosts. Pixels are
/// `INJECTED` if the signal exceeds `noise`, the standard deviation of the frame's pixels near them, or, in a frame
/// without noise, 10⁻⁴ of the chip's strongest signal. `added` is in the order of rows and columns; adjacent pixels of
/// a row form one run.
///
/// These pixels are not marked as `STREAK`, because a streak detector should find only the line, and pipelines mask
/// bleeding and ghosts by other planes.
pub fn changed_spans(added: &[AddedLight], planes: &MaskPlanes, noise: &NoiseMap) -> Vec<MaskSpan> {
    let strongest = added.iter().map(|light| light.signal_adu.abs()).fold(0.0, f32::max);
    let is_noisy = noise.is_noisy();
    let threshold =
        |light: &AddedLight| if is_noisy { noise.at(light.row, light.column) } else { FAINTEST_SHARE * strongest };
    let seen: Vec<&AddedLight> = added.iter().filter(|light| light.signal_adu.abs() > threshold(light)).collect();
    seen.chunk_by(|a, b| (a.row, a.column + 1) == (b.row, b.column))
        .map(|of_span| MaskSpan {
            row: of_span[0].row,
            first_column: of_span[0].column,
            values: vec![planes.value(false); of_span.len()],
        })
        .collect()
}

/// Survey or pipeline whose mask bits are used.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub enum MaskPreset {
    /// Named planes with `MP_` keywords. Planes that the frame's own mask names keep their bits; otherwise `STREAK` and
    /// `INJECTED` get the lowest free bits.
    #[default]
    Lsst,
    /// DES data management: `BADPIX_STREAK` = 1024, bit 10 (Morganson et al. 2018, table 9).
    Desdm,
    /// LAST: streaks in bit 20.
    Last,
    /// ZTF science masks: bit 0, aircraft or satellite track (ZTF Science Data System explanatory supplement, section
    /// 10.3).
    Ztf,
    /// ACS on the HST: satellite trails are 16384, bit 14 (as written by acstools.satdet).
    Hst,
}

/// Bits of the mask planes for streaks and for injected light.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct MaskPlanes {
    /// Pixels in which a streak exceeds the noise, which a streak detector should find.
    pub streak_bit: u32,
    /// Pixels with any injected light.
    pub injected_bit: u32,
}

/// Highest bit of a signed 32-bit integer for which mask values stay positive.
const HIGHEST_BIT: u32 = 30;

/// Bit of injected light for surveys without a plane for it; none of these surveys uses this bit.
const UNUSED_BIT: u32 = HIGHEST_BIT;

impl MaskPreset {
    /// All presets.
    pub const ALL: [Self; 5] = [Self::Lsst, Self::Desdm, Self::Last, Self::Ztf, Self::Hst];

    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lsst => "lsst",
            Self::Desdm => "desdm",
            Self::Last => "last",
            Self::Ztf => "ztf",
            Self::Hst => "hst",
        }
    }

    /// Returns a preset by its name; upper and lower case are equivalent.
    ///
    /// # Errors
    /// An unknown name.
    pub fn by_name(name: &str) -> Result<Self, Error> {
        Self::ALL
            .into_iter()
            .find(|preset| preset.name().eq_ignore_ascii_case(name.trim()))
            .ok_or_else(|| Error::invalid("mask preset", format!("{name:?}"), Self::ALL.map(Self::name).join(", ")))
    }

    /// Returns the bits, given the planes that the frame's own mask names (names without `MP_`).
    ///
    /// # Errors
    /// The mask of the frame uses all bits.
    pub fn planes(self, own: &BTreeMap<String, u32>) -> Result<MaskPlanes, Error> {
        let streak_bit = match self {
            Self::Lsst => return named(own),
            Self::Desdm => 10,
            Self::Last => 20,
            Self::Ztf => 0,
            Self::Hst => 14,
        };
        Ok(MaskPlanes { streak_bit, injected_bit: UNUSED_BIT })
    }
}

/// Returns the bits of the `STREAK` and `INJECTED` planes of the frame's mask, or the lowest free bits.
fn named(own: &BTreeMap<String, u32>) -> Result<MaskPlanes, Error> {
    let mut taken: Vec<u32> = own.values().copied().collect();
    let mut bit = |plane: &'static str| -> Result<u32, Error> {
        let bit = own.get(plane).copied().filter(|&bit| bit <= HIGHEST_BIT);
        let free = || (0..=HIGHEST_BIT).find(|bit| !taken.contains(bit));
        let bit = bit.or_else(free).ok_or_else(|| {
            let allowed = format!("a bit from 0 to {HIGHEST_BIT} that the frame's own mask does not use");
            Error::invalid(format!("mask bit of {plane}"), "missing", allowed)
        })?;
        taken.push(bit);
        Ok(bit)
    };
    Ok(MaskPlanes { streak_bit: bit("STREAK")?, injected_bit: bit("INJECTED")? })
}

impl MaskPlanes {
    /// Returns the mask value of a pixel: both bits if the streak exceeds the noise, otherwise only that of injected
    /// light.
    pub fn value(&self, stands_out: bool) -> i32 {
        let injected = 1i32 << self.injected_bit;
        if stands_out { injected | (1i32 << self.streak_bit) } else { injected }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::images::PixelPosition;
    use crate::streaks::{Blur, RadialProfile, Seeing, Source, SourceName, draw_point};

    #[test]
    fn verif_masks_distinguish_light_above_the_noise_from_fainter_light() {
        let profile = RadialProfile::new(&Blur::seeing(Seeing::Gaussian { fwhm_pix: 3.0 })).unwrap();
        let source = Source {
            name: SourceName::Random(1),
            mag_source: String::new(),
            element_age_days: None,
            hdu: None,
            image_fwhm_arcsec: None,
            parts: vec![],
        };
        let streak = |x: f64| DrawnStreak {
            source: &source,
            part: "whole",
            hdu: 0,
            chip: "",
            is_on_sky: true,
            patch: draw_point(&profile, PixelPosition { x, y: 20.0 }, 1000.0, 40, 60),
            points: vec![],
            width_arcsec: 3.0,
            width_pix: 3.0,
            length_pix: 0.0,
            middle: None,
            peak_magnitude: None,
            rate_arcsec_s: 0.0,
            frame_rate_arcsec_s: 0.0,
            range_km: None,
            size_m: None,
            zero_point_mag: 25.0,
        };
        let (left, right) = (streak(20.0), streak(26.0));
        let planes = MaskPlanes { streak_bit: 0, injected_bit: 1 };
        for noise in [0.0, 10.0] {
            let spans = mask_spans(&[&left, &right], 60, &planes, &NoiseMap::uniform(noise));
            assert!(
                spans.windows(2).all(|pair| (pair[0].row, pair[0].first_column) < (pair[1].row, pair[1].first_column))
            );
            let mut row = [0; 60];
            for span in spans.iter().filter(|span| span.row == 20) {
                row[span.first_column..][..span.values.len()].copy_from_slice(&span.values);
            }
            let at = |column: usize| row[column];
            assert_eq!((at(20), at(26)), (3, 3));
            let sum = |column: usize| left.patch.at(20, column) + right.patch.at(20, column);
            for column in (0..60).filter(|column| at(*column) != 0) {
                let stands_out =
                    if noise > 0.0 { sum(column) > noise } else { sum(column) > 0.1 * left.patch.at(20, 20) };
                // Between the two streaks their sum may exceed a threshold that neither streak exceeds; only the noise
                // threshold uses sums.
                if noise > 0.0 || (column as f64 - 23.0).abs() > 1.5 {
                    assert_eq!(at(column) & 1 == 1, stands_out, "{column} {noise}");
                }
            }
        }
        assert!(mask_spans(&[], 60, &planes, &NoiseMap::uniform(1.0)).is_empty());
    }

    #[test]
    fn verif_bled_charge_is_injected_but_not_streak() {
        let planes = MaskPlanes { streak_bit: 0, injected_bit: 1 };
        let light = |row, column, signal_adu| AddedLight { row, column, signal_adu, change_adu: signal_adu };
        let added = [light(2, 5, 40.0), light(2, 6, -30.0), light(2, 8, 9.0), light(3, 6, 20.0), light(3, 7, 0.001)];
        let span = |row, first_column, pixels| MaskSpan { row, first_column, values: vec![2; pixels] };
        assert_eq!(changed_spans(&added, &planes, &NoiseMap::uniform(10.0)), [span(2, 5, 2), span(3, 6, 1)]);
        assert_eq!(
            changed_spans(&added, &planes, &NoiseMap::uniform(0.0)),
            [span(2, 5, 2), span(2, 8, 1), span(3, 6, 1)]
        );
        assert!(changed_spans(&[], &planes, &NoiseMap::uniform(0.0)).is_empty());
    }

    fn own(names: &[(&str, u32)]) -> BTreeMap<String, u32> {
        names.iter().map(|(name, bit)| ((*name).to_owned(), *bit)).collect()
    }

    #[test]
    fn verif_bits_of_the_frames_own_mask_are_kept() {
        let planes = MaskPreset::Lsst.planes(&own(&[("BAD", 0), ("SAT", 1), ("CR", 3)])).unwrap();
        assert_eq!(planes, MaskPlanes { streak_bit: 2, injected_bit: 4 });
        let planes = MaskPreset::Lsst.planes(&own(&[("BAD", 0), ("STREAK", 9)])).unwrap();
        assert_eq!(planes, MaskPlanes { streak_bit: 9, injected_bit: 1 });
        assert_eq!(MaskPreset::Lsst.planes(&own(&[])).unwrap(), MaskPlanes { streak_bit: 0, injected_bit: 1 });
        let names: Vec<String> = (0..31).map(|bit| format!("P{bit}")).collect();
        let full = names.iter().zip(0..).map(|(name, bit)| (name.clone(), bit)).collect();
        assert!(MaskPreset::Lsst.planes(&full).unwrap_err().to_string().contains("mask bit of STREAK is missing"));
    }

    #[test]
    fn verif_surveys_have_their_own_bits() {
        for (name, value) in [("desdm", 1024), ("ZTF", 1), ("last", 1 << 20), ("hst", 16384)] {
            let planes = MaskPreset::by_name(name).unwrap().planes(&own(&[])).unwrap();
            assert_eq!(planes.value(true) & !planes.value(false), value, "{name}");
        }
        assert!(MaskPreset::by_name("sdss").unwrap_err().to_string().contains("lsst, desdm, last, ztf, hst"));
    }
}
