//! What `<actuator>` drives, and how hard.

use std::collections::{HashMap, HashSet};

use super::compiler::named;
use super::defaults::{Defaults, Item};
use super::files::Tree;
use crate::error::ModelError;
use crate::words::list;
use crate::xml::Ignored;

/// The joints that are driven, by name.
#[derive(Default)]
pub(super) struct Actuators<'a> {
    /// The most that all actuators of a joint give together [Nm or N]; infinite where one has no limit.
    pub(super) efforts: HashMap<&'a str, f64>,
    /// Whether the file has any actuator.
    pub(super) any: bool,
}

const KEYS: &[&str] = &[
    "name",
    "class",
    "group",
    "nsample",
    "interp",
    "delay",
    "ctrlrange",
    "user",
    "ctrllimited",
    "forcelimited",
    "actlimited",
    "forcerange",
    "actrange",
    "lengthrange",
    "gear",
    "damping",
    "armature",
    "cranklength",
    "joint",
    "jointinparent",
    "tendon",
    "slidersite",
    "cranksite",
    "site",
    "refsite",
    "body",
    "actdim",
    "input",
    "velrange",
    "ffrange",
    "dyntype",
    "gaintype",
    "biastype",
    "dynprm",
    "gainprm",
    "biasprm",
    "actearly",
    "inheritrange",
    "kp",
    "kv",
    "dampratio",
    "timeconst",
    "posrange",
    "ki",
    "imax",
    "slewmax",
    "area",
    "diameter",
    "bias",
    "tausmooth",
    "range",
    "force",
    "scale",
    "lmin",
    "lmax",
    "vmax",
    "fpmax",
    "fvmax",
    "gain",
    "plugin",
    "instance",
];

impl<'a> Actuators<'a> {
    pub(super) fn read(
        tree: &Tree<'a>,
        defaults: &Defaults<'a>,
        joints: &HashSet<&str>,
        ignored: &mut Ignored,
        sentences: &mut Vec<String>,
    ) -> Result<Self, ModelError> {
        let mut actuators = Self::default();
        for section in tree.sections("actuator") {
            for element in tree.children(section) {
                let element = element.of(element.get("name").unwrap_or("actuator"));
                if element.name() != "dcmotor" {
                    ignored.note(&element, &["config"], KEYS);
                }
                actuators.any = true;
                let item = defaults.item(element, 0)?;
                let Some(joint) = element.get("joint").or(element.get("jointinparent")) else {
                    let sentence = "acts on no joint and is ignored: only motors of joints are read";
                    let actuator = named("actuator", element.get("name").unwrap_or_default());
                    sentences.push(format!("{}{actuator} {sentence}", tree.at(element)));
                    continue;
                };
                if !joints.contains(&joint) {
                    let mut valid: Vec<_> = joints.iter().collect();
                    valid.sort();
                    let problem = format!("unknown joint {joint:?}; valid are {}", list(valid));
                    return Err(element.invalid(problem));
                }
                if item.number("armature")?.is_some_and(|armature| armature != 0.0) {
                    let sentence = "its armature is ignored; give it to the joint";
                    sentences.push(format!("{}{}: {sentence}", tree.at(element), named("actuator of joint", joint)));
                }
                *actuators.efforts.entry(joint).or_insert(0.0) += effort(&item)?;
            }
        }
        Ok(actuators)
    }
}

/// The most that an actuator gives at its joint [Nm or N]: its gear times the least of its limits. One whose force is no
/// multiple of what it is told, such as a servo, has the limit of its force alone.
fn effort(item: &Item) -> Result<f64, ModelError> {
    let gear = item.part::<6>("gear")?;
    let gear = if gear.1 == 0 { 1.0 } else { gear.0[0] };
    let largest = |range: Option<[f64; 2]>| range.map_or(f64::INFINITY, |[lower, upper]| lower.abs().max(upper.abs()));
    let force = largest(item.range("forcerange", "forcelimited")?);
    let is_plain = |key: &str, plain: &str| item.text(key).is_none_or(|text| text == plain);
    let gain = match item.element().name() {
        "motor" => Some(1.0),
        "general" if is_plain("gaintype", "fixed") && is_plain("biastype", "none") => {
            // With dynamics the force follows the actuator's state, which may have other limits.
            let (gain, given) = item.part::<10>("gainprm")?;
            is_plain("dyntype", "none").then_some(if given == 0 { 1.0 } else { gain[0] })
        }
        _ => None,
    };
    let told = match gain {
        Some(gain) => largest(item.range("ctrlrange", "ctrllimited")?) * gain.abs(),
        None => f64::INFINITY,
    };
    let least = force.min(told);
    // No gear at all gives nothing, not the product of zero and infinity.
    Ok(if gear == 0.0 { 0.0 } else { gear.abs() * least })
}
