# SPDX-License-Identifier: Apache-2.0
"""Writes session files: a dictionary as TOML."""

from __future__ import annotations

import collections.abc as abc
import math
import os
import re
from typing import Any, List

import numpy as np

_BARE = re.compile(r"[A-Za-z0-9_-]+")
_SHORT = {"\b": "\\b", "\t": "\\t", "\n": "\\n", "\f": "\\f", "\r": "\\r", '"': '\\"', "\\": "\\\\"}


def dumps(config: abc.Mapping[str, Any]) -> str:
    """The text of a session file that holds this dictionary.

    Values are text, bool, int, float, NumPy scalars and arrays, paths, lists and dictionaries; a
    list of dictionaries becomes [[tables]]. Raises ValueError, one line with the key, for what TOML
    cannot say.
    """
    lines: List[str] = []
    _table(lines, config, "")
    return "\n".join(lines).lstrip("\n") + "\n"


def _string(text: str, where: str) -> str:
    out = []
    for letter in text:
        code = ord(letter)
        if letter in _SHORT:
            out.append(_SHORT[letter])
        elif code < 0x20 or code == 0x7F:
            out.append(f"\\u{code:04x}")
        elif 0xD800 <= code <= 0xDFFF:
            raise ValueError(f"{where}: text that is not Unicode (half of a surrogate pair)")
        else:
            out.append(letter)
    return '"' + "".join(out) + '"'


def _key(name: object, where: str) -> str:
    if not isinstance(name, str):
        raise ValueError(f"{where or 'config'}: the key {name!r} is no text")
    return name if _BARE.fullmatch(name) else _string(name, where or "config")


def _plain(value: Any) -> Any:
    """NumPy's values, tuples and paths as those of Python."""
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    if isinstance(value, tuple):
        return list(value)
    return os.fspath(value) if isinstance(value, os.PathLike) else value


def _float(value: float, where: str) -> str:
    if not math.isfinite(value):
        raise ValueError(f"{where}: {value} is no quantity; give a finite number")
    return repr(float(value))


def _value(value: Any, where: str) -> str:
    value = _plain(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        if not -(2**63) <= value < 2**63:
            raise ValueError(f"{where}: {value:.3e} does not fit into 64 bits")
        return str(int(value))
    if isinstance(value, float):
        return _float(value, where)
    if isinstance(value, str):
        return _string(value, where)
    if isinstance(value, abc.Sequence) and not isinstance(value, (bytes, bytearray)):
        return "[" + ", ".join(_value(one, f"{where}[{i}]") for i, one in enumerate(value)) + "]"
    if isinstance(value, abc.Mapping):
        rows = (f"{_key(k, where)} = {_value(v, f'{where}.{k}')}" for k, v in value.items())
        return "{" + ", ".join(rows) + "}"
    raise ValueError(f"{where}: a {type(value).__name__} cannot stand in a session file")


def _is_tables(value: Any) -> bool:
    return isinstance(value, list) and len(value) > 0 and all(isinstance(v, abc.Mapping) for v in value)


def _table(lines: List[str], table: abc.Mapping[str, Any], name: str) -> None:
    """The values of a table, then the tables in it; its own header is there."""
    tables = []
    for key, value in table.items():
        value = _plain(value)
        word = _key(key, name)
        full = f"{name}.{word}" if name else word
        if isinstance(value, abc.Mapping) or _is_tables(value):
            tables.append((full, value))
        else:
            lines.append(f"{word} = {_value(value, full)}")
    for full, value in tables:
        if isinstance(value, abc.Mapping):
            lines += ["", f"[{full}]"]
            _table(lines, value, full)
            continue
        for one in value:
            lines += ["", f"[[{full}]]"]
            _table(lines, one, full)
