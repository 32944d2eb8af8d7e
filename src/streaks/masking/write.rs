//! Files with masks: a file of masks alone, or a copy of the frame with a bit added to its own mask planes.

use std::path::Path;

use super::super::error::StreaksError;
use super::super::frame::{TargetChip, TargetFrame, mask_name};
use super::super::injection::{provenance_lines, reject_packed, reject_untiled};
use super::area::Area;
use super::satellites::{FrameMask, MaskOptions};
use crate::images::{
    Card, CardValue, FrameCopy, Header, ImageValues, ImagesError, NewImage, Pixels, PlaneKind, Rice, write_frame,
};
use crate::output::Provenance;

/// Rows of a mask plane that are read at once.
const ROWS: usize = 256;
/// Highest bit that is added, so that mask values of 32 bits stay positive.
const HIGHEST_BIT: u32 = 30;
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
        "streakcast {version} mask: {} corridors, {} satellites left out, coverage {}, threshold {} of the noise",
        mask.streaks.len(),
        mask.omitted.len(),
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
pub fn write_mask_file(
    frame: &TargetFrame,
    mask: &FrameMask,
    history: &[String],
    output: &Path,
) -> Result<(), StreaksError> {
    reject_packed(output)?;
    let rice = output.extension().is_some_and(|end| end.eq_ignore_ascii_case("fz")).then(Rice::default);
    let mut taken = Vec::new();
    let mut images = Vec::new();
    for (index, target) in frame.chips.iter().enumerate() {
        let (name, more) = mask_name(frame, target, frame.chips.len() == 1, &mut taken)?;
        let mut cards: Vec<Card> = coordinates(frame.file.header(target.chip.hdu)?);
        cards.extend(Card::with_value("MP_STREAK", &CardValue::Integer(0), "bit: streak of a satellite"));
        cards.extend(more);
        cards.extend(history.iter().flat_map(|line| Card::remark("HISTORY", line)));
        images.push((name, cards, values(&mask.area(index), target)?));
    }
    let images: Vec<NewImage<'_>> =
        images.iter().map(|(name, cards, values)| NewImage { name, values, cards, rice }).collect();
    Ok(write_frame(output, &images)?)
}

