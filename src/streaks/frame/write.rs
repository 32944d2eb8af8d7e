//! Copy of a frame with streaks: pixels, masks, truth tables, and header cards that describe the injection.

use std::path::Path;

use super::super::drawn::DrawnStreak;
use super::super::truth::{
    MaskPlanes, NoiseMap, TruthRow, changed_spans, mask_spans, points_table, truth_rows, truth_table,
};
use super::target_frame::{TargetChip, TargetFrame};
use crate::error::Error;
use crate::frames::tai_ns;
use crate::images::{
    AddedLight, Bleeding, Card, CardValue, Cells, Changed, Detector, FrameCopy, FrameFile, FrameRows, ImageValues,
    Patch, Pixels, Quantisation, Saturation, TableColumn,
};
use crate::output::{Column, Kind, Table, Value};
use crate::watch::Watch;

/// Number of rows that are read at once.
const ROWS: usize = 64;

/// Options for the conversion of light to counts and for the truth that is written.
#[derive(Clone, Debug)]
pub struct InjectOptions {
    /// If true, photon noise is added where the gain is known, and pixels are limited to the saturation level where
    /// that is known. If false, only the light is added.
    pub noise: bool,
    /// Detector to use in place of the detector effects that the header implies. Its gain is ignored; the gain of the
    /// frame ([`TargetChip::electrons_per_unit`]) is used.
    pub detector: Option<Detector>,
    /// Seed of the noise. The same seed gives the same frame.
    pub seed: u64,
    /// Bits of the mask planes.
    pub planes: MaskPlanes,
    /// If true, masks and truth tables are appended to the file. If the file has a variance plane, the variance of the
    /// added light is added to it.
    pub write_truth: bool,
    /// HISTORY lines that describe the injection.
    pub history: Vec<String>,
}

/// Result of the injection into one frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Injected {
    /// Numbers of changed pixels, summed over all chips.
    pub changed: Changed,
    /// HDUs with unknown gain, to which the light was added without noise.
    pub without_gain: Vec<usize>,
    /// Light of each streak above the saturation level or the range of the frame's type, in the frame's unit.
    pub clipped_counts: Vec<f64>,
}

