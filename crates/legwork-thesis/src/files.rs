//! The comparison as tables in CSV and Parquet: `sweeps`, `runs`, `tables`, `limits`, `claims`, `questions`; and the
//! logs of the eight cases.

use std::fs;
use std::path::Path;

use super::case::Reading;
use super::questions::Entry;
use super::{
    Reproduction,
    claims::{Basis, Claim},
};
use legwork::error::Error;
use legwork::log_file;
use legwork_study::Rollout;
use legwork_study::table::{Cell, Column, TableWriter};

/// The folder of the logs, below that of the tables.
pub const LOGS: &str = "logs";

/// The columns of a rollout beside its figures.
const ROLLOUT: [&str; 6] = ["ending", "cause", "reason", "violations", "input_hash", "result_hash"];

/// Writes all tables and logs into `folder`, which is made where it is not there.
///
/// # Errors
/// A file cannot be written.
pub fn write(reproduction: &Reproduction, folder: &Path) -> Result<(), Error> {
    let logs = folder.join(LOGS);
    fs::create_dir_all(&logs).map_err(|error| Error::io(&logs, &error))?;
    for run in &reproduction.evidence.runs {
        log_file::write(run, &logs.join(format!("{}.parquet", run.scenario.name)))?;
    }
    sweeps(reproduction, folder)?;
    runs(reproduction, folder)?;
    tables(reproduction, folder)?;
    limits(reproduction, folder)?;
    claims(&reproduction.claims, folder)?;
    questions(reproduction, folder)
}

fn write_table(folder: &Path, name: &str, columns: Vec<Column>, rows: Vec<Vec<Cell>>) -> Result<(), Error> {
    let mut writer = TableWriter::create(folder, name, columns, &[])?;
    rows.into_iter().try_for_each(|row| writer.row(row))?;
    writer.finish()
}

fn rollout_columns(reproduction: &Reproduction) -> impl Iterator<Item = Column> + '_ {
    let figures = reproduction.columns.iter().map(|figure| Column::number(&figure.name, figure.unit));
    ROLLOUT.iter().map(|&name| Column::text(name)).chain([Column::number("fell_at_s", "s")]).chain(figures)
}

fn rollout_cells(rollout: &Rollout, figures: usize) -> Vec<Cell> {
    let text = |text: &Option<String>| Cell::from(text.as_deref());
    let mut cells =
        vec![rollout.ending.name().into(), text(&rollout.cause), text(&rollout.reason), text(&rollout.violations)];
    cells.extend([rollout.input_hash.as_str().into(), rollout.result_hash.as_str().into(), rollout.fell_at_s.into()]);
    cells.extend((0..figures).map(|figure| Cell::from(rollout.figures.get(figure).copied().flatten())));
    cells
}

fn sweeps(reproduction: &Reproduction, folder: &Path) -> Result<(), Error> {
    let texts = ["study", "thesis_figure", "scenario", "reading", "experiment", "parameter", "setting"];
    let mut columns: Vec<Column> = texts.map(Column::text).to_vec();
    columns.extend([Column::number("level", ""), Column::number("baseline_level", "")]);
    columns.push(Column::number("momentum_rate_limited_fraction", ""));
    columns.extend(rollout_columns(reproduction));
    let mut rows = Vec::new();
    for sweep in &reproduction.evidence.sweeps {
        for tried in &sweep.levels {
            let (reading, experiment) = (sweep.reading().name(), sweep.case.experiment.name());
            let texts = [&sweep.study, sweep.figure, &sweep.scenario, reading, experiment, sweep.symbol, &sweep.path];
            let mut row = texts.map(Cell::from).to_vec();
            row.extend([tried.level, sweep.marked, tried.momentum_rate_limited_fraction].map(Cell::from));
            row.extend(rollout_cells(&tried.rollout, reproduction.columns.len()));
            rows.push(row);
        }
    }
    write_table(folder, "sweeps", columns, rows)
}

fn runs(reproduction: &Reproduction, folder: &Path) -> Result<(), Error> {
    let mut columns = vec![Column::text("scenario"), Column::text("settings"), Column::text("command")];
    columns.extend([Column::number("ticks", ""), Column::number("infeasible", "")]);
    columns.extend([Column::number("first_infeasible_s", "s"), Column::number("since_trigger_s", "s")]);
    columns.push(Column::number("missed_at_start_n", "N"));
    columns.extend([Column::text("conflict"), Column::number("tasks_yielded", ""), Column::number("torque_held", "")]);
    columns.extend(rollout_columns(reproduction));
    let row = |result: &super::trial::TrialResult| {
        let (trial, program) = (&result.trial, &result.program);
        let mut row: Vec<Cell> = vec![trial.scenario.as_str().into(), trial.sets.join(" ").as_str().into()];
        row.push(trial.command().as_str().into());
        row.extend([program.ticks as f64, program.infeasible as f64].map(Cell::from));
        let figures = [program.first_infeasible_s, program.since_trigger_s, program.missed_at_start_n];
        row.extend(figures.map(Cell::from));
        row.push(program.conflict.join(", ").as_str().into());
        row.extend([program.tasks_yielded as f64, program.torque_held as f64].map(Cell::from));
        row.extend(rollout_cells(&result.rollout, reproduction.columns.len()));
        row
    };
    write_table(folder, "runs", columns, reproduction.evidence.trials.iter().map(row).collect())
}

