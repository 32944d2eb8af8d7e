//! Light of a satellite that consists of panels and spheres.
//!
//! A panel has the reflection laws `front` (lit and seen from the front), `back` (lit and seen from behind) and
//! `through` (lit from the front, seen from behind). The parts of a panel that other panels shade or hide are removed
//! exactly. Light reflected between panels is neglected, as in Lu (2024). Spheres add their light and are never hidden.

use nalgebra::Vector3;

use super::attitude::Attitude;
use super::shapes::PlacedRectangle;
use super::shapes::Sphere;
use super::shapes::{MOST_BLOCKERS, PanelPolygon, union_area_m2};
use crate::geometry::ViewingGeometry;
use crate::photometry::brdf::{Brdf, Incidence, Law};
use crate::photometry::earthshine::LitEarth;

/// Side from which a panel is lit, and side from which it is seen.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Face {
    /// Lit and seen from the front.
    Front,
    /// Lit and seen from behind.
    Back,
    /// Lit from the front, seen from behind.
    Through,
}

/// One panel of an assembly.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct AssembledPanel {
    /// Name in the model file.
    pub name: String,
    /// Position of u = v = 0, in the body frame, m.
    pub anchor_m: Vector3<f64>,
    /// Extent along u, m.
    pub u_m: [f64; 2],
    /// Extent along v, m.
    pub v_m: [f64; 2],
    /// Rule for the attitude of the panel.
    pub attitude: Attitude,
    /// Reflection laws of the front.
    pub front: Vec<Law>,
    /// Reflection laws of the back.
    pub back: Vec<Law>,
    /// Laws of transmitted light.
    pub through: Vec<Law>,
    /// True if earthshine falls on the front.
    pub earthshine: bool,
    /// Indices of panels that may shade or hide this panel; at most [`MOST_BLOCKERS`].
    pub blockers: Vec<usize>,
}

/// A face that is lit and seen, with the incidence for its laws and the area by which their values are multiplied.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct LitFace {
    /// Index of the panel.
    pub panel: usize,
    /// Face of the panel.
    pub face: Face,
    /// Incidence on the lit side: that from behind for the back, that from the front for transmitted light.
    pub incidence: Incidence,
    /// Unobstructed projected area |cos φ_i cos φ_r| A (1 - BF), m². A law with the value f, sr⁻¹, contributes f times
    /// this area.
    pub open_m2: f64,
    /// Fraction BF of the panel that is shaded or hidden, [0, 1].
    pub blocked: f64,
}

/// Light that one law of one panel contributes.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Part {
    /// Index of the panel.
    pub panel: usize,
    /// Face of the panel.
    pub face: Face,
    /// Index of the law on that face.
    pub law: usize,
    /// Light, m² sr⁻¹, including cosines, area and obstruction.
    pub m2_sr: f64,
    /// Fraction of the panel that is shaded or hidden, [0, 1].
    pub blocked: f64,
}

/// Satellite that consists of any number of panels and spheres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PanelAssembly {
    panels: Vec<AssembledPanel>,
    spheres: Vec<Sphere>,
}

impl PanelAssembly {
    /// Creates an assembly. Invalid indices in `blockers` and more than [`MOST_BLOCKERS`] are rejected earlier, in
    /// model files.
    pub(super) fn new(panels: Vec<AssembledPanel>, spheres: Vec<Sphere>) -> Self {
        Self { panels, spheres }
    }

    pub(super) fn panels(&self) -> &[AssembledPanel] {
        &self.panels
    }

