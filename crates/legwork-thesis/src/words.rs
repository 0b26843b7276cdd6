//! Numbers in sentences.

use std::fmt::Display;

/// Three significant digits, as short as they are.
pub fn digits(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    if !(1e-4..1e6).contains(&size) {
        let text = format!("{value:.2e}");
        let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        return format!("{}e{exponent}", trimmed(mantissa));
    }
    let places = (2 - libm::log10(size).floor() as i32).clamp(0, 7) as usize;
    trimmed(&format!("{value:.places$}")).to_owned()
}

fn trimmed(text: &str) -> &str {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text }
}

/// [`digits`] with the unit behind, where there is one.
pub fn with_unit(value: f64, unit: &str) -> String {
    if unit.is_empty() { digits(value) } else { format!("{} {unit}", digits(value)) }
}

/// A change as percent with its sign.
pub(crate) fn signed_percent(change: f64) -> String {
    // Adding zero makes a rounded -0 a 0.
    format!("{:+.0} %", (100.0 * change).round() + 0.0)
}

/// A share as percent.
pub(crate) fn percent(share: f64) -> String {
    format!("{} %", digits(100.0 * share))
}

/// The parts as `a, b and c`.
pub(crate) fn list(parts: &[String]) -> String {
    match parts {
        [] => "none".to_owned(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// The text with each `{name}` replaced.
pub(crate) fn filled(text: &str, values: &[(&str, &dyn Display)]) -> String {
    let fill =
        |text: String, (name, value): &(&str, &dyn Display)| text.replace(&format!("{{{name}}}"), &value.to_string());
    values.iter().fold(text.to_owned(), fill)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits_and_no_more() {
        for (value, text) in [
            (0.0, "0"),
            (0.012345, "0.0123"),
            (-2.5, "-2.5"),
            (219.96, "220"),
            (30012.4, "30012"),
            (1e-6, "1e-6"),
            (1.234e7, "1.23e7"),
            (0.1, "0.1"),
        ] {
            assert_eq!(digits(value), text);
        }
        assert_eq!((with_unit(220.0, "Nm"), with_unit(10.0, "")), ("220 Nm".to_owned(), "10".to_owned()));
        assert_eq!(percent(0.123456), "12.3 %");
        assert_eq!([0.123, -0.5, -0.001].map(signed_percent), ["+12 %", "-50 %", "+0 %"]);
    }

    #[test]
    fn lists_end_with_and() {
        let parts = ["a", "b", "c"].map(str::to_owned);
        assert_eq!([list(&parts), list(&parts[..1]), list(&[])], ["a, b and c", "a", "none"]);
    }
}