fn values(area: &Area, target: &TargetChip) -> Result<ImageValues, StreaksError> {
    let columns = target.chip.columns;
    let mut values = vec![0u8; target.chip.rows * columns];
    for (row, range) in area.runs() {
        values[row * columns + range.start..row * columns + range.end].fill(1);
    }
    ImageValues::new(columns, Pixels::U8(values))
        .ok_or_else(|| StreaksError::invalid(format!("HDU {}", target.chip.hdu), "empty", "at least one pixel"))
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
/// A plane is missing, not a mask of whole numbers, or of another size; it is not known which chip it describes; the bit
/// does not exist in it; or the file cannot be written.
pub fn write_mask_planes(
    frame: &TargetFrame,
    mask: &FrameMask,
    (planes, bit): (&[PlaneChoice], &MaskBit),
    history: &[String],
    output: &Path,
) -> Result<(), StreaksError> {
    reject_packed(output)?;
    reject_untiled(frame, output)?;
    let chosen = planes_of(frame, planes)?;
    let mut copy = FrameCopy::begin(&frame.file, output)?;
    for (index, target) in frame.chips.iter().enumerate() {
        let area = mask.area(index);
        let hdu = target.chip.hdu;
        let Some((_, plane)) = chosen.iter().find(|(chip, _)| *chip == index) else {
            if area.pixels() > 0 {
                let what = format!("{}: mask plane of HDU {hdu}", frame.file.path().display());
                return Err(StreaksError::invalid(what, "missing", allowed_planes(frame)));
            }
            continue;
        };
        add_bit(&mut copy, frame, *plane, &area, bit)?;
        for line in history {
            copy.add_history(*plane, line)?;
        }
    }
    copy.finish()?;
    Ok(())
}

/// Returns the chosen planes with the indices of their chips.
fn planes_of(frame: &TargetFrame, planes: &[PlaneChoice]) -> Result<Vec<(usize, usize)>, StreaksError> {
    let shown = frame.file.path().display();
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
                    return Err(StreaksError::invalid(
                        format!("{shown}: mask plane {name:?}"),
                        "missing",
                        allowed_planes(frame),
                    ));
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
            return Err(StreaksError::invalid(
                format!("{shown}: HDU {hdu}"),
                "not a mask plane",
                allowed_planes(frame),
            ));
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
            let what = format!("{shown}: HDU {hdu}: chip that the mask plane describes");
            return Err(StreaksError::invalid(
                what,
                "unknown",
                "EXTVER, EXTNAME or an order of HDUs that determines it",
            ));
        };
        let target = &frame.chips[chip].chip;
        let size = frame.file.image_size(hdu)?;
        if size != [target.rows, target.columns] {
            let [rows, columns] = size;
            let what = format!("{shown}: HDU {hdu}: size");
            let allowed = format!("{} by {}, that of HDU {}", target.columns, target.rows, target.hdu);
            return Err(StreaksError::invalid(what, format!("{columns} by {rows}"), allowed));
        }
        if let Some((_, other)) = chosen.iter().find(|(known, _)| *known == chip) {
            let what = format!("{shown}: mask planes of HDU {}", target.hdu);
            return Err(StreaksError::invalid(what, format!("HDU {other} and HDU {hdu}"), "one plane for each chip"));
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
fn add_bit(
    copy: &mut FrameCopy<'_>,
    frame: &TargetFrame,
    hdu: usize,
    area: &Area,
    bit: &MaskBit,
) -> Result<(), StreaksError> {
    let shown = frame.file.path().display();
    let Some((_, most)) = frame.file.hdu(hdu)?.format.whole_range() else {
        let what = format!("{shown}: HDU {hdu}: type of the pixels");
        return Err(StreaksError::invalid(what, "not whole numbers without scale", "a mask of integers"));
    };
    let (number, is_new) = number_of(frame, hdu, bit, most)?;
    let value = 2f64.powi(number as i32);
    for runs in area.runs().chunk_by(|a, b| a.0 / ROWS == b.0 / ROWS) {
        let rows = runs[0].0..runs[runs.len() - 1].0 + 1;
        let (first, columns) = (rows.start, frame.file.image_size(hdu)?[1]);
        let old = frame.file.read_rows(hdu, rows)?;
        for (row, range) in runs {
            let of_row = &old[(row - first) * columns..][range.clone()];
            let is_set = |old: f64| old.is_nan() || (old as i64 >> number) & 1 == 1;
            let added: Vec<f32> = of_row.iter().map(|old| if is_set(*old) { 0.0 } else { value as f32 }).collect();
            copy.add(hdu, *row, range.start, added)?;
        }
    }
    if let (MaskBit::Named(name), true) = (bit, is_new) {
        copy.set_card(
            hdu,
            &format!("MP_{name}"),
            &CardValue::Integer(i64::from(number)),
            "bit: streak of a satellite",
        )?;
    }
    Ok(())
}

/// Returns the number of a bit, and whether the mask does not name it yet.
fn number_of(frame: &TargetFrame, hdu: usize, bit: &MaskBit, most: f64) -> Result<(u32, bool), StreaksError> {
    let what = format!("{}: HDU {hdu}: mask bit", frame.file.path().display());
    let exists = |number: u32| number <= HIGHEST_BIT && 2f64.powi(number as i32) <= most;
    let highest = (0..=HIGHEST_BIT).rfind(|number| exists(*number)).unwrap_or(0);
    let number = match bit {
        MaskBit::Number(number) => {
            return if exists(*number) {
                Ok((*number, false))
            } else {
                Err(StreaksError::invalid(what, number, format!("0 to {highest} in pixels of this type")))
            };
        }
        MaskBit::Named(name) => name,
    };
    let header = frame.file.header(hdu)?;
    let bits = |card: &Card| {
        let keyword = card.keyword();
        let bit = u32::try_from(header.integer(&keyword)?).ok()?;
        Some((keyword.strip_prefix("MP_")?.to_owned(), bit))
    };
    let named: Vec<(String, u32)> = header.cards().iter().filter_map(bits).collect();
    if let Some((_, known)) = named.iter().find(|(known, _)| known.eq_ignore_ascii_case(number)) {
        return if exists(*known) {
            Ok((*known, false))
        } else {
            Err(StreaksError::invalid(format!("{what} of MP_{number}"), known, format!("0 to {highest}")))
        };
    }
    if named.is_empty() {
        let given = format!("{number:?}, but the mask names no bits (MP_ keywords)");
        return Err(StreaksError::invalid(what, given, format!("the number of a bit, 0 to {highest}")));
    }
    // A bit that no keyword names may still be set in pixels.
    let used = used_bits(frame, hdu)?;
    let free = (0..=highest).find(|bit| used >> bit & 1 == 0 && named.iter().all(|(_, other)| other != bit));
    let free = free.ok_or_else(|| {
        StreaksError::invalid(
            format!("{what} for {number:?}"),
            "missing",
            "a mask with a free bit, or --bit with a number",
        )
    })?;
    Ok((free, true))
}

/// Returns the bits that are set in any pixel of a plane.
fn used_bits(frame: &TargetFrame, hdu: usize) -> Result<i64, ImagesError> {
    let [rows, _] = frame.file.image_size(hdu)?;
    let mut used = 0;
    for first in (0..rows).step_by(ROWS) {
        let values = frame.file.read_rows(hdu, first..(first + ROWS).min(rows))?;
        used |= values.into_iter().filter(|value| !value.is_nan()).fold(0, |bits, value| bits | value as i64);
    }
    Ok(used)
}
