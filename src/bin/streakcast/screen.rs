//! Text for terminals: aligned tables of selected columns, with coloured verdicts and escaped control characters.

use std::borrow::Cow;

use comfy_table::presets::NOTHING;
use comfy_table::{Attribute, Cell, CellAlignment, Color, Table as Screen};
use hifitime::{Epoch, TimeScale, Unit};
use streakcast::message::{known_step_s, printable};
use streakcast::output::{Kind, Table, Value, format_utc};

/// Column of a table on a terminal: name in the data table, heading, and number of decimals.
pub struct Shown {
    pub column: &'static str,
    pub heading: &'static str,
    pub decimals: Option<usize>,
    /// Column of the data table with the error (one sigma) of a time, seconds; `None` for exact times.
    pub error: Option<&'static str>,
}

/// Returns a column with the decimals of the data table.
pub const fn shown(column: &'static str, heading: &'static str) -> Shown {
    Shown { column, heading, decimals: None, error: None }
}

/// Returns a column with numbers and seconds rounded to `decimals`.
pub const fn rounded(column: &'static str, heading: &'static str, decimals: usize) -> Shown {
    Shown { column, heading, decimals: Some(decimals), error: None }
}

/// Returns a column of times that are rounded to their error in another column, and at least to `decimals`.
pub const fn known_to(column: &'static str, heading: &'static str, decimals: usize, error: &'static str) -> Shown {
    Shown { column, heading, decimals: Some(decimals), error: Some(error) }
}

/// Style of a table on a terminal.
pub struct Style<'a> {
    /// Columns in their order. A column that is missing in the data table or empty in all rows is omitted.
    pub columns: &'a [Shown],
    /// Index of the row in bold type; `None` for no such row.
    pub bold_row: Option<usize>,
}

/// Number of characters to which text is shortened before columns are omitted.
const LEAST_TEXT: usize = 24;
/// Number of blank characters around the content of a column.
const PADDING: usize = 2;

/// Returns the width of the terminal at standard output, characters; `None` if it is not a terminal.
pub fn terminal_width() -> Option<usize> {
    // Some programs that run others in a pseudo-terminal set its width to 0 columns.
    Screen::new().width().filter(|width| *width > 0).map(usize::from)
}

/// Returns the table as text with one line per row. If `width` (characters) is given, text is shortened and the last
/// columns are omitted to fit, and a line names the omitted columns.
pub fn render(table: &Table, style: &Style<'_>, styled: bool, width: Option<usize>) -> String {
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
    let cells: Vec<Vec<String>> = table.rows.iter().map(|row| cell_texts(table, row, &columns)).collect();
    let fitted = Fitted::new(&columns, table, &cells, width);
    let shown = &columns[..fitted.columns];
    screen.set_header(shown.iter().map(|(_, shown)| Cell::new(shown.heading).add_attribute(Attribute::Bold)));
    for (number, texts) in cells.iter().enumerate() {
        screen.add_row(shown.iter().zip(texts).map(|(&(index, _), text)| {
            let is_text = matches!(table.columns[index].kind, Kind::Text | Kind::List { .. });
            let text = if is_text { shortened(text, fitted.longest_text) } else { Cow::Borrowed(text.as_str()) };
            let mut cell = Cell::new(&text);
            if matches!(table.columns[index].kind, Kind::Real { .. } | Kind::Small { .. } | Kind::Integer) {
                cell = cell.set_alignment(CellAlignment::Right);
            }
            if let Some(color) = color(&text) {
                cell = cell.fg(color);
            }
            if style.bold_row == Some(number) { cell.add_attribute(Attribute::Bold) } else { cell }
        }));
    }
    let mut text: String = screen.lines().map(|line| line.trim_end().to_owned() + "\n").collect();
    if table.rows.is_empty() {
        text.push_str("(none)\n");
    }
    if let Some(width) = width
        && fitted.columns < columns.len()
    {
        let names: Vec<&str> = columns[fitted.columns..].iter().map(|(_, shown)| shown.heading).collect();
        text += &format!("(not shown in {width} characters: {}; --format csv has all columns)\n", names.join(", "));
    }
    text
}

/// Returns the text of the cells of one row.
fn cell_texts(table: &Table, row: &[Value], columns: &[(usize, &Shown)]) -> Vec<String> {
    let cell = |&(index, shown): &(usize, &Shown)| {
        let mut column = table.columns[index];
        column.kind = match (column.kind, shown.decimals) {
            (Kind::Real { .. } | Kind::Small { .. }, Some(decimals)) => Kind::Real { decimals },
            (Kind::Time { .. }, Some(decimals)) => Kind::Time { decimals },
            (kind, _) => kind,
        };
        let error = shown.error.and_then(|name| table.columns.iter().position(|column| column.name == name));
        let text = match (row.get(index), error.and_then(|error| row.get(error))) {
            (Some(Value::Time(epoch)), Some(error)) => time_text(*epoch, shown.decimals.unwrap_or_default(), error),
            (Some(value), _) => column.text(value),
            (None, _) => String::new(),
        };
        if text.is_empty() { "-".to_owned() } else { printable(&text).into_owned() }
    };
    columns.iter().map(cell).collect()
}

