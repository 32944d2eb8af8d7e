//! Random numbers for rounding: subtractive dithering of compressed images, and rounding of added light.
//!
//! The dither follows FITS standard 4.0, appendix I: a table of 10000 numbers from the minimal standard generator of
//! Park and Miller (1988, Comm. ACM 31, 1192).

/// Length of the table.
const COUNT: usize = 10_000;

/// Table of random numbers, computed once for an image.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Dither {
    numbers: Vec<f32>,
}

impl Dither {
    pub fn new() -> Self {
        // seed ← 16807 seed mod (2³¹ - 1), from 1
        let mut seed: u64 = 1;
        let numbers = (0..COUNT)
            .map(|_| {
                seed = seed * 16_807 % 2_147_483_647;
                (seed as f64 / 2_147_483_647.0) as f32
            })
            .collect();
        Self { numbers }
    }

    /// Returns the random numbers for the pixels of a tile. The argument is the number of the tile, counted from 1,
    /// plus the seed (ZDITHER0) minus 1.
    pub fn of_tile(&self, tile_and_seed: usize) -> impl Iterator<Item = f64> + '_ {
        let mut start = (tile_and_seed + COUNT - 1) % COUNT;
        let first_of = |start: usize| (self.numbers[start] * 500.0) as usize;
        let mut next = first_of(start);
        std::iter::repeat_with(move || {
            let number = self.numbers[next];
            next += 1;
            if next == COUNT {
                start = (start + 1) % COUNT;
                next = first_of(start);
            }
            f64::from(number)
        })
    }
}

/// Returns a random number from -1/2 to 1/2 for a pixel, as a fraction of the step between two of its values.
///
/// If this is added before rounding, light of less than half a step is not always rounded to zero: the right fraction
/// of the pixels increases by a whole step. The number differs from pixel to pixel and with the seed.
pub(super) fn between_steps(seed: u64, pixel: usize) -> f64 {
    // SplitMix64 (Steele, Lea & Flood 2014): the seed is mixed first, so that adjacent seeds are not shifted sequences.
    let mixed = |mut z: u64| {
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    let z = mixed(seed).wrapping_add((pixel as u64).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    (mixed(z) >> 11) as f64 / (1u64 << 53) as f64 - 0.5
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn valid_the_last_seed_of_the_standard() {
        // FITS standard 4.0, appendix I: the 10000th seed is 1043618065.
        let dither = Dither::new();
        assert_eq!(dither.numbers[COUNT - 1], (1_043_618_065f64 / 2_147_483_647.0) as f32);
        assert_eq!(dither.of_tile(1).next(), Some(f64::from(dither.numbers[(dither.numbers[0] * 500.0) as usize])));
        // The next start follows the end of the table.
        assert_eq!(dither.of_tile(3).count_up_to(20_000), 20_000);
    }

    #[test]
    fn verif_rounding_differs_between_seeds_and_is_uniform() {
        let pixels = 10_000;
        let shares = |seed: u64| -> Vec<f64> { (0..pixels).map(|pixel| between_steps(seed, pixel)).collect() };
        let [first, second] = [0, 1].map(shares);
        assert_eq!(first, shares(0));
        // Uniform numbers have mean 0 and variance 1/12; 5 sigma of their means.
        let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / pixels as f64;
        let limit = 5.0 / (12.0 * pixels as f64).sqrt();
        for shares in [&first, &second] {
            assert!(shares.iter().all(|share| (-0.5..0.5).contains(share)));
            assert!(mean(&mut shares.iter().copied()).abs() < limit);
        }
        // Correlation with the other seed, also after a shift by up to 10 pixels.
        for shift in 0..10 {
            let product = mean(&mut first.iter().skip(shift).zip(&second).map(|(a, b)| a * b));
            assert!(product.abs() < limit / 12.0f64.sqrt(), "{shift}: {product}");
        }
    }

    trait CountUpTo: Iterator + Sized {
        fn count_up_to(self, limit: usize) -> usize {
            self.take(limit).count()
        }
    }
    impl<T: Iterator> CountUpTo for T {}
}
