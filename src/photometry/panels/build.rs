//! Validation of the panels in a model file, and the assembly that is built from them.

use nalgebra::Vector3;

use super::assembly::{AssembledPanel, PanelAssembly};
use super::attitude::{Attitude, PanelOffset};
use super::panel_file::{
    AttitudeSpec, BlockingSpec, Coefficient, LawSpec, OffsetSpec, PanelParameter, PanelSpec, PanelsSpec, SphereSpec,
};
use super::shapes::{MOST_BLOCKERS, Sphere};
use crate::error::Error;
use crate::photometry::brdf::{
    Abg, Binomial, Facets, Gaussian, Lambert, Law, Phong, Retro, Straight, reflected_share, transmitted_share,
};
use crate::photometry::error::Check;
use crate::photometry::model_file::{Coefficients, SatelliteShape};

/// Cosines of incidence at which the energy conservation of a face is checked.
const ENERGY_CHECK_COSINES: [f64; 5] = [1.0, 0.8, 0.5, 0.2, 0.05];
/// Tolerance for the error of the numerical integral of the reflected power.
const ENERGY_SLACK: f64 = 2e-3;

impl PanelsSpec {
    /// Checks that every number is in its range and that every reference is the name of a panel or a parameter.
    pub(in crate::photometry) fn validate(&self, check: &Check) -> Result<(), Error> {
        check.count("panels.panels", self.panels.len(), 1, 32)?;
        check.count("panels.parameters", self.parameters.len(), 0, 64)?;
        for (index, parameter) in self.parameters.iter().enumerate() {
            if self.parameters[..index].iter().any(|earlier| earlier.name == parameter.name) {
                return Err(check.reference("panels.parameters", &parameter.name, "unique names".to_owned()));
            }
            let key = format!("panels.parameters.{}", parameter.name);
            check.range(&key, parameter.value, -10_000.0, 10_000.0)?;
        }
        let names: Vec<&str> = self.panels.iter().map(|panel| panel.name.as_str()).collect();
        for (index, panel) in self.panels.iter().enumerate() {
            if panel.name.is_empty() || names[..index].contains(&panel.name.as_str()) {
                return Err(check.reference("panels.panels", &panel.name, "unique names".to_owned()));
            }
            panel.validate(check, self)?;
        }
        check.count("panels.spheres", self.spheres.len(), 0, 16)?;
        for (index, sphere) in self.spheres.iter().enumerate() {
            if sphere.name.is_empty() || self.spheres[..index].iter().any(|earlier| earlier.name == sphere.name) {
                return Err(check.reference("panels.spheres", &sphere.name, "unique names".to_owned()));
            }
            sphere.validate(check, self)?;
        }
        for PanelParameter { name, .. } in &self.parameters {
            if self.terms_of(name).next().is_none() {
                let allowed = "names used by a law or a sphere";
                return Err(check.reference("panels.parameters", name, allowed.to_owned()));
            }
        }
        self.validate_blocking(check, &names)?;
        self.validate_energy(check)
    }

    /// Builds the panels with these values of the parameters, given in their order; missing values are taken from the
    /// file.
    ///
    /// The file must have been validated ([`ModelFile::validate`](crate::photometry::ModelFile::validate)), because
    /// values are not checked here. A coefficient with an unknown name is 0, and a blocker with an unknown name blocks
    /// nothing.
    pub fn assemble(&self, values: &[f64]) -> PanelAssembly {
        let number_of = |name: &str| self.panels.iter().position(|panel| panel.name == name);
        let value_of = |coefficient: &Coefficient| self.value(coefficient, values).unwrap_or(0.0);
        let laws = |specs: &[LawSpec]| specs.iter().map(|spec| spec.law(&value_of)).collect();
        let panels = self.panels.iter().map(|panel| AssembledPanel {
            name: panel.name.clone(),
            anchor_m: Vector3::from(panel.anchor_m),
            u_m: panel.u_m,
            v_m: panel.v_m,
            attitude: panel.attitude.attitude(),
            front: laws(&panel.front),
            back: laws(&panel.back),
            through: laws(&panel.through),
            earthshine: panel.earthshine,
            blockers: self.blockers_of(&panel.name).filter_map(|blocking| number_of(&blocking.by)).collect(),
        });
        let spheres = self.spheres.iter().map(|sphere| Sphere {
            name: sphere.name.clone(),
            area_m2: sphere.area_m2,
            albedo: value_of(&sphere.albedo),
            phase: sphere.phase,
        });
        PanelAssembly::new(panels.collect(), spheres.collect())
    }

