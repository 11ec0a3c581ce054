# SPDX-License-Identifier: Apache-2.0
"""Clients that give: they move objects, push tools and give planes that tools touch."""

from __future__ import annotations

import collections.abc as abc
import os
import socket
import time
import weakref
from dataclasses import dataclass
from typing import Any, Dict, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _hapticd
from ._closing import Closing
from ._drawing import drawing_of
from ._records import dtype

Vector = npt.NDArray[np.float64]
_IN_WORLD = 256  # kNoObject of the records: a plane that is on no object


@dataclass(frozen=True)
class GivenObject:
    """An object that a client may move."""

    name: str
    #: Index in the scene.
    index: int


class Push:
    """The push of the hands on an object between two instants, as the wrench that is linear in
    time and has the same impulse, and the same integral of the impulse. About the object's origin,
    with the axes of W; force first, then torque."""

    def __init__(self, span: float, mean: Vector, slope: Vector) -> None:
        #: Time between the instants [s]; 0: nothing is known yet.
        self.span = span
        #: Shape (6,) [N, N·m].
        self.mean = mean
        #: Shape (6,) [N/s, N·m/s].
        self.slope = slope

    def at(self, t: npt.ArrayLike) -> Vector:
        """The wrench t [s] after the first instant: shape (6,), of an array of instants (…, 6)."""
        centred = np.asarray(t, dtype=float) - 0.5 * self.span
        wrench: Vector = self.mean + centred[..., np.newaxis] * self.slope
        return wrench

    @property
    def impulse(self) -> Vector:
        """The impulse in all, shape (6,) [N·s, N·m·s]."""
        return self.span * self.mean

    def __repr__(self) -> str:
        return f"Push(span={self.span:.4g} s, mean={self.mean} N, N·m)"


@dataclass(frozen=True)
class Period:
    """A period that ``every`` has come to."""

    #: Number of the period since the beginning; those that were missed leave a gap.
    index: int
    #: How late it begins [s].
    late: float
    #: Periods missed in all.
    skipped: int


def every(period: float) -> abc.Iterator[Period]:
    """Paces a loop: yields at the deadlines of a grid of ``period`` seconds, the first at once.

    A deadline that is missed is skipped and counted, never made up in a burst.
    """
    if not (np.isfinite(period) and period > 0):
        raise ValueError(f"period: {period} s, must be above 0 s")
    start, index, skipped = time.monotonic(), 0, 0
    while True:
        late = time.monotonic() - (start + index * period)
        if late < 0:
            time.sleep(-late)
            late = time.monotonic() - (start + index * period)
        passed = int(max(late, 0.0) / period)
        skipped += passed
        index += passed
        yield Period(index, max(late - passed * period, 0.0), skipped)
        index += 1


def _numbers(name: str, value: npt.ArrayLike, unit: str, *shapes: "tuple[int, ...]") -> Vector:
    """The value as an array of one of these shapes; one line about shape and unit otherwise."""
    wanted = " or ".join(str(shape) if shape else "a number" for shape in shapes)
    try:
        array = np.array(value, dtype=float)
    except (TypeError, ValueError):
        raise ValueError(f"{name}: no numbers; wanted {wanted} [{unit}]") from None
    if array.shape not in shapes:
        raise ValueError(f"{name}: shape {array.shape}, wanted {wanted} [{unit}]")
    if not np.isfinite(array).all():
        raise ValueError(f"{name}: not finite; wanted {wanted} [{unit}]")
    return array


def _matrix(name: str, value: npt.ArrayLike, unit: str, may_drive: bool = False) -> Vector:
    """6×6 of a number (the same in all directions, for moving), 3×3 (for moving) or 6×6."""
    given = _numbers(name, value, unit, (), (3, 3), (6, 6))
    out = np.zeros((6, 6))
    if given.shape == (6, 6):
        out[:] = given
    else:
        out[:3, :3] = given * np.eye(3) if given.ndim == 0 else given
    size = float(np.abs(out).max())
    if np.abs(out - out.T).max() > 1e-9 * size:
        raise ValueError(f"{name}: not symmetric [{unit}]")
    if not may_drive and size > 0 and np.linalg.eigvalsh(out).min() < -1e-9 * size:
        raise ValueError(f"{name}: has a negative direction [{unit}]")
    return 0.5 * (out + out.T)


