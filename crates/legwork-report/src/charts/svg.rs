//! Drawings as SVG: what every figure is made of.

use maud::{Markup, PreEscaped, html};

use super::numbers::Px;

/// Colours and line styles, shared by the page and the files of `--plots`.
pub(crate) const FIGURE_STYLE: &str = include_str!("figure.css");
/// The colours of a light page.
pub(crate) const LIGHT: &str = include_str!("light.css");

/// Height of a row of the legend [px].
const ROW: f64 = 20.0;

/// A finished drawing.
#[derive(Clone, Debug)]
pub(crate) struct Drawing {
    pub(crate) width: f64,
    pub(crate) height: f64,
    /// What is to be seen, for who can't see it.
    pub(crate) description: String,
    /// Where a time axis lies: from when to when [s], from where to where [px], from top to bottom [px].
    pub(crate) time_axis: Option<[[f64; 2]; 3]>,
    pub(crate) content: Markup,
}

impl Drawing {
    /// It as part of a page.
    pub(crate) fn inline(&self, class: &str) -> Markup {
        let pair = |[a, b]: [f64; 2]| format!("{} {}", Px(a), Px(b));
        let seconds = self.time_axis.map(|[time, ..]| format!("{} {}", time[0], time[1]));
        let [across, down] = [1, 2].map(|k| self.time_axis.map(|axis| pair(axis[k])));
        html! {
            svg class={ "figure " (class) } viewBox={ "0 0 " (Px(self.width)) " " (Px(self.height)) } role="img"
                aria-label=(self.description) data-span=[seconds] data-across=[across] data-down=[down] {
                (self.content)
            }
        }
    }

    /// It as a file of its own, in the light colours.
    pub(crate) fn standalone(&self, title: &str) -> String {
        let (width, height) = (Px(self.width), Px(self.height));
        let drawing = html! {
            svg xmlns="http://www.w3.org/2000/svg" class="figure" width=(width) height=(height)
                viewBox={ "0 0 " (width) " " (height) } role="img" {
                title { (title) }
                desc { (self.description) }
                style { (PreEscaped(resolved_style())) }
                rect class="paper" width="100%" height="100%" {}
                (self.content)
            }
        };
        format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n{}\n", drawing.into_string())
    }
}

/// The style with its colours written out: many programs that read SVG know no variables.
fn resolved_style() -> String {
    let declarations = LIGHT.lines().filter_map(|line| line.trim().strip_suffix(';')?.split_once(": "));
    declarations
        .filter(|(name, _)| name.starts_with("--"))
        .fold(FIGURE_STYLE.to_owned(), |style, (name, value)| style.replace(&format!("var({name})"), value))
}

/// Points joined by straight lines, as a path.
pub(crate) fn path(lines: &[Vec<[f64; 2]>]) -> String {
    let mut text = String::new();
    for line in lines {
        for (index, [x, y]) in line.iter().enumerate() {
            text += &format!("{}{} {}", if index == 0 { "M" } else { "L" }, Px(*x), Px(*y));
        }
    }
    text
}

/// An arrow from `tail` to `tip` [px] as a path; nothing where it would be shorter than two pixels.
pub(crate) fn arrow(tail: [f64; 2], tip: [f64; 2]) -> String {
    let (x, y) = (tip[0] - tail[0], tip[1] - tail[1]);
    let length = x.hypot(y);
    if !(2.0..1e6).contains(&length) {
        return String::new();
    }
    let head = 11.0_f64.min(0.5 * length) / length;
    let corner = |side: f64| [tip[0] - head * (x + side * 0.4 * y), tip[1] - head * (y - side * 0.4 * x)];
    let neck = [tip[0] - 0.8 * head * x, tip[1] - 0.8 * head * y];
    path(&[vec![tail, neck], vec![corner(1.0), tip, corner(-1.0)]]) + "Z"
}

