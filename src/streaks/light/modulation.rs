//! Changes of brightness along a track beyond those of a stable satellite: tumbling, glints, custom light curves.

#[cfg(all(feature = "fits", unix))]
use std::path::Path;

use super::sky_track::{SkyPoint, SkyTrack};
use crate::error::Error;
#[cfg(all(feature = "fits", unix))]
use crate::input::TableRows;
#[cfg(all(feature = "fits", unix))]
#[cfg(all(feature = "fits", unix))]
use crate::units::{MAGNITUDES, SECONDS};

/// Brightness of a rotating body, a sine curve in magnitudes.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Tumbling {
    /// Time from one maximum to the next, seconds.
    pub period_s: f64,
    /// Difference between the faintest and the brightest magnitude, mag.
    pub amplitude_mag: f64,
    /// Phase when the shutter opens, in turns. At phase 0 the brightness has its mean value and increases.
    pub phase: f64,
}

/// Short flash of light, for example from a mirror that points at the observer.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Glint {
    /// Apparent magnitude of the flash alone at its peak.
    pub magnitude: f64,
    /// Time of the peak relative to the closest approach to the middle of the frame, seconds; negative if the peak is
    /// earlier.
    pub offset_s: f64,
    /// Full width at half maximum of the Gaussian flash, seconds.
    pub duration_s: f64,
}

/// Custom light curve: magnitudes to add as a function of the time after the shutter opened.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightCurve {
    points: Vec<(f64, f64)>,
}

impl LightCurve {
    /// Creates a light curve from pairs of seconds after the shutter opened and magnitudes to add. The curve is linear
    /// between the points, and constant before the first and after the last one.
    ///
    /// # Errors
    /// Fewer than two points, numbers that are not finite, or times that do not increase.
    pub fn new(points: Vec<(f64, f64)>) -> Result<Self, Error> {
        if points.len() < 2 {
            return Err(Error::invalid("light curve: number of points", points.len(), "2 or more"));
        }
        for (index, point) in points.iter().enumerate() {
            if !(point.0.is_finite() && point.1.is_finite()) {
                let given = format!("{} s, {} mag", point.0, point.1);
                return Err(Error::invalid(format!("point {}", index + 1), given, "finite numbers").at("light curve"));
            }
            if index > 0 && points[index - 1].0 >= point.0 {
                let what = format!("light curve: time of point {}", index + 1);
                let allowed = format!("later than the previous point at {} s", points[index - 1].0);
                return Err(Error::invalid(what, format!("{} s", point.0), allowed));
            }
        }
        Ok(Self { points })
    }

    /// Reads a light curve from a table (CSV or ECSV) with the columns `time_s` and `delta_mag`.
    ///
    /// # Errors
    /// The file cannot be read, a column is missing, a cell is not a number, and the errors of [`LightCurve::new`].
    #[cfg(all(feature = "fits", unix))]
    pub fn read(path: &Path) -> Result<Self, Error> {
        const FORM: &str = "time_s, delta_mag";
        let failed = |error: &dyn std::fmt::Display| Error::format(format!("light curve: {error}")).in_file("", path);
        let rows = TableRows::open(path).map_err(|error| failed(&error))?;
        let column = |names: &[&'static str], unit| rows.numbers(names, unit, FORM).map_err(|error| failed(&error));
        let columns = [column(&["time_s"], &SECONDS)?, column(&["delta_mag"], &MAGNITUDES)?];
        let mut points = Vec::new();
        for row in rows {
            let row = row.map_err(|error| failed(&error))?;
            let number = |column| row.number_in(column, [f64::MIN, f64::MAX]).map_err(|error| failed(&error));
            points.push((number(columns[0])?, number(columns[1])?));
        }
        Self::new(points).map_err(|error| failed(&error))
    }

    /// Returns the magnitudes to add at `time_s` seconds after the shutter opened.
    pub fn at(&self, time_s: f64) -> f64 {
        let after = self.points.partition_point(|point| point.0 <= time_s);
        match (after.checked_sub(1).and_then(|before| self.points.get(before)), self.points.get(after)) {
            (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (time_s - a.0) / (b.0 - a.0),
            (Some(end), None) | (None, Some(end)) => end.1,
            (None, None) => 0.0,
        }
    }

    fn shortest_s(&self) -> f64 {
        self.points.windows(2).map(|pair| pair[1].0 - pair[0].0).fold(f64::INFINITY, f64::min)
    }
}

/// All changes of brightness along a track, which are applied together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Modulation {
    /// Rotation of the body.
    pub tumbling: Option<Tumbling>,
    /// Flashes of light.
    pub glints: Vec<Glint>,
    /// Custom light curve.
    pub curve: Option<LightCurve>,
}

/// Number of points during the shortest change of brightness.
const STEPS_IN_A_CHANGE: f64 = 16.0;

/// Full width at half maximum of a Gaussian in standard deviations: 2 √(2 ln 2).
const FWHM_SIGMAS: f64 = 2.354_820_045_030_949;

/// Largest number of points of a refined track. A change with a period too short for this number of points (far below
/// the time in which the light crosses a pixel) appears as constant light.
const MOST_POINTS: f64 = 50_000.0;

impl Modulation {
    /// Checks periods, durations and amplitudes.
    ///
    /// # Errors
    /// A number out of range.
    pub fn check(&self) -> Result<(), Error> {
        let held = |what: &str, given: f64, allowed: &str, right: bool| {
            if right { Ok(()) } else { Err(Error::invalid(what, given, allowed)) }
        };
        if let Some(Tumbling { period_s, amplitude_mag, phase }) = self.tumbling {
            held("tumbling period (s)", period_s, "0.02 to 1e5", (0.02..=1e5).contains(&period_s))?;
            held("tumbling amplitude (mag)", amplitude_mag, "0 to 10", (0.0..=10.0).contains(&amplitude_mag))?;
            held("tumbling phase (turns)", phase, "-1 to 1", (-1.0..=1.0).contains(&phase))?;
        }
        for glint in &self.glints {
            held("glint magnitude", glint.magnitude, "-20 to 30", (-20.0..=30.0).contains(&glint.magnitude))?;
            held("glint offset (s)", glint.offset_s, "-1e5 to 1e5", glint.offset_s.abs() <= 1e5)?;
            held("glint duration (s)", glint.duration_s, "1e-3 to 1e4", (1e-3..=1e4).contains(&glint.duration_s))?;
        }
        Ok(())
    }

