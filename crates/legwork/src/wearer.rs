//! The person whose segments the planar humanoids have, and what an exoskeleton adds to them.
//!
//! All masses of these models are shares of the person's mass, all lengths shares of the height (Winter), so that another
//! person's are found by proportion: a mass by the ratio m of the masses, a length by the ratio h of the heights, an inertia
//! by m h², a joint's strength by m h.
//!
//! Heights of the centre of mass and the leg's reach in the settings of start pose and walker belong to that person: with longer legs or
//! an exoskeleton's masses they shift by what [`Build`] differs.

use std::sync::LazyLock;

use legwork_rbd::{Dynamics, Model};

use crate::error::Error;
use crate::fit::Fit;
use crate::library::load_model;
use crate::scenario::{ControllerSettings, Exoskeleton, Scenario, Wearer};

/// Whose segments the models' files have.
pub const PERSON: Wearer = Wearer { mass_kg: 72.5, height_m: 1.75, strength: 1.0 };

/// Gives `model`, as its file has it, the segments of `wearer` and the masses of `exoskeleton`.
///
/// # Errors
/// The model is not one of a person, and another wearer or an exoskeleton's mass was asked for.
pub fn fit(model: &mut Model, wearer: &Wearer, exoskeleton: &Exoskeleton) -> Result<(), Error> {
    if *wearer != PERSON {
        if (model.total_mass() - PERSON.mass_kg).abs() > 1e-6 {
            let of = |wearer: &Wearer| {
                format!("{} kg, {} m and a strength of {}", wearer.mass_kg, wearer.height_m, wearer.strength)
            };
            let problem = format!(
                "found {}, but the model '{}' of {:.1} kg is not made of a person's segments; valid is {}, or one of the planar humanoids",
                of(wearer),
                model.name,
                model.total_mass(),
                of(&PERSON)
            );
            return Err(Error::invalid("wearer", problem));
        }
        let has_strength = model.dofs.iter().any(|dof| dof.actuated && dof.effort_limit.is_finite());
        if wearer.strength != PERSON.strength && !has_strength {
            let problem = format!(
                "found {}, but the joints of the model '{}' have no torque limits of their own that it could change; valid is {}, or a \
                 model with limits",
                wearer.strength, model.name, PERSON.strength
            );
            return Err(Error::invalid("wearer.strength", problem));
        }
        scale(model, wearer, &PERSON);
    }
    for (segment, mass) in exoskeleton.masses() {
        if mass == 0.0 {
            continue;
        }
        let mut bodies = model.bodies.iter_mut().filter(|body| body.name.ends_with(segment)).peekable();
        if bodies.peek().is_none() {
            let problem =
                format!("found {mass}, but the model '{}' has no body whose name ends with '{segment}'", model.name);
            return Err(Error::invalid(format!("exoskeleton.{segment}_kg"), problem));
        }
        bodies.for_each(|body| body.mass += mass);
    }
    Ok(())
}

/// Changes the wearer and the exoskeleton of a `model` that has those of the scenario `before` to those of `after`.
///
/// # Errors
/// Those of [`fit`].
pub fn refit(model: &mut Model, before: &Scenario, after: &Scenario) -> Result<(), Error> {
    for (segment, mass) in before.exoskeleton.masses() {
        model.bodies.iter_mut().filter(|body| body.name.ends_with(segment)).for_each(|body| body.mass -= mass);
    }
    if before.wearer != after.wearer {
        scale(model, &PERSON, &before.wearer);
    }
    fit(model, &after.wearer, &after.exoskeleton)
}

/// What of a body the heights depend on that walker and start pose ask for: lengths of a robot that stands upright, or by how much they
/// differ from a person's [m].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Build {
    /// From the hip to the ankle.
    pub leg: f64,
    /// From the hip up to the centre of mass.
    pub com_above_hip: f64,
}

impl Build {
    /// That of `model`, which has thighs and feet.
    fn of(model: &Model) -> Self {
        let mut dynamics = Dynamics::new(model);
        dynamics.update(model, model.neutral().as_slice(), &vec![0.0; model.nv()]);
        let height = |segment: &str| {
            let body = model.bodies.iter().position(|body| body.name.ends_with(segment)).expect("a person's segment");
            dynamics.world_from_body[body].translation.z
        };
        let (hip, ankle) = (height("thigh"), height("foot"));
        Self { leg: hip - ankle, com_above_hip: dynamics.com.z - hip }
    }

