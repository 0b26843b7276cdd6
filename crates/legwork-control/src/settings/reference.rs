//! The reference generator: what the centre of mass and the feet should do (thesis 4.3.1).

use serde::{Deserialize, Serialize};

/// The reference generator (thesis 4.3.1).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReferenceSettings {
    /// Which generator.
    pub generator: GeneratorKind,
    /// The centre of mass.
    pub com: ComSettings,
    /// The steps of the generator `steps`.
    pub step: StepSettings,
    /// The generator `stance`.
    pub stance: StanceSettings,
    /// The generator `walker`.
    pub walker: WalkerSettings,
}

/// The desired motion of the centre of mass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ComSettings {
    /// Its kind.
    pub trajectory: TrajectoryKind,
    /// Forward speed of `constant-velocity` [m/s].
    pub speed_mps: f64,
    /// Time to ramp up to that speed [s]; zero is the thesis's velocity step.
    pub ramp_s: f64,
    /// Rows `[t_s, x_m, z_m]` of `waypoints`, in the world.
    pub waypoints: Vec<[f64; 3]>,
    /// CSV file of `file`, with the columns `t_s,x_m,z_m`.
    pub file: String,
}

/// When and where the robot steps (thesis 4.3.1, Figure 4.2).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StepSettings {
    /// `t_T`: time of a step [s].
    pub duration_s: f64,
    /// `h_s`: height of the foot's arc [m].
    pub height_m: f64,
    /// Least step length [m].
    pub min_length_m: f64,
    /// What that is the least of.
    pub min_length_is: LeastStep,
    /// Longest displacement of a foot [m].
    pub max_length_m: f64,
    /// Share of the distance to the predicted XcoM that is added to it.
    pub overshoot: f64,
    /// How far the XcoM may leave the base of support, as time at reference speed [s].
    pub delay_s: f64,
    /// The most that it may leave it [m].
    pub max_delay_m: f64,
    /// Whether the step length is planned again in the swing.
    pub replan: Replan,
}

/// Standing, swaying, squatting, lifting a foot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StanceSettings {
    /// Amplitude of the CoM's sway along x, y, z [m].
    pub sway_m: [f64; 3],
    /// Depth of a squat [m].
    pub squat_m: f64,
    /// Time of one sway and one squat [s].
    pub period_s: f64,
    /// Which foot is lifted.
    pub lift: Lift,
    /// When the CoM begins to move above the other foot [s].
    pub lift_start_s: f64,
    /// Time in which the CoM moves there, or back [s].
    pub shift_s: f64,
    /// How long the foot is off the ground [s].
    pub lift_duration_s: f64,
    /// How high it is lifted [m].
    pub lift_height_m: f64,
    /// How far it swings forward and back [m].
    pub swing_m: f64,
}

