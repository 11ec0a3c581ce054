# SPDX-License-Identifier: Apache-2.0
"""A running session: its rings, its parameters, and clients that give."""

from __future__ import annotations

import json
import threading
import time
import warnings
import weakref
from pathlib import Path
from typing import Any, Dict, List, Optional, Tuple, Type, TypeVar

import numpy as np

from . import _hapticd
from ._closing import Closing
from ._records import Array, ContactLists, SceneLists, ServoLists, WithLists, dtype
from .giver import Giver

_LOOK = 0.05  # [s] between two looks for Ctrl-C, and between two attempts to connect again


class Missed(UserWarning):
    """hapticd was away for a while."""


class Frames(WithLists):
    """A ring of a session. It is read in order by ``next`` or at its end by ``latest``.

    Records are copied, for the ring overwrites itself. While a thread waits or copies, the others
    run; the lists are those of the last read, so that threads had better have frames of their own.
    """

    def __init__(self, session: str, ring: str, hand: int, record: str) -> None:
        super().__init__(record)
        self._session, self._ring, self._hand = session, ring, hand
        self._lock = threading.Lock()
        self._latest: Optional[np.void] = None
        #: Records that ``next`` could not deliver, in all.
        self.lost = 0
        #: Time without hapticd, in all [s].
        self.missed = 0.0
        #: How often hapticd was killed and came back.
        self.restarts = 0
        #: hapticd was told to stop; nothing new comes.
        self.ended = False
        self._reader: Optional[_hapticd.Reader] = _hapticd.Reader(
            session, ring, hand, ring == "control"
        )

    @property
    def dtype(self) -> "np.dtype[Any]":
        """The data type of the records without their lists."""
        return dtype(self._record)

    def empty(self, n: int) -> Array:
        """An array for ``next``, shape (n,)."""
        return np.zeros(n, self.dtype)

    def next(self, out: Array) -> Tuple[int, int]:
        """Fills ``out`` from its beginning with as many records as are there and have not been read.

        ``out``: shape (n,) of ``dtype``, as ``empty(n)`` makes it. Returns how many were read, and
        how many were lost before them because they had been overwritten. Never waits. A second at
        1 kHz is a thousand records, and the ring of the servo holds four.
        """
        if out.dtype != self.dtype or out.ndim != 1:
            raise ValueError(f"out: shape {out.shape} of {out.dtype.name}, not (n,) of {self._record}")
        if not (out.flags.c_contiguous and out.flags.writeable):
            raise ValueError("out: not contiguous or not writeable; use empty(n)")
        n, lost = self._take(out, False)
        if n > 0:
            self._latest = out[n - 1].copy()
        return n, lost

    def latest(self) -> Optional[np.void]:
        """The newest record, once more where nothing newer has come; None: there has been none.

        Records that are passed over do not count as lost.
        """
        out = np.zeros(1, self.dtype)
        if self._take(out, True)[0] > 0:
            self._latest = out[0]
        return self._latest

    def wait(self, timeout: Optional[float] = None) -> bool:
        """Waits until there is something new; other threads run, and Ctrl-C ends it.

        ``timeout`` in seconds, None: for ever. False: time is up, or the session has ended
        (``ended``).
        """
        end = time.monotonic() + timeout if timeout is not None else float("inf")
        while True:
            reader = self._open()
            gone = reader.gone()
            left = end - time.monotonic()
            if reader.wait(max(0.0, min(left, _LOOK))):
                return True
            if gone:
                self._go_on(reader, gone, 3)
            if self.ended or left <= 0:
                return False

    @property
    def is_connected(self) -> bool:
        """False while hapticd is away."""
        return self._reader is not None and not self._reader.gone()

    def close(self) -> None:
        """Lets go of the ring."""
        self._reader = None

    def _open(self) -> _hapticd.Reader:
        if self._reader is None:
            raise _hapticd.Error("these frames are closed; ask the session for new ones")
        return self._reader

    def _take(self, out: Array, newest: bool) -> Tuple[int, int]:
        reader = self._open()
        gone = reader.gone()  # asked before: what was published by then is read first
        n, lost, read = reader.read(out.view(np.uint8), newest)
        if n > 0:
            self._n, self._read = n, read
        elif gone:
            self._go_on(reader, gone, 4)
        if not newest:
            self.lost += lost
        return n, lost

    def _go_on(self, reader: _hapticd.Reader, gone: str, depth: int) -> None:
        """Connects again to a hapticd that was killed and is back."""
        with self._lock:
            if self._reader is not reader or self.ended:
                return
            if gone == "ended":
                self.ended = True
                return
            if gone != "lost":
                raise _hapticd.Error(gone)
            try:
                self._reader = _hapticd.Reader(self._session, self._ring, self._hand, True)
            except _hapticd.Error:
                return  # not yet
            away = 1e-9 * (time.monotonic_ns() - reader.gone_ns())
            self.missed += away
            self.restarts += 1
        warnings.warn(
            f"session '{self._session}' was away for {away:.1f} s; the {self._ring} has begun anew",
            Missed,
            stacklevel=depth,
        )


