//! Studies from their files to their results.

use std::path::{Path, PathBuf};

use legwork_study::design::Design;
use legwork_study::results::{self, Results};
use legwork_study::store::Store;
use legwork_study::{Ending, Level, Rollout, Study, parallel};

fn parse(text: &str) -> Result<Study, String> {
    Study::parse(text, "study.toml", None, &[]).map_err(|error| error.to_string())
}

/// Two scenarios, cut short, and two factors; `design` and more keys come first.
fn text(keys: &str) -> String {
    format!(
        "{keys}\nscenarios = [\"walk\", \"push\"]\n[set]\nduration_s = 0.6\n\
         [[factors]]\npath = \"ground.friction\"\nlinear = {{ from = 0.4, to = 0.8, count = 3 }}\n\
         [[factors]]\nname = \"mass\"\npath = \"model.bodies.torso.mass_kg\"\nrelative = true\nlist = [0.9, 1.1]\n"
    )
}

fn levels(study: &Study, index: u64) -> (usize, Vec<Option<f64>>) {
    let point = study.point(index);
    (point.base, point.levels.iter().map(|level| level.as_ref().and_then(Level::number)).collect())
}

#[test]
fn one_at_a_time_begins_with_the_scenario_as_it_stands() {
    let study = parse(&text("design = \"one-at-a-time\"")).expect("it is valid");
    assert_eq!(study.len(), 2 * (1 + 3 + 2));
    let points: Vec<_> = (0..study.len()).map(|index| levels(&study, index)).collect();
    let each =
        [[None, None], [Some(0.4), None], [Some(0.6), None], [Some(0.8), None], [None, Some(0.9)], [None, Some(1.1)]];
    for (index, (base, point)) in points.iter().enumerate() {
        assert_eq!((*base, point.as_slice()), (index / 6, each[index % 6].as_slice()));
    }
}

#[test]
fn a_grid_has_every_combination() {
    let study = parse(&text("design = \"grid\"")).expect("it is valid");
    assert_eq!(study.len(), 12);
    let points: Vec<_> = (0..6).map(|index| levels(&study, index).1).collect();
    let of = |friction, mass| vec![Some(friction), Some(mass)];
    assert_eq!(points, [of(0.4, 0.9), of(0.4, 1.1), of(0.6, 0.9), of(0.6, 1.1), of(0.8, 0.9), of(0.8, 1.1)]);
}

#[test]
fn every_sampled_design_has_its_number_of_points_within_the_ranges() {
    for (keys, each) in [
        ("design = \"latin-hypercube\"\nsamples = 7", 7),
        ("design = \"sobol-sequence\"\nsamples = 8", 8),
        ("design = \"morris\"\nsamples = 5", 5 * 3),
        ("design = \"saltelli\"\nsamples = 4", 4 * 6),
    ] {
        let study = parse(&text(keys)).expect("it is valid");
        assert_eq!(study.len(), 2 * each, "{keys}");
        for index in 0..study.len() {
            let (base, point) = levels(&study, index);
            assert_eq!(base as u64, index / each);
            assert!((0.4..=0.8).contains(&point[0].expect("it is set")), "{keys}: {point:?}");
            assert!([Some(0.9), Some(1.1)].contains(&point[1]), "{keys}: {point:?}");
            // The scenarios see the same points.
            assert_eq!(point, levels(&study, index % each).1);
        }
    }
}

#[test]
fn the_levels_reach_scenario_and_model() {
    let study = parse(&text("design = \"grid\"")).expect("it is valid");
    let variant = study.variant(&study.point(5)).expect("it is valid");
    let base = study.bases[0].variant();
    assert_eq!((variant.scenario.ground.friction, variant.scenario.duration_s), (0.8, 0.6));
    let torso = |model: &legwork::Robot| model.bodies[model.torso].mass;
    assert_eq!(torso(&variant.model), 1.1 * torso(&base.model));
}