/// Formats a time rounded to `decimals` of the second, or to its error (seconds) if this is larger: to the next step of
/// 0.1 s, 1 s, 10 s, 1 min or 10 min, without seconds from a minute on. A time of unknown error is rounded to 1 min.
fn time_text(epoch: Epoch, decimals: usize, error: &Value) -> String {
    let error_s = match error {
        Value::Real(error_s) => *error_s,
        _ => f64::NAN,
    };
    let fine = (0..=decimals).rev().find(|decimals| error_s <= 0.1_f64.powi(*decimals as i32) * (1.0 + 1e-9));
    if let Some(decimals) = fine {
        return format_utc(epoch, decimals);
    }
    // Steps are counted from the start of the time scale, so that only those of UTC are whole minutes of its clock.
    let step_s = known_step_s(error_s);
    let text = format_utc(epoch.to_time_scale(TimeScale::UTC).round(step_s * Unit::Second), 0);
    if step_s < 60.0 { text } else { format!("{}Z", &text[..16]) }
}

/// Number of columns and length of text that fit into a width.
struct Fitted {
    /// Number of columns, counted from the first.
    columns: usize,
    /// Largest number of characters of a text cell.
    longest_text: usize,
}

impl Fitted {
    fn new(columns: &[(usize, &Shown)], table: &Table, cells: &[Vec<String>], width: Option<usize>) -> Self {
        let all = Self { columns: columns.len(), longest_text: usize::MAX };
        let Some(width) = width else { return all };
        let widths: Vec<(usize, bool)> = (0..columns.len())
            .map(|number| {
                let (index, shown) = columns[number];
                let longest = cells.iter().map(|row| row[number].chars().count()).max().unwrap_or(0);
                let is_text = matches!(table.columns[index].kind, Kind::Text | Kind::List { .. });
                (longest.max(shown.heading.chars().count()), is_text)
            })
            .collect();
        let total = |count: usize, longest_text: usize| -> usize {
            let shown_width =
                |&(longest, is_text): &(usize, bool)| if is_text { longest.min(longest_text) } else { longest };
            widths[..count].iter().map(|column| shown_width(column) + PADDING).sum()
        };
        let count = (1..=columns.len()).rev().find(|&count| total(count, LEAST_TEXT) <= width).unwrap_or(1);
        // Largest length of text cells for which these columns still fit.
        let longest = widths.iter().map(|(longest, _)| *longest).max().unwrap_or(0);
        let longest_text = (LEAST_TEXT..=longest).rev().find(|&longest| total(count, longest) <= width);
        Self { columns: count.min(columns.len()), longest_text: longest_text.unwrap_or(LEAST_TEXT) }
    }
}

/// Returns a text of at most `most` characters; a shortened text ends with an ellipsis.
fn shortened(text: &str, most: usize) -> Cow<'_, str> {
    match text.char_indices().nth(most) {
        None => Cow::Borrowed(text),
        Some(_) => Cow::Owned(text.chars().take(most.saturating_sub(1)).chain(['\u{2026}']).collect()),
    }
}

fn color(text: &str) -> Option<Color> {
    match text {
        "clear" => Some(Color::Green),
        "streaked" => Some(Color::Yellow),
        "avoid" => Some(Color::Red),
        "unknown" | "invalid" => Some(Color::Magenta),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use streakcast::output::Column;

    use super::*;

    /// Times have no digits below their error; those of unknown error have minutes.
    #[test]
    fn times_are_rounded_to_their_error() {
        let columns = vec![Column::time("utc", ""), Column::real("late_s", "s", 3, "")];
        let epoch = Epoch::from_gregorian_utc(2026, 8, 14, 23, 29, 47, 126_000_000);
        let shown = |late: Value| {
            let table = Table { columns: columns.clone(), rows: vec![vec![epoch.into(), late]] };
            let style = Style { columns: &[known_to("utc", "time", 2, "late_s")], bold_row: None };
            render(&table, &style, false, None).lines().nth(1).unwrap().trim().to_owned()
        };
        for (late_s, expected) in [
            (0.0, "2026-08-14T23:29:47.13Z"),
            (0.01, "2026-08-14T23:29:47.13Z"),
            (0.05, "2026-08-14T23:29:47.1Z"),
            (0.9, "2026-08-14T23:29:47Z"),
            (4.0, "2026-08-14T23:29:50Z"),
            (12.0, "2026-08-14T23:30Z"),
        ] {
            assert_eq!(shown(late_s.into()), expected, "{late_s}");
        }
        assert_eq!(shown(Value::Null), "2026-08-14T23:30Z");
        // The times of the data table have all digits.
        assert_eq!(columns[0].text(&epoch.into()), "2026-08-14T23:29:47.126000Z");
    }

    #[test]
    fn tables_fit_and_name_what_they_omit() {
        let columns = vec![
            Column::new("id", Kind::Text, ""),
            Column::new("why", Kind::Text, ""),
            Column::real("ra", "deg", 3, ""),
        ];
        let why = "a reason of more than thirty characters";
        let table = Table { columns, rows: vec![vec!["a".into(), why.into(), 12.5.into()]] };
        let style = Style { columns: &[shown("id", "id"), shown("why", "why"), shown("ra", "RA deg")], bold_row: None };
        let lines = |width| -> Vec<String> {
            let text = render(&table, &style, false, width);
            assert!(text.lines().take(2).all(|line| width.is_none_or(|width| line.chars().count() <= width)), "{text}");
            text.lines().map(str::to_owned).collect()
        };
        assert!(lines(None)[1].contains(why) && lines(None).len() == 2);
        assert_eq!(lines(Some(60)), lines(None));
        let shortened = lines(Some(45));
        assert!(shortened[1].contains("a reason of more than thirty c\u{2026}") && shortened[1].ends_with("12.500"));
        assert_eq!(shortened.len(), 2);
        let narrow = lines(Some(30));
        assert!(narrow[1].contains("a reason of more than t\u{2026}"), "{narrow:?}");
        assert_eq!(narrow[2], "(not shown in 30 characters: RA deg; --format csv has all columns)");
    }
}
