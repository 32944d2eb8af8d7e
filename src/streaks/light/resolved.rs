//! Chassis and solar array of a near satellite, drawn as two lights.
//!
//! A solar array of 10 m at 550 km has an apparent length of 4", more than good seeing. Each of the two panels is a
//! light at its own centre, with its fraction of the satellite's light according to the brightness model. The fractions
//! include the shadow of each panel on the other.

use nalgebra::Vector3;

use super::sky_track::{SkyPoint, SkyTrack};
use crate::frames::{Direction, Gcrs, Position, seconds_between};
use crate::passes::{Exposure, Pass};
use crate::photometry::{BrightnessModel, Earthshine};

/// Chassis and solar array of a satellite along one pass.
#[derive(Clone, Debug, PartialEq)]
pub struct ResolvedPanels {
    moments: Vec<PanelMoment>,
    /// Radius of a disk with the area of the chassis, m.
    pub base_radius_m: f64,
    /// Radius of a disk with the area of the solar array, m.
    pub sail_radius_m: f64,
}

/// Relative brightness and separation of the two panels at one time.
#[derive(Copy, Clone, Debug, PartialEq)]
struct PanelMoment {
    time_s: f64,
    /// Fraction of the light from the chassis, 0 to 1.
    base_share: f64,
    /// Vector from the centre of the chassis to the centre of the solar array, projected across the line of sight,
    /// radians.
    sail_offset: Vector3<f64>,
}

impl ResolvedPanels {
    /// Computes the panels at the samples of a pass. `observer` returns the position of the observer, km from the
    /// Earth's centre, at a time in seconds after the shutter opened.
    ///
    /// `None` if the model does not have two panels, or if no sample of the pass is lit.
    pub fn of_pass(
        pass: &Pass,
        exposure: &Exposure,
        model: &BrightnessModel,
        earthshine: Earthshine,
        observer: impl Fn(f64) -> Position<Gcrs>,
    ) -> Option<Self> {
        let panels = model.satellite()?;
        let shape = model.file()?.shape.as_ref()?;
        let (sin, cos) = shape.panel_offset_deg.to_radians().sin_cos();
        // Centres relative to the hinge, with the lengths L_b and L_s and the panel offset angle POA:
        // chassis (L_b / 2, 0, 0), solar array L_s / 2 (-sin POA, 0, cos POA).
        let half_sail_m = 0.5 * shape.sail_length_m;
        let sail_in_body = Vector3::new(-sin * half_sail_m - 0.5 * shape.base_length_m, 0.0, cos * half_sail_m);
        let moment = |sample: &crate::passes::TrackPoint| {
            let time_s = seconds_between(exposure.start, sample.epoch);
            let terms = panels.terms_with(&sample.geometry, earthshine);
            let base = terms.base_glossy_m2_sr + terms.base_diffuse_m2_sr + terms.earthshine_m2_sr();
            let base_share = base / terms.b_total_m2_sr();
            let axes =
                body_axes(&sample.direction, sample.range_km, &observer(time_s), &sample.geometry.to_observer())?;
            let sail_m = axes * sail_in_body;
            let across_m = sail_m - sample.direction.vector() * sample.direction.vector().dot(&sail_m);
            base_share.is_finite().then_some(PanelMoment {
                time_s,
                base_share,
                sail_offset: across_m / (sample.range_km * 1000.0),
            })
        };
        let moments: Vec<PanelMoment> = pass.samples.iter().filter_map(moment).collect();
        let radius_m = |area_m2: f64| (area_m2 / std::f64::consts::PI).sqrt();
        (!moments.is_empty()).then(|| Self {
            moments,
            base_radius_m: radius_m(shape.base_length_m * shape.base_width_m),
            sail_radius_m: radius_m(shape.sail_length_m * shape.sail_width_m),
        })
    }

    /// Returns the tracks of the chassis and of the solar array; their light sums to the light of the given track.
    pub fn split(&self, track: &SkyTrack) -> [SkyTrack; 2] {
        let part = |is_sail: bool| {
            let points = track.points.iter().map(|point| {
                let here = self.at(point.time_s);
                let share = if is_sail { 1.0 - here.base_share } else { here.base_share };
                let offset = if is_sail { here.sail_offset } else { Vector3::zeros() };
                SkyPoint {
                    direction: Direction::from_vector((point.direction.vector() + offset).normalize()),
                    // The magnitude is m - 2.5 log10 share; a part with a share of 0 is dark.
                    magnitude: point.magnitude.filter(|_| share > 0.0).map(|magnitude| magnitude - 2.5 * share.log10()),
                    ..*point
                }
            });
            SkyTrack { points: points.collect() }
        };
        [part(false), part(true)]
    }

