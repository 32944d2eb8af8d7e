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
const SUMS: &[&str] = &["LIVETIME", "TOTALEXP", "TOTEXP", "TOTEXPT", "EXPTOT", "EXPTOTAL"];

/// Keywords of the number of exposures that the detector adds before it stores a frame.
const COADDS: &[&str] = &[
    "COADDS",
    "COADD",
    "NCOADDS",
    "NCOADD",
    "CO-ADDS",
    "NUMCOADD",
    "COADDONE",
    "NDIT",
    "ESO DET NDIT",
    "NSUBEXP",
    "COEXP",
    "NUMACC",
];
/// Keywords of the number of frames that were added afterwards.
const STACKED: &[&str] = &[
    "STACKCNT", "NCOMBINE", "NCOMB", "NUM-COMB", "SNAPSHOT", "N-STACK", "NUMSTACK", "STACKNUM", "STACKED", "NINPUTS",
    "NDRIZIM",
];
/// Keywords of a number of exposures that are added, or that follow each other in separate files.
const DOUBTFUL: &[&str] = &[
    "NEXP", "NUMEXP", "NEXPOSUR", "NFRAME", "NFRAMES", "NUMFRAME", "FRAMES", "NIMG", "NIMAGES", "N-IMAGES", "NSUB",
    "NSUBS", "NUMSUB",
];
/// Keywords of the kind of a frame, and words of stacks in their values.
const KINDS: &[&str] = &["IMAGETYP", "IMAGETYPE", "FRAMETYP", "OBSTYPE", "PRODTYPE", "PROCTYPE"];
const STACKS: &str = "stack stacked stacks stacking coadd coadded coaddition";

/// Comments of other counts of added frames state a number of [`FRAMES`], have a word of [`ADDED`], and none of
/// [`OF_CALIBRATION`].
const FRAMES: &str = "image images frame frames exposure exposures subframe subframes sub subs subexposures inputs \
     files lights";
/// Frames, if they are several.
const SEVERAL: &str = "images frames exposures subexposures subframes subs inputs files lights accumulations";
const ADDED: &str = "stack stacked stacking combine combined combining coadd coadds coadded co added adding summed sum \
     averaged average median integrated accumulated drizzled input inputs";
const OF_CALIBRATION: &str = "bias biases dark darks flat flats zero zeros fringe sky calibration master reference ref \
     template background pixel pixels star stars rejected";
/// Words of times and names instead of counts.
const NO_COUNTS: &str = "time second seconds sec s minutes hours id index method mode rate fps guiding guider";
/// Words of series of separate files.
const OF_SERIES: &str = "sequence series set run group groups";

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
/// Largest difference between keywords of the start or of the end that is not stated, in addition to their rounding,
/// seconds.
pub(super) const STATED_S: f64 = 5.0;

const PER_PART: &str = "per each single individual one";
const OF_ALL: &str = "total sum summed all combined cumulative accumulated";

/// Exposure time of a header.
pub struct Length {
    pub seconds: f64,
    pub keyword: String,
    /// Error of an exposure of several parts, unless another keyword confirms that the time is that of all parts.
    pub of_parts: Option<Error>,
    /// Sentences about other lengths, and about numbers of exposures that may be those of another file.
    pub remarks: Vec<String>,
}

/// Number of exposures that are added in a frame.
struct Parts {
    keyword: String,
    /// Number, or text that states a stack.
    shown: String,
    /// Smallest number of exposures.
    count: f64,
}

