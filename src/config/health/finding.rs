//! Result of the check of one subject: severity, text and remedy.

use std::fmt;

use crate::output::{Column, Kind, Table};

/// Severity of a finding.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// No problem.
    Fine,
    /// Information; results are not affected.
    Note,
    /// The input is not given, and therefore not checked.
    Unchecked,
    /// Results are less accurate or incomplete.
    Warning,
    /// No results can be computed, or they would be wrong.
    Error,
}

impl Severity {
    /// Returns the name in outputs.
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

/// Source of the time of a check.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum MomentSource {
    /// System clock, which may be wrong.
    Clock,
    /// Time given by the user.
    Given,
}

/// Result of the check of one subject.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Severity.
    pub severity: Severity,
    /// Subject, for example elements, clock or Earth orientation.
    pub subject: &'static str,
    /// Result of the check, with its numbers.
    pub finding: String,
    /// Remedy; empty if none is needed.
    pub remedy: String,
}

impl Finding {
    /// Returns a finding with its remedy.
    pub fn new(severity: Severity, subject: &'static str, finding: impl ToString, remedy: impl ToString) -> Self {
        Self { severity, subject, finding: finding.to_string(), remedy: remedy.to_string() }
    }

    /// Returns a finding of severity `Error`.
    pub fn error(subject: &'static str, finding: impl ToString, remedy: impl ToString) -> Self {
        Self::new(Severity::Error, subject, finding, remedy)
    }

    /// Returns a finding of severity `Warning`.
    pub fn warning(subject: &'static str, finding: impl ToString, remedy: impl ToString) -> Self {
        Self::new(Severity::Warning, subject, finding, remedy)
    }

    /// Returns a finding of severity `Note`.
    pub fn note(subject: &'static str, finding: impl ToString, remedy: impl ToString) -> Self {
        Self::new(Severity::Note, subject, finding, remedy)
    }

    /// Returns a finding of severity `Fine`, without a remedy.
    pub fn fine(subject: &'static str, finding: impl ToString) -> Self {
        Self::new(Severity::Fine, subject, finding, "")
    }
}

/// Returns the findings as a table, in their order.
pub fn finding_table(findings: &[Finding]) -> Table {
    Table {
        columns: vec![
            Column::new("severity", Kind::Text, "fine, note, unchecked, warning or error."),
            Column::new("subject", Kind::Text, "Subject of the check."),
            Column::new("finding", Kind::Text, "Result of the check."),
            Column::new("remedy", Kind::Text, "Remedy; empty if none is needed."),
        ],
        rows: findings
            .iter()
            .map(|finding| {
                let remedy = Some(finding.remedy.as_str()).filter(|remedy| !remedy.is_empty());
                vec![
                    finding.severity.name().into(),
                    finding.subject.into(),
                    finding.finding.as_str().into(),
                    remedy.into(),
                ]
            })
            .collect(),
    }
}
