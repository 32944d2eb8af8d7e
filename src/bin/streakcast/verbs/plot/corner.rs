//! `plot corner`: plots the posterior distribution of a fit from its saved samples.

use anyhow::{anyhow, bail};
use streakcast::fit::read_chain;
use streakcast::output::Provenance;
use streakcast::plot::{Corner, corner};

use super::arguments::PlotCornerArguments;
use crate::failure::Outcome;

use super::target::Target;
use crate::notices::Notices;

/// Largest number of parameters in a picture.
const MOST: usize = 9;

pub fn corner_plot(typed: PlotCornerArguments) -> anyhow::Result<Outcome> {
    let notices = Notices::new(typed.quiet);
    // There is no data file: the chain file contains the data.
    let target = Target::of_table(&typed.picture)?;
    let (chain, about) = read_chain(&typed.chains)?;
    let known = &about.parameters;
    let selected: Vec<usize> = match typed.parameters.as_slice() {
        [] => (0..known.len().min(MOST)).collect(),
        names => names
            .iter()
            .map(|name| {
                let index = known.iter().position(|parameter| parameter == name);
                index.ok_or_else(|| anyhow!("unknown parameter '{name}' in the chains; allowed: {}", known.join(", ")))
            })
            .collect::<anyhow::Result<_>>()?,
    };
    let burn_in = typed.burn_in.unwrap_or(chain.steps() / 4);
    if burn_in >= chain.steps() {
        bail!("burn-in is {burn_in}; allowed: less than the {} steps of the chains", chain.steps());
    }
    let names: Vec<String> = selected.iter().map(|&index| known[index].clone()).collect();
    let samples: Vec<Vec<f64>> = selected.iter().map(|&index| chain.column(index, burn_in)).collect();
    let default_title =
        format!("Posterior: {} walkers, {} steps after burn-in", chain.walkers(), chain.steps() - burn_in);
    let title = typed.title.title.as_deref().unwrap_or(&default_title);
    let mut provenance = Provenance::new();
    provenance.state("chains", typed.chains.display().to_string());
    provenance.state("chains_software", about.software.as_str());
    provenance.state("fit_fingerprint", about.fingerprint.as_str());
    provenance.state("seed", about.seed);
    provenance.state("burn_in", burn_in);
    provenance.state("parameters", names.as_slice());
    target.write_picture(
        &corner(&Corner { title, names: &names, samples: &samples, truths: None, bounds: None })?,
        &provenance,
        &notices,
    )?;
    Ok(Outcome::Done)
}
