//! Forecast of a night: dark intervals, visible passes, and the reason if there are no passes.

use std::cmp::Ordering;

use std::collections::HashSet;

use hifitime::{Epoch, TimeScale};

use super::pass_table::PassRow;
use super::request::{ForecastRequest, PassOrder};
use super::selection::Selection;
use super::selection::empty_selection;
use crate::constants::DAY_S;
use crate::elements::ElementSet;
use crate::error::{Error, ErrorKind};
use crate::frames::{seconds_after, seconds_between};
use crate::geometry::SunTable;
use crate::orbit::{EphemerisCoverage, LeftOut};
use crate::output::{Column, Kind, Table, Value, counted, format_utc};
use crate::passes::{BrightnessLimit, Sky, VisiblePass, VisiblePasses, VisibleRequest, intervals_where};
use crate::photometry::MagnitudeSource;

/// Sampling interval of the Sun's altitude, seconds; the altitude changes by at most 0.25° in this time.
const STEP_S: f64 = 60.0;

/// Time range at a site, with the intervals in which the Sun is below a limit.
#[derive(Clone, Debug, PartialEq)]
pub struct Night {
    /// Start.
    pub start: Epoch,
    /// End.
    pub end: Epoch,
    /// Upper limit of the Sun's altitude, radians; `None` for no limit.
    pub max_sun_altitude_rad: Option<f64>,
    /// Intervals in which the Sun is below the limit, in time order.
    pub dark: Vec<(Epoch, Epoch)>,
    /// Lowest altitude of the Sun's centre in the range, radians, without refraction.
    pub lowest_sun_rad: f64,
    /// Time of the lowest altitude.
    pub lowest_sun_at: Epoch,
}

