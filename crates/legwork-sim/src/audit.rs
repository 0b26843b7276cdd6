//! The books of a run: whether the simulation obeyed the laws that it claims to.
//!
//! Energy is held against the work of all forces, the linear momentum against their impulses; penetration, friction
//! cone, slip and the contact solver's residual are watched in every step.

use legwork_rbd::{Base, Dynamics, Model};
use nalgebra::Vector3;

use super::contact_solver::Report;
use legwork_contract::contact::Surface;
use legwork_contract::terrain::Terrain;

/// Slower contact points [m/s], and those with less friction [N], have no direction.
const SLIPS: f64 = 1e-3;

/// Figures of a run so far, each the worst or the sum over all steps.
#[derive(Clone, Debug, Default)]
pub struct Audit {
    /// Largest difference between the change of energy and the work done on the robot [J].
    pub energy_error_j: f64,
    /// Sum of the absolute work of joints, pushes and contacts [J]: what the energy error is to be held against.
    pub work_j: f64,
    /// Energy that contacts took away [J]: impacts and slip.
    pub contact_loss_j: f64,
    /// Energy that contacts gave at most [J]: the largest rise of their work above the least that it was before.
    pub contact_gain_j: f64,
    /// Largest difference between the change of linear momentum and the impulses, as velocity of the CoM [m/s].
    pub momentum_error_mps: f64,
    /// Deepest penetration of a contact point [m].
    pub penetration_m: f64,
    /// Largest excess of a tangential force over friction times normal force [N].
    pub friction_excess_n: f64,
    /// Largest angle between the friction of a slipping contact point and the direction against its slip [deg].
    pub friction_angle_deg: f64,
    /// Strongest pull of the ground on a contact [N]: zero if the ground only pushes.
    pub pull_n: f64,
    /// Way that loaded contact points slipped [m], all together.
    pub slip_m: f64,
    /// Most sweeps of the contact solver in a step.
    pub contact_sweeps: u32,
    /// Largest residual of the contact solver, as force [N].
    pub contact_residual_n: f64,
    /// Stiffness of the springs and stops that acted at joints, as the largest share of what the time step can bear.
    pub stiffness_share: f64,
    /// Whether the world holds the robot's root link, with impulses that nobody knows.
    bolted: bool,
    mass: f64,
    /// Time that the books are of [s].
    time: f64,
    energy_at_start: f64,
    work: f64,
    /// The least of the sum of the contacts' work [J].
    least_contact_work: f64,
    com_velocity_at_start: Vector3<f64>,
    impulse: Vector3<f64>,
}

/// What one step did, but for its contacts.
#[derive(Debug)]
pub struct Step<'a> {
    /// Generalized force of the joints' damping, which opposes the motion.
    pub damping: &'a [f64],
    /// Time step [s].
    pub period: f64,
    /// Acceleration of gravity [m/s²].
    pub gravity: f64,
    /// Velocities before and after.
    pub v: [&'a [f64]; 2],
    /// The coordinates that a motor drives.
    pub actuated: &'a [usize],
    /// Their torques [Nm].
    pub torque: &'a [f64],
    /// Sum of the pushes [N].
    pub push: Vector3<f64>,
    /// Generalized force of the pushes.
    pub push_force: &'a [f64],
}

impl Audit {
    /// Opens the books of `model` in the state of `dynamics`.
    pub(super) fn begin(&mut self, model: &Model, dynamics: &Dynamics) {
        self.bolted = model.base == Base::Fixed;
        self.mass = model.total_mass();
        self.energy_at_start = energy(dynamics);
        self.com_velocity_at_start = dynamics.com_velocity;
    }

    /// Enters the work and the impulses of a step, but for its contacts.
    pub(super) fn account(&mut self, step: &Step<'_>) {
        let (dt, [before, after]) = (step.period, step.v);
        self.time += dt;
        let mean = |j: usize| 0.5 * (before[j] + after[j]);
        // The kinetic energy at fixed configuration changes by exactly force · (v + v⁺)/2.
        for (&dof, torque) in step.actuated.iter().zip(step.torque) {
            self.enter(dt * torque * mean(dof));
        }
        self.enter((0..before.len()).map(|j| dt * step.push_force[j] * mean(j)).sum());
        self.enter((0..before.len()).map(|j| -dt * step.damping[j] * mean(j)).sum());
        self.impulse += step.push * dt - Vector3::z() * (self.mass * step.gravity * dt);
    }

    /// Enters what the contact solver said in a step of `period` [s].
    pub(super) fn solve(&mut self, report: Report, period: f64) {
        self.contact_sweeps = self.contact_sweeps.max(report.sweeps);
        self.contact_residual_n = self.contact_residual_n.max(report.residual / period);
    }

