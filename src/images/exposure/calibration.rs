//! Photometric calibration of counts: zero point, gain, read noise, saturation, band.

use super::super::header::Header;
use super::comment::Comment;
use super::moment::Keywords;

/// Value from a header, with the keyword that gave it.
#[derive(Clone, Debug, PartialEq)]
pub struct HeaderValue<T> {
    /// The value.
    pub value: T,
    /// The keyword, or several keywords joined.
    pub keyword: String,
}

/// Whether a zero point refers to counts of the whole frame or to counts per second.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum CountBasis {
    /// Counts of the frame: a source whose pixels sum to 1 has the magnitude of the zero point.
    Frame,
    /// Counts per second: a source whose pixels, divided by the exposure time, sum to 1 has the magnitude of the zero
    /// point.
    Second,
}

/// Magnitude zero point.
#[derive(Clone, Debug, PartialEq)]
pub struct ZeroPoint {
    /// Magnitude of a source of one count, in the sense of `basis`.
    pub mag: f64,
    /// Kind of counts; `None` if neither the keyword nor its comment determines it, so that the user must specify it.
    pub basis: Option<CountBasis>,
    /// The keyword that gave the zero point.
    pub keyword: String,
    /// True if only the usual meaning of the keyword determines the kind of counts.
    pub is_basis_assumed: bool,
}

#[cfg(all(feature = "fits", unix))]
impl ZeroPoint {
    /// Returns a sentence that states the kind of counts, if only the usual meaning of the keyword determines it.
    pub(crate) fn assumption(&self) -> Option<String> {
        let (mag, keyword) = (self.mag, &self.keyword);
        let (counts, others) = match self.basis? {
            CountBasis::Second => ("counts per second", format!("the whole exposure specify --zero-point {mag}")),
            CountBasis::Frame => ("counts of the frame", format!("counts per second specify --zero-point-1s {mag}")),
        };
        self.is_basis_assumed.then(|| format!("{keyword} {mag} is read as the zero point of {counts}; for {others}"))
    }
}

/// Unit of the pixels of a frame.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum PixelUnit {
    /// Counts, or an unknown unit.
    Counts,
    /// Electrons.
    Electrons,
    /// Calibrated flux, flux density or surface brightness, for example in nanomaggies, janskys or MJy/sr.
    Flux,
    /// Magnitudes, which are no light that can be added.
    Magnitudes,
}

/// Parts of units of flux, flux density and surface brightness, in lower case and without spaces, brackets, `*` and
/// `^`.
const FLUXES: [&str; 12] =
    ["nanomagg", "nmgy", "jy", "jansky", "erg", "watt", "w/m2", "wm-2", "w.m-2", "/sr", "sr-1", "/arcsec2"];

/// Parses BUNIT. Returns the unit, and true if it is a unit per second.
fn parsed_unit(text: &str) -> (PixelUnit, bool) {
    let unit = text.to_ascii_lowercase().replace([' ', '*', '^', '(', ')'], "");
    let ends = ["/second", "/sec", "/s", "second-1", "sec-1", "s-1", "persecond", "persec"];
    let bare = ends.iter().find_map(|end| unit.strip_suffix(end));
    let name = bare.unwrap_or(&unit).trim_end_matches(['.', '/']);
    let kind = match name {
        "e" | "e-" | "electron" | "electrons" | "photon" | "photons" => PixelUnit::Electrons,
        _ if name.starts_with("mag") => PixelUnit::Magnitudes,
        _ if FLUXES.iter().any(|part| name.contains(part)) => PixelUnit::Flux,
        _ => PixelUnit::Counts,
    };
    (kind, bare.is_some())
}

/// Photometric calibration in a header. A value is `None` if it is missing or invalid (for example a gain of 0).
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// Magnitude zero point.
    pub zero_point: Option<ZeroPoint>,
    /// Gain, electrons per count; the mean if the header gives it for two amplifiers.
    pub gain_e_adu: Option<HeaderValue<f64>>,
    /// Reason why the gain in the header is not used, for example that it may be a setting of the camera.
    pub doubtful_gain: Option<String>,
    /// Read noise, electrons; the mean if the header gives it for two amplifiers.
    pub read_noise_e: Option<HeaderValue<f64>>,
    /// Count at which a pixel is saturated; the lower one if the header gives it for two amplifiers.
    pub saturation_adu: Option<HeaderValue<f64>>,
    /// Filter or band as written in the header.
    pub band: Option<HeaderValue<String>>,
    /// Text of BUNIT, the unit of the pixels.
    pub unit: Option<HeaderValue<String>>,
    /// Unit of the pixels; counts if the header does not give a unit.
    pub pixel_unit: PixelUnit,
    /// True if pixels contain rates per second, false if they contain sums over the exposure.
    pub is_rate: bool,
}

