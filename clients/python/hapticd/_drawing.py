# SPDX-License-Identifier: Apache-2.0
"""The points and lines of a drawing as the bytes of its records."""

from __future__ import annotations

from typing import Any, Optional, Tuple

import numpy as np
import numpy.typing as npt

from ._records import dtype

Bytes = npt.NDArray[np.uint8]
_WHITE = 0xFFFFFF


def _array(name: str, value: npt.ArrayLike, unit: str, inner: Tuple[int, ...]) -> npt.NDArray[np.float64]:
    wanted = f"(n, {', '.join(map(str, inner))}) [{unit}]"
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise ValueError(f"{name}: no numbers; wanted {wanted}") from None
    if array.size == 0:
        return array.reshape((0, *inner))
    if array.shape[1:] != inner:
        raise ValueError(f"{name}: shape {array.shape}, wanted {wanted}")
    return array


def _colours(name: str, value: npt.ArrayLike, n: int) -> npt.NDArray[np.uint32]:
    """0xRRGGBB of a number, of (n,) numbers, or of (n, 3) shares of red, green and blue."""
    wanted = f"wanted 0xRRGGBB, ({n},) of these, or ({n}, 3) of 0 to 1"
    try:
        given: npt.NDArray[Any] = np.asarray(value)
        if given.ndim == 2 and given.shape == (n, 3):
            if not ((given >= 0) & (given <= 1)).all():
                raise ValueError(f"{name}: not from 0 to 1; {wanted}")
            parts = np.rint(255 * given.astype(float)).astype(np.uint32)
            return np.asarray(parts @ np.array([1 << 16, 1 << 8, 1], np.uint32), np.uint32)
        if given.shape not in ((), (n,)):
            raise ValueError(f"{name}: shape {given.shape}, {wanted}")
        if given.dtype.kind not in "iu" or (given.size and not (0 <= given.min() <= given.max() <= _WHITE)):
            raise ValueError(f"{name}: not 0 to 0xFFFFFF; {wanted}")
    except TypeError:
        raise ValueError(f"{name}: no numbers; {wanted}") from None
    return given.astype(np.uint32)


def drawing_of(
    points: Optional[npt.ArrayLike],
    radius: npt.ArrayLike,
    colour: npt.ArrayLike,
    lines: Optional[npt.ArrayLike],
    line_colour: Optional[npt.ArrayLike],
) -> Tuple[Bytes, Bytes]:
    """The bytes of DrawnPoints and DrawnLines. Raises ValueError, in a line."""
    places = _array("points", () if points is None else points, "m", (3,))
    dots = np.zeros(len(places), dtype("DrawnPoint"))
    dots["p_W"] = places
    sizes = np.asarray(radius, dtype=float)
    if sizes.shape not in ((), (len(dots),)):
        raise ValueError(f"radius: shape {sizes.shape}, wanted a number or ({len(dots)},) [m]")
    dots["radius"] = sizes
    dots["colour"] = _colours("colour", colour, len(dots))
    ends = _array("lines", () if lines is None else lines, "m", (2, 3))
    drawn = np.zeros(len(ends), dtype("DrawnLine"))
    drawn["from_W"] = ends[:, 0]
    drawn["to_W"] = ends[:, 1]
    if line_colour is None:
        line_colour = colour if np.ndim(colour) == 0 else _WHITE
    drawn["colour"] = _colours("line_colour", line_colour, len(drawn))
    return dots.view(np.uint8), drawn.view(np.uint8)
