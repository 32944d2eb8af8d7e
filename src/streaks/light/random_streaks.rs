//! Random streaks for training sets, drawn from a seed.

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Poisson};

use super::sky_track::{SkyPoint, SkyTrack};
use crate::error::Error;
use crate::frames::{Direction, Gcrs};

/// Number, magnitudes and rates of random streaks.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct RandomStreaks {
    /// Number of streaks in a frame.
    pub number: StreakNumber,
    /// Range of apparent magnitudes, the brighter first; magnitudes are distributed uniformly.
    pub magnitude: [f64; 2],
    /// Range of angular rates, rad/s, the slower first; logarithms of rates are distributed uniformly.
    pub rate_rad_s: [f64; 2],
}

/// Number of streaks in a frame.
#[derive(Copy, Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum StreakNumber {
    /// Exactly this number of streaks, all of which touch the frame.
    Exactly(usize),
    /// Poisson-distributed number with this mean.
    OnAverage(f64),
}

/// Speed of low satellites relative to an observer, km/s. The distance of a random light, and with it its defocus, is
/// this speed divided by the angular rate.
const PASSING_KM_S: f64 = 7.6;

/// Constant combined with the seed, so that the streaks are independent of stars and noise with the same seed.
const OWN_STREAM: u64 = 0x5354_5245_414b_5321;

/// Number of points of one track.
const POINTS: usize = 65;

/// Largest number of streaks in one frame.
const MOST_STREAKS: usize = 10_000;

impl RandomStreaks {
    /// Checks all ranges.
    ///
    /// # Errors
    /// A number is outside its allowed range, or the ends of a range are in the wrong order.
    pub fn check(&self) -> Result<(), Error> {
        let held = |what: &str, [from, to]: [f64; 2], allowed: &str, [least, most]: [f64; 2]| {
            let right = from >= least && to <= most && from <= to;
            let given = if from == to { from.to_string() } else { format!("{from} to {to}") };
            if right { Ok(()) } else { Err(Error::invalid(what, given, allowed).at("random streaks")) }
        };
        let number = match self.number {
            StreakNumber::Exactly(number) => number as f64,
            StreakNumber::OnAverage(mean) => mean,
        };
        held("number", [number, number], "0 to 10000", [0.0, MOST_STREAKS as f64])?;
        held("magnitudes", self.magnitude, "-20 to 30, the brighter first", [-20.0, 30.0])?;
        let rates_deg_s = self.rate_rad_s.map(f64::to_degrees);
        held("rates (deg/s)", rates_deg_s, "1e-4 to 10, the slower first", [1e-4, 10.0])
    }

    /// Returns the tracks of the random streaks of one frame.
    ///
    /// `to_sky` is called once for each streak. It converts three random numbers in [0, 1) and a random time, in
    /// seconds after the shutter opened, to a direction in the frame. The light passes this direction at that time,
    /// moving in a random direction. Its track extends `radius_rad` to either side, but not beyond the opening and the
    /// closing of the shutter.
    ///
    /// The streaks depend only on the seed, not on the other random numbers of the frame.
    pub fn tracks(
        &self,
        seed: u64,
        exposure_s: f64,
        radius_rad: f64,
        to_sky: impl Fn([f64; 3], f64) -> Option<Direction<Gcrs>>,
    ) -> Vec<SkyTrack> {
        let mut random = ChaCha8Rng::seed_from_u64(seed ^ OWN_STREAM);
        let number = match self.number {
            StreakNumber::Exactly(number) => number,
            // With a mean of 0, for which `Poisson` is not defined, there are no streaks.
            StreakNumber::OnAverage(mean) => {
                Poisson::new(mean).map_or(0, |poisson| (poisson.sample(&mut random) as usize).min(MOST_STREAKS))
            }
        };
        let streaks = (0..number).map(|_| {
            let mut draw = || random.random::<f64>();
            let drawn = [draw(), draw(), draw()];
            let [moment, turn, speed, light] = [draw(), draw(), draw(), draw()];
            let passing_s = moment * exposure_s;
            let centre = to_sky(drawn, passing_s);
            let [slow, fast] = self.rate_rad_s;
            let rate_rad_s = slow * (fast / slow).powf(speed);
            let [bright, faint] = self.magnitude;
            let magnitude = bright + (faint - bright) * light;
            Some(straight(
                &centre?,
                turn * std::f64::consts::TAU,
                rate_rad_s,
                passing_s,
                exposure_s,
                radius_rad,
                magnitude,
            ))
        });
        streaks.flatten().collect()
    }
}

