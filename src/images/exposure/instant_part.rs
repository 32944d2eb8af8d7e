//! Part of the exposure to which an instant refers, by its comments and by the device that wrote it.

use super::comment::{AFTER_EXPOSURE, Comment, Role};
use super::instant::Instant;
use super::instant_keywords::{DATES, JULIAN_DATES, MODIFIED_DATES, OTHER_STARTS, TIMES, names_start};
use super::moment::Keywords;
use super::scale::DateScale;

/// Keywords of devices, and a device whose DATE-OBS is the time at which its image was created, the end of the exposure
/// (so read by the Seestar Photometry Stack for Siril, <https://gitlab.com/Aquarius58/siril-seestar-stack>; its maker
/// documents nothing), in lower case. The ASIAIR has the same comment, but nothing is published about its time; its
/// Autorun_Log has the times of captures (so read by <https://github.com/metalglove/astro-guiding-performance>).
const DEVICES: &[&str] = &["CREATOR", "INSTRUME"];
const CREATES_AT_END: &str = "seestar";
const WITH_LOG: &str = "asiair";
const CREATED: &str = "image created";

/// Telescope whose dates are those of the middle of the exposure (Explanatory Supplement to the NEOWISE Data Release
/// Products, section III.1.b).
const WITH_MIDDLES: &str = "WISE";

/// Reason why an instant of another scale is not used.
pub const OTHER_SCALE: &str = "in another time scale than TIMESYS";

/// Part of the exposure of an instant.
pub struct Part {
    /// `None` if neither a comment nor the device states it.
    pub role: Option<Role>,
    /// Sentence about a keyword that is read in another way than usual.
    pub reading: Option<String>,
}

/// Returns the part that the first comment with a part states, or else the device.
///
/// # Errors
/// The comment that makes the instant unusable, for example as a local time, and the reason.
pub fn part_of<'a>(
    keywords: Keywords<'_>,
    dates: DateScale,
    instant: &Instant,
    comments: &'a [Comment],
) -> Result<Part, (&'a Comment, &'static str)> {
    let from = &instant.from;
    let is_named = is_named(instant);
    let stated = comments.iter().enumerate().try_fold(None, |role: Option<Role>, (at, comment)| {
        let of_comment = || {
            if !dates.is_stated {
                comment.scale()?;
            } else if instant.epoch.time_scale == dates.scale && comment.contradicts(dates.scale) {
                return Err(OTHER_SCALE);
            }
            // The second comment is that of a date.
            comment.role((is_named && at == 0).then_some(instant.role))
        };
        of_comment().map(|stated| role.or(stated)).map_err(|problem| (comment, problem))
    });
    match stated {
        Err((comment, AFTER_EXPOSURE)) if from == "DATE-OBS" && is_created_at_end(keywords, comment) => {
            let reading = format!(
                "{from} is read as the end of the exposure (comment {:?}), as the Seestar Photometry Stack for Siril does: \
                 the maker of the camera does not document it",
                comment.text()
            );
            Ok(Part { role: Some(Role::End), reading: Some(reading) })
        }
        Err(problem) => Err(problem),
        Ok(None) if !is_named && keywords.text(&["TELESCOP"]).is_some_and(|(_, name)| name == WITH_MIDDLES) => {
            let reading = format!("{from} is read as the middle of the exposure, as {WITH_MIDDLES} writes it");
            Ok(Part { role: Some(Role::Middle), reading: Some(reading) })
        }
        Ok(role) => {
            let is_other_scale = dates.is_stated && instant.epoch.time_scale != dates.scale;
            let reading = || format!("{from} is read as UTC, by its comment, and not as {}", dates.scale);
            Ok(Part { role, reading: is_other_scale.then(reading) })
        }
    }
}

/// Returns true if the name of the keyword states the part of the exposure.
pub fn is_named(instant: &Instant) -> bool {
    instant.role != Role::Start || instant.from.split(" + ").any(names_start)
}

/// Returns true for the comment of a device that creates its image at the end of the exposure, without a keyword that
/// names the start.
fn is_created_at_end(keywords: Keywords<'_>, comment: &Comment) -> bool {
    let starts = [DATES, TIMES, MODIFIED_DATES, JULIAN_DATES, OTHER_STARTS];
    let mut named = starts.into_iter().flatten().filter(|name| names_start(name));
    comment.text().to_ascii_lowercase().contains(CREATED)
        && is_of_device(keywords, CREATES_AT_END)
        && !named.any(|name| keywords.find(name).is_some())
}

fn is_of_device(keywords: Keywords<'_>, device: &str) -> bool {
    let devices = DEVICES.iter().filter_map(|keyword| keywords.text(&[keyword]));
    devices.into_iter().any(|(_, text)| text.to_ascii_lowercase().contains(device))
}

/// Returns the rest of an error about a time after the exposure: where the times of the device are.
pub fn hint_of_device(keywords: Keywords<'_>, problem: &str) -> &'static str {
    if problem == AFTER_EXPOSURE && is_of_device(keywords, WITH_LOG) {
        " (see the times of captures in Autorun_Log of the ASIAIR)"
    } else {
        ""
    }
}
