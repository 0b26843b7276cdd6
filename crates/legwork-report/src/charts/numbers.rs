//! Numbers on paper: coordinates, round steps, labels, and numbers in running text.

use std::fmt;

/// A length or coordinate of a drawing, written to a tenth of a pixel. Always a number, whatever it was.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Px(pub(crate) f64);

impl fmt::Display for Px {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The cast makes zero of what is not a number.
        let tenths = (self.0 * 10.0).round().clamp(-1e7, 1e7) as i64;
        let sign = if tenths < 0 { "-" } else { "" };
        let (whole, tenth) = (tenths.abs() / 10, tenths.abs() % 10);
        if tenth == 0 { write!(f, "{sign}{whole}") } else { write!(f, "{sign}{whole}.{tenth}") }
    }
}

/// The smallest of 1, 2, 5 × 10ⁿ that divides `span` into at most `most` parts.
pub(crate) fn round_step(span: f64, most: usize) -> f64 {
    let rough = span / most.max(1) as f64;
    let decade = 10.0_f64.powf(rough.log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * decade >= rough * (1.0 - 1e-9));
    factor.unwrap_or(10.0) * decade
}

/// The multiples of `step` from `from` to `to`.
pub(crate) fn multiples(from: f64, to: f64, step: f64) -> Vec<f64> {
    let (first, last) = ((from / step - 1e-6).ceil(), (to / step + 1e-6).floor());
    (0..=(last - first) as usize).map(|k| (first + k as f64) * step).collect()
}

/// A tick's label, with the decimals that `step` needs and a true minus sign.
pub(crate) fn tick_label(value: f64, step: f64) -> String {
    let decimals = (-(step.log10() + 1e-9).floor()).clamp(0.0, 9.0) as usize;
    let text = format!("{value:.decimals$}");
    let zero = text.bytes().all(|byte| matches!(byte, b'-' | b'0' | b'.'));
    if zero { text.trim_start_matches('-').to_owned() } else { text.replace('-', "\u{2212}") }
}

/// A power of ten, such as 10⁻⁴.
pub(crate) fn power_of_ten(exponent: i32) -> String {
    let superscript = |digit: char| match digit.to_digit(10) {
        Some(1) => '\u{b9}',
        Some(value @ 2..=3) => char::from_u32(0xb0 + value).unwrap_or(digit),
        Some(value) => char::from_u32(0x2070 + value).unwrap_or(digit),
        None => '\u{207b}',
    };
    format!("10{}", exponent.to_string().chars().map(superscript).collect::<String>())
}

/// Smallest and largest of the finite `values`, held within what can be drawn.
pub(crate) fn extent(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    let finite = values.into_iter().filter(|value| value.is_finite()).map(|value| value.clamp(-1e12, 1e12));
    finite.fold(None, |ends, value| match ends {
        None => Some((value, value)),
        Some((low, high)) => Some((value.min(low), value.max(high))),
    })
}

/// A number with three significant digits; whole ones as they are, large and small ones with a power of ten.
pub(crate) fn number(value: f64) -> String {
    if !value.is_finite() {
        return "not a number".into();
    }
    let exponent =
        format!("{:.2e}", value.abs()).split_once('e').and_then(|(_, power)| power.parse().ok()).unwrap_or(0);
    let text = if value.fract() == 0.0 && value.abs() < 1e4 {
        tick_label(value, 1.0)
    } else if (-3..4).contains(&exponent) {
        format!("{value:.*}", (2 - exponent).max(0) as usize)
    } else {
        format!("{:.2}\u{b7}{}", value / 10.0_f64.powi(exponent), power_of_ten(exponent))
    };
    text.replace('-', "\u{2212}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round() {
        for (span, most, step) in [(8.0, 10, 1.0), (8.0, 4, 2.0), (440.0, 5, 100.0), (0.07, 4, 0.02), (1e-7, 3, 5e-8)] {
            assert!((round_step(span, most) / step - 1.0).abs() < 1e-9, "{span} in {most}");
        }
    }

    #[test]
    fn ticks_have_the_decimals_they_need() {
        let labels = |from, to, step| -> Vec<String> {
            multiples(from, to, step).into_iter().map(|value| tick_label(value, step)).collect()
        };
        assert_eq!(labels(-0.2, 0.21, 0.2), ["\u{2212}0.2", "0.0", "0.2"]);
        assert_eq!(labels(0.0, 400.0, 200.0), ["0", "200", "400"]);
        assert_eq!(labels(0.88, 0.90, 0.005), ["0.880", "0.885", "0.890", "0.895", "0.900"]);
        assert_eq!(tick_label(-1e-12, 0.1), "0.0");
    }

    #[test]
    fn a_pixel_is_always_a_number() {
        let shown = |value: f64| Px(value).to_string();
        assert_eq!([shown(1.25), shown(-0.04), shown(-3.0), shown(-0.55)], ["1.3", "0", "-3", "-0.6"]);
        assert_eq!([shown(f64::NAN), shown(f64::INFINITY)], ["0", "1000000"]);
    }

    #[test]
    fn numbers_have_three_digits() {
        for (value, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (13.0, "13"),
            (0.0129, "0.0129"),
            (0.002, "0.00200"),
            (1.8e-4, "1.80\u{b7}10\u{207b}\u{2074}"),
            (30_512.0, "3.05\u{b7}10\u{2074}"),
            (220.0, "220"),
            (9999.0, "9999"),
            (9999.9, "1.00\u{b7}10\u{2074}"),
            (-69.62, "\u{2212}69.6"),
            (1e-10, "1.00\u{b7}10\u{207b}\u{b9}\u{2070}"),
            (f64::NAN, "not a number"),
        ] {
            assert_eq!(number(value), text);
        }
    }
}
