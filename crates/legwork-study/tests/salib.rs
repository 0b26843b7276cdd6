//! Designs and sensitivity indices, held against closed forms and against Python's SALib (`data/salib.py`).

use std::f64::consts::PI;

use legwork_study::design::{Design, Sampler};
use legwork_study::sensitivity::{Bootstrap, Estimate, Indices, Shares, morris, sobol_indices};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde_json::Value;

/// A function on the unit cube.
type Function = fn(&[f64]) -> f64;

/// Ishigami and Homma 1990 (doi:10.1109/ISUMA.1990.151285), with a = 7 and b = 0.1, from the unit cube.
fn ishigami(x: &[f64]) -> f64 {
    let x: Vec<f64> = x.iter().map(|x| PI * (2.0 * x - 1.0)).collect();
    x[0].sin() + 7.0 * x[1].sin().powi(2) + 0.1 * x[2].powi(4) * x[0].sin()
}

/// First-order, total and second-order indices in closed form.
struct Truth {
    mean: f64,
    variance: f64,
    first: Vec<f64>,
    total: Vec<f64>,
    second: Vec<f64>,
}

fn ishigami_truth() -> Truth {
    let (a, b) = (7.0_f64, 0.1_f64);
    let one = 0.5 * (1.0 + b * PI.powi(4) / 5.0).powi(2);
    let two = a * a / 8.0;
    let both = b * b * PI.powi(8) * (1.0 / 18.0 - 1.0 / 50.0);
    let variance = one + two + both;
    Truth {
        mean: a / 2.0,
        variance,
        first: [one, two, 0.0].map(|v| v / variance).to_vec(),
        total: [one + both, two, both].map(|v| v / variance).to_vec(),
        second: [0.0, both, 0.0].map(|v| v / variance).to_vec(),
    }
}

const G: [f64; 8] = [0.0, 1.0, 4.5, 9.0, 99.0, 99.0, 99.0, 99.0];

/// The g-function of Saltelli and Sobol' 1995 (doi:10.1016/0951-8320(95)00099-2).
fn g_function(x: &[f64]) -> f64 {
    x.iter().zip(G).map(|(x, a)| ((4.0 * x - 2.0).abs() + a) / (1.0 + a)).product()
}

fn g_truth() -> Truth {
    let part = G.map(|a| 1.0 / (3.0 * (1.0 + a) * (1.0 + a)));
    let product: f64 = part.iter().map(|v| 1.0 + v).product();
    let variance = product - 1.0;
    let pairs = (0..8).flat_map(|i| (i + 1..8).map(move |j| (i, j)));
    Truth {
        mean: 1.0,
        variance,
        first: part.iter().map(|v| v / variance).collect(),
        total: part.iter().map(|v| v * product / (1.0 + v) / variance).collect(),
        second: pairs.map(|(i, j)| part[i] * part[j] / variance).collect(),
    }
}

fn outputs(design: Design, factors: usize, seed: u64, function: Function) -> Vec<f64> {
    let sampler = Sampler::new(&design, factors, seed).expect("a sampler");
    (0..sampler.count()).map(|index| function(&sampler.point(index))).collect()
}

fn shares(indices: &Indices) -> &Shares {
    indices.shares.as_ref().expect("an output that varies")
}

/// All estimates beside their true values.
fn beside<'a>(shares: &'a Shares, truth: &'a Truth) -> impl Iterator<Item = (Estimate, f64)> + 'a {
    let ours = shares.first.iter().chain(&shares.total).copied().chain(shares.second.iter().map(|pair| pair.index));
    ours.zip(truth.first.iter().chain(&truth.total).chain(&truth.second).copied())
}

/// Outputs of independent base samples, in the order of [`Design::Saltelli`] without second order.
fn independent(samples: usize, factors: usize, seed: u64, function: Function) -> Vec<f64> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut outputs = Vec::new();
    for _ in 0..samples {
        let a: Vec<f64> = (0..factors).map(|_| random.random()).collect();
        let b: Vec<f64> = (0..factors).map(|_| random.random()).collect();
        outputs.push(function(&a));
        for factor in 0..factors {
            let mut mixed = a.clone();
            mixed[factor] = b[factor];
            outputs.push(function(&mixed));
        }
        outputs.push(function(&b));
    }
    outputs
}

/// The most that the error of a mean of independent numbers should be, in standard deviations: 1 in 16000 is beyond.
const FAR: f64 = 4.0;

