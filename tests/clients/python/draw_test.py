# SPDX-License-Identifier: GPL-3.0-or-later
"""Clients that draw: what they say is in the memory that viewers map."""

import glob
import os
import shutil
import struct
import tempfile
import time
import tomllib
import unittest
from pathlib import Path

import hapticd
import numpy as np

ROOT = Path(__file__).resolve().parents[3]
PLANE = tomllib.loads((ROOT / "configs" / "plane.toml").read_text())


def drawn_memory():
    """The bytes of the segment that this process has offered."""
    for path in map(Path, glob.glob("/proc/self/fd/*")):
        if path.is_symlink() and "draw0" in str(path.readlink()):
            return path.read_bytes()
    raise AssertionError("there is no segment of drawings")


class Drawing(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix="py")
        os.environ["HAPTICD_RUNTIME_DIR"] = cls.folder
        clients = [{"name": "painter", "may": ["draw"]}, {"name": "other", "may": ["push"]}]
        cls.session = hapticd.run({**PLANE, "client": clients})

    @classmethod
    def tearDownClass(cls):
        cls.session.close()
        shutil.rmtree(cls.folder)

    def painter(self):
        """The place is kept for a second after its client has left."""
        for _ in hapticd.every(0.1):
            try:
                return self.session.give("painter")
            except hapticd.Error as error:
                if "wait a second" not in str(error):
                    raise

    def draw(self, g, *args, **more):
        """Until it is shown."""
        for _ in range(100):
            if g.draw(*args, **more):
                return
            time.sleep(0.01)
        self.fail("never drawn")

    def test_points_and_lines_are_what_was_said(self):
        rng = np.random.default_rng(7)
        points, radius = rng.normal(size=(3000, 3)), rng.uniform(1e-4, 1e-2, 3000)
        colour = rng.integers(0, 1 << 24, 3000)
        lines = rng.normal(size=(700, 2, 3))
        with self.painter() as g:
            self.draw(g, points, radius=radius, colour=colour, lines=lines, line_colour=0x102030)
            memory = drawn_memory()
            for i in (0, 1, 2047, 2048, 2999):
                one = struct.pack("<4d2I", *points[i], radius[i], colour[i], 0)
                self.assertEqual(memory.count(one), 1, i)
            for i in (0, 511, 512, 699):
                one = struct.pack("<6d2I", *lines[i].ravel(), 0x102030, 0)
                self.assertEqual(memory.count(one), 1, i)
            # shares of red, green and blue; one colour for both
            self.draw(g, [[9, 8, 7]], colour=[[1, 0.5, 0]], radius=0.25)
            self.assertIn(struct.pack("<4d2I", 9, 8, 7, 0.25, 0xFF8000, 0), drawn_memory())
            self.draw(g, lines=[[[1, 2, 3], [4, 5, 6]]], colour=0xABCDEF)
            self.assertIn(struct.pack("<6d2I", 1, 2, 3, 4, 5, 6, 0xABCDEF, 0), drawn_memory())
            self.draw(g)

    def test_who_draws_too_often_is_told_so(self):
        with self.painter() as g:
            many = np.zeros((200_000, 3))
            self.draw(g, many)
            self.assertFalse(g.draw(many))
            self.assertFalse(g.draw([[0, 0, 0]]))

    def test_arguments_are_checked(self):
        with self.painter() as g:
            for args, more, words in (
                (([1, 2, 3],), {}, r"^points: shape \(3,\), wanted \(n, 3\) \[m\]$"),
                (("x",), {}, "^points: no numbers"),
                (([[1, 2, 3]],), {"radius": [1, 2]}, r"^radius: shape \(2,\), wanted a number or \(1,\)"),
                (([[1, 2, 3]],), {"colour": 1 << 24}, "^colour: not 0 to 0xFFFFFF"),
                (([[1, 2, 3]],), {"colour": 0.5}, "^colour: not 0 to 0xFFFFFF"),
                (([[1, 2, 3]],), {"colour": "red"}, "^colour: not 0 to 0xFFFFFF"),
                (([[1, 2, 3]],), {"colour": [[1, 2, 3]]}, "^colour: not from 0 to 1"),
                (([[1, 2, 3]],), {"colour": [1, 2]}, r"^colour: shape \(2,\)"),
                ((), {"lines": [[1, 2, 3]]}, r"^lines: shape \(1, 3\), wanted \(n, 2, 3\) \[m\]$"),
                ((), {"lines": [[[1, 2, 3], [1, 2, 3]]], "line_colour": -1}, "^line_colour: not 0"),
            ):
                with self.assertRaisesRegex(ValueError, words) as caught:
                    g.draw(*args, **more)
                self.assertNotIn("\n", str(caught.exception))
            for args, more, words in (
                (([[1, 2, 3], [1, np.nan, 3]],), {}, "^point 1 of a drawing cannot be shown"),
                (([[1, 2, 3]],), {"radius": 0}, "^point 0 of a drawing"),
                ((np.zeros((200_001, 3)),), {}, "^a drawing of 200001 points; at most 200000"),
                ((), {"lines": np.zeros((20_001, 2, 3))}, "^a drawing of 20001 lines"),
            ):
                with self.assertRaisesRegex(hapticd.Error, words):
                    g.draw(*args, **more)

    def test_who_may_not_draw_is_told_how_to_allow_it(self):
        with self.session.give("other") as g:
            with self.assertRaisesRegex(hapticd.Error, 'add "draw" to may of its'):
                g.draw([[0, 0, 0]])


if __name__ == "__main__":
    unittest.main()
