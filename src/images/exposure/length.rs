//! Exposure time in a header: its keywords, units, and the number of co-added exposures.

use crate::constants::LONGEST_EXPOSURE_S;
use crate::error::Error;

use super::super::card::{Card, CardValue};
use super::super::header::Header;
use super::comment::{Comment, FRAMES, begins_with_exposure, seconds_in};
use super::instants::unreadable;
use super::moment::{Keywords, bare, is_spelling};

/// Keywords of the exposure time, in order of precedence.
const LENGTHS: &[&str] =
    &["EXPTIME", "XPOSURE", "EXPOSURE", "EXP-TIME", "ITIME", "TEXPTIME", "INT-TIME", "ELAPTIME", "SHUTTIME", EXPOINUS];
/// Exposure time in microseconds (ZWO).
const EXPOINUS: &str = "EXPOINUS";
/// Keywords that are used only without the others: ITIME is the requested time, and TRUITIME the true one (IRTF); EXPOSED
/// (AAT); and EXP if its comment states a unit, because it may also be a number.
const LAST_LENGTHS: &[&str] = &["TRUITIME", "EXPOSED", "EXP"];
/// Keywords of the time of one of several added exposures.
const PART_TIMES: &[&str] = &["ESO DET DIT", "EXP1TIME", "SUBEXP"];

/// Keywords of the time from the start to the end of the exposure, and of the sum over several exposures.
const SPANS: &[&str] = &["TELAPSE", "TELAPSED"];
const SUMS: &[&str] = &["LIVETIME", "TOTALEXP", "TOTEXP", "TOTEXPT", "EXPTOT", "EXPTOTAL"];
/// Keywords of times that may be those of the exposure with gaps, of all parts of a stack, or of a sequence, and parts of
/// such keywords.
const DOUBTFUL_TIMES: &[&str] = &["TEXP", "EXP-SUM"];
const ELAPSED: &[&str] = &[
    "ELAPS", "DURAT", "EXPDUR", "OBSDUR", "REALTIM", "WALLTIM", "WALLCL", "CLOCKTIM", "TIMESPAN", "EXPSPAN", "OBSSPAN",
    "ONTIME", "ACQTIM",
];
const TOTALS: &[&str] = &["TOT", "CUM", "SUM", "STACK"];
/// Keywords of the true or measured exposure time, which may be shorter than the requested one, and words of comments.
const TRUE_TIMES: &[&str] = &[
    "ACTEXP", "ACTTIME", "ACTUALEX", "REALEXP", "REALTIME", "TRUEEXP", "EXPOSED", "EXPMEAS", "MEASEXP", "REXPTIME",
    "DARKTIME", "ELAPSED",
];
const TRUE: &str = "actual real measured true";
/// Words of exposures that were ended early.
const ABORTED: &str = "abort aborted interrupted cancelled canceled";

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
    "ESO DET1 NDIT",
    "ESO DET2 NDIT",
    "ESO DET WIN1 NDIT",
    "NSUBEXP",
    "COEXP",
    "COAVERAG",
    ACCUMULATIONS,
];
/// Number of accumulations (Andor).
const ACCUMULATIONS: &str = "NUMACC";
/// Keywords of the number of frames that were added afterwards.
const STACKED: &[&str] = &[
    "STACKCNT", "NCOMBINE", "NCOMB", "NUM-COMB", "SNAPSHOT", "N-STACK", "NUMSTACK", "STACKNUM", "STACKED", "NINPUTS",
    "NDRIZIM",
];
/// Parts of names of numbers of exposures that are added, or that follow each other in separate files, as in NIMG,
/// NUM_EXP, FRAMES, NACC and STACK COUNT: a prefix and a kind of frames or sums, a kind in the plural, or a sum and a
/// suffix.
const COUNT_PREFIXES: &[&str] = &["NUMBEROF", "NUMBER", "NUM", "NB", "NO", "NR", "N"];
const FRAME_KINDS: &[&str] =
    &["IMG", "IMAG", "IMAGE", "FRAME", "FRM", "EXP", "EXPOSUR", "EXPOSURE", "INT", "INTEG", "SHOT", "REPEAT", "CYCLE"];
const SUMS_OF_FRAMES: &[&str] =
    &["STACK", "COADD", "COMB", "ICOMB", "AVER", "AVG", "ACC", "ACCUM", "ADD", "SUM", "SUB", "SUBEXP", "LIGHT"];
