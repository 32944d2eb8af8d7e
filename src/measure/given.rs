//! Measurement of streaks whose ends a table gives, such as those that a detector of streaks found.

use std::path::Path;
use std::sync::Arc;

use super::frame::{FrameMeasurements, FrameOptions, MeasuredPass, measure_predictions};
use super::measurement::{Flag, PredictedStreak};
use super::predict::{KnownSatellite, Prediction};
use super::streak::LEAST_LENGTH_PIX;
use crate::elements::NoradId;
use crate::error::Error;
use crate::frames::{Direction, Gcrs};
use crate::images::{PixelPosition, RowOrigin, StreakEnds, StreakRow, StreakTable};
use crate::photometry::SIZE_SIGMA;
use crate::streaks::{
    GivenColumns, GivenStreak, GivenWidth, PathNode, SkyTrack, StreakPath, TargetChip, TargetFrame, Tracking,
};
use crate::watch::Watch;

/// Largest number of streaks in a table.
const MOST_STREAKS: usize = 10_000;
/// Position error (one sigma) of an end across the streak if none is given, pixels.
const SIGMA_PIX: f64 = 3.0;
/// Margin around a chip in which the track of a streak is computed, pixels.
const MARGIN_PIX: f64 = 100.0;
/// Length by which the path of a streak extends beyond its ends, in sigmas of their errors.
const EXTENSION_SIGMAS: f64 = 4.0;

/// Row of a table of streaks.
#[derive(Clone, Debug)]
pub struct ListedStreak {
    /// Name of the streak: the column `id`, or the number of the row from 1.
    pub id: String,
    /// File of the frame as in the table; `None` for all frames.
    pub image: Option<String>,
    /// Table and line, for errors.
    pub(crate) origin: RowOrigin,
    /// Ends, times and width; `None` for a row without ends.
    pub given: Option<GivenStreak>,
    /// Satellite of the streak, from the columns `norad_id` and `name`, or from its identification.
    pub satellite: KnownSatellite,
    /// Probability that the streak is of this satellite; `None` if it was not identified.
    pub probability: Option<f64>,
}

/// Table of streaks to be measured.
#[derive(Clone, Debug)]
pub struct StreakList {
    /// The streaks.
    pub streaks: Vec<ListedStreak>,
    /// Remarks about the columns.
    pub remarks: Vec<String>,
    /// Errors of rows that cannot be read.
    pub invalid: Vec<Error>,
}

/// Streak of a table on one chip, with its measurement.
#[derive(Clone, Debug)]
pub struct ListedMeasurement {
    /// Name of the streak.
    pub id: String,
    /// File of the frame.
    pub image: String,
    /// HDU of the chip; `None` for a streak on none of the chips.
    pub hdu: Option<usize>,
    /// Satellite of the streak.
    pub satellite: KnownSatellite,
    /// Probability that the streak is of this satellite; `None` if it was not identified.
    pub probability: Option<f64>,
    /// Measurement, or the reason why there is none.
    pub measured: Result<Box<MeasuredPass>, Flag>,
}

impl StreakList {
    /// Reads a table: CSV, ECSV or FITS with the ends of streaks, streaks.txt of ASTRiDE, a catalog of findsat_mrt, or
    /// regions of DS9.
    ///
    /// # Errors
    /// The table cannot be read.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let names = [&GivenColumns::NAMES[..], &["name", "norad_id"]].concat();
        let (table, (columns, id, name, norad_id)) = StreakTable::read(path, MOST_STREAKS, &names, |rows| {
            Ok((GivenColumns::find(rows)?, rows.find("id"), rows.find("name"), rows.find("norad_id")))
        })?;
        let (mut streaks, mut invalid) = (Vec::new(), table.invalid().to_vec());
        let read = |row: &StreakRow<'_>| -> Result<ListedStreak, Error> {
            let norad_id = match row.text(norad_id) {
                "" => None,
                text => Some(NoradId(text.parse().map_err(|_| row.invalid("norad_id", text, "a catalogue number"))?)),
            };
            // Without a column `id` and without a catalogue number, `name` is the name of the streak.
            let is_satellite = norad_id.is_some() || id.is_some();
            let name: Arc<str> = if is_satellite { row.text(name).into() } else { "".into() };
            Ok(ListedStreak {
                id: row.id(),
                image: row.image().map(str::to_owned),
                origin: row.origin(),
                given: row.has_ends().then(|| GivenStreak::of_row(row, &columns)).transpose()?,
                satellite: KnownSatellite { norad_id, name, ..KnownSatellite::default() },
                probability: None,
            })
        };
        for row in table.rows() {
            match read(&row) {
                Ok(streak) => streaks.push(streak),
                Err(error) => invalid.push(error),
            }
        }
        Ok(Self { streaks, remarks: table.remarks(), invalid })
    }
}

