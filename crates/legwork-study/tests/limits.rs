//! Limits, robustness and sizing: the search on functions whose answer is known, and each result again by hand.

use std::sync::atomic::{AtomicUsize, Ordering};

use legwork_study::limits::{self, Held, Question};
use legwork_study::robustness::{Plan, Robustness, stride};
use legwork_study::search::{Attempt, Found, Search};
use legwork_study::sizing::{Coping, Sizing, SpeedTorque, Use};
use legwork_study::{Base, Change, rollout};
use toml::Value;

fn base(name: &str, sets: &[&str]) -> Base {
    Base::load(name, &sets.iter().map(|&set| set.to_owned()).collect::<Vec<_>>()).expect("it is built in")
}

/// Searches where `holds` says what holds under which nudge, and checks the count of the tries.
fn search(search: Search, holds: impl Fn(f64, u32) -> bool + Sync) -> Found {
    let calls = AtomicUsize::new(0);
    let attempt = |value: f64, nudge: u32| {
        calls.fetch_add(1, Ordering::Relaxed);
        let failure = (!holds(value, nudge)).then(|| format!("{value} under {nudge}"));
        Some(Attempt { failure, force_n: Some(1000.0 * value), ..Attempt::default() })
    };
    let found = search.run(attempt).expect("nothing stops it");
    assert_eq!(found.rollouts, calls.into_inner());
    found
}

fn on_threads<T: Send>(threads: usize, job: impl FnOnce() -> T + Send) -> T {
    legwork_study::parallel::with_threads(Some(threads), job).expect("threads")
}

#[test]
fn an_edge_is_found_to_the_resolution_from_either_side() {
    for edge in [0.003, 0.2501, 0.4999, 0.73, 0.998] {
        let up = search(Search::new(0.0, 1.0, 2), |value, _| value < edge);
        let (value, fails) = (up.value.unwrap(), up.first_failure.unwrap());
        assert!(value < edge && fails >= edge && (fails - value - 0.005).abs() < 1e-9, "{edge}: {value}, {fails}");
        assert_eq!(up.furthest_held, up.value);
        assert_eq!(up.force_n, up.value.map(|value| 1000.0 * value), "the largest of what held, not of what failed");
        assert_eq!(up.reason_beyond, Some(format!("{fails} under 0")));
        // A scan of 25, at most 4 bisections and 5 confirmations with 3 tries each, at most every second value of 200
        assert!(up.rollouts <= 25 + 3 * (4 + 5) + 100, "{edge}: {}", up.rollouts);

        let down = search(Search::new(3.0, 2.0, 2), |value, _| value > 3.0 - edge);
        let (value, fails) = (down.value.unwrap(), down.first_failure.unwrap());
        assert!(value > 3.0 - edge && fails <= 3.0 - edge && (value - fails - 0.005).abs() < 1e-9, "{value}, {fails}");
    }
}

#[test]
fn a_limit_rests_on_what_was_tried_up_to_its_first_failure() {
    let broken_from = |from: f64| {
        let attempt = |value: f64, _| {
            let failure = (value >= 0.5).then(|| "fell".to_owned());
            let violations = (value >= from).then(|| format!("at {value}"));
            Some(Attempt { failure, violations, ..Attempt::default() })
        };
        Search::new(0.0, 1.0, 2).run(attempt).expect("nothing stops it")
    };
    // Further falls may break what they like; what fails first may not, nor what held.
    assert_eq!(broken_from(0.505).violations, None);
    assert_eq!(broken_from(0.5).violations.as_deref(), Some("at 0.5"));
    let found = broken_from(0.2);
    assert_eq!((found.value, found.violations.as_deref()), (Some(0.495), Some("at 0.5")));
    assert!(found.tried.iter().all(|trial| trial.violations.is_some() == (trial.value >= 0.2)));
}

#[test]
fn an_island_beyond_is_luck_and_no_limit() {
    let found = search(Search::new(0.0, 1.0, 2), |value, _| value < 0.4 || (0.6..0.7).contains(&value));
    assert_eq!((found.value, found.first_failure), (Some(0.395), Some(0.4)));
    assert!(found.furthest_held.is_some_and(|value| (0.6..0.7).contains(&value)), "{found:?}");
}

