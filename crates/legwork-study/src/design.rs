//! Designs: which points of a study's factors are run, each point a pure function of the design, the seed and its index.
//!
//! Two designs go through levels (`one_at_a_time`, `grid_point`); the others sample the unit cube ([`Sampler`]):
//! McKay, Beckman and Conover 1979 (doi:10.2307/1268522), Morris 1991 (doi:10.1080/00401706.1991.10484804), Saltelli 2002
//! (doi:10.1016/S0010-4655(02)00280-1), Saltelli et al. 2010 (doi:10.1016/j.cpc.2009.09.018).

use rand::seq::SliceRandom;
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};

use super::sobol_sequence::{MAX_DIMENSIONS, SobolSequence};
use legwork::error::Error;

/// How the points of a study are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Design {
    /// Each level of each factor, the other factors left as they are.
    OneAtATime,
    /// Every combination of levels.
    Grid,
    /// One point in each of as many strata as there are samples, in every factor (McKay et al. 1979).
    LatinHypercube {
        /// Number of points, at most 2^20.
        samples: u64,
    },
    /// The scrambled Sobol' sequence; a power of two fills the cube most evenly.
    SobolSequence {
        /// Number of points, at most 2^32.
        samples: u64,
    },
    /// Trajectories that change one factor after the other (Morris 1991), for [`morris`](super::sensitivity::morris).
    Morris {
        /// Number of trajectories of one point more than there are factors.
        trajectories: u64,
        /// Number of values of a factor, even.
        levels: u32,
    },
    /// The radial design over a scrambled Sobol' sequence (Saltelli 2002, Saltelli et al. 2010), for
    /// [`sobol_indices`](super::sensitivity::sobol_indices); a power of two is best here too.
    Saltelli {
        /// Number of base samples `N`, at most 2^32. With `k` factors there are `N (k + 2)` points, with second order
        /// `N (2k + 2)`.
        samples: u64,
        /// Whether the points for indices of pairs are added.
        #[serde(default)]
        second_order: bool,
    },
}

/// The runs of [`Design::OneAtATime`] as (factor, level), factor by factor; `counts` has each factor's number of levels.
pub(crate) fn one_at_a_time(counts: &[usize]) -> impl Iterator<Item = (usize, usize)> {
    counts.iter().enumerate().flat_map(|(factor, &count)| (0..count).map(move |level| (factor, level)))
}

/// The number of points of [`Design::Grid`]; `counts` has each factor's number of levels.
///
/// # Errors
/// More points than 64 bits can count.
pub(crate) fn grid_count(counts: &[usize]) -> Result<u64, Error> {
    let product = counts.iter().try_fold(1_u64, |product, &count| product.checked_mul(count as u64));
    product.ok_or_else(|| invalid(format!("a grid of {counts:?} levels has more than 2^64 points; take fewer levels")))
}

/// The levels of point `index` of [`Design::Grid`]; the first factor varies slowest.
///
/// `index` must be below [`grid_count`].
pub(crate) fn grid_point(counts: &[usize], index: u64) -> Vec<usize> {
    let mut rest = index;
    let mut levels: Vec<usize> = counts
        .iter()
        .rev()
        .map(|&count| {
            let level = rest % count as u64;
            rest /= count as u64;
            level as usize
        })
        .collect();
    assert_eq!(rest, 0, "point {index} of a grid of {counts:?}");
    levels.reverse();
    levels
}

/// The points of a design that samples the unit cube.
#[derive(Clone, Debug)]
pub struct Sampler {
    factors: usize,
    count: u64,
    scheme: Scheme,
}

/// What a scheme needs to make any of its points.
#[derive(Clone, Debug)]
enum Scheme {
    /// `strata[factor][index]`, and where the places within the strata come from.
    LatinHypercube {
        strata: Vec<Vec<u32>>,
        random: Pcg64Mcg,
    },
    SobolSequence(SobolSequence),
    Morris {
        levels: u32,
        random: Pcg64Mcg,
    },
    Saltelli {
        base: SobolSequence,
        second_order: bool,
    },
}

