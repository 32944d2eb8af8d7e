//! Checks the options of an injection, and runs it on frames.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use hifitime::Epoch;
use serde::Deserialize;

use super::document::Config;
use super::error;
use super::error::request;
use super::injection::InjectionConfig;
use super::prepared::PreparedSky;
use super::required::{INJECTED_STREAKS, SEEING};
use super::values::{Numbers, parse_angle_deg, parse_exposure_s};
use crate::error::Error;
use crate::frames::{Direction, Gcrs, parse_direction, parse_instant, parse_start};
use crate::images::{CountBasis, Detector, PsfFile, Telescope};
use crate::input;
use crate::passes::Exposure;
use crate::schedule::Schedule;
use crate::streaks::{
    ChosenStreaks, FrameOverrides, Glint, Injection, InjectionPlan, InjectionSky, Injections, LabelFormat, LightCurve,
    MaskPreset, Modulation, Optics, RandomPlan, RandomStreaks, SeeingForm, StreakNumber, SyntheticFrame, SyntheticPlan,
    Tumbling,
};
use crate::watch::Watch;

/// Default β of the Moffat profile of a point spread function.
const DEFAULT_BETA: f64 = 3.5;
/// Second Gaussian of the form `double`: twice as wide as the first, with a tenth of its light (Bosch & Armstrong 2013,
/// for SDSS images).
const DEFAULT_WIDENING: f64 = 2.0;
const DEFAULT_WIDE_SHARE: f64 = 0.1;
/// Default range of angular rates of random streaks, deg/s: satellites at 550 km height near the horizon and at the
/// zenith.
const DEFAULT_RATES_DEG_S: [f64; 2] = [0.2, 0.8];
/// Default number of points along one streak in the truth table.
const TRUTH_POINTS: usize = 11;

/// Largest number of points along one streak in the truth table.
const MOST_TRUTH_POINTS: usize = 10_000;
/// Default start time of synthetic frames with random streaks. It is written to the header and has no other effect.
const DEFAULT_START: &str = "2000-01-01T12:00:00Z";

/// Function that returns a prepared sky for a given time, for callers that cache skies.
pub type SkyOf<'a> = &'a (dyn Fn(Epoch) -> Result<Arc<PreparedSky>, Error> + Sync);

/// Adds streaks to frames and writes one output for each input image or synthetic frame.
///
/// `sky`, if given, returns the prepared sky for the time of a frame. Otherwise the sky is prepared from the
/// configuration; if that has no site, the site is taken from the headers.
///
/// # Errors
/// The request, the configuration or a frame is invalid. On an error no partial output file remains.
pub fn inject_frames(
    injection: &InjectionConfig,
    config: &Config,
    sky: Option<SkyOf<'_>>,
    outputs: &[PathBuf],
    watch: &Watch,
) -> Result<Injections, Error> {
    let plan = injection.resolve(config)?;
    let opened = Injection::open(&plan, outputs)?;
    let Some((first, last)) = opened.span().filter(|_| plan.is_of_satellites()) else {
        return opened.run(None, watch);
    };
    if let Some(sky) = sky {
        return opened.run(Some(injection_sky(&sky(first)?.watched(watch))), watch);
    }
    let (config, remark) = with_site_of_frames(config, &opened)?;
    let prepared = config.prepare(first, last)?;
    let mut injections = opened.run(Some(injection_sky(&prepared.watched(watch))), watch)?;
    injections.warnings.extend(prepared.warnings);
    injections.remarks.splice(0..0, remark);
    Ok(injections)
}

fn injection_sky(prepared: &PreparedSky) -> InjectionSky<'_> {
    InjectionSky { sky: &prepared.sky, eop: &prepared.eop, provenance: &prepared.provenance }
}

