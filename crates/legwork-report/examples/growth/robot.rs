//! Robots of any size that stand in the plane: a trunk, two legs, and arms of as many joints as are asked for.
//!
//! They are held upright by torques that carry their weight and pull each joint toward a slowly moving pose, so that what
//! is measured does not depend on whether a controller can walk with them.

use std::fmt::Write;

use legwork::Robot;
use legwork::contract::Sensed;
use legwork::error::Error;
use legwork::scenario::Scenario;
use legwork::sim::Plant;
use legwork_rbd::{Dynamics, Model};

/// Length of a thigh and of a shank [m]; height of the hips above the soles [m]; feet before and behind them [m].
const LINK: f64 = 0.43;
const HIP_HEIGHT: f64 = 0.8;
const STRIDE: f64 = 0.15;
/// Length of a foot [m].
const FOOT: f64 = 0.24;
/// Mass of all links of an arm [kg], their length together [m].
const ARM_MASS: f64 = 4.0;
const ARM_LENGTH: f64 = 0.6;

/// Right before left.
const SIDES: [&str; 2] = ["right", "left"];

/// How large a robot is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Size {
    /// Degrees of freedom: 7, and with ankles 9, at the least.
    pub(crate) dofs: usize,
    /// Contact points of each foot. One is a point foot; more lie along a sole below an ankle.
    pub(crate) contacts_per_foot: usize,
    /// Whether the legs have ankles.
    pub(crate) ankles: bool,
}

/// What a robot's controller and simulator are given.
#[derive(Clone, Debug)]
pub(crate) struct Standing {
    /// The robot.
    pub(crate) model: Robot,
    /// A state each [`Standing::torques`] is given in.
    pub(crate) estimates: Vec<Sensed>,
    /// Torques of the actuated joints [Nm].
    pub(crate) torques: Vec<Vec<f64>>,
}

impl Size {
    /// The robot of this size.
    pub(crate) fn model(self) -> Result<Robot, Error> {
        let legs = if self.ankles { 6 } else { 4 };
        let arms = self.dofs - 3 - legs;
        let mut text = "name = \"grown\"\nbase = \"planar\"\ntorso = \"trunk\"\ncontacts = [\n".to_owned();
        for side in SIDES {
            let (body, drop) = if self.ankles { ("foot", 0.0) } else { ("shank", LINK) };
            for index in 0..self.contacts_per_foot {
                let x = if self.contacts_per_foot == 1 {
                    0.0
                } else {
                    FOOT * (index as f64 / (self.contacts_per_foot - 1) as f64 - 0.5)
                };
                let _ = writeln!(
                    text,
                    "{{ name = \"{side}_{index}\", foot = \"{side}\", body = \"{side}_{body}\", position_m = [{x:?}, 0.0, {:?}] }},",
                    -drop
                );
            }
        }
        text += "]\n[[bodies]]\nname = \"trunk\"\nmass_kg = 40.0\ncom_m = [0.0, 0.0, 0.25]\ninertia_kgm2 = 2.0\n";
        for (side, arms) in SIDES.into_iter().zip([arms.div_ceil(2), arms / 2]) {
            link(&mut text, side, "thigh", "trunk", 0.0, LINK, 7.0);
            link(&mut text, side, "shank", &format!("{side}_thigh"), -LINK, LINK, 4.0);
            if self.ankles {
                link(&mut text, side, "foot", &format!("{side}_shank"), -LINK, 0.0, 1.0);
            }
            let length = ARM_LENGTH / arms.max(1) as f64;
            for index in 0..arms {
                let (parent, z) =
                    if index == 0 { ("trunk".to_owned(), 0.5) } else { (format!("{side}_arm{}", index - 1), -length) };
                link(&mut text, side, &format!("arm{index}"), &parent, z, length, ARM_MASS / arms as f64);
            }
        }
        Ok(Robot::from_toml(&text, "a robot made to measure growth")?)
    }

    /// How it stands in the beginning: both feet on the ground, one before and one behind the hips, the arms bent.
    fn pose(model: &Model) -> Vec<f64> {
        let mut q = vec![0.0; model.nq()];
        q[1] = HIP_HEIGHT;
        for (side, x) in SIDES.into_iter().zip([STRIDE, -STRIDE]) {
            let (lean, bend) = ((x / HIP_HEIGHT).atan(), (x.hypot(HIP_HEIGHT) / (2.0 * LINK)).acos());
            for (joint, angle) in [("thigh", lean + bend), ("shank", -2.0 * bend), ("foot", bend - lean)] {
                if let Some(dof) = model.dof_index(&format!("{side}_{joint}")) {
                    q[dof] = angle;
                }
            }
        }
        let arms: Vec<usize> = (3..model.nv()).filter(|&dof| model.dofs[dof].name.contains("_arm")).collect();
        arms.iter().for_each(|&dof| q[dof] = 1.6 / arms.len() as f64);
        q
    }

