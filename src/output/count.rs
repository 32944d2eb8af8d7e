//! Numbers with their noun.

/// `1 pass`, `2 passes`: a count with the word for one or that for many.
pub fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

#[cfg(test)]
mod tests {
    use super::counted;

    #[test]
    fn one_is_singular() {
        assert_eq!([0, 1, 2].map(|count| counted(count, "pass", "passes")), ["0 passes", "1 pass", "2 passes"]);
    }
}
