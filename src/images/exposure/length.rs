//! Exposure time in a header: its keywords and units, compared with the number of added exposures.

use crate::constants::LONGEST_EXPOSURE_S;
use crate::error::Error;

use super::super::card::{Card, CardValue};
use super::comment::{AGREED_S, Comment, begins_with_exposure, seconds_in};
use super::moment::{Keywords, bare, is_spelling, parse_time, unreadable};
use super::relative::RelativeTimes;
use super::stacks::{
    ACCUMULATIONS, ADDED, COADDS, OF_CALIBRATION, OF_SERIES, Parts, STACKS, agree, doubtful, is_alone,
    is_of_calibration, parts, product_in,
};

/// Keywords of the exposure time, in order of precedence.
const LENGTHS: &[&str] =
    &["EXPTIME", "XPOSURE", "EXPOSURE", "EXP-TIME", "ITIME", "TEXPTIME", "INT-TIME", "ELAPTIME", EXPOINUS];
/// Exposure time in microseconds (ZWO).
const EXPOINUS: &str = "EXPOINUS";
/// Keywords that are used only without the others: ITIME is the requested time, and TRUITIME the true one (IRTF);
/// EXPOSED (AAT); and EXP if its comment states a unit, because it may also be a number.
const LAST_LENGTHS: &[&str] = &["SHUTTIME", "TRUITIME", "EXPOSED", "EXP", "TEXP"];
/// Keywords of the time of one of several added exposures.
const PART_TIMES: &[&str] = &["ESO DET DIT", "EXP1TIME", "SUBEXP"];

/// Keywords of the time from the start to the end of the exposure, and of the sum over several exposures.
const SPANS: &[&str] = &["TELAPSE", "TELAPSED"];
const SUMS: &[&str] = &["LIVETIME", "TOTALEXP", "TOTEXP", "TOTEXPT", "EXPTOT", "EXPTOTAL"];
/// Keywords of times that may be those of the exposure with gaps, of all parts of a stack, or of a sequence, and parts
/// of such keywords.
const DOUBTFUL_TIMES: &[&str] = &["TEXP", "EXP-SUM"];
const ELAPSED: &[&str] = &[
    "ELAPS", "DURAT", "EXPDUR", "OBSDUR", "REALTIM", "WALLTIM", "WALLCL", "CLOCKTIM", "TIMESPAN", "EXPSPAN", "OBSSPAN",
    "ONTIME", "ACQTIM",
];
const TOTALS: &[&str] = &["TOT", "CUM", "SUM", "STACK"];
/// Keywords of the true or measured exposure time, which may be shorter than the requested one, and words of comments.
const TRUE_TIMES: &[&str] = &[
    "ACTEXP", "ACTTIME", "ACTUALEX", "REALEXP", "REALTIME", "TRUEEXP", "EXPOSED", "EXPMEAS", "MEASEXP", "REXPTIME",
    "DARKTIME", "ELAPSED", "TRUITIME", "SHUTTIME",
];
const TRUE: &str = "actual real measured true";
/// Words of comments of the requested exposure time, which is used alone.
const REQUESTED: &str = "requested request asked commanded";
/// Words of exposures that were ended early.
const ABORTED: &str = "abort aborted interrupted cancelled canceled";

/// Keywords of the number of integrations in headers of ESO, and of the time of one of them.
const ESO_INTEGRATIONS: &[(&str, &[&str])] = &[
    ("ESO DET NDIT", &["ESO DET DIT", "ESO DET SEQ1 DIT"]),
    ("ESO DET1 NDIT", &["ESO DET1 DIT", "ESO DET1 SEQ1 DIT"]),
    ("ESO DET2 NDIT", &["ESO DET2 DIT", "ESO DET2 SEQ1 DIT"]),
    ("ESO DET WIN1 NDIT", &["ESO DET WIN1 DIT1", "ESO DET WIN1 UIT1"]),
];
/// Keywords of the unit of the exposure time, if its comment states none.
const UNITS: &[&str] = &["EXPUNIT", "EXPUNITS", "TIMEUNIT"];
/// Keywords in the unit of TIMEUNIT (FITS standard 4.0, section 9.4.2).
const OF_TIMEUNIT: &[&str] = &["XPOSURE", "TELAPSE"];

