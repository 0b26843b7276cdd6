//! The extrapolated centre of mass of the linear inverted pendulum. Thesis (2.4), (2.5); Hof 2005.

/// A pendulum is no shorter than this [m].
pub const SHORTEST: f64 = 0.1;

/// Eigenfrequency of the pendulum [1/s] for `height` [m] of the CoM's reference over the ground (not less than
/// [`SHORTEST`]) and `gravity` [m/s²].
pub fn eigenfrequency(gravity: f64, height: f64) -> f64 {
    libm::sqrt(gravity / height.max(SHORTEST))
}

/// XcoM [m] from the CoM's place [m] and velocity [m/s]. Thesis (2.4)
pub fn xcom(x: f64, velocity: f64, omega: f64) -> f64 {
    x + velocity / omega
}

/// XcoM [m] after `time` [s] with the centre of pressure held at `cop` [m]. Thesis (2.5)
pub fn predicted_xcom(xcom: f64, cop: f64, omega: f64, time: f64) -> f64 {
    (xcom - cop) * libm::exp(omega * time) + cop
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prediction_agrees_with_the_integrated_pendulum() {
        let (omega, cop) = (eigenfrequency(9.81, 0.9), 0.1);
        let (mut x, mut v) = (0.0, 0.7);
        let start = xcom(x, v, omega);
        let (dt, steps) = (1e-5, 30_000);
        for _ in 0..steps {
            // Symplectic Euler on x'' = omega² (x - cop).
            v += dt * omega * omega * (x - cop);
            x += dt * v;
        }
        let expected = predicted_xcom(start, cop, omega, dt * f64::from(steps));
        assert!((xcom(x, v, omega) - expected).abs() < 1e-4);
    }

    #[test]
    fn cop_at_the_xcom_brings_the_com_to_rest() {
        let omega = eigenfrequency(9.81, 0.9);
        let xi = xcom(0.2, 0.5, omega);
        assert!((predicted_xcom(xi, xi, omega, 3.0) - xi).abs() < 1e-12);
    }
}
