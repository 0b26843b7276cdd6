//! The spring-damper contact that the thesis argues against (3.3), so that its bounce can be seen.

use crate::settings::ContactSettings;

/// Force of one contact [N] along its tangents and its normal (last).
///
/// `gap` [m] and `velocity` [m/s] in the same coordinates. The normal force never pulls; friction grows linearly up to
/// the Coulomb limit at `slip_speed_mps`.
pub fn force(settings: &ContactSettings, friction: f64, gap: f64, velocity: &[f64], force: &mut [f64]) {
    force.fill(0.0);
    if gap >= 0.0 {
        return;
    }
    let (normal_velocity, tangential) = velocity.split_last().expect("a contact has a normal");
    let normal = (-settings.stiffness_npm * gap - settings.damping_nspm * normal_velocity).max(0.0);
    let speed = libm::sqrt(tangential.iter().map(|v| v * v).sum());
    let share = friction * normal / speed.max(settings.slip_speed_mps);
    let last = force.len() - 1;
    for (component, v) in force.iter_mut().zip(tangential) {
        *component = -share * v;
    }
    force[last] = normal;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::SimulationSettings;

    /// 10 kN/m and 200 Ns/m, 1 cm deep: 100 N at rest. Friction of 0.5 is full from 0.1 m/s on.
    #[test]
    fn the_ground_pushes_as_its_spring_and_damper_and_rubs_against_the_slip() {
        let settings = ContactSettings {
            stiffness_npm: 1e4,
            damping_nspm: 200.0,
            slip_speed_mps: 0.1,
            ..SimulationSettings::default().contact
        };
        for (gap, velocity, expected) in [
            (-0.01, [0.0, 0.0, 0.0], [0.0, 0.0, 100.0]),
            (-0.01, [0.3, -0.4, -0.1], [-36.0, 48.0, 120.0]),
            (-0.01, [0.03, -0.04, 0.2], [-9.0, 12.0, 60.0]),
            // It does not pull, and nothing is felt above it.
            (-0.01, [0.3, -0.4, 0.6], [0.0, 0.0, 0.0]),
            (0.0, [0.3, -0.4, -1.0], [0.0, 0.0, 0.0]),
            (0.01, [0.3, -0.4, -1.0], [0.0, 0.0, 0.0]),
        ] {
            let mut found = [7.0; 3];
            force(&settings, 0.5, gap, &velocity, &mut found);
            let off = found.iter().zip(expected).map(|(found, expected)| (found - expected).abs()).fold(0.0, f64::max);
            assert!(off < 1e-12, "{gap} m, {velocity:?}: {found:?} instead of {expected:?}");
        }
        let mut in_plane = [7.0; 2];
        force(&settings, 0.5, -0.01, &[-0.2, 0.0], &mut in_plane);
        assert!((in_plane[0] - 50.0).abs() < 1e-12 && (in_plane[1] - 100.0).abs() < 1e-12, "{in_plane:?}");
    }
}
