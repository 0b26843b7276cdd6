//! Axes of numbers, linear or logarithmic, and of texts: where on the paper their values and ticks are.

use super::numbers::{extent, multiples, power_of_ten, round_step, tick_label};
use super::svg::text_width;

/// What an axis or a colour shows.
#[derive(Clone, Debug, Default)]
pub(crate) struct Quantity {
    pub(crate) name: String,
    /// Empty where it has none.
    pub(crate) unit: String,
    /// Whether equal ratios are equally far apart; ignored where a value is not positive.
    pub(crate) log: bool,
}

impl Quantity {
    /// A quantity whose axis is linear.
    pub(crate) fn new(name: impl Into<String>, unit: &str) -> Self {
        Self { name: name.into(), unit: unit.to_owned(), log: false }
    }

    /// The same on a logarithmic axis, if `log`.
    pub(crate) fn logarithmic(self, log: bool) -> Self {
        Self { log, ..self }
    }

    /// Its name, and in brackets a power of ten and its unit.
    pub(crate) fn title(&self, exponent: i32) -> String {
        let power = if exponent == 0 { String::new() } else { power_of_ten(exponent) };
        let bracket =
            [power, self.unit.clone()].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ");
        let parts = [self.name.clone(), if bracket.is_empty() { bracket } else { format!("[{bracket}]") }];
        parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ")
    }
}

/// A linear map from data to pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Scale {
    /// What the data cover.
    domain: [f64; 2],
    /// Where that is drawn [px].
    range: [f64; 2],
}

impl Scale {
    /// Where `value` is drawn [px].
    fn at(&self, value: f64) -> f64 {
        let [from, to] = self.domain;
        let [start, end] = self.range;
        start + (value - from) / (to - from) * (end - start)
    }

    /// As [`Scale::at`], held within the range.
    fn within(&self, value: f64) -> f64 {
        let [start, end] = self.range;
        self.at(value).clamp(start.min(end), start.max(end))
    }
}

/// A mark of an axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tick {
    /// Where along the axis [px].
    pub(super) at: f64,
    /// Empty for a mark between two numbers.
    pub(super) label: String,
}

/// What an axis shows and covers, before it has its place on the paper.
#[derive(Clone, Debug)]
pub(crate) struct Axis {
    quantity: Quantity,
    covers: Covers,
}

#[derive(Clone, Debug)]
enum Covers {
    /// From the first to the second value, a little more, and at least that much.
    Around([f64; 2], Option<f64>),
    /// From here to there and no further.
    Exactly([f64; 2]),
    /// The n-th text at the value n.
    Texts(Vec<String>),
}

impl Axis {
    /// An axis that covers `values` and a little more.
    pub(crate) fn around(quantity: Quantity, values: impl IntoIterator<Item = f64>) -> Self {
        let (low, high) = extent(values).unwrap_or((f64::NAN, f64::NAN));
        Self { quantity, covers: Covers::Around([low, high], None) }
    }

    /// As [`Axis::around`], with zero where the values are close to it.
    pub(crate) fn near_zero(quantity: Quantity, values: impl IntoIterator<Item = f64>) -> Self {
        let (low, high) = extent(values).unwrap_or((f64::NAN, f64::NAN));
        let low = if low > 0.0 && low < 0.6 * high && !quantity.log { 0.0 } else { low };
        Self { quantity, covers: Covers::Around([low, high], None) }
    }

    /// An axis that covers at least so much, whatever its values.
    pub(crate) fn at_least(mut self, least: f64) -> Self {
        if let Covers::Around(_, covered) = &mut self.covers {
            *covered = Some(least);
        }
        self
    }

    /// An axis that covers `domain` and no more.
    pub(crate) fn exactly(quantity: Quantity, domain: [f64; 2]) -> Self {
        Self { quantity, covers: Covers::Exactly(domain) }
    }

    /// An axis of texts, the n-th at the value n. Where there is no room for a line each, every second, third, ... is left.
    pub(crate) fn of_texts(title: &str, texts: Vec<String>) -> Self {
        Self { quantity: Quantity::new(title, ""), covers: Covers::Texts(texts) }
    }

    /// Its texts cut off to be at most `width` wide [px].
    pub(super) fn shortened(&self, width: f64) -> Self {
        let mut axis = self.clone();
        if let Covers::Texts(texts) = &mut axis.covers {
            texts.iter_mut().for_each(|text| *text = shortened(text, width));
        }
        axis
    }

