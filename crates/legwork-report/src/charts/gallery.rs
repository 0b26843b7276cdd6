//! A page of all charts on made-up data, to be looked at: `target/gallery.html`.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::axis::{Axis, Quantity};
use super::bars::{Bar, Bars, Group};
use super::chart::{Chart, Part as Coordinates, Stack};
use super::cloud::Cloud;
use super::labels::Labelled;
use super::layer::Layer;
use super::map::{HeatMap, Holds, SurvivalMap};
use super::polar::{Curve, Polar};
use super::svg::{self, Drawing};
use super::sweep::{Panel, Part, Point, Series, Sweep};

fn texts(all: &[&str]) -> Vec<String> {
    all.iter().map(|text| (*text).to_owned()).collect()
}

/// A number between −1 and 1 that looks random.
fn noise(seed: usize) -> f64 {
    let mixed = (seed as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    ((mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// Six metrics of two scenarios over a parameter.
pub(super) fn sweep(x: Quantity, xs: &[f64], fell: impl Fn(usize, f64) -> bool, categories: &[&str]) -> Sweep {
    let metrics = [
        ("CoM error", "m", 0.02, 3.0),
        ("feet error", "m", 0.0018, 14.0),
        ("torso deviation", "rad", 0.03, 3.5),
        ("joint torque", "Nm", 69.0, 3.0),
        ("ground reaction force", "N", 356.0, 2.9),
        ("u\u{b2}", "N\u{b2}m\u{b2}", 29_800.0, f64::NAN),
    ];
    let series = ["walk at 0.5 m/s", "push of 400 N"].iter().enumerate().map(|(index, label)| Series {
        label: (*label).into(),
        points: xs.iter().map(|&x| Point { x, fell: fell(index, x), doubtful: false }).collect(),
    });
    let values = |size: f64, seed: usize| -> Vec<Vec<f64>> {
        let value = |series: usize, k: usize| {
            let away = (k as f64 / xs.len() as f64 - 0.6).powi(2);
            size * (1.0 + 0.6 * series as f64) * (1.0 + 2.5 * away + 0.05 * noise(97 * seed + 13 * k + series))
        };
        (0..2).map(|series| (0..xs.len()).map(|k| value(series, k)).collect()).collect()
    };
    let panels = metrics.iter().enumerate().map(|(seed, &(title, unit, size, peak))| {
        let mut parts = vec![Part::new(Quantity::new("mean", unit), values(size, seed))];
        if peak.is_finite() {
            parts.push(Part::new(Quantity::new("peak", unit), values(peak * size, seed + 50)));
        }
        Panel { title: title.into(), parts }
    });
    Sweep {
        x,
        categories: texts(categories),
        marked: Some((xs[2 * xs.len() / 3], "the thesis's value".into())),
        series: series.collect(),
        panels: panels.collect(),
    }
}

pub(super) fn sobol() -> HeatMap {
    let factors = ["friction", "slope", "mass of the torso", "CoM height", "speed", "torque limit", "delay", "push"];
    let cell = |row: usize, column: usize| {
        if column <= row {
            f64::NAN
        } else {
            (0.16 * noise(11 * row + column).powi(3).abs() - 0.01 * noise(row)).max(-0.01)
        }
    };
    HeatMap {
        row_title: "factor".into(),
        column_title: "with factor".into(),
        rows: texts(&factors),
        columns: texts(&factors),
        value: Quantity::new("second-order index", ""),
        cells: (0..8).map(|row| (0..8).map(|column| cell(row, column)).collect()).collect(),
        centre: None,
        doubtful: Vec::new(),
    }
}

fn totals(centre: Option<f64>) -> HeatMap {
    let cell = |row: usize, column: usize| {
        let value = noise(7 * row + 3 * column + 5);
        if centre.is_some() { 0.6 * value } else { value.abs().powi(2) }
    };
    HeatMap {
        row_title: String::new(),
        column_title: "metric".into(),
        rows: texts(&[
            "friction",
            "slope [\u{b0}]",
            "torque limit [Nm]",
            "weight of the torso task",
            "time of a step [s]",
        ]),
        columns: texts(&["CoM error", "feet error", "torso deviation", "torque", "force", "recovery"]),
        value: if centre.is_some() { Quantity::new("rank correlation", "") } else { Quantity::new("total index", "") },
        cells: (0..5).map(|row| (0..6).map(|column| cell(row, column)).collect()).collect(),
        centre,
        doubtful: Vec::new(),
    }
}

pub(super) fn bars(labels: &[&str]) -> Bars {
    let bar = |value: f64, sure: f64| Bar { value, interval: Some([value - sure, value + sure]) };
    let group = |(k, label): (usize, &&str)| {
        let first = 0.5 * noise(k + 3).powi(2);
        Group {
            label: (*label).into(),
            bars: vec![bar(first, 0.04), bar(first + 0.2 * noise(k).abs(), 0.03 + 0.02 * noise(k))],
        }
    };
    Bars {
        value: Quantity::new("Sobol' index of the mean CoM error", ""),
        series: texts(&["first order", "total"]),
        interval: "95 % interval".into(),
        groups: labels.iter().enumerate().map(group).collect(),
    }
}

pub(super) fn survival(shaded: bool) -> SurvivalMap {
    let mut cells = Vec::new();
    for speed in 0..11 {
        for torque in 0..9 {
            let (x, y) = (0.1 * f64::from(speed), 80.0 + 20.0 * f64::from(torque));
            if speed == 10 && torque == 8 {
                continue;
            }
            let margin = y - 95.0 - 110.0 * x * x + 8.0 * noise(speed as usize * 31 + torque as usize);
            let holds = if margin < 0.0 { Holds::Fell } else { Holds::Value(0.8 / (10.0 + margin)) };
            cells.push(([x, y], holds));
        }
    }
    SurvivalMap {
        x: Quantity::new("speed", "m/s"),
        y: Quantity::new("torque limit", "Nm"),
        shade: shaded.then(|| Quantity::new("CoM error", "m")),
        cells,
        doubtful: Vec::new(),
    }
}

pub(super) fn polar() -> Polar {
    let curve = |(index, label): (usize, &&str)| {
        let point = |k: usize| {
            let angle = 22.5 * k as f64;
            let up = angle.to_radians().sin().abs();
            let value = (0.55 + 0.12 * index as f64) * (1.0 + 0.9 * up.powi(3) + 0.15 * angle.to_radians().cos());
            [angle, if index == 2 && (k == 5 || k == 6) { f64::NAN } else { value + 0.05 * noise(k + 16 * index) }]
        };
        Curve { label: (*label).into(), points: (0..16).map(point).collect(), doubtful: Vec::new() }
    };
    Polar {
        radius: Quantity::new("largest impulse survived", "Ns/kg"),
        directions: texts(&["forward", "up", "backward", "down"]).try_into().expect("four"),
        curves: ["both feet stand", "early swing", "mid swing", "late swing"].iter().enumerate().map(curve).collect(),
    }
}

fn robustness() -> HeatMap {
    let polar = polar();
    let value = |column: usize| move |curve: &Curve| curve.points[column][1];
    HeatMap {
        row_title: "direction".into(),
        column_title: "phase of the gait".into(),
        rows: (0..16).map(|k| format!("{}\u{b0}", 22.5 * f64::from(k))).collect(),
        columns: polar.curves.iter().map(|curve| curve.label.clone()).collect(),
        value: polar.radius.clone(),
        cells: (0..16).map(|row| polar.curves.iter().map(value(row)).collect()).collect(),
        centre: None,
        doubtful: Vec::new(),
    }
}

/// Medians of two robots over a speed, with bands.
fn spreads() -> Sweep {
    let speeds = [0.0, 0.5, 1.0, 1.25];
    let mut sweep = sweep(Quantity::new("speed", "m/s"), &speeds, |_, _| false, &[]);
    for part in sweep.panels.iter_mut().flat_map(|panel| &mut panel.parts) {
        let around = |value: &f64| [0.7, 0.9, 1.05, 1.3].map(|factor| factor * value);
        part.spreads = part.values.iter().map(|values| values.iter().map(around).collect()).collect();
    }
    sweep
}

/// Parts over time, one of them of rows with notes.
pub(super) fn over_time() -> Chart {
    let wave = |size: f64| (0..2000).map(|k| [0.004 * f64::from(k), size * (0.02 * f64::from(k)).sin()]).collect();
    let rows = ["torque right hip", "friction of the left foot"];
    let marks = |row: usize| Layer::Row { class: "torque", row, spans: vec![([row as f64, row as f64 + 1.5], 1)] };
    let names = texts(&rows);
    let lines = |size: f64| {
        vec![
            Layer::Spans { class: "single", label: "single support", spans: vec![[1.0, 1.5], [2.0, 2.5]] },
            Layer::line("right", "right", wave(size)),
            Layer::line("left", "left dashed", wave(-0.5 * size)),
            Layer::Level { class: "limit", label: "limit".into(), y: 1.2 * size },
            Layer::Upright { class: "fall", label: "fell".into(), x: 7.5 },
        ]
    };
    let parts = vec![
        Coordinates {
            y: Axis::of_texts("", names),
            height: 34.0,
            layers: vec![marks(0), marks(1)],
            notes: vec![(0.0, "12.5 %".into()), (1.0, "3.0 %".into())],
        },
        Coordinates::new(Quantity::new("the torque of a joint", "Nm"), 170.0, lines(120.0)),
        Coordinates::new(Quantity::new("slack", "N"), 86.0, lines(2e-4)),
    ];
    let x = Axis::exactly(Quantity::new("time", "s"), [0.0, 8.0]);
    Chart { over_time: true, ..Chart::new(vec![Stack { title: String::new(), x, parts }], (0.0, 1)) }
}

pub(super) fn cloud() -> Chart {
    let stack = |(index, title): (usize, &&str)| {
        let point = |k: usize| {
            let t = k as f64 * 0.0041;
            let speed = 5.0 * (1.0 + 0.3 * index as f64) * (t.sin() + 0.3 * (3.0 * t).sin() + 0.1 * noise(k));
            let torque = 110.0 * (t + 0.7 * index as f64).cos() + 60.0 * (2.0 * t).sin() + 15.0 * noise(k + 7);
            [speed, torque.clamp(-150.0, 150.0)]
        };
        let points: Vec<[f64; 2]> = (0..8000).map(point).collect();
        let x = Axis::around(Quantity::new("speed", "rad/s"), points.iter().map(|point| point[0]));
        let cloud = Cloud { points, products: vec![100.0, 300.0, 900.0], product: "equal power [W]".into(), among: 4 };
        let limit = |y: f64| Layer::Level { class: "bound", label: "limit".into(), y };
        let layers = vec![Layer::Cloud(cloud), limit(-150.0), limit(150.0)];
        Stack { title: (*title).into(), x, parts: vec![Coordinates::new(Quantity::new("torque", "Nm"), 190.0, layers)] }
    };
    Chart::new(["right hip", "right knee", "left hip", "left knee"].iter().enumerate().map(stack).collect(), (185.0, 4))
}

pub(super) fn morris() -> Chart {
    let names = [
        "friction",
        "slope",
        "torso mass",
        "thigh mass",
        "shank mass",
        "CoM height",
        "speed",
        "torque limit",
        "delay",
        "push",
        "noise of the gyroscope",
        "latency",
        "step time",
        "weight of the feet",
        "weight of the torso",
        "bias",
        "gain",
    ];
    let point = |(k, name): (usize, &&str)| {
        let mu = if k > 8 { 0.006 * (1.0 + noise(k)) } else { 0.05 + 0.05 * noise(k) };
        Labelled { label: (*name).into(), at: [mu, mu * (0.6 + 0.5 * noise(k + 40))] }
    };
    let points: Vec<Labelled> = names.iter().enumerate().map(point).collect();
    let x =
        Axis::near_zero(Quantity::new("\u{3bc}* of the mean CoM error", "m"), points.iter().map(|point| point.at[0]));
    let ray = Layer::line("\u{3c3} = \u{3bc}*", "marked", vec![[0.0, 0.0], [0.1, 0.1]]);
    Chart::of(x, Coordinates::new(Quantity::new("\u{3c3}", "m"), 330.0, vec![ray, Layer::Labelled(points)]))
}

/// Draws a chart at a width [px].
type Draw = Box<dyn Fn(f64) -> Drawing>;

/// All charts, with names.
pub(super) fn charts() -> Vec<(&'static str, Draw)> {
    let friction: Vec<f64> = (0..13).map(|k| 0.1 + 0.08 * f64::from(k)).collect();
    let decades: Vec<f64> = (0..13).map(|k| 1e-5 * 10.0_f64.powf(0.35 * f64::from(k))).collect();
    let counts: Vec<f64> = (0..4).map(f64::from).collect();
    let linear = sweep(Quantity::new("friction coefficient", ""), &friction, |s, x| x < 0.3 + 0.2 * s as f64, &[]);
    let log_sweep = sweep(
        Quantity::new("regularisation", "kg\u{b2}").logarithmic(true),
        &decades,
        |s, x| x > 0.05 || (s == 0 && (1e-3..2e-3).contains(&x)),
        &[],
    );
    let contacts = ["rigid", "spring and damper", "Hunt and Crossley", "implicit"];
    let texts = sweep(Quantity::new("contact model", ""), &counts, |s, x| s == 1 && x == 2.0, &contacts);
    let few = ["friction", "slope", "mass", "CoM height", "speed", "torque"];
    let long = [
        "friction of the ground",
        "slope of the ground",
        "mass of the torso",
        "height of the CoM reference",
        "weight of the torso task in the program",
    ];
    vec![
        ("sweep", Box::new(move |w| linear.draw(w)) as Draw),
        ("sweep, logarithmic", Box::new(move |w| log_sweep.draw(w))),
        ("sweep over texts", Box::new(move |w| texts.draw(w))),
        ("spreads", Box::new(|w| spreads().draw(w))),
        ("over time", Box::new(|w| over_time().draw(w))),
        ("second order", Box::new(|w| sobol().draw(w))),
        ("total indices", Box::new(|w| totals(None).draw(w))),
        ("diverging", Box::new(|w| totals(Some(0.0)).draw(w))),
        ("bars", Box::new(move |w| bars(&few).draw(w))),
        ("lying bars", Box::new(move |w| bars(&long).draw(w))),
        ("survival", Box::new(|w| survival(false).draw(w))),
        ("survival, shaded", Box::new(|w| survival(true).draw(w))),
        ("polar", Box::new(|w| polar().draw(w))),
        ("robustness", Box::new(|w| robustness().draw(w))),
        ("torque and speed", Box::new(|w| cloud().draw(w))),
        ("Morris", Box::new(|w| morris().draw(w))),
        ("nothing", Box::new(super::no_data)),
    ]
}

fn page() -> Markup {
    html! {
        (DOCTYPE)
        html lang="en" {
            head { meta charset="utf-8"; title { "gallery" } style { (PreEscaped(style())) } }
            body {
                @for (name, draw) in charts() {
                    h2 { (name) }
                    div style="width: 860px" { (draw(860.0).inline("")) }
                    div style="width: 430px" { (draw(860.0).inline("")) }
                    div style="width: 380px" { (draw(380.0).inline("")) }
                }
            }
        }
    }
}

fn style() -> String {
    let dark = include_str!("dark.css");
    format!(
        ":root {{\n{}}}\n@media screen and (prefers-color-scheme: dark) {{\n:root {{\n{dark}}}\n}}\n{}body {{ background: var(--paper); color: var(--ink); font: 16px sans-serif; }}",
        svg::LIGHT,
        svg::FIGURE_STYLE
    )
}

#[test]
#[ignore = "writes target/gallery.html, for who wants to look at the charts"]
fn the_gallery_is_written() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target");
    std::fs::create_dir_all(&folder).expect("target can be made");
    std::fs::write(folder.join("gallery.html"), page().into_string()).expect("target can be written to");
}
