//! `legwork compare`: two robots at the same speeds and under the same pushes, beside a person.

mod text;

use std::path::Path;
use std::process::ExitCode;

use legwork::error::Error;
use legwork::scenario::CommandedSpeed;
use legwork_report::comparison::{self, Pushes, Report, Robot, Strike};
use legwork_study::Base;
use legwork_study::comparison::{Gait, PERSON};
use legwork_study::parallel::with_threads;
use legwork_study::robustness::{Cell, Plan, Robustness};
use legwork_study::sizing::{Pair, Sizing, Use};

use crate::args::CompareArgs;
use crate::limits::{load, speed_torque};
use crate::long_work::{Jobs, conclude, interrupted, listen_for_interrupt};
use crate::output::{Failure, Output, check_writable, say, warn, write_text};

/// Rollouts that a search for the largest impulse takes, about: what the progress counts by.
const ROLLOUTS: u64 = 15;

/// How much more than the largest demand an actuator should deliver, as a share.
const MARGIN: f64 = 0.2;

pub(crate) fn compare(options: &CompareArgs, output: &mut Output) -> Result<ExitCode, Failure> {
    let walkers = [Walker::new(&options.first, options)?, Walker::new(&options.second, options)?];
    if let Some(path) = &options.report {
        if [&options.first, &options.second].into_iter().any(|scenario| Path::new(scenario) == path) {
            let problem = format!("found {}, which is a scenario's file; give another", path.display());
            return Err(Error::invalid("--report", problem).into());
        }
        check_writable(path)?;
    }
    listen_for_interrupt();
    let report = with_threads(options.threads.map(usize::from), || report(options, &walkers))??;
    if let Some(doubts) = report.doubts() {
        warn(&doubts);
    }
    let words = (!options.json).then_some(text::text as fn(&Report) -> String);
    conclude(output, &report, words, report.interrupted, || {
        let Some(path) = &options.report else { return Ok(()) };
        write_text(path, &comparison::page(&report).html)?;
        say(&format!("report: {}", path.display()));
        Ok(())
    })
}

/// A scenario that walks.
struct Walker {
    base: Base,
    commanded: CommandedSpeed,
}

impl Walker {
    fn new(name: &str, options: &CompareArgs) -> Result<Self, Error> {
        let base = load(name, &options.sets)?;
        let commanded = base.walks()?;
        Ok(Self { base, commanded })
    }

    fn robustness(&self, speed_mps: f64, quick: bool) -> Result<Robustness, Error> {
        let base = self.base.at_speed(self.commanded, speed_mps)?;
        let plan = Plan::new(2, if quick { 2 } else { 10 });
        let search = if quick { plan.search.quick() } else { plan.search };
        Robustness::new(&base, &base, Plan { search, ..plan }, interrupted)
    }

    fn robot(&self, gaits: Vec<Gait>, pushes: Option<Pushes>, map: Vec<Pair>) -> Robot {
        let model = &self.base.variant().model;
        let uses: Vec<Use> = gaits.iter().filter_map(|gait| gait.used.clone()).collect();
        Robot {
            scenario: self.base.name().to_owned(),
            mass_kg: model.total_mass(),
            point_feet: model.contacts.len() == model.feet.len(),
            gaits,
            pushes,
            sizing: Sizing::new(uses, MARGIN),
            map,
        }
    }
}

/// Finds everything out.
fn report(options: &CompareArgs, walkers: &[Walker; 2]) -> Result<Report, Error> {
    let (speeds, quick) = (&options.speeds, options.quick);
    let maps = [speed_torque(&walkers[0].base, quick)?, speed_torque(&walkers[1].base, quick)?];
    let cells = 2 * (1 + if quick { 2 } else { 10 });
    let rollouts = maps.iter().map(|map| (speeds.len() + map.cells()) as u64 + cells * ROLLOUTS).sum();
    let work = Jobs::new("compare", rollouts);

    let gaits = walkers.each_ref().map(|walker| {
        work.all(speeds.len(), 1, |index| Gait::of(&walker.base, walker.commanded, speeds[index], interrupted))
    });
    let walked = |speed: f64| gaits.iter().all(|all| all.iter().any(|g| g.speed_mps == speed && g.failure.is_none()));
    let mut pushes = [None, None];
    if let Some(&speed) = speeds.iter().find(|&&speed| walked(speed)) {
        for (walker, pushes) in walkers.iter().zip(&mut pushes) {
            let all = walker.robustness(speed, quick)?;
            let found = work.all(all.cells(), ROLLOUTS, |index| all.answer(index, interrupted));
            let mass = walker.base.variant().model.total_mass();
            let strikes = found.into_iter().map(|cell| strike(cell, mass)).collect();
            *pushes = Some(Pushes { speed_mps: speed, stride: all.stride, strikes });
        }
    }
    let maps = maps.map(|map| work.all(map.cells(), 1, |index| map.answer(index, interrupted)));
    work.finish();
    let found = walkers.iter().zip(gaits).zip(pushes).zip(maps);
    let robots = found.map(|(((walker, gaits), pushes), map)| walker.robot(gaits, pushes, map)).collect();
    Ok(Report { robots, person: PERSON, quick, interrupted: interrupted() })
}

/// An answer per kilogram as an impulse.
fn strike(cell: Cell, mass_kg: f64) -> Strike {
    Strike {
        phase: cell.phase,
        direction_deg: cell.direction_deg,
        impulse_ns: cell.found.value.map(|value| value * mass_kg),
        force_n: cell.found.force_n,
        reason_beyond: cell.found.reason_beyond,
        violations: cell.found.violations,
    }
}
