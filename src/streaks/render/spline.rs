//! Splines through nodes in time: a smooth one for positions, and one that does not overshoot for brightness.

/// Returns the slopes at the nodes of the cubic spline with continuous second derivatives. The slope at an end is that
/// of the cubic through the four nearest nodes. With only three or two nodes it is that of the parabola or line through
/// them.
///
/// `times` must increase; both slices have the same length of at least 2.
pub(super) fn smooth_slopes(times: &[f64], values: &[f64]) -> Vec<f64> {
    let count = times.len();
    let step = |i: usize| times[i + 1] - times[i];
    let rise = |i: usize| (values[i + 1] - values[i]) / step(i);
    if count == 2 {
        return vec![rise(0); 2];
    }
    let parabola = |i: usize| (rise(i) * step(i + 1) + rise(i + 1) * step(i)) / (step(i) + step(i + 1));
    if count == 3 {
        let middle = parabola(0);
        return vec![2.0 * rise(0) - middle, middle, 2.0 * rise(1) - middle];
    }
    let first = end_slope(&times[..4], &values[..4], times[0]);
    let last = end_slope(&times[count - 4..], &values[count - 4..], times[count - 1]);
    // de Boor (1978), eq. IV(7), with the slopes s_i, the steps h_i and the mean slopes r_i in the steps:
    // h_i s_(i-1) + 2 (h_(i-1) + h_i) s_i + h_(i-1) s_(i+1) = 3 (h_i r_(i-1) + h_(i-1) r_i)
    let mut slopes = vec![first; count];
    slopes[count - 1] = last;
    let mut upper = vec![0.0; count];
    for i in 1..count - 1 {
        let (before, after) = (step(i - 1), step(i));
        let mut right = 3.0 * (after * rise(i - 1) + before * rise(i));
        if i == count - 2 {
            right -= before * last;
        }
        let pivot = 2.0 * (before + after) - after * upper[i - 1];
        upper[i] = before / pivot;
        slopes[i] = (right - after * slopes[i - 1]) / pivot;
    }
    for i in (1..count - 2).rev() {
        slopes[i] -= upper[i] * slopes[i + 1];
    }
    slopes
}

/// Returns the slope at `time` of the cubic through four nodes.
fn end_slope(times: &[f64], values: &[f64], time: f64) -> f64 {
    let mut sum = 0.0;
    for (j, value) in values.iter().enumerate() {
        let mut slope = 0.0;
        for skipped in (0..4).filter(|skipped| *skipped != j) {
            let others = (0..4).filter(|k| *k != j && *k != skipped);
            let product: f64 = others.map(|k| (time - times[k]) / (times[j] - times[k])).product();
            slope += product / (times[j] - times[skipped]);
        }
        sum += value * slope;
    }
    sum
}

/// Returns the slopes of the smooth spline, limited where it would overshoot (Huynh 1993, SIAM J. Numer. Anal. 30, 57,
/// eq. 3.29: Hyman's rule that preserves smooth extrema). The slopes are also limited so that a cubic between values of
/// at least 0 does not fall below 0.
///
/// `times` must increase; both slices have the same length of at least 2.
pub(super) fn limited_slopes(times: &[f64], values: &[f64]) -> Vec<f64> {
    let count = times.len();
    let step = |i: usize| times[i + 1] - times[i];
    let rise = |i: usize| (values[i + 1] - values[i]) / step(i);
    // Second divided differences; at both ends the neighbouring value is used.
    let bend = |i: usize| {
        let i = i.clamp(1, count - 2);
        (rise(i) - rise(i - 1)) / (step(i - 1) + step(i))
    };
    let mut slopes = smooth_slopes(times, values);
    for (i, slope) in slopes.iter_mut().enumerate() {
        if count > 2 && i > 0 && i + 1 < count {
            let from_left = rise(i - 1) + lesser(bend(i - 1), bend(i)) * step(i - 1);
            let from_right = rise(i) - lesser(bend(i), bend(i + 1)) * step(i);
            let (monotone, smooth) = (lesser(rise(i - 1), rise(i)), lesser(from_left, from_right));
            let most = (3.0 * monotone.abs()).max(1.5 * smooth.abs());
            *slope = lesser(*slope, most.copysign(if monotone == 0.0 { smooth } else { monotone }));
        }
        // The Bézier points next to the node are f + h s / 3 and f - h s / 3; they must not be negative.
        if i + 1 < count {
            *slope = slope.max(-3.0 * values[i] / step(i));
        }
        if i > 0 {
            *slope = slope.min(3.0 * values[i] / step(i - 1));
        }
    }
    slopes
}

/// Returns the number with the smaller absolute value if both have the same sign, otherwise 0.
fn lesser(a: f64, b: f64) -> f64 {
    if a * b <= 0.0 {
        0.0
    } else if a.abs() < b.abs() {
        a
    } else {
        b
    }
}

/// Cubic polynomial between two nodes.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Cubic {
    /// Coefficients of the powers of the time since the first of the two nodes.
    powers: [f64; 4],
}

impl Cubic {
    /// Creates the cubic from the values and slopes at two nodes that are `step` apart.
    pub fn between(values: [f64; 2], slopes: [f64; 2], step: f64) -> Self {
        let rise = (values[1] - values[0]) / step;
        let second = (3.0 * rise - 2.0 * slopes[0] - slopes[1]) / step;
        let third = (slopes[0] + slopes[1] - 2.0 * rise) / (step * step);
        Self { powers: [values[0], slopes[0], second, third] }
    }

    #[inline]
    pub fn at(&self, time: f64) -> f64 {
        let [a, b, c, d] = self.powers;
        a + time * (b + time * (c + time * d))
    }

    #[inline]
    pub fn slope(&self, time: f64) -> f64 {
        let [_, b, c, d] = self.powers;
        b + time * (2.0 * c + time * 3.0 * d)
    }

    /// Returns the integral from 0 to `time`.
    pub fn integral(&self, time: f64) -> f64 {
        let [a, b, c, d] = self.powers;
        time * (a + time * (b / 2.0 + time * (c / 3.0 + time * d / 4.0)))
    }

    /// Returns the Bézier points of the curve between two times. The curve lies between the smallest and the largest of
    /// them.
    pub fn control_points(&self, from: f64, to: f64) -> [f64; 4] {
        let third = (to - from) / 3.0;
        let (first, last) = (self.at(from), self.at(to));
        [first, first + third * self.slope(from), last - third * self.slope(to), last]
    }
}
