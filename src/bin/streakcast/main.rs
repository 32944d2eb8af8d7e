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
use help::Typed;
use verb_tables::Words;

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
    Passes(Typed<verbs::passes::PassesArguments>),
    /// Give a verdict for each exposure of a schedule, with reasons and the next clear start
    Flag(Typed<verbs::flag::FlagArguments>),
    /// Write a copy of the schedule file with verdicts and streaks added and all other cells unchanged
    Annotate(Typed<verbs::annotate::AnnotateArguments>),
    /// Find time windows in which targets can be exposed without a crossing above the limits
    Windows(Typed<verbs::windows::WindowsArguments>),
    /// List the visible passes of a night: rise, culmination, set, shadow, peak magnitude
    Forecast(Typed<verbs::forecast::ForecastArguments>),
    /// Compute positions, rates, brightness and along-track errors of chosen satellites at given times
    ///
    /// The exit status is 1 if there is no position.
    Ephemeris(Typed<verbs::ephemeris::EphemerisArguments>),
    /// Wait until an exposure can start without a crossing, before each frame of Ekos, N.I.N.A. or a script
    Gate(Typed<verbs::gate::GateArguments>),
    /// Identify the satellite of a measured streak: ranked candidates
    ///
    /// The exit status is 1 if there is no candidate, or none that fits.
    Identify(Typed<verbs::identify::IdentifyArguments>),
    /// Map magnitudes over the sky of a site or over the directions around a satellite
    Map(Typed<verbs::map::MapArguments>),
    /// Plot nights, fields, light curves, skies and fits as PNG or SVG, with data files
    Plot(Typed<verbs::plot::PlotArguments>),
    /// Inject streaks of satellites, or random ones, into frames, with masks and truth tables
    #[cfg(unix)]
    Inject(Typed<verbs::inject::InjectArguments>),
    /// Measure the streaks of predicted satellites in frames: magnitude, lateness, offset, or upper limits
    ///
    /// The exit status is 1 if no streak is predicted.
    #[cfg(unix)]
    Measure(Typed<verbs::measure::MeasureArguments>),
    /// Mask the streaks of satellites in frames: mask files, bits of mask planes, regions, polygons on the sky
    #[cfg(unix)]
    Mask(Typed<verbs::mask::MaskArguments>),
    /// Download element sets from CelesTrak, Space-Track or SatChecker into a cache, with rate limits
    Fetch(Typed<verbs::fetch::FetchArguments>),
    /// Fit a brightness model to photometry
    Fit(Typed<verbs::fit::FitArguments>),
    /// Learn from measurements how satellites and kinds differ from their brightness models, for --learned
    Learn(Typed<verbs::learn::LearnArguments>),
    /// List passes with improbable or periodic brightness, and satellites with trends, compared with learned magnitudes
    Alarms(Typed<verbs::alarms::AlarmsArguments>),
    /// Serve a web page and an HTTP API that show the nights of a schedule and the effect of other start times
    Serve(Typed<verbs::serve::ServeArguments>),
    /// Count sunlit satellites over a site, their magnitudes, and the trails per exposure
    Statistics(Typed<verbs::statistics::StatisticsArguments>),
    /// Compare published counts of satellites with computed ones
    Reproduce(Typed<verbs::reproduce::ReproduceArguments>),
    /// List, show and check brightness models
    Model(Typed<verbs::model::ModelArguments>),
    /// Ask for site, time zone, element sets, camera and limit, and write the home file with the answers
    Setup(Typed<verbs::setup::SetupArguments>),
    /// Check the setup: element ages, Earth orientation, clock, site, models, cache
    Doctor(Typed<verbs::doctor::DoctorArguments>),
    /// List the observatories by name and MPC code
    ///
    /// The exit status is 1 if a search finds nothing.
    Sites(Typed<verbs::lists::ListArguments>),
    /// List the simulated constellations for --shells, bundled or of a file
    ///
    /// The exit status is 1 if a search finds nothing.
    Shells(Typed<verbs::lists::ShellArguments>),
    /// Write the completions of a shell to standard output
    Completions(Typed<verbs::shell_files::CompletionsArguments>),
    /// Write the manual pages into a folder
    Man(Typed<verbs::shell_files::ManArguments>),
}

fn main() -> ExitCode {
    let command = help::complete(Arguments::command());
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
    let parse = |words: &Words| {
        help::parser(command.clone(), &words.words)
            .try_get_matches_from(clock::expand(words.words.iter().cloned(), clock::now()))
    };
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
    if let Err(error) = files::check(&command, &matches) {
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
        Verb::Passes(typed) => typed.run(verbs::passes::run),
        Verb::Flag(typed) => typed.run(verbs::flag::run),
        Verb::Annotate(typed) => typed.run(verbs::annotate::run),
        Verb::Windows(typed) => typed.run(verbs::windows::run),
        Verb::Forecast(typed) => typed.run(verbs::forecast::run),
        Verb::Ephemeris(typed) => typed.run(verbs::ephemeris::run),
        Verb::Gate(typed) => typed.run(|typed| verbs::gate::run(typed, file_error)),
        Verb::Identify(typed) => typed.run(verbs::identify::run),
        Verb::Map(typed) => typed.run(verbs::map::run),
        Verb::Plot(typed) => typed.run(verbs::plot::run),
        #[cfg(unix)]
        Verb::Inject(typed) => typed.run(verbs::inject::run),
        #[cfg(unix)]
        Verb::Measure(typed) => typed.run(verbs::measure::run),
        #[cfg(unix)]
        Verb::Mask(typed) => typed.run(verbs::mask::run),
        Verb::Fetch(typed) => typed.run(|typed| verbs::fetch::run(&typed)),
        Verb::Fit(typed) => typed.run(verbs::fit::run),
        Verb::Learn(typed) => typed.run(verbs::learn::run),
        Verb::Alarms(typed) => typed.run(verbs::alarms::run),
        Verb::Serve(typed) => typed.run(verbs::serve::run),
        Verb::Model(typed) => typed.run(verbs::model::run),
        Verb::Setup(typed) => typed.run(verbs::setup::run),
        Verb::Doctor(typed) => typed.run(|typed| verbs::doctor::run(typed, &command)),
        Verb::Statistics(typed) => typed.run(verbs::statistics::run),
        Verb::Reproduce(typed) => typed.run(verbs::reproduce::run),
        Verb::Sites(typed) => typed.run(|typed| verbs::lists::sites(&typed)),
        Verb::Shells(typed) => typed.run(|typed| verbs::lists::shells(&typed)),
        Verb::Completions(typed) => typed.run(|typed| verbs::shell_files::completions(&typed, command)),
        Verb::Man(typed) => typed.run(|typed| verbs::shell_files::man(&typed, command)),
    };
    exit_code(outcome.map_err(|error| {
        let names_file = error.downcast_ref::<streakcast::Error>().is_some_and(|error| error.file().is_some());
        let error = match local_time::of_matches(&matches) {
            Some(zone) => local_time::with_offset(error, &zone),
            None => error,
        };
        match words.place_in(&error.to_string()).filter(|_| !names_file) {
            Some(place) => anyhow!("{place}: {error}"),
            None => error,
        }
    }))
}
