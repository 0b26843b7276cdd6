//! What a diagnosis says: the first cause, and the events that led to the fall.

/// Why a robot fell.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnosis {
    /// What gave way first.
    pub cause: FirstCause,
    /// What happened, in the order of time; the last is the fall.
    pub events: Vec<Event>,
    /// One sentence with the time of the fall, the first cause and the chain.
    pub sentence: String,
}

/// The first cause of a fall; its rule is in `docs/diagnosis.md`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FirstCause {
    /// A joint had no more torque to give.
    TorqueLimit {
        /// Which.
        joint: String,
    },
    /// A joint's torque could not change faster.
    TorqueRate {
        /// Which.
        joint: String,
    },
    /// The force on a foot was at the controller's limit.
    ForceLimit {
        /// Which.
        foot: String,
    },
    /// A foot slid, or its force was at the friction cone.
    Friction {
        /// Which.
        foot: String,
    },
    /// The end of its range held a joint back.
    JointLimit {
        /// Which.
        joint: String,
    },
    /// Its largest speed held a joint back.
    SpeedLimit {
        /// Which.
        joint: String,
    },
    /// A joint was at its largest acceleration.
    AccelerationLimit {
        /// Which.
        joint: String,
    },
    /// A joint that no task held went where it went, to the end of its range.
    LooseJoint {
        /// Which.
        joint: String,
    },
    /// The ground below a foot was not where the controller believed it to be, rose in the way of a foot that swung, or had an edge where
    /// it came down.
    MissedGround {
        /// Which.
        foot: String,
    },
    /// Hard tasks contradicted the limits.
    InfeasibleProgram,
    /// No limit was in the way: the cost traded a task for the others, as its weights say.
    Outweighed {
        /// Which: `momentum`, `feet`, `torso`.
        task: &'static str,
    },
    /// The longest step that the reference generator makes did not reach the XcoM.
    StepTooShort,
    /// A push carried the XcoM further than legs can step, or came before what no limit explains.
    Push,
    /// The controller was told of the state late or with noise.
    Sensing,
    /// The simulation lost its footing, not the robot.
    Numerics,
    /// None of the rules holds.
    Unexplained,
}

impl FirstCause {
    /// Label and title of each cause, in the order in which they came: what a table of causes has as rows.
    pub const LABELS: [(&'static str, &'static str); 16] = [
        ("torque-limit", "torque limit"),
        ("torque-rate-limit", "torque rate limit"),
        ("force-limit", "contact force limit"),
        ("friction", "friction"),
        ("joint-limit", "end of a joint's range"),
        ("speed-limit", "joint speed limit"),
        ("acceleration-limit", "joint acceleration limit"),
        ("missed-ground", "ground in the way or not where it was believed"),
        ("infeasible-program", "infeasible program"),
        ("outweighed", "task outweighed in the cost"),
        ("step-too-short", "step too short"),
        ("push", "push too large"),
        ("sensing", "late or noisy sensing"),
        ("numerics", "numerics"),
        ("unexplained", "unexplained"),
        ("loose-joint", "joint that no task held"),
    ];

    fn index(&self) -> usize {
        match self {
            Self::TorqueLimit { .. } => 0,
            Self::TorqueRate { .. } => 1,
            Self::ForceLimit { .. } => 2,
            Self::Friction { .. } => 3,
            Self::JointLimit { .. } => 4,
            Self::SpeedLimit { .. } => 5,
            Self::AccelerationLimit { .. } => 6,
            Self::MissedGround { .. } => 7,
            Self::InfeasibleProgram => 8,
            Self::Outweighed { .. } => 9,
            Self::StepTooShort => 10,
            Self::Push => 11,
            Self::Sensing => 12,
            Self::Numerics => 13,
            Self::Unexplained => 14,
            Self::LooseJoint { .. } => 15,
        }
    }

    /// The cause without the name of joint or foot, as in `torque-limit`: what studies count.
    pub fn label(&self) -> &'static str {
        Self::LABELS[self.index()].0
    }

    /// The same for people, as in "torque limit".
    pub fn title(&self) -> &'static str {
        Self::LABELS[self.index()].1
    }

    /// The joint or foot that it names.
    pub fn part(&self) -> Option<&str> {
        match self {
            Self::TorqueLimit { joint }
            | Self::TorqueRate { joint }
            | Self::JointLimit { joint }
            | Self::LooseJoint { joint }
            | Self::SpeedLimit { joint }
            | Self::AccelerationLimit { joint } => Some(joint),
            Self::ForceLimit { foot } | Self::Friction { foot } | Self::MissedGround { foot } => Some(foot),
            Self::InfeasibleProgram
            | Self::Outweighed { .. }
            | Self::StepTooShort
            | Self::Push
            | Self::Sensing
            | Self::Numerics
            | Self::Unexplained => None,
        }
    }
}

