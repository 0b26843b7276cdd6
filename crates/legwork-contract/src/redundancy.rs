//! Which joints the tasks of a biped leave free: those that neither torso nor feet depend on, and those that are more than torso and
//! feet need.
//!
//! Torso, centre of mass and two feet determine a body and two legs of as many joints as a foot has rows. Arms, neck and hands are on no
//! way from the torso to a foot; a waist is on the way to both; a leg of seven joints can move between a body and a foot that rest.

use crate::feet::FootRows;
use crate::robot::Robot;

/// The actuated coordinates of `robot` that its feet, centre of mass and torso leave free, by their place in `Model::dofs`, in order.
pub fn free_joints(robot: &Robot) -> Vec<usize> {
    let ways: Vec<Vec<bool>> = (0..robot.feet.len()).map(|foot| way(robot, foot)).collect();
    let on = |foot: usize, dof: usize| ways[foot][robot.dofs[dof].body];
    let shared = |dof: usize| (0..ways.len()).all(|foot| on(foot, dof));
    let spare: Vec<bool> = FootRows::of(robot)
        .iter()
        .enumerate()
        .map(|(foot, rows)| {
            let joints = robot.actuated().filter(|&dof| on(foot, dof) && !shared(dof)).count();
            joints > rows.angular.len() + rows.linear.len()
        })
        .collect();
    let needed = |dof: usize| !shared(dof) && (0..ways.len()).any(|foot| on(foot, dof) && !spare[foot]);
    robot.actuated().filter(|&dof| !needed(dof)).collect()
}

/// The bodies of a leg, from the hip to the foot: those on the way from the torso to a foot that lead to no other, with joints that move.
pub fn leg(robot: &Robot, foot: usize) -> Vec<usize> {
    let ways: Vec<Vec<bool>> = (0..robot.feet.len()).map(|foot| way(robot, foot)).collect();
    let own = |body: &usize| (0..ways.len()).all(|other| ways[other][*body] == (other == foot));
    let mut carries_torso = vec![false; robot.bodies.len()];
    let mut at = Some(robot.torso);
    while let Some(body) = at {
        carries_torso[body] = true;
        at = robot.bodies[body].parent;
    }
    // A robot may be rooted in a leg: from its torso the way goes up to the root before it goes down.
    let joints = (0..robot.bodies.len()).filter(own).filter(|&body| robot.bodies[body].joint.nv() > 0);
    let (mut up, down): (Vec<usize>, Vec<usize>) = joints.partition(|&body| carries_torso[body]);
    up.reverse();
    up.into_iter().chain(down).collect()
}

/// For each body, whether its joint is on the way from the torso to a foot.
fn way(robot: &Robot, foot: usize) -> Vec<bool> {
    let mut on = vec![false; robot.bodies.len()];
    let ends = robot.points_of(foot).take(1).map(|point| robot.contacts[point].body).chain([robot.torso]);
    for end in ends {
        let mut at = Some(end);
        while let Some(body) = at {
            // What both ends stand on is on no way between them.
            on[body] = !on[body];
            at = robot.bodies[body].parent;
        }
    }
    on
}
