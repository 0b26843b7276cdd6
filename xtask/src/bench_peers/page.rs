//! docs/performance.md and its data: all figures from the measurement, the words from here.

use std::fmt::Write;

use super::machine::Machine;
use super::measure::{Figures, Measured, Row};
use super::setup::Peer;
use super::targets;

const INTRODUCTION: &str = "\
# How fast legwork is

Measured beside other people's programs: the same models, the same states, the same quadratic programs, in one run, in turn,
each on one core. `cargo xtask bench-peers` installs the peers from the Python package index below `target/peers`, compiles
small harnesses around them (`bench/peers/`), measures, and writes this page, [its data](data/performance.csv) and the chart.
`--quick` takes fewer rounds, `--only dynamics,qp,tick,contact,loop` some of the groups, for a look without a new page. A peer
that cannot be set up is named below with the reason.

![Medians of all contenders](images/performance-peers.svg)
";

const COMPARABLE: &str = "
## What is not comparable

- **Compilers.** Ours is built as a user builds it, without flags for the processor. DAQP, PIQP, ProxQP and quadprog
  are compiled for this processor, which is to their advantage; Pinocchio, TSID, eiquadprog, MuJoCo and OSQP run as their
  packages ship them.
- **Dynamics.** Ours computes the Jacobian and its bias of each contact point (8 of exo18), energies and the gravity
  vector besides. Pinocchio computes one 6 × n Jacobian a foot; the contact points' rows that are compared follow from
  them outside the clock.
- **Solvers.** The clock runs from matrices in memory, each in the form that its solver wants, to the solution, with setup or
  update. DAQP, ProxQP and OSQP start warm; DAQP eliminates
  the equalities where that is faster (`eq_reduction`: slack form, 48 variables) and has an iteration limit of 1000; quadprog, eiquadprog, PIQP and Clarabel have no warm start. Rows that no program
  of a series uses are left out for everyone. ProxQP and OSQP have a tolerance of 1e-6, the rest their defaults. OSQP's time is that of its own clock, without Python. The
  slack program's cost is not strictly convex, which Goldfarb and Idnani's method needs: quadprog and eiquadprog cannot solve it, ours adds the
  equalities to it. A failure is what the solver calls unsolved, what is no number, or what misses a row or bound by more
  than 1e-3 of 1 + its size.
- **48 variables.** After 1.8 s of its second scenario the humanoid falls, and its program asks each tick for what the tick before did not:
  ours changes its working set 30 to 150 times then, at some 3 µs a change, for 10 to 30 members at the end. These programs are the last 1 % and more.
  Fewer changes were looked for: violations measured by the Hessian's length of their normals (p99 of the changes 124 in place of 112), the steepest rise
  of the dual objective, which costs a projection of each violated row (101), and working sets changed in blocks before the search (136 to 309).
- **Control ticks.** Each side formulates its own program for the same robot: TSID tracks centre of mass, posture and waist
  with two six-dimensional contacts of four corner forces and torque bounds; legwork adds momentum, joint-limit braking and
  the step state machine, and names the limits that are active. Both include the dynamics, and no physics runs between the
  ticks: ours are given the states of a closed loop, TSID follows its own accelerations. In single support each swings the
  foot its own way.
- **Closed loops.** TSID and MuJoCo are joined in C++, without Python: the state's way from one to the other, the tick, and one
  step are timed. It has the robot, start pose, sway, squat and pushes (200 N on the centre of mass for 0.1 s, forward and to
  the left) of ours, with position, velocity and acceleration of the centre of mass as its reference. Each side controls its own
  physics, soft or rigid, so that the motions differ. A loop whose robot falls fails in
  all ticks.
- **Physics.** MuJoCo's contacts are soft and its integrator is semi-implicit Euler with one evaluation of the dynamics; ours
  are rigid, by the midpoint rule, with three evaluations a step, an energy audit, and pushes. Both step from the same
  recorded states with the same torques; MuJoCo has its default solver, and a contact margin of 0.5 mm, without which its
  contacts would carry nothing in these states. The difference is that of the velocities after a step [rad/s, m/s]; where a push acts, or a foot lands,
  it is large by nature.
- **Noise.** A problem's time is its median over the rounds, so that the quantiles are those of problems and not of
  interruptions by other processes.
";

