//! The figures of a run, from its log. Thesis Figures 6.2, 6.4, H.1, H.2

use legwork::episode::{Outcome, Run};
use legwork::log::Field;

use super::balance::Balance;
use super::chart::{Area, Band, Chart, Content, Panel, Series};
use super::limits;
use super::scale::{self, Axis};
use super::strip::Strip;
use super::svg::Drawing;

/// A figure with its words.
#[derive(Debug)]
pub(super) struct Figure {
    /// Part of its file's name.
    pub(super) name: &'static str,
    pub(super) title: &'static str,
    pub(super) caption: String,
    body: Body,
}

#[derive(Debug)]
enum Body {
    Chart(Chart),
    Strip(Box<Strip>),
}

impl Figure {
    /// Draws it `width` wide [px].
    pub(super) fn draw(&self, width: f64) -> Drawing {
        match &self.body {
            Body::Chart(chart) => chart.draw(width),
            Body::Strip(strip) => strip.draw(width),
        }
    }
}

/// All figures of a run, in order.
pub(super) fn figures(run: &Run) -> Vec<Figure> {
    let charts = Charts::new(run);
    let figure = |name, title, caption, panels| {
        let body = Body::Chart(charts.over_time(panels));
        Figure { name, title, caption, body }
    };
    let (forces, spikes) = charts.forces();
    let balance = Balance::new(run, &charts.times);
    vec![
        Figure {
            name: "poses",
            title: "Poses",
            caption: "The robot at moments between which it moves about equally far, chosen to differ; the numbers on the \
                ground are metres. The forces are those of the program, in the friction cones of the feet."
                .into(),
            body: Body::Strip(Box::new(Strip::new(run))),
        },
        figure(
            "tracking-x",
            "Tracking in x",
            "A step is taken when the XcoM leaves the base of support by more than the delay allows.".into(),
            charts.tracking_x(),
        ),
        figure(
            "tracking-z",
            "Tracking in the vertical",
            "The feet are read on the left axis, the centre of mass on the right one.".into(),
            charts.tracking_z(),
        ),
        figure(
            "balance",
            "Balance",
            "Places on the ground, seen from the centre of mass. Where the forces of the ground act (CoP) and where the change of \
             momentum says that they must have acted (ZMP) is one point by two ways. Outside of the support, what the planner \
             wants is a fictitious ZMP, which no ground can give. The CMP lies off the CoP by what turns the robot. What goes \
             beyond the axis is cut off."
                .into(),
            balance.points(),
        ),
        figure(
            "capture",
            "Steps to a stop",
            "From where the XcoM can be brought to a stop without a step, with one, with two and with any number of them, by \
             a linear inverted pendulum with the feet, the longest step and the shortest step time of this robot."
                .into(),
            balance.capture(),
        ),
        figure("torques", "Joint torques", "Torques that the program asks for, within their limits.".into(), charts.torques()),
        figure(
            "forces",
            "Ground reaction forces",
            format!("Thick: in the program. Thin: in the simulator, whose impacts are cut off{spikes}."),
            forces,
        ),
        figure("torso", "Torso angle", "Counter-clockwise from upright: leaning forward is negative.".into(), charts.torso()),
        figure(
            "limits",
            "Limits and slack",
            "Above, when a limit of the program was active, and in which share of the ticks: a mark above the line is an \
             upper limit, below it a lower one; those of a foot count while it carries load. Below, what each task was \
             missed by."
                .into(),
            limits::panels(run, &charts.times),
        ),
    ]
}

/// What the charts of a run share.
#[derive(Debug)]
struct Charts<'a> {
    run: &'a Run,
    times: Vec<f64>,
    /// Linear axes: two in the plane.
    dimension: usize,
}

impl<'a> Charts<'a> {
    fn new(run: &'a Run) -> Self {
        let times = (0..run.log.len()).map(|index| run.log.time(index)).collect();
        Self { run, times, dimension: run.model.linear_axes().len() }
    }

    fn over_time(&self, panels: Vec<Panel>) -> Chart {
        let fall = match &self.run.outcome {
            Outcome::Fell(fall) => Some(fall.time),
            _ => None,
        };
        let end = self.times.last().map_or(0.0, |last| last + self.run.scenario.controller.period_s);
        let end = if self.times.len() > 1 { end } else { self.run.scenario.duration_s };
        let mut bands = self.single_support();
        for push in &self.run.scenario.pushes {
            let span = [push.start_s, push.start_s + push.duration_s];
            if span[0] < end {
                bands.push(Band { span, class: "push-band", label: "push" });
            }
        }
        Chart { times: self.times.clone(), span: [0.0, end], bands, fall: fall.map(|time| time.min(end)), panels }
    }

    /// Values of the column at `offset` in `field`, times `factor`.
    fn values(&self, field: Field, offset: usize, factor: f64) -> Vec<f64> {
        let column = self.run.log.range(field).start + offset;
        self.run.log.column(column).map(|value| factor * value).collect()
    }