    /// By how much `model` differs from the person who is as tall as `wearer` and carries nothing; nothing for a robot that is no
    /// `planar_humanoid_feet`.
    pub fn beyond(wearer: &Wearer, model: &Model) -> Self {
        static PERSONS: LazyLock<(String, Build)> = LazyLock::new(|| {
            let model = load_model("planar_humanoid_feet", None).expect("a model that is built in");
            (model.name.clone(), Build::of(&model))
        });
        let (name, person) = &*PERSONS;
        if model.name != *name {
            return Self::default();
        }
        let own = Self::of(model);
        let beyond = |own: f64, person: f64| {
            let difference = own - wearer.stature() * person;
            // Scaled lengths differ in their last digits.
            if difference.abs() < 1e-9 { 0.0 } else { difference }
        };
        Self { leg: beyond(own.leg, person.leg), com_above_hip: beyond(own.com_above_hip, person.com_above_hip) }
    }

    /// How much higher the centre of mass is.
    pub fn com(&self) -> f64 {
        self.leg + self.com_above_hip
    }
}

/// The controller's settings for `model`, which has the wearer and the exoskeleton of `scenario`.
pub fn controller(scenario: &Scenario, model: &Model) -> ControllerSettings {
    if scenario.fit != Fit::None || scenario.wearer == PERSON && scenario.exoskeleton == Exoskeleton::default() {
        return scenario.controller.clone();
    }
    scenario.controller.for_size(model.total_mass() / PERSON.mass_kg, scenario.wearer.stature())
}