#[test]
fn a_hole_on_the_way_is_the_limit_where_a_scan_steps_over_it() {
    // Two steps of the grid wide, between two values of the scan, and far from the edge that bisection finds first
    let holds = |value: f64, _| value < 0.9 && !(0.34..0.35).contains(&value);
    let found = search(Search::new(0.0, 1.0, 2), holds);
    assert_eq!((found.value, found.first_failure), (Some(0.335), Some(0.34)));
    assert!(found.furthest_held.is_some_and(|value| value > 0.89));
    // One step wide, but a near neighbour of the limit: 0.01 of 0.9 are two steps
    let found = search(Search::new(0.0, 1.0, 0), |value, _| value < 0.9 && (value - 0.875).abs() > 1e-9);
    assert_eq!((found.value, found.first_failure), (Some(0.87), Some(0.875)));
}

#[test]
fn a_value_that_only_holds_without_a_nudge_is_not_confirmed() {
    let found = search(Search::new(0.0, 1.0, 2), |value, nudge| value < if nudge == 2 { 0.45 } else { 0.5 });
    assert_eq!((found.value, found.first_failure), (Some(0.445), Some(0.45)));
    assert_eq!(found.reason_beyond.as_deref(), Some("0.45 under 2"));
    let quick = search(Search::new(0.0, 1.0, 2).quick(), |value, nudge| value < if nudge == 2 { 0.45 } else { 0.5 });
    assert_eq!((quick.value, quick.first_failure), (Some(0.475), Some(0.5)));
}

#[test]
fn where_all_holds_the_limit_is_at_least_the_end_and_where_nothing_does_there_is_none() {
    let all = search(Search::new(1.0, 0.0, 2), |_, _| true);
    assert_eq!((all.value, all.first_failure, all.furthest_held), (Some(0.0), None, Some(0.0)));
    let none = search(Search::new(1.0, 0.0, 2), |_, _| false);
    assert_eq!((none.value, none.first_failure, none.furthest_held), (None, Some(1.0), None));
    assert_eq!(none.rollouts, 25, "there is nothing to search after the scan");
    let late = search(Search::new(0.0, 1.0, 2), |value, _| value > 0.5);
    assert_eq!((late.value, late.first_failure, late.furthest_held), (None, Some(0.0), Some(1.0)));
}

#[test]
fn a_search_is_the_same_on_any_number_of_threads_and_can_be_stopped() {
    // Neither monotone nor smooth
    let holds = |value: f64, nudge: u32| !((1e4 * value * value) as u64 + u64::from(nudge)).is_multiple_of(97);
    let [one, two] = [1, 2].map(|threads| on_threads(threads, || search(Search::new(0.3, 1.0, 2), holds)));
    assert!(one.value.is_some() && one.first_failure.is_some());
    assert_eq!(one, two);
    let calls = AtomicUsize::new(0);
    let stopped =
        Search::new(0.0, 1.0, 2).run(|_, _| (calls.fetch_add(1, Ordering::Relaxed) < 30).then_some(Attempt::default()));
    assert_eq!(stopped, None);
}

