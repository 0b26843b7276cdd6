//! Forces that act on the robot for a time.

use legwork_rbd::words::{list, quoted};
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
    timetable: Timetable,
}

/// Which of many pushes act, for one who asks as time goes on: what is over or still to come is not looked at.
#[derive(Clone, Debug, Default)]
pub struct Timetable {
    /// When each begins and ends [s].
    spans: Vec<[f64; 2]>,
    /// Their numbers, by when they begin.
    order: Vec<usize>,
    /// Of these, how many have begun.
    begun: usize,
    /// The numbers of those that have begun and, when it was looked last, were not over; in order.
    acting: Vec<usize>,
    /// The time that was asked for last [s].
    time: f64,
}

impl Timetable {
    /// The timetable of the `pushes`.
    pub fn new(pushes: &[Push]) -> Self {
        let spans: Vec<_> = pushes.iter().map(|push| [push.start_s, push.start_s + push.duration_s]).collect();
        let mut order: Vec<_> = (0..spans.len()).collect();
        order.sort_by(|&a, &b| spans[a][0].total_cmp(&spans[b][0]));
        Self { acting: Vec::with_capacity(spans.len()), spans, order, begun: 0, time: f64::NEG_INFINITY }
    }

    /// The numbers of the pushes that act at some time between `from` and `to` [s], in order. Allocates nothing. To ask for
    /// an earlier time than before takes as long as there are pushes.
    pub fn acting(&mut self, [from, to]: [f64; 2]) -> &[usize] {
        if from < self.time {
            self.begun = 0;
            self.acting.clear();
        }
        self.time = from;
        self.acting.retain(|&push| self.spans[push][1] > from);
        while let Some(&push) = self.order.get(self.begun).filter(|&&push| self.spans[push][0] < to) {
            self.begun += 1;
            if self.spans[push][1] > from {
                let place = self.acting.partition_point(|&other| other < push);
                self.acting.insert(place, push);
            }
        }
        &self.acting
    }
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
                        format!("found {}; valid are com, {}", quoted(&push.at), list(names)),
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
        let timetable = Timetable::new(pushes);
        let pushes = pushes.iter().enumerate().map(resolve).collect::<Result<_, Error>>()?;
        Ok(Self { pushes, timetable })
    }

    /// Adds the generalized force of all pushes that act at `time` [s] to `force`, and returns their sum [N].
    ///
    /// `period` is the time step [s]: a push that covers a part of it acts with that share of its force, so that its
    /// impulse is exact.
    pub fn add(&mut self, dynamics: &Dynamics, time: f64, period: f64, force: &mut [f64]) -> Vector3<f64> {
        let mut total = Vector3::zeros();
        for &index in self.timetable.acting([time, time + period]) {
            let (push, place, whole) = &self.pushes[index];
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn those_that_act_are_found_in_the_order_of_the_list_whatever_that_is() {
        let mut number = 7_u64;
        let mut random = |below: u64| {
            number = number.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (number >> 33) % below
        };
        let mut push = |longest| Push {
            start_s: random(100) as f64 * 0.1,
            duration_s: random(longest) as f64 * 0.1,
            ..Push::default()
        };
        let pushes: Vec<Push> = (0..300).map(|k| push(if k % 10 == 0 { 100 } else { 4 })).collect();
        let mut timetable = Timetable::new(&pushes);
        // Forward, a step back, forward, and to the begin.
        for k in (0..120).chain(119..140).chain(0..3) {
            let [from, to] = [0.083 * f64::from(k), 0.083 * f64::from(k + 1)];
            let acts = |push: &Push| push.start_s < to && push.start_s + push.duration_s > from;
            let expected: Vec<usize> = (0..pushes.len()).filter(|&index| acts(&pushes[index])).collect();
            assert_eq!(timetable.acting([from, to]), expected, "from {from} s");
        }
    }
}
