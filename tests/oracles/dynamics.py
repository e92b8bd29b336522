#!/usr/bin/env python3
"""Writes dynamics.json: mass matrices, bias forces, poses and Jacobians by MuJoCo, at seeded random states, of both
arms and of a six-joint arm from the tests of graspcheck-model.

    pip install mujoco==4.0.0
    python dynamics.py [--check]

With --check nothing is written; the exit code is 0 only when the stored numbers come out again to 1e-12.
MuJoCo's habits with URDF are met one by one:
- It fuses bodies without joints and may alter inertias that break the triangle rule: both are switched off.
- It has joint limits and friction as constraints and passive forces: both stand outside `qM` and `qfrc_bias`,
  and damping and friction are removed from the text all the same.
- It does not read `<mimic>` as one driven finger: the fingers are fixed at a stated opening before loading.
- It has no rotor inertia from URDF: robot.toml's number becomes the armature, which is in the mass matrix.
Gravity is not along an axis, so that every joint of either arm bears some of it.
"""

import json
import random
import sys
import tomllib
import xml.etree.ElementTree as xml
from pathlib import Path

import mujoco
import numpy

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
ROBOTS = ROOT / "assets" / "robots"
SIX = ROOT / "crates" / "graspcheck-model" / "tests" / "arms" / "six.urdf"
GRAVITY = [1.3, -3.7, -8.9]  # m/s²
STATES = 25
SEED = 20261124


def with_fixed_fingers(text, opening):
    """The URDF with both fingers rigidly at half the opening (m) from the middle, and a <mujoco> section."""
    robot = xml.fromstring(text)
    for joint in robot.findall("joint"):
        for passive in joint.findall("dynamics"):
            joint.remove(passive)
        if not joint.get("name").startswith("finger_"):
            continue
        origin = joint.find("origin")
        if [float(angle) for angle in origin.get("rpy", "0 0 0").split()] != [0.0, 0.0, 0.0]:
            sys.exit(f"{joint.get('name')}: a turned finger is not handled")
        at = [float(value) for value in origin.get("xyz", "0 0 0").split()]
        axis = [float(value) for value in joint.find("axis").get("xyz").split()]
        origin.set("xyz", " ".join(repr(p + a * opening / 2) for p, a in zip(at, axis)))
        joint.set("type", "fixed")
        for tag in ("axis", "limit", "mimic"):
            for child in joint.findall(tag):
                joint.remove(child)
    section = xml.SubElement(robot, "mujoco")
    xml.SubElement(section, "compiler", fusestatic="false", balanceinertia="false", inertiafromgeom="false")
    return xml.tostring(robot, encoding="unicode")


def mass_matrix(model, data):
    """M(q) column by column; by products, so that no storage format matters."""
    unit, column = numpy.eye(model.nv), numpy.zeros(model.nv)
    columns = []
    for k in range(model.nv):
        mujoco.mj_mulM(model, data, column, unit[k])
        columns.append(column.copy())
    return [[float(columns[c][r]) for c in range(model.nv)] for r in range(model.nv)]


def last_link(model, data):
    """Pose of the last moving link (rotation by rows, then origin) and the Jacobian of its origin, linear rows first.

    The fingers are fixed to it and come later in the list of bodies: the last link is the last joint's.
    """
    body = int(model.jnt_bodyid[model.njnt - 1])
    linear, angular = numpy.zeros((3, model.nv)), numpy.zeros((3, model.nv))
    mujoco.mj_jac(model, data, linear, angular, data.xpos[body], body)
    return {
        "rotation": data.xmat[body].tolist(),
        "origin": data.xpos[body].tolist(),
        "jacobian": numpy.vstack([linear, angular]).tolist(),
    }


def arm(name, opening, seed):
    settings = tomllib.loads((ROBOTS / name / "robot.toml").read_text())
    rotor = {
        joint: next(value for key, value in values.items() if key.startswith("rotor_inertia_"))
        for joint, values in settings["joint"].items()
    }
    return arm_of(name, (ROBOTS / name / settings["urdf"]).read_text(), rotor, opening, seed)


def arm_of(name, text, rotor, opening, seed):
    model = mujoco.MjModel.from_xml_string(with_fixed_fingers(text, opening))
    model.opt.gravity[:] = GRAVITY
    # The whole mass must have survived the reading.
    masses = [float(mass.get("value")) for mass in xml.fromstring(text).iter("mass")]
    if abs(sum(masses) - sum(model.body_mass)) > 1e-12 * sum(masses):
        sys.exit(f"{name}: MuJoCo has {sum(model.body_mass)} kg, the URDF {sum(masses)} kg")
    joints = [model.joint(k).name for k in range(model.njnt)]
    for k, joint in enumerate(joints):
        model.dof_armature[k] = rotor.get(joint, 0.0)
    data, states, source = mujoco.MjData(model), [], random.Random(seed)
    for _ in range(STATES):
        q = [source.uniform(*model.jnt_range[k]) for k in range(model.nv)]
        qd = [source.uniform(-4.0, 4.0) for _ in joints]
        data.qpos[:], data.qvel[:] = q, qd
        mujoco.mj_forward(model, data)
        found = {"mass_matrix": mass_matrix(model, data), "bias": data.qfrc_bias.tolist(), "last_link": last_link(model, data)}
        states.append({"q": q, "qd": qd, **found})
    rotors = [rotor.get(joint, 0.0) for joint in joints]
    return {"robot": name, "opening": opening, "gravity": GRAVITY, "joints": joints, "rotor_inertia": rotors, "states": states}


def differs(a, b):
    if isinstance(a, dict):
        return a.keys() != b.keys() or any(differs(a[key], b[key]) for key in a)
    if isinstance(a, list):
        return len(a) != len(b) or any(map(differs, a, b))
    if isinstance(a, float):
        return abs(a - b) > 1e-12 * max(1.0, abs(a))
    return a != b


def main():
    fixture = {
        "source": f"MuJoCo {mujoco.__version__}, tests/oracles/dynamics.py, seed {SEED}",
        "arms": [
            arm("scara", 0.04, SEED),
            arm("rrr", 0.2, SEED + 1),
            arm_of("six", SIX.read_text(), {}, 0.0, SEED + 2),
        ],
    }
    stored = HERE / "dynamics.json"
    if "--check" in sys.argv[1:]:
        sys.exit("dynamics.json says something else" if differs(fixture, json.loads(stored.read_text())) else 0)
    stored.write_text(json.dumps(fixture, indent=None, separators=(",", ":")).replace('{"q":', '\n{"q":') + "\n")


if __name__ == "__main__":
    main()