const COUNT_SUFFIXES: &[&str] = &["COUNT", "CNT"];
/// Other keywords of such numbers.
const OTHER_COUNTS: &[&str] = &["CRSPLIT", "SUMFRAME", "FRMSUM", "FRAMEAVG", "LIVESTCK"];
/// Beginnings of numbered keywords with the names of added files.
const INPUTS: &[&str] = &["COMB", "CMB", "INP", "PROV", "STACK", "COADD", "FILE", "RAW"];
/// Keywords of the number of integrations in headers of ESO, and of the time of one of them.
const ESO_INTEGRATIONS: &[(&str, &[&str])] = &[
    ("ESO DET NDIT", &["ESO DET DIT", "ESO DET SEQ1 DIT"]),
    ("ESO DET1 NDIT", &["ESO DET1 DIT", "ESO DET1 SEQ1 DIT"]),
    ("ESO DET2 NDIT", &["ESO DET2 DIT", "ESO DET2 SEQ1 DIT"]),
    ("ESO DET WIN1 NDIT", &["ESO DET WIN1 DIT1", "ESO DET WIN1 UIT1"]),
];
/// Keywords of the kind of a frame, and words of stacks, in their values and elsewhere.
const KINDS: &[&str] =
    &["IMAGETYP", "IMAGETYPE", "FRAMETYP", "FRAMETYPE", "IMGTYPE", "OBSTYPE", "PRODTYPE", "PROCTYPE", "INTEGRAT"];
const KINDS_OF_STACKS: &[&str] = &["stack", "coadd", "integration", "integrated", "masterlight", "lightmaster"];
const STACKS: &str = "stack stacked stacks stacking coadd coadded coaddition";
const MASTER_LIGHT: &str = "light lights science object";
/// Keyword with a letter for each step of the processing: S for stacked (ASTAP).
const STEPS: &str = "CALSTAT";
/// Programs that write little else than stacks, in lower case.
const STACKING_PROGRAMS: &[&str] = &["deepskystacker", "astro pixel processor", "sequator", "autostakkert", "registax"];

/// Comments of other counts of added frames state a number of [`FRAMES`], have a word of [`ADDED`], and none of
/// [`OF_CALIBRATION`]. Frames, if they are several:
const SEVERAL: &str = "images frames exposures subexposures subframes subs inputs files lights accumulations";
const ADDED: &str = "stack stacked stacking combine combined combining coadd coadds coadded co added adding summed sum \
     averaged average mean median integrated accumulated drizzled binned input inputs";