/// Keywords of zero points, with the kind of counts that the software writing them uses.
///
/// The community pipeline of DECam and Mosaic writes MAGZERO for 1 ADU per second: its value of 25.1 in g agrees with
/// DECam's zero point of 26.6 for one electron and its gain of 4. ZTF and 2MASS write MAGZP for 1 DN of the frame. The
/// other keywords are used for both kinds of counts.
const ZERO_POINTS: &[(&str, Option<CountBasis>)] = &[
    ("MAGZERO", Some(CountBasis::Second)),
    ("MAGZP", Some(CountBasis::Frame)),
    ("MAGZPT", None),
    ("PHOTZP", None),
    ("ZP", None),
    ("ZEROPT", None),
];

/// AB magnitudes of the units of flux density: those of BUNIT, whose letters differ from `MJy`, and the magnitude of
/// one (SDSS and Legacy Surveys; -2.5 log10 of 3631 Jy).
const FLUX_UNITS: [(&[&str], f64); 5] = [
    (&["nanomaggy", "nanomaggies", "nMgy", "nmgy"], 22.5),
    (&["nJy", "nanojansky"], 31.4),
    (&["uJy", "microJy", "microjansky"], 23.9),
    (&["mJy", "millijansky"], 16.4),
    (&["Jy", "jansky"], 8.9),
];

impl Calibration {
    /// Reads the calibration from the headers of a frame, given in the order of precedence: first the header of the
    /// image, then the primary header.
    pub fn from_headers(headers: &[&Header]) -> Self {
        let keywords = Keywords(headers);
        let (pixel_unit, is_rate) =
            keywords.text(&["BUNIT"]).map_or((PixelUnit::Counts, false), |(_, unit)| parsed_unit(&unit));
        let stated_text = |names: &[&str]| keywords.text(names).map(|(keyword, value)| HeaderValue { value, keyword });
        let (gain_e_adu, doubtful_gain) = match gain(keywords) {
            Ok(gain) => (gain, None),
            Err(doubt) => (None, Some(doubt)),
        };
        // The header of a calibrated frame often still has the gain of the raw counts.
        let doubtful_gain = match (&gain_e_adu, pixel_unit) {
            (Some(gain), PixelUnit::Flux) => {
                let unit = keywords.text(&["BUNIT"]).map(|(_, unit)| unit).unwrap_or_default();
                Some(format!("{} is that of counts, the pixels are in {unit}", gain.keyword))
            }
            _ => doubtful_gain,
        };
        Self {
            zero_point: zero_point(keywords),
            gain_e_adu,
            doubtful_gain,
            read_noise_e: of_amplifiers(
                keywords,
                &["RDNOISE", "READNOIS", "READNOISE", "RON", "RONOISE", "ENOISE"],
                &["RDNOISEA", "RDNOISEB"],
                mean,
            ),
            saturation_adu: of_amplifiers(
                keywords,
                &["SATURATE", "SATURAT", "SATLEVEL", "SATURATION"],
                &["SATURATA", "SATURATB"],
                f64::min,
            ),
            band: stated_text(&["FILTER", "BAND", "FILTNAM", "FILTER01", "FILTER1", "INSFLNAM", "FILTERS", "FILTER2"]),
            unit: stated_text(&["BUNIT"]),
            pixel_unit,
            is_rate,
        }
    }
}

fn mean(a: f64, b: f64) -> f64 {
    (a + b) / 2.0
}

/// Returns a number from one of its keywords, or else from the keywords of the two amplifiers.
fn of_amplifiers(
    keywords: Keywords<'_>,
    names: &[&str],
    pair: &[&str; 2],
    join: impl Fn(f64, f64) -> f64,
) -> Option<HeaderValue<f64>> {
    let positive = |number: f64| number > 0.0;
    if let Some((keyword, value, _)) = keywords.number(names, positive) {
        return Some(HeaderValue { value, keyword });
    }
    let [first, second] = pair.map(|name| keywords.number(&[name], positive));
    let ((a, value_a, _), (b, value_b, _)) = (first?, second?);
    Some(HeaderValue { value: join(value_a, value_b), keyword: format!("{a}, {b}") })
}