/// Strata are counted and divided without rounding up to this many.
const MAX_LATIN_HYPERCUBE: u64 = 1 << 20;
/// Points of the Sobol' sequence have an index of 32 bits.
const MAX_SOBOL: u64 = 1 << 32;

impl Sampler {
    /// The sampler of `design` for a number of factors.
    ///
    /// # Errors
    /// A design that goes through levels, no factors, more factors than the Sobol' sequence has dimensions (64, or 32 for
    /// [`Design::Saltelli`]), or numbers out of the ranges that [`Design`] states.
    pub fn new(design: &Design, factors: usize, seed: u64) -> Result<Self, Error> {
        if factors == 0 {
            return Err(invalid("there are no factors to vary; name one or more"));
        }
        let random = || Pcg64Mcg::seed_from_u64(seed);
        let (count, scheme) = match *design {
            Design::OneAtATime | Design::Grid => {
                return Err(invalid("this design goes through the levels of its factors and has no points in a cube"));
            }
            Design::LatinHypercube { samples } => {
                check_range("samples", samples, 1, MAX_LATIN_HYPERCUBE)?;
                (samples, latin_hypercube(samples as u32, factors, random()))
            }
            Design::SobolSequence { samples } => {
                check_range("samples", samples, 1, MAX_SOBOL)?;
                check_range("factors", factors as u64, 1, MAX_DIMENSIONS as u64)?;
                (samples, Scheme::SobolSequence(SobolSequence::new(factors, seed)))
            }
            Design::Morris { trajectories, levels } => {
                check_range("trajectories", trajectories, 2, MAX_SOBOL)?;
                if levels == 0 || levels % 2 == 1 {
                    return Err(invalid(format!("levels is {levels}, which should be even: 4, 6, 8, ...")));
                }
                (trajectories * (factors as u64 + 1), Scheme::Morris { levels, random: random() })
            }
            Design::Saltelli { samples, second_order } => {
                check_range("samples", samples, 2, MAX_SOBOL)?;
                check_range("factors", factors as u64, 1, MAX_DIMENSIONS as u64 / 2)?;
                let base = SobolSequence::new(2 * factors, seed);
                (samples * saltelli_rows(factors, second_order), Scheme::Saltelli { base, second_order })
            }
        };
        Ok(Self { factors, count, scheme })
    }

    /// The number of points.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Point `index`, one coordinate a factor: in the open unit cube, but for [`Design::Morris`], whose lowest and highest
    /// levels are 0 and 1.
    ///
    /// # Panics
    /// If `index` is not below [`count`](Self::count).
    pub fn point(&self, index: u64) -> Vec<f64> {
        assert!(index < self.count, "point {index} of {}", self.count);
        match &self.scheme {
            Scheme::LatinHypercube { strata, random } => {
                let mut random = random.clone();
                random.advance(u128::from(index) * self.factors as u128);
                strata.iter().map(|strata| within(strata[index as usize], strata.len(), &mut random)).collect()
            }
            Scheme::SobolSequence(sequence) => sequence.point(index as u32),
            Scheme::Morris { levels, random } => {
                let points = self.factors as u64 + 1;
                let mut random = random.clone();
                // Far more draws than a trajectory takes.
                random.advance(u128::from(index / points) << 64);
                trajectory_point(self.factors, *levels, (index % points) as usize, &mut random)
            }
            Scheme::Saltelli { base, second_order } => {
                let rows = saltelli_rows(self.factors, *second_order);
                let base = base.point((index / rows) as u32);
                let (a, b) = base.split_at(self.factors);
                saltelli_point(a, b, index % rows, *second_order)
            }
        }
    }
}

fn invalid(problem: impl Into<String>) -> Error {
    Error::invalid("design", problem)
}

fn check_range(what: &str, found: u64, min: u64, max: u64) -> Result<(), Error> {
    if (min..=max).contains(&found) {
        return Ok(());
    }
    Err(invalid(format!("{what}: found {found}, expected {min} to {max}")))
}

/// A random permutation of the strata for each factor (McKay et al. 1979, 2.3).
fn latin_hypercube(samples: u32, factors: usize, mut random: Pcg64Mcg) -> Scheme {
    let permutation = |_| {
        let mut strata: Vec<u32> = (0..samples).collect();
        strata.shuffle(&mut random);
        strata
    };
    let strata = (0..factors).map(permutation).collect();
    Scheme::LatinHypercube { strata, random }
}

