//! The shape of a step: sinusoids in both directions. Thesis (4.1), (4.2)

use std::f64::consts::PI;

/// A coordinate with its first two time derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Value [m].
    pub value: f64,
    /// First derivative [m/s].
    pub rate: f64,
    /// Second derivative [m/s²].
    pub acceleration: f64,
}

/// Horizontal displacement at `t` [s] of a step of `length` [m] that takes `duration` [s]. Thesis (4.1)
pub fn forward(t: f64, duration: f64, length: f64) -> Motion {
    half_sine(t * PI / duration, PI / duration, length)
}

/// Height at `t` [s] of a step of `height` [m] that takes `duration` [s]. Thesis (4.2)
pub fn upward(t: f64, duration: f64, height: f64) -> Motion {
    half_sine(t * 2.0 * PI / duration, 2.0 * PI / duration, height)
}

/// `size/2 sin(phase - pi/2) + size/2`, whose phase moves at `rate` [rad/s].
fn half_sine(phase: f64, rate: f64, size: f64) -> Motion {
    let (sin, cos) = libm::sincos(phase - PI / 2.0);
    let half = 0.5 * size;
    Motion { value: half * sin + half, rate: half * rate * cos, acceleration: -half * rate * rate * sin }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn starts_and_lands_at_rest() {
        let (start, end) = (forward(0.0, 0.2, 0.6), forward(0.2, 0.2, 0.6));
        assert!(start.value.abs() < 1e-15 && (end.value - 0.6).abs() < 1e-15);
        assert!(start.rate.abs() < 1e-14 && end.rate.abs() < 1e-14);
        let (top, landed) = (upward(0.1, 0.2, 0.05), upward(0.2, 0.2, 0.05));
        assert!((top.value - 0.05).abs() < 1e-15 && landed.value.abs() < 1e-15);
        assert!(top.rate.abs() < 1e-14 && landed.rate.abs() < 1e-14);
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let e = 1e-5;
        for motion in [|t| forward(t, 0.225, 0.7), |t| upward(t, 0.225, 0.06)] {
            for t in [0.01, 0.1, 0.17] {
                let rate = (motion(t + e).value - motion(t - e).value) / (2.0 * e);
                let acceleration = (motion(t + e).rate - motion(t - e).rate) / (2.0 * e);
                assert!((rate - motion(t).rate).abs() < 1e-7);
                assert!((acceleration - motion(t).acceleration).abs() < 1e-5);
            }
        }
    }
}
