//! The figures of a run, from its log. Thesis Figures 6.2, 6.4, H.1, H.2

use legwork::episode::{Outcome, Run};
use legwork::log::Field;
use legwork::scenario::GeneratorKind;

use super::balance::Balance;
use super::limits;
use super::stick::forces_of;
use super::strip::Strip;
use crate::charts::axis::{Axis, Quantity};
use crate::charts::chart::{Chart, Part, Stack};
use crate::charts::layer::Layer;
use crate::charts::numbers::{extent, number};
use crate::charts::svg::Drawing;

/// A figure with its words.
#[derive(Debug)]
pub(crate) struct Figure {
    /// Part of its file's name.
    pub(crate) name: &'static str,
    pub(crate) title: &'static str,
    pub(crate) caption: String,
    body: Body,
}

#[derive(Debug)]
enum Body {
    Chart(Chart),
    Strip(Box<Strip>),
}

impl Figure {
    /// Draws it `width` wide [px].
    pub(crate) fn draw(&self, width: f64) -> Drawing {
        match &self.body {
            Body::Chart(chart) => chart.draw(width),
            Body::Strip(strip) => strip.draw(width),
        }
    }
}

/// All figures of a run, in order.
pub(crate) fn figures(run: &Run) -> Vec<Figure> {
    let charts = Charts::new(run);
    let figure = |name, title, caption: &str, parts| {
        let body = Body::Chart(charts.over_time(parts));
        Figure { name, title, caption: caption.to_owned(), body }
    };
    let generator = run.scenario.reference.generator;
    let mut figures = vec![
        Figure { name: "poses", title: "Poses", caption: poses(run), body: Body::Strip(Box::new(Strip::new(run))) },
        figure("tracking-x", "Tracking along x", charts.words(generator), charts.tracking(0)),
    ];
    if charts.is_in_space() {
        let caption = "Places to the left of the robot are positive.";
        figures.push(figure("tracking-y", "Tracking sideways", caption, charts.tracking(1)));
    }
    let balance = Balance::new(run, &charts.times);
    let is_planned = run.log.has(Field::ComReference);
    figures.extend([
        figure(
            "tracking-z",
            "Tracking in the vertical",
            "Heights of the feet are those of the middles of their contact points.",
            charts.tracking_z(),
        ),
        figure(
            "balance",
            "Balance",
            "Places on the ground, seen from the centre of mass, along x. Where the forces of the ground act (CoP) and where the \
             change of momentum says that they must have acted (ZMP) is one point by two ways. Outside of the support, what the \
             planner wants is a fictitious ZMP, which no ground can give. The CMP lies off the CoP by what turns the robot. What \
             goes beyond the axis is cut off.",
            balance.points(),
        ),
    ]);
    if is_planned && generator != GeneratorKind::Stance {
        figures.push(figure(
            "capture",
            "Steps to a stop",
            "From where the XcoM can be brought to a stop without a step, with one, with two and with any number of them, by \
             a linear inverted pendulum with the feet, the longest step and the shortest step time of this robot.",
            balance.capture(),
        ));
    }
    figures.push(figure(
        "torques",
        "Joint torques",
        "Torques that the controller asks for, within their limits.",
        charts.torques(),
    ));
    if forces_of(run).is_some() {
        let (forces, note) = charts.forces();
        figures.push(figure("forces", "Ground reaction forces", &note, forces));
    }
    let words = "Counter-clockwise from upright: leaning forward is negative.";
    figures.push(figure("torso", "Torso angle", words, charts.torso()));
    if run.log.has(Field::ActiveLimit) {
        figures.push(figure(
            "limits",
            "Limits and slack",
            "Above, when a limit of the program was active, and in which share of the ticks: a mark above the line is an \
             upper limit, below it a lower one; those of a contact point count while it carries load. Below, what each task was \
             missed by.",
            limits::parts(run, &charts.times),
        ));
    }
    figures
}

