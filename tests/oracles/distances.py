#!/usr/bin/env python3
"""Writes distances.json: distances of seeded random pairs of convex solids, each known in two ways.

    pip install mujoco==4.0.0 numpy scipy
    python distances.py [--check]

With --check nothing is written; the exit code is 0 only when the stored numbers come out again to 1e-6.
One way is a convex program of scipy (SLSQP): two points, each inside of its solid, as near as can be; it gives both
points, so that the distance is never too small. Where such a pair has a separating slab of the same width (support
functions along the line between the points) the distance is never too large either; only pairs for which both meet to
1e-7 are kept. The other way is MuJoCo's mj_geomDistance, which must agree to 1e-5: its search on round bodies ends
there. A quarter of the pairs are boxes that differ by a yaw only, for which some libraries are wrong.
"""

import json
import math
import random
import sys
from pathlib import Path

import mujoco
import numpy
from scipy.optimize import minimize
from scipy.spatial import ConvexHull

HERE = Path(__file__).resolve().parent
SEED = 20261124
PAIRS = 320
KINDS = ["box", "sphere", "capsule", "cylinder", "hull"]


def rotation(draw, yaw_only):
    """A unit quaternion [w, x, y, z]."""
    if yaw_only:
        half = draw.uniform(-math.pi, math.pi) / 2
        return [math.cos(half), 0.0, 0.0, math.sin(half)]
    quaternion = [draw.gauss(0, 1) for _ in range(4)]
    length = math.sqrt(sum(x * x for x in quaternion))
    return [x / length for x in quaternion]


def solid(draw, kind, yaw_only):
    half = lambda: draw.uniform(0.02, 0.2)
    found = {
        "kind": kind,
        "position": [draw.uniform(-0.5, 0.5) for _ in range(3)],
        "quaternion": rotation(draw, yaw_only),
    }
    if kind == "box":
        found["half_extents"] = [half(), half(), half()]
    elif kind == "sphere":
        found["radius"] = half()
    elif kind in ("capsule", "cylinder"):
        found["radius"], found["half_length"] = half(), half()
    else:
        found["points"] = [[draw.uniform(-0.2, 0.2) for _ in range(3)] for _ in range(10)]
    return found


def matrix(quaternion):
    w, x, y, z = quaternion
    return numpy.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])


class Core:
    """A core with a ball about each point: constraints `g(p) >= 0` of the core, and its support function."""

    def __init__(self, solid):
        self.turn, self.origin = matrix(solid["quaternion"]), numpy.array(solid["position"])
        self.radius, self.solid = solid["radius"] if solid["kind"] in ("sphere", "capsule") else 0.0, solid
        half = solid.get("half_length", 0.0)
        box = {"box": solid.get("half_extents"), "sphere": [0, 0, 0], "capsule": [0, 0, half]}.get(solid["kind"])
        self.planes = None
        if box is not None:
            sides = numpy.vstack([numpy.eye(3), -numpy.eye(3)])
            self.planes = (sides, numpy.array(list(box) * 2))
        elif solid["kind"] == "hull":
            hull = ConvexHull(numpy.array(solid["points"]))
            self.planes = (hull.equations[:, :3], -hull.equations[:, 3])

    def local(self, p):
        return self.turn.T @ (p - self.origin)

    def inside(self, p):
        p = self.local(p)
        if self.planes is not None:
            return self.planes[1] - self.planes[0] @ p
        radius, half = self.solid["radius"], self.solid["half_length"]
        return numpy.array([radius**2 - p[0] ** 2 - p[1] ** 2, half - p[2], half + p[2]])

    def slopes(self, p):
        p = self.local(p)
        if self.planes is not None:
            return -self.planes[0] @ self.turn.T
        return numpy.array([[-2 * p[0], -2 * p[1], 0], [0, 0, -1], [0, 0, 1]]) @ self.turn.T

    def reach(self, n):
        local = self.turn.T @ n
        kind = self.solid["kind"]
        if kind == "box":
            far = numpy.abs(local) @ self.solid["half_extents"]
        elif kind == "hull":
            far = max(numpy.array(self.solid["points"]) @ local)
        else:
            far = abs(local[2]) * self.solid.get("half_length", 0.0)
            if kind == "cylinder":
                far += math.hypot(local[0], local[1]) * self.solid["radius"]
        return n @ self.origin + far + self.radius


