//! Why a robot fell: scenarios made to fail in known ways, the named cause held against the run without it.

mod common;

use legwork::Robot;
use legwork::diagnosis::{Diagnosis, FirstCause, What};
use legwork::episode::{self, Outcome, Run};
use legwork::log::Field;
use legwork::momentum::LimitKind;
use legwork::scenario::{Scenario, Tracking};
use legwork::{library, scenario_file};

/// Loads a built-in scenario with `sets` and its model.
fn load(name: &str, sets: &[&str]) -> (Scenario, Robot) {
    let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
    let loaded = scenario_file::load(name, &sets).expect("a built-in scenario");
    let model = library::load_model(&loaded.scenario.model, None).expect("a built-in model");
    (loaded.scenario, model)
}

fn diagnosis(run: &Run) -> &Diagnosis {
    let diagnosis = run.diagnosis.as_ref().expect("it falls");
    check_form(run, diagnosis);
    diagnosis
}

/// What holds for every diagnosis.
fn check_form(run: &Run, diagnosis: &Diagnosis) {
    let Outcome::Fell(fall) = &run.outcome else { panic!("a diagnosis without a fall") };
    let sentence = &diagnosis.sentence;
    assert_eq!(run.reason.as_ref(), Some(sentence));
    assert!(sentence.starts_with(&format!("fell at {:.2} s: ", fall.time)), "{sentence}");
    assert!(sentence.len() <= 280 && !sentence.contains(". ") && !sentence.contains('\n'), "{sentence}");
    let lower = sentence.to_lowercase();
    assert!(
        !lower.contains("nan") && !lower.split([' ', ',']).any(|word| word == "inf" || word == "-inf"),
        "{sentence}"
    );
    assert!(diagnosis.events.is_sorted_by(|a, b| a.time <= b.time), "{:?}", diagnosis.events);
    assert!(diagnosis.events.iter().all(|event| (0.0..=fall.time).contains(&event.time)), "{:?}", diagnosis.events);
    // Nothing is told that was not there.
    assert!(!sentence.contains(", 0 ") && !sentence.contains(" by 0 m/s2"), "{sentence}");
    for belief in sentence.split(", assumed to be ").collect::<Vec<_>>().windows(2) {
        let said = belief[0].trim_end_matches(" deg").rsplit(' ').next().expect("a number before what was assumed");
        let assumed = belief[1].split([',', ')', ' ']).next().expect("what was assumed");
        assert_ne!(said.parse::<f64>().expect("a number"), assumed.parse::<f64>().expect("a number"), "{sentence}");
    }
    for event in &diagnosis.events {
        if let What::Saturated { share, lasted, .. } = event.what {
            let told =
                if share < 0.3 { format!("for {lasted:.2} s of") } else { format!("for {:.0} % of", 100.0 * share) };
            assert!(sentence.contains(&told), "{told}: {sentence}");
        }
    }
    if let FirstCause::Outweighed { task } = diagnosis.cause {
        let hard = run.tasks.iter().any(|known| known.name == task && known.how == Tracking::Equality);
        assert!(!hard, "a hard equality gives way to no cost: {sentence}");
    }
    let farthest = (0..run.log.len()).map(|i| past_the_feet(run, i)).fold(0.0, f64::max);
    for event in &diagnosis.events {
        if let What::OutOfReach { past, longest, short, .. } = event.what {
            // The height of the pendulum is reckoned otherwise here where the ground inclines.
            assert!(past <= 1.05 * farthest + 0.01, "{past} of {farthest} m: {sentence}");
            assert!(short <= 2.0 * longest || !sentence.contains(&format!("{short:.2}")), "{sentence}");
        }
    }
    let last = diagnosis.events.last().expect("the fall at least");
    assert_eq!((last.time, &last.what), (fall.time, &What::Fell));
}

/// How far the XcoM was from the feet in a record at the most, in any direction of the plane [m]: no place that a sentence names is farther.
fn past_the_feet(run: &Run, i: usize) -> f64 {
    let of = |field| run.log.get(i, field)[0];
    let axes = run.model.linear_axes().len();
    let height = run.log.get(i, Field::ComReference)[axes - 1];
    let xcom = of(Field::Com) + of(Field::ComVelocity) / (9.81 / height.max(0.2)).sqrt();
    run.log.get(i, Field::Feet).chunks(axes).map(|foot| (xcom - foot[0]).abs()).fold(0.0, f64::max)
}

