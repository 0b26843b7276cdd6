//! The Sobol' sequence with a random linear scramble and a digital shift: points that fill the unit cube more evenly
//! than independent ones, each of them computable from its index alone.
//!
//! Sobol' 1967 (doi:10.1016/0041-5553(67)90144-9), with the direction numbers of Joe and Kuo 2008
//! (doi:10.1137/070709359), in the Gray-code order of Antonov and Saleev 1979 (doi:10.1016/0041-5553(79)90085-5), and the
//! scramble of Matoušek 1998 (doi:10.1006/jcom.1998.0487): each point is uniform on its own, and together they keep the
//! sequence's evenness.

use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Binary digits of a coordinate; as many as an index may have.
const DIGITS: usize = 32;

/// The most dimensions that the table of direction numbers serves.
pub(super) const MAX_DIMENSIONS: usize = NUMBERS.len() + 1;

/// The sequence in a given number of dimensions.
#[derive(Clone, Debug)]
pub(super) struct SobolSequence {
    /// A dimension's direction numbers; the highest bit is the first binary digit.
    directions: Vec<[u32; DIGITS]>,
    shifts: Vec<u32>,
}

impl SobolSequence {
    /// The scrambled sequence that belongs to `seed`, in at most [`MAX_DIMENSIONS`].
    pub(super) fn new(dimensions: usize, seed: u64) -> Self {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let scrambled = |dimension| {
            let rows = triangular(&mut random);
            directions(dimension).map(|number| product(&rows, number))
        };
        let directions = (0..dimensions).map(scrambled).collect();
        let shifts = (0..dimensions).map(|_| random.next_u32()).collect();
        Self { directions, shifts }
    }

    /// The point of `index`, in the open unit cube.
    pub(super) fn point(&self, index: u32) -> Vec<f64> {
        let digits = self.directions.iter().zip(&self.shifts).map(|(directions, shift)| shift ^ sum(directions, index));
        // The middle of the cell of width 2^-32, so that no coordinate is zero.
        digits.map(|digits| (f64::from(digits) + 0.5) / 2_f64.powi(DIGITS as i32)).collect()
    }
}

/// The sum modulo 2 of the direction numbers that the digits of the index's Gray code choose (Antonov and Saleev 1979).
fn sum(directions: &[u32; DIGITS], index: u32) -> u32 {
    let gray = index ^ (index >> 1);
    (0..DIGITS).filter(|digit| gray >> digit & 1 == 1).fold(0, |sum, digit| sum ^ directions[digit])
}

/// The direction numbers of a dimension.
fn directions(dimension: usize) -> [u32; DIGITS] {
    let digit = |k: usize| DIGITS - 1 - k;
    // The first dimension is the van der Corput sequence.
    let Some((polynomial, initial)) = dimension.checked_sub(1).map(|row| NUMBERS[row]) else {
        return std::array::from_fn(|k| 1 << digit(k));
    };
    let mut v = [0; DIGITS];
    let degree = initial.len();
    for k in 0..DIGITS {
        v[k] = if k < degree {
            initial[k] << digit(k)
        } else {
            // Joe and Kuo 2008, (3), for v_k = m_k / 2^k
            let taps = (1..degree).filter(|i| polynomial >> (degree - i) & 1 == 1);
            taps.fold(v[k - degree] ^ (v[k - degree] >> degree), |sum, i| sum ^ v[k - i])
        };
    }
    v
}

/// The rows of a random lower triangular matrix over the binary digits, with ones on its diagonal.
fn triangular(random: &mut Pcg64Mcg) -> [u32; DIGITS] {
    std::array::from_fn(|row| {
        let diagonal = 1 << (DIGITS - 1 - row);
        let before_the_diagonal = !(diagonal | (diagonal - 1));
        diagonal | (random.next_u32() & before_the_diagonal)
    })
}

/// The product of such a matrix and the digits of a number.
fn product(rows: &[u32; DIGITS], number: u32) -> u32 {
    rows.iter().fold(0, |digits, row| digits << 1 | (row & number).count_ones() & 1)
}

