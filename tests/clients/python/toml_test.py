# SPDX-License-Identifier: GPL-3.0-or-later
"""A dictionary that is written as TOML is read back as it was."""

import math
import random
import tomllib
import unittest
from pathlib import Path

import numpy as np
from hapticd import toml

ROOT = Path(__file__).resolve().parents[3]
LETTERS = [chr(i) for i in range(0x100)] + list("\"'\\#=[]{},.\n\t 中\u2028\U0001f600\uffff")


def text(rng):
    return "".join(rng.choices(LETTERS, k=rng.randrange(12)))


def value(rng, depth):
    kind = rng.randrange(8 if depth < 4 else 5)
    if kind == 0:
        return rng.random() < 0.5
    if kind == 1:
        return rng.choice([rng.randrange(-(2**63), 2**63), 0, -1, 2**63 - 1, -(2**63)])
    if kind == 2:
        return rng.choice([rng.gauss(0, 1), 0.0, -0.0, 1e300, 5e-324, 1e16, 1.0, -1e-5])
    if kind in (3, 4):
        return text(rng)
    if kind == 5:
        return {text(rng): value(rng, depth + 1) for _ in range(rng.randrange(4))}
    if kind == 6:
        return [value(rng, depth + 1) for _ in range(rng.randrange(4))]
    return [{text(rng): value(rng, depth + 1)} for _ in range(rng.randrange(4))]


class Toml(unittest.TestCase):
    def test_anything_comes_back(self):
        rng = random.Random(1)
        for _ in range(2000):
            config = {text(rng): value(rng, 0) for _ in range(rng.randrange(6))}
            written = toml.dumps(config)
            self.assertEqual(repr(tomllib.loads(written)), repr(sorted_as(config, written)), written)

    def test_all_control_characters(self):
        every = "".join(map(chr, [*range(0x21), 0x7F, 0x80, 0x9F, 0x2028])) + "\"\\'"
        self.assertEqual(tomllib.loads(toml.dumps({every: every})), {every: every})

    def test_session_files_come_back(self):
        for path in sorted((ROOT / "configs").glob("*.toml")):
            config = tomllib.loads(path.read_text())
            self.assertEqual(tomllib.loads(toml.dumps(config)), config, path.name)

    def test_objects_are_tables(self):
        written = toml.dumps({"object": [{"name": "a"}, {"name": "b", "motion": {"kind": "c"}}]})
        self.assertEqual(written.count("[[object]]"), 2)
        self.assertIn("[object.motion]", written)

    def test_numpy_and_paths(self):
        config = {
            "a": np.float64(0.5), "b": np.int32(3), "c": np.bool_(True), "d": np.arange(3),
            "e": (1, 2), "f": Path("x/y"), "g": np.float32(0.25), "h": np.str_("s"),
        }  # fmt: skip
        read = tomllib.loads(toml.dumps(config))
        self.assertEqual(read, {"a": 0.5, "b": 3, "c": True, "d": [0, 1, 2], "e": [1, 2],
                                "f": "x/y", "g": 0.25, "h": "s"})  # fmt: skip

    def test_what_toml_cannot_say_is_one_line(self):
        for bad, words in (
            (math.nan, "object.size: nan"), (math.inf, "inf"), (None, "NoneType"), (2**63, "64 bits"),
            ("\ud800", "surrogate"), (b"x", "bytes"), ({1: 2}, "the key 1"), (np.nan, "nan"),
            (np.array([1, np.nan]), r"size\[1\]"), (1j, "complex"),
        ):  # fmt: skip
            with self.assertRaisesRegex(ValueError, words) as caught:
                toml.dumps({"object": {"size": bad}})
            self.assertNotIn("\n", str(caught.exception))


def sorted_as(config, written):
    """The same with values before tables, as TOML has them."""
    def order(table):
        tables, rest = {}, {}
        for key, one in table.items():
            is_tables = isinstance(one, list) and one and all(isinstance(v, dict) for v in one)
            if isinstance(one, dict):
                tables[key] = order(one)
            elif is_tables:
                tables[key] = [order(v) for v in one]
            else:
                rest[key] = one
        return {**rest, **tables}

    return order(config)


if __name__ == "__main__":
    unittest.main()