class ServoFrames(Frames, ServoLists):
    """ServoFrames: the device, the tool, the proxy, the force and why it is what it is; 1 kHz."""


class ContactFrames(Frames, ContactLists):
    """ContactSets: the contacts and the verified proxy, as fast as contact answers."""


class SceneFrames(Frames, SceneLists):
    """SceneFrames: where the objects are; 120 Hz."""


class ControlFrames(Frames):
    """ControlFrames: the desired state of the session, at each change and ten times a second."""


_Kind = TypeVar("_Kind", bound=Frames)


class Session(Closing):
    """A running session, as ``connect`` finds it. It is watched through shared memory that can
    only be read, so that a program that hangs or crashes cannot disturb the hand."""

    def __init__(self, session: str = "") -> None:
        #: Its name.
        self.name: str = Path(_hapticd.find(session)).stem
        self._open: List["weakref.ref[Any]"] = []

    def close(self) -> None:
        """Closes the rings and leaves; objects that this program moves fade."""
        for made in self._open:
            one = made()
            if one is not None:
                one.close()
        self._open = []

    def _keep(self, kind: Type[_Kind], ring: str, hand: int, record: str) -> _Kind:
        frames = kind(self.name, ring, hand, record)
        self._open.append(weakref.ref(frames))
        return frames

    def servo(self, hand: int = 0) -> ServoFrames:
        """The ServoFrames of a hand, from now on."""
        return self._keep(ServoFrames, "servo", hand, "ServoFrame")

    def contact(self, hand: int = 0) -> ContactFrames:
        """The ContactSets of a hand, from now on."""
        return self._keep(ContactFrames, "contact", hand, "ContactSet")

    def sim(self) -> SceneFrames:
        """The SceneFrames, from now on."""
        return self._keep(SceneFrames, "sim", 0, "SceneFrame")

    def control(self) -> ControlFrames:
        """The ControlFrames: the present one, and those before and after it that are still there."""
        return self._keep(ControlFrames, "control", 0, "ControlFrame")

    def give(self, name: str) -> Giver:
        """Becomes the client of that name, which a ``[[client]]`` of the session file has."""
        giver = Giver(self.name, name)
        self._open.append(weakref.ref(giver))
        return giver

    def say(self, line: str, patience: float = 5.0) -> str:
        """A line to hapticd, as ``hapt`` sends it, and its answer. Raises Error with hapticd's own
        words where it refuses."""
        return _hapticd.say(self.name, line, patience).rstrip("\n")

    def set(self, key: str, value: str, force: bool = False) -> str:
        """Changes a parameter, as ``set("stiffness", "800 N/m")``; it ramps over 200 ms.

        Keys are stiffness, damping, rotational-stiffness, rotational-damping, time-scale, renderer
        and solver. ``force``: even if the coupling is stiffer than the device can hold.
        """
        return self.say(f"set {key} {value}" + (" --force" if force else ""))

    def arm(self) -> str:
        """Enables force output."""
        return self.say("arm")

    def disarm(self) -> str:
        """Disables force output until armed again."""
        return self.say("disarm")

    def pause(self) -> str:
        """Pauses force output."""
        return self.say("pause")

    def resume(self) -> str:
        """Resumes force output."""
        return self.say("resume")

    def clear_fault(self) -> str:
        """Clears a latched fault, once the handle is still."""
        return self.say("clear-fault")

    def stop(self) -> str:
        """Ends the session."""
        return self.say("stop")

    def status(self) -> Dict[str, Any]:
        """The state of the session and its processes, as ``hapt status --json`` prints it."""
        state: Dict[str, Any] = json.loads(self.say("status"))
        return state

    def config(self) -> str:
        """The session file that it was started with."""
        return self.say("config")


def connect(session: str = "") -> Session:
    """Finds a running session; an empty name: the only one. Raises Error with a remedy."""
    return Session(session)
