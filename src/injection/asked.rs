//! From what was said to what it means: frames, exposures, streaks, optics.

use std::fs;
use std::path::{Path, PathBuf};

use crate::config::{Setup, parse_angle_deg, parse_duration_s, parse_moment};
use crate::images::Telescope;
use crate::images::{CountBasis, Detector};
use crate::passes::Exposure;
use crate::schedule::Schedule;
use crate::streaks::{
    FrameSaid, Glint, LightCurve, MaskPreset, Modulation, Optics, RandomStreaks, SeeingForm, StreakNumber,
    SyntheticFrame, Tracking, Tumbling,
};
use hifitime::Epoch;

use super::error::InjectionError;
use super::said::InjectionSaid;

/// β of the Moffat profile where none is said: what telescopes have.
const USUAL_BETA: f64 = 3.5;
/// The wide Gaussian of the double one: twice as wide, with a tenth of the light (Bosch & Armstrong 2013 take it so for images of SDSS).
const USUAL_WIDENING: f64 = 2.0;
const USUAL_WIDE_SHARE: f64 = 0.1;
/// Speeds of random streaks where none are said, deg/s: satellites of 550 km low in the sky and overhead.
const USUAL_RATES_DEG_S: [f64; 2] = [0.2, 0.8];

/// The most points of truth along one streak.
const MOST_TRUTH_POINTS: usize = 10_000;

/// What is to be done with every frame.
pub struct Asked {
    pub said: FrameSaid,
    /// The schedule's exposure, whose pointing synthetic frames take.
    pub scheduled: Option<Exposure>,
    pub tracking_arcsec_s: Option<[f64; 2]>,
    pub random: Option<Random>,
    pub modulation: Modulation,
    pub optics: Optics,
    pub telescope: Option<Telescope>,
    pub detector: Option<Detector>,
    pub preset: MaskPreset,
    pub synthetic: Option<SyntheticFrame>,
}

/// Random streaks: their number, or how many a square degree.
pub struct Random {
    pub streaks: RandomStreaks,
    pub a_square_degree: bool,
}

impl Asked {
    pub fn new(said: &InjectionSaid, setup: &Setup) -> Result<Self, InjectionError> {
        check_counts(said)?;
        let telescope = setup.telescope()?;
        let scheduled = scheduled(said, setup)?;
        let (start, duration_s) = times(said, setup, scheduled.as_ref())?;
        let modulation = modulation(said)?;
        modulation.check()?;
        let random = random(said)?;
        if let Some(random) = &random {
            random.streaks.check()?;
        }
        if random.is_none() && setup.elements.is_none() && setup.shells.is_none() {
            return Err(InjectionError::said(
                "no streaks; say --elements FILE..., --shells NAME, or --random-streaks N --magnitude MAG".to_string(),
            ));
        }
        refuse_idle(said)?;
        let (detector, own_gain) = match said.detector.as_deref().map(detector).transpose()? {
            Some((detector, own_gain)) => (Some(detector), own_gain),
            None => (None, None),
        };
        if own_gain.is_some() && said.gain.is_some() {
            return Err(InjectionError::said(
                "--gain, and a gain_e_adu in the file of --detector; allowed: one of them".to_string(),
            ));
        }
        let synthetic = said.synthetic.as_deref().map(synthetic).transpose()?;
        if synthetic.is_some() && detector.is_some() {
            return Err(InjectionError::said(
                "--detector and --synthetic: the file of a synthetic frame has its own table [detector]".to_string(),
            ));
        }
        let pixel_scale_arcsec = said.pixel_scale.as_deref().map(|text| arcsec("pixel-scale", text)).transpose()?;
        if pixel_scale_arcsec.is_some() && random.is_none() {
            return Err(InjectionError::said("--pixel-scale is for random streaks in frames that say nothing of the sky; satellites need world coordinates".to_string()));
        }
        Ok(Self {
            said: FrameSaid {
                start,
                duration_s,
                hdus: said.hdu.clone(),
                zero_point: zero_point(said),
                gain_e_adu: positive("gain", said.gain)?.or(own_gain),
                pixel_scale_arcsec,
            },
            scheduled,
            tracking_arcsec_s: said.track_rate[..].try_into().ok(),
            random,
            modulation,
            optics: optics(said, telescope.as_ref())?,
            detector,
            preset: MaskPreset::by_name(&said.mask_bits)?,
            synthetic,
            telescope,
        })
    }

