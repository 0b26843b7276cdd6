//! A joint-space hold: each actuated joint is pulled to where it was at the start, and what holds the robot there is added.
//!
//! `τ = K (q₀ − q) − D q̇ + τ₀`, with τ₀ the torques that carry the robot's weight in the start pose. It balances nothing: it is
//! what a machine does whose balance is left to somebody else, and what any other controller is to be better than.

use legwork_contract::contract::{Command, Sensed};
use legwork_contract::error::Error;
use legwork_contract::terrain::Terrain;
use legwork_rbd::{Dynamics, Model};
use nalgebra::DMatrix;

use crate::controller::Controller;
use crate::settings::{ControllerSettings, HoldSettings, ReferenceSettings};

/// The hold with its posture.
#[derive(Clone, Debug)]
pub struct HoldController {
    settings: HoldSettings,
    model: Model,
    joints: Vec<Joint>,
    command: Command,
}

/// An actuated joint.
#[derive(Clone, Copy, Debug)]
struct Joint {
    q_index: usize,
    dof: usize,
    /// Where it is held [rad or m].
    angle: f64,
    /// What carries the robot's weight there [Nm or N].
    torque: f64,
    /// The most that its motor gives [Nm or N].
    limit: f64,
}

impl HoldController {
    /// A controller that holds `model` in the posture of the `start`.
    ///
    /// # Errors
    /// What is sensed at the start is no state of the robot.
    pub fn new(settings: &HoldSettings, model: &Model, start: &Sensed) -> Result<Self, Error> {
        start.check(model)?;
        let torques = standing(model, start);
        let joint = |(index, dof): (usize, usize)| {
            let q_index = model.bodies[model.dofs[dof].body].q_index;
            Joint { q_index, dof, angle: start.q[q_index], torque: torques[index], limit: model.dofs[dof].effort_limit }
        };
        let joints: Vec<Joint> = model.actuated().enumerate().map(joint).collect();
        let command = Command { torque: vec![0.0; joints.len()] };
        Ok(Self { settings: settings.clone(), model: model.clone(), joints, command })
    }
}

/// The torques of the actuated joints that hold `model` at rest, with the least forces on the contact points that touch: the least
/// squares of `S τ + Jᵀ ρ = G + e`, with `e` what springs and stops add to the weight (`Dynamics::elastic`).
fn standing(model: &Model, start: &Sensed) -> Vec<f64> {
    let mut dynamics = Dynamics::new(model);
    dynamics.update(model, &start.q, &vec![0.0; model.nv()]);
    let actuated: Vec<usize> = model.actuated().collect();
    let axes = model.linear_axes().len();
    let touching: Vec<usize> = (0..start.contacts.len()).filter(|&contact| start.contacts[contact].touching).collect();
    let mut map = DMatrix::zeros(model.nv(), actuated.len() + touching.len() * axes);
    for (column, &dof) in actuated.iter().enumerate() {
        map[(dof, column)] = 1.0;
    }
    for (index, &contact) in touching.iter().enumerate() {
        for axis in 0..axes {
            let row = dynamics.contact_jacobian.row(contact * axes + axis).transpose();
            map.set_column(actuated.len() + index * axes + axis, &row);
        }
    }
    let borne = &dynamics.gravity + &dynamics.elastic;
    let solved = map.svd(true, true).solve(&borne, 1e-9);
    solved.map_or_else(|_| vec![0.0; actuated.len()], |solved| solved.as_slice()[..actuated.len()].to_vec())
}

impl Controller for HoldController {
    fn tick(&mut self, sensed: &Sensed, _dynamics: &Dynamics) -> &Command {
        if sensed.fits(&self.model) {
            for (torque, joint) in self.command.torque.iter_mut().zip(&self.joints) {
                let pull = self.settings.stiffness_nmprad * (joint.angle - sensed.q[joint.q_index]);
                let wanted = joint.torque + pull - self.settings.damping_nmsprad * sensed.v[joint.dof];
                *torque = wanted.clamp(-joint.limit, joint.limit);
            }
        }
        &self.command
    }

    fn command(&self) -> &Command {
        &self.command
    }

    fn change(&mut self, settings: &ControllerSettings, _reference: &ReferenceSettings, _terrain: &Terrain) {
        self.settings = settings.hold.clone();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hanging_pendulum_is_held_where_it_is_against_its_weight_and_its_spring() {
        let text = r#"
            name = "pendulum"
            base = "fixed"
            torso = "rod"
            [[bodies]]
            name = "stand"
            [[bodies]]
            name = "rod"
            parent = "stand"
            mass_kg = 2.0
            com_m = [0.0, 0.0, -0.5]
            inertia_kgm2 = { xx = 0.1, yy = 0.1, zz = 0.01 }
            joint = { name = "swing", type = "revolute", axis = [0.0, -1.0, 0.0], spring_nmpr = 20.0, rest_deg = 90.0 }
        "#;
        let model = Model::from_toml(text, "pendulum.toml").expect("a sound model");
        let mut start = Sensed::new(&model);
        start.q[0] = 0.7;
        let settings = HoldSettings { stiffness_nmprad: 100.0, damping_nmsprad: 5.0 };
        let mut hold = HoldController::new(&settings, &model, &start).expect("a state");
        let dynamics = Dynamics::new(&model);
        let borne = 2.0 * 9.81 * 0.5 * 0.7_f64.sin() + 20.0 * (0.7 - std::f64::consts::FRAC_PI_2);
        let torque = |hold: &mut HoldController, q: f64, v: f64| {
            let sensed = Sensed { q: vec![q], v: vec![v], ..start.clone() };
            hold.tick(&sensed, &dynamics).torque[0]
        };
        assert!((torque(&mut hold, 0.7, 0.0) - borne).abs() < 1e-9, "{}", torque(&mut hold, 0.7, 0.0));
        assert!((torque(&mut hold, 0.6, 0.2) - borne - 10.0 + 1.0).abs() < 1e-9);
        let before = torque(&mut hold, 0.65, 0.0);
        assert_eq!(torque(&mut hold, f64::NAN, 0.0), before, "no state: the torques of the tick before are held");
    }
}
