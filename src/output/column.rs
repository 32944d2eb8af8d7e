//! What a column is called, what it holds, in which unit, and with how many decimals it is written.

/// What the cells of a column hold, and how numbers are written.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Kind {
    /// Text.
    Text,
    /// A whole number.
    Integer,
    /// A number, written with this many decimals in every format.
    Real {
        /// Digits after the point.
        decimals: usize,
    },
    /// A moment, written as UTC with `Z` and this many decimals of the second.
    Time {
        /// Digits after the seconds' point, at most 9.
        decimals: usize,
    },
    /// True or false.
    Boolean,
    /// Several texts or whole numbers: a JSON array; elsewhere one cell with this separator.
    List {
        /// What stands between the items in formats without arrays.
        separator: &'static str,
    },
    /// A table within the cell: a JSON array of objects; elsewhere one cell of JSON text.
    Rows(&'static [Column]),
}

/// One column of a table.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Column {
    /// Name, snake_case with the unit last.
    pub name: &'static str,
    /// Unit in the spelling of astropy (`deg`, `km`, `mag`); empty for none.
    pub unit: &'static str,
    /// What its cells hold.
    pub kind: Kind,
    /// One sentence for the reader of the file.
    pub description: &'static str,
}

impl Column {
    /// A column without unit.
    pub const fn new(name: &'static str, kind: Kind, description: &'static str) -> Self {
        Self { name, unit: "", kind, description }
    }

    /// A number with its unit, written with `decimals` digits.
    pub const fn real(name: &'static str, unit: &'static str, decimals: usize, description: &'static str) -> Self {
        Self { name, unit, kind: Kind::Real { decimals }, description }
    }

    /// A moment in UTC, to the microsecond.
    pub const fn time(name: &'static str, description: &'static str) -> Self {
        Self { name, unit: "", kind: Kind::Time { decimals: 6 }, description }
    }

    /// The cell's text in formats without types; empty where there is no value.
    ///
    /// A number that is not finite is no value. Negative zero is written as zero.
    pub fn text(&self, value: &super::Value) -> String {
        use super::Value;
        match (value, self.kind) {
            (Value::Null, _) => String::new(),
            (Value::Text(text), _) => text.clone(),
            (Value::Integer(number), _) => number.to_string(),
            (Value::Boolean(truth), _) => truth.to_string(),
            (Value::Real(number), Kind::Real { decimals }) => real_text(*number, decimals),
            (Value::Real(number), _) if number.is_finite() => number.to_string(),
            (Value::Real(_), _) => String::new(),
            (Value::Time(epoch), Kind::Time { decimals }) => super::format_utc(*epoch, decimals),
            (Value::Time(epoch), _) => super::format_utc(*epoch, 6),
            (Value::List(items), Kind::List { separator }) => items.join(separator),
            (Value::List(items), _) => items.join(" "),
            (Value::Integers(items), Kind::List { separator }) => integers_text(items, separator),
            (Value::Integers(items), _) => integers_text(items, " "),
            (Value::Rows(rows), Kind::Rows(columns)) => super::json::json_rows(columns, rows),
            (Value::Rows(_), _) => String::new(),
        }
    }
}

fn integers_text(items: &[i64], separator: &str) -> String {
    items.iter().map(i64::to_string).collect::<Vec<_>>().join(separator)
}

fn real_text(number: f64, decimals: usize) -> String {
    if !number.is_finite() {
        return String::new();
    }
    let text = format!("{number:.decimals$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.bytes().all(|byte| byte == b'0' || byte == b'.') => digits.to_owned(),
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use super::super::Value;
    use super::*;

    #[test]
    fn numbers_keep_their_decimals_and_zero_has_no_sign() {
        let column = Column::real("range_km", "km", 3, "");
        for (number, text) in [
            (550.0, "550.000"),
            (-0.00049, "0.000"),
            (-0.0, "0.000"),
            (-0.0006, "-0.001"),
            (f64::NAN, ""),
            (f64::INFINITY, ""),
        ] {
            assert_eq!(column.text(&Value::Real(number)), text, "{number}");
        }
    }

    #[test]
    fn lists_are_joined_with_the_columns_separator() {
        let column = Column::new("reasons", Kind::List { separator: "; " }, "");
        assert_eq!(column.text(&Value::List(vec!["a".into(), "b".into()])), "a; b");
    }
}
