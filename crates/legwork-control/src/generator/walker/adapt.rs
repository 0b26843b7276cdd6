//! Where and when the swinging foot lands, chosen anew in each tick (Khadiv et al. 2020, as a search over time).
//!
//! The XcoM is rolled forward under the law of the centre of pressure. For each time of landing there is one place from
//! which the gait goes on as it should; the swinging foot may not reach it. The choice is the one that costs least.

use super::plan::StepPlan;
use crate::settings::{Adaptation, WalkerSettings};

/// Time between two times of landing that are looked at, of a robot with a person's legs [s].
pub const GRID_S: f64 = 0.01;

/// What a landing is chosen by.
#[derive(Clone, Copy, Debug)]
pub(super) struct Choice {
    /// Nominal step length [m] and time [s].
    pub(super) length: f64,
    pub(super) duration: f64,
    /// Landing offset `[b0, b1]`: `b0 + b1 u` for a step of length u [m].
    pub(super) offset: [f64; 2],
    /// Weight of the time against the place [m²/s²], and of what the offset is missed by.
    pub(super) time_weight: f64,
    pub(super) offset_weight: f64,
    /// Earliest and latest time of landing [s].
    pub(super) earliest: f64,
    pub(super) latest: f64,
    /// Time between two times of landing that are looked at [s].
    pub(super) grid: f64,
    /// Whether the time may be chosen, too.
    pub(super) time_is_free: bool,
}

impl Choice {
    /// What the settings say, before the first step.
    pub(super) fn of(settings: &WalkerSettings) -> Self {
        Self {
            length: 0.0,
            duration: 0.0,
            offset: [0.0; 2],
            time_weight: settings.time_weight,
            offset_weight: settings.offset_weight,
            earliest: 0.0,
            latest: settings.longest_step_s,
            grid: settings.in_time(GRID_S),
            time_is_free: settings.adaptation == Adaptation::PlaceAndTime,
        }
    }
}

/// A landing: when after the step's begin [s], and where [m]; where the centre of mass is then [m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Landing {
    pub(super) time: f64,
    pub(super) place: f64,
    pub(super) com: f64,
}

/// The law of the centre of pressure: reference and feedback, within the foot.
pub(super) fn law(plan: &StepPlan, gain: f64, xcom: f64, reference: f64, time: f64, [low, high]: [f64; 2]) -> f64 {
    let wanted = plan.cop.at(time) + (1.0 + gain / plan.omega) * (xcom - reference);
    wanted.clamp(low, high)
}