    /// Returns the smallest and largest value that each parameter may have in fits. It is the range that all
    /// coefficients referring to the parameter have in common (albedos and weights 0 to 1, exponents 0.5 to 200, …).
    /// The range is narrower than in files, so that a value in a file may be outside.
    pub fn ranges(&self) -> Vec<[f64; 2]> {
        let of = |PanelParameter { name, .. }: &PanelParameter| {
            self.terms_of(name).fold([-10_000.0_f64, 10_000.0_f64], |[least, greatest], term| {
                [least.max(term.fitted[0]), greatest.min(term.fitted[1])]
            })
        };
        self.parameters.iter().map(of).collect()
    }

    /// Returns true if the light of every law and sphere that refers to a parameter (given by its index) is
    /// proportional to it. This holds for albedos, weights, the peak of the Gaussian law and a of the ABg law.
    pub fn is_linear(&self, parameter: usize) -> bool {
        self.parameters
            .get(parameter)
            .is_some_and(|parameter| self.terms_of(&parameter.name).all(|term| term.is_linear))
    }

    /// Returns true if light is transmitted in a lobe about the direction of the sunlight.
    pub(in crate::photometry) fn has_forward_lobe(&self) -> bool {
        let mut through = self.panels.iter().flat_map(|panel| &panel.through);
        through.any(|law| matches!(law, LawSpec::Straight { .. }))
    }

    /// Multiplies the light of all laws and spheres by a factor, except for that of binomial laws.
    #[cfg(feature = "fit")]
    pub(crate) fn scale_light(&mut self, factor: f64) {
        let is_linear: Vec<bool> = (0..self.parameters.len()).map(|index| self.is_linear(index)).collect();
        for (parameter, _) in self.parameters.iter_mut().zip(is_linear).filter(|(_, is_linear)| *is_linear) {
            parameter.value *= factor;
        }
        let laws = self.panels.iter_mut().flat_map(|panel| {
            panel.front.iter_mut().chain(&mut panel.back).chain(&mut panel.through).filter_map(LawSpec::strength_mut)
        });
        for strength in laws.chain(self.spheres.iter_mut().map(|sphere| &mut sphere.albedo)) {
            if let Coefficient::Number(value) = strength {
                *value *= factor;
            }
        }
    }

    /// Returns the coefficients that refer to a parameter.
    fn terms_of<'a>(&'a self, name: &'a str) -> impl Iterator<Item = Term<'a>> {
        let terms = self.panels.iter().flat_map(PanelSpec::laws).flat_map(|(_, law)| law.terms());
        let terms = terms.chain(self.spheres.iter().map(SphereSpec::term));
        terms.filter(move |term| matches!(term.coefficient, Coefficient::Parameter(known) if known == name))
    }

    fn blockers_of<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a BlockingSpec> {
        self.blocking.iter().filter(move |blocking| blocking.panel == name)
    }

    /// Returns the value of a coefficient; `None` for an unknown parameter.
    fn value(&self, coefficient: &Coefficient, values: &[f64]) -> Option<f64> {
        match coefficient {
            Coefficient::Number(value) => Some(*value),
            Coefficient::Parameter(name) => {
                let index = self.parameters.iter().position(|parameter| parameter.name == *name)?;
                Some(values.get(index).copied().unwrap_or(self.parameters[index].value))
            }
        }
    }

    fn validate_blocking(&self, check: &Check, names: &[&str]) -> Result<(), Error> {
        for BlockingSpec { panel, by } in &self.blocking {
            for name in [panel, by] {
                if !names.contains(&name.as_str()) {
                    return Err(check.reference("panels.blocking", name, format!("one of {}", names.join(", "))));
                }
            }
            if panel == by {
                return Err(check.reference("panels.blocking", by, "a panel other than the one it blocks".to_owned()));
            }
            let key = format!("panels.blocking (of {panel})");
            check.count(&key, self.blockers_of(panel).count(), 0, MOST_BLOCKERS)?;
        }
        Ok(())
    }

