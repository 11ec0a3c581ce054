# SPDX-License-Identifier: Apache-2.0
"""Recordings of `hapt record`, of this and all earlier layouts."""

from __future__ import annotations

import os
import warnings
from typing import Any, Dict, Optional, Tuple, Type, Union

import numpy as np
import numpy.typing as npt

from . import _hapticd
from ._records import (
    Array,
    ContactLists,
    GivenLists,
    SceneLists,
    ServoLists,
    WithLists,
    dtype,
)

_FIRST, _LAST = -(2**63), 2**63 - 1


class Records(WithLists):
    """The records of a topic, in file order."""

    def __init__(self, record: str, read: Tuple[Array, Array, Any]) -> None:
        super().__init__(record)
        fixed, stamps, self._read = read
        #: The fixed parts: shape (n,), of ``hapticd.dtype(record)``.
        self.array: Array = fixed.view(dtype(record))
        #: CLOCK_MONOTONIC of each record [ns], shape (n,).
        self.t_ns: npt.NDArray[np.int64] = stamps[0::2]
        #: The same instants on CLOCK_REALTIME [ns], shape (n,).
        self.realtime_ns: npt.NDArray[np.int64] = stamps[1::2]
        self._n = len(self.array)

    def __len__(self) -> int:
        return self._n

    def __getitem__(self, key: Any) -> Any:
        """A column by its name, as ``records["depth"]``; or records by number or slice."""
        return self.array[key]


class ServoRecords(Records, ServoLists):
    """ServoFrames of a recording."""


class ContactRecords(Records, ContactLists):
    """ContactSets of a recording."""


class SceneRecords(Records, SceneLists):
    """SceneFrames of a recording."""


class GivenRecords(Records, GivenLists):
    """GivenFrames of a recording: what a client gave, as ``log["/client0/given"]``."""


_KINDS: Dict[str, Type[Records]] = {
    "ServoFrame": ServoRecords,
    "ContactSet": ContactRecords,
    "SceneFrame": SceneRecords,
    "GivenFrame": GivenRecords,
}


class Log:
    """A recording. ``log["/servo0/frame"]["depth"]`` is a column."""

    def __init__(self, path: Union[str, "os.PathLike[str]"]) -> None:
        self.path = os.fspath(path)
        self._log = _hapticd.Log(self.path)
        #: The record of each topic, by the topic's name.
        self.topics: Dict[str, str] = {
            topic.decode("utf-8", "replace"): record for topic, record in self._log.topics()
        }
        self._all: Dict[str, Records] = {}

    def __getitem__(self, topic: str) -> Any:
        """All records of a topic; they are read once and kept."""
        if topic not in self._all:
            self._all[topic] = self.records(topic)
        return self._all[topic]

    def records(
        self, topic: str, from_ns: Optional[int] = None, to_ns: Optional[int] = None
    ) -> Records:
        """The records of a topic between two instants of CLOCK_MONOTONIC [ns], both included.

        Warns once where the recording is of an older layout: the fields that it lacks have the
        values that docs/wire.md states.
        """
        notice = self._log.notice(topic)
        if notice:
            warnings.warn(f"{self.path}: {topic}: {notice}", stacklevel=2)
        read = self._log.read(
            topic, _FIRST if from_ns is None else from_ns, _LAST if to_ns is None else to_ns
        )
        record = self.topics[topic]
        return _KINDS.get(record, Records)(record, read)

    @property
    def events(self) -> Array:
        """The events, shape (n,): ``code`` is an EventCode, ``numbers`` (5,) belong to it."""
        if "/events" not in self.topics:
            return np.zeros(0, dtype("Event"))
        events: Array = self["/events"].array
        return events

    @property
    def session_file(self) -> str:
        """The text of the session file that was recorded."""
        return self._of_recording("config")

    @property
    def session(self) -> str:
        """The name of the session."""
        return self._of_recording("session")

    @property
    def version(self) -> str:
        """The version of hapticd that recorded it."""
        return self._of_recording("version")

    @property
    def is_finished(self) -> bool:
        """False: the recorder goes on or was killed; what is whole can be read."""
        return self._log.finished()

    def _of_recording(self, key: str) -> str:
        return self._log.metadata("recording", key).decode("utf-8", "replace")


def open_log(path: Union[str, "os.PathLike[str]"]) -> Log:
    """Opens a recording. Raises Error with one line: no such file, no recording, damaged."""
    return Log(path)
