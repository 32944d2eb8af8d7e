//! Convex polygons.

/// Calls `keep` with the corners of the part of a convex polygon in which a linear function is not negative, in order
/// (Sutherland and Hodgman 1974).
pub(crate) fn clip(corners: &[[f64; 2]], inside: impl Fn([f64; 2]) -> f64, mut keep: impl FnMut([f64; 2])) {
    for (&a, &b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        let (from, to) = (inside(a), inside(b));
        if from >= 0.0 {
            keep(a);
        }
        if (from >= 0.0) != (to >= 0.0) {
            let t = from / (from - to);
            keep([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
        }
    }
}