fn bootstrap(resamples: usize, level: f64) -> Bootstrap {
    Bootstrap { resamples, level, seed: 1 }
}

fn functions() -> [(Function, Truth); 2] {
    [(ishigami, ishigami_truth()), (g_function, g_truth())]
}

#[test]
fn the_closed_forms_are_those_that_are_published() {
    let truth = ishigami_truth();
    for (ours, printed) in [(&truth.first, [0.3139, 0.4424, 0.0]), (&truth.total, [0.5576, 0.4424, 0.2437])] {
        assert!(ours.iter().zip(printed).all(|(ours, printed)| (ours - printed).abs() < 5e-5));
    }
    // With three factors that interact in one pair, all shares add up to one.
    assert!((truth.first.iter().sum::<f64>() + truth.second[1] - 1.0).abs() < 1e-15);
}

#[test]
fn estimates_converge_to_the_closed_forms() {
    for (function, truth) in functions() {
        let factors = truth.first.len();
        let error = |samples| {
            let (seeds, mut squares, mut count) = (10, 0.0, 0);
            for seed in 0..seeds {
                let outputs = outputs(Design::Saltelli { samples, second_order: true }, factors, seed, function);
                let indices = sobol_indices(&outputs, factors, true, &bootstrap(4, 0.5)).expect("complete outputs");
                for (estimate, truth) in beside(shares(&indices), &truth) {
                    squares += (estimate.value - truth).powi(2);
                    count += 1;
                }
                // Mean and variance of 2 N points, as if they were independent; y² stays below four variances and means.
                let mean_error = (truth.variance / (2 * samples) as f64).sqrt();
                assert!((indices.mean - truth.mean).abs() < FAR * mean_error);
                assert!((indices.variance / truth.variance - 1.0).abs() < FAR * 2.0 / ((2 * samples) as f64).sqrt());
            }
            (squares / f64::from(count)).sqrt()
        };
        // Independent points would make the error four times smaller; the sequence does better.
        let (coarse, fine) = (error(256), error(4096));
        assert!(fine < coarse / 5.0, "{coarse} at 256, {fine} at 4096");
        // The terms of an estimate have a standard deviation of about one.
        assert!(fine < 1.0 / 4096_f64.sqrt() / 4.0, "{fine}");
    }
}

#[test]
fn intervals_are_as_wide_as_the_delta_method_says() {
    let samples = 2000;
    for (function, truth) in functions() {
        let factors = truth.first.len();
        let outputs = independent(samples, factors, 5, function);
        let indices = sobol_indices(&outputs, factors, false, &bootstrap(2000, 0.95)).expect("complete outputs");
        let centre = outputs.iter().sum::<f64>() / outputs.len() as f64;
        for factor in 0..factors {
            // An estimate is a mean of terms over a variance; its own terms are the linear part of that quotient.
            let spread = |index: f64, term: fn(f64, f64, f64) -> f64| {
                let parts = outputs.chunks(factors + 2).map(|y| {
                    let (a, ab, b) = (y[0] - centre, y[factor + 1] - centre, y[factors + 1] - centre);
                    let deviation = |y: f64| (y + centre - indices.mean).powi(2);
                    (term(a, ab, b) - index * 0.5 * (deviation(a) + deviation(b))) / indices.variance
                });
                (parts.map(|part| part * part).sum::<f64>()).sqrt() / samples as f64
            };
            let shares = shares(&indices);
            let first = spread(shares.first[factor].value, |a, ab, b| b * (ab - a));
            let total = spread(shares.total[factor].value, |a, ab, _| 0.5 * (a - ab).powi(2));
            for (estimate, spread) in [(shares.first[factor], first), (shares.total[factor], total)] {
                let width = (estimate.high - estimate.low) / (2.0 * 1.96 * spread);
                // Each end of 2000 replicates deviates by 6 % of a spread, and the centre moves with the sample.
                assert!((width - 1.0).abs() < 0.1, "{estimate:?}, spread {spread}");
            }
        }
    }
}

/// The share of intervals of independent samples that hold the truth, for each index.
fn coverage(function: Function, truth: &Truth, level: f64) -> Vec<f64> {
    let (seeds, factors) = (200, truth.first.len());
    let mut held = vec![0.0; 2 * factors];
    for seed in 0..seeds {
        let outputs = independent(128, factors, seed, function);
        let indices = sobol_indices(&outputs, factors, false, &bootstrap(400, level)).expect("complete outputs");
        for (held, (estimate, truth)) in held.iter_mut().zip(beside(shares(&indices), truth)) {
            *held += f64::from(u8::from(estimate.low <= truth && truth <= estimate.high)) / seeds as f64;
        }
    }
    held
}

