# SPDX-License-Identifier: Apache-2.0
"""Samples of a device, made of where a script says that the hand is."""

from __future__ import annotations

import collections.abc as abc
from typing import Any, Dict, Optional, Union

import numpy as np
import numpy.typing as npt

from ._records import Array, dtype
from .flags import DeviceFlag

#: Where the hand is at a tick; None ends the session.
Place = Union[npt.ArrayLike, abc.Mapping[str, Any], None]
_VECTORS = {
    "position": (3, "m"),
    "quaternion": (4, "x y z w"),
    "velocity": (3, "m/s"),
    "angular_velocity": (3, "rad/s"),
}


class ToldHand:
    """Makes a sample of the device of what ``hand`` returns."""

    def __init__(self, rate: float) -> None:
        self._rate = rate  # [Hz]
        self._last: "Optional[Dict[str, Array]]" = None

    def sample(self, told: Union[npt.ArrayLike, abc.Mapping[str, Any]]) -> bytes:
        given = dict(told) if isinstance(told, abc.Mapping) else {"position": told}
        buttons = given.pop("buttons", 0)
        unknown = ", ".join(repr(key) for key in given if key not in _VECTORS)
        if unknown or "position" not in given:
            what = f"{unknown} is not known" if unknown else "a position is missing"
            raise ValueError(f"hand: {what}; there are {', '.join(_VECTORS)} and buttons")
        now = {name: _vector(name, value) for name, value in given.items()}
        now.setdefault("quaternion", np.array([0.0, 0.0, 0.0, 1.0]))
        last, self._last = self._last or now, now
        sample = np.zeros((), dtype("DeviceState"))
        sample["X_BH"]["p"], sample["X_BH"]["q"] = now["position"], now["quaternion"]
        if "velocity" not in now:
            now["velocity"] = self._rate * (now["position"] - last["position"])
        if "angular_velocity" not in now:
            now["angular_velocity"] = self._rate * _rotation(now["quaternion"], last["quaternion"])
        sample["V_BH"]["v"], sample["V_BH"]["w"] = now["velocity"], now["angular_velocity"]
        sample["buttons"] = buttons
        sample["flags"] = DeviceFlag.FRESH | DeviceFlag.HOMED | DeviceFlag.SIMULATED
        return sample.tobytes()


def _vector(name: str, value: npt.ArrayLike) -> Array:
    n, unit = _VECTORS[name]
    try:
        vector = np.array(value, dtype=float)
    except (TypeError, ValueError):
        raise ValueError(f"hand: {name}: no numbers; wanted ({n},) [{unit}]") from None
    if vector.shape != (n,):
        raise ValueError(f"hand: {name}: shape {vector.shape}, wanted ({n},) [{unit}]")
    return vector


def _rotation(q: Array, before: Array) -> Array:
    """The rotation vector [rad] that leads from one unit quaternion to another, by the shorter
    arc."""
    if np.array_equal(q, before):
        return np.zeros(3)
    v: Array = before[3] * q[:3] - q[3] * before[:3] - np.cross(q[:3], before[:3])
    sine, cosine = float(np.linalg.norm(v)), float(q @ before)
    if cosine < 0:
        v, cosine = -v, -cosine
    turned: Array = v * (2 * np.arctan2(sine, cosine) / sine) if sine > 0 else np.zeros(3)
    return turned
