//! Vectors in lanes of four numbers, padded with zeros: loops over them have no remainder, and the compiler makes vector
//! instructions of them. A [`Span`] tells where a vector's nonzero entries are, so that short rows cost little.

use std::ops::Range;

/// Entries in a lane.
pub(crate) const WIDTH: usize = 4;

/// Four neighbouring entries of a vector.
pub(crate) type Lanes = [f64; WIDTH];

/// A vector of `n` zeros.
pub(crate) fn zeros(n: usize) -> Vec<Lanes> {
    vec![[0.0; WIDTH]; n.div_ceil(WIDTH)]
}

/// Indices of entries: outside of it a vector is zero.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Span {
    pub(crate) first: usize,
    pub(crate) end: usize,
}

impl Span {
    /// No entry at all.
    pub(crate) const EMPTY: Self = Self { first: usize::MAX, end: 0 };

    pub(crate) fn one(j: usize) -> Self {
        Self { first: j, end: j + 1 }
    }

    /// The same as [`Span::of`], quickly if it is the expected one.
    #[inline]
    pub(crate) fn expected(v: &[f64], Self { first, end }: Self) -> Self {
        let is_zero = |numbers: &[f64]| numbers.iter().fold(0, |bits, x| bits | x.to_bits()) << 1 == 0;
        let fits = match v.get(first..end) {
            Some(within) if first < end => {
                within[0] != 0.0 && within[end - first - 1] != 0.0 && is_zero(&v[..first]) && is_zero(&v[end..])
            }
            _ => end == 0 && is_zero(v),
        };
        if fits { Self { first, end } } else { Self::of(v) }
    }

    /// From the first to the last entry that is not zero.
    pub(crate) fn of(v: &[f64]) -> Self {
        const BLOCK: usize = 8;
        // Without the sign bit.
        let any = |numbers: &[f64]| numbers.iter().fold(0, |bits, x| bits | x.to_bits()) << 1 != 0;
        let (blocks, rest) = v.as_chunks::<BLOCK>();
        let nonzero = |x: &f64| x.to_bits() << 1 != 0;
        let first_block = blocks.iter().position(|block| any(block)).unwrap_or(blocks.len()) * BLOCK;
        let Some(first) = v[first_block..].iter().position(nonzero) else {
            return Self::EMPTY;
        };
        let last_block =
            if any(rest) { blocks.len() } else { blocks.iter().rposition(|block| any(block)).unwrap_or(0) };
        let tail = &v[last_block * BLOCK..v.len().min((last_block + 1) * BLOCK)];
        let last = tail.iter().rposition(nonzero).unwrap_or(0);
        Self { first: first_block + first, end: last_block * BLOCK + last + 1 }
    }

    pub(crate) fn union(self, other: Self) -> Self {
        Self { first: self.first.min(other.first), end: self.end.max(other.end) }
    }

    /// The same entries of a vector with so many more before them.
    pub(crate) fn shifted(self, by: usize) -> Self {
        Self { first: self.first + by, end: self.end + by }
    }

    /// The lanes that hold it.
    pub(crate) fn lanes(self) -> Range<usize> {
        if self.first >= self.end { 0..0 } else { self.first / WIDTH..self.end.div_ceil(WIDTH) }
    }

    /// The lanes that hold entries of both.
    pub(crate) fn common_lanes(self, other: Self) -> Range<usize> {
        Self { first: self.first.max(other.first), end: self.end.min(other.end) }.lanes()
    }

    /// The entries.
    pub(crate) fn entries(self) -> Range<usize> {
        self.first.min(self.end)..self.end
    }
}

/// The lane in which entry `j` is.
pub(crate) fn lane(j: usize) -> usize {
    j / WIDTH
}

/// `aᵀb`.
#[inline]
pub(crate) fn dot(a: &[Lanes], b: &[Lanes]) -> f64 {
    let mut sums = [0.0; WIDTH];
    for (a, b) in a.iter().zip(b) {
        for k in 0..WIDTH {
            sums[k] += a[k] * b[k];
        }
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}

/// `∑ |a_j b_j|`, the size of what cancels in [`dot`].
#[inline]
pub(crate) fn dot_abs(a: &[Lanes], b: &[Lanes]) -> f64 {
    let mut sums = [0.0; WIDTH];
    for (a, b) in a.iter().zip(b) {
        for k in 0..WIDTH {
            sums[k] += (a[k] * b[k]).abs();
        }
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}

/// `y += alpha x`.
#[inline]
pub(crate) fn axpy(alpha: f64, x: &[Lanes], y: &mut [Lanes]) {
    for (y, x) in y.as_flattened_mut().iter_mut().zip(x.as_flattened()) {
        *y += alpha * x;
    }
}

/// `aᵀv` for four vectors at once, which saves three of four times reading `v`.
#[inline]
pub(crate) fn dots(a: [&[Lanes]; WIDTH], v: &[Lanes]) -> Lanes {
    let a = a.map(|a| &a[..v.len()]);
    let mut sums = [[0.0; WIDTH]; WIDTH];
    for i in 0..v.len() {
        for (sum, a) in sums.iter_mut().zip(a) {
            for k in 0..WIDTH {
                sum[k] += a[i][k] * v[i][k];
            }
        }
    }
    sums.map(|sum| (sum[0] + sum[2]) + (sum[1] + sum[3]))
}

/// `y += ∑ alpha_i x_i` of four vectors.
#[inline]
pub(crate) fn axpys(alpha: Lanes, x: [&[Lanes]; WIDTH], y: &mut [Lanes]) {
    let x = x.map(|x| &x.as_flattened()[..y.as_flattened().len()]);
    for (i, y) in y.as_flattened_mut().iter_mut().enumerate() {
        *y += (alpha[0] * x[0][i] + alpha[1] * x[1][i]) + (alpha[2] * x[2][i] + alpha[3] * x[3][i]);
    }
}

/// `y = alpha (d * x)`, entry by entry, of a vector `x` that has no padding: where it ends, `y` keeps its zeros. Returns `yᵀy`.
// As a function of its own, the compiler knows that `y` is apart from the others.
#[inline(never)]
pub(crate) fn load_product(alpha: f64, d: &[Lanes], x: &[f64], y: &mut [Lanes]) -> f64 {
    let (fours, rest) = x.as_chunks::<WIDTH>();
    let mut last = 0.0;
    if !rest.is_empty() {
        for ((y, x), d) in y[fours.len()].iter_mut().zip(rest).zip(&d[fours.len()]) {
            *y = x * d * alpha;
            last += *y * *y;
        }
    }
    let mut sums = [0.0; WIDTH];
    for ((y, x), d) in y.iter_mut().zip(fours).zip(d) {
        for k in 0..WIDTH {
            y[k] = x[k] * d[k] * alpha;
            sums[k] += y[k] * y[k];
        }
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3]) + last
}

/// Of a matrix by rows those of lane `i`.
#[inline]
pub(crate) fn four_rows<'a>(rows: &'a [Lanes], width: usize, i: usize, lanes: &Range<usize>) -> [&'a [Lanes]; WIDTH] {
    std::array::from_fn(|k| &rows[(i * WIDTH + k) * width..][lanes.clone()])
}

