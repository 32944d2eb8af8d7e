//! Middle and scatter of pixels, also if most of them have the same value: dead pixels, single photons, a sky that is cut
//! off.

/// Ratio of the standard deviation of a normal distribution and its median absolute deviation.
pub const SIGMA_OF_MAD: f64 = 1.482_602_218_505_602;
/// Smallest distance of dead pixels below the others, in the scatter of these.
const DEAD_SIGMAS: f32 = 5.0;
/// Smallest share of the pixels with the smallest value for which these are a pile.
const LEAST_PILE: f64 = 0.3;
/// Smallest number of dead pixels, and of other values beside those that are the same, and their smallest share.
const LEAST_OTHERS: usize = 3;
const LEAST_SHARE: f64 = 0.02;

/// Middle and scatter of values.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Scatter {
    /// Median.
    pub middle: f32,
    /// Standard deviation of a normal distribution with the same scatter; 0 for constant values.
    pub sigma: f32,
    /// Light of a photon, if the scatter is that of single photons; otherwise 0.
    pub step: f32,
}

/// Returns the middle and the scatter, and reorders the values; `None` without values.
///
/// The scatter is 1.4826 times the median absolute deviation. Values that are the smallest one, several times, and far
/// below the others, relative to their scatter, are those of dead pixels and are omitted. If more than half of the rest
/// are the same, or many are the smallest value, the others determine the scatter: if they are mostly one step away, they
/// are single photons, and of a fraction p without any, -ln p is the mean and the variance of their number. Otherwise
/// values are cut off.
pub fn scatter(values: &mut [f32]) -> Option<Scatter> {
    let mut alive = without_dead(values);
    let values = alive.as_deref_mut().unwrap_or(values);
    let middle = middle_of(values)?;
    let sigma = deviation(values.iter().copied(), middle)?;
    let found = Scatter { middle, sigma, step: 0.0 };
    let least = values.iter().copied().fold(f32::INFINITY, f32::min);
    let at_least = values.iter().filter(|value| **value == least).count();
    let pile = if sigma <= 0.0 { middle } else { least };
    if sigma > 0.0 && (at_least as f64) < LEAST_PILE * values.len() as f64 {
        return Some(found);
    }
    let others: Vec<f32> = values.iter().copied().filter(|value| *value != pile).collect();
    let share = others.len() as f64 / values.len() as f64;
    if others.len() < LEAST_OTHERS {
        return Some(found);
    }
    let step = others.iter().map(|value| (value - pile).abs()).fold(f32::INFINITY, f32::min);
    let usual = deviation(others.iter().copied(), pile)?;
    Some(if f64::from(usual) < 1.5 * SIGMA_OF_MAD * f64::from(step) {
        Scatter { sigma: step * (-(1.0 - share).ln()).sqrt() as f32, step, ..found }
    } else if share >= LEAST_SHARE {
        Scatter { sigma: usual, ..found }
    } else {
        found
    })
}

/// Returns the values without those of dead pixels; `None` if there are none of these.
fn without_dead(values: &[f32]) -> Option<Vec<f32>> {
    let least = values.iter().copied().fold(f32::INFINITY, f32::min);
    let mut alive: Vec<f32> = values.iter().copied().filter(|value| *value > least).collect();
    let dead = values.len() - alive.len();
    if dead < LEAST_OTHERS || (dead as f64) < LEAST_SHARE * values.len() as f64 {
        return None;
    }
    let middle = middle_of(&mut alive)?;
    let sigma = deviation(alive.iter().copied(), middle)?;
    (sigma > 0.0 && middle - least > DEAD_SIGMAS * sigma).then_some(alive)
}

/// Returns a middle value and reorders the values; `None` if there are none.
fn middle_of(values: &mut [f32]) -> Option<f32> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f32::total_cmp).1)
}

/// Returns 1.4826 times the median absolute deviation from a value.
fn deviation(values: impl Iterator<Item = f32>, middle: f32) -> Option<f32> {
    let mut away: Vec<f32> = values.map(|value| (value - middle).abs()).collect();
    middle_of(&mut away).map(|away| SIGMA_OF_MAD as f32 * away)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Poisson, StandardNormal};

    use super::*;

    #[test]
    fn values_that_pile_up_have_the_scatter_of_the_others() {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let mut of = |change: &dyn Fn(f32, f64) -> f32| {
            let mut draw = || change(random.sample(StandardNormal), random.random());
            scatter(&mut (0..20_000).map(|_| draw()).collect::<Vec<f32>>()).unwrap()
        };
        for dead in [0.0, 0.3, 0.6, 0.9] {
            let found = of(&|noise, share| if share < dead { 0.0 } else { (1000.0 + 20.0 * noise).round() });
            assert!((found.middle - 1000.0).abs() < 2.0 && (found.sigma - 20.0).abs() < 2.0, "{dead}: {found:?}");
        }
        // A sky at 0 and below, without negative values.
        for whole in [true, false] {
            let found =
                of(&|noise, _| if whole { (9.0 * noise - 1.0).max(0.0).round() } else { (9.0 * noise).max(0.0) });
            assert!((found.sigma - 9.0).abs() < 1.5 && found.step == 0.0, "{found:?}");
        }
        for mean in [0.005_f64, 0.05, 0.4] {
            let photons = Poisson::new(mean).unwrap();
            let mut values: Vec<f32> = (0..20_000).map(|_| photons.sample(&mut random) as f32).collect();
            let found = scatter(&mut values).unwrap();
            assert!((f64::from(found.sigma) / mean.sqrt() - 1.0).abs() < 0.1, "{mean}: {found:?}");
            assert_eq!((found.middle, found.step), (0.0, 1.0));
        }
        assert_eq!(scatter(&mut [7.0; 100]).unwrap().sigma, 0.0);
        assert_eq!(scatter(&mut []), None);
    }
}