    fn validate_energy(&self, check: &Check) -> Result<(), Error> {
        if !self.conserves_energy {
            return Ok(());
        }
        let assembly = self.assemble(&[]);
        for panel in assembly.panels() {
            let faces: [(&str, &[Law], &[Law]); 2] =
                [("front and through", &panel.front, &panel.through), ("back", &panel.back, &[])];
            for (face, reflect, transmit) in faces {
                for cos_in in ENERGY_CHECK_COSINES {
                    let share: f64 = reflect.iter().map(|law| reflected_share(law, cos_in)).sum::<f64>()
                        + transmit.iter().map(|law| transmitted_share(law, cos_in)).sum::<f64>();
                    let key = format!("panels.{} ({face}, light at cosine {cos_in}): reflected fraction", panel.name);
                    check.range(&key, share, 0.0, 1.0 + ENERGY_SLACK)?;
                }
            }
        }
        for sphere in assembly.spheres() {
            let key = format!("panels.spheres.{}: reflected fraction", sphere.name);
            check.range(&key, sphere.albedo, 0.0, 1.0)?;
        }
        Ok(())
    }
}

impl PanelAssembly {
    /// Returns the chassis and the sail (solar array) of Lu (2024) as a list of panels.
    pub(in crate::photometry) fn chassis_and_sail(shape: &SatelliteShape, coefficients: &Coefficients) -> Self {
        let Coefficients { c1, c2, c3, c4, c5, n_sail, n_base } = *coefficients;
        let lambert = |albedo| Law::Lambert(Lambert { albedo });
        let phong = |weight, exponent| Law::Phong(Phong { weight, exponent });
        let sail = AssembledPanel {
            name: "sail".to_owned(),
            anchor_m: Vector3::zeros(),
            u_m: [-0.5 * shape.sail_width_m, 0.5 * shape.sail_width_m],
            v_m: [0.0, shape.sail_length_m],
            attitude: Attitude::SunAzimuth(PanelOffset::Constant(shape.panel_offset_deg.to_radians())),
            front: vec![phong(c1, n_sail), lambert(c2)],
            back: Vec::new(),
            through: vec![lambert(c3)],
            earthshine: false,
            blockers: vec![1],
        };
        let chassis = AssembledPanel {
            name: "chassis".to_owned(),
            anchor_m: Vector3::zeros(),
            u_m: [-0.5 * shape.base_width_m, 0.5 * shape.base_width_m],
            v_m: [0.0, shape.base_length_m],
            attitude: Attitude::Nadir,
            front: vec![phong(c4, n_base), lambert(c5)],
            back: Vec::new(),
            through: Vec::new(),
            earthshine: true,
            blockers: Vec::new(),
        };
        Self::new(vec![sail, chassis], Vec::new())
    }
}

impl SphereSpec {
    fn validate(&self, check: &Check, spec: &PanelsSpec) -> Result<(), Error> {
        let key = format!("panels.spheres.{}", self.name);
        check.range(&format!("{key}.area_m2"), self.area_m2, 1e-4, 1e4)?;
        self.term().validate(check, &key, spec)
    }

    fn term(&self) -> Term<'_> {
        Term::new("albedo", &self.albedo, [0.0, 10.0], [0.0, 1.0]).proportional()
    }
}

impl PanelSpec {
    /// Returns every law with the name of its face.
    fn laws(&self) -> impl Iterator<Item = (&'static str, &LawSpec)> {
        let front = self.front.iter().map(|law| ("front", law));
        let back = self.back.iter().map(|law| ("back", law));
        front.chain(back).chain(self.through.iter().map(|law| ("through", law)))
    }

    fn validate(&self, check: &Check, spec: &PanelsSpec) -> Result<(), Error> {
        let key = |rest: &str| format!("panels.{}.{rest}", self.name);
        for (axis, value) in ["x", "y", "z"].into_iter().zip(self.anchor_m) {
            check.range(&key(&format!("anchor_m ({axis})")), value, -200.0, 200.0)?;
        }
        for (edge, [from, to]) in [("u_m", self.u_m), ("v_m", self.v_m)] {
            check.range(&key(&format!("{edge}[0]")), from, -200.0, 200.0)?;
            check.range(&key(&format!("{edge}[1]")), to, from + 0.01, 200.0)?;
        }
        self.attitude.validate(check, &key("attitude"))?;
        if self.laws().next().is_none() {
            return Err(check.reference(&key("front"), "nothing", "at least one law on one face".to_owned()));
        }
        for (face, law) in self.laws() {
            law.validate(check, &key(face), spec)?;
        }
        Ok(())
    }
}

