//! The command line.

use std::path::PathBuf;

use clap::{Args as ClapArgs, Parser, Subcommand, ValueEnum};
use legwork_rbd::Base;

const RUN_HELP: &str = "\
Examples:
  legwork run walk push --report report.html
  legwork run push --set pushes.0.force_n=600 --set ground.friction=0.5 --json
  legwork show push > my-push.toml
  legwork run my-push.toml --log my-push.parquet --plots figures

With several scenarios, --log puts each one's name into the file's name.

Exit code: 0 done (a fall is a result), 1 a file could not be read or written,
or a fall under --expect-standing, 2 wrong invocation or input, 130 interrupted
(Ctrl-C keeps what was simulated so far).";

const STUDY_HELP: &str = "\
Examples:
  legwork study torque-limit
  legwork show feet-weight > my-study.toml
  legwork study my-study.toml --out my-study --threads 2
  legwork study interactions --shard 1/4 --out part

A study is kept in its folder while it runs: Ctrl-C loses at most the chunks under
way, and the same command goes on. docs/studies.md has the format of the files.

Exit code: 0 done (falls are results), 1 a file could not be read or written,
2 wrong invocation or input, 130 interrupted.";

const REPRODUCE_HELP: &str = "\
Examples:
  legwork reproduce
  legwork reproduce --out comparison --threads 2
  legwork reproduce --json > comparison.json

Everything is run in both readings of the least step length (docs/parameters.md).
The folder then holds results.json, the tables sweeps, runs, tables, limits,
claims and questions as CSV and Parquet, and the logs of the eight main runs.

Exit code: 0 done (what is not reproduced is a result), 1 a file could not be
written, 2 wrong invocation, 130 interrupted.";

const TUNE_HELP: &str = "\
Examples:
  legwork tune thesis --budget 100
  legwork tune my-tuning.toml --out my-tuning --threads 2

The folder holds a scenario with the tuned settings for each scenario tuned,
history.csv, cases.csv and results.json. docs/tuning.md has the format of the
file.

Exit code: 0 done (whether or not anything better was found), 1 a file could
not be read or written, 2 wrong invocation or input, 130 interrupted (Ctrl-C
keeps the best so far).";

const ADOPT_HELP: &str = "\
Examples:
  legwork adopt robot.urdf
  legwork adopt robot.xml --feet right_ankle_roll_link,left_ankle_roll_link
  legwork adopt robot.urdf --base planar

Beside ROBOT.urdf it writes ROBOT.legwork.toml, with what the robot's file does
not say, and the scenarios ROBOT-stand.toml and, for a robot in the plane with
soles, ROBOT-walk.toml; it runs each for two seconds. Files that are there are
kept. Exit code 1: the robot falls, or a scenario cannot start.";

const INSPECT_HELP: &str = "\
Examples:
  legwork inspect planar_humanoid
  legwork inspect robot.urdf --base floating --json
  legwork inspect planar_humanoid --state state.json