    /// What the telescope follows in an exposure of this length.
    pub fn tracking(&self, exposure_s: f64) -> Tracking {
        self.tracking_arcsec_s.map_or(Tracking::Sidereal, |[east, north]| Tracking::Rate {
            east_rad_s: (east / 3600.0).to_radians(),
            north_rad_s: (north / 3600.0).to_radians(),
            reference_s: 0.5 * exposure_s,
        })
    }
}

/// How many numbers make a statement.
fn check_counts(said: &InjectionSaid) -> Result<(), InjectionError> {
    let lists = [
        ("track-rate", &said.track_rate, 2..=2),
        ("magnitude", &said.magnitude, 1..=2),
        ("streak-rate-deg-s", &said.streak_rate_deg_s, 1..=2),
        ("tumbling", &said.tumbling, 2..=3),
    ];
    let glints = said.glint.iter().map(|glint| ("glint", glint, 3..=3));
    for (what, numbers, allowed) in lists.into_iter().filter(|(_, numbers, _)| !numbers.is_empty()).chain(glints) {
        if !allowed.contains(&numbers.len()) {
            let (least, most) = (allowed.start(), allowed.end());
            let allowed = if least == most { least.to_string() } else { format!("{least} to {most}") };
            return Err(InjectionError::said(format!("{what}: {} numbers; allowed: {allowed}", numbers.len())));
        }
        if let Some(bad) = numbers.iter().find(|number| !number.is_finite()) {
            return Err(InjectionError::said(format!("{what} {bad}; allowed: finite numbers")));
        }
    }
    Ok(())
}

fn scheduled(said: &InjectionSaid, setup: &Setup) -> Result<Option<Exposure>, InjectionError> {
    let (Some(path), Some(row)) = (&said.schedule, &said.row) else { return Ok(None) };
    let schedule = Schedule::read(path, &setup.schedule_options()?)?;
    let found = schedule.exposures.iter().find(|exposure| exposure.id == *row);
    let found = found.ok_or_else(|| InjectionError::said(format!("{}: no exposure_id {row:?}", path.display())))?;
    match &found.exposure {
        Ok(exposure) => Ok(Some(exposure.clone())),
        Err(reason) => Err(InjectionError::said(format!("{}: exposure {row}: {reason}", path.display()))),
    }
}

fn times(
    said: &InjectionSaid,
    setup: &Setup,
    scheduled: Option<&Exposure>,
) -> Result<(Option<Epoch>, Option<f64>), InjectionError> {
    if let Some(exposure) = scheduled {
        return Ok((Some(exposure.start), Some(exposure.duration_s)));
    }
    let scale = setup.time_scale()?;
    let start = said.start.as_deref().map(|start| parse_moment(start, scale)).transpose()?;
    let duration_s = said.exposure.as_deref().map(|text| parse_duration_s("exposure", text)).transpose()?;
    if duration_s.is_some_and(|seconds| seconds <= 0.0) {
        return Err(InjectionError::said("exposure of 0 s; allowed: above 0 s".to_string()));
    }
    Ok((start, duration_s))
}

