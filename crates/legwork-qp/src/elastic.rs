//! What to do where there is no solution: violate as little as possible, and say what.
//!
//! The weighted sum of squared violations of those rows and bounds that may yield is minimised first, and the objective
//! among the points that reach this minimum. Squares rather than absolute values: their minimum is reached by one set of
//! violations only, which moves continuously with the data, so that from tick to tick no row takes turns with another.
//!
//! The method is that of multipliers. With a violation `v` for each yielding row, `l <= a x + v <= u`, and the constraint
//! `v = 0`, each step minimises `f(x) + uᵀv + ½ ρ vᵀW v` and then adds `ρ W v` to `u`. Where no point has `v = 0` the
//! multipliers grow without bound, but `x` and `v` converge, linearly with a rate of order `1/ρ`, to just what is wanted:
//! A. Chiche, J. Ch. Gilbert, *How the augmented Lagrangian algorithm can deal with an infeasible convex quadratic
//! optimization problem*, Journal of Convex Analysis 23 (2016).

use crate::input::variable_unit;
use crate::linear::dot_abs;
use crate::{Conflict, Constraint, Defect, Problem, Side, Solver, Status};

/// `ρ`, in scaled variables, in which `H` has ones on its diagonal. Nearly dependent rows with `σ² = ‖aᵀH⁻¹a‖` settle at the
/// rate `1/(1 + ρσ²)`; much larger values cost digits of `x`.
const PENALTY: f64 = 1e8;
const STEPS: usize = 30;
/// The steps end when no violation has changed by more than this times the largest one, or the largest `∑ |a_j x_j|`.
const SETTLED: f64 = 1e-11;
/// A constraint is given up if its violation is above this times the same.
const GIVEN_UP: f64 = 1e-10;

/// A row or bound that does not hold.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct GivenUp {
    /// Which row or bound.
    pub constraint: Constraint,
    /// Which side of it is violated: `Lower` or `Upper`, of an equality too.
    pub side: Side,
    /// By how much, positive, in the unit of the row or bound.
    pub violation: f64,
}

/// A solver for programs that may be infeasible, allocated once for a size.
///
/// ```
/// use legwork_qp::{Constraint, Elastic, Problem, Side, Status};
///
/// // x >= 3 by a row, x <= 1 by a bound that must hold.
/// let mut problem = Problem::new(1, 1);
/// problem.hessian_mut()[0] = 1.0;
/// problem.row_mut(0)[0] = 1.0;
/// problem.row_lower_mut()[0] = 3.0;
/// problem.upper_mut()[0] = 1.0;
///
/// let mut elastic = Elastic::new(1, 1);
/// elastic.set_yielding(Constraint::Bound(0), false);
/// assert_eq!(elastic.solve(&problem), Status::Optimal);
/// assert!((elastic.x()[0] - 1.0).abs() < 1e-12);
/// let given_up: Vec<_> = elastic.given_up().collect();
/// assert_eq!((given_up[0].constraint, given_up[0].side), (Constraint::Row(0), Side::Lower));
/// assert!((given_up[0].violation - 2.0).abs() < 1e-12);
/// ```
#[derive(Clone, Debug)]
pub struct Elastic {
    n: usize,
    m: usize,
    /// Variables: `x`, then violations of rows and of bounds. Rows: those of the problem, then one for each bound.
    program: Problem,
    solver: Solver,
    /// Of rows, then of bounds.
    yielding: Vec<bool>,
    weights: Vec<f64>,
    violations: Vec<f64>,
    /// The largest violation or `∑ |a_j x_j|`, by the weights' square roots, and the largest step that the gradient asks
    /// for.
    size: f64,
    iterations: u32,
    wrong_size: Option<Defect>,
}

impl Elastic {
    /// For problems of `n` variables and `m` rows, all of which, and all bounds, may yield with the weight 1.
    pub fn new(n: usize, m: usize) -> Self {
        Self {
            n,
            m,
            program: Problem::new(n + m + n, m + n),
            solver: Solver::new(n + m + n, m + n),
            yielding: vec![true; m + n],
            weights: vec![1.0; m + n],
            violations: vec![0.0; m + n],
            size: 0.0,
            iterations: 0,
            wrong_size: None,
        }
    }

    fn index(&self, constraint: Constraint) -> usize {
        match constraint {
            Constraint::Row(i) => i,
            Constraint::Bound(j) => self.m + j,
        }
    }

    /// Whether a row or bound may be violated: the equations of motion may not.
    ///
    /// # Panics
    /// There is no such row or bound.
    pub fn set_yielding(&mut self, constraint: Constraint, yielding: bool) {
        let index = self.index(constraint);
        self.yielding[index] = yielding;
    }

    /// How much a violation counts, beside that of others: a positive number, 1 to begin with.
    ///
    /// Violations are compared in units of the problem itself: `v / |a|`, where the norm of the row is taken in the units
    /// `1/√H_jj` of the variables. A weight multiplies the square of this.
    ///
    /// # Panics
    /// There is no such row or bound, or the weight is not positive and finite.
    pub fn set_weight(&mut self, constraint: Constraint, weight: f64) {
        assert!(weight > 0.0 && weight.is_finite(), "the weight of {constraint} is {weight}, not a positive number");
        let index = self.index(constraint);
        self.weights[index] = weight;
    }

