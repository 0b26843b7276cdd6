//! What is read.

use std::fs;
use std::path::Path;

use legwork::library::{load_model, model_names, model_text, scenario_names, scenario_text};
use legwork::scenario::{ContactModel, Push, Replan, Scenario, TrajectoryKind};
use legwork::scenario_file::{load, to_toml};

use crate::{Folder, read, sets};

#[test]
fn a_file_holds_only_what_differs() {
    let scenario = read("ground.friction = 0.5\n[controller.limits]\ntorque_nm = 200\n", &[]).expect("it is valid");
    let mut expected = Scenario { name: "my".into(), ..Scenario::default() };
    expected.ground.friction = 0.5;
    expected.controller.limits.torque_nm = 200.0;
    assert_eq!(scenario, expected);
}

#[test]
fn a_push_states_three_values_and_the_rest_is_default() {
    let text = "[[pushes]]\nforce_n = 300\nstart_s = 1\nduration_s = 0.1\n[[pushes]]\nforce_n = -200.5\nstart_s = 2\n\
                duration_s = 0.1\nat = \"torso\"\npoint_m = [0, 0, 0.3]\n";
    let first = Push { force_n: 300.0, start_s: 1.0, duration_s: 0.1, ..Push::default() };
    let second = Push { force_n: -200.5, start_s: 2.0, at: "torso".into(), point_m: [0.0, 0.0, 0.3], ..first.clone() };
    assert_eq!(read(text, &[]).expect("it is valid").pushes, [first, second]);
}

#[test]
fn the_built_in_scenarios_are_what_their_names_say() {
    let scenario = |name| load(name, &[]).expect("it is valid").scenario;
    let (walk, push) = (scenario("walk"), scenario("push"));
    assert_eq!(walk.reference.com.trajectory, TrajectoryKind::ConstantVelocity);
    assert_eq!((walk.reference.com.speed_mps, walk.duration_s), (0.5, 8.0));
    let shove = Push { force_n: 700.0, start_s: 0.5, duration_s: 0.2, ..Push::default() };
    assert_eq!((&push.pushes, push.duration_s), (&vec![shove], 6.5));
    assert_eq!(scenario("stand"), Scenario { description: scenario("stand").description, ..Scenario::default() });

    // Each of these differs from its base in what it is named for, and in nothing else.
    let mut expected = push.clone();
    expected.reference.step.replan = Replan::InSwing;
    assert_same_but_for_the_name(&scenario("push-replan"), expected);
    let mut expected = walk.clone();
    expected.ground.slope_deg = 3.0;
    assert_same_but_for_the_name(&scenario("walk-slope"), expected);
    let mut expected = walk.clone();
    expected.simulation.contact.model = ContactModel::SpringDamper;
    assert_same_but_for_the_name(&scenario("walk-spring-damper"), expected);
    for (name, mut expected) in [("walk-baseline", walk), ("push-baseline", push)] {
        // Thesis, Table D.1 against Table 6.3
        expected.controller.weights.grf = 1e-6;
        expected.controller.weights.feet = 1e5;
        expected.controller.planner.foot_gain = 1000.0;
        assert_same_but_for_the_name(&scenario(name), expected);
    }
}

#[track_caller]
fn assert_same_but_for_the_name(scenario: &Scenario, mut expected: Scenario) {
    (expected.name, expected.description) = (scenario.name.clone(), scenario.description.clone());
    assert_eq!(*scenario, expected);
}

#[test]
fn every_file_in_the_folders_is_built_in_and_named_as_it_is() {
    let files = |folder: &str| -> Vec<String> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(folder);
        let entries = fs::read_dir(folder).expect("it exists").map(|entry| entry.expect("it can be read").path());
        let mut names: Vec<_> = entries
            .filter(|path| path.extension().is_some_and(|extension| extension == "toml" || extension == "urdf"))
            .map(|path| path.file_stem().expect("it has a name").to_string_lossy().into_owned())
            .filter(|name| !name.ends_with(".legwork")) // what URDF cannot say of the model beside it
            .collect();
        names.sort();
        names
    };
    let (mut scenarios, mut models): (Vec<_>, Vec<_>) = (scenario_names().collect(), model_names().collect());
    scenarios.sort_unstable();
    models.sort_unstable();
    assert_eq!(files("scenarios"), scenarios);
    assert_eq!(files("models"), models);
    for name in scenario_names() {
        let scenario = load(name, &[]).expect("it is valid").scenario;
        assert_eq!(scenario.name, name);
        assert!(scenario.description.ends_with('.') && scenario_text(name).is_some(), "{name}");
        load_model(&scenario.model, None).expect("its model is valid");
    }
    assert_eq!((scenario_text("x"), model_text("x")), (None, None));
}

#[test]
fn what_is_written_is_read_back() {
    for name in scenario_names() {
        let scenario = load(name, &[]).expect("it is valid").scenario;
        assert_eq!(read(&to_toml(&scenario), &[]).expect("it is valid"), scenario, "{name}");
    }
    let text = to_toml(&load("push", &[]).expect("it is valid").scenario);
    let unwrapped = text.replace("\n# ", " ");
    let line = "C_f: Weight of the feet's acceleration error. Valid is a number from 0 to 1e12; default 500000.0 \
                (thesis Table 6.3).\nfeet = 500000.0";
    assert!(unwrapped.contains(line), "{text}");
    let settings = text.lines().filter(|line| !line.starts_with('#') && line.contains(" = "));
    assert_eq!(unwrapped.matches(" Valid is ").count(), settings.count());
    assert!(text.lines().all(|line| !line.starts_with('#') || line.chars().count() <= 100), "{text}");
}