#[test]
fn intervals_hold_the_truth_about_as_often_as_they_should() {
    for (function, truth) in functions() {
        for level in [0.5, 0.95] {
            let held = coverage(function, &truth, level);
            // A binomial count, and up to 3 % less for so few samples of such skewed terms.
            let far = FAR * (level * (1.0 - level) / 200.0).sqrt();
            for held in &held {
                assert!((level - 0.03 - far..=level + far).contains(held), "{held} instead of {level}");
            }
            let mean = held.iter().sum::<f64>() / held.len() as f64;
            assert!((level - 0.04..=level + 0.02).contains(&mean), "{mean} instead of {level}");
        }
    }
}

#[test]
fn intervals_of_the_design_are_wide_enough_taken_together() {
    for (function, truth) in functions() {
        let factors = truth.first.len();
        let (mut held, mut count) = (0, 0);
        for seed in 0..20 {
            let outputs = outputs(Design::Saltelli { samples: 512, second_order: true }, factors, seed, function);
            let indices = sobol_indices(&outputs, factors, true, &bootstrap(200, 0.95)).expect("complete outputs");
            for (estimate, truth) in beside(shares(&indices), &truth) {
                held += u32::from(estimate.low <= truth && truth <= estimate.high);
                count += 1;
            }
        }
        assert!(f64::from(held) > 0.95 * f64::from(count), "{held} of {count}");
    }
}

#[test]
fn indices_depend_on_neither_unit_nor_zero() {
    let design = Design::Saltelli { samples: 64, second_order: true };
    let plain = outputs(design, 3, 2, ishigami);
    let find = |outputs: &[f64]| sobol_indices(outputs, 3, true, &Bootstrap::default()).expect("complete outputs");
    let truth = ishigami_truth();
    let expected = find(&plain);
    for (scale, zero, tolerance) in [(-1e-3, 0.0, 1e-12), (2.0, 1e6, 1e-9), (1e300, 0.0, 1e-12)] {
        let moved: Vec<f64> = plain.iter().map(|y| scale * y + zero).collect();
        let found = find(&moved);
        assert!((found.mean - (scale * expected.mean + zero)).abs() < 1e-12 * (scale.abs() + zero));
        for ((ours, _), (theirs, _)) in beside(shares(&found), &truth).zip(beside(shares(&expected), &truth)) {
            for (a, b) in [(ours.value, theirs.value), (ours.low, theirs.low), (ours.high, theirs.high)] {
                assert!((a - b).abs() < tolerance, "{a} and {b}");
            }
        }
    }
}

#[test]
fn a_factor_without_influence_has_indices_of_zero() {
    let design = Design::Saltelli { samples: 32, second_order: true };
    let outputs = outputs(design, 3, 4, |x| x[0] + x[2] * x[2]);
    let indices = sobol_indices(&outputs, 3, true, &Bootstrap::default()).expect("complete outputs");
    let zero = Estimate { value: 0.0, low: 0.0, high: 0.0 };
    assert_eq!(shares(&indices).first[1], zero);
    assert_eq!(shares(&indices).total[1], zero);
    assert!(shares(&indices).total[0].low > 0.1);
}

#[test]
fn an_output_that_never_changes_has_no_shares() {
    for constant in [0.0, 0.1, -7e8] {
        let indices = sobol_indices(&[constant; 50], 3, false, &Bootstrap::default()).expect("complete outputs");
        assert!((indices.mean - constant).abs() <= 1e-15 * constant.abs());
        assert_eq!((indices.variance, indices.shares), (0.0, None));
    }
}

#[test]
fn a_rare_event_has_finite_indices() {
    let mut outputs = vec![0.0; 20 * 5];
    outputs[35..37].fill(1.0);
    let indices = sobol_indices(&outputs, 3, false, &Bootstrap::default()).expect("complete outputs");
    let shares = shares(&indices);
    for estimate in shares.first.iter().chain(&shares.total) {
        assert!(estimate.value.is_finite() && estimate.low.is_finite() && estimate.high.is_finite());
    }
    // In that base sample A is 1, AB_1 is 1, the others are 0.
    assert_eq!(shares.total[0].value, 0.0);
    assert!(shares.total[1].value > 0.0);
}