/// Returns the configuration. If it has no site, sets the site of the headers, and also returns a message with that
/// site.
fn with_site_of_frames(config: &Config, opened: &Injection<'_>) -> Result<(Config, Option<String>), Error> {
    if !config.takes_site_of_frame() {
        return Ok((config.clone(), None));
    }
    match &opened.sites()?[..] {
        sites @ ([] | [_]) => config.at_site_of_header(sites.first(), opened.unused_coordinates(), "the frames"),
        [first, second, ..] => {
            Err(request(format!("the frames are from two sites ({}, {})", first.site.name, second.site.name))
                .allowing("frames of one site"))
        }
    }
}

impl InjectionConfig {
    /// Returns the paths of all input files; outputs must not replace them.
    pub fn files(&self) -> Vec<PathBuf> {
        let single = [&self.synthetic, &self.schedule, &self.light_curve, &self.detector, &self.streaks];
        let psf = self.has_psf_file().then(|| PathBuf::from(self.psf()));
        self.image.iter().chain(single.into_iter().flatten()).cloned().chain(psf).collect()
    }

    fn label_formats(&self) -> Result<Vec<LabelFormat>, Error> {
        let mut formats = Vec::new();
        for name in &self.labels {
            let format = LabelFormat::by_name(name)?;
            if !formats.contains(&format) {
                formats.push(format);
            }
        }
        Ok(formats)
    }

    /// Returns the paths of the labels of frames with one chip.
    ///
    /// # Errors
    /// An unknown format.
    pub fn label_paths(&self, outputs: &[PathBuf]) -> Result<Vec<PathBuf>, Error> {
        let formats = self.label_formats()?;
        let paths = formats.iter().flat_map(|format| {
            // COCO has one file for all frames.
            let frames = if *format == LabelFormat::Coco { &outputs[..outputs.len().min(1)] } else { outputs };
            frames.iter().map(|frame| format.path(frame, outputs.len(), None))
        });
        Ok(paths.collect())
    }

    /// Returns true for random streaks and streaks of a table, false for satellites.
    pub fn is_without_satellites(&self) -> bool {
        self.random_streaks.is_some() || self.streak_density.is_some() || self.streaks.is_some()
    }

