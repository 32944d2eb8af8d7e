//! Exposure time in a header: its keywords, units, and the number of co-added exposures.

use crate::constants::LONGEST_EXPOSURE_S;
use crate::error::Error;

use super::super::card::CardValue;
use super::super::header::Header;
use super::comment::{Comment, seconds_in};
use super::instants::unreadable;
use super::moment::{Keywords, is_spelling};

/// Keywords of the exposure time, in order of precedence.
const LENGTHS: &[&str] =
    &["EXPTIME", "XPOSURE", "EXPOSURE", "EXP-TIME", "ITIME", "TEXPTIME", "INT-TIME", "ELAPTIME", "SHUTTIME", EXPOINUS];
/// Exposure time in microseconds (ZWO).
const EXPOINUS: &str = "EXPOINUS";
/// Keyword that is used only without the others: ITIME is the requested time, and this one the true one (IRTF).
const TRUE_TIME: &str = "TRUITIME";
/// Keywords of the time of one of several added exposures.
const PART_TIMES: &[&str] = &["ESO DET DIT", "EXP1TIME", "SUBEXP"];

/// Keywords of the time from the start to the end of the exposure, and of the sum over several exposures.
const SPANS: &[&str] = &["TELAPSE", "TELAPSED"];
const SUMS: &[&str] = &["LIVETIME", "TOTALEXP", "TOTEXP", "TOTEXPT", "EXPTOTAL"];

/// Keywords of the number of exposures that the detector adds before it stores a frame.
const COADDS: &[&str] =
    &["COADDS", "COADD", "NCOADDS", "NCOADD", "CO-ADDS", "NUMCOADD", "COADDONE", "NDIT", "ESO DET NDIT", "NSUBEXP"];
/// Keywords of the number of frames that were added afterwards.
const STACKED: &[&str] =
    &["STACKCNT", "NCOMBINE", "NCOMB", "SNAPSHOT", "NSTACK", "NUMSTACK", "STACKNUM", "STACKED", "NINPUTS", "NDRIZIM"];

/// Comments of other counts of added frames state a number of [`FRAMES`], have a word of [`ADDED`], and none of
/// [`OF_CALIBRATION`].
const FRAMES: &str = "image images frame frames exposure exposures subframe subframes sub subs subexposures inputs \
     files lights";
const ADDED: &str = "stack stacked stacking combine combined combining coadd coadds coadded co added adding summed sum \
     averaged average median integrated accumulated drizzled input inputs";
const OF_CALIBRATION: &str = "bias biases dark darks flat flats zero zeros fringe sky calibration master reference ref \
     template pixel pixels star stars rejected";
/// Words of series of separate files.
const OF_SERIES: &str = "sequence series set run";

/// Keywords of the unit of the exposure time, if its comment states none.
const UNITS: &[&str] = &["EXPUNIT", "EXPUNITS", "TIMEUNIT"];
/// Keywords in the unit of TIMEUNIT (FITS standard 4.0, section 9.4.2).
const OF_TIMEUNIT: &[&str] = &["XPOSURE", "TELAPSE"];

/// Largest difference between exposure times that are taken as consistent: a fraction of the exposure time, and
/// seconds.
const LENGTH_SLACK: f64 = 0.01;
const LENGTH_SLACK_S: f64 = 0.1;
/// Largest accepted overhead within an exposure: a fraction of the exposure time, and seconds.
const SPAN_SLACK: f64 = 0.1;
const SPAN_SLACK_S: f64 = 1.0;

const PER_PART: &str = "per each single individual one";
const OF_ALL: &str = "total sum summed all combined cumulative accumulated";

/// Exposure time of a header.
pub struct Length {
    pub seconds: f64,
    pub keyword: String,
    /// Error of an exposure of several parts, unless another keyword confirms that the time is that of all parts.
    pub of_parts: Option<Error>,
}

/// One keyword of the exposure time.
struct Stated {
    seconds: f64,
    keyword: String,
    comment: Comment,
}