/// The number that stands before `unit` after `begin` in a sentence.
fn number(sentence: &str, begin: &str, unit: &str) -> f64 {
    let rest = sentence.split(begin).nth(1).unwrap_or_else(|| panic!("'{begin}' in: {sentence}"));
    let before = rest.split(unit).next().expect("text before the unit");
    before.trim().parse().unwrap_or_else(|_| panic!("'{before}' before '{unit}' in: {sentence}"))
}

/// The values of the column `name`.
fn column(run: &Run, name: &str) -> Vec<f64> {
    let index = run.log.columns().iter().position(|column| column.name == name).expect("a column");
    run.log.column(index).collect()
}

/// A scenario and the settings under which it falls; label, joint or foot; the settings under which it stands.
type Known = (&'static str, &'static [&'static str], &'static str, &'static str, &'static [&'static str]);

#[rustfmt::skip]
const KNOWN: [Known; 17] = [
    ("push", &["controller.limits.torque_nm=150"], "torque-limit", "left_knee", &["controller.limits.torque_nm=400"]),
    ("walk", &["controller.limits.torque_nm=120"], "torque-limit", "left_knee", &["controller.limits.torque_nm=400"]),
    ("stand", &["controller.limits.torque_nm=1"], "torque-limit", "right_knee", &["controller.limits.torque_nm=400"]),
    ("push-baseline", &[], "torque-limit", "left_knee", &["controller.limits.torque_nm=500"]),
    ("walk", &["ground.friction=0.1", "ground.known=false"], "friction", "left_foot", &["ground.known=false"]),
    ("walk", &["ground.friction=0.3", "ground.known=false"], "friction", "right_foot", &["ground.known=false"]),
    ("push", &["ground.friction=0.1"], "friction", "left_foot", &["ground.friction=0.3"]),
    ("push-support", &["pushes.0.force_n=1500"], "push", "", &["pushes.0.force_n=700"]),
    ("push", &["pushes.0.force_n=1000"], "push", "", &["pushes.0.force_n=800"]),
    ("push", &["reference.step.max_length_m=0.6"], "step-too-short", "", &["reference.step.max_length_m=0.7"]),
    ("push", &["controller.limits.grf_n=500"], "force-limit", "left_foot", &["controller.limits.grf_n=900"]),
    ("walk", &["controller.limits.joint_acceleration_radps2=60"], "acceleration-limit", "right_hip", &[]),
    ("walk", &["controller.limits.torque_nm=120", "controller.tracking.momentum=equality"], "infeasible-program", "",
        &["controller.limits.torque_nm=220", "controller.tracking.momentum=equality"]),
    ("walk", &["simulation.contact.model=spring-damper", "simulation.contact.stiffness_npm=1e7"], "numerics", "",
        &["simulation.contact.model=spring-damper", "simulation.contact.stiffness_npm=1e5"]),
    ("walk", &["controller.weights.momentum=200", "controller.weights.feet=14000"], "outweighed", "",
        &["controller.weights.momentum=10", "controller.weights.feet=14000"]),
    ("walk", &["ground.slope_deg=-8", "ground.known=false"], "missed-ground", "left_foot", &["ground.slope_deg=-8"]),
    ("push", &["simulation.sensors.delay_s=0.5"], "sensing", "", &[]),
];

/// The same for the walker.
#[rustfmt::skip]
const KNOWN_FEET: [Known; 17] = [
    ("push-walking", &["pushes.0.force_n=650", "pushes.0.start_s=5.2"], "push", "",
        &["pushes.0.force_n=450", "pushes.0.start_s=5.2"]),
    ("push-walking", &["pushes.0.force_n=1000", "pushes.0.direction_deg=180", "pushes.0.start_s=5.3"], "push", "",
        &["pushes.0.force_n=600", "pushes.0.direction_deg=180", "pushes.0.start_s=5.3"]),
    ("stand-push", &["pushes.0.force_n=1100"], "push", "", &["pushes.0.force_n=700"]),
    ("stand-push", &["pushes.0.force_n=300", "reference.walker.longest_m=0.1"], "step-too-short", "",
        &["pushes.0.force_n=300"]),
    ("stand-push", &["pushes.0.force_n=300", "pushes.0.direction_deg=180", "reference.walker.longest_back_m=0.1"],
        "step-too-short", "", &["pushes.0.force_n=300", "pushes.0.direction_deg=180"]),
    ("feet-walk", &["ground.patches=[[2,20,0.15]]"], "friction", "right_foot",
        &["ground.patches=[[2,20,0.15]]", "ground.relief_known=true"]),
    ("feet-walk", &["ground.friction=0.03"], "friction", "left_toe", &["ground.friction=0.1"]),
    ("feet-walk", &["controller.limits.torque_nm=100"], "torque-limit", "right_ankle", &[]),
    ("feet-walk", &["controller.limits.torque_rate_nmps=1000"], "torque-rate-limit", "right_hip", &[]),
    ("feet-walk", &["controller.limits.joint_acceleration_radps2=40"], "acceleration-limit", "right_knee", &[]),
    ("feet-walk", &["controller.limits.grf_n=350"], "force-limit", "right_toe", &["controller.limits.grf_n=500"]),
    ("feet-walk", &["ground.profile=[[1.6,0],[1.62,-0.15]]"], "missed-ground", "left_foot",
        &["ground.profile=[[1.6,0],[1.62,-0.15]]", "ground.relief_known=true"]),
    ("feet-walk", &["ground.profile=[[2.2,0],[2.22,0.08]]"], "missed-ground", "right_foot",
        &["ground.profile=[[2.2,0],[2.22,0.08]]", "ground.relief_known=true"]),
    ("feet-walk", &["ground.profile=[[1.8,0],[1.82,0.08]]"], "missed-ground", "left_foot",
        &["ground.profile=[[1.8,0],[1.82,0.02]]"]),
    ("feet-walk", &["ground.profile=[[1.95,0],[1.97,0.08]]", "ground.relief_known=true"], "missed-ground", "left_foot",
        &["ground.profile=[[1.93,0],[1.95,0.08]]", "ground.relief_known=true"]),
    ("feet-walk", &["ground.slope_deg=-14", "ground.known=false"], "missed-ground", "left_foot",
        &["ground.slope_deg=-12", "ground.known=false"]),
    ("feet-walk", &["controller.weights.feet=2"], "outweighed", "", &[]),
];

#[test]
fn a_known_cause_is_named_and_without_it_the_robot_stands() {
    check(&KNOWN, "duration_s=3");
}

#[test]
fn a_walkers_known_cause_is_named_and_without_it_it_stands() {
    check(&KNOWN_FEET, "duration_s=10");
}

/// Label, part and words of each known cause, and that without it the robot is on its feet at the end.
fn check(known: &[Known], duration: &'static str) {
    for &(name, sets, label, part, cure) in known {
        let mut sets = sets.to_vec();
        sets.push(duration);
        let run = common::run(name, &sets);
        let found = diagnosis(&run);
        let context = format!("{name} {sets:?}: {}", found.sentence);
        assert_eq!((found.cause.label(), found.cause.part().unwrap_or("")), (label, part), "{context}");
        assert!(found.sentence.contains(&part.replace('_', " ")), "{context}");

        let mut cure = cure.to_vec();
        cure.push(duration);
        let run = common::run(name, &cure);
        assert_eq!((&run.outcome, &run.diagnosis), (&Outcome::Completed, &None), "{name} {cure:?}: {:?}", run.reason);
    }
}

/// At 2.2 m/s, with steps as long as that wants, an ankle of the walker comes to its end; with more room in both of them alone it
/// walks on.
#[test]
fn the_end_of_an_ankles_range_is_named() {
    let (scenario, mut model) =
        load("feet-walk", &["reference.walker.speed_mps=2.2", "reference.walker.longest_m=1.4", "duration_s=8"]);
    let run = episode::run(&scenario, &model, &[], |_| false).expect("it can start");
    let found = diagnosis(&run);
    assert_eq!(found.cause, FirstCause::JointLimit { joint: "left_ankle".into() }, "{}", found.sentence);
    assert_eq!(number(&found.sentence, "left ankle was held back by its end at", "deg"), 40.0);
    model.dofs.iter_mut().filter(|dof| dof.name.ends_with("ankle")).for_each(|dof| dof.upper = 75.0_f64.to_radians());
    let run = episode::run(&scenario, &model, &[], |_| false).expect("it can start");
    assert_eq!(run.outcome, Outcome::Completed, "{:?}", run.reason);
}

/// With 100 Nm in every joint the walker's ankles are too weak: stronger ones alone carry it, stronger knees do not.
#[test]
fn the_walkers_named_joint_is_the_one_that_was_too_weak() {
    let (scenario, mut weak) = load("feet-walk", &[]);
    weak.dofs.iter_mut().for_each(|dof| dof.effort_limit = 100.0);
    for (strong, stands) in [("ankle", true), ("knee", false), ("", false)] {
        let mut model = weak.clone();
        for dof in model.dofs.iter_mut().filter(|dof| !strong.is_empty() && dof.name.ends_with(strong)) {
            dof.effort_limit *= 1.5;
        }
        let run = episode::run(&scenario, &model, &[], |_| false).expect("it can start");
        assert_eq!(run.outcome == Outcome::Completed, stands, "stronger '{strong}': {:?}", run.reason);
        if strong.is_empty() {
            assert_eq!(diagnosis(&run).cause, FirstCause::TorqueLimit { joint: "right_ankle".into() });
        }
    }
}

/// Not only more torque in all joints saves the baseline: that of the named joint alone does.
#[test]
fn the_named_joint_is_the_one_that_was_too_weak() {
    let (scenario, model) = load("push-baseline", &["controller.limits.torque_nm=500", "duration_s=3"]);
    for (strong, stands) in [("left_knee", true), ("right_hip", false), ("", false)] {
        let mut model = model.clone();
        for dof in model.dofs.iter_mut().filter(|dof| dof.actuated && dof.name != strong) {
            dof.effort_limit = 220.0;
        }
        let run = episode::run(&scenario, &model, &[], |_| false).expect("it can start");
        assert_eq!(run.outcome == Outcome::Completed, stands, "500 Nm in '{strong}': {:?}", run.reason);
        if strong.is_empty() {
            assert_eq!(diagnosis(&run).cause, FirstCause::TorqueLimit { joint: "left_knee".into() });
        }
    }
}

/// An effort limit of zero is a joint that can give no torque, not one without a limit.
#[test]
fn knees_with_an_effort_limit_of_zero_give_no_torque() {
    for (name, knees) in [("stand", ["right_knee", "left_knee"]), ("exo-sway", ["right_kfe", "left_kfe"])] {
        let (scenario, mut model) = load(name, &[]);
        model.dofs.iter_mut().filter(|dof| knees.contains(&dof.name.as_str())).for_each(|dof| dof.effort_limit = 0.0);
        let run = episode::run(&scenario, &model, &[], |_| false).expect("it can start");
        for knee in knees {
            let most = |column: Vec<f64>| column.iter().fold(0.0, |most: f64, torque| most.max(torque.abs()));
            let asked = most(column(&run, &format!("torque.{knee}")));
            assert!(asked < 1e-6, "{name}: {asked} Nm of {knee}");
            assert_eq!(most(column(&run, &format!("torque_applied.{knee}"))), 0.0, "{name}: {knee}");
        }
        assert_eq!(diagnosis(&run).cause, FirstCause::TorqueLimit { joint: knees[0].into() }, "{name}");
    }
}

#[test]
fn the_numbers_of_a_torque_limit_are_those_of_the_log() {
    let run = common::run("push", &["controller.limits.torque_nm=150"]);
    let sentence = &diagnosis(&run).sentence;
    let (swing, torque) = (column(&run, "swing"), column(&run, "torque.left_knee"));
    let (com, reference, time) = (column(&run, "com_z"), column(&run, "com_reference_z"), column(&run, "t"));
    // The first step is the right foot's; a torque of 150 Nm is at its limit.
    let first = swing.iter().position(|&foot| foot == 0.0).expect("a step");
    let last = (first..swing.len()).find(|&i| swing[i] != 0.0).expect("its end") - 1;
    let full = (first..=last).filter(|&i| torque[i].abs() > 150.0 - 1e-6).count();
    let share = 100.0 * full as f64 / (last + 1 - first) as f64;
    assert!((number(sentence, "limit for", "%") - share).abs() <= 1.0, "{share} %: {sentence}");
    assert!(share > 50.0, "{share}");
    assert_eq!(number(sentence, "was at its", "Nm"), 150.0);
    assert!((number(sentence, "had sunk", "m by") - (reference[last] - com[last])).abs() <= 0.005, "{sentence}");
    assert!((number(sentence, "m by", "s because") - time[last]).abs() <= 0.005, "{sentence}");
    let lift = number(sentence, "swing,", "N of lift");
    let most = column(&run, "slack.momentum.linear_z")[first..=last].iter().fold(0.0, |a: f64, &b| a.max(b));
    assert!(lift > 100.0 && lift < most, "{lift} of at most {most}: {sentence}");
}

#[test]
fn the_numbers_of_a_push_are_those_of_the_log() {
    let run = common::run("push-support", &["pushes.0.force_n=1500"]);
    let sentence = &diagnosis(&run).sentence;
    assert_eq!(number(sentence, "the push of", "Ns"), 1500.0 * 0.2);
    assert_eq!(number(sentence, "longest step of", "m fell"), 1.25);
    let time = number(sentence, "foot by", "s, and");
    let tick = (time / 0.001).round() as usize;
    assert!(time > 0.7, "after the push: {sentence}");
    // By the time of the sentence, which is rounded to 0.01 s: the XcoM moves at most 0.05 m meanwhile.
    let xcom = column(&run, "xcom")[tick];
    let front = column(&run, "foot.right_foot_x")[tick].max(column(&run, "foot.left_foot_x")[tick]);
    let past = number(sentence, "carried the XcoM", "m past");
    assert!((past - (xcom - front)).abs() < 0.06, "{past}, {}", xcom - front);
    // How far the XcoM runs within another step, after Hof's pendulum of the reference's height.
    let height = column(&run, "com_reference_z")[tick];
    let runs = past * (0.25 * (9.81_f64 / height).sqrt()).exp();
    let apart = (column(&run, "foot.right_foot_x")[tick] - column(&run, "foot.left_foot_x")[tick]).abs();
    let short = number(sentence, "m fell", "m short");
    assert!((short - (runs + apart - 1.25)).abs() < 0.05, "{short}, {}", runs + apart - 1.25);
}

#[test]
fn the_numbers_of_a_push_on_soles_are_those_of_the_log() {
    let run = common::run("push-walking", &["pushes.0.force_n=700"]);
    let sentence = &diagnosis(&run).sentence;
    assert_eq!(number(sentence, "the push of", "Ns"), 700.0 * 0.2);
    let tick = (number(sentence, "toes by", "s, and") / 0.001).round() as usize;
    let past = number(sentence, "carried the XcoM", "m past");
    assert!((past + column(&run, "xcom_margin")[tick]).abs() < 0.06, "{past}: {sentence}");
    let longest = number(sentence, "longest step of", "m fell");
    assert!(longest > 0.0 && longest <= run.scenario.reference.walker.longest_m, "{sentence}");
}

/// A step down, a step up, and a slope, none of them told.
#[test]
fn the_ground_that_a_walker_did_not_know_is_as_the_scenario_has_it() {
    for (edge, step, height, way) in
        [(1.6, -0.15, 15.0, "lower"), (1.6, -0.2, 20.0, "lower"), (2.15, 0.1, 10.0, "higher")]
    {
        let run = common::run("feet-walk", &[&format!("ground.profile=[[{edge:?},0],[{:?},{step:?}]]", edge + 0.02)]);
        let sentence = &diagnosis(&run).sentence;
        assert_eq!(number(sentence, "found the ground", &format!("cm {way} than")), height, "{sentence}");
        // When the left foot, which swings, lands beyond the edge; before a riser a foot may stand with its toe on that.
        if way == "lower" {
            let time = number(sentence, "believed at", "s;");
            let tick = (time / 0.001).round() as usize;
            let toe = |foot: &str| column(&run, &format!("foot.{foot}_toe_x"))[tick];
            assert!(toe("left") > edge && toe("right") < edge, "{sentence}");
            assert!(column(&run, "swing")[tick - 20] == 1.0 && column(&run, "swing")[tick + 20] != 1.0, "{sentence}");
        }
    }
    let run = common::run("feet-walk", &["ground.slope_deg=-14", "ground.known=false"]);
    let sentence = &diagnosis(&run).sentence;
    assert!(
        sentence.contains("lower than the controller believed at")
            && sentence.contains("(slope -14 deg, assumed to be 0)"),
        "{sentence}"
    );
}

/// A double support of seconds, at whose end a knee comes to its largest speed, 10 rad/s.
#[test]
fn what_lasts_for_a_small_share_is_told_in_seconds() {
    let push = "pushes=[{force_n=1066.9,direction_deg=0,start_s=1.621,duration_s=0.2}]";
    let run = common::run("exo-sway", &["controller.tracking.feet=equality", "seed=384", push]);
    let sentence = &diagnosis(&run).sentence;
    let told = number(sentence, "the left kfe was held to its speed limit of 10 rad/s for", "s of the double support");
    let (speed, swing) = (column(&run, "v.left_kfe"), column(&run, "swing"));
    assert!(swing.iter().all(|&foot| foot < 0.0) && told < 0.3e-3 * swing.len() as f64, "{sentence}");
    assert!(speed.iter().any(|speed| speed.abs() > 9.0), "{sentence}");
}

/// Pushed upward by more than its weight it flies, whatever its joints do in the air; a weaker push it survives.
#[test]
fn a_push_off_the_ground_is_the_cause() {
    let push = |force: &str| format!("pushes=[{{force_n={force},direction_deg=72.3,start_s=0.251,duration_s=0.2}}]");
    let run = common::run("stop-and-go", &[&push("1182.1"), "ground.unevenness_m=0.0201", "seed=152"]);
    assert_eq!(diagnosis(&run).cause, FirstCause::Push, "{:?}", run.reason);
    assert_eq!(
        number(&diagnosis(&run).sentence, "because the push of", "Ns at 0.25 s had lifted it off the ground"),
        236.0
    );
    let flies = |i: &usize| run.log.get(*i, Field::Touching).iter().all(|&touches| touches == 0.0);
    assert!((0..run.log.len()).filter(flies).count() > 100);
    assert_eq!(common::run("stop-and-go", &[&push("100")]).outcome, Outcome::Completed);
}

/// Feet that may not carry the weight slide while the robot sinks: they are not why.
#[test]
fn a_slide_of_a_robot_that_sinks_already_is_not_the_cause() {
    let sets = ["ground.friction=0.278", "ground.known=false", "ground.slope_deg=9.45", "controller.limits.grf_n=247"];
    let run = common::run("push", &sets);
    assert_eq!(diagnosis(&run).cause.label(), "force-limit", "{:?}", run.reason);
}

/// On a riser that it knows a foot comes down with its heel before the edge and its toe behind.
#[test]
fn an_edge_across_which_a_foot_comes_down_stands_above_its_sole() {
    let run = common::run("feet-walk", &["ground.profile=[[1.95,0],[1.97,0.08]]", "ground.relief_known=true"]);
    let sentence = &diagnosis(&run).sentence;
    let last = run.log.len() - 1;
    let [heel, toe] =
        ["heel", "toe"].map(|end| ["x", "z"].map(|axis| column(&run, &format!("foot.left_{end}_{axis}"))[last]));
    assert!(heel[0] < 1.97 && toe[0] > 1.97, "{heel:?} {toe:?}");
    let sole = heel[1] + (1.97 - heel[0]) / (toe[0] - heel[0]) * (toe[1] - heel[1]);
    let above = number(sentence, "the left foot came down across an edge", "cm above its sole");
    assert!((above - 100.0 * (0.08 - sole)).abs() <= 0.5, "{above} cm, {sole} m: {sentence}");
}

/// On ground that is uneven by more than the walker bears, a push that carries the XcoM out of reach still is the cause.
#[test]
fn a_push_on_uneven_ground_is_the_cause() {
    let uneven = ["ground.unevenness_m=0.02", "pushes=[]", "duration_s=8"];
    assert_eq!(common::run("walk-uneven", &uneven).outcome, Outcome::Completed);
    let run = common::run("push-walking", &["ground.unevenness_m=0.02", "pushes.0.force_n=900"]);
    assert_eq!(diagnosis(&run).cause, FirstCause::Push, "{:?}", run.reason);
}

/// The force with which a foot is unloaded is planned; only one at the setting's limit is told as a limit.
#[test]
fn a_foot_that_is_unloaded_is_not_at_its_force_limit() {
    let run = common::run("push-walking", &["pushes.0.force_n=650", "pushes.0.start_s=5.1"]);
    assert!(!run.reason.expect("it falls").contains("force limit"));
    let limits = run.limits;
    let unloading = (0..run.log.len()).any(|i| {
        let active = limits.iter().zip(run.log.get(i, Field::ActiveLimit));
        active.into_iter().any(|(limit, side)| matches!(limit.kind, LimitKind::Force { .. }) && *side != 0.0)
    });
    assert!(unloading, "the program's bound is active");
}

#[test]
fn the_slide_on_ice_is_that_of_the_log() {
    let run = common::run("walk", &["ground.friction=0.3", "ground.known=false"]);
    let sentence = &diagnosis(&run).sentence;
    let slid = number(sentence, "right foot slid", "m from");
    let from = number(sentence, "m from", "s on");
    let foot = column(&run, "foot.right_foot_x");
    let swing = column(&run, "swing");
    // Until the end of the step of the left foot, through which the right one should stand.
    let begin = (from / 0.001).round() as usize;
    let end = (begin..swing.len()).find(|&i| swing[i] != 1.0).expect("the step's end");
    let moved = foot[begin..end].windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum::<f64>();
    assert!(slid > 0.05 && slid < 1.2 * moved, "{slid} of {moved}: {sentence}");
    assert!(sentence.contains("(friction 0.3, assumed to be 0.85)"), "{sentence}");
    // While it slid, the simulator's ground gave all the friction that it has.
    let (tangential, normal) = (column(&run, "grf_simulated.right_foot_x"), column(&run, "grf_simulated.right_foot_z"));
    let slides: Vec<usize> = (begin..end - 1).filter(|&i| (foot[i + 1] - foot[i]).abs() > 1e-4).collect();
    assert!(slides.len() > 50, "{}", slides.len());
    for i in slides {
        assert!(tangential[i].abs() > 0.299 * normal[i], "{} of {} N at {i}", tangential[i], normal[i]);
    }
}

#[test]
fn a_fall_by_definition_alone_is_unexplained() {
    let run = common::run("waypoints", &["fall.min_com_height_fraction=0.99"]);
    let found = diagnosis(&run);
    assert_eq!(found.cause, FirstCause::Unexplained, "{}", found.sentence);
    assert!(found.sentence.contains("no rule explains it"), "{}", found.sentence);
}

#[test]
fn every_label_is_another_and_each_has_a_scenario() {
    let mut labels = FirstCause::LABELS.map(|(label, _)| label).to_vec();
    assert!(labels.iter().all(|label| label.chars().all(|c| c.is_ascii_lowercase() || c == '-')));
    let shown: Vec<&str> = KNOWN
        .iter()
        .chain(&KNOWN_FEET)
        .map(|known| known.2)
        // Those have robots of their own: tests/joint_limits.rs, tests/own_robots.rs.
        .chain(["joint-limit", "speed-limit", "loose-joint", "unexplained"])
        .collect();
    assert!(labels.iter().all(|label| shown.contains(label)), "{labels:?}");
    labels.sort_unstable();
    labels.dedup();
    assert_eq!(labels.len(), FirstCause::LABELS.len());
    assert_eq!(FirstCause::Push.label(), "push");
    assert_eq!(FirstCause::Unexplained.title(), "unexplained");
    let joint = FirstCause::JointLimit { joint: "left_hip".into() };
    assert_eq!(
        (joint.label(), joint.title(), joint.part()),
        ("joint-limit", "end of a joint's range", Some("left_hip"))
    );
}

/// The sentences in docs/diagnosis.md are those of the commands above them.
#[test]
fn the_examples_in_the_document_were_produced() {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/diagnosis.md"));
    let text =
        text.expect("docs/diagnosis.md").replace("```sh\nlegwork run", "`legwork run").replace("\n```\n\n", "`\n\n");
    let mut count = 0;
    for example in text.split("\n`legwork run ").skip(1) {
        let (command, rest) = example.split_once('`').expect("a command's end");
        let quoted = rest.lines().skip_while(|line| !line.starts_with('>')).take_while(|line| line.starts_with('>'));
        let quoted: Vec<&str> = quoted.map(|line| line[1..].trim()).collect();
        let mut words = command.split(' ').filter(|word| *word != "--set");
        let name = words.next().expect("a scenario");
        let run = common::run(name, &words.collect::<Vec<_>>());
        let found = diagnosis(&run);
        assert_eq!(found.sentence, quoted.join(" "), "{command}");
        if let Some((_, label)) = rest.split_once("(`").filter(|(before, _)| before.trim().is_empty()) {
            assert!(label.starts_with(&format!("{}`)", found.cause.label())), "{command}: {label}");
        }
        count += 1;
    }
    assert!(count > 10, "{count}");
}

#[test]
fn a_foot_in_the_air_was_said_to_be_at_its_force_limit() {
    let run = common::run("push", &["pushes.0.force_n=1500"]);
    let reason = run.reason.expect("it falls");
    assert!(!reason.contains("force"), "{reason}");
    let mut active = 0;
    for i in 0..run.log.len() {
        // A point that rises stands for the controller as long as it is about where it was.
        let heights = run.log.get(i, Field::Feet).chunks(2).map(|point| point[1]);
        let stands: Vec<bool> = heights.map(|height| height <= run.scenario.controller.lift_height_m + 1e-3).collect();
        let limits = run.limits.iter().zip(run.log.get(i, Field::ActiveLimit));
        for (limit, _) in limits.filter(|(_, side)| **side != 0.0) {
            active += 1;
            assert!(limit.kind.contact().is_none_or(|contact| stands[contact]), "{:?} at {i}", limit.kind);
        }
    }
    assert!(active > 100, "{active}");
}

mod random {
    use legwork::settings::{SETTINGS, Valid};
    use proptest::prelude::*;

    use super::{check_form, episode, library, scenario_file};

    /// Settings that make falls, each drawn from the whole of its range.
    fn assignment(index: usize, share: f64) -> Option<String> {
        let begins =
            ["controller.", "ground.", "pushes.", "reference.step", "reference.walker", "simulation.contact", "fall."];
        let settings: Vec<_> =
            SETTINGS.iter().filter(|setting| begins.iter().any(|begin| setting.path.starts_with(begin))).collect();
        let setting = settings[index % settings.len()];
        let path = setting.path.replace(".N.", ".0.");
        match setting.valid {
            _ if path.ends_with("period_s") => None,
            Valid::Number { min, max } => Some(format!("{path}={:e}", min + (max - min) * share * share * share)),
            Valid::OneOf(choices) => Some(format!("{path}={}", choices[(share * choices.len() as f64) as usize])),
            Valid::Bool => Some(format!("{path}={}", share < 0.5)),
            _ => None,
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 60, max_shrink_iters: 20, ..ProptestConfig::default() })]

        #[test]
        fn every_fall_has_a_diagnosis(
            name in prop::sample::select(vec!["walk", "push", "push-support", "push-replan", "feet-walk", "stand-push"]),
            draws in prop::collection::vec((0..1000_usize, 0.0..1.0f64), 1..6),
        ) {
            let mut sets: Vec<String> = draws.iter().filter_map(|&(index, share)| assignment(index, share)).collect();
            sets.push("duration_s=1.5".into());
            let Ok(loaded) = scenario_file::load(name, &sets) else { return Ok(()) };
            let model = library::load_model(&loaded.scenario.model, None).expect("a built-in model");
            let Ok(run) = episode::run(&loaded.scenario, &model, &[], |_| false) else { return Ok(()) };
            let fell = matches!(run.outcome, episode::Outcome::Fell(_));
            prop_assert_eq!(fell, run.diagnosis.is_some());
            if let Some(diagnosis) = &run.diagnosis {
                check_form(&run, diagnosis);
            }
        }
    }
}