impl ListedStreak {
    /// Returns the directions of the ends, and the side of a pixel, arcsec; `None` if they are unknown.
    pub fn on_sky(&self, frame: &TargetFrame) -> Option<([Direction<Gcrs>; 2], f64)> {
        let given = self.given.as_ref()?;
        let index = given.chip_index(&hdus(frame), frame.file.path()).ok()?.unwrap_or(0);
        let chip = &frame.chips[index].chip;
        let ends = match given.in_frame(frame.file.header(chip.hdu).ok()?).ends {
            StreakEnds::Sky(ends) => ends,
            StreakEnds::Pixels([from, to]) => [chip.wcs.to_sky(from)?, chip.wcs.to_sky(to)?],
        };
        Some((ends, chip.pixel_scale_arcsec()))
    }
}

fn hdus(frame: &TargetFrame) -> Vec<usize> {
    frame.chips.iter().map(|target| target.chip.hdu).collect()
}

/// Measures streaks of a table in a frame. A streak has at least one row: one for each chip that it reaches, or one
/// with the reason why it is not measured.
///
/// `place_sigma_arcsec` is the position error (one sigma) of the ends; three pixels if it is `None`. A streak with an
/// HDU or a time that is not of the frame has no row; `invalid` gets its error.
///
/// # Errors
/// Pixels cannot be read, or the image of a star cannot be drawn.
pub fn measure_listed(
    frame: &TargetFrame,
    streaks: &[ListedStreak],
    place_sigma_arcsec: Option<f64>,
    options: &FrameOptions<'_>,
    invalid: &mut Vec<Error>,
    watch: &Watch,
) -> Result<(Vec<ListedMeasurement>, FrameMeasurements), Error> {
    let mut predicted: Vec<Prediction> = Vec::new();
    // Index of the streak of each prediction, and the reasons why others have none.
    let (mut owners, mut reasons) = (Vec::new(), vec![Some(Flag::Outside); streaks.len()]);
    for (index, streak) in streaks.iter().enumerate() {
        let Some(given) = &streak.given else {
            reasons[index] = Some(Flag::NoEnds);
            continue;
        };
        let on_chips = given.chip_index(&hdus(frame), frame.file.path()).and_then(|chip| {
            let chips = chip.map_or(0..frame.chips.len(), |chip| chip..chip + 1);
            let on_chip = |number| placed(streak, given, frame, number, place_sigma_arcsec, options);
            chips.map(on_chip).collect::<Result<Vec<_>, Error>>()
        });
        let on_chips = match on_chips {
            Ok(on_chips) => on_chips,
            Err(error) => {
                invalid.push(streak.origin.of(error));
                reasons[index] = None;
                continue;
            }
        };
        for on_chip in on_chips {
            match on_chip {
                Ok(placed) => {
                    predicted.push(placed);
                    owners.push(index);
                    // A streak in the frame that has no measurement is on pixels without values.
                    reasons[index] = Some(Flag::Masked);
                }
                Err(reason) if reasons[index] == Some(Flag::Outside) => reasons[index] = Some(reason),
                Err(_) => {}
            }
        }
    }
    set_neighbours(&mut predicted);
    let (measured, done) = measure_predictions(frame, &predicted, options, watch)?;
    let mut rows: Vec<Vec<ListedMeasurement>> = vec![Vec::new(); streaks.len()];
    let row = |streak: &ListedStreak, hdu, measured| ListedMeasurement {
        id: streak.id.clone(),
        image: frame.file.path().display().to_string(),
        hdu,
        satellite: streak.satellite.clone(),
        probability: streak.probability,
        measured,
    };
    for (number, mut pass) in measured {
        let owner = owners[number];
        if is_open(&pass, &frame.chips[predicted[number].chip]) {
            pass.measured.flags.push(Flag::Open);
            pass.measured.flags.sort_unstable();
            if !pass.prediction.has_times && pass.prediction.satellite.norad_id.is_some() {
                // The light is that of an unknown part of the exposure: it does not give the magnitude of the
                // satellite.
                (pass.magnitude, pass.limit_mag, pass.faintest_mag) = (None, None, None);
            }
        }
        rows[owner].push(row(&streaks[owner], Some(pass.hdu), Ok(Box::new(pass))));
    }
    for ((streak, rows), reason) in streaks.iter().zip(&mut rows).zip(reasons) {
        if let Some(reason) = reason.filter(|_| rows.is_empty()) {
            let hdu = match (&streak.given, &frame.chips[..]) {
                (Some(given), _) if given.hdu.is_some() => given.hdu,
                (_, [only]) => Some(only.chip.hdu),
                _ => None,
            };
            rows.push(row(streak, hdu, Err(reason)));
        }
    }
    Ok((rows.into_iter().flatten().collect(), done))
}

