//! Streaks put into a copy of a frame: pixels, masks, tables of truth, and cards that say what was done.

use std::path::Path;

use thiserror::Error;

use super::super::drawn::DrawnStreak;
use super::super::truth::{
    MaskPlanes, TruthRow, changed_spans, mask_spans, noise_of, points_table, truth_rows, truth_table,
};
use super::target_frame::{TargetChip, TargetFrame};
use crate::images::{
    AddedLight, Bleeding, Card, CardValue, Cells, Changed, Detector, DetectorError, FrameCopy, FrameError, ImageValues,
    Patch, Pixels, Quantisation, Saturation, TableColumn,
};
use crate::output::{Column, Kind, Table, Value};

/// Why nothing was written.
#[derive(Debug, Error)]
pub enum InjectError {
    /// The files.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// The detector.
    #[error("HDU {hdu}: {source}")]
    Detector {
        /// The chip's HDU.
        hdu: usize,
        /// What is wrong.
        source: DetectorError,
    },
}

/// How light becomes counts, and what is told of it.
#[derive(Clone, Debug)]
pub struct InjectOptions {
    /// False adds the light alone; true adds the noise of its own electrons where the gain is known, and holds pixels below their saturation where that is
    /// known.
    pub noise: bool,
    /// A detector of one's own: its stages count instead. Its gain is not looked at: that of the frame counts ([`TargetChip::electrons_a_unit`]).
    pub detector: Option<Detector>,
    /// The same seed gives the same frame.
    pub seed: u64,
    /// Bits of the masks.
    pub planes: MaskPlanes,
    /// Masks and tables of truth in the file, and the light's variance where the file has a plane of variances.
    pub tell: bool,
    /// Lines of HISTORY: what was injected, from what.
    pub history: Vec<String>,
}

/// What was done to a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Injected {
    /// Pixels, all chips together.
    pub changed: Changed,
    /// HDUs whose gain is not known: their light has no noise.
    pub without_gain: Vec<usize>,
}

/// Writes a copy of the frame with streaks in it: every card, extension and table that was there is still there, and what was not touched is the same to the
/// last bit.
///
/// Where a chip has a plane of variances ([`TargetChip::variance_hdu`]) and the light has noise, that plane gets the variance of the light.
/// Behind the frame's own HDUs come, if they are wanted, one mask for each chip with streaks (`MASK`, or `MASK_<chip>` where there are several chips or a mask
/// of that name is there already) and the tables `STREAKS` and `STREAK_POINTS`. Chips without streaks stay untouched. Streaks are those of
/// [`crate::streaks::draw_on_chip`], in any order.
///
/// # Errors
/// [`InjectError`]; a file that stood at `output` is then still there.
pub fn inject(
    frame: &TargetFrame,
    streaks: &[DrawnStreak<'_>],
    options: &InjectOptions,
    output: &Path,
) -> Result<Injected, InjectError> {
    let mut copy = FrameCopy::begin(&frame.file, output)?;
    let mut report = Injected::default();
    let mut masks = Vec::new();
    for target in &frame.chips {
        let own: Vec<&DrawnStreak<'_>> = streaks.iter().filter(|streak| streak.hdu == target.chip.hdu).collect();
        if own.is_empty() {
            continue;
        }
        let detector = detector(target, options);
        if (options.noise || options.detector.is_some()) && detector.is_none() {
            report.without_gain.push(target.chip.hdu);
        }
        let noise = if options.tell { noise_of_chip(frame, target)? } else { 0.0 };
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
        if has_noise && options.tell {
            add_variance(&mut copy, target, &added)?;
        }
        if options.tell {
            masks.extend(mask(&own, &added, target, &options.planes, noise).map(|mask| (target, mask)));
        }
    }
    if options.tell {
        append_masks(&mut copy, frame, masks, &options.planes)?;
        let rows: Vec<TruthRow<'_>> = truth_rows(streaks, frame.exposure_s, options.seed);
        let cards: Vec<Card> = options.history.iter().flat_map(|line| Card::remark("HISTORY", line)).collect();
        copy.append_table("STREAKS", &fits_columns(&truth_table(&rows)), &cards)?;
        copy.append_table("STREAK_POINTS", &fits_columns(&points_table(&rows)), &[])?;
    }
    for (hdu, changed) in copy.finish()? {
        if frame.chips.iter().any(|target| target.chip.hdu == hdu) {
            report.changed += changed;
        }
    }
    Ok(report)
}

/// What turns the light of a chip into counts; `None` adds the light as it is.
fn detector(target: &TargetChip, options: &InjectOptions) -> Option<Detector> {
    if !options.noise && options.detector.is_none() {
        return None;
    }
    let gain_e_adu = target.electrons_a_unit?;
    Some(match &options.detector {
        Some(detector) => Detector { gain_e_adu, shot_noise: detector.shot_noise && options.noise, ..detector.clone() },
        None => {
            let saturation =
                target.saturation.map(|level| Saturation { full_well_e: level * gain_e_adu, bleeding: Bleeding::Off });
            Detector { gain_e_adu, saturation, quantisation: quantisation(target), ..Detector::default() }
        }
    })
}

/// Whole counts, where the frame has such: light of less than a count is then not lost by rounding, but makes a count now and then. Numbers of 32 bits are
/// too many for single precision, and rounding to one in millions loses nothing.
fn quantisation(target: &TargetChip) -> Option<Quantisation> {
    let (least_adu, greatest_adu) = target.whole_range?;
    (greatest_adu <= 65_535.0 && least_adu >= -65_536.0).then_some(Quantisation { least_adu, greatest_adu })
}

/// Light alone.
fn add<'a>(copy: &mut FrameCopy<'a>, target: &TargetChip, streaks: &[&'a DrawnStreak<'_>]) -> Result<(), FrameError> {
    let mut spans = streaks.iter().flat_map(|streak| streak.patch.iter());
    spans.try_for_each(|span| copy.add(target.chip.hdu, span.row, span.first_column, span.values))
}

