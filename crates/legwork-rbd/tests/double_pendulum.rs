//! Test number one: the double pendulum against its closed form.

mod common;

use common::assert_close;
use legwork_rbd::{Dynamics, Model};

const TOML: &str = include_str!("data/double_pendulum.toml");

#[test]
fn mass_matrix_bias_and_energy_match_the_closed_form() {
    let model = Model::from_toml(TOML, "double_pendulum.toml").unwrap();
    let (m1, m2, i1, i2) = (1.3, 0.7, 0.05, 0.02);
    let (l1, c1, c2, g) = (0.6, 0.25, 0.2, 9.81);
    let mut dynamics = Dynamics::new(&model);
    let mut random = common::Random(1);
    for _ in 0..20 {
        let (q, v) = (random.q(&model), random.v(&model));
        dynamics.update(&model, &q, &v);
        // Angles from hanging down, counter-clockwise; the second relative to the first
        let (sin2, cos2) = q[1].sin_cos();
        let m22 = i2 + m2 * c2 * c2;
        let m12 = m22 + m2 * l1 * c2 * cos2;
        let m11 = i1 + m1 * c1 * c1 + m2 * l1 * l1 + m22 + 2.0 * m2 * l1 * c2 * cos2;
        assert_close("M", dynamics.mass_matrix.as_slice(), &[m11, m12, m12, m22], 1e-14);
        let g2 = m2 * c2 * g * (q[0] + q[1]).sin();
        let g1 = (m1 * c1 + m2 * l1) * g * q[0].sin() + g2;
        assert_close("G", dynamics.gravity.as_slice(), &[g1, g2], 1e-14);
        let centrifugal = m2 * l1 * c2 * sin2;
        let h1 = g1 - centrifugal * (2.0 * v[0] * v[1] + v[1] * v[1]);
        let h2 = g2 + centrifugal * v[0] * v[0];
        assert_close("h", dynamics.bias.as_slice(), &[h1, h2], 1e-14);
        let kinetic = 0.5 * (m11 * v[0] * v[0] + 2.0 * m12 * v[0] * v[1] + m22 * v[1] * v[1]);
        let (z1, z2) = (-c1 * q[0].cos(), -l1 * q[0].cos() - c2 * (q[0] + q[1]).cos());
        let potential = g * (m1 * z1 + m2 * z2);
        assert_close("energy", &[dynamics.kinetic_energy, dynamics.potential_energy], &[kinetic, potential], 1e-14);
        assert_close("damping", dynamics.damping.as_slice(), &[0.1 * v[0], 0.2 * v[1]], 1e-15);
        let tip = [l1 * q[0].sin() + 0.4 * (q[0] + q[1]).sin(), 0.0, -l1 * q[0].cos() - 0.4 * (q[0] + q[1]).cos()];
        assert_close("tip", dynamics.contact_positions[0].as_slice(), &tip, 1e-14);
    }
}
