# SPDX-License-Identifier: Apache-2.0
"""Builds the extension from the tree that this folder lies in, for `pip install`."""

import os
import re
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
VERSION = re.search(r"project\(hapticd VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text())[1]


class Build(build_ext):
    """Sources outside of this folder: setuptools takes their full paths only when it compiles."""

    def build_extension(self, ext):
        ext.sources = [str(ROOT / line) for line in (HERE / "sources.txt").read_text().split()]
        super().build_extension(ext)


os.chdir(HERE)
FOLDER = ROOT / "build" / "pip"
FOLDER.mkdir(parents=True, exist_ok=True)
setup(
    version=VERSION,
    options={"build": {"build_base": str(FOLDER)}, "egg_info": {"egg_base": str(FOLDER)}},
    cmdclass={"build_ext": Build},
    ext_modules=[
        Extension(
            "hapticd._hapticd",
            sources=[],
            include_dirs=[str(ROOT)],
            libraries=["zstd", "z"],
            extra_compile_args=["-std=c++20", "-O2", "-g0", "-fvisibility=hidden", "-ffp-contract=off"],
            extra_link_args=["-Wl,-z,now"],
            language="c++",
        )
    ],
)