    /// Checks the options, and reads the files of detector, synthetic frame, light curve and schedule.
    ///
    /// # Errors
    /// The options are incomplete or contradictory, or a number is out of range.
    pub fn resolve(&self, config: &Config) -> Result<InjectionPlan, Error> {
        self.check_counts()?;
        let telescope = config.telescope()?;
        let scheduled = self.scheduled(config)?;
        let (start, duration_s) = self.times(config, scheduled.as_ref())?;
        let modulation = self.modulation()?;
        let random = self.random()?;
        if !self.is_without_satellites() && !config.has_satellites() {
            return Err(INJECTED_STREAKS.missing());
        }
        self.check_idle()?;
        if random.is_some() && self.streaks.is_some() {
            return Err(error::both("--streaks", "--random-streaks or --streak-density"));
        }
        let chosen = self.streaks.as_deref().map(ChosenStreaks::read).transpose()?;
        let satellite_size_m = checked_size(self.satellite_size)?;
        if let (Some(size_m), Some(chosen)) = (satellite_size_m.filter(|size_m| *size_m > 0.0), &chosen) {
            chosen.check_distances(size_m)?;
        }
        let (detector, gain_of_file) = match self.detector.as_deref().map(read_detector).transpose()? {
            Some((detector, gain_of_file)) => (Some(detector), gain_of_file),
            None => (None, None),
        };
        if gain_of_file.is_some() && self.gain.is_some() {
            return Err(request(
                "--gain and gain_e_adu in the file of --detector exclude each other; specify one of them",
            ));
        }
        if self.synthetic.is_some() && detector.is_some() {
            return Err(request(
                "--detector and --synthetic exclude each other: the file of a synthetic frame has its own table [detector]",
            ));
        }
        if let Some(gain) = self.gain.filter(|gain| !(*gain > 0.0 && gain.is_finite())) {
            return Err(Error::invalid("gain", format_args!("{gain} e/count"), "above 0 e/count"));
        }
        let pixel_scale_arcsec = self.pixel_scale.as_deref().map(|text| arcsec("pixel-scale", text)).transpose()?;
        if pixel_scale_arcsec.is_some() && !self.is_without_satellites() {
            return Err(Error::invalid(
                "--pixel-scale",
                "given without random streaks",
                "with --random-streaks, --streak-density or --streaks (satellites need world coordinates)",
            ));
        }
        let photometry = config.photometry()?;
        let zero_point = self.zero_point.map(|mag| (mag, CountBasis::Frame));
        let synthetic = match &self.synthetic {
            Some(path) => Some(self.synthetic_plan(path, (start, duration_s), scheduled.as_ref())?),
            None => None,
        };
        Ok(InjectionPlan {
            images: self.image.clone(),
            overrides: FrameOverrides {
                start,
                duration_s,
                hdus: self.hdu.clone(),
                zero_point: zero_point.or(self.zero_point_1s.map(|mag| (mag, CountBasis::Second))),
                gain_e_adu: self.gain.or(gain_of_file),
                // That of the detector file.
                saturation: None,
                pixel_scale_arcsec,
            },
            tracking_arcsec_s: numbers(&self.track_rate).try_into().ok(),
            random,
            chosen,
            satellite_size_m,
            modulation,
            resolve_panels: self.resolve_panels,
            optics: self.optics(telescope.as_ref())?,
            psf_file: self.psf_file()?,
            psf_name: self.psf().to_owned(),
            telescope: telescope.map(|telescope| telescope.name),
            detector: detector.or(synthetic.as_ref().map(|synthetic| synthetic.frame.detector.clone())),
            synthetic,
            photometry,
            band_of_filter: config.light.band.is_none(),
            mag_system: config.light.mag_system.is_some().then_some(photometry.system),
            noise: !self.no_noise,
            seed: self.seed,
            truth_points: self.truth_points(),
            labels: self.label_formats()?,
            inputs: self.files().into_iter().chain(config.files()).collect(),
            mask_preset: MaskPreset::by_name(self.mask_bits.as_deref().unwrap_or("lsst"))?,
            pixels_only: self.pixels_only,
        })
    }

    /// Checks that each option has the required number of values, and that they are finite.
    fn check_counts(&self) -> Result<(), Error> {
        let lists = [
            ("track-rate", &self.track_rate, 2..=2),
            ("magnitude", &self.magnitude, 1..=2),
            ("streak-rate-deg-s", &self.streak_rate_deg_s, 1..=2),
            ("tumbling", &self.tumbling, 2..=3),
        ];
        let lists = lists.iter().map(|(what, list, allowed)| (*what, numbers(list), allowed));
        let given = lists.filter(|(_, numbers, _)| !numbers.is_empty());
        for (what, numbers, allowed) in given.chain(self.glint.iter().map(|glint| ("glint", &glint.0[..], &(3..=3)))) {
            if !allowed.contains(&numbers.len()) {
                let (least, most) = (allowed.start(), allowed.end());
                let allowed = if least == most { least.to_string() } else { format!("{least} to {most}") };
                return Err(request(format!("{what} has {} numbers", numbers.len())).allowing(allowed));
            }
            if let Some(bad) = numbers.iter().find(|number| !number.is_finite()) {
                return Err(request(format!("{what} is {bad}")).allowing("finite numbers"));
            }
        }
        Ok(())
    }

