//! The page of the reproduction: the thesis's results chapter, measured anew.

use std::collections::BTreeSet;

use legwork_study::rollout::DOUBTFUL;
use legwork_thesis::case::{Case, Experiment, Gains, Reading};
use legwork_thesis::claims::{Claim, Verdict};
use legwork_thesis::limits::{LimitRow, Measured};
use legwork_thesis::questions::{Entry, Question, Table as QuestionTable};
use legwork_thesis::sweep::{STUDIES, Sweep as Sweeps};
use legwork_thesis::tables::{Cell, Table};
use legwork_thesis::{Reproduction, terms};
use maud::{Markup, html};

use crate::charts::axis::Quantity;
use crate::charts::numbers::number;
use crate::charts::sweep::{Panel, Part, Point, Series, Sweep};
use crate::document::{Chapter, Figures, Page, Section, page as document};
use crate::run::figures;

/// The page of `reproduction`.
pub fn page(reproduction: &Reproduction) -> Page {
    let mut figures = Figures::default();
    let chapters = vec![
        tables(reproduction),
        motion(reproduction, &mut figures),
        parameters(reproduction, &mut figures),
        limits(reproduction),
        questions(reproduction),
        claims(reproduction),
        method(),
    ];
    document("The thesis, reproduced", &lead(reproduction), &chapters, figures)
}

/// A reading as the page names it.
fn name(reading: Reading) -> &'static str {
    match reading {
        Reading::Displacement => "way of the foot",
        Reading::BaseOfSupport => "base of support",
    }
}

fn lead(reproduction: &Reproduction) -> Markup {
    html! {
        p {
            "What the thesis reports, beside what legwork measures: its tables and figures, its limits, each claim of its results, and the "
            "questions that it leaves open. The thesis does not say what its least step length is the least of. Both readings are "
            "measured throughout: the least " b { "way of the foot" } ", the parameter set that was given, and the least "
            b { "base of support" } " after a step, a set of our own fit."
        }
        div.scroll { table {
            thead { tr { th.left { "of " (reproduction.claims.len()) " claims" } @for verdict in Verdict::ALL { th { (title(verdict)) } } th { "reproduced, but fitted or by construction" } } }
            tbody {
                @for reading in Reading::ALL {
                    tr {
                        th scope="row" { (name(reading)) }
                        @for count in reproduction.counts(reading) { td { (count) } }
                        td { (reproduction.without_evidence(reading)) }
                    }
                }
            }
        } }
    }
}

fn title(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Reproduced => "reproduced",
        Verdict::Partly => "partly",
        Verdict::Not => "not reproduced",
    }
}

fn badge(verdict: Verdict) -> Markup {
    let class = match verdict {
        Verdict::Reproduced => "badge good",
        Verdict::Partly => "badge",
        Verdict::Not => "badge bad",
    };
    html! { span class=(class) { (title(verdict)) } }
}

fn tables(reproduction: &Reproduction) -> Chapter {
    let sections = reproduction
        .tables
        .iter()
        .map(|table| Section { title: format!("Table {}: {}", table.number, table.title), body: published(table) });
    Chapter {
        title: "Tables".into(),
        lead: html! { p { "Published figures beside measured ones, with the difference. The figures of a run that fell are those up to the fall and say little." } },
        sections: sections.collect(),
    }
}

fn published(table: &Table) -> Markup {
    let cells = || table.rows.iter().flat_map(|row| &row.measured);
    let fallen: BTreeSet<&str> = cells().filter(|cell| cell.fell).map(|cell| cell.scenario).collect();
    let broken: BTreeSet<(&str, &String)> =
        cells().filter_map(|cell| Some((cell.scenario, cell.violations.as_ref()?))).collect();
    html! {
        div.scroll { table {
            thead {
                tr {
                    th rowspan="2" { "figure" } th rowspan="2" {} th rowspan="2" { "thesis" }
                    @for reading in Reading::ALL { th colspan="2" { (name(reading)) } }
                }
                tr { @for _ in Reading::ALL { th { "measured" } th { "difference" } } }
            }
            tbody {
                @for row in &table.rows {
                    tr {
                        th scope="row" { (row.label) @if !row.unit.is_empty() { " " span.unit { "[" (row.unit) "]" } } }
                        td.soft { (row.kind) }
                        td { @if let Some(printed) = row.misprint { (printed) ", read as " } (row.thesis) }
                        @for cell in &row.measured { (measured(cell)) }
                    }
                }
            }
        } }
        @for scenario in fallen { p.note { "The run of " code { (scenario) } " ended in a fall." } }
        @for (scenario, violations) in broken { p.note { "The run of " code { (scenario) } " " (DOUBTFUL) ": " (violations) "." } }
    }
}

