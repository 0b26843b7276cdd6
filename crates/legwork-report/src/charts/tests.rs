//! What holds for every chart: numbers are numbers, texts are escaped, neither clipped nor on top of each other.

use super::axis::{Axis, Quantity};
use super::bars::{Bar, Bars, Group};
use super::chart::{Chart, Part as Coordinates};
use super::cloud::Cloud;
use super::gallery;
use super::labels::Labelled;
use super::layer::Layer;
use super::map::{HeatMap, Holds, SurvivalMap};
use super::polar::{Curve, Polar};
use super::svg::{Drawing, text_width};
use super::sweep::{Panel, Part, Point, Series, Sweep};

const WIDTHS: [f64; 4] = [380.0, 430.0, 640.0, 860.0];

/// A text's corners on the paper, in turn.
struct Label {
    text: String,
    corners: [[f64; 2]; 4],
}

/// All texts of a drawing.
fn labels(drawing: &str) -> Vec<Label> {
    let mut anchors = vec![None];
    let mut labels = Vec::new();
    for piece in drawing.split('<').skip(1) {
        let (tag, text) = piece.split_once('>').expect("a tag ends");
        if tag.starts_with("g ") {
            anchors.push(attribute(tag, "text-anchor").map(str::to_owned));
        } else if tag == "/g" {
            anchors.pop();
        } else if tag.starts_with("text ") && !text.is_empty() {
            let anchor = attribute(tag, "text-anchor").or(anchors.last().and_then(Option::as_deref));
            labels.push(label(tag, &text.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&"), anchor));
        }
    }
    labels
}

fn attribute<'a>(tag: &'a str, name: &str) -> Option<&'a str> {
    tag.split_once(&format!(" {name}=\""))?.1.split('"').next()
}

fn label(tag: &str, text: &str, anchor: Option<&str>) -> Label {
    let number = |name| attribute(tag, name).and_then(|text| text.parse().ok()).unwrap_or(0.0);
    let (x, y): (f64, f64) = (number("x"), number("y"));
    let small = attribute(tag, "class").is_some_and(|class| class.contains("small"));
    let width = text_width(text) * if small { 11.5 / 12.5 } else { 1.0 };
    let start = match anchor {
        Some("end") => -width,
        Some("middle") => -0.5 * width,
        _ => 0.0,
    };
    let degrees = attribute(tag, "transform")
        .and_then(|turn| turn.trim_start_matches("rotate(").split(' ').next()?.parse::<f64>().ok())
        .unwrap_or(0.0);
    let (sin, cos) = degrees.to_radians().sin_cos();
    // From the baseline up to the capitals.
    let corners = [[start, -9.0], [start + width, -9.0], [start + width, 1.0], [start, 1.0]];
    Label { text: text.to_owned(), corners: corners.map(|[i, j]| [x + i * cos - j * sin, y + i * sin + j * cos]) }
}

/// Whether two rectangles overlap: no side of either has the other beyond it.
fn overlap(a: &Label, b: &Label) -> bool {
    [a, b].into_iter().all(|label| {
        (0..2).all(|side| {
            let axis = [0, 1].map(|k| label.corners[side + 1][k] - label.corners[side][k]);
            let ends = |label: &Label| {
                let along = label.corners.map(|corner| corner[0] * axis[0] + corner[1] * axis[1]);
                [
                    along.iter().copied().fold(f64::INFINITY, f64::min),
                    along.iter().copied().fold(f64::NEG_INFINITY, f64::max),
                ]
            };
            let ([a, b], [c, d]) = (ends(a), ends(b));
            a < d && c < b
        })
    })
}

fn assert_sound(name: &str, drawing: &Drawing) {
    let text = drawing.content.clone().into_string();
    let whole = drawing.standalone(name);
    for nonsense in ["NaN", "inf", "e-", "e+"] {
        let numbers: Vec<&str> = text.split(" d=\"").skip(1).map(|rest| rest.split('"').next().unwrap_or("")).collect();
        assert!(!numbers.iter().any(|path| path.contains(nonsense)), "{name}: {nonsense}");
    }
    assert!(!text.contains("NaN") && !text.contains("\"inf") && !text.contains(">inf"), "{name}");
    assert!(
        !drawing.description.contains("NaN") && !drawing.description.contains("inf"),
        "{name}: {}",
        drawing.description
    );
    crate::run::tests::assert_well_formed(&whole, &[]);
}

