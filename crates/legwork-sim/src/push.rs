//! Forces that act on the robot for a time.

use legwork_rbd::{Dynamics, Model};
use nalgebra::Vector3;

use crate::settings::Push;
use legwork_contract::error::Error;

/// Where a push acts.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    /// On the centre of mass of the whole robot.
    CentreOfMass,
    /// On a point of a body, in its frame [m].
    Body { body: usize, point: Vector3<f64> },
}

/// The pushes of a scenario, resolved for a model.
#[derive(Clone, Debug)]
pub struct Pushes {
    pushes: Vec<(Push, Place, Vector3<f64>)>,
}

impl Pushes {
    /// Finds the bodies that the pushes name.
    ///
    /// # Errors
    /// A body that the model does not have.
    pub fn new(pushes: &[Push], model: &Model) -> Result<Self, Error> {
        let resolve = |(index, push): (usize, &Push)| {
            let place = if push.at == "com" {
                Place::CentreOfMass
            } else {
                let body = model.body_index(&push.at).ok_or_else(|| {
                    let names: Vec<&str> =
                        model.bodies.iter().filter(|body| body.mass > 0.0).map(|body| body.name.as_str()).collect();
                    Error::invalid(
                        format!("pushes.{index}.at"),
                        format!("found '{}'; valid are com, {}", push.at, names.join(", ")),
                    )
                })?;
                Place::Body { body, point: model.bodies[body].com + Vector3::from(push.point_m) }
            };
            let direction = push.direction();
            if model.is_planar() && direction.y != 0.0 {
                let problem = format!("found {}; valid is 0 for a planar robot", push.heading_deg);
                return Err(Error::invalid(format!("pushes.{index}.heading_deg"), problem));
            }
            Ok((push.clone(), place, push.force_n * direction))
        };
        let pushes = pushes.iter().enumerate().map(resolve).collect::<Result<_, Error>>()?;
        Ok(Self { pushes })
    }

    /// Adds the generalized force of all pushes that act at `time` [s] to `force`, and returns their sum [N].
    ///
    /// `period` is the time step [s]: a push that covers a part of it acts with that share of its force, so that its
    /// impulse is exact.
    pub fn add(&self, dynamics: &Dynamics, time: f64, period: f64, force: &mut [f64]) -> Vector3<f64> {
        let mut total = Vector3::zeros();
        for (push, place, whole) in &self.pushes {
            let end = push.start_s + push.duration_s;
            let share = ((time + period).min(end) - time.max(push.start_s)) / period;
            // What rounding leaves of a step that the push does not reach.
            if share < 1e-9 {
                continue;
            }
            let vector = if share > 1.0 - 1e-9 { *whole } else { whole * share };
            total += vector;
            match place {
                Place::CentreOfMass => dynamics.add_com_force(&vector, force),
                Place::Body { body, point } => {
                    let world = dynamics.world_from_body[*body].point(point);
                    dynamics.add_point_force(*body, &world, &vector, force);
                }
            }
        }
        total
    }
}