def by_program(a, b):
    """The distance by a convex program, and the width of the slab between its points; None when it fails."""
    a, b = Core(a), Core(b)
    start = numpy.concatenate([a.origin, b.origin])
    if a.solid["kind"] == "hull":
        start[:3] += a.turn @ numpy.mean(a.solid["points"], axis=0)
    if b.solid["kind"] == "hull":
        start[3:] += b.turn @ numpy.mean(b.solid["points"], axis=0)
    zeros = lambda slopes: numpy.zeros_like(slopes)
    beside = lambda slopes, first: numpy.hstack([slopes, zeros(slopes)] if first else [zeros(slopes), slopes])
    found = minimize(
        lambda x: 0.5 * (x[3:] - x[:3]) @ (x[3:] - x[:3]),
        start,
        jac=lambda x: numpy.concatenate([x[:3] - x[3:], x[3:] - x[:3]]),
        method="SLSQP",
        constraints=[
            {"type": "ineq", "fun": lambda x: a.inside(x[:3]), "jac": lambda x: beside(a.slopes(x[:3]), True)},
            {"type": "ineq", "fun": lambda x: b.inside(x[3:]), "jac": lambda x: beside(b.slopes(x[3:]), False)},
        ],
        options={"ftol": 1e-16, "maxiter": 500},
    )
    across = found.x[3:] - found.x[:3]
    length = numpy.linalg.norm(across)
    if length < 1e-6:
        return None
    n = across / length
    slab = -b.reach(-n) - a.reach(n)
    return length - a.radius - b.radius, slab


def by_mujoco(a, b):
    """mj_geomDistance."""
    meshes, geoms = "", ""
    for name, solid in (("a", a), ("b", b)):
        size = {
            "box": solid.get("half_extents"),
            "sphere": [solid.get("radius")],
            "capsule": [solid.get("radius"), solid.get("half_length")],
            "cylinder": [solid.get("radius"), solid.get("half_length")],
        }.get(solid["kind"])
        words = lambda numbers: " ".join(repr(x) for x in numbers)
        place = f'pos="{words(solid["position"])}" quat="{words(solid["quaternion"])}"'
        if size is None:
            # MuJoCo moves a mesh to its middle and along its axes, and undoes that for a geom that names it.
            points = words([x for point in solid["points"] for x in point])
            meshes += f'<mesh name="{name}" vertex="{points}"/>'
            geoms += f'<geom name="{name}" type="mesh" mesh="{name}" {place}/>'
        else:
            geoms += f'<geom name="{name}" type="{solid["kind"]}" size="{words(size)}" {place}/>'
    text = f'<mujoco><option ccd_tolerance="1e-10" ccd_iterations="500"/><asset>{meshes}</asset>'
    model = mujoco.MjModel.from_xml_string(text + f"<worldbody>{geoms}</worldbody></mujoco>")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return mujoco.mj_geomDistance(model, data, 0, 1, 10.0, numpy.zeros(6))


def pairs():
    draw = random.Random(SEED)
    found, tried, worst = [], 0, 0.0
    while len(found) < PAIRS:
        tried += 1
        yaw_only = len(found) % 4 == 0
        kinds = ["box", "box"] if yaw_only else [draw.choice(KINDS), draw.choice(KINDS)]
        a, b = (solid(draw, kind, yaw_only) for kind in kinds)
        program = by_program(a, b)
        if program is None or program[0] < 1e-4 or abs(program[0] - program[1]) > 1e-7:
            continue
        other = by_mujoco(a, b)
        worst = max(worst, abs(other - program[0]))
        assert abs(other - program[0]) < 1e-5, (program, other, a, b)
        found.append({"a": a, "b": b, "distance": program[0], "mujoco": other})
    print(f"{len(found)} of {tried} pairs; the two ways differ by at most {worst:.1e} m")
    return found


def main():
    path = HERE / "distances.json"
    found = {"seed": SEED, "pairs": pairs()}
    if "--check" in sys.argv:
        stored = json.loads(path.read_text())["pairs"]
        near = lambda x, y: abs(x["distance"] - y["distance"]) < 1e-6 and x["a"] == y["a"] and x["b"] == y["b"]
        return 0 if len(stored) == len(found["pairs"]) and all(map(near, stored, found["pairs"])) else 1
    path.write_text(json.dumps(found, separators=(",", ":")).replace('{"a":', '\n{"a":') + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