/// The best landing, where centre of mass and XcoM are `com` and `xcom` at `now` [s]; `range(time)` are the ends of the
/// support, `reach(time, com)` those of the places that the foot can reach by then with the centre of mass there.
pub(super) fn best_landing(
    plan: &StepPlan,
    gain: f64,
    choice: &Choice,
    now: f64,
    [mut com, mut xcom]: [f64; 2],
    range: impl Fn(f64) -> [f64; 2],
    reach: impl Fn(f64, f64) -> [f64; 2],
) -> Landing {
    let mut best = Landing { time: plan.cop.time[3], place: choice.length, com };
    let mut least = f64::INFINITY;
    let grid = choice.grid;
    let growth = libm::exp(plan.omega * grid);
    let mut time = now;
    // Landings are looked at on a grid that does not move with the present.
    let mut next = ((now / grid).floor() + 1.0) * grid;
    if !choice.time_is_free {
        next = plan.cop.time[3];
    }
    loop {
        let mut cop_time = time;
        while next - cop_time > 1e-9 {
            let step = grid.min(next - cop_time);
            let cop = law(plan, gain, xcom, plan.xcom(cop_time), cop_time, range(cop_time));
            let factor = if step == grid { growth } else { libm::exp(plan.omega * step) };
            // ẋ = ω (ξ - x), too
            let half = 0.5 * (xcom - cop);
            com = cop + half * factor + (com - cop - half) / factor;
            xcom = cop + 2.0 * half * factor;
            cop_time += step;
        }
        time = next;
        // Later ones cost more by their time alone.
        let late = time - choice.duration;
        if late > 0.0 && choice.time_weight * late * late >= least {
            return best;
        }
        if time >= choice.earliest - 1e-9 || !choice.time_is_free {
            let [low, high] = reach(time, com);
            let wanted = (xcom - choice.offset[0]) / (1.0 + choice.offset[1]);
            let place = wanted.clamp(low, high);
            let missed = xcom - place - choice.offset[0] - choice.offset[1] * place;
            let far = place - choice.length;
            let cost = far * far + choice.time_weight * late * late + choice.offset_weight * missed * missed;
            if cost < least {
                (least, best) = (cost, Landing { time, place, com });
            }
        }
        next += grid;
        if next > choice.latest || !choice.time_is_free {
            return best;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::plan::CopPlan;
    use super::*;

    const OMEGA: f64 = 3.2;
    const LENGTH: f64 = 0.5;

    fn nominal() -> (StepPlan, Choice) {
        let time = [0.0, 0.1, 0.4, 0.5];
        let after = |u: f64| CopPlan { time, cop: [0.18 - u, 0.0, 0.18, 0.18] };
        let end = LENGTH + after(LENGTH).offset(OMEGA, LENGTH);
        let at_zero = after(0.0).back(OMEGA, end, 0.5, 0.0);
        let offset = [at_zero, after(1.0).back(OMEGA, end, 0.5, 0.0) - at_zero];
        let choice = Choice {
            length: LENGTH,
            duration: 0.5,
            offset,
            time_weight: 0.5,
            offset_weight: 200.0,
            earliest: 0.3,
            latest: 1.1,
            grid: GRID_S,
            time_is_free: true,
        };
        (StepPlan { cop: after(LENGTH), omega: OMEGA, end }, choice)
    }

    fn foot(_time: f64) -> [f64; 2] {
        [-0.05, 0.18]
    }

    fn anywhere(_time: f64, _com: f64) -> [f64; 2] {
        [-1.0, 1.0]
    }

    fn landing(disturbance: f64, change: impl Fn(&mut Choice)) -> Landing {
        let (plan, mut choice) = nominal();
        change(&mut choice);
        best_landing(&plan, 3.0, &choice, 0.2, [0.0, plan.xcom(0.2) + disturbance], foot, anywhere)
    }

    #[test]
    fn an_undisturbed_step_stays_as_planned() {
        let Landing { time, place, .. } = landing(0.0, |_| {});
        // The centre of pressure is rolled forward in steps of the grid, of which this is the error.
        assert!((time - 0.5).abs() < GRID_S && (place - LENGTH).abs() < 0.02, "{time} s, {place} m");
    }

    #[test]
    fn a_push_lengthens_and_hastens_the_step() {
        let (calm, pushed, held) = (landing(0.0, |_| {}), landing(0.1, |_| {}), landing(-0.1, |_| {}));
        assert!(pushed.place > calm.place && pushed.time < calm.time - GRID_S, "{pushed:?}");
        assert!(held.place < calm.place && held.time > calm.time + GRID_S, "{held:?}");
    }

    #[test]
    fn with_the_time_fixed_only_the_place_changes() {
        let pushed = landing(0.1, |choice| choice.time_is_free = false);
        assert!((pushed.time - 0.5).abs() < 1e-9);
        assert!(pushed.place > landing(0.1, |_| {}).place, "a later landing has to be farther");
    }

    #[test]
    fn a_place_out_of_reach_is_not_chosen() {
        let (plan, choice) = nominal();
        let short = |_time: f64, _com: f64| [0.0, 0.45];
        let chosen = best_landing(&plan, 3.0, &choice, 0.2, [0.0, plan.xcom(0.2) + 0.2], foot, short);
        assert!(chosen.place <= 0.45 && chosen.time < 0.5, "{chosen:?}");
        let leg = |_time: f64, com: f64| [com - 0.2, com + 0.2];
        let chosen = best_landing(&plan, 3.0, &choice, 0.2, [0.0, plan.xcom(0.2) + 0.2], foot, leg);
        assert!((chosen.place - chosen.com - 0.2).abs() < 1e-12, "as far as the leg reaches: {chosen:?}");
    }

    #[test]
    fn the_centre_of_mass_is_rolled_forward_as_a_pendulum() {
        let (plan, mut choice) = nominal();
        choice.time_is_free = false;
        let (com, xcom, cop, left) = (-0.02, 0.3, 0.05, 0.3);
        let chosen = best_landing(&plan, 3.0, &choice, 0.2, [com, xcom], |_| [cop; 2], anywhere);
        let (sinh, cosh) = (libm::sinh(OMEGA * left), libm::cosh(OMEGA * left));
        let expected = cop + (com - cop) * cosh + (xcom - com) * sinh;
        assert!((chosen.com - expected).abs() < 1e-12, "{} and {expected}", chosen.com);
    }
}