/// Words in comments of a gain that is a setting of the camera, in its own steps, or of one of its stages.
const SETTINGS: &str = "db setting settings sensor camera analog analogue digital iso index mode value level percent \
     percentage unitless relative zwo qhy step steps pre preamp preamplifier em emccd multiplication shift bit bits units dial \
     slider table unity uv mv volt volts microvolt microvolts x x1 x2 x4 x8";
/// Keywords that camera programs write beside a gain that is a setting.
const CAMERA_OFFSETS: &[&str] = &["OFFSET", "BLKLEVEL", "ISOSPEED", "ISO"];
/// Keywords of the multiplication of electrons before the amplifier, by which a gain is to be divided.
const MULTIPLICATIONS: &[&str] = &["EMGAIN", "EM-GAIN", "EMREALGN", "MULTGAIN"];
/// Keywords with the camera or the program that wrote the header, and beginnings of words of those whose gain is a
/// setting.
const CAMERAS: &[&str] =
    &["INSTRUME", "CAMERA", "CAMMODEL", "DETECTOR", "SWCREATE", "SWMODIFY", "CREATOR", "PROGRAM", "SOFTWARE"];
const SETTING_CAMERAS: &[&str] = &[
    "zwo",
    "asi",
    "qhy",
    "toupcam",
    "touptek",
    "altair",
    "svbony",
    "sv",
    "moravian",
    "seestar",
    "vespera",
    "stellina",
    "mallincam",
    "bresser",
    "basler",
    "flir",
    "blackfly",
    "player",
    "poseidon",
    "atr3",
    "atr2",
    "atik",
    "dmk",
    "dfk",
    "apt",
    "omegon",
    "ogma",
    "risingcam",
    "canon",
    "nikon",
    "sony",
    "sharpcap",
    "nina",
    "n.i.n.a",
    "firecapture",
    "kstars",
    "ekos",
    "asistudio",
    "asiair",
    "asicap",
    "stellarmate",
];
/// Largest gain without a unit that is taken as electrons per count. The 16 bits of most detectors hold a full well of
/// 100,000 electrons at a gain below 2, and those of infrared arrays at a gain below 20.
const LARGEST_GAIN_E: f64 = 20.0;
/// Largest difference between two gains that are taken as the same, a fraction.
const GAIN_SLACK: f64 = 0.05;

