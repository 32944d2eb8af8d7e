//! Form of the model to fit, from the flags: model, free parameters, loss function.

use anyhow::anyhow;
use streakcast::fit::{FitSettings, Form, Loss, PanelsForm, Parameter, TwoPanelForm};
use streakcast::photometry::{Band, Earthshine, ModelFile, ModelLibrary, PANEL_OFFSET};

use super::arguments::{FormArguments, LossName};
use crate::verbs::map::model_of;

/// Model to fit, with its settings.
pub struct ChosenForm {
    pub file: ModelFile,
    /// Band of the model.
    pub band: Band,
    pub form: FittedForm,
    pub settings: FitSettings,
}

/// Form of a brightness model that can be fitted.
pub enum FittedForm {
    TwoPanel(TwoPanelForm),
    Panels(PanelsForm),
}

impl FittedForm {
    pub fn as_form(&self) -> &dyn Form {
        match self {
            Self::TwoPanel(form) => form,
            Self::Panels(form) => form,
        }
    }

    /// Returns the two-panel form of Lu (2024) with the sizes of this form; `None` if this form has no such sizes.
    pub fn as_two_panels(&self) -> Option<TwoPanelForm> {
        match self {
            Self::TwoPanel(form) => Some(form.clone()),
            Self::Panels(form) => form.as_two_panels(),
        }
    }

    /// Returns the form in a box.
    pub fn boxed(&self) -> Box<dyn Form> {
        match self {
            Self::TwoPanel(form) => Box::new(form.clone()),
            Self::Panels(form) => Box::new(form.clone()),
        }
    }
}

/// Resolves form and settings of a fit.
pub fn form(typed: &FormArguments, raw_points: bool) -> anyhow::Result<ChosenForm> {
    let model = model_of(&ModelLibrary::embedded(), &typed.model)?;
    let file = model.file().cloned().ok_or_else(|| {
        anyhow!(
            "model {} has no file; allowed: models of kind two_panel or panels (streakcast model list)",
            typed.model
        )
    })?;
    let (band, system) = model.band();
    let sun_magnitude = band.sun_magnitude(system);
    let earthshine = if typed.no_earthshine { Earthshine::Off } else { Earthshine::Computed };
    let form = match (TwoPanelForm::from_model(&model, earthshine), &file.panels) {
        (Some(form), _) => FittedForm::TwoPanel(form),
        (None, Some(spec)) => FittedForm::Panels(PanelsForm { spec: spec.clone(), earthshine, sun_magnitude }),
        _ => {
            let allowed = "allowed: models of kind two_panel or panels (streakcast model list)";
            return Err(anyhow!("model {} has no parameters to fit; {allowed}", typed.model));
        }
    };
    let parameters = form.as_form().parameters();
    let known = || parameters.iter().map(|parameter| parameter.name.as_str()).collect::<Vec<_>>().join(", ");
    let mut held = Vec::new();
    for entry in &typed.hold {
        let parsed =
            entry.split_once('=').and_then(|(name, value)| Some((name.trim(), value.trim().parse::<f64>().ok()?)));
        let (name, value) =
            parsed.ok_or_else(|| anyhow!("invalid hold {entry}; allowed: NAME=NUMBER, for example c1=0"))?;
        let found = parameters.iter().find(|parameter| parameter.name == name);
        let parameter = found.ok_or_else(|| anyhow!("unknown parameter {name} in hold; allowed: {}", known()))?;
        if !(parameter.least..=parameter.greatest).contains(&value) {
            return Err(anyhow!("hold {name} is {value}; allowed: {} to {}", parameter.least, parameter.greatest));
        }
        held.push((name.to_owned(), value));
    }
    let mut free = typed.free.clone();
    if free.is_empty() {
        let fitted = |parameter: &&Parameter| parameter.name != PANEL_OFFSET;
        free = parameters.iter().filter(fitted).map(|parameter| parameter.name.clone()).collect();
    }
    if let Some(name) = free.iter().find(|name| parameters.iter().all(|parameter| parameter.name != **name)) {
        return Err(anyhow!("unknown parameter {name} in free; allowed: {}", known()));
    }
    free.retain(|name| held.iter().all(|(other, _)| other != name));
    let loss = match typed.loss {
        Some(LossName::Squares) => Loss::Squares,
        Some(LossName::SoftL1) => Loss::SoftL1,
        Some(LossName::Student) => Loss::Student(4.0),
        None if raw_points => Loss::SoftL1,
        None => Loss::Squares,
    };
    Ok(ChosenForm { file, band, form, settings: FitSettings { free, held, loss, ..FitSettings::default() } })
}
