//! Formatting of numbers: the digits follow from a step or an error, and negative numbers get a true minus sign.

/// Formats a number with `decimals` decimals, without a sign on zero.
pub(super) fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.chars().all(|digit| matches!(digit, '0' | '.')) => digits.to_owned(),
        Some(digits) => format!("−{digits}"),
        None => text,
    }
}

/// Returns labels of ticks that are `step` apart, all in the same format, with a power of ten if values are very large
/// or small.
pub(super) fn labels(values: &[f64], step: f64) -> Vec<String> {
    let largest = values.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    let digits = decimals_of(step);
    if largest >= 1e5 || (largest > 0.0 && digits > 5) {
        let power = largest.log10().floor() as i32;
        let places = (power - step.log10().floor() as i32).clamp(0, 15) as usize;
        let scaled =
            |value: &f64| format!("{}e{}", fixed(value / 10_f64.powi(power), places), fixed(f64::from(power), 0));
        values.iter().map(|value| if *value == 0.0 { "0".to_owned() } else { scaled(value) }).collect()
    } else {
        values.iter().map(|value| fixed(*value, digits)).collect()
    }
}

/// Formats a value with its errors, for example `0.0123 +0.0004 −0.0003`, where the errors are the distances to the
/// upper and the lower quantile. The smaller error has one digit, or two if its first digit is 1.
pub(super) fn with_errors(value: f64, above: f64, below: f64) -> String {
    let error = if below > 0.0 && above > 0.0 { below.min(above) } else { below.max(above) };
    // Without an error, the value gets six digits.
    let least = if error > 0.0 { error } else { value.abs().max(1e-300) * 2.001e-6 };
    let power = least.log10().floor() as i32;
    let begins_with_one = error > 0.0 && least / 10_f64.powi(power) < 1.95;
    let decimals = i32::from(begins_with_one) - power;
    let largest = value.abs().max(above).max(below);
    if (decimals > 6 && largest < 1e-2) || largest >= 1e6 {
        let scale = largest.log10().floor() as i32;
        let places = (decimals + scale).clamp(0, 15) as usize;
        let [value, above, below] = [value, above, below].map(|part| fixed(part / 10_f64.powi(scale), places));
        format!("({value} +{above} −{below})e{}", fixed(f64::from(scale), 0))
    } else {
        let places = decimals.clamp(0, 15) as usize;
        format!("{} +{} −{}", fixed(value, places), fixed(above, places), fixed(below, places))
    }
}

/// Formats a fraction in percent.
pub(super) fn per_cent(share: f64) -> String {
    format!("{} %", fixed(100.0 * share, 1))
}

/// Formats a number with its noun, singular or plural.
pub(super) fn many(number: usize, singular: &str, more: &str) -> String {
    format!("{} {}", count(number), if number == 1 { singular } else { more })
}

/// Formats a number with separated thousands.
pub(super) fn count(number: usize) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Returns the decimals required by a step of 1, 2 or 5 times a power of ten.
fn decimals_of(step: f64) -> usize {
    if step > 0.0 { (-(step.log10() + 1e-9).floor()).clamp(0.0, 300.0) as usize } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_the_error_determines_the_digits() {
        assert_eq!(with_errors(0.012_34, 0.000_41, 0.000_32), "0.0123 +0.0004 −0.0003");
        assert_eq!(with_errors(-5.4321, 0.12, 0.2), "−5.43 +0.12 −0.20");
        assert_eq!(with_errors(123.4, 21.0, 30.0), "123 +21 −30");
        assert_eq!(with_errors(0.5, 0.0, 0.0), "0.500000 +0.000000 −0.000000");
        assert_eq!(with_errors(0.0, 0.0, 0.0).split(' ').count(), 3);
        assert_eq!(with_errors(1.2345e-7, 3e-9, 2e-9), "(1.23 +0.03 −0.02)e−7");
    }

    #[test]
    fn verif_labels_of_one_axis_are_alike() {
        assert_eq!(labels(&[-0.5, 0.0, 0.5], 0.5), ["−0.5", "0.0", "0.5"]);
        assert_eq!(labels(&[10.0, 20.0], 10.0), ["10", "20"]);
        assert_eq!(labels(&[0.0, 2e6], 2e6), ["0", "2e6"]);
        assert_eq!(labels(&[1.5e-7, 2e-7], 5e-8), ["1.5e−7", "2.0e−7"]);
        assert_eq!((count(1_234_567), count(80)), ("1,234,567".to_owned(), "80".to_owned()));
        assert_eq!(fixed(-0.001, 2), "0.00");
    }
}
