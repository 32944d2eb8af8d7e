//! Trails in the exposures of a telescope in orbit: random pointings within the limits of the telescope over a span of
//! time.
//!
//! Times and pointings are drawn evenly over the times at which the position of the telescope is known, and the parts
//! of the sky that the Earth does not hide and that the limits allow while the shutter is open. The field has a random
//! rotation in each exposure. The errors of the means are those of a bootstrap: the standard deviation of the mean over
//! random samples of the same exposures, drawn with replacement.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use hifitime::Epoch;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::constants::LONGEST_EXPOSURE_S;
use crate::elements::ElementSet;
use crate::error::{Error, ErrorKind};
use crate::frames::{Direction, seconds_after, seconds_between};
use crate::orbit::LeftOut;
use crate::output::{Column, Kind, Table, Value};
use crate::passes::{Exposure, Field, Pass, PassOptions, Sky};
use crate::photometry::PhotometryOptions;

/// Number of samples of the bootstrap.
const SAMPLES: usize = 1000;
/// Number of draws for each pointing after which the limits are taken as too narrow.
const MOST_DRAWS: usize = 10_000;
/// Largest number of pointings.
const MOST_POINTINGS: usize = 1_000_000;
/// Number of random sets of pointings that are tested together.
const CHUNK: usize = 4096;
/// Width of the bins of position angles, degrees.
const BIN_DEG: f64 = 10.0;

/// Class of an orbit by its mean motion and eccentricity.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum OrbitHeight {
    /// Low: period below 128 min.
    Low,
    /// Medium: between low and geosynchronous orbits.
    Medium,
    /// Eccentricity of 0.25 or more, or above geosynchronous orbits.
    HighlyElliptical,
    /// Geosynchronous: 0.9 to 1.1 revolutions a day.
    Geosynchronous,
}

impl OrbitHeight {
    /// All classes, in the order of the tables.
    pub const ALL: [Self; 4] = [Self::Low, Self::Medium, Self::HighlyElliptical, Self::Geosynchronous];

    /// Returns the class of the orbit of an element set.
    pub fn from_elements(elements: &ElementSet) -> Self {
        match (elements.eccentricity, elements.mean_motion_rev_day) {
            (0.25.., _) => Self::HighlyElliptical,
            (_, 11.25..) => Self::Low,
            (_, 0.9..=1.1) => Self::Geosynchronous,
            (_, 1.1..) => Self::Medium,
            _ => Self::HighlyElliptical,
        }
    }

    /// Returns the usual abbreviation.
    pub fn name(self) -> &'static str {
        match self {
            Self::Low => "LEO",
            Self::Medium => "MEO",
            Self::HighlyElliptical => "HEO",
            Self::Geosynchronous => "GEO",
        }
    }
}

/// Request for trails in random exposures of a telescope in orbit.
#[derive(Clone, Debug)]
pub struct TrailRequest<'a> {
    /// Start of the span in which exposures begin.
    pub start: Epoch,
    /// End of the span.
    pub end: Epoch,
    /// Number of exposures.
    pub pointings: usize,
    /// Seed of the random times, pointings, rotations and samples.
    pub seed: u64,
    /// Exposure time, seconds.
    pub exposure_s: f64,
    /// Field of view.
    pub field: &'a Field,
    /// If given, trails brighter than this magnitude are counted, too.
    pub limit_mag: Option<f64>,
    /// If true, satellites in the Earth's shadow are counted, too.
    pub include_dark: bool,
    /// Band and magnitude system.
    pub photometry: PhotometryOptions,
}

/// Trail of a satellite in one exposure.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Trail {
    /// Class of the orbit.
    pub orbit: OrbitHeight,
    /// True if the satellite is lit in a part of the field.
    pub lit: bool,
    /// Position angle of the trail in its middle, from north through east, radians, in [-π/2, π/2).
    pub position_angle_rad: f64,
    /// Probability that the satellite is brighter than the limit of the request; 0 without a limit and in shadow.
    pub p_brighter: f64,
}

/// Trails in random exposures.
#[derive(Clone, Debug, Default)]
pub struct TrailStatistics {
    /// Exposures, in the order in which they were drawn.
    pub exposures: Vec<Exposure>,
    /// Trails of each exposure.
    pub trails: Vec<Vec<Trail>>,
    /// Number of satellites of each class in the catalogue, in the order of [`OrbitHeight::ALL`].
    pub satellites: [usize; 4],
    /// Share of the drawn times and directions that the Earth does not hide and that the limits allow.
    pub allowed_share: f64,
    /// Satellites whose position cannot be computed.
    pub left_out: Vec<LeftOut>,
}