/// `x *= alpha`.
#[inline]
pub(crate) fn scale(alpha: f64, x: &mut [Lanes]) {
    for x in x.as_flattened_mut() {
        *x *= alpha;
    }
}

/// Rotates the pair of vectors `(x, y)` to `(c x + s y, −s x + c y)`.
pub(crate) fn rotate(c: f64, s: f64, x: &mut [Lanes], y: &mut [Lanes]) {
    for (x, y) in x.as_flattened_mut().iter_mut().zip(y.as_flattened_mut()) {
        (*x, *y) = (c * *x + s * *y, c * *y - s * *x);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_span_does_not_depend_on_what_is_expected() {
        for pattern in 0..32_u32 {
            // Zeros of both signs.
            let zero = if pattern % 2 == 0 { 0.0 } else { -0.0 };
            let v: Vec<f64> = (0..5).map(|k| if pattern >> k & 1 == 1 { 3.0 } else { zero }).collect();
            let nonzero = || (0..5).filter(|&k| v[k] != 0.0);
            let span = nonzero().next().map_or(Span::EMPTY, |first| Span { first, end: nonzero().max().unwrap() + 1 });
            assert_eq!(Span::of(&v), span, "{v:?}");
            for (first, end) in (0..7).flat_map(|first| (first + 1..8).map(move |end| (first, end))) {
                assert_eq!(Span::expected(&v, Span { first, end }), span, "{v:?}, {first}..{end}");
            }
            assert_eq!(Span::expected(&v, Span::EMPTY), span, "{v:?}");
        }
    }

    #[test]
    fn dot_of_all_lengths() {
        for length in 0..=40 {
            let mut numbers = zeros(length);
            (1..=length).for_each(|k| numbers.as_flattened_mut()[k - 1] = k as f64);
            let squares = (1..=length).map(|k| k * k).sum::<usize>() as f64;
            assert!((dot(&numbers, &numbers) - squares).abs() < 0.5);
            assert!((dot_abs(&numbers, &numbers) - squares).abs() < 0.5);
        }
    }

    #[test]
    fn a_loaded_row_is_a_product_with_the_sum_of_its_squares() {
        for length in 0..=13 {
            let x: Vec<f64> = (1..=length).map(f64::from).collect();
            let (mut d, mut y) = (zeros(x.len()), zeros(x.len()));
            d.as_flattened_mut().iter_mut().enumerate().for_each(|(k, d)| *d = 2.0 + k as f64);
            let squares = load_product(0.5, &d, &x, &mut y);
            let expected: Vec<f64> = (1..=length).map(|k| f64::from(k * (k + 1)) / 2.0).collect();
            assert_eq!(y.as_flattened()[..x.len()], expected);
            assert_eq!(squares, expected.iter().map(|value| value * value).sum::<f64>());
        }
    }

    #[test]
    fn the_span_is_from_the_first_to_the_last_nonzero_entry() {
        assert_eq!(Span::of(&[]), Span::EMPTY);
        for length in 1..40 {
            assert_eq!(Span::of(&vec![-0.0; length]), Span::EMPTY);
            for first in 0..length {
                for last in first..length {
                    let mut v = vec![0.0; length];
                    (v[first], v[last]) = (f64::NAN, 1e-300);
                    assert_eq!(Span::of(&v), Span { first, end: last + 1 });
                    let lanes = Span::of(&v).lanes();
                    assert!(lanes.start * WIDTH <= first && last < lanes.end * WIDTH);
                }
            }
        }
        let apart = Span { first: 0, end: 3 }.common_lanes(Span { first: 3, end: 9 });
        assert!(apart.is_empty() && Span::EMPTY.lanes().is_empty());
        assert_eq!(Span::EMPTY.union(Span::one(5)), Span::one(5));
    }
}
