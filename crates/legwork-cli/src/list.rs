//! `legwork list` and `legwork show`: what there is and what can be set.

use legwork::Robot;
use legwork::error::Error;
use legwork::fit::Fit;
use legwork::metrics::{JOINT_METRICS, METRICS, Metric};
use legwork::scenario::Scenario;
use legwork::settings::{SETTINGS, Setting};
use legwork::{library, scenario_file};
use legwork_rbd::Model;
use legwork_rbd::words::{self, quoted};
use legwork_study::Study;
use serde_json::{Value, json};

use crate::args::{ListArgs, Listing, ShowArgs};
use crate::output::{Failure, Output, folded};

/// What is listed under one heading.
struct Section {
    title: &'static str,
    /// Name, the lines that describe it, and the same for programs.
    entries: Vec<(String, String, Value)>,
}

pub(crate) fn list(options: &ListArgs, output: &mut Output) -> Result<(), Failure> {
    let wanted = |listing| options.what.is_none_or(|what| what == listing);
    let mut sections = Vec::new();
    if wanted(Listing::Models) {
        let models = library::model_names().map(builtin_model).collect::<Result<Vec<_>, _>>()?;
        let entry = |m: &Robot| (m.name.clone(), model_line(m), model_json(m));
        sections.push(Section { title: "models", entries: models.iter().map(entry).collect() });
    }
    if wanted(Listing::Scenarios) {
        let scenarios = library::scenario_names()
            .map(|name| scenario_file::load(name, &[]).map(|loaded| loaded.scenario))
            .collect::<Result<Vec<_>, _>>()?;
        let width = scenarios.iter().map(|s| s.name.len()).max().unwrap_or(0);
        let line = |s: &Scenario| folded(&format!("  {:<width$}  {}", s.name, s.description), width + 4);
        let entry = |s: &Scenario| (s.name.clone(), line(s), json!({ "name": s.name, "description": s.description }));
        sections.push(Section { title: "scenarios", entries: scenarios.iter().map(entry).collect() });
    }
    if wanted(Listing::Studies) {
        let studies = library::study_names().map(|name| Study::load(name, &[])).collect::<Result<Vec<_>, _>>()?;
        let study_json = |s: &Study| json!({ "name": s.name, "description": s.description, "rollouts": s.len(), "design": s.design });
        let width = studies.iter().map(|s| s.name.len()).max().unwrap_or(0);
        let line =
            |s: &Study| folded(&format!("  {:<width$}  {} {} rollouts.", s.name, s.description, s.len()), width + 4);
        let entry = |s: &Study| (s.name.clone(), line(s), study_json(s));
        sections.push(Section { title: "studies", entries: studies.iter().map(entry).collect() });
    }
    if wanted(Listing::Settings) {
        let entry = |s: &Setting| (s.path.to_owned(), setting_lines(s), setting_json(s));
        sections.push(Section { title: "settings", entries: SETTINGS.iter().map(entry).collect() });
    }
    if wanted(Listing::Metrics) {
        sections.push(Section { title: "metrics", entries: METRICS.iter().map(metric_entry).collect() });
        sections.push(Section { title: "joint_metrics", entries: JOINT_METRICS.iter().map(metric_entry).collect() });
    }
    if let Some(within) = &options.within {
        restrict(&mut sections, within)?;
    }
    if options.json {
        let values = sections.into_iter().map(|section| {
            (section.title.to_owned(), section.entries.into_iter().map(|(_, _, value)| value).collect())
        });
        return output.line(Value::Object(values.collect()));
    }
    if options.what.is_none() {
        return output.line(overview(&sections));
    }
    for (_, lines, _) in sections.iter().flat_map(|section| &section.entries) {
        output.line(lines)?;
    }
    Ok(())
}

/// Leaves what is called `within`, or begins so.
fn restrict(sections: &mut [Section], within: &str) -> Result<(), Error> {
    let names: Vec<String> =
        sections.iter().flat_map(|section| &section.entries).map(|entry| entry.0.clone()).collect();
    let inside = |name: &str| name.strip_prefix(within).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'));
    let exact = names.iter().any(|name| inside(name));
    let kept = |name: &str| if exact { inside(name) } else { name.starts_with(within) };
    if !names.iter().any(|name| kept(name)) {
        let mut valid: Vec<&str> =
            names.iter().map(|name| name.rsplit_once('.').map_or(name.as_str(), |(table, _)| table)).collect();
        valid.dedup();
        let problem = format!("found {}, with which no name begins; valid are {}", quoted(within), words::list(valid));
        return Err(Error::invalid("list", problem));
    }
    sections.iter_mut().for_each(|section| section.entries.retain(|entry| kept(&entry.0)));
    Ok(())
}

