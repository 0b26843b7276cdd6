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
    setting("name", Valid::Text, OURS, "Name; where a file gives none, its own."),
    setting("description", Valid::Text, OURS, "What the scenario shows, in a sentence."),
    setting("model", Valid::Text, OURS, "A built-in model, or a TOML or URDF file."),
    number("duration_s", "s", [1e-3, 1e6], OURS, "Simulated time."),
    setting(
        "seed",
        Valid::Integer { min: 0, max: i64::MAX },
        OURS,
        "Seed of sensor noise, model error and uneven ground.",
    ),
    //
    number("wearer.mass_kg", "kg", [20.0, 250.0], WINTER, "Mass of the person whose segments the robot has."),
    number(
        "wearer.height_m",
        "m",
        [1.0, 2.3],
        WINTER,
        "Height of that person; lengths of start pose and \"walker\" follow.",
    ),
    number("exoskeleton.torso_kg", "kg", [0.0, 100.0], OURS, "Mass that an exoskeleton adds to the torso."),
    number("exoskeleton.thigh_kg", "kg", [0.0, 50.0], OURS, "The same to each thigh."),
    number("exoskeleton.shank_kg", "kg", [0.0, 50.0], OURS, "The same to each shank."),
    number("exoskeleton.foot_kg", "kg", [0.0, 50.0], OURS, "The same to each foot."),
    //
    number("start.right_foot_x_m", "m", PLACE, FITTED, "Place of the right foot."),
    number("start.left_foot_x_m", "m", PLACE, FITTED, "Place of the left foot."),
    number("start.feet_width_m", "m", [0.0, 2.0], OURS, "Distance of the feet along y; robots in space only."),
    number("start.com_x_m", "m", PLACE, FITTED, "Place of the centre of mass."),
    number("start.com_height_m", "m", [0.05, 5.0], FITTED, "Height of the centre of mass above the ground below it."),
    number(
        "start.torso_angle_deg",
        "deg",
        TILT,
        FITTED,
        "Torso angle, counter-clockwise: leaning forward is negative.",
    ),
    //
    number("ground.friction", "", FRICTION, FITTED, "Coefficient of friction.").called("mu"),
    number("ground.slope_deg", "deg", SLOPE, "thesis, flat ground", "Slope, upward in x.").called("theta"),
    number(
        "ground.cross_slope_deg",
        "deg",
        SLOPE,
        OURS,
        "Slope across, upward in y; robots in space only. A controller that is not told the slopes assumes none across.",
    ),
    setting("ground.known", Valid::Bool, OURS, "Whether the controller is given the true friction and slopes."),
    setting("ground.profile", Valid::Rows(&PROFILE), OURS, "Heights above the plane, joined by straight lines."),
    number("ground.unevenness_m", "m", [0.0, 0.5], OURS, "Random heights besides, as much up and down."),
    number("ground.unevenness_spacing_m", "m", [0.02, 10.0], OURS, "Distance of the points that have them."),
    number("ground.unevenness_from_m", "m", PLACE, OURS, "Where they begin."),
    setting("ground.patches", Valid::Rows(&PATCHES), OURS, "Where the friction is another."),
    setting("ground.relief_known", Valid::Bool, OURS, "Whether the controller is given these five."),
    //
    choice(
        "reference.generator",
        &["steps", "stance", "walker"],
        OURS,
        "Steps after a moving centre of mass (thesis 4.3.1); planned standing, swaying, squatting; or a walk on feet.",
    ),
    choice(
        "reference.com.trajectory",
        &["stationary", "constant-velocity", "waypoints", "file"],
        GENERATOR,
        "How the centre of mass should move.",
    ),
    number("reference.com.speed_mps", "m/s", [-5.0, 5.0], OURS, "Forward speed of \"constant-velocity\"."),
    number("reference.com.ramp_s", "s", ANY_TIME, GENERATOR, "Time to ramp up to that speed; 0 is a step."),
    setting(
        "reference.com.waypoints",
        Valid::Rows(&TRAJECTORY_COLUMNS),
        OURS,
        "Points of \"waypoints\" in the world, at rest in each.",
    ),
    setting("reference.com.file", Valid::Text, OURS, "CSV file of \"file\" with the columns t_s, x_m, z_m."),
    //
    number("reference.step.duration_s", "s", [1e-2, 10.0], FITTED, "Time of a step.").called("t_T"),
    number("reference.step.height_m", "m", [0.0, 1.0], FITTED, "Height of the foot's arc.").called("h_s"),
    number("reference.step.min_length_m", "m", LENGTH, FITTED, "Least step length."),
    choice(
        "reference.step.min_length_is",
        &["displacement", "base-of-support"],
        OURS,
        "What that is the least of: a foot's way, or the distance of the feet after the step.",
    ),
    number("reference.step.max_length_m", "m", LENGTH, FITTED, "Longest displacement of a foot.").called("l_s"),
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
        "How far the XcoM may leave the base of support before a step, as time at reference speed.",
    ),
    number("reference.step.max_delay_m", "m", LENGTH, FITTED, "The most that it may leave it."),
    choice("reference.step.replan", &["never", "in-swing"], GENERATOR, "When the step length is planned again."),
    //
    setting(
        "reference.stance.sway_m",
        Valid::Row(&SWAY),
        OURS,
        "Amplitude of the sway of the centre of mass ahead, to the left and up.",
    )
    .measured_in("m"),
    number("reference.stance.squat_m", "m", [0.0, 1.0], OURS, "Depth of a squat."),
    number("reference.stance.period_s", "s", [0.1, 100.0], OURS, "Time of one sway and one squat."),
    choice("reference.stance.lift", &["none", "right", "left"], OURS, "Which foot is lifted."),
    number(
        "reference.stance.lift_start_s",
        "s",
        ANY_TIME,
        OURS,
        "When the centre of mass begins to move above the other foot.",
    ),
    number("reference.stance.lift_duration_s", "s", SOME_TIME, OURS, "How long the foot is off the ground."),
    number("reference.stance.lift_height_m", "m", [0.0, 1.0], OURS, "How high it is lifted."),
    number("reference.stance.swing_m", "m", [0.0, 1.0], OURS, "How far it swings forward and back."),
    //
    number("reference.walker.speed_mps", "m/s", [-2.0, 2.5], OURS, "Commanded speed, negative backward."),
    setting(
        "reference.walker.speeds",
        Valid::Rows(&SPEEDS),
        OURS,
        "A commanded speed that changes: rows of time and speed, linear between them.",
    ),
    number(
        "reference.walker.speed_change_mps",
        "m/s",
        [0.0, 2.0],
        FEET,
        "Most that the speed changes from step to step.",
    ),
    setting(
        "reference.walker.march",
        Valid::Bool,
        OURS,
        "Whether it steps in place where the commanded speed is zero.",
    ),
    setting(
        "reference.walker.schedule",
        Valid::Rows(&SCHEDULE),
        FEET,
        "What changes with the speed: step time, height of the centre of mass, its bob and the share of the step after which it is lowest, time from the heel's lift-off to the landing.",
    ),
    number(
        "reference.walker.climb_lowering_m",
        "m",
        [0.0, 2.0],
        OURS,
        "How much lower the centre of mass is uphill, for a steepness of 1.",
    ),
    number(
        "reference.walker.unseen_com_height_m",
        "m",
        [0.0, 2.0],
        OURS,
        "Its largest height where that of the ground is not known.",
    ),
    number("reference.walker.double_support_s", "s", [0.01, 1.0], FEET, "Time in which the rear foot is unloaded."),
    number(
        "reference.walker.unloading",
        "",
        [0.0, 10.0],
        FEET,
        "Most that the rear foot carries as it begins to be unloaded, in weights.",
    ),
    number(
        "reference.walker.way_gain",
        "1/s",
        [0.0, 10.0],
        FEET,
        "Speed that an error in the place of the centre of mass adds.",
    ),
    number(
        "reference.walker.cop_gain",
        "1/s",
        [0.0, 100.0],
        FEET,
        "What an error of the XcoM moves the centre of pressure by.",
    )
    .called("k"),
    number(
        "reference.walker.cop_margin_m",
        "m",
        [0.0, 0.1],
        FEET,
        "The centre of pressure stays that far inside of the foot.",
    ),
    number(
        "reference.walker.cop_centre_m",
        "m",
        [-0.2, 0.3],
        FEET,
        "Middle of the centre of pressure's way over a step, from the ankle.",
    )
    .called("p_c"),
    number("reference.walker.cop_span_m", "m", [0.0, 1.0], FEET, "Most that the centre of pressure moves in a step."),
    number("reference.walker.cop_span_share", "", [0.0, 2.0], FEET, "The same as a share of the step length."),
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
        "How far beyond the feet a turn of the torso shifts the centre of pressure at most; zero forbids it.",
    ),
    number(
        "reference.walker.hip_acceleration_radps2",
        "rad/s²",
        [0.1, 100.0],
        OURS,
        "Angular acceleration of the torso that does that.",
    ),
    number("reference.walker.hip_lean_rad", "rad", [0.01, 1.5], OURS, "The most that the torso leans away for it."),
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
        "Weight of a change of the step's time against one of its place.",
    ),
    number(
        "reference.walker.offset_weight",
        "",
        WEIGHT,
        FEET,
        "Weight of the XcoM's error at the step's end against a change of its place.",
    ),
    number("reference.walker.shortest_swing_s", "s", [0.05, 10.0], FEET, "Shortest swing."),
    number("reference.walker.longest_step_s", "s", [0.1, 10.0], FEET, "Longest step."),
    number("reference.walker.longest_m", "m", LENGTH, FEET, "Farthest that a foot lands before the other."),
    number("reference.walker.longest_back_m", "m", LENGTH, FEET, "Farthest that it lands behind it."),
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
        "Longest way from hip to ankle that a place of landing may need.",
    ),
    number(
        "reference.walker.stretched_leg_m",
        "m",
        [0.1, 2.0],
        OURS,
        "Way from hip to ankle at which the heel lifts where a step is prolonged.",
    ),
    number("reference.walker.hip_below_com_m", "m", LENGTH, FEET, "How far the hip is below the centre of mass."),
    number(
        "reference.walker.longest_drop_m",
        "m",
        [0.0, 0.5],
        OURS,
        "Most that the centre of mass is lowered for a long step.",
    ),
    number("reference.walker.drop_acceleration_mps2", "m/s2", [0.1, 100.0], OURS, "Largest acceleration of that."),
    number("reference.walker.clearance_m", "m", [0.0, 1.0], FEET, "Height of the swinging toe."),
    number("reference.walker.heel_off_from_m", "m", LENGTH, OURS, "Steps longer than this end with a heel-off."),
    number(
        "reference.walker.heel_off_turn",
        "rad/m",
        [0.0, 10.0],
        FEET,
        "Turn of a foot over its toe, a metre of step length.",
    ),
    number("reference.walker.heel_off_max_rad", "rad", [0.0, 1.5], FEET, "The most that it turns."),
    number(
        "reference.walker.touchdown_force_n",
        "N",
        [0.0, 1e4],
        FEET,
        "A swinging foot that carries this has touched down.",
    ),
    number("reference.walker.settling_s", "s", [0.0, 1.0], OURS, "How long before it lands a foot is above its place."),
    number("reference.walker.landing_speed_mps", "m/s", [0.0, 5.0], FEET, "Speed at which a foot meets the ground."),
    number(
        "reference.walker.unseen_landing_speed_mps",
        "m/s",
        [0.0, 5.0],
        OURS,
        "The same where the ground's height is not known.",
    ),
    number(
        "reference.walker.landing_acceleration_mps2",
        "m/s2",
        [0.1, 1e3],
        FEET,
        "How fast it gets faster where it does not find the ground in time.",
    ),
    //
    choice(
        "controller.kind",
        &["momentum", "hold"],
        OURS,
        "Which controller drives the robot: the quadratic program, or a spring and a damper at each joint that hold the start pose.",
    ),
    number("controller.period_s", "s", PERIOD, OURS, "Time between two ticks; a whole multiple of the physics period."),
    choice("controller.form", &["direct", "slack"], OURS, "Form of the quadratic program; both have one optimum."),
    number(
        "controller.assumed_friction",
        "",
        FRICTION,
        OURS,
        "Friction that the controller assumes where the ground is not known.",
    ),
    number("controller.assumed_slope_deg", "deg", SLOPE, OURS, "Slope that it assumes where the ground is not known."),
    //
    number("controller.planner.angular_momentum_gain", "1/s", GAIN, FITTED, "Angular momentum to its rate.")
        .called("P_theta"),
    number("controller.planner.com_gain", "N/m", GAIN, FINAL, "CoM error to force.").called("P_C"),
    number("controller.planner.foot_gain", "1/s²", GAIN, FINAL, "Foot error to acceleration.").called("P_f"),
    number(
        "controller.planner.foot_rotation_gain",
        "1/s²",
        GAIN,
        OURS,
        "Foot orientation error to angular acceleration; feet with several contact points.",
    ),
    number("controller.planner.torso_gain", "1/s²", GAIN, FITTED, "Torso angle error to angular acceleration.")
        .called("P_a"),
    number(
        "controller.planner.posture_gain",
        "1/s²",
        GAIN,
        OURS,
        "Joint position error to acceleration, of the posture.",
    ),
    choice(
        "controller.planner.damping",
        &["printed", "critical"],
        "thesis 6.3.7",
        "Damping gains: D = sqrt(2 m P) as printed (ratio 0.71), or critical, D = 2 sqrt(m P).",
    ),
    number(
        "controller.planner.max_horizontal_momentum_rate_n",
        "N",
        [0.0, 1e6],
        FITTED,
        "Largest horizontal momentum rate asked for.",
    ),
    number("controller.planner.torso_angle_deg", "deg", TILT, "thesis (4.6)", "Torso angle asked for."),
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
        "What the angular rows of the momentum weigh against the linear ones.",
    ),
    number(
        "controller.weights.vertical_momentum_factor",
        "",
        WEIGHT,
        OURS,
        "What the momentum's vertical row weighs against the horizontal ones.",
    ),
    number("controller.weights.feet", "", WEIGHT, FINAL, "Weight of the feet's acceleration error.").called("C_f"),
    number(
        "controller.weights.swing_feet_factor",
        "",
        WEIGHT,
        OURS,
        "What a swinging foot's place weighs against a standing one's.",
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
        "What a swinging foot's turn weighs against a standing one's.",
    ),
    number(
        "controller.weights.rolling_rotation_factor",
        "",
        WEIGHT,
        OURS,
        "What the turn of a foot that rolls over its toe weighs against a standing one's.",
    ),
    number(
        "controller.weights.trailing_rotation_factor",
        "",
        WEIGHT,
        OURS,
        "The same while it hands its load to the other foot.",
    ),
    number("controller.weights.torso", "", WEIGHT, FINAL, "Weight of the torso's angular acceleration error.")
        .called("C_a"),
    number(
        "controller.weights.torso_urgency_s4",
        "s4",
        WEIGHT,
        OURS,
        "What the square of the torso's wanted acceleration raises its weight by.",
    ),
    number(
        "controller.weights.posture",
        "",
        WEIGHT,
        OURS,
        "Weight of the joint accelerations toward the posture of the first tick.",
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
        &["off", "cost", "equality"],
        OURS,
        "How the posture of the first tick is tracked by the actuated joints, if it is.",
    ),
    //
    number("controller.limits.torque_nm", "Nm", [0.1, 1e5], FINAL, "Largest joint torque."),
    number(
        "controller.limits.torque_rate_nmps",
        "Nm/s",
        [1.0, 1e9],
        OURS,
        "Largest change of a joint's torque; the default is none to speak of.",
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
        "How a joint is kept within its limits.",
    ),
    number(
        "controller.limits.approach_rate_1ps",
        "1/s",
        [1.0, 1e3],
        OURS,
        "Rate of \"approach\": a joint comes to its limit no faster than critically damped with it.",
    ),
    //
    number(
        "controller.hold.stiffness_nmprad",
        "Nm/rad",
        [0.0, 1e6],
        OURS,
        "Torque of the controller \"hold\" for a joint angle off its start.",
    ),
    number(
        "controller.hold.damping_nmsprad",
        "Nms/rad",
        [0.0, 1e5],
        OURS,
        "Torque of the controller \"hold\" against a joint's velocity.",
    ),
    //
    number("simulation.period_s", "s", PERIOD, OURS, "Time step of the physics."),
    choice(
        "simulation.integrator",
        &["semi-implicit-euler", "midpoint"],
        OURS,
        "How the state is advanced: new velocity first, or Moreau's midpoint.",
    ),
    number(
        "simulation.model_error",
        "",
        [0.0, 0.5],
        OURS,
        "Share by which mass, centre of mass and inertia of each body differ at most from those that the controller knows; by seed.",
    ),
    //
    choice("simulation.contact.model", &["rigid", "spring-damper"], "thesis 3.3", "The law of the ground."),
    number(
        "simulation.contact.flag_height_m",
        "m",
        [0.0, 0.1],
        OURS,
        "A contact point below this height counts as touching for the controller.",
    ),
    number(
        "simulation.contact.penetration_recovery",
        "",
        [0.0, 1.0],
        OURS,
        "Share of a penetration that is undone in a step (rigid).",
    ),
    number("simulation.contact.relaxation", "", [1e-3, 1.0], OURS, "Relaxation of the sweeps (rigid).").called("alpha"),
    number(
        "simulation.contact.tolerance_n",
        "N",
        [1e-12, 1e3],
        OURS,
        "Sweeps end when no impulse changes by more than this, as force (rigid).",
    ),
    setting(
        "simulation.contact.max_sweeps",
        Valid::Integer { min: 1, max: 100_000 },
        OURS,
        "Most sweeps in a step (rigid).",
    ),
    number("simulation.contact.stiffness_npm", "N/m", [1.0, 1e9], OURS, "Normal stiffness (spring-damper)."),
    number("simulation.contact.damping_nspm", "Ns/m", [0.0, 1e7], OURS, "Normal damping (spring-damper)."),
    number(
        "simulation.contact.slip_speed_mps",
        "m/s",
        [1e-6, 10.0],
        OURS,
        "Slip speed at which friction is fully developed (spring-damper).",
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
    number("simulation.sensors.delay_s", "s", DELAY, OURS, "Delay of the measured state."),
    number("simulation.actuators.delay_s", "s", DELAY, OURS, "Delay of the torque."),
    number("simulation.actuators.lag_s", "s", DELAY, OURS, "Time constant of a first-order lag behind that delay."),
    //
    number(
        "fall.min_com_height_fraction",
        "",
        [0.0, 0.99],
        OURS,
        "Fallen below this CoM height, as a share of the start's.",
    ),
    number("fall.max_torso_angle_deg", "deg", [1.0, 180.0], OURS, "Fallen above this torso angle from its reference."),
    number("fall.max_joint_speed_radps", "rad/s", [1.0, 1e6], OURS, "Out of bounds above this joint speed."),
    //
    number("metrics.from_s", "s", ANY_TIME, OURS, "Figures count from this time; recovery counts from the push."),
    number("metrics.com_error_from_s", "s", ANY_TIME, "thesis 7.1.3", "The CoM error counts from this time."),
    number("metrics.recovered_within_m", "m", [1e-4, 10.0], OURS, "Recovered: the CoM error stays below this."),
    //
    number("pushes.N.force_n", "N", [-1e6, 1e6], OURS, "Size of the force."),
    number("pushes.N.direction_deg", "deg", [-360.0, 360.0], OURS, "0 is forward, 90 up, 180 backward."),
    number(
        "pushes.N.heading_deg",
        "deg",
        [-360.0, 360.0],
        OURS,
        "How far it is turned to the left about z; robots in space only.",
    ),
    number("pushes.N.start_s", "s", ANY_TIME, OURS, "When it begins."),
    number("pushes.N.duration_s", "s", SOME_TIME, OURS, "How long it lasts."),
    setting("pushes.N.at", Valid::Text, OURS, "\"com\" or the name of a body."),
    Setting {
        unit: "m",
        ..setting("pushes.N.point_m", Valid::Row(&POINT), OURS, "Where on that body, from its centre of mass.")
    },
];