/// Returns the gain, electrons per count. The comment of the keyword may state that the value is the inverse.
///
/// # Errors
/// The reason why a value is not used: programs of cameras write a setting as GAIN.
fn gain(keywords: Keywords<'_>) -> Result<Option<HeaderValue<f64>>, String> {
    let positive = |number: f64| number > 0.0;
    // EGAIN of SharpCap is that of the detector's own bits, and EGAINSAV that of the pixels.
    let names = ["EGAINSAV", "EGAIN", "GAIN", "CCDGAIN", "ESO DET OUT1 CONAD"];
    let Some((keyword, value, comment)) = keywords.number(&names, positive) else {
        let pair = of_amplifiers(keywords, &[], &["GAINA", "GAINB"], mean);
        return match pair {
            Some(gain) if gain.value > LARGEST_GAIN_E => Err(doubt(&gain.keyword, gain.value, "")),
            pair => Ok(pair),
        };
    };
    let words = Comment::new(&comment);
    let joined = joined(&comment);
    let is_inverse = [
        "adu/e",
        "dn/e",
        "adupere",
        "dnpere",
        "count/e",
        "counts/e",
        "countpere",
        "countspere",
        "adu/photo",
        "count/photo",
        "counts/photo",
    ]
    .iter()
    .any(|words| joined.contains(words));
    // "Conversion from electrons to ADU" is a number of counts per electron in raw frames of ESO, and of electrons per count
    // in reduced ones.
    let is_either = ["adu", "dn", "count"].iter().any(|count| {
        ["electronsto", "electronto", "e-to"].iter().any(|from| joined.contains(&format!("{from}{count}")))
    });
    if is_either && !is_inverse {
        return Err(format!("{keyword} is {value} ({comment}): electrons per count or counts per electron"));
    }
    let has_unit = is_inverse || has_electron_unit(&comment);
    // "0.1dB", "%", "[uV/e-]"
    let in_brackets = comment.trim_start().strip_prefix('[').is_some_and(|unit| !unit.starts_with('e'));
    let has_other_unit = in_brackets || comment.contains('%') || comment.contains("dB");
    // Of electrons by their names.
    let is_named = keyword.starts_with("EGAIN");
    let is_of_camera = !is_named && keywords.number(CAMERA_OFFSETS, |_| true).is_some();
    let is_setting = words.has(SETTINGS) || has_other_unit || is_of_camera;
    let is_camera = CAMERAS.iter().filter_map(|keyword| keywords.text(&[keyword])).any(|(keyword, text)| {
        let lower = text.to_ascii_lowercase();
        let is_of = |word: &str, camera: &str| {
            word.strip_prefix(camera).is_some_and(|rest| match camera {
                // Names of cameras have a number, as ASI294MM; other words begin like this.
                "asi" | "sv" => rest.starts_with(|mark: char| mark.is_ascii_digit()),
                // Sensors of Sony are also in the cameras of observatories.
                "sony" => keyword != "DETECTOR",
                _ => true,
            })
        };
        lower.split_whitespace().any(|word| SETTING_CAMERAS.iter().any(|camera| is_of(word, camera)))
    });
    let is_setting = is_setting || (is_camera && keyword == "GAIN");
    let is_of_sharpcap = || {
        let texts = CAMERAS.iter().filter_map(|keyword| keywords.text(&[keyword]));
        texts.into_iter().any(|(_, text)| text.to_ascii_lowercase().contains("sharpcap"))
    };
    if keyword == "EGAIN" && is_of_sharpcap() {
        return Err(format!(
            "{keyword} is {value}: of the bits of the sensor, not of the pixels (SharpCap without EGAINSAV)"
        ));
    }
    if words.has_pair("bit", "depth") && keyword != "EGAINSAV" {
        return Err(format!("{keyword} is {value} ({}): perhaps not of the pixels of this file", words.text()));
    }
    if let Some((multiplication, factor, _)) = keywords.number(MULTIPLICATIONS, |factor| factor > 1.0) {
        return Err(format!(
            "{keyword} is {value}, and {multiplication} is {factor}: with or without the multiplication"
        ));
    }
    // "[e-]" does not tell electrons per count from a number of electrons.
    let is_per_count =
        is_inverse || has_unit && ["/", "per", "adu", "dn", "count"].iter().any(|sign| joined.contains(sign));
    if !has_unit && is_setting || !is_per_count && value > LARGEST_GAIN_E {
        return Err(doubt(&keyword, value, &comment));
    }
    // "GAIN = 1.0 / e-/ADU" beside EGAIN; a GAIN without a unit is that of the camera.
    let other = keywords.number(&names[2..], |other| positive(other) && (other / value - 1.0).abs() > GAIN_SLACK);
    if let Some((other, other_value, comment)) =
        other.filter(|(other, _, comment)| *other != keyword && !is_inverse && has_electron_unit(comment))
    {
        return Err(format!("{keyword} is {value}, and {other} is {other_value} ({comment})"));
    }
    Ok(Some(HeaderValue { value: if is_inverse { value.recip() } else { value }, keyword }))
}

/// Returns a comment in lower case, without blanks and brackets.
fn joined(comment: &str) -> String {
    comment.to_ascii_lowercase().replace([' ', '(', ')', '[', ']'], "")
}

/// Returns true if the comment of a gain states electrons, as in "[electrons/count]".
fn has_electron_unit(comment: &str) -> bool {
    let joined = joined(comment);
    let units = ["e-/", "e/adu", "e/dn", "e-adu", "e-per", "eperadu", "toe-", "electron", "photon"];
    units.iter().any(|unit| joined.contains(unit))
}

/// Returns the reason why a gain is not used.
fn doubt(keyword: &str, value: f64, comment: &str) -> String {
    let stated = if comment.is_empty() { String::new() } else { format!(" ({comment})") };
    format!("{keyword} is {value}{stated}: a setting of the camera or electrons per count")
}

/// Names of the exposure time in formulas, and beginnings of them in logarithms, in lower case.
const TIMES: &[&str] = &["exptime", "texp", "t_exp", "xposure"];
const TIMES_IN_LOGARITHMS: &[&str] = &["exp", "texp", "t_exp", "xpos", "itime", "time"];

