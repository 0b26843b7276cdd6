//! What a setting may be, the check, and the words for it.

use std::fmt::{self, Display, Formatter};

use legwork_rbd::words::quoted;
use toml::Value;

/// What a value may be. NaN and infinity never are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Valid {
    /// A number; a whole one will do.
    Number {
        /// The least.
        min: f64,
        /// The most.
        max: f64,
    },
    /// A whole number.
    Integer {
        /// The least.
        min: i64,
        /// The most.
        max: i64,
    },
    /// One of these texts.
    OneOf(&'static [&'static str]),
    /// True or false.
    Bool,
    /// Any text.
    Text,
    /// A list of texts.
    Texts,
    /// A number, or a table of numbers by joint.
    ByJoint {
        /// The least.
        min: f64,
        /// The most.
        max: f64,
    },
    /// The name of a posture, or a table of positions by joint.
    Posture,
    /// A list with a number a column.
    Row(&'static [Column]),
    /// A list of such rows, or an empty one.
    Rows(&'static [Column]),
}

/// A column of rows of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Column {
    /// Its name, with the unit.
    pub name: &'static str,
    /// The least that it may hold.
    pub min: f64,
    /// The most.
    pub max: f64,
}

impl Column {
    /// A column.
    pub const fn new(name: &'static str, min: f64, max: f64) -> Self {
        Self { name, min, max }
    }

    /// Whether it may hold `value`; never NaN.
    pub fn holds(&self, value: f64) -> bool {
        (self.min..=self.max).contains(&value)
    }
}

impl Valid {
    /// The value, whole numbers turned into floating-point ones where that is meant.
    ///
    /// # Errors
    /// What was found instead of something valid, in words that follow "found".
    pub fn check(&self, value: &Value) -> Result<Value, String> {
        let ok = match (self, value) {
            (Self::Number { min, max }, _) => return number(&Column::new("", *min, *max), value),
            (Self::Row(columns), _) => return row(columns, value),
            (Self::ByJoint { min, max }, Value::Table(_)) => return by_joint(&Column::new("", *min, *max), value),
            (Self::ByJoint { min, max }, _) => return number(&Column::new("", *min, *max), value),
            (Self::Posture, Value::Table(_)) => return by_joint(&POSITION, value),
            (Self::Rows(columns), Value::Array(rows)) => {
                let numbered = |(index, value)| row(columns, value).map_err(|found| format!("{found} in row {index}"));
                return rows.iter().enumerate().map(numbered).collect::<Result<_, _>>().map(Value::Array);
            }
            (Self::Texts, Value::Array(list)) => list.iter().all(Value::is_str),
            (Self::Integer { min, max }, Value::Integer(found)) => (min..=max).contains(&found),
            (Self::OneOf(alternatives), Value::String(found)) => alternatives.contains(&found.as_str()),
            (Self::Bool, Value::Boolean(_)) | (Self::Text | Self::Posture, Value::String(_)) => true,
            _ => false,
        };
        if ok { Ok(value.clone()) } else { Err(in_words(value)) }
    }
}

/// Where a joint may be [rad, m].
const POSITION: Column = Column::new("", -100.0, 100.0);

fn by_joint(column: &Column, value: &Value) -> Result<Value, String> {
    let Value::Table(table) = value else { return Err(in_words(value)) };
    let checked = table.iter().map(|(name, value)| {
        let value = number(column, value).map_err(|found| format!("{found} for {}", quoted(name)))?;
        Ok((name.clone(), value))
    });
    checked.collect::<Result<_, _>>().map(Value::Table)
}

fn number(column: &Column, value: &Value) -> Result<Value, String> {
    let found = match value {
        Value::Float(float) => *float,
        #[allow(clippy::cast_precision_loss)]
        Value::Integer(integer) => *integer as f64,
        _ => return Err(in_words(value)),
    };
    if column.holds(found) { Ok(Value::Float(found)) } else { Err(in_words(value)) }
}

fn row(columns: &[Column], value: &Value) -> Result<Value, String> {
    let Value::Array(list) = value else { return Err(in_words(value)) };
    if list.len() != columns.len() {
        return Err(format!("{} values", list.len()));
    }
    let checked = list
        .iter()
        .zip(columns)
        .map(|(value, column)| number(column, value).map_err(|found| format!("{found} for {}", column.name)));
    checked.collect::<Result<_, _>>().map(Value::Array)
}

