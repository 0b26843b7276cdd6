//! The whole report: that it is complete, well formed, harmless, and the same each time.

use legwork::episode::{self, Episode, Parts, Run};
use legwork::library;
use legwork::metrics::{MeanPeak, Metrics};
use legwork::recording::Replay;
use legwork::scenario::Scenario;
use legwork_thesis::published;

use super::stick::{Poses, Side, View};
use super::*;
use crate::charts::tests::assert_readable;

/// `ticks` ticks of a built-in scenario with `sets`, under a name of its own where one is given.
fn run_for(ticks: usize, scenario: &str, sets: &[&str], name: Option<&str>) -> Run {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    let mut scenario: Scenario = scenario_file::load(scenario, &sets).expect("a built-in scenario").scenario;
    if let Some(name) = name {
        scenario.name = name.to_owned();
    }
    let model = library::load_model(&scenario.model, None).expect("a built-in model");
    let mut episode = Episode::new(&scenario, &model, &[]).expect("a valid scenario");
    for _ in 0..ticks {
        if !episode.advance().expect("nothing that could fail") {
            break;
        }
    }
    episode.finish(0.125).expect("nothing that could fail")
}

fn fallen() -> Run {
    let run = run_for(4000, "push", &["ground.friction=0.1", "controller.limits.torque_nm=100"], None);
    assert!(matches!(run.outcome, Outcome::Fell(_)), "the ice is slippery");
    run
}

/// Checks that tags are balanced and attributes quoted, and that what XML reserves is escaped.
pub(crate) fn assert_well_formed(text: &str, void: &[&str]) {
    let mut open: Vec<String> = Vec::new();
    let mut rest = text;
    while let Some(at) = rest.find('<') {
        let (before, tag) = rest.split_at(at);
        assert!(!before.contains('>') || open.last().is_some_and(|name| raw(name)), "a stray > in {before:.80}");
        if let Some(after) = tag.strip_prefix("<!--") {
            rest = &after[after.find("-->").expect("a comment ends") + 3..];
            continue;
        }
        if open.last().is_some_and(|name| raw(name)) && !tag.starts_with("</") {
            rest = &tag[1..];
            continue;
        }
        let end = tag.find('>').expect("a tag ends");
        let inside = &tag[1..end];
        assert_eq!(inside.matches('"').count() % 2, 0, "{inside}");
        rest = &tag[end + 1..];
        let name = inside.trim_start_matches('/').split([' ', '\n']).next().unwrap_or("").to_owned();
        if inside.starts_with('/') {
            assert_eq!(open.pop().as_ref(), Some(&name), "{inside}");
        } else if !inside.starts_with(['!', '?']) && !inside.ends_with('/') && !void.contains(&name.as_str()) {
            open.push(name);
        }
    }
    assert!(open.is_empty(), "{open:?} never end");
}

/// Elements whose content is not markup.
fn raw(name: &str) -> bool {
    ["script", "style"].contains(&name)
}

const VOID: [&str; 3] = ["meta", "link", "input"];

/// The page without what the script reads and without the times.
fn words(page: &str) -> String {
    let mut kept = String::new();
    for (k, part) in page.split("<!-- timing -->").enumerate() {
        kept += if k == 0 { part } else { part.split_once("<!-- /timing -->").expect("it is closed").1 };
    }
    kept
}

#[test]
fn the_same_run_gives_the_same_bytes_save_the_times() {
    let mut runs = [run_for(700, "push", &[], None), run_for(700, "push", &[], None)];
    runs[1].timing.wall_s = 99.0;
    let pages = runs.each_ref().map(|run| html(std::slice::from_ref(run)));
    assert_ne!(pages[0], pages[1]);
    assert_eq!(words(&pages[0]), words(&pages[1]));
    assert_eq!(plots(&runs[0]), plots(&runs[1]));
}