/// Returns a track of constant angular rate along a great circle through `centre`, which the light passes at
/// `passing_s`.
fn straight(
    centre: &Direction<Gcrs>,
    position_angle_rad: f64,
    rate_rad_s: f64,
    passing_s: f64,
    exposure_s: f64,
    radius_rad: f64,
    magnitude: f64,
) -> SkyTrack {
    let (east, north) = centre.east_north();
    let ahead: Vector3<f64> = east * position_angle_rad.sin() + north * position_angle_rad.cos();
    let reach_s = radius_rad / rate_rad_s;
    let (from_s, to_s) = ((passing_s - reach_s).max(0.0), (passing_s + reach_s).min(exposure_s));
    let points = (0..POINTS).map(|index| {
        let time_s = from_s + (to_s - from_s) * index as f64 / (POINTS - 1) as f64;
        let (sin, cos) = (rate_rad_s * (time_s - passing_s)).sin_cos();
        SkyPoint {
            time_s,
            direction: Direction::from_vector(centre.vector() * cos + ahead * sin),
            range_km: PASSING_KM_S / rate_rad_s,
            magnitude: Some(magnitude),
        }
    });
    SkyTrack { points: points.collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn streaks(number: StreakNumber) -> RandomStreaks {
        RandomStreaks { number, magnitude: [4.0, 8.0], rate_rad_s: [0.2f64.to_radians(), 1.0f64.to_radians()] }
    }

    fn to_sky(drawn: [f64; 3], _: f64) -> Option<Direction<Gcrs>> {
        Some(Direction::from_lon_lat_rad(1.0 + 0.01 * drawn[1], 0.5 + 0.01 * drawn[2]))
    }

    #[test]
    fn verif_streaks_are_in_their_ranges_and_depend_on_the_seed() {
        let request = streaks(StreakNumber::Exactly(200));
        request.check().unwrap();
        let tracks = request.tracks(7, 30.0, 0.02, to_sky);
        assert_eq!(tracks.len(), 200);
        assert_eq!(tracks, request.tracks(7, 30.0, 0.02, to_sky));
        assert_ne!(tracks, request.tracks(8, 30.0, 0.02, to_sky));
        let mut faint = 0;
        for track in &tracks {
            let [first, last] = [track.points[0], track.points[POINTS - 1]];
            assert!(first.time_s >= 0.0 && last.time_s <= 30.0 && last.time_s > first.time_s);
            let rate = first.direction.separation_rad(&last.direction) / (last.time_s - first.time_s);
            assert!(
                (0.2..=1.0).contains(&(rate.to_degrees() + 1e-9)) || (rate.to_degrees() - 1.0).abs() < 1e-6,
                "{rate}"
            );
            assert!((first.range_km * rate / PASSING_KM_S - 1.0).abs() < 1e-6);
            let magnitude = first.magnitude.unwrap();
            assert!((4.0..=8.0).contains(&magnitude));
            faint += usize::from(magnitude > 6.0);
        }
        // Half of 200, within four sigma of the binomial distribution.
        assert!((72..=128).contains(&faint), "{faint}");
    }

    #[test]
    fn verif_mean_numbers_give_poisson_numbers() {
        let request = streaks(StreakNumber::OnAverage(3.0));
        let counts: Vec<f64> = (0..2000).map(|seed| request.tracks(seed, 30.0, 0.02, to_sky).len() as f64).collect();
        let mean = counts.iter().sum::<f64>() / 2000.0;
        let variance = counts.iter().map(|count| (count - mean).powi(2)).sum::<f64>() / 1999.0;
        // The standard deviations are √(3 / 2000) = 0.04 for the mean and 3 √(2 / 2000 (1 + 1 / 6)) = 0.1 for the
        // variance; the tolerances are five times as large.
        assert!((mean - 3.0).abs() < 0.2 && (variance - 3.0).abs() < 0.5, "{mean} {variance}");
        assert!(streaks(StreakNumber::OnAverage(0.0)).tracks(1, 30.0, 0.02, to_sky).is_empty());
    }

    #[test]
    fn verif_invalid_ranges_are_rejected() {
        let mut request = streaks(StreakNumber::Exactly(20_000));
        assert!(request.check().unwrap_err().to_string().contains("0 to 10000"));
        request = RandomStreaks { magnitude: [8.0, 4.0], ..streaks(StreakNumber::Exactly(1)) };
        assert!(request.check().unwrap_err().to_string().contains("the brighter first"));
        request = RandomStreaks { rate_rad_s: [0.0, 0.01], ..streaks(StreakNumber::Exactly(1)) };
        assert!(request.check().is_err());
        assert!(streaks(StreakNumber::OnAverage(f64::NAN)).check().is_err());
    }
}
