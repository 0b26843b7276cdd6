//! What is refused on the command line.

use legwork::scenario_file::load;

use crate::{assert_says, refuses_set, sets};

#[test]
fn unknown_paths_on_the_command_line() {
    refuses_set("ground.friction", "--set ground.friction", &["found no \"=\"; valid is path=value, such as"]);
    refuses_set(
        "ground.fricton=1",
        "--set ground.fricton",
        &["did you mean ground.friction?", "valid here: cross_slope_deg, friction, known"],
    );
    refuses_set("contoller.weights.feet=1", "--set contoller.weights.feet", &["did you mean controller.weights.feet?"]);
    refuses_set("torque_nm=1", "--set torque_nm", &["did you mean controller.limits.torque_nm?"]);
    refuses_set(
        "controller.limits.torque_knm=1",
        "--set controller.limits.torque_knm",
        &["controller.limits.torque_nm?"],
    );
    refuses_set("ground.friction.x=1", "--set ground.friction.x", &["ground.friction is a single value"]);
    refuses_set("=1", "--set ", &["unknown; valid here: controller"]);
    refuses_set("pushes.1.force_n=1", "--set pushes.1.force_n", &["pushes holds 1 element, valid is pushes.0"]);
    refuses_set("pushes.force_n=1", "--set pushes.force_n", &["pushes holds 1 element, valid is pushes.0"]);
    refuses_set("pushes.0.force=1", "--set pushes.0.force", &["did you mean pushes.0.force_n?"]);
    assert_says(
        load("stand", &sets(&["pushes.0.force_n=1"])),
        "--set pushes.0.force_n",
        &["pushes is empty, there are none"],
    );
    let two =
        sets(&["pushes=[{force_n=1,start_s=0,duration_s=1},{force_n=1,start_s=0,duration_s=1}]", "pushes.2.at=com"]);
    assert_says(load("stand", &two), "--set pushes.2.at", &["holds 2 elements, valid are pushes.0 to pushes.1"]);
}

#[test]
fn wrong_values_on_the_command_line() {
    refuses_set(
        "ground.friction=high",
        "--set ground.friction",
        &["found the text \"high\"; valid is a number from 0 to 10"],
    );
    refuses_set("ground.friction=", "--set ground.friction", &["found the text \"\""]);
    refuses_set("ground.friction=1=2", "--set ground.friction", &["found the text \"1=2\""]);
    refuses_set("ground.friction=nan", "--set ground.friction", &["found nan"]);
    refuses_set("ground=wet", "--set ground", &["not a TOML value"]);
    refuses_set("ground=1", "--set ground", &["found 1; valid is a table with the keys"]);
    refuses_set("ground={frction=1}", "--set ground.frction", &["did you mean ground.friction?"]);
    refuses_set(
        "reference.step.replan=often",
        "--set reference.step.replan",
        &["found the text \"often\"; valid is \"never\" or \"in-swing\""],
    );
    refuses_set("pushes=[{force_n=1}]", "--set pushes.0", &["start_s is missing"]);
    refuses_set(
        "pushes.0.force_n=9e9",
        "--set pushes.0.force_n",
        &["found 9000000000.0; valid is a number from -1e6 to 1e6 [N]"],
    );
    refuses_set("pushes.0.point_m.1=x", "--set pushes.0.point_m.1", &["not a TOML value"]);
    refuses_set("pushes.0.point_m.1=99", "--set pushes.0.point_m.1", &["found 99 for y; valid is [x, y, z]"]);
    refuses_set("controller.period_s=0.0015", "--set controller.period_s", &["whole multiple"]);
}
