//! Minimum of a function of one variable.

/// Largest number of steps. This many golden-section steps shrink the interval by a factor of 10¹⁰.
const MOST_STEPS: usize = 48;

/// (3 - √5)/2: the smaller part of an interval divided by the golden section.
const GOLDEN: f64 = 0.381_966_011_250_105_1;

/// Returns the position and value of a minimum in an interval. The search starts from a point in the interval, whose
/// value is given.
///
/// Brent's method (1973, Algorithms for Minimization without Derivatives, chapter 5) goes to the vertex of the parabola
/// through the three best points if the previous steps were small enough, otherwise it makes a golden-section step. If
/// the function has a single minimum, the position is accurate to two tolerances, and the value is the lowest one
/// evaluated. Values that are not finite are treated as larger than all others. If the start is an end of the interval
/// and the function rises from there, the start is returned.
pub fn minimum(
    mut function: impl FnMut(f64) -> f64,
    [mut low, mut high]: [f64; 2],
    start: (f64, f64),
    tolerance: f64,
) -> (f64, f64) {
    let mut best = start;
    let (is_low, is_high) = (best.0 - low <= tolerance, high - best.0 <= tolerance);
    if is_low || is_high {
        let inward = best.0 + if is_low { tolerance } else { -tolerance };
        let value = function(inward);
        if (is_low && is_high) || value >= best.1 || value.is_nan() {
            return best;
        }
        best = (inward, value);
    }
    let (mut second, mut third) = (best, best);
    // The last step, and the step before it.
    let (mut step, mut earlier) = (0.0_f64, 0.0_f64);
    for _ in 0..MOST_STEPS {
        let middle = 0.5 * (low + high);
        if (best.0 - middle).abs() + 0.5 * (high - low) <= 2.0 * tolerance {
            break;
        }
        // From the best point to the vertex of the parabola: -p / q
        let r = (best.0 - second.0) * (best.1 - third.1);
        let q = (best.0 - third.0) * (best.1 - second.1);
        let vertex = -((best.0 - third.0) * q - (best.0 - second.0) * r) / (2.0 * (q - r));
        let is_within = low < best.0 + vertex && best.0 + vertex < high;
        if vertex.abs() < 0.5 * earlier.abs() && is_within {
            (step, earlier) = (vertex, step);
            let x = best.0 + step;
            if x - low < 2.0 * tolerance || high - x < 2.0 * tolerance {
                step = tolerance.copysign(middle - best.0);
            }
        } else {
            earlier = if best.0 < middle { high - best.0 } else { low - best.0 };
            step = GOLDEN * earlier;
        }
        let x = best.0 + if step.abs() < tolerance { tolerance.copysign(step) } else { step };
        let tried = (x, function(x));
        if tried.1 <= best.1 {
            if tried.0 < best.0 {
                high = best.0
            } else {
                low = best.0
            }
            (third, second, best) = (second, best, tried);
        } else {
            if tried.0 < best.0 {
                low = tried.0
            } else {
                high = tried.0
            }
            if tried.1 <= second.1 || second.0 == best.0 {
                (third, second) = (second, tried);
            } else if tried.1 <= third.1 || third.0 == best.0 || third.0 == second.0 {
                third = tried;
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Position, value, and number of evaluations.
    fn searched(function: impl Fn(f64) -> f64, ends: [f64; 2], start: f64, tolerance: f64) -> (f64, f64, usize) {
        let mut evaluations = 0;
        let counted = |x: f64| {
            evaluations += 1;
            function(x)
        };
        let (x, value) = minimum(counted, ends, (start, function(start)), tolerance);
        assert_eq!(value, function(x));
        (x, value, evaluations)
    }

    #[test]
    fn verif_smooth_minima_take_few_steps() {
        for (start, least) in [(0.3, 0.7), (1.0, 0.7), (0.69, 0.7), (1.9, 1.2)] {
            let (x, _, evaluations) = searched(|x| (x - least).powi(2) * (1.0 + 0.1 * x), [0.0, 2.0], start, 1e-5);
            // The minimum is at the vertex of the square: the other factor has no effect where the square is 0.
            assert!((x - least).abs() <= 2e-5 && evaluations <= 12, "{start}: {x} in {evaluations}");
        }
        // Golden sections alone would take 22 steps.
        let (x, _, evaluations) = searched(|x| -(x - 0.9_f64).cos(), [0.0, 2.0], 1.0, 5e-5);
        assert!((x - 0.9).abs() <= 1e-4 && evaluations <= 8, "{x} in {evaluations}");
    }

    #[test]
    fn verif_ends_and_minima_next_to_them_are_found_at_once() {
        assert_eq!(searched(|x| x, [1.0, 2.0], 1.0, 1e-4), (1.0, 1.0, 1));
        assert_eq!(searched(|x| -x, [1.0, 2.0], 2.0, 1e-4), (2.0, -2.0, 1));
        // No space between the ends.
        assert_eq!(searched(|x| -x, [1.0, 1.0], 1.0, 1e-4).0, 1.0);
        let (x, ..) = searched(|x| (x - 1.02).powi(2), [1.0, 2.0], 1.0, 1e-4);
        assert!((x - 1.02).abs() <= 2e-4, "{x}");
    }

    #[test]
    fn verif_kinks_and_points_without_a_value_are_handled() {
        let (x, ..) = searched(|x| (x - 0.31).abs(), [0.0, 1.0], 0.5, 1e-6);
        assert!((x - 0.31).abs() <= 2e-6, "{x}");
        // An edge of a shadow: behind it the magnitude is infinite, the brightest point is in front of it.
        for dark in [f64::INFINITY, f64::NAN] {
            let (x, ..) = searched(|x| if x < 0.62 { -x } else { dark }, [0.0, 1.0], 0.5, 1e-6);
            assert!((0.0..=2e-6).contains(&(0.62 - x)), "{x}");
        }
        let (x, value, evaluations) = searched(|_| 3.0, [0.0, 1.0], 0.5, 1e-4);
        assert!((0.0..=1.0).contains(&x) && value == 3.0 && evaluations <= MOST_STEPS);
    }
}
