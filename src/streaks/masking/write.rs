//! Files with masks: a file of masks alone, or a copy of the frame with a bit added to its own mask planes.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::super::frame::{TargetChip, TargetFrame, mask_name};
use super::super::injection::{provenance_lines, reject_packed, reject_untiled};
use super::area::Area;
use super::satellites::{FrameMask, MaskOptions};
use crate::error::Error;
use crate::images::{
    Bitpix, Card, CardValue, FrameCopy, Header, ImageValues, NewImage, Pixels, PlaneKind, Rice, write_frame,
};
use crate::output::{Provenance, counted};

/// Rows of a mask plane that are read at once.
const ROWS: usize = 256;
/// Highest bit that is added: integers of 64 bits are computed in double precision, which is exact below 2⁵³.
const HIGHEST_BIT: u32 = 52;
const EXACT: f64 = 9_007_199_254_740_992.0;
/// Beginnings of keywords of world coordinates.
const COORDINATES: [&str; 20] = [
    "WCSAXES", "WCSNAME", "CTYPE", "CRVAL", "CRPIX", "CDELT", "CUNIT", "CROTA", "CD1_", "CD2_", "PC1_", "PC2_", "PV1_",
    "PV2_", "LONPOLE", "LATPOLE", "RADESYS", "RADECSYS", "EQUINOX", "WAT",
];
/// Beginnings of keywords of SIP distortions.
const SIP: [&str; 4] = ["A_", "B_", "AP_", "BP_"];

/// Mask plane to which a bit is added.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PlaneChoice {
    /// Number of its HDU, from 0.
    Number(usize),
    /// Name of its HDU; upper and lower case are equivalent. Several planes may have it.
    Name(String),
}

/// Bit that marks streaks in a mask plane.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MaskBit {
    /// Bit of the plane with this name in the `MP_` keywords of the mask, or a free bit.
    Named(String),
    /// Number of the bit, from 0.
    Number(u32),
}

/// Returns the HISTORY lines of a mask.
pub fn mask_history(provenance: &Provenance, mask: &FrameMask, options: &MaskOptions) -> Vec<String> {
    let version = env!("CARGO_PKG_VERSION");
    let mut lines = vec![format!(
        "streakcast {version} mask: {}, {} left out, coverage {}, threshold {} of the noise",
        counted(mask.streaks.len(), "corridor", "corridors"),
        counted(mask.left_out.len(), "satellite", "satellites"),
        options.coverage,
        options.threshold,
    )];
    lines.extend(provenance_lines(provenance));
    lines
}

/// Writes the masks of all chips of a frame to a new file, one image of 8-bit integers for each chip, with its world
/// coordinates: 1 (bit 0, `MP_STREAK`) for masked pixels. If the name of the file ends in `.fz`, the images are
/// compressed.
///
/// # Errors
/// The file cannot be written.
pub fn write_mask_file(frame: &TargetFrame, mask: &FrameMask, history: &[String], output: &Path) -> Result<(), Error> {
    reject_packed(output)?;
    let rice = output.extension().is_some_and(|end| end.eq_ignore_ascii_case("fz")).then(Rice::default);
    let mut taken = Vec::new();
    let mut images = Vec::new();
    for (index, target) in frame.chips.iter().enumerate() {
        let (name, more) = mask_name("MASK", frame, target, &mut taken)?;
        let mut cards: Vec<Card> = coordinates(frame.file.header(target.chip.hdu)?);
        cards.extend(Card::with_value("MP_STREAK", &CardValue::Integer(0), "bit: streak of a satellite"));
        cards.extend(more);
        cards.extend(history.iter().flat_map(|line| Card::remark("HISTORY", line)));
        images.push((name, cards, values(&mask.area(index), target)?));
    }
    let images: Vec<NewImage<'_>> =
        images.iter().map(|(name, cards, values)| NewImage { name, values, cards, rice }).collect();
    write_frame(output, &images)
}

