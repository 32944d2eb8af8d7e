//! Tables on a terminal: selected columns, aligned, with coloured verdicts.

use comfy_table::presets::NOTHING;
use comfy_table::{Attribute, Cell, CellAlignment, Color, Table as Screen};
use streakcast::output::{Kind, Table, Value};

/// Column on the terminal: name in the table, heading, and number of decimals.
pub struct Shown {
    pub column: &'static str,
    pub heading: &'static str,
    pub decimals: Option<usize>,
}

/// Returns a column with the decimals of the table.
pub const fn shown(column: &'static str, heading: &'static str) -> Shown {
    Shown { column, heading, decimals: None }
}

/// Returns a column with numbers and seconds rounded to `decimals`.
pub const fn rounded(column: &'static str, heading: &'static str, decimals: usize) -> Shown {
    Shown { column, heading, decimals: Some(decimals) }
}

/// Style of a table on a terminal.
pub struct Style<'a> {
    /// Columns in their order. Columns without a value in any row, or missing from the table, are omitted.
    pub columns: &'a [Shown],
    /// Index of the row in bold, if any.
    pub bold_row: Option<usize>,
}

/// Returns the table as text, with one line per row.
pub fn render(table: &Table, style: &Style<'_>, styled: bool) -> String {
    let mut screen = Screen::new();
    screen.load_style(NOTHING).set_content_arrangement(comfy_table::ContentArrangement::Disabled);
    if styled {
        screen.enforce_styling();
    } else {
        screen.force_no_tty();
    }
    let has_values =
        |index: usize| table.rows.is_empty() || table.rows.iter().any(|row| row.get(index) != Some(&Value::Null));
    let columns: Vec<(usize, &Shown)> = style
        .columns
        .iter()
        .filter_map(|shown| {
            let index = table.columns.iter().position(|column| column.name == shown.column)?;
            has_values(index).then_some((index, shown))
        })
        .collect();
    screen.set_header(columns.iter().map(|(_, shown)| Cell::new(shown.heading).add_attribute(Attribute::Bold)));
    for (number, row) in table.rows.iter().enumerate() {
        screen.add_row(columns.iter().filter_map(|&(index, shown)| {
            let mut column = table.columns[index];
            column.kind = match (column.kind, shown.decimals) {
                (Kind::Real { .. }, Some(decimals)) => Kind::Real { decimals },
                (Kind::Time { .. }, Some(decimals)) => Kind::Time { decimals },
                (kind, _) => kind,
            };
            let value = row.get(index)?;
            let text = column.text(value);
            let mut cell = Cell::new(if text.is_empty() { "-" } else { &text });
            if matches!(column.kind, Kind::Real { .. } | Kind::Integer) {
                cell = cell.set_alignment(CellAlignment::Right);
            }
            if let Some(color) = color(&text) {
                cell = cell.fg(color);
            }
            Some(if style.bold_row == Some(number) { cell.add_attribute(Attribute::Bold) } else { cell })
        }));
    }
    let mut text: String = screen.lines().map(|line| line.trim_end().to_owned() + "\n").collect();
    if table.rows.is_empty() {
        text.push_str("(none)\n");
    }
    text
}

fn color(text: &str) -> Option<Color> {
    match text {
        "clear" => Some(Color::Green),
        "streaked" => Some(Color::Yellow),
        "avoid" => Some(Color::Red),
        "invalid" => Some(Color::Magenta),
        _ => None,
    }
}