    /// Returns the names of the panels, in the order of their indices.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.panels.iter().map(|panel| panel.name.as_str())
    }

    /// Returns the positions of the panels for a direction of the Sun (unit vector in the body frame with y = 0).
    pub fn placed(&self, to_sun: &Vector3<f64>) -> Vec<PlacedRectangle> {
        self.panels.iter().map(|panel| panel.placed(to_sun)).collect()
    }

    /// Returns the reflected sunlight, m² sr⁻¹. The arguments are unit vectors to the Sun (y = 0) and the observer, in
    /// the body frame.
    pub fn b_total_m2_sr(&self, to_sun: &Vector3<f64>, to_observer: &Vector3<f64>) -> f64 {
        let mut total = self.sphere_parts(to_sun, to_observer).sum();
        self.each_part(to_sun, to_observer, |part| total += part.m2_sr);
        total
    }

    /// Returns the light of the panels, with one entry for each law of each face that is lit and seen. These entries
    /// and those of [`Self::sphere_parts`] sum to the total.
    pub fn parts(&self, to_sun: &Vector3<f64>, to_observer: &Vector3<f64>) -> Vec<Part> {
        let mut parts = Vec::new();
        self.each_part(to_sun, to_observer, |part| parts.push(part));
        parts
    }

    /// Returns each face that is sunlit, visible to the observer and has a reflection law, in the order of the panels.
    ///
    /// These faces do not depend on the coefficients of the laws, so that a fit can keep them and take [`Self::laws`]
    /// from each new assembly. The light of the panels is the sum of f · `open_m2` over these faces and their laws.
    /// [`Self::spheres`] add their light, which depends only on the phase angle.
    pub fn lit_faces(&self, to_sun: &Vector3<f64>, to_observer: &Vector3<f64>) -> Vec<LitFace> {
        let mut faces = Vec::new();
        self.each_lit_face(to_sun, to_observer, |lit| faces.push(lit));
        faces
    }

    /// Returns the laws of one face, in the order of the file; empty for an invalid index.
    pub fn laws(&self, panel: usize, face: Face) -> &[Law] {
        self.panels.get(panel).map_or(&[], |panel| panel.laws(face))
    }

    /// Returns the spheres, in the order of the file.
    pub fn spheres(&self) -> &[Sphere] {
        &self.spheres
    }

    /// Returns the light of each sphere, in the order of the file, m² sr⁻¹.
    pub fn sphere_parts(&self, to_sun: &Vector3<f64>, to_observer: &Vector3<f64>) -> impl Iterator<Item = f64> {
        let cos_phase = to_sun.dot(to_observer).clamp(-1.0, 1.0);
        self.spheres.iter().map(move |sphere| sphere.m2_sr(cos_phase.acos()))
    }

    /// Returns the fraction of a panel's area that other panels shade or hide, [0, 1].
    pub fn blocked(&self, panel: usize, to_sun: &Vector3<f64>, to_observer: &Vector3<f64>) -> f64 {
        let Some(of) = self.panels.get(panel) else { return 0.0 };
        self.share_blocked(of, &of.placed(to_sun), to_sun, &[to_sun, to_observer])
    }

    /// Returns the earthshine reflected by the fronts that receive it, m² sr⁻¹.
    ///
    /// The hidden parts of a panel are removed. Shading of the extended Earth by other panels is neglected. Spheres
    /// receive no earthshine.
    pub fn earthshine_m2_sr(&self, geometry: &ViewingGeometry) -> f64 {
        let (to_sun, to_observer) = (geometry.to_sun(), geometry.to_observer());
        let (to_sun, to_observer) = (to_sun.vector(), to_observer.vector());
        let Some(earth) = LitEarth::new(geometry.sun_latitude_rad, geometry.height_km) else { return 0.0 };
        let mut sources = Vec::new();
        let mut resolved_exponent = f64::NAN;
        let mut total = 0.0;
        for panel in self.panels.iter().filter(|panel| panel.earthshine) {
            let placed = panel.placed(to_sun);
            let normal = placed.axes.normal;
            if normal.dot(to_observer) <= 0.0 {
                continue;
            }
            let open = 1.0 - self.share_blocked(panel, &placed, to_sun, &[to_observer]);
            if let Some(reflected) = level_reflection_per_sr(&earth, &normal, &panel.front, to_observer) {
                total += open * placed.area_m2() * reflected;
                continue;
            }
            for law in &panel.front {
                let exponent = law.equivalent_exponent();
                if exponent != resolved_exponent {
                    sources = earth.sources(exponent);
                    resolved_exponent = exponent;
                }
                total += open * placed.area_m2() * reflected_per_sr(&sources, &normal, law, to_observer);
            }
        }
        total
    }

    fn each_part(&self, to_sun: &Vector3<f64>, to_observer: &Vector3<f64>, mut take: impl FnMut(Part)) {
        self.each_lit_face(to_sun, to_observer, |lit| {
            for (law, brdf) in self.laws(lit.panel, lit.face).iter().enumerate() {
                // f cos φ_i cos φ_r A (1 - BF)                             Lu (2024), eqs. 2-6
                let m2_sr = if lit.open_m2 > 0.0 { brdf.value_per_sr(&lit.incidence) * lit.open_m2 } else { 0.0 };
                take(Part { panel: lit.panel, face: lit.face, law, m2_sr, blocked: lit.blocked });
            }
        });
    }

    pub(super) fn each_lit_face(
        &self,
        to_sun: &Vector3<f64>,
        to_observer: &Vector3<f64>,
        mut take: impl FnMut(LitFace),
    ) {
        for (number, panel) in self.panels.iter().enumerate() {
            let placed = panel.placed(to_sun);
            let incidence = Incidence::new(&placed.axes.normal, to_sun, to_observer);
            let face = match (incidence.cos_in > 0.0, incidence.cos_out > 0.0) {
                (true, true) => Face::Front,
                (false, false) => Face::Back,
                (true, false) => Face::Through,
                (false, true) => continue,
            };
            let projection = (incidence.cos_in * incidence.cos_out).abs();
            if panel.laws(face).is_empty() || projection == 0.0 {
                continue;
            }
            let blocked = self.share_blocked(panel, &placed, to_sun, &[to_sun, to_observer]);
            // The cosines of projection are the same for both sides.
            let incidence = if face == Face::Back { incidence.from_behind() } else { incidence };
            let open_m2 = projection * placed.area_m2() * (1.0 - blocked);
            take(LitFace { panel: number, face, incidence, open_m2, blocked });
        }
    }

    /// Returns the fraction of a panel that the other panels block in at least one of up to two directions.
    pub(super) fn share_blocked(
        &self,
        panel: &AssembledPanel,
        placed: &PlacedRectangle,
        to_sun: &Vector3<f64>,
        directions: &[&Vector3<f64>],
    ) -> f64 {
        if panel.blockers.is_empty() {
            return 0.0;
        }
        let mut shapes = [PanelPolygon::default(); 2 * MOST_BLOCKERS];
        let mut count = 0;
        for blocker in panel.blockers.iter().take(MOST_BLOCKERS).filter_map(|&number| self.panels.get(number)) {
            let other = blocker.placed(to_sun);
            for direction in directions.iter().take(2) {
                shapes[count] = placed.blocked_by(&other, direction);
                count += 1;
            }
        }
        (union_area_m2(&shapes[..count]) / placed.area_m2()).clamp(0.0, 1.0)
    }
}