fn values(area: &Area, target: &TargetChip) -> Result<ImageValues<'static>, Error> {
    let (rows, columns) = (target.chip.rows, target.chip.columns);
    ImageValues::new(columns, Pixels::U8(area.values([rows, columns], [0, 1]).into()))
        .ok_or_else(|| Error::invalid(format!("HDU {}", target.chip.hdu), "empty", "at least one pixel"))
}

/// Returns the cards of the world coordinates of a header.
fn coordinates(header: &Header) -> Vec<Card> {
    let is_sip = |keyword: &str| {
        let rest = SIP.iter().find_map(|start| keyword.strip_prefix(start));
        rest.is_some_and(|rest| rest == "ORDER" || rest.starts_with(|c: char| c.is_ascii_digit()))
    };
    let is_kept = |keyword: &str| COORDINATES.iter().any(|start| keyword.starts_with(start)) || is_sip(keyword);
    header.cards().iter().filter(|card| is_kept(&card.keyword())).cloned().collect()
}

/// Writes a copy of the frame in which a bit of its mask planes is set where streaks are masked. Other bits are kept.
/// Each chip with a masked pixel must have one of the planes.
///
/// # Errors
/// A chip with a masked pixel has no plane, or the file cannot be written.
pub fn write_mask_planes(
    frame: &TargetFrame,
    mask: &FrameMask,
    planes: &ChosenPlanes,
    history: &[String],
    output: &Path,
) -> Result<(), Error> {
    reject_packed(output)?;
    reject_untiled(frame, output)?;
    let mut copy = FrameCopy::begin(&frame.file, output)?;
    for (index, target) in frame.chips.iter().enumerate() {
        let area = mask.area(index);
        let hdu = target.chip.hdu;
        let Some((_, plane)) = planes.of_chips.iter().find(|(chip, _)| *chip == index) else {
            if area.pixels() > 0 {
                return Err(Error::invalid(format!("mask plane of HDU {hdu}"), "missing", allowed_planes(frame))
                    .in_file("", frame.file.path()));
            }
            continue;
        };
        add_bit(&mut copy, frame, *plane, &area, planes.bit)?;
        if let Some(name) = &planes.new_name {
            let number = CardValue::Integer(i64::from(planes.bit));
            copy.set_card(*plane, &format!("MP_{name}"), &number, "bit: streak of a satellite")?;
        }
        for line in history {
            copy.add_history(*plane, line)?;
        }
    }
    copy.finish()?;
    Ok(())
}

/// Returns the chosen planes with the indices of their chips.
fn planes_of(frame: &TargetFrame, planes: &[PlaneChoice]) -> Result<Vec<(usize, usize)>, Error> {
    let path = frame.file.path();
    let mut hdus: Vec<usize> = Vec::new();
    for choice in planes {
        match choice {
            PlaneChoice::Number(hdu) => {
                frame.file.image_size(*hdu)?;
                hdus.push(*hdu);
            }
            PlaneChoice::Name(name) => {
                let named = frame.file.hdus().iter().filter(|hdu| hdu.name.eq_ignore_ascii_case(name));
                let named: Vec<usize> = named.map(|hdu| hdu.index).collect();
                if named.is_empty() {
                    return Err(Error::invalid(format!("mask plane {name:?}"), "missing", allowed_planes(frame))
                        .in_file("", path));
                }
                hdus.extend(named);
            }
        }
    }
    hdus.sort_unstable();
    hdus.dedup();
    let mut chosen: Vec<(usize, usize)> = Vec::new();
    for hdu in hdus {
        let described = frame.images.companions.iter().find(|plane| plane.hdu == hdu);
        if frame.chips.iter().any(|target| target.chip.hdu == hdu) || described.is_none() {
            return Err(
                Error::invalid(format!("HDU {hdu}"), "not a mask plane", allowed_planes(frame)).in_file("", path)
            );
        }
        let of = described.and_then(|plane| plane.of);
        let chip = match (&frame.chips[..], of) {
            ([_], None) => Some(0),
            (chips, of) => chips.iter().position(|target| Some(target.chip.hdu) == of),
        };
        let Some(chip) = chip else {
            // The plane of a chip that is not masked, or of an unknown one.
            if of.is_some() {
                continue;
            }
            let allowed = "EXTVER, EXTNAME or an order of HDUs that determines it";
            return Err(Error::invalid("chip that the mask plane describes", "unknown", allowed).in_hdu(path, hdu));
        };
        let target = &frame.chips[chip].chip;
        let size = frame.file.image_size(hdu)?;
        if size != [target.rows, target.columns] {
            let [rows, columns] = size;
            let allowed = format!("{} by {}, that of HDU {}", target.columns, target.rows, target.hdu);
            return Err(Error::invalid("size", format!("{columns} by {rows}"), allowed).in_hdu(path, hdu));
        }
        if let Some((_, other)) = chosen.iter().find(|(known, _)| *known == chip) {
            let what = format!("mask planes of HDU {}", target.hdu);
            let given = format!("HDU {other} and HDU {hdu}");
            return Err(Error::invalid(what, given, "one plane for each chip").in_file("", path));
        }
        chosen.push((chip, hdu));
    }
    Ok(chosen)
}

