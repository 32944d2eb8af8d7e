//! Sixteen neighbouring pixels of a row: light in each of them, or in four and along the cubic through these.

/// Pixels at a time.
pub(super) const LANES: usize = 16;

/// Columns of all of them, from the first.
pub(super) const EACH: [f32; LANES] = {
    let mut columns = [0.0; LANES];
    let mut lane = 0;
    while lane < LANES {
        columns[lane] = lane as f32;
        lane += 1;
    }
    columns
};

/// Columns of four, evenly spaced, the first and the last among them.
pub(super) const FOUR: [f32; 4] = [0.0, 5.0, 10.0, 15.0];
const _: () = assert!(FOUR[3] == EACH[LANES - 1]);

/// Lagrange's weights of the four in each pixel: Π_(k≠j) (x - x_k) / (x_j - x_k).
const WEIGHTS: [[f32; LANES]; 4] = {
    let mut weights = [[1.0; LANES]; 4];
    let (mut node, mut lane, mut other) = (0, 0, 0);
    while node < 4 {
        if other != node {
            weights[node][lane] *= (EACH[lane] - FOUR[other]) / (FOUR[node] - FOUR[other]);
        }
        other += 1;
        if other == 4 {
            (other, lane) = (0, lane + 1);
        }
        if lane == LANES {
            (lane, node) = (0, node + 1);
        }
    }
    weights
};

/// Light in all pixels from that in the four.
#[inline(always)]
pub(super) fn through(four: [f32; 4]) -> [f32; LANES] {
    let mut light = [0.0; LANES];
    for (value, weights) in four.iter().zip(&WEIGHTS) {
        for lane in 0..LANES {
            light[lane] += value * weights[lane];
        }
    }
    light
}

/// What each of four evenly spaced rows has to do with one that lies so many rows after the first.
#[inline(always)]
pub(super) fn weights(place: usize) -> [f32; 4] {
    WEIGHTS.map(|weights| weights[place])
}

/// Adds light to the pixels that there are, at most [`LANES`].
#[inline(always)]
pub(super) fn add(light: &[f32; LANES], pixels: &mut [f32]) {
    if let Ok(whole) = <&mut [f32; LANES]>::try_from(&mut *pixels) {
        for lane in 0..LANES {
            whole[lane] += light[lane];
        }
    } else {
        for (pixel, value) in pixels.iter_mut().zip(light) {
            *pixel += value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_goes_through_its_four_pixels() {
        let cubic = |x: f32| 1.0 + x * (0.5 + x * (-0.25 + x * 0.01));
        let light = through(FOUR.map(cubic));
        for (lane, found) in light.iter().enumerate() {
            assert!((found - cubic(lane as f32)).abs() < 1e-4, "{lane}: {found}");
        }
        let mut few = [1.0; 3];
        add(&light, &mut few);
        assert_eq!(few, [1.0 + light[0], 1.0 + light[1], 1.0 + light[2]]);
    }
}