/// A value in an error message: itself, or its kind where it may be long.
pub fn in_words(value: &Value) -> String {
    match value {
        Value::Table(_) => "a table".to_owned(),
        Value::Array(_) => "a list".to_owned(),
        Value::String(text) => format!("the text {}", quoted(text)),
        Value::Float(number) => format!("{number:?}").to_lowercase(),
        other => other.to_string(),
    }
}

/// A number without a long row of zeros.
fn in_digits(number: f64) -> String {
    let size = number.abs();
    if number == 0.0 || (1e-3..1e6).contains(&size) || !number.is_finite() {
        number.to_string()
    } else {
        format!("{number:e}")
    }
}

impl Display for Valid {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            Self::Number { min, max } => write!(f, "a number from {} to {}", in_digits(*min), in_digits(*max)),
            Self::Integer { min, max } => write!(f, "a whole number from {min} to {max}"),
            Self::OneOf(alternatives) => {
                let quoted: Vec<_> = alternatives.iter().map(|text| format!("\"{text}\"")).collect();
                f.write_str(&quoted.join(" or "))
            }
            Self::Bool => f.write_str("true or false"),
            Self::Text => f.write_str("text"),
            Self::Texts => f.write_str("a list of texts"),
            Self::ByJoint { min, max } => {
                let [min, max] = [min, max].map(|end| in_digits(*end));
                write!(f, "a number from {min} to {max}, or a table of such by names or patterns of joints")
            }
            Self::Posture => f.write_str(
                "the name of a posture, or a table of positions [rad, m] by names or patterns of joints, such as { \"*_elbow\" = 0.3 }",
            ),
            Self::Row(columns) => columns_in_words(columns, f),
            Self::Rows(columns) => {
                f.write_str("a list of rows ")?;
                columns_in_words(columns, f)
            }
        }
    }
}

/// `[t_s, x_m] with t_s from 0 to 3600, x_m from -1000 to 1000`.
fn columns_in_words(columns: &[Column], f: &mut Formatter) -> fmt::Result {
    let names: Vec<_> = columns.iter().map(|column| column.name).collect();
    let range = |c: &Column| format!("{} from {} to {}", c.name, in_digits(c.min), in_digits(c.max));
    let ranges: Vec<_> = columns.iter().map(range).collect();
    write!(f, "[{}] with {}", names.join(", "), ranges.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPEED: Valid = Valid::Number { min: -5.0, max: 5.0 };
    const POINTS: Valid = Valid::Rows(&[Column::new("t_s", 0.0, 10.0), Column::new("x_m", -1.0, 1.0)]);

    fn check(valid: Valid, text: &str) -> Result<Value, String> {
        valid.check(&text.parse().expect("it is TOML"))
    }

    #[test]
    fn a_whole_number_is_a_number_but_not_the_other_way_round() {
        assert_eq!(check(SPEED, "3"), Ok(Value::Float(3.0)));
        assert_eq!(check(Valid::Integer { min: 0, max: 9 }, "3.0"), Err("3.0".into()));
    }

    #[test]
    fn what_is_not_finite_or_out_of_range_is_refused() {
        for text in ["nan", "-nan", "inf", "-inf", "5.0000001", "-6"] {
            assert!(check(SPEED, text).is_err(), "{text}");
        }
        assert!(check(POINTS, "[[0, nan]]").is_err());
        assert!(check(Valid::Integer { min: 0, max: 9 }, "10").is_err());
    }

    #[test]
    fn rows_name_the_row_and_the_column() {
        assert!(check(POINTS, "[]").is_ok());
        assert!(check(POINTS, "[[0, 1], [10.0, -1]]").is_ok());
        assert_eq!(check(POINTS, "[[0, 1], [2, 3]]"), Err("3 for x_m in row 1".into()));
        assert_eq!(check(POINTS, "[[0, 1], [2]]"), Err("1 values in row 1".into()));
        assert_eq!(check(POINTS, "[0, 1]"), Err("0 in row 0".into()));
        assert_eq!(check(POINTS, "[['a', 1]]"), Err("the text \"a\" for t_s in row 0".into()));
    }

    #[test]
    fn words_are_short() {
        assert_eq!(in_words(&Value::String("a\nb".into())), "the text \"a\\nb\"");
        assert!(in_words(&Value::String("ä".repeat(5000))).len() < 150);
        assert_eq!([in_digits(1e-12), in_digits(0.001), in_digits(1e12)], ["1e-12", "0.001", "1e12"]);
        assert_eq!(SPEED.to_string(), "a number from -5 to 5");
        assert_eq!(POINTS.to_string(), "a list of rows [t_s, x_m] with t_s from 0 to 10, x_m from -1 to 1");
    }
}
