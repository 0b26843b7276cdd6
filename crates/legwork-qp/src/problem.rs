//! The data of a quadratic program.

/// `min ½ xᵀHx + gᵀx` subject to `row_lower <= A x <= row_upper` and `lower <= x <= upper`.
///
/// Bounds may be infinite; `lower == upper` makes an equality (a fixed variable). All storage is allocated by
/// [`Problem::new`] and never resized: a row is switched off by its bounds.
#[derive(Clone, Debug)]
pub struct Problem {
    n: usize,
    m: usize,
    hessian: Vec<f64>,
    gradient: Vec<f64>,
    rows: Vec<f64>,
    row_lower: Vec<f64>,
    row_upper: Vec<f64>,
    lower: Vec<f64>,
    upper: Vec<f64>,
}

impl Problem {
    /// `n` variables, `m` rows; `H`, `g` and `A` zero, all bounds infinite.
    pub fn new(n: usize, m: usize) -> Self {
        Self {
            n,
            m,
            hessian: vec![0.0; n * n],
            gradient: vec![0.0; n],
            rows: vec![0.0; m * n],
            row_lower: vec![f64::NEG_INFINITY; m],
            row_upper: vec![f64::INFINITY; m],
            lower: vec![f64::NEG_INFINITY; n],
            upper: vec![f64::INFINITY; n],
        }
    }

    /// Number of variables.
    pub fn n(&self) -> usize {
        self.n
    }

    /// Number of rows of `A`.
    pub fn m(&self) -> usize {
        self.m
    }

    /// Back to the state of [`Problem::new`], without allocating.
    pub fn reset(&mut self) {
        self.hessian.fill(0.0);
        self.gradient.fill(0.0);
        self.rows.fill(0.0);
        self.row_lower.fill(f64::NEG_INFINITY);
        self.row_upper.fill(f64::INFINITY);
        self.lower.fill(f64::NEG_INFINITY);
        self.upper.fill(f64::INFINITY);
    }

    /// `H`, full and symmetric, `n × n`: entry (i, j) at `i * n + j`.
    pub fn hessian(&self) -> &[f64] {
        &self.hessian
    }

    /// `H` to write; both triangles must be filled.
    pub fn hessian_mut(&mut self) -> &mut [f64] {
        &mut self.hessian
    }

    /// `g`, length `n`.
    pub fn gradient(&self) -> &[f64] {
        &self.gradient
    }

    /// `g` to write.
    pub fn gradient_mut(&mut self) -> &mut [f64] {
        &mut self.gradient
    }

    /// Row `i` of `A`, length `n`.
    pub fn row(&self, i: usize) -> &[f64] {
        &self.rows[i * self.n..(i + 1) * self.n]
    }

    /// Row `i` of `A` to write.
    pub fn row_mut(&mut self, i: usize) -> &mut [f64] {
        &mut self.rows[i * self.n..(i + 1) * self.n]
    }

    /// Lower bounds of `A x`, length `m`.
    pub fn row_lower(&self) -> &[f64] {
        &self.row_lower
    }

    /// Lower bounds of `A x` to write.
    pub fn row_lower_mut(&mut self) -> &mut [f64] {
        &mut self.row_lower
    }

    /// Upper bounds of `A x`, length `m`.
    pub fn row_upper(&self) -> &[f64] {
        &self.row_upper
    }

    /// Upper bounds of `A x` to write.
    pub fn row_upper_mut(&mut self) -> &mut [f64] {
        &mut self.row_upper
    }

    /// Lower bounds of `x`, length `n`.
    pub fn lower(&self) -> &[f64] {
        &self.lower
    }

    /// Lower bounds of `x` to write.
    pub fn lower_mut(&mut self) -> &mut [f64] {
        &mut self.lower
    }

    /// Upper bounds of `x`, length `n`.
    pub fn upper(&self) -> &[f64] {
        &self.upper
    }

    /// Upper bounds of `x` to write.
    pub fn upper_mut(&mut self) -> &mut [f64] {
        &mut self.upper
    }

    /// `½ xᵀHx + gᵀx` at `x`, length `n`.
    pub fn objective(&self, x: &[f64]) -> f64 {
        let mut value = 0.0;
        for i in 0..self.n {
            let mut hx = 0.0;
            for j in 0..self.n {
                hx += self.hessian[i * self.n + j] * x[j];
            }
            value += x[i] * (0.5 * hx + self.gradient[i]);
        }
        value
    }
}
