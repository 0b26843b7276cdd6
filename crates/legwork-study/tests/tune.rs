//! Tunings: what they read, what they find, and the tuned scenarios that are built in.

use legwork::scenario_file;
use legwork_study::parallel::with_threads;
use legwork_study::tune::{Score, Stop, Tuned, Tuning};

/// A short walk and a short push, so that a candidate takes some milliseconds.
const SMALL: &str = r#"
name = "small"
budget = 20
seed = 3

[[factors]]
name = "CoM gain"
path = "controller.planner.com_gain"
logarithmic = { from = 500, to = 5000 }

[[factors]]
name = "feet weight"
path = "controller.weights.feet"
logarithmic = { from = 5e4, to = 5e6 }

[[cases]]
name = "walk"
scenario = "walk"
set.duration_s = 1.0

[[cases]]
name = "push"
scenario = "push"
set = { duration_s = 1.2 }

[[held_out]]
name = "fast"
scenario = "walk"
set = { duration_s = 1.0, "reference.com.speed_mps" = 0.55 }

[[objective]]
metric = "com_error_m.mean"

[[constraints]]
metric = "torque_nm.mean"
at_most_times_base = 1.0
"#;

fn parse(text: &str) -> Tuning {
    Tuning::parse(text, "t.toml", None).unwrap_or_else(|error| panic!("{error}"))
}

fn run(tuning: &Tuning, threads: usize) -> Tuned {
    let tuned = with_threads(Some(threads), || tuning.run(None, |_| (), || false)).expect("there are threads");
    tuned.expect("the base has all figures").expect("nothing stops it")
}

fn column(tuning: &Tuning, name: &str) -> usize {
    tuning.columns.iter().position(|column| column.name == name).expect("there is such a figure")
}

#[test]
fn a_small_budget_betters_the_base_within_its_bounds() {
    let tuning = parse(SMALL);
    assert_eq!(tuning.own, [1500.0, 5e5]);
    let tuned = run(&tuning, 2);
    assert_eq!((tuned.evaluations, tuned.why), (20, Stop::Budget));
    let Score::Feasible(base) = tuned.base_score else { panic!("{:?}", tuned.base_score) };
    assert!((base - 1.0).abs() < 1e-12, "the base beside itself: {base}");
    let Score::Feasible(objective) = tuned.score else { panic!("{:?}", tuned.score) };
    assert!(objective < 0.99, "{objective}");
    // The objective once more, from the table
    let (com, torque) = (column(&tuning, "com_error_m.mean"), column(&tuning, "torque_nm.mean"));
    let shares: Vec<f64> = tuned.training.iter().map(|case| case.figure(com).expect("both stood").2).collect();
    assert!((shares.iter().sum::<f64>() / 2.0 - objective).abs() < 1e-12);
    for case in &tuned.training {
        assert!(case.figure(torque).expect("both stood").2 <= 1.0 + 1e-12, "{}", case.case);
    }
    assert_eq!(tuned.held_out.iter().map(|case| case.case.as_str()).collect::<Vec<_>>(), ["fast"]);
    // Four digits, within the ranges
    for (level, range) in tuned.levels.iter().zip([500.0..=5e3, 5e4..=5e6]) {
        assert_eq!(format!("{level:.3e}").parse(), Ok(*level));
        assert!(range.contains(level));
    }
}

#[test]
fn the_number_of_threads_does_not_change_a_bit() {
    let tuning = parse(&SMALL.replace("budget = 20", "budget = 8"));
    let (one, two) = (run(&tuning, 1), run(&tuning, 2));
    assert_eq!((&one.levels, &one.history), (&two.levels, &two.history));
    assert_eq!((&one.training, &one.held_out), (&two.training, &two.held_out));
}

