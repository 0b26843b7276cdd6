//! Runs made of other parts than the scenario's: physics, controllers and sinks of one's own, replays, settings that change under way.

use legwork::channel::{Channel, Columns, Field, Record};
use legwork::contract::{Command, Sensed};
use legwork::control::Controller;
use legwork::diagnosis::FirstCause;
use legwork::episode::{self, Episode, KEPT_S, Outcome, Parts, Run};
use legwork::error::Error;
use legwork::rbd::Dynamics;
use legwork::recording::Replay;
use legwork::scenario_file::{self, Loaded};
use legwork::sim::audit::Audit;
use legwork::sim::{Health, Plant, Simulator};
use legwork::sink::{Hashes, Sink};
use legwork::start::start_pose;

fn load(name: &str, sets: &[&str]) -> Loaded {
    let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
    scenario_file::load(name, &sets).expect("a built-in scenario")
}

fn run_with(loaded: &Loaded, parts: Parts) -> Run {
    episode::run_with(&loaded.scenario, &loaded.model().expect("built in"), parts, |_| false).expect("it runs")
}

/// Our simulator, as somebody else's: it does not hand out its dynamics.
#[derive(Debug)]
struct Foreign(Simulator);

impl Plant for Foreign {
    fn read(&self, sensed: &mut Sensed) {
        self.0.read(sensed);
    }

    fn apply(&mut self, command: &Command, period: f64) -> Health {
        self.0.apply(command, period)
    }

    fn audit(&self) -> Option<&Audit> {
        Some(self.0.audit())
    }

    fn channels(&self) -> Vec<Channel> {
        self.0.channels()
    }

    fn record(&self, record: &mut Record<'_>) {
        self.0.record(record);
    }
}

#[test]
fn a_physics_without_dynamics_gives_the_same_bits() {
    for name in ["push", "feet-walk", "exo-lift"] {
        let loaded = load(name, &["duration_s=1"]);
        let (scenario, model) = (&loaded.scenario, loaded.model().expect("built in"));
        let q = start_pose(scenario, &model, &scenario.terrain(&model)).expect("a pose");
        let foreign = Foreign(scenario.simulator(&model, q.as_slice()).expect("valid pushes"));
        let other = run_with(&loaded, Parts { plant: Some(Box::new(foreign)), ..Parts::default() });
        assert_eq!(other.result_hash, run_with(&loaded, Parts::default()).result_hash, "{name}");
    }
}

/// What it takes is counted, and the last record kept.
#[derive(Debug, Default)]
struct Counted(std::sync::Arc<std::sync::Mutex<(usize, Option<Hashes>)>>);

impl Sink for Counted {
    fn record(&mut self, columns: &Columns, values: &[f64]) -> Result<(), Error> {
        assert_eq!(columns.width(), values.len());
        self.0.lock().expect("nobody panics with it").0 += 1;
        Ok(())
    }

    fn finish(&mut self, hashes: &Hashes) -> Result<(), Error> {
        self.0.lock().expect("nobody panics with it").1 = Some(*hashes);
        Ok(())
    }
}

#[test]
fn a_sink_takes_every_record_and_memory_keeps_the_latest() {
    let loaded = load("stand", &["duration_s=200", "controller.period_s=0.01", "simulation.period_s=0.01"]);
    let counted = Counted::default();
    let seen = std::sync::Arc::clone(&counted.0);
    let streamed = run_with(&loaded, Parts { sink: Some(Box::new(counted)), ..Parts::default() });
    let whole = run_with(&loaded, Parts::default());
    let (count, hashes) = *seen.lock().expect("nobody panics with it");
    assert_eq!((count, whole.log.len()), (20_000, 20_000));
    assert_eq!(streamed.result_hash, whole.result_hash);
    assert_eq!(hashes, Some(Hashes { input: whole.input_hash, result: whole.result_hash }));
    let kept = (KEPT_S / 0.01) as usize;
    assert!((kept..=kept + kept / 4).contains(&streamed.log.len()), "{}", streamed.log.len());
    let (a, b) = (&streamed.log, &whole.log);
    assert_eq!(a.record(a.len() - 1), b.record(b.len() - 1));
}

