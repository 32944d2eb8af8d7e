//! Command line program: parses flags, calls the library, writes the results.

mod arguments;
mod cache;
mod clock;
mod failure;
mod files;
mod help;
mod home;
mod local_time;
mod notices;
mod output;
mod rejected;
mod required;
mod screen;
mod signals;
mod start;
mod verb_tables;
mod verbs;

use std::ffi::OsString;
use std::process::ExitCode;

use anyhow::anyhow;
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use failure::{exit_code, report_usage, usage_message};
use verb_tables::Words;
use verbs::alarms::AlarmsArguments;
use verbs::annotate::AnnotateArguments;
use verbs::doctor::DoctorArguments;
use verbs::ephemeris::EphemerisArguments;
use verbs::fetch::FetchArguments;
use verbs::fit::FitArguments;
use verbs::flag::FlagArguments;
use verbs::forecast::ForecastArguments;
use verbs::gate::GateArguments;
use verbs::identify::IdentifyArguments;
#[cfg(unix)]
use verbs::inject::InjectArguments;
use verbs::learn::LearnArguments;
use verbs::lists::{ListArguments, ShellArguments};
use verbs::map::MapArguments;
#[cfg(unix)]
use verbs::mask::MaskArguments;
#[cfg(unix)]
use verbs::measure::MeasureArguments;
use verbs::model::ModelArguments;
use verbs::passes::PassesArguments;
use verbs::plot::PlotArguments;
use verbs::reproduce::ReproduceArguments;
use verbs::serve::ServeArguments;
use verbs::setup::SetupArguments;
use verbs::shell_files::{CompletionsArguments, ManArguments};
use verbs::statistics::StatisticsArguments;
use verbs::windows::WindowsArguments;

/// Predicts satellites that cross astronomical exposures: which, when, where and how bright.
#[derive(Parser)]
#[command(name = "streakcast", version, arg_required_else_help = true, propagate_version = true)]
struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    /// List the satellites that cross the field during one exposure, with times, tracks and magnitudes
    ///
    /// The exit status is 1 if no satellite crosses.
    Passes(Box<PassesArguments>),
    /// Give a verdict for each exposure of a schedule, with reasons and the next clear start
    Flag(Box<FlagArguments>),
    /// Write a copy of the schedule file with verdicts and streaks added and all other cells unchanged
    Annotate(Box<AnnotateArguments>),
    /// Find time windows in which targets can be exposed without a crossing above the limits
    Windows(Box<WindowsArguments>),
    /// List the visible passes of a night: rise, culmination, set, shadow, peak magnitude
    Forecast(Box<ForecastArguments>),
    /// Compute positions, rates, brightness and along-track errors of chosen satellites at given times
    ///
    /// The exit status is 1 if there is no position.
    Ephemeris(Box<EphemerisArguments>),
    /// Wait until an exposure can start without a crossing, before each frame of Ekos, N.I.N.A. or a script
    Gate(Box<GateArguments>),
    /// Identify the satellite of a measured streak: ranked candidates
    ///
    /// The exit status is 1 if there is no candidate, or none that fits.
    Identify(Box<IdentifyArguments>),
    /// Map magnitudes over the sky of a site or over the directions around a satellite
    Map(MapArguments),
    /// Plot nights, fields, light curves, skies and fits as PNG or SVG, with data files
    Plot(Box<PlotArguments>),
    /// Inject streaks of satellites, or random ones, into frames, with masks and truth tables
    #[cfg(unix)]
    Inject(Box<InjectArguments>),
    /// Measure the streaks of predicted satellites in frames: magnitude, lateness, offset, or upper limits
    ///
    /// The exit status is 1 if no streak is predicted.
    #[cfg(unix)]
    Measure(Box<MeasureArguments>),
    /// Mask the streaks of satellites in frames: mask files, bits of mask planes, regions, polygons on the sky
    #[cfg(unix)]
    Mask(Box<MaskArguments>),
    /// Download element sets from CelesTrak, Space-Track or SatChecker into a cache, with rate limits
    Fetch(Box<FetchArguments>),
    /// Fit a brightness model to photometry
    Fit(Box<FitArguments>),
    /// Learn from measurements how satellites and kinds differ from their brightness models, for --learned
    Learn(Box<LearnArguments>),
    /// List passes with improbable or periodic brightness, and satellites with trends, compared with learned magnitudes
    Alarms(Box<AlarmsArguments>),
    /// Serve a web page and an HTTP API that show the nights of a schedule and the effect of other start times
    Serve(Box<ServeArguments>),
    /// Count sunlit satellites over a site, their magnitudes, and the trails per exposure
    Statistics(Box<StatisticsArguments>),
    /// Compare published counts of satellites with computed ones
    Reproduce(ReproduceArguments),
    /// List, show and check brightness models
    Model(ModelArguments),
    /// Ask for site, time zone, element sets, camera and limit, and write the home file with the answers
    Setup(SetupArguments),
    /// Check the setup: element ages, Earth orientation, clock, site, models, cache
    Doctor(Box<DoctorArguments>),
    /// List the observatories by name and MPC code
    ///
    /// The exit status is 1 if a search finds nothing.
    Sites(ListArguments),
    /// List the simulated constellations for --shells, bundled or of a file
    ///
    /// The exit status is 1 if a search finds nothing.
    Shells(ShellArguments),
    /// Write the completions of a shell to standard output
    Completions(CompletionsArguments),
    /// Write the manual pages into a folder
    Man(ManArguments),
}