/// Mean of a number over the exposures, with its bootstrap error.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Mean {
    /// Mean over the exposures.
    pub mean: f64,
    /// One-sigma error from the bootstrap.
    pub sigma: f64,
}

/// Computes the trails in random exposures of a telescope in orbit.
///
/// # Errors
/// A number is out of range, the observer is not in orbit, its position cannot be computed, or the limits allow no
/// pointing.
pub fn trail_statistics(sky: &Sky, request: &TrailRequest<'_>) -> Result<TrailStatistics, Error> {
    request.check()?;
    // Positions along the orbit need not be known: only numbers of satellites are computed.
    let sky = &sky.clone().with_elements_of_any_age();
    let (exposures, allowed_share) = random_exposures(sky, request)?;
    let options = PassOptions {
        include_dark: request.include_dark,
        without_light: request.limit_mag.is_none(),
        without_probability: true,
        photometry: request.photometry,
        ..PassOptions::default()
    };
    let passes = sky.field_passes(&exposures, request.field, &options)?;
    let trail = |pass: &Pass| Trail {
        orbit: OrbitHeight::from_elements(&sky.elements()[pass.element_index]),
        lit: pass.lit,
        position_angle_rad: (pass.position_angle_rad + FRAC_PI_2).rem_euclid(PI) - FRAC_PI_2,
        p_brighter: request.limit_mag.map_or(0.0, |limit_mag| pass.probability_brighter_than(limit_mag)),
    };
    let of_exposure = |passes: &Vec<Pass>| passes.iter().filter(|pass| pass.is_crossing()).map(trail).collect();
    let mut satellites = [0; 4];
    for set in sky.elements() {
        satellites[OrbitHeight::from_elements(set) as usize] += 1;
    }
    Ok(TrailStatistics {
        trails: passes.by_exposure.iter().map(of_exposure).collect(),
        exposures,
        satellites,
        allowed_share,
        left_out: passes.left_out,
    })
}

impl TrailRequest<'_> {
    fn check(&self) -> Result<(), Error> {
        let out_of_range = |what: &str, given: f64, unit: &str, allowed: &str| {
            Err(Error::invalid(what, format_args!("{given}{unit}"), allowed))
        };
        if !(0.0..=LONGEST_EXPOSURE_S).contains(&self.exposure_s) {
            return out_of_range("exposure", self.exposure_s, " s", "0 to 86400 s");
        }
        if !(2..=MOST_POINTINGS).contains(&self.pointings) {
            return out_of_range("pointings", self.pointings as f64, "", "2 to 1000000");
        }
        match self.limit_mag {
            Some(limit_mag) if !(-30.0..=40.0).contains(&limit_mag) => {
                out_of_range("limit-mag", limit_mag, " mag", "-30 to 40 mag")
            }
            _ => Ok(()),
        }
    }
}

/// Draws exposures until enough of them are allowed; returns these, and the share of the allowed ones.
fn random_exposures(sky: &Sky, request: &TrailRequest<'_>) -> Result<(Vec<Exposure>, f64), Error> {
    let observer = sky.viewpoint().orbit().ok_or_else(|| {
        Error::new(ErrorKind::Invalid, format!("{} is not in orbit", sky.viewpoint().name()))
            .allowing("a telescope in orbit")
    })?;
    let mut random = ChaCha8Rng::seed_from_u64(request.seed);
    let span_s = seconds_between(request.start, request.end);
    let (mut found, mut drawn) = (Vec::new(), 0);
    while found.len() < request.pointings {
        sky.watch().check()?;
        let draws: Vec<Exposure> = (0..CHUNK).map(|_| random_exposure(&mut random, request, span_s)).collect();
        let is_allowed = |exposure: &Exposure| -> Result<bool, Error> {
            let interval = [exposure.start, seconds_after(exposure.start, exposure.duration_s)];
            if sky.viewpoint().known_part(interval, 0.0, 0.0).is_none() {
                return Ok(false);
            }
            let allows = |exposure: &Exposure| {
                let angles = sky.pointing_angles(exposure)?;
                let is_free = |angles: &_| observer.limits().margin_rad(angles) >= 0.0;
                Ok::<_, Error>(angles.iter().all(|angles| angles.limb_rad >= 0.0 && is_free(angles)))
            };
            // Most draws are rejected at opening.
            Ok(allows(&Exposure { duration_s: 0.0, ..exposure.clone() })? && allows(exposure)?)
        };
        let allowed: Vec<bool> = draws.par_iter().map(is_allowed).collect::<Result<_, Error>>()?;
        for (exposure, is_allowed) in draws.into_iter().zip(allowed) {
            if found.len() == request.pointings {
                break;
            }
            drawn += 1;
            found.extend(is_allowed.then_some(exposure));
        }
        // With a share of one in MOST_DRAWS, none are found in so many draws by chance in less than 1 % of cases.
        if (found.len() + 5) * MOST_DRAWS < drawn {
            return Err(Error::new(
                ErrorKind::TooFewData,
                format!("the limits of the telescope allow {} of {drawn} random pointings", found.len()),
            )
            .allowing("wider limits, a shorter exposure, or a lower limb"));
        }
    }
    for (number, exposure) in found.iter_mut().enumerate() {
        exposure.id = (number + 1).to_string();
    }
    let share = found.len() as f64 / drawn as f64;
    Ok((found, share))
}

