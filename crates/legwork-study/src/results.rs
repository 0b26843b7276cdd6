//! What the rollouts of a study say together: endings, causes of falls, sweeps, sensitivity indices.

use std::collections::BTreeMap;
use std::path::Path;

use crate::design::Design;
use crate::rollout::Column;
use crate::sensitivity::{Bootstrap, Effects, Indices, morris, sobol_indices};
use crate::table::{self, Cell, Kind, TableWriter};
use crate::ties;
use crate::{Ending, Level, Rollout, Study};
use legwork::error::Error;

/// The figure of whether the robot was on its feet to the end: 1 or 0.
pub const SURVIVED: &str = "survived";

/// What is kept in memory of a rollout.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Its number in the study.
    pub index: u64,
    /// How it ended.
    pub ending: Ending,
    /// When the robot fell [s].
    pub fell_at_s: Option<f64>,
    /// The first cause of the fall.
    pub cause: Option<String>,
    /// Whether the run broke bounds of the simulator's audit.
    pub is_doubtful: bool,
    /// The study's metrics, in their order.
    pub metrics: Vec<Option<f64>>,
}

/// The rows of a study.
#[derive(Clone, Debug)]
pub struct Results<'a> {
    /// What was run.
    pub study: &'a Study,
    /// One a rollout, in order.
    pub rows: Vec<Row>,
    /// The columns of the study's metrics.
    pub columns: Vec<Column>,
}

/// How the rollouts of a scenario ended.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Endings {
    /// All of them.
    pub rollouts: usize,
    /// On their feet to the end, without a force that injures.
    pub completed: usize,
    /// On their feet to the end, with one ([`Ending::Injurious`]).
    pub injurious: usize,
    /// Falls.
    pub fell: usize,
    /// Combinations of values that could not be run.
    pub invalid: usize,
    /// Failures of the program.
    pub failed: usize,
    /// Runs, however they ended, that broke bounds of the simulator's audit.
    pub doubtful: usize,
    /// Falls by their first cause.
    pub causes: BTreeMap<String, usize>,
}

/// A factor's levels with the rows of all its rollouts in one scenario.
pub type Sweep<'a> = Vec<(Level, &'a Row)>;

/// What one metric depends on in one scenario.
#[derive(Clone, Debug)]
pub struct Sensitivity<T> {
    /// The metric, or [`SURVIVED`].
    pub metric: String,
    /// What the analysis found.
    pub found: T,
}

/// The elementary effects of each factor; none where the metric is the same in all rollouts but for rounding.
pub type AllEffects = Option<Vec<Effects>>;

/// How far a metric goes in the rollouts of one scenario that stood.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range<'a> {
    /// The metric.
    pub column: &'a Column,
    /// The least value, in the metric's unit.
    pub least: f64,
    /// The greatest.
    pub greatest: f64,
}

impl Range<'_> {
    /// Whether all values are the same but for rounding.
    pub fn is_one_value(&self) -> bool {
        ties::are_equal(self.least, self.greatest)
    }
}

impl<'a> Results<'a> {
    /// The results that `rollouts` are, all of them in order.
    ///
    /// # Errors
    /// One of them cannot be read.
    pub fn new(study: &'a Study, rollouts: impl Iterator<Item = Result<Rollout, Error>>) -> Result<Self, Error> {
        let all = study.columns();
        let wanted: Vec<usize> = study
            .metrics
            .iter()
            .map(|metric| all.iter().position(|column| column.name == *metric).expect("metrics were checked"))
            .collect();
        let row = |(index, rollout): (usize, Result<Rollout, Error>)| {
            let Rollout { ending, fell_at_s, cause, violations, figures, .. } = rollout?;
            let metrics = wanted.iter().map(|&column| figures.get(column).copied().flatten()).collect();
            Ok(Row { index: index as u64, ending, fell_at_s, cause, is_doubtful: violations.is_some(), metrics })
        };
        let rows = rollouts.enumerate().map(row).collect::<Result<_, Error>>()?;
        let columns = wanted.iter().map(|&column| all[column].clone()).collect();
        Ok(Self { study, rows, columns })
    }

    /// The rows of the scenario of number `base`.
    pub fn of(&self, base: usize) -> &[Row] {
        let each = self.rows.len() / self.study.bases.len();
        &self.rows[base * each..(base + 1) * each]
    }

    /// How the rollouts of the scenario of number `base` ended.
    pub fn endings(&self, base: usize) -> Endings {
        let mut endings = Endings { rollouts: self.of(base).len(), ..Endings::default() };
        for row in self.of(base) {
            match row.ending {
                Ending::Completed => endings.completed += 1,
                Ending::Injurious => endings.injurious += 1,
                Ending::Fell => endings.fell += 1,
                Ending::Invalid => endings.invalid += 1,
                Ending::Failed => endings.failed += 1,
            }
            endings.doubtful += usize::from(row.is_doubtful);
            if let Some(cause) = &row.cause {
                *endings.causes.entry(cause.clone()).or_default() += 1;
            }
        }
        endings
    }