/// A rollout is the run that `legwork run` would make of the same settings.
#[test]
fn a_rollout_is_the_run_of_its_settings() {
    let study = parse(&text("design = \"one-at-a-time\"")).expect("it is valid");
    let rollout = study.rollout(2, || false).expect("nobody stops it");
    let sets = ["duration_s=0.6", "ground.friction=0.6"].map(str::to_owned);
    let loaded = legwork::scenario_file::load("walk", &sets).expect("it is built in");
    let run =
        legwork::episode::run(&loaded.scenario, &loaded.model().expect("built in"), &[], |_| false).expect("valid");
    assert_eq!(rollout.result_hash, format!("{:032x}", run.result_hash));
    assert_eq!(rollout.input_hash, format!("{:032x}", run.input_hash));
    let columns = study.columns();
    let figure = |name: &str| rollout.figures[columns.iter().position(|column| column.name == name).expect("a figure")];
    assert_eq!(figure("torque_nm.mean"), Some(run.metrics.torque_nm.expect("it is measured").mean));
    assert_eq!(figure("joint.left_knee.power_peak_w"), Some(run.metrics.joints[3].power_peak_w));
    assert_eq!(figure("recovery_time_s"), None);
}

#[test]
fn a_combination_that_cannot_be_run_is_a_result() {
    let text = "design = \"grid\"\nscenarios = [\"stand\"]\n[set]\nduration_s = 0.1\nstart.com_height_m = 0.78\n\
                [[factors]]\npath = \"start.com_height_m\"\nlist = [0.78, 0.885]\n\
                [[factors]]\npath = \"start.left_foot_x_m\"\nlist = [0.575, 0.75]\n";
    let study = parse(text).expect("each level alone can be run");
    let endings: Vec<Rollout> = (0..4).map(|index| study.rollout(index, || false).expect("nobody stops it")).collect();
    assert_eq!(endings[0].ending, Ending::Completed);
    let last = &endings[3];
    assert_eq!((last.ending, last.figures.len()), (Ending::Invalid, 0), "{last:?}");
    assert!(last.reason.as_ref().is_some_and(|reason| reason.contains("start")), "{last:?}");
}

#[test]
fn wrong_files_are_refused_with_place_found_and_valid() {
    let good = text("design = \"one-at-a-time\"");
    for (from, to, message) in [
        (
            "ground.friction",
            "ground.fricton",
            "study.toml:5: factors, \"ground.fricton\": ground.fricton: unknown; did you mean ground.friction?",
        ),
        ("from = 0.4", "from = 0.9", "study.toml:5: factors.0: linear: from 0.9 to 0.8 is crossed; valid is from < to"),
        ("from = 0.4", "from = 0.8", "is empty; valid is from < to"),
        ("from = 0.4", "from = nan", "from NaN to 0.8; valid are finite numbers"),
        (", count = 3", "", "count is missing"),
        ("count = 3", "count = 1", "count is 1; valid is a whole number from 2 to 100000"),
        (
            "to = 0.8",
            "to = 80.0",
            "is not one that walk can have: ground.friction: found 40.2; valid is a number from 0 to 10",
        ),
        (
            "list = [0.9, 1.1]",
            "list = [0.9, -1.1]",
            "the level -1.1 is not one that walk can have: model.bodies.torso.mass_kg",
        ),
        ("list = [0.9, 1.1]", "list = []", "found 0 levels; valid are at least 1"),
        ("list = [0.9, 1.1]", "list = [0.9, 0.9]", "0.9 is in it twice"),
        ("list = [0.9, 1.1]", "", "needs exactly one of list, linear and logarithmic"),
        ("list = [0.9, 1.1]", "list = [[1]]", "found a list; valid are numbers, texts, true and false"),
        ("list = [0.9, 1.1]", "list = [[1, 2, 3]]", "found 3 numbers (1 and 2 and 3); valid is one for each path"),
        ("list = [0.9, 1.1]", "list = [[1, \"x\"]]", "found the text \"x\"; valid are numbers"),
        ("name = \"mass\"", "name = \"ground.friction\"", "another factor is called \"ground.friction\" as well"),
        ("path = \"ground.friction\"", "", "needs either path or paths"),
        ("linear = { from = 0.4", "logarithmic = { from = 0", "logarithmic: from is 0; valid is a number above 0"),
        ("\"push\"", "\"walk\"", "another scenario is called \"walk\" as well"),
        (
            "\"push\"",
            "\"pusch\"",
            "study.toml:2: scenarios: scenario: neither a built-in scenario nor a file is called \"pusch\"; did you mean push?",
        ),
        ("[\"walk\", \"push\"]", "[]", "found none; a study needs at least one"),
        (
            "duration_s = 0.6",
            "duration_s = -1",
            "study.toml:4: set.duration_s: in the scenario walk: found -1; valid is",
        ),
        ("duration_s = 0.6", "duration = 0.6", "study.toml:4: set.duration: in the scenario walk: unknown"),
        // Whatever characters a key has, its line is told.
        ("duration_s = 0.6", "\"dur\\tation\" = 0.6", "study.toml:4: set.dur\\tation: in the scenario walk: unknown"),
        ("one-at-a-time", "all", "study.toml:1: unknown variant `all`"),
        ("\"one-at-a-time\"", "\"one-at-a-time\"\nsamples = 3", "study.toml:2: samples: this design takes every level"),
        ("\"one-at-a-time\"", "\"saltelli\"", "this design needs samples"),
        ("\"one-at-a-time\"", "\"saltelli\"\nsamples = 1", "found 1; valid is a whole number from 2"),
        ("\"one-at-a-time\"", "\"morris\"\nsamples = 9\nmorris_levels = 5", "found 5; valid is an even number"),
        ("\"one-at-a-time\"", "\"grid\"\nmorris_levels = 4", "only the design \"morris\" has these"),
        (
            "\"one-at-a-time\"",
            "\"grid\"\nmetrics = [\"com_error\"]",
            "metrics: found \"com_error\"; valid are com_error_m.mean,",
        ),
        ("\"one-at-a-time\"", "\"grid\"\nname = \"a/b\"", "study.toml:2: name: found \"a/b\"; valid is"),
        ("\"one-at-a-time\"", "\"grid\"\ncolour = 3", "unknown field `colour`"),
    ] {
        assert!(good.contains(from), "{from}");
        let refusal = parse(&good.replace(from, to)).expect_err(to);
        assert!(refusal.contains(message), "{to}: {refusal}");
    }
    assert!(parse("").expect_err("empty").contains("nothing in it"));
    assert!(parse("design = \"grid").is_err());
}