fn random_exposure(random: &mut ChaCha8Rng, request: &TrailRequest<'_>, span_s: f64) -> Exposure {
    let [moment, longitude, z, turn]: [f64; 4] = std::array::from_fn(|_| random.random());
    Exposure {
        id: String::new(),
        start: seconds_after(request.start, moment * span_s),
        duration_s: request.exposure_s,
        pointing: Direction::from_lon_lat_rad(longitude * TAU, (2.0 * z - 1.0).asin()),
        rotation_rad: turn * TAU,
    }
}

impl TrailStatistics {
    /// Returns the mean over the exposures of a sum over the trails of each.
    pub fn mean_of(&self, seed: u64, sum: impl Fn(&[Trail]) -> f64) -> Mean {
        let values: Vec<f64> = self.trails.iter().map(|trails| sum(trails)).collect();
        let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / self.trails.len() as f64;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let sample = |random: &mut ChaCha8Rng| {
            mean(&mut (0..values.len()).map(|_| values[random.random_range(0..values.len())]))
        };
        let samples: Vec<f64> = (0..SAMPLES).map(|_| sample(&mut random)).collect();
        let middle = samples.iter().sum::<f64>() / SAMPLES as f64;
        let variance = samples.iter().map(|sample| (sample - middle).powi(2)).sum::<f64>() / (SAMPLES - 1) as f64;
        Mean { mean: mean(&mut values.iter().copied()), sigma: variance.sqrt() }
    }

    /// Returns the mean number of trails in an exposure, and the share of exposures with one, for one class of orbits
    /// or all; with satellites in shadow if `with_dark`.
    pub fn trails_and_share(&self, seed: u64, orbit: Option<OrbitHeight>, with_dark: bool) -> [Mean; 2] {
        let count = |trails: &[Trail]| {
            trails
                .iter()
                .filter(|trail| (trail.lit || with_dark) && orbit.is_none_or(|orbit| trail.orbit == orbit))
                .count()
        };
        [
            self.mean_of(seed, |trails| count(trails) as f64),
            self.mean_of(seed, |trails| f64::from(u8::from(count(trails) > 0))),
        ]
    }

    /// Returns the numbers of exposures with 0, 1, 2, ... trails, up to the largest number.
    pub fn histogram(&self, with_dark: bool) -> Vec<usize> {
        let counts = self.trails.iter().map(|trails| trails.iter().filter(|trail| trail.lit || with_dark).count());
        counts.fold(Vec::new(), |mut bins, count| {
            bins.resize(bins.len().max(count + 1), 0);
            bins[count] += 1;
            bins
        })
    }

    /// Returns the numbers of trails by position angle, in bins of 10° from -90° to 90°.
    pub fn position_angles(&self, with_dark: bool) -> [usize; 18] {
        let mut bins = [0; 18];
        for trail in self.trails.iter().flatten().filter(|trail| trail.lit || with_dark) {
            let bin = (trail.position_angle_rad.to_degrees() + 90.0) / BIN_DEG;
            bins[(bin as usize).min(17)] += 1;
        }
        bins
    }
}