    /// Interpolates linearly between two samples; before the first and after the last sample, that sample's values are
    /// used.
    fn at(&self, time_s: f64) -> PanelMoment {
        let after = self.moments.partition_point(|moment| moment.time_s <= time_s);
        let last = self.moments.len() - 1;
        let (Some(from), to) = (self.moments.get(after.saturating_sub(1)), self.moments[after.min(last)]) else {
            return self.moments[last];
        };
        let span_s = to.time_s - from.time_s;
        let share = if span_s > 0.0 { ((time_s - from.time_s) / span_s).clamp(0.0, 1.0) } else { 0.0 };
        PanelMoment {
            time_s,
            base_share: from.base_share + share * (to.base_share - from.base_share),
            sail_offset: from.sail_offset + (to.sail_offset - from.sail_offset) * share,
        }
    }
}

/// Returns the axes of the body frame as columns, in GCRS: z to the satellite's zenith, x towards the Sun's longitude.
///
/// The direction of the observer is given in both frames. Together with the zenith it determines the third axis. `None`
/// if the observer is in the satellite's zenith or nadir, where the longitude is undefined.
fn body_axes(
    direction: &Direction<Gcrs>,
    range_km: f64,
    observer: &Position<Gcrs>,
    to_observer: &Direction<crate::frames::Body>,
) -> Option<nalgebra::Matrix3<f64>> {
    let satellite = observer.vector() + direction.vector() * range_km;
    let zenith = satellite.try_normalize(0.0)?;
    let back = -direction.vector();
    let level = (back - zenith * zenith.dot(&back)).try_normalize(1e-9)?;
    let (sin, cos) = to_observer.longitude_rad().sin_cos();
    // The horizontal part of the observer's direction is level = x cos α + y sin α, and z × level = -x sin α + y cos α.
    let ahead = zenith.cross(&level);
    let x = level * cos - ahead * sin;
    let y = level * sin + ahead * cos;
    Some(nalgebra::Matrix3::from_columns(&[x, y, zenith]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::ViewingGeometry;

    #[test]
    fn verif_axes_turn_the_body_frame_onto_the_sky() {
        let observer = Position::<Gcrs>::new(6378.0, 0.0, 0.0);
        let sun = Position::<Gcrs>::new(-5.0e7, 1.2e8, 6.0e7);
        for satellite in [Position::<Gcrs>::new(6850.0, 500.0, -300.0), Position::new(6700.0, -900.0, 700.0)] {
            let geometry = ViewingGeometry::new(&satellite, &observer, &sun).unwrap();
            let line = satellite.vector() - observer.vector();
            let direction = Direction::from_vector(line.normalize());
            let axes = body_axes(&direction, line.norm(), &observer, &geometry.to_observer()).unwrap();
            assert!((axes.transpose() * axes - nalgebra::Matrix3::identity()).norm() < 1e-12);
            assert!((axes.determinant() - 1.0).abs() < 1e-12);
            // The directions of the Sun and the observer agree with the geometry.
            let to_sun = axes.transpose() * (sun.vector() - satellite.vector()).normalize();
            assert!((to_sun - geometry.to_sun().vector()).norm() < 1e-9);
            assert!((axes * geometry.to_observer().vector() + direction.vector()).norm() < 1e-9);
        }
    }

    #[test]
    fn verif_the_two_lights_sum_to_the_light_of_the_track() {
        let panels = ResolvedPanels {
            moments: vec![
                PanelMoment { time_s: 0.0, base_share: 0.2, sail_offset: Vector3::new(0.0, 0.0, 1e-5) },
                PanelMoment { time_s: 2.0, base_share: 1.0, sail_offset: Vector3::new(0.0, 0.0, 3e-5) },
            ],
            base_radius_m: 1.0,
            sail_radius_m: 3.0,
        };
        let point = |time_s: f64| SkyPoint {
            time_s,
            direction: Direction::from_lon_lat_rad(0.01 * time_s, 0.0),
            range_km: 600.0,
            magnitude: Some(5.0),
        };
        let track = SkyTrack { points: [-1.0, 1.0, 3.0].map(point).to_vec() };
        let [base, sail] = panels.split(&track);
        let light = |magnitude: Option<f64>| magnitude.map_or(0.0, |magnitude| 10f64.powf(-0.4 * magnitude));
        for ((whole, base), sail) in track.points.iter().zip(&base.points).zip(&sail.points) {
            let sum = light(base.magnitude) + light(sail.magnitude);
            assert!((sum / light(whole.magnitude) - 1.0).abs() < 1e-12);
            assert_eq!(base.direction, whole.direction);
        }
        assert!((light(base.points[1].magnitude) / light(Some(5.0)) - 0.6).abs() < 1e-12);
        assert!((sail.points[1].direction.separation_rad(&track.points[1].direction) - 2e-5).abs() < 1e-12);
        // All the light comes from the chassis: the sail is dark, not infinitely faint.
        assert_eq!(sail.points[2].magnitude, None);
    }
}
