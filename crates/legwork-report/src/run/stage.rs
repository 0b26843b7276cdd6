//! The animated stick figure: its stage, its controls and the data that `animation.js` moves it with.

use legwork::episode::Run;
use legwork::log::Field;
use maud::{Markup, PreEscaped, html};
use serde::Serialize;

use super::figures::{plain, side};
use super::limits;
use super::stick::{Planar, Pose, Poses, Side, Spatial, View, translate};
use crate::charts::numbers::{Px, extent};
use crate::charts::svg;

/// Shortest time between two frames [s].
const PERIOD: f64 = 0.005;
/// Most frames, so that a long run stays a page that opens.
const MOST: usize = 6000;
/// The stage [px]; the page may cut off its sides.
const SIZE: [f64; 2] = [860.0, 400.0];
/// From the ground to the lower edge [px].
const FOOT: f64 = 46.0;

/// What the script reads. Lengths are in mm and forces in N, as whole numbers.
#[derive(Serialize)]
struct Data<'a> {
    /// Between two frames [s].
    period: f64,
    /// [px/m]
    scale: f64,
    metres_per_newton: f64,
    cone_length: f64,
    /// Rise of the ground along x and y.
    slopes: [f64; 2],
    /// Numbers of a place: x and z, or x, y and z.
    axes: usize,
    /// A stage for each side from which the robot is seen.
    stages: Vec<Stage>,
    points: usize,
    links: Vec<[usize; 2]>,
    joints: &'a [usize],
    contacts: &'a [usize],
    marks: usize,
    pushes: usize,
    /// What may be said of a frame.
    states: Vec<String>,
    /// Points, marks, CoM, forces, pushes (force and place), index of the state.
    frames: Vec<Vec<i64>>,
}

/// A side from which the robot is seen.
#[derive(Serialize)]
struct Stage {
    /// The axis that runs across it: 0 is x, 1 is y.
    across: usize,
    /// The edges of a friction cone.
    cone: [Planar; 2],
    /// Width of the stage and place of the ground in it [px].
    size: [f64; 2],
    /// What the robot covers [m].
    range: Planar,
}

/// The animation of `run`, hidden until the script shows it; nothing for a run without records.
pub(super) fn animation(run: &Run, id: &str) -> Markup {
    if run.log.is_empty() {
        return html! {};
    }
    let mut poses = Poses::new(run);
    let scale = (SIZE[1] - FOOT) / (1.17 * poses.height());
    let sides = poses.sides();
    let views: Vec<View> = sides.iter().map(|&side| View::new(&mut poses, side, scale.round())).collect();
    let stride =
        ((PERIOD / run.scenario.controller.period_s).round() as usize).max(run.log.len().div_ceil(MOST)).max(1);
    let records: Vec<usize> = (0..run.log.len()).step_by(stride).collect();
    let shown: Vec<Pose> = records.iter().map(|&record| poses.at(record)).collect();
    let width = SIZE[0] / sides.len() as f64;
    let stage = |view: &View| {
        let across = view.side as usize;
        let range = extent(shown.iter().flat_map(|pose| pose.points.iter().map(|point| point[across])));
        let range = range.map_or([0.0, 0.0], |(low, high)| [low, high]);
        Stage { across, cone: view.cone, size: [width, SIZE[1] - FOOT], range }
    };
    let axes = run.model.linear_axes().len();
    let mut states = Vec::new();
    let frames =
        records.iter().zip(&shown).map(|(&record, pose)| frame(pose, axes, state(run, record, &mut states))).collect();
    let data = Data {
        period: stride as f64 * run.scenario.controller.period_s,
        scale: scale.round(),
        metres_per_newton: views[0].metres_per_newton,
        cone_length: views[0].cone_length,
        slopes: poses.ground.base().steepness(),
        axes,
        stages: views.iter().map(stage).collect(),
        points: shown[0].points.len(),
        links: poses.skeleton.links.iter().map(|(ends, _)| *ends).collect(),
        joints: &poses.skeleton.joints,
        contacts: &poses.skeleton.contacts,
        marks: shown[0].marks.len(),
        pushes: run.scenario.pushes.len(),
        states,
        frames,
    };
    markup(run, id, &data, &views, &poses, &shown)
}

/// A stage with the first pose on it.
fn stage(run: &Run, stage: &Stage, view: &View, poses: &Poses<'_>, shown: &[Pose]) -> Markup {
    let first = &shown[0];
    let width = stage.size[0];
    let half = 0.5 * width / view.scale + 1.0;
    let floor = [stage.range[0] - half, stage.range[1] + half];
    // Numbers stay countable however far the robot went.
    let step =
        [0.5, 1.0, 5.0, 20.0, 100.0].into_iter().find(|step| (floor[1] - floor[0]) / step < 200.0).unwrap_or(1e3);
    let [x, y, _] = first.com;
    let [across, base] = view.pixel([x, y, poses.ground.height_at(x, if view.side == Side::Front { y } else { 0.0 })]);
    let camera = translate([0.5 * width - across, stage.size[1] - base]);
    html! {
        svg.figure.stage viewBox={ "0 0 " (Px(width)) " " (Px(SIZE[1])) } preserveAspectRatio="xMidYMid slice"
            role="img" aria-label={ "Stick figure of the robot, seen " (view.side.name()) ", at the time that the slider shows" } {
            g.world transform=(camera) {
                (view.ground(&poses.ground, x, floor, step, 10.0 * SIZE[1]))
                @for (class, d) in trails(view, poses, shown) { path class={ "trail " (class) } d=(d) {} }
                g.pose { (view.draw(first, &poses.skeleton, &run.model)) }
            }
        }
    }
}