/// Returns the means as a table: one row for all satellites, and one for each class of orbits.
pub fn trail_table(statistics: &TrailStatistics, request: &TrailRequest<'_>) -> Table {
    let mut columns = vec![
        Column::new(
            "orbits",
            Kind::Text,
            "Orbits of the counted satellites: all, LEO (period below 128 min), MEO, HEO \
            (eccentricity of 0.25 or more, or above geosynchronous orbits) or GEO (0.9 to 1.1 revolutions a day).",
        ),
        Column::new("satellites", Kind::Integer, "Number of satellites in such orbits."),
        Column::real("trails_per_exposure", "", 4, "Mean number of trails of lit satellites in one exposure."),
        Column::real("trails_sigma", "", 4, "One-sigma bootstrap error of trails_per_exposure."),
        Column::real("streaked_share", "", 4, "Share of exposures with at least one trail of a lit satellite."),
        Column::real("streaked_sigma", "", 4, "One-sigma bootstrap error of streaked_share."),
    ];
    if request.include_dark {
        columns.extend([
            Column::real("trails_with_dark", "", 4, "The same as trails_per_exposure with satellites in shadow."),
            Column::real("trails_with_dark_sigma", "", 4, "One-sigma bootstrap error of trails_with_dark."),
            Column::real("streaked_with_dark", "", 4, "The same as streaked_share with satellites in shadow."),
            Column::real("streaked_with_dark_sigma", "", 4, "One-sigma bootstrap error of streaked_with_dark."),
        ]);
    }
    if request.limit_mag.is_some() {
        columns.extend([
            Column::real("limit_mag", "mag", 2, "Limit for which brighter trails are counted."),
            Column::real(
                "trails_brighter_than_limit",
                "",
                4,
                "Expected number of trails in one exposure of satellites \
                brighter than limit_mag.",
            ),
            Column::real("brighter_sigma", "", 4, "One-sigma bootstrap error of trails_brighter_than_limit."),
        ]);
    }
    let orbits = std::iter::once(None).chain(OrbitHeight::ALL.map(Some));
    let row = |orbit: Option<OrbitHeight>| -> Vec<Value> {
        let satellites = match orbit {
            Some(orbit) => statistics.satellites[orbit as usize],
            None => statistics.satellites.iter().sum(),
        };
        let mut row: Vec<Value> = vec![orbit.map_or("all", OrbitHeight::name).into(), (satellites as i64).into()];
        let mut add = |mean: Mean| row.extend([mean.mean.into(), mean.sigma.into()]);
        let dark: &[bool] = if request.include_dark { &[false, true] } else { &[false] };
        for &with_dark in dark {
            statistics.trails_and_share(request.seed, orbit, with_dark).into_iter().for_each(&mut add);
        }
        if let Some(limit_mag) = request.limit_mag {
            let of_orbit = |trail: &&Trail| orbit.is_none_or(|orbit| trail.orbit == orbit);
            let bright = |trails: &[Trail]| trails.iter().filter(of_orbit).map(|trail| trail.p_brighter).sum();
            let Mean { mean, sigma } = statistics.mean_of(request.seed, bright);
            row.extend([limit_mag.into(), mean.into(), sigma.into()]);
        }
        row
    };
    Table { columns, rows: orbits.map(row).collect() }
}

/// Returns the numbers of exposures by their number of trails as a table.
pub fn trail_histogram_table(statistics: &TrailStatistics, request: &TrailRequest<'_>) -> Table {
    let lit = statistics.histogram(false);
    let dark = request.include_dark.then(|| statistics.histogram(true));
    let mut columns = vec![
        Column::new("trails", Kind::Integer, "Number of trails in an exposure."),
        Column::new("exposures", Kind::Integer, "Number of exposures with so many trails of lit satellites."),
        Column::real("share", "", 4, "Share of these exposures."),
    ];
    if dark.is_some() {
        columns.push(Column::new("exposures_with_dark", Kind::Integer, "The same with satellites in shadow."));
    }
    let longest = lit.len().max(dark.as_ref().map_or(0, Vec::len));
    let at = |bins: &[usize], trails: usize| bins.get(trails).copied().unwrap_or(0);
    let row = |trails: usize| {
        let exposures = at(&lit, trails);
        let share = exposures as f64 / statistics.trails.len() as f64;
        let mut row: Vec<Value> = vec![(trails as i64).into(), (exposures as i64).into(), share.into()];
        row.extend(dark.as_ref().map(|dark| Value::from(at(dark, trails) as i64)));
        row
    };
    Table { columns, rows: (0..longest).map(row).collect() }
}

