//! Springs at joints, and the stops at the ends of their ranges: stiff springs with a damper that only push.

use crate::dynamics::Dynamics;
use crate::model::{Dof, Model};

impl Dof {
    /// Whether a spring or a stop acts on it.
    #[inline]
    #[must_use]
    pub fn is_elastic(&self) -> bool {
        // One comparison: most joints have neither.
        self.stiffness.abs() + self.stop_stiffness.abs() != 0.0
    }

    /// How far the position `q` is beyond the end of the range [rad or m]: positive above, negative below, zero within.
    #[must_use]
    pub fn beyond(&self, q: f64) -> f64 {
        (q - self.upper).max(0.0) + (q - self.lower).min(0.0)
    }
}

impl Model {
    /// Whether a spring or a stop acts on any joint.
    #[inline]
    #[must_use]
    pub fn is_elastic(&self) -> bool {
        self.dofs.iter().any(Dof::is_elastic)
    }
}

impl Dynamics {
    /// Fills `elastic` and `elastic_energy`.
    pub(crate) fn springs(&mut self, model: &Model, q: &[f64]) {
        self.elastic_energy = 0.0;
        let was_elastic = std::mem::replace(&mut self.is_elastic, model.is_elastic());
        if !self.is_elastic && !was_elastic {
            return;
        }
        for (j, dof) in model.dofs.iter().enumerate() {
            if !dof.is_elastic() {
                (self.elastic[j], self.stop_force[j]) = (0.0, 0.0);
                continue;
            }
            let q = q[model.bodies[dof.body].q_index];
            let (stretch, beyond) = (q - dof.rest, dof.beyond(q));
            self.stop_force[j] = dof.stop_stiffness * beyond;
            self.elastic[j] = dof.stiffness * stretch + self.stop_force[j];
            self.elastic_energy += 0.5 * (dof.stiffness * stretch * stretch + self.stop_force[j] * beyond);
        }
    }

    /// Adds the dampers of stops to `damping`.
    pub(crate) fn stop_dampers(&mut self, model: &Model, v: &[f64]) {
        if self.is_elastic {
            for (j, dof) in model.dofs.iter().enumerate() {
                self.damping[j] += self.stop_damping(j, dof, v[j]);
            }
        }
    }

    /// The damper of a stop: it acts while the joint is beyond its end, and lets go where the stop would pull.
    fn stop_damping(&self, j: usize, dof: &Dof, speed: f64) -> f64 {
        let (elastic, viscous) = (self.stop_force[j], dof.stop_damping * speed);
        match elastic {
            push if push > 0.0 => viscous.max(-push),
            push if push < 0.0 => viscous.min(-push),
            _ => 0.0,
        }
    }
}
