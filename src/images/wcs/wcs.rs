//! Pixels to the sky and back.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

use crate::frames::{Direction, Gcrs};

use super::super::card::Card;
use super::super::header::Header;
use super::error::WcsError;
use super::header_terms::HeaderTerms;
use super::projection::NativePole;
use super::projection::Projection;
use crate::images::plane::PixelPosition;

/// Arcseconds in a radian.
const ARCSEC: f64 = 648_000.0 / std::f64::consts::PI;

/// Frames are trusted this far beyond their edges in any case where the distortion allows it, pixels.
const LEAST_MARGIN_PIX: f64 = 1000.0;

/// Size of a frame whose header does not know it, pixels.
const UNKNOWN_SIDE_PIX: usize = 4096;

/// Points along each side of a frame at which a distortion is looked at for folds.
const FOLD_GRID: usize = 13;

/// How much of the slope at the centre the slopes elsewhere must keep, so that no two pixels have one place.
const LEAST_SLOPE: f64 = 0.1;

/// The part of the margin that is tried where the whole of it folds.
const MARGINS: [f64; 6] = [1.0, 0.5, 0.25, 0.1, 0.03, 0.0];

/// Newton's method ends here, pixels.
const CLOSE_PIX: f64 = 1e-11;

/// Steps of Newton's method; three or four are usual.
const MOST_STEPS: usize = 25;

/// What places the pixels of one frame on the sky: ICRS, directions as seen from the barycentre's axes ([`Gcrs`]).
///
/// Read from a header by [`from_header`](Wcs::from_header) or made by [`tangent`](Wcs::tangent). FK5 of equinox 2000 is taken as ICRS: they differ
/// by 0.02 arcsec. Where the frame is distorted by a polynomial, places are given within the frame and a margin around it alone (its own size, or 1000
/// pixels, less where the polynomial folds): further out polynomials bend back, and a satellite far away would appear in the frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Wcs {
    terms: HeaderTerms,
    /// Pixels to degrees of the plane.
    matrix: Matrix2<f64>,
    inverse: Matrix2<f64>,
    to_sky: Matrix3<f64>,
    size: [usize; 2],
    trusted: Option<Trusted>,
}

/// Where a distorted frame has one place for each pixel and one pixel for each place.
#[derive(Clone, Debug, PartialEq)]
struct Trusted {
    /// Smallest and largest coordinates, pixels from CRPIX.
    low: Vector2<f64>,
    high: Vector2<f64>,
    /// The frame's centre, its place in the plane, and the inverse of the slopes there: where Newton's method begins.
    centre: Vector2<f64>,
    plane_centre: Vector2<f64>,
    inverse_slopes: Matrix2<f64>,
}

impl Wcs {
    /// From the cards of a header.
    ///
    /// # Errors
    /// [`WcsError`] where there are no celestial axes, a number is missing or impossible, the projection or the system of axes is not read, the matrix has
    /// no inverse, or the distortion folds within the frame.
    pub fn from_header(header: &Header) -> Result<Self, WcsError> {
        Self::from_terms(HeaderTerms::from_header(header)?)
    }

    /// A gnomonic frame for what is simulated: `centre` falls on the middle of `columns` by `rows` pixels of `scale_arcsec`.
    ///
    /// Without rotation north is up (rows grow northwards) and east to the left (columns grow westwards). `rotation_rad` turns the sky: the position
    /// angle, north through east, of the direction in which rows grow.
    pub fn tangent(
        centre: Direction<Gcrs>,
        scale_arcsec: f64,
        rotation_rad: f64,
        columns: usize,
        rows: usize,
    ) -> Result<Self, WcsError> {
        let scale_deg = scale_arcsec / 3600.0;
        let (sine, cosine) = rotation_rad.sin_cos();
        Self::from_terms(HeaderTerms {
            longitude_axis: 0,
            reference_pixel: [(columns as f64 + 1.0) / 2.0, (rows as f64 + 1.0) / 2.0],
            matrix_deg: [[-scale_deg * cosine, scale_deg * sine], [scale_deg * sine, scale_deg * cosine]],
            pixel_distortion: None,
            plane_distortion: None,
            projection: Projection::Tan,
            pole: NativePole {
                right_ascension_deg: centre.longitude_rad().to_degrees(),
                declination_deg: centre.latitude_rad().to_degrees(),
                lonpole_deg: Some(180.0),
                latpole_deg: None,
                is_zenithal: true,
            },
            size: Some([columns, rows]),
        })
    }