    /// Returns true if the brightness is not changed at all.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// Returns the track with changed brightness and with enough points to resolve the changes. The times of glints are
    /// relative to `middle_s`, seconds after the shutter opened. Points in the Earth's shadow stay dark.
    pub fn applied(&self, track: &SkyTrack, middle_s: f64) -> SkyTrack {
        if self.is_none() || track.points.is_empty() {
            return track.clone();
        }
        let span_s = track.points.last().map_or(0.0, |last| last.time_s) - track.points[0].time_s;
        let shortest_s = self.shortest_s() / STEPS_IN_A_CHANGE;
        let mut points = track.refined(shortest_s.max(span_s / MOST_POINTS)).points;
        for point in &mut points {
            point.magnitude = point.magnitude.map(|steady| self.magnitude(steady, point, middle_s));
        }
        SkyTrack { points }
    }

    fn magnitude(&self, steady: f64, point: &SkyPoint, middle_s: f64) -> f64 {
        // m = m₀ - A/2 sin 2π(t / P + φ)
        let turned = self.tumbling.map_or(0.0, |tumbling| {
            let turns = point.time_s / tumbling.period_s + tumbling.phase;
            -0.5 * tumbling.amplitude_mag * (std::f64::consts::TAU * turns).sin()
        });
        let curved = self.curve.as_ref().map_or(0.0, |curve| curve.at(point.time_s));
        let light = |magnitude: f64| 10f64.powf(-0.4 * magnitude);
        let flashes: f64 = self
            .glints
            .iter()
            .map(|glint| {
                let sigmas = (point.time_s - middle_s - glint.offset_s) / (glint.duration_s / FWHM_SIGMAS);
                light(glint.magnitude) * (-0.5 * sigmas * sigmas).exp()
            })
            .sum();
        -2.5 * (light(steady + turned + curved) + flashes).log10()
    }