/// The shipped tuning of the robot with feet: two generations, its five walks and a push, each for a second.
#[test]
fn a_walker_on_feet_is_tuned_to_the_same_bits_on_any_number_of_threads() {
    let mut file: toml::Table = legwork::library::tuning_text("feet").expect("built in").parse().expect("TOML");
    file.insert("budget".into(), 8.into());
    file.insert("population".into(), 4.into());
    for (key, count) in [("cases", 6), ("held_out", 2)] {
        let cases = file[key].as_array_mut().expect("a list");
        cases.truncate(count);
        for case in cases {
            let set = case["set"].as_table_mut().expect("settings");
            set.insert("duration_s".into(), 1.0.into());
            set.remove("metrics");
            if let Some(pushes) = set.get_mut("pushes") {
                pushes[0]["start_s"] = 0.5.into();
            }
        }
    }
    let kept: Vec<String> =
        file["cases"].as_array().expect("a list").iter().map(|case| case["name"].to_string()).collect();
    for constraint in file["constraints"].as_array_mut().expect("a list") {
        constraint["cases"].as_array_mut().expect("names").retain(|name| kept.contains(&name.to_string()));
    }
    let tuning = parse(&file.to_string());
    let (one, two) = (run(&tuning, 1), run(&tuning, 2));
    assert_eq!((&one.levels, &one.history), (&two.levels, &two.history));
    assert_eq!((&one.training, &one.held_out), (&two.training, &two.held_out));
    assert_eq!((one.evaluations, one.history.len(), one.held_out.len()), (8, 2, 2));
    assert!(one.training.iter().all(|case| case.base.survived()), "the first second is no trouble");
    // A figure that only feet have
    let ankle = column(&tuning, "joint.right_ankle.torque_peak_nm");
    assert_ne!(one.levels, tuning.own, "something is better");
    let (_, written) = &tuning.scenarios(&tuning.own)[0];
    assert!(written.contains("\ntorque = 1.86e-8\n") && written.contains("\ncop_gain = 5.27\n"), "{written}");
    assert!(scenario_file::parse(written, "x.toml", None, &[]).is_ok(), "{written}");
    assert!(one.training.iter().any(|case| case.figure(ankle).is_some_and(|(base, tuned, _)| base != tuned)));
}

#[test]
fn what_is_held_out_has_no_say_in_what_is_found() {
    let text = SMALL.replace("budget = 20", "budget = 8");
    // A case in which every robot falls at once
    let hostile = text.replace("\"reference.com.speed_mps\" = 0.55", "\"ground.friction\" = 0.01");
    let (one, other) = (run(&parse(&text), 2), run(&parse(&hostile), 2));
    assert_eq!((&one.levels, &one.history, &one.training), (&other.levels, &other.history, &other.training));
    assert!(one.held_out[0].tuned.survived() && one.held_out != other.held_out);
}

#[test]
fn the_scenarios_that_are_written_are_those_that_were_run() {
    let relative =
        SMALL.replace("logarithmic = { from = 5e4, to = 5e6 }", "relative = true\nlinear = { from = 0.5, to = 4 }");
    let tuning = parse(&relative.replace("budget = 20", "budget = 3"));
    assert_eq!(tuning.own, [1500.0, 1.0]);
    let tuned = run(&tuning, 2);
    let written = tuning.scenarios(&[2345.0, 1.5]);
    assert_eq!(written.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["walk-tuned", "push-tuned"]);
    for ((name, text), case) in written.iter().zip(["walk", "push"]) {
        let read = scenario_file::parse(text, "x.toml", None, &[]).expect("it is valid").scenario;
        let mut expected = scenario_file::load(case, &[]).expect("it is built in").scenario;
        (expected.name, expected.description) = (name.clone(), read.description.clone());
        (expected.controller.planner.com_gain, expected.controller.weights.feet) = (2345.0, 7.5e5);
        assert_eq!(read, expected);
    }
    // To the bit: the same inputs as in the table
    let (_, text) = &tuning.scenarios(&tuned.levels)[0];
    let sets = ["duration_s=1.0".to_owned()];
    let loaded = scenario_file::parse(text, "x.toml", None, &sets).expect("it is valid");
    let model = loaded.model().expect("it is built in");
    let again = legwork::episode::run(&loaded.scenario, &model, &[], |_| false).expect("it can be run");
    assert_eq!(format!("{:032x}", again.result_hash), tuned.training[0].tuned.result_hash);
}

