//! Computations of a model: sky cache with field of view, telescope, policy and photometry options.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use hifitime::Epoch;
use numpy::{IntoPyArray, PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use streakcast::config::{Config, PreparedSky};
use streakcast::frames::seconds_after;
use streakcast::images::Telescope;
use streakcast::output::{Column, Table};
use streakcast::passes::{
    Exposure, Field, Pass, PassOptions, SatelliteSnapshot, SatelliteTrack, SnapshotOptions, SnapshotPositions,
};
use streakcast::photometry::{Brightness, PhotometryOptions};
use streakcast::schedule::{
    Blocking, BrightStreaks, ClearWindow, FlagReport, FlagRequest, FlagTotals, Policy, ScheduledExposure,
    StreakColumns, StreakRow, Verdict, VerdictKind, WindowRequest, WindowTarget, clear_windows_without_passes,
    flag_exposures, flag_table, judge_exposures, streak_table,
};
use streakcast::{ErrorKind, Watch};

use crate::columns::{columns, times};
use crate::exposures::{Columns, rows, scale_name, start_of, within};
use crate::failure;
use crate::sky_cache::{SkyCache, setup_of};

/// Result with its warnings.
pub(crate) type WithWarnings<T> = (T, Vec<String>);

/// Sky cache with a field, a telescope, a policy and a band.
#[pyclass(frozen, module = "streakcast._core")]
pub struct Engine {
    pub(crate) sky_cache: Py<SkyCache>,
    /// Field of view, or the error message if there is none.
    pub(crate) field: Result<Field, String>,
    pub(crate) telescope: Option<Telescope>,
    pub(crate) policy: Policy,
    pub(crate) photometry: PhotometryOptions,
    time_scale: Option<String>,
    default_samples: usize,
    default_rotation_deg: f64,
    pub(crate) setup: Config,
}

/// Requirements for clear windows: blocking satellites (those of the policy if `None`), altitude limits of pointing and
/// Sun.
struct Limits {
    blocking: Option<Blocking>,
    min_altitude_rad: f64,
    max_sun_altitude_rad: Option<f64>,
}

/// Indices of the rows of one night, with the prepared sky.
struct Night {
    prepared: PreparedSky,
    indices: Vec<usize>,
}

impl Engine {
    pub(crate) fn field(&self) -> PyResult<&Field> {
        self.field.as_ref().map_err(|message| failure::SetupError::new_err(message.clone()))
    }

    pub(crate) fn request<'a>(&'a self, field: &'a Field, prepared: &'a PreparedSky) -> FlagRequest<'a> {
        FlagRequest {
            sky: &prepared.sky,
            field,
            policy: &self.policy,
            telescope: self.telescope.as_ref(),
            photometry: &self.photometry,
        }
    }

    /// Returns whether satellites in the Earth's shadow are included: as given, or else as in the configuration file.
    pub(crate) fn includes_dark(&self, given: Option<bool>) -> bool {
        given.or(self.setup.include_dark).unwrap_or(false)
    }

    fn nights(&self, starts: impl Iterator<Item = Epoch>, watch: &Watch) -> PyResult<Vec<Night>> {
        let sky_cache = self.sky_cache.get();
        let mut nights: BTreeMap<i64, (Epoch, Vec<usize>)> = BTreeMap::new();
        for (index, start) in starts.enumerate() {
            watch.check().map_err(failure::request)?;
            nights.entry(sky_cache.night_of(start)).or_insert((start, Vec::new())).1.push(index);
        }
        let night = |(start, indices)| Ok(Night { prepared: sky_cache.sky_at(start, watch)?, indices });
        nights.into_values().map(night).collect()
    }

    /// Computes verdicts for each night, and returns them in the order of the rows. Invalid rows have the verdict
    /// `invalid`. `each` is called with the sky, the rows and the verdicts of each night.
    pub(crate) fn report(
        &self,
        rows: &[ScheduledExposure],
        policy: &Policy,
        judge: impl Fn(&[&ScheduledExposure], &FlagRequest<'_>) -> Result<FlagReport, streakcast::Error>,
        each: &mut dyn FnMut(&PreparedSky, &[&ScheduledExposure], &mut [Verdict]),
        watch: &Watch,
    ) -> PyResult<WithWarnings<Vec<Verdict>>> {
        let field = self.field()?;
        let mut flags: Vec<Option<Verdict>> =
            rows.iter().map(|row| Some(Verdict::invalid(&row.id, row.exposure.as_ref().err()?.clone()))).collect();
        let mut warnings = Vec::new();
        let mut totals = FlagTotals::default();
        let (valid, starts): (Vec<usize>, Vec<Epoch>) = rows
            .iter()
            .enumerate()
            .filter_map(|(row, scheduled)| Some((row, scheduled.exposure.as_ref().ok()?.start)))
            .unzip();
        for Night { prepared, indices } in self.nights(starts.iter().copied(), watch)? {
            let night_rows: Vec<&ScheduledExposure> = indices.iter().map(|index| &rows[valid[*index]]).collect();
            let mut report = judge(&night_rows, &FlagRequest { policy, ..self.request(field, &prepared) })
                .map_err(failure::request)?;
            warnings.extend(left_out(&prepared, &report.left_out, starts[indices[0]])?);
            totals.add(&report);
            each(&prepared, &night_rows, &mut report.flags);
            for (index, flag) in indices.into_iter().zip(report.flags) {
                flags[valid[index]] = Some(flag);
            }
        }
        warnings.extend(totals.warnings());
        let bands = rows.iter().map(|row| row.band.as_deref()).collect();
        warnings.extend(policy.band_warnings(&bands));
        Ok((flags.into_iter().flatten().collect(), warnings))
    }
}