#[test]
fn name_and_description_are_not_inherited() {
    let scenario = read("extends = \"push\"\nseed = 1\n", &[]).expect("it is valid");
    assert_eq!((scenario.name.as_str(), scenario.description.as_str(), scenario.seed), ("my", "", 1));
    assert_eq!(scenario.pushes.len(), 1);
}

#[test]
fn files_extend_files_relative_to_their_own_folder() {
    let folder = Folder::new("extends");
    folder.file("base/robots/tall.toml", "");
    folder.file("base/base.toml", "model = \"robots/tall.toml\"\nreference.com.file = \"com.csv\"\nseed = 1\n");
    folder.file("middle.toml", "extends = \"base/base.toml\"\nduration_s = 2\n");
    let top = folder.file("top/top.toml", "extends = \"../middle.toml\"\nground.friction = 0.5\n");
    let loaded = load(&top, &[]).expect("it is valid");
    let Scenario { name, seed, duration_s, ground, model, reference, .. } = &loaded.scenario;
    assert_eq!((name.as_str(), *seed, *duration_s, ground.friction), ("top", 1, 2.0, 0.5));
    let resolved = |text: &str| loaded.resolve_path(text).canonicalize();
    assert_eq!(resolved(model).ok(), folder.0.join("base/robots/tall.toml").canonicalize().ok());
    assert!(loaded.resolve_path(&reference.com.file).ends_with("base/com.csv"));
}

#[test]
fn built_in_models_keep_their_names_when_extended() {
    let folder = Folder::new("extends-model");
    folder.file("base/base.toml", "model = \"planar_humanoid\"\n");
    let top = folder.file("top.toml", "extends = \"base/base.toml\"\n");
    let loaded = load(&top, &[]).expect("it is valid");
    assert_eq!((loaded.scenario.model.as_str(), loaded.scenario.reference.com.file.as_str()), ("planar_humanoid", ""));
}

#[test]
fn a_path_on_the_command_line_starts_from_the_current_folder() {
    let folder = Folder::new("set-path");
    let file = folder.file("my.toml", "seed = 1\n");
    let here = std::env::current_dir().expect("there is one");
    let loaded = load(&file, &sets(&["model=robots/my.urdf"])).expect("it is valid");
    assert_eq!(loaded.resolve_path(&loaded.scenario.model), here.join("robots/my.urdf"));
    let built_in = load("walk", &sets(&["model=robots/my.urdf"])).expect("it is valid");
    assert_eq!((built_in.folder.clone(), built_in.scenario.model.as_str()), (None, "robots/my.urdf"));
    assert_eq!(built_in.resolve_path("robots/my.urdf"), Path::new("robots/my.urdf"));
}

#[test]
fn set_reaches_every_kind_of_value() {
    let assignments = [
        "pushes.0.force_n=655",
        "pushes.0.point_m=[0, 0, 1]",
        "pushes.0.point_m.2=2",
        " controller.limits.torque_nm = 200 ",
        "reference.step.replan=in-swing",
        "controller.form=\"slack\"",
        "ground.known=false",
        "ground={friction=0.3, slope_deg=2}",
        "description=a = b",
        "name=5",
        "seed=0x10",
        "reference.com.waypoints=[[0, 0.1, 0.9], [1, 0.2, 0.8]]",
        "reference.com.waypoints.1.0=1.5",
    ];
    let scenario = load("push", &sets(&assignments)).expect("all are valid").scenario;
    let push = &scenario.pushes[0];
    assert_eq!((push.force_n, push.point_m, push.duration_s), (655.0, [0.0, 0.0, 2.0], 0.2));
    assert_eq!((scenario.reference.step.replan, scenario.controller.limits.torque_nm), (Replan::InSwing, 200.0));
    assert_eq!((scenario.ground.known, scenario.ground.friction, scenario.ground.slope_deg), (false, 0.3, 2.0));
    assert_eq!((scenario.description.as_str(), scenario.name.as_str(), scenario.seed), ("a = b", "5", 16));
    assert_eq!(scenario.reference.com.waypoints, [[0.0, 0.1, 0.9], [1.5, 0.2, 0.8]]);

    let none = load("push", &sets(&["pushes=[]"])).expect("it is valid").scenario;
    assert!(none.pushes.is_empty());
    let one = "pushes=[{force_n=1, start_s=0, duration_s=1}]";
    let two = load("stand", &sets(&[one, "pushes.0.force_n=2"])).expect("it is valid").scenario;
    assert_eq!(two.pushes, [Push { force_n: 2.0, duration_s: 1.0, ..Push::default() }]);
}

#[test]
fn the_last_word_counts() {
    let scenario = read("seed = -1\n", &["seed=1", "seed=2"]).expect("the file's mistake is put right");
    assert_eq!(scenario.seed, 2);
}