    /// Rejects options that have no effect together with the others.
    fn check_idle(&self) -> Result<(), Error> {
        let of_synthetic =
            [("--frames", self.frames.is_some()), ("--ra", self.ra.is_some()), ("--dec", self.dec.is_some())];
        if let Some((option, _)) = of_synthetic.iter().find(|(_, is_given)| *is_given && self.synthetic.is_none()) {
            return Err(request(format!("{option} is given without --synthetic"))
                .allowing("with --synthetic (the position of an image is in its header)"));
        }
        if self.synthetic.is_some() && !self.hdu.is_empty() {
            return Err(Error::invalid(
                "--hdu",
                "given with --synthetic",
                "with --image (a synthetic frame has one image)",
            ));
        }
        if self.resolve_panels && self.is_without_satellites() {
            return Err(
                request("--resolve-panels has no effect on random streaks").allowing("with streaks of satellites")
            );
        }
        if self.resolve_panels && self.satellite_size.is_some() {
            return Err(error::both("--satellite-size", "--resolve-panels"));
        }
        if !(2..=MOST_TRUTH_POINTS).contains(&self.truth_points()) {
            return Err(Error::invalid("truth-points", self.truth_points(), format!("2 to {MOST_TRUTH_POINTS}")));
        }
        Ok(())
    }

    fn scheduled(&self, config: &Config) -> Result<Option<Exposure>, Error> {
        let (Some(path), Some(row)) = (&self.schedule, &self.row) else { return Ok(None) };
        let schedule = Schedule::read(path, &config.schedule_options()?)?;
        let found = schedule.exposures.iter().find(|exposure| exposure.id == *row);
        let found = found.ok_or_else(|| {
            Error::about_file("", path, format!("has no exposure_id {row:?}"))
                .allowing("an exposure_id of the schedule")
        })?;
        match &found.exposure {
            Ok(exposure) => Ok(Some(exposure.clone())),
            Err(reason) => Err(Error::format(reason.clone()).at(format_args!("exposure {row}")).in_file("", path)),
        }
    }

    fn times(&self, config: &Config, scheduled: Option<&Exposure>) -> Result<(Option<Epoch>, Option<f64>), Error> {
        if let Some(exposure) = scheduled {
            return Ok((Some(exposure.start), Some(exposure.duration_s)));
        }
        let scale = config.time_scale()?;
        let start = self.start.as_deref().map(|start| parse_start(start, scale)).transpose()?;
        let duration_s = self.exposure.as_deref().map(parse_exposure_s).transpose()?;
        Ok((start, duration_s))
    }

    fn modulation(&self) -> Result<Modulation, Error> {
        let tumbling = match *numbers(&self.tumbling) {
            [period_s, amplitude_mag] => Some(Tumbling { period_s, amplitude_mag, phase: 0.0 }),
            [period_s, amplitude_mag, phase] => Some(Tumbling { period_s, amplitude_mag, phase }),
            _ => None,
        };
        let glint = |numbers: &Numbers| match numbers.0[..] {
            [magnitude, offset_s, duration_s] => Some(Glint { magnitude, offset_s, duration_s }),
            _ => None,
        };
        let modulation = Modulation {
            tumbling,
            glints: self.glint.iter().filter_map(glint).collect(),
            curve: self.light_curve.as_deref().map(LightCurve::read).transpose()?,
        };
        modulation.check()?;
        Ok(modulation)
    }

    fn random(&self) -> Result<Option<RandomPlan>, Error> {
        let number = match (self.random_streaks, self.streak_density) {
            (Some(number), _) => StreakNumber::Exactly(number),
            (None, Some(mean)) => StreakNumber::OnAverage(mean),
            (None, None) if numbers(&self.magnitude).is_empty() && numbers(&self.streak_rate_deg_s).is_empty() => {
                return Ok(None);
            }
            (None, None) => {
                return Err(Error::invalid(
                    "--magnitude or --streak-rate-deg-s",
                    "given without random streaks",
                    "with --random-streaks or --streak-density",
                ));
            }
        };
        let range = |given: &Option<Numbers>, usual: [f64; 2]| match *numbers(given) {
            [value] => [value, value],
            [from, to] => [from, to],
            _ => usual,
        };
        let streaks = RandomStreaks {
            number,
            magnitude: range(&self.magnitude, [f64::NAN; 2]),
            rate_rad_s: range(&self.streak_rate_deg_s, DEFAULT_RATES_DEG_S).map(f64::to_radians),
        };
        streaks.check()?;
        Ok(Some(RandomPlan { streaks, is_per_square_degree: self.streak_density.is_some() }))
    }