/// Returns the numbers of trails by position angle as a table.
pub fn trail_angle_table(statistics: &TrailStatistics, request: &TrailRequest<'_>) -> Table {
    let lit = statistics.position_angles(false);
    let dark = request.include_dark.then(|| statistics.position_angles(true));
    let mut columns = vec![
        Column::real(
            "from_deg",
            "deg",
            0,
            "Lower end of the position angles, from north through east. A trail has no \
            direction: its position angle is in [-90, 90) deg.",
        ),
        Column::real("to_deg", "deg", 0, "Upper end of the position angles."),
        Column::new("trails", Kind::Integer, "Number of trails of lit satellites with such position angles."),
        Column::real("share", "", 4, "Share of these trails."),
    ];
    if dark.is_some() {
        columns.push(Column::new("trails_with_dark", Kind::Integer, "The same with satellites in shadow."));
    }
    let all = lit.iter().sum::<usize>().max(1) as f64;
    let row = |bin: usize| {
        let from_deg = BIN_DEG * bin as f64 - 90.0;
        let mut row: Vec<Value> = vec![
            from_deg.into(),
            (from_deg + BIN_DEG).into(),
            (lit[bin] as i64).into(),
            (lit[bin] as f64 / all).into(),
        ];
        row.extend(dark.map(|dark| Value::from(dark[bin] as i64)));
        row
    };
    Table { columns, rows: (0..lit.len()).map(row).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trail(lit: bool, position_angle_deg: f64) -> Trail {
        let orbit = OrbitHeight::Low;
        Trail { orbit, lit, position_angle_rad: position_angle_deg.to_radians(), p_brighter: 0.0 }
    }

    #[test]
    fn bootstrap_error_is_that_of_the_mean() {
        // Numbers of trails 0, 1, 2, 3: mean 1.5, standard deviation √1.25, error of the mean √(1.25 / 400).
        let trails: Vec<Vec<Trail>> = (0..400).map(|number| vec![trail(true, 0.0); number % 4]).collect();
        let statistics = TrailStatistics { trails, ..TrailStatistics::default() };
        let [mean, share] = statistics.trails_and_share(1, None, false);
        assert!((mean.mean - 1.5).abs() < 1e-12 && (share.mean - 0.75).abs() < 1e-12);
        // The standard deviation of a standard deviation of 1000 samples is 2 %.
        assert!((mean.sigma / (1.25_f64 / 400.0).sqrt() - 1.0).abs() < 0.1, "{mean:?}");
        assert!((share.sigma / (0.75 * 0.25_f64 / 400.0).sqrt() - 1.0).abs() < 0.1, "{share:?}");
    }

    #[test]
    fn bins_of_numbers_and_angles() {
        let trails = vec![vec![trail(true, -90.0), trail(false, 89.9)], vec![], vec![trail(true, 31.0)]];
        let statistics = TrailStatistics { trails, ..TrailStatistics::default() };
        assert_eq!((statistics.histogram(false), statistics.histogram(true)), (vec![1, 2], vec![1, 1, 1]));
        let filled = |bins: [usize; 18]| -> Vec<usize> { (0..18).filter(|bin| bins[*bin] == 1).collect() };
        assert_eq!(filled(statistics.position_angles(false)), [0, 12]);
        assert_eq!(filled(statistics.position_angles(true)), [0, 12, 17]);
    }

    #[test]
    fn classes_of_orbits() {
        let of = |mean_motion_rev_day: f64, eccentricity: f64| {
            let set = ElementSet { mean_motion_rev_day, eccentricity, ..element_set() };
            OrbitHeight::from_elements(&set).name()
        };
        let found = [of(15.2, 0.001), of(2.0, 0.01), of(2.0, 0.7), of(1.0027, 0.001), of(0.5, 0.1), of(11.2, 0.0)];
        assert_eq!(found, ["LEO", "MEO", "HEO", "GEO", "HEO", "MEO"]);
    }

    fn element_set() -> ElementSet {
        let epoch = Epoch::from_gregorian_utc_at_midnight(2026, 4, 25);
        crate::elements::Constellation::by_name("oneweb").expect("built in").element_sets(epoch).remove(0)
    }
}