#[test]
fn a_base_that_falls_is_bettered_by_what_falls_later_or_stands() {
    let hard = SMALL.replace("duration_s = 1.2", "duration_s = 2.5, \"pushes.0.force_n\" = 900");
    let tuning = parse(&hard.replace("budget = 20", "budget = 12"));
    let tuned = run(&tuning, 2);
    let fell_at = tuned.training[1].base.fell_at_s.expect("the push is too strong for the base");
    assert_eq!(tuned.base_score, Score::Falling(2.0 - fell_at / 2.5));
    assert!(tuned.score < tuned.base_score, "{:?} {:?}", tuned.score, tuned.base_score);
    assert!(tuned.training[1].tuned.fell_at_s.is_none_or(|later| later > fell_at));
    assert_eq!(tuned.training[1].figure(column(&tuning, "com_error_m.mean")), None, "nothing to compare with");
}

#[test]
fn what_is_stopped_is_the_best_so_far() {
    use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
    let tuning = parse(SMALL);
    let done = AtomicU64::new(0);
    let stop_at = |most: u64| {
        done.store(0, Relaxed);
        let told = |count| done.store(count, Relaxed);
        with_threads(Some(1), || tuning.run(None, told, || done.load(Relaxed) >= most))
            .expect("a thread")
            .expect("figures")
    };
    assert!(stop_at(1).is_none(), "not even the base is whole");
    let tuned = stop_at(2 + 2 * 8 + 1).expect("the base was run");
    assert_eq!((tuned.why, tuned.evaluations, tuned.held_out.len()), (Stop::Interrupted, 8, 0));
    let whole = run(&tuning, 1);
    assert_eq!(tuned.history[0], whole.history[0], "the first generation is whole");
    assert!(tuned.score >= whole.score);
}

/// The place and the problem of a text that is refused, whose lines are those of [`SMALL`].
#[track_caller]
fn refuses(found: &str, replaced: &str, place: &str, words: &[&str]) {
    assert!(SMALL.contains(found), "{found} is not in the text");
    let text = SMALL.replacen(found, replaced, 1);
    let error = Tuning::parse(&text, "t.toml", None).expect_err("it is not valid").to_string();
    assert!(error.starts_with(place), "{error}");
    for word in words {
        assert!(error.contains(word), "{word:?} is not in {error:?}");
    }
}

#[test]
fn files_that_are_none() {
    let valid = ["valid are com_error_m.mean, com_error_m.peak, ", " more"];
    refuses("\"com_error_m.mean\"", "\"com_error\"", "t.toml:31: objective.0: metric: found \"com_error\"; ", &valid);
    refuses("\"torque_nm.mean\"", "\"x\"", "t.toml:34: constraints.0: metric: found \"x\"", &valid);
    let unknown =
        "t.toml:6: factors.0: controller.planner.com_gains: unknown; did you mean controller.planner.com_gain?";
    refuses("planner.com_gain\"", "planner.com_gains\"", unknown, &[]);
    refuses("from = 500,", "from = 5e3,", "t.toml:6: factors.0: logarithmic: from 5000 to 5000 is empty", &[]);
    refuses("from = 500,", "from = 6e3,", "t.toml:6: factors.0: logarithmic: from 6000 to 5000 is crossed", &[]);
    let own = "t.toml:6: factors.0: starts from the own 1500, which is not between 2000 and 5000";
    refuses("from = 500,", "from = 2e3,", own, &[]);
    refuses("to = 5000 }", "to = 5e7 }", "t.toml:6: factors.0: the level 5e7 is not one that walk can have", &[]);
    refuses("budget = 20", "budget = 0", "t.toml:3: budget: found 0; valid is a whole number from 1 to", &[]);
    refuses("seed = 3", "sigma = 0.5", "t.toml:4: sigma: found 0.5; valid is a share", &[]);
    refuses("seed = 3", "sigma = nan", "t.toml:4: sigma: found NaN", &[]);
    refuses("seed = 3", "population = 3", "t.toml:4: population: found 3; valid is a whole number from 4", &[]);
    refuses("seed = 3", "sed = 3", "t.toml:4: unknown field `sed`, expected one of `name`", &[]);
    refuses("name = \"small\"", "name = \"a/b\"", "t.toml:2: name: found \"a/b\"", &[]);
}