    /// Returns true if the point spread function is that of a file.
    pub fn has_psf_file(&self) -> bool {
        PsfFile::is_name(self.psf())
    }

    fn psf(&self) -> &str {
        self.psf.as_deref().unwrap_or("moffat")
    }

    fn truth_points(&self) -> usize {
        self.truth_points.unwrap_or(TRUTH_POINTS)
    }

    /// Reads the file of the point spread function, and rejects options that have no effect with it.
    fn psf_file(&self) -> Result<Option<PsfFile>, Error> {
        if !self.has_psf_file() {
            return match self.psf_oversampling {
                Some(_) => Err(Error::invalid(
                    "--psf-oversampling",
                    format_args!("given with --psf {}", self.psf()),
                    "with a file of --psf",
                )),
                None => Ok(None),
            };
        }
        let idle = [
            ("--seeing", self.seeing.is_some()),
            ("--satellite-size", self.satellite_size.is_some()),
            ("--resolve-panels", self.resolve_panels),
            ("--synthetic", self.synthetic.is_some()),
        ];
        if let Some((first, _)) = idle.into_iter().find(|(_, is_given)| *is_given) {
            return Err(error::both(first, "a file of --psf"));
        }
        Ok(Some(PsfFile::read(Path::new(self.psf()), self.psf_oversampling)?))
    }

    fn optics(&self, telescope: Option<&Telescope>) -> Result<Optics, Error> {
        if self.has_psf_file() {
            // The file replaces seeing and defocus.
            return Ok(Optics {
                form: SeeingForm::Gaussian,
                seeing_arcsec: f64::NAN,
                outer_radius_m: 0.0,
                inner_radius_m: 0.0,
            });
        }
        let seeing_arcsec = match (&self.seeing, telescope) {
            (Some(text), _) => arcsec("seeing", text)?,
            (None, Some(telescope)) => telescope.seeing_arcsec,
            (None, None) => return Err(SEEING.missing()),
        };
        Ok(Optics {
            form: seeing_form(self.psf())?,
            seeing_arcsec,
            outer_radius_m: telescope.map_or(0.0, |telescope| telescope.outer_radius_m),
            inner_radius_m: telescope.map_or(0.0, |telescope| telescope.inner_radius_m),
        })
    }

    fn synthetic_plan(
        &self,
        path: &Path,
        (start, duration_s): (Option<Epoch>, Option<f64>),
        scheduled: Option<&Exposure>,
    ) -> Result<SyntheticPlan, Error> {
        let text = text_of("synthetic frame", path)?;
        let mut frame = SyntheticFrame::from_toml(&text, &path.display().to_string())?;
        // Relative paths in a file are relative to the folder of the file.
        let folder = path.parent().unwrap_or(Path::new(""));
        frame.star_list = frame.star_list.map(|list| folder.join(list));
        let opened = match start {
            Some(start) => start,
            None if self.is_without_satellites() => parse_instant(DEFAULT_START, None)?,
            None => {
                return Err(Error::missing(
                    "start of the exposure",
                    "--start 2024-08-14T00:30:00.000Z, or --schedule FILE --row ID",
                ));
            }
        };
        let exposure_s =
            duration_s.ok_or_else(|| Error::missing("exposure time", "--exposure 30s, or --schedule FILE --row ID"))?;
        Ok(SyntheticPlan { frame, path: path.to_owned(), opened, exposure_s, centre: self.centre(scheduled)? })
    }