/// Rejects a request for times at which the positions of the satellites are unknown.
fn check_known(prepared: &PreparedSky, times: impl IntoIterator<Item = Epoch>, field: Option<&Field>) -> PyResult<()> {
    let reason = times.into_iter().find_map(|time| prepared.sky.predictability(time, field).reason());
    reason.map_or(Ok(()), |reason| Err(failure::unknown(reason)))
}

fn left_out(
    prepared: &PreparedSky,
    left_out: &[streakcast::orbit::LeftOut],
    moment: Epoch,
) -> PyResult<Option<String>> {
    prepared.left_out_warning(left_out, moment).map_err(failure::setup)
}

#[pymethods]
impl Engine {
    /// Creates an engine from a configuration document (JSON) and its sky cache.
    #[new]
    #[pyo3(signature = (sky_cache, setup, config=None))]
    fn new(py: Python<'_>, sky_cache: Py<SkyCache>, setup: &str, config: Option<&str>) -> PyResult<Self> {
        failure::without_lock(py, |_| {
            let setup = setup_of(setup, config)?;
            let field = match setup.field_of_view() {
                Ok(field) => Ok(field),
                // Forecasts need no field; the other methods report the missing field when they are called.
                Err(error) if error.kind() == ErrorKind::Missing => Err(failure::as_arguments(&error.to_string())),
                Err(error) => return Err(failure::setup(error)),
            };
            Ok(Self {
                sky_cache,
                field,
                telescope: setup.telescope().map_err(failure::setup)?,
                policy: setup.policy().map_err(failure::setup)?,
                photometry: setup.photometry().map_err(failure::setup)?,
                time_scale: setup.time_scale().map_err(failure::setup)?.map(scale_name),
                default_samples: setup.samples().map_err(failure::setup)?,
                default_rotation_deg: setup
                    .schedule_options()
                    .map_err(failure::setup)?
                    .default_rotation_rad
                    .to_degrees(),
                setup,
            })
        })
    }

    /// Returns the time scale of numbers given as times; `None` if there is none.
    #[getter]
    fn time_scale(&self) -> Option<&str> {
        self.time_scale.as_deref()
    }

    /// Returns the radius of a circle that contains the field, degrees; `None` without a field.
    #[getter]
    fn field_radius_deg(&self) -> Option<f64> {
        self.field.as_ref().ok().map(|field| field.bounding_radius_rad().to_degrees())
    }

    /// Returns the area of the field, square degrees; `None` without a field.
    #[getter]
    fn field_area_deg2(&self) -> Option<f64> {
        self.field.as_ref().ok().map(Field::area_deg2)
    }