#[test]
fn cases_that_are_none() {
    let twice = "t.toml:26: held_out.0: \"fast\" is the case \"walk\" over again";
    refuses(", \"reference.com.speed_mps\" = 0.55", "", twice, &[]);
    refuses("name = \"push\"", "name = \"walk\"", "t.toml:21: cases.1: another case is called \"walk\" as well", &[]);
    refuses("scenario = \"push\"", "scenario = \"puhs\"", "t.toml:21: cases.1: scenario: ", &["did you mean push?"]);
    refuses("{ duration_s = 1.2 }", "{ duration = 1.2 }", "t.toml:21: cases.1: duration: unknown; did you mean", &[]);
    refuses("{ duration_s = 1.2 }", "{ duration_s = -1 }", "t.toml:21: cases.1: duration_s: found -1", &[]);
    let scaled = "t.toml:21: cases.1: scale, seed: found the text \"a\"; valid is a number";
    refuses("set = { duration_s = 1.2 }", "scale.seed = \"a\"", scaled, &[]);
    let both = "t.toml:6: factors.0: the case \"push\" sets controller.planner.com_gain as well";
    refuses("{ duration_s = 1.2 }", "{ controller.planner.com_gain = 900 }", both, &[]);
    refuses("scenario = \"push\"", "scenario = \"push\"\nweight = 0", "t.toml:21: cases.1: weight: found 0", &[]);
    let others = "t.toml:6: factors.0: controller.planner.torso_gain of walk is 45, ";
    let other =
        SMALL.replace("controller.planner.com_gain", "controller.planner.torso_gain").replace("500, to", "10, to");
    let error = Tuning::parse(&other.replace("\"push\"", "\"push-support\""), "t.toml", None).unwrap_err().to_string();
    assert!(error.starts_with(others) && error.contains("relative = true"), "{error}");
    for (key, part) in
        [("cases", "candidates are tried"), ("held_out", "what a tuning is worth"), ("factors", "changes")]
    {
        let kept = SMALL.split("\n\n").filter(|block| !block.contains(&format!("[[{key}]]"))).collect::<Vec<_>>();
        let error = Tuning::parse(&kept.join("\n\n"), "t.toml", None).unwrap_err().to_string();
        assert!(error.starts_with(&format!("t.toml: no [[{key}]]")) && error.contains(part), "{error}");
    }
    assert!(Tuning::parse(" \n", "t.toml", None).unwrap_err().to_string().starts_with("t.toml: nothing in it"));
}

#[test]
fn factors_and_aims_that_are_none() {
    let list = "list = [1, 2]";
    refuses("logarithmic = { from = 500, to = 5000 }", list, "t.toml:6: factors.0: a list has nothing between", &[]);
    let number = "valid are settings that hold one number";
    for path in ["controller.form", "seed", "model.gravity_mps2"] {
        let text = SMALL.replace("controller.planner.com_gain", path);
        let error = Tuning::parse(&text, "t.toml", None).unwrap_err().to_string();
        assert!(error.starts_with(&format!("t.toml:6: factors.0: {path}")) && error.contains(number), "{error}");
    }
    let same = "t.toml:11: factors.1: \"CoM gain\" changes controller.planner.com_gain as well";
    refuses("controller.weights.feet", "controller.planner.com_gain", same, &[]);
    let weight = "t.toml:31: objective.0: weight: found -1; valid is";
    refuses("\"com_error_m.mean\"", "\"com_error_m.mean\"\nweight = -1", weight, &[]);
    let case = "t.toml:31: objective.0: cases: found \"stroll\"; valid are walk, push";
    refuses("\"com_error_m.mean\"", "\"com_error_m.mean\"\ncases = [\"stroll\"]", case, &[]);
    let none = "t.toml:31: objective.0: scenarios: found none; valid are walk, push";
    refuses("\"com_error_m.mean\"", "\"com_error_m.mean\"\nscenarios = []", none, &[]);
    refuses("at_most_times_base = 1.0", "", "t.toml:34: constraints.0: needs one of at_most", &[]);
    let two = "at_most_times_base = 1.0\nat_least = 3";
    refuses("at_most_times_base = 1.0", two, "t.toml:34: constraints.0: needs one of at_most", &[]);
    refuses("at_most_times_base = 1.0", "at_most = -2", "t.toml:34: constraints.0: at_most: found -2", &[]);
    let lacking = parse(&SMALL.replace("\"com_error_m.mean\"", "\"recovery_distance_m\""));
    let error = lacking.run(None, |_| (), || false).expect_err("the walk has none").to_string();
    assert!(error.starts_with("t.toml:31: objective.0: the case \"walk\" has no recovery_distance_m"), "{error}");
}

