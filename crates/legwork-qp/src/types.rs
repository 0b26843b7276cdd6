//! The words of the answer: status, working set, conflict, and what can be wrong with a problem.

use std::fmt;

/// How a solve ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Status {
    /// `x` and the multipliers satisfy the optimality conditions.
    ///
    /// No row is violated by more than [`Settings::feasibility_tolerance`] says, or, where rounding errors kept the last
    /// steps from making progress, by more than ten times that tolerance times `|b| + ∑ |a_j x_j|`. Bounds of variables
    /// hold exactly. [`Problem::kkt`](crate::Problem::kkt) tells what was reached.
    Optimal,
    /// No `x` satisfies all rows and bounds. [`Solver::conflict`](crate::Solver::conflict) holds the certificate.
    Infeasible,
    /// Stopped before all rows and bounds were satisfied, by [`Settings::max_iterations`] or because rounding errors left
    /// no step to take.
    ///
    /// The iterate is usable: `x` is the optimum of the program that keeps only the rows and bounds of the working set,
    /// its multipliers have the right signs, its objective is a lower bound of the optimum; it violates some other row or
    /// bound.
    IterationLimit,
    /// `H`, with the equality rows added to it as the crate's documentation says, is not positive definite.
    NotConvex,
    /// The data are not a program: see [`Solver::defect`](crate::Solver::defect).
    InvalidInput,
}

/// What a user may set.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Changes of the working set before the solver gives up with [`Status::IterationLimit`]. Default 1000; programs of
    /// whole-body control take about as many as rows and bounds are active.
    pub max_iterations: u32,
    /// A row `a` with bound `b` counts as violated when it is so by more than this times `|b| + 0.001 ∑ |a_j x_j|`, plus
    /// the rounding error that `x` must be expected to carry. A row without a nonzero entry: by more than this, absolutely.
    /// Default 1e-10.
    pub feasibility_tolerance: f64,
    /// Start from the working set of the previous solve. Default true.
    pub warm_start: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self { max_iterations: 1000, feasibility_tolerance: 1e-10, warm_start: true }
    }
}

/// A row of `A` or the bounds of a variable.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub enum Constraint {
    /// `row_lower[i] <= (A x)[i] <= row_upper[i]`.
    Row(usize),
    /// `lower[j] <= x[j] <= upper[j]`.
    Bound(usize),
}

/// The side on which a constraint holds `x`.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Side {
    /// At its lower bound: multiplier >= 0.
    Lower,
    /// At its upper bound: multiplier <= 0.
    Upper,
    /// Lower and upper bound are the same number: multiplier of any sign.
    Equal,
}

/// A member of the working set.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Active {
    /// Which row or bound.
    pub constraint: Constraint,
    /// On which side.
    pub side: Side,
}

/// A member of a certificate of infeasibility.
///
/// With `s = +1` for a lower and `−1` for an upper side, `a` the row (or unit vector) and `b` the bound at that side, every
/// feasible `x` has `s aᵀx >= s b`. In a certificate `∑ weight s a = 0` up to rounding errors and `∑ weight s b > 0`
/// (Farkas), which no `x` can satisfy.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Conflict {
    /// Which row or bound.
    pub constraint: Constraint,
    /// The side that takes part, `Lower` or `Upper`, of an equality too.
    pub side: Side,
    /// Farkas weight, positive; the largest of a certificate is 1. In the inverse unit of the row or bound.
    pub weight: f64,
}

/// Why a problem is no program.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Defect {
    /// The problem has not the size that the solver was made for; sizes are (variables, rows).
    WrongSize {
        /// Of the solver.
        expected: (usize, usize),
        /// Of the problem.
        found: (usize, usize),
    },
    /// An entry of `H` is NaN or infinite.
    Hessian {
        /// Its row.
        row: usize,
        /// Its column.
        column: usize,
    },
    /// `H[row, column]` and `H[column, row]` differ by more than rounding errors.
    Asymmetric {
        /// The larger index.
        row: usize,
        /// The smaller index.
        column: usize,
    },
    /// An entry of `g` is NaN or infinite.
    Gradient {
        /// Its index.
        index: usize,
    },
    /// An entry of `A` is NaN or infinite.
    Row {
        /// Its row.
        row: usize,
        /// Its column.
        column: usize,
    },
    /// A bound is NaN, a lower one is +∞ or an upper one −∞.
    Bound(Constraint),
    /// The lower bound is above the upper one.
    Crossed(Constraint),
    /// The numbers are so large that their products overflow.
    Overflow,
}

impl fmt::Display for Constraint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Row(i) => write!(f, "row {i}"),
            Self::Bound(j) => write!(f, "bounds of variable {j}"),
        }
    }
}

impl fmt::Display for Defect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::WrongSize { expected, found } => write!(
                f,
                "the solver was made for {} variables and {} rows, the problem has {} and {}",
                expected.0, expected.1, found.0, found.1
            ),
            Self::Hessian { row, column } => write!(f, "entry ({row}, {column}) of the Hessian is not a finite number"),
            Self::Asymmetric { row, column } => {
                write!(f, "entries ({row}, {column}) and ({column}, {row}) of the Hessian differ")
            }
            Self::Gradient { index } => {
                write!(f, "entry {index} of the gradient is not a finite number")
            }
            Self::Row { row, column } => {
                write!(f, "entry {column} of row {row} is not a finite number")
            }
            Self::Bound(constraint) => {
                write!(f, "{constraint}: NaN, or an infinity of the wrong sign")
            }
            Self::Crossed(constraint) => {
                write!(f, "{constraint}: the lower bound is above the upper one")
            }
            Self::Overflow => write!(f, "the numbers are so large that their products overflow"),
        }
    }
}
