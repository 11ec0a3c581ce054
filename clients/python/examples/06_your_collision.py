# SPDX-License-Identifier: Apache-2.0
"""A landscape of heights in NumPy, felt through the planes that this script finds below the tool.
06_your_collision.py [SESSION]; start one with `hapticd configs/field.toml`."""
import sys

import hapticd
import numpy as np

EDGE, CELLS = 0.2, 256  # of the square landscape [m]
AXIS = np.linspace(-EDGE / 2, EDGE / 2, CELLS)
X, Y = np.meshgrid(AXIS, AXIS, indexing="ij")
HEIGHT = 0.008 * np.sin(60 * X) * np.cos(45 * Y) - 0.02  # [m]
SLOPE = np.gradient(HEIGHT, AXIS, AXIS)
STEP = AXIS[1] - AXIS[0]


def plane_at(x, y):
    """A point on the landscape near x, y, and the normal there."""
    i, j = (int(np.clip(np.searchsorted(AXIS, c), 1, CELLS - 2)) for c in (x, y))
    normal = np.array([-SLOPE[0][i, j], -SLOPE[1][i, j], 1.0])
    return np.array([AXIS[i], AXIS[j], HEIGHT[i, j]]), normal / np.linalg.norm(normal)


def planes_near(p):
    """The plane below the tool, and those a little way around it."""
    reach = 0.004
    for dx, dy in ((0, 0), (reach, 0), (-reach, 0), (0, reach), (0, -reach)):
        yield plane_at(p[0] + dx, p[1] + dy)


with hapticd.connect(*sys.argv[1:2]) as session, session.give("landscape") as landscape:
    rows = [np.stack([X, Y, HEIGHT], axis=-1)[::4, ::4].reshape(-1, 3)]
    for period in landscape.every(0.01):
        p = landscape.tool()["p"]
        for number, (point, normal) in enumerate(planes_near(p)):
            landscape.touch(point, normal, extent=3 * STEP + 0.002, feature=number)
        if not landscape.publish():
            break
        if period.index % 50 == 0:
            print(f"tool at {1e3 * p.round(4)} mm, ground below at {1e3 * plane_at(*p[:2])[0][2]:.1f} mm")
