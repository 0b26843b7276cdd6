//! Whether the instability at high operating weights comes from the program or from the references. (7.1.2)
//!
//! Two experiments. The program alone: the states and references of a healthy run of the baseline are given to a
//! program with a high weight, whose loop stays open. If it gives up a task there already, the program is at fault.
//! The references: longer step times ask for less acceleration. If the robot stands with these where it fell, the
//! references are.

use super::{Entry, Question, Table, ending, replay_of};
use crate::case::{Case, Gains};
use crate::evidence::Evidence;
use crate::replay::Replay;
use crate::trial::{HIGH_WEIGHTS, STEP_TIMES, step_time, weight};
use legwork::settings::Setting;

/// A task counts as given up where the program misses by so much more of it than with the baseline's weight on the same
/// states: as a share of the robot's weight, or of the swing foot's acceleration.
const GIVEN_UP: f64 = 0.10;

/// The raised weights as settings.
pub(super) fn raised_weights() -> impl Iterator<Item = String> {
    HIGH_WEIGHTS.into_iter().flat_map(|(path, values)| values.map(|value| weight(path, value)))
}

/// The baselines, of which those that stand are replayed.
pub(super) fn cases() -> impl Iterator<Item = Case> {
    Case::all().filter(|case| case.gains == Gains::Baseline)
}

pub(super) fn question(evidence: &Evidence, replays: &[Replay]) -> Question {
    let mut replayed = Vec::new();
    for case in cases() {
        for sets in [Vec::new()].into_iter().chain(raised_weights().map(|set| vec![set])) {
            let Some(replay) = replay_of(replays, case.scenario(), &sets) else { continue };
            replayed.push(vec![
                case.scenario().into(),
                sets.first().map_or("baseline".to_owned(), |set| named(set)).into(),
                replay.weight_missed_fraction.into(),
                replay.momentum_missed_fraction.into(),
                replay.swing_foot_missed_fraction.into(),
                replay.stance_foot_missed_mps2.into(),
            ]);
        }
    }
    let mut closed = Vec::new();
    for case in cases() {
        let highest = HIGH_WEIGHTS.map(|(path, [_, highest])| vec![weight(path, highest)]);
        for own in [Vec::new()].into_iter().chain(highest) {
            let with = |duration| [own.clone(), vec![step_time(duration)]].concat();
            let name = own.first().map_or("baseline".to_owned(), |set| named(set));
            let mut row = vec![Entry::from(case.scenario()), name.into(), ending(evidence.trial(case, &own)).into()];
            row.extend(STEP_TIMES.map(|duration| Entry::from(ending(evidence.trial(case, &with(duration))))));
            closed.push(row);
        }
    }
    Question {
        id: "operating-weights",
        section: "7.1.2",
        asks: "Does the instability at high weights of the operating costs come from the program or from the \
               references?",
        method: "First, the states of the baseline's runs that stand are given to controllers with a high weight, \
                 without closing the loop, so that states and references are healthy and what differs is the program; \
                 what it misses of its tasks is taken. Second, the same weights in closed loop, with the step time of \
                 the reading and with longer ones, whose swings ask for less acceleration."
            .to_owned(),
        tables: vec![
            Table {
                title: "Open loop: what the program misses on healthy states and references",
                columns: vec![
                    ("scenario", ""),
                    ("weight", ""),
                    ("vertical force missing, share of the robot's weight", ""),
                    ("linear momentum missed, RMS, share of the robot's weight", ""),
                    ("swing foot's acceleration missed, RMS, share of what is asked", ""),
                    ("standing feet's acceleration, RMS", "m/s²"),
                ],
                rows: replayed,
            },
            Table {
                title: "Closed loop: endings by step time",
                columns: vec![("scenario", ""), ("weight", ""), ("own step time", ""), ("0.30 s", ""), ("0.35 s", "")],
                rows: closed,
            },
        ],
        answer: HIGH_WEIGHTS
            .iter()
            .enumerate()
            .map(|(p, _)| answer(evidence, replays, p))
            .collect::<Vec<_>>()
            .join(" "),
        has_times: false,
    }
}

