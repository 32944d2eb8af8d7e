//! Distortion polynomials (SIP, TPV, TNX, ZPX), from pixels to the projection plane and within that plane.

use super::super::header::Header;
use crate::error::Error;

/// Powers (m, n) of (u, v) in the term PVi_k of TPV, by k; `None` for a radial term: r, r³, r⁵, r⁷.
///
/// Source: registry of FITS conventions, "The TPV world coordinate system". u is the axis i itself, v the other axis.
const TPV_POWERS: [Option<(usize, usize)>; 40] = {
    let mut powers = [None; 40];
    let mut k = 0;
    let mut degree = 0;
    while degree <= 7 {
        let mut n = 0;
        while n <= degree {
            powers[k] = Some((degree - n, n));
            k += 1;
            n += 1;
        }
        // In TPV, the terms of each odd degree are followed by a radial term.
        if degree % 2 == 1 {
            k += 1;
        }
        degree += 1;
    }
    powers
};

/// Highest accepted order of SIP and TNX polynomials.
const HIGHEST_ORDER: usize = 20;

/// Polynomial of shifted and scaled variables.
#[derive(Clone, Debug, PartialEq)]
struct Surface {
    polynomial: Polynomial,
    centre: [f64; 2],
    stretch: [f64; 2],
}

impl Surface {
    fn plain(polynomial: Polynomial) -> Self {
        Self { polynomial, centre: [0.0; 2], stretch: [1.0; 2] }
    }

    fn at(&self, u: f64, v: f64) -> Sloped {
        let [scale_u, scale_v] = self.stretch;
        let inner = self.polynomial.at((u - self.centre[0]) * scale_u, (v - self.centre[1]) * scale_v);
        Sloped { value: inner.value, du: inner.du * scale_u, dv: inner.dv * scale_v }
    }
}

/// Distortion of a plane by two surfaces, which give the new coordinates or the changes of the coordinates.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Distortion {
    surfaces: [Surface; 2],
    adds: bool,
    /// Name of the distortion convention.
    pub kind: &'static str,
}

impl Distortion {
    /// Returns both distorted coordinates with their slopes.
    pub fn at(&self, u: f64, v: f64) -> [Sloped; 2] {
        let mut at = [self.surfaces[0].at(u, v), self.surfaces[1].at(u, v)];
        if self.adds {
            at[0].value += u;
            at[0].du += 1.0;
            at[1].value += v;
            at[1].dv += 1.0;
        }
        at
    }

    /// Reads the SIP coefficients A_p_q and B_p_q, which apply to pixels relative to CRPIX; `None` without A_ORDER and
    /// B_ORDER.
    ///
    /// Shupe et al. (2005, ASP Conf. 347, 491): u' = u + Σ A_pq uᵖ v^q. The coefficients AP and BP, which approximate
    /// the inverse, are not used; the inverse is solved numerically.
    pub fn sip(header: &Header) -> Result<Option<Self>, Error> {
        if !header.contains("A_ORDER") && !header.contains("B_ORDER") {
            return Ok(None);
        }
        let surface = |letter: char| -> Result<Surface, Error> {
            let keyword = format!("{letter}_ORDER");
            let order =
                header.integer(&keyword).ok_or_else(|| Error::invalid(keyword.clone(), "missing", "a number"))?;
            let order = usize::try_from(order)
                .ok()
                .filter(|order| *order <= HIGHEST_ORDER)
                .ok_or_else(|| Error::invalid(keyword, order.to_string(), "an order from 0 to 20"))?;
            let mut polynomial = Polynomial::zero(order);
            for p in 0..=order {
                for q in 0..=order - p {
                    polynomial.add(p, q, header.number(&format!("{letter}_{p}_{q}")).unwrap_or(0.0));
                }
            }
            Ok(Surface::plain(polynomial))
        };
        Ok(Some(Self { surfaces: [surface('A')?, surface('B')?], adds: true, kind: "SIP" }))
    }

