//! Scales, round ticks, and the thinning of long series to what a screen can show.

use std::fmt;

/// A length or coordinate of a drawing, written to a tenth of a pixel. Always a number, whatever it was.
#[derive(Clone, Copy, Debug)]
pub(super) struct Px(pub(super) f64);

impl fmt::Display for Px {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The cast makes zero of what is not a number.
        let tenths = (self.0 * 10.0).round().clamp(-1e7, 1e7) as i64;
        let sign = if tenths < 0 { "-" } else { "" };
        let (whole, tenth) = (tenths.abs() / 10, tenths.abs() % 10);
        if tenth == 0 { write!(f, "{sign}{whole}") } else { write!(f, "{sign}{whole}.{tenth}") }
    }
}

/// A linear map from data to pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale {
    /// What the data cover.
    pub(super) domain: [f64; 2],
    /// Where that is drawn [px].
    pub(super) range: [f64; 2],
}

impl Scale {
    /// Where `value` is drawn [px].
    pub(super) fn at(&self, value: f64) -> f64 {
        let [from, to] = self.domain;
        let [start, end] = self.range;
        start + (value - from) / (to - from) * (end - start)
    }

    /// As [`Scale::at`], held within the range.
    pub(super) fn within(&self, value: f64) -> f64 {
        let [start, end] = self.range;
        self.at(value).clamp(start.min(end), start.max(end))
    }
}

/// The smallest of 1, 2, 5 × 10ⁿ that divides `span` into at most `most` parts.
pub(super) fn round_step(span: f64, most: usize) -> f64 {
    let rough = span / most.max(1) as f64;
    let decade = 10.0_f64.powf(rough.log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * decade >= rough * (1.0 - 1e-9));
    factor.unwrap_or(10.0) * decade
}

/// The multiples of `step` from `from` to `to`.
pub(super) fn multiples(from: f64, to: f64, step: f64) -> Vec<f64> {
    let (first, last) = ((from / step - 1e-6).ceil(), (to / step + 1e-6).floor());
    (0..=(last - first) as usize).map(|k| (first + k as f64) * step).collect()
}

/// A tick's label, with the decimals that `step` needs and a true minus sign.
pub(super) fn tick_label(value: f64, step: f64) -> String {
    let decimals = (-(step.log10() + 1e-9).floor()).clamp(0.0, 9.0) as usize;
    let text = format!("{value:.decimals$}");
    let zero = text.bytes().all(|byte| matches!(byte, b'-' | b'0' | b'.'));
    if zero { text.trim_start_matches('-').to_owned() } else { text.replace('-', "\u{2212}") }
}

/// A power of ten, such as 10⁻⁴.
pub(super) fn power_of_ten(exponent: i32) -> String {
    let superscript = |digit: char| match digit.to_digit(10) {
        Some(1) => '\u{b9}',
        Some(value @ 2..=3) => char::from_u32(0xb0 + value).unwrap_or(digit),
        Some(value) => char::from_u32(0x2070 + value).unwrap_or(digit),
        None => '\u{207b}',
    };
    format!("10{}", exponent.to_string().chars().map(superscript).collect::<String>())
}

/// What an axis covers.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Axis {
    /// What it measures, with the unit.
    pub(super) label: String,
    /// From where to where.
    pub(super) domain: [f64; 2],
    /// Distance of the ticks.
    pub(super) step: f64,
}

impl Axis {
    /// An axis around `values` with about `intervals` intervals, that covers `least` at the least.
    pub(super) fn around(
        label: impl Into<String>,
        values: impl IntoIterator<Item = f64>,
        least: f64,
        intervals: usize,
    ) -> Self {
        let [low, high] = covered(values, least);
        let step = round_step(high - low, intervals);
        let round = outward([low, high], step);
        let air = 0.06 * (high - low);
        let tight = [round[0].max(low - air), round[1].min(high + air)];
        let domain = if multiples(tight[0], tight[1], step).len() < 3 { round } else { tight };
        Self { label: label.into(), domain, step }
    }

    /// It, made longer so that it ends on ticks.
    pub(super) fn rounded(self) -> Self {
        Self { domain: outward(self.domain, self.step), ..self }
    }