#[test]
fn a_level_may_be_a_number_for_each_path() {
    let text = "scenarios = [\"push\"]\ndesign = \"grid\"\n[[factors]]\nname = \"push\"\n\
                paths = [\"pushes.0.force_n\", \"pushes.0.duration_s\"]\nlist = [[900, 0.05], [450, 0.1]]\n";
    let study = Study::parse(text, "t.toml", None, &[]).expect("a study");
    let push = |index| study.variant(&study.point(index)).expect("it is valid").scenario.pushes[0].clone();
    assert_eq!([0, 1].map(|index| (push(index).force_n, push(index).duration_s)), [(900.0, 0.05), (450.0, 0.1)]);
    let level = study.point(0).levels[0].clone().expect("a level");
    assert_eq!((level.to_string(), study.factors[0].unit()), ("900 and 0.05".to_owned(), ""));
}

#[test]
fn too_many_rollouts_are_refused() {
    let factor = "[[factors]]\npath = \"ground.friction\"\nlinear = { from = 0.1, to = 1, count = 100000 }\n";
    let other =
        factor.replace("ground.friction", "controller.limits.torque_nm").replace("0.1, to = 1", "100, to = 200");
    let text = format!("design = \"grid\"\nscenarios = [\"walk\"]\n{factor}{other}");
    assert!(
        parse(&text).expect_err("10^10 rollouts").contains("found 10000000000 a scenario; valid are at most"),
        "{text}"
    );
}

#[test]
fn every_built_in_study_can_be_read_and_again_as_it_is_written() {
    for name in legwork::library::study_names() {
        let study = Study::load(name, &[]).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(study.name, name);
        assert!(study.description.ends_with(['.', '?']), "{name}");
        let again = Study::parse(study.to_toml(), "again.toml", None, &[]).expect("it was written by us");
        assert_eq!((again.identity(), again.len()), (study.identity(), study.len()), "{name}");
        assert_eq!(again.point(study.len() - 1), study.point(study.len() - 1), "{name}");
    }
}

