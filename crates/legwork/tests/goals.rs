//! From state to goals: the planner's equations, the step state machine, the friction cone on a slope.

use legwork::Robot;
use legwork::contact::Pyramid;
use legwork::feet::{FeetMotion, rotated, rotation_error};
use legwork::generator::step::{Phase, StepMachine};
use legwork::generator::{Observation, PointReference, Reference, TurnReference};
use legwork::library;
use legwork::momentum::tasks::Seen;
use legwork::planner::MotionReferencePlanner;
use legwork::scenario::{ByJoint, Damping, LeastStep, PostureTracking, Replan, Scenario, StepSettings};
use legwork::terrain::Terrain;
use legwork_rbd::Dynamics;
use nalgebra::{Matrix3, Vector3};

const GRAVITY: f64 = 9.81;

fn humanoid() -> Robot {
    library::load_model("planar_humanoid", None).expect("a built-in model")
}

#[test]
fn goals_are_equations_4_3_to_4_6() {
    let model = humanoid();
    let q = [0.1, 0.2, -0.7, 1.1, -0.3, -2.2, -0.9];
    let v = [0.3, -0.1, 0.4, -0.8, 0.5, 0.2, -0.6];
    let mut dynamics = Dynamics::new(&model);
    dynamics.update(&model, &q, &v);
    let mut reference = Reference::default();
    reference.chest.point = PointReference {
        position: Vector3::new(0.28, 0.0, 0.9),
        velocity: Vector3::new(0.5, 0.0, -0.1),
        acceleration: Vector3::new(0.2, 0.0, 0.3),
    };
    reference.chest.turn = TurnReference::pitch(-0.08, 0.6, -1.7);
    reference.feet[1].point = PointReference {
        position: Vector3::new(0.6, 0.0, 0.05),
        velocity: Vector3::new(1.0, 0.0, 0.5),
        acceleration: Vector3::new(3.0, 0.0, -4.0),
    };
    for (damping, factor) in [(Damping::Printed, 2.0_f64.sqrt()), (Damping::Critical, 2.0)] {
        let mut settings = Scenario::default().controller;
        settings.planner.damping = damping;
        settings.planner.max_horizontal_momentum_rate_n = 60.0;
        let mut planner = MotionReferencePlanner::new(&settings, &model);
        let mut feet = FeetMotion::new(&model);
        feet.update(&model, &dynamics);
        let (dynamics, feet, reference, settings) = (&dynamics, &feet, &reference, &settings.planner);
        planner.plan(&Seen { model: &model, dynamics, feet, q: &q, v: &v, reference, settings });
        let [momentum_rate, foot_acceleration, torso_acceleration] =
            ["momentum", "feet", "torso"].map(|task| planner.goal(task));

        // (4.3): the angular momentum, from the bodies' velocities by the momentum matrix of another test's trust.
        let momentum: f64 = (0..7).map(|j| dynamics.momentum_matrix[(0, j)] * v[j]).sum();
        assert!((momentum_rate[0] + 200.0 * momentum).abs() < 1e-9);
        // (4.4), with D_C = factor sqrt(m P_C), limited in x only.
        let (p, d, m) = (1500.0, factor * (72.5_f64 * 1500.0).sqrt(), 72.5);
        let com = &reference.chest.point;
        let force = |axis: usize| {
            p * (com.position[axis] - dynamics.com[axis])
                + d * (com.velocity[axis] - dynamics.com_velocity[axis])
                + m * com.acceleration[axis]
        };
        assert!(force(0).abs() > 60.0, "the limit must be met: {}", force(0));
        assert!((momentum_rate[1] - force(0).clamp(-60.0, 60.0)).abs() < 1e-9);
        assert!((momentum_rate[2] - force(2)).abs() < 1e-9);
        // With a centre of pressure the pendulum that stands on it, limited as well.
        let cop = Vector3::new(0.08, 0.0, 0.05);
        let pendulum = (m * GRAVITY + force(2)) / (dynamics.com.z - cop.z) * (dynamics.com.x - cop.x);
        let with_cop = Reference { cop: Some(cop), ..*reference };
        let mut other = planner.clone();
        other.plan(&Seen { model: &model, dynamics, feet, q: &q, v: &v, reference: &with_cop, settings });
        assert!((other.goal("momentum")[1] - pendulum.clamp(-60.0, 60.0)).abs() < 1e-9, "{pendulum}");
        assert!((other.goal("momentum")[2] - force(2)).abs() < 1e-9 && pendulum.abs() < 60.0, "{pendulum}");
        // (4.5), with D_f = factor sqrt(P_f).
        let foot = &reference.feet[1].point;
        for (row, axis) in [(2, 0), (3, 2)] {
            let expected = 1500.0 * (foot.position[axis] - dynamics.contact_positions[1][axis])
                + factor * 1500.0_f64.sqrt() * (foot.velocity[axis] - dynamics.contact_velocities[1][axis])
                + foot.acceleration[axis];
            assert!((foot_acceleration[row] - expected).abs() < 1e-9);
        }
        // (4.6) with S_c = (0 0 1 1 1 0 0).
        let (angle, rate) = (q[2] + q[3] + q[4], v[2] + v[3] + v[4]);
        let expected = 45.0 * (-0.08 - angle) + factor * 45.0_f64.sqrt() * (0.6 - rate) - 1.7;
        assert!((torso_acceleration[0] - expected).abs() < 1e-9);
    }
}