/// A search that steps over the hole from 159 to 168 Ns finds 180 Ns.
#[test]
fn the_largest_push_of_push_support_survives_and_the_next_does_not() {
    let base = base("push-support", &[]);
    let mut questions = limits::of_push(&base).expect("it has a push");
    let question = &mut questions[0];
    question.search = Search { nudges: 2, ..question.search.quick() };
    let [answer, again] = [1, 2].map(|threads| on_threads(threads, || question.answer(|| false).expect("an answer")));
    assert_eq!(answer, again);
    assert_eq!((answer.question.as_str(), answer.unit), ("largest push forward", "Ns"));
    let (value, fails) = (answer.found.value.unwrap(), answer.found.first_failure.unwrap());
    assert!((140.0..165.0).contains(&value) && (fails - value - 5.0).abs() < 1e-9, "{value}, {fails}");

    // By hand: impulse over duration is the force.
    let survives = |impulse: f64, com: f64| {
        let force = Change::To(Value::Float(impulse / 0.2));
        let com = Change::To(Value::Float(base.variant().scenario.start.com_x_m + com));
        let variant = base.vary([("pushes.0.force_n", &force), ("start.com_x_m", &com)]).expect("it is valid");
        rollout::run(&variant, || false).expect("nothing stops it").survived()
    };
    assert!([-0.001, 0.0, 0.001].iter().all(|&nudge| survives(value, nudge)));
    assert!(![-0.001, 0.0, 0.001].iter().all(|&nudge| survives(fails, nudge)));
    assert!(
        answer.found.tried.iter().all(|trial| trial.nudged || trial.failure.is_none() == survives(trial.value, 0.0))
    );
    assert_eq!(question.answer(|| true), None);
}

#[test]
fn a_scenario_that_falls_as_it_stands_has_no_limit() {
    let base = base("push", &["controller.limits.torque_nm=30", "duration_s=1.5"]);
    let mut questions = limits::of_push(&base).expect("it has a push");
    let question = questions.iter_mut().find(|question| question.label == "lowest torque limit").expect("it is asked");
    question.search = question.search.quick();
    let found = question.answer(|| false).expect("an answer").found;
    assert_eq!((found.value, found.first_failure), (None, Some(30.0)));
    assert!(found.reason_beyond.is_some_and(|reason| reason.starts_with("fell at ")));
}

#[test]
fn questions_that_make_no_sense_are_refused() {
    let (walk, push) = (base("walk", &[]), base("push", &[]));
    let words = limits::of_push(&walk).expect_err("it has none").to_string();
    assert!(words.starts_with("walk: pushes: found no push"), "{words}");
    let words = limits::of_walk(&push).expect_err("it stands").to_string();
    assert!(words.starts_with("push: reference.com.trajectory: found a scenario that does not walk"), "{words}");
    let ask = |path, to| Question::new(&walk, "a", (path, 0.85, to), Vec::new(), Held::OnItsFeet).map(drop);
    assert!(ask("ground.frction", 0.1).expect_err("no such path").to_string().contains("ground.friction"));
    assert!(ask("ground.friction", -1.0).is_err() && ask("ground.friction", 0.85).is_err());
    assert!(ask("ground.friction", 0.1).is_ok());
    // Without friction there is no lower one.
    let ice = base("push", &["ground.friction=0"]);
    assert!(limits::of_push(&ice).expect("it has a push").iter().all(|question| question.label != "lowest friction"));
}

/// The walk lags so far behind at 1.5 m/s that it keeps neither speed nor reference, but it does not fall.
#[test]
fn what_is_held_is_more_than_not_falling() {
    let base = base("walk", &["duration_s=4", "reference.com.speed_mps=1.5"]);
    let rollout = rollout::run(base.variant(), || false).expect("nothing stops it");
    assert_eq!(Held::OnItsFeet.failure(base.variant(), &rollout), None);
    let speed = limits::figure(&rollout, "mean_speed_mps").expect("it moved");
    let words = Held::KeepsSpeed(0.05).failure(base.variant(), &rollout).expect("it is too slow");
    assert_eq!(words, format!("{speed:.3} m/s on average where 1.500 m/s was asked for"));
    assert_eq!(Held::KeepsSpeed(1.0 - speed / 1.5 + 1e-9).failure(base.variant(), &rollout), None);
    let error = limits::figure(&rollout, "com_error_m.mean").expect("it is long enough");
    assert!(Held::Follows(error * 0.999).failure(base.variant(), &rollout).is_some());
    assert_eq!(Held::Follows(error).failure(base.variant(), &rollout), None);
}

