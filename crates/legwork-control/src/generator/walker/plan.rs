//! The plan of one step: the centre of pressure as a piecewise linear function of time, and the XcoM that belongs to it.
//!
//! Everything is measured from the stance foot's ankle, and time from the step's begin. With `ẋi = ω (ξ - p)` and
//! `p = a + b t`, `ξ(t) = a + b t + b/ω + (ξ_T - a - b T - b/ω) e^{ω (t - T)}` (Englsberger, Ott and Albu-Schäffer 2015),
//! integrated backward from the step's end, where it is stable.

/// A centre of pressure that is linear between knots.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct CopPlan {
    /// Times of the knots [s]: touchdown, the rear foot's lift-off, the heel's lift-off, the step's end.
    pub(super) time: [f64; 4],
    /// Centre of pressure at the knots [m].
    pub(super) cop: [f64; 4],
}

/// The XcoM of a step, `end` at its end [m].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct StepPlan {
    pub(super) cop: CopPlan,
    /// Eigenfrequency of the pendulum [1/s].
    pub(super) omega: f64,
    /// XcoM at the step's end [m].
    pub(super) end: f64,
}

impl CopPlan {
    /// Centre of pressure at `time` [s]; before and after the step that of its ends.
    pub(super) fn at(&self, time: f64) -> f64 {
        let k = self.segment(time);
        let (begin, slope) = self.line(k);
        begin + slope * (time.clamp(self.time[0], self.time[3]) - self.time[k])
    }

    /// The segment that `time` is in.
    fn segment(&self, time: f64) -> usize {
        (1..3).rev().find(|&k| time >= self.time[k]).unwrap_or(0)
    }

    /// Begin and slope of a segment.
    fn line(&self, k: usize) -> (f64, f64) {
        let length = self.time[k + 1] - self.time[k];
        (self.cop[k], if length > 0.0 { (self.cop[k + 1] - self.cop[k]) / length } else { 0.0 })
    }

    /// XcoM at `time` [s] where it is `xcom` at `end` [s], a later time.
    pub(super) fn back(&self, omega: f64, mut xcom: f64, mut end: f64, time: f64) -> f64 {
        for k in (0..3).rev() {
            let from = self.time[k].max(time);
            if from >= end {
                continue;
            }
            let (begin, slope) = self.line(k);
            let steady = |t: f64| begin + slope * (t - self.time[k]) + slope / omega;
            xcom = steady(from) + (xcom - steady(end)) * libm::exp(omega * (from - end));
            end = from;
            if end <= time {
                break;
            }
        }
        xcom
    }

    /// XcoM at the step's begin of a gait that repeats itself every `length` [m].
    pub(super) fn offset(&self, omega: f64, length: f64) -> f64 {
        // ξ(0) = c + (ξ(0) + length) e^{-ω T}
        let decay = libm::exp(omega * (self.time[0] - self.time[3]));
        (self.back(omega, 0.0, self.time[3], self.time[0]) + length * decay) / (1.0 - decay)
    }
}

impl StepPlan {
    /// XcoM at `time` [s].
    pub(super) fn xcom(&self, time: f64) -> f64 {
        let end = self.cop.time[3];
        if time >= end {
            // Past its end the last centre of pressure stays.
            let cop = self.cop.cop[3];
            return cop + (self.end - cop) * libm::exp(self.omega * (time - end));
        }
        self.cop.back(self.omega, self.end, end, time.max(self.cop.time[0]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cop() -> CopPlan {
        CopPlan { time: [0.0, 0.1, 0.45, 0.55], cop: [-0.4, 0.0, 0.15, 0.18] }
    }

    /// `ξ̇ = ω (ξ - p)` by steps of Heun.
    fn forward(plan: &CopPlan, omega: f64, mut xcom: f64, [from, to]: [f64; 2]) -> f64 {
        let steps = 20_000;
        let step = (to - from) / f64::from(steps);
        for k in 0..steps {
            let time = from + f64::from(k) * step;
            let rate = omega * (xcom - plan.at(time));
            let next = omega * (xcom + step * rate - plan.at(time + step));
            xcom += 0.5 * step * (rate + next);
        }
        xcom
    }

    #[test]
    fn the_closed_form_is_what_the_pendulum_does() {
        let plan = StepPlan { cop: cop(), omega: 3.2, end: 0.7 };
        for time in [0.0, 0.05, 0.1, 0.3, 0.45, 0.5] {
            let end = forward(&plan.cop, plan.omega, plan.xcom(time), [time, 0.55]);
            assert!((end - 0.7).abs() < 1e-7, "from {time}: {end}");
        }
        assert_eq!(plan.xcom(0.55), 0.7);
        // Past its end the last centre of pressure stays.
        let late = forward(&plan.cop, plan.omega, 0.7, [0.55, 0.65]);
        assert!((plan.xcom(0.65) - late).abs() < 1e-7);
    }

    #[test]
    fn with_the_offset_a_gait_repeats_itself() {
        for (omega, length) in [(3.2, 0.55), (3.0, 0.1), (3.4, -0.2)] {
            let offset = cop().offset(omega, length);
            let end = forward(&cop(), omega, offset, [0.0, 0.55]);
            assert!((end - offset - length).abs() < 1e-7, "{end} after {offset}");
        }
    }

    #[test]
    fn the_centre_of_pressure_is_linear_between_its_knots() {
        let plan = cop();
        for (time, expected) in
            [(-1.0, -0.4), (0.0, -0.4), (0.05, -0.2), (0.1, 0.0), (0.275, 0.075), (0.5, 0.165), (2.0, 0.18)]
        {
            assert!((plan.at(time) - expected).abs() < 1e-12, "at {time}: {}", plan.at(time));
        }
        let step = CopPlan { time: [0.0, 0.1, 0.55, 0.55], cop: [0.0, 0.1, 0.2, 0.2] };
        assert_eq!(step.at(0.6), 0.2, "no heel-off: the last knots are one");
    }
}
