# SPDX-License-Identifier: Apache-2.0
"""What ends with its ``with``."""
from types import TracebackType
from typing import Optional, Type, TypeVar

_Self = TypeVar("_Self", bound="Closing")


class Closing:
    """The base of all that has to be closed: leaving its ``with`` closes it."""

    def close(self) -> None:
        """Ends it; each class says how."""
        raise NotImplementedError

    def __enter__(self: _Self) -> _Self:
        return self

    def __exit__(
        self,
        kind: Optional[Type[BaseException]],
        error: Optional[BaseException],
        trace: Optional[TracebackType],
    ) -> None:
        self.close()
