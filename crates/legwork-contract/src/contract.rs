//! The contract between a controller and whatever moves the robot: [`Sensed`] goes in, [`Command`] comes out.

use legwork_rbd::Model;

use crate::error::Error;

/// The largest magnitude of a position, a velocity or a load that a controller takes in [m, rad, m/s, rad/s, N]: what is beyond it is
/// no state of a robot.
pub const MOST: f64 = 1e6;

fn is_sound(value: f64) -> bool {
    value.abs() <= MOST
}

/// What a controller is told of the robot in a tick. Whoever runs the controller provides it: the simulator through its
/// sensors, a real robot through a state estimator.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensed {
    /// Time since the run began [s]. It increases from tick to tick; generators take their durations from it.
    pub time: f64,
    /// Joint positions (nq) [rad, m], of a floating base a unit quaternion and a position. A delay or an error is the
    /// controller's to bear; lengths that are not the model's and numbers that are not sound are refused by
    /// [`Sensed::check`]. A controller that meets them nevertheless refuses the sample: it holds the torques of the tick before, says
    /// so in its report of the tick, and goes on with the next.
    pub q: Vec<f64>,
    /// Joint velocities (nv) [rad/s, m/s], under the same terms.
    pub v: Vec<f64>,
    /// What the contact points feel, in the order of the model's.
    pub contacts: Vec<ContactSensed>,
}

/// What a contact point feels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactSensed {
    /// Whether it touches the ground: it is no higher than some millimetres, or bears more than some newtons. The simulator says so
    /// below a height, `simulation.contact.flag_height_m`, or above a force (`simulation.sensors`); a robot above a pressure. A
    /// `false` where it stands is borne as long as the point stays where it was (`controller.lift_height_m`).
    pub touching: bool,
    /// Vertical force on it [N], the mean of the control period before; zero in the first tick. Generators that wait for a
    /// touchdown compare it with a force of some 20 N. Where nothing measures it, zero on all points will do: the points that
    /// touch then share the weight.
    pub load: f64,
}

/// What a controller asks for in a tick.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Command {
    /// Torques of the actuated joints, in the order of [`Model::actuated`] [Nm]: finite, and within the limits of the
    /// controller that gives them. They hold until the next tick.
    pub torque: Vec<f64>,
}

impl Sensed {
    /// A robot in its zero position at time zero, whose contact points feel nothing: storage to be written to.
    pub fn new(model: &Model) -> Self {
        Self {
            time: 0.0,
            q: model.neutral().as_slice().to_vec(),
            v: vec![0.0; model.nv()],
            contacts: vec![ContactSensed::default(); model.contacts.len()],
        }
    }

    /// Whether its lengths are those of `model` and all its numbers are sound: finite, and but for the time at most [`MOST`].
    /// Allocates nothing.
    pub fn fits(&self, model: &Model) -> bool {
        let sizes = [self.q.len(), self.v.len(), self.contacts.len()] == [model.nq(), model.nv(), model.contacts.len()];
        sizes && self.time.is_finite() && self.values().all(is_sound)
    }

    /// # Errors
    /// A length that is not that of `model`, or a number that is not sound, by the name of its field.
    pub fn check(&self, model: &Model) -> Result<(), Error> {
        let sizes = [
            ("q", self.q.len(), model.nq()),
            ("v", self.v.len(), model.nv()),
            ("contacts", self.contacts.len(), model.contacts.len()),
        ];
        if let Some((field, found, valid)) = sizes.into_iter().find(|(_, found, valid)| found != valid) {
            let problem = format!("found {found} values; the model '{}' has {valid}", model.name);
            return Err(Error::invalid(format!("sensed.{field}"), problem));
        }
        let names = model.q_names().into_iter().map(|name| format!("q of {name}"));
        let names = names.chain(model.v_names().into_iter().map(|name| format!("v of {name}")));
        let names = names.chain(model.contacts.iter().map(|contact| format!("load of {}", contact.name)));
        if !self.time.is_finite() {
            return Err(Error::invalid("sensed", format!("found time = {}; valid are finite numbers", self.time)));
        }
        match names.zip(self.values()).find(|(_, value)| !is_sound(*value)) {
            Some((name, value)) => {
                let problem = format!("found {name} = {value}; valid are finite numbers of at most {MOST:e}");
                Err(Error::invalid("sensed", problem))
            }
            None => Ok(()),
        }
    }

    fn values(&self) -> impl Iterator<Item = f64> + '_ {
        self.q.iter().chain(&self.v).copied().chain(self.contacts.iter().map(|contact| contact.load))
    }
}