/// (4.6) in space, each term alone: the torso that is where and as fast as its reference is given the reference's acceleration.
#[test]
fn the_goal_of_a_torso_in_space_follows_its_reference() {
    let model = library::load_model("exo18", None).expect("a built-in model");
    let settings = Scenario::default().controller;
    let v: Vec<f64> = (0..model.nv()).map(|j| (1.0 + 1.7 * j as f64).sin()).collect();
    let (mut q, mut later) = (vec![0.0; model.nq()], vec![0.0; model.nq()]);
    model.integrate(model.neutral().as_slice(), &v, 0.3, &mut q);
    let mut dynamics = Dynamics::new(&model);
    let rotation = |dynamics: &Dynamics| dynamics.world_from_body[model.torso].rotation;
    // The angular velocity by differences.
    let step = 1e-6;
    let [before, after] = [-step, step].map(|time| {
        model.integrate(&q, &v, time, &mut later);
        dynamics.update(&model, &later, &v);
        rotation(&dynamics)
    });
    let velocity = rotation_error(&before, &after) / (2.0 * step);
    dynamics.update(&model, &q, &v);
    let mut feet = FeetMotion::new(&model);
    feet.update(&model, &dynamics);
    let mut planner = MotionReferencePlanner::new(&settings, &model);
    let (gain, acceleration) = (settings.planner.torso_gain, Vector3::new(3.0, -2.0, 1.0));
    let (turn, faster) = (Vector3::new(0.2, 0.1, -0.3), Vector3::new(-0.4, 0.5, 0.7));
    for (ahead, more) in [(Vector3::zeros(), Vector3::zeros()), (turn, Vector3::zeros()), (Vector3::zeros(), faster)] {
        let still = TurnReference::still(&(rotated(&ahead) * rotation(&dynamics)));
        let mut reference = Reference::default();
        reference.chest.turn = TurnReference { velocity: velocity + more, acceleration, ..still };
        let (dynamics, feet, reference, settings) = (&dynamics, &feet, &reference, &settings.planner);
        planner.plan(&Seen { model: &model, dynamics, feet, q: &q, v: &v, reference, settings });
        let expected = gain * ahead + (2.0 * gain).sqrt() * more + acceleration;
        let found = Vector3::from_column_slice(planner.goal("torso"));
        assert!((found - expected).norm() < 1e-7, "{found} instead of {expected}");
    }
}

/// `P (q_0 - q) - D q̇` for each actuated joint, with `q_0` of the first tick, on a base whose positions are one more than its velocities.
#[test]
fn the_goal_of_the_posture_draws_the_joints_to_where_they_were_first() {
    let model = library::load_model("exo18", None).expect("a built-in model");
    let mut settings = Scenario::default().controller;
    settings.tracking.posture = PostureTracking::Cost;
    (settings.planner.posture_gain, settings.planner.damping) = (ByJoint::All(36.0), Damping::Critical);
    let mut planner = MotionReferencePlanner::new(&settings, &model);
    let mut dynamics = Dynamics::new(&model);
    let mut feet = FeetMotion::new(&model);
    let reference = Reference::default();
    let first = model.neutral();
    // D = 2 sqrt(36) = 12.
    for (moved, speed) in [(0.0, 0.5), (0.1, 0.0), (0.1, -0.2), (-0.3, 0.4)] {
        let (mut q, mut v) = (first.as_slice().to_vec(), vec![0.0; model.nv()]);
        let joints: Vec<usize> = model.actuated().collect();
        for (index, &dof) in joints.iter().enumerate() {
            q[dof + 1] += moved * index as f64;
            v[dof] = speed * index as f64;
        }
        dynamics.update(&model, &q, &v);
        feet.update(&model, &dynamics);
        let (dynamics, feet, reference, settings) = (&dynamics, &feet, &reference, &settings.planner);
        planner.plan(&Seen { model: &model, dynamics, feet, q: &q, v: &v, reference, settings });
        let goal = planner.goal("posture");
        assert_eq!(goal.len(), joints.len());
        for (index, goal) in goal.iter().enumerate() {
            let expected = (-36.0 * moved - 12.0 * speed) * index as f64;
            assert!((goal - expected).abs() < 1e-12, "joint {index}: {goal} instead of {expected}");
        }
    }
}