#[test]
fn a_late_fall_is_explained_in_the_same_words_wherever_the_records_go() {
    let push = "pushes=[{force_n=900.0, start_s=14.0, duration_s=0.2}]";
    let loaded = load("stand-push", &["duration_s=20", push]);
    let streamed = run_with(&loaded, Parts { sink: Some(Box::new(())), ..Parts::default() });
    let whole = run_with(&loaded, Parts::default());
    assert!(whole.log.time(0) < streamed.log.time(0), "the streamed run has forgotten its begin");
    let diagnosis = streamed.diagnosis.expect("it falls");
    assert_ne!(diagnosis.cause, FirstCause::Unexplained);
    assert_eq!(Some(diagnosis), whole.diagnosis);
}

#[derive(Debug)]
struct Full;

impl Sink for Full {
    fn record(&mut self, _columns: &Columns, _values: &[f64]) -> Result<(), Error> {
        Err(Error::Io { path: "there".into(), problem: "no space left".to_owned() })
    }
}

#[test]
fn a_sink_that_fails_ends_the_run_with_its_error() {
    let loaded = load("stand", &["duration_s=0.1"]);
    let parts = Parts { sink: Some(Box::new(Full)), ..Parts::default() };
    let run = episode::run_with(&loaded.scenario, &loaded.model().expect("built in"), parts, |_| false);
    assert!(run.expect_err("the sink is full").to_string().contains("no space left"));
}

#[test]
fn the_states_of_a_run_are_given_once_more_whatever_is_asked_for() {
    let walk = run_with(&load("walk", &["duration_s=1"]), Parts::default());
    let loaded = load("walk", &["duration_s=1", "controller.weights.grf=10"]);
    let replay = Replay::of(&walk.log).expect("records");
    let other = run_with(&loaded, Parts { plant: Some(Box::new(replay)), ..Parts::default() });
    assert_eq!(other.outcome, Outcome::Completed);
    for index in 0..walk.log.len() {
        for field in [Field::Time, Field::Q, Field::V, Field::Touching, Field::Com] {
            assert_eq!(other.log.get(index, field), walk.log.get(index, field), "{field:?} at {index}");
        }
    }
    // The torques are those of the other controller, ticked by hand.
    let model = loaded.model().expect("built in");
    let mut controller = loaded.scenario.momentum_controller(&model, &[], &walk.log.truth(0)).expect("the model fits");
    let mut dynamics = Dynamics::new(&model);
    for index in 0..walk.log.len() {
        let truth = walk.log.truth(index);
        dynamics.update(&model, &truth.q, &truth.v);
        assert_eq!(controller.tick(&truth, &dynamics).torque, other.log.get(index, Field::Torque), "tick {index}");
    }
    assert_ne!(other.log.get(500, Field::Torque), walk.log.get(500, Field::Torque));
}

#[test]
fn the_hold_stands_and_falls_of_a_push_with_a_reason() {
    let feet = run_with(&load("stand-push", &["controller.kind=hold", "pushes=[]", "duration_s=3"]), Parts::default());
    assert_eq!(feet.outcome, Outcome::Completed);
    let pushed = run_with(&load("push", &["controller.kind=hold"]), Parts::default());
    assert!(matches!(pushed.outcome, Outcome::Fell(_)), "it takes no step");
    assert!(pushed.reason.expect("a reason").starts_with("fell at"));
    assert!(feet.log.range(Field::ComReference).is_empty() && feet.tasks.is_empty() && feet.limits.is_empty());
}

#[test]
fn settings_change_under_way_or_say_why_not() {
    let loaded = load("stand", &["duration_s=0.4"]);
    let model = loaded.model().expect("built in");
    let run = |change: Option<(&str, &str)>| {
        let mut episode = Episode::new(&loaded.scenario, &model, &[]).expect("it can start");
        while episode.time() < 0.2 {
            episode.advance().expect("nothing that could fail");
        }
        if let Some((path, value)) = change {
            episode.set(path, value).expect("a setting that may change");
        }
        while episode.advance().expect("nothing that could fail") {}
        episode.finish(0.0).expect("nothing that could fail")
    };
    let plain = run(None);
    for (path, value) in [
        ("controller.limits.torque_nm", "40"),
        ("controller.planner.com_gain", "500"),
        ("controller.weights.torque", "1"),
        ("ground.friction", "0"),
        ("pushes", "[{force_n=100, start_s=0.25, duration_s=0.1}]"),
    ] {
        let changed = run(Some((path, value)));
        let differs = (0..plain.log.len()).find(|&i| changed.log.record(i) != plain.log.record(i));
        assert_eq!(differs, Some(200), "{path}");
        assert_ne!(changed.input_hash, plain.input_hash, "{path}");
    }
    let mut episode = Episode::new(&loaded.scenario, &model, &[]).expect("it can start");
    for (path, value, says) in [
        ("controller.form", "slack", "may not change while a run goes on"),
        ("seed", "3", "may not change while a run goes on"),
        ("simulation.sensors.delay_s", "0.1", "may not change while a run goes on"),
        ("controller.limits.torque_nm", "-1", "valid is a number"),
        ("controller.limits.torque_knm", "1", "did you mean"),
        ("controller.limits", "1", "a table"),
        ("reference.walker.speed_mps", "1", "has no effect with reference.generator"),
        ("pushes", "[{force_n=100, start_s=0, duration_s=0.1, at='nose'}]", "nose"),
    ] {
        let error = episode.set(path, value).expect_err(path).to_string();
        assert!(error.contains(says), "{path}: {error}");
    }
    while episode.advance().expect("nothing that could fail") {}
    let refused = episode.finish(0.0).expect("nothing that could fail");
    assert_eq!((refused.result_hash, refused.input_hash), (plain.result_hash, plain.input_hash));
}