/// Largest accepted overhead within an exposure: a fraction of the exposure time, and seconds.
const SPAN_SLACK: f64 = 0.1;
const SPAN_SLACK_S: f64 = 1.0;
/// Largest difference of middles, ends and lengths of long exposures that is not stated, in addition to their rounding,
/// seconds.
pub const STATED_S: f64 = 5.0;

/// Words of times beside the exposure time.
const OVERHEADS: &str = "overhead overheads readout reading dead deadtime download delay delays gaps dither dithers";
/// Words of the time of one of several exposures, and of all of them.
const PER_PART: &str = "per each single individual one";
const OF_ALL: &str = "total sum summed all combined cumulative accumulated";

/// Exposure time of a header.
pub struct Length {
    pub seconds: f64,
    pub keyword: String,
    /// Number of exposures that the detector adds.
    pub coadds: Option<f64>,
    /// Error of an exposure of several parts, unless another keyword confirms that the time is that of all parts.
    pub of_parts: Option<Error>,
    /// Sentences about other lengths, and about numbers of exposures that may be those of another file.
    pub remarks: Vec<String>,
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
    for keyword in LAST_LENGTHS {
        if lengths.is_empty() {
            let has_unit = |length: &Stated| *keyword != "EXP" || matches!(length.comment.unit_s(), Ok(Some(_)));
            lengths.extend(stated(keywords, keyword)?.filter(has_unit));
        }
    }
    let is_per_part = lengths.iter().any(|length| is_of_part(&length.comment));
    let mut parts = parts(keywords, COADDS, is_per_part);
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
    let is_request = |length: &Stated| length.comment.has(REQUESTED) || is_with_overhead(&length.comment);
    let has_other = !lengths.iter().all(is_request);
    let (requests, lengths): (Vec<Stated>, Vec<Stated>) =
        lengths.into_iter().partition(|length| has_other && is_request(length));
    let mut lengths = lengths.into_iter();
    let first = lengths.next().ok_or_else(|| {
        let allowed = "EXPTIME, XPOSURE, EXPOSURE, ITIME, ..., or for example --exposure 30s";
        Error::invalid("length of the exposure", "missing", allowed)
    })?;
    let Stated { mut seconds, mut keyword, comment } = first;
    if !(seconds > 0.0 && seconds <= LONGEST_EXPOSURE_S) {
        let allowed = format!("above 0 s, at most {LONGEST_EXPOSURE_S} s (a bias frame has no exposure)");
        return Err(Error::invalid(keyword, format!("{seconds} s"), allowed));
    }
    if let Some(other) = lengths.find(|other| !agree(seconds, other.seconds)) {
        let given = format!("{seconds} s and {} is {} s", other.keyword, other.seconds);
        return Err(Error::invalid(keyword, given, "one length; specify it, for example --exposure 30s"));
    }
    let mut remarks = Vec::new();
    for other in requests.iter().filter(|other| !agree(seconds, other.seconds)) {
        remarks.push(format!(
            "{keyword} is {seconds} s, and {} is {} s, by its comment {:?} another time: {keyword} is used; for another one specify \
             --exposure",
            other.keyword,
            other.seconds,
            other.comment.text()
        ));
    }
    let is_of_coadds = |name: &str| COADDS.iter().any(|coadds| is_spelling(coadds, name));
    // EXPTIME of ESO is the time of one integration or of all, depending on the instrument.
    let of_eso = ESO_INTEGRATIONS.iter().find_map(|(number, times)| {
        let time = keywords.number(times, |time| time > 0.0)?;
        Some((time, keywords.number(&[number], |count| count > 1.0)?))
    });
    let is_of_eso = |part_s: f64, count: f64| agree(seconds, part_s) || agree(seconds, count * part_s);
    let of_eso = of_eso.filter(|((_, part_s, _), (_, count, _))| is_of_eso(*part_s, *count));
    if let Some(((name, part_s, _), (number, count, _))) = &of_eso {
        remarks.push(format!(
            "{keyword} is {seconds} s, and {number} is {count}: {name} x {number} = {} s is used as the time of this frame \
             from start to end, without the time between integrations; for another span specify --exposure",
            count * part_s
        ));
        (seconds, keyword) = (count * part_s, format!("{name} x {number}"));
        parts = super::stacks::parts(keywords, &[], is_per_part);
    }
    let mut of_sum = None;
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
        } else if other.seconds > seconds + stated_s(seconds)
            || (is_span && other.seconds < seconds - stated_s(seconds))
        {
            let other = format!("{} is {} s ({what})", other.keyword, other.seconds);
            remarks.push(format!(
                "{keyword} is {seconds} s, but {other}: {keyword} is used; for another span specify --exposure"
            ));
        }
    }
    if let Some(times) = RelativeTimes::read(keywords) {
        let near = |slack_s: f64| times.spans_s().into_iter().any(|span_s| (span_s - seconds).abs() <= slack_s);
        let span_s = times.spans_s()[0];
        let unit = if times.has_unit() { "" } else { ", if they are in seconds" };
        let given = format!("{seconds} s, but it is {span_s} s from TSTART to TSTOP{unit}");
        if times.has_unit() && !near(SPAN_SLACK_S + SPAN_SLACK * seconds) {
            let allowed =
                "an exposure without gaps; specify --exposure of the whole span, or --start and --exposure of one part";
            return Err(Error::invalid(keyword, given, allowed));
        }
        if !near(stated_s(seconds)) {
            remarks.push(format!("{keyword} is {given}: {keyword} is used; for another span specify --exposure"));
        }
    }
    if comment.has("including incl includes included plus") && comment.has(OVERHEADS) && !comment.has("not no without")
    {
        let text = comment.text();
        remarks.push(format!(
            "{keyword} is {seconds} s, by its comment {text:?} with overheads: it is used as the exposure time; for a shorter one \
             specify --exposure"
        ));
    }
    if comment.is_approximate() {
        let text = comment.text();
        remarks.push(format!(
            "{keyword} is {seconds} s, by its comment {text:?} approximately; for another one specify --exposure"
        ));
    }
    for other in doubtful_times(keywords, seconds) {
        let Stated { seconds: other_s, keyword: other, .. } = other;
        remarks.push(format!(
            "{keyword} is {seconds} s, but {other} is {other_s} s: {keyword} is used; for another span specify --exposure"
        ));
    }
    remarks.extend(aborted(keywords).map(|(name, value)| {
        format!("{keyword} is {seconds} s, and {name} is {value}: if the exposure was shorter, specify --exposure")
    }));
    let of_part = keywords.number(PART_TIMES, |time| agree(time, seconds));
    let is_whole = is_whole
        || parts.as_ref().is_some_and(|Parts { count, .. }| {
            keywords.number(&["EXP1TIME"], |time| agree(count * time, seconds) && time < seconds).is_some()
        });
    let is_of_all = is_whole || (comment.has(OF_ALL) && !is_of_part(&comment) && of_part.is_none());
    let is_resampled = comment.has("equivalent");
    let part_time = || {
        let shorter = keywords.number(PART_TIMES, |time| time > 0.0 && time < seconds && !agree(time, seconds));
        shorter.filter(|_| of_eso.is_none()).map(|(name, time, _)| (name, time.to_string()))
    };
    let in_comment = || {
        let is_of_several = is_of_part(&comment) || comment.has(ADDED);
        let is_doubtful = product_in(comment.text(), seconds, false) || (is_of_several && !is_alone(keywords));
        is_doubtful.then(|| ("its comment".to_owned(), format!("{:?}", comment.text())))
    };
    if parts.is_none()
        && let Some((name, value)) = doubtful(keywords, seconds).or_else(part_time).or_else(in_comment)
    {
        remarks.push(format!(
            "{keyword} is {seconds} s, and {name} is {value}: {keyword} is used as the time of this frame from start to end; \
             if it is a stack, specify --exposure"
        ));
    }
    let parts = parts.or_else(|| is_resampled.then(|| Parts::new(keyword.clone(), 1.0)));
    let coadds = parts.as_ref().filter(|parts| is_of_coadds(&parts.keyword)).map(|parts| parts.count);
    let of_parts = parts.and_then(|Parts { keyword: name, shown, count }| {
        // The comment of Andor is "Total Exposure Time" also where EXPOSURE is the time of one accumulation.
        let is_coadd = is_of_coadds(&name) && (is_whole || name != ACCUMULATIONS);
        if is_of_all && is_coadd {
            return None;
        }
        let given = if is_resampled {
            format!("{seconds} s, the equivalent time of a stack by its comment {:?}", comment.text())
        } else if is_of_part(&comment) || of_part.is_some() {
            format!("{seconds} s of each of {count} exposures ({name})")
        } else {
            format!("{seconds} s, and {name} is {shown}: the time of one exposure or of all")
        };
        let least_s = if is_of_all && name != ACCUMULATIONS { seconds } else { count * seconds };
        let example = if least_s <= LONGEST_EXPOSURE_S {
            format!("--exposure {least_s}s if there are no gaps")
        } else {
            format!("--exposure {seconds}s if {keyword} is the sum and there are no gaps")
        };
        let allowed = format!("the time from the first to the last exposure; specify it, for example {example}");
        Some(Error::invalid(keyword.clone(), given, allowed))
    });
    Ok(Length { seconds, keyword, coadds, of_parts: of_parts.or(of_sum), remarks })
}

