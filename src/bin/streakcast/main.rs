//! Command line: reads flags, calls the library, prints its answers.

mod arguments;
mod cache;
mod failure;
mod notices;
mod output;
mod screen;
mod verbs;

use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};

use failure::{exit_code, report_usage};
use verbs::annotate::AnnotateArguments;
use verbs::doctor::DoctorArguments;
#[cfg(feature = "fetch")]
use verbs::fetch::FetchArguments;
#[cfg(feature = "fit")]
use verbs::fit::FitArguments;
use verbs::flag::FlagArguments;
use verbs::forecast::ForecastArguments;
use verbs::gate::GateArguments;
use verbs::identify::IdentifyArguments;
#[cfg(feature = "fits")]
use verbs::inject::InjectArguments;
use verbs::lists::ListArguments;
use verbs::map::MapArguments;
use verbs::model::ModelArguments;
use verbs::passes::PassesArguments;
#[cfg(feature = "plot")]
use verbs::plot::PlotArguments;
use verbs::reproduce::ReproduceArguments;
#[cfg(feature = "serve")]
use verbs::serve::ServeArguments;
use verbs::statistics::StatisticsArguments;
use verbs::windows::WindowsArguments;

/// Satellites crossing astronomers' exposures: which, when, where and how bright.
#[derive(Parser)]
#[command(name = "streakcast", version, arg_required_else_help = true, propagate_version = true)]
struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    /// Every satellite that crosses the field during one exposure, with times, track and magnitude
    Passes(Box<PassesArguments>),
    /// One verdict for each exposure of a schedule, with reasons and the next clear start
    Flag(Box<FlagArguments>),
    /// The schedule file with all its cells unchanged, and flags and streaks beside them
    Annotate(Box<AnnotateArguments>),
    /// Time windows in which targets can be exposed without any satellite that matters
    Windows(Box<WindowsArguments>),
    /// Every visible pass of a night: rise, culmination, set, shadow, peak magnitude
    Forecast(Box<ForecastArguments>),
    /// Waits until an exposure can start clear: before each frame of Ekos, N.I.N.A. or a script
    Gate(Box<GateArguments>),
    /// Satellites that may have made a measured streak: ranked candidates
    Identify(Box<IdentifyArguments>),
    /// Maps of magnitude over a satellite's own sky and over that of a site
    Map(MapArguments),
    /// Pictures: nights, fields, light curves, skies, fits, as PNG and SVG with their data beside
    #[cfg(feature = "plot")]
    Plot(Box<PlotArguments>),
    /// Streaks of satellites, or random ones, put into frames, with masks and their truth
    #[cfg(feature = "fits")]
    Inject(Box<InjectArguments>),
    /// Element sets from CelesTrak, Space-Track or SatChecker into a cache, politely
    #[cfg(feature = "fetch")]
    Fetch(Box<FetchArguments>),
    /// From photometry to a brightness model
    #[cfg(feature = "fit")]
    Fit(Box<FitArguments>),
    /// A web page and an HTTP API on this machine: the night of a schedule, and the effect of other start times
    #[cfg(feature = "serve")]
    Serve(Box<ServeArguments>),
    /// How many satellites are lit over a site, how bright, and how many trails an exposure gets
    Statistics(Box<StatisticsArguments>),
    /// Counts of a paper beside ours
    Reproduce(ReproduceArguments),
    /// The brightness models: list, show, check
    Model(ModelArguments),
    /// Config check for tonight: element ages, Earth orientation, clock, site, models, cache
    Doctor(Box<DoctorArguments>),
    /// The observatories known by name and MPC code
    Sites(ListArguments),
    /// The synthetic constellations for --shells
    Shells(ListArguments),
}

fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => return report_usage(&error, Arguments::command()),
    };
    exit_code(match arguments.verb {
        Verb::Passes(typed) => verbs::passes::run(*typed),
        Verb::Flag(typed) => verbs::flag::run(*typed),
        Verb::Annotate(typed) => verbs::annotate::run(*typed),
        Verb::Windows(typed) => verbs::windows::run(*typed),
        Verb::Forecast(typed) => verbs::forecast::run(*typed),
        Verb::Gate(typed) => verbs::gate::run(*typed),
        Verb::Identify(typed) => verbs::identify::run(*typed),
        Verb::Map(typed) => verbs::map::run(typed),
        #[cfg(feature = "plot")]
        Verb::Plot(typed) => verbs::plot::run(*typed),
        #[cfg(feature = "fits")]
        Verb::Inject(typed) => verbs::inject::run(*typed),
        #[cfg(feature = "fetch")]
        Verb::Fetch(typed) => verbs::fetch::run(&typed),
        #[cfg(feature = "fit")]
        Verb::Fit(typed) => verbs::fit::run(*typed),
        #[cfg(feature = "serve")]
        Verb::Serve(typed) => verbs::serve::run(*typed),
        Verb::Model(typed) => verbs::model::run(typed),
        Verb::Doctor(typed) => verbs::doctor::run(*typed),
        Verb::Statistics(typed) => verbs::statistics::run(*typed),
        Verb::Reproduce(typed) => verbs::reproduce::run(typed),
        Verb::Sites(typed) => verbs::lists::sites(&typed),
        Verb::Shells(typed) => verbs::lists::shells(&typed),
    })
}