    /// The rollouts that were made for `factor` in a scenario, by its level. Of a design that changes one factor at a
    /// time these are a curve, of the others a cloud.
    pub fn sweep(&self, base: usize, factor: usize) -> Sweep<'_> {
        let at = |row: &'_ Row| self.study.point(row.index).levels[factor].clone();
        self.of(base).iter().filter_map(|row| Some((at(row)?, row))).collect()
    }

    /// The `shares` quantiles of a metric over the runs of a scenario that did not fall; none where no run has it.
    pub fn quantiles<const N: usize>(&self, base: usize, metric: usize, shares: [f64; N]) -> [Option<f64>; N] {
        let whole = self.of(base).iter().filter(|row| row.ending.stood());
        let mut values: Vec<f64> = whole.filter_map(|row| row.metrics[metric]).collect();
        values.sort_by(f64::total_cmp);
        let last = values.len().saturating_sub(1) as f64;
        shares.map(|share| values.get((share * last).round() as usize).copied())
    }

    /// Sobol' indices of survival and of each metric; none of another design than Saltelli's.
    ///
    /// The indices of a metric are those of its rank among the scenario's rollouts (Saltelli and Sobol' 1995,
    /// doi:10.1016/0951-8320(95)00099-2). A fall has no figure that could be compared with those of whole runs: all falls
    /// share the last rank. The values themselves would not do, as a few runs near a fall have most of their variance.
    ///
    /// # Errors
    /// Fewer than two base samples can be used.
    pub fn sobol(&self, base: usize, bootstrap: &Bootstrap) -> Result<Vec<Sensitivity<Indices>>, Error> {
        let Design::Saltelli { second_order, .. } = self.study.design else { return Ok(Vec::new()) };
        let of = |(metric, outputs): (String, Vec<f64>)| {
            let found = sobol_indices(&outputs, self.study.factors.len(), second_order, bootstrap)?;
            Ok(Sensitivity { metric, found })
        };
        self.outputs(base).map(of).collect()
    }

    /// Elementary effects of each factor on survival and on the rank of each metric, as in [`Results::sobol`]; none of
    /// another design than Morris's.
    ///
    /// # Errors
    /// Fewer than two trajectories can be used.
    pub fn morris(&self, base: usize, bootstrap: &Bootstrap) -> Result<Vec<Sensitivity<AllEffects>>, Error> {
        let Design::Morris { .. } = self.study.design else { return Ok(Vec::new()) };
        let points = self.study.unit_points().expect("the design is a sampled one");
        let of = |(metric, outputs): (String, Vec<f64>)| {
            let effects = morris(&points, &outputs, bootstrap)?;
            let mut known = outputs.iter().filter(|output| !output.is_nan());
            let differs = known.next().is_some_and(|first| known.any(|output| output != first));
            Ok(Sensitivity { metric, found: differs.then_some(effects) })
        };
        self.outputs(base).map(of).collect()
    }

    /// Survival, and the ranks of each metric.
    fn outputs(&self, base: usize) -> impl Iterator<Item = (String, Vec<f64>)> + '_ {
        let ranked = self.whole_runs(base).map(|(metric, values)| (metric, ranks(&values)));
        std::iter::once((SURVIVED.to_owned(), self.survival(base))).chain(ranked)
    }

    /// The range of each metric in a scenario, without those that no run that stood has.
    pub fn ranges(&self, base: usize) -> impl Iterator<Item = Range<'_>> {
        self.columns.iter().enumerate().filter_map(move |(metric, column)| {
            let [least, greatest] = self.quantiles(base, metric, [0.0, 1.0]);
            Some(Range { column, least: least?, greatest: greatest? })
        })
    }

    /// The range of the metric of that name.
    pub fn range(&self, base: usize, metric: &str) -> Option<Range<'_>> {
        self.ranges(base).find(|range| range.column.name == metric)
    }

    /// 1 for each rollout of a scenario that was on its feet to the end, 0 for falls, missing where it could not be run.
    fn survival(&self, base: usize) -> Vec<f64> {
        let value = |row: &Row| match row.ending {
            Ending::Completed | Ending::Injurious => 1.0,
            Ending::Fell => 0.0,
            Ending::Invalid | Ending::Failed => f64::NAN,
        };
        self.of(base).iter().map(value).collect()
    }

    /// Each metric of all rollouts of a scenario, none for those that fell, missing where it could not be run; without the metrics that no run of it has.
    fn whole_runs(&self, base: usize) -> impl Iterator<Item = (String, Vec<Option<f64>>)> + '_ {
        let whole = |row: &Row, metric: usize| match row.ending {
            Ending::Completed | Ending::Injurious => row.metrics[metric],
            Ending::Fell => None,
            Ending::Invalid | Ending::Failed => Some(f64::NAN),
        };
        let values = move |metric: usize| self.of(base).iter().map(|row| whole(row, metric)).collect::<Vec<_>>();
        let named = move |(metric, name): (usize, &String)| (name.clone(), values(metric));
        self.study
            .metrics
            .iter()
            .enumerate()
            .map(named)
            .filter(|(_, values)| values.iter().flatten().any(|value| !value.is_nan()))
    }
}