/// Something that happened on the way to the fall.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// When [s].
    pub time: f64,
    /// What.
    pub what: What,
}

/// What happened.
#[derive(Clone, Debug, PartialEq)]
pub enum What {
    /// A push began.
    Pushed {
        /// Its impulse [Ns].
        impulse: f64,
    },
    /// A limit was active for a large share of a time.
    Saturated {
        /// Which.
        cause: FirstCause,
        /// Its value [Nm, Nm/s, rad/s and rad/s², of a joint that slides N, N/s, m/s and m/s²; N of a foot's force, 1 of friction];
        /// of a joint's range the end that held it back [rad or m].
        value: f64,
        /// For which share of the step or double support, 0 to 1.
        share: f64,
        /// How long in all [s].
        lasted: f64,
        /// The foot that swung, none in double support.
        swing: Option<String>,
    },
    /// A joint that no task held ran into the end of its range.
    RanLoose {
        /// Which.
        joint: String,
        /// The end [rad or m].
        end: f64,
    },
    /// A foot slid under load.
    Slid {
        /// Which.
        foot: String,
        /// How far [m].
        by: f64,
        /// The friction where it began.
        friction: f64,
        /// What the controller counted on there.
        believed: f64,
    },
    /// A swinging foot found no ground at the end of its path.
    MissedGround {
        /// Which.
        foot: String,
        /// How long its step lasted [s].
        lasted: f64,
        /// How much lower the ground is than the controller believed [m].
        lower: f64,
    },
    /// A foot of the walker landed on ground that was not where the controller believed it to be.
    Misstepped {
        /// Which.
        foot: String,
        /// How much lower the ground is [m], negative where it is higher.
        lower: f64,
    },
    /// A swinging foot met ground that is higher than where it left.
    Stubbed {
        /// Which.
        foot: String,
        /// How much higher [m].
        higher: f64,
    },
    /// A foot came down across an edge of the ground.
    Straddled {
        /// Which.
        foot: String,
        /// How far the edge stands above the sole [m].
        higher: f64,
    },
    /// The program let standing feet accelerate, and counted on forces that the ground did not give.
    Unmet {
        /// How much less it gave [N].
        force: f64,
        /// Acceleration that the task of the foot which misses most was given up by [m/s²].
        given_up: f64,
    },
    /// A push came before, and no limit explains what followed.
    Upset {
        /// Its impulse [Ns].
        impulse: f64,
        /// When it began [s].
        since: f64,
        /// Whether no foot touched the ground then.
        lifted: bool,
    },
    /// The controller was told of the state late or with noise, and no limit explains what followed.
    Misled {
        /// By how much it was late [s].
        delay: f64,
        /// Standard deviation of positions [rad or m] and velocities [rad/s or m/s].
        noise: [f64; 2],
    },
    /// The XcoM went out of the reach of all steps to come.
    OutOfReach {
        /// How far past `edge` [m].
        past: f64,
        /// The `front foot`, or of feet with soles the `toes` or `heels`.
        edge: &'static str,
        /// The longest step [m].
        longest: f64,
        /// How long it lasts [s], where that is given.
        lasts: Option<f64>,
        /// By how much the longest step falls short of where the XcoM will be [m].
        short: f64,
        /// The impulse of the pushes until then [Ns], where they are the first cause.
        pushed: Option<f64>,
    },
    /// The centre of mass sank for good.
    Sank {
        /// How far below its reference, by the end of the step or double support [m].
        by: f64,
        /// Upward force that the momentum task missed meanwhile [N].
        missed: f64,
    },
    /// The torso left its reference for good.
    Leaned {
        /// How far, by the end of the step or double support [rad], backward positive.
        by: f64,
        /// Angular acceleration that the torso task missed meanwhile [rad/s²].
        missed: f64,
    },
    /// A swinging foot left its path.
    FootAstray {
        /// Which.
        foot: String,
        /// How far short of its place it came down [m], negative beyond it; none where it did not come down.
        short: Option<f64>,
        /// How far it was off its path at most [m].
        off: f64,
        /// Acceleration that the foot task missed meanwhile [m/s²].
        missed: f64,
    },
    /// Hard tasks gave way, or no program had a solution.
    TasksYielded {
        /// In how many ticks.
        ticks: usize,
        /// Of how many.
        of: usize,
    },
    /// The program missed a task for the sake of the others, without a limit in the way.
    Outweighed {
        /// Which: `momentum`, `feet`, `torso`.
        task: &'static str,
        /// How many times as much as in the time before.
        times: f64,
    },
    /// The balance of energy broke.
    EnergyFromNothing {
        /// Its error [J].
        joules: f64,
    },
    /// The simulator's numbers went out of bounds.
    Diverged,
    /// Feet that should stand bounced on the damped spring.
    Bounced {
        /// Share of the time that they were off the ground, 0 to 1.
        share: f64,
    },
    /// The definition of a fall was met.
    Fell,
}
