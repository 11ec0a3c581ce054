# SPDX-License-Identifier: Apache-2.0
"""Prints the tool and the force ten times a second. 01_watch.py [SESSION]"""

import sys

import hapticd

with hapticd.connect(*sys.argv[1:2]) as session:
    frames = session.servo()
    for _ in hapticd.every(0.1):
        frame = frames.latest()
        if frames.ended:
            break
        if frame is not None:
            x, y, z = frame["X_WT"]["p"]
            fx, fy, fz = frame["F_device_B"]["f"]
            force = (fx * fx + fy * fy + fz * fz) ** 0.5
            print(f"tool {x:+8.4f} {y:+8.4f} {z:+8.4f} m   force {force:5.2f} N", flush=True)
