//! What every record holds, whatever the controller and the physics: the true state and the reference.

use std::fmt::{self, Debug, Formatter};

use legwork_rbd::{Dynamics, Model};
use nalgebra::Vector3;
use xxhash_rust::xxh3::{Xxh3, xxh3_128};

use crate::channel::{Channel, Columns, Field, Record};
use crate::contract::Sensed;
use crate::control::controller::Controller;
use crate::feet::{FeetMotion, FootRows, right_of};
use crate::generator::{PointReference, Reference};
use crate::names;
use crate::robot::Robot;
use crate::sim::Plant;

/// The channels of a run of `model` with this controller and this physics.
pub(crate) fn channels(model: &Robot, controller: &dyn Controller, plant: &dyn Plant) -> Vec<Channel> {
    let positions = model.q_names().into_iter().enumerate().map(|(index, name)| {
        let unit = match model.nq() == model.nv() {
            false => "",
            true if model.dofs[index].rotational => "rad",
            true => "m",
        };
        (format!("q.{name}"), unit)
    });
    let touching = model.contacts.iter().map(|contact| (format!("touching.{}", contact.name), ""));
    let energies =
        ["energy.kinetic", "energy.potential"].into_iter().chain(model.is_elastic().then_some("energy.elastic"));
    let mut channels = [
        Channel::all(Field::Time, [("t", "s")]),
        Channel::all(Field::Q, positions),
        Channel::all(Field::V, names::dofs(model, "v", "m/s", "rad/s")),
        Channel::all(Field::Torque, names::joints(model, "torque", "Nm")),
        Channel::all(Field::Com, names::vector(model, "com", "m")),
        Channel::all(Field::ComVelocity, names::vector(model, "com_velocity", "m/s")),
        Channel::all(Field::Torso, [("torso", "rad"), ("torso_velocity", "rad/s")]),
        Channel::all(Field::Feet, names::contacts(model, "foot", "m")),
        Channel::all(Field::Touching, touching),
        Channel::all(Field::Energy, energies.map(|name| (name, "J"))),
        controller.channels(),
        plant.channels(),
    ]
    .concat();
    if controller.reference().is_some() {
        channels.extend(reference_channels(model));
    }
    channels
}

fn reference_channels(model: &Robot) -> Vec<Channel> {
    let feet = model.feet.iter().take(2).flat_map(|foot| names::motion(model, &format!("foot_reference.{foot}")));
    let across = if model.is_planar() { 1 } else { 2 };
    let torso = [("", "rad"), ("_velocity", "rad/s"), ("_acceleration", "rad/s2")];
    let mut channels = [
        Channel::all(Field::ComReference, names::motion(model, "com_reference")),
        Channel::all(Field::Xcom, ["xcom", "xcom_y"].into_iter().take(across).map(|name| (name, "m"))),
        Channel::all(Field::TorsoReference, torso.map(|(suffix, unit)| (format!("torso_reference{suffix}"), unit))),
        Channel::all(Field::FeetReference, feet),
        Channel::all(Field::Swing, [("swing", ""), ("swing_since", "s")]),
    ]
    .concat();
    if FootRows::of(model).iter().any(|rows| !rows.angular.is_empty()) {
        let places = ["cop_reference", "xcom_reference", "cop", "zmp", "zmp_wanted", "cmp", "xcom_margin"];
        channels.extend(Channel::all(Field::Balance, places.map(|name| (name, "m"))));
        channels.extend(Channel::all(Field::Balance, [("capture_steps", "")]));
        if !model.is_planar() {
            let across = places[..6].iter().map(|name| (format!("{name}_y"), "m"));
            channels.extend(Channel::all(Field::Balance, across));
        }
    }
    channels
}

/// Writes the true state down.
pub(crate) fn state(record: &mut Record<'_>, model: &Robot, truth: &Sensed, dynamics: &Dynamics) {
    record.set(Field::Time, [truth.time]);
    record.set(Field::Q, truth.q.iter().copied());
    record.set(Field::V, truth.v.iter().copied());
    record.set(Field::Com, along(model, dynamics.com));
    record.set(Field::ComVelocity, along(model, dynamics.com_velocity));
    let turning = dynamics.body_velocity[model.torso].angular;
    let turning = if model.is_planar() {
        model.angular_axes()[0].dot(&turning)
    } else {
        right_of(&model.torso_rotation(dynamics).column(0).into_owned()).dot(&turning)
    };
    record.set(Field::Torso, [model.torso_angle(dynamics, &truth.q), turning]);
    record.set(Field::Feet, dynamics.contact_positions.iter().flat_map(|point| along(model, *point)));
    record.set(Field::Touching, truth.contacts.iter().map(|contact| f64::from(u8::from(contact.touching))));
    let elastic = model.is_elastic().then_some(dynamics.elastic_energy);
    record.set(Field::Energy, [dynamics.kinetic_energy, dynamics.potential_energy].into_iter().chain(elastic));
}

/// Writes a reference down. All of a record's feet are the middles of their contact points, also where the reference is of the
/// toe: what lies between is taken from the true robot.
pub(crate) fn reference(
    record: &mut Record<'_>,
    model: &Model,
    feet: &FeetMotion,
    dynamics: &Dynamics,
    reference: &Reference,
) {
    let motion = |point: PointReference| {
        let parts = [point.position, point.velocity, point.acceleration];
        parts.into_iter().flat_map(move |part| along(model, part))
    };
    let place = |ends: &[usize]| {
        let sum: Vector3<f64> = ends.iter().map(|&contact| dynamics.contact_positions[contact]).sum();
        sum / ends.len() as f64
    };
    let foot = |foot: usize| {
        let (mut point, footing) = (reference.feet[foot].point, reference.footing[foot]);
        if footing.is_on_an_end() {
            point.position += place(feet.contacts(foot)) - place(feet.points(foot, footing));
        }
        motion(point)
    };
    record.set(Field::ComReference, motion(reference.chest.point));
    record.set(Field::Xcom, reference.xcom.into_iter().take(if model.is_planar() { 1 } else { 2 }));
    record.set(Field::TorsoReference, reference.chest.turn.in_plane());
    record.set(Field::FeetReference, [0, 1].into_iter().flat_map(foot));
    let swing = reference.swing.map_or([-1.0, -1.0], |swing| [swing.foot as f64, swing.since]);
    record.set(Field::Swing, swing);
}

/// The components of a vector along the model's linear axes.
fn along(model: &Model, vector: Vector3<f64>) -> impl Iterator<Item = f64> {
    model.linear_axes().iter().map(move |axis| axis.dot(&vector))
}

/// The hash of records, bit by bit, and of the names of their columns.
pub(crate) struct Hasher(Xxh3);

impl Debug for Hasher {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        write!(f, "Hasher({:032x})", self.digest())
    }
}

impl Hasher {
    pub(crate) fn new(columns: &Columns) -> Self {
        let mut hasher = Xxh3::new();
        for channel in columns.channels() {
            hasher.update(channel.name.as_bytes());
            hasher.update(&[0]);
        }
        Self(hasher)
    }

    pub(crate) fn add(&mut self, record: &[f64]) {
        for value in record {
            self.0.update(&value.to_bits().to_le_bytes());
        }
    }

    pub(crate) fn digest(&self) -> u128 {
        self.0.digest128()
    }
}

/// The input hash of a run in which a setting was changed before `tick`.
pub(crate) fn changed(input_hash: u128, tick: u64, path: &str, value: &str) -> u128 {
    xxh3_128(format!("{input_hash:032x} {tick} {path}={value}").as_bytes())
}
