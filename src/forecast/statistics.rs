//! Statistics of a site as functions of the Sun's altitude: number and brightness of lit satellites above an altitude,
//! and expected trails in an exposure.
//!
//! Expected trails follow Bassa et al. (2022, A&A 657, A75). For pointings uniform over the sky above the altitude h,
//! the probability that a satellite is in the field at shutter opening is the solid angle of the field divided by that
//! of the sky above h. The probability that it enters the field later is the solid angle that the field's diameter
//! sweeps along the satellite's motion, divided by that of the sky above h. The sum over the lit satellites above the
//! altitude h is
//!
//! ```text
//! trails = Σ (π D²/4 + ω t D) / 2π (1 - sin h)
//! ```
//!
//! with the angular rate ω of each satellite, a circular field of diameter D and an exposure of length t. This is the
//! mean over uniform pointings above h. For other fields, π D²/4 is replaced by the area, and D by the mean width over
//! all directions of motion.

use std::f64::consts::{PI, TAU};

use hifitime::{Epoch, TimeScale};

use crate::constants::LONGEST_EXPOSURE_S;
use crate::error::Error;
use crate::frames::{OrientationTable, seconds_after, seconds_between};
use crate::geometry::{Observer, SunTable};
use crate::orbit::LeftOut;
use crate::output::{Column, Kind, Table, Value};
use crate::passes::{SatelliteSnapshot, SatelliteTrack, Sky, SnapshotOptions, intervals_where};
use crate::photometry::PhotometryOptions;

/// Magnitudes for which brighter satellites are counted.
const MAGNITUDES: [f64; 6] = [3.0, 4.0, 5.0, 6.0, 7.0, 8.0];
/// Sampling interval of the Sun's altitude, seconds.
const STEP_S: f64 = 60.0;

/// Request for counts of satellites.
#[derive(Clone, Debug, PartialEq)]
pub struct StatisticsRequest {
    /// Start of the range: local noon.
    pub start: Epoch,
    /// End of the range: the next noon.
    pub end: Epoch,
    /// Altitudes of the Sun at which satellites are counted, radians.
    pub sun_altitudes_rad: Vec<f64>,
    /// Lowest altitudes of the counted satellites, radians.
    pub min_altitudes_rad: Vec<f64>,
    /// Diameter of the field, radians; for a field that is not a circle its mean width, see
    /// [`Field::mean_width_deg`](crate::passes::Field::mean_width_deg).
    pub field_rad: f64,
    /// Area of the field, steradians; that of a circle if `None`.
    pub field_sr: Option<f64>,
    /// Exposure time, seconds.
    pub exposure_s: f64,
    /// Number of times over which each count is averaged, evenly spaced over [`Self::spread_s`].
    pub moments: usize,
    /// Interval over which each count is averaged, seconds, centred on the time of the Sun's altitude.
    pub spread_s: f64,
    /// If given, satellites brighter than this magnitude and their trails are counted, too.
    pub limit_mag: Option<f64>,
    /// Band, magnitude system and extinction of the magnitudes.
    pub photometry: PhotometryOptions,
}

/// Mean counts at one altitude of the Sun.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyCount {
    /// Time at which the Sun has this altitude: the middle of the averaged interval.
    pub epoch: Epoch,
    /// True if the Sun is setting, false if it is rising.
    pub evening: bool,
    /// Altitude of the Sun, radians.
    pub sun_altitude_rad: f64,
    /// Lowest altitude of the satellites counted, radians.
    pub min_altitude_rad: f64,
    /// Number of satellites above that altitude, lit or not.
    pub above: f64,
    /// Number of lit satellites above that altitude.
    pub lit: f64,
    /// Expected numbers of satellites brighter than the magnitudes 3, 4, ..., 8: sums of probabilities.
    pub brighter_than: [f64; 6],
    /// Expected number of trails in one exposure.
    pub trails: f64,
    /// Expected number of satellites brighter than the limit of the request; `None` without a limit.
    pub brighter_than_limit: Option<f64>,
    /// Expected number of trails brighter than the limit in one exposure: sum over the satellites of their expected
    /// number of trails times the probability of being brighter; `None` without a limit.
    pub trails_brighter_than_limit: Option<f64>,
}