/// A random place within a stratum; at 32 binary digits and up to 2^20 strata the sum is exact and stays inside.
fn within(stratum: u32, strata: usize, random: &mut Pcg64Mcg) -> f64 {
    let place = ((random.next_u64() >> 32) as f64 + 0.5) / 2_f64.powi(32);
    (f64::from(stratum) + place) / strata as f64
}

/// Point `step` of a random trajectory.
///
/// Morris 1991, (3), by factors: each starts at a level of the lower half or that level plus Δ = p / (2 (p - 1)), and
/// changes to the other of the two when its turn in a random order has come.
fn trajectory_point(factors: usize, levels: u32, step: usize, random: &mut Pcg64Mcg) -> Vec<f64> {
    let half = levels / 2;
    let lower: Vec<u32> = (0..factors).map(|_| random.random_range(0..half)).collect();
    let mut raised: Vec<bool> = (0..factors).map(|_| random.random()).collect();
    let mut order: Vec<usize> = (0..factors).collect();
    order.shuffle(random);
    for &factor in &order[..step] {
        raised[factor] = !raised[factor];
    }
    let level = |(lower, raised): (&u32, &bool)| lower + if *raised { half } else { 0 };
    lower.iter().zip(&raised).map(level).map(|level| f64::from(level) / f64::from(levels - 1)).collect()
}

/// The number of points of a base sample.
pub(super) fn saltelli_rows(factors: usize, second_order: bool) -> u64 {
    let mixed = if second_order { 2 * factors } else { factors };
    mixed as u64 + 2
}

