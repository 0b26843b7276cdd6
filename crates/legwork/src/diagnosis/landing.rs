//! Where the walker can land, and whether the XcoM is caught there: its capturability.
//!
//! With the centre of pressure at the end of the sole that the XcoM leaves, `ξ̇ = ω (ξ − p)`. A landing is as far ahead as the
//! swinging foot's acceleration, the leg and the longest step allow by then, the choice of `reference/walker/landing.rs`. After
//! it, steps that are as long and fast as they can be catch an XcoM up to e∞ past the end of the foot (Koolen et al. 2012).
//! Places are measured from the end of the sole, in the direction in which the XcoM leaves it.

use super::evidence::Evidence;
use crate::balance::{Meter, margin};
use crate::feet::Sole;
use crate::generator::walker::{GRID_S, Motion};
use crate::log::Field;
use crate::robot::Robot;
use crate::scenario::{Scenario, WalkerSettings};

/// Largest acceleration on a quintic from rest to rest of 1 m in 1 s [m/s²]: 10/√3.
const OF_QUINTIC: f64 = 5.7735;

/// The walker's settings for its robot, and what measures its balance.
#[derive(Debug)]
pub(super) struct WalkerSteps {
    settings: WalkerSettings,
    sole: Sole,
    meter: Meter,
}

/// A landing of the walker.
#[derive(Clone, Copy, Debug)]
pub(super) struct Landing {
    /// How far from the standing foot [m].
    pub(super) length: f64,
    /// How far the XcoM will then be past the end of the foot that landed [m].
    pub(super) short: f64,
    /// How far the XcoM is now beyond what that step and all later ones catch [m].
    pub(super) beyond: f64,
}

/// A moment of a walk.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moment {
    /// 1 where the XcoM leaves the feet forward, -1 where it does so backward.
    pub(super) way: f64,
    /// How far the XcoM is past the end of the sole [m].
    pub(super) past: f64,
    omega: f64,
    com: f64,
    standing: f64,
    swinging: Motion,
    /// How long the foot that is to land swings already, or how long until it does [s].
    elapsed: f64,
    wait: f64,
    /// Farthest that an ankle lands before the centre of mass where that is lowered as far as it may be [m].
    leg: f64,
    /// The longest step with the centre of mass as high as it is in walking [m].
    pub(super) upright_step: f64,
}

impl WalkerSteps {
    pub(super) fn of(scenario: &Scenario, model: &Robot) -> Self {
        Self {
            settings: scenario.fitted_reference(model).walker,
            sole: Sole::of(model),
            meter: Meter::new(scenario, model),
        }
    }

    /// Tick `i`, or in flight the last before it with a foot on the ground, if there is one.
    pub(super) fn moment(&self, evidence: &Evidence<'_>, i: usize) -> Option<Moment> {
        let log = evidence.log;
        let (tick, capture, xcom) = (0..=i).rev().find_map(|tick| {
            let measures = self.meter.at(log, tick);
            measures.capture.map(|capture| (tick, capture, measures.xcom[0]))
        })?;
        let [low, high] = capture.support;
        let (way, end) = if xcom - low > high - xcom { (1.0, high) } else { (-1.0, low) };
        let from_end = |x: f64| way * (x - end);
        let feet = [0, 1].map(|foot| from_end(evidence.foot_ahead(tick, foot)));
        let stretch = evidence.stretch(tick);
        let lasted = evidence.time(tick) - evidence.time(stretch.ticks.start);
        let (foot, swinging, elapsed, wait) = match stretch.foot {
            Some(foot) => {
                let [value, rate, acceleration] = [0, 1, 2].map(|k| evidence.goal_ahead(tick, foot, k));
                let goal = Motion { value: from_end(value), rate: way * rate, acceleration: way * acceleration };
                (foot, goal, lasted, 0.0)
            }
            // The foot behind is the next to swing.
            None => {
                let rear = usize::from(feet[1] < feet[0]);
                let wait = (self.settings.double_support_s - lasted).max(0.0);
                (rear, Motion { value: feet[rear], ..Motion::default() }, 0.0, wait)
            }
        };
        let speed = log.get(tick, Field::ComReference)[evidence.axes];
        Some(Moment {
            way,
            past: -margin(capture.support, xcom),
            omega: capture.omega,
            com: from_end(log.get(tick, Field::Com)[0]),
            standing: feet[1 - foot],
            swinging,
            elapsed,
            wait,
            leg: self.settings.farthest_ahead(speed, self.sole.ankle, self.settings.longest_drop_m),
            upright_step: 2.0 * self.settings.farthest_ahead(speed, self.sole.ankle, 0.0),
        })
    }

