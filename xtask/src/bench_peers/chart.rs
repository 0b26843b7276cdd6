//! The chart: medians as bars on a logarithmic axis, ours and theirs, case by case.

use std::fmt::Write;

use super::measure::Measured;

const LABELS: f64 = 250.0;
const WIDTH: f64 = 1000.0;
const BAR: f64 = 20.0;
const GAP: f64 = 34.0;
/// Blue and orange of Okabe and Ito 2008, which colour-blind people tell apart.
const OURS: &str = "#0072b2";
const THEIRS: &str = "#e69f00";

/// An SVG of all cases that have a peer.
pub(super) fn svg(measured: &[Measured]) -> String {
    let mut body = String::new();
    let mut y = 50.0;
    let compared = measured.iter().filter(|case| case.rows.iter().skip(1).any(|row| row.figures.is_ok()));
    let cases: Vec<&Measured> = compared.collect();
    let medians = || {
        cases
            .iter()
            .flat_map(|case| &case.rows)
            .filter_map(|row| row.figures.as_ref().ok())
            .filter(|figures| figures.failures < figures.count)
    };
    let low = medians().map(|figures| figures.median.log10()).fold(f64::INFINITY, f64::min).floor();
    let high = medians().map(|figures| figures.median.log10()).fold(f64::NEG_INFINITY, f64::max).ceil();
    let at = |microseconds: f64| LABELS + (microseconds.log10() - low) / (high - low) * (WIDTH - LABELS - 90.0);
    for case in &cases {
        let _ = writeln!(body, "<text x=\"8\" y=\"{:.0}\" font-weight=\"bold\">{}</text>", y + 14.0, case.case.title);
        y += 22.0;
        for (index, row) in case.rows.iter().enumerate() {
            // The time of a wrong answer is no measure.
            let Some(figures) = row.figures.as_ref().ok().filter(|figures| figures.failures < figures.count) else {
                continue;
            };
            let colour = if index == 0 { OURS } else { THEIRS };
            let (from, to) = (at(10f64.powf(low)), at(figures.median));
            let failed = if figures.failures > 0 { format!(", fails {}", figures.failures) } else { String::new() };
            let _ = writeln!(
                body,
                "<text x=\"{:.0}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>\
                 <rect x=\"{from:.1}\" y=\"{y:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{colour}\"/>\
                 <text x=\"{:.1}\" y=\"{:.1}\">{}{failed}</text>",
                LABELS - 8.0,
                y + 14.0,
                row.name,
                (to - from).max(1.0),
                BAR - 3.0,
                to + 6.0,
                y + 14.0,
                super::page::microseconds(figures.median)
            );
            y += BAR;
        }
        y += GAP - BAR;
    }
    let mut axis = String::new();
    for decade in low as i32..=high as i32 {
        let (x, value) = (at(10f64.powi(decade)), 10f64.powi(decade));
        let _ = writeln!(
            axis,
            "<line x1=\"{x:.1}\" y1=\"40\" x2=\"{x:.1}\" y2=\"{y:.0}\" stroke=\"#cccccc\"/>\
             <text x=\"{x:.1}\" y=\"32\" text-anchor=\"middle\">{value}</text>"
        );
    }
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {:.0}\" font-family=\"sans-serif\" \
         font-size=\"16\" fill=\"#222222\">\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n\
         <text x=\"8\" y=\"32\">median time [µs], logarithmic</text>\n{axis}{body}</svg>\n",
        y + 10.0
    )
}
