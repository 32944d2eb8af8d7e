//! HEALPix pixels in RING order: number of pixels, centre of a pixel, and the pixel that contains a direction.
//!
//! Source: Górski et al. (2005, ApJ 622, 759). In RING order pixels are counted along rings of equal latitude from the
//! north pole to the south pole, so that the northern hemisphere is a contiguous range of numbers.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Largest supported nside, with 12 × 1024² pixels of 3.4 arcmin.
pub const MOST_NSIDE: u32 = 1024;

/// Returns the number of pixels of the whole sphere, 12 nside².
pub const fn cell_count(nside: u32) -> u64 {
    12 * nside as u64 * nside as u64
}

/// Returns the number of pixels with centres on or north of the equator. These are the first pixels in RING order.
pub const fn northern_cell_count(nside: u32) -> u64 {
    // Half of all pixels, and half of the 4 nside pixels of the equatorial ring.
    cell_count(nside) / 2 + 2 * nside as u64
}

/// A ring of equally spaced pixels at one latitude.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Ring {
    /// Number of pixels.
    pub count: u32,
    /// Longitude of the centre of the first pixel, radians.
    pub first_rad: f64,
    /// Latitude of the centres of the pixels, [0, π/2), radians.
    pub latitude_rad: f64,
}

/// Returns the rings from the north pole to the equator, the equatorial ring included, in RING order. The southern
/// rings are their mirror images.
pub fn northern_rings(nside: u32) -> impl Iterator<Item = Ring> {
    let n = f64::from(nside);
    (1..=2 * nside).map(move |ring| {
        let i = f64::from(ring);
        // Polar cap: 4 i pixels, 1 - sin b = i² / (3 N²) = 2 sin²(θ/2).    eq. 4
        // Equatorial belt: 4 N pixels, sin b = 4/3 - 2 i / (3 N).          eq. 8
        let (count, latitude_rad) = if ring < nside {
            (4 * ring, FRAC_PI_2 - 2.0 * (i / (n * 6_f64.sqrt())).asin())
        } else {
            (4 * nside, ((2.0 * n - i) / (1.5 * n)).asin())
        };
        // In the caps and in every other ring of the belt, the first pixel is half a step from longitude 0. eqs. 5, 9
        let is_half = ring < nside || (ring - nside).is_multiple_of(2);
        let first_rad = if is_half { PI / f64::from(count) } else { 0.0 };
        Ring { count, first_rad, latitude_rad }
    })
}

/// Returns longitude in [0, 2π) and latitude of the centre of a pixel, radians; `None` for an invalid pixel number.
pub fn ring_centre_rad(nside: u32, cell: u64) -> Option<(f64, f64)> {
    ((1..=MOST_NSIDE).contains(&nside) && cell < cell_count(nside)).then(|| cdshealpix::ring::center(nside, cell))
}

/// Returns the number of the pixel that contains a direction. The longitude may be any finite angle, the latitude must
/// be in [-π/2, π/2], radians. `None` for other angles or an unsupported nside.
pub fn ring_cell(nside: u32, longitude_rad: f64, latitude_rad: f64) -> Option<u64> {
    let is_sound = (1..=MOST_NSIDE).contains(&nside) && longitude_rad.is_finite() && latitude_rad.abs() <= FRAC_PI_2;
    is_sound.then(|| cdshealpix::ring::hash(nside, longitude_rad.rem_euclid(TAU), latitude_rad))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// healpy 1.20.1: `healpy.pix2ang(nside, cell, lonlat=True)`, degrees, 2026-11-21.
    const HEALPY: &[(u32, u64, f64, f64)] = &[
        (1, 0, 45.0, 41.810_314_895_778_59),
        (1, 4, 0.0, 0.0),
        (2, 11, 337.5, 41.810_314_895_778_59),
        (64, 0, 45.0, 89.269_029_291_573_9),
        (64, 12_345, 260.859_375, 29.999_999_999_999_993),
        (64, 24_448, 0.703_125, 0.0),
        (64, 49_151, 315.0, -89.269_029_291_573_9),
    ];

    #[test]
    fn valid_centres_against_healpy() {
        for &(nside, cell, longitude_deg, latitude_deg) in HEALPY {
            let (longitude, latitude) = ring_centre_rad(nside, cell).unwrap();
            assert!((longitude.to_degrees() - longitude_deg).abs() < 1e-11, "{nside} {cell}: {longitude}");
            assert!((latitude.to_degrees() - latitude_deg).abs() < 1e-11, "{nside} {cell}: {latitude}");
        }
        assert_eq!(ring_centre_rad(64, cell_count(64)), None);
        assert_eq!(ring_centre_rad(0, 0), None);
    }

    #[test]
    fn valid_rings_against_healpy() {
        let mut found = 0;
        for &(nside, cell, longitude_deg, latitude_deg) in HEALPY {
            let mut first_cell = 0;
            for ring in northern_rings(nside) {
                if (first_cell..first_cell + u64::from(ring.count)).contains(&cell) {
                    let step = TAU / f64::from(ring.count) * (cell - first_cell) as f64;
                    assert!(((ring.first_rad + step).to_degrees() - longitude_deg).abs() < 1e-11, "{nside} {cell}");
                    assert!((ring.latitude_rad.to_degrees() - latitude_deg).abs() < 1e-11, "{nside} {cell}");
                    found += 1;
                }
                first_cell += u64::from(ring.count);
            }
            assert_eq!(first_cell, northern_cell_count(nside));
        }
        assert_eq!(found, 6);
    }

    #[test]
    fn verif_the_north_comes_first() {
        for nside in [1, 2, 3, 7, 64] {
            let latitude = |cell| ring_centre_rad(nside, cell).unwrap().1;
            let north = northern_cell_count(nside);
            assert!((0..north).all(|cell| latitude(cell) >= 0.0), "{nside}");
            assert!((north..cell_count(nside)).all(|cell| latitude(cell) < 0.0), "{nside}");
        }
    }
}