/// An asterisk of six arms around `centre` [px] as a path.
pub(crate) fn asterisk(centre: [f64; 2], radius: f64) -> String {
    let arms = [0.5, 7.0 / 6.0, 11.0 / 6.0].map(|turn: f64| {
        let (sin, cos) = (turn * std::f64::consts::PI).sin_cos();
        let end = |side: f64| [centre[0] + side * radius * cos, centre[1] + side * radius * sin];
        vec![end(1.0), end(-1.0)]
    });
    path(&arms)
}

/// An upright cross, turned by an eighth, around `centre` [px] as a path.
pub(crate) fn cross([x, y]: [f64; 2], radius: f64) -> String {
    path(&[
        vec![[x - radius, y - radius], [x + radius, y + radius]],
        vec![[x - radius, y + radius], [x + radius, y - radius]],
    ])
}

/// An error bar between two points on one vertical or horizontal [px] as a path.
pub(crate) fn whisker(from: [f64; 2], to: [f64; 2]) -> String {
    let cap = |[x, y]: [f64; 2]| {
        if (from[0] - to[0]).abs() < 1e-9 { vec![[x - 3.0, y], [x + 3.0, y]] } else { vec![[x, y - 3.0], [x, y + 3.0]] }
    };
    path(&[cap(from), vec![from, to], cap(to)])
}

/// Radius of a ring around a mark [px].
pub(crate) const RING: f64 = 6.0;

/// How many marks of [`shape`] differ.
pub(crate) const SHAPES: usize = 6;

/// The mark of the `index`-th series around `centre` [px] as a closed path: marks tell series apart without colours.
pub(crate) fn shape(index: usize, [x, y]: [f64; 2], radius: f64) -> String {
    let corners: &[[f64; 2]] = match index % SHAPES {
        0 => {
            let r = Px(radius);
            return format!(
                "M{} {}a{r} {r} 0 1 0 {} 0a{r} {r} 0 1 0 -{} 0Z",
                Px(x - radius),
                Px(y),
                Px(2.0 * radius),
                Px(2.0 * radius)
            );
        }
        1 => &[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]],
        2 => &[[0.0, -1.2], [1.1, 0.8], [-1.1, 0.8]],
        3 => &[[0.0, -1.3], [1.1, 0.0], [0.0, 1.3], [-1.1, 0.0]],
        4 => &[[0.0, 1.2], [1.1, -0.8], [-1.1, -0.8]],
        _ => &[
            [-1.2, -0.45],
            [-0.45, -0.45],
            [-0.45, -1.2],
            [0.45, -1.2],
            [0.45, -0.45],
            [1.2, -0.45],
            [1.2, 0.45],
            [0.45, 0.45],
            [0.45, 1.2],
            [-0.45, 1.2],
            [-0.45, 0.45],
            [-1.2, 0.45],
        ],
    };
    path(&[corners.iter().map(|[i, j]| [x + radius * i, y + radius * j]).collect()]) + "Z"
}

/// How an entry of a legend is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Symbol {
    /// A piece of a line.
    Line,
    /// A piece of an area.
    Area,
    /// An asterisk.
    Asterisk,
    /// A filled circle.
    Dot,
    /// An arrow.
    Arrow,
    /// A piece of a line with the mark of the series of that index.
    Marked(usize),
    /// A cross.
    Cross,
    /// A ring.
    Ring,
    /// An error bar.
    Whisker,
}

/// An entry of a legend.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Key {
    pub(crate) symbol: Symbol,
    /// Classes of [`FIGURE_STYLE`].
    pub(crate) class: String,
    pub(crate) label: String,
}

impl Key {
    pub(crate) fn new(symbol: Symbol, class: &str, label: &str) -> Self {
        Self { symbol, class: class.to_owned(), label: label.to_owned() }
    }
}

/// About how wide a text is at the size of all texts [px]: as in Helvetica; fonts differ.
pub(crate) fn text_width(text: &str) -> f64 {
    let share = |c: char| match c {
        'i' | 'j' | 'l' | '.' | ',' | ':' | ';' | '\'' | '|' => 0.24,
        'f' | 't' | 'I' | ' ' | '(' | ')' | '[' | ']' | '/' | '-' => 0.29,
        'r' => 0.34,
        'm' | 'M' | 'w' | 'W' | '%' | '@' => 0.84,
        'A'..='Z' => 0.7,
        'c' | 'k' | 's' | 'v' | 'x' | 'y' | 'z' => 0.5,
        _ => 0.56,
    };
    12.5 * text.chars().map(share).sum::<f64>()
}

