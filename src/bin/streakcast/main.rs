//! The command line: it translates what was typed and prints what the library answers.

fn main() {}