    /// It stands for `ticks` ticks of `scenario`.
    pub(crate) fn stand(self, scenario: &Scenario, ticks: usize) -> Result<Standing, Error> {
        let model = self.model()?;
        let pose = Self::pose(&model);
        let mut simulator = scenario.simulator(&model, &pose)?;
        let (mut estimates, mut torques) = (Vec::new(), Vec::new());
        for _ in 0..ticks {
            let mut sensed = Sensed::new(&model);
            simulator.read(&mut sensed);
            let torque = holding(&model, simulator.dynamics(), &pose, &sensed.q, &sensed.v, sensed.time);
            simulator.step(&torque);
            estimates.push(sensed);
            torques.push(torque);
        }
        Ok(Standing { model, estimates, torques })
    }
}

/// A link of `length` [m] and `mass` [kg] that hangs at the height `z` [m] of its parent's frame.
fn link(text: &mut String, side: &str, name: &str, parent: &str, z: f64, length: f64, mass: f64) {
    // As a rod; a foot, which is short, as one of its own length.
    let inertia = mass * length.max(FOOT).powi(2) / 12.0;
    let _ = writeln!(
        text,
        "[[bodies]]\nname = \"{side}_{name}\"\nparent = \"{parent}\"\nmass_kg = {mass:?}\n\
         com_m = [0.0, 0.0, {:?}]\ninertia_kgm2 = {inertia:?}\n\
         joint = {{ name = \"{side}_{name}\", type = \"revolute\", axis = [0.0, -1.0, 0.0], origin_m = [0.0, 0.0, {z:?}] }}",
        -0.5 * length
    );
}

/// Torques that carry the weight, an equal share on each contact point, and pull toward a pose that sways a little:
/// `τ = h - Jᵀ ρ + M (ω² (q_d - q) - 2 ω q̇)`, rows and columns of the actuated joints.
fn holding(model: &Model, dynamics: &Dynamics, pose: &[f64], q: &[f64], v: &[f64], time: f64) -> Vec<f64> {
    const OMEGA: f64 = 30.0;
    const SWAY: f64 = 0.01;
    let actuated: Vec<usize> = model.actuated().collect();
    let share = model.total_mass() * model.gravity / model.nc() as f64;
    let wanted = |j: usize| {
        let sway = SWAY * (std::f64::consts::TAU * 5.0 * time + j as f64).sin();
        OMEGA * OMEGA * (pose[j] + sway - q[j]) - 2.0 * OMEGA * v[j]
    };
    let torque = |&i: &usize| {
        let carried: f64 = (0..model.nc()).map(|contact| dynamics.contact_jacobian[(2 * contact + 1, i)] * share).sum();
        let pulled: f64 = actuated.iter().map(|&j| dynamics.mass_matrix[(i, j)] * wanted(j)).sum();
        dynamics.bias[i] - carried + pulled
    };
    actuated.iter().map(torque).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use legwork::scenario_file;

    #[test]
    fn a_robot_of_any_size_is_what_was_asked_for_and_stands() {
        let scenario = scenario_file::load("stand", &[]).expect("it is built in").scenario;
        for (dofs, contacts_per_foot, ankles) in
            [(7, 1, false), (8, 1, false), (40, 1, false), (9, 1, true), (9, 8, true)]
        {
            let size = Size { dofs, contacts_per_foot, ankles };
            let standing = size.stand(&scenario, 200).expect("it can stand");
            assert_eq!((standing.model.nv(), standing.model.nc()), (dofs, 2 * contacts_per_foot), "{size:?}");
            let mut dynamics = Dynamics::new(&standing.model);
            for estimate in [&standing.estimates[0], &standing.estimates[199]] {
                dynamics.update(&standing.model, &estimate.q, &estimate.v);
                assert!((dynamics.com.z - 0.9).abs() < 0.15, "{size:?}: CoM at {}", dynamics.com.z);
                let highest = dynamics.contact_positions.iter().map(|point| point.z.abs()).fold(0.0, f64::max);
                assert!(highest < 0.02, "{size:?}: a contact point at {highest}");
            }
        }
    }
}