    fn centre(&self, scheduled: Option<&Exposure>) -> Result<Direction<Gcrs>, Error> {
        match (scheduled, &self.ra, &self.dec) {
            (_, Some(ra), Some(dec)) => parse_direction(ra, dec),
            (Some(exposure), None, None) => Ok(exposure.pointing),
            (None, None, None) if self.is_without_satellites() => Ok(Direction::from_lon_lat_rad(0.0, 0.0)),
            _ => Err(Error::missing("centre of the frame", "--ra 188.5 --dec=-30.5, or --schedule FILE --row ID")),
        }
    }
}

fn numbers(given: &Option<Numbers>) -> &[f64] {
    given.as_ref().map_or(&[], |numbers| &numbers.0)
}

fn arcsec(what: &'static str, text: &str) -> Result<f64, Error> {
    Ok(parse_angle_deg(what, text)? * 3600.0)
}

fn text_of(what: &str, path: &Path) -> Result<String, Error> {
    input::read_to_string(path).map_err(|source| error::unreadable(what, path, source))
}

/// Largest size of a satellite, m.
const LARGEST_M: f64 = 1000.0;

/// Checks the diameter of the satellites, m.
pub(super) fn checked_size(size_m: Option<f64>) -> Result<Option<f64>, Error> {
    match size_m {
        Some(size_m) if !(0.0..=LARGEST_M).contains(&size_m) => {
            Err(Error::invalid("satellite-size", format_args!("{size_m} m"), format!("0 to {LARGEST_M} m")))
        }
        _ => Ok(size_m),
    }
}

pub(super) fn seeing_form(text: &str) -> Result<SeeingForm, Error> {
    let (name, number) = text.split_once(':').map_or((text, None), |(name, number)| (name, Some(number)));
    match (name.to_ascii_lowercase().as_str(), number) {
        ("gaussian", None) => Ok(SeeingForm::Gaussian),
        ("moffat", None) => Ok(SeeingForm::Moffat { beta: DEFAULT_BETA }),
        ("moffat", Some(number)) => match number.parse::<f64>() {
            Ok(beta) if (2.0..=100.0).contains(&beta) => Ok(SeeingForm::Moffat { beta }),
            _ => Err(request(format!("invalid β of the Moffat profile in psf {text:?}")).allowing("2 to 100")),
        },
        ("double", None) => {
            Ok(SeeingForm::DoubleGaussian { widening: DEFAULT_WIDENING, wide_share: DEFAULT_WIDE_SHARE })
        }
        _ => Err(request(format!("invalid psf {text:?}"))
            .allowing("gaussian, moffat, moffat:BETA, double; inject also a file .fits or .psf")),
    }
}

/// Reads a detector from a file with the table `[detector]`, from that of a synthetic frame, or from a file with only
/// the keys of the table. Returns the detector, and its gain if the file sets one.
fn read_detector(path: &Path) -> Result<(Detector, Option<f64>), Error> {
    #[derive(Deserialize)]
    struct DetectorFile {
        detector: Detector,
    }
    let text = text_of("detector", path)?;
    let shown = path.display().to_string();
    let failed = |error: Error| error.in_file("detector", path);
    // Errors of syntax are reported by the parsers below, with their lines.
    let keys: toml::Table = toml::from_str(&text).unwrap_or_default();
    let table = keys.get("detector");
    let detector = match table {
        None => Detector::parse(&text).map_err(failed)?,
        Some(_) if keys.len() == 1 => {
            let DetectorFile { detector } =
                toml::from_str(&text).map_err(|error| failed(input::toml_error(&error, &text)))?;
            detector.check().map_err(failed)?;
            detector
        }
        Some(_) => SyntheticFrame::from_toml(&text, &shown)?.detector,
    };
    let has_gain = table.map_or(keys.contains_key("gain_e_adu"), |table| table.get("gain_e_adu").is_some());
    let gain_of_file = has_gain.then_some(detector.gain_e_adu);
    Ok((detector, gain_of_file))
}
