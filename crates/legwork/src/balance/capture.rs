//! How many steps it takes to come to a stop: N-step capturability of the linear inverted pendulum with feet of finite
//! length and a least time of a step (Koolen et al. 2012, "3D-LIPM with finite-sized foot").
//!
//! With the centre of pressure at p the XcoM obeys `ξ̇ = ω (ξ − p)`. It is held best at the foot's edge that it flees to,
//! then the next foot lands as soon and as far as it can. In the paper `d₀ = r`, `d_N = r + (l − r + d_{N−1}) e^{−ωT}`,
//! measured from the ankle, r from it to the edge. Measured from the edge, `e_N = d_N − r`, that is
//! `e₀ = 0`, `e_N = (l + e_{N−1}) e^{−ωT}`, whatever the foot.

use super::Point;
use super::support::along;

/// What a step may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepLimits {
    /// Farthest that a foot lands from the other, backward and forward [m].
    pub longest: [f64; 2],
    /// Shortest swing [s].
    pub swing_s: f64,
    /// Time from a landing to the next swing [s].
    pub double_support_s: f64,
}

/// A moment of a walk, as its capturability depends on it along one direction. In space that is the way out of the base of support
/// ([`super::support`]); there the region of a number of steps has no place outside of it that the steps could reach, but may have
/// places that they cannot: the steps to a stop are the least that may do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capture {
    /// The unit direction along which it is measured; x in the plane.
    pub way: Point,
    /// Eigenfrequency of the pendulum [1/s].
    pub omega: f64,
    /// Ends of the base of support, where the centre of pressure can be [m].
    pub support: [f64; 2],
    /// Ends of the feet that stand; further apart than those of the support where a foot stands on its toe [m].
    pub feet: [f64; 2],
    /// What a step may be.
    pub limits: StepLimits,
    /// Least time to the next landing [s].
    pub landing_s: f64,
}

impl StepLimits {
    /// What of the steps counts along a direction whose component along the walking direction is `share`.
    pub fn seen_along(&self, share: f64) -> Self {
        let [back, front] = self.longest;
        Self { longest: [-share, share].map(|share| (share * front).max(-share * back)), ..*self }
    }
}

impl Capture {
    /// The component of a place along the direction [m].
    pub fn along(&self, place: Point) -> f64 {
        along(self.way, place)
    }

    /// Ends of the places of the XcoM along the direction from which `steps` are enough [m]; with none, any number of steps.
    pub fn region(&self, steps: Option<u32>) -> [f64; 2] {
        if steps == Some(0) {
            return self.support;
        }
        let delayed = libm::exp(-self.omega * self.landing_s);
        std::array::from_fn(|side| {
            let sign = SIGNS[side];
            // Koolen et al. 2012: d_N of the support that there is, the first step after what is left of its time.
            let landed = self.feet[side] + sign * (self.limits.longest[side] + self.beyond(side, steps.map(|n| n - 1)));
            self.support[side] + (landed - self.support[side]) * delayed
        })
    }

    /// Steps that are needed with the XcoM at `xcom` along the direction [m]; none where no number of them is enough.
    pub fn steps(&self, xcom: f64) -> Option<u32> {
        let side = usize::from(xcom > self.support[1]);
        let sign = SIGNS[side];
        let out = sign * (xcom - self.support[side]);
        if out <= 0.0 {
            return Some(0);
        }
        // How far the XcoM is beyond the foot that lands first.
        let longest = self.limits.longest[side];
        let reached = sign * (self.feet[side] - self.support[side]) + longest;
        let beyond = out * libm::exp(self.omega * self.landing_s) - reached;
        if beyond <= 0.0 {
            return Some(1);
        }
        // The least n with e_n ≥ beyond.
        let decay = self.decay();
        let rest = 1.0 - beyond * (1.0 - decay) / (longest * decay);
        (rest > 0.0).then(|| 1 + (libm::log(rest) / libm::log(decay)).ceil() as u32)
    }

    /// `e_N`: how far the XcoM may be beyond a foot that has landed, `steps` before the last [m].
    fn beyond(&self, side: usize, steps: Option<u32>) -> f64 {
        let decay = self.decay();
        // The sum of l e^{−kωT} over k = 1..N; without end Koolen et al. 2012, d_∞
        let taken = steps.map_or(1.0, |n| 1.0 - decay.powi(n as i32));
        self.limits.longest[side] * decay / (1.0 - decay) * taken
    }

    fn decay(&self) -> f64 {
        libm::exp(-self.omega * (self.limits.swing_s + self.limits.double_support_s))
    }
}

/// Backward, forward.
const SIGNS: [f64; 2] = [-1.0, 1.0];

#[cfg(test)]
mod tests {
    use super::*;

    const OMEGA: f64 = 3.2;
    const LIMITS: StepLimits = StepLimits { longest: [0.3, 0.7], swing_s: 0.25, double_support_s: 0.1 };