/// The caption of the poses.
fn poses(run: &Run) -> String {
    let views = if run.model.is_planar() {
        ""
    } else {
        " Each moment is seen from the robot's right side and, below, from the front, where its left is on the right."
    };
    let forces = forces_of(run).map_or(String::new(), |(_, whose)| {
        format!(
            " The forces are those of the {whose}, one on each contact point, in the friction cones of those points."
        )
    });
    format!(
        "The robot at moments between which it moves about equally far, chosen to differ; the numbers on the ground are \
         metres.{views}{forces}"
    )
}

/// What a generator does with what the figure of the tracking shows.
fn tracking(generator: GeneratorKind) -> &'static str {
    match generator {
        GeneratorKind::Steps => {
            "A step is taken when the XcoM leaves the base of support by more than the delay allows."
        }
        GeneratorKind::Stance => {
            "The feet stay where they stand or come down where they were lifted; the centre of mass follows its plan."
        }
        GeneratorKind::Walker => {
            "Each step is planned from where the XcoM is, and adapted to it while the step is under way."
        }
    }
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

    fn is_in_space(&self) -> bool {
        self.dimension == 3
    }

    fn over_time(&self, mut parts: Vec<Part>) -> Chart {
        let end = self.times.last().map_or(0.0, |last| last + self.run.scenario.controller.period_s);
        let end = if self.times.len() > 1 { end } else { self.run.scenario.duration_s };
        let pushes = self.run.scenario.pushes.iter().filter(|push| push.start_s < end);
        let pushes: Vec<[f64; 2]> = pushes.map(|push| [push.start_s, push.start_s + push.duration_s]).collect();
        let bands = [("single", "single support", self.single_support()), ("push-band", "push", pushes)];
        let bands = bands.into_iter().filter(|(_, _, spans)| !spans.is_empty());
        let bands: Vec<Layer> = bands.map(|(class, label, spans)| Layer::Spans { class, label, spans }).collect();
        let fall = match &self.run.outcome {
            Outcome::Fell(fall) => Some(Layer::Upright { class: "fall", label: "fell".into(), x: fall.time.min(end) }),
            _ => None,
        };
        for part in &mut parts {
            part.layers.splice(0..0, bands.iter().cloned());
            part.layers.extend(fall.clone());
        }
        let x = Axis::exactly(Quantity::new("time", "s"), [0.0, end]);
        Chart { over_time: true, ..Chart::new(vec![Stack { title: String::new(), x, parts }], (0.0, 1)) }
    }

    /// What the generator does with what the figure of the tracking shows; nothing where there is none.
    fn words(&self, generator: GeneratorKind) -> &'static str {
        if self.run.log.has(Field::ComReference) { tracking(generator) } else { "" }
    }

    /// Values of the column at `offset` in `field`, times `factor`, as a line, where the log has them.
    fn line(&self, label: &str, class: &str, field: Field, offset: usize, factor: f64) -> Option<Layer> {
        let column = self.run.log.range(field).nth(offset)?;
        Some(line(label, class, &self.times, self.run.log.column(column).map(|value| factor * value)))
    }

    /// The foot that swings in a record.
    fn swinging(&self, index: usize) -> Option<usize> {
        self.run.log.get(index, Field::Swing).first().filter(|foot| **foot >= 0.0).map(|&foot| foot as usize)
    }

    /// Each swing by itself: one foot may follow the other without a pause.
    fn single_support(&self) -> Vec<[f64; 2]> {
        let period = self.run.scenario.controller.period_s;
        [0, 1]
            .into_iter()
            .flat_map(|foot| spans(&self.times, period, |index| self.swinging(index) == Some(foot)))
            .collect()
    }

    /// Place of each foot, and of its reference, along the linear axis `axis`.
    fn feet(&self, axis: usize) -> Vec<Layer> {
        let (d, log) = (self.dimension, &self.run.log);
        let mut lines = Vec::new();
        for (foot, name) in self.run.model.feet.iter().enumerate().take(2) {
            let (class, label) = (side(name), foot_name(name));
            let place = (0..log.len()).filter_map(|index| log.foot(index, foot).nth(axis));
            lines.push(line(&label, dashed(class), &self.times, place));
            let reference = format!("{label} reference");
            lines.extend(self.line(
                &reference,
                &format!("{class} dotted"),
                Field::FeetReference,
                3 * d * foot + axis,
                1.0,
            ));
        }
        lines
    }

    fn com(&self, axis: usize) -> Vec<Layer> {
        let com = self.line("CoM", "com", Field::Com, axis, 1.0);
        com.into_iter().chain(self.line("CoM reference", "reference dashed", Field::ComReference, axis, 1.0)).collect()
    }

    /// Along the linear axis `axis`, which is not the vertical one.
    fn tracking(&self, axis: usize) -> Vec<Part> {
        let points = self.base_of_support(axis);
        let mut layers = vec![Layer::Area { class: "support".into(), label: "base of support".into(), points }];
        layers.extend(self.feet(axis));
        layers.extend(self.line("XcoM", "xcom dash-dotted", Field::Xcom, axis, 1.0));
        layers.extend(self.com(axis));
        vec![part(["x", "y"][axis], "m", 290.0, 0.1, layers)]
    }

    /// Between the outermost contact points that touch the ground, while no foot swings.
    fn base_of_support(&self, axis: usize) -> Vec<[f64; 3]> {
        let log = &self.run.log;
        let base = |index: usize| {
            let points = log.get(index, Field::Feet).chunks_exact(self.dimension).map(|point| point[axis]);
            let touching = points.zip(log.get(index, Field::Touching)).filter(|(_, flag)| **flag > 0.5);
            let stands = self.swinging(index).is_none();
            extent(touching.map(|(x, _)| x)).filter(|_| stands).unwrap_or((f64::NAN, f64::NAN))
        };
        let point = |(index, &time): (usize, &f64)| [time, base(index).0, base(index).1];
        self.times.iter().enumerate().map(point).collect()
    }

    fn tracking_z(&self) -> Vec<Part> {
        let up = self.dimension - 1;
        vec![part("CoM: z", "m", 130.0, 0.01, self.com(up)), part("feet: z", "m", 170.0, 0.02, self.feet(up))]
    }

    /// A part for each pair of right and left joints.
    fn torques(&self) -> Vec<Part> {
        let (settings, model) = (&self.run.scenario.controller.limits, &self.run.model);
        let mut joints: Vec<(String, Vec<[usize; 2]>)> = Vec::new();
        for (index, dof) in model.actuated().enumerate() {
            let name = plain(without_side(&model.dofs[dof].name));
            match joints.iter_mut().find(|(known, _)| *known == name) {
                Some((_, members)) => members.push([index, dof]),
                None => joints.push((name, vec![[index, dof]])),
            }
        }
        let height = if joints.len() > 3 { 120.0 } else { 170.0 };
        let parts = joints.into_iter().map(|(name, members)| {
            let mut layers = Vec::new();
            let mut bounds: Vec<f64> = Vec::new();
            for [index, dof] in members {
                let dof = &model.dofs[dof];
                let (class, limit) = (side(&dof.name), settings.torque_nm.min(dof.effort_limit));
                let label = if class.is_empty() { "torque" } else { class };
                let log = &self.run.log;
                let differs = |(a, b): (f64, f64)| (a - b).abs() > 1e-6;
                let [asked, applied] = [Field::Torque, Field::TorqueApplied].map(|field| log.range(field).nth(index));
                if let (Some(asked), Some(applied)) = (asked, applied)
                    && log.column(asked).zip(log.column(applied)).any(differs)
                {
                    let label = format!("{label}, applied");
                    layers.extend(self.line(&label, &format!("{class} thin"), Field::TorqueApplied, index, 1.0));
                }
                layers.extend(self.line(label, dashed(class), Field::Torque, index, 1.0));
                if bounds.iter().all(|known| (known.abs() - limit).abs() > 1e-9) {
                    bounds.extend([-limit, limit]);
                }
            }
            layers.extend(bounds.iter().map(|&y| Layer::Level { class: "limit", label: "limit".into(), y }));
            part(&name, "Nm", height, 1.0, layers)
        });
        parts.collect()
    }

    /// Forces of the feet along each axis, and what they are.
    fn forces(&self) -> (Vec<Part>, String) {
        let (d, log, model) = (self.dimension, &self.run.log, &self.run.model);
        let of_foot = |field: Field, foot: usize, axis: usize| -> Vec<f64> {
            let columns: Vec<usize> = model.points_of(foot).map(|point| point * d + axis).collect();
            (0..log.len()).map(|i| columns.iter().map(|&column| log.get(i, field)[column]).sum()).collect()
        };
        let mut axes = vec![(d - 1, "vertical", 200.0), (0, "along x", 150.0)];
        axes.extend((d == 3).then_some((1, "to the left", 150.0)));
        let parts = axes.into_iter().map(|(axis, label, height)| {
            let feet = |field: Field| model.feet.iter().enumerate().filter(move |_| self.run.log.has(field));
            let simulated = feet(Field::GrfSimulated).map(|(foot, name)| {
                let class = format!("{} thin", side(name));
                line(
                    &format!("{}, simulated", foot_name(name)),
                    &class,
                    &self.times,
                    of_foot(Field::GrfSimulated, foot, axis),
                )
            });
            let asked = feet(Field::Grf).map(|(foot, name)| {
                line(&foot_name(name), dashed(side(name)), &self.times, of_foot(Field::Grf, foot, axis))
            });
            // Impacts of the simulator do not stretch the axis.
            let (simulated, asked): (Vec<Layer>, Vec<Layer>) = (simulated.collect(), asked.collect());
            let Part { y, .. } =
                part(label, "N", height, 100.0, if asked.is_empty() { &simulated } else { &asked }.clone());
            Part { y, height, layers: [simulated, asked].concat(), notes: Vec::new() }
        });
        let several = model.contacts.len() > model.feet.len();
        let whole =
            if several { "A line is the force of a whole foot, of all its contact points together. " } else { "" };
        let [peak, asked_peak] =
            [self.run.metrics.grf_simulated_n, self.run.metrics.grf_n].map(|force| force.unwrap_or_default().peak);
        let point = if several { " on one contact point" } else { "" };
        let cut = if peak > asked_peak {
            format!(" (the largest force{point} is {} N)", number(peak.round()))
        } else {
            String::new()
        };
        let lines = match (self.run.log.has(Field::Grf), self.run.log.has(Field::GrfSimulated)) {
            (true, true) => format!("Thick: in the program. Thin: in the simulator, whose impacts are cut off{cut}."),
            (true, false) => "They are those of the program.".to_owned(),
            (false, _) => "They are those of the simulator.".to_owned(),
        };
        (parts.collect(), format!("{whole}{lines}"))
    }

    fn torso(&self) -> Vec<Part> {
        let degrees = 1.0_f64.to_degrees();
        let torso = self.line("torso", "com", Field::Torso, 0, degrees);
        let reference = self.line("reference", "reference dashed", Field::TorsoReference, 0, degrees);
        vec![part("torso", "\u{b0}", 170.0, 1.0, torso.into_iter().chain(reference).collect())]
    }
}

/// A part whose axis covers `least` at the least.
pub(super) fn part(name: &str, unit: &str, height: f64, least: f64, layers: Vec<Layer>) -> Part {
    let Part { y, layers, .. } = Part::new(Quantity::new(name, unit), height, layers);
    Part { y: y.at_least(least), height, layers, notes: Vec::new() }
}

/// Values over the times of the records.
pub(super) fn line(label: &str, class: &str, times: &[f64], values: impl IntoIterator<Item = f64>) -> Layer {
    Layer::line(label, class, times.iter().zip(values).map(|(&time, value)| [time, value]).collect())
}

/// The class of a line of a side: that of the left is dashed, so that both are told apart where they meet.
pub(super) fn dashed(side: &'static str) -> &'static str {
    if side == "left" { "left dashed" } else { side }
}

/// The name of a foot as it is read, such as `right foot` for `right`.
pub(super) fn foot_name(name: &str) -> String {
    if ["right", "left"].contains(&name) { format!("{name} foot") } else { plain(name) }
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
