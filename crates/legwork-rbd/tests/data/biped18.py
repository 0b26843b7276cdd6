"""Writes biped18.urdf and, with Pinocchio, biped18_vectors.json.

    pip install pin && python biped18.py

The robot is made up for the tests: a pelvis with a trunk on a fixed joint and two legs of six joints, 18 degrees of
freedom on a floating base, with oblique axes, turned origins and turned inertias so that no sign can hide. The vectors
are in this project's order (angular before linear, quaternion w first), converted here from Pinocchio's.
"""

import json
import random

import numpy as np
import pinocchio as pin

random.seed(18)


def inertial(mass, com, size, rpy=(0, 0, 0)):
    """Of a solid box."""
    a, b, c = size
    i = [mass / 12 * (b * b + c * c), mass / 12 * (a * a + c * c), mass / 12 * (a * a + b * b)]
    cross = [0.08 * min(i), -0.05 * min(i), 0.06 * min(i)]
    return f"""    <inertial>
      <origin xyz="{com[0]} {com[1]} {com[2]}" rpy="{rpy[0]} {rpy[1]} {rpy[2]}"/>
      <mass value="{mass}"/>
      <inertia ixx="{i[0]:.6f}" iyy="{i[1]:.6f}" izz="{i[2]:.6f}" ixy="{cross[0]:.6f}" ixz="{cross[1]:.6f}" iyz="{cross[2]:.6f}"/>
    </inertial>
"""


def link(name, *args, **kw):
    return f'  <link name="{name}">\n{inertial(*args, **kw)}  </link>\n'


def joint(name, kind, parent, child, xyz, axis=None, rpy=(0, 0, 0), limits=None):
    text = f'  <joint name="{name}" type="{kind}">\n'
    text += f'    <origin xyz="{xyz[0]} {xyz[1]} {xyz[2]}" rpy="{rpy[0]} {rpy[1]} {rpy[2]}"/>\n'
    text += f'    <parent link="{parent}"/>\n    <child link="{child}"/>\n'
    if axis:
        text += f'    <axis xyz="{axis[0]} {axis[1]} {axis[2]}"/>\n'
    if limits:
        text += f'    <limit lower="{limits[0]}" upper="{limits[1]}" effort="{limits[2]}" velocity="{limits[3]}"/>\n'
        text += '    <dynamics damping="0.5"/>\n'
    return text + "  </joint>\n"


def robot():
    text = '<?xml version="1.0"?>\n<!-- Written by biped18.py: a robot made up for the tests. -->\n<robot name="biped18">\n'
    text += link("pelvis", 9.5, (0.01, 0.0, 0.04), (0.2, 0.3, 0.15), rpy=(0.1, -0.2, 0.3))
    text += link("trunk", 31.0, (0.02, 0.01, 0.21), (0.22, 0.36, 0.55))
    text += joint("waist", "fixed", "pelvis", "trunk", (-0.01, 0.0, 0.11), rpy=(0.02, 0.05, -0.03))
    for side, y in (("right", -1.0), ("left", 1.0)):
        text += link(f"{side}_hip", 1.6, (0.02, 0.01 * y, -0.01), (0.1, 0.1, 0.12))
        text += link(f"{side}_hip_fork", 1.1, (-0.01, 0.02 * y, 0.02), (0.08, 0.12, 0.1), rpy=(0.4, 0.1, -0.2))
        text += link(f"{side}_thigh", 7.2, (0.01, 0.015 * y, -0.19), (0.14, 0.15, 0.42))
        text += link(f"{side}_shank", 3.4, (-0.015, 0.005 * y, -0.18), (0.1, 0.11, 0.4), rpy=(0, 0.15, 0.1))
        text += link(f"{side}_ankle", 0.4, (0.0, 0.0, -0.02), (0.06, 0.07, 0.05))
        text += link(f"{side}_foot", 1.1, (0.045, 0.0, -0.03), (0.26, 0.1, 0.06))
        text += f'  <link name="{side}_sole"/>\n'
        text += joint(f"{side}_haa", "revolute", "pelvis", f"{side}_hip", (0.0, 0.09 * y, -0.03), (1, 0, 0), limits=(-0.6, 0.6, 160, 8))
        text += joint(f"{side}_hie", "revolute", f"{side}_hip", f"{side}_hip_fork", (0.01, 0.01 * y, -0.04), (0.1, 0, 1), rpy=(0, 0.1, 0), limits=(-0.7, 0.7, 80, 8))
        text += joint(f"{side}_hfe", "revolute", f"{side}_hip_fork", f"{side}_thigh", (0.0, 0.02 * y, -0.03), (0, 1, 0), rpy=(0.05 * y, 0, 0.1), limits=(-1.9, 0.6, 180, 10))
        text += joint(f"{side}_kfe", "revolute", f"{side}_thigh", f"{side}_shank", (0.0, 0.0, -0.42), (0, 1, 0), limits=(0.0, 2.3, 220, 12))
        text += joint(f"{side}_adp", "revolute", f"{side}_shank", f"{side}_ankle", (0.0, 0.0, -0.41), (0, 2, 0), limits=(-0.8, 0.7, 150, 10))
        text += joint(f"{side}_aie", "revolute", f"{side}_ankle", f"{side}_foot", (0.0, 0.0, -0.02), (0.9, 0.1 * y, -0.3), limits=(-0.4, 0.4, 60, 10))
        text += joint(f"{side}_sole_frame", "fixed", f"{side}_foot", f"{side}_sole", (0.04, 0.0, -0.06))
    return text + "</robot>\n"