fn measured(cell: &Cell) -> Markup {
    html! {
        td class=(if cell.fell { "soft" } else { "measured" }) { (cell.value.map_or("none".to_owned(), number)) }
        td.soft { @if let Some(deviation) = cell.deviation.filter(|_| !cell.fell) { (signed_percent(deviation)) } }
    }
}

fn signed_percent(share: f64) -> String {
    match (100.0 * share).round() {
        0.0 => "0 %".to_owned(),
        percent if percent < 0.0 => format!("\u{2212}{:.0} %", -percent),
        percent => format!("+{percent:.0} %"),
    }
}

/// Figures 6.2, 6.3, 6.4, H.1 and H.2.
fn motion(reproduction: &Reproduction, numbered: &mut Figures) -> Chapter {
    let parts: [(&str, Gains, &[&str]); 3] = [
        ("Tracking of the baseline, as in Figure 6.2", Gains::Baseline, &["tracking-x", "tracking-z"]),
        ("Tracking of the final design, as in Figure 6.4", Gains::Final, &["tracking-x", "tracking-z"]),
        ("Poses and torques of the final design, as in Figures 6.3, H.1, H.2", Gains::Final, &["poses", "torques"]),
    ];
    let sections = parts.into_iter().map(|(title, gains, names)| {
        let mut body = Vec::new();
        for experiment in Experiment::ALL {
            for reading in Reading::ALL {
                let run = reproduction.evidence.run(Case::new(reading, experiment, gains));
                for figure in figures::figures(run).iter().filter(|figure| names.contains(&figure.name)) {
                    let file = format!("{}-{}", run.scenario.name, figure.name);
                    let title = format!("{}: {}", run.scenario.name, figure.title);
                    body.push(numbered.add(&file, &title, &figure.caption, |width| figure.draw(width)));
                }
            }
        }
        Section { title: title.into(), body: html! { @for figure in body { (figure) } } }
    });
    Chapter { title: "Motion".into(), lead: html! {}, sections: sections.collect() }
}

/// The parameters, each with what the thesis says of it.
fn parameters(reproduction: &Reproduction, numbered: &mut Figures) -> Chapter {
    let sections = STUDIES.iter().enumerate().map(|(index, (study, symbol, thesis))| {
        let section = if index == 0 { "6.1".to_owned() } else { format!("6.3.{index}") };
        let claims: Vec<&Claim> = reproduction.claims.iter().filter(|claim| claim.section() == section).collect();
        let factor = &reproduction.evidence.sweep(study, Reading::BaseOfSupport, Experiment::Walk).factor;
        let title = format!("{}{} {symbol}, thesis {section}", factor[..1].to_uppercase(), &factor[1..]);
        let body = html! {
            (verdicts(&claims))
            @for (experiment, figure) in Experiment::ALL.into_iter().zip(thesis) {
                @let chart = sweep(reproduction, study, experiment);
                (numbered.add(
                    &format!("{study}-{}", experiment.name()),
                    &format!("{} over the {factor}, as in Figure {figure}", if experiment == Experiment::Walk { "Walking" } else { "The push" }),
                    "All other parameters are the baseline's. A cross marks a fall; the figures of a run that fell are not drawn. \
                     The dashed line is the thesis's value.",
                    |width| chart.draw(width),
                ))
            }
        };
        Section { title, body }
    });
    Chapter {
        title: "Parameters".into(),
        lead: html! { p { "Each of the nine parameters of Section 5.2 over its levels, all others at the baseline (Table D.1, 220 Nm): what the thesis concludes, and what is measured. Figure 6.1 is the mean feet error over the torque limit." } },
        sections: sections.collect(),
    }
}

/// The claims of a section with their verdicts, short.
fn verdicts(claims: &[&Claim]) -> Markup {
    html! {
        div.scroll { table.settings {
            thead { tr { th.left { "claim" } th.left { "" } @for reading in Reading::ALL { th { (name(reading)) } } } }
            tbody {
                @for claim in claims {
                    tr {
                        td.left { a href={ "#claim-" (claim.id) } { (claim.id) } }
                        td.left { (claim.says_and_basis()) }
                        @for finding in &claim.findings { td { (badge(finding.verdict)) } }
                    }
                }
            }
        } }
    }
}

