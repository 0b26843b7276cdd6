//! A dense dual active-set solver for the small quadratic programs of whole-body control.
//!
//! # The program
//!
//! ```text
//! minimise    ½ xᵀH x + gᵀx
//! subject to  row_lower <= A x <= row_upper
//!                 lower <=  x  <= upper
//! ```
//!
//! with some 10 to 60 variables and 10 to 100 rows. Bounds may be infinite; lower = upper makes an equality, or a fixed
//! variable. `x` is optimal if and only if multipliers `λ` of the rows and `μ` of the bounds exist with
//!
//! ```text
//! H x + g = Aᵀλ + μ
//! λ_i >= 0 where the row is at its lower side, <= 0 at its upper side, = 0 between, of any sign at an equality; μ alike
//! ```
//!
//! ```
//! use legwork_qp::{Problem, Solver, Status};
//!
//! // The point next to (2, 1) with x + y <= 2 and y >= 0.8.
//! let mut problem = Problem::new(2, 1);
//! problem.hessian_mut().copy_from_slice(&[1.0, 0.0, 0.0, 1.0]);
//! problem.gradient_mut().copy_from_slice(&[-2.0, -1.0]);
//! problem.row_mut(0).copy_from_slice(&[1.0, 1.0]);
//! problem.row_upper_mut()[0] = 2.0;
//! problem.lower_mut()[1] = 0.8;
//!
//! let mut solver = Solver::new(2, 1);
//! assert_eq!(solver.solve(&problem), Status::Optimal);
//! let near = |a: f64, b: f64| (a - b).abs() < 1e-14;
//! assert!(near(solver.x()[0], 1.2) && near(solver.x()[1], 0.8));
//! // The row is at its upper side, the bound at its lower.
//! assert!(near(solver.row_multipliers()[0], -0.8) && near(solver.bound_multipliers()[1], 0.6));
//! assert!(problem.kkt(solver.x(), solver.row_multipliers(), solver.bound_multipliers()).worst_relative() < 1e-14);
//! ```
//!
//! # The method
//!
//! That of D. Goldfarb and A. Idnani, *A numerically stable dual method for solving strictly convex quadratic programs*,
//! Mathematical Programming 27 (1983), with factors of another kind. In the variables `y = Lᵀx`, `H = L Lᵀ`, the Hessian is
//! the identity, and a constraint's normal is `L⁻¹a`. Of the normals `L⁻¹N` of a working set a thin factorisation `Q R` is
//! kept (Daniel, Gragg, Kaufman and Stewart, 1976): `Q` has as many columns as there are members. Point and multipliers
//! follow from triangular systems with `R`:
//!
//! ```text
//! Rᵀ t = b,   y = Q t − (1 − QQᵀ) L⁻¹g,   R λ = t + Qᵀ L⁻¹g
//! ```
//!
//! Each violated constraint enters by Gram-Schmidt orthogonalisation; on the way constraints leave, by rotations, whose
//! multiplier reaches zero. The dual objective rises with each entry, so that no working set comes back. Zeros are made use
//! of by extent: rows, normals and columns of `Q` keep the range of their nonzero entries, and a block-diagonal Hessian is
//! factorised block by block.
//!
//! In this order:
//! 1. Scaling: variables by `√H_jj` (Jacobi), rows to unit norm, by powers of two, which round nothing.
//! 2. Slacks: a variable without bounds, with a cost `½ h s² + g_s s` of its own, that only one row contains, an equality
//!    `aᵀx + e s = b`, is replaced by the cost `½ (h/e²) (b − aᵀx)² + (g_s/e) (b − aᵀx)`, and the row with it. The answer is that
//!    of the program as given, with the row's multiplier and in the working set; where the weights differ by so much that
//!    the new Hessian is nearly singular, the slacks stay.
//! 3. Equalities: fixed variables, then rows, the clearly independent ones first. Those that follow from others are left
//!    out, checked against the solution, and have the multiplier zero.
//! 4. A guess, as far as it is independent: the working set of the previous solve, of the last optimum of the same contact
//!    mode ([`Solver::select_mode`]), or one of one's own ([`Solver::start_from`]). Negative multipliers are dropped. Optimal
//!    working sets of control ticks change little, so this is most often all.
//! 5. Violated constraints, the largest violation of the scaled program first.
//! 6. One step of iterative refinement of point and multipliers with the program's own numbers, after which nothing may be
//!    violated and no multiplier negative. With a guess it comes first: most often it then is the last step too.
//!
//! # What is not there
//!
//! **No regularisation.** If the scaled `H` is not positive definite (a pivot of its Cholesky factorisation is below
//! 64 n ε), the squares of the equalities are added, once: `H + Âᵀ Â` and `g − Âᵀ b̂` in place of `H` and `g`, with the scaled
//! equality rows and fixed variables. If the diagonal of `H` has zeros, there are two shorter ways: where each variable
//! without a cost stands in one row only, an equality, this row defines it, and its bounds become those of a row of the
//! others, with the same optimum and multipliers; else the squares are tried first of those equalities alone that contain
//! such a variable. On the feasible set this adds a constant to the objective, so optimum and
//! multipliers stay those of the program as given. [`Solver::convexified`] tells. If that is not positive definite
//! either: [`Status::NotConvex`].
//!
//! **No unproven infeasibility.** [`Status::Infeasible`] comes with weights ([`Solver::conflict`]) that sum the rows and
//! bounds to a contradiction, and with the check that rounding errors cannot have made it. Where that fails the row is set
//! aside, and the status at the end is [`Status::Optimal`] or [`Status::IterationLimit`] according to what is left of its
//! violation.
//!
//! **No way out hidden in the solver.** An infeasible program is answered with its certificate. Who would rather have the
//! point that violates least asks [`Elastic`], which names what it gave up.
//!
//! **No allocation** in [`Solver::solve`], no threads, no random numbers: the same problems in the same order give the same
//! bits.
#![forbid(unsafe_code)]

mod certificate;
mod dual;
mod elastic;
mod factor;
mod hessian;
mod input;
mod kkt;
mod lanes;
mod linear;
mod modes;
mod problem;
mod replaced;
mod scale;
mod solver;
mod start;
mod types;
mod whitening;
mod working_set;

pub use elastic::{Elastic, GivenUp};
pub use kkt::{KktResiduals, Residual};
pub use problem::Problem;
pub use solver::Solver;
pub use types::{Active, Conflict, Constraint, Defect, Settings, Side, Status};
