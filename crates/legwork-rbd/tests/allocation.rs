//! A control tick allocates nothing. In a binary of its own, since the counting allocator is global.

#![allow(non_snake_case)]

mod common;

use legwork_rbd::{Dynamics, ForwardDynamics, InverseDynamics};
use nalgebra::DMatrix;

#[test]
fn update_and_queries_allocate_nothing() {
    for model in [common::planar_humanoid(), common::biped18()] {
        let mut random = common::Random(12);
        let (q, v) = (random.q(&model), random.v(&model));
        let mut next = vec![0.0; model.nq()];
        let mut dynamics = Dynamics::new(&model);
        let mut J = DMatrix::zeros(model.linear_axes().len(), model.nv());
        let mut W = DMatrix::zeros(model.angular_axes().len(), model.nv());
        let (mut forward, mut inverse) = (ForwardDynamics::new(&model), InverseDynamics::new(&model));
        let (mut vdot, mut tau) = (vec![0.0; model.nv()], vec![0.0; model.nv()]);
        let rho = vec![1.0; model.linear_axes().len() * model.nc()];
        let frame = model.frame(&model.bodies.last().unwrap().name).unwrap();
        let mut of_frame = DMatrix::zeros(J.nrows() + W.nrows(), model.nv());
        let foot = model.contacts[0].body;
        let count = allocation_counter::measure(|| {
            for _ in 0..10 {
                dynamics.update(&model, &q, &v);
                dynamics.frame_jacobian(&model, &frame, &mut of_frame);
                std::hint::black_box((dynamics.frame_pose(&frame), dynamics.frame_bias(&frame)));
                inverse.solve(&model, &dynamics, &v, &rho, &mut tau);
                assert!(forward.solve(&model, &dynamics, &tau, &rho, &mut vdot));
                model.integrate(&q, &v, 1e-3, &mut next);
                let position = dynamics.contact_positions[0];
                dynamics.point_jacobian(&model, foot, &position, &mut J);
                dynamics.angular_jacobian(&model, foot, &mut W);
                std::hint::black_box((dynamics.angular_bias(foot), dynamics.point_bias(foot, &position)));
            }
        });
        assert_eq!(count.count_total, 0, "{}", model.name);
        // The counter counts
        assert!(allocation_counter::measure(|| drop(std::hint::black_box(vec![0; 8]))).count_total > 0);
    }
}