    /// Each swing by itself: one foot may follow the other without a pause.
    fn single_support(&self) -> Vec<Band> {
        let swings = self.values(Field::Swing, 0, 1.0);
        let period = self.run.scenario.controller.period_s;
        let of = |foot: f64| spans(&self.times, period, |index| (swings[index] - foot).abs() < 0.5);
        let spans = [0.0, 1.0].into_iter().flat_map(of);
        spans.map(|span| Band { span, class: "single", label: "single support" }).collect()
    }

    /// Position of a foot, and of its reference, along the linear axis `axis`.
    fn feet(&self, axis: usize) -> Vec<Series> {
        let d = self.dimension;
        let mut lines = Vec::new();
        for (foot, name) in self.run.model.feet.iter().enumerate().take(2) {
            let (class, label) = (side(name), plain(name));
            let reference = self.values(Field::FeetReference, 3 * d * foot + axis, 1.0);
            let log = &self.run.log;
            let position = (0..log.len()).filter_map(|index| log.foot(index, foot).nth(axis)).collect();
            lines.push(line(&label, class, position));
            lines.push(line(&format!("{label} reference"), &format!("{class} dotted"), reference));
        }
        lines
    }

    fn tracking_x(&self) -> Vec<Panel> {
        let mut series = self.feet(0);
        series.push(line("XcoM", "xcom dash-dotted", self.values(Field::Xcom, 0, 1.0)));
        series.push(line("CoM", "com", self.values(Field::Com, 0, 1.0)));
        series.push(line("CoM reference", "reference dashed", self.values(Field::ComReference, 0, 1.0)));
        let mut panel = panel("x [m]", 290.0, 0.1, series);
        if let Content::Lines { areas, .. } = &mut panel.content {
            *areas = vec![Area { label: "base of support", class: "support", pieces: self.base_of_support() }];
        }
        vec![panel]
    }

    /// Between the outermost contact points that touch the ground, while there are two or more.
    fn base_of_support(&self) -> Vec<Vec<[f64; 3]>> {
        let log = &self.run.log;
        let base = |index: usize| {
            let points = log.get(index, Field::Feet).chunks_exact(self.dimension).map(|point| point[0]);
            let touching = points.zip(log.get(index, Field::Touching)).filter(|(_, flag)| **flag > 0.5);
            let swings = log.get(index, Field::Swing)[0] >= 0.0;
            scale::extent(touching.map(|(x, _)| x)).filter(|_| !swings)
        };
        let mut pieces = vec![Vec::new()];
        for (index, &time) in self.times.iter().enumerate() {
            match base(index) {
                Some((low, high)) => pieces.last_mut().expect("there is always one").push([time, low, high]),
                None => pieces.push(Vec::new()),
            }
        }
        pieces.retain(|piece| piece.len() > 1);
        pieces
    }

    fn tracking_z(&self) -> Vec<Panel> {
        let up = self.dimension - 1;
        let mut panel = panel("feet: z [m]", 230.0, 0.02, self.feet(up));
        if let Content::Lines { left, right, series, .. } = &mut panel.content {
            *left = left.clone().rounded();
            let com = self.values(Field::Com, up, 1.0);
            let reference = self.values(Field::ComReference, up, 1.0);
            let values = com.iter().chain(&reference).copied();
            *right = Some(Axis::beside(left, "CoM: z [m]", values, 0.01));
            series.push(Series { right: true, ..line("CoM", "com", com) });
            series.push(Series { right: true, ..line("CoM reference", "reference dashed", reference) });
        }
        vec![panel]
    }

    /// A panel for each pair of right and left joints.
    fn torques(&self) -> Vec<Panel> {
        let (settings, model) = (&self.run.scenario.controller.limits, &self.run.model);
        let mut joints: Vec<(String, Vec<usize>)> = Vec::new();
        for (index, &dof) in self.run.layout.actuated.iter().enumerate() {
            let name = plain(without_side(&model.dofs[dof].name));
            match joints.iter_mut().find(|(known, _)| *known == name) {
                Some((_, members)) => members.push(index),
                None => joints.push((name, vec![index])),
            }
        }
        let panels = joints.into_iter().map(|(name, members)| {
            let mut series = Vec::new();
            let mut bounds: Vec<f64> = Vec::new();
            for index in members {
                let dof = &model.dofs[self.run.layout.actuated[index]];
                let (class, limit) = (side(&dof.name), settings.torque_nm.min(dof.effort_limit));
                let asked = self.values(Field::Torque, index, 1.0);
                let applied = self.values(Field::TorqueApplied, index, 1.0);
                let differs = asked.iter().zip(&applied).any(|(a, b)| (a - b).abs() > 1e-6);
                let label = if class.is_empty() { "torque".to_owned() } else { class.to_owned() };
                if differs {
                    series.push(line(&format!("{label}, applied"), &format!("{class} thin"), applied));
                }
                let dashed = if class == "left" { "left dashed" } else { class };
                series.push(line(&label, dashed, asked));
                if bounds.iter().all(|known| (known.abs() - limit).abs() > 1e-9) {
                    bounds.extend([-limit, limit]);
                }
            }
            let mut panel = panel(&format!("{name} [Nm]"), 170.0, 1.0, series);
            if let Content::Lines { left, series, limits, .. } = &mut panel.content {
                let values = series.iter().flat_map(|line| &line.values).chain(&bounds).copied();
                *left = Axis::around(left.label.clone(), values, 1.0, 6);
                *limits = bounds;
            }
            panel
        });
        panels.collect()
    }

