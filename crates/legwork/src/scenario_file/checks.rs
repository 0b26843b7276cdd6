//! The checks of a resolved scenario: each value by itself, then values against one another.

use legwork_rbd::words::quoted;
use toml::Value;

use super::draft::Draft;
use crate::error::Error;
use crate::scenario::{GeneratorKind, Scenario, TrajectoryKind};
use crate::settings::{self, SETTINGS, Setting, at};

impl Draft {
    /// The scenario, if all is valid; `file_name` is for what no line can be blamed for.
    pub(super) fn check(&mut self, file_name: &str) -> Result<Scenario, Error> {
        let pushes = self.tree["pushes"].as_array().map_or(0, Vec::len);
        for setting in SETTINGS {
            if setting.path.starts_with("pushes.") {
                for index in 0..pushes {
                    self.check_value(setting, &setting.path.replace('N', &index.to_string()))?;
                }
            } else {
                self.check_value(setting, setting.path)?;
            }
        }
        for (path, place) in self.places.of_sets() {
            if let Some(why) = settings::idle(&mut self.tree, path) {
                return Err(Error::invalid(place, why));
            }
        }
        let scenario = std::mem::replace(&mut self.tree, Value::Boolean(false))
            .try_into()
            .map_err(|error: toml::de::Error| Error::invalid(file_name, error.message()))?;
        match conflict(&scenario) {
            Some((paths, problem)) => {
                let place = self.places.of(paths).map_or_else(|| format!("{file_name}: {}", paths[0]), str::to_owned);
                Err(Error::invalid(place, problem))
            }
            None => Ok(scenario),
        }
    }

    /// Checks the value at `path` and brings it to its type.
    fn check_value(&mut self, setting: &Setting, path: &str) -> Result<(), Error> {
        let value = at(&mut self.tree, path).expect("a draft has the shape of a scenario");
        match setting.valid.check(value) {
            Ok(checked) => {
                *value = checked;
                Ok(())
            }
            Err(found) => {
                let problem = format!("found {found}; valid is {}", setting.valid_in_words());
                Err(Error::invalid(self.places.of(&[path]).unwrap_or(path), problem))
            }
        }
    }
}

/// The first contradiction between values: the settings concerned and what is wrong.
fn conflict(scenario: &Scenario) -> Option<(&'static [&'static str], String)> {
    let Scenario { name, duration_s: duration, controller, simulation, reference, .. } = scenario;
    if name.trim().is_empty() || name.contains(['/', '\\']) || name.contains(char::is_control) {
        let problem = format!("found {}; valid is a text that can be part of a file's name", quoted(name));
        return Some((&["name"], problem));
    }

    let (control, physics) = (controller.period_s, simulation.period_s);
    let ratio = control / physics;
    if ratio < 0.5 || (ratio - ratio.round()).abs() > 1e-9 {
        let problem = format!(
            "the control period of {control} s is {ratio} times the physics period of {physics} s; \
             valid is a whole multiple of it"
        );
        return Some((&["controller.period_s", "simulation.period_s"], problem));
    }
    if *duration < control {
        let problem = format!("the run of {duration} s is shorter than one control period of {control} s");
        return Some((&["duration_s", "controller.period_s"], problem));
    }

    let delays: [(&'static [&'static str], f64, f64); 4] = [
        (&["simulation.sensors.delay_s", "duration_s"], simulation.sensors.delay_s, control),
        (&["simulation.sensors.load_delay_s", "duration_s"], simulation.sensors.load_delay_s, control),
        (&["simulation.actuators.delay_s", "duration_s"], simulation.actuators.delay_s, physics),
        (&["controller.known_delay_s", "duration_s"], controller.known_delay_s, control),
    ];
    for (paths, delay, period) in delays {
        let periods = delay / period;
        if (periods - periods.round()).abs() > 1e-6 {
            let problem =
                format!("the delay of {delay} s is {periods} periods of {period} s; valid is a whole multiple");
            return Some((paths, problem));
        }
        if delay >= *duration {
            return Some((paths, format!("the delay of {delay} s is not shorter than the run of {duration} s")));
        }
    }

    let (least, most) = (reference.step.min_length_m, reference.step.max_length_m);
    if least > most {
        let paths = &["reference.step.min_length_m", "reference.step.max_length_m"];
        return Some((paths, format!("the shortest step of {least} m is longer than the longest of {most} m")));
    }
    ground_conflict(scenario)
        .or_else(|| trajectory_conflict(scenario))
        .or_else(|| fall_conflict(scenario))
        .or_else(|| walker_conflict(scenario))
}

