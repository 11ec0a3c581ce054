# SPDX-License-Identifier: Apache-2.0
"""NumPy data types of the records, made from the list that the C++ structs are made of."""

from __future__ import annotations

import functools
from typing import Any, Dict, List, Tuple

import numpy as np
import numpy.typing as npt

from . import _hapticd

Array = npt.NDArray[Any]

_COMPOUNDS: Dict[str, Any] = {
    "double": np.dtype("<f8"),
    "int64_t": np.dtype("<i8"),
    "uint64_t": np.dtype("<u8"),
    "uint32_t": np.dtype("<u4"),
    "Vec3": np.dtype(("<f8", (3,))),
    "Pose": np.dtype([("p", "<f8", (3,)), ("q", "<f8", (4,))]),
    "Twist": np.dtype([("v", "<f8", (3,)), ("w", "<f8", (3,))]),
    "Wrench": np.dtype([("f", "<f8", (3,)), ("t", "<f8", (3,))]),
}
_RECORDS = _hapticd.records()
_made: Dict[str, "np.dtype[Any]"] = {}


def _type_of(name: str) -> "np.dtype[Any]":
    made: "np.dtype[Any]" = _COMPOUNDS[name] if name in _COMPOUNDS else dtype(name)
    return made


def dtype(record: str) -> "np.dtype[Any]":
    """The data type of a record without its lists, with the offsets of the C++ struct.

    ``record`` is a name of docs/wire.md, as ``"ServoFrame"``. A ``Vec3`` is an array of 3, a
    ``Pose`` has ``p`` (3, [m]) and ``q`` (4, x y z w), a ``Twist`` ``v`` (3, [m/s]) and ``w``
    (3, [rad/s]), a ``Wrench`` ``f`` (3, [N]) and ``t`` (3, [N·m]). The frame is what a field's
    name ends with: ``X_WT`` is the pose of T in W, ``F_device_B`` a wrench with the axes of B.
    """
    if record in _made:
        return _made[record]
    if record not in _RECORDS:
        raise ValueError(f"there is no record {record!r}; there are {', '.join(_RECORDS)}")
    size, _, fields = _RECORDS[record]
    names: List[str] = []
    formats: List[Any] = []
    offsets: List[int] = []
    for name, kind, count, offset, _, is_part, _ in fields:
        if is_part:
            size = min(size, offset)
            continue
        names.append(name)
        formats.append((_type_of(kind), (count,)) if count else _type_of(kind))
        offsets.append(offset)
    made = np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": size})
    _made[record] = made
    return made


@functools.lru_cache(maxsize=None)
def lists_of(record: str) -> Dict[str, Tuple[int, "np.dtype[Any]"]]:
    """The lists of a record by name: their place among its lists, and the type of a value."""
    parts = [field for field in _RECORDS[record][2] if field[5]]
    return {field[0]: (place, _type_of(field[1])) for place, field in enumerate(parts)}


class WithLists:
    """Records that were read, and what is in use of their lists."""

    def __init__(self, record: str) -> None:
        self._record = record
        self._places = lists_of(record)
        self._read: Any = None
        self._n = 0

    def _list(self, name: str, i: int) -> Array:
        if not -self._n <= i < self._n:
            raise IndexError(f"record {i} of {self._n} that were read")
        place, kind = self._places[name]
        values: Array = self._read.values(i % self._n, place).view(kind)
        return values


class ServoLists(WithLists):
    """The lists of ServoFrames."""

    def pushes(self, i: int = -1) -> Array:
        """ObjectPush of record i, by ``SceneObject.response``: what each object was pushed with."""
        return self._list("pushes", i)

    def felt(self, i: int = -1) -> Array:
        """FeltClient of record i: what the hand has of each client's wrench and planes."""
        return self._list("felt", i)


class ContactLists(WithLists):
    """The lists of ContactSets."""

    def objects(self, i: int = -1) -> Array:
        """ObjectSeen of record i: where each object was for the query."""
        return self._list("objects", i)

    def contacts(self, i: int = -1) -> Array:
        """Contact of record i, each in the frame O of its object."""
        return self._list("contacts", i)

    def guides(self, i: int = -1) -> Array:
        """GuideRow of record i: equations that hold the tool."""
        return self._list("guides", i)

    def compliance(self, i: int = -1) -> Array:
        """Numbers of record i: the compliance of the contacts [m/N]."""
        return self._list("compliance", i)

    def wrenches(self, i: int = -1) -> Array:
        """AppliedWrench of record i: wrenches of clients, in W."""
        return self._list("wrenches", i)

    def givers(self, i: int = -1) -> Array:
        """GiverState of record i: what has been taken of each client that pushes or touches."""
        return self._list("givers", i)


class SceneLists(WithLists):
    """The lists of SceneFrames."""

    def objects(self, i: int = -1) -> Array:
        """SceneObject of record i: pose ``X_WO`` and twist ``V_WO`` of each object, in W."""
        return self._list("objects", i)

    def joints(self, i: int = -1) -> Array:
        """JointState of record i: the coordinates of the mechanisms."""
        return self._list("joints", i)

    def responses(self, i: int = -1) -> Array:
        """ObjectResponse of record i: how the objects that a push can move answer it."""
        return self._list("responses", i)

    def seen(self, i: int = -1) -> Array:
        """SeenPush of record i: how far the counters of each hand are used."""
        return self._list("seen", i)

    def world_pushes(self, i: int = -1) -> Array:
        """ObjectPush of record i: what bodies have pushed the objects of clients with."""
        return self._list("world_pushes", i)

    def givers(self, i: int = -1) -> Array:
        """GiverState of record i: what has been taken of each client that gives."""
        return self._list("givers", i)


class GivenLists(WithLists):
    """The lists of GivenFrames."""

    def moves(self, i: int = -1) -> Array:
        """GivenMotion of record i: how the client moves its objects."""
        return self._list("moves", i)

    def pushes(self, i: int = -1) -> Array:
        """GivenWrench of record i: what it pushes tools with."""
        return self._list("pushes", i)

    def planes(self, i: int = -1) -> Array:
        """GivenPlane of record i: planes that tools touch."""
        return self._list("planes", i)
