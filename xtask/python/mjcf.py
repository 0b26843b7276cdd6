"""MJCF robots of other people, read by legwork and by MuJoCo: the same mass matrix, bias, springs, dampers and places of bodies in
random states, the same ranges and motors of joints.

Usage: mjcf.py PROGRAM [FILE...]

PROGRAM is the example `dynamics` of legwork-rbd. Without files the robots of the installed packages are read that walk.
"""

import json
import pathlib
import subprocess
import sys
import unittest
from importlib.util import find_spec

import mujoco
import numpy as np

PROGRAM = pathlib.Path(sys.argv[1]).resolve()
ROOT = pathlib.Path(__file__).resolve().parents[2]

# Bipeds, humanoids and other robots on legs.
ROBOTS = {
    "gymnasium": ["envs/mujoco/assets/" + name for name in [
        "ant.xml", "half_cheetah.xml", "hopper.xml", "humanoid.xml", "humanoidstandup.xml", "walker2d.xml", "walker2d_v5.xml"
    ]],
    "mjlab": ["asset_zoo/robots/unitree_g1/xmls/g1.xml", "asset_zoo/robots/unitree_go1/xmls/go1.xml"],
    "dm_control": [
        "suite/cheetah.xml", "suite/hopper.xml", "suite/humanoid.xml", "suite/humanoid_CMU.xml", "suite/quadruped.xml",
        "suite/walker.xml", "locomotion/walkers/assets/humanoid_CMU_V2019.xml",
        "locomotion/walkers/assets/humanoid_CMU_V2020.xml", "locomotion/walkers/assets/rodent.xml", "third_party/ant/ant.xml",
        # An arm whose inertias come from meshes.
        "third_party/kinova/jaco_arm.xml",
    ],
}

STATES = 20
# Of the largest entry. What differs is rounding: the same numbers are added in other orders.
TOLERANCE = 1e-10

FREE, BALL = int(mujoco.mjtJoint.mjJNT_FREE), int(mujoco.mjtJoint.mjJNT_BALL)


def joint_name(model, joint):
    return model.joint(joint).name or f"joint_{joint}"


class Coordinates:
    """Where each coordinate of legwork stands among those of MuJoCo."""

    def __init__(self, model, head):
        joints = {joint_name(model, joint): joint for joint in range(model.njnt)}
        names = [dof["name"] for dof in head["dofs"]]
        self.free, self.q, self.v = False, [], []
        if head["base"] == "floating":
            # Of several free bodies the one that carries others.
            free = [joint for joint in range(model.njnt) if model.jnt_type[joint] == FREE]
            root = max(free, key=lambda joint: np.sum(model.body_rootid == model.jnt_bodyid[joint]))
            q, v = model.jnt_qposadr[root], model.jnt_dofadr[root]
            self.free = True
            self.q += [*range(q + 3, q + 7), *range(q, q + 3)]
            self.v += [*range(v + 3, v + 6), *range(v, v + 3)]
            names = names[6:]
        for name in names:
            stem = name if name in joints else name[: -len("_wx")]
            joint = joints[stem]
            sizes = (4, 3) if model.jnt_type[joint] == BALL else (1, 1)
            if model.jnt_dofadr[joint] not in self.v:
                self.q += [model.jnt_qposadr[joint] + k for k in range(sizes[0])]
                self.v += [model.jnt_dofadr[joint] + k for k in range(sizes[1])]

    def of(self, qpos, qvel):
        """q and v of legwork, and the T and Ṫ v of v_mujoco = T v_legwork: both turn in the body's axes, MuJoCo moves in the world's."""
        q, v = qpos[self.q], qvel[self.v]
        T, rate = np.eye(len(v)), np.zeros(len(v))
        if self.free:
            rotation = np.zeros(9)
            mujoco.mju_quat2Mat(rotation, q[:4])
            rotation = rotation.reshape(3, 3)
            T[3:6, 3:6] = rotation
            v[3:6] = rotation.T @ v[3:6]
            rate[3:6] = rotation @ np.cross(v[:3], v[3:6])
        return q, v, T, rate


def random_state(model, random):
    qpos = np.array(model.qpos0)
    for joint in range(model.njnt):
        at = model.jnt_qposadr[joint]
        if model.jnt_type[joint] == FREE:
            qpos[at : at + 3] = random.uniform(-2, 2, 3)
            at += 3
        if model.jnt_type[joint] in (FREE, BALL):
            quaternion = random.normal(size=4)
            qpos[at : at + 4] = quaternion / np.linalg.norm(quaternion)
        else:
            qpos[at] += random.uniform(-1.5, 1.5)
    return qpos, random.uniform(-3, 3, model.nv)


def legwork(path, states):
    """What the program says of a file: of the robot, then of each state."""
    lines = "".join(json.dumps([list(map(float, q)), list(map(float, v))]) + "\n" for q, v in states)
    answer = subprocess.run([PROGRAM, path], input=lines, capture_output=True, text=True)
    if answer.returncode != 0:
        raise AssertionError(answer.stderr.strip())
    return [json.loads(line) for line in answer.stdout.splitlines()]


def mass_matrix(model, data):
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, M)
    return M