fn modulation(said: &InjectionSaid) -> Result<Modulation, InjectionError> {
    let tumbling = match said.tumbling[..] {
        [period_s, amplitude_mag] => Some(Tumbling { period_s, amplitude_mag, phase: 0.0 }),
        [period_s, amplitude_mag, phase] => Some(Tumbling { period_s, amplitude_mag, phase }),
        _ => None,
    };
    let glint = |numbers: &Vec<f64>| match numbers[..] {
        [magnitude, offset_s, duration_s] => Some(Glint { magnitude, offset_s, duration_s }),
        _ => None,
    };
    Ok(Modulation {
        tumbling,
        glints: said.glint.iter().filter_map(glint).collect(),
        curve: said.light_curve.as_deref().map(light_curve).transpose()?,
    })
}

fn light_curve(path: &Path) -> Result<LightCurve, InjectionError> {
    let shown = path.display();
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_path(path)
        .map_err(|error| InjectionError::said(format!("light curve {shown}: {error}")))?;
    let headers =
        reader.headers().map_err(|error| InjectionError::said(format!("light curve {shown}: {error}")))?.clone();
    let column = |name: &str| {
        headers.iter().position(|header| header == name).ok_or_else(|| {
            InjectionError::said(format!("light curve {shown}: no column {name} (needed: time_s, delta_mag)"))
        })
    };
    let (time, delta) = (column("time_s")?, column("delta_mag")?);
    let mut points = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| InjectionError::said(format!("light curve {shown}: {error}")))?;
        let line = record.position().map_or(0, csv::Position::line);
        let number = |index: usize| {
            let text = record.get(index).unwrap_or_default();
            text.parse::<f64>()
                .map_err(|_| InjectionError::said(format!("light curve {shown}, line {line}: {text:?} is no number")))
        };
        points.push((number(time)?, number(delta)?));
    }
    LightCurve::new(points).map_err(|error| InjectionError::said(format!("{shown}: {error}")))
}

fn random(said: &InjectionSaid) -> Result<Option<Random>, InjectionError> {
    let number = match (said.random_streaks, said.streak_density) {
        (Some(number), _) => StreakNumber::Exactly(number),
        (None, Some(mean)) => StreakNumber::OnAverage(mean),
        (None, None) if said.magnitude.is_empty() && said.streak_rate_deg_s.is_empty() => return Ok(None),
        (None, None) => {
            return Err(InjectionError::said("--magnitude and --streak-rate-deg-s are for --random-streaks and --streak-density; satellites have their own".to_string()));
        }
    };
    let range = |given: &[f64], usual: [f64; 2]| match *given {
        [one] => [one, one],
        [from, to] => [from, to],
        _ => usual,
    };
    let streaks = RandomStreaks {
        number,
        magnitude: range(&said.magnitude, [f64::NAN; 2]),
        rate_rad_s: range(&said.streak_rate_deg_s, USUAL_RATES_DEG_S).map(f64::to_radians),
    };
    Ok(Some(Random { streaks, a_square_degree: said.streak_density.is_some() }))
}

fn optics(said: &InjectionSaid, telescope: Option<&Telescope>) -> Result<Optics, InjectionError> {
    let seeing_arcsec = match (&said.seeing, telescope) {
        (Some(text), _) => arcsec("seeing", text)?,
        (None, Some(telescope)) => telescope.seeing_arcsec,
        (None, None) => {
            return Err(InjectionError::said(
                "no width of a star's image; say --seeing 1.2arcsec, or --telescope NAME, which brings the defocus too"
                    .to_string(),
            ));
        }
    };
    Ok(Optics {
        form: form(&said.psf)?,
        seeing_arcsec,
        outer_radius_m: telescope.map_or(0.0, |telescope| telescope.outer_radius_m),
        inner_radius_m: telescope.map_or(0.0, |telescope| telescope.inner_radius_m),
    })
}

