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
