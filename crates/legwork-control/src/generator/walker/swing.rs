//! The foot that swings: ankle and pitch by quintics that are planned again in each tick, the toe's height by a curve that
//! leaves the ground without speed or acceleration and meets it with a small speed.

/// A scalar with two derivatives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Value [m or rad].
    pub value: f64,
    /// First derivative.
    pub rate: f64,
    /// Second derivative.
    pub acceleration: f64,
}

impl From<[f64; 3]> for Motion {
    fn from([value, rate, acceleration]: [f64; 3]) -> Self {
        Self { value, rate, acceleration }
    }
}

impl Motion {
    /// At rest.
    pub(super) fn rest(value: f64) -> Self {
        Self { value, rate: 0.0, acceleration: 0.0 }
    }

    /// This motion `step` [s] later on the quintic that is at rest in `target` after `left` [s].
    pub(super) fn toward(self, target: f64, left: f64, step: f64) -> Self {
        if left <= step.max(1e-6) {
            return Self::rest(target);
        }
        let s = step / left;
        let [way, rate, acceleration] = [target - self.value, self.rate * left, self.acceleration * left * left];
        // x(s) = x0 + v s + a/2 s² + c3 s³ + c4 s⁴ + c5 s⁵, with x(1) = target and no speed or acceleration there
        let c3 = 10.0 * way - 6.0 * rate - 1.5 * acceleration;
        let c4 = -15.0 * way + 8.0 * rate + 1.5 * acceleration;
        let c5 = 6.0 * way - 3.0 * rate - 0.5 * acceleration;
        Self {
            value: self.value + s * (rate + s * (0.5 * acceleration + s * (c3 + s * (c4 + s * c5)))),
            rate: (rate + s * (acceleration + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)))) / left,
            acceleration: (acceleration + s * (6.0 * c3 + s * (12.0 * c4 + s * 20.0 * c5))) / (left * left),
        }
    }

    /// The targets that it can reach in `left` [s] without accelerating by more than `limit` [m/s²], as far as that is up
    /// to the target; the one that takes least where there is none.
    pub fn reach(self, limit: f64, left: f64) -> [f64; 2] {
        // The quintic's acceleration is linear in the way: α(s) way + β(s).
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        let [rate, acceleration] = [self.rate * left, self.acceleration * left * left];
        let most = limit * left * left;
        for s in [0.2113, 0.7887] {
            let of_way = 60.0 * s - 180.0 * s * s + 120.0 * s * s * s;
            let rest = acceleration * (1.0 - 9.0 * s + 18.0 * s * s - 10.0 * s * s * s)
                + rate * (-36.0 * s + 96.0 * s * s - 60.0 * s * s * s);
            let ends = [(-most - rest) / of_way, (most - rest) / of_way];
            low = f64::max(low, ends[0].min(ends[1]));
            high = f64::min(high, ends[0].max(ends[1]));
        }
        if low > high {
            let middle = 0.5 * (low + high);
            (low, high) = (middle, middle);
        }
        [self.value + low, self.value + high]
    }
}

/// Height above the ground of the toe [m] at the share `phase` of a swing of `duration` [s]: about `clearance` [m] at
/// most, with the speed `landing` [m/s] at its end.
pub(super) fn height(phase: f64, duration: f64, clearance: f64, landing: f64) -> Motion {
    if !(0.0..1.0).contains(&phase) {
        return Motion::default();
    }
    let (s, r) = (phase, 1.0 - phase);
    Motion {
        value: clearance * 64.0 * s * s * s * r * r * r + landing * duration * s * s * s * r,
        rate: clearance * 192.0 * s * s * r * r * (r - s) / duration + landing * s * s * (3.0 - 4.0 * s),
        acceleration: clearance * 384.0 * s * r * (r * r - 3.0 * s * r + s * s) / (duration * duration)
            + landing * 6.0 * s * (1.0 - 2.0 * s) / duration,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generator::stance::minimum_jerk;

    #[test]
    fn a_quintic_planned_again_and_again_arrives_at_rest() {
        let mut motion = Motion { value: 0.1, rate: 1.5, acceleration: -3.0 };
        let (step, duration) = (1e-3, 0.4);
        let whole = motion.toward(0.7, duration, 0.2);
        for k in 0..200 {
            motion = motion.toward(0.7, duration - f64::from(k) * step, step);
        }
        assert!((motion.value - whole.value).abs() < 1e-9 && (motion.rate - whole.rate).abs() < 1e-8);
        for k in 200..400 {
            motion = motion.toward(0.7, duration - f64::from(k) * step, step);
        }
        assert!((motion.value - 0.7).abs() < 1e-12 && motion.rate.abs() < 1e-9 && motion.acceleration.abs() < 1e-9);
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let e = 1e-6;
        let curves: [&dyn Fn(f64) -> Motion; 3] =
            [&|t| height(t / 0.5, 0.5, 0.04, 0.2), &|t| Motion::from(minimum_jerk(t, 0.0, 0.5)), &|t| {
                Motion { value: 0.1, rate: -0.5, acceleration: 2.0 }.toward(0.6, 0.5, t)
            }];
        for curve in curves {
            for time in [0.05, 0.2, 0.31, 0.45] {
                let (before, here, after) = (curve(time - e), curve(time), curve(time + e));
                assert!((here.rate - (after.value - before.value) / (2.0 * e)).abs() < 1e-7);
                assert!((here.acceleration - (after.rate - before.rate) / (2.0 * e)).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn what_is_within_reach_stays_within_the_acceleration() {
        let motion = Motion { value: 0.0, rate: 1.0, acceleration: 5.0 };
        let [low, high] = motion.reach(40.0, 0.3);
        for (target, within) in [(low, true), (high, true), (high + 0.2, false), (low - 0.2, false)] {
            let most = (1..300).map(|k| motion.toward(target, 0.3, f64::from(k) * 1e-3).acceleration.abs());
            let most = most.fold(0.0, f64::max);
            assert_eq!(most < 40.0 * 1.05, within, "{target}: {most}");
        }
    }
}