    /// Its name and unit.
    pub(super) fn title(&self) -> String {
        self.quantity.title(0)
    }

    /// Its texts; none of an axis of numbers.
    pub(super) fn texts(&self) -> Option<&[String]> {
        if let Covers::Texts(texts) = &self.covers { Some(texts) } else { None }
    }

    /// It on the paper, along `range`, with numbers at least `spacing` apart [px].
    pub(super) fn on(&self, range: [f64; 2], spacing: f64) -> Ruler {
        let most = (((range[1] - range[0]).abs() / spacing) as usize).max(2);
        match &self.covers {
            Covers::Around([low, high], _) if self.quantity.log && *low > 0.0 => {
                let [low, high] = [low.log10(), high.log10()];
                let air = (0.04 * (high - low)).max(0.5 * (0.3 - (high - low)));
                logarithmic(&self.quantity, [low - air, high + air], range, most)
            }
            Covers::Around(ends, least) => linear(&self.quantity, padded(*ends, *least), range, most),
            Covers::Exactly(domain) if self.quantity.log && domain[0] > 0.0 => {
                logarithmic(&self.quantity, domain.map(f64::log10), range, most)
            }
            Covers::Exactly(domain) => linear(&self.quantity, *domain, range, most),
            Covers::Texts(texts) => of_texts(&self.quantity.name, texts, range),
        }
    }
}

/// An axis laid out on the paper.
#[derive(Clone, Debug)]
pub(super) struct Ruler {
    /// Of the values, or of their decimal logarithms.
    scale: Scale,
    log: bool,
    /// Whether its values count texts.
    of_texts: bool,
    pub(super) ticks: Vec<Tick>,
    pub(super) title: String,
}

/// Least slope of labels that do not fit side by side [degrees], and how far apart they then are [px].
const SLANT: f64 = 35.0;
const LINE: f64 = 14.0;

impl Ruler {
    /// Where `value` is drawn [px], within the axis; not a number for what is none.
    pub(super) fn at(&self, value: f64) -> f64 {
        if !value.is_finite() {
            return f64::NAN;
        }
        self.scale.within(if self.log { value.max(f64::MIN_POSITIVE).log10() } else { value })
    }

    /// From where to where it reaches [px].
    pub(super) fn range(&self) -> [f64; 2] {
        self.scale.range
    }

    /// Whether zero lies between its ends, and is one of its values.
    pub(super) fn crosses_zero(&self) -> bool {
        let [from, to] = self.domain();
        !self.of_texts && from < 0.0 && to > 0.0
    }

    /// What it covers.
    pub(super) fn domain(&self) -> [f64; 2] {
        self.scale.domain.map(|end| if self.log { 10.0_f64.powf(end) } else { end })
    }

    /// Width of the widest label [px].
    pub(super) fn widest(&self) -> f64 {
        self.ticks.iter().map(|tick| text_width(&tick.label)).fold(0.0, f64::max)
    }

    /// Whether its labels must be slanted not to touch, were it horizontal.
    pub(super) fn is_slanted(&self) -> bool {
        let labelled: Vec<&Tick> = self.ticks.iter().filter(|tick| !tick.label.is_empty()).collect();
        labelled.windows(2).any(|pair| {
            0.5 * (text_width(&pair[0].label) + text_width(&pair[1].label)) + 6.0 > (pair[1].at - pair[0].at).abs()
        })
    }

    /// How steep the labels of a horizontal axis rise [degrees]: just so that they do not touch.
    pub(super) fn slant(&self) -> f64 {
        if !self.is_slanted() {
            return 0.0;
        }
        let apart = self.ticks.windows(2).map(|pair| (pair[1].at - pair[0].at).abs()).fold(f64::INFINITY, f64::min);
        (LINE / apart).min(1.0).asin().to_degrees().max(SLANT).round()
    }

