//! The programs of a control loop, one a tick, as a table: variables n, rows m, then H (n × n), g, A (m × n), lower and upper
//! bounds of A x, lower and upper bounds of x.

use std::error::Error;
use std::path::Path;

use legwork::contract::Sensed;
use legwork::control::Controller;
use legwork::recording::Recording;
use legwork::sim::Plant;
use legwork::{episode, scenario_file};
use legwork_qp::Problem;

use crate::files::Table;

/// What is recorded: a scenario, its settings, the first tick and the number of ticks.
type Part = (&'static str, &'static [&'static str], usize, usize);

const SLACK: [Part; 2] =
    [("push", &["controller.form=slack"], 300, 1600), ("walk", &["controller.form=slack"], 0, 1600)];
const DIRECT: [Part; 2] = [("push", &[], 300, 1600), ("walk", &[], 0, 1600)];
/// 24 accelerations, eight contact points; the torque limit is low enough to be met.
const SWAYING: Part = ("exo-sway", &["model=bench/peers/humanoid24.urdf", "controller.limits.torque_nm=60"], 0, 800);
/// It falls after 1.79 s.
const LIFTING: [&str; 4] = [
    "model=bench/peers/humanoid24.urdf",
    "controller.limits.torque_nm=100",
    "reference.stance.lift_start_s=0.1",
    "reference.stance.lift_duration_s=0.5",
];
const HUMANOID: [Part; 2] = [SWAYING, ("exo-lift", &LIFTING, 0, 2400)];
const STANDING: [Part; 2] = [SWAYING, ("exo-lift", &LIFTING, 0, 1700)];

/// What a scenario's run gives to its controller and its simulator, in so many ticks at most.
pub(crate) fn recorded(scenario: &str, sets: &[String], most: usize) -> Result<Recording, Box<dyn Error>> {
    let loaded = scenario_file::load(scenario, sets)?;
    let samples = loaded.samples()?;
    let mut ticks = 0;
    let enough = |_| {
        ticks += 1;
        ticks >= most
    };
    let run = episode::run(&loaded.scenario, &loaded.model()?, &samples, enough)?;
    match run.reason {
        Some(reason) => Err(format!("{scenario} {}: {reason}", sets.join(" ")).into()),
        None => Ok(Recording::of(&run, &samples)),
    }
}

/// Which contact points touch the ground.
pub(crate) fn touching(sensed: &Sensed) -> Vec<bool> {
    sensed.contacts.iter().map(|contact| contact.touching).collect()
}

/// Records the programs "slack", "direct" (of the thesis's scenarios), "humanoid", or "standing" (the humanoid's before it falls), and says
/// what happened in them.
pub(crate) fn record(which: &str, out: &Path) -> Result<(), Box<dyn Error>> {
    let parts = match which {
        "slack" => SLACK,
        "direct" => DIRECT,
        "humanoid" => HUMANOID,
        "standing" => STANDING,
        _ => return Err(format!("found '{which}'; valid are slack, direct, humanoid, standing").into()),
    };
    let mut problems: Vec<Problem> = Vec::new();
    let (mut switches, mut saturated) = (0, 0);
    for (scenario, sets, first, ticks) in parts {
        let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
        // The loop goes on where a run would end as a fall: programs of a falling robot are the hardest.
        let recording = recorded(scenario, &sets, 1)?;
        let (mut controller, mut simulator) = (recording.controller()?, recording.simulator()?);
        let mut estimate = recording.estimates[0].clone();
        let mut before = (touching(&estimate), None);
        for tick in 0..first + ticks {
            simulator.read(&mut estimate);
            controller.tick(&estimate, simulator.dynamics());
            let swing = controller.reference().and_then(|reference| reference.swing);
            let now = (touching(&estimate), swing.map(|swing| swing.foot));
            if tick >= first {
                problems.push(controller.problem().clone());
                switches += usize::from(now != before);
                saturated += usize::from(controller.latest().active.iter().any(|&side| side != 0));
            }
            before = now;
            if !(0..recording.steps_per_tick).all(|_| simulator.step(&controller.latest().solution.tau)) {
                return Err(format!("{scenario} left the bounds of the possible").into());
            }
        }
    }
    let kept = used_rows(&problems);
    let (count, n, m) = (problems.len(), problems[0].n(), kept.len());
    say(&format!(
        "{count} programs of {n} variables and {m} rows, {switches} contact switches, a limit active in {saturated}"
    ));
    let mut table = Table::new(row(&problems[0], &kept).len());
    problems.iter().for_each(|problem| table.push(row(problem, &kept)));
    Ok(table.write(out)?)
}

/// The rows that say something in some program: those of relaxations that never come would burden everyone.
fn used_rows(problems: &[Problem]) -> Vec<usize> {
    let used = |problem: &Problem, i: usize| problem.row_lower()[i].is_finite() || problem.row_upper()[i].is_finite();
    (0..problems[0].m()).filter(|&i| problems.iter().any(|problem| used(problem, i))).collect()
}

/// One line for whoever started the program.
pub(crate) fn say(line: &str) {
    use std::io::Write;
    let _ = writeln!(std::io::stdout(), "{line}");
}

fn row(problem: &Problem, kept: &[usize]) -> Vec<f64> {
    let mut row = vec![problem.n() as f64, kept.len() as f64];
    row.extend(problem.hessian());
    row.extend(problem.gradient());
    kept.iter().for_each(|&i| row.extend(problem.row(i)));
    row.extend(kept.iter().map(|&i| problem.row_lower()[i]));
    row.extend(kept.iter().map(|&i| problem.row_upper()[i]));
    row.extend(problem.lower());
    row.extend(problem.upper());
    row
}

/// The program of a table's row.
pub(crate) fn problem(row: &[f64]) -> Problem {
    let (n, m) = (row[0] as usize, row[1] as usize);
    let mut problem = Problem::new(n, m);
    let mut rest = &row[2..];
    let mut take = |count: usize| {
        let (head, tail) = rest.split_at(count);
        rest = tail;
        head
    };
    problem.hessian_mut().copy_from_slice(take(n * n));
    problem.gradient_mut().copy_from_slice(take(n));
    (0..m).for_each(|i| problem.row_mut(i).copy_from_slice(take(n)));
    problem.row_lower_mut().copy_from_slice(take(m));
    problem.row_upper_mut().copy_from_slice(take(m));
    problem.lower_mut().copy_from_slice(take(n));
    problem.upper_mut().copy_from_slice(take(n));
    problem
}
