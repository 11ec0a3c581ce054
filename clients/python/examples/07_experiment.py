# SPDX-License-Identifier: Apache-2.0
"""Which wall is stiffer? A two-interval forced choice with a staircase, two down and one up, which
ends near 71 % right. 07_experiment.py [--simulated]: a made-up person answers, to try it."""

import random
import sys
import time

import hapticd
import numpy as np

STANDARD = 500.0  # [N/m]
FIRST_STEP, FACTOR = 200.0, 0.7  # of the difference [N/m]
INTERVAL, REVERSALS = (0.3, 6) if "--simulated" in sys.argv else (2.0, 8)  # [s], number
CONFIG = {
    "session": {"name": "experiment"},
    "device": {"kind": "simulated-hand"},  # yours: docs/devices.md
    "coupling": {"stiffness": f"{STANDARD} N/m"},
    "object": [{"name": "wall", "primitive": "sphere", "size": "80 mm"}],
}


def feel(session, stiffness):
    """One interval; the largest force that was felt [N]."""
    frames = session.servo()
    session.set("stiffness", f"{stiffness:.1f} N/m")
    time.sleep(0.2 + INTERVAL)  # the stiffness ramps over 200 ms
    out = frames.empty(4096)
    n, _ = frames.next(out)
    return float(np.linalg.norm(out["F_device_B"]["f"][:n], axis=1).max(initial=0))


def answer(stiffnesses):
    """1 or 2: which of them the person calls stiffer."""
    if "--simulated" in sys.argv:
        felt = [k * random.gauss(1, 0.1) for k in stiffnesses]  # a Weber fraction of 10 %
        return 1 + int(felt[1] > felt[0])
    return int(input("which was stiffer, 1 or 2? "))


with hapticd.run(CONFIG) as session:
    difference, right_in_row, turns, last = FIRST_STEP, 0, [], 0
    while len(turns) < REVERSALS:
        pair = [STANDARD, STANDARD + difference]
        random.shuffle(pair)
        forces = [feel(session, stiffness) for stiffness in pair]
        right = pair[answer(pair) - 1] > STANDARD
        right_in_row = right_in_row + 1 if right else 0
        print(f"{difference:6.1f} N/m  {'right' if right else 'wrong'}   {np.round(forces, 2)} N", flush=True)
        way = 1 if not right else -1 if right_in_row == 2 else 0
        if way and last and way != last:
            turns.append(difference)
        if way:
            difference, right_in_row, last = difference * FACTOR**-way, 0, way
    print(f"threshold {np.mean(turns[2:]):.0f} N/m at {STANDARD:.0f} N/m")