fn sweep(reproduction: &Reproduction, study: &str, experiment: Experiment) -> Sweep {
    let sweeps: Vec<&Sweeps> =
        Reading::ALL.iter().map(|&reading| reproduction.evidence.sweep(study, reading, experiment)).collect();
    let series = sweeps.iter().zip(Reading::ALL).map(|(sweep, reading)| Series {
        label: name(reading).to_owned(),
        points: sweep
            .levels
            .iter()
            .map(|tried| Point {
                x: tried.level,
                fell: !tried.rollout.survived(),
                doubtful: tried.rollout.violations.is_some(),
            })
            .collect(),
    });
    let values = |figure: &str| -> Vec<Vec<f64>> {
        let column = reproduction.columns.iter().position(|column| column.name == figure).expect("it is a figure");
        let value = |tried: &legwork_thesis::sweep::Tried| tried.rollout.figures[column].unwrap_or(f64::NAN);
        sweeps.iter().map(|sweep| sweep.levels.iter().map(value).collect()).collect()
    };
    let panel = |(title, name, unit): (&str, &str, &str)| Panel {
        title: title.into(),
        parts: ["mean", "peak"]
            .map(|kind| Part::new(Quantity::new(kind, unit), values(&format!("{name}.{kind}"))))
            .into(),
    };
    let first = sweeps[0];
    Sweep {
        x: Quantity::new(&first.factor, first.unit).logarithmic(first.is_logarithmic),
        categories: Vec::new(),
        marked: Some((first.marked, "thesis".into())),
        series: series.collect(),
        panels: [
            ("CoM error", "com_error_m", "m"),
            ("feet error", "feet_error_m", "m"),
            ("torso deviation", "torso_deviation_rad", "rad"),
            ("joint torque", "torque_nm", "Nm"),
            ("force on a contact point", "grf_n", "N"),
            ("u\u{b2}", "u2_n2m2", "N\u{b2}m\u{b2}"),
        ]
        .map(panel)
        .into(),
    }
}

fn limits(reproduction: &Reproduction) -> Chapter {
    let body = html! {
        div.scroll { table {
            thead {
                tr {
                    th.left { "limit" } th { "thesis" } @for reading in Reading::ALL { th { (name(reading)) } } th.left { "how it is measured" }
                }
            }
            tbody { @for row in &reproduction.evidence.limits { (limit(row)) } }
        } }
        @for row in &reproduction.evidence.limits {
            @for measured in &row.measured {
                @if let Some(violations) = &measured.violations {
                    p.note { "The " (row.quantity) ", " (name(measured.reading)) ", rests on rollouts that " (DOUBTFUL) ": " (violations) "." }
                }
            }
        }
        h4 { "Why it failed beyond" }
        ul.note {
            @for row in &reproduction.evidence.limits {
                @for measured in &row.measured {
                    @if let Some(reason) = &measured.reason {
                        li { (row.quantity) ", " (name(measured.reading)) @if let Some(value) = measured.first_failure { ", at " (number(value)) " " (row.unit) } ": " (reason) }
                    }
                }
            }
        }
    };
    Chapter {
        title: "Limits".into(),
        lead: html! { p { "A limit is the last value before the first failure that was found, with neighbours tried. In brackets the furthest value that held beyond it: the border is ragged." } },
        sections: vec![Section { title: "What the controller survives".into(), body }],
    }
}

fn limit(row: &LimitRow) -> Markup {
    let beyond =
        |measured: &Measured| measured.furthest_held.filter(|&held| measured.value.is_some_and(|value| value != held));
    html! {
        tr {
            th scope="row" { (row.quantity) @if !row.unit.is_empty() { " " span.unit { "[" (row.unit) "]" } } }
            td { (row.thesis.map_or("\u{2013}".to_owned(), number)) }
            @for measured in &row.measured {
                td.measured {
                    (measured.value.map_or("none".to_owned(), number))
                    @if let Some(held) = beyond(measured) { span.soft { " (" (number(held)) ")" } }
                }
            }
            td.left.soft { (row.remark) }
        }
    }
}

