//! Default classes, and an element with what its class gives it.

use std::collections::HashMap;

use nalgebra::{Matrix3, Vector3};

use super::compiler::Compiler;
use super::files::Tree;
use crate::error::ModelError;
use crate::joints::rotation_from_quaternion;
use crate::spatial::rotation_about;
use crate::words::{list, quoted};
use crate::xml::Element;

/// The elements that set up an actuator; in a class they are one.
pub(super) const ACTUATORS: &[&str] = &[
    "general",
    "motor",
    "position",
    "velocity",
    "intvelocity",
    "orientation",
    "pid",
    "damper",
    "cylinder",
    "muscle",
    "adhesion",
    "dcmotor",
    "plugin",
];

/// The classes of `<default>`. The first has all others in it.
pub(super) struct Defaults<'a> {
    classes: Vec<Class<'a>>,
    by_name: HashMap<&'a str, usize>,
}

struct Class<'a> {
    parent: Option<usize>,
    elements: Vec<Element<'a>>,
}

impl<'a> Defaults<'a> {
    pub(super) fn read(tree: &Tree<'a>) -> Result<Self, ModelError> {
        let main = Class { parent: None, elements: Vec::new() };
        let mut defaults = Self { classes: vec![main], by_name: HashMap::from([("main", 0)]) };
        let mut open: Vec<_> = tree.sections("default").into_iter().map(|section| (section, None)).collect();
        open.reverse();
        while let Some((section, parent)) = open.pop() {
            let section = section.of(section.get("class").unwrap_or("default"));
            let class = match (parent, section.get("class")) {
                (None, name) => {
                    name.map(|name| defaults.by_name.insert(name, 0));
                    0
                }
                (Some(_), None) => return Err(section.invalid("class is missing; a class within another has a name")),
                (Some(_), Some(name)) => {
                    defaults.classes.push(Class { parent, elements: Vec::new() });
                    let class = defaults.classes.len() - 1;
                    if defaults.by_name.insert(name, class).is_some() {
                        let problem = format!("class {} is given twice; names of classes must differ", quoted(name));
                        return Err(section.invalid(problem));
                    }
                    class
                }
            };
            for child in tree.children(section) {
                match child.name() {
                    "default" => open.push((child, Some(class))),
                    _ => defaults.classes[class].elements.push(child.of(section.get("class").unwrap_or("default"))),
                }
            }
        }
        Ok(defaults)
    }

    /// The class of this name.
    pub(super) fn class(&self, name: &str, at: Element) -> Result<usize, ModelError> {
        self.by_name.get(name).copied().ok_or_else(|| {
            let mut names: Vec<_> = self.by_name.keys().collect();
            names.sort();
            at.invalid(format!("unknown class {}; valid are {}", quoted(name), list(names)))
        })
    }

    /// An element with the defaults of the class that it names, or else of the class `within` which it stands.
    pub(super) fn item(&self, element: Element<'a>, within: usize) -> Result<Item<'a>, ModelError> {
        let class = element.get("class").map_or(Ok(within), |name| self.class(name, element))?;
        let is_actuator = ACTUATORS.contains(&element.name());
        let alike = |other: &&Element| {
            if is_actuator { ACTUATORS.contains(&other.name()) } else { other.name() == element.name() }
        };
        let mut levels = vec![element];
        let mut next = Some(class);
        while let Some(class) = next {
            let Class { parent, elements } = &self.classes[class];
            levels.extend(elements.iter().rev().filter(alike));
            next = *parent;
        }
        Ok(Item { levels })
    }
}

/// An element, then the elements of its classes, from the inner to the outer, that say what it leaves out.
pub(super) struct Item<'a> {
    levels: Vec<Element<'a>>,
}