/// A controller that gives channels as it is told to.
#[derive(Debug)]
struct Channels(Vec<Channel>, usize, Command);

impl Controller for Channels {
    fn tick(&mut self, _sensed: &Sensed, _dynamics: &Dynamics) -> &Command {
        &self.2
    }

    fn command(&self) -> &Command {
        &self.2
    }

    fn channels(&self) -> Vec<Channel> {
        self.0.clone()
    }

    fn record(&self, record: &mut Record<'_>) {
        record.set(Field::OfController, vec![7.0; self.1]);
    }
}

#[test]
fn channels_of_ones_own_are_logged_and_wrong_ones_are_told() {
    let loaded = load("stand", &["duration_s=0.01"]);
    let model = loaded.model().expect("built in");
    let run = |names: &[&str], values: usize| {
        let channels = Channel::all(Field::OfController, names.iter().map(|&name| (name, "V")));
        let controller = Channels(channels, values, Command { torque: vec![0.0; 4] });
        let parts = Parts { controller: Some(Box::new(controller)), ..Parts::default() };
        episode::run_with(&loaded.scenario, &model, parts, |_| false)
    };
    let log = run(&["battery", "bus"], 2).expect("two channels, two values").log;
    assert_eq!(log.get(3, Field::OfController), [7.0, 7.0]);
    assert_eq!(log.columns().last().map(|channel| channel.name.as_str()), Some("bus"));
    let error = run(&["battery", "q.right_knee"], 2).expect_err("a name twice").to_string();
    assert!(error.contains("two channels of the name 'q.right_knee'"), "{error}");
    let error = run(&["battery"], 2).expect_err("a value too many").to_string();
    assert!(error.contains("OfController"), "{error}");
}

#[test]
fn what_is_sensed_is_checked_and_no_state_holds_the_torques() {
    let loaded = load("stand", &[]);
    let (scenario, model) = (&loaded.scenario, loaded.model().expect("built in"));
    let q = start_pose(scenario, &model, &scenario.terrain(&model)).expect("a pose");
    let robot = scenario.simulator(&model, q.as_slice()).expect("no push");
    let mut sensed = Sensed::new(&model);
    robot.read(&mut sensed);
    assert!(sensed.check(&model).is_ok() && sensed.fits(&model));
    let mut controller = scenario.momentum_controller(&model, &[], &sensed).expect("the model fits");
    let torque = controller.tick(&sensed, robot.dynamics()).torque.clone();
    assert!(torque.iter().any(|torque| *torque != 0.0));
    type Spoil = fn(&mut Sensed);
    let wrong: [(&str, Spoil); 5] = [
        ("sensed.q", |sensed| sensed.q.truncate(1)),
        ("sensed.contacts", |sensed| sensed.contacts.clear()),
        ("v of right_knee", |sensed| sensed.v[3] = f64::NAN),
        ("load of", |sensed| sensed.contacts[0].load = f64::INFINITY),
        ("time", |sensed| sensed.time = f64::NAN),
    ];
    for (says, spoil) in wrong {
        let mut spoilt = sensed.clone();
        spoil(&mut spoilt);
        let error = spoilt.check(&model).expect_err(says).to_string();
        assert!(error.contains(says), "{error}");
        assert_eq!(controller.tick(&spoilt, robot.dynamics()).torque, torque, "{says}");
        assert!(controller.program().is_some_and(|program| program.solves == 0));
    }
}