#[test]
fn names_and_files() {
    let error = Tuning::load("thesys").expect_err("there is none").to_string();
    assert!(error.contains("did you mean thesis? built-in: thesis"), "{error}");
    assert!(Tuning::load("no/such.toml").expect_err("there is none").is_io());
    for name in legwork::library::tuning_names() {
        let tuning = Tuning::load(name).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(tuning.name, name);
        assert!(tuning.description.ends_with('.'));
        // What it writes about itself is the same tuning.
        let again = Tuning::parse(&tuning.to_toml(), "again.toml", None).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((again.to_toml(), &again.factors, &again.own), (tuning.to_toml(), &tuning.factors, &tuning.own));
    }
}

/// The shipped scenarios are as good as the thesis's final design in both experiments, to a hundredth, at less torque.
#[test]
fn what_is_shipped_is_as_good_as_the_final_design() {
    let measured = |name: &str| {
        let base = legwork_study::Base::load(name, &[]).expect("it is built in");
        let run = legwork_study::rollout::simulate(base.variant(), || false).expect("it can be run");
        assert_eq!(run.outcome, legwork::episode::Outcome::Completed, "{name}");
        run.metrics
    };
    for name in ["walk", "push"] {
        let (base, tuned) = (measured(name), measured(&format!("{name}-tuned")));
        let [before, after] = [&base, &tuned].map(|m| m.com_error_m.expect("it lasts"));
        assert!(after.mean < 1.01 * before.mean && after.peak <= before.peak, "{name}: {after:?} {before:?}");
        let [before, after] = [&base, &tuned].map(|m| m.feet_error_m.expect("it is measured"));
        assert!(after.mean < 1.002 * before.mean && after.peak <= before.peak, "{name}: {after:?} {before:?}");
        let [before, after] = [&base, &tuned].map(|m| m.torque_nm.expect("it is measured"));
        assert!(after.mean < before.mean && after.peak <= before.peak, "{name}: {after:?} {before:?}");
        let [before, after] = [&base, &tuned].map(|m| m.u2_n2m2.expect("it is measured"));
        assert!(after.mean < before.mean, "{name}: {after:?} {before:?}");
    }
}

/// They are what the shipped tuning may find: its factors and nothing else differ from the scenarios as they stand.
#[test]
fn the_shipped_scenarios_differ_in_the_factors_alone() {
    let tuning = Tuning::load("thesis").expect("it is built in");
    for name in ["walk", "push"] {
        let base = legwork_study::Base::load(name, &[]).expect("it is built in");
        let tuned = legwork_study::Base::load(&format!("{name}-tuned"), &[]).expect("it is built in");
        let mut scenario = tuned.variant().scenario.clone();
        let before = &base.variant().scenario;
        (scenario.name, scenario.description) = (before.name.clone(), before.description.clone());
        let paths: Vec<&String> = tuning.factors.iter().flat_map(|factor| &factor.paths).collect();
        assert!(paths.iter().any(|path| base.value(path).ok() != tuned.value(path).ok()));
        let changes: Vec<(&str, legwork_study::Change)> = paths
            .iter()
            .map(|path| (path.as_str(), legwork_study::Change::To(base.value(path).expect("a setting"))))
            .collect();
        let back = tuned.vary(changes.iter().map(|(path, change)| (*path, change))).expect("it is valid");
        let mut back = back.scenario;
        (back.name, back.description) = (before.name.clone(), before.description.clone());
        assert_eq!(&back, before, "{name}");
    }
}
