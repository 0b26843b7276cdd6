//! Results to pages and figures: text in memory, without files, clocks or a terminal.
//!
//! | module | page |
//! |---|---|
//! | [`run`] | runs, with animation, figures, books and how to repeat them |
//! | [`study`] | a study: how its rollouts ended, and what its factors do |
//! | [`envelope`] | limits, robustness and actuators |
//! | [`comparison`] | two robots beside a person |
//! | [`reproduction`] | the thesis beside what is measured |
//! | [`growth`] | the figure of how a tick's time grows with the robot |
//!
//! A page is complete in itself and loads nothing. Each figure is drawn twice, for wide and for narrow pages, as the text of a
//! drawing shrinks with it.

mod charts;
pub mod comparison;
pub mod document;
pub mod envelope;
pub mod growth;
pub mod reproduction;
pub mod run;
pub mod study;

/// Widths at which figures are drawn [px].
const WIDE: f64 = 860.0;
const NARROW: f64 = 380.0;

/// A name that any file system takes.
fn file_name(name: &str) -> String {
    let kept = |c: char| if c.is_alphanumeric() || "_-".contains(c) { c } else { '-' };
    let text: String = name.chars().take(80).map(kept).collect();
    let text = text.trim_matches('-');
    if text.is_empty() { "run".to_owned() } else { text.to_owned() }
}
