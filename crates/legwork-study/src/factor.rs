//! A factor of a study: which values it changes, and through which levels.

use std::fmt::{self, Display, Formatter};

use serde::{Deserialize, Serialize};
use toml::Value;

use crate::Change;
use legwork::settings::Setting;

/// A value of a factor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Level {
    /// True or false.
    Flag(bool),
    /// A number.
    Number(f64),
    /// One of the texts that a setting may have.
    Text(String),
    /// A number for each path.
    Row(Vec<f64>),
}

impl Level {
    /// Its number, where it is one.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            Self::Flag(_) | Self::Text(_) | Self::Row(_) => None,
        }
    }
}

impl Display for Level {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Flag(flag) => write!(f, "{flag}"),
            // The shortest text that reads back to the same bits
            Self::Number(number) if *number == 0.0 || (1e-4..1e7).contains(&number.abs()) => write!(f, "{number}"),
            Self::Number(number) => write!(f, "{number:e}"),
            Self::Text(text) => f.write_str(text),
            Self::Row(row) => {
                let row: Vec<String> = row.iter().map(|&number| Self::Number(number).to_string()).collect();
                f.write_str(&row.join(" and "))
            }
        }
    }
}

/// The levels of a factor.
#[derive(Clone, Debug, PartialEq)]
pub enum Levels {
    /// These, in this order.
    List(Vec<Level>),
    /// From the first to the last number in equal steps.
    Linear(Range),
    /// From the first to the last number in equal ratios.
    Logarithmic(Range),
}

/// A range of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Range {
    /// The least.
    pub from: f64,
    /// The most.
    pub to: f64,
    /// How many levels it has; designs that sample need none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub count: Option<usize>,
}

impl Levels {
    /// How many there are; none for a range without a count.
    pub fn count(&self) -> Option<usize> {
        match self {
            Self::List(list) => Some(list.len()),
            Self::Linear(range) | Self::Logarithmic(range) => range.count,
        }
    }

    /// The level of number `index`, which is less than [`Levels::count`]; of a range, to twelve digits.
    pub fn level(&self, index: usize) -> Level {
        match self {
            Self::List(list) => list[index].clone(),
            Self::Linear(range) | Self::Logarithmic(range) => {
                let last = range.count.map_or(1, |count| count.saturating_sub(1)).max(1);
                match self.at(index as f64 / last as f64) {
                    // 0.6, not 0.6000000000000001
                    Level::Number(number) => Level::Number(format!("{number:.12e}").parse().unwrap_or(number)),
                    other => other,
                }
            }
        }
    }

    /// The level at a `share` from 0 to 1 of the way through the range; of a list, each element has an equal share.
    pub fn at(&self, share: f64) -> Level {
        match self {
            Self::List(list) => list[((share * list.len() as f64) as usize).min(list.len() - 1)].clone(),
            // The ends are met exactly.
            Self::Linear(range) | Self::Logarithmic(range) if share >= 1.0 => Level::Number(range.to),
            Self::Linear(range) => Level::Number(range.from + share * (range.to - range.from)),
            Self::Logarithmic(range) => Level::Number(range.from * libm::pow(range.to / range.from, share)),
        }
    }

    /// The levels that show whether all are in their domain: of a list all, of a range the ends and what is between.
    pub fn extremes(&self) -> Vec<Level> {
        match (self, self.count()) {
            (Self::List(list), _) => list.clone(),
            (_, Some(count)) if count <= 100 => (0..count).map(|index| self.level(index)).collect(),
            // A place that whole numbers and multiples would miss
            _ => [0.0, 0.371, 1.0].map(|share| self.at(share)).to_vec(),
        }
    }

    /// Whether they are a list.
    pub fn is_list(&self) -> bool {
        matches!(self, Self::List(_))
    }

    /// Whether an axis of these levels is best drawn logarithmic.
    pub fn is_logarithmic(&self) -> bool {
        match self {
            Self::Linear(_) => false,
            Self::Logarithmic(_) => true,
            Self::List(list) => {
                let numbers: Option<Vec<f64>> = list.iter().map(Level::number).collect();
                let ends = numbers.map(|n| n.iter().fold((f64::MAX, f64::MIN), |(a, b), &x| (a.min(x), b.max(x))));
                ends.is_some_and(|(least, most)| least > 0.0 && most / least > 30.0)
            }
        }
    }
}

/// What a study varies.
#[derive(Clone, Debug, PartialEq)]
pub struct Factor {
    /// Its name, which no other factor of the study has.
    pub name: String,
    /// The values that it changes together; see [`crate::Base::value`].
    pub paths: Vec<String>,
    /// Its levels multiply what stands there, instead of replacing it.
    pub relative: bool,
    /// Its levels.
    pub levels: Levels,
    /// A level to be marked in figures, such as the thesis's, and what it is.
    pub marked: Option<(f64, String)>,
}

impl Factor {
    /// Its paths with what it does to each of them at `level`.
    pub fn changes<'a>(&'a self, level: &'a Level) -> impl Iterator<Item = (&'a str, Change)> {
        self.paths.iter().enumerate().map(|(place, path)| (path.as_str(), self.change(level, place)))
    }

    fn change(&self, level: &Level, place: usize) -> Change {
        match level {
            Level::Row(row) => Change::To(Value::Float(row[place])),
            Level::Number(number) if self.relative => Change::Times(*number),
            Level::Number(number) => Change::To(Value::Float(*number)),
            Level::Flag(flag) => Change::To(Value::Boolean(*flag)),
            Level::Text(text) => Change::To(Value::String(text.clone())),
        }
    }

    /// The unit of its levels.
    pub fn unit(&self) -> &'static str {
        /// Units of the model's keys, by their endings.
        const ENDINGS: [(&str, &str); 8] = [
            ("_kgm2", "kg m²"),
            ("_mps2", "m/s²"),
            ("_radps", "rad/s"),
            ("_nmspr", "Nms/rad"),
            ("_nm", "Nm"),
            ("_kg", "kg"),
            ("_rad", "rad"),
            ("_m", "m"),
        ];
        let in_rows =
            matches!(&self.levels, Levels::List(list) if list.iter().any(|level| matches!(level, Level::Row(_))));
        match Setting::find(&self.paths[0]) {
            _ if self.relative || in_rows => "",
            Some(setting) => setting.unit,
            None => ENDINGS.iter().find(|(ending, _)| self.paths[0].ends_with(ending)).map_or("", |(_, unit)| unit),
        }
    }

    /// Its name with the thesis's symbol: `feet weight C_f`.
    pub fn title(&self) -> String {
        let symbol = Setting::find(&self.paths[0]).map_or("", |setting| setting.symbol);
        if symbol.is_empty() || self.relative { self.name.clone() } else { format!("{} {symbol}", self.name) }
    }

    /// Its title and unit: `torque limit [Nm]`.
    pub fn label(&self) -> String {
        match (self.unit(), self.relative) {
            (_, true) => format!("{} [× base]", self.title()),
            ("", false) => self.title(),
            (unit, false) => format!("{} [{unit}]", self.title()),
        }
    }
}