#[test]
fn a_run_of_any_length_gives_well_formed_numbers() {
    for ticks in [0, 1, 2, 3, 17] {
        let run = run_for(ticks, "push", &[], None);
        assert_eq!(run.log.len(), ticks);
        for (name, text) in plots(&run) {
            assert_well_formed(&text, &[]);
            assert!(!text.contains("NaN") && !text.contains("inf"), "{name} after {ticks} ticks");
        }
        let page = html(&[run]);
        assert_well_formed(&page, &VOID);
        for nonsense in ["NaN", "inf ", "Infinity", "not a number"] {
            let drawn = page.split("<script>").next().unwrap_or("");
            assert!(!drawn.contains(nonsense), "{nonsense} after {ticks} ticks");
        }
        assert_eq!(page.contains("class=\"animation\""), ticks > 0);
    }
}

/// A run of `scenario` on the states of another run: a physics that tells no forces.
fn replayed(scenario: &str, sets: &[&str]) -> Run {
    let states = run_for(30, "stand", &[], None);
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    let scenario = scenario_file::load(scenario, &sets).expect("a built-in scenario").scenario;
    let parts = Parts { plant: Some(Box::new(Replay::of(&states.log).expect("records"))), ..Parts::default() };
    episode::run_with(&scenario, &states.model, parts, |time| time > 0.03).expect("it runs")
}

#[test]
fn a_run_tells_and_draws_what_its_controller_and_its_physics_give() {
    let hold = ["controller.kind=hold", "pushes=[{force_n=50.0, start_s=0.01, duration_s=0.1}]"];
    let runs = [run_for(30, "stand", &hold, None), replayed("stand", &[]), replayed("stand", &hold)];
    let [held, without_physics, without_both] = &runs;
    let page = html(std::slice::from_ref(held));
    assert_well_formed(&page, &VOID);
    assert!(page.contains("The forces are those of the physics, one on each contact point"));
    assert!(page.contains("They are those of the simulator."));
    for word in ["CoM reference", "foot reference", "Quadratic programs", "Limits and slack", "A step is taken"] {
        assert!(!words(&page).contains(word), "{word}");
    }
    let page = html(std::slice::from_ref(without_physics));
    assert_well_formed(&page, &VOID);
    assert!(page.contains("The forces are those of the program") && page.contains("They are those of the program."));
    assert!(page.contains("CoM reference") && page.contains("Limits and slack") && page.contains("keeps no books"));
    let page = html(std::slice::from_ref(without_both));
    assert_well_formed(&page, &VOID);
    for word in ["Ground reaction forces", "friction cone", "force on the robot", "NaN"] {
        assert!(!words(&page).contains(word), "{word}");
    }
    assert!(runs.iter().all(|run| plots(run).len() >= 6));
}

#[test]
fn a_page_without_runs_is_a_page() {
    assert_well_formed(&html(&[]), &VOID);
}

#[test]
fn nothing_is_loaded() {
    let page = html(&[run_for(300, "walk", &[], None)]);
    let namespaces = ["http://www.w3.org/2000/svg"];
    let links =
        page.match_indices("http").filter(|(at, _)| !namespaces.iter().any(|known| page[*at..].starts_with(known)));
    let links: Vec<&str> =
        links.map(|(at, _)| &page[at..at + 20]).filter(|link| !link.starts_with("http-equiv")).collect();
    assert!(links.is_empty(), "{links:?}");
    assert!(!page.contains("src=") && !page.contains("@import") && !page.contains("url("));
}

#[test]
fn a_fall_cannot_be_missed() {
    let run = fallen();
    let sentence = run.reason.clone().expect("it fell");
    let page = html(&[run_for(50, "stand", &[], None), run]);
    assert!(page.contains(&format!("<strong>The robot </strong>{sentence}.")), "{sentence}");
    assert_eq!(page.matches("class=\"banner bad\"").count(), 1, "of two runs, one fell");
    assert!(page.contains("badge bad") && page.contains(">fell</text>"));
    assert_well_formed(&page, &VOID);
}

#[test]
fn a_broken_bound_is_shown() {
    let mut run = run_for(50, "stand", &[], None);
    assert!(!html(std::slice::from_ref(&run)).contains("broke its own bounds"));
    run.audit.as_mut().expect("our simulator").penetration_m = 0.02;
    let violation = run.violations().pop().expect("2 cm is too deep");
    let page = html(&[run]);
    assert!(page.contains("broke its own bounds") && page.contains(&violation));
}

