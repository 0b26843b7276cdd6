//! Energy and momentum of a robot that nobody touches, integrated by the classical Runge-Kutta method of fourth order.

mod common;

use common::Random;
use legwork_rbd::{Base, Dynamics, Model};
use nalgebra::{DVector, Vector3};

/// The state as one vector: q, then v. A floating base's quaternion is integrated as four plain numbers.
type State = DVector<f64>;

fn rate(model: &Model, dynamics: &mut Dynamics, state: &State) -> State {
    let (nq, nv) = (model.nq(), model.nv());
    let (q, v) = (&state.as_slice()[..nq], &state.as_slice()[nq..]);
    dynamics.update(model, q, v);
    let vd = dynamics.mass_matrix.clone().cholesky().unwrap().solve(&(-&dynamics.bias));
    let mut out = DVector::zeros(nq + nv);
    if model.base == Base::Floating {
        // q̇ = ½ q ∘ (0, ω), ṗ = R u
        let (w, x, y, z) = (q[0], q[1], q[2], q[3]);
        out[0] = 0.5 * (-x * v[0] - y * v[1] - z * v[2]);
        out[1] = 0.5 * (w * v[0] + y * v[2] - z * v[1]);
        out[2] = 0.5 * (w * v[1] + z * v[0] - x * v[2]);
        out[3] = 0.5 * (w * v[2] + x * v[1] - y * v[0]);
        let velocity = dynamics.world_from_body[0].rotation * Vector3::new(v[3], v[4], v[5]);
        out.rows_mut(4, 3).copy_from(&velocity);
        out.rows_mut(7, nv - 6).copy_from_slice(&v[6..]);
    } else {
        out.rows_mut(0, nv).copy_from_slice(v);
    }
    out.rows_mut(nq, nv).copy_from(&vd);
    out
}

fn simulate(model: &Model, start: &State, duration: f64, steps: usize) -> State {
    let mut dynamics = Dynamics::new(model);
    let dt = duration / steps as f64;
    let mut state = start.clone();
    for _ in 0..steps {
        let k1 = rate(model, &mut dynamics, &state);
        let k2 = rate(model, &mut dynamics, &(&state + &k1 * (0.5 * dt)));
        let k3 = rate(model, &mut dynamics, &(&state + &k2 * (0.5 * dt)));
        let k4 = rate(model, &mut dynamics, &(&state + &k3 * dt));
        state += (k1 + (k2 + k3) * 2.0 + k4) * (dt / 6.0);
    }
    state
}

fn start(model: &Model, seed: u64) -> State {
    let mut random = Random(seed);
    let (mut state, v) = (random.q(model), random.v(model));
    state.extend(v);
    DVector::from_vec(state)
}

fn at(model: &Model, state: &State) -> Dynamics {
    let mut dynamics = Dynamics::new(model);
    let (q, v) = state.as_slice().split_at(model.nq());
    dynamics.update(model, q, v);
    dynamics
}

fn momentum(model: &Model, state: &State) -> DVector<f64> {
    &at(model, state).momentum_matrix * state.rows(model.nq(), model.nv())
}

fn pendulum() -> Model {
    Model::from_toml(include_str!("data/double_pendulum.toml"), "double_pendulum.toml").unwrap()
}

fn with_rotors(mut model: Model) -> Model {
    model.dofs[6..].iter_mut().for_each(|dof| dof.armature = 0.05);
    model
}

#[test]
fn runge_kutta_converges_with_its_order() {
    for model in [pendulum(), common::planar_humanoid(), common::biped18()] {
        let start = start(&model, 2);
        let [a, b, c] = [50, 100, 200].map(|steps| simulate(&model, &start, 0.2, steps));
        let ratio = (&a - &b).norm() / (&b - &c).norm();
        // Fourth order: 2⁴ in the limit of small steps
        assert!((14.0..19.0).contains(&ratio), "{}: {ratio}", model.name);
    }
}

#[test]
fn energy_is_conserved_and_its_error_falls_with_the_order() {
    for model in [pendulum(), common::planar_humanoid(), common::biped18(), with_rotors(common::biped18())] {
        let start = start(&model, 4);
        let energy = |state: &State| {
            let dynamics = at(&model, state);
            dynamics.kinetic_energy + dynamics.potential_energy
        };
        let error = |steps| (energy(&simulate(&model, &start, 0.4, steps)) - energy(&start)).abs();
        let (coarse, fine) = (error(200), error(400));
        assert!(fine < 1e-6 * at(&model, &start).kinetic_energy, "{}: {fine}", model.name);
        assert!(coarse / fine > 12.0, "{}: {coarse} {fine}", model.name);
    }
}

#[test]
fn momentum_in_free_fall() {
    for model in [common::planar_humanoid(), common::biped18()] {
        let start = start(&model, 6);
        let end = simulate(&model, &start, 0.3, 600);
        let (before, after) = (momentum(&model, &start), momentum(&model, &end));
        let mut expected = before.clone();
        // Only the weight acts: it changes the last row, the vertical momentum
        expected[before.len() - 1] -= model.total_mass() * model.gravity * 0.3;
        common::assert_close(&model.name, after.as_slice(), expected.as_slice(), 1e-8);
    }
}