/// A column of each reading, and one of it under another name.
fn of_readings(suffix: &str) -> impl Iterator<Item = Column> + '_ {
    Reading::ALL.into_iter().map(move |reading| Column::number(format!("{}{suffix}", reading.name()), ""))
}

fn tables(reproduction: &Reproduction, folder: &Path) -> Result<(), Error> {
    let mut columns = ["table", "title", "figure", "kind", "unit"].map(Column::text).to_vec();
    columns.push(Column::number("thesis", ""));
    columns.extend(of_readings(""));
    columns.extend(of_readings("_deviation"));
    columns.push(Column::text("remark"));
    let mut rows = Vec::new();
    for table in &reproduction.tables {
        for row in &table.rows {
            let mut cells = [table.number, table.title, row.label, row.kind, row.unit].map(Cell::from).to_vec();
            cells.push(row.thesis.into());
            cells.extend(row.measured.iter().map(|cell| Cell::from(cell.value)));
            cells.extend(row.measured.iter().map(|cell| Cell::from(cell.deviation)));
            cells.push(row.remark().as_str().into());
            rows.push(cells);
        }
    }
    write_table(folder, "tables", columns, rows)
}

fn limits(reproduction: &Reproduction, folder: &Path) -> Result<(), Error> {
    let mut columns = ["quantity", "section", "unit"].map(Column::text).to_vec();
    columns.push(Column::number("thesis", ""));
    for suffix in ["", "_first_failure", "_furthest_held"] {
        columns.extend(of_readings(suffix));
    }
    for suffix in ["reason", "violations"] {
        columns.extend(Reading::ALL.map(|reading| Column::text(format!("{}_{suffix}", reading.name()))));
    }
    columns.push(Column::text("remark"));
    let row = |row: &super::limits::LimitRow| {
        let mut cells = [row.quantity, row.section, row.unit].map(Cell::from).to_vec();
        cells.push(row.thesis.into());
        cells.extend(row.measured.iter().map(|measured| Cell::from(measured.value)));
        cells.extend(row.measured.iter().map(|measured| Cell::from(measured.first_failure)));
        cells.extend(row.measured.iter().map(|measured| Cell::from(measured.furthest_held)));
        let text = |text: &Option<String>| Cell::from(text.as_deref());
        cells.extend(row.measured.iter().map(|measured| text(&measured.reason)));
        cells.extend(row.measured.iter().map(|measured| text(&measured.violations)));
        cells.push(row.remark.into());
        cells
    };
    write_table(folder, "limits", columns, reproduction.evidence.limits.iter().map(row).collect())
}

/// A row for each part of a claim's test in each reading.
fn claims(claims: &[Claim], folder: &Path) -> Result<(), Error> {
    let names = ["claim", "section", "says", "test", "basis", "reading", "verdict", "part_holds", "finding", "why"];
    let sources = ["source_file", "source_rows", "source_columns"];
    let columns = names.into_iter().chain(sources).map(Column::text).collect();
    let mut rows = Vec::new();
    for claim in claims {
        for found in &claim.findings {
            for check in &found.checks {
                let (reading, verdict) = (found.reading.name(), found.verdict.name());
                let holds = if check.holds { "yes" } else { "no" };
                let mut row = [claim.id, claim.section(), claim.says, claim.test].map(Cell::from).to_vec();
                row.push(claim.basis.map(Basis::words).into());
                row.extend([reading, verdict, holds, &check.finding].map(Cell::from));
                row.push(found.why.into());
                let source = &claim.source;
                row.extend(
                    [&source.file, &source.rows, &source.columns.join(" ")].map(|text| Cell::from(text.as_str())),
                );
                rows.push(row);
            }
        }
    }
    write_table(folder, "claims", columns, rows)
}

/// A row for each entry of each question's tables.
fn questions(reproduction: &Reproduction, folder: &Path) -> Result<(), Error> {
    let mut columns = vec![Column::text("question"), Column::text("table"), Column::number("row", "")];
    columns.extend([Column::text("column"), Column::text("unit"), Column::number("value", ""), Column::text("text")]);
    let mut rows = Vec::new();
    for question in &reproduction.questions {
        for table in &question.tables {
            for (number, entries) in table.rows.iter().enumerate() {
                for ((column, unit), entry) in table.columns.iter().zip(entries) {
                    let (value, text) = match entry {
                        Entry::Number(number) => (Cell::from(*number), Cell::Empty),
                        Entry::Text(text) => (Cell::Empty, Cell::from(text.as_str())),
                    };
                    let place = [Cell::from(question.id), table.title.into(), (number as f64).into()];
                    rows.push(place.into_iter().chain([(*column).into(), (*unit).into(), value, text]).collect());
                }
            }
        }
    }
    write_table(folder, "questions", columns, rows)
}
