# SPDX-License-Identifier: Apache-2.0
"""hapticd from Python: watch a session, change it, move its objects, read its recordings.

    import hapticd

    with hapticd.connect() as s:
        frames = s.servo()
        while frames.wait():
            frame = frames.latest()
            print(frame["X_WT"]["p"], frame["F_device_B"]["f"])

SI units everywhere; the last letter of a field's name is its frame (W world, B device base, H
handle, T tool, O object); quaternions are x y z w. docs/python.md begins with examples.
"""

from . import toml
from ._hapticd import Error, abi
from ._records import dtype
from .flags import (
    ContactFlag,
    DeviceFlag,
    EventCode,
    Fault,
    GiverFlag,
    GiverRefusal,
    GuideFlag,
    ServoFlag,
)
from .giver import GivenObject, Giver, Period, Push, every
from .lockstep import Step, lockstep
from .log import Log, Records, open_log
from .run import RunningSession, find_hapticd, run
from .session import Frames, Missed, Session, connect

__all__ = [
    "ContactFlag",
    "DeviceFlag",
    "Error",
    "EventCode",
    "Fault",
    "Frames",
    "GivenObject",
    "Giver",
    "GiverFlag",
    "GiverRefusal",
    "GuideFlag",
    "Log",
    "Missed",
    "Period",
    "Push",
    "Records",
    "RunningSession",
    "ServoFlag",
    "Session",
    "Step",
    "abi",
    "connect",
    "dtype",
    "every",
    "find_hapticd",
    "lockstep",
    "open_log",
    "run",
    "toml",
]