/// Knots in no order, patches without extent.
fn ground_conflict(scenario: &Scenario) -> Option<(&'static [&'static str], String)> {
    let ground = &scenario.ground;
    if let Some(late) = ground.profile.windows(2).position(|rows| rows[1][0] <= rows[0][0]) {
        let (before, after) = (ground.profile[late][0], ground.profile[late + 1][0]);
        let problem = format!(
            "row {}: {after} m comes after {before} m; valid are places that increase (a step is a short steep piece)",
            late + 1
        );
        return Some((&["ground.profile"], problem));
    }
    let (row, [from, to, _]) = ground.patches.iter().enumerate().find(|(_, [from, to, _])| from >= to)?;
    let problem = format!("row {row}: a patch from {from} m to {to} m; valid is an end beyond its begin");
    Some((&["ground.patches"], problem))
}

fn trajectory_conflict(scenario: &Scenario) -> Option<(&'static [&'static str], String)> {
    let com = &scenario.reference.com;
    let waypoints = &["reference.com.waypoints", "reference.com.trajectory"];
    match com.trajectory {
        TrajectoryKind::File if com.file.is_empty() => {
            let problem = "the trajectory \"file\" needs a CSV file in reference.com.file";
            Some((&["reference.com.trajectory", "reference.com.file"], problem.to_owned()))
        }
        TrajectoryKind::Waypoints if com.waypoints.is_empty() => {
            let problem = "the trajectory \"waypoints\" needs rows [t_s, x_m, z_m] in reference.com.waypoints";
            Some((waypoints, problem.to_owned()))
        }
        TrajectoryKind::Waypoints => {
            let late = com.waypoints.windows(2).position(|rows| rows[1][0] <= rows[0][0])? + 1;
            let (before, after) = (com.waypoints[late - 1][0], com.waypoints[late][0]);
            Some((waypoints, format!("row {late}: {after} s comes after {before} s; valid are times that increase")))
        }
        _ => None,
    }
}

/// A walk that no leg and no ground could bear.
fn walker_conflict(scenario: &Scenario) -> Option<(&'static [&'static str], String)> {
    if scenario.reference.generator != GeneratorKind::Walker {
        return None;
    }
    let walker = &scenario.reference.walker;
    let schedule: &[&str] = &["reference.walker.schedule"];
    if walker.schedule.is_empty() {
        return Some((schedule, "found no row; valid is at least one".to_owned()));
    }
    if let Some(row) = walker.schedule.windows(2).position(|rows| rows[1][0] <= rows[0][0]) {
        let problem = format!("row {}: valid are speeds that increase", row + 1);
        return Some((schedule, problem));
    }
    let shortest = walker.double_support_s + walker.shortest_swing_s;
    for (row, &[_, step_time, .., heel_off]) in walker.schedule.iter().enumerate() {
        if step_time < shortest || step_time > walker.longest_step_s || heel_off >= step_time - walker.double_support_s
        {
            let problem = format!(
                "row {row}: a step of {step_time} s with a heel-off of {heel_off} s; valid are steps from {shortest:.3} s (double \
                 support and shortest swing) to {} s (longest_step_s) whose heel-off is shorter than the swing",
                walker.longest_step_s
            );
            return Some((schedule, problem));
        }
    }
    if let Some(row) = walker.speeds.windows(2).position(|rows| rows[1][0] <= rows[0][0]) {
        let problem = format!("row {}: valid are times that increase", row + 1);
        return Some((&["reference.walker.speeds"], problem));
    }
    let speeds = walker.speeds.iter().map(|row| row[1]).chain(walker.speeds.is_empty().then_some(walker.speed_mps));
    for speed in speeds {
        let (length, longest) =
            (speed * walker.scheduled(speed)[0], if speed < 0.0 { walker.longest_back_m } else { walker.longest_m });
        if length.abs() > longest {
            let problem = format!(
                "a speed of {speed} m/s takes steps of {:.2} m; the longest are {longest} m (longest_m, longest_back_m)",
                length.abs()
            );
            return Some((
                &["reference.walker.speed_mps", "reference.walker.speeds", "reference.walker.schedule"],
                problem,
            ));
        }
    }
    let ground = &scenario.ground;
    let steepness = libm::tan(ground.slope_deg.to_radians()).abs();
    if steepness > ground.friction {
        let problem = format!(
            "a slope of {} deg needs a friction of {steepness:.3} to stand on; found {}",
            ground.slope_deg, ground.friction
        );
        return Some((&["ground.slope_deg", "ground.friction"], problem));
    }
    None
}

/// The start must not count as a fall.
fn fall_conflict(scenario: &Scenario) -> Option<(&'static [&'static str], String)> {
    let (start, reference) = (scenario.start.torso_angle_deg, scenario.controller.planner.torso_angle_deg);
    let limit = scenario.fall.max_torso_angle_deg;
    if (start - reference).abs() <= limit {
        return None;
    }
    let paths = &["fall.max_torso_angle_deg", "start.torso_angle_deg", "controller.planner.torso_angle_deg"];
    let problem = format!(
        "the start counts as a fall: its torso angle of {start} deg is more than {limit} deg from the {reference} deg \
         asked for"
    );
    Some((paths, problem))
}