impl AttitudeSpec {
    fn validate(&self, check: &Check, key: &str) -> Result<(), Error> {
        match self {
            Self::Nadir {} => Ok(()),
            Self::SunAzimuth { offset_deg } | Self::SunTracking { offset_deg } => {
                let key = format!("{key}.offset_deg");
                match offset_deg {
                    OffsetSpec::Constant(offset_deg) => check.range(&key, *offset_deg, -180.0, 180.0),
                    OffsetSpec::Table(rows) => {
                        check.count(&format!("{key} (rows)"), rows.len(), 1, 1000)?;
                        let mut least_deg = -90.0;
                        for [latitude_deg, offset_deg] in rows {
                            check.range(&format!("{key} (Sun's latitude)"), *latitude_deg, least_deg, 90.0)?;
                            check.range(&key, *offset_deg, -180.0, 180.0)?;
                            least_deg = latitude_deg + 1e-6;
                        }
                        Ok(())
                    }
                }
            }
            Self::Fixed { normal, v } => {
                let (normal, v) = (Vector3::from(*normal), Vector3::from(*v));
                check.range(&format!("{key}.normal (length)"), normal.norm(), 1e-6, 1e6)?;
                check.range(&format!("{key}.v (length)"), v.norm(), 1e-6, 1e6)?;
                let cosine = normal.normalize().dot(&v.normalize());
                check.range(&format!("{key}.v (cosine with the normal)"), cosine, -1e-6, 1e-6)
            }
        }
    }

    fn attitude(&self) -> Attitude {
        let offset = |offset: &OffsetSpec| match offset {
            OffsetSpec::Constant(offset_deg) => PanelOffset::Constant(offset_deg.to_radians()),
            OffsetSpec::Table(rows) => PanelOffset::Table(rows.iter().map(|row| row.map(f64::to_radians)).collect()),
        };
        match self {
            Self::Nadir {} => Attitude::Nadir,
            Self::SunAzimuth { offset_deg } => Attitude::SunAzimuth(offset(offset_deg)),
            Self::SunTracking { offset_deg } => Attitude::SunTracking(offset(offset_deg)),
            Self::Fixed { normal, v } => {
                let normal = Vector3::from(*normal).normalize();
                let v = Vector3::from(*v);
                // v is made perpendicular to the normal within rounding.
                Attitude::Fixed { normal, v: (v - normal * normal.dot(&v)).normalize() }
            }
        }
    }
}

/// A coefficient of a law that may refer to a parameter.
pub(crate) struct Term<'a> {
    key: &'static str,
    pub(crate) coefficient: &'a Coefficient,
    /// Range that is allowed in files.
    allowed: [f64; 2],
    /// Range that is allowed in fits.
    fitted: [f64; 2],
    /// True if the light is proportional to the coefficient.
    pub(crate) is_linear: bool,
}

impl<'a> Term<'a> {
    fn new(key: &'static str, coefficient: &'a Coefficient, allowed: [f64; 2], fitted: [f64; 2]) -> Self {
        Self { key, coefficient, allowed, fitted, is_linear: false }
    }

    fn proportional(self) -> Self {
        Self { is_linear: true, ..self }
    }

    fn validate(&self, check: &Check, owner: &str, spec: &PanelsSpec) -> Result<(), Error> {
        let key = format!("{owner}.{}", self.key);
        match (spec.value(self.coefficient, &[]), self.coefficient) {
            (Some(value), _) => check.range(&key, value, self.allowed[0], self.allowed[1]),
            (None, Coefficient::Parameter(given)) => {
                let known: Vec<&str> = spec.parameters.iter().map(|parameter| parameter.name.as_str()).collect();
                Err(check.reference(&key, given, format!("a number or one of {}", known.join(", "))))
            }
            (None, Coefficient::Number(_)) => Ok(()),
        }
    }
}