CONTACTS = [
    ("right_heel", "right_foot", (-0.07, 0.0, -0.06)),
    ("right_toe", "right_foot", (0.17, 0.01, -0.06)),
    ("left_heel", "left_foot", (-0.07, 0.0, -0.06)),
    ("left_toe", "left_foot", (0.17, -0.01, -0.06)),
]


def main():
    with open("biped18.urdf", "w") as file:
        file.write(robot())
    with open("biped18.legwork.toml", "w") as file:
        file.write('# Beside biped18.urdf; written by biped18.py.\nbase = "floating"\ntorso = "trunk"\ngravity_mps2 = 9.81\n\n')
        file.write("contacts = [\n")
        for name, body, position in CONTACTS:
            file.write(f'    {{ name = "{name}", body = "{body}", foot = "{body}", position_m = {list(map(float, position))} }},\n')
        file.write("]\n")

    model = pin.buildModelFromUrdf("biped18.urdf", pin.JointModelFreeFlyer())
    model.gravity.linear = np.array([0, 0, -9.81])
    frames = []
    for name, body, position in CONTACTS:
        frame = model.frames[model.getFrameId(body)]
        placement = frame.placement * pin.SE3(np.eye(3), np.array(position))
        frames.append(model.addFrame(pin.Frame(name, frame.parentJoint, model.getFrameId(body), placement, pin.FrameType.OP_FRAME)))
    trunk = model.getFrameId("trunk")
    data = model.createData()
    aligned = pin.LOCAL_WORLD_ALIGNED

    order = [f"{side}_{j}" for side in ("right", "left") for j in ("haa", "hie", "hfe", "kfe", "adp", "aie")]
    joints = [model.joints[model.getJointId(name)].idx_v for name in order]
    columns = [3, 4, 5, 0, 1, 2] + joints  # angular before linear
    rows6 = [3, 4, 5, 0, 1, 2]

    def own_q(q):
        return [q[6], q[3], q[4], q[5], q[0], q[1], q[2]] + [q[i + 1] for i in joints]

    cases = []
    for _ in range(5):
        q = pin.neutral(model)
        q[:3] = [random.uniform(-2, 2) for _ in range(3)]
        quaternion = np.array([random.gauss(0, 1) for _ in range(4)])
        q[3:7] = quaternion / np.linalg.norm(quaternion)
        q[7:] = [random.uniform(-1, 1) for _ in range(12)]
        v = np.array([random.uniform(-3, 3) for _ in range(18)])
        M = pin.crba(model, data, q)
        M = np.triu(M) + np.triu(M, 1).T
        h = pin.nonLinearEffects(model, data, q, v)
        G = pin.computeGeneralizedGravity(model, data, q)
        pin.dccrba(model, data, q, v)
        A, Adv = data.Ag.copy(), data.dAg @ v
        Jcom = pin.jacobianCenterOfMass(model, data, q)
        pin.centerOfMass(model, data, q, v)
        com, vcom = data.com[0].copy(), data.vcom[0].copy()
        kinetic = pin.computeKineticEnergy(model, data, q, v)
        pin.forwardKinematics(model, data, q, v, np.zeros(18))
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        J = np.vstack([pin.getFrameJacobian(model, data, f, aligned)[:3] for f in frames])
        Jdv = np.hstack([pin.getFrameClassicalAcceleration(model, data, f, aligned).linear for f in frames])
        feet = np.hstack([data.oMf[f].translation for f in frames])
        torso = pin.getFrameJacobian(model, data, trunk, aligned)[3:]
        torso_bias = pin.getFrameAcceleration(model, data, trunk, aligned).angular
        turned = pin.integrate(model, q, 0.1 * v)
        cases.append(
            {
                "q": own_q(q),
                "v": v[columns].tolist(),
                "M": M[np.ix_(columns, columns)].tolist(),
                "h": h[columns].tolist(),
                "G": G[columns].tolist(),
                "A": A[np.ix_(rows6, columns)].tolist(),
                "Adv": Adv[rows6].tolist(),
                "com": com.tolist(),
                "vcom": vcom.tolist(),
                "Jcom": Jcom[:, columns].tolist(),
                "J": J[:, columns].tolist(),
                "Jdv": Jdv.tolist(),
                "contacts": feet.tolist(),
                "torso_J": torso[:, columns].tolist(),
                "torso_Jdv": torso_bias.tolist(),
                "kinetic_energy": kinetic,
                "q_after_0.1_s": own_q(turned),
            }
        )
    note = f"Computed by Pinocchio {pin.__version__} with biped18.py from biped18.urdf. SI units, world axes, rows and columns angular before linear."
    with open("biped18_vectors.json", "w") as file:
        file.write(json.dumps({"note": note, "joints": order, "cases": cases}, separators=(",", ":")) + "\n")


main()