/// The whole page.
pub(super) fn document(measured: &[Measured], peers: &[Peer], machine: &Machine, rounds: usize) -> String {
    let mut text = INTRODUCTION.to_owned();
    let missing = peers.iter().filter(|peer| peer.command.is_err()).count();
    let _ = writeln!(text, "\n## Targets and what was reached\n\n{rounds} rounds; {missing} peers not available.\n");
    text.push_str(&targets::table(measured));
    text.push_str(&tables(measured));
    text.push_str(COMPARABLE);
    text.push_str("\n## Machine and versions\n\n| | |\n|---|---|\n");
    for (what, which) in machine {
        let _ = writeln!(text, "| {what} | {} |", which.replace('|', "\\|"));
    }
    text
}

/// One table a case.
pub(super) fn tables(measured: &[Measured]) -> String {
    let mut text = String::new();
    for case in measured {
        let _ = writeln!(text, "\n## {}\n", case.case.title);
        for line in case.inputs.lines() {
            let _ = writeln!(text, "{line}.\n");
        }
        text.push_str("| | median µs | p99 µs | max µs | median ours / theirs | iterations | failures | difference, median / max |\n");
        text.push_str("|---|---|---|---|---|---|---|---|\n");
        let ours = case.rows.first().and_then(|row| row.figures.as_ref().ok());
        for (index, row) in case.rows.iter().enumerate() {
            let _ = writeln!(text, "{}", line(row, ours, index == 0));
        }
        for row in case.rows.iter().filter(|row| !row.says.is_empty()) {
            let _ = writeln!(text, "\n{}: {}.", row.name, row.says);
        }
        if let (Some(ours), "loop") = (ours, case.case.group) {
            let _ = writeln!(
                text,
                "\nlegwork: {:.0} times real time, control and physics at 1 kHz.",
                targets::real_time(ours)
            );
        }
        if case.rows[0].figures.as_ref().is_ok_and(|figures| figures.difference.is_some()) {
            text.push_str("\nOurs has no difference but the largest relative residual of the optimality conditions.\n");
        }
    }
    text
}

fn line(row: &Row, ours: Option<&Figures>, is_ours: bool) -> String {
    let figures = match &row.figures {
        Ok(figures) => figures,
        Err(reason) => return format!("| {} | {reason} | | | | | | |", row.name),
    };
    let ratio = match ours {
        Some(ours) if !is_ours && figures.is_a_measure() => format!("{:.2}", ours.median / figures.median),
        _ => String::new(),
    };
    let difference = figures.difference.map_or(String::new(), |(median, max)| format!("{median:.1e} / {max:.1e}"));
    format!(
        "| {} | {} | {} | {} | {ratio} | {:.1} | {} of {} | {difference} |",
        row.name,
        microseconds(figures.median),
        microseconds(figures.p99),
        microseconds(figures.max),
        figures.iterations,
        figures.failures,
        figures.count
    )
}

/// Three digits.
pub(super) fn microseconds(value: f64) -> String {
    match value {
        value if value < 10.0 => format!("{value:.2}"),
        value if value < 100.0 => format!("{value:.1}"),
        value => format!("{value:.0}"),
    }
}

/// All figures, a row a contender and case.
pub(super) fn csv(measured: &[Measured]) -> String {
    let mut text =
        "case,contender,median_us,p99_us,p999_us,max_us,problems,iterations_mean,failures,difference_median,difference_max,note\n"
            .to_owned();
    for case in measured {
        for row in &case.rows {
            let _ = match &row.figures {
                Ok(f) => {
                    let (median, max) = f
                        .difference
                        .map_or((String::new(), String::new()), |(a, b)| (format!("{a:e}"), format!("{b:e}")));
                    writeln!(
                        text,
                        "{},{},{:.3},{:.3},{:.3},{:.3},{},{:.2},{},{median},{max},",
                        case.case.key, row.name, f.median, f.p99, f.p999, f.max, f.count, f.iterations, f.failures
                    )
                }
                Err(reason) => {
                    writeln!(text, "{},{},,,,,,,,,,\"{}\"", case.case.key, row.name, reason.replace('"', "'"))
                }
            };
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_says_what_its_contenders_say() {
        let row = |name: &str, says: &str| Row {
            name: name.to_owned(),
            says: says.to_owned(),
            figures: Ok(Figures::default()),
        };
        let rows = vec![row("legwork", ""), row("other", "it stands")];
        let case = super::super::cases::all().remove(0);
        let text = tables(&[Measured { case, inputs: String::new(), rows }]);
        assert!(text.contains("\nother: it stands.\n") && !text.contains("legwork:"), "{text}");
    }
}