#[test]
fn friction_rows_are_equations_4_12_to_4_16_on_a_slope() {
    let (friction, slope) = (0.6, 0.2_f64);
    let ground = Terrain::plane(&humanoid(), friction, [slope, 0.0]);
    let (normal, tangent) = ([-slope.sin(), slope.cos()], [slope.cos(), slope.sin()]);
    let expected = [
        [-normal[0], -normal[1]],
        [tangent[0] - friction * normal[0], tangent[1] - friction * normal[1]],
        [-tangent[0] - friction * normal[0], -tangent[1] - friction * normal[1]],
    ];
    let pyramid = Pyramid::new(&humanoid(), 4);
    assert_eq!(pyramid.rows(), 3);
    for (row, expected) in expected.iter().enumerate() {
        let found = pyramid.row(ground.base(), row);
        assert!((found.x - expected[0]).abs() < 1e-15 && (found.z - expected[1]).abs() < 1e-15, "row {row}");
    }
    assert!((ground.gap(&Vector3::new(1.0, 0.0, ground.height_at(1.0, 0.0)))).abs() < 1e-15);
    assert!((ground.height_at(1.0, 0.0) - slope.tan()).abs() < 1e-15);
}

/// What the pyramid allows the cone allows: along its edges all of the friction, between them at least the cosine of half the
/// angle.
#[test]
fn the_pyramid_of_friction_lies_inside_the_cone() {
    let model = library::load_model("exo18", None).expect("built in");
    for edges in [3, 4, 8, 15] {
        let (pyramid, friction) = (Pyramid::new(&model, edges), 0.6);
        let ground = Terrain::plane(&model, friction, [0.1, -0.2]);
        let [t, s] = [ground.base().tangents()[0], ground.base().tangents()[1]];
        let largest = |angle: f64| {
            let way = t * angle.cos() + s * angle.sin();
            // Of one newton of normal force.
            let bound = |row: usize| {
                let row = pyramid.row(ground.base(), row);
                let (gain, give) = (row.dot(&way), -row.dot(&ground.base().normal));
                if gain > 1e-12 { give / gain } else { f64::INFINITY }
            };
            (1..pyramid.rows()).map(bound).fold(f64::INFINITY, f64::min)
        };
        let half = std::f64::consts::PI / edges as f64;
        for k in 0..360 {
            let allowed = largest(f64::from(k).to_radians());
            assert!(allowed <= friction + 1e-12 && allowed >= friction * half.cos() - 1e-12, "{edges}: {allowed}");
        }
        assert!((largest(0.0) - friction).abs() < 1e-12 && (largest(half) - friction * half.cos()).abs() < 1e-12);
    }
}

/// A step machine with feet at 0 (right) and 0.5 m (left), over level ground.
struct Walker {
    machine: StepMachine,
    observation: Observation,
    com: PointReference,
}

impl Walker {
    fn new(reference_speed: f64, replan: Replan) -> Self {
        Self::with(StepSettings { replan, ..Scenario::default().reference.step }, reference_speed)
    }

    fn with(settings: StepSettings, reference_speed: f64) -> Self {
        let observation = Observation {
            rotation: [Matrix3::identity(); 2],
            ahead: [Vector3::x(); 2],
            time: 0.0,
            com: Vector3::new(0.25, 0.0, 0.9),
            com_velocity: Vector3::zeros(),
            feet: [Vector3::zeros(), Vector3::new(0.5, 0.0, 0.0)],
            pitch: [[0.0; 2]; 2],
            touching: [true, true],
            load: [0.0; 2],
            end_load: [[0.0; 2]; 2],
        };
        let com = PointReference {
            position: Vector3::new(0.25, 0.0, 0.9),
            velocity: Vector3::x() * reference_speed,
            ..PointReference::default()
        };
        let ground = Terrain::plane(&humanoid(), 0.85, [0.0; 2]);
        Self { machine: StepMachine::new(settings, ground, true, GRAVITY, &observation), observation, com }
    }

    /// Moves on with the CoM standing still at `x`, which is then also the XcoM.
    fn with_xcom(&mut self, x: f64) -> Phase {
        self.observation.com.x = x;
        self.machine.update(&self.observation, &self.com);
        assert_eq!(self.machine.xcom(), x);
        self.machine.phase()
    }
}

fn swinging(phase: Phase) -> Option<(usize, f64)> {
    match phase {
        Phase::DoubleSupport => None,
        Phase::Step { foot, length, .. } => Some((foot, length)),
    }
}

