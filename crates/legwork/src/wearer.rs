//! The person whose segments the planar humanoids have, and what an exoskeleton adds to them.
//!
//! All masses of these models are shares of the person's mass, all lengths shares of the height (Winter), so that another
//! person's are found by proportion: a mass by the ratio m of the masses, a length by the ratio h of the heights, an inertia
//! by m h², a joint's strength by m h.

use legwork_rbd::{Dynamics, Model};

use crate::error::Error;
use crate::scenario::{ControllerSettings, Exoskeleton, Scenario, Wearer};

/// Whose segments the models' files have.
pub const PERSON: Wearer = Wearer { mass_kg: 72.5, height_m: 1.75 };

/// Gives `model`, as its file has it, the segments of `wearer` and the masses of `exoskeleton`.
///
/// # Errors
/// The model is not one of a person, and another wearer or an exoskeleton's mass was asked for.
pub fn fit(model: &mut Model, wearer: &Wearer, exoskeleton: &Exoskeleton) -> Result<(), Error> {
    if *wearer != PERSON {
        if (model.total_mass() - PERSON.mass_kg).abs() > 1e-6 {
            let problem = format!(
                "found {} kg and {} m, but the model '{}' of {:.1} kg is not made of a person's segments; valid is {} kg and \
                 {} m, or one of the planar humanoids",
                wearer.mass_kg,
                wearer.height_m,
                model.name,
                model.total_mass(),
                PERSON.mass_kg,
                PERSON.height_m
            );
            return Err(Error::invalid("wearer", problem));
        }
        scale(model, wearer.mass_kg / PERSON.mass_kg, wearer.height_m / PERSON.height_m);
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
    take_off(model, &before.exoskeleton);
    let (from, to) = (&before.wearer, &after.wearer);
    if from != to {
        scale(model, PERSON.mass_kg / from.mass_kg, PERSON.height_m / from.height_m);
    }
    fit(model, to, &after.exoskeleton)
}

/// Takes the masses of `exoskeleton` from a `model` that has them.
fn take_off(model: &mut Model, exoskeleton: &Exoskeleton) {
    for (segment, mass) in exoskeleton.masses() {
        model.bodies.iter_mut().filter(|body| body.name.ends_with(segment)).for_each(|body| body.mass -= mass);
    }
}

/// By how much the masses of `exoskeleton`, which `model` has, raise the centre of mass of the person who stands upright [m]. Masses at
/// the legs lower it.
pub fn com_shift(exoskeleton: &Exoskeleton, model: &Model) -> f64 {
    if *exoskeleton == Exoskeleton::default() {
        return 0.0;
    }
    let height = |model: &Model| {
        let mut dynamics = Dynamics::new(model);
        dynamics.update(model, model.neutral().as_slice(), &vec![0.0; model.nv()]);
        dynamics.com.z
    };
    let mut bare = model.clone();
    take_off(&mut bare, exoskeleton);
    height(model) - height(&bare)
}

/// The controller's settings for `model`, which has the wearer and the exoskeleton of `scenario`.
pub fn controller(scenario: &Scenario, model: &Model) -> ControllerSettings {
    if scenario.wearer == PERSON && scenario.exoskeleton == Exoskeleton::default() {
        return scenario.controller.clone();
    }
    scenario.controller.for_size(model.total_mass() / PERSON.mass_kg, scenario.wearer.stature())
}

fn scale(model: &mut Model, mass: f64, length: f64) {
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
        dof.effort_limit *= mass * length;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::library::load_model;
    use crate::robot::Robot;

    fn fitted(name: &str, mass_kg: f64, height_m: f64) -> Robot {
        let mut model = load_model(name, None).expect("built in");
        fit(&mut model, &Wearer { mass_kg, height_m }, &Exoskeleton::default()).expect("a person");
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
        let shift = com_shift(&worn, &model);
        assert!((shift - expected).abs() < 1e-12 && (-0.05..-0.02).contains(&shift), "{shift}, not {expected}");
        assert_eq!(com_shift(&Exoskeleton::default(), &bare), 0.0);
    }

    #[test]
    fn a_robot_is_no_person() {
        let mut exo = load_model("exo18", None).expect("built in");
        let wearer = Wearer { mass_kg: 80.0, ..PERSON };
        let error = fit(&mut exo, &wearer, &Exoskeleton::default()).expect_err("it has links of its own");
        assert!(error.to_string().contains("wearer"), "{error}");
    }
}