    /// Enters one contact of a change of velocity in a step of `dt` [s], which it takes `time` [s] of: its impulse [Ns], its velocities before and after, and the velocity that it
    /// ends with if it moves on as it does [m/s], all in contact coordinates. Returns its work, which is for [`Audit::contact_work`].
    #[inline]
    pub(super) fn contact<const D: usize>(
        &mut self,
        ground: &Surface,
        [dt, time]: [f64; 2],
        impulse: &[f64; D],
        [before, after]: [&[f64; D]; 2],
        motion: &[f64; D],
    ) -> f64 {
        let normal = impulse[D - 1];
        let norm = |vector: &[f64; D]| vector[..D - 1].iter().map(|value| value * value).sum::<f64>().sqrt();
        self.friction_excess_n = self.friction_excess_n.max((norm(impulse) - ground.friction * normal) / dt);
        self.pull_n = self.pull_n.max(-normal / dt);
        let speed = norm(motion);
        if normal > 0.0 {
            self.slip_m += time * speed;
        }
        if D == 3 && speed > SLIPS && norm(impulse) > SLIPS * dt {
            let along: f64 = (0..D - 1).map(|i| -impulse[i] * motion[i]).sum();
            let across = impulse[0] * motion[1] - impulse[1] * motion[0];
            self.friction_angle_deg = self.friction_angle_deg.max(libm::atan2(across.abs(), along).to_degrees());
        }
        for (direction, impulse) in ground.directions().zip(impulse) {
            self.impulse += *direction * *impulse;
        }
        (0..D).map(|k| impulse[k] * 0.5 * (before[k] + after[k])).sum()
    }

    /// Enters the work of all contacts of a step [J].
    pub(super) fn contact_work(&mut self, work: f64) {
        self.enter(work);
        self.contact_loss_j -= work;
        self.least_contact_work = self.least_contact_work.min(-self.contact_loss_j);
        self.contact_gain_j = self.contact_gain_j.max(-self.contact_loss_j - self.least_contact_work);
    }

    /// Enters how stiff the springs and stops are that act in a step, as a share of what is stable.
    pub(super) fn springs(&mut self, share: f64) {
        self.stiffness_share = self.stiffness_share.max(share);
    }

    fn enter(&mut self, work: f64) {
        self.work += work;
        self.work_j += work.abs();
    }

    /// Holds the state after the step against the books.
    pub(super) fn close(&mut self, dynamics: &Dynamics, ground: &Terrain) {
        self.energy_error_j = self.energy_error_j.max((energy(dynamics) - self.energy_at_start - self.work).abs());
        let momentum = self.mass * (dynamics.com_velocity - self.com_velocity_at_start);
        if !self.bolted {
            self.momentum_error_mps = self.momentum_error_mps.max((momentum - self.impulse).norm() / self.mass);
        }
        for position in &dynamics.contact_positions {
            self.penetration_m = self.penetration_m.max(-ground.gap(position));
        }
    }

    /// Bounds that a sound run keeps, and which of them this one violated, in words.
    ///
    /// What adds up over a run is held against the work, or against the time. The bounds hold for rigid contact at time steps of up to 1 ms (see docs/simulator.md); a coarser step or a soft ground
    /// shows here.
    pub fn violations(&self) -> Vec<String> {
        let finer = "a smaller simulation.period_s follows the motion better";
        let work = self.work_j;
        let checks = [
            ("energy differs from the work done", self.energy_error_j, 1.0 + 0.02 * work, "J", finer),
            ("energy given by contacts", self.contact_gain_j, 0.1 + 1e-3 * work, "J", finer),
            ("momentum differs from the impulses", self.momentum_error_mps, 0.1 + 1e-3 * self.time, "m/s", finer),
            (
                "penetration of the ground",
                self.penetration_m,
                1e-3,
                "m",
                "a smaller simulation.period_s or a stiffer ground helps",
            ),
            ("tangential force over the friction cone", self.friction_excess_n, 1e-3, "N", finer),
            ("friction is not opposite to the slip", self.friction_angle_deg, 0.1, "deg", finer),
            ("pull of the ground", self.pull_n, 1e-6, "N", finer),
            (
                "residual of the contact solver",
                self.contact_residual_n,
                0.1,
                "N",
                "a larger simulation.contact.max_sweeps or a smaller simulation.period_s may find the forces",
            ),
            (
                "stiffness of springs and stops for the time step",
                self.stiffness_share,
                0.25,
                "of the stable",
                "softer springs or a smaller simulation.period_s resolve them",
            ),
        ];
        let broken = checks.into_iter().filter(|(_, value, bound, ..)| value.is_nan() || value > bound);
        broken
            .map(|(what, value, bound, unit, help)| {
                format!("{what}: {value:.3e} {unit}, more than {bound:.3e} {unit}; {help}")
            })
            .collect()
    }
}