/// Walking on feet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WalkerSettings {
    /// Commanded speed, negative backward [m/s].
    pub speed_mps: f64,
    /// Rows `[t_s, speed_mps]` of a commanded speed that changes; it is linear between them.
    pub speeds: Vec<[f64; 2]>,
    /// Most that the speed changes from step to step [m/s].
    pub speed_change_mps: f64,
    /// Whether it steps in place where the commanded speed is zero.
    pub march: bool,
    /// Rows `[speed_mps, step_time_s, com_height_m, bob_m, lowest, heel_off_s]`: what changes with the speed; linear between
    /// them.
    pub schedule: Vec<[f64; 6]>,
    /// How much lower the centre of mass is on ground that rises, for a steepness of 1 [m]; where the ground is not known, half as much on
    /// ground that falls.
    pub climb_lowering_m: f64,
    /// Largest height of the centre of mass where the controller does not know how high the ground is [m].
    pub unseen_com_height_m: f64,
    /// Time in which the rear foot is unloaded [s].
    pub double_support_s: f64,
    /// Most that the rear foot carries as it begins to be unloaded, in weights.
    pub unloading: f64,
    /// Speed that an error in the place of the centre of mass adds [1/s].
    pub way_gain: f64,
    /// `k`: what the error of the XcoM is multiplied with to move the centre of pressure [1/s].
    pub cop_gain: f64,
    /// The centre of pressure stays that far inside of the foot [m].
    pub cop_margin_m: f64,
    /// Its middle over a step, from the ankle [m].
    pub cop_centre_m: f64,
    /// Most that it moves in a step [m].
    pub cop_span_m: f64,
    /// As far as a share of the step length allows.
    pub cop_span_share: f64,
    /// How far the XcoM may leave the feet before a standing robot steps [m].
    pub stand_margin_m: f64,
    /// How far beyond the feet a turn of the torso shifts the centre of pressure at most [m]; zero forbids it.
    pub hip_shift_m: f64,
    /// Angular acceleration of the torso that does that [rad/s²].
    pub hip_acceleration_radps2: f64,
    /// The most that the torso leans away for it [rad].
    pub hip_lean_rad: f64,
    /// What a step under way may change.
    pub adaptation: Adaptation,
    /// Weight of a change of the step's time against one of its place [m²/s²].
    pub time_weight: f64,
    /// Weight of the XcoM's error at the step's end against a change of its place.
    pub offset_weight: f64,
    /// Shortest swing [s].
    pub shortest_swing_s: f64,
    /// Longest step [s].
    pub longest_step_s: f64,
    /// Farthest that a foot lands before the other [m].
    pub longest_m: f64,
    /// Farthest that it lands behind it [m].
    pub longest_back_m: f64,
    /// Largest acceleration of the swinging foot [m/s²].
    pub swing_acceleration_mps2: f64,
    /// Longest way from hip to ankle that a place of landing may need [m].
    pub leg_m: f64,
    /// The heel lifts where a step is prolonged and hip and ankle are that far apart [m].
    pub stretched_leg_m: f64,
    /// How far the hip is below the centre of mass [m].
    pub hip_below_com_m: f64,
    /// The most that the centre of mass is lowered for a long step [m].
    pub longest_drop_m: f64,
    /// Largest acceleration of that [m/s²].
    pub drop_acceleration_mps2: f64,
    /// Height of the swinging toe [m].
    pub clearance_m: f64,
    /// Steps longer than this end with a heel-off [m].
    pub heel_off_from_m: f64,
    /// Length of the steps from which on it does so in full [m]; between the two it does the more the longer the step is.
    pub heel_off_full_m: f64,
    /// Turn of a foot over its toe, a metre of step length [rad/m].
    pub heel_off_turn: f64,
    /// The most that it turns [rad].
    pub heel_off_max_rad: f64,
    /// A foot that carries this has touched down [N].
    pub touchdown_force_n: f64,
    /// How long before it lands a foot is above its place [s].
    pub settling_s: f64,
    /// Speed at which a foot meets the ground [m/s].
    pub landing_speed_mps: f64,
    /// The same where the controller does not know how high the ground is.
    pub unseen_landing_speed_mps: f64,
    /// How fast it gets faster where it does not find the ground in time [m/s²].
    pub landing_acceleration_mps2: f64,
    /// Unit of the lengths in the walker's own rules: a metre of a robot with a person's legs [m].
    pub unit_m: f64,
    /// Unit of the times in them: a second of such a robot [s].
    pub unit_s: f64,
}

/// How the centre of mass should move (thesis 4.3.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TrajectoryKind {
    /// Stay where the run started.
    Stationary,
    /// Constant forward velocity, with an optional linear ramp from rest.
    ConstantVelocity,
    /// Minimum-jerk motion between points, at rest in each.
    Waypoints,
    /// Samples from a CSV file, joined by a cubic spline.
    File,
}

/// What the feet and the centre of mass should do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GeneratorKind {
    /// The CoM follows its trajectory, and the feet step when the XcoM leaves the base of support (thesis 4.3.1).
    Steps,
    /// The robot stands, sways, squats or lifts a foot, as planned beforehand.
    Stance,
    /// Walking on feet at a commanded speed: the XcoM follows a plan, and steps are adapted while under way.
    Walker,
}

/// What a step under way may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Adaptation {
    /// Nothing.
    None,
    /// Where it ends.
    Place,
    /// Where and when it ends.
    PlaceAndTime,
}

/// Which foot is lifted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Lift {
    /// None.
    None,
    /// The right one.
    Right,
    /// The left one.
    Left,
}

/// Whether the step length is planned once or again while the foot swings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Replan {
    /// Once, when the step is triggered (thesis).
    Never,
    /// At every tick of the swing.
    InSwing,
}

/// What the least step length is to prevent (thesis 4.3.1 says: a base of support that becomes too small).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LeastStep {
    /// A foot that moves less than that.
    Displacement,
    /// Feet that stand closer together than that after the step.
    BaseOfSupport,
}

/// A constant speed that is commanded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CommandedSpeed {
    /// The setting that commands it.
    pub path: &'static str,
    /// It, negative backward [m/s].
    pub speed_mps: f64,
    /// From when on a robot that starts from rest should go at it [s].
    pub steady_from_s: f64,
}