A state is {\"q\": [...], \"v\": [...]}; q_names and v_names of --json give the order.
A floating base has q = quaternion w x y z, then position x y z, and
v = angular, then linear velocity in the body's frame.";

const LIMITS_HELP: &str = "\
Examples:
  legwork limits
  legwork limits --only limits --quick
  legwork limits --walk walk-support --push push-support --out limits
  legwork limits --only sizing --set reference.com.speed_mps=0.4 --json

The two scenarios share --set, but for the settings of pushes, which only the
second has. Walking needs a constant speed, and the second scenario a push.

Exit code: 0 done (what does not hold is a result), 1 a file could not be read
or written, 2 wrong invocation or input, 130 interrupted (Ctrl-C keeps what
was finished).";

const COMPARE_HELP: &str = "\
Examples:
  legwork compare --report comparison.html
  legwork compare --quick --speeds 0.5
  legwork compare walk walk-support --set ground.friction=0.5 --json

Both scenarios must walk at a constant speed, which is set to each of --speeds.
--set changes both.

Exit code: 0 done (a speed that is not walked is a result), 1 a file could not
be read or written, 2 wrong invocation or input, 130 interrupted (Ctrl-C keeps
what was finished).";

const BENCH_HELP: &str = "\
Examples:
  legwork bench
  legwork bench push --set controller.form=slack --seconds 1

Times are those of this machine: leave it alone meanwhile. Each figure is the
median of several rounds, so that one disturbed round does not matter.
docs/benchmarks.md explains each.

Exit code: 0 done, 1 a file could not be written, 2 wrong invocation or input,
130 interrupted (Ctrl-C keeps the rounds that were finished).";

/// Finds out what a biped's controller can survive, and why it fell.
///
/// Without a command: runs the thesis's two experiments, prints each published figure beside the measured one, and
/// writes legwork-report.html into the current folder.
#[derive(Debug, Parser)]
#[command(
    name = "legwork",
    version,
    after_help = "Example:\n  legwork run push --set pushes.0.force_n=600 --report push.html"
)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Simulate scenarios and print their figures beside the thesis's
    #[command(after_help = RUN_HELP)]
    Run(RunArgs),
    /// Run a study: scenarios over many values of their settings, on all cores
    #[command(after_help = STUDY_HELP, args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
    Study(StudyArgs),
    /// Find the top speed, the largest push, the lowest torque limit, and what the actuators must deliver
    #[command(after_help = LIMITS_HELP)]
    Limits(LimitsArgs),
    /// Hold two robots beside each other and a person: torques, energy, pushes, what the actuators must deliver
    #[command(after_help = COMPARE_HELP)]
    Compare(CompareArgs),
    /// Hold everything that the thesis reports beside what is measured: tables, sweeps, limits, claims, open questions
    #[command(after_help = REPRODUCE_HELP)]
    Reproduce(ReproduceArgs),
    /// Find settings that better a design, and judge them in cases that the search has not seen
    #[command(after_help = TUNE_HELP)]
    Tune(TuneArgs),
    /// Measure legwork on this machine: control tick and its parts, simulation step, rollouts, threads
    #[command(after_help = BENCH_HELP)]
    Bench(BenchArgs),
    /// List the names of models, scenarios, studies and settings, or all of one kind with their descriptions
    #[command(
        after_help = "Examples:\n  legwork list\n  legwork list scenarios\n  legwork list settings controller.weights"
    )]
    List(ListArgs),
    /// Print a scenario with all its settings, or a study, as a file that can be saved and run
    #[command(after_help = "Example:\n  legwork show push > my-push.toml")]
    Show(ShowArgs),
    /// Make a robot of one's own (URDF, MJCF, TOML) stand, and in the plane walk: find feet, soles and torso, write scenarios
    #[command(after_help = ADOPT_HELP)]
    Adopt(AdoptArgs),
    /// Show a robot model (TOML, URDF or MJCF): tree, masses, limits, contacts, warnings; with a state also its dynamics
    #[command(after_help = INSPECT_HELP)]
    Inspect(InspectArgs),
}

impl Command {
    /// What the program does without arguments.
    pub(crate) fn main_job() -> Self {
        Self::Run(RunArgs {
            scenarios: vec!["walk".into(), "push".into()],
            report: Some("legwork-report.html".into()),
            ..RunArgs::default()
        })
    }
}

/// Options of `run`.
#[derive(Debug, Default, ClapArgs)]
pub(crate) struct RunArgs {
    /// Built-in scenarios (see `legwork list scenarios`) or TOML files
    #[arg(required = true, value_name = "SCENARIO")]
    pub(crate) scenarios: Vec<String>,
    /// Change a setting; lists are indexed by number, as in pushes.0.force_n=655
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub(crate) sets: Vec<String>,
    /// Time to simulate in seconds, instead of the scenario's duration
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(crate) duration: Option<String>,
    /// Write one record a control tick to a .csv or .parquet file
    #[arg(long, value_name = "FILE")]
    pub(crate) log: Option<PathBuf>,
    /// Write a self-contained page with table, plots and animation
    #[arg(long, value_name = "FILE.html")]
    pub(crate) report: Option<PathBuf>,
    /// Write the figures as SVG files into a folder
    #[arg(long, value_name = "DIR")]
    pub(crate) plots: Option<PathBuf>,
    /// Print a JSON object for each scenario instead of tables
    #[arg(long)]
    pub(crate) json: bool,
    /// End with exit code 1 if a robot falls
    #[arg(long)]
    pub(crate) expect_standing: bool,
}

