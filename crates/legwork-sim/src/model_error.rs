//! How the simulated robot differs from the one that the controller knows: mass, centre of mass and inertia of its bodies.

use legwork_contract::robot::Robot;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Makes the stream another one than that of the sensors, which begins with the seed itself.
const STREAM: u64 = 0x6d61_7373_6572_726f;

/// `known` with bodies that differ from its by random factors, evenly distributed in 1 ± `share`; a pure function of `seed`.
///
/// Each body has a factor of its mass, of its inertia a unit of mass (so that the inertia stays one that a body can have), and of
/// each component of its centre of mass, from the origin of its joint. Joints, contact points and gravity stay.
pub fn real(known: &Robot, share: f64, seed: u64) -> Robot {
    let mut model = known.clone();
    if share == 0.0 {
        return model;
    }
    let mut random = Pcg64Mcg::seed_from_u64(seed ^ STREAM);
    let mut factor = || 1.0 + share * random.random_range(-1.0..=1.0);
    for body in &mut model.bodies {
        let mass = factor();
        body.mass *= mass;
        body.inertia *= mass * factor();
        for place in body.com.iter_mut() {
            *place *= factor();
        }
    }
    model
}

#[cfg(test)]
mod tests {
    use super::*;

    fn load(name: &str) -> Robot {
        let text = match name {
            "planar_humanoid" => include_str!("../../../models/planar_humanoid.toml"),
            "planar_humanoid_feet" => include_str!("../../../models/planar_humanoid_feet.toml"),
            _ => unreachable!("{name}"),
        };
        Robot::from_toml(text, name).expect("a sound model")
    }

    #[test]
    fn bodies_differ_by_no_more_than_the_share_and_nothing_else_does() {
        for name in ["planar_humanoid", "planar_humanoid_feet"] {
            let known = load(name);
            let (mut least, mut most) = (1.0_f64, 1.0_f64);
            for seed in 0..50 {
                let mut robot = real(&known, 0.1, seed);
                for (body, before) in robot.bodies.iter_mut().zip(&known.bodies).filter(|(_, known)| known.mass > 0.0) {
                    let mass = body.mass / before.mass;
                    (least, most) = (least.min(mass), most.max(mass));
                    assert!((mass - 1.0).abs() <= 0.1 + 1e-12);
                    for axis in 0..3 {
                        assert!((body.com[axis] - before.com[axis]).abs() <= 0.1 * before.com[axis].abs() + 1e-12);
                    }
                    // One factor for the whole matrix: principal axes and their proportions stay.
                    let scale = body.inertia.trace() / before.inertia.trace();
                    assert!((body.inertia - before.inertia * scale).abs().max() < 1e-12);
                    assert!((scale / mass - 1.0).abs() <= 0.1 + 1e-12);
                    (body.mass, body.com, body.inertia) = (before.mass, before.com, before.inertia);
                }
                assert_eq!(robot, known, "{name}, seed {seed}");
            }
            // The range is used: beyond 0.098 with a probability of 1 − 0.98^n for n draws a side, n ≥ 250.
            assert!(least < 0.902 && most > 1.098, "{name}: {least} to {most}");
        }
    }

    #[test]
    fn right_and_left_differ_and_so_do_seeds() {
        let known = load("planar_humanoid_feet");
        let mass = |seed: u64, body: &str| {
            let robot = real(&known, 0.02, seed);
            robot.bodies[robot.body_index(body).expect("a body")].mass
        };
        assert_eq!(mass(3, "right_thigh"), mass(3, "right_thigh"));
        assert_ne!(mass(3, "right_thigh"), mass(3, "left_thigh"));
        assert_ne!(mass(3, "right_thigh"), mass(4, "right_thigh"));
        assert_eq!(real(&known, 0.0, 3), known);
    }

    #[test]
    fn masses_of_neighbouring_seeds_are_spread_evenly() {
        let known = load("planar_humanoid_feet");
        let thigh = known.body_index("right_thigh").expect("a body");
        let share = |seed: u64| (real(&known, 0.1, seed).bodies[thigh].mass / known.bodies[thigh].mass - 1.0) / 0.1;
        let values: Vec<f64> = (0..1000).map(share).collect();
        let mean = values.iter().sum::<f64>() / 1000.0;
        let square = values.iter().map(|value| value * value).sum::<f64>() / 1000.0;
        // Of a value even in ±1: 0 ± 0.018 and 1/3 ± 0.0094; four deviations.
        assert!(mean.abs() < 0.073 && (square - 1.0 / 3.0).abs() < 0.038, "{mean} {square}");
    }
}
