//! What was to be reached, and whether it was.

use std::fmt::Write;

use super::measure::{Figures, Measured, Row};
use super::page::microseconds;

/// What was to be reached: the target in words, its case, and how to tell.
struct Target {
    words: &'static str,
    case: &'static str,
    check: Check,
}

enum Check {
    /// Quantiles of ours over those of the peer: median, p99; each at most.
    Ratio(&'static str, f64, Option<f64>),
    /// The same quantiles, of which nothing was asked.
    Beside(&'static str),
    /// Ours alone [µs]: median, p99.9.
    Time(f64, f64),
    /// Ours alone [µs]: p99, at most.
    Tail(f64),
    /// Times real time, at 1 kHz: at least.
    RealTime(f64),
}

const TARGETS: [Target; 16] = [
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
        words: "48 variables, a humanoid that falls among them: p99 at most 60 µs",
        case: "qp-48",
        check: Check::Tail(60.0),
    },
    Target {
        words: "48 variables, before it falls: p99 at most 60 µs",
        case: "qp-48-standing",
        check: Check::Tail(60.0),
    },
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
    Target { words: "tick, exo18, single support: beside TSID", case: "tick-single", check: Check::Beside("TSID") },
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
        words: "contact step, exo18 under random torques: at most 1/2 of MuJoCo",
        case: "contact-random",
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

/// All targets as a table of the page.
pub(super) fn table(measured: &[Measured]) -> String {
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
    if !ours.is_a_measure() {
        return (format!("legwork fails {} of {}", ours.failures, ours.count), "missed");
    }
    let word = |met: bool| if met { "met" } else { "missed" };
    match check {
        Check::Time(median, p999) => {
            let reached = format!("{} µs, p99.9 {} µs", microseconds(ours.median), microseconds(ours.p999));
            (reached, word(ours.median <= *median && ours.p999 < *p999))
        }
        Check::Tail(p99) => (format!("{} µs", microseconds(ours.p99)), word(ours.p99 <= *p99)),
        Check::RealTime(least) => {
            let times = real_time(ours);
            (format!("{times:.0} times real time"), word(times >= *least))
        }
        Check::Ratio(peer, ..) | Check::Beside(peer) => {
            let Some(theirs) = find(peer) else { return (format!("{peer} was not measured"), "") };
            if !theirs.is_a_measure() {
                return (format!("{peer} fails {} of {}", theirs.failures, theirs.count), "");
            }
            let (of_median, of_p99) = (ours.median / theirs.median, ours.p99 / theirs.p99);
            let verdict = match check {
                Check::Ratio(_, median, p99) => word(of_median <= *median && p99.is_none_or(|most| of_p99 <= most)),
                _ => "no target",
            };
            (format!("{of_median:.2} of the median, {of_p99:.2} of p99"), verdict)
        }
    }
}

/// A tick stands for a millisecond.
pub(super) fn real_time(figures: &Figures) -> f64 {
    figures.count as f64 * 1e3 / figures.total
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(name: &str, median: f64, p99: f64, failures: usize) -> Row {
        let figures =
            Figures { median, p99, p999: p99, total: 100.0 * median, count: 100, failures, ..Figures::default() };
        Row { name: name.to_owned(), says: String::new(), figures: Ok(figures) }
    }

    fn verdict(rows: &[Row], check: &Check) -> &'static str {
        outcome(rows, check).1
    }

    #[test]
    fn a_ratio_is_met_where_both_quantiles_are() {
        let rows = [row("legwork", 2.0, 6.0, 0), row("other", 4.0, 8.0, 0)];
        assert_eq!(outcome(&rows, &Check::Ratio("other", 0.5, Some(0.75))).0, "0.50 of the median, 0.75 of p99");
        assert_eq!(verdict(&rows, &Check::Ratio("other", 0.5, Some(0.75))), "met");
        assert_eq!(verdict(&rows, &Check::Ratio("other", 0.5, Some(0.74))), "missed");
        assert_eq!(verdict(&rows, &Check::Ratio("other", 0.49, None)), "missed");
        assert_eq!(verdict(&rows, &Check::Ratio("other", 0.5, None)), "met");
    }

    #[test]
    fn a_figure_without_a_target_is_neither_met_nor_missed() {
        let rows = [row("legwork", 9.0, 9.0, 0), row("other", 4.0, 3.0, 0)];
        let (reached, verdict) = outcome(&rows, &Check::Beside("other"));
        assert_eq!((reached.as_str(), verdict), ("2.25 of the median, 3.00 of p99", "no target"));
    }

    #[test]
    fn who_fails_has_no_time() {
        let check = Check::Ratio("other", 0.5, None);
        let fallen = [row("legwork", 1.0, 1.0, 0), row("other", 4.0, 8.0, 100)];
        assert_eq!(outcome(&fallen, &check), ("other fails 100 of 100".to_owned(), ""));
        let ours = [row("legwork", 1.0, 1.0, 100), row("other", 4.0, 8.0, 0)];
        assert_eq!(outcome(&ours, &check), ("legwork fails 100 of 100".to_owned(), "missed"));
        assert_eq!(verdict(&ours, &Check::RealTime(1.0)), "missed");
    }

    #[test]
    fn what_was_not_measured_is_said() {
        assert_eq!(outcome(&[], &Check::Time(1.0, 1.0)), ("not measured".to_owned(), ""));
        let missing = Row { name: "other".to_owned(), says: String::new(), figures: Err("no compiler".to_owned()) };
        let rows = [row("legwork", 1.0, 1.0, 0), missing];
        assert_eq!(outcome(&rows, &Check::Ratio("other", 1.0, None)), ("other was not measured".to_owned(), ""));
    }

    #[test]
    fn times_of_our_own_have_their_bounds() {
        let rows = [row("legwork", 5.0, 20.0, 0)];
        assert_eq!(verdict(&rows, &Check::Time(5.0, 20.1)), "met");
        assert_eq!(verdict(&rows, &Check::Time(4.9, 20.1)), "missed");
        assert_eq!(verdict(&rows, &Check::Time(5.0, 20.0)), "missed");
        // 5 µs for each millisecond
        assert_eq!(outcome(&rows, &Check::RealTime(200.0)), ("200 times real time".to_owned(), "met"));
        assert_eq!(verdict(&rows, &Check::RealTime(201.0)), "missed");
    }

    #[test]
    fn every_target_names_a_case_and_a_peer_of_it() {
        let cases = super::super::cases::all();
        for target in &TARGETS {
            let case = cases.iter().find(|case| case.key == target.case).expect(target.words);
            if let Check::Ratio(peer, ..) | Check::Beside(peer) = target.check {
                assert!(case.peers.iter().any(|(name, _)| *name == peer), "{}", target.words);
            }
        }
    }
}
