//! `legwork list` and `legwork show`: what there is and what can be set.

use legwork::error::Error;
use legwork::metrics::{JOINT_METRICS, METRICS, Metric};
use legwork::scenario::Scenario;
use legwork::settings::{SETTINGS, Setting};
use legwork::{library, scenario_file};
use legwork_rbd::Model;
use legwork_study::Study;
use serde_json::{Value, json};

use crate::args::{ListArgs, Listing, ShowArgs};
use crate::output::{Failure, Output, folded};

pub(crate) fn list(options: &ListArgs, output: &mut Output) -> Result<(), Failure> {
    let wanted = |listing| options.what.is_none_or(|what| what == listing);
    let mut object = serde_json::Map::new();
    let mut sections: Vec<(&str, Vec<String>)> = Vec::new();
    if wanted(Listing::Models) {
        let models = library::model_names().map(builtin_model).collect::<Result<Vec<_>, _>>()?;
        object.insert("models".into(), models.iter().map(model_json).collect());
        sections.push(("models", models.iter().map(model_line).collect()));
    }
    if wanted(Listing::Scenarios) {
        let scenarios = library::scenario_names()
            .map(|name| scenario_file::load(name, &[]).map(|loaded| loaded.scenario))
            .collect::<Result<Vec<_>, _>>()?;
        object.insert(
            "scenarios".into(),
            scenarios.iter().map(|s| json!({ "name": s.name, "description": s.description })).collect(),
        );
        let width = scenarios.iter().map(|s| s.name.len()).max().unwrap_or(0);
        let line = |s: &Scenario| folded(&format!("  {:<width$}  {}", s.name, s.description), width + 4);
        sections.push(("scenarios", scenarios.iter().map(line).collect()));
    }
    if wanted(Listing::Studies) {
        let studies = library::study_names().map(|name| Study::load(name, &[])).collect::<Result<Vec<_>, _>>()?;
        let study_json = |s: &Study| json!({ "name": s.name, "description": s.description, "rollouts": s.len(), "design": s.design });
        object.insert("studies".into(), studies.iter().map(study_json).collect());
        let width = studies.iter().map(|s| s.name.len()).max().unwrap_or(0);
        let line =
            |s: &Study| folded(&format!("  {:<width$}  {} {} rollouts.", s.name, s.description, s.len()), width + 4);
        sections.push(("studies", studies.iter().map(line).collect()));
    }
    if wanted(Listing::Settings) {
        object.insert("settings".into(), SETTINGS.iter().map(setting_json).collect());
        sections.push(("settings", SETTINGS.iter().map(setting_lines).collect()));
    }
    if wanted(Listing::Metrics) {
        let [of_run, of_joint]: [Vec<Value>; 2] =
            [METRICS.iter().map(metric_json).collect(), JOINT_METRICS.iter().map(metric_json).collect()];
        object.insert("metrics".into(), of_run.into());
        object.insert("joint_metrics".into(), of_joint.into());
        sections.push(("metrics", METRICS.iter().map(metric_lines).collect()));
        sections.push(("metrics of a joint", JOINT_METRICS.iter().map(metric_lines).collect()));
    }
    if options.json {
        return output.line(Value::Object(object));
    }
    for (title, lines) in sections {
        output.line(title)?;
        for line in lines {
            output.line(line)?;
        }
        output.line("")?;
    }
    Ok(())
}

fn builtin_model(name: &str) -> Result<Model, legwork::error::Error> {
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

fn metric_lines<Of>(metric: &Metric<Of>) -> String {
    let unit = if metric.unit.is_empty() { String::new() } else { format!(" [{}]", metric.unit) };
    let heading = format!("  {}: {}{unit}, {}", metric.name, metric.label, metric.kind());
    [heading, format!("      {}", metric.help)].map(|line| folded(&line, 6)).join("\n")
}

fn metric_json<Of>(metric: &Metric<Of>) -> Value {
    json!({
        "name": metric.name,
        "label": metric.label,
        "unit": metric.unit,
        "kind": metric.kind(),
        "help": metric.help,
    })
}

pub(crate) fn show(options: &ShowArgs, output: &mut Output) -> Result<(), Failure> {
    if let Some(text) = library::study_text(&options.scenario) {
        if let Some(set) = options.sets.first() {
            let problem = "a study is shown as it is; give this to `legwork study`";
            return Err(Error::invalid(format!("--set {}", set.escape_debug()), problem).into());
        }
        return output.line(text.trim_end());
    }
    let loaded = scenario_file::load(&options.scenario, &options.sets)?;
    output.line(scenario_file::to_toml(&loaded.portable()).trim_end())
}