/// Of motion, weight, springs and stops [J].
fn energy(dynamics: &Dynamics) -> f64 {
    dynamics.kinetic_energy + dynamics.potential_energy + dynamics.elastic_energy
}

#[cfg(test)]
mod tests {
    use legwork_contract::robot::Robot;

    use super::*;

    const DT: f64 = 0.001;

    fn close_to(found: f64, expected: f64) {
        assert!((found - expected).abs() <= 1e-12 * expected.abs(), "{found} instead of {expected}");
    }

    fn humanoid() -> Robot {
        let text = include_str!("../../../models/planar_humanoid.toml");
        Robot::from_toml(text, "humanoid").expect("a sound model")
    }

    /// On level ground in space, of friction 0.5.
    #[test]
    fn a_contact_is_entered_with_its_work_its_slip_and_what_it_has_too_much() {
        let text = "name = \"box\"\nbase = \"floating\"\ntorso = \"box\"\n[[bodies]]\nname = \"box\"\nmass_kg = 1.0\n\
                    inertia_kgm2 = { xx = 0.1, yy = 0.1, zz = 0.1 }";
        let model = Model::from_toml(text, "box").expect("a sound model");
        let ground = Surface::new(&model, 0.5, [0.0; 2]);
        let mut audit = Audit::default();
        // 5 N against a slip of 0.5 m/s, under a load of 8 N, for half a step.
        let (before, after, slip) = ([1.0, 0.0, -2.0], [0.2, -0.5, 0.0], [0.3, -0.4, 0.0]);
        let work = audit.contact(&ground, [DT, 0.5 * DT], &[-0.003, 0.004, 0.008], [&before, &after], &slip);
        close_to(work, -0.003 * 0.6 - 0.004 * 0.25 - 0.008);
        close_to(audit.friction_excess_n, 5.0 - 0.5 * 8.0);
        close_to(audit.slip_m, 0.5 * DT * 0.5);
        assert!(audit.pull_n == 0.0 && audit.friction_angle_deg < 1e-12, "{audit:?}");
        assert!((audit.impulse - Vector3::new(-0.003, 0.004, 0.008)).norm() < 1e-15);
        // 2 N at 30 degrees to the slip: less excess, and no slip that takes no time.
        let (sin, cos) = (0.5, 0.75_f64.sqrt());
        audit.contact(&ground, [DT, 0.0], &[-0.002, 0.0, 0.008], [&before, &after], &[cos, sin, 0.0]);
        close_to(audit.friction_angle_deg, 30.0);
        close_to(audit.friction_excess_n, 1.0);
        close_to(audit.slip_m, 2.5e-4);
        // Neither what hardly slips nor what hardly rubs has a direction.
        audit.contact(&ground, [DT, DT], &[0.002, 0.0, 0.008], [&before, &after], &[0.0009, 0.0, 0.0]);
        audit.contact(&ground, [DT, DT], &[0.9e-6, 0.0, 0.008], [&before, &after], &[0.5, 0.0, 0.0]);
        close_to(audit.friction_angle_deg, 30.0);
        close_to(audit.slip_m, 2.5e-4 + 0.0009 * DT + 0.5 * DT);
        // 5 N across the slip with a pull of 1 N: what does not press does not slip.
        audit.contact(&ground, [DT, DT], &[-0.004, -0.003, -0.001], [&before, &after], &slip);
        close_to(audit.friction_angle_deg, 90.0);
        close_to(audit.friction_excess_n, 5.0 + 0.5);
        close_to(audit.pull_n, 1.0);
        close_to(audit.slip_m, 2.5e-4 + 0.0009 * DT + 0.5 * DT);
    }

    #[test]
    fn contacts_gain_what_their_work_rises_above_its_least() {
        let mut audit = Audit::default();
        let mut gains = Vec::new();
        for work in [-2.0, 0.5, -1.0, 0.25, 0.75, -0.5] {
            audit.contact_work(work);
            gains.push(audit.contact_gain_j);
        }
        assert_eq!(gains, [0.0, 0.5, 0.5, 0.5, 1.0, 1.0]);
        assert_eq!((audit.contact_loss_j, audit.work_j), (2.0, 5.0));
    }

