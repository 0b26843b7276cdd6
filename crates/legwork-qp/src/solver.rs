//! The solver as its user sees it: from a [`Problem`] to `x`, multipliers, working set or conflict.

use crate::certificate::side;
use crate::dual::Search;
use crate::hessian::Squares;
use crate::modes::Modes;
use crate::scale::{Kind, Scaled};
use crate::working_set::{Member, WorkingSet};
use crate::{Active, Conflict, Constraint, Defect, Problem, Settings, Side, Status};

/// Workspace and result of a solve, allocated once for a size.
#[derive(Clone, Debug)]
pub struct Solver {
    settings: Settings,
    program: Scaled,
    set: WorkingSet,
    /// What the next solve starts from: inequalities in the working set of the previous one, or as the user wished.
    guess: Vec<Member>,
    /// The user wished so.
    given: bool,
    /// The guess comes from an optimum, or from the user.
    informed: bool,
    modes: Modes,
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
            guess: Vec::with_capacity(n),
            given: false,
            informed: false,
            modes: Modes::new(n),
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
        match self.load(problem) {
            Ok(true) => {}
            Ok(false) => {
                self.program.replaced.clear();
                return Status::NotConvex;
            }
            Err(defect) => {
                self.defect = Some(defect);
                return Status::InvalidInput;
            }
        }
        if !self.settings.warm_start && !self.given {
            self.guess.clear();
            self.informed = false;
        }
        self.given = false;
        let mut search = Search {
            program: &self.program,
            set: &mut self.set,
            settings: &self.settings,
            conflict: &mut self.conflict,
            informed: self.informed,
            iterations: 0,
            refined: false,
        };
        let status = search.run(&self.guess);
        self.iterations = search.iterations;
        self.guess.clear();
        self.guess.extend_from_slice(&self.set.members[self.set.equalities..]);
        self.informed = status == Status::Optimal || !self.guess.is_empty();
        if status == Status::Optimal {
            self.modes.keep(&self.guess);
        }
        self.take_result(problem, status)
    }

    /// Scales the problem and factorises its Hessian. False if it is not convex.
    fn load(&mut self, problem: &Problem) -> Result<bool, Defect> {
        self.defect = None;
        let loaded = self.load_with(problem, true);
        if loaded == Ok(true) || self.program.replaced.slacks().is_empty() {
            return loaded;
        }
        // Some weights are too far from others to be in one Hessian, or something is wrong.
        self.load_with(problem, false)
    }

    /// With the slacks replaced or not, and if need be with the squares of equalities.
    fn load_with(&mut self, problem: &Problem, slacks: bool) -> Result<bool, Defect> {
        self.program.load(problem, slacks)?;
        // A zero on the diagonal tells beforehand that H alone will not do.
        let n = problem.n();
        let free = (0..n).filter(|j| problem.hessian()[j * (n + 1)] == 0.0).count();
        let is_replaced = free > 0 && self.program.replaced.all.len() - self.program.replaced.slacks().len() == free;
        let mut squares = if is_replaced || free == 0 { Squares::None } else { Squares::OfFreeVariables };
        loop {
            self.program.load_hessian(problem, squares)?;
            self.convexified = is_replaced || squares != Squares::None;
            if self.set.factorise(&self.program) {
                return Ok(true);
            }
            if squares == Squares::All {
                return Ok(false);
            }
            squares = Squares::All;
        }
    }

    /// Back to the units of the problem.
    fn take_result(&mut self, problem: &Problem, status: Status) -> Status {
        let (program, set) = (&self.program, &self.set);
        for (x, (z, unit)) in self.x.iter_mut().zip(set.z.as_flattened().iter().zip(program.unit())) {
            *x = z * unit;
        }
        if !self.x.iter().chain(&set.multipliers).chain(&set.pulls).all(|x| x.is_finite()) {
            return self.overflow();
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
        let (rows, bounds) = (&mut self.row_multipliers, &mut self.bound_multipliers);
        for (replaced, pull) in program.replaced.slacks().iter().zip(&set.pulls) {
            rows[replaced.row] = pull * program.multiplier_factor(replaced.row);
            replaced.restore_slack(problem, &mut self.x, rows);
        }
        for replaced in program.replaced.all.iter().filter(|replaced| replaced.cost == 0.0) {
            replaced.restore(problem, &mut self.x, rows, bounds, status == Status::Optimal);
        }
        if program.replaced.all.iter().all(|replaced| self.x[replaced.variable].is_finite()) {
            return status;
        }
        self.overflow()
    }

    /// There is no answer in finite numbers.
    fn overflow(&mut self) -> Status {
        self.x.fill(0.0);
        self.row_multipliers.fill(0.0);
        self.bound_multipliers.fill(0.0);
        self.guess.clear();
        self.set.members.clear();
        self.program.replaced.clear();
        self.conflict.clear();
        self.defect = Some(Defect::Overflow);
        Status::InvalidInput
    }

    /// Forgets all working sets: the next solve starts cold.
    pub fn forget(&mut self) {
        self.guess.clear();
        (self.given, self.informed) = (false, false);
        self.modes.forget();
    }

    /// The next solve starts from these rows and bounds, as far as they can hold together, whatever the settings say of warm
    /// starts. Equalities hold anyway and need not be named; what the problem does not have is passed over.
    pub fn start_from(&mut self, working_set: impl IntoIterator<Item = Active>) {
        self.guess.clear();
        let (n, m) = (self.program.n, self.program.m);
        for Active { constraint, side } in working_set {
            let c = match constraint {
                Constraint::Row(i) if i < m => i,
                Constraint::Bound(j) if j < n => m + j,
                _ => continue,
            };
            if side != Side::Equal && self.guess.len() < n {
                self.guess.push(Member { c, sign: if side == Side::Lower { 1.0 } else { -1.0 } });
            }
        }
        (self.given, self.informed) = (true, true);
    }

    /// Says in which mode, of contacts for instance, the problems that follow are: a key of one's own making.
    ///
    /// At a change to a mode that is known the next solve starts from the last optimal working set of that mode, instead of
    /// the previous solve's. Eight modes are remembered; a ninth replaces the one that was not used for longest. Without a
    /// change this does nothing, so it may be called before each solve. Allocates nothing.
    pub fn select_mode(&mut self, key: u64) {
        if let Some(members) = self.modes.select(key) {
            self.guess.clear();
            self.guess.extend_from_slice(members);
        }
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

    /// Whether the Hessian of the last solve was not positive definite, so that equalities had to help.
    pub fn convexified(&self) -> bool {
        self.convexified
    }

    /// After [`Status::InvalidInput`]: what is wrong, and where.
    pub fn defect(&self) -> Option<Defect> {
        self.defect
    }

    /// The rows and bounds that hold `x`: equality rows that define a slack or a variable without a cost, then the others in
    /// the order in which they entered. Equalities that follow from others are not among them.
    pub fn working_set(&self) -> impl Iterator<Item = Active> + '_ {
        let program = &self.program;
        let equality = |c: usize| Active { constraint: program.constraint(c), side: Side::Equal };
        let members = self.set.members.iter().map(move |&member| match program.replaced.of(member.c) {
            Some(replaced) => Active { constraint: Constraint::Bound(replaced.variable), side: replaced.side(member) },
            None if program.kind[member.c] == Kind::Equality => equality(member.c),
            None => Active { constraint: program.constraint(member.c), side: side(member) },
        });
        program.replaced.all.iter().map(move |replaced| equality(replaced.row)).chain(members)
    }

    /// After [`Status::Infeasible`]: the rows and bounds that contradict each other, the one first that was found violated.
    pub fn conflict(&self) -> impl Iterator<Item = Conflict> + '_ {
        self.conflict.iter().flat_map(|&(member, weight)| {
            let own = Conflict { constraint: self.program.constraint(member.c), side: side(member), weight };
            let bound = self.program.replaced.of(member.c).map(|replaced| Conflict {
                constraint: Constraint::Bound(replaced.variable),
                side: replaced.side(member),
                weight: weight * replaced.entry.abs(),
            });
            std::iter::once(own).chain(bound)
        })
    }
}
