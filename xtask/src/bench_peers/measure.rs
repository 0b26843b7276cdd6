//! Runs a case round by round, ours and theirs in turn, and turns answers into figures.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use super::Places;
use super::cases::{Case, Judge};
use super::setup::{Peer, ours};
use crate::say;

/// Nobody needs longer for a case.
const TIME_LIMIT: Duration = Duration::from_secs(120);
/// A row or bound counts as violated beyond this times 1 + its size: a newton of a thousand.
const VIOLATION: f64 = 1e-3;

/// A case with what came out.
#[derive(Clone, Debug)]
pub(super) struct Measured {
    pub(super) case: Case,
    /// What our example said of the inputs.
    pub(super) inputs: String,
    /// Ours first.
    pub(super) rows: Vec<Row>,
}

/// A contender's figures, or why there are none.
#[derive(Clone, Debug)]
pub(super) struct Row {
    pub(super) name: String,
    /// What it said of its problems in the first round.
    pub(super) says: String,
    pub(super) figures: Result<Figures, String>,
}

/// Times in microseconds; each problem's time is its median over the rounds.
#[derive(Clone, Debug, Default)]
pub(super) struct Figures {
    pub(super) median: f64,
    pub(super) p99: f64,
    pub(super) p999: f64,
    pub(super) max: f64,
    /// Sum over all problems: of a closed loop, what it takes.
    pub(super) total: f64,
    pub(super) count: usize,
    pub(super) iterations: f64,
    /// Problems that it calls unsolved or answers wrongly.
    pub(super) failures: usize,
    /// Median and largest difference from ours; of ours the largest relative residual, twice.
    pub(super) difference: Option<(f64, f64)>,
}

impl Figures {
    /// The time of wrong answers is no measure.
    pub(super) fn is_a_measure(&self) -> bool {
        2 * self.failures < self.count
    }
}

/// Rows of doubles.
#[derive(Clone, Debug)]
struct Table {
    columns: usize,
    values: Vec<f64>,
}

impl Table {
    fn read(path: &Path) -> Result<Self, String> {
        let bytes = std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
        let values: Vec<f64> = bytes.as_chunks().0.iter().map(|eight: &[u8; 8]| f64::from_le_bytes(*eight)).collect();
        match values.split_first() {
            Some((&columns, rest)) if columns >= 3.0 && rest.len() >= columns as usize => {
                Ok(Self { columns: columns as usize, values: rest.to_vec() })
            }
            _ => Err("it wrote no answers".to_owned()),
        }
    }

    fn rows(&self) -> impl Iterator<Item = &[f64]> {
        self.values.chunks_exact(self.columns)
    }
}

/// Measures a case.
pub(super) fn case(case: &Case, peers: &[Peer], places: &Places, rounds: usize) -> Result<Measured, String> {
    let fill = |text: &str| text.replace('@', &places.peers.join("data").display().to_string());
    let split = |text: &str| fill(text).split(' ').map(str::to_owned).collect::<Vec<String>>();
    let mut inputs = String::new();
    for call in &case.prepare {
        inputs.push_str(&start(&[vec![ours(places)], split(call)].concat(), places)?);
    }
    // Program and arguments of each contender that can start.
    let mut contenders = vec![("legwork".to_owned(), Ok([vec![ours(places)], split(case.ours)].concat()))];
    for (name, arguments) in &case.peers {
        let peer = peers.iter().find(|peer| peer.name == *name).ok_or_else(|| format!("no peer is called {name}"))?;
        let command = peer.command.clone().map(|command| [command, split(arguments)].concat());
        contenders.push(((*name).to_owned(), command));
    }
    let mut answers: Vec<Result<Vec<Table>, String>> = contenders
        .iter()
        .map(|(_, command)| command.clone().map(|_| Vec::new()).map_err(|why| format!("not available: {why}")))
        .collect();
    let mut says = vec![String::new(); contenders.len()];
    for round in 0..rounds {
        for (index, (name, command)) in contenders.iter().enumerate() {
            let (Ok(command), Ok(tables)) = (command, &mut answers[index]) else { continue };
            let out = places.data(&format!("answers-{}-{index}", case.key));
            let _ = std::fs::remove_file(&out);
            let call = [command.clone(), vec![out.display().to_string()]].concat();
            match start(&call, places).and_then(|said| Ok((said, Table::read(&out)?))) {
                Ok((said, table)) => {
                    if round == 0 {
                        says[index] = said.trim().to_owned();
                    }
                    tables.push(table);
                }
                Err(problem) => {
                    say(&format!("{name}, round {}: {problem}", round + 1));
                    answers[index] = Err(problem);
                }
            }
        }
    }
    let reference = answers[0].clone()?;
    let programs = match case.judge {
        Judge::Programs => Some(Table::read(Path::new(&split(case.ours)[1]))?),
        Judge::Values | Judge::Velocities | Judge::Nothing => None,
    };
    let rows = contenders.into_iter().zip(answers).zip(says).enumerate().map(|(index, (((name, _), tables), says))| {
        let figures = tables.map(|tables| figures(case.judge, &tables, &reference[0], programs.as_ref(), index == 0));
        Row { name, says, figures }
    });
    Ok(Measured { case: case.clone(), inputs: inputs.trim().to_owned(), rows: rows.collect() })
}