    /// Vertical and horizontal forces of the feet, and a note on the simulator's peak.
    fn forces(&self) -> (Vec<Panel>, String) {
        let d = self.dimension;
        let log = &self.run.log;
        let foot_force = |field: Field, foot: usize, axis: usize| -> Vec<f64> {
            let contacts = self.run.model.contacts.iter().enumerate().filter(|(_, contact)| contact.foot == foot);
            let columns: Vec<usize> = contacts.map(|(contact, _)| contact * d + axis).collect();
            (0..log.len()).map(|i| columns.iter().map(|&column| log.get(i, field)[column]).sum()).collect()
        };
        let panels = [(d - 1, "vertical [N]", 200.0), (0, "horizontal [N]", 150.0)].map(|(axis, label, height)| {
            let feet = || self.run.model.feet.iter().enumerate();
            let simulated = feet().map(|(foot, name)| {
                let class = format!("{} thin", side(name));
                line(&format!("{}, simulated", plain(name)), &class, foot_force(Field::GrfSimulated, foot, axis))
            });
            let asked = feet().map(|(foot, name)| {
                let class = if side(name) == "left" { "left dashed" } else { side(name) };
                line(&plain(name), class, foot_force(Field::Grf, foot, axis))
            });
            let asked: Vec<Series> = asked.collect();
            let values = asked.iter().flat_map(|line| line.values.iter().copied());
            let left = Axis::around(label, values, 100.0, 6);
            let mut series: Vec<Series> = simulated.collect();
            series.extend(asked);
            Panel { height, content: lines(left, series) }
        });
        let peak = self.run.metrics.grf_simulated_n.peak;
        let cut = peak > self.run.metrics.grf_n.peak;
        (panels.into(), if cut { format!(" (their peak is {peak:.0} N)") } else { String::new() })
    }

    fn torso(&self) -> Vec<Panel> {
        let degrees = 1.0_f64.to_degrees();
        let series = vec![
            line("torso", "com", self.values(Field::Torso, 0, degrees)),
            line("reference", "reference dashed", self.values(Field::TorsoReference, 0, degrees)),
        ];
        vec![panel("torso [°]", 170.0, 1.0, series)]
    }
}

/// A panel of lines on one axis, which covers `least` at the least.
pub(super) fn panel(label: &str, height: f64, least: f64, series: Vec<Series>) -> Panel {
    let intervals = (height / 42.0) as usize;
    let left = Axis::around(label, series.iter().flat_map(|line| line.values.iter().copied()), least, intervals);
    Panel { height, content: lines(left, series) }
}

fn lines(left: Axis, series: Vec<Series>) -> Content {
    Content::Lines { left, right: None, series, areas: Vec::new(), limits: Vec::new(), note: String::new() }
}

pub(super) fn line(label: &str, class: &str, values: Vec<f64>) -> Series {
    Series { label: label.to_owned(), class: class.to_owned(), values, right: false }
}

/// The time spans [s] of the ticks for which `holds`, each `period` long.
pub(super) fn spans(times: &[f64], period: f64, holds: impl Fn(usize) -> bool) -> Vec<[f64; 2]> {
    let mut spans: Vec<[f64; 2]> = Vec::new();
    let mut open = false;
    for (index, &time) in times.iter().enumerate() {
        let now = holds(index);
        match spans.last_mut() {
            Some(span) if now && open => span[1] = time + period,
            _ if now => spans.push([time, time + period]),
            _ => {}
        }
        open = now;
    }
    spans
}

/// `right` or `left`, as a name begins or ends; nothing for others.
pub(super) fn side(name: &str) -> &'static str {
    ["right", "left"].into_iter().find(|side| name.starts_with(side) || name.ends_with(side)).unwrap_or("")
}

fn without_side(name: &str) -> &str {
    ["right_", "left_"].into_iter().find_map(|side| name.strip_prefix(side)).unwrap_or(name)
}

/// A name as it is read.
pub(super) fn plain(name: &str) -> String {
    name.replace('_', " ")
}
