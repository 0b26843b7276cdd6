//! `legwork adopt`: from a robot's file to scenarios in which it stands and walks.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use legwork::adopt::{Understanding, Wanted, understand};
use legwork::episode::{self, Outcome};
use legwork::error::Error;
use legwork::{Robot, scenario_file};
use legwork_rbd::{Base, Model, Roles, file};

use crate::args::{AdoptArgs, BaseArg};
use crate::inspect::model_text;
use crate::output::{Failure, Output, folded, say, write_text};
use crate::summary::outcome;

/// So long each scenario is tried [s].
const TRIED_S: &str = "duration_s=2";

pub(crate) fn adopt(options: &AdoptArgs, output: &mut Output) -> Result<ExitCode, Failure> {
    let path = &options.robot;
    let files = Files::of(path)?;
    let (model, roles) = files.read(options.base)?;
    let mut text = String::new();
    if model.nc() == 0 {
        let wanted = Wanted { feet: options.feet.clone(), torso: options.torso.clone() };
        let side_name = files.side.display().to_string();
        let understood = understand(&model, &roles, &wanted, &|mesh| read_mesh(path, mesh), &side_name);
        let understood = understood.map_err(|lacking| with_lines(lacking.error, &lacking.lines))?;
        let planar = match options.base {
            Some(base) => base == BaseArg::Planar,
            None => understood.sideways.is_empty(),
        };
        text += &told(&understood);
        let side = understood.side_file(&files.name, planar);
        if files.side.exists() {
            let problem = "is there already and names no contact points; add what is missing of the lines above, or delete the file";
            return Err(with_lines(Error::invalid(side_name, problem), &side).into());
        }
        write_text(&files.side, &side)?;
    } else {
        text += &format!("{} tells the contact points, feet and torso: they are kept.\n", roles.file);
    }
    let robot = Robot::load(path).map_err(Error::from)?;
    let words = robot.faces();
    output.line(format!("{text}{}\n\n{}", folded(&format!("forward: {words}."), 2), model_text(&robot)))?;
    let scenarios = files.scenarios(&robot)?;
    let mut stands = true;
    for scenario in &scenarios {
        let (sentence, stood) = tried(scenario);
        output.line(folded(&format!("{}: {sentence}", scenario.display()), 2))?;
        stands &= stood;
    }
    if stands && let Some(first) = scenarios.first() {
        output.line(format!("\nnext: legwork run {} --report report.html", first.display()))?;
    }
    Ok(if stands { ExitCode::SUCCESS } else { ExitCode::from(1) })
}

/// The error, once the lines that would help have been said.
fn with_lines(error: Error, lines: &str) -> Error {
    if !lines.is_empty() {
        say(lines);
    }
    error
}

/// The files about a robot, each beside its own.
struct Files {
    robot: PathBuf,
    /// Its name without a folder.
    name: String,
    side: PathBuf,
}

impl Files {
    fn of(robot: &Path) -> Result<Self, Error> {
        let name = robot.file_name().map(|name| name.to_string_lossy().into_owned());
        let Some(name) = name.filter(|_| !robot.is_dir()) else {
            return Err(Error::invalid(
                "adopt",
                format!("{} is no file; name a robot's .urdf, .xml or .toml", robot.display()),
            ));
        };
        // A TOML robot says all of it itself.
        let side = if is_toml(robot) { robot.to_owned() } else { robot.with_extension("legwork.toml") };
        Ok(Self { robot: robot.to_owned(), name, side })
    }

    /// The robot as its files have it so far. Joints that leave the plane are locked only in the file that is to be written.
    fn read(&self, base: Option<BaseArg>) -> Result<(Model, Roles), Error> {
        let base = base.map(Base::from).filter(|base| *base != Base::Planar || is_toml(&self.robot));
        Ok(Model::load_with_roles(&self.robot, base)?)
    }

    /// Writes the scenarios that there are none of yet; all that belong to the robot.
    fn scenarios(&self, robot: &Robot) -> Result<Vec<PathBuf>, Failure> {
        let stem = self.robot.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        let planar = robot.is_planar();
        let has_soles = (0..robot.feet.len()).all(|foot| robot.points_of(foot).count() > 1);
        let mut texts = vec![("stand", Understanding::stand(&self.name, &robot.name, planar))];
        if planar && has_soles {
            texts.push(("walk", Understanding::walk(&self.name, &robot.name)));
        }
        let mut written = Vec::new();
        for (what, text) in texts {
            let path = self.robot.with_file_name(format!("{stem}-{what}.toml"));
            if !path.exists() {
                write_text(&path, &text)?;
            }
            written.push(path);
        }
        Ok(written)
    }
}

fn is_toml(robot: &Path) -> bool {
    robot.extension().is_some_and(|extension| extension == "toml")
}

/// What a robot was taken to be, and why.
fn told(understood: &Understanding) -> String {
    let mut text = format!("torso: {}. {}.\n", understood.torso, understood.torso_because);
    for foot in &understood.feet {
        let count = foot.points.len();
        let line = format!("{} foot: {}, {}; its {count} {}.", foot.name, foot.link, foot.because, foot.points_from);
        text += &(folded(&line, 2) + "\n");
    }
    text
}

/// How the first seconds of a scenario go, and whether the robot stands at their end.
fn tried(scenario: &Path) -> (String, bool) {
    let run = || {
        let loaded = scenario_file::load(&scenario.display().to_string(), &[TRIED_S.to_owned()])?;
        episode::run(&loaded.scenario, &loaded.model()?, &[], |_| false)
    };
    match run() {
        Ok(run) => (outcome(&run), run.outcome == Outcome::Completed),
        Err(error) => (error.to_string(), false),
    }
}

/// The bytes of a mesh that a robot's file names: beside it, or for `package://NAME/REST` in a folder above that holds NAME or REST.
pub(crate) fn read_mesh(robot: &Path, mesh: &str) -> Option<Vec<u8>> {
    let mesh = mesh.strip_prefix("file://").unwrap_or(mesh);
    let folder = robot.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let read = |path: PathBuf| path.is_file().then(|| file::read(&path, file::TEXT).ok()).flatten();
    let Some(packaged) = mesh.strip_prefix("package://").or_else(|| mesh.strip_prefix("model://")) else {
        return read(folder.join(mesh));
    };
    let rest = packaged.split_once('/').map_or(packaged, |(_, rest)| rest);
    let folder = folder.canonicalize().ok()?;
    folder.ancestors().find_map(|above| read(above.join(packaged)).or_else(|| read(above.join(rest))))
}