/// `C_rho = 10` of `controller.weights.grf=10`.
fn named(set: &str) -> String {
    let (path, value) = set.split_once('=').unwrap_or((set, ""));
    format!("{} = {value}", Setting::find(path).map_or(path, |setting| setting.symbol))
}

/// What the highest level of a weight says.
fn answer(evidence: &Evidence, replays: &[Replay], parameter: usize) -> String {
    let (path, values) = HIGH_WEIGHTS[parameter];
    let sets = vec![weight(path, values[1])];
    let name = named(&sets[0]);
    let stands = |case: Case, sets: &[String]| evidence.trial(case, sets).stands();
    let healthy: Vec<Case> = cases().filter(|&case| stands(case, &[])).collect();
    let falls: Vec<Case> = healthy.iter().copied().filter(|&case| !stands(case, &sets)).collect();
    if falls.is_empty() {
        return format!("With {name} no run falls that stands with the baseline's weight.");
    }
    // Only a step time that the robot stands with the baseline's weight can tell.
    let tried = falls.iter().flat_map(|&case| STEP_TIMES.map(|duration| (case, step_time(duration))));
    let tried: Vec<(Case, String)> = tried.filter(|(case, set)| stands(*case, std::slice::from_ref(set))).collect();
    let saved = tried.iter().filter(|(case, set)| stands(*case, &[sets[0].clone(), set.clone()])).count();
    let missed = |of: fn(&Replay) -> f64| Missed::new(&falls, replays, &sets, of);
    let (momentum, foot) = (missed(|r| r.momentum_missed_fraction), missed(|r| r.swing_foot_missed_fraction));
    let (task, program) = match (momentum.is_given_up(), foot.is_given_up()) {
        (true, true) => ("gives up the momentum and the swing foot", true),
        (true, false) => ("gives up the momentum, not the swing foot", true),
        (false, true) => ("gives up the swing foot", true),
        (false, false) => ("gives up no task", false),
    };
    let verdict = match (program, saved) {
        (true, 0) => "This comes from the program",
        (true, _) => "This comes from the program, though longer steps help",
        (false, 0) => "This comes neither from the program alone nor from short steps",
        (false, _) => "This comes from the references",
    };
    format!(
        "With {name} {} of the {} baselines fall that stand with their own weight. {verdict}: on healthy states and \
         references it {task}. It misses {} of the robot's weight in linear momentum and {} of the swing foot's \
         acceleration. With longer steps, of which the baseline's own weight copes, it stands in {saved} of {} runs.",
        falls.len(),
        healthy.len(),
        momentum.words(),
        foot.words(),
        tried.len()
    )
}

/// What replays miss of a task with a high weight and with the baseline's own.
struct Missed(Vec<[f64; 2]>);

impl Missed {
    fn new(cases: &[Case], replays: &[Replay], sets: &[String], of: fn(&Replay) -> f64) -> Self {
        let share = |case: &Case, sets: &[String]| replay_of(replays, case.scenario(), sets).map(of);
        Self(cases.iter().filter_map(|case| Some([share(case, sets)?, share(case, &[])?])).collect())
    }

    /// In most of the runs.
    fn is_given_up(&self) -> bool {
        2 * self.0.iter().filter(|[high, own]| high - own >= GIVEN_UP).count() > self.0.len()
    }

    fn words(&self) -> String {
        let range = |of: usize| {
            let shares = || self.0.iter().map(|pair| pair[of]);
            let (least, most) = (shares().fold(f64::INFINITY, f64::min), shares().fold(0.0, f64::max));
            format!("{:.0} to {:.0} %", 100.0 * least, 100.0 * most)
        };
        format!("{} (with the baseline's weight {})", range(0), range(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_task_is_given_up_where_most_runs_miss_much_more_than_before() {
        assert!(Missed(vec![[0.4, 0.1], [0.5, 0.3], [0.35, 0.3]]).is_given_up());
        assert!(!Missed(vec![[0.4, 0.35], [0.5, 0.3], [0.35, 0.3]]).is_given_up());
        assert_eq!(Missed(vec![[0.4, 0.1], [0.5, 0.3]]).words(), "40 to 50 % (with the baseline's weight 10 to 30 %)");
        assert_eq!(named("controller.weights.grf=10"), "C_rho = 10");
    }
}