    /// A foot from heel to toe, 0.2 s from the next landing.
    fn moment() -> Capture {
        Capture {
            way: [1.0, 0.0],
            omega: OMEGA,
            support: [-0.06, 0.18],
            feet: [-0.06, 0.18],
            limits: LIMITS,
            landing_s: 0.2,
        }
    }

    /// The pendulum itself, ẍ = ω² (x − p), for `time` [s]; `state` is place and velocity of its mass. Runge-Kutta
    fn swing(state: [f64; 2], cop: f64, time: f64) -> [f64; 2] {
        let rate = |[x, v]: [f64; 2]| [v, OMEGA * OMEGA * (x - cop)];
        let go = |a: [f64; 2], b: [f64; 2], h: f64| [a[0] + h * b[0], a[1] + h * b[1]];
        let (count, mut state) = (20, state);
        let h = time / f64::from(count);
        for _ in 0..count {
            let k1 = rate(state);
            let k2 = rate(go(state, k1, 0.5 * h));
            let k3 = rate(go(state, k2, 0.5 * h));
            let k4 = rate(go(state, k3, h));
            state = std::array::from_fn(|i| state[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        }
        state
    }

    /// Whether any of many ways to place centre of pressure and feet holds the pendulum above its foot after `steps`.
    fn can_stop(state: [f64; 2], foot: [f64; 2], wait: f64, steps: u32) -> bool {
        let xcom = state[0] + state[1] / OMEGA;
        if (foot[0]..=foot[1]).contains(&xcom) {
            return true;
        }
        if steps == 0 {
            return false;
        }
        let cops = [foot[0], 0.5 * (foot[0] + foot[1]), foot[1]];
        let strides = [-LIMITS.longest[0], -0.1, 0.2, LIMITS.longest[1]];
        [1.0, 1.2].into_iter().any(|late| {
            cops.into_iter().any(|cop| {
                let landed = swing(state, cop, late * wait);
                let least = LIMITS.swing_s + LIMITS.double_support_s;
                strides.into_iter().any(|stride| can_stop(landed, foot.map(|end| end + stride), least, steps - 1))
            })
        })
    }

    #[test]
    fn a_pendulum_can_stop_from_inside_of_a_region_and_not_from_outside() {
        let capture = moment();
        for steps in 0..=3 {
            for (end, sign) in capture.region(Some(steps)).into_iter().zip(SIGNS) {
                for x in [-0.2, 0.1] {
                    let at = |xcom: f64| [x, OMEGA * (xcom - x)];
                    let stops = |xcom| can_stop(at(xcom), capture.support, capture.landing_s, steps);
                    // The pendulum is integrated to 1e-6 of its way.
                    assert!(stops(end - 1e-4 * sign), "{steps} steps, inside of {end}");
                    assert!(!stops(end + 1e-4 * sign), "{steps} steps, outside of {end}");
                }
            }
        }
    }

    #[test]
    fn the_number_of_steps_is_that_of_the_smallest_region() {
        let rolling = Capture { support: [0.18, 0.18], landing_s: 0.0, ..moment() };
        for capture in [moment(), rolling] {
            for k in -2000..4000 {
                let xcom = 1e-3 * f64::from(k) + 1e-7;
                let within = |steps| (capture.region(steps)[0]..=capture.region(steps)[1]).contains(&xcom);
                match capture.steps(xcom) {
                    Some(steps) => {
                        assert!(within(Some(steps)), "{xcom} with {steps}");
                        assert!(steps == 0 || !within(Some(steps - 1)), "{xcom} with {steps}");
                    }
                    None => assert!(!within(None), "{xcom}"),
                }
            }
        }
        assert_eq!([0.1, 0.5, 0.6, 2.0].map(|xcom| moment().steps(xcom)), [Some(0), Some(1), Some(2), None]);
    }

    #[test]
    fn of_a_step_its_component_along_the_way_counts() {
        for (share, longest) in
            [(1.0, [0.3, 0.7]), (0.5, [0.15, 0.35]), (0.0, [0.0; 2]), (-0.5, [0.35, 0.15]), (-1.0, [0.7, 0.3])]
        {
            assert_eq!(LIMITS.seen_along(share), StepLimits { longest, ..LIMITS });
        }
    }

    #[test]
    fn regions_grow_to_that_of_any_number_of_steps() {
        let capture = moment();
        let ends: Vec<f64> = (0..60).map(|steps| capture.region(Some(steps))[1]).collect();
        assert!(ends[..20].windows(2).all(|pair| pair[0] < pair[1]));
        assert!((ends[59] - capture.region(None)[1]).abs() < 1e-12);
    }

    #[test]
    fn a_robot_that_takes_no_steps_has_its_support_and_no_more() {
        let limits = StepLimits { longest: [0.0; 2], swing_s: f64::INFINITY, double_support_s: 0.0 };
        let capture = Capture { limits, landing_s: f64::INFINITY, ..moment() };
        for steps in [Some(0), Some(1), Some(5), None] {
            assert_eq!(capture.region(steps), capture.support);
        }
        assert_eq!([0.1, 0.18, 0.19, -0.07].map(|xcom| capture.steps(xcom)), [Some(0), Some(0), None, None]);
    }
}