/// Runs a program on the last core where that can be chosen, and returns what it says.
fn start(call: &[String], places: &Places) -> Result<String, String> {
    let core = std::thread::available_parallelism().map_or(0, |cores| cores.get() - 1).to_string();
    let pinned = Command::new("taskset").arg("--version").stdout(Stdio::null()).status().is_ok();
    let mut command = Command::new(if pinned { "taskset" } else { &call[0] });
    if pinned {
        command.args(["-c", &core, &call[0]]);
    }
    command.args(&call[1..]).current_dir(&places.root).stdout(Stdio::piped()).stderr(Stdio::piped());
    // One thread each, whatever linear algebra lies below.
    command.env("OMP_NUM_THREADS", "1").env("OPENBLAS_NUM_THREADS", "1");
    let mut child = command.spawn().map_err(|error| format!("{}: {error}", call[0]))?;
    if !ends_in_time(&mut child) {
        return Err(format!("it did not end within {} s", TIME_LIMIT.as_secs()));
    }
    let output = child.wait_with_output().map_err(|error| error.to_string())?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    Err(format!("it failed ({}): {}", output.status, words.lines().last().unwrap_or("without a word")))
}

fn ends_in_time(child: &mut Child) -> bool {
    let begin = Instant::now();
    while begin.elapsed() < TIME_LIMIT {
        match child.try_wait() {
            Ok(Some(_)) => return true,
            _ => std::thread::sleep(Duration::from_millis(5)),
        }
    }
    let _ = child.kill();
    let _ = child.wait();
    false
}

fn figures(judge: Judge, tables: &[Table], ours: &Table, programs: Option<&Table>, is_ours: bool) -> Figures {
    let count = tables.iter().map(|table| table.rows().count()).min().unwrap_or(0);
    let rounds: Vec<Vec<f64>> = tables.iter().map(|table| table.rows().map(|row| row[0]).collect()).collect();
    let mut times: Vec<f64> =
        (0..count).map(|i| quantile(&mut rounds.iter().map(|round| round[i]).collect::<Vec<f64>>(), 0.5)).collect();
    let first = &tables[0];
    let mut programs = programs.map(Table::rows);
    let (mut failures, mut differences) = (0, Vec::new());
    for (row, own) in first.rows().zip(ours.rows()) {
        let program = programs.as_mut().and_then(Iterator::next);
        let values = &row[3..];
        let sound = row[1] == 1.0 && values.iter().all(|value| value.is_finite());
        if !sound || program.is_some_and(|program| violation(program, values) > VIOLATION) {
            failures += 1;
        } else if judge == Judge::Programs && is_ours {
            differences.push(values[values.len() - 1]);
        } else if judge != Judge::Nothing && !is_ours {
            let difference = values.iter().zip(&own[3..]).map(|(a, b)| (a - b).abs());
            differences.push(difference.fold(0.0, f64::max));
        }
    }
    let mut iterations: Vec<f64> = first.rows().map(|row| row[2]).collect();
    let total = times.iter().sum();
    Figures {
        total,
        count,
        median: quantile(&mut times, 0.5),
        p99: quantile(&mut times, 0.99),
        p999: quantile(&mut times, 0.999),
        max: quantile(&mut times, 1.0),
        iterations: iterations.iter_mut().map(|value| *value).sum::<f64>() / count.max(1) as f64,
        failures,
        difference: (!differences.is_empty())
            .then(|| (quantile(&mut differences, 0.5), quantile(&mut differences, 1.0))),
    }
}

