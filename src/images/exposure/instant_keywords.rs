//! Keywords of instants.

use super::comment::Role;

/// Keywords with the date and time of the start, in order of precedence. A missing hyphen is read everywhere.
pub const DATES: &[&str] = &["DATE-BEG", "DATE-OBS", "DATE-STR"];

/// Keywords with the time of day of the start, used together with a date.
pub const TIMES: &[&str] = &[
    "TIME-BEG",
    "UTC-OBS",
    "TIME-OBS",
    "UT-OBS",
    "UT-START",
    "UT-STR",
    "UTC-START",
    "UTC-STR",
    "UT-BEG",
    "UT-BEGIN",
    "START-UT",
    "TIME-STR",
    "TM-START",
    "TU-START",
    "UTSHUT",
    "TAIHMS",
];

/// Keywords with a time of day that is not the start at some observatories. They are used only if no keyword of
/// [`TIMES`] exists.
pub const LOOSE_TIMES: &[&str] = &["UT", "UTC", "UTIME", "UTC-TIME", "UT-TIME", "TIME-UTC"];

/// Keywords with the modified Julian date of the start.
pub const MODIFIED_DATES: &[&str] = &["MJD-BEG", "MJD-OBS", "MJD-STR", "MJD-START", "OBSMJD"];

/// Keywords with the Julian date of the start.
pub const JULIAN_DATES: &[&str] = &["JD-START", "JD-BEG", "JD-STR", "JD-OBS", "OBSJD"];

/// Keywords of the start that contain a date, a Julian date or a time of day. FRAME is that of Andor's cameras, and
/// DATE-HP DATE-OBS with more digits (MaxIm DL).
pub const OTHER_STARTS: &[&str] = &["DATE-START", "EXP-START", "EXP-STRT", "SHUT-OPEN", "FRAME", "DATE-HP"];

/// Keywords of dates that are used only if no other keyword gives the start.
pub const LOOSE_DATES: &[&str] = &["MJD", "JD"];

/// Keywords of the middle and of the end of the exposure.
pub const MIDDLES: &[&str] = &[
    "DATE-AVG",
    "MJD-AVG",
    "MJD-MID",
    "DATE-MID",
    "JD-MID",
    "JD-AVG",
    "EXP-MID",
    "UT-MID",
    "UTC-MID",
    "TIME-MID",
    "MIDTIME",
    "MIDPOINT",
    "UT-MIDDLE",
];
pub const ENDS: &[&str] = &[
    "DATE-END",
    "MJD-END",
    "JD-END",
    "EXP-END",
    "DATE-STOP",
    "DATE-STP",
    "MJD-STOP",
    "MJD-STP",
    "JD-STOP",
    "EXP-STOP",
];

/// Keywords with the time of day of the end. At some observatories it includes the readout, so that they only show that
/// an exposure time is far too short.
pub const END_TIMES: &[&str] = &["TIME-END", "UT-END", "UTC-END", "UT-STOP", "UTC-STOP", "TIME-STOP", "TM-END"];

/// Returns true for a keyword of the start whose name states that it is that of the start, such as DATE-BEG, UT-START
/// and SHUT-OPEN.
pub fn names_start(keyword: &str) -> bool {
    ["BEG", "STR", "START", "OPEN"].iter().any(|part| keyword.contains(part))
}

/// Words before or after those of [`CLOCKS`] in keywords of the first and the last of several exposures, as in UTC-LAST
/// and MINJD.
pub const OUTERMOST: &[(Role, &str)] =
    &[(Role::Start, "FIRST"), (Role::Start, "FRST"), (Role::Start, "MIN"), (Role::End, "LAST"), (Role::End, "MAX")];
pub const CLOCKS: &[&str] = &["UT", "UTC", "TIME", "DATE", "JD", "MJD", "OBS", "EXP", "DATEOBS", "JDOBS", "MJDOBS"];

/// Keyword of the opening of the shutter (DECam), which is about that of DATE-OBS, but is 33 s earlier in some frames.
pub const SHUTTER: &str = "OPENSHUT";

/// Keywords of the date in universal time, beside a date that may be that of the night.
pub const UNIVERSAL_DATES: &[&str] = &["UT-DATE", "UTC-DATE", "DATE-UT", "DATE-UTC"];

/// Other keywords of the date of the observation, which are used without those of [`DATES`]. The date may be that of
/// the evening, or local.
pub const OTHER_DATES: &[&str] = &["OBS-DATE", "DATETIME"];

/// Keywords with a time of day that may be local, which are used only beside a date without any other time (Lick).
pub const LAST_TIMES: &[&str] = &["TIME"];

/// Keywords of local times.
pub const LOCAL_TIMES: &[&str] = &["DATE-LOC", "TIME-LOC", "LOCALTIM", "LOCTIME", "LT"];

/// Keywords of the receiver of GPS of a camera (QHY with N.I.N.A.): start and end of the exposure.
pub const GPS_TIMES: &[(&str, Role)] =
    &[("GPS-SUTC", Role::Start), ("GPS-ST", Role::Start), ("GPS-EUTC", Role::End), ("GPS-ET", Role::End)];

/// Keywords of the sidereal time of the site.
pub const SIDEREAL_TIMES: &[&str] = &["LST", "LST-OBS", "LMST", "ST", "SIDTIME", "SIDEREAL"];
