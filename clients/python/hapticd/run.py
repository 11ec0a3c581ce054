# SPDX-License-Identifier: Apache-2.0
"""Sessions that a script starts and ends."""

from __future__ import annotations

import collections.abc as abc
import itertools
import os
import shutil
import signal
import subprocess
import tempfile
import time
import weakref
from pathlib import Path
from typing import Any, List, Optional, Union

from . import _hapticd, toml
from .session import Session

Config = Union[str, "os.PathLike[str]", abc.Mapping[str, Any]]
_numbers = itertools.count(1)
_POLL = 0.02  # [s]
_PATIENCE = 5.0  # [s] after SIGTERM, then SIGKILL


def find_hapticd() -> str:
    """The program: $HAPTICD_BIN, else in $HAPTICD_LIBEXEC, in PATH, or installed beside this
    package, or built in the tree that this package lies in."""
    named = os.environ.get("HAPTICD_BIN")
    if named:
        return named
    folders = [os.environ.get("HAPTICD_LIBEXEC", ""), *os.environ.get("PATH", "").split(":")]
    for above in Path(__file__).resolve().parents:
        folders += [str(above / "libexec" / "hapticd"), str(above / "build" / "dev" / "bin")]
    for folder in filter(None, folders):
        path = os.path.join(folder, "hapticd")
        if os.path.isfile(path) and os.access(path, os.X_OK):
            return path
    raise _hapticd.Error(
        "hapticd is not found; install the package hapticd, or name the program in $HAPTICD_BIN"
    )


def session_file(config: Config, folder: str) -> str:
    """The path of a session file; a dictionary is written to one in that folder."""
    if not isinstance(config, abc.Mapping):
        return os.fspath(config)
    path = os.path.join(folder, "session.toml")
    with open(path, "w", encoding="utf-8") as file:
        file.write(toml.dumps(config))
    return path


def last_line(log: str) -> str:
    """The last line that a program has said; empty: it has said nothing."""
    with open(log, encoding="utf-8", errors="replace") as file:
        return (file.read().splitlines() or [""])[-1]


def _arguments(options: abc.Mapping[str, Any]) -> List[str]:
    """`--replay-from 2s` of ``replay_from="2s"``; True is an option without a value."""
    words: List[str] = []
    for name, value in options.items():
        if value is None or value is False:
            continue
        words.append("--" + name.replace("_", "-"))
        if value is not True:
            words.append(os.fspath(value) if isinstance(value, os.PathLike) else str(value))
    return words


def _remove(folder: str, pid: int) -> None:
    if os.getpid() == pid:
        shutil.rmtree(folder, ignore_errors=True)


class RunningSession(Session):
    """A session that this script has started; it ends with the ``with``, or with the script."""

    def __init__(
        self,
        config: Config,
        timeout: float,
        options: abc.Mapping[str, Any],
    ) -> None:
        self._pid = os.getpid()
        self._folder = tempfile.mkdtemp(prefix="hapticd-")
        weakref.finalize(self, _remove, self._folder, self._pid)
        self._process: Optional["subprocess.Popen[bytes]"] = None
        try:
            self._start(config, dict(options))
            self._wait(timeout)
            super().__init__(self._name)
        except BaseException:
            self._end()
            raise

    def _start(self, config: Config, options: "dict[str, Any]") -> None:
        path = session_file(config, self._folder)
        self._name = str(options.pop("session", None) or f"python-{os.getpid()}-{next(_numbers)}")
        words = [find_hapticd(), path, "--session", self._name, *_arguments(options)]
        # the session ends with this program, however that ends
        if shutil.which("setpriv"):
            words = ["setpriv", "--pdeathsig", "TERM", *words]
        self._log = os.path.join(self._folder, "log")
        with open(self._log, "wb") as log:
            # a process group of its own: Ctrl-C reaches only this program, which stops it in order
            self._process = subprocess.Popen(
                words, stdin=subprocess.DEVNULL, stdout=log, stderr=log, process_group=0
            )

    def _wait(self, timeout: float) -> None:
        """Until all processes run."""
        end = time.monotonic() + timeout
        while time.monotonic() < end:
            if self._process is not None and self._process.poll() is not None:
                raise _hapticd.Error(self._last_words())
            try:
                answer = _hapticd.say(self._name, "status", _PATIENCE)
                if '"runs": false' not in answer:
                    return
            except _hapticd.Error:
                pass  # not yet
            time.sleep(_POLL)
        raise _hapticd.Error(f"hapticd did not come up within {timeout:g} s: {self._last_words()}")

    def _last_words(self) -> str:
        return last_line(self._log) or "hapticd ended without a word"

    def log(self) -> str:
        """The log of hapticd."""
        with open(self._log, encoding="utf-8", errors="replace") as file:
            return file.read()

    def close(self) -> None:
        """Ends the session."""
        super().close()
        self._end()

    def _end(self) -> None:
        if os.getpid() != self._pid:
            return  # a child by fork() does not end its parent's session
        process, self._process = self._process, None
        if process is not None and process.poll() is None:
            process.send_signal(signal.SIGTERM)
            try:
                process.wait(_PATIENCE)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def run(
    config: Config,
    timeout: float = 60.0,
    **options: Any,
) -> RunningSession:
    """Starts hapticd and waits until the session runs; the ``with`` ends it.

    ``config``: path or name of a session file, or its contents as a dictionary, in which a
    quantity is a text with its unit as in the file; meshes by their full path. ``options`` are
    those of hapticd: ``replay="out.mcap"``, ``renderer="direct6"``, ``force=True``. Without
    ``session`` it has a name of its own. Raises Error with hapticd's own line where it does not
    start. Call it in a thread that lives as long as the session.
    """
    return RunningSession(config, timeout, options)
