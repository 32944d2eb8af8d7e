//! Values under their many names, in several headers.

use super::super::card::Card;
use super::super::header::Header;

/// Headers in the order in which they count: that of the image first, then the primary one.
#[derive(Copy, Clone)]
pub(super) struct Keywords<'a>(pub &'a [&'a Header]);

impl<'a> Keywords<'a> {
    /// The first header that has a keyword with a value, and the name it has there: a hyphen may be an underscore.
    pub fn find(self, keyword: &str) -> Option<(&'a Header, String)> {
        let names = [keyword.to_owned(), keyword.replace('-', "_")];
        self.0.iter().find_map(|header| {
            let has_value = |name: &&String| header.number(name).is_some() || header.text(name).is_some();
            names.iter().find(has_value).map(|name| (*header, name.clone()))
        })
    }

    /// The number of the first of several names that is there and satisfies a condition.
    pub fn number(self, keywords: &[&str], allows: impl Fn(f64) -> bool) -> Option<(String, f64, String)> {
        keywords.iter().find_map(|keyword| {
            let (header, name) = self.find(keyword)?;
            let number = header.number(&name).filter(|number| allows(*number))?;
            let comment = header.comment(&name);
            Some((name, number, comment))
        })
    }

    /// The text of the first of several names that is there.
    pub fn text(self, keywords: &[&str]) -> Option<(String, String)> {
        keywords.iter().find_map(|keyword| {
            let (header, name) = self.find(keyword)?;
            header.text(&name).map(|text| (name, text))
        })
    }
}

/// Half the last digit's unit of a number as it stands in its card.
pub(super) fn resolution(card: &Card) -> f64 {
    let text = card.text();
    let field =
        text.split_once('=').map_or("", |(_, field)| field.split('/').next().unwrap_or("")).trim().to_ascii_uppercase();
    let (mantissa, exponent) = field.split_once(['E', 'D']).unwrap_or((&field, "0"));
    let decimals = mantissa.split_once('.').map_or(0, |(_, digits)| digits.len() as i32);
    0.5 * 10f64.powi(exponent.trim().parse::<i32>().unwrap_or(0) - decimals)
}
