//! The mass matrix as `M = Lᵀ L`, where L has the sparsity of the robot's tree. Featherstone 2008, Section 6.5.
//!
//! Row k of L is nonzero only at the coordinates that carry k, its chain from the base. The factorisation keeps it so:
//! it fills nothing in. Rows are stored packed along their chains, and since the chain of an ancestor is a beginning of
//! the own one, all work is on beginnings of packed rows.

use legwork_rbd::{Dynamics, Model};
use nalgebra::DMatrix;

/// Where the row of a coordinate is: its entries beside the diagonal are `first..last`, the diagonal is `last`.
#[derive(Clone, Copy, Debug)]
struct Row {
    first: usize,
    last: usize,
}

/// The factor and its tree, preallocated.
#[derive(Clone, Debug)]
pub(super) struct TreeFactor {
    rows: Vec<Row>,
    /// The coordinates of all rows, from the base outward, the own one last. A row is padded to whole fours; what stands
    /// in the padding means nothing.
    chain: Vec<usize>,
    /// Where the rows of those coordinates begin, in fours.
    carriers: Vec<usize>,
    /// The entries of L, in fours.
    entry: Vec<[f64; 4]>,
    /// 1 / L_kk.
    inverse: Vec<f64>,
}

impl TreeFactor {
    /// Storage for `model`, with its tree as `dynamics` knows it.
    pub(super) fn new(model: &Model, dynamics: &Dynamics) -> Self {
        Self::of_chains((0..model.nv()).map(|k| dynamics.chain_to(model, k)))
    }

    fn of_chains(chains: impl Iterator<Item = Vec<usize>>) -> Self {
        let (mut rows, mut chain): (Vec<Row>, Vec<usize>) = (Vec::new(), Vec::new());
        for row in chains {
            rows.push(Row { first: chain.len(), last: chain.len() + row.len() - 1 });
            chain.extend(&row);
            chain.resize(chain.len().next_multiple_of(4), row[0]);
        }
        let carriers = chain.iter().map(|&j: &usize| rows[j].first / 4).collect();
        Self { entry: vec![[0.0; 4]; chain.len() / 4], inverse: vec![0.0; rows.len()], rows, chain, carriers }
    }

    /// Factorises the symmetric `matrix`. Returns false where it is not positive definite.
    pub(super) fn factor(&mut self, matrix: &DMatrix<f64>) -> bool {
        let n = self.rows.len();
        for (row, column) in self.rows.iter().zip(matrix.as_slice().chunks_exact(n)) {
            let range = row.first..=row.last;
            for (entry, &j) in self.entry.as_flattened_mut()[range.clone()].iter_mut().zip(&self.chain[range]) {
                *entry = column[j];
            }
        }
        // Featherstone 2008, Table 6.3
        for (row, inverse) in self.rows.iter().zip(&mut self.inverse).rev() {
            let (above, own) = self.entry.split_at_mut(row.first / 4);
            let length = row.last - row.first;
            let own = &mut own[..=length / 4];
            let pivot = own[length / 4][length % 4];
            if pivot.is_nan() || pivot <= 0.0 {
                return false;
            }
            *inverse = 1.0 / pivot.sqrt();
            own.iter_mut().for_each(|four| *four = four.map(|value| value * *inverse));
            for (p, &target) in self.carriers[row.first..row.last].iter().enumerate() {
                let factor = own[p / 4][p % 4];
                for (target, own) in above[target..].iter_mut().zip(&own[..=p / 4]) {
                    *target = std::array::from_fn(|lane| target[lane] - factor * own[lane]);
                }
            }
        }
        true
    }

    /// `x := L⁻ᵀ x`
    pub(super) fn solve_transposed(&self, x: &mut [f64]) {
        let entry = self.entry.as_flattened();
        for k in (0..x.len()).rev() {
            let Row { first, last } = self.rows[k];
            let value = x[k] * self.inverse[k];
            x[k] = value;
            for (entry, &j) in entry[first..last].iter().zip(&self.chain[first..last]) {
                x[j] -= entry * value;
            }
        }
    }

    /// `x := L⁻¹ x`
    pub(super) fn solve(&self, x: &mut [f64]) {
        let entry = self.entry.as_flattened();
        for k in 0..x.len() {
            let Row { first, last } = self.rows[k];
            let mut value = x[k];
            for (entry, &j) in entry[first..last].iter().zip(&self.chain[first..last]) {
                value -= entry * x[j];
            }
            x[k] = value * self.inverse[k];
        }
    }

