//! `identify`: which satellite a measured streak is of. `asked` makes a streak of what was typed, `run` answers.

mod asked;
mod run;

pub use run::run;
