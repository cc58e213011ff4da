"""The errors that reach a user: one line each, saying what is wrong, how much, and what to do.

Every adapter (command, node) catches `FlexIdentError` at its outermost function, prints the message
and leaves with `exit_status`. Anything else that escapes is a bug.
"""

from __future__ import annotations


class FlexIdentError(Exception):
    """Base of all errors that flex_ident raises on purpose. `exit_status` is what a command returns."""

    exit_status = 3


class UsageError(FlexIdentError):
    """A command or a call was given arguments that make no sense together."""

    exit_status = 2


class ConfigurationError(FlexIdentError):
    """A configuration file or a parameter holds an unknown key, a wrong type or a value out of range."""

    exit_status = 2


class DataError(FlexIdentError):
    """The data cannot answer the question."""


class BagError(DataError):
    """A recording cannot be opened or read."""


class SignalError(DataError):
    """A topic, joint or field is missing, or holds no usable numbers."""


class ExcitationError(DataError):
    """The motion does not determine what was asked for: no motion, too few samples, too low a rate."""