impl Night {
    /// Finds the dark intervals from `start` to `end` at the site of a sky. `end` must not be before `start`.
    ///
    /// # Errors
    /// The observer is in orbit.
    pub fn over(sky: &Sky, start: Epoch, end: Epoch, max_sun_altitude_rad: Option<f64>) -> Result<Self, Error> {
        let observer = sky.viewpoint().required_site()?;
        let (orientation, sun) = (sky.orientation_over(start, end), SunTable::new(start, end));
        let span_s = seconds_between(start, end).max(0.0);
        let altitude_rad = |time_s: f64| observer.sun_altitude_rad(&orientation, &sun, time_s);
        let steps = (span_s / STEP_S).ceil().max(1.0) as usize;
        let (lowest_s, lowest_sun_rad) = (0..=steps)
            .map(|step| span_s * step as f64 / steps as f64)
            .map(|time_s| (time_s, altitude_rad(time_s)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or((0.0, f64::NAN));
        let epoch = |time_s: f64| seconds_after(start, time_s).to_time_scale(TimeScale::UTC);
        let dark = match max_sun_altitude_rad {
            Some(limit_rad) => intervals_where(0.0, span_s, steps, |time_s| altitude_rad(time_s) < limit_rad)
                .into_iter()
                .map(|(from_s, until_s)| (epoch(from_s), epoch(until_s)))
                .collect(),
            None => vec![(start, end)],
        };
        Ok(Self { start, end, max_sun_altitude_rad, dark, lowest_sun_rad, lowest_sun_at: epoch(lowest_s) })
    }

    /// Returns the total length of the dark intervals, seconds.
    pub fn dark_s(&self) -> f64 {
        self.dark.iter().map(|(from, until)| seconds_between(*from, *until)).sum()
    }

    /// Returns the reason why the Sun is always above the limit; `None` if it is not.
    pub fn why_never_dark(&self, site: &str) -> Option<String> {
        let limit_rad = self.max_sun_altitude_rad.filter(|_| self.dark.is_empty())?;
        Some(format!(
            "it does not get dark at {site} between {} and {}: the lowest altitude of the Sun is {:.1} deg (at {}), above the limit of {:.1} deg",
            format_utc(self.start, 0),
            format_utc(self.end, 0),
            self.lowest_sun_rad.to_degrees(),
            format_utc(self.lowest_sun_at, 0),
            limit_rad.to_degrees(),
        ))
    }
}

/// Night with its visible passes.
#[derive(Clone, Debug, PartialEq)]
pub struct Forecast {
    /// The night.
    pub night: Night,
    /// Visible passes, and counts of the omitted passes.
    pub found: VisiblePasses,
    /// Number of selected satellites whose times are uncertain by more than a minute in the middle of the night (one
    /// sigma), and the largest of their sigmas, seconds.
    pub late: (usize, f64),
}

/// Error of the times, seconds, above which a pass may be visible although the predicted one is not: the Earth's shadow
/// moves along a pass of some minutes.
const UNCERTAIN_S: f64 = 60.0;

/// Computes all visible passes of the selected satellites. It uses all threads of the current thread pool.
///
/// # Errors
/// A number is out of range, no satellite is selected, the observer is in orbit, or the time is outside the planetary
/// ephemerides.
pub fn forecast(sky: &Sky, request: &ForecastRequest, selection: &Selection) -> Result<Forecast, Error> {
    request.check()?;
    let satellites = sky.elements().len();
    let selected = selection.among(sky.elements());
    if selected.is_empty() {
        return Err(empty_selection(satellites, &selection.description()));
    }
    let night = Night::over(sky, request.start, request.end, request.max_sun_altitude_rad)?;
    let mut found = sky.visible_passes(
        &VisibleRequest {
            start: request.start,
            end: request.end,
            dark: night.dark.clone(),
            min_altitude_rad: request.min_altitude_rad,
            min_culmination_rad: request.min_culmination_rad,
            limit: request.max_magnitude.map(|magnitude| BrightnessLimit {
                magnitude,
                min_probability: request.min_probability,
                twilight: request.twilight,
            }),
            include_dark: request.include_dark,
            samples: request.samples,
            photometry: request.photometry,
        },
        &|element_index| selected.contains(&sky.elements()[element_index]),
    )?;
    if request.order == PassOrder::Brightness {
        // The sort is stable: passes that are equally bright stay in the order of time.
        found.passes.sort_by(|a, b| {
            b.p_brighter.partial_cmp(&a.p_brighter).unwrap_or(Ordering::Equal).then_with(|| {
                let magnitude =
                    |pass: &VisiblePass| pass.peak_brightness().map_or(f64::INFINITY, |light| light.magnitude.0);
                magnitude(a).total_cmp(&magnitude(b))
            })
        });
    }
    let middle = seconds_after(request.start, 0.5 * seconds_between(request.start, request.end));
    let with_ephemeris: HashSet<usize> = sky
        .ephemeris_coverage(request.start, request.end)
        .filter(|(_, coverage)| *coverage != EphemerisCoverage::None)
        .map(|(index, _)| index)
        .collect();
    let is_meant = |(index, set): &(usize, &ElementSet)| selected.contains(set) && !with_ephemeris.contains(index);
    let elements = sky.elements().iter().enumerate().filter(is_meant);
    let late = elements
        .map(|(index, set)| {
            let age_days = seconds_between(set.epoch, middle) / DAY_S;
            if sky.is_known(index, age_days) { sky.uncertainty(index, age_days).along_track_s } else { 0.0 }
        })
        .filter(|sigma_s| *sigma_s > UNCERTAIN_S)
        .fold((0, 0.0), |(count, largest_s), sigma_s| (count + 1, sigma_s.max(largest_s)));
    Ok(Forecast { night, found, late })
}

impl Forecast {
    /// Returns the rows of the passes for tables. `sky` is that of the forecast.
    #[doc(hidden)]
    pub fn rows<'a>(&'a self, sky: &'a Sky) -> impl Iterator<Item = PassRow<'a>> {
        let (range, dark) = ((self.night.start, self.night.end), self.night.dark.as_slice());
        let elements = sky.elements();
        self.found.passes.iter().map(move |pass| PassRow { pass, elements: &elements[pass.element_index], range, dark })
    }

    /// Returns a warning if brightest points are outside the fitted ranges of the models.
    pub fn fitted_range_warning(&self) -> Option<String> {
        let with_light = self.found.passes.iter().filter_map(|pass| Some((pass, pass.peak_brightness()?)));
        let count = with_light.clone().count();
        let outside: Vec<_> = with_light.filter(|(_, light)| !light.in_fitted_range).map(|(pass, _)| pass).collect();
        (!outside.is_empty()).then(|| {
            let (is, their) = if outside.len() == 1 { ("is", "its sigma is") } else { ("are", "their sigmas are") };
            let passes = counted(count, "pass", "passes");
            let expected: f64 = outside.iter().filter_map(|pass| pass.p_brighter).sum();
            let expected =
                if expected > 0.0 { format!(" ({expected:.1} expected above the limit)") } else { String::new() };
            format!(
                "{} of {passes}{expected} {is} brightest where no photometry was fitted; {their} larger",
                outside.len()
            )
        })
    }

    /// Returns the number of satellites whose passes are unknown, because their elements are too old.
    pub fn unknown(&self) -> usize {
        let is_unknown = |satellite: &&LeftOut| satellite.reason.kind() == ErrorKind::UnknownPosition;
        self.found.left_out.iter().filter(is_unknown).count()
    }

    /// Returns true if passes are in the Earth's shadow, and the times of most satellites are uncertain by more than a
    /// minute.
    fn is_uncertain(&self) -> bool {
        self.found.not_shown.in_shadow > 0 && 2 * self.late.0 > self.found.satellites
    }

    /// Returns true if a night without visible passes may have some: the elements of some satellites are too old, or
    /// the times of most satellites are uncertain.
    pub fn may_have_passes(&self) -> bool {
        !self.night.dark.is_empty() && (self.unknown() > 0 || self.is_uncertain())
    }

    /// Returns the reason why no pass over the site is visible; `None` if there is one.
    pub fn why_empty(&self, sky: &Sky, request: &ForecastRequest) -> Option<String> {
        if !self.found.passes.is_empty() {
            return None;
        }
        let site = sky.viewpoint().site().map_or("the site", |observer| observer.site().name.as_str());
        if let Some(why) = self.night.why_never_dark(site).filter(|_| !request.include_dark) {
            return Some(why);
        }
        let count = &self.found.not_shown;
        let satellites = self.found.satellites;
        let passes = |count: usize| counted(count, "pass", "passes");
        let verb = |count: usize, singular: &'static str, many: &'static str| if count == 1 { singular } else { many };
        let mut reasons = Vec::new();
        if count.in_shadow > 0 {
            let (passes, is) = (passes(count.in_shadow), verb(count.in_shadow, "is", "are"));
            reasons.push(format!("{passes} {is} in the Earth's shadow while it is dark at {site}"));
        }
        if count.too_low > 0 {
            let lowest_deg = request.min_culmination_rad.to_degrees();
            let culminates = verb(count.too_low, "culminates", "culminate");
            reasons.push(format!("{} {culminates} below {lowest_deg:.1} deg", passes(count.too_low)));
        }
        if let Some(limit) = request.max_magnitude.filter(|_| count.too_faint > 0) {
            let is = verb(count.too_faint, "is", "are");
            let least = 100.0 * request.min_probability;
            let passes = passes(count.too_faint);
            reasons.push(format!("{passes} {is} brighter than mag {limit} with a probability below {least:.0} %"));
        }
        let unknown = self.unknown();
        if unknown > 0 {
            reasons.push(format!("the elements of {unknown} of {satellites} satellites are too old to predict passes"));
        }
        if reasons.is_empty() {
            let lowest_deg = request.min_altitude_rad.to_degrees();
            let of = if satellites == 1 {
                "the only satellite does not rise".to_owned()
            } else {
                format!("none of {satellites} satellites rises")
            };
            let when = if request.include_dark { String::new() } else { format!(" while it is dark at {site}") };
            reasons.push(format!("{of} above {lowest_deg:.1} deg{when} within the requested interval"));
        }
        if self.is_uncertain() {
            let (count, largest_s) = self.late;
            let are = if count == 1 { "is" } else { "are" };
            let times =
                format!("the times of {count} of {satellites} satellites {are} uncertain by up to {largest_s:.0} s");
            reasons.push(format!("{times}, so that a pass may be visible"));
        }
        Some(reasons.join("; "))
    }

    /// Returns a warning with the number of passes whose satellites have only a default brightness model, both listed
    /// and omitted as too faint; `None` if there are none.
    pub fn prior_warning(&self, sky: &Sky, max_magnitude: Option<f64>) -> Option<String> {
        let is_prior = |pass: &&VisiblePass| *sky.model(pass.element_index).source() == MagnitudeSource::Prior;
        let shown = self.found.passes.iter().filter(|pass| pass.visible.is_some()).filter(is_prior).count();
        let hidden = self.found.not_shown.too_faint_by_prior;
        let passes = |count: usize| counted(count, "pass", "passes");
        let mut parts = Vec::new();
        if shown > 0 {
            parts.push(format!("{} shown", passes(shown)));
        }
        if let Some(limit) = max_magnitude.filter(|_| hidden > 0) {
            parts.push(format!("{} omitted as probably fainter than mag {limit}", passes(hidden)));
        }
        let parts = (!parts.is_empty()).then(|| parts.join(", "))?;
        Some(format!(
            "the brightness of some satellites is unknown: their magnitudes are only a wide prior ({parts}); specify standard magnitudes with --qs-mag FILE"
        ))
    }
}

const NIGHT_COLUMNS: [Column; 13] = [
    Column::time("start_utc", "Start of the requested interval."),
    Column::time("end_utc", "End of the requested interval."),
    Column::real(
        "sun_altitude_limit_deg",
        "deg",
        3,
        "Upper limit of the Sun's altitude for a visible pass; empty if there is no limit.",
    ),
    Column::time("dark_from_utc", "Start of the first dark interval; empty if it does not get dark."),
    Column::time("dark_until_utc", "End of the last dark interval; empty if it does not get dark."),
    Column::real("dark_h", "h", 4, "Total duration of darkness."),
    Column::real("lowest_sun_altitude_deg", "deg", 3, "Lowest altitude of the Sun's centre, without refraction."),
    Column::time("lowest_sun_utc", "Time of the Sun's lowest altitude."),
    Column::new(
        "passes_in_shadow",
        Kind::Integer,
        "Passes omitted because the satellite is in the Earth's shadow whenever it is dark at the site.",
    ),
    Column::new("passes_too_faint", Kind::Integer, "Passes omitted because of the magnitude limit."),
    Column::new("passes_too_low", Kind::Integer, "Passes omitted because they culminate too low."),
    Column::new("why_empty", Kind::Text, "Reason why there is no pass; empty if there is one."),
    Column::real(
        "expected_brighter",
        "",
        2,
        "Expected number of visible passes brighter than the magnitude limit: the sum of p_brighter, those omitted as too faint included; empty without a limit.",
    ),
];

/// Returns the night of a forecast as a table of one row, with the reason if no pass is visible.
pub fn night_table(forecast: &Forecast, why_empty: Option<&str>) -> Table {
    let (night, count) = (&forecast.night, &forecast.found.not_shown);
    let row: Vec<Value> = vec![
        night.start.into(),
        night.end.into(),
        night.max_sun_altitude_rad.map(f64::to_degrees).into(),
        night.dark.first().map(|dark| dark.0).into(),
        night.dark.last().map(|dark| dark.1).into(),
        (night.dark_s() / 3600.0).into(),
        night.lowest_sun_rad.to_degrees().into(),
        night.lowest_sun_at.into(),
        count.in_shadow.into(),
        count.too_faint.into(),
        count.too_low.into(),
        why_empty.into(),
        forecast.found.expected_brighter.into(),
    ];
    Table { columns: NIGHT_COLUMNS.to_vec(), rows: vec![row] }
}
