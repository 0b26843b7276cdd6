//! The thesis's tables beside what is measured, in both readings.

use serde::Serialize;

use super::case::{Case, Experiment, Gains, Reading};
use crate::published;
use legwork::episode::Run;
use legwork_study::rollout::{DOUBTFUL, violations};

/// One of Tables 6.1 to 6.5.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Table {
    /// Its number in the thesis.
    pub number: &'static str,
    /// What it is of.
    pub title: &'static str,
    /// Its rows.
    pub rows: Vec<Row>,
}

/// A figure.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// It in words.
    pub label: &'static str,
    /// Its unit, or nothing.
    pub unit: &'static str,
    /// `mean` or `peak`; `setting` of a parameter.
    pub kind: &'static str,
    /// What the thesis publishes.
    pub thesis: f64,
    /// What it prints, where that is taken for a misprint (docs/thesis.md).
    pub misprint: Option<f64>,
    /// What is measured, in the order of [`Reading::ALL`].
    pub measured: Vec<Cell>,
}

/// A figure in a reading.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cell {
    /// The reading.
    pub reading: Reading,
    /// The scenario.
    pub scenario: &'static str,
    /// The measured figure; of a run that ended in a fall it is that of the time before, and says little.
    pub value: Option<f64>,
    /// Measured over published, minus one.
    pub deviation: Option<f64>,
    /// Whether the run ended in a fall.
    pub fell: bool,
    /// Bounds of the simulator's audit that the run broke, in words.
    pub violations: Option<String>,
}

impl Row {
    /// What there is to say of it beside the figures: which of its runs fell or broke bounds of the audit, what was
    /// misprinted.
    pub fn remark(&self) -> String {
        let fell = self.measured.iter().filter(|cell| cell.fell);
        let mut remarks: Vec<String> = fell.map(|cell| format!("{} fell", cell.scenario)).collect();
        let broke = |cell: &Cell| Some(format!("{} {DOUBTFUL}: {}", cell.scenario, cell.violations.as_ref()?));
        remarks.extend(self.measured.iter().filter_map(broke));
        remarks.extend(self.misprint.map(|printed| format!("printed as {printed}, read as {}", self.thesis)));
        remarks.join("; ")
    }
}

const TABLES: [(&str, &str, Experiment, Gains); 4] = [
    ("6.1", "Baseline, walking", Experiment::Walk, Gains::Baseline),
    ("6.2", "Baseline, push recovery", Experiment::Push, Gains::Baseline),
    ("6.4", "Final design, walking", Experiment::Walk, Gains::Final),
    ("6.5", "Final design, push recovery", Experiment::Push, Gains::Final),
];

/// A controller parameter, its unit, the printed value, and what the scenario holds.
type Parameter = (&'static str, &'static str, f64, fn(&Run) -> f64);

/// Table 6.3
const FINAL_DESIGN: [Parameter; 10] = [
    ("torque limit", "Nm", 220.0, |run| run.scenario.controller.limits.torque_nm),
    ("force limit", "N", 1000.0, |run| run.scenario.controller.limits.grf_n),
    ("C_v", "", 1e-2, |run| run.scenario.controller.weights.joint_acceleration),
    ("C_ρ", "", 1e-4, |run| run.scenario.controller.weights.grf),
    ("C_τ", "", 0.0, |run| run.scenario.controller.weights.torque),
    ("C_m", "", 10.0, |run| run.scenario.controller.weights.momentum),
    ("C_f", "", 5e5, |run| run.scenario.controller.weights.feet),
    ("C_a", "", 1e5, |run| run.scenario.controller.weights.torso),
    ("P_C", "N/m", 1500.0, |run| run.scenario.controller.planner.com_gain),
    ("P_f", "1/s²", 1500.0, |run| run.scenario.controller.planner.foot_gain),
];

