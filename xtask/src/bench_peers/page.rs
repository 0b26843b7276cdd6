//! docs/performance.md and its data: all figures from the measurement, the words from here.

use std::fmt::Write;

use super::machine::Machine;
use super::measure::{Figures, Measured, Row};
use super::setup::Peer;

/// What was to be reached: the target in words, its case, and how to tell.
struct Target {
    words: &'static str,
    case: &'static str,
    check: Check,
}

enum Check {
    /// Quantiles of ours over those of the peer: median, p99; each at most.
    Ratio(&'static str, f64, Option<f64>),
    /// Ours alone [µs]: median, p99.9.
    Time(f64, f64),
    /// Times real time, at 1 kHz: at least.
    RealTime(f64),
}

const TARGETS: [Target; 13] = [
    Target {
        words: "dynamics, planar humanoid: at most 1/2 of Pinocchio",
        case: "dynamics-planar7",
        check: Check::Ratio("Pinocchio", 0.5, None),
    },
    Target {
        words: "dynamics, exo18: at most 1/2 of Pinocchio",
        case: "dynamics-exo18",
        check: Check::Ratio("Pinocchio", 0.5, None),
    },
    Target {
        words: "slack program: at most 1/2 of DAQP's median, 1/5 of its p99",
        case: "qp-slack",
        check: Check::Ratio("DAQP", 0.5, Some(0.2)),
    },
    Target {
        words: "direct program: at most DAQP's median, p99 below it",
        case: "qp-direct",
        check: Check::Ratio("DAQP", 1.0, Some(1.0)),
    },
    Target { words: "48 variables: at most DAQP's median", case: "qp-48", check: Check::Ratio("DAQP", 1.0, None) },
    Target {
        words: "tick, planar humanoid: at most 6 µs, p99.9 below 20 µs",
        case: "tick-planar7",
        check: Check::Time(6.0, 20.0),
    },
    Target {
        words: "tick, exo18, double support: at most 1/3 of TSID, p99 too",
        case: "tick-double",
        check: Check::Ratio("TSID", 1.0 / 3.0, Some(1.0 / 3.0)),
    },
    Target {
        words: "tick, exo18, single support: at most 1/3 of TSID, p99 too",
        case: "tick-single",
        check: Check::Ratio("TSID", 1.0 / 3.0, Some(1.0 / 3.0)),
    },
    Target {
        words: "contact step, planar humanoid: at most 1/2 of MuJoCo",
        case: "contact-planar7",
        check: Check::Ratio("MuJoCo", 0.5, None),
    },
    Target {
        words: "contact step, exo18: at most 1/2 of MuJoCo",
        case: "contact-exo18",
        check: Check::Ratio("MuJoCo", 0.5, None),
    },
    Target {
        words: "closed loop, thesis's walk: at least 120 times real time",
        case: "loop-walk",
        check: Check::RealTime(120.0),
    },
    Target {
        words: "closed loop, exo18: at least 25 times real time",
        case: "loop-exo18",
        check: Check::RealTime(25.0),
    },
    Target {
        words: "closed loop, exo18: at most 1/3 of TSID + MuJoCo",
        case: "loop-exo18",
        check: Check::Ratio("TSID + MuJoCo", 1.0 / 3.0, None),
    },
];

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
- **Dynamics.** Ours computes the Jacobian and its bias of each contact point (8 of exo18), the torso's, energies and the
  gravity vector besides. Pinocchio computes one 6 × n Jacobian a foot; the contact points' rows that are compared follow from
  them outside the clock.
- **Solvers.** The clock runs from matrices in memory, each in the form that its solver wants, to the solution, with setup or
  update. DAQP, ProxQP and OSQP start warm; DAQP eliminates
  the equalities where that is faster (`eq_reduction`: slack form, 48 variables) and has an iteration limit of 1000; quadprog, eiquadprog, PIQP and Clarabel have no warm start. Rows that no program
  of a series uses are left out for everyone. ProxQP and OSQP have a tolerance of 1e-6, the rest their defaults. OSQP's time is that of its own clock, without Python. The
  slack program's cost is not strictly convex, which Goldfarb and Idnani's method needs: quadprog and eiquadprog cannot solve it, ours adds the
  equalities to it. A failure is what the solver calls unsolved, what is no number, or what misses a row or bound by more
  than 1e-3 of 1 + its size.
- **Control ticks.** Each side formulates its own program for the same robot: TSID tracks centre of mass, posture and waist
  with two six-dimensional contacts of four corner forces and torque bounds; legwork adds momentum, joint-limit braking and
  the step state machine, and names the limits that are active. Both include the dynamics.
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
    text.push_str(&targets(measured));
    text.push_str(&tables(measured));
    text.push_str(COMPARABLE);
    text.push_str("\n## Machine and versions\n\n| | |\n|---|---|\n");
    for (what, which) in machine {
        let _ = writeln!(text, "| {what} | {} |", which.replace('|', "\\|"));
    }
    text
}

fn targets(measured: &[Measured]) -> String {
    let mut text = "| target | reached | |\n|---|---|---|\n".to_owned();
    for target in &TARGETS {
        let rows = measured.iter().find(|case| case.case.key == target.case).map_or(&[][..], |case| &case.rows);
        let (reached, met) = outcome(rows, &target.check);
        let _ = writeln!(text, "| {} | {reached} | {met} |", target.words);
    }
    text
}

fn outcome(rows: &[Row], check: &Check) -> (String, &'static str) {
    let find = |name: &str| rows.iter().find(|row| row.name == name).and_then(|row| row.figures.as_ref().ok());
    let Some(ours) = find("legwork") else { return ("not measured".to_owned(), "") };
    let word = |met: bool| if met { "met" } else { "missed" };
    match check {
        Check::Time(median, p999) => {
            let reached = format!("{} µs, p99.9 {} µs", microseconds(ours.median), microseconds(ours.p999));
            (reached, word(ours.median <= *median && ours.p999 < *p999))
        }
        Check::RealTime(least) => {
            let times = real_time(ours);
            (format!("{times:.0} times real time"), word(times >= *least))
        }
        Check::Ratio(peer, median, p99) => {
            let Some(theirs) = find(peer) else { return (format!("{peer} was not measured"), "") };
            let (of_median, of_p99) = (ours.median / theirs.median, ours.p99 / theirs.p99);
            let met = of_median <= *median && p99.is_none_or(|most| of_p99 <= most);
            (format!("{of_median:.2} of the median, {of_p99:.2} of p99"), word(met))
        }
    }
}

/// A tick stands for a millisecond.
fn real_time(figures: &Figures) -> f64 {
    figures.count as f64 * 1e3 / figures.total
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
        if let (Some(ours), "loop") = (ours, case.case.group) {
            let _ = writeln!(text, "\nlegwork: {:.0} times real time, control and physics at 1 kHz.", real_time(ours));
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
        // The time of a wrong answer is no measure.
        Some(ours) if !is_ours && 2 * figures.failures < figures.count => {
            format!("{:.2}", ours.median / figures.median)
        }
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