    /// Reads the TPV coefficients, in degrees of the projection plane. `longitude_axis` is the number of the right
    /// ascension axis, 0 or 1.
    ///
    /// ξ' = PV1_0 + PV1_1 ξ + PV1_2 η + PV1_3 r + PV1_4 ξ² + ...; η' is the same with PV2 and with ξ and η exchanged.
    /// The default of PVi_1 is 1.
    pub fn tpv(header: &Header, longitude_axis: usize) -> Self {
        let surface = |axis: usize, is_longitude: bool| {
            let mut polynomial = Polynomial::zero(1);
            let mut radius = 0;
            for (k, powers) in TPV_POWERS.iter().enumerate() {
                let default = if k == 1 { 1.0 } else { 0.0 };
                let coefficient = header.number(&format!("PV{}_{k}", axis + 1)).unwrap_or(default);
                match *powers {
                    None => {
                        polynomial.add_radial(radius, coefficient);
                        radius += 1;
                    }
                    Some(_) if coefficient == 0.0 => {}
                    Some((m, n)) if is_longitude => polynomial.add(m, n, coefficient),
                    Some((m, n)) => polynomial.add(n, m, coefficient),
                }
            }
            Surface::plain(polynomial)
        };
        let latitude_axis = 1 - longitude_axis;
        Self { surfaces: [surface(longitude_axis, true), surface(latitude_axis, false)], adds: false, kind: "TPV" }
    }

    /// Reads IRAF's surfaces `lngcor` and `latcor`, which are added in degrees of the projection plane; `None` if both
    /// are missing.
    ///
    /// Source: F. Valdes and L. Davis, "The TNX world coordinate system" (registry of FITS conventions).
    pub fn iraf(longitude: &str, latitude: &str, kind: &'static str) -> Result<Option<Self>, Error> {
        let read = |words: &str, name: &str| {
            match attribute(words, name) {
            Some(numbers) => surface_of(&numbers).map(Some).ok_or_else(|| Error::invalid("WATj_nnn".to_owned(), format!("{name} = {numbers:?}"), "the numbers of a surface: type (1 Chebyshev, 2 Legendre, 3 plain), orders, cross terms, limits, coefficients")),
            None => Ok(None),
        }
        };
        let surfaces = [read(longitude, "lngcor")?, read(latitude, "latcor")?];
        let none = || Surface::plain(Polynomial::zero(0));
        Ok(match surfaces {
            [None, None] => None,
            [u, v] => Some(Self { surfaces: [u.unwrap_or_else(none), v.unwrap_or_else(none)], adds: true, kind }),
        })
    }
}

/// Returns the value of `name = value` or `name = "value"` in a text of IRAF attributes.
pub(super) fn attribute(words: &str, name: &str) -> Option<String> {
    let start = words
        .match_indices(name)
        .find(|(at, _)| words[..*at].ends_with(|c: char| c.is_whitespace() || c == '"') || *at == 0)?
        .0;
    let rest = words[start + name.len()..].trim_start().strip_prefix('=')?.trim_start();
    match rest.strip_prefix('"') {
        Some(quoted) => Some(quoted.split('"').next().unwrap_or_default().trim().to_owned()),
        None => rest.split_whitespace().next().map(str::to_owned),
    }
}