    /// An axis around `values` whose ticks lie where those of a rounded `other` lie.
    pub(super) fn beside(
        other: &Self,
        label: impl Into<String>,
        values: impl IntoIterator<Item = f64>,
        least: f64,
    ) -> Self {
        let intervals = ((other.domain[1] - other.domain[0]) / other.step).round();
        let [low, high] = covered(values, least);
        let mut step = round_step(high - low, intervals as usize);
        let spare = |step: f64| {
            let [from, to] = outward([low, high], step);
            intervals - ((to - from) / step).round()
        };
        while spare(step) < -0.5 {
            step = round_step(1.5 * step, 1);
        }
        let from = outward([low, high], step)[0] - (0.5 * spare(step)).floor() * step;
        Self { label: label.into(), domain: [from, from + intervals * step], step }
    }

    /// Its ticks.
    pub(super) fn ticks(&self) -> Vec<f64> {
        multiples(self.domain[0], self.domain[1], self.step)
    }
}

/// What `values` cover, widened to `least`.
fn covered(values: impl IntoIterator<Item = f64>, least: f64) -> [f64; 2] {
    let (low, high) = extent(values).unwrap_or((0.0, 0.0));
    let missing = (least - (high - low)).max(0.0);
    [low - 0.5 * missing, high + 0.5 * missing]
}

/// The next multiples of `step` outside of a range; what is over one by a hundredth of the range does not count.
fn outward([low, high]: [f64; 2], step: f64) -> [f64; 2] {
    let little = 0.01 * (high - low);
    [((low + little) / step).floor() * step, ((high - little) / step).ceil() * step]
}

/// Smallest and largest of the finite `values`, held within what can be drawn.
pub(super) fn extent(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    let finite = values.into_iter().filter(|value| value.is_finite()).map(|value| value.clamp(-1e12, 1e12));
    finite.fold(None, |ends, value| match ends {
        None => Some((value, value)),
        Some((low, high)) => Some((value.min(low), value.max(high))),
    })
}

/// How far a thinned line may be from the full one [px].
const TOLERANCE: f64 = 0.2;

/// Thins a line whose points come from left to right [px]: of each column of pixels its lowest and highest point, of
/// those what a straight line would miss. Where a point is not finite the line is broken.
pub(super) fn thin(points: impl IntoIterator<Item = [f64; 2]>) -> Vec<Vec<[f64; 2]>> {
    let mut lines = vec![Vec::new()];
    for point in points {
        if point.iter().all(|value| value.is_finite()) {
            lines.last_mut().expect("there is always a line").push(point);
        } else {
            lines.push(Vec::new());
        }
    }
    lines.iter().filter(|line| !line.is_empty()).map(|line| straighten(&columns(line))).collect()
}

/// First and last point of a line, and the lowest and highest of each column of pixels.
fn columns(line: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut kept = vec![0];
    let mut start = 0;
    for column in line.chunk_by(|a, b| a[0].floor().total_cmp(&b[0].floor()).is_eq()) {
        let place = |index: usize| (column[index][1], index);
        let lowest = (0..column.len()).map(place).fold(place(0), |a, b| if b.0 < a.0 { b } else { a }).1;
        let highest = (0..column.len()).map(place).fold(place(0), |a, b| if b.0 > a.0 { b } else { a }).1;
        kept.extend([start + lowest.min(highest), start + lowest.max(highest)]);
        start += column.len();
    }
    kept.push(line.len() - 1);
    kept.dedup();
    kept.into_iter().map(|index| line[index]).collect()
}