    /// Returns the values that determine the costs of streaks of exposures in a band: `bright_share`, `bright_mag` and
    /// the magnitude limit of the policy, if there is one; `None` without a telescope.
    #[pyo3(signature = (band=None))]
    fn cost_parameters(&self, band: Option<&str>) -> Option<(f64, f64, Option<f64>)> {
        let telescope = self.telescope.as_ref()?;
        Some((telescope.bright_share, telescope.bright_mag_in(band), self.policy.limit_mag_in(band)))
    }

    /// Returns the rotation of the field of the configuration file, degrees.
    #[getter]
    fn default_rotation_deg(&self) -> f64 {
        self.default_rotation_deg
    }

    /// Returns the choice of satellites that block a start: `any` or `avoid`.
    #[getter]
    fn blocking(&self) -> &'static str {
        self.policy.blocking.name()
    }

    /// Returns verdicts as arrays: `verdict` (0 clear, 1 streaked, 2 avoid, 3 invalid, 4 unknown), `n_streaks`,
    /// `brightest_mag`, `lost_fraction`, `p_any`, `streak_length_deg`, `p_any_is_lower_limit`, `p_crossing`,
    /// `elements_age_days`, `late_s`, `streak_cost_s`. Numbers out of range are an error, or make the verdict `invalid`
    /// if `keep_invalid`.
    #[pyo3(signature = (exposures, bands, keep_invalid=false))]
    fn judge<'py>(
        &self,
        py: Python<'py>,
        exposures: Columns<'py>,
        bands: Vec<String>,
        keep_invalid: bool,
    ) -> PyResult<WithWarnings<Bound<'py, PyDict>>> {
        let rows = exposures.to_rows(py, &bands, keep_invalid)?;
        let (flags, warnings) = failure::without_lock(py, |watch| {
            self.report(&rows, &self.policy, judge_exposures, &mut |_, _, _| {}, watch)
        })?;
        let result = PyDict::new(py);
        let reals = |value: fn(&Verdict) -> f64| flags.iter().map(value).collect::<Vec<f64>>().into_pyarray(py);
        let verdicts: Vec<u8> = flags.iter().map(|flag| code(flag.kind)).collect();
        let streaks: Vec<i64> = flags.iter().map(|flag| flag.n_streaks as i64).collect();
        result.set_item("verdict", verdicts.into_pyarray(py))?;
        result.set_item("n_streaks", streaks.into_pyarray(py))?;
        result.set_item("brightest_mag", reals(|flag| flag.brightest_mag.unwrap_or(f64::NAN)))?;
        result.set_item("lost_fraction", reals(|flag| flag.expected_lost_pixel_fraction.unwrap_or(f64::NAN)))?;
        result.set_item("p_any", reals(|flag| flag.p_any))?;
        result.set_item("streak_length_deg", reals(|flag| flag.streak_length_deg))?;
        let lower_limits: Vec<bool> = flags.iter().map(|flag| flag.p_any_is_lower_limit).collect();
        result.set_item("p_any_is_lower_limit", lower_limits.into_pyarray(py))?;
        result.set_item("p_crossing", reals(|flag| flag.p_crossing))?;
        result.set_item("elements_age_days", reals(|flag| flag.elements_age_days.unwrap_or(f64::NAN)))?;
        result.set_item("late_s", reals(|flag| flag.late_s.unwrap_or(f64::NAN)))?;
        result.set_item("streak_cost_s", reals(|flag| flag.streak_cost_s.unwrap_or(f64::NAN)))?;
        Ok((result, warnings))
    }

    /// Returns verdicts with reasons and the next clear start, with the columns of `streakcast flag`. For a telescope
    /// in orbit without a longest delay, later starts are searched if `seeks_starts`.
    #[pyo3(signature = (exposures, bands, seeks_starts=false, keep_invalid=false))]
    fn flags<'py>(
        &self,
        py: Python<'py>,
        exposures: Columns<'py>,
        bands: Vec<String>,
        seeks_starts: bool,
        keep_invalid: bool,
    ) -> PyResult<WithWarnings<Bound<'py, PyList>>> {
        let rows = exposures.to_rows(py, &bands, keep_invalid)?;
        let mut policy = self.policy.clone();
        if seeks_starts {
            policy.max_delay_s = Some(policy.max_delay_or_default_s());
        }
        let (flags, warnings) =
            failure::without_lock(py, |watch| self.report(&rows, &policy, flag_exposures, &mut |_, _, _| {}, watch))?;
        Ok((columns(py, &flag_table(&flags))?, warnings))
    }

    /// Writes a copy of a schedule file with verdicts and streaks, as `streakcast annotate`. `scale` is the time scale
    /// of bare numbers in the file. Returns the paths of the written files.
    #[pyo3(signature = (schedule, output, scale=None, replace=false))]
    fn annotate(
        &self,
        py: Python<'_>,
        schedule: PathBuf,
        output: PathBuf,
        scale: Option<&str>,
        replace: bool,
    ) -> PyResult<WithWarnings<Vec<PathBuf>>> {
        failure::without_lock(py, |watch| self.annotated(&schedule, &output, scale, replace, watch))
    }

    /// Returns one row per crossing, with the columns of `streakcast passes`. `limits_mag` has one magnitude limit for
    /// each exposure (NaN for none), used for the columns `p_brighter` and `streak_cost_s`. Without it the limit of the
    /// policy for the band of the exposure is used.
    #[pyo3(signature = (exposures, include_dark, samples, bands, limits_mag=None))]
    fn passes<'py>(
        &self,
        py: Python<'py>,
        exposures: Columns<'py>,
        include_dark: Option<bool>,
        samples: Option<usize>,
        bands: Vec<String>,
        limits_mag: Option<Vec<f64>>,
    ) -> PyResult<WithWarnings<Bound<'py, PyList>>> {
        let rows = exposures.to_rows(py, &bands, false)?;
        let (include_dark, samples) = (self.includes_dark(include_dark), samples.unwrap_or(self.default_samples));
        if samples > streakcast::config::MOST_SAMPLES {
            let most = streakcast::config::MOST_SAMPLES;
            return Err(failure::request(format!("samples is {samples}; allowed: 0 to {most}")));
        }
        let limits_mag = limits_mag.or_else(|| {
            let of_row = |row: &ScheduledExposure| self.policy.limit_mag_in(row.band.as_deref()).unwrap_or(f64::NAN);
            let limits_mag: Vec<f64> = rows.iter().map(of_row).collect();
            limits_mag.iter().any(|limit_mag| !limit_mag.is_nan()).then_some(limits_mag)
        });
        let (table, warnings) = failure::without_lock(py, |watch| {
            self.pass_table(&rows, include_dark, samples, limits_mag.as_deref(), watch)
        })?;
        Ok((columns(py, &table)?, warnings))
    }

    /// Returns intervals of clear starts: index of the target, first and last start.
    #[pyo3(signature = (exposures, bands, exposure_s, min_altitude_deg, blocking=None, max_sun_altitude_deg=None))]
    fn clear_windows<'py>(
        &self,
        py: Python<'py>,
        exposures: Columns<'py>,
        bands: Vec<String>,
        exposure_s: f64,
        min_altitude_deg: f64,
        blocking: Option<&str>,
        max_sun_altitude_deg: Option<f64>,
    ) -> PyResult<WithWarnings<Bound<'py, PyDict>>> {
        within("exposure", 0, exposure_s, 0.0, 86_400.0, "s")?;
        within("min_altitude", 0, min_altitude_deg, 0.0, 90.0, "deg")?;
        let rows = rows(exposures.to_exposures(py, true)?, &bands)?;
        if let Some(sun_deg) = max_sun_altitude_deg {
            within("max_sun_altitude", 0, sun_deg, -90.0, 90.0, "deg")?;
        }
        let blocking = blocking.map(str::parse).transpose().map_err(failure::request)?;
        let limits = Limits {
            blocking,
            min_altitude_rad: min_altitude_deg.to_radians(),
            max_sun_altitude_rad: max_sun_altitude_deg.map(f64::to_radians),
        };
        let (found, warnings) = failure::without_lock(py, |watch| self.windows(rows, exposure_s, &limits, watch))?;
        let targets: Vec<i64> = found.iter().map(|(index, _)| *index as i64).collect();
        let result = PyDict::new(py);
        result.set_item("target", targets.into_pyarray(py))?;
        let starts = |start: fn(&ClearWindow) -> Epoch| {
            times(py, &found.iter().map(|(_, window)| Some(start(window))).collect::<Vec<_>>())
        };
        result.set_item("first_start", starts(|window| window.first))?;
        result.set_item("last_start", starts(|window| window.last))?;
        Ok((result, warnings))
    }

    /// Returns the satellites above the site at times `seconds` after a start: one row per satellite and time, with the
    /// probability of being brighter than each value of `limits_mag`, `(n_rows, n_limits)`, and of leaving a bright
    /// streak in exposures in `band`.
    #[allow(clippy::too_many_arguments)]
    #[pyo3(signature = (jd1, jd2, seconds, min_altitude_deg, include_dark, light, possible, limits_mag=Vec::new(), band=None))]
    fn overhead<'py>(
        &self,
        py: Python<'py>,
        jd1: f64,
        jd2: f64,
        seconds: Vec<f64>,
        min_altitude_deg: f64,
        include_dark: Option<bool>,
        light: bool,
        possible: bool,
        limits_mag: Vec<f64>,
        band: Option<&str>,
    ) -> PyResult<WithWarnings<Bound<'py, PyDict>>> {
        let start = start_of(0, jd1, jd2)?;
        for (index, limit_mag) in limits_mag.iter().enumerate() {
            within("limit_mag", index, *limit_mag, -30.0, 40.0, "mag")?;
        }
        within("min_altitude", 0, min_altitude_deg, 0.0, 90.0, "deg")?;
        // Brightness is only computed at the middle of each track.
        let options = SnapshotOptions {
            min_altitude_rad: min_altitude_deg.to_radians(),
            include_dark: self.includes_dark(include_dark) || self.photometry.band.is_thermal(),
            positions: if possible { SnapshotPositions::Possible } else { SnapshotPositions::Predicted },
            photometry: None,
        };
        let of_light = LightRequest { is_computed: light, limits_mag: &limits_mag, band };
        let (rows, warnings) =
            failure::without_lock(py, |watch| self.sky_rows(start, &seconds, &options, &of_light, watch))?;
        let result = PyDict::new(py);
        let reals = |column: Vec<f64>| -> Bound<'py, PyArray1<f64>> { column.into_pyarray(py) };
        result.set_item("moment", rows.moment.into_pyarray(py))?;
        result.set_item("norad_id", rows.norad_id.into_pyarray(py))?;
        result.set_item("direction", reals(rows.direction).reshape([rows.range_km.len(), 3])?)?;
        result.set_item("probability", reals(rows.probability))?;
        result.set_item("range_km", reals(rows.range_km))?;
        result.set_item("angular_rate_deg_s", reals(rows.rate_deg_s))?;
        result.set_item("lost_width_arcsec", reals(rows.lost_width_arcsec))?;
        let n_rows = rows.magnitude.len();
        result.set_item("magnitude", reals(rows.magnitude))?;
        result.set_item("p_brighter", reals(rows.p_brighter).reshape([n_rows, limits_mag.len()])?)?;
        result.set_item("q_bright", reals(rows.q_bright))?;
        Ok((result, warnings))
    }
}

