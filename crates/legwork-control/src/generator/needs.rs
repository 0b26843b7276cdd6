//! What each generator needs of a robot.

use legwork_contract::error::Error;
use legwork_contract::feet::{Sole, from_joints};
use legwork_contract::robot::Robot;
use legwork_rbd::Base;

use crate::settings::{GeneratorKind, WalkerSettings};

/// Soles are level and alike to this [m].
const LEVEL_M: f64 = 1e-3;

/// Whether the feet's joints are above their soles and between heel and toe.
fn has_ankles(model: &Robot) -> bool {
    let sole = Sole::of(model);
    sole.heel < 0.0 && sole.toe > 0.0 && sole.ankle > 0.0
}

/// What is wrong with the soles on which the walker is to stand: each is level, below its ankle, and the other's like.
fn uneven_soles(model: &Robot) -> Option<String> {
    let sole = Sole::of(model);
    for (contact, place) in model.contacts.iter().zip(from_joints(model)) {
        let [x, z] = [place.x, place.z];
        if z >= 0.0 || (z + sole.ankle).abs() > LEVEL_M {
            return Some(format!(
                "contact point '{}' is at z = {z} m from its ankle; the walker's soles are level, here at z = {} m, below the ankle",
                contact.name, -sole.ankle
            ));
        }
        if x < sole.heel - LEVEL_M || x > sole.toe + LEVEL_M {
            return Some(format!(
                "contact point '{}' is at x = {x} m from its ankle; both of the walker's soles go from {} to {} m, as that of the first foot",
                contact.name, sole.heel, sole.toe
            ));
        }
    }
    None
}

/// The walker's legs reach the ground from wherever its schedule has the centre of mass.
pub(super) fn check_reach(walker: &WalkerSettings, model: &Robot) -> Result<(), Error> {
    let ankle = Sole::of(model).ankle;
    for (row, &[speed, _, height, ..]) in walker.schedule.iter().enumerate() {
        if walker.farthest_ahead(speed, ankle, walker.longest_drop_m) == 0.0 {
            let problem = format!(
                "row {row}: with the centre of mass {height} m high no leg of leg_m = {} m reaches the ground; valid is a lower \
                 one or a longer leg",
                walker.leg_m
            );
            return Err(Error::invalid("reference.walker.schedule", problem));
        }
    }
    Ok(())
}

/// Two feet, as every start pose and every generator wants them.
///
/// # Errors
/// The model has another number of feet.
pub fn check_feet(model: &Robot) -> Result<(), Error> {
    if model.feet.len() == 2 {
        return Ok(());
    }
    let problem = format!("found a robot with {} feet; valid is one with two, right before left", model.feet.len());
    Err(Error::invalid("model", problem))
}

/// Two feet, right before left; the thesis's steps want a planar robot with point feet.
///
/// # Errors
/// The model does not have what the generator needs; the message says what that is.
pub fn check_model(model: &Robot, generator: GeneratorKind) -> Result<(), Error> {
    let points = |foot: usize| model.points_of(foot).count();
    let two_feet = model.feet.len() == 2 && points(0) > 0 && points(1) > 0;
    let parts = || model.contacts.iter().zip(&model.foot_of);
    let one_body_each = parts().all(|(a, foot)| parts().all(|(b, other)| foot != other || a.body == b.body));
    let (valid, needs) = match generator {
        GeneratorKind::Steps => (
            model.is_planar() && two_feet && model.contacts.len() == 2,
            "the generator \"steps\" needs a planar base and two feet with one contact point each, right before left",
        ),
        GeneratorKind::Stance => (
            model.base != Base::Fixed && two_feet && one_body_each,
            "the generator \"stance\" needs a planar or floating base and two feet, right before left, each with its \
             contact points on one body",
        ),
        GeneratorKind::Walker => (
            model.is_planar() && two_feet && one_body_each && points(0) > 1 && points(1) > 1 && has_ankles(model),
            "the generator \"walker\" needs a planar base and two feet, right before left, each with a heel and a toe on \
             one body, the heel behind and the toe before the ankle and both below it",
        ),
    };
    if valid {
        return match uneven_soles(model) {
            Some(problem) if generator == GeneratorKind::Walker => {
                Err(Error::invalid("model", format!("the model '{}': {problem}", model.name)))
            }
            _ => Ok(()),
        };
    }
    let found = format!(
        "the model '{}' has base {} and {} contact points on {} feet",
        model.name,
        format!("{:?}", model.base).to_lowercase(),
        model.contacts.len(),
        model.feet.len()
    );
    Err(Error::invalid("model", format!("{found}; {needs}")))
}
