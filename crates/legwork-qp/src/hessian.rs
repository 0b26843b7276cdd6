//! The Hessian of the scaled program: symmetric, and its blocks.

use crate::input::check;
use crate::lanes::{self, Span, WIDTH};
use crate::scale::{Kind, Scaled, are_finite};
use crate::{Defect, Problem};

/// Which equalities' squares are added to the Hessian.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Squares {
    None,
    /// Of those with an entry at a variable without a cost.
    OfFreeVariables,
    All,
}

impl Scaled {
    /// Fills in the Hessian with the blocks that it and the squares of equalities make.
    pub(crate) fn load_hessian(&mut self, problem: &Problem, squares: Squares) -> Result<(), Defect> {
        let n = self.n;
        let h = problem.hessian();
        self.choose_squares(problem, squares);
        if !self.squared.iter().all(|(_, weight)| weight.is_normal()) {
            return Err(Defect::Overflow);
        }
        if !(self.blocks_known && self.squared.is_empty()) {
            self.find_blocks();
            self.blocks_known = self.squared.is_empty();
        }
        let mut regular = true;
        let rows = h.chunks_exact(n.max(1)).zip(self.hessian.chunks_exact_mut(self.width.max(1)));
        let mut lanes = 0..0;
        for (i, ((row, out), block)) in rows.zip(&self.block).enumerate() {
            for j in block.first..i {
                let (a, b) = (row[j], h[j * n + i]);
                regular &= (a - b).abs() <= 2.0 * f64::EPSILON * a.abs();
            }
            regular &= row[i].is_finite();
            if i.is_multiple_of(WIDTH) {
                let last = self.block[n.min(i + WIDTH) - 1];
                lanes = block.union(last).lanes();
            }
            let source = &row[WIDTH * lanes.start..n.min(WIDTH * lanes.end)];
            lanes::load_product(
                self.unit.as_flattened()[i],
                &self.unit[lanes.clone()],
                source,
                &mut out[lanes.clone()],
            );
        }
        for replaced in &self.replaced.all {
            self.hessian[replaced.variable * self.width..].as_flattened_mut()[replaced.variable] = 1.0;
        }
        if regular { Ok(()) } else { self.symmetrise(problem) }
    }

    /// A closer look at a Hessian with what is not a finite number, or with more than rounding errors between its triangles.
    fn symmetrise(&mut self, problem: &Problem) -> Result<(), Defect> {
        check(problem)?;
        let matrix = self.hessian.as_flattened_mut();
        let stride = WIDTH * self.width;
        let coupled = |j: usize| self.block[j].entries().any(|i| i != j && matrix[i * stride + j] != 0.0);
        // A slack in one triangle only of the Hessian is none.
        if self.replaced.slacks().iter().any(|slack| coupled(slack.variable)) {
            return Err(Defect::Asymmetric { row: 0, column: 0 });
        }
        for i in 0..self.n {
            for j in self.block[i].first..i {
                let mean = 0.5 * matrix[i * stride + j] + 0.5 * matrix[j * stride + i];
                matrix[i * stride + j] = mean;
                matrix[j * stride + i] = mean;
            }
        }
        let finite = (0..self.n).all(|i| are_finite(&self.hessian_row(i)[self.block[i].lanes()]));
        if finite { Ok(()) } else { Err(Defect::Overflow) }
    }

    fn choose_squares(&mut self, problem: &Problem, squares: Squares) {
        self.squared.clear();
        for slack in self.replaced.slacks() {
            let factor = self.row_factor[slack.row];
            self.squared.push((slack.row, slack.weight() / (factor * factor)));
        }
        if squares == Squares::None {
            return;
        }
        let has_cost = |j: usize| problem.hessian()[j * (self.n + 1)] != 0.0;
        for c in (0..self.constraints()).filter(|&c| self.kind[c] == Kind::Equality) {
            let is_entry = |j: usize| c >= self.m || problem.row(c)[j] != 0.0;
            if squares == Squares::All || self.span[c].entries().any(|j| is_entry(j) && !has_cost(j)) {
                self.squared.push((c, 1.0));
            }
        }
    }

    /// Spans that overlap belong to one block.
    fn find_blocks(&mut self) {
        for j in 0..self.n {
            self.block[j] = Span::one(j);
        }
        let rows = self.squared.iter().map(|&(c, _)| self.span[c]);
        for span in self.hessian_span.iter().copied().chain(rows) {
            let end = &mut self.block[span.first].end;
            *end = span.end.max(*end);
        }
        let mut first = 0;
        while first < self.n {
            let (mut end, mut j) = (first, first);
            while j == first || j < end {
                end = end.max(self.block[j].end);
                j += 1;
            }
            self.block[first..end].fill(Span { first, end });
            first = end;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Equalities of x and y, y and t, x and t, of which t has no cost; and x fixed.
    #[test]
    fn squares_are_those_of_equalities_with_a_variable_without_a_cost() {
        let mut problem = Problem::new(3, 3);
        (problem.hessian_mut()[0], problem.hessian_mut()[4]) = (1.0, 2.0);
        for (i, row) in [[1.0, 1.0, 0.0], [0.0, 1.0, 1.0], [1.0, 0.0, 1.0]].into_iter().enumerate() {
            problem.row_mut(i).copy_from_slice(&row);
            (problem.row_lower_mut()[i], problem.row_upper_mut()[i]) = (1.0, 1.0);
        }
        (problem.lower_mut()[0], problem.upper_mut()[0]) = (0.5, 0.5);
        let mut program = Scaled::new(3, 3);
        program.load(&problem, true).unwrap();
        let one = |c: usize| (c, 1.0);
        for (squares, expected) in
            [(Squares::None, &[][..]), (Squares::OfFreeVariables, &[1, 2]), (Squares::All, &[0, 1, 2, 3])]
        {
            program.load_hessian(&problem, squares).unwrap();
            assert_eq!(program.squared, expected.iter().copied().map(one).collect::<Vec<_>>(), "{squares:?}");
        }
    }
}
