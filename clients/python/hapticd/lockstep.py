# SPDX-License-Identifier: Apache-2.0
"""Sessions on virtual time, whose hand is a function of the script."""

from __future__ import annotations

import collections.abc as abc
import itertools
import json
import os
import shutil
import subprocess
import tempfile
import weakref
from pathlib import Path
from typing import Any, Dict, List, NoReturn, Optional, Tuple, Type, TypeVar

import numpy as np
import numpy.typing as npt

from . import _hapticd
from ._records import Array, ContactLists, SceneLists, ServoLists, WithLists, dtype, lists_of
from ._told_hand import Place, ToldHand
from .run import Config, find_hapticd, last_line, session_file

_Lists = TypeVar("_Lists", bound=WithLists)
_HEAD = 8  # of a packed record, and of each list in it: how many, and zero [bytes]


class _Packed:
    """The lists of one record that is packed (proto/wire/packing.h)."""

    def __init__(self, record: str, packed: bytes) -> None:
        self._begin = dtype(record).itemsize
        self._sizes = [kind.itemsize for _, kind in lists_of(record).values()]
        self._packed = packed

    def values(self, _: int, part: int) -> "npt.NDArray[np.uint8]":
        at = self._begin
        for size in self._sizes[:part]:
            at += _HEAD + size * self._number(at)
        return np.frombuffer(self._packed, np.uint8, self._sizes[part] * self._number(at), at + _HEAD)

    def _number(self, at: int) -> int:
        return int.from_bytes(self._packed[at : at + 4], "little")


def _unpack(kind: Type[_Lists], record: str, packed: bytes) -> "Tuple[np.void, _Lists]":
    lists = kind(record)
    lists._read, lists._n = _Packed(record, packed), 1
    fixed: np.void = np.frombuffer(packed, dtype(record), 1)[0]
    return fixed, lists


class Step:
    """What one tick has come to. Its records cannot be written."""

    def __init__(self, t: float, packed: "List[bytes]") -> None:
        #: Virtual time of the tick [s], as ``hand`` was told it.
        self.t = t
        #: The ServoFrame of the tick, and its lists ``pushes()`` and ``felt()``.
        self.servo, self.of_servo = _unpack(ServoLists, "ServoFrame", packed[0])
        #: The ContactSet that it used, and its lists; an empty one before the first.
        self.contact, self.of_contact = _unpack(ContactLists, "ContactSet", packed[1])
        #: The SceneFrame that it used, and its lists.
        self.scene, self.of_scene = _unpack(SceneLists, "SceneFrame", packed[2])

    def contacts(self) -> Array:
        """Contact of the set, each in the frame O of its object."""
        return self.of_contact.contacts()

    def objects(self) -> Array:
        """SceneObject of the scene: pose ``X_WO`` and twist ``V_WO`` of each object, in W."""
        return self.of_scene.objects()


def _end(process: "subprocess.Popen[bytes]", folder: str, pid: int) -> None:
    if os.getpid() == pid:  # a child by fork() does not end its parent's session
        process.kill()
        process.wait()
        shutil.rmtree(folder, ignore_errors=True)
    for pipe in filter(None, (process.stdin, process.stdout)):
        pipe.close()


class _Program:
    """haptic-lockstep with a session; it ends with ``end``, or with the script."""

    def __init__(self, config: Config, renderer: Optional[str]) -> None:
        path = Path(find_hapticd()).resolve().parent / "haptic-lockstep"
        if not os.access(path, os.X_OK):
            raise _hapticd.Error(f"{path} is not there; install a hapticd of this module's version")
        folder = tempfile.mkdtemp(prefix="hapticd-")
        self._log = os.path.join(folder, "log")
        try:
            words = [str(path), session_file(config, folder)]
            words += ["--renderer", renderer] if renderer is not None else []
            with open(self._log, "wb") as log:
                # a process group of its own: Ctrl-C reaches only this program, which ends it
                self._process = subprocess.Popen(
                    words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=log, process_group=0
                )
        except BaseException:
            shutil.rmtree(folder, ignore_errors=True)
            raise
        self.end = weakref.finalize(self, _end, self._process, folder, os.getpid())

    def begin(self) -> float:
        """Reads its first line; returns the rate of the servo [Hz]."""
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line.endswith(b"\n"):
            self._died()
        head: Dict[str, Any] = json.loads(line)
        if head["abi"] != _hapticd.abi:
            raise _hapticd.Error(
                f"haptic-lockstep writes records of layout {head['abi']}, this module reads"
                f" {_hapticd.abi}; install both of one version"
            )
        return float(head["servo_rate"])

    def tick(self, sample: bytes) -> "List[bytes]":
        """Makes a tick; the three packed records."""
        assert self._process.stdin is not None
        try:
            os.write(self._process.stdin.fileno(), sample)
        except BrokenPipeError:
            self._died()
        return [self._read(8 * int.from_bytes(self._read(_HEAD)[:4], "little")) for _ in range(3)]

    def _read(self, n: int) -> bytes:
        assert self._process.stdout is not None
        data = self._process.stdout.read(n)
        if len(data) < n:
            self._died()
        return data

    def _died(self) -> NoReturn:
        code = self._process.wait()
        words = last_line(self._log) or f"haptic-lockstep ended without a word (exit code {code})"
        raise _hapticd.Error(words)


def lockstep(
    config: Config, hand: "abc.Callable[[float, Array], Place]", renderer: Optional[str] = None
) -> abc.Iterator[Step]:
    """A session step by step on virtual time, without a device: the same on every run, to the bit.

    ``config``: path or name of a session file, or its contents as for ``run``; ``renderer``: instead
    of the file's. Whatever its device, the hand is ``hand(t, wrench)``: before each tick it is told
    the virtual time t [s], from 0 on, and the wrench (6,) [N, N·m] that the device holds, on the
    handle at its origin, with the axes of B. It returns where the handle is in B: a position (3,)
    [m], or a mapping with ``position`` and what else is known of ``quaternion`` (4,) x y z w,
    ``velocity`` (3,) [m/s], ``angular_velocity`` (3,) [rad/s] and ``buttons``, a bit each; None ends
    the session. A velocity that is not said is the difference to the tick before; contact answers
    one tick late.

    Yields a Step after each tick. Raises Error with the program's own line where the session file
    is wrong or the program has died.
    """
    program = _Program(config, renderer)
    try:
        rate = program.begin()
        sampler, wrench = ToldHand(rate), np.zeros(6)
        for tick in itertools.count():
            place = hand(tick / rate, wrench)
            if place is None:
                return
            step = Step(tick / rate, program.tick(sampler.sample(place)))
            held = step.servo["F_device_B"]
            wrench = np.concatenate([held["f"], held["t"]])
            yield step
    finally:
        program.end()