/// Satellites over a site, one row per satellite and time.
#[derive(Default)]
struct SkyRows {
    moment: Vec<i64>,
    norad_id: Vec<i64>,
    /// Unit vectors, three components per row.
    direction: Vec<f64>,
    /// Probability of the position.
    probability: Vec<f64>,
    range_km: Vec<f64>,
    rate_deg_s: Vec<f64>,
    lost_width_arcsec: Vec<f64>,
    magnitude: Vec<f64>,
    /// Probability of being brighter than each limit, one value per limit and row.
    p_brighter: Vec<f64>,
    /// Probability of a bright streak; NaN without a telescope or without brightness.
    q_bright: Vec<f64>,
}

/// Brightness of satellites over a site.
struct LightRequest<'a> {
    is_computed: bool,
    limits_mag: &'a [f64],
    /// Band of the exposures.
    band: Option<&'a str>,
}

impl Engine {
    fn sky_rows(
        &self,
        start: Epoch,
        seconds: &[f64],
        options: &SnapshotOptions,
        light: &LightRequest<'_>,
        watch: &Watch,
    ) -> PyResult<WithWarnings<SkyRows>> {
        let prepared = self.sky_cache.get().sky_at(start, watch)?;
        check_known(&prepared, [start], None)?;
        let sky = &prepared.sky;
        let (tracks, failed) = sky.snapshots(start, seconds, options).map_err(failure::request)?;
        let warnings = left_out(&prepared, &failed, start)?.into_iter().collect();
        let lost_width = |track: &SatelliteTrack, range_km: f64| {
            let width = |telescope: &Telescope| {
                telescope.mask_width_arcsec(telescope.width_arcsec(range_km, sky.model(track.element_index).size_m()))
            };
            self.telescope.as_ref().map_or(f64::NAN, width)
        };
        let telescope = self.telescope.as_ref().filter(|_| light.is_computed);
        let bright_streaks =
            telescope.map(|telescope| BrightStreaks::new(telescope, sky, light.band, self.photometry.band));
        // Unknown brightness is that of the prior.
        let or_prior = |track: &SatelliteTrack, middle: &SatelliteSnapshot, brightness: Option<&Brightness>| {
            let prior = || sky.prior_brightness(track.element_index, &middle.point.geometry, &self.photometry);
            brightness.cloned().or_else(prior)
        };
        let mut rows = SkyRows::default();
        for track in &tracks {
            watch.check().map_err(failure::request)?;
            let Some(middle) = track.middle() else { continue };
            let range_km = middle.point.range_km;
            let lost_width_arcsec = lost_width(track, range_km);
            let brightness = if light.is_computed {
                sky.brightness(track.element_index, &middle.point, &self.photometry)
            } else {
                None
            };
            let magnitude = brightness.as_ref().map_or(f64::NAN, |light| light.magnitude.0);
            // Probability that depends on the brightness: 0 for a dark satellite, 1 if nothing is known.
            let is_seen = middle.point.illumination.is_lit() || self.photometry.band.has_emission();
            let probability = |of: &dyn Fn(&Brightness) -> f64| match is_seen {
                true if light.is_computed => {
                    or_prior(track, middle, brightness.as_ref()).map_or(1.0, |light| of(&light))
                }
                _ => 0.0,
            };
            let brighter = |&limit: &f64| probability(&|light| light.probability_brighter_than(limit));
            let p_brighter: Vec<f64> = light.limits_mag.iter().map(brighter).collect();
            let q_bright = bright_streaks.as_ref().map_or(f64::NAN, |bright_streaks| {
                probability(&|light| {
                    bright_streaks.probability(light, track.element_index, range_km, middle.angular_rate_rad_s)
                })
            });
            for snapshot in &track.snapshots {
                rows.moment.push(snapshot.time_index as i64);
                rows.norad_id.push(i64::from(track.norad_id.0));
                rows.direction.extend(snapshot.point.direction.vector().iter());
                rows.probability.push(snapshot.probability);
                rows.range_km.push(range_km);
                rows.rate_deg_s.push(snapshot.angular_rate_rad_s.to_degrees());
                rows.lost_width_arcsec.push(lost_width_arcsec);
                rows.magnitude.push(magnitude);
                rows.p_brighter.extend(&p_brighter);
                rows.q_bright.push(q_bright);
            }
        }
        Ok((rows, warnings))
    }

