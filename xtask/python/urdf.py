"""Every URDF of public packages, read by legwork and by Pinocchio: the same dynamics in the same states.

usage: urdf.py STATES, where STATES is the program `states` of crates/legwork-rbd/examples.
"""

import glob
import json
import os
import subprocess
import sys
import sysconfig
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

# Packages that carry robots, as folders below site-packages.
FOLDERS = ["cmeel.prefix/share/example-robot-data", "icub_models", "jvrc_description", "upkie_description"]
# Of the files that Pinocchio loads, so many legwork has to load.
SHARE = 0.97
# Of the largest entry, at least 1.
TOLERANCE = 1e-12


def robots():
    """The files that Pinocchio loads with two joints or more."""
    site = sysconfig.get_paths()["purelib"]
    files = [file for folder in FOLDERS for file in glob.glob(f"{site}/{folder}/**/*.urdf", recursive=True)]
    loaded = []
    for file in sorted({os.path.realpath(file) for file in files}):
        try:
            model = pin.buildModelFromUrdf(file)
        except Exception:
            continue
        if model.njoints > 2:
            loaded.append(file)
    return loaded


def leaders(file):
    """For each joint that mimics another one, that joint with the ratio and the offset."""
    joints = ElementTree.parse(file).getroot().iterfind("joint[mimic]")
    mimics = {joint.get("name"): joint.find("mimic") for joint in joints if joint.get("type") != "fixed"}
    number = lambda mimic, key, default: float(mimic.get(key, default))
    return {name: (m.get("joint"), number(m, "multiplier", 1), number(m, "offset", 0)) for name, m in mimics.items()}


def placed(peer, told, state, mimics):
    """Pinocchio's q and v of a state, and the matrix T with its v = T v, where joints of `mimics` may follow others."""
    q, v, T = pin.neutral(peer), np.zeros(peer.nv), np.zeros((peer.nv, told["nv"]))
    ours = {joint["name"]: joint for joint in told["joints"]}
    for index in range(1, peer.njoints):
        theirs, name, ratio, offset = peer.joints[index], peer.names[index], 1.0, 0.0
        name = "base" if name == "root_joint" else name
        is_locked = name in ours and ours[name]["type"] == "fixed"
        while name in mimics if is_locked else name not in ours:
            name, own_ratio, own_offset = mimics[name]
            ratio, offset = ratio * own_ratio, ratio * own_offset + offset
        if is_locked:
            # At zero, or where it is led to from there.
            q[theirs.idx_q : theirs.idx_q + theirs.nq] = (np.cos(offset), np.sin(offset)) if theirs.nq == 2 else offset
            continue
        own, at = state["q"][ours[name]["q"] :], ours[name]["v"]
        iq, iv = theirs.idx_q, theirs.idx_v
        if ours[name]["type"] == "floating":
            q[iq : iq + 7] = [*own[4:7], *own[1:4], own[0]]
            T[iv : iv + 3, at + 3 : at + 6] = T[iv + 3 : iv + 6, at : at + 3] = np.eye(3)
            continue
        angle = ratio * own[0] + offset
        q[iq : iq + theirs.nq] = (np.cos(angle), np.sin(angle)) if theirs.nq == 2 else angle
        T[iv, at] = ratio
    return q, T @ np.array(state["v"]), T


def differences(peer, told, mimics):
    """The largest difference of each quantity, as a share of its largest entry."""
    data, worst = peer.createData(), {}

    def compare(name, ours, theirs):
        scale = max(1.0, np.abs(theirs).max(initial=0.0))
        worst[name] = max(worst.get(name, 0.0), np.abs(np.array(ours) - theirs).max(initial=0.0) / scale)

    for state in told["states"]:
        q, v, T = placed(peer, told, state, mimics)
        pin.computeAllTerms(peer, data, q, v)
        M = np.triu(data.M) + np.triu(data.M, 1).T
        compare("mass matrix", state["mass_matrix"], T.T @ M @ T)
        compare("bias", state["bias"], T.T @ data.nle)
        compare("gravity", state["gravity"], T.T @ pin.computeGeneralizedGravity(peer, data, q))
        compare("centre of mass", state["com"], pin.centerOfMass(peer, data, q))
        A = pin.computeCentroidalMap(peer, data, q) @ T
        compare("momentum matrix", state["momentum_matrix"], np.vstack([A[3:], A[:3]]))
        pin.computeJointJacobians(peer, data, q)
        pin.updateFramePlacements(peer, data)
        for jacobian in state["jacobians"]:
            frame = peer.getFrameId(jacobian["body"], pin.FrameType.BODY)
            J = pin.getFrameJacobian(peer, data, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED) @ T
            compare("Jacobian", jacobian["rows"], np.vstack([J[3:], J[:3]]))
    return worst


def main():
    files = robots()
    by_mimic = {}
    for mimic in ["free", "coupled"]:
        answer = subprocess.run(
            [sys.argv[1], "--side", f'gravity_mps2 = 9.81\nmimic = "{mimic}"', *files], capture_output=True, text=True, check=True
        )
        by_mimic[mimic] = [json.loads(line) for line in answer.stdout.splitlines()]
    passed = failed = 0

    def count(what, holds):
        nonlocal passed, failed
        print(f"{'ok    ' if holds else 'FAILED'} {what}", flush=True)
        passed, failed = passed + holds, failed + (not holds)

    refused = [(told["file"], told["model"]["error"]) for told in by_mimic["free"] if "error" in told["model"]]
    for file, error in refused:
        print(f"refused: {error}")
    read = len(files) - len(refused)
    count(f"{read} of {len(files)} URDF files that Pinocchio loads are read", read >= SHARE * len(files) and len(files) > 60)
    for mimic, answers in by_mimic.items():
        for told in answers:
            file, model = told["file"], told["model"]
            if "error" in model:
                continue
            is_free = any(joint["name"] == "base" and joint["type"] == "floating" for joint in model["joints"])
            root = [pin.JointModelFreeFlyer()] if is_free else []
            # Coupled joints are v = G q̇ of those of the free model, whose equation of motion is then Gᵀ M G q̈ + Gᵀ h.
            peer = pin.buildModelFromUrdf(file, *root)
            peer.gravity.linear = np.array([0.0, 0.0, -9.81])
            name = os.path.basename(file)
            try:
                worst = differences(peer, model, leaders(file) if mimic == "coupled" else {})
            except Exception as error:
                count(f"{name}, mimic {mimic}: {error}", False)
                continue
            what, largest = max(worst.items(), key=lambda item: item[1])
            count(f"{name}, mimic {mimic}: {model['nv']} velocities, {what} within {largest:.1e}", largest < TOLERANCE)
    print(f"test result: {'FAILED' if failed else 'ok'}. {passed} passed; {failed} failed")
    sys.exit(bool(failed))


if __name__ == "__main__":
    main()
