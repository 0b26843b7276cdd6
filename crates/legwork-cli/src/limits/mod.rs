//! `legwork limits`: how far things can go, and what the actuators must deliver.

mod files;
pub(crate) mod text;

use std::process::ExitCode;

use legwork::error::Error;
use legwork_report::envelope::{Report, RobustnessMap};
use legwork_study::limits::{self, Question};
use legwork_study::parallel::with_threads;
use legwork_study::robustness::{Plan, Robustness};
use legwork_study::sizing::{Sizing, SpeedTorque, Use};
use legwork_study::{Base, rollout};

use crate::args::{LimitsArgs, Part};
use crate::long_work::{Jobs, conclude, interrupted, listen_for_interrupt};
use crate::output::{Failure, Output, say, warn};

/// Rollouts that an answer and a cell of the robustness map take, about: what the progress counts by.
const ROLLOUTS: (u64, u64) = (55, 15);

pub(crate) fn limits(options: &LimitsArgs, output: &mut Output) -> Result<ExitCode, Failure> {
    let study = Study::new(options)?;
    if let Some(folder) = &options.out {
        files::check(folder)?;
    }
    listen_for_interrupt();
    let report = with_threads(options.threads.map(usize::from), || study.report())??;
    if let Some(doubts) = report.doubts() {
        warn(&doubts);
    }
    let words = (!options.json).then_some(text::text as fn(&Report) -> String);
    conclude(output, &report, words, report.interrupted, || {
        let Some(folder) = &options.out else { return Ok(()) };
        files::write(&report, folder)?;
        say(&format!("report: {}", folder.join("report.html").display()));
        Ok(())
    })
}

/// What is to be found out.
struct Study<'a> {
    options: &'a LimitsArgs,
    walk: Base,
    push: Base,
}

impl<'a> Study<'a> {
    fn new(options: &'a LimitsArgs) -> Result<Self, Error> {
        let of_a_push = |set: &String| set.starts_with("pushes.");
        let for_walk: Vec<String> = options.sets.iter().filter(|set| !of_a_push(set)).cloned().collect();
        let walk = load(&options.walk, &for_walk)?;
        let study = Self { options, walk, push: load(&options.push, &options.sets)? };
        // Wrong scenarios are found before anything runs.
        if study.asks(Part::Limits) {
            study.questions()?;
        }
        if study.asks(Part::Map) {
            study.map()?;
        }
        Ok(study)
    }

    fn asks(&self, part: Part) -> bool {
        self.options.only.is_empty() || self.options.only.contains(&part)
    }

    fn questions(&self) -> Result<Vec<Question<'_>>, Error> {
        let mut questions = limits::of_walk(&self.walk)?;
        questions.extend(limits::of_push(&self.push)?);
        if self.options.quick {
            questions.iter_mut().for_each(|question| question.search = question.search.quick());
        }
        Ok(questions)
    }

    fn plan(&self) -> Plan {
        if self.options.quick {
            let plan = Plan::new(4, 2);
            Plan { search: plan.search.quick(), ..plan }
        } else {
            Plan::new(8, 5)
        }
    }

    fn map(&self) -> Result<SpeedTorque<'_>, Error> {
        speed_torque(&self.walk, self.options.quick)
    }

    /// Finds everything out that was asked for.
    fn report(&self) -> Result<Report, Error> {
        let asked = |part| self.asks(part);
        let questions = if asked(Part::Limits) { Some(self.questions()?) } else { None };
        let robustness = asked(Part::Robustness)
            .then(|| Robustness::new(&self.walk, &self.push, self.plan(), interrupted))
            .transpose()?;
        let map = if asked(Part::Map) { Some(self.map()?) } else { None };
        let rollouts = questions.as_ref().map_or(0, |all| all.len() as u64 * ROLLOUTS.0)
            + robustness.as_ref().map_or(0, |all| all.cells() as u64 * ROLLOUTS.1)
            + map.as_ref().map_or(0, |all| all.cells() as u64);

        let work = Jobs::new("limits", rollouts);
        let sizing = if asked(Part::Sizing) { Some(self.sizing()?) } else { None };
        let map = map.map(|all| work.all(all.cells(), 1, |index| all.answer(index, interrupted)));
        let limits = questions.map(|all| work.all(all.len(), ROLLOUTS.0, |index| all[index].answer(interrupted)));
        let robustness = robustness.map(|all| RobustnessMap {
            stride: all.stride,
            cells: work.all(all.cells(), ROLLOUTS.1, |index| all.answer(index, interrupted)),
        });
        work.finish();
        let (walk, push) = (self.walk.name().to_owned(), self.push.name().to_owned());
        Ok(Report {
            walk,
            push,
            quick: self.options.quick,
            interrupted: interrupted(),
            limits,
            robustness,
            sizing,
            map,
        })
    }

    fn sizing(&self) -> Result<Sizing, Error> {
        let mut uses = Vec::new();
        for base in [&self.walk, &self.push] {
            let run = rollout::simulate(base.variant(), interrupted)?;
            if interrupted() {
                break;
            }
            uses.push(Use::of(&run));
        }
        Ok(Sizing::new(uses, self.options.margin))
    }
}

/// The map over speed and torque limit.
pub(crate) fn speed_torque(base: &Base, quick: bool) -> Result<SpeedTorque<'_>, Error> {
    if quick { SpeedTorque::new(base, 5, 5) } else { SpeedTorque::new(base, 13, 11) }
}

/// As [`Base::load`]; of several scenarios, an error of a `--set` names the one.
pub(crate) fn load(name: &str, sets: &[String]) -> Result<Base, Error> {
    Base::load(name, sets).map_err(|error| match error {
        Error::Invalid { place, problem } if place.starts_with("--set ") => {
            Error::invalid(format!("{place} of {name}"), problem)
        }
        other => other,
    })
}