def _quaternion_of(rotation: npt.ArrayLike) -> Vector:
    """x y z w of a rotation matrix."""
    R = _numbers("rotation", rotation, "1", (3, 3))
    if np.abs(R @ R.T - np.eye(3)).max() > 1e-6 or np.linalg.det(R) < 0:
        raise ValueError("rotation: the matrix (3, 3) is no rotation [1]")
    # the eigenvector of the largest eigenvalue (Bar-Itzhack 2000)
    K = np.zeros((4, 4))
    K[:3, :3] = R + R.T - np.trace(R) * np.eye(3)
    K[:3, 3] = K[3, :3] = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    K[3, 3] = np.trace(R)
    q: Vector = np.linalg.eigh(K)[1][:, 3]
    return q if q[3] >= 0 else -q


_givers: "weakref.WeakSet[Giver]" = weakref.WeakSet()


class Giver(Closing):
    """A client that moves objects of a session, from ``Session.give``.

    The hand feels what it says at once, and what is pushed comes back here: integrate the object
    over ``pushed(obj).span``, then ``move`` it and ``publish``. As long as this lives it gives;
    leaving the ``with``, an exception or Ctrl-C ends it, and the force fades.
    """

    def __init__(self, session: str, name: str) -> None:
        self.name = name
        #: Periods of ``every`` that were missed.
        self.late_periods = 0
        self._session = session
        self._tools: Dict[int, Any] = {}  # by hand: the ring of its servo, and its newest frame
        self._giving: Optional[_hapticd.Giving] = _hapticd.Giving(session, name)
        _givers.add(self)

    def close(self) -> None:
        """Leaves the session; the force of what it moved fades."""
        self._giving = None
        self._tools.clear()

    def object(self, name: str) -> GivenObject:
        """An object that this client may move, by its name in the session file."""
        return GivenObject(name, self._open().object(name))

    def pushed(self, obj: Union[GivenObject, str]) -> Push:
        """The push since the last call for this object; the first call begins to count."""
        numbers = self._open().pushed(self._of(obj).index)
        return Push(float(numbers[0]), numbers[1:7], numbers[7:])

    def move(
        self,
        obj: Union[GivenObject, str],
        *,
        position: npt.ArrayLike,
        quaternion: Optional[npt.ArrayLike] = None,
        rotation: Optional[npt.ArrayLike] = None,
        velocity: npt.ArrayLike = (0, 0, 0),
        angular_velocity: npt.ArrayLike = (0, 0, 0),
        acceleration: npt.ArrayLike = (0, 0, 0),
        angular_acceleration: npt.ArrayLike = (0, 0, 0),
        mass: Optional[float] = None,
        mobility: Optional[npt.ArrayLike] = None,
        stiffness: npt.ArrayLike = 0.0,
        damping: npt.ArrayLike = 0.0,
        power: float = 0.0,
    ) -> None:
        """Says how an object moves at the instant of the last ``pushed``, and how it
        answers a push until the next frame: Ẍ = a + M⁻¹ [F − D (V − V_WO) − K (X − X_WO)].

        All in W, about the object's origin; a twist is moving first, then turning.

        - position (3,) [m]; quaternion (4,) x y z w, or rotation (3, 3); neither: not turned
        - velocity (3,) [m/s], angular_velocity (3,) [rad/s]
        - acceleration (3,) [m/s²], angular_acceleration (3,) [rad/s²]: by all but hands
        - mass [kg] of what is free to move and does not turn, or mobility M⁻¹: a number or (3, 3)
          [1/kg] for moving, (6, 6); neither: a push does not move it
        - stiffness K [N/m] and damping D [N·s/m] of its own world: a number, (3, 3) or (6, 6)
        - power [W] of what drives it, which the hand may feel: at most its client's max_power
        """
        motion = np.zeros((), dtype("GivenMotion"))
        motion["object"] = self._of(obj).index
        pose = motion["X_WO"]
        pose["p"] = _numbers("position", position, "m", (3,))
        pose["q"] = _orientation(quaternion, rotation)
        for field, names, units, values in (
            ("V_WO", ("velocity", "angular_velocity"), ("m/s", "rad/s"), (velocity, angular_velocity)),
            (
                "acceleration_W",
                ("acceleration", "angular_acceleration"),
                ("m/s²", "rad/s²"),
                (acceleration, angular_acceleration),
            ),
        ):
            for key, name, unit, value in zip("vw", names, units, values):
                motion[field][key] = _numbers(name, value, unit, (3,))
        motion["mobility"] = _mobility(mass, mobility).ravel()
        motion["stiffness"] = _matrix("stiffness", stiffness, "N/m").ravel()
        motion["damping"] = _matrix("damping", damping, "N·s/m").ravel()
        motion["power"] = _not_negative("power", power, "W")
        self._open().move(np.frombuffer(motion.tobytes(), np.uint8))

    def tool(self, hand: int = 0) -> Any:
        """The newest place of a hand's tool in W: a structured scalar with ``p`` (3,) [m] and ``q``
        (4,) x y z w. It waits up to a second for the first frame of the servo."""
        if hand not in self._tools:
            self._tools[hand] = (
                _hapticd.Reader(self._session, "servo", hand, False),
                np.zeros(1, dtype("ServoFrame")),
            )
        reader, frame = self._tools[hand]
        reader.read(frame.view(np.uint8), True)
        if frame["t_ns"][0] == 0 and not (reader.wait(1.0) and reader.read(frame.view(np.uint8), True)[0]):
            raise _hapticd.Error(f"hand {hand} has no tool; see 'hapt status'")
        return frame["X_WT"][0]

    def push(
        self,
        force: npt.ArrayLike,
        *,
        at: Any,
        torque: npt.ArrayLike = (0, 0, 0),
        stiffness: npt.ArrayLike = 0.0,
        damping: npt.ArrayLike = 0.0,
        trust: float = 0.01,
        hand: int = 0,
    ) -> None:
        """Puts a wrench on a hand's tool until the next ``publish``: F = F0 + K (X − at) − B V. It
        may pull. The right ``"push"``.

        All in W, about the tool's origin; a motion is moving first, then turning.

        - force (3,) [N], torque (3,) [N·m]: F0, of a tool at rest at ``at``
        - at: the place that they are for, as ``tool()`` gives it
        - stiffness K: the derivative of the force by the tool's motion [N/m], a number, (3, 3) or
          (6, 6), symmetric; of a spring it is negative. The server uses it a thousand times a
          second, so that a field that you give at 100 Hz is felt without steps
        - damping B [N·s/m]: likewise, by which the tool is braked
        - trust [m]: how far from ``at`` the K is right; beyond, the wrench stays
        """
        push = np.zeros((), dtype("GivenWrench"))
        wrench = push["wrench"]
        pose = np.asarray(at)
        if pose.dtype.names is None or not {"p", "q"} <= set(pose.dtype.names):
            raise ValueError("at: no pose; pass what tool() gives, or X_WT of a ServoFrame")
        wrench["X_WT"]["p"] = _numbers("at", pose["p"], "m", (3,))
        wrench["X_WT"]["q"] = _orientation(pose["q"], None)
        wrench["F0_W"]["f"] = _numbers("force", force, "N", (3,))
        wrench["F0_W"]["t"] = _numbers("torque", torque, "N·m", (3,))
        wrench["K"] = _matrix("stiffness", stiffness, "N/m", may_drive=True).ravel()
        wrench["B"] = _matrix("damping", damping, "N·s/m").ravel()
        wrench["trust_radius"] = _not_negative("trust", trust, "m")
        push["hand"] = hand
        self._open().push(np.frombuffer(push.tobytes(), np.uint8))

    def touch(
        self,
        point: npt.ArrayLike,
        normal: npt.ArrayLike,
        *,
        obj: Union[GivenObject, int, None] = None,
        tool_point: npt.ArrayLike = (0, 0, 0),
        extent: float = 0.0,
        stiffness: float = 0.0,
        feature: int = 0,
        hand: int = 0,
    ) -> None:
        """Gives a plane that a hand's tool does not pass until the next ``publish``, at most 24. The
        right ``"touch"``.

        - point (3,) [m] on the plane and normal (3,), of length 1, towards the tool: in W, or in the
          frame of ``obj``, an object or its index in the scene, with which the plane then moves
        - tool_point (3,) [m] on the tool that meets it, in its own frame; of a point the origin
        - extent [m]: radius around the point in which it holds; 0: no bound
        - stiffness [N/m] where the tool may enter objects; 0: that of the session's contacts
        - feature: an id of yours, which should stay with the same face
        """
        plane = np.zeros((), dtype("GivenPlane"))
        plane["object_point_O"] = _numbers("point", point, "m", (3,))
        plane["normal_O"] = _numbers("normal", normal, "1", (3,))
        length = float(np.linalg.norm(plane["normal_O"]))
        if abs(length - 1) > 1e-4:
            raise ValueError(f"normal: length {length:.4g}, must be 1")
        plane["tool_point_T"] = _numbers("tool_point", tool_point, "m", (3,))
        plane["extent"] = _not_negative("extent", extent, "m")
        plane["stiffness"] = _not_negative("stiffness", stiffness, "N/m")
        plane["feature"] = feature
        index = obj.index if isinstance(obj, GivenObject) else obj
        plane["object"] = _IN_WORLD if index is None else index
        plane["hand"] = hand
        self._open().touch(np.frombuffer(plane.tobytes(), np.uint8))

    def publish(self) -> bool:
        """Publishes what has been said by ``move``, ``push`` and ``touch`` since the last time;
        wrenches and planes that were not said again are gone.

        False: the session was told to end, and nobody listens. Raises Error where hapticd was
        killed or has refused this client.
        """
        giving = self._open()
        gone = giving.gone()
        if gone and gone != "ended":
            raise _hapticd.Error(_words_of(gone))
        giving.publish()
        return not gone

    def draw(
        self,
        points: Optional[npt.ArrayLike] = None,
        *,
        radius: npt.ArrayLike = 1e-3,
        colour: npt.ArrayLike = 0xFFFFFF,
        lines: Optional[npt.ArrayLike] = None,
        line_colour: Optional[npt.ArrayLike] = None,
    ) -> bool:
        """Shows points and lines to viewers (``hapt view``), in place of the last ones; without
        any it shows nothing. The ``[[client]]`` needs ``may = ["draw"]``.

        - points (n, 3) [m] in W, at most 200,000
        - radius [m]: a number or (n,); colour: 0xRRGGBB, (n,) of these, or (n, 3) of 0 to 1
        - lines (m, 2, 3) [m] in W from and to, at most 20,000; line_colour as colour; without it
          that of the points where it is one for all, else white

        False: nothing was drawn, for the last drawing is shown for too short a time yet: at most 60
        are shown in a second, 5 where one has more than 20,000 points or 2,000 lines.
        """
        return self._open().draw(*drawing_of(points, radius, colour, lines, line_colour))

    @property
    def is_connected(self) -> bool:
        """False once the session has ended, or this client has left."""
        return self._giving is not None and not self._giving.gone()

    def every(self, period: float) -> abc.Iterator[Period]:
        """Paces a loop, as ``hapticd.every``, until the session is told to end.

        Raises Error where hapticd was killed or has refused this client.
        """
        for one in every(period):
            gone = self._giving.gone() if self._giving is not None else "ended"
            if gone == "ended":
                return
            if gone:
                raise _hapticd.Error(_words_of(gone))
            self.late_periods = one.skipped
            yield one

    def _open(self) -> _hapticd.Giving:
        if self._giving is None:
            raise _hapticd.Error(f"client '{self.name}' has left; call give() again")
        return self._giving

    def _of(self, obj: Union[GivenObject, str]) -> GivenObject:
        return self.object(obj) if isinstance(obj, str) else obj


