//! The tables of `limits` as CSV files, its page and its figures.

use std::fs;
use std::path::Path;

use legwork::error::Error;
use legwork_report::envelope::{self, Report};
use legwork_study::sizing::{Demand, Use};
use serde::Serialize;

use crate::output::{Failure, PAGE, check_writable, write_page, write_text};

const LIMITS: &str = "limits.csv";
const ROBUSTNESS: &str = "robustness.csv";
const SIZING: &str = "sizing.csv";
const TORQUE_SPEED: &str = "torque_speed.csv";
const MAP: &str = "speed_torque_map.csv";

/// Makes the folder and finds out whether files can be written there.
pub(crate) fn check(folder: &Path) -> Result<(), Failure> {
    let problem = |error: std::io::Error| {
        if folder.exists() { "is a file; give the name of a folder".to_owned() } else { error.to_string() }
    };
    fs::create_dir_all(folder).map_err(|error| Failure::Output { path: folder.to_owned(), problem: problem(error) })?;
    [LIMITS, ROBUSTNESS, SIZING, TORQUE_SPEED, MAP, PAGE].iter().try_for_each(|name| check_writable(&folder.join(name)))
}

/// Writes a file for each part that was asked for, and the page.
pub(crate) fn write(report: &Report, folder: &Path) -> Result<(), Failure> {
    write_page(&envelope::page(report), folder)?;
    let write = |name: &str, text: String| write_text(&folder.join(name), &text);
    if let Some(answers) = &report.limits {
        let head = "scenario,question,unit,value,largest_force_n,first_failure,furthest_held,rollouts,reason_beyond,violations";
        let rows = answers.iter().map(|answer| {
            let found = &answer.found;
            let values = (found.value, found.force_n, found.first_failure, found.furthest_held, found.rollouts);
            (&answer.scenario, &answer.question, answer.unit, values, &found.reason_beyond, &found.violations)
        });
        write(LIMITS, csv(head, rows)?)?;
    }
    if let Some(map) = &report.robustness {
        let head = "scenario,phase,direction_deg,start_s,value_nspkg,largest_force_n,first_failure_nspkg,furthest_held_nspkg,rollouts,reason_beyond,violations";
        let rows = map.cells.iter().map(|cell| {
            let found = &cell.found;
            let values = (found.value, found.force_n, found.first_failure, found.furthest_held, found.rollouts);
            (
                &cell.scenario,
                cell.phase,
                cell.direction_deg,
                cell.start_s,
                values,
                &found.reason_beyond,
                &found.violations,
            )
        });
        write(ROBUSTNESS, csv(head, rows)?)?;
    }
    if let Some(sizing) = &report.sizing {
        let head = "scenario,joint,torque_peak_nm,torque_rms_nm,speed_peak_radps,power_peak_w,power_mean_w,at_limit,violations";
        let of = |name: &str, demands: &[Demand], violations: Option<&String>| {
            let rows = demands.iter().map(|demand| (name.to_owned(), demand.clone(), violations.cloned()));
            rows.collect::<Vec<_>>()
        };
        let rows = sizing.uses.iter().flat_map(|used| of(&used.scenario, &used.joints, used.violations.as_ref()));
        let any = sizing.uses.iter().find_map(|used| used.violations.as_ref());
        let all = [("envelope", &sizing.envelope), ("required", &sizing.required)];
        let all = all.into_iter().flat_map(|(name, demands)| of(name, demands, any));
        write(SIZING, csv(head, rows.chain(all))?)?;
        let head = "scenario,joint,speed_from_radps,speed_to_radps,torque_from_nm,torque_to_nm,ticks";
        write(TORQUE_SPEED, csv(head, sizing.uses.iter().flat_map(bins))?)?;
    }
    if let Some(pairs) = &report.map {
        let head = "speed_mps,torque_limit_nm,coping,mean_speed_mps,com_error_m,fell_at_s,cause,reason,violations";
        write(MAP, csv(head, pairs)?)?;
    }
    Ok(())
}

/// The bins that something is in.
fn bins(used: &Use) -> impl Iterator<Item = impl Serialize> {
    used.clouds.iter().flat_map(move |cloud| {
        let rows = cloud.torque_edges_nm.windows(2).zip(&cloud.ticks);
        rows.flat_map(move |(torque, row)| {
            let cells = cloud.speed_edges_radps.windows(2).zip(row).filter(|(_, ticks)| **ticks > 0);
            cells.map(move |(speed, ticks)| {
                (&used.scenario, &cloud.joint, speed[0], speed[1], torque[0], torque[1], *ticks)
            })
        })
    })
}

/// A table with this head; what there is none of is left empty.
fn csv(head: &str, rows: impl IntoIterator<Item = impl Serialize>) -> Result<String, Error> {
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    let wrong = |error: csv::Error| Error::invalid("a table", error.to_string());
    writer.write_record(head.split(',')).map_err(wrong)?;
    rows.into_iter().try_for_each(|row| writer.serialize(row)).map_err(wrong)?;
    let bytes = writer.into_inner().expect("memory can be written to");
    Ok(String::from_utf8(bytes).expect("what was written is text"))
}