pub(crate) fn assert_readable(name: &str, drawing: &Drawing) {
    let labels = labels(&drawing.content.clone().into_string());
    let size = [drawing.width, drawing.height];
    for (index, label) in labels.iter().enumerate() {
        for corner in label.corners {
            let inside = (0..2).all(|k| corner[k] > -1.0 && corner[k] < size[k] + 1.0);
            assert!(inside, "{name}: '{}' at {corner:?} of {size:?}", label.text);
        }
        for other in &labels[..index] {
            assert!(!overlap(label, other), "{name}: '{}' and '{}'", label.text, other.text);
        }
    }
}

#[test]
fn texts_are_neither_clipped_nor_on_top_of_each_other() {
    for (name, draw) in gallery::charts() {
        for width in WIDTHS {
            assert_readable(&format!("{name} at {width}"), &draw(width));
        }
    }
}

#[test]
fn many_and_long_labels_are_readable_too() {
    let long = ["a long name at the start", "one", "two", "three words more", "four", "five", "six", "seven", "eight"];
    let counts: Vec<f64> = (0..long.len()).map(|k| k as f64).collect();
    let texts = |count: usize| -> Vec<String> { (0..count).map(|k| format!("{} {k}", long[k % long.len()])).collect() };
    for width in WIDTHS {
        let sweep = gallery::sweep(quantity("x"), &counts, |_, x| x < 1.0, &long);
        assert_readable("sweep", &sweep.draw(width));
        let map = |columns: usize| HeatMap {
            row_title: "rows".into(),
            column_title: "columns".into(),
            rows: texts(5),
            columns: texts(columns),
            value: quantity("a value with a long name"),
            cells: vec![counts.iter().copied().cycle().take(columns).collect(); 5],
            centre: None,
            doubtful: Vec::new(),
        };
        assert_readable("one column", &map(1).draw(width));
        assert_readable("many columns", &map(16).draw(width));
        assert_readable("bars", &gallery::bars(&long).draw(width));
        let shade = Some(quantity("a value with a very long name"));
        assert_readable(
            "survival",
            &SurvivalMap { shade, y: quantity("the long name of the vertical axis"), ..gallery::survival(true) }
                .draw(width),
        );
    }
}

#[test]
fn every_chart_is_sound_and_the_same_each_time() {
    for (name, draw) in gallery::charts() {
        for width in WIDTHS {
            assert_sound(name, &draw(width));
            assert_eq!(draw(width).standalone(name), draw(width).standalone(name));
        }
    }
}

fn quantity(name: &str) -> Quantity {
    Quantity::new(name, "m").logarithmic(true)
}

/// Every chart of one value at one place, labelled with one text.
fn of_one(label: &str, x: f64, y: f64) -> Vec<(&'static str, Drawing)> {
    let (own, title) = (|| quantity(label), || label.to_owned());
    let sweep = |fell: bool| Sweep {
        x: own(),
        categories: Vec::new(),
        marked: Some((x, title())),
        series: vec![Series { label: title(), points: vec![Point { x, fell, doubtful: fell }] }],
        panels: vec![Panel { title: title(), parts: vec![Part::new(own(), vec![vec![y]])] }],
    };
    let heat = |centre| HeatMap {
        row_title: title(),
        column_title: title(),
        rows: vec![title()],
        columns: vec![title()],
        value: own(),
        cells: vec![vec![y]],
        centre,
        doubtful: vec![[0, 0]],
    };
    let bars = Bars {
        value: own(),
        series: vec![title()],
        interval: title(),
        groups: vec![Group { label: title(), bars: vec![Bar { value: y, interval: Some([y, f64::NAN]) }] }],
    };
    let map = |holds| SurvivalMap {
        x: own(),
        y: own(),
        shade: Some(own()),
        cells: vec![([x, y], holds)],
        doubtful: vec![[x, y]],
    };
    let polar = Polar {
        radius: own(),
        directions: [(); 4].map(|()| title()),
        curves: vec![Curve { label: title(), points: vec![[x, y]], doubtful: vec![x] }],
    };
    let of = |layer: Layer| {
        let marks = vec![
            Layer::Level { class: "bound", label: title(), y },
            Layer::Upright { class: "marked", label: title(), x },
        ];
        Chart::of(Axis::around(own(), [x]), Coordinates::new(own(), 190.0, [layer].into_iter().chain(marks).collect()))
    };
    let cloud = Cloud { points: vec![[x, y]], products: vec![1.0, f64::NAN], product: title(), among: 1 };
    let labelled = vec![Labelled { label: title(), at: [x, y] }];
    let area = Layer::Area { class: "support".into(), label: title(), points: vec![[x, y, y], [y, x, y]] };
    vec![
        ("sweep", sweep(false).draw(640.0)),
        ("fall", sweep(true).draw(640.0)),
        ("heat map", heat(None).draw(640.0)),
        ("diverging", heat(Some(0.0)).draw(640.0)),
        ("bars", bars.draw(640.0)),
        ("stood", map(Holds::Value(y)).draw(640.0)),
        ("fell", map(Holds::Fell).draw(640.0)),
        ("polar", polar.draw(640.0)),
        ("cloud", of(Layer::Cloud(cloud)).draw(640.0)),
        ("labelled", of(Layer::Labelled(labelled)).draw(640.0)),
        ("line", of(Layer::line(label, "com", vec![[x, y]])).draw(640.0)),
        ("area", of(area).draw(640.0)),
    ]
}