/// The largest violation of a program's rows and bounds, relative to 1 + the bound.
fn violation(program: &[f64], x: &[f64]) -> f64 {
    let (n, m) = (program[0] as usize, program[1] as usize);
    let rows = &program[2 + n * n + n..];
    let (rows, bounds) = rows.split_at(m * n);
    let (row_bounds, own_bounds) = bounds.split_at(2 * m);
    let outside = |value: f64, lower: f64, upper: f64| {
        let below = (lower - value) / (1.0 + lower.abs());
        let above = (value - upper) / (1.0 + upper.abs());
        // An infinite bound gives NaN, which max leaves out.
        0.0_f64.max(below).max(above)
    };
    let of_rows = (0..m).map(|i| {
        let value = rows[i * n..(i + 1) * n].iter().zip(x).map(|(a, x)| a * x).sum();
        outside(value, row_bounds[i], row_bounds[m + i])
    });
    let of_bounds = (0..n).map(|j| outside(x[j], own_bounds[j], own_bounds[n + j]));
    of_rows.chain(of_bounds).fold(0.0, f64::max)
}

/// The `share` quantile; sorts on the way.
fn quantile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let last = values.len().saturating_sub(1);
    values.get((share * last as f64).round() as usize).copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_values_of_the_sample() {
        let mut values: Vec<f64> = (0..101).rev().map(f64::from).collect();
        for (share, expected) in [(0.0, 0.0), (0.5, 50.0), (0.99, 99.0), (0.994, 99.0), (0.996, 100.0), (1.0, 100.0)] {
            assert_eq!(quantile(&mut values, share), expected, "{share}");
        }
        assert_eq!(quantile(&mut [3.0], 0.99), 3.0);
        assert!(quantile(&mut [], 0.5).is_nan());
    }

    /// 1 <= x + y <= 3, x <= 4 and -1 <= y.
    fn program() -> Vec<f64> {
        let cost = [1.0, 0.0, 0.0, 1.0, 0.0, 0.0];
        let rows = [1.0, 1.0, 1.0, 3.0];
        let bounds = [f64::NEG_INFINITY, -1.0, 4.0, f64::INFINITY];
        [&[2.0, 1.0], &cost[..], &rows, &bounds].concat()
    }

    #[test]
    fn a_violation_is_relative_to_the_bound() {
        let cases = [
            ([1.0, 1.0], 0.0),
            ([4.0, -1.0], 0.0),
            ([0.0, 0.0], 0.5),        // row below 1
            ([3.0, 2.0], 0.5),        // row above 3
            ([4.5, -1.5], 0.25),      // x above 4 by a tenth, y below -1 by a quarter
            ([-1e6, 1e6 + 2.0], 0.0), // no bound there
        ];
        for (x, expected) in cases {
            assert_eq!(violation(&program(), &x), expected, "{x:?}");
        }
    }

    fn table(rows: &[[f64; 5]]) -> Table {
        Table { columns: 5, values: rows.concat() }
    }

    #[test]
    fn a_problem_takes_the_median_of_its_rounds() {
        let rounds =
            [1.0, 9.0, 2.0].map(|time| table(&[[time, 1.0, 4.0, 0.0, 0.0], [10.0 * time, 1.0, 6.0, 0.0, 0.0]]));
        let figures = figures(Judge::Nothing, &rounds, &rounds[0], None, true);
        assert_eq!((figures.total, figures.max, figures.count), (22.0, 20.0, 2));
        assert_eq!((figures.iterations, figures.failures, figures.difference), (5.0, 0, None));
    }

    #[test]
    fn unsolved_infinite_and_wrong_answers_are_failures() {
        let ours = table(&[[1.0, 1.0, 0.0, 1.0, 1.0]; 4]);
        let theirs = table(&[
            [1.0, 0.0, 0.0, 1.0, 1.0],
            [1.0, 1.0, 0.0, f64::NAN, 1.0],
            [1.0, 1.0, 0.0, 0.0, 0.0],
            [1.0, 1.0, 0.0, 1.5, 1.25],
        ]);
        let program = program();
        let programs = Table { columns: program.len(), values: program.repeat(4) };
        let judged = figures(Judge::Programs, &[theirs], &ours, Some(&programs), false);
        assert_eq!((judged.failures, judged.difference), (3, Some((0.5, 0.5))));
        assert!(!judged.is_a_measure());
    }
}
