//! The terms in which claims are tested, each with its bound.
//!
//! The bounds are the same for all claims and were set before the sweeps were judged; only [`VISIBLE`] came later, and
//! lets fewer claims pass.

use serde::Serialize;

/// Rank correlation from which on a figure rises, or falls, with a parameter.
pub const TREND: f64 = 0.7;
/// Change that a trend must make at least, as a share of its mean.
pub const VISIBLE: f64 = 0.01;
/// Fewest levels at which the robot stands for a trend to be spoken of.
pub const FEWEST: usize = 4;
/// Change of a figure, as a share of the baseline's, up to which it is unchanged.
pub const UNCHANGED: f64 = 0.05;
/// Change up to which it is little changed; above it is much changed.
pub const LITTLE: f64 = 0.20;
/// Multiple of the baseline's figure from which on tracking is poor.
pub const POOR: f64 = 2.0;
/// Share of the variance that a straight line must explain.
pub const STRAIGHT: f64 = 0.9;
/// Largest gain in the upper half of a range for diminishing returns, as a share of that in the lower half.
pub const DIMINISHED: f64 = 0.5;
/// Difference to a published figure up to which it is met.
pub const MET: f64 = 0.10;

/// The terms with their meaning, for people who check.
pub fn terms() -> Vec<(&'static str, String)> {
    let percent = |share: f64| format!("{:.0} %", 100.0 * share);
    vec![
        ("stands", "the robot is on its feet to the end of the run; only such runs have figures that count".into()),
        (
            "rises, sinks",
            format!(
                "Spearman's rank correlation of at least {TREND}, or at most -{TREND}, over at least {FEWEST} levels, \
                 and a change of at least {}",
                percent(VISIBLE)
            ),
        ),
        (
            "unchanged",
            format!("from the least to the largest value, no more than {} of the baseline's own", percent(UNCHANGED)),
        ),
        ("little changed", format!("the same with {}; what is more is much changed", percent(LITTLE))),
        ("poor", format!("at least {POOR} times the baseline's own, or a fall")),
        ("straight", format!("a line explains at least {} of the variance", percent(STRAIGHT))),
        (
            "diminishing",
            format!(
                "the change over the upper half of the levels is less than {} of that over the lower half",
                percent(DIMINISHED)
            ),
        ),
        ("met", format!("within {} of the published figure; an error may be less", percent(MET))),
        (
            "reproduced, partly, not",
            "all parts of the test hold, some of them, none; a part that nothing can be said of does not hold".into(),
        ),
    ]
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
