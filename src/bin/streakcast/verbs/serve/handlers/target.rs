//! Centre of the field: by coordinates in degrees, or as a target that is typed as a name or as coordinates.

use streakcast::frames::{Direction, Gcrs, deep_sky_object, parse_direction};

use super::super::problem::Problem;
use super::super::query::{Kind, Parameter, Query, optional};

pub const TARGET: Parameter = optional(
    "target",
    Kind::Text { longest: 100 },
    "Field's centre instead of ra_deg and dec_deg: name of a Messier or Caldwell object, also by NGC or IC number, or right ascension and declination (ICRS) such as 12h34m -30d30m or 188.5 -30.5.",
);

const ACCEPTED: &str = "a Messier or Caldwell object, also by NGC or IC number, such as M31; or right ascension and declination such as 12h34m -30d30m or 188.5 -30.5";

/// Returns the centre of the field of a query.
pub fn pointing_of(query: &Query) -> Result<Direction<Gcrs>, Problem> {
    match (query.text(TARGET.name), query.number("ra_deg"), query.number("dec_deg")) {
        (Some(target), None, None) => parsed(target).ok_or_else(|| Problem::parameter(TARGET.name, target, ACCEPTED)),
        (None, Some(ra_deg), Some(dec_deg)) => {
            Ok(Direction::from_lon_lat_rad(ra_deg.to_radians(), dec_deg.to_radians()))
        }
        (Some(_), ..) => Err(Problem::both(TARGET.name, "ra_deg or dec_deg")),
        (None, None, _) => Err(Problem::missing("ra_deg", "ra_deg and dec_deg, or target")),
        (None, _, None) => Err(Problem::missing("dec_deg", "ra_deg and dec_deg, or target")),
    }
}

fn parsed(target: &str) -> Option<Direction<Gcrs>> {
    deep_sky_object(target).ok().or_else(|| {
        let (ra, dec) = angles(target)?;
        parse_direction(ra.trim(), dec.trim()).ok()
    })
}

/// Divides coordinates at a comma, at the sign of the declination, or at the only blank. Coordinates at a comma must
/// have the same number of parts: in `12,5 30` and `12 30,5` the comma is a decimal one, which is an error on the
/// command line.
fn angles(text: &str) -> Option<(&str, &str)> {
    if let Some((ra, dec)) = text.split_once(',') {
        let parts = |text: &str| text.split_whitespace().count();
        return (parts(ra) == parts(dec)).then_some((ra, dec));
    }
    let at_sign = || text.rfind(['+', '-', '\u{2212}']).map(|place| text.split_at(place));
    let at_blank = || text.trim().split_once(' ').filter(|(_, dec)| !dec.trim().contains(' '));
    at_sign().or_else(at_blank)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_names_and_coordinates_give_the_same_directions() {
        let expected = parse_direction("188.5", "-30.5").unwrap();
        for text in [
            "188.5 -30.5",
            "188.5,-30.5",
            " 188.5 , -30.5 ",
            "12h34m -30d30m",
            "12h34m-30d30m",
            "12:34:00 -30:30:00",
            "12 34 00 -30 30 00",
            "12 34 00, -30 30 00",
            "12h34m00s \u{2212}30\u{b0}30\u{2032}",
        ] {
            let apart_rad = parsed(text).expect(text).separation_rad(&expected);
            assert!(apart_rad < 1e-12, "{text}: {apart_rad} rad");
        }
        assert_eq!(parsed("188.5 30.5"), parse_direction("188.5", "30.5").ok());
        for name in ["M31", "ngc 224", "IC-342"] {
            assert_eq!(parsed(name), deep_sky_object(name).ok(), "{name}");
        }
        for text in [
            "",
            "M111",
            "188.5",
            "188.5 -95",
            "400 10",
            "12 34 56",
            "12h34m, 56d, 7",
            "nan nan",
            "<b>",
            "12,5 30",
            "12 30,5",
            "12,5 30,5",
            "12,5 +30",
        ] {
            assert_eq!(parsed(text), None, "{text}");
        }
    }
}