impl LawSpec {
    /// Returns the coefficient to which the light is proportional; `None` for the binomial law.
    #[cfg(feature = "fit")]
    fn strength_mut(&mut self) -> Option<&mut Coefficient> {
        match self {
            Self::Lambert { albedo } => Some(albedo),
            Self::Abg { a, .. } => Some(a),
            Self::Gaussian { peak_per_sr, .. } => Some(peak_per_sr),
            Self::Phong { weight, .. }
            | Self::Straight { weight, .. }
            | Self::Retro { weight, .. }
            | Self::Facets { weight, .. } => Some(weight),
            Self::Binomial { .. } => None,
        }
    }

    /// Returns the coefficients that may be parameters.
    pub(crate) fn terms(&self) -> Vec<Term<'_>> {
        match self {
            Self::Lambert { albedo } => vec![Term::new("albedo", albedo, [0.0, 10.0], [0.0, 1.0]).proportional()],
            Self::Phong { weight, exponent }
            | Self::Straight { weight, exponent }
            | Self::Retro { weight, exponent } => vec![
                Term::new("weight", weight, [0.0, 10.0], [0.0, 1.0]).proportional(),
                Term::new("exponent", exponent, [0.0, 10_000.0], [0.5, 200.0]),
            ],
            Self::Abg { a, b, g } => vec![
                Term::new("a", a, [0.0, 1e3], [0.0, 100.0]).proportional(),
                Term::new("b", b, [1e-9, 1e3], [1e-6, 10.0]),
                Term::new("g", g, [0.0, 20.0], [0.1, 6.0]),
            ],
            Self::Gaussian { peak_per_sr, width } => vec![
                Term::new("peak_per_sr", peak_per_sr, [0.0, 1e6], [0.0, 1e3]).proportional(),
                Term::new("width", width, [1e-6, 10.0], [1e-3, 2.0]),
            ],
            Self::Facets { weight, slope } => vec![
                Term::new("weight", weight, [0.0, 10.0], [0.0, 1.0]).proportional(),
                Term::new("slope", slope, [1e-3, 1.0], [2e-3, 0.6]),
            ],
            Self::Binomial { .. } => Vec::new(),
        }
    }

    fn validate(&self, check: &Check, key: &str, spec: &PanelsSpec) -> Result<(), Error> {
        self.terms().iter().try_for_each(|term| term.validate(check, key, spec))?;
        let Self::Binomial { b, c, d, first } = self else { return Ok(()) };
        check.count(&format!("{key}.b (rows)"), b.len(), 1, 8)?;
        check.count(&format!("{key}.c (rows, as many as b)"), c.len(), b.len(), b.len())?;
        for (name, value) in [("b", b), ("c", c)] {
            for row in value {
                check.count(&format!("{key}.{name} (columns)"), row.len(), 0, 32)?;
                row.iter().try_for_each(|value| check.range(&format!("{key}.{name}"), *value, -100.0, 100.0))?;
            }
        }
        check.range(&format!("{key}.d"), *d, 1e-3, 1e3)?;
        check.range(&format!("{key}.first"), f64::from(*first), -20.0, 20.0)
    }

    fn law(&self, value_of: &impl Fn(&Coefficient) -> f64) -> Law {
        match self {
            Self::Lambert { albedo } => Law::Lambert(Lambert { albedo: value_of(albedo) }),
            Self::Phong { weight, exponent } => {
                Law::Phong(Phong { weight: value_of(weight), exponent: value_of(exponent) })
            }
            Self::Straight { weight, exponent } => {
                Law::Straight(Straight { weight: value_of(weight), exponent: value_of(exponent) })
            }
            Self::Retro { weight, exponent } => {
                Law::Retro(Retro { weight: value_of(weight), exponent: value_of(exponent) })
            }
            Self::Facets { weight, slope } => Law::Facets(Facets { weight: value_of(weight), slope: value_of(slope) }),
            Self::Abg { a, b, g } => Law::Abg(Abg { a: value_of(a), b: value_of(b), g: value_of(g) }),
            Self::Gaussian { peak_per_sr, width } => {
                Law::Gaussian(Gaussian { peak_per_sr: value_of(peak_per_sr), width: value_of(width) })
            }
            Self::Binomial { b, c, d, first } => {
                Law::Binomial(Binomial { b: b.clone(), c: c.clone(), d: *d, first: *first })
            }
        }
    }
}
