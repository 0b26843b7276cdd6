//! The tasks of the program, each in a file of its own, and the list of them.
//!
//! A task is `J q̈ + J̇ q̇ + s = goal`, with `s` what it is missed by: in the cost, or zero where it is an equality. A new task is
//! a file with its [`Law`] and an entry in [`laws`]; program, log, diagnosis and report follow the list.

pub mod feet;
pub mod momentum;
pub mod posture;
pub mod torso;

use std::fmt::Debug;
use std::ops::Range;

use legwork_rbd::{Dynamics, Model};
use nalgebra::{DMatrix, DVector};

use super::Inputs;
use crate::generator::Reference;
use crate::settings::{ControllerSettings, Damping, PlannerSettings, Tracking, TrackingSettings};
use legwork_contract::feet::FeetMotion;
use legwork_contract::names;
use legwork_contract::robot::Robot;

/// The tasks that `settings` ask for, in the order of their rows. Thesis (B.1): momentum, feet, torso.
pub fn laws(settings: &ControllerSettings, model: &Robot) -> Vec<Box<dyn Law>> {
    let mut all: Vec<Box<dyn Law>> = vec![
        Box::new(momentum::Momentum),
        Box::new(feet::Feet),
        Box::new(torso::Torso::new(model)),
        Box::new(posture::Posture::new(settings, model)),
    ];
    all.retain(|law| law.how(&settings.tracking) != Tracking::Off);
    all
}

/// How a task's goal, Jacobian and weights come about.
pub trait Law: CloneLaw + Debug + Send + Sync {
    /// The task's name: that of its setting in `controller.tracking` and of its columns in the log, and its word in sentences.
    fn name(&self) -> &'static str;

    /// The task's rows, in their order.
    fn parts(&self, model: &Robot) -> Vec<Part>;

    /// Whether the task is a cost, an equality, or not there at all.
    fn how(&self, tracking: &TrackingSettings) -> Tracking;

    /// Writes the goal of this tick, a number a row, in the units of [`Law::parts`]. Allocates nothing.
    fn plan(&mut self, seen: &Seen<'_>, goal: &mut [f64]);

    /// `J` (rows × nv) and `J̇ q̇` (rows) in the state that was seen last.
    fn motion<'a>(&'a self, dynamics: &'a Dynamics, feet: &'a FeetMotion) -> (&'a DMatrix<f64>, &'a DVector<f64>);

    /// Tells `add` the rows that weigh the same in the cost, and their weight.
    fn weigh(&self, inputs: &Inputs<'_>, goal: &[f64], add: &mut dyn FnMut(Range<usize>, f64));
}

/// Cloning of a [`Law`] that stands in a list; every law that can be cloned has it.
pub trait CloneLaw {
    /// A clone of the law.
    fn clone_law(&self) -> Box<dyn Law>;
}

impl<T: Law + Clone + 'static> CloneLaw for T {
    fn clone_law(&self) -> Box<dyn Law> {
        Box::new(self.clone())
    }
}

impl Clone for Box<dyn Law> {
    fn clone(&self) -> Self {
        self.as_ref().clone_law()
    }
}

/// What a goal is planned from in one tick.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    /// The robot.
    pub model: &'a Robot,
    /// Its dynamics in the present state.
    pub dynamics: &'a Dynamics,
    /// The feet in the present state.
    pub feet: &'a FeetMotion,
    /// Joint positions [rad, m].
    pub q: &'a [f64],
    /// Joint velocities [rad/s, m/s].
    pub v: &'a [f64],
    /// Where to.
    pub reference: &'a Reference,
    /// The gains.
    pub settings: &'a PlannerSettings,
}

/// A law with its latest goal.
#[derive(Clone, Debug)]
pub struct Aim {
    /// How the goal comes about.
    pub law: Box<dyn Law>,
    /// The goal, in the rows of the task.
    pub goal: Vec<f64>,
}

impl Aim {
    pub(crate) fn new(law: Box<dyn Law>, model: &Robot) -> Self {
        Self { goal: vec![0.0; height(&law.parts(model))], law }
    }
}

/// Rows of a task that are one quantity of one thing along the robot's axes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// The quantity in words, as in `momentum rate, linear`.
    pub quantity: &'static str,
    /// The quantity's unit.
    pub unit: &'static str,
    /// Name of the foot or joint that the rows are about; empty where they are about the robot or its torso.
    pub of: String,
    /// For each row, what follows the task's name in that of a column, as in `.linear_x`.
    pub suffixes: Vec<String>,
}

impl Part {
    /// Rows along the angular axes of `model`; their columns' names begin with `stem` after the task's.
    fn angular(model: &Model, quantity: &'static str, unit: &'static str, of: &str, stem: &str) -> Self {
        let suffixes = names::angular(model).iter().map(|axis| format!("{stem}{axis}")).collect();
        Self { quantity, unit, of: of.to_owned(), suffixes }
    }

    /// Rows along the linear axes of `model`.
    fn linear(model: &Model, quantity: &'static str, unit: &'static str, of: &str, stem: &str) -> Self {
        let suffixes = names::linear(model).map(|axis| format!("{stem}_{axis}")).collect();
        Self { quantity, unit, of: of.to_owned(), suffixes }
    }
}

/// A task of the program, as data.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Task {
    /// The task's name, as in `momentum`.
    pub name: &'static str,
    /// Cost or equality.
    pub how: Tracking,
    /// The task's rows among those of all tasks: the places of its slack in [`super::Solution::slack`].
    pub rows: Range<usize>,
    /// The rows by quantity, in their order.
    pub parts: Vec<Part>,
    /// The task's rows in the program; none where the direct form has it in the cost.
    pub constraints: Range<usize>,
    /// The task's slack variables in the program (slack form).
    pub variables: Range<usize>,
}

impl Task {
    /// The task of `law`, with its rows from 0 on and no place in the program yet.
    pub(super) fn new(law: &dyn Law, settings: &ControllerSettings, model: &Robot) -> Self {
        let parts = law.parts(model);
        let (name, how, rows) = (law.name(), law.how(&settings.tracking), 0..height(&parts));
        Self { name, how, rows, parts, constraints: 0..0, variables: 0..0 }
    }

    /// Each part with its rows among those of all tasks.
    pub fn parts(&self) -> impl Iterator<Item = (&Part, Range<usize>)> {
        let mut next = self.rows.start;
        self.parts.iter().map(move |part| {
            next += part.suffixes.len();
            (part, next - part.suffixes.len()..next)
        })
    }

    /// Name and unit of a column for each row, where `name` stands for the task.
    pub fn columns(&self, name: &str) -> Vec<(String, &'static str)> {
        let of = |part: &'_ Part| part.suffixes.iter().map(|suffix| (format!("{name}{suffix}"), part.unit)).collect();
        self.parts.iter().flat_map(|part| -> Vec<_> { of(part) }).collect()
    }
}

/// Number of rows.
fn height(parts: &[Part]) -> usize {
    parts.iter().map(|part| part.suffixes.len()).sum()
}

/// The damping gain that belongs to a stiffness. Thesis 6.3.7: "D = sqrt(2 m P)" is printed as critical; critical is
/// 2 sqrt(m P).
fn damping(settings: &PlannerSettings, inertia: f64, gain: f64) -> f64 {
    match settings.damping {
        Damping::Printed => libm::sqrt(2.0 * inertia * gain),
        Damping::Critical => 2.0 * libm::sqrt(inertia * gain),
    }
}