/// The five tables; `run` finds the run of a case.
pub(crate) fn tables<'a>(run: impl Fn(Case) -> &'a Run) -> Vec<Table> {
    let mut tables: Vec<Table> = TABLES
        .iter()
        .map(|&(number, title, experiment, gains)| Table { number, title, rows: rows(&run, experiment, gains) })
        .collect();
    let settings = FINAL_DESIGN.iter().map(|&(label, unit, thesis, of)| {
        let value = |case: Case| Some(of(run(case)));
        let measured = cells(&run, Experiment::Walk, Gains::Final, thesis, value);
        Row { label, unit, kind: "setting", thesis, misprint: None, measured }
    });
    tables.insert(2, Table { number: "6.3", title: "Final design, parameters", rows: settings.collect() });
    tables
}

fn rows<'a>(run: &impl Fn(Case) -> &'a Run, experiment: Experiment, gains: Gains) -> Vec<Row> {
    // The thesis knows one reading only, whose scenario the published figures go by.
    let name = Case::new(Reading::Displacement, experiment, gains).scenario();
    let compared = |case: Case| published::compare(name, &run(case).metrics);
    let printed = compared(Case::new(Reading::Displacement, experiment, gains));
    let mut rows = Vec::new();
    for (index, row) in printed.iter().enumerate() {
        // Single figures are of the text, not of the tables; [`super::limits`] has them.
        let Some(peak) = row.published_peak else { continue };
        let mut add = |kind, thesis, value: fn(&published::Row) -> Option<f64>| {
            let measured = cells(run, experiment, gains, thesis, |case| value(&compared(case)[index]));
            let misprint = (kind == "peak").then(|| misprint(experiment, gains, row.label)).flatten();
            rows.push(Row { label: row.label, unit: row.unit, kind, thesis, misprint, measured });
        };
        if let Some(mean) = row.published {
            add("mean", mean, |row| row.measured);
        }
        add("peak", peak, |row| row.measured_peak);
    }
    rows
}

/// What is printed for the peak of a row, where that is a misprint (docs/thesis.md).
fn misprint(experiment: Experiment, gains: Gains, label: &str) -> Option<f64> {
    let is_it = (experiment, gains, label) == (Experiment::Push, Gains::Baseline, "feet error");
    is_it.then_some(0.79)
}

fn cells<'a>(
    run: &impl Fn(Case) -> &'a Run,
    experiment: Experiment,
    gains: Gains,
    thesis: f64,
    value: impl Fn(Case) -> Option<f64>,
) -> Vec<Cell> {
    let cell = |reading| {
        let case = Case::new(reading, experiment, gains);
        let value = value(case);
        let deviation = value.filter(|_| thesis != 0.0).map(|value| value / thesis - 1.0);
        let (fell, violations) = (run(case).reason.is_some(), violations(run(case)));
        Cell { reading, scenario: case.scenario(), value, deviation, fell, violations }
    };
    Reading::ALL.map(cell).to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits;
    use crate::trial::Trial;

    #[test]
    fn a_run_that_broke_the_audit_is_said_beside_its_figures() {
        // The soles of a walk in steps of 10 ms reach millimetres into the ground.
        let sets = ["simulation.period_s=0.01", "controller.period_s=0.01", "duration_s=1"].map(str::to_owned).to_vec();
        let coarse = Trial { scenario: "walk".into(), sets }.run(|| false).expect("it can be run");
        let remark = tables(|_| &coarse)[0].rows[0].remark();
        assert!(remark.starts_with("walk-baseline broke bounds of the simulation: "), "{remark}");
        assert!(remark.contains("; penetration of the ground: "), "{remark}");
        let limit = limits::of_runs(|_| &coarse).remove(0);
        for measured in limit.measured {
            assert_eq!(measured.violations, Some(coarse.violations().join("; ")));
        }
        let sound =
            Trial { scenario: "walk".into(), sets: vec!["duration_s=1".into()] }.run(|| false).expect("it can be run");
        assert!(tables(|_| &sound).iter().flat_map(|table| &table.rows).all(|row| !row.remark().contains("broke")));
    }
}