def _words_of(gone: str) -> str:
    return "hapticd is gone; once it is back call give() again" if gone == "lost" else gone


def _orientation(quaternion: Optional[npt.ArrayLike], rotation: Optional[npt.ArrayLike]) -> Vector:
    if rotation is not None:
        if quaternion is not None:
            raise ValueError("rotation: say it or the quaternion, not both")
        return _quaternion_of(rotation)
    if quaternion is None:
        return np.array([0.0, 0.0, 0.0, 1.0])
    q = _numbers("quaternion", quaternion, "1, x y z w", (4,))
    length = float(np.linalg.norm(q))
    if abs(length - 1) > 1e-3:
        raise ValueError(f"quaternion: length {length:.4g}, must be 1 (x y z w)")
    return q / length


def _mobility(mass: Optional[float], mobility: Optional[npt.ArrayLike]) -> Vector:
    if mass is None:
        return _matrix("mobility", 0.0 if mobility is None else mobility, "1/kg")
    if mobility is not None:
        raise ValueError("mass: say it or the mobility, not both")
    value = float(_numbers("mass", mass, "kg", ()))
    if value <= 0:
        raise ValueError(f"mass: {value} kg, must be above 0 kg")
    return _matrix("mobility", 1 / value, "1/kg")


def _not_negative(name: str, number: float, unit: str) -> float:
    value = float(_numbers(name, number, unit, ()))
    if value < 0:
        raise ValueError(f"{name}: {value} {unit}, must not be below 0 {unit}")
    return value


def _leave_in_child() -> None:
    """A child by fork() does not keep its parent's place: closes its copies of the sockets."""
    if not len(_givers):
        return
    for fd in map(int, os.listdir("/proc/self/fd")):
        try:
            with socket.socket(fileno=os.dup(fd)) as copy:
                peer = copy.getpeername() if copy.family == socket.AF_UNIX else ""
        except OSError:
            continue
        if isinstance(peer, str) and peer.endswith(".give"):
            os.close(fd)


os.register_at_fork(after_in_child=_leave_in_child)