impl ReferenceSettings {
    /// The speed that is commanded; none where the generator has no speed, or one that changes.
    pub fn commanded_speed(&self) -> Option<CommandedSpeed> {
        let (com, walker) = (&self.com, &self.walker);
        match self.generator {
            GeneratorKind::Steps if com.trajectory == TrajectoryKind::ConstantVelocity => Some(CommandedSpeed {
                path: "reference.com.speed_mps",
                speed_mps: com.speed_mps,
                steady_from_s: com.ramp_s,
            }),
            GeneratorKind::Walker if walker.speeds.is_empty() => Some(CommandedSpeed {
                path: "reference.walker.speed_mps",
                speed_mps: walker.speed_mps,
                steady_from_s: walker.time_to(walker.speed_mps),
            }),
            _ => None,
        }
    }
}

impl WalkerSettings {
    /// How long it takes from rest to a steady walk at `speed` [s]: the steps in which it speeds up, and once the time
    /// constant with which it catches up with the way that it lost in them. Infinite where it cannot speed up.
    fn time_to(&self, speed: f64) -> f64 {
        let steps = if speed == 0.0 { 0.0 } else { (speed.abs() / self.speed_change_mps).ceil() };
        steps * self.scheduled(speed)[0] + if self.way_gain > 0.0 { 1.0 / self.way_gain } else { 0.0 }
    }

    /// A length of the walker's own rules [m].
    #[inline]
    pub(crate) fn in_length(&self, of_a_person: f64) -> f64 {
        of_a_person * self.unit_m
    }

    /// A time of them [s].
    #[inline]
    pub(crate) fn in_time(&self, of_a_person: f64) -> f64 {
        of_a_person * self.unit_s
    }

    /// A speed of them [m/s].
    #[inline]
    pub(crate) fn in_speed(&self, of_a_person: f64) -> f64 {
        of_a_person * (self.unit_m / self.unit_s)
    }

    /// How much of a heel-off a step of `length` [m] ends with, from 0 to 1.
    pub(crate) fn heel_off_share(&self, length: f64) -> f64 {
        let (from, full) = (self.heel_off_from_m, self.heel_off_full_m);
        if length <= from { 0.0 } else { ((length - from) / (full - from).max(f64::MIN_POSITIVE)).min(1.0) }
    }

    /// What the schedule has for `speed` [m/s]: step time [s], height of the centre of mass [m], its bob [m], the
    /// share of the step after which it is lowest, heel-off [s].
    ///
    /// # Panics
    /// Where the schedule has no row; a scenario that was read has one.
    pub fn scheduled(&self, speed: f64) -> [f64; 5] {
        let (rows, speed) = (&self.schedule, speed.abs());
        let after = rows.partition_point(|row| row[0] <= speed);
        let (a, b) = (rows[after.saturating_sub(1)], rows[after.min(rows.len() - 1)]);
        let share = if a[0] < b[0] { ((speed - a[0]) / (b[0] - a[0])).clamp(0.0, 1.0) } else { 0.0 };
        std::array::from_fn(|k| a[k + 1] + share * (b[k + 1] - a[k + 1]))
    }

    /// Height of the hip above the ankle of a foot below it, where the centre of mass and the ankle are `com` and `ankle` above the
    /// ground [m].
    pub fn hip_above_ankle(&self, com: f64, ankle: f64) -> f64 {
        com - self.hip_below_com_m - ankle
    }

    /// Farthest that an ankle lands before the centre of mass on level ground at `speed` [m/s], where `ankle` is its height above the
    /// ground and the centre of mass is `lowered` for it [m].
    pub fn farthest_ahead(&self, speed: f64, ankle: f64, lowered: f64) -> f64 {
        let [_, height, bob, ..] = self.scheduled(speed);
        let hip = self.hip_above_ankle(height - 0.5 * bob, ankle) - lowered;
        (self.leg_m * self.leg_m - hip * hip).max(0.0).sqrt()
    }

    /// The settings for a robot whose legs are longer by `leg` and whose centre of mass is higher above its hips by `com` [m]: knees and
    /// hips go on as they did.
    #[must_use]
    pub fn for_build(&self, leg: f64, com: f64) -> Self {
        let mut built = self.clone();
        built.schedule.iter_mut().for_each(|[_, _, com_height, ..]| *com_height += leg + com);
        built.unseen_com_height_m += leg + com;
        built.hip_below_com_m += com;
        built.leg_m += leg;
        built.stretched_leg_m += leg;
        built
    }