impl<'a> Item<'a> {
    pub(super) fn element(&self) -> Element<'a> {
        self.levels[0]
    }

    /// The first element that has the attribute.
    fn level(&self, key: &str) -> Option<Element<'a>> {
        self.levels.iter().find(|level| level.get(key).is_some()).copied()
    }

    pub(super) fn text(&self, key: &str) -> Option<&'a str> {
        self.level(key).and_then(|level| level.get(key))
    }

    pub(super) fn number(&self, key: &str) -> Result<Option<f64>, ModelError> {
        self.level(key).map_or(Ok(None), |level| level.number(key))
    }

    /// All numbers of a row.
    pub(super) fn row<const N: usize>(&self, key: &str) -> Result<Option<[f64; N]>, ModelError> {
        self.level(key).map_or(Ok(None), |level| level.numbers(key))
    }

    /// The first numbers of a row of at most `N`, with how many there are. A class gives those that its item leaves out.
    pub(super) fn part<const N: usize>(&self, key: &str) -> Result<([f64; N], usize), ModelError> {
        let (mut numbers, mut count) = ([0.0; N], 0);
        for level in self.levels.iter().rev() {
            let Some(text) = level.get(key) else { continue };
            let parsed: Result<Vec<f64>, _> = text.split_whitespace().map(str::parse).collect();
            let Some(parsed) = parsed.ok().filter(|row| row.len() <= N && row.iter().all(|number| number.is_finite()))
            else {
                let needed = format!("at most {N} finite numbers with blanks between them are needed");
                return Err(level.refused_at(key, &needed));
            };
            if parsed.is_empty() {
                return Err(level.refused_at(key, "a number is needed"));
            }
            numbers[..parsed.len()].copy_from_slice(&parsed);
            count = count.max(parsed.len());
        }
        Ok((numbers, count))
    }

    /// A switch; `None` where it is to be found out (`auto`) or not given.
    pub(super) fn switch(&self, key: &str) -> Result<Option<bool>, ModelError> {
        let Some(level) = self.level(key) else { return Ok(None) };
        match level.get(key).map(str::trim) {
            Some("true") => Ok(Some(true)),
            Some("false") => Ok(Some(false)),
            Some("auto") => Ok(None),
            _ => Err(level.refused_at(key, "valid are true, false and auto")),
        }
    }

    /// A range that is in use: where `switch` says so, or leaves it open and the range is not empty.
    pub(super) fn range(&self, key: &str, switch: &str) -> Result<Option<[f64; 2]>, ModelError> {
        let range = self.row::<2>(key)?;
        Ok(match self.switch(switch)? {
            Some(true) => Some(range.unwrap_or_default()),
            Some(false) => None,
            None => range.filter(|[lower, upper]| lower < upper),
        })
    }

    pub(super) fn vector(&self, key: &str) -> Result<Vector3<f64>, ModelError> {
        Ok(Vector3::from(self.row(key)?.unwrap_or_default()))
    }

    /// The rotation that one of five keys gives.
    pub(super) fn rotation(&self, compiler: &Compiler) -> Result<Matrix3<f64>, ModelError> {
        const KEYS: [&str; 5] = ["quat", "axisangle", "xyaxes", "zaxis", "euler"];
        let has = |level: &&Element| KEYS.iter().any(|key| level.has(key));
        let Some(&level) = self.levels.iter().find(has) else { return Ok(Matrix3::identity()) };
        let given: Vec<_> = KEYS.into_iter().filter(|key| level.has(key)).collect();
        let [key] = given[..] else {
            return Err(level.invalid(format!("{} are given at once; give one rotation", list(given))));
        };
        let refused = |needed: &str| level.refused_at(key, needed);
        let alone = Item { levels: vec![level] };
        match key {
            "quat" => {
                let quaternion: [f64; 4] = alone.row(key)?.unwrap_or_default();
                let largest = quaternion.iter().fold(0.0, |largest: f64, entry| largest.max(entry.abs()));
                if largest == 0.0 {
                    return Err(refused("a rotation such as \"1 0 0 0\" is needed"));
                }
                Ok(rotation_from_quaternion(&quaternion.map(|entry| entry / largest)))
            }
            "axisangle" => {
                let [x, y, z, angle]: [f64; 4] = alone.row(key)?.unwrap_or_default();
                let axis =
                    direction(Vector3::new(x, y, z)).ok_or_else(|| refused("an axis that is not zero is needed"))?;
                Ok(rotation_about(&axis, compiler.angle(angle)))
            }
            "xyaxes" => {
                let entries: [f64; 6] = alone.row(key)?.unwrap_or_default();
                let needed = "two axes that are not parallel are needed";
                let x = direction(Vector3::from_column_slice(&entries[..3])).ok_or_else(|| refused(needed))?;
                let y = Vector3::from_column_slice(&entries[3..]);
                let y = direction(y - x * x.dot(&y)).ok_or_else(|| refused(needed))?;
                Ok(Matrix3::from_columns(&[x, y, x.cross(&y)]))
            }
            "zaxis" => {
                let z = Vector3::from(alone.row(key)?.unwrap_or_default());
                let z = direction(z).ok_or_else(|| refused("an axis that is not zero is needed"))?;
                Ok(rotation_to(&z))
            }
            _ => Ok(compiler.euler(alone.row(key)?.unwrap_or_default())),
        }
    }
}

/// The direction of a vector that has one.
pub(super) fn direction(vector: Vector3<f64>) -> Option<Vector3<f64>> {
    let largest = vector.amax();
    if largest == 0.0 {
        return None;
    }
    let scaled = vector / largest;
    Some(scaled / libm::sqrt(scaled.norm_squared()))
}

/// The smallest rotation that takes the z axis to a direction; about x where that is half a turn.
pub(super) fn rotation_to(z: &Vector3<f64>) -> Matrix3<f64> {
    let axis = Vector3::z().cross(z);
    let sine = libm::sqrt(axis.norm_squared());
    let about = direction(axis).unwrap_or_else(Vector3::x);
    rotation_about(&about, libm::atan2(sine, z.z))
}