/// The rank of each value, from 0 for the least to 1 for the largest, as [`ties::ranks`]; those that are none come last together.
fn ranks(values: &[Option<f64>]) -> Vec<f64> {
    let ranks = ties::ranks(&values.iter().map(|value| value.unwrap_or(f64::INFINITY)).collect::<Vec<_>>());
    let last = ranks.iter().filter(|rank| !rank.is_nan()).count().saturating_sub(1).max(1) as f64;
    ranks.into_iter().map(|rank| (rank - 1.0) / last).collect()
}

/// Writes all rollouts of `study` as `rollouts.csv` and `rollouts.parquet` into `folder`: number, scenario, the level of
/// each factor (nothing where the scenario's own value stays), how it ended, every figure, the hashes.
///
/// # Errors
/// A rollout cannot be read, or a file cannot be written.
pub fn write_table(
    study: &Study,
    folder: &Path,
    rollouts: impl Iterator<Item = Result<Rollout, Error>>,
) -> Result<(), Error> {
    let figures = study.columns();
    let mut columns = vec![table::Column::number("rollout", ""), table::Column::text("scenario")];
    let kinds: Vec<Kind> = study.factors.iter().map(|factor| kind(&factor.levels.extremes())).collect();
    for (factor, &kind) in study.factors.iter().zip(&kinds) {
        columns.push(table::Column { name: factor.name.clone(), unit: factor.unit().to_owned(), kind });
    }
    columns.extend(["ending", "cause", "reason", "violations", "input_hash", "result_hash"].map(table::Column::text));
    columns.extend([table::Column::number(SURVIVED, ""), table::Column::number("fell_at_s", "s")]);
    columns.extend(figures.iter().map(|figure| table::Column::number(&figure.name, figure.unit)));
    let metadata = [("study", study.to_toml().to_owned()), ("identity", format!("{:032x}", study.identity()))];
    let mut writer = TableWriter::create(folder, "rollouts", columns, &metadata)?;
    for (index, rollout) in rollouts.enumerate() {
        let (rollout, point) = (rollout?, study.point(index as u64));
        let mut cells = vec![Cell::Number(index as f64), study.bases[point.base].name().into()];
        cells.extend(point.levels.iter().zip(&kinds).map(|(level, kind)| match (level, kind) {
            (None, _) => Cell::Empty,
            (Some(Level::Number(number)), Kind::Number) => Cell::Number(*number),
            (Some(Level::Flag(flag)), Kind::Flag) => Cell::Flag(*flag),
            (Some(level), _) => Cell::Text(level.to_string()),
        }));
        let text = |text: &Option<String>| Cell::from(text.as_deref());
        cells.extend([
            rollout.ending.name().into(),
            text(&rollout.cause),
            text(&rollout.reason),
            text(&rollout.violations),
        ]);
        cells.extend([rollout.input_hash.as_str().into(), rollout.result_hash.as_str().into()]);
        cells.extend([f64::from(u8::from(rollout.survived())).into(), rollout.fell_at_s.into()]);
        cells.extend((0..figures.len()).map(|figure| rollout.figures.get(figure).copied().flatten().into()));
        writer.row(cells)?;
    }
    writer.finish()
}

/// What a column of these levels holds: of several kinds, their texts.
fn kind(levels: &[Level]) -> Kind {
    match levels {
        numbers if numbers.iter().all(|level| matches!(level, Level::Number(_))) => Kind::Number,
        flags if flags.iter().all(|level| matches!(level, Level::Flag(_))) => Kind::Flag,
        _ => Kind::Text,
    }
}

#[cfg(test)]
mod tests {
    use super::ranks;

    #[test]
    fn ranks_are_shared_by_equals_and_falls_come_last() {
        assert_eq!(ranks(&[Some(3.0), None, Some(1.0), Some(2.0), None]), [0.5, 0.875, 0.0, 0.25, 0.875]);
        assert_eq!(ranks(&[Some(2.0), Some(2.0), Some(2.0)]), [0.5; 3]);
        assert_eq!(ranks(&[Some(-1e300), Some(0.0), Some(1e300)]), [0.0, 0.5, 1.0]);
        assert_eq!((ranks(&[]), ranks(&[None])), (vec![], vec![0.0]));
        let with_hole = ranks(&[Some(3.0), Some(f64::NAN), Some(1.0)]);
        assert!(with_hole[0] == 1.0 && with_hole[1].is_nan() && with_hole[2] == 0.0);
    }
}