fn markup(run: &Run, id: &str, data: &Data<'_>, views: &[View], poses: &Poses<'_>, shown: &[Pose]) -> Markup {
    let last = data.frames.len() - 1;
    html! {
        figure.animation id=(id) hidden tabindex="0" data-scenario=(run.scenario.name)
            aria-label={ "Animation of " (run.scenario.name) } {
            div.stages {
                @for (view, of) in views.iter().zip(&data.stages) { (stage(run, of, view, poses, shown)) }
            }
            div.controls {
                button.play type="button" aria-label="Play" { "\u{25b6}" }
                input.time type="range" min="0" max=(last) value="0" step="1" aria-label="Time";
                output.clock { "0.000 s" }
                label { "Speed "
                    select.speed {
                        @for (speed, label) in [("0.05", "1/20"), ("0.1", "1/10"), ("0.25", "1/4"), ("0.5", "1/2")] {
                            option value=(speed) { (label) }
                        }
                        option value="1" selected { "1" }
                        option value="2" { "2" }
                    }
                }
            }
            p.state { "\u{a0}" }
            figcaption {
                @if views.len() > 1 { "Seen from the robot's right side, and from the front, where its left is on the right. " }
                "Marks as in the poses below. Space plays and pauses, \u{2190} and \u{2192} move by a frame (with Shift by ten), Home and End to the ends. \
                 The vertical line in the charts below shows the time; a click there moves to it, \
                 and so does #" (run.scenario.name) "@1.50 at the end of this page's address."
            }
            script.frames type="application/json" { (PreEscaped(embedded(data))) }
        }
    }
}

/// The data in a form that cannot end the element that holds it.
fn embedded(data: &Data<'_>) -> String {
    serde_json::to_string(data).unwrap_or_default().replace('<', "\\u003c")
}

/// The ways of the feet and of the centre of mass.
fn trails(view: &View, poses: &Poses<'_>, shown: &[Pose]) -> Vec<(&'static str, String)> {
    let trail = |place: &dyn Fn(&Pose) -> Spatial| {
        let mut line: Vec<Planar> = Vec::new();
        for pose in shown {
            let pixel = view.pixel(place(pose));
            if line.last().is_none_or(|last| (last[0] - pixel[0]).hypot(last[1] - pixel[1]) > 3.0) {
                line.push(pixel);
            }
        }
        svg::path(&[line])
    };
    let feet = poses.skeleton.contacts.iter().zip(&poses.run.model.contacts);
    let feet = feet.map(|(&point, contact)| (side(&contact.name), trail(&|pose: &Pose| pose.points[point])));
    feet.chain([("", trail(&|pose: &Pose| pose.com))]).collect()
}

fn frame(pose: &Pose, axes: usize, state: usize) -> Vec<i64> {
    let whole = |value: f64| value.round().clamp(-1e9, 1e9) as i64;
    // In the plane nothing is said of y.
    let kept = |[x, y, z]: Spatial| if axes == 2 { vec![x, z] } else { vec![x, y, z] };
    let mm = |point: &Spatial| kept(*point).into_iter().map(|metres| whole(1e3 * metres)).collect::<Vec<_>>();
    let newtons = |force: Spatial| kept(force).into_iter().map(whole).collect::<Vec<_>>();
    let mut row: Vec<i64> = pose.points.iter().flat_map(mm).collect();
    row.extend(pose.marks.iter().flat_map(|(point, _)| mm(point)).chain(mm(&pose.com)));
    row.extend(pose.forces.iter().flat_map(|force| newtons(*force)));
    for push in &pose.pushes {
        let [force, at] = push.unwrap_or([[0.0; 3]; 2]);
        row.extend(newtons(force).into_iter().chain(mm(&at)));
    }
    row.push(state as i64);
    row
}

/// The place in `states` of what is to be said of record `index`.
fn state(run: &Run, index: usize, states: &mut Vec<String>) -> usize {
    let swings = |foot: usize| run.model.feet.get(foot).map(|foot| format!("{} swings", plain(foot)));
    let feet = match *run.log.get(index, Field::Swing) {
        [foot, ..] if foot >= 0.0 => swings(foot as usize),
        [_, ..] => Some("both feet stand".to_owned()),
        [] => None,
    };
    let limits: Vec<String> =
        limits::active(run, index).map(|(limit, _)| plain(&run.limits[limit].in_words(&run.model))).collect();
    let limits = (!limits.is_empty()).then(|| format!("at its limit: {}", limits.join(", ")));
    let text = feet.into_iter().chain(limits).collect::<Vec<_>>().join("; ");
    states.iter().position(|known| *known == text).unwrap_or_else(|| {
        states.push(text);
        states.len() - 1
    })
}