/// Section 5.2 and the ranges that the findings of Section 6.3 span, each with ten levels or more around the baseline.
#[test]
fn the_nine_parameters_are_shipped_as_studies() {
    for (name, path, least, most) in [
        ("torque-limit", "controller.limits.torque_nm", 150.0, 500.0),
        ("grf-limit", "controller.limits.grf_n", 500.0, 1000.0),
        ("acceleration-weight", "controller.weights.joint_acceleration", 1e-2, 1e2),
        ("grf-weight", "controller.weights.grf", 1e-6, 1e1),
        ("momentum-weight", "controller.weights.momentum", 1.0, 1e4),
        ("feet-weight", "controller.weights.feet", 1e3, 1e6),
        ("torso-weight", "controller.weights.torso", 1e3, 1e6),
        ("com-gain", "controller.planner.com_gain", 500.0, 3000.0),
        ("foot-gain", "controller.planner.foot_gain", 500.0, 3000.0),
    ] {
        let study = Study::load(name, &[]).expect("it is built in");
        let factor = &study.factors[0];
        assert_eq!((&study.design, factor.paths.as_slice()), (&Design::OneAtATime, [path.to_owned()].as_slice()));
        let levels: Vec<f64> = (0..factor.levels.count().expect("levels"))
            .map(|index| factor.levels.level(index).number().expect("a number"))
            .collect();
        assert!(levels.len() >= 10 && levels.is_sorted(), "{name}: {levels:?}");
        assert!(levels[0] <= least && levels[levels.len() - 1] >= most, "{name}: {levels:?}");
        let marked = factor.marked.as_ref().expect("the thesis's value").0;
        let base = study.bases[0].value(path).expect("a setting");
        assert_eq!(base.as_float(), Some(marked), "{name}");
        assert!(study.bases.iter().any(|base| base.name().starts_with("walk")));
        assert!(study.bases.iter().any(|base| base.name().starts_with("push")));
    }
}

struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("legwork-study-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn fill(study: &Study, folder: &Path, threads: usize) -> Store {
    let store = Store::open(folder, study.to_toml(), study.identity(), study.len(), None).expect("a new folder");
    let survey = store.survey().expect("it can be read");
    let job = |index| study.rollout(index, || false);
    let work = || parallel::run_chunks::<Rollout>(&store, &survey, job, |_| {}, || false);
    let progress = parallel::with_threads(Some(threads), work).expect("threads").expect("written");
    assert!(!progress.is_stopped());
    store
}

/// An older version had other figures, and so another identity.
#[test]
fn what_an_older_version_measured_is_refused_by_file_and_never_mixed_in() {
    let study = parse(&text("design = \"latin-hypercube\"\nsamples = 5")).expect("it is valid");
    let [old, new] = ["older", "newer"].map(Folder::new);
    let fresh = fill(&study, &new.0, 2);
    let rollouts: Vec<Rollout> = fresh.records().collect::<Result<_, _>>().expect("they are whole");
    let chunk = |folder: &Folder| folder.0.join("chunks/000000.jsonl");
    let whole = std::fs::read(chunk(&new)).expect("it was written");
    drop(fresh);

    let older = Store::open(&old.0, study.to_toml(), !study.identity(), study.len(), None).expect("a new folder");
    let fewer = |rollout: &Rollout| Rollout { figures: rollout.figures[1..].to_vec(), ..rollout.clone() };
    let range = older.range(0);
    let records: Vec<Rollout> = rollouts[range.start as usize..range.end as usize].iter().map(fewer).collect();
    older.write(0, &records).expect("it can be written");
    drop(older);
    let refused = Store::open(&old.0, study.to_toml(), study.identity(), study.len(), None).expect_err("another");
    for words in [&old.0.display().to_string(), "other figures; choose another folder, or delete this one"] {
        assert!(refused.to_string().contains(words), "{refused}");
    }

    // Its chunk, brought into the folder of today
    std::fs::copy(chunk(&old), chunk(&new)).expect("it can be copied");
    let store = Store::read(&new.0).expect("it holds a study");
    let refused = store.records::<Rollout>().find_map(Result::err).expect("a chunk is none").to_string();
    assert!(refused.starts_with(&chunk(&new).display().to_string()), "{refused}");
    assert!(refused.contains("belongs to study") && refused.ends_with("run the study again to redo it"), "{refused}");
    let damaged = store.survey().expect("it can be read").damaged;
    assert_eq!(damaged.iter().map(|damaged| &damaged.path).collect::<Vec<_>>(), [&chunk(&new)]);
    fill(&study, &new.0, 2);
    assert!(std::fs::read(chunk(&new)).expect("it is there") == whole, "made again");
}

