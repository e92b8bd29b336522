#!/usr/bin/env python3
"""Writes splines.json: cubic splines by scipy under every end condition, at seeded random points.

    pip install scipy==1.17.1
    python splines.py [--check]

With --check nothing is written; the exit code is 0 only when the stored numbers come out again to 1e-12.
Points are 2, 3, 4, 5 and 12, unequally spaced, of two joints; the first time is not 0. Conditions at the two
ends are mixed in all ways; `periodic` closes the last point on the first one. Stored are position, velocity,
acceleration and jerk at one place inside each piece: these four numbers are the cubic.
"""

import itertools
import json
import random
import sys
from pathlib import Path

import numpy
from scipy.interpolate import CubicSpline

HERE = Path(__file__).resolve().parent
SEED = 20261125
JOINTS = 2
COUNTS = [2, 3, 4, 5, 12]
INSIDE = 0.37  # of each piece
ENDS = ["velocity", "acceleration", "natural", "not_a_knot"]


def end_condition(word, draw):
    """The condition as scipy takes it, and the numbers in it."""
    if word == "not_a_knot":
        return "not-a-knot", None
    if word == "natural":
        return (2, numpy.zeros(JOINTS)), None
    values = numpy.array([draw.uniform(-2.0, 2.0) for _ in range(JOINTS)])
    return (1 if word == "velocity" else 2, values), values.tolist()


def case(count, start, end, draw):
    """A spline through points drawn at random, and its values."""
    times = numpy.cumsum([draw.uniform(0.1, 2.0) for _ in range(count)])
    positions = numpy.array([[draw.uniform(-3.0, 3.0) for _ in range(JOINTS)] for _ in range(count)])
    if start == "periodic":
        positions[-1] = positions[0]
        conditions, numbers = "periodic", [None, None]
    else:
        (at_start, first), (at_end, second) = end_condition(start, draw), end_condition(end, draw)
        conditions, numbers = (at_start, at_end), [first, second]
    spline = CubicSpline(times, positions, bc_type=conditions)
    places = [a + INSIDE * (b - a) for a, b in zip(times, times[1:])]
    return {
        "start": {"kind": start, "values": numbers[0]},
        "end": {"kind": end, "values": numbers[1]},
        "times": times.tolist(),
        "positions": positions.tolist(),
        "at": [float(t) for t in places],
        "values": [[spline(t, order).tolist() for order in range(4)] for t in places],
    }


def cases():
    draw = random.Random(SEED)
    found = []
    for count in COUNTS:
        for start, end in itertools.product(ENDS, ENDS):
            found.append(case(count, start, end, draw))
        found.append(case(count, "periodic", "periodic", draw))
    return found


def same(stored, found):
    """Whether two values agree to 1e-12 of the larger one."""
    if isinstance(stored, dict):
        return stored.keys() == found.keys() and all(same(stored[key], found[key]) for key in stored)
    if isinstance(stored, list):
        return len(stored) == len(found) and all(map(same, stored, found))
    if isinstance(stored, float):
        return abs(stored - found) <= 1e-12 * max(1.0, abs(stored), abs(found))
    return stored == found


def main():
    import scipy

    found = {"scipy": scipy.__version__, "cases": cases()}
    path = HERE / "splines.json"
    if "--check" in sys.argv[1:]:
        sys.exit(0 if same(json.loads(path.read_text())["cases"], found["cases"]) else "the numbers differ")
    lines = ",\n".join(json.dumps(case, separators=(",", ":")) for case in found["cases"])
    path.write_text(f'{{"scipy": "{found["scipy"]}", "cases": [\n{lines}\n]}}\n')


if __name__ == "__main__":
    main()