fn questions(reproduction: &Reproduction) -> Chapter {
    let sections = reproduction.questions.iter().map(|question: &Question| Section {
        title: question.asks.to_owned(),
        body: html! {
            p { b { "Answer. " } (question.answer) }
            p.note { b { "Method. " } (question.method) " The thesis leaves it open in Section " (question.section) "." }
            @for table in &question.tables { (entries(table)) }
        },
    });
    Chapter {
        title: "What the thesis left open".into(),
        lead: html! { p { "Each answer is composed of what was measured on this computer, now." } },
        sections: sections.collect(),
    }
}

fn entries(table: &QuestionTable) -> Markup {
    let is_text = |column: usize| table.rows.iter().any(|row| matches!(row[column], Entry::Text(_)));
    let class = |column: usize| is_text(column).then_some("left");
    html! {
        h4 { (table.title) }
        div.scroll { table {
            thead { tr {
                @for (column, (name, unit)) in table.columns.iter().enumerate() {
                    th class=[class(column)] { (name) @if !unit.is_empty() { " " span.unit { "[" (unit) "]" } } }
                }
            } }
            tbody {
                @for row in &table.rows {
                    tr {
                        @for (column, entry) in row.iter().enumerate() {
                            td class=[class(column)] {
                                @match entry {
                                    Entry::Number(value) => (value.map_or("\u{2013}".to_owned(), number)),
                                    Entry::Text(text) => (text),
                                }
                            }
                        }
                    }
                }
            }
        } }
    }
}

/// The sections of the thesis whose claims stand together.
const GROUPS: [(&str, &str); 4] = [
    ("6.1", "Torque limit (6.1)"),
    ("6.3", "Parameters (6.3)"),
    ("6.4", "Final design (6.4)"),
    ("7", "Discussion (7)"),
];

fn claims(reproduction: &Reproduction) -> Chapter {
    let group =
        |claim: &Claim| GROUPS.iter().rposition(|(prefix, _)| claim.id.starts_with(prefix)).unwrap_or(GROUPS.len() - 1);
    let mut sections: Vec<Section> = Vec::new();
    for (index, (_, title)) in GROUPS.iter().enumerate() {
        let claims: Vec<&Claim> = reproduction.claims.iter().filter(|claim| group(claim) == index).collect();
        if !claims.is_empty() {
            let body = html! { @for claim in claims { (claim_in_full(claim)) } };
            sections.push(Section { title: (*title).to_owned(), body });
        }
    }
    sections.push(Section {
        title: "Terms of the tests".into(),
        body: html! { dl { @for (term, meaning) in terms::terms() { div { dt { (term) } dd { (meaning) } } } } },
    });
    Chapter {
        title: "Claims".into(),
        lead: html! { p { "Each claim in our words, with the test that decides and what it finds. The data named can be had from the files beside this page." } },
        sections,
    }
}

fn claim_in_full(claim: &Claim) -> Markup {
    html! {
        section id={ "claim-" (claim.id) } {
            h4 { (claim.id) " \u{b7} " (claim.says_and_basis()) }
            p.note { "Test: " (claim.test) ". Data: " code { (claim.source.file) @if claim.source.file == "logs" { "/*.parquet" } @else { ".csv" } } ", " (claim.source.rows) ", " (claim.source.columns.join(", ")) "." }
            @for finding in &claim.findings {
                p { (badge(finding.verdict)) " " b { (name(finding.reading)) } }
                ul {
                    @for check in &finding.checks { li { (if check.holds { "\u{2713} " } else { "\u{2717} " }) (check.finding) } }
                    @if let Some(why) = finding.why { li.soft { "Why: " (why) } }
                }
            }
        }
    }
}

fn method() -> Chapter {
    let body = html! {
        p { "Everything on this page comes from " code { "legwork reproduce" } ". Beside it lie the data, as CSV and Parquet: "
            code { "sweeps" } " with every level of the nine parameters and all its figures, " code { "runs" } ", " code { "tables" } ", "
            code { "limits" } ", " code { "claims" } " and " code { "questions" } "; " code { "results.json" } " holds all of it. Each row carries the hashes of "
            "its inputs and of its result: the same program gives the same bits, but for the computation times." }
    };
    Chapter {
        title: "Method and data".into(),
        lead: html! {},
        sections: vec![Section { title: "Where the figures come from".into(), body }],
    }
}