#[test]
fn names_are_escaped() {
    let name = "<script>alert('1')</script> & \"more\"";
    let run = run_for(600, "push", &[], Some(name));
    let files = plots(&run);
    let page = html(&[run]);
    assert_eq!(page.matches("<script>").count(), 1, "only our own");
    assert!(page.contains("&lt;script&gt;alert"));
    assert_well_formed(&page, &VOID);
    for (file, text) in files {
        assert!(file.chars().all(|c| c.is_ascii_alphanumeric() || "-_.".contains(c)), "{file}");
        assert_well_formed(&text, &[]);
    }
}

#[test]
fn the_data_of_the_animation_cannot_end_its_element() {
    let mut run = run_for(400, "walk", &[], None);
    run.model.feet[0] = "right</script><b>".into();
    assert_well_formed(&html(&[run]), &VOID);
}

#[test]
fn the_table_holds_published_and_measured_figures() {
    let mut run = run_for(100, "push", &[], None);
    run.metrics = Metrics { recovery_time_s: Some(4.41), ..run.metrics };
    run.metrics.com_error_m = Some(MeanPeak { mean: 0.234, peak: 0.5 });
    let page = html(std::slice::from_ref(&run));
    for row in published::compare("push", &run.metrics) {
        if let Some(value) = row.published.or(row.measured) {
            assert!(page.contains(row.label), "{}", row.label);
            assert!(value >= 1e4 || row.published.is_none() || page.contains(&format!("<td>{value}</td>")), "{value}");
        }
    }
    for cell in ["<td>0.36</td>", "0.234", "\u{2212}35 %", "<td>4.2</td>", "4.41", "+5.0 %", "2.8\u{b7}10\u{2074}"] {
        assert!(page.contains(cell), "{cell}");
    }
    assert!(!page.contains("differs from the thesis's experiment"));
    let other = html(&[run_for(100, "push", &["pushes.0.force_n=300"], None)]);
    assert!(other.contains("differs from the thesis's experiment in 1 setting;"));
}

#[test]
fn every_figure_is_in_the_page_and_in_a_file() {
    let run = run_for(900, "push", &[], None);
    let files: Vec<String> = plots(&run).into_iter().map(|(name, _)| name).collect();
    let figures = ["poses", "tracking-x", "tracking-z", "balance", "capture", "torques", "forces", "torso", "limits"];
    assert_eq!(files, figures.map(|figure| format!("push-{figure}.svg")));
    let page = html(&[run]);
    assert_eq!(page.matches("<svg class=\"figure wide\"").count(), figures.len());
    assert_eq!(page.matches("<svg class=\"figure narrow\"").count(), figures.len());
    assert_eq!(page.matches("role=\"img\" aria-label=\"").count(), 2 * figures.len() + 1, "and the stage");
    for anchor in page.split("href=\"#").skip(1) {
        let id = anchor.split('"').next().unwrap_or("");
        assert!(page.contains(&format!("id=\"{id}\"")), "{id}");
    }
}

#[test]
fn a_page_stays_small() {
    let run = run_for(6500, "push", &[], None);
    let size = html(&[run]).len();
    assert!(size < 700_000, "{size} bytes");
}

#[test]
fn a_long_run_has_a_bounded_number_of_frames() {
    let sets = ["duration_s=40.0", "controller.period_s=0.002", "simulation.period_s=0.002"];
    let page = html(&[run_for(20_000, "stand", &sets, None)]);
    let data =
        page.split("application/json\">").nth(1).and_then(|rest| rest.split("</script>").next()).expect("the data");
    let data: serde_json::Value = serde_json::from_str(data).expect("JSON");
    let frames = data["frames"].as_array().expect("a list");
    let period = data["period"].as_f64().expect("a number");
    assert!(frames.len() <= 6000 && (frames.len() as f64 * period - 40.0).abs() < 2.0 * period);
    let points = data["points"].as_u64().expect("a number") as usize;
    assert!(frames.iter().all(|frame| frame.as_array().is_some_and(|row| row.len() == 2 * points + 10 + 4 + 1)));
}