#[test]
fn one_value_is_drawn_whatever_it_is() {
    let values = [0.0, 1.0, -3.0, 1e-12, 1e12, 1e-300, 1e300, -1e300, f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    for x in values {
        for y in values {
            for (name, drawing) in of_one("a", x, y) {
                assert_sound(&format!("{name} of {x:e}, {y:e}"), &drawing);
            }
        }
    }
}

#[test]
fn labels_are_escaped() {
    let label = "<b>\"torque\" & 'speed'</b>";
    for (name, drawing) in of_one(label, 2.0, 1.0) {
        assert_sound(name, &drawing);
        let text = drawing.inline("").into_string();
        assert!(text.contains("&lt;b&gt;") && !text.contains("<b>") && !text.contains("& "), "{name}");
    }
}

#[test]
fn where_there_is_nothing_to_draw_it_says_so() {
    let says_so = |drawing: Drawing| drawing.content.into_string().contains(">no data<");
    for (name, drawing) in of_one("a", f64::NAN, f64::NAN) {
        assert!(["sweep", "fall"].contains(&name) || says_so(drawing), "{name}");
    }
    for (name, drawing) in of_one("a", 2.0, 1.0) {
        assert!(!says_so(drawing), "{name}");
    }
    assert!(says_so(
        Sweep { series: Vec::new(), ..gallery::sweep(quantity("x"), &[1.0], |_, _| false, &[]) }.draw(860.0)
    ));
    assert!(says_so(
        Sweep { panels: Vec::new(), ..gallery::sweep(quantity("x"), &[1.0], |_, _| false, &[]) }.draw(860.0)
    ));
    assert!(says_so(HeatMap { cells: Vec::new(), ..gallery::sobol() }.draw(860.0)));
    assert!(says_so(Bars { groups: Vec::new(), ..gallery::bars(&[]) }.draw(860.0)));
    assert!(says_so(SurvivalMap { cells: Vec::new(), ..gallery::survival(true) }.draw(860.0)));
    assert!(says_so(Polar { curves: Vec::new(), ..gallery::polar() }.draw(860.0)));
    assert!(says_so(Chart { stacks: Vec::new(), ..gallery::cloud() }.draw(860.0)));
    let mut morris = gallery::morris();
    morris.stacks[0].parts[0].layers.clear();
    assert!(says_so(morris.draw(860.0)));
}

#[test]
fn texts_are_large_enough_to_be_read_at_half_the_size() {
    let sizes = super::svg::FIGURE_STYLE.split("font-size: ").skip(1);
    let sizes: Vec<f64> =
        sizes.map(|rest| rest.split("px").next().and_then(|size| size.parse().ok()).expect("px")).collect();
    assert!(sizes.len() > 1 && sizes.iter().all(|size| *size >= 11.0), "{sizes:?}");
}