def effort(model, joint):
    """The most that the motors of a joint give together; none if there are no motors."""
    largest = lambda limited, span: np.abs(span).max() if limited else np.inf
    total = None
    for a in range(model.nu):
        if model.actuator_trntype[a] > int(mujoco.mjtTrn.mjTRN_JOINTINPARENT) or model.actuator_trnid[a, 0] != joint:
            continue
        most = largest(model.actuator_forcelimited[a], model.actuator_forcerange[a])
        plain = (
            model.actuator_gaintype[a] == int(mujoco.mjtGain.mjGAIN_FIXED)
            and model.actuator_biastype[a] == int(mujoco.mjtBias.mjBIAS_NONE)
            and model.actuator_dyntype[a] == int(mujoco.mjtDyn.mjDYN_NONE)
        )
        if plain:
            told = largest(model.actuator_ctrllimited[a], model.actuator_ctrlrange[a])
            most = min(most, abs(model.actuator_gainprm[a, 0]) * told)
        total = (total or 0) + abs(model.actuator_gear[a, 0]) * most
    if total is None:
        return None
    return min(total, largest(model.jnt_actfrclimited[joint], model.jnt_actfrcrange[joint]))


class Robots(unittest.TestCase):
    def close(self, what, found, expected):
        found, expected = np.asarray(found), np.asarray(expected)
        error = np.abs(found - expected).max(initial=0) / max(np.abs(expected).max(initial=0), 1e-3)
        self.worst[what] = max(self.worst.get(what, 0), error)
        self.assertLessEqual(error, TOLERANCE, what)

    def compare(self, path):
        self.worst = {}
        model = mujoco.MjModel.from_xml_path(str(path))
        model.opt.gravity[:2] = 0
        data = mujoco.MjData(model)
        head = legwork(path, [])[0]
        coordinates = Coordinates(model, head)
        random = np.random.default_rng(1)
        states = [random_state(model, random) for _ in range(STATES)]
        found = legwork(path, [coordinates.of(*state)[:2] for state in states])[1:]
        bodies = {model.body(body).name: body for body in range(1, model.nbody)}
        for (qpos, qvel), ours in zip(states, found, strict=True):
            data.qpos[:], data.qvel[:] = qpos, qvel
            mujoco.mj_forward(model, data)
            _, v, T, rate = coordinates.of(qpos, qvel)
            M = mass_matrix(model, data)[np.ix_(coordinates.v, coordinates.v)]
            bias = T.T @ (M @ rate + data.qfrc_bias[coordinates.v])
            passive = -T.T @ (data.qfrc_spring + data.qfrc_damper)[coordinates.v]
            self.close("M", np.reshape(ours["mass_matrix"], M.shape), T.T @ M @ T)
            self.close("bias", ours["bias"], bias)
            self.close("springs and dampers", ours["passive"], passive)
            named = [(place, bodies[name]) for place, name in zip(ours["positions"], head["bodies"]) if name in bodies]
            self.close("places", [place for place, _ in named], [data.xpos[body] for _, body in named])
        self.joints(model, head)
        figures = ", ".join(f"{what} {error:.1e}" for what, error in self.worst.items())
        print(f"{path}: {len(head['dofs'])} coordinates, {head['mass']:.4g} kg, {figures}")

    def joints(self, model, head):
        """Ranges, and which joints are driven, how hard; all are where a file has no motors at all."""
        dofs = {dof["name"]: dof for dof in head["dofs"]}
        for joint in range(model.njnt):
            dof = dofs.get(joint_name(model, joint))
            if dof is None or model.jnt_type[joint] in (FREE, BALL):
                continue
            limits = model.jnt_range[joint] if model.jnt_limited[joint] else [None, None]
            for end, limit in zip(("lower", "upper"), limits):
                self.assertEqual(dof[end] is None, limit is None, (dof["name"], end))
                if limit is not None:
                    self.assertAlmostEqual(dof[end], limit, 12, (dof["name"], end))
            most = effort(model, joint)
            self.assertEqual(dof["actuated"], most is not None or model.nu == 0, dof["name"])
            if most is not None and np.isfinite(most):
                self.assertAlmostEqual(dof["effort"], most, 9, dof["name"])
            elif model.nu > 0:
                self.assertIsNone(dof["effort"], dof["name"])


def installed():
    folder = lambda package: pathlib.Path(find_spec(package).submodule_search_locations[0])
    files = [folder(package) / name for package, names in ROBOTS.items() for name in names]
    return [ROOT / "crates/legwork-rbd/tests/data/biped.xml", *files]


for number, file in enumerate([pathlib.Path(name) for name in sys.argv[2:]] or installed()):
    setattr(Robots, f"test_{number:02}_{file.stem}", lambda self, file=file: self.compare(file))

if __name__ == "__main__":
    program = unittest.main(argv=sys.argv[:1], exit=False)
    failed = len({getattr(test, "test_case", test).id() for test, _ in program.result.failures + program.result.errors})
    passed = max(program.result.testsRun - failed, 0)
    print(f"test result: {passed} passed; {failed} failed")
    sys.exit(0 if failed == 0 and passed else 1)