#[test]
fn tables_have_the_same_bytes_for_any_number_of_threads_and_the_figures_of_the_rollouts() {
    let study = parse(&text("design = \"latin-hypercube\"\nsamples = 5")).expect("it is valid");
    let folders = [Folder::new("one"), Folder::new("three")];
    let stores = [fill(&study, &folders[0].0, 1), fill(&study, &folders[1].0, 3)];
    for (folder, store) in folders.iter().zip(&stores) {
        results::write_table(&study, &folder.0, store.records()).expect("it can be written");
    }
    for name in ["rollouts.csv", "rollouts.parquet", "study.toml"] {
        let [one, three] = [0, 1].map(|i: usize| std::fs::read(folders[i].0.join(name)).expect("it was written"));
        assert!(one == three, "{name}");
    }
    let csv = std::fs::read_to_string(folders[0].0.join("rollouts.csv")).expect("it was written");
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let header: Vec<String> = reader.headers().expect("a header").iter().map(str::to_owned).collect();
    let column = |name: &str| header.iter().position(|column| column == name).unwrap_or_else(|| panic!("{name}"));
    let mut count = 0;
    for (index, record) in reader.records().enumerate() {
        let record = record.expect("a row");
        let rollout = study.rollout(index as u64, || false).expect("nobody stops it");
        assert_eq!(record[column("result_hash")], rollout.result_hash);
        assert_eq!(record[column("ending")], *rollout.ending.name());
        let torque: f64 = record[column("torque_nm.mean [Nm]")].parse().expect("a number");
        let at = study.columns().iter().position(|column| column.name == "torque_nm.mean").expect("a figure");
        assert_eq!(Some(torque), rollout.figures[at]);
        let mass: f64 = record[column("mass")].parse().expect("a number");
        assert_eq!(Some(mass), levels(&study, index as u64).1[1]);
        count += 1;
    }
    assert_eq!(count, study.len());
}

#[test]
fn results_count_endings_and_take_quantiles() {
    let study =
        parse(&text("design = \"sobol-sequence\"\nsamples = 4\nmetrics = [\"torque_nm.mean\"]")).expect("valid");
    let rollout = |index: u64| Rollout {
        ending: [Ending::Completed, Ending::Fell, Ending::Injurious]
            .get(index as usize)
            .copied()
            .unwrap_or(Ending::Completed),
        fell_at_s: (index == 1).then_some(0.3),
        cause: (index == 1).then(|| "friction".to_owned()),
        reason: None,
        violations: None,
        figures: study.columns().iter().map(|c| (c.name == "torque_nm.mean").then_some(index as f64)).collect(),
        input_hash: String::new(),
        result_hash: String::new(),
    };
    let results = Results::new(&study, (0..8).map(|index| Ok(rollout(index)))).expect("they can be read");
    let endings = results.endings(0);
    assert_eq!((endings.rollouts, endings.completed, endings.fell, endings.causes["friction"]), (4, 2, 1, 1));
    assert_eq!(endings.injurious, 1);
    assert_eq!(results.endings(1).fell, 0);
    // 0, 2, 3 of the first scenario: the fall does not count.
    assert_eq!(results.quantiles(0, 0, [0.0, 0.5, 1.0]), [Some(0.0), Some(2.0), Some(3.0)]);
    assert_eq!(results.sweep(1, 0).len(), 4);
}

#[test]
fn a_force_that_injures_is_an_ending_of_its_own() {
    // The force at which the rollout's ending changes is the largest one that the run says.
    let study =
        |bound: &str| parse(&text("design = \"grid\"").replace("duration_s = 0.6", bound)).expect("it is valid");
    let rollout = |bound: &str| {
        let study = study(bound);
        study
            .variant(&study.point(0))
            .map(|variant| legwork_study::rollout::run(&variant, || false))
            .expect("valid")
            .expect("whole")
    };
    let of = rollout("duration_s = 0.6");
    let at = study("duration_s = 0.6").columns().iter().position(|column| column.name == "grf_simulated_n.peak");
    let peak = of.figures[at.expect("a figure")].expect("it stands on the ground");
    assert!(of.ending == Ending::Completed && peak > 300.0, "{peak} N");
    for (bound, ending) in [(peak + 1.0, Ending::Completed), (peak - 1.0, Ending::Injurious)] {
        let tried = rollout(&format!("duration_s = 0.6\nmetrics.injurious_force_n = {bound}"));
        assert!(tried.ending == ending && tried.survived(), "{:?} with a bound of {bound} N", tried.ending);
    }
}