/// Exponent that determines the nodes for panels with diffuse laws only. A level panel sees the whole lit ground,
/// without the kink at 90° for which a lobe of exponent 1 requires more nodes.
const DIFFUSE_EXPONENT: f64 = 5.0;

/// Returns Σ dE f cos φ_i cos φ_r of a panel that faces down with one diffuse law, one law of facets, or both, sr⁻¹;
/// `None` for any other panel.
fn level_reflection_per_sr(
    earth: &LitEarth,
    normal: &Vector3<f64>,
    front: &[Law],
    to_observer: &Vector3<f64>,
) -> Option<f64> {
    let is_level = normal.x == 0.0 && normal.y == 0.0 && normal.z < 0.0;
    let facets = front.iter().find(|law| matches!(law, Law::Facets(_)));
    let others = || front.iter().filter(|law| !matches!(law, Law::Lambert(_)));
    if !is_level || others().count() > usize::from(facets.is_some()) {
        return None;
    }
    let (irradiance, reflected) = match facets {
        Some(law @ Law::Facets(facets)) => {
            let [irradiance, reflected] = earth.shine_on_facets(facets, to_observer, law.equivalent_exponent());
            (irradiance, facets.weight * reflected)
        }
        _ => (earth.shine(normal, to_observer, DIFFUSE_EXPONENT).irradiance, 0.0),
    };
    let albedo: f64 = front.iter().map(|law| if let Law::Lambert(law) = law { law.albedo } else { 0.0 }).sum();
    // Lambert: f = albedo/π
    Some((albedo / std::f64::consts::PI * irradiance + reflected) * normal.dot(to_observer))
}

