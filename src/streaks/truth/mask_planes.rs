//! Which bit of a mask says what, in the manner of LSST and of other surveys.

use super::super::error::StreaksError;
use std::collections::BTreeMap;

/// Whose bits a mask follows.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub enum MaskPreset {
    /// Named planes with `MP_` keywords. Bits that the frame's own mask names are kept; `STREAK` and `INJECTED` take the next free ones.
    #[default]
    Lsst,
    /// DES data management: `BADPIX_STREAK` = 1024, bit 10 (Morganson et al. 2018, table 9).
    Desdm,
    /// LAST: streaks in bit 20.
    Last,
    /// ZTF science masks: bit 0, aircraft or satellite track (ZTF Science Data System explanatory supplement, section 10.3).
    Ztf,
    /// ACS on the HST: satellite trails are 16384, bit 14 (acstools.satdet writes it so).
    Hst,
}

/// The bits of the two planes.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct MaskPlanes {
    /// Pixels on which a streak stands out: what a detector of streaks should find.
    pub streak_bit: u32,
    /// Pixels that hold any injected light.
    pub injected_bit: u32,
}

/// The highest bit of a signed 32-bit image that keeps its numbers positive.
const HIGHEST_BIT: u32 = 30;

/// Where surveys that know no injected light get that plane: out of the way of bits that mean something to them.
const OUT_OF_THE_WAY: u32 = HIGHEST_BIT;

impl MaskPreset {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Lsst, Self::Desdm, Self::Last, Self::Ztf, Self::Hst];

    /// As it is typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lsst => "lsst",
            Self::Desdm => "desdm",
            Self::Last => "last",
            Self::Ztf => "ztf",
            Self::Hst => "hst",
        }
    }

    /// By name, in any case.
    ///
    /// # Errors
    /// [`StreaksError::MaskPreset`] with the names that are known.
    pub fn by_name(name: &str) -> Result<Self, StreaksError> {
        Self::ALL.into_iter().find(|preset| preset.name().eq_ignore_ascii_case(name.trim())).ok_or_else(|| {
            StreaksError::MaskPreset { given: name.to_owned(), allowed: Self::ALL.map(Self::name).join(", ") }
        })
    }

    /// The bits, given the planes that the frame's own mask names (without `MP_`).
    ///
    /// # Errors
    /// [`StreaksError::MaskBits`] where the frame's own mask leaves none.
    pub fn planes(self, own: &BTreeMap<String, u32>) -> Result<MaskPlanes, StreaksError> {
        let streak_bit = match self {
            Self::Lsst => return named(own),
            Self::Desdm => 10,
            Self::Last => 20,
            Self::Ztf => 0,
            Self::Hst => 14,
        };
        Ok(MaskPlanes { streak_bit, injected_bit: OUT_OF_THE_WAY })
    }
}

/// The planes of these names where the mask has them, else the lowest bits that it does not use.
fn named(own: &BTreeMap<String, u32>) -> Result<MaskPlanes, StreaksError> {
    let mut taken: Vec<u32> = own.values().copied().collect();
    let mut bit = |plane: &'static str| -> Result<u32, StreaksError> {
        let bit = own.get(plane).copied().filter(|&bit| bit <= HIGHEST_BIT);
        let free = || (0..=HIGHEST_BIT).find(|bit| !taken.contains(bit));
        let bit = bit.or_else(free).ok_or(StreaksError::MaskBits { plane, highest: HIGHEST_BIT })?;
        taken.push(bit);
        Ok(bit)
    };
    Ok(MaskPlanes { streak_bit: bit("STREAK")?, injected_bit: bit("INJECTED")? })
}

impl MaskPlanes {
    /// The value of a pixel in both planes or in the second alone.
    pub fn value(&self, stands_out: bool) -> i32 {
        let injected = 1i32 << self.injected_bit;
        if stands_out { injected | (1i32 << self.streak_bit) } else { injected }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        assert!(MaskPreset::Lsst.planes(&full).unwrap_err().to_string().contains("none is left for STREAK"));
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