/// Reads the exposure time.
///
/// # Errors
/// The exposure time is missing, invalid or contradictory, or its comment states an unknown unit.
pub fn length(keywords: Keywords<'_>) -> Result<Length, Error> {
    keywords.are_unique(LENGTHS.iter().copied())?;
    let mut lengths: Vec<Stated> = Vec::new();
    for keyword in LENGTHS {
        lengths.extend(stated(keywords, keyword)?);
    }
    if lengths.is_empty() {
        lengths.extend(stated(keywords, TRUE_TIME)?);
    }
    let parts = parts(keywords, lengths.iter().any(|length| length.comment.has(PER_PART)));
    let agree = |a: f64, b: f64| (a - b).abs() <= LENGTH_SLACK_S + LENGTH_SLACK * a.abs();
    let mut is_whole = false;
    if let Some((_, count)) = &parts {
        // A time of one part is consistent with the time of all parts.
        let wholes: Vec<f64> = lengths.iter().map(|length| length.seconds).collect();
        let is_part = |length: &Stated| {
            wholes.iter().any(|whole| agree(*whole, count * length.seconds) && *whole > length.seconds)
        };
        is_whole = lengths.iter().any(is_part);
        lengths.retain(|length| !is_part(length));
    }
    let mut lengths = lengths.into_iter();
    let first = lengths.next().ok_or_else(|| {
        let allowed = "EXPTIME, XPOSURE, EXPOSURE, ITIME, ..., or for example --exposure 30s";
        Error::invalid("length of the exposure", "missing", allowed)
    })?;
    let Stated { seconds, keyword, comment } = first;
    if !(seconds > 0.0 && seconds <= LONGEST_EXPOSURE_S) {
        let allowed = format!("above 0 s, at most {LONGEST_EXPOSURE_S} s (a bias frame has no exposure)");
        return Err(Error::invalid(keyword, format!("{seconds} s"), allowed));
    }
    if let Some(other) = lengths.find(|other| !agree(seconds, other.seconds)) {
        let given = format!("{seconds} s and {} is {} s", other.keyword, other.seconds);
        return Err(Error::invalid(keyword, given, "one length; specify it, for example --exposure 30s"));
    }
    let mut of_sum = None;
    for name in SPANS.iter().chain(SUMS) {
        let Some(other) = stated(keywords, name)? else { continue };
        let slack_s = SPAN_SLACK_S + SPAN_SLACK * seconds;
        let is_span = SPANS.contains(name);
        let what = if is_span { "from start to end" } else { "in all parts" };
        let given = format!("{seconds} s, but {} is {} s ({what})", other.keyword, other.seconds);
        let allowed =
            "an exposure without gaps; specify --exposure of the whole span, or --start and --exposure of one part";
        let error = Error::invalid(keyword.clone(), given, allowed);
        if is_span && (other.seconds - seconds).abs() > slack_s {
            return Err(error);
        }
        if other.seconds > seconds + slack_s {
            of_sum = of_sum.or(Some(error));
        }
    }
    let of_part = keywords.number(PART_TIMES, |time| agree(time, seconds));
    let is_of_all = is_whole || (comment.has(OF_ALL) && !comment.has(PER_PART) && of_part.is_none());
    let is_resampled = comment.has("equivalent");
    let of_parts = parts.or_else(|| is_resampled.then(|| (keyword.clone(), 1.0))).and_then(|(name, count)| {
        let is_coadd = COADDS.iter().any(|coadds| is_spelling(coadds, &name));
        if is_of_all && is_coadd {
            return None;
        }
        let given = if is_resampled {
            format!("{seconds} s, the equivalent time of a stack by its comment {:?}", comment.text())
        } else if comment.has(PER_PART) || of_part.is_some() {
            format!("{seconds} s of each of {count} exposures ({name})")
        } else {
            format!("{seconds} s, and {name} is {count}: the time of one exposure or of all")
        };
        let least_s = if is_of_all { seconds } else { count * seconds };
        let allowed = format!(
            "the time from the first to the last exposure; specify it, for example --exposure {least_s}s if there are no gaps"
        );
        Some(Error::invalid(keyword.clone(), given, allowed))
    });
    Ok(Length { seconds, keyword, of_parts: of_parts.or(of_sum) })
}

