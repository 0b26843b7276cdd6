//! Colours for numbers: equal differences look equally large, also in grey and to the colour-blind.
//!
//! They are interpolated in Oklab (Ottosson 2020, "A perceptual color space for image processing"), whose first
//! coordinate is the perceived lightness; it changes evenly along each of the scales.

use maud::{Markup, html};

use super::axis::{Axis, Quantity, Ruler};
use super::numbers::{Px, extent, round_step, tick_label};
use super::svg::text_width;

/// Lightness, green to red, blue to yellow.
type Oklab = [f64; 3];

/// From little to much: pale yellow, teal, dark blue.
const SEQUENTIAL: [Oklab; 4] = [[0.96, -0.02, 0.055], [0.74, -0.075, 0.0], [0.52, -0.045, -0.08], [0.3, 0.01, -0.11]];
/// From below the centre to above it: blue, white, vermilion.
const DIVERGING: [Oklab; 5] =
    [[0.4, -0.02, -0.13], [0.68, -0.04, -0.09], [0.96, 0.0, 0.0], [0.68, 0.11, 0.08], [0.4, 0.11, 0.08]];

/// A colour for each number of a range.
#[derive(Clone, Debug)]
pub(crate) struct Colours {
    domain: [f64; 2],
    diverging: bool,
}

impl Colours {
    /// From the least to the greatest of `values`; with a `centre`, as far below it as above it.
    pub(crate) fn of(values: &[f64], centre: Option<f64>) -> Self {
        let (low, high) = extent(values.iter().copied()).unwrap_or((0.0, 1.0));
        let reach = |centre: f64| {
            let reach = (high - centre).max(centre - low);
            if reach > 0.0 { reach } else { 1.0 }
        };
        let domain = match centre {
            Some(centre) => [centre - reach(centre), centre + reach(centre)],
            None if low > 0.0 && low < 0.6 * high => [0.0, high],
            None if high > low => [low, high],
            None => [low - 0.5 * reach(0.0), high + 0.5 * reach(0.0)],
        };
        Self { domain, diverging: centre.is_some() }
    }

    /// The colour of `value`, and the class of a text on it.
    pub(super) fn at(&self, value: f64) -> (String, &'static str) {
        let [from, to] = self.domain;
        let share = ((value - from) / (to - from)).clamp(0.0, 1.0);
        let colour = if self.diverging { between(&DIVERGING, share) } else { between(&SEQUENTIAL, share) };
        let [r, g, b] = srgb(colour);
        (format!("#{r:02x}{g:02x}{b:02x}"), if colour[0] < 0.65 { "on-dark" } else { "on-light" })
    }

    /// A bar of all colours with its numbers, from `top` to `bottom` [px], and what they are above it; all of it ends
    /// at `end`.
    pub(super) fn bar(&self, quantity: &Quantity, end: f64, [top, bottom]: [f64; 2], title: f64) -> Markup {
        const PIECES: usize = 48;
        let ruler = self.ruler(quantity, [bottom, top]);
        let height = (bottom - top) / PIECES as f64;
        let [from, to] = self.domain;
        let colour = |piece: usize| self.at(from + (to - from) * (piece as f64 + 0.5) / PIECES as f64).0;
        let x = end - self.bar_width(quantity);
        let right = x + BAR;
        html! {
            text class="label" x=(Px(end)) y=(Px(title)) text-anchor="end" { (ruler.title) }
            @for piece in (0..PIECES).rev() {
                // Down to the bottom, so that no seam shows between two.
                @let rise = height * (piece + 1) as f64;
                rect x=(Px(x)) y=(Px(bottom - rise)) width=(Px(BAR)) height=(Px(rise)) fill=(colour(piece)) {}
            }
            path class="axis" d={
                "M" (Px(x)) " " (Px(top)) "H" (Px(right)) "V" (Px(bottom)) "H" (Px(x)) "Z"
                @for tick in &ruler.ticks { "M" (Px(right)) " " (Px(tick.at)) "h4" }
            } {}
            g class="ticks" {
                @for tick in &ruler.ticks { text x=(Px(right + 7.0)) y=(Px(tick.at + 4.0)) { (tick.label) } }
            }
        }
    }

    fn ruler(&self, quantity: &Quantity, range: [f64; 2]) -> Ruler {
        Axis::exactly(quantity.clone().logarithmic(false), self.domain).on(range, 26.0)
    }

    /// How wide its bar is with its numbers [px].
    pub(super) fn bar_width(&self, quantity: &Quantity) -> f64 {
        BAR + 7.0 + self.ruler(quantity, [200.0, 0.0]).widest()
    }

    /// How wide the title of its bar is [px].
    pub(super) fn title_width(&self, quantity: &Quantity) -> f64 {
        text_width(&self.ruler(quantity, [200.0, 0.0]).title)
    }