/// Returns the time of one keyword; `None` if the header does not have it.
fn stated(keywords: Keywords<'_>, keyword: &str) -> Result<Option<Stated>, Error> {
    let Some((header, keyword)) = keywords.find(keyword) else { return Ok(None) };
    let comment = Comment::new(&keywords.remark(header, &keyword));
    // "Exposure request number" (JWST)
    if comment.has_pair("exposure request", "number") {
        return Ok(None);
    }
    let Some(number) = header.number(&keyword) else {
        let value = header.text(&keyword).unwrap_or_default();
        let of_comment = comment.unit_s().ok().flatten();
        return match duration_s(&value) {
            Some((seconds, unit_s)) if of_comment.is_none() || of_comment == unit_s => {
                Ok(Some(Stated { seconds, keyword, comment }))
            }
            _ => Err(unreadable(
                keyword,
                &value,
                "a number of seconds, or with its unit as in '1.5 min'; or for example --exposure 30s",
            )),
        };
    };
    let in_unit = |unit: String| {
        let given = format!("{number} in {unit} (comment {:?})", comment.text());
        let allowed = "one of [s], [ms], [us], [ns], [min], [h], [d]; or for example --exposure 30s";
        Error::invalid(keyword.clone(), given, allowed)
    };
    let unit_s = match comment.unit_of_s(number).map_err(in_unit)? {
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

/// Returns the duration in a text such as `60 s`, `1 min` or `00:01:00`, seconds, and its unit if it has one.
fn duration_s(text: &str) -> Option<(f64, Option<f64>)> {
    if text.matches(':').count() == 2 && !text.contains(|c: char| c.is_ascii_alphabetic()) {
        let ([hours, minutes], seconds) = parse_time(text)?;
        return Some((f64::from(3600 * hours + 60 * minutes) + seconds, None));
    }
    let at = text.find(|c: char| c.is_ascii_alphabetic() && !matches!(c, 'e' | 'E'))?;
    let (number, unit_s) = (text[..at].trim().parse::<f64>().ok()?, seconds_in(text[at..].trim())?);
    Some((number * unit_s, Some(unit_s)))
}

/// Returns the largest difference from the middle, the end or the length of an exposure that is not stated, seconds: a
/// tenth of a short exposure.
pub fn stated_s(duration_s: f64) -> f64 {
    (SPAN_SLACK * duration_s).clamp(AGREED_S, STATED_S)
}

/// Returns true if the comment of a time is that of a sum with an overhead, such as "EXPTIME + reset time".
fn is_with_overhead(comment: &Comment) -> bool {
    comment.text().contains('+') && (comment.has(OVERHEADS) || comment.has("reset"))
}

/// Returns true if the comment of an exposure time states that it is that of one of several exposures; "per pixel" does
/// not.
fn is_of_part(comment: &Comment) -> bool {
    // "s/frame"
    let is_per_frame = comment.text().to_ascii_lowercase().split('/').skip(1).any(begins_with_exposure);
    is_per_frame || (comment.has(PER_PART) && !comment.has_pair("per", "pixel pix"))
}

/// Returns other times that may be those of the same frame: longer ones by their name or by a comment such as "total
/// exposure time", and shorter ones that are true or measured.
fn doubtful_times(keywords: Keywords<'_>, seconds: f64) -> Vec<Stated> {
    let is_known = |name: &str| [LENGTHS, SPANS, SUMS].concat().iter().any(|known| is_spelling(known, name));
    let is_total = |comment: &Comment| {
        let is_of_exposure = comment.has("exposure exptime integration observation");
        let is_elapsed = comment.has("elapsed wallclock walltime timespan")
            || comment.has_pair("wall", "clock time")
            || comment.has_pair("time", "span");
        ((comment.has(OF_ALL) || comment.has(STACKS)) && is_of_exposure || is_elapsed)
            && !comment.has("number count")
            && !comment.has(OF_CALIBRATION)
            && !comment.has(OF_SERIES)
    };
    let is_total_name = |name: &str| {
        TOTALS.iter().any(|total| name.starts_with(total) || name.ends_with(total))
            && (name.contains("EXP") || name.contains("TIM"))
    };
    let is_true = |name: &str, comment: &Comment| {
        TRUE_TIMES.iter().any(|known| is_spelling(known, name))
            || (comment.has(TRUE)
                && (comment.has("exptime") || comment.has_pair("exposure integration", "time duration length"))
                && !comment.has(OF_CALIBRATION))
    };
    let is_doubtful = |card: &&Card| {
        let name = card.keyword();
        if DOUBTFUL_TIMES.iter().any(|known| is_spelling(known, &name)) {
            return true;
        }
        if !matches!(card.value(), Some(CardValue::Integer(_) | CardValue::Real(_))) || is_known(&name) {
            return false;
        }
        let (bare, comment) = (bare(&name), Comment::new(&card.comment()));
        let is_longer = || is_total(&comment) || is_total_name(&name) || ELAPSED.iter().any(|part| bare.contains(part));
        is_true(&name, &comment) || (!is_of_calibration(&name) && is_longer())
    };
    let times =
        keywords.cards().filter(is_doubtful).filter_map(|card| stated(keywords, &card.keyword()).ok().flatten());
    let differs = |time: &Stated| {
        let is_shorter = time.seconds > 0.0 && time.seconds < seconds && !agree(seconds, time.seconds);
        // A dark time contains overheads.
        let is_longer = (seconds + stated_s(seconds)..=LONGEST_EXPOSURE_S).contains(&time.seconds);
        (is_longer && !is_of_calibration(&time.keyword)) || (is_shorter && is_true(&time.keyword, &time.comment))
    };
    let mut others: Vec<Stated> = times.filter(differs).collect();
    others.dedup_by(|next, time| next.keyword == time.keyword);
    others
}

/// Returns the card that states that the exposure was ended early.
fn aborted(keywords: Keywords<'_>) -> Option<(String, String)> {
    keywords.cards().find_map(|card| {
        let name = card.keyword();
        let value = match card.value()? {
            CardValue::Logical(true) if name.starts_with("ABORT") => "T".to_owned(),
            CardValue::Text(text) if Comment::new(&text).has(ABORTED) && !text.contains(' ') => format!("{text:?}"),
            _ => return None,
        };
        Some((name, value))
    })
}
