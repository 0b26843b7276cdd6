//! The table of settings, in the order of the scenario's structs.

use super::{Column, Setting, TRAJECTORY_COLUMNS, Valid};

// Sources of the defaults
const FINAL: &str = "thesis Table 6.3";
const GENERATOR: &str = "thesis 4.3.1";
const FITTED: &str = "fitted";
const OURS: &str = "ours";
const WINTER: &str = "Winter";
const FEET: &str = "feet prototype";

// Ranges: wide enough for any study, narrow enough to catch a slip
const ANY_TIME: [f64; 2] = [0.0, 3600.0];
const SOME_TIME: [f64; 2] = [1e-5, 3600.0];
const PERIOD: [f64; 2] = [1e-5, 0.1];
const DELAY: [f64; 2] = [0.0, 1.0];
const PLACE: [f64; 2] = [-1e3, 1e3];
const LENGTH: [f64; 2] = [0.0, 5.0];
const TILT: [f64; 2] = [-90.0, 90.0];
const SLOPE: [f64; 2] = [-60.0, 60.0];
const FRICTION: [f64; 2] = [0.0, 10.0];
const WEIGHT: [f64; 2] = [0.0, 1e12];
/// The program is strictly convex only with these.
const POSITIVE_WEIGHT: [f64; 2] = [1e-12, 1e12];
const GAIN: [f64; 2] = [0.0, 1e6];

const TRACKING: &[&str] = &["cost", "equality"];
const POINT: [Column; 3] =
    [Column::new("x", -10.0, 10.0), Column::new("y", -10.0, 10.0), Column::new("z", -10.0, 10.0)];

const SPEEDS: [Column; 2] = [Column::new("t_s", 0.0, 3600.0), Column::new("speed_mps", -2.0, 2.5)];
const SCHEDULE: [Column; 6] = [
    Column::new("speed_mps", 0.0, 2.5),
    Column::new("step_time_s", 0.2, 5.0),
    Column::new("com_height_m", 0.05, 5.0),
    Column::new("bob_m", 0.0, 0.2),
    Column::new("lowest", 0.0, 1.0),
    Column::new("heel_off_s", 0.0, 1.0),
];

const PROFILE: [Column; 2] = [Column::new("x_m", -1e3, 1e3), Column::new("z_m", -10.0, 10.0)];
const PATCHES: [Column; 3] =
    [Column::new("from_m", -1e3, 1e3), Column::new("to_m", -1e3, 1e3), Column::new("friction", 0.0, 10.0)];

const SWAY: [Column; 3] = [Column::new("x", -1.0, 1.0), Column::new("y", -1.0, 1.0), Column::new("z", -1.0, 1.0)];

const fn setting(path: &'static str, valid: Valid, source: &'static str, help: &'static str) -> Setting {
    Setting { path, symbol: "", unit: "", valid, source, help }
}

const fn number(
    path: &'static str,
    unit: &'static str,
    [min, max]: [f64; 2],
    source: &'static str,
    help: &'static str,
) -> Setting {
    Setting { unit, ..setting(path, Valid::Number { min, max }, source, help) }
}

const fn choice(
    path: &'static str,
    alternatives: &'static [&'static str],
    source: &'static str,
    help: &'static str,
) -> Setting {
    setting(path, Valid::OneOf(alternatives), source, help)
}

