//! Whatever comes is read or refused in one line, and never panics.

use legwork::error::Error;
use legwork::library::scenario_names;
use legwork::scenario_file::{Loaded, load, parse, to_toml};
use legwork::settings::{SETTINGS, Setting};
use proptest::prelude::*;

use crate::read;

/// A value for any setting, valid or not.
fn any_value() -> impl Strategy<Value = String> {
    prop_oneof![
        any::<f64>().prop_map(|number| format!("{number:?}")),
        any::<i64>().prop_map(|number| number.to_string()),
        "[a-z0-9.\\[\\]{}\"'=, -]{0,12}",
        Just("[[0, 1, 2], [1, 2, 3]]".to_owned()),
        Just("[{force_n=1,start_s=0,duration_s=1}]".to_owned()),
        Just("in-swing".to_owned()),
    ]
}

fn any_path() -> impl Strategy<Value = String> {
    let known = proptest::sample::select(SETTINGS).prop_map(|setting: Setting| setting.path.replace('N', "0"));
    prop_oneof![4 => known, 1 => "[a-z_.0-9]{0,30}", 1 => ".{0,10}"]
}

/// What comes out is valid, and what is in use of it stays the same when written and read.
fn is_sound(result: Result<Loaded, Error>) -> Result<(), TestCaseError> {
    match result {
        Ok(Loaded { scenario, .. }) => {
            let again = read(&to_toml(&scenario), &[]).map_err(|error| TestCaseError::fail(error.to_string()))?;
            prop_assert_eq!(to_toml(&again), to_toml(&scenario));
        }
        Err(error) => prop_assert!(!error.to_string().contains('\n'), "one line: {:?}", error.to_string()),
    }
    Ok(())
}

proptest! {
    #[test]
    fn any_text_is_read_or_refused(text in ".{0,200}") {
        is_sound(parse(&text, "any.toml", None, &[]))?;
    }

    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..100)) {
        is_sound(parse(&String::from_utf8_lossy(&bytes), "any.toml", None, &[]))?;
    }

    #[test]
    fn a_damaged_file_is_read_or_refused(
        name in proptest::sample::select(scenario_names().collect::<Vec<_>>()),
        at in any::<prop::sample::Index>(),
        removed in 0usize..20,
        inserted in any_value(),
    ) {
        let mut chars: Vec<char> = to_toml(&load(name, &[]).expect("it is valid").scenario).chars().collect();
        let start = at.index(chars.len());
        chars.splice(start..(start + removed).min(chars.len()), inserted.chars());
        is_sound(parse(&chars.into_iter().collect::<String>(), "any.toml", None, &[]))?;
    }

    /// A line may be lost to the comment before it: the settings that only it asked for are then not in use.
    #[test]
    fn a_file_that_misses_a_line_is_read_or_refused(
        name in proptest::sample::select(scenario_names().collect::<Vec<_>>()),
        at in any::<prop::sample::Index>(),
    ) {
        let text = to_toml(&load(name, &[]).expect("it is valid").scenario);
        let mut lines: Vec<_> = text.lines().collect();
        lines.remove(at.index(lines.len()));
        is_sound(parse(&lines.join("\n"), "any.toml", None, &[]))?;
    }

    #[test]
    fn any_assignments_are_taken_or_refused(
        assignments in prop::collection::vec((any_path(), any_value()), 0..4),
        loose in ".{0,20}",
    ) {
        let mut texts: Vec<_> = assignments.into_iter().map(|(path, value)| format!("{path}={value}")).collect();
        is_sound(load("push", &texts))?;
        texts.push(loose);
        is_sound(load("waypoints", &texts))?;
    }

    #[test]
    fn any_valid_number_is_kept_to_the_last_bit(friction in 0.0..10.0f64, height in 0.05..5.0f64, seed in 0..i64::MAX) {
        let texts = [format!("ground.friction={friction}"), format!("start.com_height_m={height:e}"), format!("seed={seed}")];
        let scenario = load("walk", &texts).expect("it is valid").scenario;
        prop_assert_eq!(scenario.ground.friction.to_bits(), friction.to_bits());
        prop_assert_eq!(scenario.start.com_height_m.to_bits(), height.to_bits());
        prop_assert_eq!(scenario.seed, u64::try_from(seed).expect("it is positive"));
        is_sound(load("walk", &texts))?;
    }
}