/// Returns the time of one keyword; `None` if the header does not have it.
fn stated(keywords: Keywords<'_>, keyword: &str) -> Result<Option<Stated>, Error> {
    let Some((header, keyword)) = keywords.find(keyword) else { return Ok(None) };
    let Some(number) = header.number(&keyword) else {
        let value = header.text(&keyword).unwrap_or_default();
        return Err(unreadable(keyword, &value, "a number of seconds"));
    };
    let comment = Comment::new(&header.comment(&keyword));
    let in_unit = |unit: String| {
        let given = format!("{number} in {unit} (comment {:?})", comment.text());
        let allowed = "one of [s], [ms], [us], [ns], [min], [h], [d]; or for example --exposure 30s";
        Error::invalid(keyword.clone(), given, allowed)
    };
    let unit_s = match comment.unit_s().map_err(in_unit)? {
        Some(unit_s) => unit_s,
        None if keyword == EXPOINUS => 1e-6,
        None => match keywords.text(UNITS) {
            None => 1.0,
            Some((name, unit)) => {
                let stated = seconds_in(&unit).ok_or_else(|| in_unit(format!("the unit {unit:?} of {name}")))?;
                // TIMEUNIT is the unit of these keywords only; others may be in seconds nevertheless.
                if stated != 1.0 && name == "TIMEUNIT" && !OF_TIMEUNIT.contains(&keyword.as_str()) {
                    return Err(in_unit(format!("seconds, or in the unit {unit:?} of TIMEUNIT")));
                }
                stated
            }
        },
    };
    // Rounded to 1 ns: 2.31481481481481e-05 days are 2 s.
    let seconds = if unit_s == 1.0 { number } else { (number * unit_s * 1e9).round() / 1e9 };
    Ok(Some(Stated { seconds, keyword, comment }))
}

/// Returns the keyword and the number of exposures that are added in the frame, if they are several. `is_per_part` is
/// true if the comment of the exposure time states that it is the time of one of them.
fn parts(keywords: Keywords<'_>, is_per_part: bool) -> Option<(String, f64)> {
    let sure = COADDS.iter().chain(STACKED).find_map(|keyword| keywords.number(&[keyword], |count| count > 1.0));
    if let Some((keyword, count, _)) = sure {
        return Some((keyword, count));
    }
    keywords.0.iter().find_map(|header| counted(header, is_per_part))
}

/// Returns the keyword and the number of added frames that the comment of a card, the list of the frames (IRAF) or the
/// history (PixInsight) states.
fn counted(header: &Header, is_per_part: bool) -> Option<(String, f64)> {
    let mut listed = 0;
    for card in header.cards() {
        let keyword = card.keyword();
        if keyword == "HISTORY" {
            let text = card.remark_text();
            let count = text.split_once("numberOfImages:").and_then(|(_, count)| count.trim().parse::<f64>().ok());
            if let Some(count) = count.filter(|count| *count > 1.0) {
                return Some(("numberOfImages in HISTORY".to_owned(), count));
            }
        } else if keyword.strip_prefix("IMCMB").is_some_and(|number| number.parse::<u32>().is_ok()) {
            listed += 1;
        } else if let Some(CardValue::Integer(count)) = card.value() {
            let comment = Comment::new(&card.comment());
            let is_number = comment.has_pair("number num count", "of") || comment.has_pair(FRAMES, "count");
            if count > 1
                && is_number
                && comment.has(FRAMES)
                && ((is_per_part && !comment.has(OF_SERIES)) || comment.has(ADDED))
                && !comment.has(OF_CALIBRATION)
            {
                return Some((keyword, count as f64));
            }
        }
    }
    (listed > 1).then(|| ("IMCMBnnn".to_owned(), f64::from(listed)))
}
