//! Weighted least-squares fit of a template to a band of pixels.

use super::band::Band;

/// Ranges of columns of a band in which the background is fitted separately, and the extent of the fit across the
/// track.
#[derive(Clone, Debug)]
pub struct Blocks {
    /// First column of each block, and the end of the last one.
    pub bounds: Vec<usize>,
    /// Half width of the fit, pixels of the minor axis.
    pub half_width: usize,
    /// Weight of the pixels of each block: the smallest variance of the residuals in a block divided by that of this
    /// block. Blocks at a bright edge of the frame or at a bright star have small weights.
    pub weights: Vec<f64>,
}

impl Blocks {
    /// Divides a band into blocks of about `length` columns.
    pub fn new(columns: usize, length: usize, half_width: usize) -> Self {
        let count = (columns / length.max(1)).max(1);
        let bounds = (0..=count).map(|block| block * columns / count).collect();
        Self { bounds, half_width, weights: vec![1.0; count] }
    }

    /// Sets the weights by the residuals of the template and the background in each block.
    pub fn weigh(&mut self, band: &Band, mask: &[bool], template: &[f32]) {
        self.weights.fill(1.0);
        let fits = fit_blocks(band, &band.values, mask, template, 0, self);
        let variances: Vec<f64> = fits.iter().map(BlockFit::variance).collect();
        let least = variances.iter().copied().filter(|variance| *variance > 0.0).fold(f64::INFINITY, f64::min);
        for (weight, variance) in self.weights.iter_mut().zip(variances) {
            *weight = if variance > 0.0 { least / variance } else { 1.0 };
        }
    }

    /// Returns the columns and the weight of each block.
    pub fn weighted(&self) -> impl Iterator<Item = (std::ops::Range<usize>, f64)> + '_ {
        self.ranges().zip(self.weights.iter().copied())
    }

    /// Returns the ranges of columns.
    pub fn ranges(&self) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
        self.bounds.windows(2).map(|pair| pair[0]..pair[1])
    }
}

/// Fit of a block: its light after projection on the template without constant and slope. The sums include the weight
/// of the block.
#[derive(Copy, Clone, Debug, Default)]
pub struct BlockFit {
    /// Σ m'², the weight of the amplitude; m' is the template minus its fit by a constant and a slope.
    pub weight: f64,
    /// Σ m' d, where d are the data.
    pub signal: f64,
    /// Σ d'², where d' are the data minus their fit by a constant and a slope.
    pub squares: f64,
    /// Constant and slope per pixel of the minor axis without the template.
    pub background: [f64; 2],
    /// Response of the constant and the slope to the template.
    pub response: [f64; 2],
    /// Number of pixels.
    pub pixels: usize,
}

impl BlockFit {
    /// Amplitude of the template; `None` without any pixel of the streak.
    pub fn amplitude(&self) -> Option<f64> {
        (self.weight > 0.0).then(|| self.signal / self.weight)
    }

    /// Sum of the squared residuals with the amplitude of the block.
    fn rest(&self) -> f64 {
        self.squares - if self.weight > 0.0 { self.signal * self.signal / self.weight } else { 0.0 }
    }

    /// Variance of the residuals; 0 with too few pixels.
    fn variance(&self) -> f64 {
        /// Smallest number of pixels whose scatter is a measure of the noise.
        const LEAST_PIXELS: usize = 30;
        if self.pixels < LEAST_PIXELS { 0.0 } else { self.rest() / (self.pixels - 3) as f64 }
    }
}

/// Fit of a streak with the assumed form.
pub struct AssumedForm<'a> {
    pub amplitude: &'a Amplitude,
    /// Seeing that was fitted with this form, arcsec.
    pub seeing_arcsec: f64,
    /// Increase of the sum of the squared residuals at a distance of one sigma from the best fit.
    pub squares_of_sigma: f64,
}