/// Leaves out points that lie within [`TOLERANCE`] of the line between the ones that stay.
fn straighten(line: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut kept = vec![0];
    let mut anchor = 0;
    // Slopes from the anchor that miss no point since then.
    let (mut shallow, mut steep) = (f64::NEG_INFINITY, f64::INFINITY);
    for (index, [x, y]) in line.iter().enumerate().skip(1) {
        let slope = |anchor: usize, y: f64| (y - line[anchor][1]) / (x - line[anchor][0]);
        let straight = *x > line[anchor][0] && (shallow..=steep).contains(&slope(anchor, *y));
        if !straight && index - 1 > anchor {
            anchor = index - 1;
            kept.push(anchor);
            (shallow, steep) = (f64::NEG_INFINITY, f64::INFINITY);
        }
        if *x > line[anchor][0] {
            shallow = shallow.max(slope(anchor, y - TOLERANCE));
            steep = steep.min(slope(anchor, y + TOLERANCE));
        } else {
            anchor = index;
            kept.push(anchor);
        }
    }
    kept.push(line.len() - 1);
    kept.dedup();
    kept.into_iter().map(|index| line[index]).collect()
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
    fn an_axis_covers_its_values() {
        for values in [vec![-220.0, 220.0], vec![0.013], vec![], vec![f64::NAN, 3.0, f64::INFINITY], vec![0.1, 7.3]] {
            for intervals in 2..8 {
                let axis = Axis::around("", values.iter().copied(), 0.01, intervals);
                assert!((2..=intervals + 3).contains(&axis.ticks().len()), "{axis:?}");
                let little = 0.011 * (axis.domain[1] - axis.domain[0]);
                let inside = |value: &f64| *value >= axis.domain[0] - little && *value <= axis.domain[1] + little;
                assert!(values.iter().filter(|value| value.is_finite()).all(inside), "{axis:?}");
                let round = axis.clone().rounded();
                let ticks = round.ticks();
                assert!((ticks[0] - round.domain[0]).abs() < 1e-9, "{round:?}");
                assert!((ticks[ticks.len() - 1] - round.domain[1]).abs() < 1e-9, "{round:?}");
            }
        }
    }

    #[test]
    fn a_hair_over_a_tick_adds_no_interval() {
        assert!(Axis::around("", [-1e-4, 0.0622], 0.0, 5).domain[0].abs() < 1e-12);
    }

    #[test]
    fn axes_side_by_side_share_their_ticks() {
        let left = Axis::around("", [0.0, 0.062], 0.0, 4).rounded();
        for values in [[0.855, 0.897], [0.0, 1.0], [-3.0, 0.1]] {
            let right = Axis::beside(&left, "", values, 0.01);
            assert_eq!(left.ticks().len(), right.ticks().len());
            let little = 0.01 * (values[1] - values[0]);
            assert!(right.domain[0] <= values[0] + little && right.domain[1] >= values[1] - little);
        }
    }

    #[test]
    fn a_thinned_line_keeps_ends_and_peaks_and_stays_close() {
        // It rises by less than a pixel a pixel, save for one peak.
        let wave = |k: usize| [k as f64 * 0.05, 20.0 * (k as f64 * 0.002).sin() + if k == 4321 { 500.0 } else { 0.0 }];
        let lines = thin((0..10_000).map(wave));
        assert_eq!(lines.len(), 1);
        let line = &lines[0];
        assert!(line.len() < 100, "{}", line.len());
        assert_eq!((line[0], line[line.len() - 1]), (wave(0), wave(9999)));
        assert!(line.contains(&wave(4321)));
        for k in (0..4300).chain(4340..10_000) {
            let [x, y] = wave(k);
            let right = line.iter().position(|point| point[0] >= x).expect("it reaches to the end");
            let [a, b] = [line[right.saturating_sub(1)], line[right]];
            let share = if b[0] > a[0] { (x - a[0]) / (b[0] - a[0]) } else { 0.0 };
            assert!((y - a[1] - share * (b[1] - a[1])).abs() < 1.0, "{k}");
        }
    }

    #[test]
    fn a_straight_line_needs_two_points_and_a_gap_breaks_it() {
        assert_eq!(thin((0..1000).map(|k| [f64::from(k), 2.0 * f64::from(k)]))[0].len(), 2);
        let gap = |k: i32| [f64::from(k), if k == 5 { f64::NAN } else { 1.0 }];
        assert_eq!(thin((0..10).map(gap)).len(), 2);
        assert!(thin([]).is_empty());
        assert_eq!(thin([[1.0, 2.0]]), [[[1.0, 2.0]]]);
    }

    #[test]
    fn a_pixel_is_always_a_number() {
        let shown = |value: f64| Px(value).to_string();
        assert_eq!([shown(1.25), shown(-0.04), shown(-3.0), shown(-0.55)], ["1.3", "0", "-3", "-0.6"]);
        assert_eq!([shown(f64::NAN), shown(f64::INFINITY)], ["0", "1000000"]);
    }
}