/// A robot in space, pushed to its left after 20 ms.
fn pushed_aside() -> Run {
    run_for(60, "exo-sway", &["pushes=[{force_n=200.0, heading_deg=90.0, start_s=0.02, duration_s=0.1}]"], None)
}

#[test]
fn a_push_to_the_side_is_called_so_and_drawn_from_the_front() {
    let run = pushed_aside();
    let page = html(std::slice::from_ref(&run));
    assert!(page.contains("<b>200 N to the left</b>") && !page.contains("forward</b>"));
    let mut poses = Poses::new(&run);
    let pose = poses.at(50);
    let [[_, sideways, _], _] = pose.pushes[0].expect("it acts");
    assert!((sideways - 200.0).abs() < 1e-9);
    let arrow = |side: Side| {
        let view = View::new(&mut Poses::new(&run), side, 300.0);
        let drawn = view.draw(&pose, &poses.skeleton, &run.model).into_string();
        let path =
            drawn.split("class=\"arrow push\" d=\"").nth(1).and_then(|rest| rest.split('"').next()).expect("a path");
        path.to_owned()
    };
    assert_eq!(arrow(Side::Right), "", "it goes away from who stands at the right");
    assert!(arrow(Side::Front).starts_with('M'));
}

#[test]
fn a_robot_in_space_is_seen_from_two_sides_and_plotted_sideways() {
    let run = pushed_aside();
    let page = html(std::slice::from_ref(&run));
    assert_eq!(page.matches("class=\"figure stage\"").count(), 2);
    assert_eq!(html(&[run_for(60, "push", &[], None)]).matches("class=\"figure stage\"").count(), 1);
    let figures = figures::figures(&run);
    let of = |name: &str| figures.iter().find(|figure| figure.name == name).expect("it is drawn").draw(WIDE);
    let sideways = of("tracking-y").description;
    for line in ["CoM ", "CoM reference ", "XcoM ", "right foot ", "left foot ", "base of support "] {
        assert!(sideways.contains(line), "{line}: {sideways}");
    }
    assert!(of("forces").description.contains("to the left [N] over time [s]: right foot, simulated"));
    assert!(of("poses").content.into_string().contains(">from the front<"));
}

#[test]
fn captions_are_those_of_the_generator() {
    let of_steps = ["A step is taken when", "Steps to a stop", " steps</span>"];
    let page = html(&[pushed_aside()]);
    assert!(page.contains("The feet stay where they stand"));
    assert!(of_steps.iter().all(|words| !page.contains(words)), "it only stands");
    let page = html(&[run_for(60, "walk", &[], None)]);
    assert!(of_steps.iter().all(|words| page.contains(words)));
    let page = html(&[run_for(60, "feet-walk", &[], None)]);
    assert!(page.contains("Each step is planned from where the XcoM is") && !page.contains(of_steps[0]));
}

#[test]
fn forces_are_those_of_something() {
    let of = |run: &Run| figures::figures(run).into_iter().find(|figure| figure.name == "forces").expect("one").caption;
    let feet = of(&run_for(1200, "feet-walk", &[], None));
    assert!(feet.contains("the force of a whole foot, of all its contact points together"), "{feet}");
    assert!(feet.contains("the largest force on one contact point is"), "{feet}");
    assert!(!of(&run_for(1200, "walk", &[], None)).contains("contact point"));
    assert!(html(&[run_for(60, "stand", &[], None)]).contains("force on a contact point"));
}

#[test]
fn charts_of_runs_are_readable_at_any_width() {
    for run in [fallen(), run_for(2500, "feet-walk", &[], None), pushed_aside(), run_for(3, "walk", &[], None)] {
        for figure in figures::figures(&run).iter().filter(|figure| figure.name != "poses") {
            for width in [NARROW, 640.0, WIDE] {
                assert_readable(&format!("{}, {} at {width}", run.scenario.name, figure.name), &figure.draw(width));
            }
        }
    }
}