    /// Of a robot that stays at rest although forces act on it, so that all of their work and impulse is missing.
    #[test]
    fn energy_and_momentum_are_held_against_the_work_and_the_impulses_of_all_forces() {
        let model = humanoid();
        let mut dynamics = Dynamics::new(&model);
        let mut q = vec![0.0; 7];
        // Its feet are 1 cm below the ground.
        dynamics.update(&model, &q, &[0.0; 7]);
        q[1] = -0.01 - dynamics.contact_positions[0].z;
        dynamics.update(&model, &q, &[0.0; 7]);
        let terrain = Terrain::plane(&model, 0.5, [0.0; 2]);
        let mut audit = Audit::default();
        audit.begin(&model, &dynamics);
        let (before, after) = ([0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0], [0.2, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
        let (mut push_force, mut damping) = ([0.0; 7], [0.0; 7]);
        (push_force[0], damping[3]) = (50.0, 2.0);
        let step = Step {
            damping: &damping,
            period: 0.002,
            gravity: 10.0,
            v: [&before, &after],
            actuated: &[3, 4, 5, 6],
            torque: &[-8.0, 1.0, 1.0, 1.0],
            push: Vector3::new(50.0, 0.0, 0.0),
            push_force: &push_force,
        };
        audit.account(&step);
        audit.account(&step);
        audit.close(&dynamics, &terrain);
        // Means of 0.1 and 0.75: the motor, the push and the damping, each twice for 2 ms.
        let [motor, push, damper] = [-8.0 * 0.75, 50.0 * 0.1, -2.0 * 0.75].map(|power: f64| 0.004 * power);
        assert!((audit.energy_error_j - (motor + push + damper).abs()).abs() < 1e-12, "{audit:?}");
        close_to(audit.work_j, motor.abs() + push.abs() + damper.abs());
        close_to(audit.momentum_error_mps, 0.004 * (50.0_f64 / 72.5).hypot(10.0));
        assert!((audit.penetration_m - 0.01).abs() < 1e-12, "{audit:?}");
        close_to(audit.time, 0.004);
    }

    /// Just within each bound nothing is told, just beyond it this alone.
    #[test]
    fn every_bound_is_told_where_it_is_passed() {
        type Change = fn(&mut Audit, f64);
        let cases: [(&str, f64, Change); 9] = [
            ("energy differs from the work done", 3.0, |audit, value| audit.energy_error_j = value),
            ("energy given by contacts", 0.2, |audit, value| audit.contact_gain_j = value),
            ("momentum differs from the impulses", 0.15, |audit, value| audit.momentum_error_mps = value),
            ("penetration of the ground", 1e-3, |audit, value| audit.penetration_m = value),
            ("tangential force over the friction cone", 1e-3, |audit, value| audit.friction_excess_n = value),
            ("friction is not opposite to the slip", 0.1, |audit, value| audit.friction_angle_deg = value),
            ("pull of the ground", 1e-6, |audit, value| audit.pull_n = value),
            ("residual of the contact solver", 0.1, |audit, value| audit.contact_residual_n = value),
            ("stiffness of springs and stops for the time step", 0.25, |audit, value| audit.stiffness_share = value),
        ];
        for (words, bound, set) in cases {
            let told = |value: f64| {
                // Of 50 s, and of 100 J.
                let mut audit = Audit { work_j: 100.0, time: 50.0, ..Audit::default() };
                set(&mut audit, value);
                audit.violations()
            };
            assert_eq!(told(bound * (1.0 - 1e-9)), Vec::<String>::new());
            for value in [bound * (1.0 + 1e-9), f64::NAN] {
                let told = told(value);
                assert!(told.len() == 1 && told[0].starts_with(&format!("{words}: ")), "{told:?}");
            }
        }
    }

    #[test]
    fn the_worst_of_all_steps_is_kept() {
        let mut audit = Audit::default();
        for (sweeps, residual, share) in [(3, 0.002, 0.1), (7, 0.001, 0.2), (2, 0.004, 0.05)] {
            audit.solve(Report { sweeps, residual }, DT);
            audit.springs(share);
        }
        assert_eq!((audit.contact_sweeps, audit.stiffness_share), (7, 0.2));
        close_to(audit.contact_residual_n, 4.0);
    }

    #[test]
    fn what_adds_up_over_a_run_is_held_against_its_length() {
        let of = |time, momentum_error_mps| Audit { time, momentum_error_mps, ..Audit::default() }.violations();
        // What an hour of `walk` comes to, and a thousandth of gravity that nobody entered.
        assert_eq!(of(3600.0, 0.122), Vec::<String>::new());
        let told = of(3600.0, 3600.0 * 0.00981);
        assert!(
            told[0].starts_with("momentum differs from the impulses: 3.532e1 m/s, more than 3.700e0 m/s;"),
            "{told:?}"
        );
        assert_eq!(of(2.0, 0.122).len(), 1);
    }
}
