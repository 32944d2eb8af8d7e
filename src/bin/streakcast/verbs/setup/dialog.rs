//! Questions on a terminal, with answers from flags.

use std::io::{IsTerminal, Write, stdin, stdout};

use anyhow::{anyhow, bail};

/// Source of answers: flags, then the keyboard if standard input is a terminal, then defaults.
pub struct Dialog {
    is_terminal: bool,
}

/// One question: text, flag that answers it, and default; an empty default is none.
pub struct Prompt<'a> {
    pub text: &'a str,
    pub flag: &'a str,
    pub default: &'a str,
}

impl Dialog {
    pub fn new() -> Self {
        Self { is_terminal: stdin().is_terminal() && stdout().is_terminal() }
    }

    /// Returns the answer to a question as `read` converts it. On a terminal, the question is repeated after an invalid
    /// answer.
    ///
    /// # Errors
    /// The flag or the default is invalid, there is no answer, or standard input ends.
    pub fn answer<T>(
        &self,
        prompt: &Prompt<'_>,
        given: Option<&str>,
        read: impl Fn(&str) -> anyhow::Result<T>,
    ) -> anyhow::Result<T> {
        let Prompt { text, flag, default } = prompt;
        if let Some(given) = given {
            return read(given).map_err(|error| anyhow!("{flag}: {error}"));
        }
        if !self.is_terminal && default.is_empty() {
            bail!(
                "missing answer: {text}; specify {flag} (standard input is not a terminal, so that setup cannot ask)"
            );
        }
        if !self.is_terminal {
            return read(default);
        }
        loop {
            let shown = if default.is_empty() { String::new() } else { format!(" [{default}]") };
            let typed = line(&format!("{text}{shown}: "))?;
            let typed = if typed.is_empty() { default } else { typed.as_str() };
            match read(typed) {
                Ok(answer) => return Ok(answer),
                Err(error) => writeln!(stdout(), "  {error}")?,
            }
        }
    }

    /// Returns true if the user agrees; false without a terminal.
    pub fn agrees(&self, text: &str) -> anyhow::Result<bool> {
        Ok(self.is_terminal && matches!(line(&format!("{text} [y/N]: "))?.to_lowercase().as_str(), "y" | "yes"))
    }
}

/// Prints a text and reads the answer of one line, without blanks at its ends.
fn line(text: &str) -> anyhow::Result<String> {
    let mut out = stdout();
    write!(out, "{text}").and_then(|()| out.flush())?;
    let mut typed = String::new();
    if stdin().read_line(&mut typed)? == 0 {
        bail!("standard input ended before the last question; nothing was written");
    }
    Ok(typed.trim().to_owned())
}
