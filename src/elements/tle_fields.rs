//! Column fields of two-line element sets: numbers, catalogue numbers, designators, checksums.

use std::sync::Arc;

use super::epoch;
use crate::error::Error;

/// Length of a line without its checksum.
pub(super) const BODY: usize = 68;

/// Letters of Alpha-5 in place of the first two digits: 10 for A to 33 for Z.
pub(super) const ALPHA5: &[u8; 24] = b"ABCDEFGHJKLMNPQRSTUVWXYZ";

/// Parses a catalogue number of at most five characters: digits, or Alpha-5.
pub(super) fn parse_five_characters(field: &[u8]) -> Option<u32> {
    match field {
        [letter, rest @ ..] if letter.is_ascii_uppercase() && rest.len() == 4 => {
            let tens = ALPHA5.iter().position(|candidate| candidate == letter)? as u32 + 10;
            Some(tens * 10_000 + epoch::digits(rest)?)
        }
        _ if field.len() <= 5 => epoch::digits(field),
        _ => None,
    }
}

/// Converts `98067A` to `1998-067A`; other forms are unchanged.
pub(super) fn designator_of(field: &[u8]) -> Arc<str> {
    let field = field.trim_ascii();
    if field.is_empty() {
        return Arc::default();
    }
    if let [y1, y2, n1, n2, n3, piece @ ..] = field
        && [y1, y2, n1, n2, n3].iter().all(|byte| byte.is_ascii_digit())
        && piece.iter().all(u8::is_ascii_uppercase)
    {
        let century = if (*y1, *y2) < (b'5', b'7') { *b"20" } else { *b"19" };
        let mut text = [b' '; 11];
        text[..8].copy_from_slice(&[century[0], century[1], *y1, *y2, b'-', *n1, *n2, *n3]);
        let length = 8 + piece.len();
        text[8..length].copy_from_slice(piece);
        if let Ok(text) = std::str::from_utf8(&text[..length]) {
            return Arc::from(text);
        }
    }
    Arc::from(String::from_utf8_lossy(field).as_ref())
}

/// Powers of ten that are exact in binary64.
const TENS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];

/// Parses a signed decimal number of at most 15 digits, correctly rounded. Surrounding blanks are allowed.
pub(super) fn decimal(field: &[u8]) -> Option<f64> {
    let field = field.trim_ascii();
    let (negative, field) = match field {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, field),
    };
    let (mut value, mut digits, mut decimals, mut point) = (0_u64, 0, 0, false);
    for &byte in field {
        match byte {
            b'0'..=b'9' => {
                value = value * 10 + u64::from(byte - b'0');
                digits += 1;
                decimals += usize::from(point);
            }
            b'.' if !point => point = true,
            _ => return None,
        }
    }
    if digits == 0 || digits > 15 {
        return None;
    }
    // Integers below 2^53 and powers up to 10^22 are exact, so the quotient is the double nearest to the decimal.
    let value = value as f64 / TENS[decimals];
    Some(if negative { -value } else { value })
}

/// Parses ` 10370-3` as 0.10370e-3, correctly rounded. A blank in place of the sign is a plus.
pub(super) fn exponential(field: &[u8]) -> Option<f64> {
    let [sign, mantissa @ .., exponent_sign, exponent] = field else { return None };
    let negative = match sign {
        b'-' => true,
        b'+' | b' ' | b'0' => false,
        _ => return None,
    };
    let mantissa = f64::from(epoch::digits(mantissa.trim_ascii_start())?);
    if !exponent.is_ascii_digit() {
        return None;
    }
    let exponent = usize::from(exponent - b'0');
    let value = match exponent_sign {
        b'-' => mantissa / TENS[5 + exponent],
        b'+' | b' ' | b'0' if exponent <= 5 => mantissa / TENS[5 - exponent],
        b'+' | b' ' | b'0' => mantissa * TENS[exponent - 5],
        _ => return None,
    };
    Some(if negative { -value } else { value })
}

/// Returns the checksum: the sum of the digits in the first 68 characters modulo 10, where a minus sign counts as 1.
pub(super) fn checksum(text: &[u8]) -> u8 {
    let sum: u32 = text
        .iter()
        .take(BODY)
        .map(|byte| match byte {
            b'0'..=b'9' => u32::from(byte - b'0'),
            b'-' => 1,
            _ => 0,
        })
        .sum();
    (sum % 10) as u8
}

pub(super) fn verify_checksum(line: u8, text: &[u8]) -> Result<(), Error> {
    let computed = checksum(text);
    match text.get(BODY) {
        None | Some(b' ') => Ok(()),
        Some(stated) if *stated == b'0' + computed => Ok(()),
        Some(stated) => {
            let stated = char::from(*stated);
            let sentence = format!("line {line}: checksum {stated:?} does not match the sum of the line, {computed}");
            Err(Error::format(sentence).about("checksum"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_alpha5_covers_its_range() {
        for (text, id) in [("A0000", 100_000), ("H9999", 179_999), ("J0000", 180_000), ("N9999", 229_999)] {
            assert_eq!(parse_five_characters(text.as_bytes()), Some(id), "{text}");
        }
        assert_eq!(parse_five_characters(b"P0000"), Some(230_000));
        assert_eq!(parse_five_characters(b"Z9999"), Some(339_999));
        for text in ["I0000", "O0000", "a0000", "A000", "A00000", "1A000", "", "1 2"] {
            assert_eq!(parse_five_characters(text.as_bytes()), None, "{text}");
        }
    }
}
