//! The walkers of `fit run --mcmc`: a chain begun, or one gone on with, drawn and saved on the way.

use std::path::Path;

use anyhow::anyhow;
use indicatif::ProgressBar;
use streakcast::fit::{
    Chain, ChainAbout, Fit, Posterior, PosteriorSettings, Problem, draw, posterior, read_chain, write_chain,
};

use super::arguments::FitRunArguments;
use super::points::Placed;

/// Chains are saved after so many steps, if at all.
const SAVED_EVERY: usize = 500;

/// A chain that is to be drawn.
pub struct Begun {
    settings: PosteriorSettings,
    about: ChainAbout,
    resumed: Option<Chain>,
}

/// What is drawn, and the chain that it goes on from, if there is one.
pub fn begun(typed: &FitRunArguments, placed: &Placed, problem: &Problem, steps: usize) -> anyhow::Result<Begun> {
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
        return Err(anyhow!("mcmc {steps}: the chains hold {} steps already; allowed: as many or more", chain.steps()));
    }
    if let Some(chain) = &resumed {
        placed.notices.say(&format!("going on after {} steps", chain.steps()));
    }
    Ok(Begun { settings, about, resumed })
}

pub fn drawn(
    typed: &FitRunArguments,
    placed: &Placed,
    problem: &Problem,
    fit: &Fit,
    begun: Begun,
) -> anyhow::Result<(Chain, Posterior)> {
    let Begun { settings, about, resumed } = begun;
    let bar: ProgressBar = placed.notices.steps(settings.steps);
    let objective = problem.objective();
    let save = |chain: &Chain| typed.chains.as_deref().map_or(Ok(()), |path| write_chain(path, chain, &about));
    let chain = draw(&objective, fit, &settings, resumed, |chain| {
        bar.set_position(chain.steps() as u64);
        if chain.steps() % SAVED_EVERY == 0 { save(chain) } else { Ok(()) }
    })?;
    bar.finish_and_clear();
    save(&chain)?;
    let found = posterior(&chain, fit, typed.burn_in);
    let slow = found.marginals.iter().filter(|marginal| !marginal.autocorrelation.is_trusted);
    for marginal in slow {
        let tau = marginal.autocorrelation.steps;
        placed.notices.say(&format!(
            "warning: {} moves slowly: {} steps are fewer than 50 of its autocorrelation times ({tau:.0} steps)",
            marginal.name, found.steps
        ));
    }
    Ok((chain, found))
}

/// A chain of the same fit, to go on with.
fn resumed(path: &Path, about: &ChainAbout, typed: &FitRunArguments) -> anyhow::Result<Chain> {
    let (chain, was) = read_chain(path)?;
    let same = was.fingerprint == about.fingerprint && was.seed == about.seed && was.parameters == about.parameters;
    if !same || chain.walkers() != typed.walkers {
        return Err(anyhow!(
            "chains {}: they are of another fit (other points, parameters, walkers or seed); allowed: the same, or a new file",
            path.display()
        ));
    }
    Ok(chain)
}