impl Setting {
    const fn measured_in(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    const fn called(self, symbol: &'static str) -> Self {
        Self { symbol, ..self }
    }
}

/// Every value of a scenario, in the order in which files are written.
pub const SETTINGS: &[Setting] = &[
    setting("name", Valid::Text, OURS, "Name of the scenario; a file that gives none is called after itself."),
    setting("description", Valid::Text, OURS, "What the scenario shows, in a sentence."),
    setting("model", Valid::Text, OURS, "Name of a built-in model, or path of a TOML, URDF or MJCF file."),
    choice(
        "fit",
        &["none", "done", "planar_humanoid", "planar_humanoid_feet", "exo18"],
        OURS,
        "Robot that the settings of start, reference, controller and pushes are stated for: they are scaled from it to the model, by length of the legs, mass and gravity. With \"none\" they are taken as they stand and follow the wearer, with \"done\" they have been scaled.",
    ),
    setting(
        "locked",
        Valid::Texts,
        OURS,
        "Joints of the model that are fixed where start.posture has them, by names or patterns such as \"*_wrist_*\".",
    ),
    number("duration_s", "s", [1e-3, 1e6], OURS, "Simulated time."),
    setting(
        "seed",
        Valid::Integer { min: 0, max: i64::MAX },
        OURS,
        "Seed of the sensor noise, the model error and the uneven ground.",
    ),
    //
    number("wearer.mass_kg", "kg", [20.0, 250.0], WINTER, "Mass of the person whose segments the robot has."),
    number(
        "wearer.height_m",
        "m",
        [1.0, 2.3],
        WINTER,
        "Height of the person whose segments the robot has; the lengths of the start pose and of the generator \"walker\" grow with it.",
    ),
    number(
        "wearer.strength",
        "",
        [0.1, 10.0],
        OURS,
        "Strength of the joints, as a factor of what the model's person has, by mass and height: that of motors that help, or of a person who is weaker.",
    ),
    number(
        "exoskeleton.torso_kg",
        "kg",
        [0.0, 100.0],
        OURS,
        "Mass that an exoskeleton adds to the torso; heights of the centre of mass at the start and of the generator \"walker\" shift with it.",
    ),
    number("exoskeleton.thigh_kg", "kg", [0.0, 50.0], OURS, "Mass that an exoskeleton adds to each thigh."),
    number("exoskeleton.shank_kg", "kg", [0.0, 50.0], OURS, "Mass that an exoskeleton adds to each shank."),
    number("exoskeleton.foot_kg", "kg", [0.0, 50.0], OURS, "Mass that an exoskeleton adds to each foot."),
    //
    number("start.right_foot_x_m", "m", PLACE, FITTED, "Place of the right foot along x at the start."),
    number("start.left_foot_x_m", "m", PLACE, FITTED, "Place of the left foot along x at the start."),
    number(
        "start.feet_width_m",
        "m",
        [0.0, 2.0],
        OURS,
        "Distance of the feet along y at the start; robots in space only.",
    ),
    number("start.com_x_m", "m", PLACE, FITTED, "Place of the centre of mass along x at the start."),
    number(
        "start.com_height_m",
        "m",
        [0.0, 5.0],
        FITTED,
        "Height of the centre of mass above the ground below it at the start; 0, and no value for a robot that is not built in, is one that follows from the robot's legs.",
    ),
    number(
        "start.torso_angle_deg",
        "deg",
        TILT,
        FITTED,
        "Torso angle at the start, counter-clockwise: leaning forward is negative.",
    ),
    setting(
        "start.posture",
        Valid::Posture,
        OURS,
        "Posture near which the start pose is sought, of the joints that feet, centre of mass and torso leave free: \"neutral\", where joints are at zero or at the near end of their range; one that the robot's file names; or positions by joint, the others neutral.",
    ),
    //
    number("ground.friction", "", FRICTION, FITTED, "Coefficient of friction of the ground.").called("mu"),
    number("ground.slope_deg", "deg", SLOPE, "thesis, flat ground", "Slope of the ground, upward in x.")
        .called("theta"),
    number(
        "ground.cross_slope_deg",
        "deg",
        SLOPE,
        OURS,
        "Slope of the ground across, upward in y; robots in space only. A controller that is not told the slopes assumes none across.",
    ),
    setting("ground.known", Valid::Bool, OURS, "Whether the controller is told the ground's friction and slopes."),
    setting(
        "ground.profile",
        Valid::Rows(&PROFILE),
        OURS,
        "Heights of the ground above its plane, joined by straight lines.",
    ),
    number(
        "ground.unevenness_m",
        "m",
        [0.0, 0.5],
        OURS,
        "Largest random height of the ground above or below its profile.",
    ),
    number(
        "ground.unevenness_spacing_m",
        "m",
        [0.02, 10.0],
        OURS,
        "Distance between the points of the ground that have random heights.",
    ),
    number("ground.unevenness_from_m", "m", PLACE, OURS, "Place along x from which on the ground has random heights."),
    setting("ground.patches", Valid::Rows(&PATCHES), OURS, "Stretches of the ground with another friction."),
    setting(
        "ground.relief_known",
        Valid::Bool,
        OURS,
        "Whether the controller is told the ground's profile, unevenness and patches.",
    ),
    //
    choice(
        "reference.generator",
        &["steps", "stance", "walker"],
        OURS,
        "Where the references come from: steps after a moving centre of mass (thesis 4.3.1); planned standing, swaying, squatting; or a walk on feet.",
    ),
    choice(
        "reference.com.trajectory",
        &["stationary", "constant-velocity", "waypoints", "file"],
        GENERATOR,
        "How the reference of the centre of mass moves.",
    ),
    number(
        "reference.com.speed_mps",
        "m/s",
        [-5.0, 5.0],
        OURS,
        "Forward speed of the trajectory \"constant-velocity\".",
    ),
    number(
        "reference.com.ramp_s",
        "s",
        ANY_TIME,
        GENERATOR,
        "Time in which the trajectory \"constant-velocity\" comes to its speed; at 0 it has it at once.",
    ),
    setting(
        "reference.com.waypoints",
        Valid::Rows(&TRAJECTORY_COLUMNS),
        OURS,
        "Points of the trajectory \"waypoints\" in the world; the centre of mass comes to rest in each.",
    ),
    setting(
        "reference.com.file",
        Valid::Text,
        OURS,
        "CSV file of the trajectory \"file\", with the columns t_s, x_m, z_m.",
    ),
    //
    number("reference.step.duration_s", "s", [1e-2, 10.0], FITTED, "Time of a step.").called("t_T"),
    number("reference.step.height_m", "m", [0.0, 1.0], FITTED, "Height of the swinging foot's arc.").called("h_s"),
    number("reference.step.min_length_m", "m", LENGTH, FITTED, "Least step length."),
    choice(
        "reference.step.min_length_is",
        &["displacement", "base-of-support"],
        OURS,
        "What the least step length is the least of: the swinging foot's way, or the distance of the feet after the step.",
    ),
    number("reference.step.max_length_m", "m", LENGTH, FITTED, "Longest way of a foot in a step.").called("l_s"),
    number(
        "reference.step.overshoot",
        "",
        [0.0, 5.0],
        GENERATOR,
        "Share of the distance to the predicted XcoM that is added to the step length.",
    ),
    number(
        "reference.step.delay_s",
        "s",
        [0.0, 10.0],
        GENERATOR,
        "How far the XcoM may leave the base of support before a step begins, as the time that it takes at the reference speed.",
    ),
    number(
        "reference.step.max_delay_m",
        "m",
        LENGTH,
        FITTED,
        "How far the XcoM may leave the base of support before a step begins, at most, whatever the speed.",
    ),
    choice("reference.step.replan", &["never", "in-swing"], GENERATOR, "When the length of a step is planned again."),
    //
    setting(
        "reference.stance.sway_m",
        Valid::Row(&SWAY),
        OURS,
        "Amplitude of the sway of the centre of mass ahead, to the left and up.",
    )
    .measured_in("m"),
    number("reference.stance.squat_m", "m", [0.0, 1.0], OURS, "Depth of a squat."),
    number("reference.stance.period_s", "s", [0.1, 100.0], OURS, "Time of one sway and of one squat."),
    choice("reference.stance.lift", &["none", "right", "left"], OURS, "Which foot is lifted."),
    number(
        "reference.stance.lift_start_s",
        "s",
        ANY_TIME,
        OURS,
        "Time at which the centre of mass begins to move above the foot that stays on the ground.",
    ),
    number(
        "reference.stance.shift_s",
        "s",
        [0.1, 100.0],
        OURS,
        "Time in which the centre of mass moves above the foot that stays on the ground, and back.",
    ),
    number(
        "reference.stance.lift_duration_s",
        "s",
        SOME_TIME,
        OURS,
        "Time for which the lifted foot is off the ground.",
    ),
    number("reference.stance.lift_height_m", "m", [0.0, 1.0], OURS, "Height to which the foot is lifted."),
    number(
        "reference.stance.swing_m",
        "m",
        [0.0, 1.0],
        OURS,
        "Amplitude of the swing of the lifted foot forward and back.",
    ),
    //
    number("reference.walker.speed_mps", "m/s", [-2.0, 2.5], OURS, "Commanded speed; a negative one is backward."),
    setting(
        "reference.walker.speeds",
        Valid::Rows(&SPEEDS),
        OURS,
        "Commanded speed over time: rows of time and speed, joined by straight lines.",
    ),
    number(
        "reference.walker.speed_change_mps",
        "m/s",
        [0.0, 2.0],
        FEET,
        "Largest change of the speed from one step to the next.",
    ),
    setting(
        "reference.walker.march",
        Valid::Bool,
        OURS,
        "Whether the robot steps in place while the commanded speed is zero.",
    ),
    setting(
        "reference.walker.schedule",
        Valid::Rows(&SCHEDULE),
        FEET,
        "What changes with the speed: step time; height of the centre of mass; its bob; the share of the step after which it is lowest; time from the lift-off of the heel to the landing.",
    ),
    number(
        "reference.walker.climb_lowering_m",
        "m",
        [0.0, 2.0],
        OURS,
        "How much lower the centre of mass is uphill, or by half downhill where the ground's height is not known, for a steepness of 1.",
    ),
    number(
        "reference.walker.unseen_com_height_m",
        "m",
        [0.0, 2.0],
        OURS,
        "Largest height of the centre of mass where the ground's height is not known.",
    ),
    number(
        "reference.walker.double_support_s",
        "s",
        [0.01, 1.0],
        FEET,
        "Time of double support, in which the rear foot is unloaded.",
    ),
    number(
        "reference.walker.unloading",
        "",
        [0.0, 10.0],
        FEET,
        "Largest load of the rear foot as its unloading begins, as a share of the weight.",
    ),
    number(
        "reference.walker.way_gain",
        "1/s",
        [0.0, 10.0],
        FEET,
        "Gain from an error in the place of the centre of mass to the speed that makes up for it.",
    ),
    number(
        "reference.walker.cop_gain",
        "1/s",
        [0.0, 100.0],
        FEET,
        "Gain from an error of the XcoM to the shift of the centre of pressure.",
    )
    .called("k"),
    number(
        "reference.walker.cop_margin_m",
        "m",
        [0.0, 0.1],
        FEET,
        "Least distance of the centre of pressure from the ends of the foot.",
    ),
    number(
        "reference.walker.cop_centre_m",
        "m",
        [-0.2, 0.3],
        FEET,
        "Middle of the centre of pressure's way over a step, from below the ankle.",
    )
    .called("p_c"),
    number("reference.walker.cop_span_m", "m", [0.0, 1.0], FEET, "Longest way of the centre of pressure in a step."),
    number(
        "reference.walker.cop_span_share",
        "",
        [0.0, 2.0],
        FEET,
        "Longest way of the centre of pressure in a step, as a share of the step length.",
    ),
    number(
        "reference.walker.stand_margin_m",
        "m",
        [0.0, 1.0],
        OURS,
        "How far the XcoM may leave the feet before a standing robot steps.",
    ),
    number(
        "reference.walker.hip_shift_m",
        "m",
        [0.0, 1.0],
        OURS,
        "How far beyond the feet an angular acceleration of the torso may shift the centre of pressure; zero forbids it.",
    ),
    number(
        "reference.walker.hip_acceleration_radps2",
        "rad/s²",
        [0.1, 100.0],
        OURS,
        "Angular acceleration of a torso that shifts the centre of pressure beyond the feet.",
    ),
    number(
        "reference.walker.hip_lean_rad",
        "rad",
        [0.01, 1.5],
        OURS,
        "Largest lean of a torso that shifts the centre of pressure beyond the feet.",
    ),
    choice(
        "reference.walker.adaptation",
        &["none", "place", "place-and-time"],
        FEET,
        "What a step under way may change.",
    ),
    number(
        "reference.walker.time_weight",
        "m2/s2",
        WEIGHT,
        FEET,
        "Weight of a change of the step's time against a change of its place.",
    ),
    number(
        "reference.walker.offset_weight",
        "",
        WEIGHT,
        FEET,
        "Weight of the XcoM's error at the end of the step against a change of the step's place.",
    ),
    number("reference.walker.shortest_swing_s", "s", [0.05, 10.0], FEET, "Shortest time of a swing."),
    number("reference.walker.longest_step_s", "s", [0.1, 10.0], FEET, "Longest time of a step."),
    number("reference.walker.longest_m", "m", LENGTH, FEET, "Farthest that a foot lands before the other."),
    number("reference.walker.longest_back_m", "m", LENGTH, FEET, "Farthest that a foot lands behind the other."),
    number(
        "reference.walker.swing_acceleration_mps2",
        "m/s2",
        [1.0, 1e4],
        FEET,
        "Largest acceleration of the swinging foot.",
    ),
    number(
        "reference.walker.leg_m",
        "m",
        LENGTH,
        FEET,
        "Longest distance from hip to ankle that a place of landing may need.",
    ),
    number(
        "reference.walker.stretched_leg_m",
        "m",
        [0.1, 2.0],
        OURS,
        "Distance from hip to ankle at which the heel lifts where a step is prolonged.",
    ),
    number("reference.walker.hip_below_com_m", "m", LENGTH, FEET, "How far the hip is below the centre of mass."),
    number(
        "reference.walker.longest_drop_m",
        "m",
        [0.0, 0.5],
        OURS,
        "Most that the centre of mass is lowered for a long step.",
    ),
    number(
        "reference.walker.drop_acceleration_mps2",
        "m/s2",
        [0.1, 100.0],
        OURS,
        "Largest vertical acceleration of a centre of mass that is lowered for a long step.",
    ),
    number("reference.walker.clearance_m", "m", [0.0, 1.0], FEET, "Height of the toe of the swinging foot."),
    number(
        "reference.walker.heel_off_from_m",
        "m",
        LENGTH,
        OURS,
        "Step length from which on a step ends with a heel-off.",
    ),
    number(
        "reference.walker.heel_off_full_m",
        "m",
        LENGTH,
        OURS,
        "Step length from which on that is a full one; shorter steps have less of it.",
    ),
    number(
        "reference.walker.heel_off_turn",
        "rad/m",
        [0.0, 10.0],
        FEET,
        "Angle by which a foot turns over its toe at a heel-off, a metre of step length.",
    ),
    number(
        "reference.walker.heel_off_max_rad",
        "rad",
        [0.0, 1.5],
        FEET,
        "Largest angle by which a foot turns over its toe at a heel-off.",
    ),
    number(
        "reference.walker.touchdown_force_n",
        "N",
        [0.0, 1e4],
        FEET,
        "Load at which a swinging foot counts as landed.",
    ),
    number(
        "reference.walker.settling_s",
        "s",
        [0.0, 1.0],
        OURS,
        "Time before the landing from which on a swinging foot is above its place.",
    ),
    number("reference.walker.landing_speed_mps", "m/s", [0.0, 5.0], FEET, "Speed at which a foot meets the ground."),
    number(
        "reference.walker.unseen_landing_speed_mps",
        "m/s",
        [0.0, 5.0],
        OURS,
        "Speed at which a foot meets the ground where the ground's height is not known.",
    ),
    number(
        "reference.walker.landing_acceleration_mps2",
        "m/s2",
        [0.1, 1e3],
        FEET,
        "Downward acceleration of a foot that has not found the ground in time.",
    ),
    number(
        "reference.walker.unit_m",
        "m",
        [1e-3, 1e3],
        OURS,
        "Unit of the lengths in the walker's own rules, such as how close feet stand that stand together: a metre of a robot with a person's legs.",
    ),
    number(
        "reference.walker.unit_s",
        "s",
        [1e-3, 1e3],
        OURS,
        "Unit of the times in the walker's own rules: a second of a robot with a person's legs.",
    ),
    //
    choice(
        "controller.kind",
        &["momentum", "hold"],
        OURS,
        "Which controller drives the robot: the quadratic program, or a spring and a damper at each joint that hold the start pose.",
    ),
    number(
        "controller.period_s",
        "s",
        PERIOD,
        OURS,
        "Time between two control ticks; a whole multiple of the time step of the physics.",
    ),
    choice(
        "controller.form",
        &["direct", "slack"],
        OURS,
        "Form of the quadratic program; both forms have one optimum.",
    ),
    number(
        "controller.assumed_friction",
        "",
        FRICTION,
        OURS,
        "Friction of the ground that the controller assumes where it is not told.",
    ),
    setting(
        "controller.friction_edges",
        Valid::Integer { min: 3, max: 64 },
        OURS,
        "Edges of the pyramid inside the cone of friction that stands for it in the program; robots in space only.",
    ),
    number(
        "controller.assumed_slope_deg",
        "deg",
        SLOPE,
        OURS,
        "Slope of the ground that the controller assumes where it is not told.",
    ),
    number(
        "controller.known_delay_s",
        "s",
        DELAY,
        OURS,
        "How late torques act behind what is measured, as far as the controller knows: delays of sensors and actuators and the time constant of their lag, summed up. It predicts the state over that time.",
    ),
    number(
        "controller.lift_height_m",
        "m",
        [0.0, 0.1],
        OURS,
        "How far from the height at which it was felt last a contact point that is no longer felt is taken to stand.",
    ),
    //
    number(
        "controller.planner.angular_momentum_gain",
        "1/s",
        GAIN,
        FITTED,
        "Gain from the angular momentum to its rate.",
    )
    .called("P_theta"),
    number(
        "controller.planner.com_gain",
        "N/m",
        GAIN,
        FINAL,
        "Gain from an error of the centre of mass to the force that corrects it.",
    )
    .called("P_C"),
    number(
        "controller.planner.foot_gain",
        "1/s²",
        GAIN,
        FINAL,
        "Gain from an error of a foot's place to the foot's acceleration.",
    )
    .called("P_f"),
    number(
        "controller.planner.foot_rotation_gain",
        "1/s²",
        GAIN,
        OURS,
        "Gain from an error of a foot's orientation to the foot's angular acceleration; feet with several contact points only.",
    ),
    number(
        "controller.planner.torso_gain",
        "1/s²",
        GAIN,
        FITTED,
        "Gain from an error of the torso's angle to the torso's angular acceleration.",
    )
    .called("P_a"),
    setting(
        "controller.planner.posture_gain",
        Valid::ByJoint { min: GAIN[0], max: GAIN[1] },
        OURS,
        "Gain from an error of a joint's position to the joint's acceleration, in the posture task; in a table, joints without a number have 45.",
    )
    .measured_in("1/s²"),
    setting(
        "controller.planner.posture",
        Valid::Posture,
        OURS,
        "Posture that the posture task holds: \"start\", that of the first tick; \"neutral\"; one that the robot's file names; or positions by joint, the others as in the first tick.",
    ),
    choice(
        "controller.planner.damping",
        &["printed", "critical"],
        "thesis 6.3.7",
        "Which damping gain D belongs to a gain P of a mass m: D = sqrt(2 m P) as printed (ratio 0.71), or the critical D = 2 sqrt(m P).",
    ),
    number(
        "controller.planner.max_horizontal_momentum_rate_n",
        "N",
        [0.0, 1e6],
        FITTED,
        "Largest horizontal momentum rate that the planner asks for.",
    ),
    number("controller.planner.torso_angle_deg", "deg", TILT, "thesis (4.6)", "Torso angle that the planner asks for."),
    //
    number("controller.weights.joint_acceleration", "", POSITIVE_WEIGHT, FINAL, "Weight of joint accelerations.")
        .called("C_v"),
    number("controller.weights.grf", "", POSITIVE_WEIGHT, FINAL, "Weight of ground reaction forces.").called("C_rho"),
    number("controller.weights.torque", "", WEIGHT, FINAL, "Weight of joint torques.").called("C_tau"),
    number("controller.weights.momentum", "", WEIGHT, FINAL, "Weight of the momentum rate's error.").called("C_m"),
    number(
        "controller.weights.angular_momentum_factor",
        "",
        WEIGHT,
        OURS,
        "Weight of the angular rows of the momentum against the linear ones.",
    ),
    number(
        "controller.weights.vertical_momentum_factor",
        "",
        WEIGHT,
        OURS,
        "Weight of the vertical row of the momentum against the horizontal ones.",
    ),
    number("controller.weights.feet", "", WEIGHT, FINAL, "Weight of the feet's acceleration error.").called("C_f"),
    number(
        "controller.weights.swing_feet_factor",
        "",
        WEIGHT,
        OURS,
        "Weight of a swinging foot's place against a standing one's.",
    ),
    number(
        "controller.weights.foot_rotation",
        "",
        WEIGHT,
        OURS,
        "Weight of the angular acceleration error of feet with several contact points.",
    ),
    number(
        "controller.weights.swing_rotation_factor",
        "",
        WEIGHT,
        OURS,
        "Weight of a swinging foot's orientation against a standing one's.",
    ),
    number(
        "controller.weights.rolling_rotation_factor",
        "",
        WEIGHT,
        OURS,
        "Weight of the orientation of a foot that rolls over its toe against a standing one's.",
    ),
    number(
        "controller.weights.trailing_rotation_factor",
        "",
        WEIGHT,
        OURS,
        "Weight of the orientation of a foot that hands its load to the other foot against a standing one's.",
    ),
    number("controller.weights.torso", "", WEIGHT, FINAL, "Weight of the torso's angular acceleration error.")
        .called("C_a"),
    number(
        "controller.weights.torso_urgency_s4",
        "s4",
        WEIGHT,
        OURS,
        "Gain from the square of the torso's wanted acceleration to the growth of the torso's weight.",
    ),
    setting(
        "controller.weights.posture",
        Valid::ByJoint { min: WEIGHT[0], max: WEIGHT[1] },
        OURS,
        "Weight of the joint accelerations toward the posture; in a table, joints without a number have 1.",
    ),
    number(
        "controller.weights.braking",
        "",
        WEIGHT,
        OURS,
        "Weight of a braking joint's acceleration error where the bound (4.32) had to yield.",
    ),
    //
    choice("controller.tracking.momentum", TRACKING, "thesis (4.17)", "How the momentum rate is tracked."),
    choice("controller.tracking.feet", TRACKING, "thesis (4.19)", "How the feet are tracked."),
    choice("controller.tracking.torso", TRACKING, "thesis (4.20)", "How the torso is tracked."),
    choice(
        "controller.tracking.posture",
        &["off", "free", "cost", "equality"],
        OURS,
        "How actuated joints are held in the posture, if they are: with \"free\" in the cost, those that feet, torso and centre of mass leave free (arms, neck, waist, legs of more than six joints); else all of them.",
    ),
    //
    number("controller.limits.torque_nm", "Nm", [0.1, 1e5], FINAL, "Largest joint torque."),
    number(
        "controller.limits.torque_rate_nmps",
        "Nm/s",
        [1.0, 1e9],
        OURS,
        "Largest change of a joint's torque in a second; the default is above what any motor does.",
    ),
    number("controller.limits.grf_n", "N", [1.0, 1e6], FINAL, "Largest component of a contact's force."),
    number(
        "controller.limits.joint_acceleration_radps2",
        "rad/s²",
        [1.0, 1e6],
        FITTED,
        "Largest acceleration of an actuated joint.",
    ),
    choice(
        "controller.limits.joint_limits",
        &["braking-distance", "approach"],
        "thesis (4.32)",
        "How a joint is kept within its range.",
    ),
    number(
        "controller.limits.approach_rate_1ps",
        "1/s",
        [1.0, 1e3],
        OURS,
        "Rate at which a joint comes to its largest speed, and with \"approach\" to the end of its range, as a critically damped joint of this rate.",
    ),
    //
    number(
        "controller.hold.stiffness_nmprad",
        "Nm/rad",
        [0.0, 1e6],
        OURS,
        "Stiffness with which the controller \"hold\" pulls a joint to its start.",
    ),
    number(
        "controller.hold.damping_nmsprad",
        "Nms/rad",
        [0.0, 1e5],
        OURS,
        "Damping with which the controller \"hold\" brakes a joint.",
    ),
    //
    number("simulation.period_s", "s", PERIOD, OURS, "Time step of the physics."),
    choice(
        "simulation.integrator",
        &["semi-implicit-euler", "midpoint"],
        OURS,
        "How the state is advanced: with the new velocity, or by Moreau's midpoint rule.",
    ),
    number(
        "simulation.model_error",
        "",
        [0.0, 0.5],
        OURS,
        "Largest share by which mass, centre of mass and inertia of each simulated body differ from those that the controller knows; drawn by the seed.",
    ),
    //
    choice(
        "simulation.contact.model",
        &["rigid", "spring-damper"],
        "thesis 3.3",
        "The law of contact between feet and ground.",
    ),
    number(
        "simulation.contact.flag_height_m",
        "m",
        [0.0, 0.1],
        OURS,
        "Height above the ground below which a contact point touches it for the controller.",
    ),
    number(
        "simulation.contact.relaxation",
        "",
        [1e-3, 1.0],
        OURS,
        "Share by which the ground is raised each time under a contact that slips, where the contact solver has to do that; law \"rigid\" only.",
    ),
    number(
        "simulation.contact.tolerance_n",
        "N",
        [1e-12, 1e3],
        OURS,
        "By how much an impulse, as a force, may miss the law of contact; law \"rigid\" only.",
    ),
    setting(
        "simulation.contact.max_sweeps",
        Valid::Integer { min: 1, max: 100_000 },
        OURS,
        "Linear solves after which the contact solver makes no further attempt and takes the impulses that miss the law least; law \"rigid\" only.",
    ),
    number(
        "simulation.contact.stiffness_npm",
        "N/m",
        [1.0, 1e9],
        OURS,
        "Normal stiffness of the ground; law \"spring-damper\" only.",
    ),
    number(
        "simulation.contact.damping_nspm",
        "Ns/m",
        [0.0, 1e7],
        OURS,
        "Normal damping of the ground; law \"spring-damper\" only.",
    ),
    number(
        "simulation.contact.slip_speed_mps",
        "m/s",
        [1e-6, 10.0],
        OURS,
        "Slip speed at which friction is fully developed; law \"spring-damper\" only.",
    ),
    //
    number(
        "simulation.sensors.position_noise",
        "rad or m",
        [0.0, 10.0],
        OURS,
        "Standard deviation of each measured position.",
    ),
    number(
        "simulation.sensors.velocity_noise",
        "rad/s or m/s",
        [0.0, 100.0],
        OURS,
        "Standard deviation of each measured velocity.",
    ),
    number("simulation.sensors.delay_s", "s", DELAY, OURS, "Delay of all that is measured."),
    choice(
        "simulation.sensors.flag",
        &["gap", "force"],
        OURS,
        "What raises the flag of a contact point: a height of at most simulation.contact.flag_height_m, or a vertical force of more than simulation.sensors.flag_force_n.",
    ),
    number(
        "simulation.sensors.flag_force_n",
        "N",
        [0.0, 1e4],
        OURS,
        "Vertical force on a contact point above which its flag is up; flag \"force\" only.",
    ),
    choice(
        "simulation.sensors.loads",
        &["measured", "none"],
        OURS,
        "Whether the controller is told the vertical forces on the contact points.",
    ),
    number(
        "simulation.sensors.load_delay_s",
        "s",
        DELAY,
        OURS,
        "Delay of the measured forces on the contact points and of flags that are made of them, beside that of all that is measured.",
    ),
    number("simulation.actuators.delay_s", "s", DELAY, OURS, "Delay of the torque behind its command."),
    number(
        "simulation.actuators.lag_s",
        "s",
        DELAY,
        OURS,
        "Time constant of a first-order lag of the torque, behind its delay.",
    ),
    //
    number(
        "fall.min_com_height_fraction",
        "",
        [0.0, 0.99],
        OURS,
        "Height of the centre of mass below which the robot has fallen, as a share of that at the start.",
    ),
    number(
        "fall.max_torso_angle_deg",
        "deg",
        [1.0, 180.0],
        OURS,
        "Angle of the torso from its reference above which the robot has fallen.",
    ),
    number(
        "fall.max_joint_speed_radps",
        "rad/s",
        [1.0, 1e6],
        OURS,
        "Speed of a joint above which the numbers are out of bounds, which counts as a fall.",
    ),
    //
    number(
        "metrics.from_s",
        "s",
        ANY_TIME,
        OURS,
        "Time from which on the metrics count; recovery counts from the push.",
    ),
    number("metrics.com_error_from_s", "s", ANY_TIME, "thesis 7.1.3", "Time from which on the CoM error counts."),
    number(
        "metrics.recovered_within_m",
        "m",
        [1e-4, 10.0],
        OURS,
        "CoM error below which a pushed robot has recovered, if it stays so.",
    ),
    number(
        "metrics.followed_within_m",
        "m",
        [1e-4, 10.0],
        OURS,
        "Mean CoM error up to which a steady walk counts as following its reference.",
    ),
    number(
        "metrics.injurious_force_n",
        "N",
        [1.0, 1e6],
        "NATO RTO-TR-HFM-090 (2007): axial force in the lower leg",
        "Force on a contact point above which a run that ends on its feet counts as injurious.",
    ),
    //
    number("pushes.N.force_n", "N", [-1e6, 1e6], OURS, "Size of the push's force."),
    number(
        "pushes.N.direction_deg",
        "deg",
        [-360.0, 360.0],
        OURS,
        "Direction of the push: 0 is forward, 90 up, 180 backward.",
    ),
    number(
        "pushes.N.heading_deg",
        "deg",
        [-360.0, 360.0],
        OURS,
        "Angle by which the push is turned to the left about z; robots in space only.",
    ),
    number("pushes.N.start_s", "s", ANY_TIME, OURS, "Time at which the push begins."),
    number("pushes.N.duration_s", "s", SOME_TIME, OURS, "Time for which the push lasts."),
    setting(
        "pushes.N.at",
        Valid::Text,
        OURS,
        "Where the push acts: \"com\", the centre of mass, or the name of a body.",
    ),
    Setting {
        unit: "m",
        ..setting(
            "pushes.N.point_m",
            Valid::Row(&POINT),
            OURS,
            "Place of the push on its body, from the body's centre of mass.",
        )
    },
];
