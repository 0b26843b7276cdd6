//! What several tests share: models from random trees, a textbook RNEA as the independent route, differences.

#![allow(dead_code, unreachable_pub, non_snake_case)]

use std::fmt::Write;
use std::path::PathBuf;

use legwork_rbd::{Base, Joint, Model, Placement, Prismatic, Revolute};
use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, Quaternion, Rotation3, UnitQuaternion, Vector3, Vector6};

pub fn crate_path(relative: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(relative)
}

pub fn planar_humanoid() -> Model {
    Model::load(&crate_path("../../models/planar_humanoid.toml")).unwrap()
}

pub fn biped18() -> Model {
    Model::load(&crate_path("tests/data/biped18.urdf")).unwrap()
}

/// SplitMix64: a state of one number, so a failing case is named by its seed.
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    pub fn vector(&mut self, size: f64) -> [f64; 3] {
        [0; 3].map(|_| self.between(-size, size))
    }

    /// A position: quaternions are random rotations.
    pub fn q(&mut self, model: &Model) -> Vec<f64> {
        let mut q: Vec<f64> = (0..model.nq()).map(|_| self.between(-1.5, 1.5)).collect();
        for body in model.bodies.iter().filter(|body| matches!(body.joint, Joint::Floating(_) | Joint::Ball(_))) {
            let quaternion = &mut q[body.q_index..body.q_index + 4];
            let norm = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
            quaternion.iter_mut().for_each(|x| *x /= norm);
        }
        q
    }

    pub fn v(&mut self, model: &Model) -> Vec<f64> {
        (0..model.nv()).map(|_| self.between(-2.0, 2.0)).collect()
    }
}

/// The TOML text of a random tree with `bodies` bodies: every kind of joint, some that follow others, any axes and origins that the base allows, dampers, springs, stops, four contacts, three frames.
pub fn random_tree(seed: u64, bodies: usize, base: Base) -> String {
    let mut random = Random(seed);
    let name = match base {
        Base::Fixed => "fixed",
        Base::Planar => "planar",
        Base::Floating => "floating",
    };
    let mut text = format!("name = \"tree\"\nbase = \"{name}\"\ngravity_mps2 = 9.81\n");
    writeln!(text, "torso = \"b{}\"", random.below(bodies)).unwrap();
    let mut moving = Vec::new();
    for i in 0..bodies {
        let Inertia { xx, yy, zz, xy, xz, yz } = random_inertia(&mut random);
        writeln!(text, "[[bodies]]\nname = \"b{i}\"\nmass_kg = {}", random.between(0.1, 5.0)).unwrap();
        writeln!(text, "com_m = {:?}", random.vector(0.3)).unwrap();
        writeln!(text, "inertia_kgm2 = {{ xx = {xx}, yy = {yy}, zz = {zz}, xy = {xy}, xz = {xz}, yz = {yz} }}")
            .unwrap();
        if i == 0 {
            continue;
        }
        writeln!(text, "parent = \"b{}\"\n[bodies.joint]\nname = \"j{i}\"", random.below(i)).unwrap();
        writeln!(text, "origin_m = {:?}", random.vector(0.5)).unwrap();
        let mut rpy = random.vector(180.0);
        let mut axis = random.vector(1.0);
        let kinds = ["revolute", "revolute", "prismatic", "fixed", "ball", "floating"];
        let kind = kinds[random.below(if base == Base::Planar { 4 } else { kinds.len() })];
        if base == Base::Planar {
            rpy = [0.0, rpy[1], 0.0];
            axis = if kind == "revolute" { [0.0, axis[1].signum(), 0.0] } else { [axis[0], 0.0, axis[2]] };
        }
        writeln!(text, "type = \"{kind}\"\naxis = {axis:?}\norigin_rpy_deg = {rpy:?}").unwrap();
        let (turning, length) = match kind {
            "revolute" => ("nm", "rad"),
            "prismatic" => ("n", "m"),
            _ => continue,
        };
        if !moving.is_empty() && random.below(4) == 0 {
            let (leader, ratio, offset) =
                (moving[random.below(moving.len())], random.between(-2.0, 2.0), random.between(-1.0, 1.0));
            writeln!(text, "follows = \"j{leader}\"\nratio = {ratio}\noffset = {offset}").unwrap();
            moving.push(i);
            continue;
        }
        moving.push(i);
        let per = &length[..1];
        writeln!(text, "damping_{turning}sp{per} = {}", random.between(0.0, 3.0)).unwrap();
        if random.below(2) == 0 {
            let (stiffness, rest) = (random.between(1.0, 50.0), random.between(-1.0, 1.0));
            writeln!(text, "spring_{turning}p{per} = {stiffness}\nrest_{length} = {rest}").unwrap();
        }
        if random.below(2) == 0 {
            let (end, stiffness, damping) =
                (random.between(0.1, 1.0), random.between(10.0, 500.0), random.between(0.0, 50.0));
            let end = if random.below(2) == 0 {
                format!("lower_{length} = -{end}")
            } else {
                format!("upper_{length} = {end}")
            };
            writeln!(text, "{end}\nstop_{turning}p{per} = {stiffness}\nstop_damping_{turning}sp{per} = {damping}")
                .unwrap();
        }
    }
    for k in 0..4 {
        let (body, position) = (random.below(bodies), random.vector(0.4));
        writeln!(text, "[[contacts]]\nname = \"c{k}\"\nfoot = \"f{}\"", k / 2).unwrap();
        writeln!(text, "body = \"b{body}\"\nposition_m = {position:?}").unwrap();
    }
    for k in 0..3 {
        let (body, position, rpy) = (random.below(bodies), random.vector(0.4), random.vector(180.0));
        writeln!(text, "[[frames]]\nname = \"f{k}\"\nbody = \"b{body}\"").unwrap();
        writeln!(text, "position_m = {position:?}\nrpy_deg = {rpy:?}").unwrap();
    }
    text
}

