//! Numbers of exposures that are added in a frame, and other statements of stacks in a header.

use super::super::card::{Card, CardValue};
use super::super::header::Header;
use super::comment::{AGREED_S, Comment, FRAMES, seconds_in};
use super::moment::{Keywords, bare, is_spelling};

/// Keywords of the number of exposures that the detector adds before it stores a frame.
pub const COADDS: &[&str] = &[
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
pub const ACCUMULATIONS: &str = "NUMACC";
/// Keywords of the number of frames that were added afterwards.
const STACKED: &[&str] = &[
    "STACKCNT", "NCOMBINE", "NCOMB", "NUM-COMB", "SNAPSHOT", "N-STACK", "NUMSTACK", "STACKNUM", "STACKED", "NINPUTS",
    "NDRIZIM",
];
/// Parts of names of numbers of exposures that are added, or that follow each other in separate files, as in NIMG,
/// NUM_EXP, FRAMES, NACC and STACK COUNT: a prefix and a kind of frames or sums, a kind in the plural, or a sum and a
/// suffix.
const COUNT_PREFIXES: &[&str] = &["NUMBEROF", "NUMBER", "NUM", "NB", "NO", "NR", "N"];
const FRAME_KINDS: &[&str] = &[
    "IMG", "IMAG", "IMAGE", "FRAME", "FRM", "EXP", "EXPOSUR", "EXPOSURE", "INT", "INTEG", "DIT", "SHOT", "REPEAT",
    "CYCLE",
];
const SUMS_OF_FRAMES: &[&str] = &[
    "STACK", "STACKED", "COADD", "COMB", "ICOMB", "IMCOMB", "COADDED", "COMBINED", "SUMMED", "AVERAGE", "MEDIAN",
    "INPUT", "AVER", "AVG", "ACC", "ACCUM", "ADD", "SUM", "SUB", "SUBEXP", "LIGHT",
];
const COUNT_SUFFIXES: &[&str] = &["COUNT", "CNT", "NUM", "N"];
/// Other keywords of such numbers.
const OTHER_COUNTS: &[&str] = &[
    "CRSPLIT", "SUMFRAME", "FRMSUM", "FRAMEAVG", "LIVESTCK", "LIVECNT", "COADDED", "TOTFRAME", "TOTALFRM", "IMGCOUNT",
];
/// Beginnings of numbered keywords with the names of added files.
const INPUTS: &[&str] = &["COMB", "CMB", "INP", "PROV", "STACK", "COADD", "FILE", "RAW"];
/// Keywords of the kind of a frame, and words of stacks, in their values and elsewhere.
const KINDS: &[&str] =
    &["IMAGETYP", "IMAGETYPE", "FRAMETYP", "FRAMETYPE", "IMGTYPE", "OBSTYPE", "PRODTYPE", "PROCTYPE", "INTEGRAT"];
const KINDS_OF_STACKS: &[&str] = &["stack", "coadd", "integration", "integrated", "masterlight", "lightmaster"];
pub const STACKS: &str = "stack stacked stacks stacking coadd coadded coaddition";
const MASTER_LIGHT: &str = "light lights science object";
/// Keyword with a letter for each step of the processing: S for stacked (ASTAP).
const STEPS: &str = "CALSTAT";
/// Programs that write little else than stacks, in lower case.
const STACKING_PROGRAMS: &[&str] = &["deepskystacker", "astro pixel processor", "sequator", "autostakkert", "registax"];
/// Program that resamples and adds frames (<https://www.astromatic.net/software/swarp/>). Not pswarp of Pan-STARRS.
const COADDING_PROGRAM: &str = "swarp";

/// Comments of other counts of added frames state a number of [`FRAMES`], have a word of [`ADDED`], and none of
/// [`OF_CALIBRATION`]. Frames, if they are several:
const SEVERAL: &str = "images frames exposures subexposures subframes subs inputs files lights accumulations";
pub const ADDED: &str = "stack stacked stacking combine combined combining coadd coadds coadded co added adding summed sum \
     averaged average mean median integrated accumulated drizzle drizzled binned input inputs";
/// Words of sums in remarks, which are more often about other frames.
const COMBINED: &str = "combine combined combining averaged summed";
/// Keywords of remarks.
pub const REMARKS: &[&str] = &["HISTORY", "COMMENT"];
/// Words of other frames than exposures of the sky, and of parts of frames.
pub const OF_CALIBRATION: &str = "bias biases dark darks flat flats zero zeros fringe sky calibration master reference ref \
     template background pixel pixels star stars rejected";
/// Words of times and names instead of counts.
const NO_COUNTS: &str =
    "width height size time second seconds sec s minutes hours id index method mode rate fps guiding guider";
/// Words of series of separate files.
pub const OF_SERIES: &str = "sequence series set run group groups";

/// Largest difference between exposure times that are taken as consistent, in addition to 0.1 s: a fraction of the
/// exposure time.
const LENGTH_SLACK: f64 = 0.01;

/// Number of exposures that are added in a frame.
pub struct Parts {
    pub keyword: String,
    /// Number, or text that states a stack.
    pub shown: String,
    /// Smallest number of exposures.
    pub count: f64,
}

impl Parts {
    pub fn new(keyword: impl Into<String>, count: f64) -> Self {
        Self { keyword: keyword.into(), shown: count.to_string(), count }
    }
}

/// Returns true if two exposure times are taken as the same.
pub fn agree(a: f64, b: f64) -> bool {
    (a - b).abs() <= AGREED_S + LENGTH_SLACK * a.abs()
}

/// Returns the number of exposures that are added in the frame, if they are several. `is_per_part` is true if the
/// comment of the exposure time states that it is the time of one of them.
pub fn parts(keywords: Keywords<'_>, coadds: &[&str], is_per_part: bool) -> Option<Parts> {
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
pub fn is_alone(keywords: Keywords<'_>) -> bool {
    let is_one = |card: &Card| is_count(&card.keyword()) && whole_number(card.value()) == Some(1.0);
    keywords.number(STACKED, |count| count == 1.0).is_some()
        || keywords.number(COADDS, |count| count == 1.0).is_some()
        || keywords.cards().any(is_one)
}

/// Returns the name and the value of what may state that the frame is a sum of several: a number of exposures, which
/// may be that of separate files, the names of added files, or a text.
pub fn doubtful(keywords: Keywords<'_>, seconds: f64) -> Option<(String, String)> {
    if keywords.number(STACKED, |count| count == 1.0).is_some() {
        return None;
    }
    let count = || keywords.cards().find_map(number_of_frames).map(|(keyword, count)| (keyword, count.to_string()));
    let in_text = |card: &Card| {
        let keyword = card.keyword();
        let is_named = keyword.contains("STACK") || ["COMB", "COADD"].iter().any(|name| keyword.starts_with(name));
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
        let is_of_stacks = STACKING_PROGRAMS.iter().any(|program| lower.contains(program))
            || Comment::new(&text).has(COADDING_PROGRAM);
        (is_of_stacks || is_of_sum(&text, seconds)).then(|| (keyword, format!("{:?}", text.trim())))
    };
    // "Mean time of the stack"
    let of_times = |card: &Card| {
        let (keyword, comment) = (card.keyword(), card.comment());
        let is_time = ["DATE", "MJD", "JD", "UT", "TIME"].iter().any(|name| keyword.starts_with(name));
        (is_time && Comment::new(&comment).has(STACKS))
            .then(|| (keyword, format!("that of a stack by its comment {comment:?}")))
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
    count()
        .or_else(|| keywords.cards().find_map(in_text))
        .or_else(|| keywords.cards().find_map(of_times))
        .or_else(inputs)
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
pub fn product_in(text: &str, seconds: f64, has_unit: bool) -> bool {
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
pub fn is_of_calibration(text: &str) -> bool {
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
