//! The quadratic program (thesis 4.4): from goals to joint accelerations, ground reaction forces and torques.
//!
//! ```text
//! minimise    q̈ᵀ C_v q̈ + ρᵀ C_ρ ρ + τᵀ C_τ τ  +  s_mᵀ C_m s_m + s_fᵀ C_f s_f + s_aᵀ C_a s_a     (4.23) (4.28)
//! subject to  M q̈ + h = S_τ τ + Jᵀ ρ                                                            (4.8)
//!             Ȧ q̇ + A q̈ + s_m = ḣ_D,   J̇ q̇ + J q̈ + s_f = p̈_D,   S_c q̈ + s_a = α_D             (4.17) (4.19) (4.20)
//!             ρ = 0 where there is no contact,   Q_c ρ ≤ 0                                      (4.10) (4.16)
//!             |τ| ≤ τ_max,   |ρ| ≤ ρ_max,   braking distance of each joint                      (4.32)
//! ```
//!
//! Building the program, solving it and reading the solution are three functions: [`build`],
//! [`legwork_qp::Solver::solve`] and [`read_solution`]. Two forms have the same optimum: `slack` is Appendix B to the
//! letter, `direct` eliminates torques and slack variables.

pub mod bounds;
pub mod constraints;
pub mod controller;
pub mod cost;
pub mod layout;
pub mod limit;
mod solution;
pub mod tasks;

use legwork_qp::Problem;
use legwork_rbd::Dynamics;

use crate::settings::{Limits, Weights};
pub use controller::{Fallback, MomentumController, Part, Tick};
pub use layout::Layout;
use legwork_contract::contact::Surface;
use legwork_contract::feet::{FeetMotion, Footing};
use legwork_contract::robot::Robot;
pub use limit::{Condition, Limit, LimitKind};
pub use solution::{Solution, read_solution};
use tasks::Aim;
pub use tasks::Task;

/// What the program is built from in one tick.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a> {
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
    /// The tasks' laws with the motion reference planner's goals, in the order of [`Layout::tasks`].
    pub aims: &'a [Aim],
    /// Which contacts may carry force.
    pub stance: &'a [bool],
    /// What the feet do.
    pub footing: &'a [Footing],
    /// Largest normal force on each foot [N].
    pub max_load: &'a [f64],
    /// The ground below each contact point, as the controller knows it.
    pub ground: &'a [Surface],
    /// The cost's weights.
    pub weights: &'a Weights,
    /// The bounds.
    pub limits: &'a Limits,
    /// Torques of the tick before [Nm]; none in the first.
    pub torque_before: Option<&'a [f64]>,
    /// Time between two ticks [s].
    pub period: f64,
    /// What gives way.
    pub relaxed: Relaxation,
}

/// What gives way in the program when it is infeasible as it stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Relaxation {
    /// The bound on a braking joint's acceleration (4.32) becomes a cost.
    pub joint_limits: bool,
    /// The largest joint accelerations are no bounds.
    pub accelerations: bool,
    /// Hard tasks become costs.
    pub tasks: bool,
}

/// Writes the program of this tick into `problem`, whose size is that of `layout`.
pub fn build(layout: &Layout, inputs: &Inputs<'_>, problem: &mut Problem) {
    problem.reset();
    constraints::dynamics(layout, inputs, problem);
    constraints::friction(layout, inputs, problem);
    constraints::tasks(layout, inputs, problem);
    constraints::complementarity(layout, inputs, problem);
    cost::operating(layout, inputs, problem);
    cost::tracking(layout, inputs, problem);
    bounds::forces(layout, inputs, problem);
    bounds::torques(layout, inputs, problem);
    bounds::accelerations(layout, inputs, problem);
}