/// Returns the mask planes of a file, for errors.
fn allowed_planes(frame: &TargetFrame) -> String {
    let masks = frame.images.companions.iter().filter(|plane| plane.kind == PlaneKind::Mask);
    let masks: Vec<String> = masks.map(|plane| format!("HDU {} ({})", plane.hdu, plane.name)).collect();
    if masks.is_empty() {
        "a frame with a mask plane (this one has none), or a mask file without --into".to_owned()
    } else {
        format!("mask planes: {}", masks.join(", "))
    }
}

/// Adds a bit to the pixels of a mask plane in which it is not set.
fn add_bit(copy: &mut FrameCopy<'_>, frame: &TargetFrame, hdu: usize, area: &Area, number: u32) -> Result<(), Error> {
    let value = 2f32.powi(number as i32);
    for runs in area.runs().chunk_by(|a, b| a.0 / ROWS == b.0 / ROWS) {
        let rows = runs[0].0..runs[runs.len() - 1].0 + 1;
        let (first, columns) = (rows.start, frame.file.image_size(hdu)?[1]);
        let old = frame.file.read_rows(hdu, rows)?;
        for (row, range) in runs {
            let of_row = &old[(row - first) * columns..][range.clone()];
            let is_set = |old: f64| old.is_nan() || (old as i64 >> number) & 1 == 1;
            let added: Vec<f32> = of_row.iter().map(|old| if is_set(*old) { 0.0 } else { value }).collect();
            copy.add(hdu, *row, range.start, added)?;
        }
    }
    Ok(())
}

/// Mask planes of a frame and the bit that is set in them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChosenPlanes {
    /// Indices of chips, and the HDUs of their planes.
    of_chips: Vec<(usize, usize)>,
    /// Number of the bit, the same in all planes.
    bit: u32,
    /// Name of the bit, if it is added to the headers.
    new_name: Option<String>,
}

