//! How stiff the springs and stops of joints may be for the time step.
//!
//! The step takes a spring's force as it is at the step's middle, and a damper's as the mean of before and after. A joint
//! with stiffness k and damper d on a robot that nobody holds, which gives way there by `m = (M⁻¹)_jj` a unit of force, is
//! then stable while `dt² k m < 4` and `dt d m < 2`; by the semi-implicit Euler rule while `dt² k m / 4 + dt d m / 2 < 1`.
//! That sum is at most the sum over all such joints, and contacts only make it smaller.

use legwork_contract::error::Error;
use legwork_rbd::{Dof, Model};

use crate::velocity::VelocityStep;

/// The joints that have a spring or a stop.
#[derive(Clone, Debug)]
pub(super) struct Elastic {
    dofs: Vec<usize>,
}

impl Elastic {
    pub(super) fn new(model: &Model) -> Self {
        Self { dofs: (0..model.nv()).filter(|&j| model.dofs[j].is_elastic()).collect() }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.dofs.is_empty()
    }

    /// The sum over the springs, and over the stops that joints are at in the position `q`, as a share of what is stable.
    pub(super) fn share<const D: usize, const K: usize>(
        &self,
        model: &Model,
        q: &[f64],
        dt: f64,
        velocity: &mut VelocityStep<D, K>,
    ) -> f64 {
        let one = |&j: &usize| {
            let dof = &model.dofs[j];
            let at_stop = dof.beyond(q[model.bodies[dof.body].q_index]) != 0.0;
            share(dof, at_stop, dt, velocity.mobility(j))
        };
        self.dofs.iter().map(one).sum()
    }

    /// Refuses a spring or stop that is unstable by itself in the position that `velocity` was set up in.
    pub(super) fn check<const D: usize, const K: usize>(
        &self,
        model: &Model,
        dt: f64,
        velocity: &mut VelocityStep<D, K>,
    ) -> Result<(), Error> {
        for &j in &self.dofs {
            let dof = &model.dofs[j];
            let share = share(dof, true, dt, velocity.mobility(j));
            if share >= 1.0 {
                let problem = format!(
                    "its spring and stop ({} and {}, damped by {}) are too stiff for time steps of {dt} s: by a factor of \
                     {share:.3}, where less than 1 is stable and 0.25 is resolved; make them softer, or simulation.period_s \
                     smaller",
                    dof.stiffness, dof.stop_stiffness, dof.stop_damping
                );
                return Err(Error::invalid(format!("joint {:?}", dof.name), problem));
            }
        }
        Ok(())
    }
}

fn share(dof: &Dof, at_stop: bool, dt: f64, mobility: f64) -> f64 {
    let (stiffness, damping) = if at_stop { (dof.stop_stiffness, dof.stop_damping) } else { (0.0, 0.0) };
    (0.25 * dt * dt * (dof.stiffness + stiffness) + 0.5 * dt * damping) * mobility
}