    /// `X := L⁻ᵀ X` for K columns that are nonzero only along `chain`, and stay so; a row a coordinate of the chain.
    pub(super) fn whiten<const K: usize>(&self, chain: &[usize], columns: &mut [[f64; K]]) {
        for p in (0..chain.len()).rev() {
            let k = chain[p];
            let (before, rest) = columns.split_at_mut(p);
            let own = &mut rest[0];
            own.iter_mut().for_each(|value| *value *= self.inverse[k]);
            let row = &self.entry.as_flattened()[self.rows[k].first..self.rows[k].last];
            for (target, entry) in before.iter_mut().zip(row) {
                for i in 0..K {
                    target[i] -= entry * own[i];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two branches on a base of two coordinates: 0-1-2-3 and 0-1-4.
    fn tree() -> Vec<Vec<usize>> {
        vec![vec![0], vec![0, 1], vec![0, 1, 2], vec![0, 1, 2, 3], vec![0, 1, 4]]
    }

    fn matrix() -> DMatrix<f64> {
        let mut m = DMatrix::zeros(5, 5);
        for (k, chain) in tree().iter().enumerate() {
            for &j in chain {
                let value = if j == k { 4.0 + k as f64 } else { 0.3 * (1.0 + k as f64) - 0.7 * j as f64 };
                (m[(k, j)], m[(j, k)]) = (value, value);
            }
        }
        m
    }

    #[test]
    fn it_solves_as_a_dense_factorisation_does() {
        let mut factor = TreeFactor::of_chains(tree().into_iter());
        assert!(factor.factor(&matrix()));
        let right = nalgebra::DVector::from_column_slice(&[1.0, -2.0, 0.5, 3.0, -0.25]);
        let expected = matrix().cholesky().expect("positive definite").solve(&right);
        let mut x = right.as_slice().to_vec();
        factor.solve_transposed(&mut x);
        factor.solve(&mut x);
        assert!((nalgebra::DVector::from_vec(x) - expected).amax() < 1e-14);
    }

    #[test]
    fn columns_along_a_chain_stay_on_it() {
        let mut factor = TreeFactor::of_chains(tree().into_iter());
        assert!(factor.factor(&matrix()));
        let chain = [0, 1, 4];
        let mut columns = [[1.0, 0.5], [-2.0, 1.0], [0.25, 3.0]];
        let full = |column: usize| {
            let mut x = vec![0.0; 5];
            for (p, &j) in chain.iter().enumerate() {
                x[j] = [[1.0, 0.5], [-2.0, 1.0], [0.25, 3.0]][p][column];
            }
            factor.solve_transposed(&mut x);
            x
        };
        let expected = [full(0), full(1)];
        factor.whiten(&chain, &mut columns);
        for column in 0..2 {
            for (p, &j) in chain.iter().enumerate() {
                assert!((columns[p][column] - expected[column][j]).abs() < 1e-15);
            }
            assert_eq!((expected[column][2], expected[column][3]), (0.0, 0.0));
        }
    }

    #[test]
    fn an_indefinite_matrix_is_refused() {
        let chains = || vec![vec![0], vec![0, 1]].into_iter();
        assert!(!TreeFactor::of_chains(chains()).factor(&DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 1.0])));
        assert!(!TreeFactor::of_chains(chains()).factor(&DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 0.0, f64::NAN])));
    }

    /// A joint that follows one of another branch couples the two: the factor's tree is no longer the robot's.
    #[test]
    fn joints_that_follow_others_are_factorised_along_their_own_tree() {
        let body = |name: &str, parent: &str, joint: &str| {
            format!(
                "[[bodies]]\nname = \"{name}\"\nparent = \"{parent}\"\nmass_kg = 1.5\ncom_m = [0.1, 0.02, -0.3]\n\
                 inertia_kgm2 = {{ xx = 0.1, yy = 0.12, zz = 0.05 }}\n\
                 joint = {{ name = \"{name}\", type = \"revolute\", axis = [0, 1, 0.5], origin_m = [0, 0.1, -0.2]{joint} }}\n"
            )
        };
        let text = format!(
            "name = \"r\"\nbase = \"floating\"\n[[bodies]]\nname = \"t\"\nmass_kg = 9\ninertia_kgm2 = {{ xx = 1, yy = 1, zz = 1 }}\n{}{}{}{}{}",
            body("a", "t", ""),
            body("b", "a", ""),
            body("c", "t", ""),
            // Below c, led by a joint of the other branch.
            body("d", "c", ", follows = \"a\", ratio = -1.5"),
            body("e", "d", "")
        );
        let model = Model::from_toml(&text, "r.toml").expect("a robot");
        assert_eq!(model.nv(), 6 + 4);
        let mut dynamics = Dynamics::new(&model);
        let q: Vec<f64> = (0..model.nq()).map(|k| if k < 4 { 0.5 } else { 0.1 * k as f64 }).collect();
        dynamics.update(&model, &q, &vec![0.0; model.nv()]);
        let mut factor = TreeFactor::new(&model, &dynamics);
        assert!(factor.factor(&dynamics.mass_matrix));
        let right = nalgebra::DVector::from_fn(model.nv(), |k, _| 1.0 - 0.3 * k as f64);
        let expected = dynamics.mass_matrix.clone().cholesky().expect("positive definite").solve(&right);
        let mut x = right.as_slice().to_vec();
        factor.solve_transposed(&mut x);
        factor.solve(&mut x);
        assert!((nalgebra::DVector::from_vec(x) - expected).amax() < 1e-12);
    }
}