impl SkyCount {
    /// Returns the fraction of exposures with at least one trail, 1 - exp(-trails), for independent trails.
    pub fn streaked_share(&self) -> f64 {
        -(-self.trails).exp_m1()
    }
}

/// Counts of one night (evening before morning, in the order of the requested altitudes of the Sun), altitudes that the
/// Sun does not reach, and satellites whose position cannot be computed.
pub type SkyCounts = (Vec<SkyCount>, Vec<f64>, Vec<LeftOut>);

/// Counts satellites at every altitude of the Sun, in the evening and in the morning.
///
/// # Errors
/// A number is out of range, the observer is in orbit, or the time is outside the planetary ephemerides.
pub fn sky_counts(sky: &Sky, request: &StatisticsRequest) -> Result<SkyCounts, Error> {
    request.check()?;
    // Positions along the orbit need not be known: only numbers of satellites are computed.
    let sky = &sky.clone().with_elements_of_any_age();
    let observer = sky.viewpoint().required_site()?;
    let (mut counts, mut missed, mut left_out) = (Vec::new(), Vec::new(), Vec::new());
    let moments = moments_of(sky, observer, request);
    for &sun_rad in &request.sun_altitudes_rad {
        if !moments.iter().any(|(reached_rad, ..)| *reached_rad == sun_rad) {
            missed.push(sun_rad);
        }
    }
    for evening in [true, false] {
        for &(sun_rad, epoch, _) in moments.iter().filter(|moment| moment.2 == evening) {
            let mut seen: Vec<Vec<SatelliteTrack>> = Vec::new();
            for moment in 0..request.moments {
                let share = (moment as f64 + 0.5) / request.moments as f64 - 0.5;
                let lowest_rad = request.min_altitudes_rad.iter().copied().fold(f64::INFINITY, f64::min);
                let at = seconds_after(epoch, share * request.spread_s);
                let (found, without) = sky.snapshots(at, &[0.0], &SnapshotOptions::all_above(lowest_rad))?;
                seen.push(found);
                left_out = without;
            }
            for &min_altitude_rad in &request.min_altitudes_rad {
                counts.push(count(sky, request, &seen, (epoch, evening, sun_rad, min_altitude_rad)));
            }
        }
    }
    Ok((counts, missed, left_out))
}

impl StatisticsRequest {
    fn check(&self) -> Result<(), Error> {
        let out_of_range = |what: &str, given: f64, unit: &str, allowed: &str| {
            Err(Error::invalid(what, format_args!("{given}{unit}"), allowed))
        };
        let bad = |angles: &[f64], from: f64, to: f64| {
            angles.iter().copied().find(|angle| !(from..=to).contains(&angle.to_degrees()))
        };
        if let Some(sun_rad) = bad(&self.sun_altitudes_rad, -90.0, 90.0) {
            return out_of_range("sun-altitude-deg", sun_rad.to_degrees(), " deg", "-90 to 90 deg");
        }
        if let Some(altitude_rad) = bad(&self.min_altitudes_rad, 0.0, 89.0) {
            return out_of_range("min-altitude", altitude_rad.to_degrees(), " deg", "0 to 89 deg");
        }
        if !(self.field_rad > 0.0 && self.field_rad <= PI) {
            return out_of_range("fov", self.field_rad.to_degrees(), " deg", "above 0 deg, at most 180 deg");
        }
        if let Some(area_sr) = self.field_sr.filter(|area_sr| !(*area_sr > 0.0 && *area_sr <= TAU)) {
            return out_of_range(
                "field",
                area_sr * 1f64.to_degrees().powi(2),
                " deg2",
                "above 0, at most 20626.5 deg2",
            );
        }
        if !(0.0..=LONGEST_EXPOSURE_S).contains(&self.exposure_s) {
            return out_of_range("exposure", self.exposure_s, " s", "0 to 86400 s");
        }
        if !(1..=10_000).contains(&self.moments) {
            return out_of_range("moments", self.moments as f64, "", "1 to 10000");
        }
        if !(0.0..=86_400.0).contains(&seconds_between(self.start, self.end)) {
            return out_of_range("length of the night", seconds_between(self.start, self.end), " s", "0 to 86400 s");
        }
        match self.limit_mag {
            Some(limit_mag) if !(-30.0..=40.0).contains(&limit_mag) => {
                out_of_range("limit-mag", limit_mag, " mag", "-30 to 40 mag")
            }
            _ => Ok(()),
        }
    }
}