/// Parses a surface in IRAF's form: type, orders in ξ and η, kind of cross terms (0 none, 1 full, 2 half), limits of ξ
/// and η, coefficients.
fn surface_of(numbers: &str) -> Option<Surface> {
    let numbers: Vec<f64> = numbers.split_whitespace().map(|word| word.parse().ok()).collect::<Option<_>>()?;
    let [kind, order_u, order_v, cross, from_u, to_u, from_v, to_v, ref coefficients @ ..] = numbers[..] else {
        return None;
    };
    let order = |number: f64| {
        (number.fract() == 0.0 && (1.0..=HIGHEST_ORDER as f64).contains(&number)).then_some(number as usize)
    };
    let (order_u, order_v) = (order(order_u)?, order(order_v)?);
    let is_plain = kind == 3.0;
    if !is_plain && (to_u <= from_u || to_v <= from_v) {
        return None;
    }
    let basis_u = basis(kind, order_u)?;
    let basis_v = basis(kind, order_v)?;
    let highest = order_u.max(order_v);
    let is_there = |m: usize, n: usize| match cross as i64 {
        0 => m == 0 || n == 0,
        2 => m + n < highest,
        _ => true,
    };
    let mut polynomial = Polynomial::zero(highest - 1);
    let mut rest = coefficients.iter();
    for (n, of_v) in basis_v.iter().enumerate() {
        for (_, of_u) in basis_u.iter().enumerate().filter(|(m, _)| is_there(*m, n)) {
            let coefficient = rest.next()?;
            for (power_v, c_v) in of_v.iter().enumerate() {
                for (power_u, c_u) in of_u.iter().enumerate() {
                    polynomial.add(power_u, power_v, coefficient * c_u * c_v);
                }
            }
        }
    }
    if is_plain {
        return Some(Surface::plain(polynomial));
    }
    // ξn = (2ξ - (ξmax + ξmin)) / (ξmax - ξmin)
    let centre = [(from_u + to_u) / 2.0, (from_v + to_v) / 2.0];
    Some(Surface { polynomial, centre, stretch: [2.0 / (to_u - from_u), 2.0 / (to_v - from_v)] })
}

/// Returns the first `count` polynomials of a kind as coefficients of powers: 1 Chebyshev, 2 Legendre, 3 plain powers.
fn basis(kind: f64, count: usize) -> Option<Vec<Vec<f64>>> {
    let mut basis: Vec<Vec<f64>> = vec![vec![1.0], vec![0.0, 1.0]];
    for n in 1..count.saturating_sub(1) {
        let order = n as f64;
        // P_{n+1} = a x P_n - b P_{n-1}
        let (a, b) = match kind as i64 {
            1 => (2.0, 1.0),
            2 => ((2.0 * order + 1.0) / (order + 1.0), order / (order + 1.0)),
            3 => (1.0, 0.0),
            _ => return None,
        };
        let mut next = vec![0.0; n + 2];
        for (power, c) in basis[n].iter().enumerate() {
            next[power + 1] += a * c;
        }
        for (power, c) in basis[n - 1].iter().enumerate() {
            next[power] -= b * c;
        }
        basis.push(next);
    }
    basis.truncate(count);
    [1.0, 2.0, 3.0].contains(&kind).then_some(basis)
}

/// Number of radial terms of TPV: r, r³, r⁵, r⁷.
const RADIAL_TERMS: usize = 4;

/// Sum of terms c·uᵐ·vⁿ, and of odd powers of the radius √(u² + v²).
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Polynomial {
    /// Row n contains the coefficients of uᵐ·vⁿ by m; all rows have the length of the first.
    rows: Vec<Vec<f64>>,
    /// Coefficients of r, r³, r⁵, r⁷; empty if none is given.
    radial: Vec<f64>,
}

/// Value of a function of two variables, with its slopes along both.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub(super) struct Sloped {
    /// The value.
    pub value: f64,
    /// ∂/∂u.
    pub du: f64,
    /// ∂/∂v.
    pub dv: f64,
}

impl Polynomial {
    /// Creates a polynomial of zeros with powers up to `order` of each variable.
    pub fn zero(order: usize) -> Self {
        Self { rows: vec![vec![0.0; order + 1]; order + 1], radial: Vec::new() }
    }

    /// Adds to the coefficient of uᵐ·vⁿ and raises the order if necessary.
    pub fn add(&mut self, m: usize, n: usize, coefficient: f64) {
        let order = self.rows.len().max(m + 1).max(n + 1);
        self.rows.resize(order, Vec::new());
        for row in &mut self.rows {
            row.resize(order, 0.0);
        }
        self.rows[n][m] += coefficient;
    }

    /// Adds to the coefficient of r^(2k+1), for k from 0 to 3.
    pub fn add_radial(&mut self, k: usize, coefficient: f64) {
        if coefficient != 0.0 {
            self.radial.resize(RADIAL_TERMS.max(k + 1), 0.0);
            self.radial[k] += coefficient;
        }
    }