fn form(text: &str) -> Result<SeeingForm, InjectionError> {
    let (name, number) = text.split_once(':').map_or((text, None), |(name, number)| (name, Some(number)));
    match (name.to_ascii_lowercase().as_str(), number) {
        ("gaussian", None) => Ok(SeeingForm::Gaussian),
        ("moffat", None) => Ok(SeeingForm::Moffat { beta: USUAL_BETA }),
        ("moffat", Some(number)) => match number.parse::<f64>() {
            Ok(beta) if (2.0..=100.0).contains(&beta) => Ok(SeeingForm::Moffat { beta }),
            _ => Err(InjectionError::said(format!("psf {text:?}: β of a Moffat profile; allowed: 2 to 100"))),
        },
        ("double", None) => Ok(SeeingForm::DoubleGaussian { widening: USUAL_WIDENING, wide_share: USUAL_WIDE_SHARE }),
        _ => Err(InjectionError::said(format!(
            "psf {text:?} is not known; allowed: gaussian, moffat, moffat:BETA, double"
        ))),
    }
}

fn arcsec(what: &'static str, text: &str) -> Result<f64, InjectionError> {
    Ok(parse_angle_deg(what, text)? * 3600.0)
}

fn positive(what: &str, given: Option<f64>) -> Result<Option<f64>, InjectionError> {
    match given {
        Some(number) if !(number > 0.0 && number.is_finite()) => {
            Err(InjectionError::said(format!("{what} {number}; allowed: above 0")))
        }
        given => Ok(given),
    }
}

fn zero_point(said: &InjectionSaid) -> Option<(f64, CountBasis)> {
    let frame = said.zero_point.map(|mag| (mag, CountBasis::Frame));
    frame.or(said.zero_point_1s.map(|mag| (mag, CountBasis::Second)))
}

fn text_of(what: &str, path: &Path) -> Result<String, InjectionError> {
    fs::read_to_string(path).map_err(|error| InjectionError::said(format!("{what} {}: {error}", path.display())))
}

/// A detector, and its gain where the file says one.
fn detector(path: &Path) -> Result<(Detector, Option<f64>), InjectionError> {
    let text = text_of("detector", path)?;
    let detector = Detector::from_toml(&text)
        .map_err(|error| InjectionError::said(format!("detector {}: {error}", path.display())))?;
    let says_gain = toml::from_str::<toml::Table>(&text).is_ok_and(|table| table.contains_key("gain_e_adu"));
    let own_gain = says_gain.then_some(detector.gain_e_adu);
    Ok((detector, own_gain))
}

/// Refuses options that would do nothing.
fn refuse_idle(said: &InjectionSaid) -> Result<(), InjectionError> {
    let of_synthetic =
        [("--frames", said.frames.is_some()), ("--ra", said.ra.is_some()), ("--dec", said.dec.is_some())];
    if let Some((option, _)) = of_synthetic.iter().find(|(_, is_said)| *is_said && said.synthetic.is_none()) {
        return Err(InjectionError::said(format!("{option} is for --synthetic; a frame on file says where it is")));
    }
    if said.synthetic.is_some() && !said.hdu.is_empty() {
        return Err(InjectionError::said("--hdu is for frames on file; a synthetic one has one image".to_string()));
    }
    let is_random = said.random_streaks.is_some() || said.streak_density.is_some();
    if said.resolve_panels && is_random {
        return Err(InjectionError::said(
            "--resolve-panels is for satellites; random streaks have neither chassis nor solar array".to_string(),
        ));
    }
    if !(2..=MOST_TRUTH_POINTS).contains(&said.truth_points) {
        return Err(InjectionError::said(format!(
            "truth-points {}; allowed: 2 to {MOST_TRUTH_POINTS}",
            said.truth_points
        )));
    }
    Ok(())
}

fn synthetic(path: &Path) -> Result<SyntheticFrame, InjectionError> {
    let mut frame = SyntheticFrame::from_toml(&text_of("synthetic frame", path)?, &path.display().to_string())?;
    // Paths in a file start from its folder.
    let folder: PathBuf = path.parent().unwrap_or(Path::new("")).to_owned();
    frame.star_list = frame.star_list.map(|list| folder.join(list));
    Ok(frame)
}