    fn pass_table(
        &self,
        rows: &[ScheduledExposure],
        include_dark: bool,
        samples: usize,
        limits_mag: Option<&[f64]>,
        watch: &Watch,
    ) -> PyResult<WithWarnings<Table>> {
        let field = self.field()?;
        let options = PassOptions {
            include_dark,
            samples,
            min_probability: self.policy.min_probability,
            photometry: self.photometry,
            ..PassOptions::default()
        };
        let exposures: Vec<&Exposure> = rows.iter().filter_map(|row| row.exposure.as_ref().ok()).collect();
        let mut found: Vec<(usize, Arc<PreparedSky>, Vec<Pass>)> = Vec::new();
        let mut warnings = Vec::new();
        for Night { prepared, indices } in self.nights(exposures.iter().map(|exposure| exposure.start), watch)? {
            let of_night: Vec<Exposure> = indices.iter().map(|index| exposures[*index].clone()).collect();
            check_known(&prepared, of_night.iter().map(|exposure| exposure.start), Some(field))?;
            let passes = prepared.sky.field_passes(&of_night, field, &options).map_err(failure::request)?;
            warnings.extend(left_out(&prepared, &passes.left_out, of_night[0].start)?);
            let prepared = Arc::new(prepared);
            found.extend(
                indices.into_iter().zip(passes.by_exposure).map(|(index, passes)| (index, prepared.clone(), passes)),
            );
        }
        found.sort_by_key(|(index, ..)| *index);
        let rows: Vec<StreakRow<'_>> = found
            .iter()
            .flat_map(|(index, prepared, passes)| {
                let (exposure, row) = (exposures[*index], &rows[*index]);
                let (request, band) = (self.request(field, prepared), row.band.as_deref());
                let limit_mag =
                    limits_mag.and_then(|limits| limits.get(*index).copied()).filter(|limit| !limit.is_nan());
                passes.iter().map(move |pass| request.streak_row((exposure, row.open_s), pass, band, limit_mag))
            })
            .collect();
        let columns = StreakColumns {
            p_brighter: limits_mag.is_some() || self.policy.has_limit(),
            chords: true,
            samples: samples > 0,
        };
        let mut table = streak_table(rows.iter().copied(), columns);
        table.columns.push(LOST);
        for (cells, row) in table.rows.iter_mut().zip(&rows) {
            let lost = self.telescope.as_ref().map(|telescope| {
                let width_arcsec = telescope.width_arcsec(row.pass.mid.range_km, row.satellite_size_m);
                let length_deg = self.policy.streak_length_rad(row.pass).to_degrees();
                telescope.lost_pixel_fraction(length_deg, width_arcsec, field.area_deg2())
            });
            cells.push(lost.into());
        }
        Ok((table, warnings))
    }