/// Fits amplitude, constant and slope in each block. The template is shifted by `shift` pixels along the minor axis,
/// and the fit extends to the half width of the blocks on both sides of the shifted line. Masked pixels and pixels
/// without a value are omitted.
pub fn fit_blocks(
    band: &Band,
    data: &[f32],
    mask: &[bool],
    template: &[f32],
    shift: isize,
    blocks: &Blocks,
) -> Vec<BlockFit> {
    fit_blocks_where(band, data, |_, at, _| !mask[at], template, shift, blocks)
}

/// Same as [`fit_blocks`], but uses the pixels for which `is_used(column, index, value of the template)` is true.
pub fn fit_blocks_where(
    band: &Band,
    data: &[f32],
    is_used: impl Fn(usize, usize, f32) -> bool,
    template: &[f32],
    shift: isize,
    blocks: &Blocks,
) -> Vec<BlockFit> {
    let (height, half) = (band.height as isize, band.half() as isize);
    let width = blocks.half_width as isize;
    let from = (half + shift - width).clamp(0, height);
    let to = (half + shift + width + 1).clamp(0, height);
    blocks
        .weighted()
        .map(|(columns, of_block)| {
            // Sums of 1, x, x², m, m x, m², d, d x, d m, d².
            let mut sums = [0.0f64; 10];
            for column in columns {
                let start = column as isize * height;
                for offset in from..to {
                    let at = (start + offset) as usize;
                    let value = data[at];
                    let source = offset - shift;
                    let light = if (0..height).contains(&source) { template[(start + source) as usize] } else { 0.0 };
                    if value.is_nan() || !is_used(column, at, light) {
                        continue;
                    }
                    let (x, m, d) = ((offset - half - shift) as f64, f64::from(light), f64::from(value));
                    let terms = [1.0, x, x * x, m, m * x, m * m, d, d * x, d * m, d * d];
                    sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
                }
            }
            let [n, x, xx, m, mx, mm, d, dx, dm, dd] = sums;
            let determinant = n * xx - x * x;
            if n < 8.0 || determinant <= 0.0 {
                return BlockFit::default();
            }
            // Constant and slope of the template and of the data.
            let line =
                |sum: f64, moment: f64| [(xx * sum - x * moment) / determinant, (n * moment - x * sum) / determinant];
            let (of_template, of_data) = (line(m, mx), line(d, dx));
            BlockFit {
                weight: of_block * (mm - of_template[0] * m - of_template[1] * mx).max(0.0),
                signal: of_block * (dm - of_template[0] * d - of_template[1] * dx),
                squares: of_block * (dd - of_data[0] * d - of_data[1] * dx).max(0.0),
                background: of_data,
                response: of_template,
                pixels: n as usize,
            }
        })
        .collect()
}

/// Amplitude over all blocks, with the sum of their weights.
#[derive(Copy, Clone, Debug)]
pub struct Amplitude {
    /// Amplitude.
    pub value: f64,
    /// Sum of the weights; the variance of the amplitude is that of a pixel divided by it.
    pub weight: f64,
    /// Sum of the squared residuals.
    pub squares: f64,
    /// Number of pixels minus number of parameters.
    pub freedom: f64,
}

/// Combines the blocks. `None` if no block has light of the template.
pub fn combined(fits: &[BlockFit]) -> Option<Amplitude> {
    let sum = |of: fn(&BlockFit) -> f64| fits.iter().map(of).sum::<f64>();
    let (weight, signal, squares) = (sum(|fit| fit.weight), sum(|fit| fit.signal), sum(|fit| fit.squares));
    (weight > 0.0).then(|| {
        let pixels: usize = fits.iter().map(|fit| fit.pixels).sum();
        Amplitude {
            value: signal / weight,
            weight,
            squares: (squares - signal * signal / weight).max(0.0),
            freedom: (pixels as f64 - 2.0 * fits.len() as f64 - 1.0).max(1.0),
        }
    })
}

/// Sum of the squared residuals with an amplitude for each block.
pub fn squares_by_block(fits: &[BlockFit]) -> f64 {
    fits.iter().map(BlockFit::rest).sum()
}
