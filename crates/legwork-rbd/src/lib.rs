//! Rigid-body dynamics of robots that are trees: mass matrix, bias, Jacobians, contact points, centroidal momentum.
//!
//! A [`Model`] is read from a TOML, URDF or MJCF file and does not change; a [`Dynamics`] holds every result and all scratch
//! for one state and is refreshed by [`Dynamics::update`] without allocating. One code path serves fixed, planar and
//! floating bases.
//!
//! ```
//! use legwork_rbd::{Dynamics, Model};
//!
//! let text = r#"
//!     name = "pendulum"
//!     base = "fixed"
//!     [[bodies]]
//!     name = "stand"
//!     [[bodies]]
//!     name = "rod"
//!     parent = "stand"
//!     mass_kg = 2.0
//!     com_m = [0.0, 0.0, -0.5]
//!     inertia_kgm2 = { xx = 0.1, yy = 0.1, zz = 0.01 }
//!     joint = { name = "swing", type = "revolute", axis = [0.0, -1.0, 0.0] }
//! "#;
//! let model = Model::from_toml(text, "pendulum.toml")?;
//! let mut dynamics = Dynamics::new(&model);
//! dynamics.update(&model, &[0.0], &[0.0]);
//! assert!((dynamics.mass_matrix[(0, 0)] - (0.1 + 2.0 * 0.5 * 0.5)).abs() < 1e-12);
//! # Ok::<(), legwork_rbd::ModelError>(())
//! ```
//!
//! # Conventions
//! SI units and radians. x forward, y left, z up; gravity along −z. Angular before linear, in every vector of six and in
//! every matrix with such rows. Vectors are in world axes unless their documentation says otherwise.
//!
//! # The same bits on every machine
//! Sine, cosine and arc tangent come from `libm`, the portable Rust port, never from `f64::sin`: the platform's own
//! functions differ in their last bits from machine to machine, and a simulation of a falling robot makes the last bit
//! visible within seconds. What remains (add, multiply, divide, square root) is fixed by IEEE 754.
//!
//! # Sources
//! R. Featherstone, *Rigid Body Dynamics Algorithms*, Springer 2008 (recursive Newton-Euler, composite rigid bodies,
//! articulated bodies).
//! D. E. Orin, A. Goswami, S.-H. Lee, *Centroidal dynamics of a humanoid robot*, Autonomous Robots 35, 2013.

// M, A, J are the field's names.
#![allow(non_snake_case)]

mod assemble;
mod base;
mod bias;
mod centroidal;
mod check;
pub mod content;
mod description;
mod dynamics;
mod elastic;
mod error;
pub mod file;
mod forward_dynamics;
mod frame;
mod geometry;
mod inverse_dynamics;
mod joints;
mod kinematics;
mod mass_matrix;
mod mjcf;
mod model;
mod model_file;
mod read;
mod read_toml;
mod roles;
mod spatial;
mod table;
mod tree;
mod urdf;
mod urdf_text;
mod weld;
pub mod words;
mod write;
mod xml;

pub use base::Base;
pub use dynamics::Dynamics;
pub use error::ModelError;
pub use forward_dynamics::ForwardDynamics;
pub use frame::Frame;
pub use geometry::{Geometry, Shape};
pub use inverse_dynamics::InverseDynamics;
pub use joints::{Ball, Fixed, Floating, Joint, Prismatic, Revolute};
pub use mjcf::mesh_corners;
pub use model::{Body, ContactPoint, Dof, Follows, Model};
pub use roles::Roles;
pub use spatial::{Force, Inertia, Motion, Placement};