    fn shortest_s(&self) -> f64 {
        let tumbling = self.tumbling.map(|tumbling| 0.5 * tumbling.period_s);
        let glints = self.glints.iter().map(|glint| glint.duration_s);
        let curve = self.curve.as_ref().map(LightCurve::shortest_s);
        tumbling.into_iter().chain(glints).chain(curve).fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::Direction;

    fn steady(magnitude: f64) -> SkyTrack {
        let point = |index: u32| SkyPoint {
            time_s: 2.0 + 0.25 * f64::from(index),
            direction: Direction::from_lon_lat_rad(0.01 * f64::from(index), 0.2),
            range_km: 600.0,
            magnitude: (index <= 16).then_some(magnitude),
        };
        SkyTrack { points: (0..=24).map(point).collect() }
    }

    /// ∫ light dt by the trapezoidal rule, in seconds of magnitude 0.
    fn light_s(track: &SkyTrack) -> f64 {
        let light = |point: &SkyPoint| point.magnitude.map_or(0.0, |magnitude| 10f64.powf(-0.4 * magnitude));
        track
            .points
            .windows(2)
            .map(|pair| 0.5 * (light(&pair[0]) + light(&pair[1])) * (pair[1].time_s - pair[0].time_s))
            .sum()
    }

    #[test]
    fn verif_a_tumbling_body_varies_by_its_amplitude() {
        let tumbling = Tumbling { period_s: 0.5, amplitude_mag: 2.0, phase: 0.0 };
        let track = Modulation { tumbling: Some(tumbling), ..Modulation::default() }.applied(&steady(6.0), 5.0);
        let lit = || track.points.iter().filter_map(|point| point.magnitude);
        assert!((lit().fold(f64::INFINITY, f64::min) - 5.0).abs() < 0.01);
        assert!((lit().fold(f64::NEG_INFINITY, f64::max) - 7.0).abs() < 0.01);
        let quarter = track.points.iter().find(|point| (point.time_s - 2.125).abs() < 1e-9).unwrap();
        assert!(
            (quarter.magnitude.unwrap() - 5.0).abs() < 1e-9,
            "brightest a quarter of a period after a whole number of turns"
        );
        assert!(track.points.iter().filter(|point| point.time_s > 6.01).all(|point| point.magnitude.is_none()));
    }

    #[test]
    fn verif_a_glint_adds_its_own_light() {
        // The track lasts from 2 to 8 s: its middle is at 5 s.
        let glint = Glint { magnitude: 3.0, offset_s: -1.0, duration_s: 0.1 };
        let track = Modulation { glints: vec![glint], ..Modulation::default() }.applied(&steady(7.0), 5.0);
        let peak = track
            .points
            .iter()
            .min_by(|a, b| a.magnitude.unwrap_or(99.0).total_cmp(&b.magnitude.unwrap_or(99.0)))
            .unwrap();
        assert!((peak.time_s - 4.0).abs() < 0.01, "{}", peak.time_s);
        // Gaussian of height h and FWHM w: h w √(π / ln 2) / 2.
        let own = 10f64.powf(-0.4 * 3.0) * 0.1 * (std::f64::consts::PI / std::f64::consts::LN_2).sqrt() / 2.0;
        let gained = light_s(&track) - light_s(&steady(7.0).refined(0.1 / 16.0));
        assert!((gained / own - 1.0).abs() < 2e-3, "{gained} {own}");
    }

    #[test]
    fn verif_a_light_curve_is_applied_and_checked() {
        let curve = LightCurve::new(vec![(3.0, 0.0), (4.0, 1.0), (4.1, -1.0)]).unwrap();
        for (time_s, added) in [(0.0, 0.0), (3.5, 0.5), (4.05, 0.0), (9.0, -1.0)] {
            assert!((curve.at(time_s) - added).abs() < 1e-12, "{time_s}");
        }
        let track = Modulation { curve: Some(curve), ..Modulation::default() }.applied(&steady(6.0), 5.0);
        let at =
            |time_s: f64| track.points.iter().find(|point| (point.time_s - time_s).abs() < 1e-9).unwrap().magnitude;
        assert!((at(3.5).unwrap() - 6.5).abs() < 1e-9 && (at(5.0).unwrap() - 5.0).abs() < 1e-9);
        for (points, words) in [
            (vec![(1.0, 0.0)], "number of points is 1; allowed: 2 or more"),
            (vec![(1.0, 0.0), (1.0, 1.0)], "time of point 2 is 1 s; allowed: later than"),
            (vec![(1.0, 0.0), (2.0, f64::NAN)], "point 2 is 2 s, NaN mag; allowed: finite"),
        ] {
            let message = LightCurve::new(points).unwrap_err().to_string();
            assert!(message.contains(words), "{message}");
        }
    }

    #[test]
    fn verif_invalid_changes_are_rejected_and_no_change_is_the_identity() {
        let tumbling = |period_s, amplitude_mag| Modulation {
            tumbling: Some(Tumbling { period_s, amplitude_mag, phase: 0.0 }),
            ..Modulation::default()
        };
        assert!(tumbling(0.0, 1.0).check().unwrap_err().to_string().contains("period (s) is 0; allowed: 0.02 to 1e5"));
        assert!(tumbling(1.0, f64::NAN).check().is_err());
        let glint = Glint { magnitude: 3.0, offset_s: 0.0, duration_s: -1.0 };
        assert!(Modulation { glints: vec![glint], ..Modulation::default() }.check().is_err());
        assert!(tumbling(2.0, 1.0).check().is_ok());
        assert_eq!(Modulation::default().applied(&steady(6.0), 5.0), steady(6.0));
    }
}