/// Returns the altitudes of the Sun with the times at which it has them, and true for the evening.
fn moments_of(sky: &Sky, observer: &Observer, request: &StatisticsRequest) -> Vec<(f64, Epoch, bool)> {
    let orientation: OrientationTable = sky.orientation_over(request.start, request.end);
    let sun = SunTable::new(request.start, request.end);
    let span_s = seconds_between(request.start, request.end);
    let altitude_rad = |time_s: f64| observer.sun_altitude_rad(&orientation, &sun, time_s);
    let steps = (span_s / STEP_S).ceil().max(1.0) as usize;
    let at = |time_s: f64| seconds_after(request.start, time_s).to_time_scale(TimeScale::UTC);
    let mut found = Vec::new();
    for &sun_rad in &request.sun_altitudes_rad {
        for (from_s, until_s) in intervals_where(0.0, span_s, steps, |time_s| altitude_rad(time_s) < sun_rad) {
            found.extend((from_s > 0.0).then(|| (sun_rad, at(from_s), true)));
            found.extend((until_s < span_s).then(|| (sun_rad, at(until_s), false)));
        }
    }
    found
}

fn count(
    sky: &Sky,
    request: &StatisticsRequest,
    seen: &[Vec<SatelliteTrack>],
    (epoch, evening, sun_altitude_rad, min_altitude_rad): (Epoch, bool, f64, f64),
) -> SkyCount {
    let share = 1.0 / seen.len() as f64;
    let mut count = SkyCount {
        epoch,
        evening,
        sun_altitude_rad,
        min_altitude_rad,
        above: 0.0,
        lit: 0.0,
        brighter_than: [0.0; 6],
        trails: 0.0,
        brighter_than_limit: request.limit_mag.map(|_| 0.0),
        trails_brighter_than_limit: request.limit_mag.map(|_| 0.0),
    };
    // Ω = 2π (1 - sin h)
    let sky_sr = TAU * (1.0 - min_altitude_rad.sin());
    let snapshots =
        seen.iter().flatten().flat_map(|track| track.snapshots.iter().map(|snapshot| (track.element_index, snapshot)));
    let is_above = |snapshot: &SatelliteSnapshot| {
        snapshot.point.altitude_rad.is_some_and(|altitude_rad| altitude_rad >= min_altitude_rad)
    };
    for (element_index, snapshot) in snapshots.filter(|(_, snapshot)| is_above(snapshot)) {
        count.above += share;
        if snapshot.is_lit() {
            count.lit += share;
        } else if !request.photometry.band.is_thermal() {
            continue;
        }
        // (π D²/4 + ω t D) / Ω                                             Bassa et al. (2022), section 2
        let field_sr = request.field_sr.unwrap_or(0.25 * PI * request.field_rad * request.field_rad);
        let swept_sr = snapshot.angular_rate_rad_s * request.exposure_s * request.field_rad;
        let trails = (field_sr + swept_sr) / sky_sr;
        count.trails += share * trails;
        let light = sky.brightness(element_index, &snapshot.point, &request.photometry);
        let p_brighter =
            |limit_mag: f64| light.as_ref().map_or(0.0, |light| light.probability_brighter_than(limit_mag));
        for (limit, number) in MAGNITUDES.iter().zip(&mut count.brighter_than) {
            *number += share * p_brighter(*limit);
        }
        if let Some(limit_mag) = request.limit_mag {
            let expected = share * p_brighter(limit_mag);
            count.brighter_than_limit = count.brighter_than_limit.map(|sum| sum + expected);
            count.trails_brighter_than_limit = count.trails_brighter_than_limit.map(|sum| sum + expected * trails);
        }
    }
    count
}

