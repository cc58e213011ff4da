"""Libraries that are needed for some files only: which extra of the package brings them."""

from __future__ import annotations

import importlib
from typing import Any

from flex_ident.errors import UsageError


class MissingExtraError(UsageError):
    """A library that is not installed is needed to read a file."""


def extra_module(name: str, extra: str, what: str) -> Any:
    """The module `name`. Raises MissingExtraError that says what needs it and how to install it."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        library = {"google": "protobuf"}.get(name.partition(".")[0], name.partition(".")[0])
        if not isinstance(error, ModuleNotFoundError):  # it is there, and is not for what else is installed
            raise MissingExtraError(f"{what} need {library}, and the one installed cannot be used: {error}.") from error
        raise MissingExtraError(f"{what} need {library}: pip install 'flex_ident[{extra}]'.") from error
