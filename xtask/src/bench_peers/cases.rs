//! What is measured: the cases, who takes part, and how their inputs are made.

/// The names that `--only` takes.
pub(super) const GROUPS: [&str; 5] = ["dynamics", "qp", "tick", "contact", "loop"];

/// How a contender's answers are judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Judge {
    /// Same quantities: the largest difference from ours.
    Values,
    /// Points of quadratic programs: rows and bounds met, difference of the point from ours.
    Programs,
    /// Velocities after a step: the difference from ours.
    Velocities,
    /// Other problems, as each contender formulates its own: nothing to compare.
    Nothing,
}

/// One table of the page.
#[derive(Clone, Debug)]
pub(super) struct Case {
    pub(super) key: &'static str,
    pub(super) group: &'static str,
    pub(super) title: &'static str,
    pub(super) judge: Judge,
    /// Calls of our example that make the inputs; `@` stands for the data folder.
    pub(super) prepare: Vec<&'static str>,
    /// Our call, without the output.
    pub(super) ours: &'static str,
    /// A peer of [`super::setup`] and its arguments without the output.
    pub(super) peers: Vec<(&'static str, &'static str)>,
}

/// Makes the exoskeleton's files.
const EXO18: &str = "model models/exo18.urdf @/exo18";

/// The solvers, in the order of the tables.
const SOLVERS: [&str; 7] = ["eiquadprog-fast", "quadprog", "PIQP", "ProxQP", "Clarabel", "OSQP", "qpOASES"];

/// All cases.
pub(super) fn all() -> Vec<Case> {
    vec![
        dynamics(
            "dynamics-planar7",
            "Dynamics of a tick, planar humanoid, 7 coordinates",
            vec!["model planar_humanoid @/planar7", "states planar_humanoid 2000 @/planar7.states"],
            "dynamics planar_humanoid @/planar7.states",
            "@/planar7 @/planar7.states",
        ),
        dynamics(
            "dynamics-exo18",
            "Dynamics of a tick, exo18, 18 coordinates",
            vec![EXO18, "states models/exo18.urdf 2000 @/exo18.states"],
            "dynamics models/exo18.urdf @/exo18.states",
            "@/exo18 @/exo18.states",
        ),
        programs(
            "qp-slack",
            "Thesis program, slack form, 23 variables",
            "programs slack @/slack",
            "qp @/slack",
            "@/slack",
            "@/slack on",
        ),
        programs(
            "qp-direct",
            "Thesis program, direct form, 11 variables",
            "programs direct @/direct",
            "qp @/direct",
            "@/direct",
            "@/direct off",
        ),
        programs(
            "qp-48",
            "Humanoid program, 48 variables, also of a humanoid that falls",
            "programs humanoid @/humanoid",
            "qp @/humanoid",
            "@/humanoid",
            "@/humanoid on",
        ),
        programs(
            "qp-48-standing",
            "Humanoid program, 48 variables, before it falls",
            "programs standing @/standing",
            "qp @/standing",
            "@/standing",
            "@/standing on",
        ),
        loops("tick-planar7", "tick", "Control tick, planar humanoid, thesis's walk", "tick walk", vec![], vec![]),
        loops(
            "tick-double",
            "tick",
            "Control tick, exo18, double support",
            "tick exo-sway",
            vec![EXO18, "start exo-sway @/sway.start"],
            vec![("TSID", "@/exo18 double @/sway.start")],
        ),
        loops(
            "tick-single",
            "tick",
            "Control tick, exo18, single support with a swing foot",
            "tick exo-lift",
            vec![EXO18, "start exo-lift @/lift.start"],
            vec![("TSID", "@/exo18 single @/lift.start")],
        ),
        contact(
            "contact-planar7",
            "Physics step of 1 ms with contacts, planar humanoid pushed",
            "steps push @/push.steps",
            "contact push @/push.steps",
            "@/planar7.xml @/push.steps",
        ),
        contact(
            "contact-exo18",
            "Physics step of 1 ms with contacts, exo18 standing, swaying, pushed",
            "steps exo-sway @/sway.steps",
            "contact exo-sway @/sway.steps",
            "@/exo18.xml @/sway.steps",
        ),
        contact(
            "contact-random",
            "Physics step of 1 ms with contacts, exo18 under random torques: it falls, slides, rolls on its edges",
            "steps exo-sway 20 @/random.steps",
            "contact exo-sway @/random.steps",
            "@/exo18.xml @/random.steps",
        ),
        loops("loop-walk", "loop", "Closed loop, planar humanoid, thesis's walk", "loop walk", vec![], vec![]),
        loops(
            "loop-exo18",
            "loop",
            "Closed loop, exo18 swaying, squatting, pushed",
            "loop exo-sway",
            vec![EXO18, "start exo-sway @/sway.start"],
            vec![("TSID + MuJoCo", "@/exo18 @/sway.start")],
        ),
    ]
}

fn dynamics(
    key: &'static str,
    title: &'static str,
    prepare: Vec<&'static str>,
    ours: &'static str,
    peer: &'static str,
) -> Case {
    Case { key, group: "dynamics", title, judge: Judge::Values, prepare, ours, peers: vec![("Pinocchio", peer)] }
}

fn programs(
    key: &'static str,
    title: &'static str,
    prepare: &'static str,
    ours: &'static str,
    file: &'static str,
    daqp: &'static str,
) -> Case {
    let peers = [("DAQP", daqp)].into_iter().chain(SOLVERS.map(|solver| (solver, file))).collect();
    Case { key, group: "qp", title, judge: Judge::Programs, prepare: vec![prepare], ours, peers }
}

fn contact(
    key: &'static str,
    title: &'static str,
    prepare: &'static str,
    ours: &'static str,
    peer: &'static str,
) -> Case {
    let models = vec!["model planar_humanoid @/planar7", EXO18, prepare];
    Case {
        key,
        group: "contact",
        title,
        judge: Judge::Velocities,
        prepare: models,
        ours,
        peers: vec![("MuJoCo", peer)],
    }
}

fn loops(
    key: &'static str,
    group: &'static str,
    title: &'static str,
    ours: &'static str,
    prepare: Vec<&'static str>,
    peers: Vec<(&'static str, &'static str)>,
) -> Case {
    Case { key, group, title, judge: Judge::Nothing, prepare, ours, peers }
}
