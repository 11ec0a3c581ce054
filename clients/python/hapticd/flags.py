# SPDX-License-Identifier: Apache-2.0
"""The bits and codes in the records, as in proto/wire/wire.h."""

from enum import IntEnum, IntFlag


class DeviceFlag(IntFlag):
    """Bits of ``DeviceState.flags``."""

    FRESH = 1 << 0
    HELD = 1 << 1
    HOMED = 1 << 2
    SATURATED = 1 << 3
    ENDED = 1 << 4
    OPEN_LOOP = 1 << 5
    SIMULATED = 1 << 6
    LOST_TIME = 1 << 7
    LOST = 1 << 8
    STALE = 1 << 9
    NOISY = 1 << 10
    LED = 1 << 11
    ADMITTANCE = 1 << 12


class ServoFlag(IntFlag):
    """Bits of ``ServoFrame.flags``."""

    CONTACT = 1 << 0
    NO_CONTACT_SET = 1 << 1
    HOLDING = 1 << 2
    FADING = 1 << 3
    STALE = 1 << 4
    REOPENING = 1 << 5
    SATURATED = 1 << 6
    SOFT_START = 1 << 7
    FAULT = 1 << 8
    CLUTCHED = 1 << 9
    PAUSED = 1 << 10
    SOLVER_LIMIT = 1 << 11
    TORQUE_DROPPED = 1 << 12
    STOPPED = 1 << 13
    DISARMED = 1 << 14
    TOO_FAST = 1 << 15
    SLEWING = 1 << 16
    THERMAL = 1 << 17
    PASSIVITY = 1 << 18
    WORKSPACE_EDGE = 1 << 19
    NO_DEVICE = 1 << 20
    SOFTENED = 1 << 21
    FORCED = 1 << 22
    LATE = 1 << 23
    CONTACT_LATE = 1 << 24
    SIM_LATE = 1 << 25
    WEIGHT_ENDED = 1 << 26


class Fault(IntEnum):
    """Why the force is latched at zero: ``ServoFrame.fault``."""

    NONE = 0
    DEVICE_NOT_FINITE = 1
    CONTACTS_NOT_FINITE = 2
    FORCE_NOT_FINITE = 3
    FORCE_HUGE = 4
    POSE_JUMP = 5
    DEVICE_STALE = 6
    DEVICE_NOISY = 7


class ContactFlag(IntFlag):
    """Bits of ``ContactSet.flags``."""

    RESEEDED = 1 << 0
    ITERATION_LIMIT = 1 << 1
    TRUNCATED = 1 << 2
    NO_FREE_POSE = 1 << 3
    NO_DETECTOR = 1 << 5
    GIVEN = 1 << 6


class GiverRefusal(IntEnum):
    """Why a frame of a client was not taken."""

    NONE = 0
    NOT_FINITE = 1
    NOT_ALLOWED = 2
    BACK_IN_TIME = 3
    UNKNOWN_TICK = 4
    NOT_SYMMETRIC = 5
    TOO_LIGHT = 6
    TOO_STIFF = 7
    TOO_FAST = 8
    TOO_STRONG = 9
    NO_PLANE = 10


class GiverFlag(IntFlag):
    """Bits of ``GiverState.flags``."""

    ATTACHED = 1 << 0
    LATE = 1 << 1
    SOFTENED = 1 << 2
    CUT = 1 << 3
    LIMITED = 1 << 4


class GuideFlag(IntFlag):
    """Bits of ``GuideRow.flags``."""

    ONE_WAY = 1 << 0


class EventCode(IntEnum):
    """Kind of an ``Event``."""

    STARTED = 1
    FLAGS_CHANGED = 2
    STOPPED = 3
    RECORDS_LOST = 4
    FAULT = 5
    SESSION_BACK = 6

