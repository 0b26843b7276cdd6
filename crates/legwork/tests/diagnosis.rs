//! Why a robot fell, in words that are true.

mod common;

use legwork::log::Field;

#[test]
fn a_foot_in_the_air_was_said_to_be_at_its_force_limit() {
    let run = common::run("push", &["pushes.0.force_n=1500"]);
    let reason = run.reason.expect("it falls");
    assert!(!reason.contains("force"), "{reason}");
    let mut active = 0;
    for i in 0..run.log.len() {
        let touching = run.log.get(i, Field::Touching);
        let limits = run.layout.limits().iter().zip(run.log.get(i, Field::ActiveLimit));
        for (limit, _) in limits.filter(|(_, side)| **side != 0.0) {
            active += 1;
            assert!(limit.contact.is_none_or(|contact| touching[contact] > 0.5), "{} at {i}", limit.name);
        }
    }
    assert!(active > 100, "{active}");
}

#[test]
fn a_fall_within_half_a_second_is_not_explained_by_time_before_the_start() {
    let run = common::run("stand", &["controller.limits.torque_nm=1"]);
    let reason = run.reason.expect("it falls");
    let legwork::episode::Outcome::Fell(fall) = run.outcome else { panic!("it falls") };
    assert!(fall.time < 0.5 && reason.ends_with(&format!("of the last {:.2} s", fall.time)), "{reason}");
}