    /// Returns windows with the indices of their targets. Start and duration of each row are the time span of its
    /// windows. Rows with the same time span are computed together.
    fn windows(
        &self,
        rows: Vec<ScheduledExposure>,
        exposure_s: f64,
        limits: &Limits,
        watch: &Watch,
    ) -> PyResult<WithWarnings<Vec<(usize, ClearWindow)>>> {
        let field = self.field()?;
        let policy = Policy { blocking: limits.blocking.unwrap_or(self.policy.blocking), ..self.policy.clone() };
        let times: Vec<(Exposure, Option<String>)> =
            rows.into_iter().filter_map(|row| Some((row.exposure.ok()?, row.band))).collect();
        let bands = times.iter().map(|(_, band)| band.as_deref()).collect();
        let (mut found, mut warnings) = (Vec::new(), policy.band_warnings(&bands));
        for Night { prepared, indices } in self.nights(times.iter().map(|(time, _)| time.start), watch)? {
            let conditions = FlagRequest { policy: &policy, ..self.request(field, &prepared) };
            let Limits { min_altitude_rad, max_sun_altitude_rad, .. } = *limits;
            let request = WindowRequest { conditions, min_altitude_rad, max_sun_altitude_rad };
            let mut by_span: BTreeMap<(Epoch, Epoch), Vec<usize>> = BTreeMap::new();
            for index in indices {
                let (time, _) = &times[index];
                let end = seconds_after(time.start, time.duration_s);
                by_span.entry((time.start, end)).or_default().push(index);
            }
            for ((first, end), indices) in by_span {
                let target = |index: &usize| {
                    let (time, band) = times[*index].clone();
                    WindowTarget { exposure: Exposure { duration_s: exposure_s, ..time }, band }
                };
                let targets: Vec<WindowTarget> = indices.iter().map(target).collect();
                let report = clear_windows_without_passes(&targets, first, end, &request).map_err(failure::request)?;
                warnings.extend(left_out(&prepared, &report.left_out, first)?);
                if let Some(reason) = report.by_target.iter().find_map(|target| target.unknown.clone()) {
                    return Err(failure::unknown(reason));
                }
                for (index, target) in indices.into_iter().zip(report.by_target) {
                    found.extend(target.windows.into_iter().map(|window| (index, window)));
                }
            }
        }
        found.sort_by_key(|(index, _)| *index);
        Ok((found, warnings))
    }
}

/// Column for the pixel loss of each streak.
const LOST: Column = Column::real(
    "lost_pixel_fraction",
    "",
    6,
    "Fraction of the field's pixels lost to the nominal streak; missing without a telescope.",
);

/// Returns the index of a verdict in `VERDICTS` of the Python package.
fn code(verdict: VerdictKind) -> u8 {
    match verdict {
        VerdictKind::Clear => 0,
        VerdictKind::Streaked => 1,
        VerdictKind::Avoid => 2,
        VerdictKind::Invalid => 3,
        VerdictKind::Unknown => 4,
    }
}