    /// The landing that leaves least of the XcoM uncaught.
    pub(super) fn best(&self, moment: &Moment) -> Landing {
        let settings = &self.settings;
        let longest = if moment.way > 0.0 { settings.longest_m } else { settings.longest_back_m };
        let (earliest, latest) = (settings.shortest_swing_s - moment.elapsed, settings.longest_step_s - moment.elapsed);
        let count = ((latest - earliest.max(0.0)) / GRID_S).max(0.0) as usize;
        let landings = (0..=count).map(|k| self.landing(moment, earliest.max(GRID_S) + k as f64 * GRID_S, longest));
        let least = |best: Landing, next: Landing| if next.beyond < best.beyond { next } else { best };
        landings.reduce(least).expect("a landing at the earliest time")
    }

    /// The farthest landing after another `swing` [s].
    fn landing(&self, moment: &Moment, swing: f64, longest: f64) -> Landing {
        let settings = &self.settings;
        let growth = libm::exp(moment.omega * (moment.wait + swing));
        let half = 0.5 * moment.past;
        let com = half * growth + (moment.com - half) / growth; // ẋ = ω (ξ − x)
        let [_, foot] = moment.swinging.reach(settings.swing_acceleration_mps2, swing);
        let leg = com + moment.leg + moment.way * self.sole.middle();
        let place = foot.min(leg).min(moment.standing + longest);
        let short = moment.past * growth - (place + 0.5 * (self.sole.toe - self.sole.heel));
        let beyond = (short - self.caught_later(moment.omega, longest)) / growth;
        Landing { length: place - moment.standing, short, beyond }
    }

    /// `e_∞ = l e^{−ωT} / (1 − e^{−ωT})`: how far past the end of a foot that landed steps of length l catch the XcoM [m]; the
    /// foot swings twice as far. Koolen et al. 2012, "3D-LIPM with finite-sized foot"
    fn caught_later(&self, omega: f64, longest: f64) -> f64 {
        let settings = &self.settings;
        let swing = libm::sqrt(OF_QUINTIC * 2.0 * longest / settings.swing_acceleration_mps2);
        let decay = libm::exp(-omega * (settings.double_support_s + swing.max(settings.shortest_swing_s)));
        longest * decay / (1.0 - decay)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{library, scenario_file};

    fn walker() -> WalkerSteps {
        let scenario = scenario_file::load("feet-walk", &[]).expect("a built-in scenario").scenario;
        let model = library::load_model(&scenario.model, None).expect("a built-in model");
        WalkerSteps::of(&scenario, &model)
    }

    #[test]
    fn what_later_steps_catch_stays_in_reach_of_them_and_more_runs_away() {
        let (walker, omega, longest) = (walker(), 3.2, 0.9);
        let swing = libm::sqrt(10.0 / libm::sqrt(3.0) * 2.0 * longest / walker.settings.swing_acceleration_mps2);
        let growth = libm::exp(omega * (walker.settings.double_support_s + swing));
        let bound = walker.caught_later(omega, longest);
        for (start, stays) in [(bound - 1e-3, true), (bound + 1e-3, false)] {
            // With the centre of pressure at the toe, past which the XcoM is; then the next foot lands.
            let past = (0..20).fold(start, |past, _| past * growth - longest);
            assert_eq!(past < bound, stays, "{start}: {past}");
        }
    }

    #[test]
    fn a_landing_is_as_far_as_the_nearest_of_foot_leg_and_longest_step() {
        let walker = walker();
        let moment = Moment {
            way: 1.0,
            past: 0.3,
            omega: 3.2,
            com: -0.1,
            standing: -0.125,
            swinging: Motion { value: -0.625, ..Motion::default() },
            elapsed: 0.0,
            wait: 0.0,
            leg: 0.45,
            upright_step: 0.5,
        };
        // From rest a quintic goes a t² / 5.7735 far, here in the shortest swing.
        let foot = walker.landing(&moment, 0.2, 1.1);
        let swing = walker.settings.swing_acceleration_mps2;
        assert!((foot.length - (swing * 0.04 / 5.7735 - 0.5)).abs() < 1e-4, "{foot:?}");
        // Later the leg ends it, before a centre of mass that the pendulum has carried on.
        let (late, leg) = (0.4, walker.landing(&moment, 0.4, 5.0));
        let growth = libm::exp(3.2 * late);
        let com = 0.15 * growth - 0.25 / growth;
        assert!((leg.length - (com + 0.45 + 0.06 + 0.125)).abs() < 1e-12, "{leg:?}");
        assert!((leg.short - (0.3 * growth - (leg.length - 0.125) - 0.125)).abs() < 1e-12, "{leg:?}");
        assert_eq!(walker.landing(&moment, late, 0.7).length, 0.7);
        let best = walker.best(&moment);
        assert!((0..90).all(|k| walker.landing(&moment, 0.2 + 0.01 * f64::from(k), 1.1).beyond >= best.beyond));
    }
}