fn zero_point(keywords: Keywords<'_>) -> Option<ZeroPoint> {
    let of_frame =
        |mag: f64, keyword: String| ZeroPoint { mag, basis: Some(CountBasis::Frame), keyword, is_basis_assumed: false };
    let unit = keywords.text(&["BUNIT"]).map(|(_, unit)| unit.replace(' ', "")).unwrap_or_default();
    // "nJy/pixel"
    let flux =
        unit.split_once('/').filter(|(_, area)| ["pix", "pixel"].contains(area)).map_or(&*unit, |(flux, _)| flux);
    // Names are read in any case; symbols are not, because M is a million.
    let is_unit = |name: &&str| *name == flux || (name.len() > 4 && name.eq_ignore_ascii_case(flux));
    if let Some((_, mag)) = FLUX_UNITS.iter().find(|(names, _)| names.iter().any(is_unit)) {
        return Some(of_frame(*mag, "BUNIT".to_owned()));
    }
    // The LSST pipelines write the counts of a source of magnitude 0 instead of a zero point.
    if let Some((keyword, flux, _)) = keywords.number(&["FLUXMAG0"], |flux| flux > 0.0) {
        return Some(of_frame(2.5 * flux.log10(), keyword));
    }
    let is_magnitude = |number: f64| number != 0.0 && number.is_finite() && number.abs() < 60.0;
    ZERO_POINTS.iter().find_map(|(name, usual)| {
        let (keyword, mag, comment) = keywords.number(&[name], is_magnitude)?;
        let comment = comment.to_ascii_lowercase();
        let is_per_second = ["/s", "per sec", "1 sec", "s-1", "s^-1"].iter().any(|words| comment.contains(words));
        // As in synthetic frames
        let is_of_frame = ["in the frame", "of the frame"].iter().any(|words| comment.contains(words));
        let of_formula = basis_of_formula(&comment);
        let of_frame = is_of_frame.then_some(CountBasis::Frame);
        let of_words = if is_per_second { Some(CountBasis::Second) } else { of_frame };
        let stated = of_words.or(of_formula.flatten());
        // A formula that cannot be read leaves no usual meaning.
        let usual = if of_words.is_none() && of_formula == Some(None) { &None } else { usual };
        // If the pixels are rates, their sum is already the count of one second and must not be divided by the exposure
        // time.
        let is_rate = parsed_unit(&unit).1;
        let basis = if is_rate { Some(CountBasis::Frame) } else { stated.or(*usual) };
        Some(ZeroPoint { mag, basis, keyword, is_basis_assumed: !is_rate && stated.is_none() && usual.is_some() })
    })
}

/// Returns the kind of counts of a formula in lower case, such as "mag=-2.5*log(data)+photzp" (ESO phase 3): those of
/// the frame, or of one second if the pixels are rates or divided by the exposure time, in the logarithm or by another
/// one with the opposite sign. `None` without a logarithm of pixels, and `Some(None)` if the exposure time has another
/// effect.
fn basis_of_formula(comment: &str) -> Option<Option<CountBasis>> {
    let is_time = |text: &str| {
        text.trim() == "t" || TIMES_IN_LOGARITHMS.iter().any(|beginning| text.trim().starts_with(beginning))
    };
    // The signs and the arguments of all logarithms.
    let logarithms: Vec<(bool, &str)> = ["log(", "log10("]
        .iter()
        .flat_map(|log| comment.match_indices(log).map(move |(at, log)| (at, at + log.len())))
        .filter_map(|(at, from)| {
            let is_negative = comment[..at].trim_end_matches(|c: char| "0123456789.* ".contains(c)).ends_with('-');
            Some((is_negative, comment[from..].split_once(')')?.0))
        })
        .collect();
    let (is_negative, pixels) = logarithms.iter().find(|(_, inside)| !is_time(inside) && !inside.contains("flux"))?;
    let is_rate = pixels.contains('/') || pixels.contains("rate");
    let times: Vec<&(bool, &str)> = logarithms.iter().filter(|(_, inside)| is_time(inside)).collect();
    Some(match times[..] {
        [] if is_rate => Some(CountBasis::Second),
        [] => (!is_beside_time(comment, pixels)).then_some(CountBasis::Frame),
        [(of_time, _)] if !is_rate && of_time != is_negative => Some(CountBasis::Second),
        _ => None,
    })
}

/// Returns true if a formula contains the exposure time outside of its logarithm.
fn is_beside_time(comment: &str, pixels: &str) -> bool {
    comment
        .split(pixels)
        .any(|part| part.split(|c: char| !(c.is_ascii_alphabetic() || c == '_')).any(|word| TIMES.contains(&word)))
}