    /// Returns the value and the slopes, by Horner's rule in both variables.
    pub fn at(&self, u: f64, v: f64) -> Sloped {
        let mut sum = Sloped::default();
        for row in self.rows.iter().rev() {
            let (mut value, mut slope) = (0.0, 0.0);
            for coefficient in row.iter().rev() {
                slope = slope * u + value;
                value = value * u + coefficient;
            }
            sum.dv = sum.dv * v + sum.value;
            sum.value = sum.value * v + value;
            sum.du = sum.du * v + slope;
        }
        if !self.radial.is_empty() {
            let square = u * u + v * v;
            let r = square.sqrt();
            // Σ c r^(2k+1), and its slope along r: Σ (2k+1) c r^(2k). At the centre, r has no slopes along u and v, so
            // they are omitted.
            let (mut value, mut slope) = (0.0, 0.0);
            for (k, coefficient) in self.radial.iter().enumerate().rev() {
                value = value * square + coefficient;
                slope = slope * square + (2 * k + 1) as f64 * coefficient;
            }
            sum.value += value * r;
            if r > 0.0 {
                sum.du += slope * u / r;
                sum.dv += slope * v / r;
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_powers_of_tpv() {
        // From the table of the convention.
        for (k, powers) in [
            (0, Some((0, 0))),
            (2, Some((0, 1))),
            (3, None),
            (5, Some((1, 1))),
            (8, Some((2, 1))),
            (11, None),
            (12, Some((4, 0))),
            (16, Some((0, 4))),
            (22, Some((0, 5))),
            (23, None),
            (24, Some((6, 0))),
            (31, Some((7, 0))),
            (38, Some((0, 7))),
            (39, None),
        ] {
            assert_eq!(TPV_POWERS[k], powers, "{k}");
        }
    }

    #[test]
    fn verif_bases() {
        assert_eq!(basis(1.0, 4).unwrap()[3], [0.0, -3.0, 0.0, 4.0]);
        assert_eq!(basis(2.0, 3).unwrap()[2], [-0.5, 0.0, 1.5]);
        assert_eq!(basis(3.0, 3).unwrap()[2], [0.0, 0.0, 1.0]);
        assert_eq!(basis(3.0, 1).unwrap().len(), 1);
        assert_eq!(basis(4.0, 3), None);
    }

    #[test]
    fn verif_attributes_of_iraf() {
        let words = "wtype=zpx axtype=ra projp0=0. projp1=1. lngcor = \"3. 1. 1. 2. 0. 1. 0. 1. 0.5 \"";
        assert_eq!(attribute(words, "projp1").as_deref(), Some("1."));
        assert_eq!(attribute(words, "wtype").as_deref(), Some("zpx"));
        assert_eq!(attribute(words, "latcor"), None);
        let surface = surface_of(&attribute(words, "lngcor").unwrap()).unwrap();
        assert_eq!(surface.at(0.3, 0.4).value, 0.5);
        assert_eq!(surface_of("3. 2. 2. 2. 0. 1. 0. 1. 0.5"), None);
    }

    #[test]
    fn verif_slopes_are_those_of_the_values() {
        let mut polynomial = Polynomial::zero(1);
        for (m, n, c) in [(0, 0, 0.3), (1, 0, 1.1), (0, 1, -0.2), (2, 1, 0.07), (0, 3, -0.4), (4, 1, 0.9)] {
            polynomial.add(m, n, c);
        }
        polynomial.add_radial(0, 0.05);
        polynomial.add_radial(2, -0.3);
        let direct = |u: f64, v: f64| {
            let r = u.hypot(v);
            0.3 + 1.1 * u - 0.2 * v + 0.07 * u * u * v - 0.4 * v.powi(3) + 0.9 * u.powi(4) * v + 0.05 * r
                - 0.3 * r.powi(5)
        };
        let (u, v, h) = (0.7, -0.4, 1e-6);
        let at = polynomial.at(u, v);
        assert!((at.value - direct(u, v)).abs() < 1e-15);
        // Central differences are accurate to h² and to rounding errors over h.
        assert!((at.du - (direct(u + h, v) - direct(u - h, v)) / (2.0 * h)).abs() < 1e-9);
        assert!((at.dv - (direct(u, v + h) - direct(u, v - h)) / (2.0 * h)).abs() < 1e-9);
    }
}