    /// Minimises the violations, and the objective among what is left. Allocates nothing.
    ///
    /// [`Status::Optimal`] says so; [`Status::Infeasible`] that those rows and bounds contradict each other which must not
    /// yield ([`Elastic::conflict`]); [`Status::IterationLimit`] that the violations have not settled or an inner program
    /// was not solved; the others are as for [`Solver::solve`].
    pub fn solve(&mut self, problem: &Problem) -> Status {
        self.violations.fill(0.0);
        self.iterations = 0;
        self.wrong_size = None;
        let (expected, found) = ((self.n, self.m), (problem.n(), problem.m()));
        if expected != found {
            self.wrong_size = Some(Defect::WrongSize { expected, found });
            return Status::InvalidInput;
        }
        self.load(problem);
        self.solver.forget();
        for _ in 0..STEPS {
            let status = self.solver.solve(&self.program);
            self.iterations += self.solver.iterations();
            if status != Status::Optimal {
                return status;
            }
            if self.advance() {
                return Status::Optimal;
            }
        }
        Status::IterationLimit
    }

    fn load(&mut self, problem: &Problem) {
        let (n, m) = (self.n, self.m);
        let width = self.program.n();
        self.program.reset();
        for j in 0..n {
            let row = &problem.hessian()[j * n..(j + 1) * n];
            self.program.hessian_mut()[j * width..j * width + n].copy_from_slice(row);
        }
        self.program.gradient_mut()[..n].copy_from_slice(problem.gradient());
        let steps = (0..n).map(|j| problem.gradient()[j].abs() * variable_unit(problem, j));
        self.size = PENALTY.sqrt() * steps.fold(0.0, f64::max);
        for c in 0..m + n {
            let is_row = c < m;
            let mut squares = 0.0;
            if is_row {
                self.program.row_mut(c)[..n].copy_from_slice(problem.row(c));
                for (j, a) in problem.row(c).iter().enumerate().filter(|(_, a)| a.abs() > 0.0) {
                    squares += (a * variable_unit(problem, j)).powi(2);
                }
            } else {
                squares = variable_unit(problem, c - m).powi(2);
            }
            // A row without an entry has only itself to be compared with.
            let size = if squares > 0.0 { squares } else { 1.0 };
            self.program.hessian_mut()[(n + c) * (width + 1)] = PENALTY * self.weights[c] / size;
            let (lower, upper) = if is_row {
                (problem.row_lower()[c], problem.row_upper()[c])
            } else {
                (problem.lower()[c - m], problem.upper()[c - m])
            };
            if is_row || self.yielding[c] {
                self.program.row_lower_mut()[c] = lower;
                self.program.row_upper_mut()[c] = upper;
            } else {
                self.program.lower_mut()[c - m] = lower;
                self.program.upper_mut()[c - m] = upper;
            }
            if self.yielding[c] {
                self.program.row_mut(c)[n + c] = 1.0;
                if !is_row {
                    self.program.row_mut(c)[c - m] = 1.0;
                }
            } else {
                self.program.lower_mut()[n + c] = 0.0;
                self.program.upper_mut()[n + c] = 0.0;
            }
        }
    }

    /// Multipliers of the next step. True if the violations have settled.
    fn advance(&mut self) -> bool {
        let (n, width) = (self.n, self.program.n());
        let (x, found) = self.solver.x().split_at(n);
        let (mut change, mut size) = (0.0_f64, self.size);
        for c in 0..found.len() {
            let weight = self.program.hessian()[(n + c) * (width + 1)];
            self.program.gradient_mut()[n + c] += weight * found[c];
            let unit = weight.sqrt();
            change = change.max(unit * (found[c] - self.violations[c]).abs());
            size = size.max(unit * (found[c].abs() + dot_abs(&self.program.row(c)[..n], x)));
        }
        self.violations.copy_from_slice(found);
        self.size = size;
        change <= SETTLED * size
    }

    /// The solution, length n.
    pub fn x(&self) -> &[f64] {
        &self.solver.x()[..self.n]
    }

    /// The rows and bounds that are violated: rows first, in order.
    pub fn given_up(&self) -> impl Iterator<Item = GivenUp> + '_ {
        let (n, width) = (self.n, self.program.n());
        let unit = move |c: usize| self.program.hessian()[(n + c) * (width + 1)].sqrt();
        let is_given_up = move |&c: &usize| unit(c) * self.violations[c].abs() > GIVEN_UP * self.size;
        (0..self.violations.len()).filter(is_given_up).map(|c| GivenUp {
            constraint: self.constraint(c),
            side: if self.violations[c] > 0.0 { Side::Lower } else { Side::Upper },
            violation: self.violations[c].abs(),
        })
    }

    /// After [`Status::Infeasible`]: those of the rows and bounds which must not yield that contradict each other.
    pub fn conflict(&self) -> impl Iterator<Item = Conflict> + '_ {
        self.solver.conflict().map(|conflict| match conflict.constraint {
            Constraint::Row(c) => Conflict { constraint: self.constraint(c), ..conflict },
            Constraint::Bound(_) => conflict,
        })
    }

    /// Changes of the working set in the last solve, all steps together.
    pub fn iterations(&self) -> u32 {
        self.iterations
    }

    /// After [`Status::InvalidInput`]: what is wrong, and where.
    pub fn defect(&self) -> Option<Defect> {
        let own = |constraint| if let Constraint::Row(c) = constraint { self.constraint(c) } else { constraint };
        self.wrong_size.or_else(|| {
            self.solver.defect().map(|defect| match defect {
                Defect::Bound(constraint) => Defect::Bound(own(constraint)),
                Defect::Crossed(constraint) => Defect::Crossed(own(constraint)),
                other => other,
            })
        })
    }

    fn constraint(&self, c: usize) -> Constraint {
        if c < self.m { Constraint::Row(c) } else { Constraint::Bound(c - self.m) }
    }
}