#[test]
fn a_base_sample_with_a_missing_output_is_left_out() {
    let mut outputs = outputs(Design::Saltelli { samples: 32, second_order: true }, 3, 6, ishigami);
    let find = |outputs: &[f64]| sobol_indices(outputs, 3, true, &Bootstrap::default());
    let complete = [&outputs[..16], &outputs[24..80], &outputs[88..]].concat();
    outputs[17] = f64::NAN;
    outputs[87] = f64::INFINITY;
    outputs[80] = f64::NAN;
    let (found, expected) = (find(&outputs).expect("30 samples"), find(&complete).expect("30 samples"));
    assert_eq!((found.used, found.left_out), (30, 2));
    assert_eq!((expected.used, expected.left_out), (30, 0));
    assert_eq!(found.shares, expected.shares);
    assert_eq!((found.mean, found.variance), (expected.mean, expected.variance));

    let error = find(&outputs[8..24]).expect_err("one sample is too few").to_string();
    assert!(error.contains("1 of 2 base samples"), "{error}");
}

#[test]
fn outputs_of_another_design_are_refused() {
    let find = |count, factors| {
        let outputs = vec![1.0; count];
        sobol_indices(&outputs, factors, false, &Bootstrap::default()).expect_err("another design").to_string()
    };
    assert!(find(51, 3).contains("found 51 for 3 factors, expected a multiple of 5"));
    assert!(find(10, 0).contains("for 0 factors"));
    assert!(find(0, 3).contains("0 of 0 base samples"));
}

#[test]
fn the_bootstrap_changes_intervals_and_nothing_else() {
    let outputs = outputs(Design::Saltelli { samples: 32, second_order: true }, 3, 6, ishigami);
    let find = |bootstrap: Bootstrap| {
        let indices = sobol_indices(&outputs, 3, true, &bootstrap).expect("complete outputs");
        shares(&indices).total[0]
    };
    let (one, same, other) = (find(bootstrap(100, 0.9)), find(bootstrap(100, 0.9)), find(bootstrap(101, 0.9)));
    assert_eq!(one, same);
    assert_eq!(one.value, other.value);
    assert_ne!((one.low, one.high), (other.low, other.high));
    let narrow = find(bootstrap(100, 0.5));
    assert!(one.low < narrow.low && narrow.high < one.high);
}

/// Points and outputs of twelve trajectories.
fn trajectories(factors: usize, function: Function) -> (Vec<Vec<f64>>, Vec<f64>) {
    let sampler = Sampler::new(&Design::Morris { trajectories: 12, levels: 4 }, factors, 8).expect("a sampler");
    let points: Vec<Vec<f64>> = (0..sampler.count()).map(|index| sampler.point(index)).collect();
    let outputs = points.iter().map(|point| function(point)).collect();
    (points, outputs)
}

#[test]
fn effects_on_a_linear_function_are_its_coefficients() {
    let (points, outputs) = trajectories(3, |x| 5.0 + 2.0 * x[0] - 3.0 * x[2]);
    let effects = morris(&points, &outputs, &Bootstrap::default()).expect("trajectories");
    // Outputs up to 7 are rounded by 1e-15, and their differences divided by 2/3.
    for (effects, coefficient) in effects.iter().zip([2.0_f64, 0.0, -3.0]) {
        assert_eq!(effects.used, 12);
        assert!((effects.mu - coefficient).abs() < 1e-14);
        for value in [effects.mu_star.value, effects.mu_star.low, effects.mu_star.high] {
            assert!((value - coefficient.abs()).abs() < 1e-14);
        }
        assert!(effects.sigma < 1e-14);
    }
}

#[test]
fn an_interaction_and_a_curve_show_in_sigma() {
    let (points, outputs) = trajectories(4, |x| x[0] * x[1] + (x[2] - 0.5).powi(2) + x[3]);
    let effects = morris(&points, &outputs, &Bootstrap::default()).expect("trajectories");
    for factor in 0..3 {
        assert!(effects[factor].sigma > 0.1, "{:?}", effects[factor]);
        assert!(effects[factor].mu_star.low < effects[factor].mu_star.high);
    }
    assert!(effects[3].sigma < 1e-14);
    // Steps across the middle of a parabola go both ways.
    assert!(effects[2].mu.abs() < effects[2].mu_star.value);
    // The effect of x0 is x1, whose mean over the levels 0, 1/3, 2/3, 1 is 1/2 with a spread of 0.37.
    assert!((effects[0].mu - 0.5).abs() < FAR * 0.37 / 12_f64.sqrt());
}