    /// What the labels of a horizontal axis need below it, left of its left end, and right of its right end [px].
    pub(super) fn needs(&self) -> [f64; 3] {
        let (sin, cos) = self.slant().to_radians().sin_cos();
        let [start, end] = self.scale.range;
        let beyond = |share: f64| {
            self.ticks.iter().map(|tick| share * text_width(&tick.label) - (tick.at - start)).fold(0.0, f64::max)
        };
        let after = self.ticks.iter().map(|tick| 0.5 * text_width(&tick.label) - (end - tick.at)).fold(0.0, f64::max);
        if self.is_slanted() {
            [18.0 + sin * self.widest(), 4.0 + beyond(cos), 0.0]
        } else {
            [22.0, beyond(0.5), after]
        }
    }
}

fn of_texts(title: &str, texts: &[String], range: [f64; 2]) -> Ruler {
    let count = texts.len().max(1) as f64;
    let scale = Scale { domain: [-0.5, count - 0.5], range };
    let stride = (LINE * count / (range[1] - range[0]).abs()).ceil().max(1.0) as usize;
    let shown = texts.iter().enumerate().step_by(stride);
    let ticks = shown.map(|(k, text)| Tick { at: scale.at(k as f64), label: text.clone() });
    Ruler { scale, log: false, of_texts: true, ticks: ticks.collect(), title: title.to_owned() }
}

/// A range of values, a little wider, and at least `least` wide; never empty.
fn padded([low, high]: [f64; 2], least: Option<f64>) -> [f64; 2] {
    let [low, high] = if low.is_nan() { [0.0, if least.is_some() { 0.0 } else { 1.0 }] } else { [low, high] };
    let least = least.unwrap_or(if high == 0.0 { 1.0 } else { 0.2 * high.abs() });
    let missing = (least - (high - low)).max(0.0);
    let air = 0.07 * (high - low + missing);
    // What is never negative does not look as if it were.
    let down = if low >= 0.0 { low.min(air + 0.5 * missing) } else { air + 0.5 * missing };
    [low - down, high + air + 0.5 * missing]
}

fn linear(quantity: &Quantity, domain: [f64; 2], range: [f64; 2], most: usize) -> Ruler {
    let scale = Scale { domain, range };
    let largest = domain[0].abs().max(domain[1].abs());
    let exponent = if (1e-3..1e4).contains(&largest) { 0 } else { 3 * (largest.log10() / 3.0).floor() as i32 };
    let unit = 10.0_f64.powi(exponent);
    let ruler = |step: f64| {
        let tick = |value: f64| Tick { at: scale.at(value), label: tick_label(value / unit, step / unit) };
        let ticks = multiples(domain[0], domain[1], step).into_iter().map(tick).collect();
        Ruler { scale, log: false, of_texts: false, ticks, title: quantity.title(exponent) }
    };
    let span = domain[1] - domain[0];
    let mut step = round_step(span, most);
    // A vertical axis, whose range runs upwards, has room for a number of any width.
    while range[1] > range[0] && step < 0.4 * span && ruler(step).is_slanted() {
        step = round_step(1.5 * step, 1);
    }
    while ruler(step).ticks.len() < 2 {
        step = round_step(0.4 * step, 1);
    }
    ruler(step)
}

/// An axis whose domain is given as decimal logarithms.
fn logarithmic(quantity: &Quantity, domain: [f64; 2], range: [f64; 2], most: usize) -> Ruler {
    let scale = Scale { domain, range };
    let [from, to] = domain;
    let decades: Vec<i32> = ((from - 1e-9).ceil() as i32..=(to + 1e-9).floor() as i32).collect();
    let tick = |value: f64, label: String| Tick { at: scale.within(value.log10()), label };
    let ticks = if decades.len() >= 2 {
        let stride = decades.len().div_ceil(most.max(1));
        let numbered = |exponent: i32| exponent.rem_euclid(stride as i32) == 0;
        let plain = decades.iter().filter(|e| numbered(**e)).all(|exponent| (-2..=3).contains(exponent));
        let label = |exponent: i32| match plain {
            _ if !numbered(exponent) => String::new(),
            true => tick_label(10.0_f64.powi(exponent), 10.0_f64.powi(exponent.min(0))),
            false => power_of_ten(exponent),
        };
        let mut ticks: Vec<Tick> = decades.iter().map(|&e| tick(10.0_f64.powi(e), label(e))).collect();
        if stride == 1 && decades.len() <= 6 {
            let between = (decades[0] - 1..=decades[decades.len() - 1])
                .flat_map(|exponent| (2..10).map(move |digit| f64::from(digit) * 10.0_f64.powi(exponent)))
                .filter(|value| (from..=to).contains(&value.log10()));
            ticks.extend(between.map(|value| tick(value, String::new())));
        }
        ticks
    } else {
        within_a_decade(scale.domain.map(|end| 10.0_f64.powf(end)), most)
            .into_iter()
            .map(|(value, label)| tick(value, label))
            .collect()
    };
    Ruler { scale, log: true, of_texts: false, ticks, title: quantity.title(0) }
}

