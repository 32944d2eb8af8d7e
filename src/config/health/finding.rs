//! One thing that was looked at: how bad it is, and what to do.

use std::fmt;

use crate::output::{Column, Kind, Table};

/// How bad.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// As it should be.
    Fine,
    /// Worth knowing; answers are right.
    Note,
    /// Not looked at, for it was not said: neither right nor wrong.
    Unchecked,
    /// Answers will be worse than they could be, or some are missing.
    Warning,
    /// There will be no answers, or wrong ones.
    Error,
}

impl Severity {
    /// Its word in outputs.
    pub fn name(self) -> &'static str {
        match self {
            Severity::Fine => "fine",
            Severity::Note => "note",
            Severity::Unchecked => "unchecked",
            Severity::Warning => "warning",
            Severity::Error => "error",
        }
    }
}

impl fmt::Display for Severity {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

/// Source of the moment.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum MomentSource {
    /// This machine's clock, which may be wrong.
    Clock,
    /// The user.
    Asked,
}

/// One finding.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// How bad.
    pub severity: Severity,
    /// What was looked at: elements, clock, Earth orientation, ...
    pub subject: &'static str,
    /// What was found, with its numbers.
    pub finding: String,
    /// What to do; empty where there is nothing to do.
    pub remedy: String,
}

impl Finding {
    /// A finding with what to do.
    pub fn new(
        severity: Severity,
        subject: &'static str,
        finding: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self { severity, subject, finding: finding.into(), remedy: remedy.into() }
    }

    /// One that asks for nothing.
    pub fn fine(subject: &'static str, finding: impl Into<String>) -> Self {
        Self::new(Severity::Fine, subject, finding, "")
    }
}

/// Findings as a table, in their order.
pub fn finding_table(findings: &[Finding]) -> Table {
    Table {
        columns: vec![
            Column::new("severity", Kind::Text, "fine, note, unchecked, warning or error."),
            Column::new("subject", Kind::Text, "What was looked at."),
            Column::new("finding", Kind::Text, "What was found."),
            Column::new("remedy", Kind::Text, "What to do; empty where there is nothing to do."),
        ],
        rows: findings
            .iter()
            .map(|one| {
                let remedy = Some(one.remedy.as_str()).filter(|remedy| !remedy.is_empty());
                vec![one.severity.name().into(), one.subject.into(), one.finding.as_str().into(), remedy.into()]
            })
            .collect(),
    }
}