/// Point `row` of a base sample: `A`, `AB_1` to `AB_k`, with second order `BA_1` to `BA_k`, and `B`, where `AB_i` is `A`
/// with coordinate `i` of `B`, and `BA_i` the converse (Saltelli 2002, Theorem 1; Saltelli et al. 2010, 2.1).
fn saltelli_point(a: &[f64], b: &[f64], row: u64, second_order: bool) -> Vec<f64> {
    let factors = a.len();
    let row = row as usize;
    let mixed = |most: &[f64], one: &[f64], factor: usize| {
        let mut point = most.to_vec();
        point[factor] = one[factor];
        point
    };
    match row {
        0 => a.to_vec(),
        _ if row <= factors => mixed(a, b, row - 1),
        _ if second_order && row <= 2 * factors => mixed(b, a, row - factors - 1),
        _ => b.to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLED: [Design; 5] = [
        Design::LatinHypercube { samples: 50 },
        Design::SobolSequence { samples: 64 },
        Design::Morris { trajectories: 12, levels: 6 },
        Design::Saltelli { samples: 16, second_order: false },
        Design::Saltelli { samples: 16, second_order: true },
    ];

    fn points(design: Design, factors: usize, seed: u64) -> Vec<Vec<f64>> {
        let sampler = Sampler::new(&design, factors, seed).expect("a sampler");
        (0..sampler.count()).map(|index| sampler.point(index)).collect()
    }

    fn problem(design: Design, factors: usize) -> String {
        Sampler::new(&design, factors, 0).expect_err("not a valid design").to_string()
    }

    #[test]
    fn one_at_a_time_goes_factor_by_factor() {
        let runs: Vec<_> = one_at_a_time(&[2, 0, 3]).collect();
        assert_eq!(runs, [(0, 0), (0, 1), (2, 0), (2, 1), (2, 2)]);
    }

    #[test]
    fn a_grid_counts_like_an_odometer() {
        let counts = [3, 1, 4, 2];
        let mut index = 0;
        for a in 0..3 {
            for c in 0..4 {
                for d in 0..2 {
                    assert_eq!(grid_point(&counts, index), [a, 0, c, d]);
                    index += 1;
                }
            }
        }
        assert_eq!(grid_count(&counts).expect("a small grid"), index);
    }

    #[test]
    fn a_grid_beyond_64_bits_is_refused() {
        let counts = [1 << 32, 1 << 31];
        assert_eq!(grid_count(&counts).expect("a grid of 2^63 points"), 1 << 63);
        assert_eq!(grid_point(&counts, (1 << 63) - 1), [(1 << 32) - 1, (1 << 31) - 1]);
        assert!(grid_count(&[1 << 32, 1 << 32]).is_err());
    }

    #[test]
    fn a_latin_hypercube_has_one_point_in_each_stratum() {
        for samples in [1, 2, 50] {
            let points = points(Design::LatinHypercube { samples }, 5, 3);
            for factor in 0..5 {
                let mut strata: Vec<u64> =
                    points.iter().map(|point| (point[factor] * samples as f64).floor() as u64).collect();
                strata.sort_unstable();
                assert_eq!(strata, (0..samples).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn the_largest_latin_hypercube_stays_in_the_open_cube() {
        let sampler = Sampler::new(&Design::LatinHypercube { samples: MAX_LATIN_HYPERCUBE }, 1, 0).expect("a sampler");
        let Scheme::LatinHypercube { strata, .. } = &sampler.scheme else { panic!("another scheme") };
        for stratum in [0, MAX_LATIN_HYPERCUBE as u32 - 1] {
            let index = strata[0].iter().position(|&s| s == stratum).expect("a permutation");
            let x = sampler.point(index as u64)[0] * MAX_LATIN_HYPERCUBE as f64;
            assert_eq!(x.floor(), f64::from(stratum));
        }
        // The place closest to the far end, 1 - 2^-33, does not round up to it.
        let last = (MAX_LATIN_HYPERCUBE - 1) as f64 + (f64::from(u32::MAX) + 0.5) / 2_f64.powi(32);
        assert!(last / (MAX_LATIN_HYPERCUBE as f64) < 1.0);
    }

    #[test]
    fn factors_of_a_latin_hypercube_are_uncorrelated() {
        // The correlation of n independent pairs has a standard deviation of 1 / sqrt(n).
        let samples = 2000;
        let points = points(Design::LatinHypercube { samples }, 4, 11);
        for a in 0..4 {
            for b in 0..a {
                let covariance = points.iter().map(|x| (x[a] - 0.5) * (x[b] - 0.5)).sum::<f64>() / samples as f64;
                assert!((12.0 * covariance).abs() < 4.0 / (samples as f64).sqrt());
            }
        }
    }

    #[test]
    fn a_trajectory_changes_each_factor_once_by_delta() {
        for levels in [2, 4, 6, 10] {
            let factors = 7;
            let delta = f64::from(levels) / (2.0 * f64::from(levels - 1));
            let points = points(Design::Morris { trajectories: 20, levels }, factors, 5);
            assert_eq!(points.len(), 20 * (factors + 1));
            let mut orders = Vec::new();
            for trajectory in points.chunks(factors + 1) {
                let mut order = Vec::new();
                for (from, to) in trajectory.iter().zip(&trajectory[1..]) {
                    let changed: Vec<usize> = (0..factors).filter(|&i| from[i] != to[i]).collect();
                    assert_eq!(changed.len(), 1);
                    assert!(((from[changed[0]] - to[changed[0]]).abs() - delta).abs() < 1e-15);
                    order.push(changed[0]);
                }
                orders.push(order.clone());
                order.sort_unstable();
                assert_eq!(order, (0..factors).collect::<Vec<_>>());
            }
            orders.dedup();
            assert!(orders.len() > 15, "the order is not random");
        }
    }

    #[test]
    fn every_level_is_visited_equally_often() {
        let (trajectories, levels) = (3000, 6);
        let mut visits = vec![0_u32; levels];
        for point in points(Design::Morris { trajectories, levels: levels as u32 }, 1, 9) {
            visits[(point[0] * (levels - 1) as f64).round() as usize] += 1;
        }
        // Each trajectory visits a level with probability 2 / p: a binomial count.
        let share = 2.0 / levels as f64;
        let mean = trajectories as f64 * share;
        let deviation = (mean * (1.0 - share)).sqrt();
        for count in visits {
            assert!((f64::from(count) - mean).abs() < 4.0 * deviation, "{count} visits, expected {mean}");
        }
    }

    #[test]
    fn the_rows_of_a_base_sample_are_those_of_salib() {
        let data: serde_json::Value =
            serde_json::from_str(include_str!("../tests/data/salib.json")).expect("valid JSON");
        for (key, second_order, rows) in [("sobol", false, 5), ("sobol_second_order", true, 8)] {
            let theirs: Vec<Vec<f64>> = serde_json::from_value(data[key]["points"].clone()).expect("points");
            assert_eq!(saltelli_rows(3, second_order), rows);
            assert_eq!(theirs.len() as u64 % rows, 0);
            for base in theirs.chunks(rows as usize) {
                let (a, b) = (&base[0], &base[base.len() - 1]);
                for (row, point) in base.iter().enumerate() {
                    assert_eq!(*point, saltelli_point(a, b, row as u64, second_order));
                }
            }
        }
    }

    #[test]
    fn a_point_depends_on_nothing_but_design_seed_and_index() {
        for design in SAMPLED {
            let all = points(design, 6, 42);
            let again = Sampler::new(&design, 6, 42).expect("a sampler");
            for index in (0..again.count()).rev() {
                assert_eq!(again.point(index), all[index as usize]);
            }
            assert_ne!(points(design, 6, 43), all);
        }
    }

    #[test]
    fn points_lie_in_the_cube() {
        for design in SAMPLED {
            let closed = matches!(design, Design::Morris { .. });
            for x in points(design, 6, 1).into_iter().flatten() {
                assert!(if closed { (0.0..=1.0).contains(&x) } else { 0.0 < x && x < 1.0 }, "{x} in {design:?}");
            }
        }
    }

    #[test]
    fn the_largest_designs_have_their_last_point() {
        let samples = MAX_SOBOL;
        for (design, factors) in [
            (Design::SobolSequence { samples }, MAX_DIMENSIONS),
            (Design::Saltelli { samples, second_order: true }, MAX_DIMENSIONS / 2),
            (Design::Morris { trajectories: MAX_SOBOL, levels: 4 }, 1000),
        ] {
            let sampler = Sampler::new(&design, factors, 0).expect("a sampler");
            assert_eq!(sampler.point(sampler.count() - 1).len(), factors);
        }
    }

    #[test]
    fn designs_out_of_range_are_refused_with_what_would_be_valid() {
        assert!(problem(Design::Grid, 2).contains("goes through the levels"));
        assert!(problem(Design::SobolSequence { samples: 8 }, 0).contains("no factors"));
        assert!(problem(Design::SobolSequence { samples: 8 }, 65).contains("found 65, expected 1 to 64"));
        assert!(problem(Design::SobolSequence { samples: MAX_SOBOL + 1 }, 3).contains("expected 1 to 4294967296"));
        assert!(problem(Design::LatinHypercube { samples: 0 }, 3).contains("found 0, expected 1 to 1048576"));
        assert!(problem(Design::Saltelli { samples: 8, second_order: true }, 33).contains("expected 1 to 32"));
        assert!(
            problem(Design::Saltelli { samples: 1, second_order: true }, 3).contains("samples: found 1, expected 2")
        );
        assert!(
            problem(Design::Morris { trajectories: 1, levels: 4 }, 3).contains("trajectories: found 1, expected 2")
        );
        for levels in [0, 5] {
            assert!(problem(Design::Morris { trajectories: 4, levels }, 3).contains("should be even"));
        }
    }

    #[test]
    fn designs_are_read_by_their_names() {
        let read = |text: &str| toml::from_str::<Design>(text);
        assert_eq!(read("kind = 'one-at-a-time'").expect("a design"), Design::OneAtATime);
        assert_eq!(
            read("kind = 'saltelli'\nsamples = 64").expect("a design"),
            Design::Saltelli { samples: 64, second_order: false }
        );
        for design in SAMPLED.into_iter().chain([Design::OneAtATime, Design::Grid]) {
            let text = toml::to_string(&design).expect("text");
            assert_eq!(read(&text).expect("a design"), design);
        }
        assert!(read("kind = 'latin-hypercube'\nsamples = 8\nlevels = 4").is_err());
        assert!(read("kind = 'random'").is_err());
    }
}