#[test]
fn a_step_is_triggered_where_the_xcom_leaves_the_base_of_support() {
    let mut walker = Walker::new(0.0, Replan::Never);
    assert_eq!(walker.with_xcom(0.49), Phase::DoubleSupport);
    let (foot, length) = swinging(walker.with_xcom(0.51)).expect("a step forward");
    assert!(foot == 0 && length > 0.0, "the rear foot steps forward");
    let mut walker = Walker::new(0.0, Replan::Never);
    assert_eq!(walker.with_xcom(0.01), Phase::DoubleSupport);
    let (foot, length) = swinging(walker.with_xcom(-0.01)).expect("a step backward");
    assert!(foot == 1 && length < 0.0, "the left foot is the rear one in a fall backward");
}

#[test]
fn the_delay_holds_on_the_side_of_the_motion_only() {
    // 0.2 s of 0.5 m/s: 0.1 m.
    assert_eq!(Walker::new(0.5, Replan::Never).with_xcom(0.59), Phase::DoubleSupport);
    assert_ne!(Walker::new(0.5, Replan::Never).with_xcom(0.61), Phase::DoubleSupport);
    assert_ne!(Walker::new(0.5, Replan::Never).with_xcom(-0.01), Phase::DoubleSupport);
    assert_eq!(Walker::new(-0.5, Replan::Never).with_xcom(-0.09), Phase::DoubleSupport);
    // At most 0.15 m.
    assert_ne!(Walker::new(2.0, Replan::Never).with_xcom(0.66), Phase::DoubleSupport);
}

#[test]
fn the_step_reaches_past_the_predicted_xcom_within_its_limits() {
    let mut walker = Walker::new(0.0, Replan::Never);
    let (_, length) = swinging(walker.with_xcom(0.6)).expect("a step");
    let omega = (GRAVITY / 0.9_f64).sqrt();
    let predicted = 0.5 + (0.6 - 0.5) * (omega * 0.225_f64).exp(); // (2.5) about the standing foot
    assert!((length - 1.1 * predicted).abs() < 1e-12, "{length}");
    let shortest = swinging(Walker::new(0.0, Replan::Never).with_xcom(-0.001)).expect("a step").1;
    assert!((shortest + 0.59).abs() < 1e-12, "at least 0.59 m: {shortest}");
    let longest = swinging(Walker::new(0.0, Replan::Never).with_xcom(2.0)).expect("a step").1;
    assert!((longest - 1.05).abs() < 1e-12, "at most 1.05 m: {longest}");
}

#[test]
fn the_least_step_is_of_the_foot_or_of_the_base_of_support() {
    for (is, expected) in [(LeastStep::Displacement, 0.59), (LeastStep::BaseOfSupport, 0.5 + 0.59)] {
        let mut settings = Scenario::default().reference.step;
        settings.min_length_is = is;
        settings.max_length_m = 2.0;
        for (direction, xcom) in [(1.0, 0.501), (-1.0, -0.001)] {
            let mut walker = Walker::with(settings.clone(), 0.0);
            let (_, length) = swinging(walker.with_xcom(xcom)).expect("a step");
            let least = f64::max(expected, if direction > 0.0 { 1.1 * 0.5 } else { 0.0 });
            assert!((direction * length - least).abs() < 1e-2, "{is:?} {direction}: {length}, expected {least}");
        }
    }
}

#[test]
fn touchdown_counts_after_half_of_the_step_and_latches_the_reference() {
    let mut walker = Walker::new(0.0, Replan::Never);
    walker.with_xcom(0.55);
    walker.observation.feet[0] = Vector3::new(0.3, 0.0, 0.0005);
    walker.observation.time = 0.1;
    assert_ne!(walker.with_xcom(0.55), Phase::DoubleSupport, "too early");
    walker.observation.time = 0.12;
    walker.observation.feet[0].x = 0.7;
    assert_eq!(walker.with_xcom(0.6), Phase::DoubleSupport);
    let latched = walker.machine.foot(0, 0.2);
    assert!((latched.position - Vector3::new(0.7, 0.0, 0.0)).norm() < 1e-12, "on the ground where it stands");
    assert!(latched.velocity.norm() < 1e-12 && latched.acceleration.norm() < 1e-12);
}

#[test]
fn only_replanning_answers_a_push_in_the_swing() {
    for (replan, changes) in [(Replan::Never, false), (Replan::InSwing, true)] {
        let mut walker = Walker::new(0.0, replan);
        let before = swinging(walker.with_xcom(0.55)).expect("a step").1;
        walker.observation.time = 0.05;
        walker.observation.touching[0] = false;
        let after = swinging(walker.with_xcom(0.70)).expect("still in the step").1;
        assert_eq!(after > before + 0.05, changes, "{replan:?}: {before} to {after}");
    }
}