/// The names of all there is, on one screen.
fn overview(sections: &[Section]) -> String {
    let mut text = String::new();
    for Section { title, entries } in sections {
        let names: Vec<String> = if *title == "settings" {
            groups()
                .into_iter()
                .map(|(name, count)| count.map_or(name.to_owned(), |count| format!("{name} ({count})")))
                .collect()
        } else {
            entries.iter().map(|(name, _, _)| name.clone()).collect()
        };
        let more = if *title == "settings" { "; of a group: legwork list settings wearer" } else { "" };
        let (title, what) =
            if *title == "joint_metrics" { ("metrics of each joint", "metrics") } else { (*title, *title) };
        text += &format!("{} {title}: legwork list {what}{more}\n", entries.len());
        // What belongs together stays on one line.
        let names: Vec<String> = names.iter().map(|name| name.replace(' ', "\u{a0}")).collect();
        text += &folded(&format!("  {}", names.join(", ")), 2).replace('\u{a0}', " ");
        text += "\n\n";
    }
    text + "legwork show NAME prints a scenario with its settings, or a study, as a file."
}

/// The tables of settings, each with the number of its settings, and the settings of no table.
fn groups() -> Vec<(&'static str, Option<usize>)> {
    let tables = SETTINGS.chunk_by(|a, b| a.table() == b.table());
    let group = |settings: &'static [Setting]| match settings[0].table() {
        "" => settings.iter().map(|setting| (setting.path, None)).collect(),
        table => vec![(table, Some(settings.len()))],
    };
    tables.flat_map(group).collect()
}

fn builtin_model(name: &str) -> Result<Robot, legwork::error::Error> {
    library::load_model(name, None)
}

fn model_line(model: &Model) -> String {
    format!(
        "  {}  {:.1} kg, {} degrees of freedom, {} actuated, {} contacts",
        model.name,
        model.total_mass(),
        model.nv(),
        model.actuated().count(),
        model.contacts.len()
    )
}

fn model_json(model: &Model) -> Value {
    json!({
        "name": model.name,
        "total_mass_kg": model.total_mass(),
        "degrees_of_freedom": model.nv(),
        "actuated": model.actuated().count(),
        "contacts": model.contacts.len(),
    })
}

fn default_text(setting: &Setting) -> String {
    setting.default().map_or_else(|| "required".into(), |value| value.to_string())
}

fn setting_lines(setting: &Setting) -> String {
    let symbol = if setting.symbol.is_empty() { String::new() } else { format!(" ({})", setting.symbol) };
    let heading = format!("  {}{symbol} = {}", setting.path, default_text(setting));
    let valid = format!("valid: {}; source: {}", setting.valid_in_words(), setting.source);
    [heading, format!("      {}", setting.help), format!("      {valid}")].map(|line| folded(&line, 6)).join("\n")
}

fn setting_json(setting: &Setting) -> Value {
    json!({
        "path": setting.path,
        "symbol": setting.symbol,
        "unit": setting.unit,
        "default": setting.default().map(|value| serde_json::to_value(value).unwrap_or(Value::Null)),
        "valid": setting.valid.to_string(),
        "source": setting.source,
        "help": setting.help,
    })
}

fn metric_entry<Of>(metric: &Metric<Of>) -> (String, String, Value) {
    let unit = if metric.unit.is_empty() { String::new() } else { format!(" [{}]", metric.unit) };
    let heading = format!("  {}: {}{unit}, {}", metric.name, metric.label, metric.kind());
    let lines = [heading, format!("      {}", metric.help)].map(|line| folded(&line, 6)).join("\n");
    let value = json!({
        "name": metric.name,
        "label": metric.label,
        "unit": metric.unit,
        "kind": metric.kind(),
        "help": metric.help,
    });
    (metric.name.to_owned(), lines, value)
}

pub(crate) fn show(options: &ShowArgs, output: &mut Output) -> Result<(), Failure> {
    if let Some(text) = library::study_text(&options.scenario) {
        if let Some(set) = options.sets.first() {
            let problem = "a study is shown as it is; give this to `legwork study`";
            return Err(Error::invalid("--set ".to_owned() + set, problem).into());
        }
        return output.line(text.trim_end());
    }
    let loaded = scenario_file::load(&options.scenario, &options.sets)?;
    let scenario = &loaded.scenario;
    let scenario = if scenario.fit == Fit::None && scenario.start.com_height_m > 0.0 {
        loaded.portable()
    } else {
        loaded.fitted(&loaded.model()?)?
    };
    output.line(scenario_file::to_toml(&scenario).trim_end())
}
