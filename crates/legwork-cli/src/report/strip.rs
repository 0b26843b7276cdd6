//! Poses side by side. Thesis Figure 6.3

use legwork::contact::GroundPlane;
use legwork::episode::Run;
use legwork_rbd::Model;
use maud::html;

use super::scale::{Px, round_step};
use super::stick::{Planar, Pose, Poses, Skeleton, View, keys};
use super::svg::{self, Drawing, Key};

/// How many poses are shown.
const POSES: usize = 8;
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
    model: Model,
    ground: GroundPlane,
    view: View,
    height: f64,
    keys: Vec<Key>,
}

impl Strip {
    /// The poses of `run` between which the points of the skeleton move equally far, first and last among them.
    pub(super) fn new(run: &Run) -> Self {
        let mut reader = Poses::new(run);
        let (view, height) = (View::new(&mut reader, 1.0), reader.height());
        let stride = run.log.len().div_ceil(LOOKED_AT).max(1);
        let last = run.log.len().saturating_sub(1);
        let mut records: Vec<usize> = (0..run.log.len()).step_by(stride).collect();
        if records.last().is_some_and(|&record| record != last) {
            records.push(last);
        }
        let mut way = vec![0.0; records.len()];
        let mut before: Option<Pose> = None;
        for (k, &record) in records.iter().enumerate() {
            let pose = reader.at(record);
            if let Some(before) = &before {
                // A robot at rest still shows poses, at equal times.
                way[k] = way[k - 1] + distance(before, &pose) + 1e-3 * (pose.time - before.time);
            }
            before = Some(pose);
        }
        let mut chosen: Vec<usize> = (0..POSES)
            .filter_map(|k| {
                let target = way.last()? * k as f64 / (POSES - 1) as f64;
                Some(records[way.iter().position(|&way| way >= target).unwrap_or(records.len() - 1)])
            })
            .collect();
        chosen.dedup();
        Self {
            poses: chosen.into_iter().map(|record| reader.at(record)).collect(),
            skeleton: reader.skeleton,
            model: run.model.clone(),
            ground: reader.ground,
            view,
            height,
            keys: keys(run),
        }
    }

    /// Draws it `width` wide [px].
    pub(super) fn draw(&self, width: f64) -> Drawing {
        let columns = if width > 600.0 { 4 } else { 2 };
        let across = (width + GAP) / columns as f64 - GAP;
        // A robot with its legs apart is wider than high, with its forces somewhat higher than itself.
        let scale = across / (1.3 * self.height);
        let view = View { scale, ..self.view.clone() };
        let (above, metres) = (1.12 * self.height * scale + 14.0, across / scale);
        let down = above + FOOT;
        let (legend, top) = svg::legend(&self.keys, 4.0, width);
        let content = html! {
            (legend)
            @for (index, pose) in self.poses.iter().enumerate() {
                @let middle = middle(pose);
                @let ground = self.ground.height_at(middle);
                @let corner = [middle - 0.5 * metres, middle + 0.5 * metres];
                @let [left, base] = view.pixel([corner[0], ground]);
                @let place = [(index % columns) as f64 * (across + GAP), top + GAP + (index / columns) as f64 * (down + GAP)];
                svg x=(Px(place[0])) y=(Px(place[1])) width=(Px(across)) height=(Px(down))
                    viewBox={ (Px(left)) " " (Px(base - above)) " " (Px(across)) " " (Px(down)) } {
                    (view.ground(&self.ground, corner, round_step(metres, 5), 10.0 * FOOT))
                    (view.draw(pose, &self.skeleton, &self.model))
                    text class="moment" x=(Px(left + 4.0)) y=(Px(base - above + 14.0)) { (format!("{:.2} s", pose.time)) }
                }
            }
        };
        let rows = self.poses.len().div_ceil(columns) as f64;
        let times: Vec<String> = self.poses.iter().map(|pose| format!("{:.2}", pose.time)).collect();
        Drawing {
            width,
            height: top + GAP + rows * (down + GAP),
            description: format!("Stick figures of the robot at {} s.", times.join(", ")),
            time_axis: None,
            content,
        }
    }
}

/// The way of all points between two poses [m].
fn distance(a: &Pose, b: &Pose) -> f64 {
    a.points.iter().zip(&b.points).map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1])).sum()
}

/// Between the outermost points of the robot [m].
fn middle(pose: &Pose) -> f64 {
    let x = |point: &Planar| point[0];
    super::scale::extent(pose.points.iter().map(x)).map_or(0.0, |(low, high)| 0.5 * (low + high))
}