/// Draws `keys` in rows between `left` and `right` [px] from the top on; returns its height [px] as well.
pub(crate) fn legend(keys: &[Key], left: f64, right: f64) -> (Markup, f64) {
    let sample =
        |key: &Key| if matches!(key.symbol, Symbol::Line | Symbol::Arrow | Symbol::Marked(_)) { 26.0 } else { 14.0 };
    let (mut x, mut row) = (left, 0);
    let mut placed = Vec::new();
    for key in keys {
        let width = sample(key) + 6.0 + text_width(&key.label);
        if x > left && x + width > right {
            (x, row) = (left, row + 1);
        }
        placed.push((key, x, ROW * (f64::from(row) + 0.5)));
        x += width + 18.0;
    }
    let drawn = html! {
        g class="legend" {
            @for (key, x, y) in placed {
                (symbol(key, x, y, sample(key)))
                text x=(Px(x + sample(key) + 6.0)) y=(Px(y + 4.0)) { (key.label) }
            }
        }
    };
    (drawn, if keys.is_empty() { 0.0 } else { ROW * f64::from(row + 1) })
}

fn symbol(key: &Key, x: f64, y: f64, width: f64) -> Markup {
    let middle = [x + 0.5 * width, y];
    html! {
        @match key.symbol {
            Symbol::Line => path class={ "line " (key.class) } d=(path(&[vec![[x, y], [x + width, y]]])) {},
            Symbol::Area => rect class=(key.class) x=(Px(x)) y=(Px(y - 6.0)) width=(Px(width)) height="12" {},
            Symbol::Asterisk => path class={ "mark " (key.class) } d=(asterisk(middle, 6.0)) {},
            Symbol::Dot => circle class=(key.class) cx=(Px(middle[0])) cy=(Px(y)) r="5" {},
            Symbol::Arrow => path class={ "arrow " (key.class) } d=(arrow([x, y], [x + width - 3.0, y])) {},
            Symbol::Marked(index) => {
                path class={ "line " (key.class) } d=(path(&[vec![[x, y], [x + width, y]]])) {}
                path class={ "shape " (key.class) } d=(shape(index, middle, 4.0)) {}
            },
            Symbol::Cross => path class={ "cross " (key.class) } d=(cross(middle, 4.0)) {},
            Symbol::Ring => path class="doubtful" d=(shape(0, middle, RING)) {},
            Symbol::Whisker => path class="whisker" d=(whisker([middle[0], y - 6.0], [middle[0], y + 6.0])) {},
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_of_its_own_knows_no_variables() {
        let style = resolved_style();
        assert!(!style.contains("var(") && !style.contains("--"), "{style}");
        assert!(!style.contains(['<', '&']), "XML");
    }

    #[test]
    fn an_arrow_ends_at_its_tip() {
        assert!(arrow([0.0, 0.0], [100.0, 0.0]).contains("L100 0"));
        assert_eq!(arrow([0.0, 0.0], [0.0, 1.0]), "");
        assert_eq!(arrow([0.0, 0.0], [f64::NAN, 1.0]), "");
    }

    #[test]
    fn a_legend_wraps_before_the_edge() {
        let keys: Vec<Key> = (0..9).map(|k| Key::new(Symbol::Line, "left", &format!("a long entry {k}"))).collect();
        let (one, height) = legend(&keys[..1], 0.0, 100.0);
        assert!(one.into_string().contains("a long entry 0") && height.total_cmp(&ROW).is_eq());
        assert!(legend(&keys, 0.0, 400.0).1 > legend(&keys, 0.0, 2000.0).1);
        assert!(legend(&[], 0.0, 100.0).1 < 1e-9);
    }
}