/// Returns Σ dE f cos φ_i cos φ_r, sr⁻¹, for sources that light the front of a panel.
fn reflected_per_sr(
    sources: &[(Vector3<f64>, f64)],
    normal: &Vector3<f64>,
    law: &impl Brdf,
    to_observer: &Vector3<f64>,
) -> f64 {
    let reflected = |(to_source, irradiance): &(Vector3<f64>, f64)| {
        let incidence = Incidence::new(normal, to_source, to_observer);
        let projection = incidence.front();
        // The laws are not evaluated for sources that do not light the panel.
        if projection > 0.0 { irradiance * law.value_per_sr(&incidence) * projection } else { 0.0 }
    };
    sources.iter().map(reflected).sum()
}

impl AssembledPanel {
    pub(super) fn laws(&self, face: Face) -> &[Law] {
        match face {
            Face::Front => &self.front,
            Face::Back => &self.back,
            Face::Through => &self.through,
        }
    }

    pub(super) fn placed(&self, to_sun: &Vector3<f64>) -> PlacedRectangle {
        PlacedRectangle { anchor_m: self.anchor_m, axes: self.attitude.axes(to_sun), u_m: self.u_m, v_m: self.v_m }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photometry::brdf::{Facets, Lambert};

    #[test]
    fn verif_level_panels_by_rings_equal_the_sum_over_sources() {
        // The tolerance covers the error of the vectorised exponential.
        const TOLERANCE: f64 = 1e-6;
        let lambert = Law::Lambert(Lambert { albedo: 0.1 });
        let down = -Vector3::z();
        let mut compared = 0;
        for slope in [0.08, 0.17, 0.4] {
            let facets = Law::Facets(Facets { weight: 0.2, slope });
            for sun_deg in [-18.0_f64, -8.0, 0.0, 8.0, 60.0] {
                let Some(earth) = LitEarth::new(sun_deg.to_radians(), 550.0) else { continue };
                for (longitude, latitude) in [(0.0_f64, -80.0_f64), (40.0, -30.0), (120.0, -50.0), (180.0, -3.0)] {
                    let [longitude, latitude] = [longitude, latitude].map(f64::to_radians);
                    let to_observer = Vector3::new(
                        latitude.cos() * longitude.cos(),
                        latitude.cos() * longitude.sin(),
                        latitude.sin(),
                    );
                    for (front, exponent) in [
                        (vec![facets.clone()], facets.equivalent_exponent()),
                        (vec![lambert.clone()], DIFFUSE_EXPONENT),
                        (vec![lambert.clone(), facets.clone()], facets.equivalent_exponent()),
                    ] {
                        let computed = level_reflection_per_sr(&earth, &down, &front, &to_observer).expect("level");
                        let sources = earth.sources(exponent);
                        let of = |law: &Law| reflected_per_sr(&sources, &down, law, &to_observer);
                        let expected: f64 = front.iter().map(of).sum();
                        let error = (computed - expected).abs();
                        assert!(error <= TOLERANCE * expected, "{front:?} {sun_deg}: {computed:e} {expected:e}");
                        compared += 1;
                    }
                }
            }
        }
        assert_eq!(compared, 180);
        assert_eq!(level_reflection_per_sr(&LitEarth::new(0.0, 550.0).unwrap(), &Vector3::z(), &[], &down), None);
    }
}