/// The primitive polynomial of each dimension after the first, as the bits of its coefficients, and the first numbers
/// `m_k`: the first rows of new-joe-kuo-6.21201 (Joe and Kuo 2008).
#[rustfmt::skip]
const NUMBERS: [(u32, &[u32]); 63] = [
    (3, &[1]),
    (7, &[1, 3]),
    (11, &[1, 3, 1]),
    (13, &[1, 1, 1]),
    (19, &[1, 1, 3, 3]),
    (25, &[1, 3, 5, 13]),
    (37, &[1, 1, 5, 5, 17]),
    (41, &[1, 1, 5, 5, 5]),
    (47, &[1, 1, 7, 11, 19]),
    (55, &[1, 1, 5, 1, 1]),
    (59, &[1, 1, 1, 3, 11]),
    (61, &[1, 3, 5, 5, 31]),
    (67, &[1, 3, 3, 9, 7, 49]),
    (91, &[1, 1, 1, 15, 21, 21]),
    (97, &[1, 3, 1, 13, 27, 49]),
    (103, &[1, 1, 1, 15, 7, 5]),
    (109, &[1, 3, 1, 15, 13, 25]),
    (115, &[1, 1, 5, 5, 19, 61]),
    (131, &[1, 3, 7, 11, 23, 15, 103]),
    (137, &[1, 3, 7, 13, 13, 15, 69]),
    (143, &[1, 1, 3, 13, 7, 35, 63]),
    (145, &[1, 3, 5, 9, 1, 25, 53]),
    (157, &[1, 3, 1, 13, 9, 35, 107]),
    (167, &[1, 3, 1, 5, 27, 61, 31]),
    (171, &[1, 1, 5, 11, 19, 41, 61]),
    (185, &[1, 3, 5, 3, 3, 13, 69]),
    (191, &[1, 1, 7, 13, 1, 19, 1]),
    (193, &[1, 3, 7, 5, 13, 19, 59]),
    (203, &[1, 1, 3, 9, 25, 29, 41]),
    (211, &[1, 3, 5, 13, 23, 1, 55]),
    (213, &[1, 3, 7, 3, 13, 59, 17]),
    (229, &[1, 3, 1, 3, 5, 53, 69]),
    (239, &[1, 1, 5, 5, 23, 33, 13]),
    (241, &[1, 1, 7, 7, 1, 61, 123]),
    (247, &[1, 1, 7, 9, 13, 61, 49]),
    (253, &[1, 3, 3, 5, 3, 55, 33]),
    (285, &[1, 3, 1, 15, 31, 13, 49, 245]),
    (299, &[1, 3, 5, 15, 31, 59, 63, 97]),
    (301, &[1, 3, 1, 11, 11, 11, 77, 249]),
    (333, &[1, 3, 1, 11, 27, 43, 71, 9]),
    (351, &[1, 1, 7, 15, 21, 11, 81, 45]),
    (355, &[1, 3, 7, 3, 25, 31, 65, 79]),
    (357, &[1, 3, 1, 1, 19, 11, 3, 205]),
    (361, &[1, 1, 5, 9, 19, 21, 29, 157]),
    (369, &[1, 3, 7, 11, 1, 33, 89, 185]),
    (391, &[1, 3, 3, 3, 15, 9, 79, 71]),
    (397, &[1, 3, 7, 11, 15, 39, 119, 27]),
    (425, &[1, 1, 3, 1, 11, 31, 97, 225]),
    (451, &[1, 1, 1, 3, 23, 43, 57, 177]),
    (463, &[1, 3, 7, 7, 17, 17, 37, 71]),
    (487, &[1, 3, 1, 5, 27, 63, 123, 213]),
    (501, &[1, 1, 3, 5, 11, 43, 53, 133]),
    (529, &[1, 3, 5, 5, 29, 17, 47, 173, 479]),
    (539, &[1, 3, 3, 11, 3, 1, 109, 9, 69]),
    (545, &[1, 1, 1, 5, 17, 39, 23, 5, 343]),
    (557, &[1, 3, 1, 5, 25, 15, 31, 103, 499]),
    (563, &[1, 1, 1, 11, 11, 17, 63, 105, 183]),
    (601, &[1, 1, 5, 11, 9, 29, 97, 231, 363]),
    (607, &[1, 1, 5, 15, 19, 45, 41, 7, 383]),
    (617, &[1, 3, 7, 7, 31, 19, 83, 137, 221]),
    (623, &[1, 1, 1, 3, 23, 15, 111, 223, 83]),
    (631, &[1, 1, 5, 13, 31, 15, 55, 25, 161]),
    (637, &[1, 1, 3, 13, 25, 47, 39, 87, 257]),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plain_sequence_is_that_of_scipy() {
        let data: serde_json::Value =
            serde_json::from_str(include_str!("../tests/data/salib.json")).expect("valid JSON");
        let points = data["sobol_sequence"].as_array().expect("a list of points");
        assert!(points.len() > 10);
        for row in points {
            let index = row["index"].as_u64().expect("an index") as u32;
            let theirs: Vec<f64> = serde_json::from_value(row["point"].clone()).expect("a point");
            assert_eq!(theirs.len(), MAX_DIMENSIONS);
            for (dimension, &theirs) in theirs.iter().enumerate() {
                let ours = f64::from(sum(&directions(dimension), index)) / 2_f64.powi(32);
                assert_eq!(ours, theirs, "dimension {dimension}, point {index}");
            }
        }
    }

    #[test]
    fn every_block_of_a_power_of_two_fills_each_axis_evenly() {
        let sequence = SobolSequence::new(MAX_DIMENSIONS, 7);
        for (start, log_size) in [(0, 3), (64, 6), (512, 9), (1 << 31, 8)] {
            let size = 1_usize << log_size;
            let mut seen = vec![vec![false; size]; MAX_DIMENSIONS];
            for index in 0..size as u32 {
                for (dimension, x) in sequence.point(start + index).into_iter().enumerate() {
                    assert!(0.0 < x && x < 1.0);
                    seen[dimension][(x * size as f64) as usize] = true;
                }
            }
            assert!(seen.iter().flatten().all(|&cell| cell), "a cell is empty in the block from {start}");
        }
    }

    #[test]
    fn a_scrambled_point_is_uniform_over_the_seeds() {
        // The mean of n uniform numbers deviates by 1 / sqrt(12 n), their mean square about 1/2 by 1 / sqrt(180 n).
        let seeds = 4000;
        for index in [0, 1, 1000] {
            let (mut mean, mut square) = ([0.0; 3], [0.0; 3]);
            for seed in 0..seeds {
                let point = SobolSequence::new(3, seed).point(index);
                for (dimension, x) in point.into_iter().enumerate() {
                    mean[dimension] += (x - 0.5) / seeds as f64;
                    square[dimension] += (x - 0.5).powi(2) / seeds as f64;
                }
            }
            for dimension in 0..3 {
                assert!(mean[dimension].abs() < 4.0 / (12.0 * seeds as f64).sqrt());
                assert!((square[dimension] - 1.0 / 12.0).abs() < 4.0 / (180.0 * seeds as f64).sqrt());
            }
        }
    }

    #[test]
    fn pairs_of_dimensions_are_even_too() {
        // A product of two centred coordinates integrates to zero; independent points leave 1 / (12 sqrt n).
        let sequence = SobolSequence::new(MAX_DIMENSIONS, 3);
        let count = 1024;
        let points: Vec<Vec<f64>> = (0..count).map(|index| sequence.point(index)).collect();
        let mut sum_of_squares = 0.0;
        for a in 0..MAX_DIMENSIONS {
            for b in 0..a {
                let mean: f64 = points.iter().map(|x| (x[a] - 0.5) * (x[b] - 0.5)).sum::<f64>() / f64::from(count);
                sum_of_squares += mean * mean;
            }
        }
        let pairs = (MAX_DIMENSIONS * (MAX_DIMENSIONS - 1) / 2) as f64;
        let independent = 1.0 / (12.0 * f64::from(count).sqrt());
        assert!((sum_of_squares / pairs).sqrt() < 0.5 * independent);
    }
}
