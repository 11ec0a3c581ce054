# SPDX-License-Identifier: GPL-3.0-or-later
"""The stated types are those of the module."""

import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import hapticd

FOLDER = Path(hapticd.__file__).parent.parent


@unittest.skipUnless(shutil.which("stubtest", path="/usr/bin"), "SKIPPED: stubtest is not installed (mypy)")
class Types(unittest.TestCase):
    def test_stubtest_finds_nothing(self):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run(
                [sys.executable, "/usr/bin/stubtest", "hapticd"], cwd=folder, text=True,
                env={**os.environ, "MYPYPATH": str(FOLDER)}, capture_output=True,
            )  # fmt: skip
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main()