/// One sigma of a chip's pixels, from some of its rows.
fn noise_of_chip(frame: &TargetFrame, target: &TargetChip) -> Result<f32, FrameError> {
    const ROWS: usize = 48;
    let (hdu, lit) = (target.chip.hdu, &target.chip.light_area);
    let rows = lit.rows.clone().step_by(lit.rows.len().div_ceil(ROWS).max(1));
    let values = frame.file.read_rows(hdu, rows)?;
    let lit_of_rows = values.chunks(target.chip.columns).flat_map(|row| &row[lit.columns.clone()]);
    Ok(noise_of(&lit_of_rows.map(|value| *value as f32).collect::<Vec<_>>()))
}

/// Light through a detector: the whole chip is read, since full wells hold the sum of what was there and what is added. What it made of the pixels that are lit,
/// in their order.
fn expose(
    copy: &mut FrameCopy<'_>,
    frame: &TargetFrame,
    target: &TargetChip,
    streaks: &[&DrawnStreak<'_>],
    detector: &Detector,
    seed: u64,
) -> Result<Vec<AddedLight>, InjectError> {
    let (hdu, lit) = (target.chip.hdu, &target.chip.light_area);
    let before = frame.file.read_plane(hdu)?;
    let electrons = |patch: &Patch| {
        let mut patch = patch.clone();
        patch.scale(detector.gain_e_adu as f32);
        patch
    };
    let patches: Vec<Patch> = streaks.iter().map(|streak| electrons(&streak.patch)).collect();
    // Every chip has random numbers of its own.
    let seed = seed ^ (hdu as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let failed = |source| InjectError::Detector { hdu, source };
    let (mut added, _) = detector.light_on(&before, &patches, seed).map_err(failed)?;
    // Charge that bled out of what is lit went to the registers.
    added.retain(|light| lit.rows.contains(&light.row) && lit.columns.contains(&light.column));
    for of_row in added.chunk_by(|a, b| a.row == b.row) {
        let first = of_row[0].column;
        let mut values = vec![0.0; of_row[of_row.len() - 1].column + 1 - first];
        of_row.iter().for_each(|light| values[light.column - first] = light.change_adu);
        copy.add(hdu, of_row[0].row, first, values)?;
    }
    Ok(added)
}

/// Into the plane of variances, where there is one: light of n electrons has a variance of n, in the frame's unit n / gain². As in the pipelines that
/// wrote the plane, n is what was counted and not what was expected.
fn add_variance(copy: &mut FrameCopy<'_>, target: &TargetChip, added: &[AddedLight]) -> Result<(), FrameError> {
    let (Some(hdu), Some(gain)) = (target.variance_hdu, target.electrons_a_unit) else { return Ok(()) };
    for of_span in added.chunk_by(|a, b| (a.row, a.column + 1) == (b.row, b.column)) {
        let variances: Vec<f32> = of_span.iter().map(|light| light.change_adu.max(0.0) / gain as f32).collect();
        copy.add(hdu, of_span[0].row, of_span[0].column, variances)?;
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
    noise: f32,
) -> Option<ImageValues> {
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
        Pixels::U8(values)
    } else {
        let mut values = vec![0i32; rows * columns];
        for span in &spans {
            let start = span.row * columns + span.first_column;
            for (pixel, value) in values[start..].iter_mut().zip(&span.values) {
                *pixel |= value;
            }
        }
        Pixels::I32(values)
    };
    ImageValues::new(columns, pixels)
}

fn append_masks(
    copy: &mut FrameCopy<'_>,
    frame: &TargetFrame,
    masks: Vec<(&TargetChip, ImageValues)>,
    planes: &MaskPlanes,
) -> Result<(), FrameError> {
    let taken = |name: &str| frame.file.hdus().iter().any(|hdu| hdu.name.eq_ignore_ascii_case(name));
    let one = frame.chips.len() == 1 && !taken("MASK");
    for (target, image) in masks {
        let chip = if target.chip.name.is_empty() { target.chip.hdu.to_string() } else { target.chip.name.clone() };
        let name = if one { "MASK".to_owned() } else { format!("MASK_{chip}") };
        let card =
            |keyword: &str, value: i64, comment: &str| Card::with_value(keyword, &CardValue::Integer(value), comment);
        let mut cards = card("MP_STREAK", i64::from(planes.streak_bit), "bit: a streak stands out");
        cards.extend(card("MP_INJECTED", i64::from(planes.injected_bit), "bit: holds injected light"));
        cards.extend(card("IMAGEHDU", target.chip.hdu as i64, "HDU that it masks, the first being 0"));
        copy.append_image(&name, &image, &cards, None);
    }
    Ok(())
}

/// A table as columns of a FITS file; moments and lists are text.
fn fits_columns(table: &Table) -> Vec<TableColumn> {
    let column = |(index, column): (usize, &Column)| {
        let cells = table.rows.iter().map(|row| &row[index]);
        let cells = match column.kind {
            Kind::Real { .. } => {
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
