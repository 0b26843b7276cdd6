//! `legwork reproduce`: everything that the thesis reports, beside what is measured.

use std::fmt::Write;
use std::fs;
use std::process::ExitCode;

use legwork::error::Error;
use legwork_study::parallel;
use legwork_study::rollout::DOUBT;
use legwork_thesis::case::Reading;
use legwork_thesis::claims::Verdict;
use legwork_thesis::limits::Measured;
use legwork_thesis::words::with_unit;
use legwork_thesis::{Reproduction, files};

use crate::args::ReproduceArgs;
use crate::limits::text::{star, starred};
use crate::long_work::{INTERRUPTED, Progress, interrupted, listen_for_interrupt};
use crate::output::{Failure, Output, PAGE, check_writable, folded, say, warn, write_page, write_text};

const RESULTS: &str = "results.json";

/// Runs everything, writes the folder and prints the summary.
pub(crate) fn reproduce(options: &ReproduceArgs, output: &mut Output) -> Result<ExitCode, Failure> {
    let folder = &options.out;
    fs::create_dir_all(folder).map_err(|error| Error::io(folder, &error))?;
    check_writable(&folder.join(RESULTS))?;
    listen_for_interrupt();
    let bar = Progress::new("reproduce", legwork_thesis::amount()?, "{percent} %");
    let run = || legwork_thesis::run(|done| bar.tell(done), interrupted);
    let result = parallel::with_threads(options.threads.map(usize::from), run)?;
    bar.finish();
    let Some(reproduction) = result? else {
        say("interrupted; nothing is written");
        return Ok(ExitCode::from(INTERRUPTED));
    };
    files::write(&reproduction, folder)?;
    let json = reproduction.to_json();
    write_text(&folder.join(RESULTS), &format!("{json:#}\n"))?;
    write_page(&legwork_report::reproduction::page(&reproduction), folder)?;
    output.line(if options.json { json.to_string() } else { summary(&reproduction) })?;
    output.flush()?;
    let [doubtful, rollouts] = reproduction.doubtful();
    if doubtful > 0 {
        warn(&format!("reproduce: {doubtful} of {rollouts} rollouts {DOUBT}"));
    }
    say(&format!("report: {}", folder.join(PAGE).display()));
    Ok(ExitCode::SUCCESS)
}

/// Verdicts, limits and answers for people.
fn summary(reproduction: &Reproduction) -> String {
    let mut text = String::new();
    claims(reproduction, &mut text);
    text += &tables(reproduction);
    text += &limits(reproduction);
    for question in &reproduction.questions {
        let _ =
            write!(text, "\n{}\n  {}\n", folded(question.asks, 0), folded(&format!("  {}", question.answer), 2).trim());
    }
    text.truncate(text.trim_end().len());
    text
}

/// The claims, a line or a few each, with both verdicts; then what is known of those that are not reproduced.
fn claims(reproduction: &Reproduction, text: &mut String) {
    let [first, second] = Reading::ALL.map(Reading::name);
    let _ = writeln!(text, "Claims of the thesis, in two readings of the least step length\n");
    let _ = writeln!(text, "{:<9}{first:<14}{second:<17}", "");
    for claim in &reproduction.claims {
        let verdicts = claim.findings.iter().map(|finding| finding.verdict.name()).collect::<Vec<_>>();
        let head = format!("{:<9}{:<14}{:<17}", claim.id, verdicts[0], verdicts[1]);
        let _ = writeln!(text, "{head}{}", wrapped(&claim.says_and_basis(), head.chars().count()));
    }
    for reading in Reading::ALL {
        let counts = reproduction.counts(reading);
        let parts: Vec<String> =
            Verdict::ALL.iter().zip(counts).map(|(verdict, count)| format!("{count} {}", verdict.name())).collect();
        let _ = write!(text, "\n{}: {} of {} claims", reading.name(), parts.join(", "), reproduction.claims.len());
        let _ = write!(
            text,
            "; {} of the reproduced are fitted or by construction",
            reproduction.without_evidence(reading)
        );
    }
    text.push('\n');
}

/// The words in lines up to the terminal's width, of which all but the first begin at column `indent`.
fn wrapped(words: &str, indent: usize) -> String {
    folded(&format!("{}{words}", "\u{a0}".repeat(indent)), indent).trim_start_matches('\u{a0}').to_owned()
}

/// How much of the tables is met.
fn tables(reproduction: &Reproduction) -> String {
    let mut text = "\nFigures of the thesis's tables within 10 % and within 25 %".to_owned();
    for table in &reproduction.tables {
        let _ = write!(text, "\n  {:<5}{:<28}", table.number, table.title);
        for (index, reading) in Reading::ALL.iter().enumerate() {
            let cells: Vec<_> = table.rows.iter().map(|row| &row.measured[index]).collect();
            let within = |share: f64| {
                cells.iter().filter(|cell| cell.deviation.is_none_or(|deviation| deviation.abs() <= share)).count()
            };
            let fell = if cells.iter().any(|cell| cell.fell) { ", fell" } else { "" };
            let star = star(cells.iter().find_map(|cell| cell.violations.as_ref()));
            let entry = format!("{} and {} of {}{fell}{star}", within(0.10), within(0.25), cells.len());
            let _ = write!(text, "{entry:<24}");
            if index + 1 == Reading::ALL.len() {
                text.truncate(text.trim_end().len());
            }
            debug_assert!(table.rows.iter().all(|row| row.measured[index].reading == *reading));
        }
    }
    starred(text) + "\n"
}

fn limits(reproduction: &Reproduction) -> String {
    let [first, second] = Reading::ALL.map(Reading::name);
    let mut text = String::new();
    let _ = write!(text, "\nLimits\n  {:<40}{:>10}{first:>14}{second:>16}", "", "thesis");
    for row in &reproduction.evidence.limits {
        let number = |value: Option<f64>| value.map_or("none".to_owned(), |value| with_unit(value, row.unit));
        let thesis = row.thesis.map_or(String::new(), |value| with_unit(value, row.unit));
        let shown = |measured: &Measured| number(measured.value) + star(measured.violations.as_ref());
        let measured: Vec<String> = row.measured.iter().map(shown).collect();
        let _ = write!(text, "\n  {:<40}{thesis:>10}{:>14}{:>16}", row.quantity, measured[0], measured[1]);
    }
    starred(text) + "\n"
}
