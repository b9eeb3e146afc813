"""Signal handlers: a signal that the program sends itself shuts the contexts down.

The real ones are in C: they pass the signal on to the handler of Python, and one that the program
sets later takes their place.
"""

from __future__ import annotations

import signal
from enum import IntEnum

from ._run import run


class SignalHandlerOptions(IntEnum):
    """Which signals end the contexts."""

    NO = 0
    SIGINT = 1
    SIGTERM = 2
    ALL = 3


def install_signal_handlers(options: SignalHandlerOptions = SignalHandlerOptions.ALL) -> None:
    """End all contexts at these signals; a signal from outside ends the run itself."""
    state = run()
    state.signal_options = int(options)
    for bit, number in ((1, signal.SIGINT), (2, signal.SIGTERM)):
        is_taken = bool(state.signal_options & bit)
        state.scheduler.signals.take_first(number, state.end_contexts if is_taken else None)


def uninstall_signal_handlers() -> None:
    """Leave the contexts alone at any signal."""
    install_signal_handlers(SignalHandlerOptions.NO)


def get_current_signal_handlers_options() -> SignalHandlerOptions:
    """Return which signals would end the contexts."""
    return SignalHandlerOptions(run().signal_options)