/// Words of sums in remarks, which are more often about other frames.
const COMBINED: &str = "combine combined combining averaged summed";
/// Keywords of remarks.
pub(super) const REMARKS: &[&str] = &["HISTORY", "COMMENT"];
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
        parts = self::parts(keywords, &[], is_per_part);
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
        } else if other.seconds > seconds + STATED_S || (is_span && other.seconds < seconds - STATED_S) {
            let other = format!("{} is {} s ({what})", other.keyword, other.seconds);
            remarks.push(format!(
                "{keyword} is {seconds} s, but {other}: {keyword} is used; for another span specify --exposure"
            ));
        }
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
    let of_parts = parts.and_then(|Parts { keyword: name, shown, count }| {
        // The comment of Andor is "Total Exposure Time" also where EXPOSURE is the time of one accumulation.
        let is_coadd = COADDS.iter().any(|coadds| is_spelling(coadds, &name)) && (is_whole || name != ACCUMULATIONS);
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

/// Returns true if the comment of an exposure time states that it is that of one of several exposures; "per pixel" does
/// not.
fn is_of_part(comment: &Comment) -> bool {
    // "s/frame"
    let is_per_frame = comment.text().to_ascii_lowercase().split('/').skip(1).any(begins_with_exposure);
    is_per_frame || (comment.has(PER_PART) && !comment.has_pair("per", "pixel pix"))
}

/// Returns true if two exposure times are taken as the same.
fn agree(a: f64, b: f64) -> bool {
    (a - b).abs() <= LENGTH_SLACK_S + LENGTH_SLACK * a.abs()
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
        let is_longer = (seconds + STATED_S..=LONGEST_EXPOSURE_S).contains(&time.seconds);
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

/// Returns the number of exposures that are added in the frame, if they are several. `is_per_part` is true if the comment
/// of the exposure time states that it is the time of one of them.
fn parts(keywords: Keywords<'_>, coadds: &[&str], is_per_part: bool) -> Option<Parts> {
    let sure = coadds.iter().chain(STACKED).find_map(|keyword| keywords.number(&[keyword], |count| count > 1.0));
    if let Some((keyword, count, _)) = sure {
        return Some(Parts::new(keyword, count));
    }
    if let Some((keyword, count)) = keywords.cards().filter(|_| is_per_part).find_map(number_of_frames) {
        return Some(Parts::new(keyword, count));
    }
    let kind = KINDS.iter().find_map(|name| {
        keywords.text(&[name]).map(|(keyword, kind)| (keyword, Comment::new(&kind))).filter(|(_, kind)| {
            let joined = bare(&kind.text().to_ascii_lowercase());
            let is_stack = KINDS_OF_STACKS.iter().any(|word| joined.contains(word));
            (is_stack && !kind.has(OF_CALIBRATION) && !is_of_calibration(&joined) && !kind.has("candidate"))
                || (kind.has("master") && kind.has(MASTER_LIGHT))
        })
    });
    let steps = || {
        let (keyword, steps) = keywords.text(&[STEPS])?;
        let is_letters = steps.chars().all(|letter| "BDFS".contains(letter));
        (is_letters && steps.contains('S')).then(|| (keyword, Comment::new(&steps)))
    };
    let of_kind = kind.or_else(steps).map(|(keyword, kind)| {
        let shown = format!("{:?}", kind.text());
        Parts { keyword, shown, count: 1.0 }
    });
    keywords.0.iter().find_map(|header| counted(header, is_per_part)).or(of_kind)
}

/// Returns true if a name is that of a number of frames or exposures.
fn is_count(name: &str) -> bool {
    let bare = bare(name);
    let singular = bare.trim_end_matches('S');
    let is_kind = |root: &str| FRAME_KINDS.contains(&root) || SUMS_OF_FRAMES.contains(&root);
    OTHER_COUNTS.contains(&bare.as_str())
        || (bare.ends_with('S') && is_kind(singular))
        || COUNT_PREFIXES.iter().any(|prefix| singular.strip_prefix(prefix).is_some_and(is_kind))
        || COUNT_SUFFIXES
            .iter()
            .any(|suffix| bare.strip_suffix(suffix).is_some_and(|sum| SUMS_OF_FRAMES.contains(&sum)))
}

/// Returns the keyword and the value of a number of exposures above 1, which may be that of separate files.
fn number_of_frames(card: &Card) -> Option<(String, f64)> {
    let number = match card.value()? {
        CardValue::Real(number) if number.fract() == 0.0 => number,
        value => whole_number(Some(value))?,
    };
    let (keyword, comment) = (card.keyword(), Comment::new(&card.comment()));
    let is_number = is_count(&keyword)
        || comment.has_pair(STACKS, "count number size")
        || Comment::new(&keyword).has_pair(SEVERAL, ADDED)
        || (keyword.contains(' ') && Comment::new(&keyword).has("stacked coadded combined"));
    let is_of_frame = !comment.has(OF_SERIES) && !comment.has(OF_CALIBRATION);
    (number > 1.0 && is_number && is_of_frame).then_some((keyword, number))
}

/// Returns true if a number of exposures is 1.
fn is_alone(keywords: Keywords<'_>) -> bool {
    let is_one = |card: &Card| is_count(&card.keyword()) && whole_number(card.value()) == Some(1.0);
    keywords.number(STACKED, |count| count == 1.0).is_some()
        || keywords.number(COADDS, |count| count == 1.0).is_some()
        || keywords.cards().any(is_one)
}

/// Returns the name and the value of what may state that the frame is a sum of several: a number of exposures, which may
/// be that of separate files, the names of added files, or a text.
fn doubtful(keywords: Keywords<'_>, seconds: f64) -> Option<(String, String)> {
    if keywords.number(STACKED, |count| count == 1.0).is_some() {
        return None;
    }
    let count = || keywords.cards().find_map(number_of_frames).map(|(keyword, count)| (keyword, count.to_string()));
    let in_text = |card: &Card| {
        let keyword = card.keyword();
        let is_named = ["STACK", "COMB", "COADD"].iter().any(|name| keyword.starts_with(name));
        let text = match card.value() {
            Some(CardValue::Logical(true)) if is_named => return Some((keyword, "T".to_owned())),
            Some(CardValue::Text(text)) if is_named && Comment::new(&text).has(ADDED) => {
                return Some((keyword, format!("{text:?}")));
            }
            Some(CardValue::Text(text)) => text,
            None if REMARKS.contains(&keyword.as_str()) => card.remark_text(),
            _ => return None,
        };
        let lower = text.to_ascii_lowercase();
        let is_of_stacks = STACKING_PROGRAMS.iter().any(|program| lower.contains(program));
        (is_of_stacks || is_of_sum(&text, seconds)).then(|| (keyword, format!("{:?}", text.trim())))
    };
    let is_input = |card: &&Card| {
        let keyword = card.keyword();
        let stem = keyword.trim_end_matches(|c: char| c.is_ascii_digit());
        let is_file = || matches!(card.value(), Some(CardValue::Text(text)) if is_file(&text));
        stem.len() < keyword.len() && INPUTS.iter().chain(FRAME_KINDS).any(|name| stem.starts_with(name)) && is_file()
    };
    let inputs = || {
        let (mut files, number) = (keywords.cards().filter(is_input), keywords.cards().filter(is_input).count());
        files.next().filter(|_| number > 1).map(|card| (card.keyword(), format!("the first of {number} files")))
    };
    count().or_else(|| keywords.cards().find_map(in_text)).or_else(inputs)
}

/// Returns true if a text is the name of a FITS file, perhaps with an extension in brackets.
fn is_file(text: &str) -> bool {
    let name = text.trim().split('[').next().unwrap_or_default().to_ascii_lowercase();
    [".fits", ".fit", ".fts", ".fz"].iter().any(|end| name.ends_with(end))
}

/// Returns true if a text states a sum of frames: their number, as in "ncombine = 12", "Average of 12 frames" or
/// "12x30s", or their names after a word such as "imcombine".
fn is_of_sum(text: &str, seconds: f64) -> bool {
    if is_of_calibration(text) {
        return false;
    }
    let number = text.split_once('=').and_then(|(before, after)| {
        let name = before.split_whitespace().last()?.to_ascii_uppercase();
        let is_known = COADDS.iter().chain(STACKED).any(|known| is_spelling(known, &name)) || is_count(&name);
        after.split_whitespace().next()?.parse::<f64>().ok().filter(|count| is_known && *count > 1.0)
    });
    let lower = text.to_ascii_lowercase();
    let has_files = lower.split([' ', ',', ';']).filter(|word| is_file(word)).count() > 1
        && ["combin", "stack", "coadd", "averag", "sum"].iter().any(|word| lower.contains(word));
    let is_of_pixinsight = lower.contains("imageintegration.");
    number.is_some()
        || is_of_pixinsight
        || has_files
        || counted_in(text, ADDED).is_some()
        || product_in(text, seconds, true)
}

/// Returns true if a text contains a number of exposures times the time of one, such as "12x30s", which is the exposure
/// time, or the product is. Without `has_unit` no unit is necessary.
fn product_in(text: &str, seconds: f64, has_unit: bool) -> bool {
    let lower = text.to_ascii_lowercase();
    lower.match_indices(['x', '*']).any(|(at, _)| {
        // "12 subs x 30 s"
        let before = lower[..at].trim_end_matches(|c: char| c == ' ' || c.is_ascii_alphabetic());
        let count = before.rsplit(|c: char| !c.is_ascii_digit()).next().unwrap_or_default();
        let rest = lower[at + 1..].trim_start();
        let end = rest.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(rest.len());
        let unit = rest[end..].trim_start().split(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or_default();
        let unit_s = seconds_in(unit).or((!has_unit).then_some(1.0));
        let (Ok(count), Ok(part), Some(unit_s)) = (count.parse::<f64>(), rest[..end].parse::<f64>(), unit_s) else {
            return false;
        };
        let part_s = part * unit_s;
        count > 1.0 && part_s > 0.0 && (agree(seconds, part_s) || agree(seconds, count * part_s))
    })
}

/// Returns true if a text names calibration frames, such as "masterdark" and "superbias".
fn is_of_calibration(text: &str) -> bool {
    let lower = text.to_ascii_lowercase();
    ["bias", "dark", "flat", "zero", "fringe", "cosmic"].iter().any(|word| lower.contains(word))
}

/// Returns the number of added frames that the comment of a card, the list of the frames (IRAF) or a remark states, for
/// example in the history of PixInsight.
fn counted(header: &Header, is_per_part: bool) -> Option<Parts> {
    let mut listed = 0;
    for card in header.cards() {
        let keyword = card.keyword();
        if REMARKS.contains(&keyword.as_str()) {
            if let Some(count) = counted_in(&card.remark_text(), COMBINED).filter(|count| *count > 1.0) {
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

/// Returns the number of added frames in a text such as "Stacked 12 images using median" with one of several words.
fn counted_in(text: &str, added: &str) -> Option<f64> {
    if let Some((_, count)) = text.split_once("numberOfImages:") {
        return count.trim().parse().ok();
    }
    let remark = Comment::new(text);
    let words = text.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    // "25 light frames stacked"
    let words: Vec<&str> =
        words.filter(|word| !["light", "raw", "science"].iter().any(|kind| kind.eq_ignore_ascii_case(word))).collect();
    let is_several = |word: &str| SEVERAL.split_ascii_whitespace().any(|other| other.eq_ignore_ascii_case(word));
    let pair = words.windows(2).find(|pair| is_several(pair[1]) && pair[0].parse::<u32>().is_ok());
    let is_sum = (remark.has(STACKS) || remark.has(added)) && !remark.has(OF_CALIBRATION) && !is_of_calibration(text);
    pair.filter(|_| is_sum)?[0].parse().ok()
}