    /// The settings for a robot whose lengths are `stature` times those that they are for. Times follow the square root,
    /// as for pendulums (Hof 1996); speeds stay what is commanded.
    #[must_use]
    pub fn for_stature(&self, stature: f64) -> Self {
        let mut scaled = self.clone();
        let time = libm::sqrt(stature);
        for [speed, step_time, com_height, bob, _lowest, heel_off] in &mut scaled.schedule {
            *speed *= time;
            *step_time *= time;
            *com_height *= stature;
            *bob *= stature;
            *heel_off *= time;
        }
        for length in [
            &mut scaled.climb_lowering_m,
            &mut scaled.unseen_com_height_m,
            &mut scaled.cop_margin_m,
            &mut scaled.cop_centre_m,
            &mut scaled.cop_span_m,
            &mut scaled.stand_margin_m,
            &mut scaled.hip_shift_m,
            &mut scaled.longest_m,
            &mut scaled.longest_back_m,
            &mut scaled.leg_m,
            &mut scaled.stretched_leg_m,
            &mut scaled.hip_below_com_m,
            &mut scaled.longest_drop_m,
            &mut scaled.clearance_m,
            &mut scaled.heel_off_from_m,
            &mut scaled.heel_off_full_m,
        ] {
            *length *= stature;
        }
        scaled.heel_off_turn /= stature;
        scaled.hip_acceleration_radps2 /= stature;
        for duration in [
            &mut scaled.double_support_s,
            &mut scaled.settling_s,
            &mut scaled.shortest_swing_s,
            &mut scaled.longest_step_s,
        ] {
            *duration *= time;
        }
        scaled
    }
}

impl Default for ReferenceSettings {
    fn default() -> Self {
        Self {
            generator: GeneratorKind::Steps,
            com: ComSettings {
                trajectory: TrajectoryKind::Stationary,
                speed_mps: 0.0,
                ramp_s: 0.0,
                waypoints: Vec::new(),
                file: String::new(),
            },
            step: StepSettings {
                duration_s: 0.225,
                height_m: 0.062,
                min_length_m: 0.59,
                min_length_is: LeastStep::Displacement,
                max_length_m: 1.05,
                overshoot: 0.1,
                delay_s: 0.2,
                max_delay_m: 0.15,
                replan: Replan::Never,
            },
            stance: StanceSettings {
                sway_m: [0.0; 3],
                squat_m: 0.0,
                period_s: 2.0,
                lift: Lift::None,
                lift_start_s: 1.0,
                shift_s: 1.5,
                lift_duration_s: 2.0,
                lift_height_m: 0.05,
                swing_m: 0.0,
            },
            walker: WalkerSettings {
                speed_mps: 1.0,
                speeds: Vec::new(),
                speed_change_mps: 0.25,
                march: false,
                schedule: vec![
                    [0.0, 0.515, 0.958, 0.0, 0.38, 0.145],
                    [0.5, 0.523, 1.003, 0.008, 0.3, 0.134],
                    [1.0, 0.5691, 0.9799, 0.01, 0.35, 0.18],
                    [1.25, 0.4761, 0.9533, 0.017, 0.5, 0.1188],
                ],
                climb_lowering_m: 0.3,
                unseen_com_height_m: 0.92,
                double_support_s: 0.094,
                unloading: 1.71,
                way_gain: 0.6,
                cop_gain: 5.27,
                cop_margin_m: 0.012,
                cop_centre_m: 0.0744,
                cop_span_m: 0.148,
                cop_span_share: 1.18,
                stand_margin_m: 0.02,
                hip_shift_m: 0.15,
                hip_acceleration_radps2: 14.0,
                hip_lean_rad: 0.6,
                adaptation: Adaptation::PlaceAndTime,
                time_weight: 0.147,
                offset_weight: 152.0,
                shortest_swing_s: 0.2,
                longest_step_s: 1.17,
                longest_m: 1.1,
                longest_back_m: 0.45,
                swing_acceleration_mps2: 62.0,
                leg_m: 0.817,
                stretched_leg_m: 0.845,
                hip_below_com_m: 0.105,
                longest_drop_m: 0.1,
                drop_acceleration_mps2: 3.0,
                clearance_m: 0.0638,
                heel_off_from_m: 0.15,
                heel_off_full_m: 0.25,
                heel_off_turn: 1.78,
                heel_off_max_rad: 1.1,
                touchdown_force_n: 20.0,
                settling_s: 0.0124,
                landing_speed_mps: 0.0307,
                unseen_landing_speed_mps: 0.3,
                landing_acceleration_mps2: 5.0,
                unit_m: 1.0,
                unit_s: 1.0,
            },
        }
    }
}
