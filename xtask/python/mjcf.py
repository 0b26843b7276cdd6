"""MJCF robots of other people, read by legwork and by MuJoCo: the same mass matrix, bias, springs and dampers in random states.

Usage: mjcf.py PROGRAM [--list] FILE...

PROGRAM is the example `dynamics` of legwork-rbd. A file that MuJoCo itself cannot load is no test. Ends with `N passed, N failed`.
"""

import json
import subprocess
import sys

import mujoco
import numpy as np

STATES = 20
# Relative to the largest entry: rounding of the two, which add the same numbers in other orders.
TOLERANCE = 1e-10


def joint_name(model, j):
    return model.joint(j).name or f"joint_{j}"


class Coordinates:
    """Where each coordinate of legwork stands in MuJoCo's."""

    def __init__(self, model, head):
        names = {joint_name(model, j): j for j in range(model.njnt)}
        free = [j for j in range(model.njnt) if model.jnt_type[j] == mujoco.mjtJoint.mjJNT_FREE]
        self.free = None
        self.dofs, self.q = [], []
        dofs = [dof["name"] for dof in head["dofs"]]
        if head["base"] == "floating":
            # Of several free bodies the one that carries joints.
            carries = [j for j in free if (model.body_rootid[model.jnt_bodyid] == model.jnt_bodyid[j]).sum() > 1] or free
            self.free = carries[0]
            dofs = dofs[6:]
            at, v = model.jnt_qposadr[self.free], model.jnt_dofadr[self.free]
            self.q += list(range(at + 3, at + 7)) + list(range(at, at + 3))
            self.dofs += list(range(v + 3, v + 6)) + list(range(v, v + 3))
        done = set()
        for name in dofs:
            ball = next((name[: -len(s)] for s in ("_wx", "_wy", "_wz") if name.endswith(s) and name[: -len(s)] in names), None)
            j = names[ball if ball and name not in names else name]
            if j in done:
                continue
            done.add(j)
            size = {mujoco.mjtJoint.mjJNT_BALL: (4, 3)}.get(model.jnt_type[j], (1, 1))
            self.q += [model.jnt_qposadr[j] + k for k in range(size[0])]
            self.dofs += [model.jnt_dofadr[j] + k for k in range(size[1])]

    def state(self, model, random):
        qpos = np.array(model.qpos0)
        for j in range(model.njnt):
            at = model.jnt_qposadr[j]
            kind = model.jnt_type[j]
            if kind in (mujoco.mjtJoint.mjJNT_FREE, mujoco.mjtJoint.mjJNT_BALL):
                if kind == mujoco.mjtJoint.mjJNT_FREE:
                    qpos[at : at + 3] = random.uniform(-2, 2, 3)
                    at += 3
                quaternion = random.normal(size=4)
                qpos[at : at + 4] = quaternion / np.linalg.norm(quaternion)
            else:
                qpos[at] += random.uniform(-1.5, 1.5)
        return qpos, random.uniform(-3, 3, model.nv)

    def to_legwork(self, qpos, qvel):
        """q and v of legwork, and T of v_mujoco = T v_legwork with T's rate times v."""
        q, v = qpos[self.q], qvel[self.dofs]
        T, rate = np.eye(len(v)), np.zeros(len(v))
        if self.free is not None:
            R = np.zeros(9)
            mujoco.mju_quat2Mat(R, q[:4])
            R = R.reshape(3, 3)
            T[3:6, 3:6] = R
            v[3:6] = R.T @ v[3:6]
            rate[3:6] = R @ np.cross(v[:3], v[3:6])
        return q, v, T, rate


def full_mass_matrix(model, data):
    M = np.zeros((model.nv, model.nv))
    try:
        mujoco.mj_fullM(model, M, data.qM)
    except (TypeError, AttributeError):
        mujoco.mj_fullM(model, data, M)
    return M


def compare(program, path):
    """The worst errors, relative to the largest entry: mass matrix, bias, springs and dampers; then the head."""
    model = mujoco.MjModel.from_xml_path(path)
    data = mujoco.MjData(model)
    answer = subprocess.run([program, path], input="", capture_output=True, text=True)
    if answer.returncode != 0:
        raise RuntimeError(answer.stderr.strip())
    head = json.loads(answer.stdout.splitlines()[0])
    coordinates = Coordinates(model, head)
    random = np.random.default_rng(1)
    states = [coordinates.state(model, random) for _ in range(STATES)]
    lines = []
    for qpos, qvel in states:
        q, v, _, _ = coordinates.to_legwork(qpos, qvel)
        lines.append(json.dumps([list(map(float, q)), list(map(float, v))]))
    answer = subprocess.run([program, path], input="\n".join(lines), capture_output=True, text=True)
    if answer.returncode != 0:
        raise RuntimeError(answer.stderr.strip())
    worst = np.zeros(3)
    for (qpos, qvel), line in zip(states, answer.stdout.splitlines()[1:], strict=True):
        found = json.loads(line)
        data.qpos[:], data.qvel[:] = qpos, qvel
        mujoco.mj_forward(model, data)
        q, v, T, rate = coordinates.to_legwork(qpos, qvel)
        n = len(v)
        rows = np.ix_(coordinates.dofs, coordinates.dofs)
        M = full_mass_matrix(model, data)[rows]
        bias = T.T @ (M @ rate + data.qfrc_bias[coordinates.dofs])
        M = T.T @ M @ T
        passive = -T.T @ (data.qfrc_spring + data.qfrc_damper)[coordinates.dofs]
        for k, (own, other) in enumerate(
            [(np.reshape(found["mass_matrix"], (n, n)), M), (found["bias"], bias), (found["passive"], passive)]
        ):
            scale = max(np.abs(other).max(initial=0.0), 1e-3)
            worst[k] = max(worst[k], np.abs(np.asarray(own) - other).max(initial=0.0) / scale)
    return worst, head, model


def efforts(model, head):
    """Joints whose limits of position differ."""
    wrong = []
    for dof in head["dofs"]:
        for j in range(model.njnt):
            if joint_name(model, j) != dof["name"] or not model.jnt_limited[j]:
                continue
            if not np.allclose([dof["lower"], dof["upper"]], model.jnt_range[j], rtol=1e-12, atol=1e-12):
                wrong.append(dof["name"])
    return wrong


def main():
    program, *files = sys.argv[1:]
    details = "--list" in files
    passed = failed = 0
    for path in (file for file in files if file != "--list"):
        try:
            mujoco.MjModel.from_xml_path(path)
        except ValueError as error:
            print(f"skipped, MuJoCo does not load it: {path}: {str(error).splitlines()[0]}")
            continue
        try:
            worst, head, model = compare(program, path)
            ranges = efforts(model, head)
            good = (worst <= TOLERANCE).all() and not ranges
            words = f"M {worst[0]:.1e}, bias {worst[1]:.1e}, springs and dampers {worst[2]:.1e}"
            words += f", {len(head['dofs'])} coordinates, {head['mass']:.4g} kg" + (f", ranges of {ranges}" if ranges else "")
        except Exception as error:  # noqa: BLE001: whatever it is, the file failed
            good, words, head = False, f"{type(error).__name__}: {error}", None
        passed, failed = passed + good, failed + (not good)
        print(f"{'ok' if good else 'FAILED'}: {path}: {words}")
        if details and head:
            for warning in head["warnings"]:
                print(f"    {warning}")
    print(f"{passed} passed, {failed} failed")
    return failed > 0


if __name__ == "__main__":
    sys.exit(main())