#[test]
fn the_stride_is_that_of_the_log_and_each_cell_of_the_map_can_be_run_again() {
    let (walk, stand) = (base("walk", &[]), base("push", &[]));
    let run = rollout::simulate(walk.variant(), || false).expect("it can run");
    // By another route: the times at which the column of the swinging foot turns to the right foot's number
    let swing = run.log.columns().iter().position(|column| column.name == "swing").expect("it is logged");
    let feet: Vec<f64> = run.log.column(swing).collect();
    let begin = |foot: f64| -> Vec<f64> {
        let begins = |i: &usize| feet[*i] == foot && feet[*i - 1] != foot && run.log.time(*i) >= 3.0;
        (1..feet.len()).filter(begins).map(|i| run.log.time(i)).take(2).collect()
    };
    let first = if begin(0.0)[0] < begin(1.0)[0] { begin(0.0) } else { begin(1.0) };
    let found = stride(&run.log, 3.0).expect("it walks");
    assert!((found.start_s - first[0]).abs() < 1e-9 && (found.period_s - (first[1] - first[0])).abs() < 1e-9);
    assert_eq!(stride(&run.log, 7.9), None);

    let mut plan = Plan::new(2, 1);
    plan.search = Search { parts: 5, neighbours: 0, ..plan.search.quick() };
    let map = Robustness::new(&walk, &stand, plan, || false).expect("it can run");
    assert_eq!((map.stride, map.cells()), (Some(found), 4));
    let cells: Vec<_> = (0..4).map(|index| map.answer(index, || false).expect("nothing stops it")).collect();
    let of = |phase: Option<f64>| cells.iter().filter(|cell| cell.phase == phase).collect::<Vec<_>>();
    assert_eq!((of(None).len(), of(Some(0.0)).len()), (2, 2));
    for cell in cells {
        let base = if cell.phase.is_some() { &walk } else { &stand };
        assert_eq!(cell.scenario, base.name());
        let survives = |impulse: f64| {
            let variant = map.struck(base.variant(), impulse, cell.direction_deg, cell.start_s);
            let [push] = &variant.scenario.pushes[..] else { panic!("one push") };
            assert!((push.force_n * push.duration_s / variant.model.total_mass() - impulse).abs() < 1e-9);
            assert_eq!(variant.scenario.duration_s, cell.start_s + 0.2 + 4.0);
            rollout::run(&variant, || false).expect("nothing stops it").survived()
        };
        let (value, fails) = (cell.found.value.unwrap(), cell.found.first_failure.unwrap());
        assert!(value >= 0.5 && fails <= 4.0 && survives(value) && !survives(fails), "{value}, {fails}");
    }
}

#[test]
fn a_robot_that_does_not_walk_is_only_struck_standing() {
    let map = Robustness::new(&base("stand", &[]), &base("stand", &[]), Plan::new(3, 5), || false).expect("it can run");
    assert_eq!((map.stride, map.cells()), (None, 3));
}

#[test]
fn the_demands_and_clouds_are_those_of_the_log() {
    let run = rollout::simulate(base("push", &["duration_s=2"]).variant(), || false).expect("it can run");
    let used = Use::of(&run);
    assert_eq!(used.joints.len(), 4);
    for (demand, cloud) in used.joints.iter().zip(&used.clouds) {
        let column = |name: &str| -> Vec<f64> {
            let name = format!("{name}.{}", demand.joint);
            let index = run.log.columns().iter().position(|column| column.name == name).expect("it is logged");
            run.log.column(index).collect()
        };
        let (torque, speed, asked) = (column("torque_applied"), column("v"), column("torque"));
        let ticks = torque.len() as f64;
        let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / ticks;
        let power = || torque.iter().zip(&speed).map(|(t, v)| (t * v).abs());
        let close = |a: f64, b: f64| assert!((a - b).abs() <= 1e-9 * b.abs(), "{a} {b}");
        close(demand.torque_peak_nm, torque.iter().fold(0.0, |peak, t| t.abs().max(peak)));
        close(demand.torque_rms_nm, mean(&mut torque.iter().map(|t| t * t)).sqrt());
        close(demand.speed_peak_radps, speed.iter().fold(0.0, |peak, v| v.abs().max(peak)));
        close(demand.power_peak_w, power().fold(0.0, f64::max));
        close(demand.power_mean_w, mean(&mut power()));
        let at_limit = asked.iter().filter(|t| t.abs() > 219.999).count();
        assert!(at_limit > 0);
        close(demand.at_limit, at_limit as f64 / ticks);

        // Each tick is in one bin, and in the right one.
        let total: u32 = cloud.ticks.iter().flatten().sum();
        assert_eq!(total as usize, torque.len());
        let (rows, columns) = (&cloud.torque_edges_nm, &cloud.speed_edges_radps);
        assert_eq!((rows[0], *columns.last().unwrap()), (-demand.torque_peak_nm, demand.speed_peak_radps));
        let inside = |bounds: &[f64], value: f64| bounds[0] + 1e-9 < value && value < bounds[1] - 1e-9;
        for (row, bin) in (0..24).map(|i| (i, 23 - i)) {
            let at_least = torque.iter().zip(&speed);
            let at_least = at_least.filter(|(t, v)| inside(&rows[row..], **t) && inside(&columns[bin..], **v)).count();
            let counted = cloud.ticks[row][bin] as usize;
            assert!(counted >= at_least && counted <= at_least + 5, "{counted} {at_least}");
        }
    }
}

