//! Where light is so even that over some pixels of a row it is a cubic.

/// Length over which it is to be one, pixels.
pub(super) const EVEN_PIX: f64 = 15.0;

/// What may be wrong, of the peak of a long line.
const TOLERANCE: f64 = 2e-6;

/// The least distance from which on light over [`EVEN_PIX`] is the cubic through four evenly spaced points; infinite where it never is.
///
/// `light` gives some values, each of which is to be even, for a distance and a way of up to [`EVEN_PIX`] from it; `peak` is that of a long line.
pub(super) fn even_from<const N: usize>(reach_pix: f64, peak: f64, light: impl Fn(f64, f64) -> [f64; N]) -> f64 {
    let is_even = |nearest: f64| {
        let nodes: [[f64; N]; 4] = std::array::from_fn(|node| light(nearest, EVEN_PIX * node as f64 / 3.0));
        // Half way between the nodes, where a cubic errs most.
        [0.5, 1.5, 2.5].into_iter().all(|place| {
            let weights = super::curve::cubic(place);
            let truth = light(nearest, EVEN_PIX * place / 3.0);
            (0..N).all(|k| {
                let found: f64 = weights.iter().zip(&nodes).map(|(weight, node)| weight * node[k]).sum();
                (found - truth[k]).abs() <= TOLERANCE * peak
            })
        })
    };
    // From the outside in: wings become smoother and fainter outwards.
    let mut from = f64::INFINITY;
    let mut nearest = reach_pix - EVEN_PIX;
    while nearest > 1.0 && is_even(nearest) {
        from = nearest;
        nearest *= 0.93;
    }
    from
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steeper_wings_are_even_farther_out_and_cubics_everywhere() {
        let wing = |power: i32| move |nearest: f64, x: f64| [(1.0 + (nearest + x) / 2.0).powi(-power)];
        let [gentle, steep] = [3, 4].map(|power| even_from(100.0, 1.0, wing(power)));
        assert!(gentle > steep && steep > 5.0 && gentle < 40.0, "{gentle} {steep}");
        assert!(even_from(100.0, 1.0, |nearest, x| [(nearest + x).powi(3)]) < 2.0);
        assert_eq!(even_from(100.0, 1.0, |nearest, x| [0.0, (nearest + x).sin()]), f64::INFINITY);
        assert_eq!(even_from(12.0, 1.0, wing(3)), f64::INFINITY);
    }
}
