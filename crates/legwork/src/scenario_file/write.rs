//! Writing a scenario in full.

use std::fmt::Write as _;

use textwrap::{Options, WordSeparator, WordSplitter};
use toml::Value;

use crate::scenario::Scenario;
use crate::settings::{self, SETTINGS, Setting, at};

/// The scenario as TOML with every value that is in use, each with a comment: meaning, symbol, range, unit, default and its source.
///
/// What [`super::parse`] reads from it runs as `scenario` does, if its values are valid.
///
/// # Panics
/// If the seed is above `i64::MAX`.
pub fn to_toml(scenario: &Scenario) -> String {
    let mut tree = settings::in_use(scenario);
    let mut text = String::new();
    for group in SETTINGS.chunk_by(|a, b| a.table() == b.table()) {
        let group: Vec<_> = group.iter().map(|setting| (setting, wrapped(&comment(setting)))).collect();
        match group[0].0.table() {
            "pushes.N" => {
                for index in 0..scenario.pushes.len() {
                    text += "\n[[pushes]]\n";
                    write_values(&group, &index.to_string(), &mut tree, &mut text);
                }
            }
            table => {
                if group.iter().all(|(setting, _)| at(&mut tree, setting.path).is_none()) {
                    continue;
                }
                if !table.is_empty() {
                    let _ = writeln!(text, "\n[{table}]");
                }
                write_values(&group, "", &mut tree, &mut text);
            }
        }
    }
    text
}

/// The values of a table that are in use, each with its comment; `index` stands for the N in their paths.
fn write_values(group: &[(&Setting, String)], index: &str, tree: &mut Value, text: &mut String) {
    for (setting, comment) in group {
        let path = setting.path.replace('N', index);
        let Some(value) = at(tree, &path) else { continue };
        let _ = writeln!(text, "{comment}{} = {value}", setting.key());
    }
}

/// Columns of a comment.
const WIDTH: usize = 100;

/// A comment in lines of at most [`WIDTH`] columns, where its words allow it.
fn wrapped(comment: &str) -> String {
    let options = Options::new(WIDTH).initial_indent("# ").subsequent_indent("# ").break_words(false);
    let options = options.word_splitter(WordSplitter::NoHyphenation).word_separator(WordSeparator::AsciiSpace);
    textwrap::fill(comment, options) + "\n"
}

fn comment(setting: &Setting) -> String {
    let symbol = if setting.symbol.is_empty() { String::new() } else { format!("{}: ", setting.symbol) };
    let default = match setting.default() {
        Some(default) => format!("default {default} ({})", setting.source),
        None => "required".to_owned(),
    };
    format!("{symbol}{} Valid is {}; {default}.", setting.help, setting.valid_in_words())
}