    /// A number of its range, with one digit more than the numbers of its bar.
    pub(super) fn number(&self, value: f64) -> String {
        tick_label(value, 0.1 * round_step(self.domain[1] - self.domain[0], 5))
    }
}

/// Width of a bar of colours [px].
const BAR: f64 = 14.0;

/// The colour at `share` of the way along equally spaced `stops`.
fn between(stops: &[Oklab], share: f64) -> Oklab {
    let place = share * (stops.len() - 1) as f64;
    let first = (place.floor() as usize).min(stops.len() - 2);
    let rest = place - first as f64;
    [0, 1, 2].map(|k| stops[first][k] + rest * (stops[first + 1][k] - stops[first][k]))
}

/// As red, green and blue of sRGB.
fn srgb([lightness, a, b]: Oklab) -> [u8; 3] {
    // Ottosson 2020: from Oklab to linear sRGB.
    let l = (lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let m = (lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let s = (lightness - 0.089_484_177_5 * a - 1.291_485_548_0 * b).powi(3);
    let linear = [
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s,
    ];
    // IEC 61966-2-1: the sRGB transfer function.
    let encoded = |c: f64| if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
    linear.map(|c| (255.0 * encoded(c)).round().clamp(0.0, 255.0) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Perceived lightness by another way: CIE L* of the relative luminance.
    fn cie_lightness([r, g, b]: [u8; 3]) -> f64 {
        let linear = |c: u8| {
            let c = f64::from(c) / 255.0;
            if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        };
        let y = 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
        116.0 * y.cbrt() - 16.0
    }

    #[test]
    fn grey_stays_grey_and_the_primaries_are_met() {
        assert_eq!(srgb([1.0, 0.0, 0.0]), [255, 255, 255]);
        assert_eq!(srgb([0.0, 0.0, 0.0]), [0, 0, 0]);
        // Ottosson 2020: pure red.
        assert_eq!(srgb([0.627_955, 0.224_863, 0.125_846]), [255, 0, 0]);
    }

    #[test]
    fn more_is_darker_in_even_steps() {
        let steps: Vec<f64> =
            (0..=10).map(|k| cie_lightness(srgb(between(&SEQUENTIAL, f64::from(k) / 10.0)))).collect();
        let whole = steps[0] - steps[10];
        for pair in steps.windows(2) {
            let share = (pair[0] - pair[1]) / whole;
            assert!((0.07..0.13).contains(&share), "{steps:?}");
        }
    }

    #[test]
    fn a_diverging_scale_is_as_light_on_both_sides() {
        for k in 0..5 {
            let side = |share: f64| cie_lightness(srgb(between(&DIVERGING, share)));
            let share = f64::from(k) / 10.0;
            assert!((side(share) - side(1.0 - share)).abs() < 8.0, "{share}: {} {}", side(share), side(1.0 - share));
        }
        let colours = Colours::of(&[-0.1, 0.4], Some(0.0));
        assert_eq!(colours.at(0.0).0, "#f2f2f2");
        assert_ne!(
            colours.at(-0.1).0,
            Colours::of(&[-0.1, 0.1], Some(0.0)).at(-0.1).0,
            "one unit is one step of colour"
        );
    }

    #[test]
    fn text_stands_out_from_its_colour() {
        for colours in [Colours::of(&[0.0, 1.0], None), Colours::of(&[-1.0, 1.0], Some(0.0))] {
            for k in -20..=20 {
                let (colour, class) = colours.at(f64::from(k) / 20.0);
                let channel = |at: usize| u8::from_str_radix(&colour[at..at + 2], 16).expect("hexadecimal");
                let lightness = cie_lightness([channel(1), channel(3), channel(5)]);
                // A contrast of 3:1 and more, as for large text in WCAG 2.1, 1.4.3.
                let luminance = ((lightness + 16.0) / 116.0).powi(3);
                let contrast = if class == "on-dark" { 1.05 / (luminance + 0.05) } else { (luminance + 0.05) / 0.058 };
                assert!(contrast > 3.0, "{k}: {colour} {class} {contrast}");
            }
        }
    }

    #[test]
    fn a_range_of_nothing_has_colours() {
        for values in [vec![], vec![f64::NAN], vec![0.0], vec![3.0, 3.0], vec![-2.0]] {
            for centre in [None, Some(0.0), Some(3.0)] {
                let colours = Colours::of(&values, centre);
                assert!(colours.domain[1] > colours.domain[0], "{values:?}");
                let bar = colours.bar(&Quantity::default(), 90.0, [20.0, 120.0], 10.0);
                assert!(!bar.into_string().contains("NaN"));
            }
        }
    }
}