impl Parts {
    fn new(keyword: impl Into<String>, count: f64) -> Self {
        Self { keyword: keyword.into(), shown: count.to_string(), count }
    }
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
    if let Some(Parts { count, .. }) = &parts {
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
    let mut remarks = Vec::new();
    // "Total number of exposures" (Liverpool Telescope) is no time.
    let is_count = |name: &str| {
        let found = keywords.find(name);
        found.is_some_and(|(header, from)| keywords.comment(header, &from).has("number count"))
    };
    for name in SPANS.iter().chain(SUMS).filter(|name| !is_count(name)) {
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
        } else if other.seconds > seconds + STATED_S || (is_span && other.seconds < seconds - STATED_S) {
            let other = format!("{} is {} s ({what})", other.keyword, other.seconds);
            remarks.push(format!(
                "{keyword} is {seconds} s, but {other}: {keyword} is used; for another span specify --exposure"
            ));
        }
    }
    let of_part = keywords.number(PART_TIMES, |time| agree(time, seconds));
    let is_whole = is_whole
        || parts.as_ref().is_some_and(|Parts { count, .. }| {
            keywords.number(&["EXP1TIME"], |time| agree(count * time, seconds) && time < seconds).is_some()
        });
    let is_of_all = is_whole || (comment.has(OF_ALL) && !comment.has(PER_PART) && of_part.is_none());
    let is_resampled = comment.has("equivalent");
    if parts.is_none()
        && let Some((name, count)) = doubtful(keywords)
    {
        remarks.push(format!(
            "{keyword} is {seconds} s, and {name} is {count}: {keyword} is used as the time of this frame from start to end; \
             if it is a stack, specify --exposure"
        ));
    }
    let parts = parts.or_else(|| is_resampled.then(|| Parts::new(keyword.clone(), 1.0)));
    let of_parts = parts.and_then(|Parts { keyword: name, shown, count }| {
        let is_coadd = COADDS.iter().any(|coadds| is_spelling(coadds, &name));
        if is_of_all && is_coadd {
            return None;
        }
        let given = if is_resampled {
            format!("{seconds} s, the equivalent time of a stack by its comment {:?}", comment.text())
        } else if comment.has(PER_PART) || of_part.is_some() {
            format!("{seconds} s of each of {count} exposures ({name})")
        } else {
            format!("{seconds} s, and {name} is {shown}: the time of one exposure or of all")
        };
        let least_s = if is_of_all { seconds } else { count * seconds };
        let allowed = format!(
            "the time from the first to the last exposure; specify it, for example --exposure {least_s}s if there are no gaps"
        );
        Some(Error::invalid(keyword.clone(), given, allowed))
    });
    Ok(Length { seconds, keyword, of_parts: of_parts.or(of_sum), remarks })
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

/// Returns the number of exposures that are added in the frame, if they are several. `is_per_part` is true if the comment
/// of the exposure time states that it is the time of one of them.
fn parts(keywords: Keywords<'_>, is_per_part: bool) -> Option<Parts> {
    let sure = COADDS.iter().chain(STACKED).find_map(|keyword| keywords.number(&[keyword], |count| count > 1.0));
    if let Some((keyword, count, _)) = sure {
        return Some(Parts::new(keyword, count));
    }
    if let Some((keyword, count)) = doubtful(keywords).filter(|_| is_per_part) {
        return Some(Parts::new(keyword, count));
    }
    let kind = KINDS.iter().find_map(|name| {
        keywords
            .text(&[name])
            .map(|(keyword, kind)| (keyword, Comment::new(&kind)))
            .filter(|(_, kind)| kind.has(STACKS) && !kind.has(OF_CALIBRATION) && !kind.has("candidate"))
    });
    if let Some((keyword, kind)) = kind {
        return Some(Parts { keyword, shown: format!("{:?}", kind.text()), count: 1.0 });
    }
    keywords.0.iter().find_map(|header| counted(header, is_per_part))
}

/// Returns the keyword and the value of a number of exposures that may be that of separate files.
fn doubtful(keywords: Keywords<'_>) -> Option<(String, f64)> {
    DOUBTFUL.iter().find_map(|name| {
        let is_of_frame = |comment: &String| {
            let comment = Comment::new(comment);
            !comment.has(OF_SERIES) && !comment.has(OF_CALIBRATION)
        };
        let found = keywords.number(&[name], |count| count > 1.0).filter(|(.., comment)| is_of_frame(comment));
        found.map(|(keyword, count, _)| (keyword, count))
    })
}

/// Returns the number of added frames that the comment of a card, the list of the frames (IRAF) or a remark states, for
/// example in the history of PixInsight.
fn counted(header: &Header, is_per_part: bool) -> Option<Parts> {
    let mut listed = 0;
    for card in header.cards() {
        let keyword = card.keyword();
        if ["HISTORY", "COMMENT"].contains(&keyword.as_str()) {
            if let Some(count) = counted_in(&card.remark_text()).filter(|count| *count > 1.0) {
                return Some(Parts::new(format!("the number of frames in {keyword}"), count));
            }
        } else if keyword.strip_prefix("IMCMB").is_some_and(|number| number.parse::<u32>().is_ok()) {
            listed += 1;
        } else if let Some(count) = whole_number(card.value()).filter(|count| *count > 1.0) {
            let comment = Comment::new(&card.comment());
            let is_number = comment.has_pair("number num count", "of") || comment.has_pair(FRAMES, "count");
            let is_of_parts = (is_per_part && !comment.has(OF_SERIES)) || comment.has(ADDED);
            // "Light frames combined", "images in this stack", "accumulated images"
            let is_sum = comment.has_pair(SEVERAL, ADDED)
                || comment.has_pair(ADDED, SEVERAL)
                || (comment.has_pair(SEVERAL, "in") && comment.has(ADDED));
            let is_sum = is_sum && !comment.has(NO_COUNTS) && !comment.has(OF_SERIES);
            if ((is_number && comment.has(FRAMES) && is_of_parts) || is_sum) && !comment.has(OF_CALIBRATION) {
                return Some(Parts::new(keyword, count));
            }
        }
    }
    (listed > 1).then(|| Parts::new("IMCMBnnn", f64::from(listed)))
}

/// Returns a whole number, which may be written as a text.
fn whole_number(value: Option<CardValue>) -> Option<f64> {
    match value? {
        CardValue::Integer(count) => Some(count as f64),
        CardValue::Text(text) => text.trim().parse::<u32>().ok().map(f64::from),
        _ => None,
    }
}

/// Returns the number of added frames in a remark such as "Stacked 12 images using median".
fn counted_in(text: &str) -> Option<f64> {
    if let Some((_, count)) = text.split_once("numberOfImages:") {
        return count.trim().parse().ok();
    }
    let remark = Comment::new(text);
    let words: Vec<&str> = text.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty()).collect();
    let is_several = |word: &str| SEVERAL.split_ascii_whitespace().any(|other| other.eq_ignore_ascii_case(word));
    let pair = words.windows(2).find(|pair| is_several(pair[1]) && pair[0].parse::<u32>().is_ok());
    // "masterdark", "superbias"
    let lower = text.to_ascii_lowercase();
    let is_of_calibration =
        ["bias", "dark", "flat", "zero", "fringe", "cosmic"].iter().any(|word| lower.contains(word));
    let is_sum = (remark.has(STACKS) || remark.has("combine combined combining averaged summed"))
        && !remark.has(OF_CALIBRATION)
        && !is_of_calibration;
    pair.filter(|_| is_sum)?[0].parse().ok()
}