impl ChosenPlanes {
    /// Finds the planes of a frame and the bit in them. A new name gets the first bit that no plane of the frame uses.
    ///
    /// # Errors
    /// A plane is missing, not a mask of whole numbers, or of another size; it is not known which chip it describes;
    /// the bit does not exist in it, or its number is that of another name; or pixels of 64 bits are outside ±2⁵³.
    pub fn new(frame: &TargetFrame, planes: &[PlaneChoice], bit: &MaskBit) -> Result<Self, Error> {
        let of_chips = planes_of(frame, planes)?;
        let path = frame.file.path();
        let (mut highest, mut names) = (HIGHEST_BIT, Vec::new());
        for (_, hdu) in &of_chips {
            let format = frame.file.hdu(*hdu)?.format;
            let Some((_, most)) = format.whole_range() else {
                let given = "not whole numbers without scale";
                return Err(Error::invalid("type of the pixels", given, "a mask of integers").in_hdu(path, *hdu));
            };
            highest = (0..=highest).rfind(|number| 2f64.powi(*number as i32) <= most).unwrap_or(0);
            if let MaskBit::Number(number) = bit
                && *number > highest
            {
                let allowed = format!("0 to {highest} in this plane");
                return Err(Error::invalid("mask bit", number, allowed).in_hdu(path, *hdu));
            }
            if format.bitpix == Bitpix::I64 {
                used_bits(frame, *hdu)?;
            }
            let bits = bit_names(frame.file.header(*hdu)?);
            if let MaskBit::Number(number) = bit
                && let Some((name, _)) = bits.iter().find(|(name, bit)| *bit == number && *name != "STREAK")
            {
                let allowed = format!("--bit {name}, or a number that no MP_ keyword of this plane has");
                return Err(
                    Error::invalid("mask bit", format!("{number}, that of MP_{name}"), allowed).in_hdu(path, *hdu)
                );
            }
            names.push((*hdu, bits));
        }
        let name = match bit {
            MaskBit::Number(number) => return Ok(Self { of_chips, bit: *number, new_name: None }),
            MaskBit::Named(name) => name,
        };
        let invalid =
            |what: &str, given: String, allowed: String| Err(Error::invalid(what, given, allowed).in_file("", path));
        if let Some((hdu, _)) = names.iter().find(|(_, bits)| bits.is_empty()) {
            let given = format!("{name:?}, but the mask names no bits (MP_ keywords)");
            return invalid(&format!("HDU {hdu}: mask bit"), given, format!("the number of a bit, 0 to {highest}"));
        }
        let known: BTreeSet<u32> = names.iter().filter_map(|(_, bits)| bits.get(name).copied()).collect();
        let without: Vec<_> = names.iter().filter(|(_, bits)| !bits.contains_key(name)).collect();
        // A bit that no keyword names may still be set in pixels.
        let mut taken = 0;
        for (hdu, bits) in &without {
            taken |=
                bits.values().filter(|bit| **bit < i64::BITS).fold(used_bits(frame, *hdu)?, |all, bit| all | 1 << bit);
        }
        let is_free = |bit: &u32| *bit <= highest && taken >> bit & 1 == 0;
        let number = match (known.len(), known.first().copied().filter(is_free)) {
            (0, _) => (0..=highest).find(is_free),
            (1, free) => free,
            _ => None,
        };
        let Some(bit) = number else {
            let given = match &known.iter().map(u32::to_string).collect::<Vec<_>>()[..] {
                [] => "missing: all bits are used".to_owned(),
                numbers => format!("{} in some mask planes", numbers.join(" and ")),
            };
            let allowed =
                format!("one bit from 0 to {highest} that is free in all mask planes, or --bit with its number");
            return invalid(&format!("bit MP_{name}"), given, allowed);
        };
        Ok(Self { of_chips, bit, new_name: (!without.is_empty()).then(|| name.clone()) })
    }

    /// Returns the number of the bit.
    pub fn bit(&self) -> u32 {
        self.bit
    }
}

/// Returns the bits that the `MP_` keywords of a mask name, by their names in capital letters.
fn bit_names(header: &Header) -> BTreeMap<String, u32> {
    let bit = |card: &Card| {
        let keyword = card.keyword();
        let bit = u32::try_from(header.integer(&keyword)?).ok()?;
        Some((keyword.strip_prefix("MP_")?.to_ascii_uppercase(), bit))
    };
    header.cards().iter().filter_map(bit).collect()
}

/// Returns the bits that are set in any pixel of a plane.
///
/// # Errors
/// Pixels cannot be read, or are not exact in double precision.
fn used_bits(frame: &TargetFrame, hdu: usize) -> Result<i64, Error> {
    let [rows, _] = frame.file.image_size(hdu)?;
    let zero = frame.file.hdu(hdu)?.format.zero;
    let mut used = 0;
    for first in (0..rows).step_by(ROWS) {
        let values = frame.file.read_rows(hdu, first..(first + ROWS).min(rows))?;
        for value in values.into_iter().filter(|value| !value.is_nan()) {
            if let Some(inexact) = [zero, value].into_iter().find(|value| value.abs() >= EXACT) {
                return Err(Error::invalid(
                    "BZERO or pixel of 64 bits",
                    format!("{inexact:.0}"),
                    "above -2^53 and below 2^53",
                )
                .in_hdu(frame.file.path(), hdu));
            }
            used |= value as i64;
        }
    }
    Ok(used)
}
