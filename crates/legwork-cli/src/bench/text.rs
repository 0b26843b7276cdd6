//! The tables of `bench` for people.

use super::Report;
use super::machine::Machine;
use super::samples::{Histogram, Statistics};
use super::scenario::{Measured, Threads};
use crate::output::folded;

/// Columns of the longest bar of a histogram.
const BAR: f64 = 40.0;

/// Everything that was measured.
pub(super) fn text(report: &Report) -> String {
    let parts = std::iter::once(machine(&report.machine)).chain(report.scenarios.iter().map(scenario));
    parts.collect::<Vec<_>>().join("\n\n")
}

fn machine(machine: &Machine) -> String {
    let processor = machine.processor.as_deref().unwrap_or("unknown processor");
    let load = machine.load.map_or(String::new(), |load| format!(", load {load}"));
    let Machine { legwork, rustc, target, opt_level, clock_ns, cores, .. } = machine;
    folded(
        &format!(
            "{processor}, {cores} cores{load}; legwork {legwork} by {rustc} for {target}, opt-level {opt_level}; \
             reading the clock takes {clock_ns:.0} ns, which is taken off"
        ),
        2,
    )
}

fn scenario(measured: &Measured) -> String {
    let Measured { scenario, dofs, contacts, variables, rows, ticks, steps, rounds, .. } = measured;
    let head = format!(
        "{scenario}: {dofs} degrees of freedom, {contacts} contact points, a program of {variables} variables and {rows} \
         rows; {ticks} ticks, {steps} steps, medians of {rounds} rounds"
    );
    let mut text = folded(&head, 2);
    text += &format!(
        "\n  {:<22}{:>9}{:>9}{:>9}{:>9}{:>9}{:>8}",
        "[µs]", "median", "p99", "p99.9", "max", "slowest", "share"
    );
    text += &line("control tick", &measured.tick, None);
    for part in &measured.parts {
        text += &line(&format!("  {}", part.part), &part.durations, Some(part.share));
    }
    let together: f64 = measured.parts.iter().map(|part| part.share).sum();
    text += &format!("\n  {:<67}{:>6.0} %", "  parts together", 100.0 * together);
    text += &line("simulation step", &measured.step, None);
    text += &line("  random torques", &measured.step_under_random_torques, None);

    let solver = &measured.solver;
    text += &format!("\n  {:<22}{:>9}{:>9}", "a tick", "mean", "max");
    text += &format!("\n  {:<22}{:>9.3}{:>9}", "  solver's iterations", solver.iterations_mean, solver.iterations_max);
    text += &format!(
        "\n  {:<22}{:>9.3}{:>9}",
        "  limits met or left", solver.limits_changed_mean, solver.limits_changed_max
    );
    text += &format!(
        "\n  {:<22}{:>9.3}   ({} ticks with a fallback)",
        "  programs", solver.programs_mean, solver.fallbacks
    );

    let rollout = &measured.rollout;
    text += &format!(
        "\n  rollout of {} s: {:.1} ms (at most {:.1}), {:.0} times real time",
        rollout.simulated_s,
        1e3 * rollout.median_s,
        1e3 * rollout.max_s,
        rollout.times_real_time
    );
    text += &format!("\n  {:<22}{:>12}{:>10}{:>10}", "threads", "rollouts/s", "speed-up", "steps/s");
    for row in &measured.threads {
        let Threads { threads, rollouts_per_s, speed_up, steps_per_s } = row;
        text += &format!("\n  {threads:<22}{rollouts_per_s:>12.1}{speed_up:>10.2}{steps_per_s:>10.0}");
    }
    text + "\n  control tick [µs], all rounds" + &histogram(&measured.tick_histogram)
}

fn line(name: &str, times: &Statistics, share: Option<f64>) -> String {
    let values = [times.median_us, times.p99_us, times.p999_us, times.max_us, times.slowest_input_us];
    let mut line = format!("\n  {name:<22}");
    values.iter().for_each(|&value| line += &format!("{:>9}", digits(value)));
    line + &share.map_or(String::new(), |share| format!("{:>6.0} %", 100.0 * share))
}

/// With three digits that count.
fn digits(value: f64) -> String {
    let decimals = if value < 10.0 { 2 } else { usize::from(value < 100.0) };
    format!("{value:.decimals$}")
}

/// A bar a bin, in eighths of a column.
fn histogram(histogram: &Histogram) -> String {
    let largest = histogram.shares.iter().copied().fold(0.0, f64::max);
    let mut text = String::new();
    for (edges, &share) in histogram.edges_us.windows(2).zip(&histogram.shares) {
        let bar = bar(BAR * share / largest);
        let line = format!("\n  {:>7} to {:>6}{:>8.2} %  {bar}", digits(edges[0]), digits(edges[1]), 100.0 * share);
        text += line.trim_end();
    }
    text + &format!("\n  {:>17}{:>8.2} %", "more", 100.0 * histogram.above)
}

/// A bar of so many columns; what there is of something is seen, however little.
fn bar(columns: f64) -> String {
    const EIGHTHS: [&str; 8] = ["", "▏", "▎", "▍", "▌", "▋", "▊", "▉"];
    let eighths = (8.0 * columns).round().max(f64::from(u8::from(columns > 0.0))) as usize;
    "█".repeat(eighths / 8) + EIGHTHS[eighths % 8]
}

#[cfg(test)]
mod tests {
    use super::{bar, digits};

    #[test]
    fn bars_are_drawn_in_eighths_and_never_vanish() {
        assert_eq!([bar(0.0), bar(0.01), bar(0.5), bar(2.25)], ["", "▏", "▌", "██▎"]);
    }

    #[test]
    fn numbers_have_three_digits() {
        assert_eq!([0.123, 9.9, 12.34, 456.7].map(digits), ["0.12", "9.90", "12.3", "457"]);
    }
}