const COLUMNS: [Column; 17] = [
    Column::time("utc", "Middle of the averaged times."),
    Column::new("twilight", Kind::Text, "Half of the night: evening or morning."),
    Column::real("latitude_deg", "deg", 4, "Latitude of the site."),
    Column::real("sun_altitude_deg", "deg", 2, "Altitude of the Sun's centre, without refraction."),
    Column::real("min_altitude_deg", "deg", 1, "Lowest altitude of the counted satellites and of the pointings."),
    Column::real("above", "", 2, "Satellites above min_altitude_deg, lit or not."),
    Column::real("lit", "", 2, "Satellites above min_altitude_deg in full or partial sunlight."),
    Column::real("brighter_than_3", "", 2, "Expected number of satellites brighter than magnitude 3."),
    Column::real("brighter_than_4", "", 2, "Expected number of satellites brighter than magnitude 4."),
    Column::real("brighter_than_5", "", 2, "Expected number of satellites brighter than magnitude 5."),
    Column::real("brighter_than_6", "", 2, "Expected number of satellites brighter than magnitude 6."),
    Column::real("brighter_than_7", "", 2, "Expected number of satellites brighter than magnitude 7."),
    Column::real("brighter_than_8", "", 2, "Expected number of satellites brighter than magnitude 8."),
    Column::real("field_deg", "deg", 4, "Full diameter of the field; mean width of a field that is not a circle."),
    Column::real("exposure_s", "s", 3, "Length of the exposure."),
    Column::real(
        "trails_per_exposure",
        "",
        5,
        "Expected number of trails of lit satellites in one exposure; in thermal bands of all.",
    ),
    Column::real("streaked_share", "", 5, "Expected fraction of exposures with at least one trail."),
];
const LIMIT_COLUMNS: [Column; 3] = [
    Column::real("limit_mag", "mag", 2, "Limit for which brighter satellites and trails are counted."),
    Column::real("brighter_than_limit", "", 2, "Expected number of satellites brighter than limit_mag."),
    Column::real(
        "trails_brighter_than_limit",
        "",
        5,
        "Expected number of trails in one exposure of satellites brighter than limit_mag.",
    ),
];

/// Returns counts as a table: one row for each night, latitude, altitude of the Sun and lowest altitude. Each row is
/// given with the latitude of its site in radians. Columns for a limiting magnitude are added if a request has one.
pub fn statistics_table<'a>(counts: impl IntoIterator<Item = (f64, &'a StatisticsRequest, &'a SkyCount)>) -> Table {
    let counts: Vec<_> = counts.into_iter().collect();
    let has_limit = counts.iter().any(|(_, request, _)| request.limit_mag.is_some());
    let row = |(latitude_rad, request, count): (f64, &StatisticsRequest, &SkyCount)| -> Vec<Value> {
        let mut row: Vec<Value> = vec![
            count.epoch.into(),
            if count.evening { "evening" } else { "morning" }.into(),
            latitude_rad.to_degrees().into(),
            count.sun_altitude_rad.to_degrees().into(),
            count.min_altitude_rad.to_degrees().into(),
            count.above.into(),
            count.lit.into(),
        ];
        row.extend(count.brighter_than.iter().map(|number| Value::Real(*number)));
        row.extend([
            request.field_rad.to_degrees().into(),
            request.exposure_s.into(),
            count.trails.into(),
            count.streaked_share().into(),
        ]);
        if has_limit {
            row.extend(
                [request.limit_mag, count.brighter_than_limit, count.trails_brighter_than_limit].map(Value::from),
            );
        }
        row
    };
    let rows = counts.into_iter().map(row).collect();
    let mut columns = COLUMNS.to_vec();
    if has_limit {
        columns.extend(LIMIT_COLUMNS);
    }
    Table { columns, rows }
}
