//! Radii where a profile is kept: close together in its core, far apart in its wings.

/// Nodes at equal steps of t = r / (r + c), from 0 to an end.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Radii {
    /// c: within it steps are about equal.
    core_pix: f64,
    end_pix: f64,
    intervals: usize,
}

impl Radii {
    /// `intervals` of at least 4.
    pub fn new(core_pix: f64, end_pix: f64, intervals: usize) -> Self {
        Self { core_pix, end_pix, intervals }
    }

    pub fn core_pix(&self) -> f64 {
        self.core_pix
    }

    pub fn end_pix(&self) -> f64 {
        self.end_pix
    }

    pub fn intervals(&self) -> usize {
        self.intervals
    }

    /// Number of steps that t = 1, an infinite radius, would be.
    pub fn scale(&self) -> f64 {
        self.intervals as f64 * (self.end_pix + self.core_pix) / self.end_pix
    }

    /// Radius of a node, pixels.
    pub fn radius(&self, node: usize) -> f64 {
        let t = node as f64 / self.scale();
        self.core_pix * t / (1.0 - t)
    }

    /// Where among the nodes a radius lies.
    pub fn place(&self, r_pix: f64) -> f64 {
        r_pix / (r_pix + self.core_pix) * self.scale()
    }
}