/// Returns the track of a streak on a chip, or the reason why it cannot be measured there.
fn placed(
    streak: &ListedStreak,
    given: &GivenStreak,
    frame: &TargetFrame,
    number: usize,
    place_sigma_arcsec: Option<f64>,
    options: &FrameOptions<'_>,
) -> Result<Result<Prediction, Flag>, Error> {
    let chip = &frame.chips[number].chip;
    // A light of this magnitude has a rate of 1 in the unit of the frame per second.
    let Some((unit_mag, (centre, _))) = chip.scale.magnitude(1.0).zip(chip.circle()) else {
        return Ok(Err(Flag::Outside));
    };
    let given = given.in_frame(frame.file.header(chip.hdu)?);
    let time = (frame.opened, frame.exposure_s);
    let track: SkyTrack = given.track(chip, time, (&Tracking::Sidereal, &centre), unit_mag)?;
    let ends_s = [track.points[0].time_s, track.points[track.points.len() - 1].time_s];
    let scale_arcsec = chip.pixel_scale_arcsec();
    let cross_sigma_pix = place_sigma_arcsec.map_or(SIGMA_PIX, |sigma_arcsec| sigma_arcsec / scale_arcsec);
    let paths = chip.paths(&track, &Tracking::Sidereal, &centre, MARGIN_PIX)?;
    let inside = paths.into_iter().filter_map(|path| Some((path.inside_s?, path.path)));
    let lengths = inside.map(|([from_s, to_s], path)| (path.point_at(from_s).distance(path.point_at(to_s)), path));
    let Some((length_pix, path)) = lengths.max_by(|a, b| a.0.total_cmp(&b.0)) else {
        return Ok(Err(Flag::Outside));
    };
    if length_pix < LEAST_LENGTH_PIX as f64 {
        return Ok(Err(Flag::Short));
    }
    let (range_km, size_m) = match given.width {
        GivenWidth::Distance { range_km, size_m } => (Some(range_km), size_m),
        _ => (streak.satellite.range_km, None),
    };
    let image_fwhm_arcsec = match given.width {
        GivenWidth::Pixels(fwhm_pix) => Some(fwhm_pix * scale_arcsec),
        GivenWidth::Arcsec(fwhm_arcsec) => Some(fwhm_arcsec),
        GivenWidth::Unknown | GivenWidth::Distance { .. } => None,
    };
    // A given or fitted width contains the size.
    let has_angle = range_km.is_some() && image_fwhm_arcsec.is_none();
    let given_m = size_m.or(options.satellite_size_m).filter(|_| has_angle);
    let model_m = streak.satellite.model_size_m.filter(|_| has_angle && given_m.is_none());
    let size_m = given_m.or(model_m);
    Ok(Ok(Prediction {
        id: streak.id.as_str().into(),
        satellite: KnownSatellite { range_km, ..streak.satellite.clone() },
        is_position_known: true,
        has_times: given.has_times(),
        chip: number,
        image_fwhm_arcsec,
        size_m,
        neighbour_pix: None,
        streak: PredictedStreak {
            path: extended(&path, EXTENSION_SIGMAS * cross_sigma_pix)?,
            drift_pix_s: [0.0; 2],
            lateness_sigma_s: 0.0,
            largest_delay_s: 0.0,
            ends_s: Some(ends_s),
            cross_sigma_pix,
            // Without a distance, the width of the image is given or fitted.
            range_km: range_km.unwrap_or(PredictedStreak::FAR_KM),
            radius_m: 0.5 * size_m.unwrap_or(0.0),
            radius_sigma_m: 0.5 * SIZE_SIGMA * model_m.unwrap_or(0.0),
        },
    }))
}

/// Sets the distance of each streak from the nearest other one beside it on the same chip.
fn set_neighbours(predicted: &mut [Prediction]) {
    let samples: Vec<Vec<PixelPosition>> = predicted.iter().map(|prediction| along(&prediction.streak)).collect();
    for (index, own) in samples.iter().enumerate() {
        let chip = predicted[index].chip;
        let others = samples.iter().zip(&*predicted).enumerate();
        let others = others.filter(|(other, (_, prediction))| *other != index && prediction.chip == chip);
        let nearest = others.filter_map(|(_, (other, _))| distance_beside(own, other)).min_by(f64::total_cmp);
        predicted[index].neighbour_pix = nearest;
    }
}