/// Makes the segments of `from` those of `to`.
fn scale(model: &mut Model, to: &Wearer, from: &Wearer) {
    let (mass, length) = (to.mass_kg / from.mass_kg, to.height_m / from.height_m);
    for body in &mut model.bodies {
        body.placement.translation *= length;
        body.mass *= mass;
        body.com *= length;
        body.inertia *= mass * length * length;
    }
    for contact in &mut model.contacts {
        contact.position *= length;
    }
    // The strength of a person; a model without it has infinite limits.
    for dof in &mut model.dofs {
        dof.effort_limit *= mass * length * (to.strength / from.strength);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::library::load_model;
    use crate::robot::Robot;

    fn fitted(name: &str, mass_kg: f64, height_m: f64) -> Robot {
        let mut model = load_model(name, None).expect("built in");
        fit(&mut model, &Wearer { mass_kg, height_m, ..PERSON }, &Exoskeleton::default()).expect("a person");
        model
    }

    #[test]
    fn a_person_of_twice_the_mass_moves_as_before_with_twice_the_torques() {
        for name in ["planar_humanoid", "planar_humanoid_feet"] {
            let (one, other) = (fitted(name, 72.5, 1.75), fitted(name, 145.0, 1.75));
            let (q, v): (Vec<f64>, Vec<f64>) = (0..one.nv()).map(|k| (0.1 * k as f64, 0.5 - 0.1 * k as f64)).unzip();
            let bias = |model: &Model| {
                let mut dynamics = Dynamics::new(model);
                dynamics.update(model, &q, &v);
                dynamics.bias.clone()
            };
            assert!((2.0 * bias(&one) - bias(&other)).amax() < 1e-10, "{name}");
        }
    }

    #[test]
    fn a_taller_person_is_the_same_one_in_slower_time() {
        // Dynamic similarity (Hof 1996): with all lengths times h and speeds times √h, forces per weight stay.
        let height: f64 = 1.21;
        let (one, other) =
            (fitted("planar_humanoid_feet", 72.5, 1.75), fitted("planar_humanoid_feet", 72.5, 1.75 * height));
        let kinetic = |model: &Model, length: f64| {
            let mut dynamics = Dynamics::new(model);
            let mut q: Vec<f64> = (0..model.nq()).map(|k| 0.1 * k as f64).collect();
            let mut v: Vec<f64> = (0..model.nv()).map(|k| (0.5 - 0.1 * k as f64) / length.sqrt()).collect();
            (0..2).for_each(|k| (q[k], v[k]) = (q[k] * length, v[k] * length));
            dynamics.update(model, &q, &v);
            dynamics.kinetic_energy
        };
        assert!((kinetic(&other, height) - height * kinetic(&one, 1.0)).abs() < 1e-10);
        let toe = |model: &Model| model.contacts[1].position.x;
        assert!((toe(&other) - height * toe(&one)).abs() < 1e-15);
    }

    #[test]
    fn an_exoskeleton_adds_its_masses_and_needs_their_segments() {
        let mut model = load_model("planar_humanoid_feet", None).expect("built in");
        let worn = Exoskeleton { torso_kg: 8.0, thigh_kg: 3.0, shank_kg: 1.5, foot_kg: 0.5 };
        fit(&mut model, &PERSON, &worn).expect("it has all segments");
        assert!((model.total_mass() - (72.5 + 8.0 + 2.0 * 5.0)).abs() < 1e-12);
        let mut point_feet = load_model("planar_humanoid", None).expect("built in");
        let error = fit(&mut point_feet, &PERSON, &worn).expect_err("it has no feet");
        assert!(error.to_string().contains("exoskeleton.foot_kg"), "{error}");
    }

    #[test]
    fn an_exoskeleton_shifts_the_centre_of_mass_by_its_masses() {
        let worn = Exoskeleton { torso_kg: 8.0, thigh_kg: 3.0, shank_kg: 1.5, foot_kg: 0.5 };
        let bare = load_model("planar_humanoid_feet", None).expect("built in");
        let mut model = bare.clone();
        fit(&mut model, &PERSON, &worn).expect("it has all segments");
        // Mass and centre above the base of each segment of the person who stands upright: joints and centres add up along the leg.
        let of_segment = |segment: &str| -> Vec<[f64; 2]> {
            let height = |mut index: usize| {
                let mut height = bare.bodies[index].com.z;
                loop {
                    height += bare.bodies[index].placement.translation.z;
                    let Some(parent) = bare.bodies[index].parent else { return height };
                    index = parent;
                }
            };
            let bodies = bare.bodies.iter().enumerate().filter(|(_, body)| body.name.ends_with(segment));
            bodies.map(|(index, body)| [body.mass, height(index)]).collect()
        };
        let (mut person, mut with) = ([0.0; 2], [0.0; 2]);
        for (segment, added) in worn.masses() {
            for [mass, height] in of_segment(segment) {
                person = [person[0] + mass, person[1] + mass * height];
                with = [with[0] + mass + added, with[1] + (mass + added) * height];
            }
        }
        assert!((person[0] - 72.5).abs() < 1e-9, "all segments: {} kg", person[0]);
        let expected = with[1] / with[0] - person[1] / person[0];
        let Build { leg, com_above_hip: shift } = Build::beyond(&PERSON, &model);
        assert!((shift - expected).abs() < 1e-12 && (-0.05..-0.02).contains(&shift), "{shift}, not {expected}");
        assert_eq!((leg, Build::beyond(&PERSON, &bare)), (0.0, Build::default()));
    }

    #[test]
    fn longer_shanks_lengthen_the_leg() {
        let taller = Wearer { height_m: 1.95, ..PERSON };
        let mut model = fitted("planar_humanoid_feet", 72.5, 1.95);
        assert_eq!(Build::beyond(&taller, &model), Build::default());
        let shank = model.bodies.iter().position(|body| body.name == "right_foot").expect("it has one");
        model.bodies[shank].placement.translation.z -= 0.02;
        let build = Build::beyond(&taller, &model);
        // The foot's mass hangs lower from the hip.
        let lower = 0.02 * model.bodies[shank].mass / model.total_mass();
        assert!((build.leg - 0.02).abs() < 1e-12 && (build.com_above_hip + lower).abs() < 1e-12, "{build:?}");
        assert!((build.com() - 0.02 + lower).abs() < 1e-12);
    }

    #[test]
    fn joints_are_as_strong_as_asked() {
        let strong = Wearer { strength: 1.5, ..PERSON };
        let before = Scenario { wearer: Wearer { mass_kg: 60.0, ..PERSON }, ..Scenario::default() };
        let after = Scenario { wearer: strong, ..Scenario::default() };
        let mut model = fitted("planar_humanoid_feet", 60.0, 1.75);
        refit(&mut model, &before, &after).expect("a person");
        let knee = model.dofs.iter().find(|dof| dof.name == "right_knee").expect("it has one");
        assert!((knee.effort_limit - 300.0).abs() < 1e-9, "{}", knee.effort_limit);
    }

    #[test]
    fn a_robot_is_no_person() {
        let mut exo = load_model("exo18", None).expect("built in");
        let wearer = Wearer { mass_kg: 80.0, ..PERSON };
        let error = fit(&mut exo, &wearer, &Exoskeleton::default()).expect_err("it has links of its own");
        assert!(error.to_string().contains("wearer"), "{error}");
        let strong = Wearer { strength: 1.2, ..PERSON };
        let error = fit(&mut exo, &strong, &Exoskeleton::default()).expect_err("nor is it one that is stronger");
        assert!(error.to_string().contains("a strength of 1.2"), "{error}");
        let mut model = load_model("planar_humanoid", None).expect("built in");
        let error = fit(&mut model, &strong, &Exoskeleton::default()).expect_err("its joints have no limits");
        assert!(error.to_string().contains("no torque limits of their own"), "{error}");
    }
}
