//! Ahead of what is told late: where a delay is known, a tick works for the state in which its torques will act.
//!
//! The state is told late, and torques act late; both are one here, and so is a lag, which to slow motion is a delay of its time constant.
//! Over that time the state is carried on with the accelerations that the ticks in between have planned: a Smith predictor whose
//! model is the program. To invert a lag instead asks for ten times what noise changes of the torque (lag 10 ms, tick 1 ms).

use std::collections::VecDeque;

use legwork_contract::contract::Sensed;
use legwork_contract::robot::Robot;
use legwork_rbd::Dynamics;

/// The state carried on over the delay.
#[derive(Clone, Debug)]
pub(crate) struct Prediction {
    /// Accelerations that the latest ticks have planned, the oldest first: as many as the delay has.
    planned: VecDeque<Vec<f64>>,
    period: f64,
    sensed: Sensed,
    dynamics: Dynamics,
    mean: Vec<f64>,
    position: Vec<f64>,
}

impl Prediction {
    /// Over `delay` [s] in ticks of `period` [s]; none where that is less than half a tick.
    pub(crate) fn over(delay: f64, period: f64, model: &Robot) -> Option<Self> {
        let ticks = (delay / period).round() as usize;
        (ticks > 0).then(|| Self {
            planned: std::iter::repeat_n(vec![0.0; model.nv()], ticks).collect(),
            period,
            sensed: Sensed::new(model),
            dynamics: Dynamics::new(model),
            mean: vec![0.0; model.nv()],
            position: vec![0.0; model.nq()],
        })
    }

    /// What will be sensed when the torques of this tick act, and the dynamics then, where `told` is what is told now. Contacts are those
    /// that are told. Allocates nothing.
    pub(crate) fn ahead(&mut self, model: &Robot, told: &Sensed) -> (&Sensed, &Dynamics) {
        let Self { planned, period, sensed, dynamics, mean, position } = self;
        sensed.time = told.time;
        sensed.q.copy_from_slice(&told.q);
        sensed.v.copy_from_slice(&told.v);
        sensed.contacts.copy_from_slice(&told.contacts);
        for acceleration in &*planned {
            for ((mean, v), acceleration) in mean.iter_mut().zip(&mut sensed.v).zip(acceleration) {
                let before = *v;
                *v += *period * acceleration;
                *mean = 0.5 * (before + *v);
            }
            model.integrate(&sensed.q, mean, *period, position);
            sensed.q.copy_from_slice(position);
        }
        dynamics.update(model, &sensed.q, &sensed.v);
        (sensed, dynamics)
    }

    /// Takes in the accelerations that this tick has planned.
    pub(crate) fn follow(&mut self, planned: &[f64]) {
        self.planned.rotate_left(1);
        self.planned.back_mut().expect("at least one tick").copy_from_slice(planned);
    }
}