/// Writes a copy of the frame with streaks. All header cards, extensions and tables are kept, and unchanged data are
/// identical to the last bit.
///
/// If a chip has a variance plane ([`TargetChip::variance_hdu`]) and noise was added, the variance of the light is
/// added to that plane. If requested, a mask for each chip with streaks and the tables `STREAKS` and `STREAK_POINTS`
/// are appended after the HDUs of the frame, with the first EXTVER that is free in it. A mask is named
/// `STREAKMASK`, or `STREAKMASK_<chip>` if there are several chips: `MASK` is the name of bad pixels, as which other
/// programs read it. Chips without streaks are not changed. The streaks come
/// from [`crate::streaks::draw_on_chip`], in any order.
///
/// # Errors
/// The file cannot be written, or the streaks do not fit the frame; an existing file at `output` is then unchanged.
pub fn inject(
    frame: &TargetFrame,
    streaks: &[DrawnStreak<'_>],
    options: &InjectOptions,
    output: &Path,
    watch: &Watch,
) -> Result<Injected, Error> {
    let mut copy = FrameCopy::begin(&frame.file, output)?;
    // Frames of different times have different patterns of rounding also with the same seed.
    copy.set_seed(options.seed ^ tai_ns(frame.opened) as u64);
    let mut report = Injected { clipped_counts: vec![0.0; streaks.len()], ..Injected::default() };
    let mut masks = Vec::new();
    for target in &frame.chips {
        watch.check()?;
        let own_indices: Vec<usize> =
            (0..streaks.len()).filter(|index| streaks[*index].hdu == target.chip.hdu).collect();
        let own: Vec<&DrawnStreak<'_>> = own_indices.iter().map(|index| &streaks[*index]).collect();
        if own.is_empty() {
            continue;
        }
        let detector = detector(target, options);
        if (options.noise || options.detector.is_some()) && detector.is_none() {
            report.without_gain.push(target.chip.hdu);
        }
        let noise = if options.write_truth { noise_of_chip(frame, target)? } else { NoiseMap::uniform(0.0) };
        if let Some(most) = greatest_count(target, detector.as_ref()) {
            let clipped = clipped_counts(frame, target, &own, most)?;
            own_indices.iter().zip(clipped).for_each(|(index, clipped)| report.clipped_counts[*index] = clipped);
        }
        let has_noise = detector.as_ref().is_some_and(|detector| detector.shot_noise);
        let added = match detector {
            Some(detector) => expose(&mut copy, frame, target, &own, &detector, options.seed)?,
            None => {
                add(&mut copy, target, &own)?;
                Vec::new()
            }
        };
        for line in &options.history {
            copy.add_history(target.chip.hdu, line)?;
        }
        if has_noise && options.write_truth {
            add_variance(&mut copy, &frame.file, target, &added)?;
        }
        if options.write_truth {
            masks.extend(mask(&own, &added, target, &options.planes, &noise).map(|mask| (target, mask)));
        }
    }
    if options.write_truth {
        let mut taken = versions(&frame.file)?;
        let version = free_version(&taken, &["STREAKS", "STREAK_POINTS"], None);
        append_masks(&mut copy, frame, masks, &options.planes, &mut taken)?;
        let rows: Vec<TruthRow<'_>> = truth_rows(streaks, &report.clipped_counts, frame.exposure_s, options.seed);
        let version = version_card(version);
        let history = options.history.iter().flat_map(|line| Card::remark("HISTORY", line));
        let cards: Vec<Card> = version.iter().cloned().chain(history).collect();
        copy.append_table("STREAKS", &fits_columns(&truth_table(&rows)), &cards)?;
        copy.append_table("STREAK_POINTS", &fits_columns(&points_table(&rows)), &version)?;
    }
    for (hdu, changed) in copy.finish()? {
        if frame.chips.iter().any(|target| target.chip.hdu == hdu) {
            report.changed += changed;
        }
    }
    Ok(report)
}

/// Returns the detector that converts the light of a chip to counts; `None` if the light is added unchanged.
fn detector(target: &TargetChip, options: &InjectOptions) -> Option<Detector> {
    if !options.noise && options.detector.is_none() {
        return None;
    }
    let gain_e_adu = target.electrons_per_unit?;
    Some(match &options.detector {
        Some(detector) => Detector { gain_e_adu, shot_noise: detector.shot_noise && options.noise, ..detector.clone() },
        None => {
            let saturation =
                target.saturation.map(|level| Saturation { full_well_e: level * gain_e_adu, bleeding: Bleeding::Off });
            Detector { gain_e_adu, saturation, quantisation: quantisation(target), ..Detector::default() }
        }
    })
}

/// Returns the quantisation of a frame of integer counts. With it, light of less than a count is rounded up or down at
/// random instead of always to zero. It is not used for 32-bit counts, which exceed single precision and for which
/// rounding is negligible.
fn quantisation(target: &TargetChip) -> Option<Quantisation> {
    let (least_adu, greatest_adu) = target.whole_range?;
    (greatest_adu <= 65_535.0 && least_adu >= -65_536.0).then_some(Quantisation { least_adu, greatest_adu })
}

/// Returns the greatest count that a pixel of the chip can have; `None` if it is not limited.
fn greatest_count(target: &TargetChip, detector: Option<&Detector>) -> Option<f64> {
    let full = detector.and_then(|detector| {
        let saturation = detector.saturation.as_ref()?;
        Some(saturation.full_well_e / detector.gain_e_adu + detector.bias_adu)
    });
    let rounded = detector.and_then(|detector| Some(detector.quantisation.as_ref()?.greatest_adu));
    let of_type = target.whole_range.map(|(_, greatest)| greatest);
    [full, rounded, of_type].into_iter().flatten().min_by(f64::total_cmp)
}

/// Returns the light of each streak above the greatest count of a pixel. In a pixel with several streaks it is divided
/// in proportion to their light.
fn clipped_counts(
    frame: &TargetFrame,
    target: &TargetChip,
    streaks: &[&DrawnStreak<'_>],
    most: f64,
) -> Result<Vec<f64>, Error> {
    let mut clipped = vec![0.0; streaks.len()];
    let is_lit = |row: &usize| streaks.iter().any(|streak| !streak.patch.row(*row).values.is_empty());
    let rows: Vec<usize> = (0..target.chip.rows).filter(is_lit).collect();
    for rows in rows.chunks(ROWS) {
        let before = frame.file.read_rows(target.chip.hdu, rows.iter().copied())?;
        for (row, before) in rows.iter().zip(before.chunks_exact(target.chip.columns)) {
            let mut light = vec![0.0; target.chip.columns];
            let spans: Vec<_> = streaks.iter().map(|streak| streak.patch.row(*row)).collect();
            for span in &spans {
                let sums = light[span.first_column..].iter_mut();
                sums.zip(span.values).for_each(|(sum, value)| *sum += f64::from(*value));
            }
            for (clipped, span) in clipped.iter_mut().zip(&spans) {
                for (column, value) in (span.first_column..).zip(span.values) {
                    let excess = (before[column] + light[column] - most).min(light[column]);
                    if excess > 0.0 {
                        *clipped += f64::from(*value) * excess / light[column];
                    }
                }
            }
        }
    }
    Ok(clipped)
}

/// Adds the light to the pixels without the effects of a detector.
fn add<'a>(copy: &mut FrameCopy<'a>, target: &TargetChip, streaks: &[&'a DrawnStreak<'_>]) -> Result<(), Error> {
    let mut spans = streaks.iter().flat_map(|streak| streak.patch.iter());
    spans.try_for_each(|span| copy.add(target.chip.hdu, span.row, span.first_column, span.values))
}

/// Returns the standard deviation of the noise in a chip's pixels, estimated from some of its rows.
pub(in crate::streaks) fn noise_of_chip(frame: &TargetFrame, target: &TargetChip) -> Result<NoiseMap, Error> {
    let (hdu, lit) = (target.chip.hdu, &target.chip.light_area);
    NoiseMap::new(lit, target.chip.columns, |rows| frame.file.read_rows(hdu, rows.iter().copied()))
}

/// Adds light through a detector and returns the changes of the illuminated pixels, in order. Existing pixels are read,
/// because saturation depends on the sum of existing and added light.
fn expose(
    copy: &mut FrameCopy<'_>,
    frame: &TargetFrame,
    target: &TargetChip,
    streaks: &[&DrawnStreak<'_>],
    detector: &Detector,
    seed: u64,
) -> Result<Vec<AddedLight>, Error> {
    /// Number of columns up to which light is added together with the unchanged pixels in between.
    const WIDEST_GAP: usize = 16;
    let (hdu, lit) = (target.chip.hdu, &target.chip.light_area);
    let electrons = |patch: &Patch| {
        let mut patch = patch.clone();
        patch.scale(detector.gain_e_adu as f32);
        patch
    };
    let patches: Vec<Patch> = streaks.iter().map(|streak| electrons(&streak.patch)).collect();
    // Each chip has its own random numbers, from a seed that depends on its HDU.
    let seed = seed ^ (hdu as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let frame_rows = target.chip.rows;
    let rows_at_once = if detector.mixes_rows() { frame_rows } else { ROWS };
    let mut added = Vec::new();
    for first_row in (0..frame_rows).step_by(rows_at_once) {
        let rows = first_row..frame_rows.min(first_row + rows_at_once);
        let is_lit = |patch: &Patch| rows.clone().any(|row| !patch.row(row).values.is_empty());
        if !patches.iter().any(is_lit) {
            continue;
        }
        let counts = frame.file.read_strip(hdu, rows.clone())?;
        let before = FrameRows { counts: &counts, first_row, frame_rows };
        let (of_rows, _) =
            detector.added_light(before, &patches, seed).map_err(|error| error.in_hdu(frame.file.path(), hdu))?;
        // Charge that bled out of the illuminated area is lost.
        let is_kept = |light: &AddedLight| lit.rows.contains(&light.row) && lit.columns.contains(&light.column);
        added.extend(of_rows.into_iter().filter(is_kept));
    }
    let is_near = |a: &AddedLight, b: &AddedLight| a.row == b.row && b.column - a.column <= WIDEST_GAP;
    for near in added.chunk_by(is_near) {
        let first = near[0].column;
        let mut values = vec![0.0; near[near.len() - 1].column + 1 - first];
        near.iter().for_each(|light| values[light.column - first] = light.change_adu);
        copy.add(hdu, near[0].row, first, values)?;
    }
    Ok(added)
}

/// Adds the variance of the added light to the variance plane, if there is one. The variance of n electrons is n, or n
/// / gain² in the unit of the frame. As in the pipelines that wrote the plane, n is the number measured (with noise),
/// not the expected number. A variance that is not above 0 marks a bad pixel and is kept.
fn add_variance(
    copy: &mut FrameCopy<'_>,
    file: &FrameFile,
    target: &TargetChip,
    added: &[AddedLight],
) -> Result<(), Error> {
    let (Some(hdu), Some(gain)) = (target.variance_hdu, target.electrons_per_unit) else { return Ok(()) };
    let [_, columns] = file.image_size(hdu)?;
    let rows: Vec<&[AddedLight]> = added.chunk_by(|a, b| a.row == b.row).collect();
    for of_rows in rows.chunks(ROWS) {
        let before = file.read_rows(hdu, of_rows.iter().map(|of_row| of_row[0].row))?;
        for (of_row, before) in of_rows.iter().zip(before.chunks_exact(columns)) {
            for of_span in of_row.chunk_by(|a, b| a.column + 1 == b.column) {
                let variance = |light: &AddedLight| {
                    if before[light.column] > 0.0 { light.change_adu.max(0.0) / gain as f32 } else { 0.0 }
                };
                let variances: Vec<f32> = of_span.iter().map(variance).collect();
                copy.add(hdu, of_row[0].row, of_span[0].column, variances)?;
            }
        }
    }
    if !added.is_empty() {
        copy.add_history(hdu, "streakcast inject: variance of the added light, its counts divided by the gain")?;
    }
    Ok(())
}

fn mask(
    streaks: &[&DrawnStreak<'_>],
    added: &[AddedLight],
    target: &TargetChip,
    planes: &MaskPlanes,
    noise: &NoiseMap,
) -> Option<ImageValues<'static>> {
    let (rows, columns) = (target.chip.rows, target.chip.columns);
    let mut spans = mask_spans(streaks, columns, planes, noise);
    spans.extend(changed_spans(added, planes, noise));
    let pixels = if planes.streak_bit.max(planes.injected_bit) < 8 {
        let mut values = vec![0u8; rows * columns];
        for span in &spans {
            let start = span.row * columns + span.first_column;
            for (pixel, value) in values[start..].iter_mut().zip(&span.values) {
                *pixel |= *value as u8;
            }
        }
        Pixels::U8(values.into())
    } else {
        let mut values = vec![0i32; rows * columns];
        for span in &spans {
            let start = span.row * columns + span.first_column;
            for (pixel, value) in values[start..].iter_mut().zip(&span.values) {
                *pixel |= value;
            }
        }
        Pixels::I32(values.into())
    };
    ImageValues::new(columns, pixels)
}

fn append_masks(
    copy: &mut FrameCopy<'_>,
    frame: &TargetFrame,
    masks: Vec<(&TargetChip, ImageValues<'static>)>,
    planes: &MaskPlanes,
    taken: &mut Vec<(String, i64)>,
) -> Result<(), Error> {
    for (target, image) in masks {
        let card =
            |keyword: &str, value: i64, comment: &str| Card::with_value(keyword, &CardValue::Integer(value), comment);
        let mut cards = card("MP_STREAK", i64::from(planes.streak_bit), "bit: streak above the noise");
        cards.extend(card("MP_INJECTED", i64::from(planes.injected_bit), "bit: injected light"));
        let (name, more) = mask_name("STREAKMASK", frame, target, taken)?;
        cards.extend(more);
        copy.append_image(&name, image, &cards, None);
    }
    Ok(())
}

/// Returns the name of the mask of a chip, and the cards that state its version and its chip. The name contains that of
/// the chip if the frame has several. HDUs with the same name have different versions; `taken`
/// holds those of the other HDUs of the file.
pub(in crate::streaks) fn mask_name(
    name: &str,
    frame: &TargetFrame,
    target: &TargetChip,
    taken: &mut Vec<(String, i64)>,
) -> Result<(String, Vec<Card>), Error> {
    let hdu = target.chip.hdu;
    let chip = if target.chip.name.is_empty() { hdu.to_string() } else { target.chip.name.clone() };
    let name = if frame.chips.len() == 1 { name.to_owned() } else { format!("{name}_{chip}") };
    let own = frame.file.header(hdu)?.integer("EXTVER");
    let version = free_version(taken, &[&name], own);
    // The version of a name is 1 without EXTVER.
    let mut cards = if own.is_some() || version > 1 { version_card(version) } else { Vec::new() };
    cards.extend(Card::with_value("IMAGEHDU", &CardValue::Integer(hdu as i64), "masked HDU, counted from 0"));
    taken.push((name.clone(), version));
    Ok((name, cards))
}

/// Returns the names of the HDUs of a file, and their versions.
fn versions(file: &FrameFile) -> Result<Vec<(String, i64)>, Error> {
    let all = file.hdus().iter();
    all.map(|hdu| Ok((hdu.name.clone(), file.header(hdu.index)?.integer("EXTVER").unwrap_or(1)))).collect()
}

/// Returns `preferred`, or else the first version from 1, that is free for all of the names.
fn free_version(taken: &[(String, i64)], names: &[&str], preferred: Option<i64>) -> i64 {
    let is_taken = |version: i64| {
        taken.iter().any(|(name, other)| *other == version && names.iter().any(|own| own.eq_ignore_ascii_case(name)))
    };
    preferred.into_iter().chain(1..).find(|version| !is_taken(*version)).unwrap_or(1)
}

fn version_card(version: i64) -> Vec<Card> {
    Card::with_value("EXTVER", &CardValue::Integer(version), "version of the extension name")
}

/// Converts a table to the columns of a FITS table; times and lists become text.
fn fits_columns(table: &Table) -> Vec<TableColumn> {
    let column = |(index, column): (usize, &Column)| {
        let cells = table.rows.iter().map(|row| &row[index]);
        let cells = match column.kind {
            Kind::Real { .. } | Kind::Small { .. } => {
                Cells::Real(cells.map(|cell| if let Value::Real(number) = cell { *number } else { f64::NAN }).collect())
            }
            Kind::Integer => Cells::Integer(
                cells.map(|cell| if let Value::Integer(number) = cell { Some(*number) } else { None }).collect(),
            ),
            _ => Cells::Text(cells.map(|cell| column.text(cell)).collect()),
        };
        TableColumn {
            name: column.name.to_owned(),
            unit: column.unit.to_owned(),
            meaning: column.description.to_owned(),
            cells,
        }
    };
    table.columns.iter().enumerate().map(column).collect()
}