/// Options of `study`.
#[derive(Debug, ClapArgs)]
pub(crate) struct StudyArgs {
    #[command(subcommand)]
    pub(crate) command: Option<StudyCommand>,
    /// Built-in studies (see `legwork list studies`) or TOML files
    #[arg(required = true, value_name = "STUDY")]
    pub(crate) studies: Vec<String>,
    /// Change a setting of every scenario
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub(crate) sets: Vec<String>,
    /// Folder for the rollouts, tables, figures and report, instead of legwork-STUDY
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Number of threads; one for each core by default
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Do only a shard of the study, as in 2/8, for arrays of jobs on several machines
    #[arg(long, value_name = "I/N")]
    pub(crate) shard: Option<String>,
    /// Print a JSON object for each study instead of tables
    #[arg(long)]
    pub(crate) json: bool,
}

/// What else `study` can do.
#[derive(Debug, Subcommand)]
pub(crate) enum StudyCommand {
    /// Join the rollouts of shards, and make tables and a report of them
    #[command(after_help = "Example:\n  legwork study merge node-1 node-2 --into all")]
    Merge(MergeArgs),
}

/// Options of `study merge`.
#[derive(Debug, ClapArgs)]
pub(crate) struct MergeArgs {
    /// Folders of shards of one study
    #[arg(required = true, value_name = "DIR")]
    pub(crate) folders: Vec<PathBuf>,
    /// Folder for the joined study, instead of the first of the folders
    #[arg(long, value_name = "DIR")]
    pub(crate) into: Option<PathBuf>,
    /// Print a JSON object instead of tables
    #[arg(long)]
    pub(crate) json: bool,
}

/// Options of `limits`.
#[derive(Debug, ClapArgs)]
pub(crate) struct LimitsArgs {
    /// The scenario that walks: built in, or a TOML file
    #[arg(long, value_name = "SCENARIO", default_value = "walk")]
    pub(crate) walk: String,
    /// The scenario that is pushed: built in, or a TOML file
    #[arg(long, value_name = "SCENARIO", default_value = "push")]
    pub(crate) push: String,
    /// Change a setting
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub(crate) sets: Vec<String>,
    /// Find out only these parts, separated by commas
    #[arg(long, value_enum, value_name = "PARTS", value_delimiter = ',')]
    pub(crate) only: Vec<Part>,
    /// Search in coarser steps, over fewer directions and phases, and confirm limits less
    #[arg(long)]
    pub(crate) quick: bool,
    /// How much more than the largest demand an actuator should deliver, as a share
    #[arg(long, value_name = "SHARE", default_value_t = 0.2, value_parser = share)]
    pub(crate) margin: f64,
    /// Write the tables as CSV files into a folder
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print one JSON object instead of tables
    #[arg(long)]
    pub(crate) json: bool,
    /// Number of threads; one for each core by default
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
}

fn share(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|number| (0.0..=10.0).contains(number));
    number.ok_or_else(|| "valid is a number from 0 to 10".to_owned())
}

/// Options of `compare`.
#[derive(Debug, ClapArgs)]
pub(crate) struct CompareArgs {
    /// A scenario that walks: built in, or a TOML file
    #[arg(value_name = "A", default_value = "walk")]
    pub(crate) first: String,
    /// A second scenario that walks: built in, or a TOML file
    #[arg(value_name = "B", default_value = "feet-walk")]
    pub(crate) second: String,
    /// The speeds in m/s, separated by commas; pushes strike at the first that both walk at
    #[arg(long, value_name = "SPEEDS", value_delimiter = ',', default_value = "0.5,1", allow_hyphen_values = true, value_parser = speed)]
    pub(crate) speeds: Vec<f64>,
    /// Change a setting of both scenarios
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub(crate) sets: Vec<String>,
    /// Search in coarser steps, at fewer phases of the stride, over a smaller map
    #[arg(long)]
    pub(crate) quick: bool,
    /// Write a self-contained page with tables and figures
    #[arg(long, value_name = "FILE.html")]
    pub(crate) report: Option<PathBuf>,
    /// Print one JSON object instead of tables
    #[arg(long)]
    pub(crate) json: bool,
    /// Number of threads; one for each core by default
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
}

fn speed(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|number| *number != 0.0 && number.abs() <= 5.0);
    number.ok_or_else(|| "valid is a number from -5 to 5, not zero".to_owned())
}

/// A part of `limits`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Part {
    /// Top speed, largest push, lowest torque and force limit, lowest friction
    Limits,
    /// Largest impulse by direction and gait phase
    Robustness,
    /// Torque, speed and power of each joint
    Sizing,
    /// Pairs of speed and torque limit
    Map,
}