/// Returns positions at equal times from one given end of a streak to the other.
fn along(streak: &PredictedStreak) -> Vec<PixelPosition> {
    const PARTS: u32 = 16;
    let [from_s, to_s] = streak.ends_s.unwrap_or_default();
    let time_s = |part: u32| from_s + (to_s - from_s) * f64::from(part) / f64::from(PARTS);
    (0..=PARTS).map(|part| streak.path.point_at(time_s(part))).collect()
}

/// Returns the mean distance of the positions along a streak from the line through another one, of those that are
/// beside that streak. `None` if none is, or if the streaks have different directions.
fn distance_beside(own: &[PixelPosition], other: &[PixelPosition]) -> Option<f64> {
    /// Sine of the largest angle between streaks beside each other.
    const LARGEST_SINE: f64 = 0.1;
    let direction = |streak: &[PixelPosition]| {
        let (first, last) = (streak[0], streak[streak.len() - 1]);
        let length = first.distance(last);
        (length, [(last.x - first.x) / length, (last.y - first.y) / length])
    };
    let (first, (length, [ex, ey])) = (other[0], direction(other));
    let (_, [x, y]) = direction(own);
    if (x * ey - y * ex).abs() > LARGEST_SINE {
        return None;
    }
    let beside = own.iter().filter_map(|at| {
        let [x, y] = [at.x - first.x, at.y - first.y];
        (0.0..=length).contains(&(x * ex + y * ey)).then(|| (y * ex - x * ey).abs())
    });
    let (sum, count) = beside.fold((0.0, 0.0), |(sum, count), distance| (sum + distance, count + 1.0));
    // Pieces of one line meet at their ends.
    (count > 1.0).then(|| sum / count)
}

/// Returns a path that is longer by `pix` at both ends, along its direction there.
fn extended(path: &StreakPath, pix: f64) -> Result<StreakPath, Error> {
    /// Smallest extension, pixels. The times of nodes differ by more than their rounding.
    const LEAST_PIX: f64 = 1e-3;
    let pix = pix.max(LEAST_PIX);
    let nodes = path.nodes();
    let beyond = |end: &PathNode, next: &PathNode| -> Option<PathNode> {
        let length = end.at.distance(next.at);
        let share = pix / length;
        let at = |end: f64, next: f64| end + share * (end - next);
        let at = PixelPosition { x: at(end.at.x, next.at.x), y: at(end.at.y, next.at.y) };
        (length > 0.0 && share.is_finite())
            .then(|| PathNode::new(end.time_s + share * (end.time_s - next.time_s), at, end.rate))
    };
    let (first, last) = (&nodes[0], &nodes[nodes.len() - 1]);
    let before = beyond(first, &nodes[1]);
    let after = beyond(last, &nodes[nodes.len() - 2]);
    let all = before.into_iter().chain(nodes.iter().copied()).chain(after).collect();
    StreakPath::new(all)
}

/// Returns true if an end of a streak is outside of the illuminated pixels, or nearer to their edge than its error: the
/// streak may continue there.
fn is_open(pass: &MeasuredPass, target: &TargetChip) -> bool {
    let area = &target.chip.light_area;
    let margin = pass.prediction.streak.cross_sigma_pix;
    let path = &pass.prediction.streak.path;
    pass.prediction.streak.ends_s.into_iter().flatten().any(|time_s| {
        let PixelPosition { x, y } = path.point_at(time_s);
        let is_within = |at: f64, range: &std::ops::Range<usize>| {
            (range.start as f64 - 0.5 + margin..=range.end as f64 - 0.5 - margin).contains(&at)
        };
        !(is_within(x, &area.columns) && is_within(y, &area.rows))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_parallel_streaks_are_beside_each_other() {
        let line = |from: [f64; 2], to: [f64; 2]| -> Vec<PixelPosition> {
            let at = |share: f64| [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]));
            (0..=16).map(|part| at(f64::from(part) / 16.0)).map(|[x, y]| PixelPosition { x, y }).collect()
        };
        let own = line([0.0, 0.0], [100.0, 0.0]);
        let distance = |from, to| distance_beside(&own, &line(from, to));
        assert_eq!(distance([20.0, 16.0], [80.0, 16.0]), Some(16.0));
        assert_eq!(distance([100.0, -4.0], [0.0, -4.0]), Some(4.0));
        assert!((distance([0.0, 4.0], [100.0, 8.0]).unwrap() - 6.0).abs() < 0.2);
        // A crossing streak, and the next piece of a broken one.
        assert_eq!(distance([40.0, -50.0], [60.0, 50.0]), None);
        assert_eq!(distance([100.0, 0.0], [200.0, 0.0]), None);
    }
}
