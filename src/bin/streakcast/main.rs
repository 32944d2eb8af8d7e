//! The command line: it translates what was typed and prints what the library answers.

mod arguments;
mod cache;
mod failure;
mod notices;
mod output;
mod screen;
mod verbs;

use std::process::ExitCode;

use clap::Parser;

use arguments::{Arguments, Verb};
use failure::{exit_code, report_usage};

fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => return report_usage(&error),
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
