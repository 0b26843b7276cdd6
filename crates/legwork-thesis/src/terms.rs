//! The terms in which claims are tested, each with its bound.
//!
//! The bounds are the same for all claims and were set before the sweeps were judged; only `VISIBLE` came later, and
//! lets fewer claims pass.

use std::fmt::Display;

use serde::Serialize;

use super::words::{filled, percent};

/// Rank correlation from which on a figure rises, or falls, with a parameter.
pub(crate) const TREND: f64 = 0.7;
/// Change that a trend must make at least, as a share of its mean.
pub(crate) const VISIBLE: f64 = 0.01;
/// Fewest levels at which the robot stands for a trend to be spoken of.
pub(crate) const FEWEST: usize = 4;
/// Change of a figure, as a share of the baseline's, up to which it is unchanged.
pub(crate) const UNCHANGED: f64 = 0.05;
/// Change up to which it is little changed; above it is much changed.
pub(crate) const LITTLE: f64 = 0.20;
/// Multiple of the baseline's figure from which on tracking is poor.
pub(crate) const POOR: f64 = 2.0;
/// Share of the variance that a straight line must explain.
pub(crate) const STRAIGHT: f64 = 0.9;
/// Largest gain in the upper half of a range for diminishing returns, as a share of that in the lower half.
pub(crate) const DIMINISHED: f64 = 0.5;
/// Difference to a published figure up to which it is met.
pub(crate) const MET: f64 = 0.10;

/// The terms with their meaning.
const TERMS: [(&str, &str); 9] = [
    ("stands", "the robot is on its feet to the end of the run; only such runs have figures that count"),
    (
        "rises, sinks",
        "Spearman's rank correlation of at least {trend}, or at most -{trend}, over at least {fewest} levels, and a \
         change of at least {visible}",
    ),
    ("unchanged", "from the least to the largest value, no more than {unchanged} of the baseline's own"),
    ("little changed", "the same with {little}; what is more is much changed"),
    ("poor", "at least {poor} times the baseline's own at every level, of a fall up to it"),
    ("straight", "a line explains at least {straight} of the variance"),
    (
        "diminishing",
        "the change over the upper half of the levels is less than {diminished} of that over the lower half",
    ),
    ("met", "within {met} of the published figure; an error may be less"),
    (
        "reproduced, partly, not",
        "all parts of the test hold, some of them, none; a part that nothing can be said of does not hold",
    ),
];

/// The terms with their meaning, for people who check.
pub fn terms() -> Vec<(&'static str, String)> {
    let [visible, unchanged, little] = [VISIBLE, UNCHANGED, LITTLE].map(percent);
    let [straight, diminished, met] = [STRAIGHT, DIMINISHED, MET].map(percent);
    let bounds: [(&str, &dyn Display); 9] = [
        ("trend", &TREND),
        ("fewest", &FEWEST),
        ("visible", &visible),
        ("unchanged", &unchanged),
        ("little", &little),
        ("poor", &POOR),
        ("straight", &straight),
        ("diminished", &diminished),
        ("met", &met),
    ];
    TERMS.map(|(term, meaning)| (term, filled(meaning, &bounds))).into()
}

/// One part of the test of a claim.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// Whether it holds.
    pub holds: bool,
    /// What was found, with the figures.
    pub finding: String,
}

impl Check {
    /// A part that holds or not.
    pub fn new(holds: bool, finding: impl Into<String>) -> Self {
        Self { holds, finding: finding.into() }
    }
}