/// Round numbers on a logarithmic axis that has no two powers of ten on it.
fn within_a_decade([from, to]: [f64; 2], most: usize) -> Vec<(f64, String)> {
    let first = from.log10().floor() as i32;
    let fine = |digits: &[f64]| -> Vec<f64> {
        let all = (first..=first + 1).flat_map(|e| digits.iter().map(move |digit| digit * 10.0_f64.powi(e)));
        all.filter(|value| (from..=to).contains(value)).collect()
    };
    let values = [fine(&[1.0, 2.0, 5.0]), fine(&[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0])];
    let values = values.into_iter().find(|values| (2..=most.max(3)).contains(&values.len()));
    let values = values.unwrap_or_else(|| multiples(from, to, round_step(to - from, most.clamp(3, 5))));
    let label = |value: f64| {
        let exponent = value.log10().floor() as i32;
        if (-3..4).contains(&exponent) {
            let fine = tick_label(value, 10.0_f64.powi((exponent - 1).min(0)));
            if exponent < 1 { fine.trim_end_matches('0').trim_end_matches('.').to_owned() } else { fine }
        } else {
            let digits = format!("{:.1}", value / 10.0_f64.powi(exponent));
            format!("{}\u{b7}{}", digits.trim_end_matches(".0"), power_of_ten(exponent))
        }
    };
    values.into_iter().map(|value| (value, label(value))).collect()
}

