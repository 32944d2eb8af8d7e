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
}

impl Blocks {
    /// Divides a band into blocks of about `length` columns.
    pub fn new(columns: usize, length: usize, half_width: usize) -> Self {
        let count = (columns / length.max(1)).max(1);
        Self { bounds: (0..=count).map(|block| block * columns / count).collect(), half_width }
    }

    /// Returns the ranges of columns.
    pub fn ranges(&self) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
        self.bounds.windows(2).map(|pair| pair[0]..pair[1])
    }
}

/// Fit of a block: its light after projection on the template without constant and slope.
#[derive(Copy, Clone, Debug, Default)]
pub struct BlockFit {
    /// Σ m'², the weight of the amplitude; m' is the template minus its fit by a constant and a slope.
    pub weight: f64,
    /// Σ m' d.
    pub signal: f64,
    /// Σ d'², the light that constant and slope leave.
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
    let (height, half) = (band.height as isize, band.half() as isize);
    let width = blocks.half_width as isize;
    let from = (half + shift - width).clamp(0, height);
    let to = (half + shift + width + 1).clamp(0, height);
    blocks
        .ranges()
        .map(|columns| {
            // Sums of 1, x, x², m, m x, m², d, d x, d m, d².
            let mut sums = [0.0f64; 10];
            for column in columns {
                let start = column as isize * height;
                for offset in from..to {
                    let at = (start + offset) as usize;
                    let value = data[at];
                    if mask[at] || value.is_nan() {
                        continue;
                    }
                    let source = offset - shift;
                    let light = if (0..height).contains(&source) { template[(start + source) as usize] } else { 0.0 };
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
                weight: (mm - of_template[0] * m - of_template[1] * mx).max(0.0),
                signal: dm - of_template[0] * d - of_template[1] * dx,
                squares: (dd - of_data[0] * d - of_data[1] * dx).max(0.0),
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
    let of = |fit: &BlockFit| fit.squares - if fit.weight > 0.0 { fit.signal * fit.signal / fit.weight } else { 0.0 };
    fits.iter().map(of).sum()
}