#[test]
fn effects_beside_a_missing_output_are_left_out() {
    let (points, mut outputs) = trajectories(3, |x| 2.0 * x[0] - 3.0 * x[1] + x[2]);
    outputs[5] = f64::NAN;
    outputs[8] = f64::INFINITY;
    let effects = morris(&points, &outputs, &Bootstrap::default()).expect("trajectories");
    // An inner point takes two effects with it, a trajectory's first point one.
    assert_eq!(effects.iter().map(|effects| effects.used).sum::<usize>(), 36 - 3);
    for (effects, coefficient) in effects.iter().zip([2.0, -3.0, 1.0]) {
        assert!((effects.mu - coefficient).abs() < 1e-14);
    }
    let error = morris(&points, &vec![f64::NAN; 48], &Bootstrap::default()).expect_err("no effects").to_string();
    assert!(error.contains("factor 0 has 0 effects"), "{error}");
}

#[test]
fn points_that_are_no_trajectories_are_refused() {
    let (points, outputs) = trajectories(3, |x| x[0]);
    let problem = |points: &[Vec<f64>], outputs: &[f64]| {
        morris(points, outputs, &Bootstrap::default()).expect_err("no trajectories").to_string()
    };
    assert!(problem(&points[1..], &outputs).contains("found 48, expected 47"));
    assert!(problem(&points[1..], &outputs[1..]).contains("no trajectories"));
    assert!(problem(&[], &[]).contains("no trajectories"));
    let mut broken = points.clone();
    broken.swap(1, 6);
    assert!(problem(&broken, &outputs).contains("changes no factor, several"));
    let mut back_and_forth = points.clone();
    back_and_forth[2] = points[0].clone();
    assert!(problem(&back_and_forth, &outputs).contains("for the second time"));
    back_and_forth[2].pop();
    assert!(problem(&back_and_forth, &outputs).contains("no trajectories"));
}

fn salib() -> Value {
    serde_json::from_str(include_str!("data/salib.json")).expect("valid JSON")
}

fn numbers(value: &Value) -> Vec<f64> {
    serde_json::from_value(value.clone()).expect("a list of numbers")
}

#[test]
fn sobol_indices_are_those_of_salib() {
    for (key, second_order) in [("sobol", false), ("sobol_second_order", true)] {
        let theirs = &salib()[key];
        let indices = sobol_indices(&numbers(&theirs["outputs"]), 3, second_order, &Bootstrap::default());
        let indices = indices.expect("complete outputs");
        let shares = shares(&indices);
        for (ours, theirs) in [(&shares.first, &theirs["S1"]), (&shares.total, &theirs["ST"])] {
            for (ours, theirs) in ours.iter().zip(numbers(theirs)) {
                assert!((ours.value - theirs).abs() < 1e-10, "{} and {theirs}", ours.value);
            }
        }
        assert_eq!(shares.second.len(), if second_order { 3 } else { 0 });
        for (pair, row) in shares.second.iter().zip(theirs["S2"].as_array().into_iter().flatten()) {
            let row = numbers(row);
            assert_eq!(pair.factors.map(|factor| factor as f64), row[..2]);
            assert!((pair.index.value - row[2]).abs() < 1e-10, "{} and {}", pair.index.value, row[2]);
        }
    }
}

#[test]
fn elementary_effects_are_those_of_salib() {
    for theirs in salib()["morris"].as_array().expect("a list") {
        let points: Vec<Vec<f64>> = serde_json::from_value(theirs["points"].clone()).expect("points");
        let effects = morris(&points, &numbers(&theirs["outputs"]), &Bootstrap::default()).expect("trajectories");
        for (key, ours) in [
            ("mu", effects.iter().map(|e| e.mu).collect::<Vec<_>>()),
            ("mu_star", effects.iter().map(|e| e.mu_star.value).collect()),
            ("sigma", effects.iter().map(|e| e.sigma).collect()),
        ] {
            for (ours, theirs) in ours.iter().zip(numbers(&theirs[key])) {
                assert!((ours - theirs).abs() < 1e-10, "{key}: {ours} and {theirs}");
            }
        }
    }
}
