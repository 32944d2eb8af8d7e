//! Posterior sampling of `fit run --mcmc`: starts or resumes a chain, and saves it regularly.

use std::path::Path;

use anyhow::anyhow;
use indicatif::ProgressBar;
use streakcast::fit::{
    Chain, ChainAbout, Fit, Posterior, PosteriorSettings, Problem, draw, posterior, read_chain, write_chain,
};

use super::arguments::FitRunArguments;
use super::points::FitInput;

/// Number of steps between two saves of the chains.
const SAVE_EVERY: usize = 500;

/// Sampling run, ready to start.
pub struct SamplingRun {
    settings: PosteriorSettings,
    about: ChainAbout,
    resumed: Option<Chain>,
}

/// Prepares a sampling run. If a saved chain exists, the run continues it.
pub fn prepare(
    typed: &FitRunArguments,
    input: &FitInput,
    problem: &Problem,
    steps: usize,
) -> anyhow::Result<SamplingRun> {
    let settings = PosteriorSettings { steps, burn_in: typed.burn_in, walkers: typed.walkers, seed: typed.seed };
    let about = ChainAbout {
        software: format!("streakcast {}", env!("CARGO_PKG_VERSION")),
        parameters: problem.objective().free_parameters().map(|parameter| parameter.name.clone()).collect(),
        seed: typed.seed,
        fingerprint: problem.fingerprint(),
    };
    let resumed =
        typed.chains.as_deref().filter(|path| path.exists()).map(|path| resumed(path, &about, typed)).transpose()?;
    if let Some(chain) = resumed.as_ref().filter(|chain| chain.steps() > steps) {
        return Err(anyhow!(
            "mcmc is {steps}, but the chains already have {} steps; allowed: as many or more",
            chain.steps()
        ));
    }
    if let Some(chain) = &resumed {
        input.notices.info(&format!("continuing after {} steps", chain.steps()));
    }
    Ok(SamplingRun { settings, about, resumed })
}

pub fn sample(
    typed: &FitRunArguments,
    input: &FitInput,
    problem: &Problem,
    fit: &Fit,
    run: SamplingRun,
) -> anyhow::Result<(Chain, Posterior)> {
    let SamplingRun { settings, about, resumed } = run;
    let bar: ProgressBar = input.notices.steps(settings.steps);
    let objective = problem.objective();
    let save = |chain: &Chain| typed.chains.as_deref().map_or(Ok(()), |path| write_chain(path, chain, &about));
    let chain = draw(&objective, fit, &settings, resumed, |chain| {
        bar.set_position(chain.steps() as u64);
        if chain.steps() % SAVE_EVERY == 0 { save(chain) } else { Ok(()) }
    })?;
    bar.finish_and_clear();
    save(&chain)?;
    typed.chains.iter().for_each(|path| input.notices.wrote(path));
    let found = posterior(&chain, fit, typed.burn_in);
    let slow = found.marginals.iter().filter(|marginal| !marginal.autocorrelation.is_trusted);
    for marginal in slow {
        let tau = marginal.autocorrelation.steps;
        input.notices.info(&format!(
            "warning: {} is not converged: {} steps are fewer than 50 of its autocorrelation times ({tau:.0} steps)",
            marginal.name, found.steps
        ));
    }
    Ok((chain, found))
}

/// Reads a saved chain, and checks that it belongs to the same fit.
fn resumed(path: &Path, about: &ChainAbout, typed: &FitRunArguments) -> anyhow::Result<Chain> {
    let (chain, was) = read_chain(path)?;
    let same = was.fingerprint == about.fingerprint && was.seed == about.seed && was.parameters == about.parameters;
    if !same || chain.walkers() != typed.walkers {
        return Err(anyhow!(
            "the chains {} are of another fit (other points, parameters, walkers or seed); allowed: chains of the same fit, or a new file",
            path.display()
        ));
    }
    Ok(chain)
}
