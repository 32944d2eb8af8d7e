//! Reports in Markdown and HTML.

use std::fmt::Write;

use pulldown_cmark::{Options, Parser, html};

use crate::output::{Kind, Table};

/// Report with its parts in the order in which they are added.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    text: String,
}

impl Report {
    /// Report with this title.
    pub fn new(title: &str) -> Self {
        Self { text: format!("# {title}\n") }
    }

    /// Adds a heading of the second level.
    pub fn section(&mut self, title: &str) {
        let _ = write!(self.text, "\n## {title}\n");
    }

    /// Adds a paragraph.
    pub fn paragraph(&mut self, text: &str) {
        let _ = write!(self.text, "\n{}\n", plain(text));
    }

    /// Adds a list.
    pub fn list(&mut self, items: impl IntoIterator<Item = String>) {
        self.text.push('\n');
        for item in items {
            let _ = writeln!(self.text, "- {}", plain(&item));
        }
    }

    /// Adds a table; numbers have the digits of their columns.
    pub fn table(&mut self, table: &Table) {
        self.text.push('\n');
        let cell = |text: &str| plain(text).replace('|', "\\|");
        let heads = table.columns.iter().map(|column| cell(column.name));
        let _ = writeln!(self.text, "| {} |", heads.collect::<Vec<_>>().join(" | "));
        let rules = table.columns.iter().map(|column| match column.kind {
            Kind::Real { .. } | Kind::Integer => "---:",
            _ => "---",
        });
        let _ = writeln!(self.text, "| {} |", rules.collect::<Vec<_>>().join(" | "));
        for row in &table.rows {
            let cells = table.columns.iter().zip(row).map(|(column, value)| cell(&column.text(value)));
            let _ = writeln!(self.text, "| {} |", cells.collect::<Vec<_>>().join(" | "));
        }
    }

    /// Adds a picture by the name of its file, in the folder of the report.
    pub fn picture(&mut self, caption: &str, file: &str) {
        let _ = write!(self.text, "\n![{caption}](<{file}>)\n");
    }

    /// The report in Markdown.
    pub fn to_markdown(&self) -> &str {
        &self.text
    }

    /// The report as one HTML page; pictures are inlined if `picture` returns a data URL for their names.
    pub fn to_html(&self, picture: impl Fn(&str) -> Option<String>) -> String {
        let events = Parser::new_ext(&self.text, Options::ENABLE_TABLES).map(|event| match event {
            pulldown_cmark::Event::Start(pulldown_cmark::Tag::Image { link_type, dest_url, title, id }) => {
                let inlined = picture(&dest_url).map_or_else(|| dest_url.clone(), Into::into);
                pulldown_cmark::Event::Start(pulldown_cmark::Tag::Image { link_type, dest_url: inlined, title, id })
            }
            other => other,
        });
        let mut body = String::new();
        html::push_html(&mut body, events);
        let title = self.text.lines().next().unwrap_or_default().trim_start_matches("# ").to_owned();
        let mut escaped = String::new();
        // Titles contain names chosen by users.
        let _ = pulldown_cmark_escape::escape_html(&mut escaped, &title);
        format!(
            "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
             <title>{escaped}</title>\n<style>{STYLE}</style></head>\n<body>\n{body}</body></html>\n"
        )
    }
}

/// Escapes markup in text from outside.
fn plain(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}

const STYLE: &str = "body{font:16px/1.5 sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem;color:#222}\
table{border-collapse:collapse;font-variant-numeric:tabular-nums;display:block;overflow-x:auto}\
th,td{border:1px solid #bbb;padding:.2rem .6rem}img{max-width:100%}";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::{Column, Value};

    #[test]
    fn verif_both_forms_hold_the_table_and_html_escapes() {
        let mut report = Report::new("Fit of <a & b>");
        report.section("Numbers");
        report.table(&Table {
            columns: vec![Column::new("name", Kind::Text, "A name."), Column::real("x_mag", "mag", 2, "A number.")],
            rows: vec![vec!["a|b".into(), Value::Real(1.234)]],
        });
        report.paragraph("Data: <script>alert(1)</script> & more");
        report.picture("residuals", "a r.png");
        assert!(
            report.to_markdown().contains("| name | x_mag |\n| --- | ---: |\n| a\\|b | 1.23 |"),
            "{}",
            report.to_markdown()
        );
        let page = report.to_html(|name| (name == "a r.png").then(|| "data:image/png;base64,AA".to_owned()));
        assert!(page.contains("<title>Fit of &lt;a &amp; b&gt;</title>"), "{page}");
        assert!(!page.contains("<script>") && page.contains("&lt;script&gt;alert(1)"), "{page}");
        assert!(page.contains("<td>a|b</td>") && page.contains("src=\"data:image/png;base64,AA\""), "{page}");
    }
}