/// A text cut off to be at most `width` wide [px].
fn shortened(text: &str, width: f64) -> String {
    if text_width(text) <= width {
        return text.to_owned();
    }
    let mut kept = String::new();
    for letter in text.chars() {
        if text_width(&kept) + text_width("m\u{2026}") > width {
            break;
        }
        kept.push(letter);
    }
    format!("{}\u{2026}", kept.trim_end())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quantity(log: bool) -> Quantity {
        Quantity { name: "gain".into(), unit: "Nm".into(), log }
    }

    fn labels(ruler: &Ruler) -> Vec<&str> {
        ruler.ticks.iter().map(|tick| tick.label.as_str()).filter(|label| !label.is_empty()).collect()
    }

    #[test]
    fn a_logarithmic_axis_has_its_numbers_at_decades() {
        let ruler = Axis::around(quantity(true), [2e-5, 3e-1]).on([0.0, 400.0], 40.0);
        assert_eq!(labels(&ruler), ["10\u{207b}\u{2074}", "10\u{207b}\u{b3}", "10\u{207b}\u{b2}", "10\u{207b}\u{b9}"]);
        let numbered: Vec<f64> = ruler.ticks.iter().filter(|t| !t.label.is_empty()).map(|t| t.at).collect();
        assert!(
            numbered.windows(3).all(|at| (at[2] - 2.0 * at[1] + at[0]).abs() < 1e-9),
            "equal ratios, equally far apart"
        );
        assert!((numbered[1] - ruler.at(1e-3)).abs() < 1e-9);
        assert_eq!(ruler.ticks.len() - 4, 8 * 4 + 3, "2e-5 to 9e-2, and up to 4e-1");
    }

    #[test]
    fn few_decades_have_plain_numbers() {
        let shown = |low: f64, high: f64| {
            let ruler = Axis::around(quantity(true), [low, high]).on([0.0, 300.0], 40.0);
            labels(&ruler).join(" ")
        };
        assert_eq!(shown(0.01, 100.0), "0.01 0.1 1 10 100");
        assert_eq!(shown(0.2, 4.0), "0.2 0.5 1 2");
        assert_eq!(shown(20.0, 70.0), "20 50");
        assert_eq!(shown(2e-6, 7e-6), "2\u{b7}10\u{207b}\u{2076} 5\u{b7}10\u{207b}\u{2076}");
    }

    #[test]
    fn a_value_that_is_not_positive_has_no_logarithm() {
        for values in [[0.0, 10.0], [-1.0, 10.0]] {
            assert!(!Axis::around(quantity(true), values).on([0.0, 300.0], 40.0).log);
        }
        assert!(Axis::around(quantity(true), [f64::NAN, 1.0, 10.0]).on([0.0, 300.0], 40.0).log);
    }

    #[test]
    fn every_axis_has_numbers_that_do_not_touch() {
        let all: [&[f64]; 12] = [
            &[],
            &[0.0],
            &[3.0],
            &[-7.0],
            &[1e-9],
            &[f64::NAN, 2.0],
            &[1e300],
            &[5.0, 5.0],
            &[-1e-4, 3e-4],
            &[0.1, 0.13],
            &[1e-8, 1e8],
            &[99_990.0, 100_010.0],
        ];
        for values in all {
            for range in [[10.0, 90.0], [0.0, 240.0], [0.0, 800.0], [200.0, 0.0]] {
                for log in [false, true] {
                    let ruler = Axis::around(quantity(log), values.iter().copied()).on(range, 36.0);
                    assert!(!labels(&ruler).is_empty(), "{values:?} {ruler:?}");
                    let [low, high] = [range[0].min(range[1]), range[0].max(range[1])];
                    assert!(
                        ruler.ticks.iter().all(|tick| (low - 0.1..=high + 0.1).contains(&tick.at)),
                        "{values:?} {ruler:?}"
                    );
                    let mut different = labels(&ruler);
                    different.dedup();
                    assert_eq!(different, labels(&ruler), "{values:?}");
                    if range[0] < range[1] && range[1] > 200.0 && !log {
                        assert!(!ruler.is_slanted(), "{values:?} {:?}", labels(&ruler));
                    }
                }
            }
        }
    }

    #[test]
    fn a_value_lies_between_the_ticks_around_it() {
        let ruler = Axis::around(quantity(false), [0.0, 10.0]).on([0.0, 500.0], 50.0);
        let at = |label: &str| ruler.ticks.iter().find(|tick| tick.label == label).expect("a tick").at;
        assert!((ruler.at(5.0) - 0.5 * (at("4") + at("6"))).abs() < 1e-9);
    }

    #[test]
    fn texts_stand_a_line_apart_however_many_there_are() {
        for count in [1_usize, 7, 20, 21, 200, 5000] {
            let texts: Vec<String> = (0..count).map(|k| k.to_string()).collect();
            let ruler = Axis::of_texts("seed", texts).on([40.0, 320.0], 40.0);
            assert!(ruler.ticks.windows(2).all(|pair| pair[1].at - pair[0].at >= LINE - 1e-9), "{count}");
            // At their own places, and as many as fit: 280 px are 20 lines.
            assert!(ruler.ticks.iter().all(|tick| tick.at == ruler.at(tick.label.parse().expect("a number"))));
            let stride = count.div_ceil(20);
            assert_eq!(ruler.ticks.len(), count.div_ceil(stride), "{count}");
            assert_eq!(labels(&ruler)[0], "0");
        }
        assert!(Axis::of_texts("", Vec::new()).on([0.0, 100.0], 40.0).ticks.is_empty());
    }

    #[test]
    fn large_and_small_numbers_have_their_power_in_the_title() {
        let title = |value: f64| Axis::around(quantity(false), [0.0, value]).on([100.0, 0.0], 20.0).title;
        assert_eq!(title(20_000.0), "gain [10\u{b3} Nm]");
        assert_eq!(title(2e-4), "gain [10\u{207b}\u{2076} Nm]");
        assert_eq!(title(20.0), "gain [Nm]");
        assert_eq!(Quantity { name: "index".into(), ..Quantity::default() }.title(3), "index [10\u{b3}]");
        let ruler = Axis::around(quantity(false), [0.0, 20_000.0]).on([100.0, 0.0], 20.0);
        assert_eq!(labels(&ruler), ["0", "5", "10", "15", "20"]);
    }

    #[test]
    fn a_long_text_ends_in_an_ellipsis() {
        assert_eq!(shortened("short", 200.0), "short");
        for width in [30.0, 60.0, 90.0] {
            let text = shortened("the weight of the task of the torso", width);
            assert!(text.ends_with('\u{2026}') && text_width(&text) <= width, "{text}");
        }
    }
}