struct Inertia {
    xx: f64,
    yy: f64,
    zz: f64,
    xy: f64,
    xz: f64,
    yz: f64,
}

/// Of a random ellipsoid: principal second moments of mass a, b, c give the moments b + c, a + c, a + b.
fn random_inertia(random: &mut Random) -> Inertia {
    let [a, b, c] = [0; 3].map(|_| random.between(0.001, 0.1));
    let [x, y, z] = random.vector(3.0);
    let R = Rotation3::from_euler_angles(x, y, z).into_inner();
    let i = R * Matrix3::from_diagonal(&Vector3::new(b + c, a + c, a + b)) * R.transpose();
    Inertia { xx: i[(0, 0)], yy: i[(1, 1)], zz: i[(2, 2)], xy: i[(0, 1)], xz: i[(0, 2)], yz: i[(1, 2)] }
}

/// The recursive Newton-Euler algorithm as in the textbook: body coordinates, 6×6 spatial transforms (Featherstone 2008,
/// Table 5.1, (2.24)-(2.33), (2.63)). Shares nothing with the crate but the model: τ = M a + C v + G.
pub fn rnea(model: &Model, q: &[f64], v: &[f64], a: &[f64], gravity: f64) -> DVector<f64> {
    let n = model.bodies.len();
    let mut X = vec![Matrix6::zeros(); n];
    let mut S: Vec<DMatrix<f64>> = Vec::new();
    let mut velocity = vec![Vector6::zeros(); n];
    let mut acceleration = vec![Vector6::zeros(); n];
    let mut force = vec![Vector6::zeros(); n];
    for (i, body) in model.bodies.iter().enumerate() {
        let (ratio, own) = match body.follows {
            Some(follows) => (follows.ratio, vec![follows.ratio * q[body.q_index] + follows.offset]),
            None => (1.0, q[body.q_index..].to_vec()),
        };
        let (pose, columns) = joint_calculation(&body.joint, &own);
        let columns = columns * ratio;
        X[i] = transform(&pose) * transform(&body.placement);
        let nv = columns.ncols();
        let vj = &columns * DVector::from_column_slice(&v[body.v_index..body.v_index + nv]);
        let aj = &columns * DVector::from_column_slice(&a[body.v_index..body.v_index + nv]);
        let (vj, aj) = (Vector6::from_column_slice(vj.as_slice()), Vector6::from_column_slice(aj.as_slice()));
        let (v_parent, a_parent) = match body.parent {
            Some(p) => (velocity[p], acceleration[p]),
            None => (Vector6::zeros(), Vector6::new(0.0, 0.0, 0.0, 0.0, 0.0, gravity)),
        };
        velocity[i] = X[i] * v_parent + vj;
        acceleration[i] = X[i] * a_parent + aj + cross_motion(&velocity[i]) * vj;
        let inertia = spatial_inertia(body.mass, &body.com, &body.inertia);
        // v ×* = −(v ×)ᵀ
        force[i] = inertia * acceleration[i] - cross_motion(&velocity[i]).transpose() * (inertia * velocity[i]);
        S.push(columns);
    }
    let mut tau = DVector::zeros(model.nv());
    for (i, body) in model.bodies.iter().enumerate().rev() {
        let generalised = S[i].transpose() * DVector::from_column_slice(force[i].as_slice());
        let mut sum = tau.rows_mut(body.v_index, generalised.len());
        sum += &generalised;
        if let Some(p) = body.parent {
            let carried = X[i].transpose() * force[i];
            force[p] += carried;
        }
    }
    tau
}