fn main() -> ExitCode {
    let command = rejected::hide(help::complete(Arguments::command()));
    let typed: Vec<OsString> = std::env::args_os().collect();
    // Errors in a file are faults of the gate, which may not stop an exposure.
    let is_gate = typed.get(1).is_some_and(|verb| verb == "gate");
    let mut file_error = None;
    let mut words = match verb_tables::insert(&command, typed.clone(), home::file().as_deref()) {
        Ok(words) => words,
        Err(error) if is_gate => {
            file_error = Some(error);
            Words::typed(typed.clone())
        }
        Err(error) => return exit_code(Err(error)),
    };
    let parse =
        |words: &Words| command.clone().try_get_matches_from(clock::expand(words.words.iter().cloned(), clock::now()));
    let matches = match parse(&words) {
        Err(error) if is_gate && words.place_of(&error).is_some() => {
            file_error = Some(anyhow!(usage_message(&error, command.clone(), words.place_of(&error))));
            words = Words::typed(typed.clone());
            parse(&words)
        }
        matches => matches,
    };
    let matches = match matches {
        Ok(matches) => matches,
        Err(error) => return report_usage(&error, command, words.place_of(&error)),
    };
    if let Err(error) = rejected::check(&matches).and_then(|()| files::check(&command, &matches)) {
        return exit_code(Err(error));
    }
    let mut arguments = match Arguments::from_arg_matches(&matches) {
        Ok(arguments) => arguments,
        Err(error) => return report_usage(&error, command, words.place_of(&error)),
    };
    // The same for values that the parser does not check.
    if let (Verb::Gate(gate), Some(tables)) = (&arguments.verb, words.tables())
        && let Err(error) = verbs::gate::check_values(gate)
    {
        file_error = Some(anyhow!("{tables}: {error}"));
        arguments = match parse(&Words::typed(typed)).and_then(|matches| Arguments::from_arg_matches(&matches)) {
            Ok(arguments) => arguments,
            Err(error) => return report_usage(&error, command, None),
        };
    }
    let is_server = matches!(arguments.verb, Verb::Serve(_));
    // The server handles signals itself, and writes no files.
    if !is_server {
        signals::remove_files_at_end();
    }
    let outcome = match arguments.verb {
        Verb::Passes(typed) => verbs::passes::run(*typed),
        Verb::Flag(typed) => verbs::flag::run(*typed),
        Verb::Annotate(typed) => verbs::annotate::run(*typed),
        Verb::Windows(typed) => verbs::windows::run(*typed),
        Verb::Forecast(typed) => verbs::forecast::run(*typed),
        Verb::Ephemeris(typed) => verbs::ephemeris::run(*typed),
        Verb::Gate(typed) => verbs::gate::run(*typed, file_error),
        Verb::Identify(typed) => verbs::identify::run(*typed),
        Verb::Map(typed) => verbs::map::run(typed),
        Verb::Plot(typed) => verbs::plot::run(*typed),
        #[cfg(unix)]
        Verb::Inject(typed) => verbs::inject::run(*typed),
        #[cfg(unix)]
        Verb::Measure(typed) => verbs::measure::run(*typed),
        #[cfg(unix)]
        Verb::Mask(typed) => verbs::mask::run(*typed),
        Verb::Fetch(typed) => verbs::fetch::run(&typed),
        Verb::Fit(typed) => verbs::fit::run(*typed),
        Verb::Learn(typed) => verbs::learn::run(*typed),
        Verb::Alarms(typed) => verbs::alarms::run(*typed),
        Verb::Serve(typed) => verbs::serve::run(*typed),
        Verb::Model(typed) => verbs::model::run(typed),
        Verb::Setup(typed) => verbs::setup::run(typed),
        Verb::Doctor(typed) => verbs::doctor::run(*typed, &command),
        Verb::Statistics(typed) => verbs::statistics::run(*typed),
        Verb::Reproduce(typed) => verbs::reproduce::run(typed),
        Verb::Sites(typed) => verbs::lists::sites(&typed),
        Verb::Shells(typed) => verbs::lists::shells(&typed),
        Verb::Completions(typed) => verbs::shell_files::completions(&typed, command),
        Verb::Man(typed) => verbs::shell_files::man(&typed, command),
    };
    exit_code(outcome.map_err(|error| match local_time::of_matches(&matches) {
        Some(zone) => local_time::with_offset(error, &zone),
        None => error,
    }))
}