    fn from_terms(terms: HeaderTerms) -> Result<Self, WcsError> {
        let [[a, b], [c, d]] = terms.matrix_deg;
        let matrix = Matrix2::new(a, b, c, d);
        let inverse = matrix
            .try_inverse()
            .filter(|inverse| inverse.iter().all(|entry| entry.is_finite()))
            .ok_or(WcsError::Singular(terms.matrix_deg))?;
        let to_sky = terms.pole.to_sky().ok_or_else(|| WcsError::Value {
            keyword: "LONPOLE".to_owned(),
            value: format!("{:?} with LATPOLE {:?}", terms.pole.lonpole_deg, terms.pole.latpole_deg),
            allowed: "a native pole that CRVAL can have",
        })?;
        let size = terms.size.unwrap_or([UNKNOWN_SIDE_PIX; 2]);
        let mut wcs = Self { terms, matrix, inverse, to_sky, size, trusted: None };
        if let Some(kind) = wcs.distortion() {
            wcs.trusted = Some(wcs.trusted_area().ok_or(WcsError::Folded { kind })?);
        }
        Ok(wcs)
    }

    /// The distortion's kind (SIP, TPV, TNX, ZPX), if there is one.
    pub fn distortion(&self) -> Option<&'static str> {
        let terms = &self.terms;
        terms.pixel_distortion.as_ref().or(terms.plane_distortion.as_ref()).map(|distortion| distortion.kind)
    }

    /// Columns and rows of the frame as the header says; 4096 each where it does not.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// The direction of a place in the frame; `None` where the projection has no answer, or far outside of a distorted frame.
    pub fn to_sky(&self, place: PixelPosition) -> Option<Direction<Gcrs>> {
        let offset = self.offset(place);
        if !(offset.x.is_finite() && offset.y.is_finite()) {
            return None;
        }
        if let Some(trusted) = &self.trusted
            && !trusted.contains(&offset)
        {
            return None;
        }
        let plane = self.plane(&offset).0;
        let native = self.terms.projection.to_native(plane.x.to_radians(), plane.y.to_radians())?;
        Some(Direction::from_vector(self.to_sky * native))
    }

    /// The place of a direction in the frame; `None` where the projection does not show it, or far outside of a distorted frame.
    ///
    /// Undistorted frames answer far beyond their edges too, up to 90° from the centre of a gnomonic one.
    pub fn to_pixel(&self, direction: Direction<Gcrs>) -> Option<PixelPosition> {
        let native = self.to_sky.tr_mul(direction.vector());
        let [x, y] = self.terms.projection.to_plane(&native)?;
        let plane = Vector2::new(x.to_degrees(), y.to_degrees());
        let offset = match &self.trusted {
            None => self.inverse * plane,
            Some(trusted) => self.solved(trusted, &plane)?,
        };
        let [reference_x, reference_y] = self.terms.reference_pixel;
        Some(PixelPosition::from_fits(offset.x + reference_x, offset.y + reference_y))
    }

    /// Side of a square as large as a pixel there, arcseconds: the geometric mean of the scales along both axes, by its area. NaN where
    /// [`to_sky`](Wcs::to_sky) has no answer.
    pub fn pixel_scale_arcsec(&self, place: PixelPosition) -> f64 {
        self.pixel_area_arcsec2(place).sqrt()
    }

    /// Area of the sky on a pixel there, square arcseconds; NaN where [`to_sky`](Wcs::to_sky) has no answer.
    pub fn pixel_area_arcsec2(&self, place: PixelPosition) -> f64 {
        match self.pixel_sides(place) {
            Some([across, along]) => across.cross(&along).norm() * ARCSEC * ARCSEC,
            None => f64::NAN,
        }
    }

    /// How many times as wide on the sky (along rows) as high a pixel is there; NaN where [`to_sky`](Wcs::to_sky) has no answer.
    pub fn pixel_aspect(&self, place: PixelPosition) -> f64 {
        self.pixel_sides(place).map_or(f64::NAN, |[across, along]| across.norm() / along.norm())
    }

    /// From its left to its right side, and from its lower to its upper one.
    fn pixel_sides(&self, place: PixelPosition) -> Option<[Vector3<f64>; 2]> {
        let half = 0.5;
        let at = |x: f64, y: f64| self.to_sky(PixelPosition { x: place.x + x, y: place.y + y });
        let across = at(half, 0.0)?.vector() - at(-half, 0.0)?.vector();
        Some([across, at(0.0, half)?.vector() - at(0.0, -half)?.vector()])
    }

    /// The cards that say the same, for undistorted frames of one of this library's own projections ([`tangent`](Wcs::tangent)); none for others, whose
    /// header has them.
    pub fn cards(&self) -> Vec<Card> {
        if self.distortion().is_some() || self.terms.projection != Projection::Tan || self.terms.longitude_axis != 0 {
            return Vec::new();
        }
        let [crpix1, crpix2] = self.terms.reference_pixel;
        let [[cd1_1, cd1_2], [cd2_1, cd2_2]] = self.terms.matrix_deg;
        let pole = &self.terms.pole;
        let texts = [
            ("CTYPE1", "RA---TAN", "right ascension, gnomonic"),
            ("CTYPE2", "DEC--TAN", "declination, gnomonic"),
            ("CUNIT1", "deg", ""),
            ("CUNIT2", "deg", ""),
        ];
        let numbers = [
            ("CRPIX1", crpix1, "reference pixel, counted from 1"),
            ("CRPIX2", crpix2, "reference pixel, counted from 1"),
            ("CRVAL1", pole.right_ascension_deg, "[deg] right ascension there"),
            ("CRVAL2", pole.declination_deg, "[deg] declination there"),
            ("CD1_1", cd1_1, "[deg] a pixel"),
            ("CD1_2", cd1_2, "[deg] a pixel"),
            ("CD2_1", cd2_1, "[deg] a pixel"),
            ("CD2_2", cd2_2, "[deg] a pixel"),
        ];
        let mut cards = Card::with_value("WCSAXES", &2_i64.into(), "number of world coordinate axes");
        cards.extend(
            texts.iter().flat_map(|(keyword, text, comment)| Card::with_value(keyword, &(*text).into(), comment)),
        );
        cards.extend(
            numbers.iter().flat_map(|(keyword, number, comment)| Card::with_value(keyword, &(*number).into(), comment)),
        );
        if let Some(lonpole_deg) = pole.lonpole_deg {
            cards.extend(Card::with_value(
                "LONPOLE",
                &lonpole_deg.into(),
                "[deg] native longitude of the celestial pole",
            ));
        }
        cards.extend(Card::with_value("RADESYS", &"ICRS".into(), "system of axes"));
        cards
    }

    /// From a place to pixels from CRPIX.
    fn offset(&self, place: PixelPosition) -> Vector2<f64> {
        let [x, y] = place.fits();
        Vector2::new(x - self.terms.reference_pixel[0], y - self.terms.reference_pixel[1])
    }

    /// The plane, degrees, and its slopes along pixels.
    fn plane(&self, offset: &Vector2<f64>) -> (Vector2<f64>, Matrix2<f64>) {
        let (mut place, mut slopes) = (*offset, Matrix2::identity());
        if let Some(distortion) = &self.terms.pixel_distortion {
            let [u, v] = distortion.at(place.x, place.y);
            place = Vector2::new(u.value, v.value);
            slopes = Matrix2::new(u.du, u.dv, v.du, v.dv);
        }
        place = self.matrix * place;
        slopes = self.matrix * slopes;
        if let Some(distortion) = &self.terms.plane_distortion {
            let [u, v] = distortion.at(place.x, place.y);
            place = Vector2::new(u.value, v.value);
            slopes = Matrix2::new(u.du, u.dv, v.du, v.dv) * slopes;
        }
        (place, slopes)
    }

    /// The frame and as much around it as has no folds; `None` where the frame itself has one.
    ///
    /// A map f of a convex area is one to one where (J₀⁻¹ J) + (J₀⁻¹ J)ᵀ is positive definite everywhere, J being its slopes and J₀ those at one
    /// point: along any straight line f then moves on. It is asked at the points of a grid.
    fn trusted_area(&self) -> Option<Trusted> {
        let [columns, rows] = self.size.map(|count| count as f64);
        let corner = self.offset(PixelPosition { x: -0.5, y: -0.5 });
        let side = Vector2::new(columns, rows);
        let centre = corner + side / 2.0;
        let (plane_centre, slopes) = self.plane(&centre);
        let inverse_slopes = slopes.try_inverse()?;
        let margin = columns.max(rows).max(LEAST_MARGIN_PIX);
        MARGINS.iter().find_map(|part| {
            let around = Vector2::from_element(margin * part);
            let (low, high) = (corner - around, corner + side + around);
            let is_plain = |index: usize| {
                let step = |place: usize| place as f64 / (FOLD_GRID - 1) as f64;
                let at =
                    low + (high - low).component_mul(&Vector2::new(step(index % FOLD_GRID), step(index / FOLD_GRID)));
                let relative = inverse_slopes * self.plane(&at).1;
                let both = (relative + relative.transpose()) / 2.0;
                // The smaller eigenvalue of a symmetric matrix.
                let smaller = both.trace() / 2.0 - ((both.m11 - both.m22) / 2.0).hypot(both.m12);
                smaller > LEAST_SLOPE
            };
            (0..FOLD_GRID * FOLD_GRID).all(is_plain).then_some(Trusted {
                low,
                high,
                centre,
                plane_centre,
                inverse_slopes,
            })
        })
    }

    /// The pixel from CRPIX whose place in the plane this is, by Newton's method.
    fn solved(&self, trusted: &Trusted, wanted: &Vector2<f64>) -> Option<Vector2<f64>> {
        let mut offset = trusted.centre + trusted.inverse_slopes * (wanted - trusted.plane_centre);
        for _ in 0..MOST_STEPS {
            if !trusted.is_near(&offset) {
                return None;
            }
            let (plane, slopes) = self.plane(&offset);
            let determinant = slopes.m11 * slopes.m22 - slopes.m12 * slopes.m21;
            let miss = wanted - plane;
            let step =
                Vector2::new(slopes.m22 * miss.x - slopes.m12 * miss.y, slopes.m11 * miss.y - slopes.m21 * miss.x)
                    / determinant;
            offset += step;
            if step.amax() < CLOSE_PIX * (1.0 + offset.amax() * 1e-4) {
                return trusted.contains(&offset).then_some(offset);
            }
        }
        None
    }
}

impl Trusted {
    fn contains(&self, offset: &Vector2<f64>) -> bool {
        (0..2).all(|axis| (self.low[axis]..=self.high[axis]).contains(&offset[axis]))
    }

    /// Within the area or half its size around: on its way Newton's method may leave it.
    fn is_near(&self, offset: &Vector2<f64>) -> bool {
        let around = (self.high - self.low) / 2.0;
        (0..2).all(|axis| (self.low[axis] - around[axis]..=self.high[axis] + around[axis]).contains(&offset[axis]))
    }
}
