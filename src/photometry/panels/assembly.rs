//! A satellite made of panels, ready to be asked for its light.
//!
//! Each panel reflects by the laws of the face that is lit and seen: its front, its back, or through from the front to
//! the back. What other panels shade of it or hide of it is cut out exactly; light that goes from panel to panel is left
//! out, as in the paper.

use nalgebra::Vector3;

use super::attitude::Attitude;
use super::obstruction::{MOST_BLOCKERS, union_area_m2};
use super::rectangle::PlacedRectangle;
use crate::photometry::brdf::{Brdf, Law};
use crate::photometry::panel::Incidence;
use crate::photometry::polygon::PanelPolygon;

/// Which way light goes at a panel.
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
    /// As its file calls it.
    pub name: String,
    /// The point u = v = 0, in the body frame, m.
    pub anchor_m: Vector3<f64>,
    /// From and to along u, m.
    pub u_m: [f64; 2],
    /// From and to along v, m.
    pub v_m: [f64; 2],
    /// How it turns.
    pub attitude: Attitude,
    /// Laws of the front.
    pub front: Vec<Law>,
    /// Laws of the back.
    pub back: Vec<Law>,
    /// Laws of light that comes through.
    pub through: Vec<Law>,
    /// Panels that may shade or hide it, by number; at most [`MOST_BLOCKERS`].
    pub blockers: Vec<usize>,
}

/// Light of one law of one panel.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Part {
    /// Number of the panel.
    pub panel: usize,
    /// Its face.
    pub face: Face,
    /// Number of the law on that face.
    pub law: usize,
    /// Cosines, area and obstruction included.
    pub m2_sr: f64,
    /// Share of the panel that is lost to shadow or hidden, [0, 1].
    pub blocked: f64,
}

/// Any number of panels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PanelAssembly {
    panels: Vec<AssembledPanel>,
}

impl PanelAssembly {
    /// Numbers in `blockers` beyond the panels, and blockers beyond [`MOST_BLOCKERS`], are refused by model files.
    pub(super) fn new(panels: Vec<AssembledPanel>) -> Self {
        Self { panels }
    }

    pub(super) fn panels(&self) -> &[AssembledPanel] {
        &self.panels
    }

    /// Names of the panels, in the order of their numbers.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.panels.iter().map(|panel| panel.name.as_str())
    }

    /// Where each panel stands while the Sun stands in this direction (unit vector in the body frame, y = 0).
    pub fn placed(&self, to_sun: &Vector3<f64>) -> Vec<PlacedRectangle> {
        self.panels.iter().map(|panel| panel.placed(to_sun)).collect()
    }

    /// Reflected sunlight, m² sr⁻¹, for unit vectors to Sun (y = 0) and observer in the body frame.
    pub fn b_total_m2_sr(&self, to_sun: &Vector3<f64>, to_observer: &Vector3<f64>) -> f64 {
        let mut total = 0.0;
        self.each_part(to_sun, to_observer, |part| total += part.m2_sr);
        total
    }

    /// The same taken apart: one entry for each law of each face that is lit and seen.
    pub fn parts(&self, to_sun: &Vector3<f64>, to_observer: &Vector3<f64>) -> Vec<Part> {
        let mut parts = Vec::new();
        self.each_part(to_sun, to_observer, |part| parts.push(part));
        parts
    }

    /// Share of a panel's area that is in the others' shadow or hidden by them, [0, 1].
    pub fn blocked(&self, panel: usize, to_sun: &Vector3<f64>, to_observer: &Vector3<f64>) -> f64 {
        let Some(of) = self.panels.get(panel) else { return 0.0 };
        self.share_blocked(of, &of.placed(to_sun), to_sun, to_observer)
    }

    fn each_part(&self, to_sun: &Vector3<f64>, to_observer: &Vector3<f64>, mut take: impl FnMut(Part)) {
        for (number, panel) in self.panels.iter().enumerate() {
            let placed = panel.placed(to_sun);
            let incidence = Incidence::new(&placed.axes.normal, to_sun, to_observer);
            let (face, laws) = match (incidence.cos_in > 0.0, incidence.cos_out > 0.0) {
                (true, true) => (Face::Front, &panel.front),
                (false, false) => (Face::Back, &panel.back),
                (true, false) => (Face::Through, &panel.through),
                (false, true) => continue,
            };
            let projection = (incidence.cos_in * incidence.cos_out).abs();
            if laws.is_empty() || projection == 0.0 {
                continue;
            }
            let blocked = self.share_blocked(panel, &placed, to_sun, to_observer);
            // The same cosines whichever side they are counted from.
            let seen = if face == Face::Back { incidence.from_behind() } else { incidence };
            // f cos φ_i cos φ_r A (1 - BF)                                 Lu (2024), eqs. 2-6
            let open_m2 = projection * placed.area_m2() * (1.0 - blocked);
            for (law, brdf) in laws.iter().enumerate() {
                let m2_sr = if open_m2 > 0.0 { brdf.value_per_sr(&seen) * open_m2 } else { 0.0 };
                take(Part { panel: number, face, law, m2_sr, blocked });
            }
        }
    }

    fn share_blocked(
        &self,
        panel: &AssembledPanel,
        placed: &PlacedRectangle,
        to_sun: &Vector3<f64>,
        to_observer: &Vector3<f64>,
    ) -> f64 {
        if panel.blockers.is_empty() {
            return 0.0;
        }
        let mut shapes = [PanelPolygon::default(); 2 * MOST_BLOCKERS];
        let mut count = 0;
        for blocker in panel.blockers.iter().take(MOST_BLOCKERS).filter_map(|&number| self.panels.get(number)) {
            let other = blocker.placed(to_sun);
            for direction in [to_sun, to_observer] {
                shapes[count] = placed.stopped_by(&other, direction);
                count += 1;
            }
        }
        (union_area_m2(&shapes[..count]) / placed.area_m2()).clamp(0.0, 1.0)
    }
}

impl AssembledPanel {
    fn placed(&self, to_sun: &Vector3<f64>) -> PlacedRectangle {
        PlacedRectangle { anchor_m: self.anchor_m, axes: self.attitude.axes(to_sun), u_m: self.u_m, v_m: self.v_m }
    }
}