#[test]
fn the_envelope_is_the_largest_of_each_figure_and_the_margin_multiplies_it() {
    let uses: Vec<Use> = ["walk", "push"]
        .iter()
        .map(|name| Use::of(&rollout::simulate(base(name, &["duration_s=1"]).variant(), || false).expect("it can run")))
        .collect();
    let sizing = Sizing::new(uses, 0.25);
    let [walk, push] = &sizing.uses[..] else { panic!("two") };
    let mut both_lead = [false; 2];
    for (index, (largest, required)) in sizing.envelope.iter().zip(&sizing.required).enumerate() {
        let (a, b) = (&walk.joints[index], &push.joints[index]);
        assert_eq!((&largest.joint, &required.joint), (&a.joint, &b.joint));
        both_lead = [both_lead[0] || a.power_mean_w > b.power_mean_w, both_lead[1] || a.power_mean_w < b.power_mean_w];
        assert_eq!(largest.power_mean_w, a.power_mean_w.max(b.power_mean_w));
        assert_eq!(largest.torque_rms_nm, a.torque_rms_nm.max(b.torque_rms_nm));
        assert_eq!(largest.at_limit, a.at_limit.max(b.at_limit));
        assert_eq!(required.speed_peak_radps, 1.25 * largest.speed_peak_radps);
        assert_eq!(required.at_limit, largest.at_limit);
    }
    assert_eq!(both_lead, [true; 2], "the scenarios must differ for this test to tell");
}

#[test]
fn the_map_has_a_cell_for_each_pair_and_tells_how_the_robot_copes() {
    let base = base("walk", &["duration_s=4"]);
    let map = SpeedTorque::new(&base, 2, 2).expect("all are valid");
    assert_eq!((&map.speeds_mps[..], &map.torques_nm[..]), (&[0.1, 1.3][..], &[110.0, 330.0][..]));
    let cells: Vec<_> = (0..map.cells()).map(|index| map.answer(index, || false).expect("an answer")).collect();
    let pairs: Vec<_> = cells.iter().map(|cell| (cell.speed_mps, cell.torque_limit_nm, cell.coping)).collect();
    let coping = [Coping::Falls, Coping::Falls, Coping::Follows, Coping::Survives];
    let expected = [(0.1, 110.0), (1.3, 110.0), (0.1, 330.0), (1.3, 330.0)];
    assert_eq!(pairs, std::array::from_fn::<_, 4, _>(|i| (expected[i].0, expected[i].1, coping[i])));
    assert!(cells[0].fell_at_s.is_some() && cells[0].reason.is_some() && cells[3].reason.is_none());
    // The fastest speeds that can be set bound the map.
    let fast = Base::load("walk", &["reference.com.speed_mps=4".to_owned()]).expect("it is valid");
    assert_eq!(SpeedTorque::new(&fast, 2, 1).expect("all are valid").speeds_mps, [0.8, 5.0]);
}
