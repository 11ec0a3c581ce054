# SPDX-License-Identifier: Apache-2.0
"""How the force of a wall rises with depth: on virtual time, without a device, the same each time.
02_lockstep.py [RENDERER…]: a column each."""

import sys

import hapticd
import numpy as np

CONFIG = {
    "session": {"name": "wall"},
    "device": {"kind": "simulated-hand"},  # its limits count; the hand is `dive`
    "coupling": {"stiffness": "800 N/m"},
    "object": [{"name": "wall", "primitive": "box", "extent": ["80 mm", "80 mm", "80 mm"]}],
}
SURFACE = 0.04  # [m], its upper face
DEPTHS = 0.001 * np.arange(9)  # [m]
BEGIN, MOVE, HOLD = 0.7, 0.1, 0.2  # [s]: soft start and way to the surface; to the next depth; there


def dive(t, wrench):
    """Where the hand is: from 10 mm above the wall to each depth, where it rests for a while."""
    places = np.concatenate([[SURFACE + 0.01], SURFACE - DEPTHS])
    arrive = np.concatenate([[0.0], BEGIN + (MOVE + HOLD) * np.arange(len(DEPTHS))])
    leave = arrive + HOLD
    if t > leave[-1]:
        return None
    z = np.interp(t, np.stack([arrive, leave], 1).ravel(), np.repeat(places, 2))
    return np.array([0.0, 0.0, z])


def forces(renderer):
    """The force at each depth [N], at the end of the rest."""
    ends = BEGIN + (MOVE + HOLD) * np.arange(len(DEPTHS)) + HOLD
    felt = [
        (step.t, step.servo["F_device_B"]["f"][2])
        for step in hapticd.lockstep(CONFIG, dive, renderer=renderer)
    ]
    t, force = np.transpose(felt)
    return force[np.searchsorted(t, ends - 1e-9) - 1]


renderers = sys.argv[1:] or ["god-object3", "penalty3"]
columns = [forces(renderer) for renderer in renderers]
print("depth [mm]  " + "  ".join(f"{name:>12} [N]" for name in renderers))
for depth, *row in zip(DEPTHS, *columns):
    print(f"{1e3 * depth:10.1f}  " + "  ".join(f"{force:16.3f}" for force in row))
