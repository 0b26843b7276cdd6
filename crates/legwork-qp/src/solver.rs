//! The solver as its user sees it: from a [`Problem`] to `x`, multipliers, working set or conflict.

use crate::certificate::side;
use crate::dual::Search;
use crate::linear::axpy;
use crate::scale::{Kind, Scaled};
use crate::working_set::{Member, WorkingSet};
use crate::{Active, Conflict, Defect, Problem, Settings, Side, Status};

/// Workspace and result of a solve, allocated once for a size.
#[derive(Clone, Debug)]
pub struct Solver {
    settings: Settings,
    program: Scaled,
    set: WorkingSet,
    /// Inequalities in the working set of the previous solve.
    previous: Vec<Member>,
    /// Members with Farkas weights.
    conflict: Vec<(Member, f64)>,
    x: Vec<f64>,
    row_multipliers: Vec<f64>,
    bound_multipliers: Vec<f64>,
    iterations: u32,
    convexified: bool,
    defect: Option<Defect>,
}

impl Solver {
    /// A solver for problems of `n` variables and `m` rows.
    pub fn new(n: usize, m: usize) -> Self {
        Self::with_settings(n, m, Settings::default())
    }

    /// The same with settings of one's own.
    pub fn with_settings(n: usize, m: usize, settings: Settings) -> Self {
        Self {
            settings,
            program: Scaled::new(n, m),
            set: WorkingSet::new(n, m),
            previous: Vec::with_capacity(n),
            conflict: Vec::with_capacity(n + 1),
            x: vec![0.0; n],
            row_multipliers: vec![0.0; m],
            bound_multipliers: vec![0.0; n],
            iterations: 0,
            convexified: false,
            defect: None,
        }
    }

    /// The settings in force.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Solves without allocating. Starts from the working set of the previous solve unless the settings say otherwise.
    ///
    /// After [`Status::Optimal`] and [`Status::IterationLimit`] `x` and the multipliers are as the status says, after
    /// [`Status::Infeasible`] those of the last working set, otherwise zero. The same problems in the same order give the
    /// same bits.
    pub fn solve(&mut self, problem: &Problem) -> Status {
        self.x.fill(0.0);
        self.row_multipliers.fill(0.0);
        self.bound_multipliers.fill(0.0);
        self.conflict.clear();
        self.set.members.clear();
        self.iterations = 0;
        self.convexified = false;
        self.defect = self.program.load(problem).err();
        if self.defect.is_some() {
            return Status::InvalidInput;
        }
        if !self.factorise() {
            return Status::NotConvex;
        }
        if !self.settings.warm_start {
            self.previous.clear();
        }
        let mut search = Search {
            program: &self.program,
            set: &mut self.set,
            settings: &self.settings,
            convexified: self.convexified,
            conflict: &mut self.conflict,
            iterations: 0,
            refined: false,
        };
        let status = search.run(&self.previous);
        self.iterations = search.iterations;
        self.previous.clear();
        self.previous.extend_from_slice(&self.set.members[self.set.equalities..]);
        self.take_result(problem, status)
    }

    /// Factorises the scaled Hessian; if that is not positive definite, with the equalities added to it.
    fn factorise(&mut self) -> bool {
        let program = &self.program;
        let factor = &mut self.set.factor;
        factor.matrix_mut().copy_from_slice(&program.hessian);
        if factor.factorise(&program.gradient) {
            return true;
        }
        // H + ∑ a aᵀ and g − ∑ b a over the equalities aᵀz = b: on the feasible set this changes the objective by a constant.
        self.convexified = true;
        let n = program.n;
        // x serves as the place for the gradient.
        self.x.copy_from_slice(&program.gradient);
        let matrix = factor.matrix_mut();
        matrix.copy_from_slice(&program.hessian);
        for c in (0..program.constraints()).filter(|&c| program.kind[c] == Kind::Equality) {
            program.add_to(c, -program.lower[c], &mut self.x);
            if c < program.m {
                let row = program.row(c);
                for (column, a) in matrix.chunks_exact_mut(n).zip(row) {
                    axpy(*a, row, column);
                }
            } else {
                let j = c - program.m;
                matrix[j * n + j] += 1.0;
            }
        }
        let definite = factor.factorise(&self.x);
        self.x.fill(0.0);
        definite
    }

    /// Back to the units of the problem.
    fn take_result(&mut self, problem: &Problem, status: Status) -> Status {
        let (program, set) = (&self.program, &self.set);
        for (x, (z, unit)) in self.x.iter_mut().zip(set.z.iter().zip(&program.unit)) {
            *x = z * unit;
        }
        if !self.x.iter().chain(&set.multipliers).all(|x| x.is_finite()) {
            self.x.fill(0.0);
            self.previous.clear();
            self.set.members.clear();
            self.conflict.clear();
            self.defect = Some(Defect::Overflow);
            return Status::InvalidInput;
        }
        if status == Status::Optimal {
            for (j, x) in self.x.iter_mut().enumerate() {
                *x = x.clamp(problem.lower()[j], problem.upper()[j]);
            }
        }
        for (k, member) in set.members.iter().enumerate() {
            let mut multiplier = set.multipliers[k];
            if k >= set.equalities {
                multiplier = multiplier.max(0.0);
            }
            multiplier *= member.sign * program.multiplier_factor(member.c);
            if member.c < program.m {
                self.row_multipliers[member.c] = multiplier;
            } else {
                let j = member.c - program.m;
                self.bound_multipliers[j] = multiplier;
                if status == Status::Optimal {
                    self.x[j] = if member.sign > 0.0 { problem.lower()[j] } else { problem.upper()[j] };
                }
            }
        }
        status
    }

    /// Forgets the working set: the next solve starts cold.
    pub fn forget(&mut self) {
        self.previous.clear();
    }

    /// The solution, length n.
    pub fn x(&self) -> &[f64] {
        &self.x
    }

    /// Multipliers `λ` of the rows, length m: `Hx + g = Aᵀλ + μ`, positive at a lower, negative at an upper side.
    pub fn row_multipliers(&self) -> &[f64] {
        &self.row_multipliers
    }

    /// Multipliers `μ` of the bounds, length n, with the same signs.
    pub fn bound_multipliers(&self) -> &[f64] {
        &self.bound_multipliers
    }

    /// Changes of the working set in the last solve, after the equalities and the guess were in.
    pub fn iterations(&self) -> u32 {
        self.iterations
    }

    /// Whether the last solve added the equalities to a Hessian that is not positive definite.
    pub fn convexified(&self) -> bool {
        self.convexified
    }

    /// After [`Status::InvalidInput`]: what is wrong, and where.
    pub fn defect(&self) -> Option<Defect> {
        self.defect
    }

    /// The rows and bounds that hold `x`, in the order in which they entered. Equalities that follow from others are not
    /// among them.
    pub fn working_set(&self) -> impl Iterator<Item = Active> + '_ {
        self.set.members.iter().map(|&member| Active {
            constraint: self.program.constraint(member.c),
            side: if self.program.kind[member.c] == Kind::Equality { Side::Equal } else { side(member) },
        })
    }

    /// After [`Status::Infeasible`]: the rows and bounds that contradict each other, the one first that was found violated.
    pub fn conflict(&self) -> impl Iterator<Item = Conflict> + '_ {
        self.conflict.iter().map(|&(member, weight)| Conflict {
            constraint: self.program.constraint(member.c),
            side: side(member),
            weight,
        })
    }
}