/// Options of `reproduce`.
#[derive(Debug, ClapArgs)]
pub(crate) struct ReproduceArgs {
    /// Folder for the tables and logs
    #[arg(long, value_name = "DIR", default_value = "legwork-reproduction")]
    pub(crate) out: PathBuf,
    /// Number of threads; one for each core by default
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Print one JSON object instead of a summary
    #[arg(long)]
    pub(crate) json: bool,
}

/// Options of `tune`.
#[derive(Debug, ClapArgs)]
pub(crate) struct TuneArgs {
    /// A built-in tuning (thesis, feet) or a TOML file
    #[arg(value_name = "TUNING")]
    pub(crate) tuning: String,
    /// Folder for scenarios, tables and results, instead of legwork-tuning-TUNING
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Number of threads; one for each core by default
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// How many candidates to try, instead of what the file says
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=10_000_000))]
    pub(crate) budget: Option<u64>,
    /// Print a JSON object instead of tables
    #[arg(long)]
    pub(crate) json: bool,
}

/// Options of `bench`.
#[derive(Debug, ClapArgs)]
pub(crate) struct BenchArgs {
    /// Built-in scenarios or TOML files; walk and push by default
    #[arg(value_name = "SCENARIO")]
    pub(crate) scenarios: Vec<String>,
    /// Change a setting of every scenario
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub(crate) sets: Vec<String>,
    /// Seconds to spend on each scenario
    #[arg(long, value_name = "S", default_value_t = 5.0, value_parser = seconds)]
    pub(crate) seconds: f64,
    /// Print a JSON object instead of tables
    #[arg(long)]
    pub(crate) json: bool,
}

fn seconds(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|number| (0.1..=3600.0).contains(number));
    number.ok_or_else(|| "valid is a number from 0.1 to 3600".to_owned())
}

/// Options of `list`.
#[derive(Debug, ClapArgs)]
pub(crate) struct ListArgs {
    /// The kind to describe; without it the names of all kinds
    #[arg(value_enum)]
    pub(crate) what: Option<Listing>,
    /// Only entries of this name, or whose names begin with it, such as a group of settings
    #[arg(value_name = "NAME")]
    pub(crate) within: Option<String>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// What can be listed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Listing {
    /// Built-in robot models
    Models,
    /// Built-in scenarios
    Scenarios,
    /// Built-in studies
    Studies,
    /// Settings of a scenario, with unit, default, range and source
    Settings,
    /// Every metric of a run
    Metrics,
}

/// Options of `show`.
#[derive(Debug, ClapArgs)]
pub(crate) struct ShowArgs {
    /// A built-in scenario, a TOML file of one, or a built-in study
    pub(crate) scenario: String,
    /// Change a setting
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub(crate) sets: Vec<String>,
}

/// Options of `adopt`.
#[derive(Debug, ClapArgs)]
pub(crate) struct AdoptArgs {
    /// A URDF, MJCF or TOML file
    pub(crate) robot: PathBuf,
    /// The links that are the robot's feet, instead of those that are found
    #[arg(long, value_name = "RIGHT,LEFT", value_delimiter = ',')]
    pub(crate) feet: Vec<String>,
    /// The link that is the robot's torso, instead of the one that is found
    #[arg(long, value_name = "LINK")]
    pub(crate) torso: Option<String>,
    /// How the root is held: planar locks the joints that would leave the plane
    #[arg(long, value_enum)]
    pub(crate) base: Option<BaseArg>,
}

/// Options of `inspect`.
#[derive(Debug, ClapArgs)]
pub(crate) struct InspectArgs {
    /// A built-in model, or a TOML, URDF or MJCF file
    pub(crate) model: String,
    /// How the root is held, instead of what the model says
    #[arg(long, value_enum)]
    pub(crate) base: Option<BaseArg>,
    /// JSON file with joint positions and velocities
    #[arg(long, value_name = "FILE.json")]
    pub(crate) state: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// How the root of a model is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum BaseArg {
    /// Fixed to the world
    Fixed,
    /// Free in the x-z plane
    Planar,
    /// Free in space
    Floating,
}

impl From<BaseArg> for Base {
    fn from(base: BaseArg) -> Self {
        match base {
            BaseArg::Fixed => Base::Fixed,
            BaseArg::Planar => Base::Planar,
            BaseArg::Floating => Base::Floating,
        }
    }
}
