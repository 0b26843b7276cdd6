//! Poses side by side. Thesis Figure 6.3

use legwork::Robot;
use legwork::episode::Run;
use legwork::scenario::Push;
use legwork::terrain::Terrain;
use maud::html;
use nalgebra::Vector3;

use super::stick::{Pose, Poses, Side, Skeleton, Spatial, View, keys};
use crate::charts::numbers::{Px, round_step};
use crate::charts::svg::{self, Drawing, Key};

/// How many poses are shown.
const POSES: usize = 10;
/// How many records are looked at to choose them.
const LOOKED_AT: usize = 2000;
/// Below the ground of a panel [px].
const FOOT: f64 = 26.0;
const GAP: f64 = 8.0;

/// The chosen poses with all that is needed to draw them.
#[derive(Debug)]
pub(super) struct Strip {
    poses: Vec<Pose>,
    skeleton: Skeleton,
    model: Robot,
    ground: Terrain,
    views: Vec<View>,
    height: f64,
    keys: Vec<Key>,
}

impl Strip {
    /// The poses of `run`, first and last among them.
    pub(super) fn new(run: &Run) -> Self {
        let mut reader = Poses::new(run);
        let views = reader.sides().iter().map(|&side| View::new(&mut reader, side, 1.0)).collect();
        let height = reader.height();
        let stride = run.log.len().div_ceil(LOOKED_AT).max(1);
        let last = run.log.len().saturating_sub(1);
        let mut records: Vec<usize> = (0..run.log.len()).step_by(stride).collect();
        if records.last().is_some_and(|&record| record != last) {
            records.push(last);
        }
        let poses: Vec<Pose> = records.into_iter().map(|record| reader.at(record)).collect();
        Self {
            poses: choose(&poses, &run.scenario.pushes),
            skeleton: reader.skeleton,
            model: run.model.clone(),
            ground: reader.ground,
            views,
            height,
            keys: keys(run),
        }
    }

    /// Draws it `width` wide [px].
    pub(super) fn draw(&self, width: f64) -> Drawing {
        let columns = if width > 600.0 { 5 } else { 2 };
        let across = (width + GAP) / columns as f64 - GAP;
        // A robot with its legs apart is wider than high, with its forces somewhat higher than itself.
        let scale = across / (1.05 * self.height);
        let views: Vec<View> = self.views.iter().map(|view| View { scale, ..view.clone() }).collect();
        let (above, metres) = (1.12 * self.height * scale + 14.0, across / scale);
        let (down, sides) = (above + FOOT, views.len() as f64);
        let (legend, top) = svg::legend(&self.keys, 4.0, width);
        let content = html! {
            (legend)
            @for (index, pose) in self.poses.iter().enumerate() {
                @for (row, view) in views.iter().enumerate() {
                    @let middle = middle(pose, view.side);
                    @let [below, aside] = if view.side == Side::Right { [middle, 0.0] } else { [pose.com[0], middle] };
                    @let ends = [middle - 0.5 * metres, middle + 0.5 * metres];
                    @let [left, base] = [view.scale * ends[0], -view.scale * self.ground.height_at(below, aside)];
                    @let upper = top + GAP + (index / columns) as f64 * (sides * down + GAP) + row as f64 * down;
                    svg x=(Px((index % columns) as f64 * (across + GAP))) y=(Px(upper)) width=(Px(across)) height=(Px(down))
                        viewBox={ (Px(left)) " " (Px(base - above)) " " (Px(across)) " " (Px(down)) } {
                        (view.ground(&self.ground, below, ends, round_step(metres, 5), 10.0 * FOOT))
                        (view.draw(pose, &self.skeleton, &self.model))
                        text class="moment" x=(Px(left + 4.0)) y=(Px(base - above + 14.0)) {
                            @if row == 0 { (format!("{:.2} s", pose.time)) } @else { (view.side.name()) }
                        }
                    }
                }
            }
        };
        let rows = self.poses.len().div_ceil(columns) as f64;
        let times: Vec<String> = self.poses.iter().map(|pose| format!("{:.2}", pose.time)).collect();
        Drawing {
            width,
            height: top + GAP + rows * (sides * down + GAP),
            description: format!("Stick figures of the robot at {} s.", times.join(", ")),
            time_axis: None,
            content,
        }
    }
}

/// The first pose, the last one, one in each push, and between them at about equal ways of all points the poses that are
/// most unlike the others: else a periodic gait would show the same pose again and again.
fn choose(poses: &[Pose], pushes: &[Push]) -> Vec<Pose> {
    let Some(last) = poses.len().checked_sub(1) else { return Vec::new() };
    let mut way = vec![0.0; poses.len()];
    for k in 1..poses.len() {
        // A robot at rest still shows poses, at equal times.
        way[k] = way[k - 1] + distance(&poses[k - 1], &poses[k], [0.0; 3]) + 1e-3 * (poses[k].time - poses[k - 1].time);
    }
    let pushed = |push: &Push| poses.iter().position(|pose| pose.time >= push.start_s + 0.5 * push.duration_s);
    let mut chosen: Vec<usize> = [0, last].into_iter().chain(pushes.iter().take(3).filter_map(pushed)).collect();
    let parts = POSES + 1 - chosen.len();
    let part = way[last] / parts as f64;
    for k in 1..parts {
        let off = |index: usize| (way[index] - part * k as f64).abs();
        let unlike =
            |index: usize| chosen.iter().map(|&other| shape_distance(&poses[index], &poses[other])).fold(9.0, f64::min);
        let score = |index: usize| (unlike(index) - 0.05 * off(index), index);
        let near = (0..poses.len()).filter(|&index| off(index) <= 0.4 * part).map(score);
        chosen.extend(near.reduce(|best, next| if next.0 > best.0 { next } else { best }).map(|best| best.1));
    }
    chosen.sort_unstable();
    chosen.dedup();
    chosen.into_iter().map(|index| poses[index].clone()).collect()
}

/// Sum of the distances of all points between two poses, the second moved by `shift` [m].
fn distance(a: &Pose, b: &Pose, shift: Spatial) -> f64 {
    let apart = |(a, b): (&Spatial, &Spatial)| Vector3::from([0, 1, 2].map(|k| a[k] - b[k] - shift[k])).norm();
    a.points.iter().zip(&b.points).map(apart).sum()
}

/// As seen from the centres of mass.
fn shape_distance(a: &Pose, b: &Pose) -> f64 {
    distance(a, b, [0, 1, 2].map(|k| a.com[k] - b.com[k]))
}

/// Between the outermost points of the robot, as seen from a side [m].
fn middle(pose: &Pose, side: Side) -> f64 {
    let across = |point: &Spatial| point[side as usize];
    crate::charts::numbers::extent(pose.points.iter().map(across)).map_or(0.0, |(low, high)| 0.5 * (low + high))
}
