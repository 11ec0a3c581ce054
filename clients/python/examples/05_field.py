# SPDX-License-Identifier: Apache-2.0
"""A charge that pulls the hand's tool: the force and how it changes, computed here a hundred times a
second. 05_field.py [SESSION]; start one with `hapticd configs/field.toml`."""
import sys

import hapticd
import numpy as np

CHARGE = np.array([0.0, 0.0, 0.0])  # in W [m]
STRENGTH = 2e-3  # F = STRENGTH / r²: 2 N at 32 mm [N·m²]
NEAREST = 0.02  # where the law ends, inside of the ball that stands for the charge [m]


def force_and_slope(x):
    """F [N] at x [m], and its derivative K (3, 3) [N/m]."""
    away = x - CHARGE
    r = max(np.linalg.norm(away), NEAREST)
    F = -STRENGTH / r**3 * away
    K = -STRENGTH / r**3 * np.eye(3)
    if r > NEAREST:
        K += 3 * STRENGTH / r**5 * np.outer(away, away)
    return F, K


with hapticd.connect(*sys.argv[1:2]) as session, session.give("field") as field:
    for period in field.every(0.01):
        tool = field.tool()
        F, K = force_and_slope(tool["p"])
        field.push(F, at=tool, stiffness=K, trust=0.01)
        if not field.publish():
            break
        if period.index % 50 == 0:
            r = np.linalg.norm(tool["p"] - CHARGE)
            print(f"tool at {1e3 * r:5.1f} mm of the charge, which pulls with {np.linalg.norm(F):.2f} N")