fn joint_calculation(joint: &Joint, q: &[f64]) -> (Placement, DMatrix<f64>) {
    let mut pose = Placement::identity();
    match joint {
        Joint::Fixed(_) => (pose, DMatrix::zeros(6, 0)),
        Joint::Revolute(Revolute { axis }) => {
            pose.rotation = Rotation3::from_axis_angle(axis, q[0]).into_inner();
            (pose, DMatrix::from_column_slice(6, 1, &[axis.x, axis.y, axis.z, 0.0, 0.0, 0.0]))
        }
        Joint::Prismatic(Prismatic { axis }) => {
            pose.translation = axis.into_inner() * q[0];
            (pose, DMatrix::from_column_slice(6, 1, &[0.0, 0.0, 0.0, axis.x, axis.y, axis.z]))
        }
        Joint::Ball(_) => {
            let quaternion = UnitQuaternion::from_quaternion(Quaternion::new(q[0], q[1], q[2], q[3]));
            pose.rotation = quaternion.to_rotation_matrix().into_inner();
            (pose, DMatrix::identity(6, 3))
        }
        Joint::Floating(_) => {
            let quaternion = UnitQuaternion::from_quaternion(Quaternion::new(q[0], q[1], q[2], q[3]));
            pose.rotation = quaternion.to_rotation_matrix().into_inner();
            pose.translation = Vector3::new(q[4], q[5], q[6]);
            (pose, DMatrix::identity(6, 6))
        }
    }
}

/// Motion vectors from the outer to the inner frame of `pose` (Featherstone 2008, (2.24)).
fn transform(pose: &Placement) -> Matrix6<f64> {
    let E = pose.rotation.transpose();
    blocks(&E, &Matrix3::zeros(), &(-E * pose.translation.cross_matrix()), &E)
}

fn cross_motion(v: &Vector6<f64>) -> Matrix6<f64> {
    let (w, u) = (Vector3::new(v[0], v[1], v[2]).cross_matrix(), Vector3::new(v[3], v[4], v[5]).cross_matrix());
    blocks(&w, &Matrix3::zeros(), &u, &w)
}

fn spatial_inertia(mass: f64, com: &Vector3<f64>, about_com: &Matrix3<f64>) -> Matrix6<f64> {
    let C = com.cross_matrix();
    blocks(&(about_com + mass * C * C.transpose()), &(mass * C), &(mass * C.transpose()), &(mass * Matrix3::identity()))
}

fn blocks(a: &Matrix3<f64>, b: &Matrix3<f64>, c: &Matrix3<f64>, d: &Matrix3<f64>) -> Matrix6<f64> {
    let mut m = Matrix6::zeros();
    m.fixed_view_mut::<3, 3>(0, 0).copy_from(a);
    m.fixed_view_mut::<3, 3>(0, 3).copy_from(b);
    m.fixed_view_mut::<3, 3>(3, 0).copy_from(c);
    m.fixed_view_mut::<3, 3>(3, 3).copy_from(d);
    m
}

/// The position after moving with `v` for `dt`.
pub fn moved(model: &Model, q: &[f64], v: &[f64], dt: f64) -> Vec<f64> {
    let mut out = vec![0.0; model.nq()];
    model.integrate(q, v, dt, &mut out);
    out
}

pub fn unit(n: usize, j: usize) -> Vec<f64> {
    let mut e = vec![0.0; n];
    e[j] = 1.0;
    e
}

/// Each entry within `tolerance` of the largest entry wanted (at least of 1).
#[track_caller]
pub fn assert_close(name: &str, got: &[f64], want: &[f64], tolerance: f64) {
    assert_eq!(got.len(), want.len(), "{name}: length");
    let scale = want.iter().fold(1.0_f64, |largest, x| largest.max(x.abs()));
    for (i, (got, want)) in got.iter().zip(want).enumerate() {
        assert!(
            (got - want).abs() <= tolerance * scale,
            "{name}[{i}]: {got:e} instead of {want:e}, off by {:e} of {scale}",
            (got - want) / scale
        );
    }
}
