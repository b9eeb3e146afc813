"""Signal handlers: a simulated run gets no signals, so that there is none to install."""

from __future__ import annotations

from enum import IntEnum

from ._run import run


class SignalHandlerOptions(IntEnum):
    """Which signals end the contexts."""

    NO = 0
    SIGINT = 1
    SIGTERM = 2
    ALL = 3


def install_signal_handlers(options: SignalHandlerOptions = SignalHandlerOptions.ALL) -> None:
    """Take the options; Ctrl-C ends the run itself."""
    run().signal_options = int(options)


def uninstall_signal_handlers() -> None:
    """Take it that no signal ends the contexts."""
    run().signal_options = int(SignalHandlerOptions.NO)


def get_current_signal_handlers_options() -> SignalHandlerOptions:
    """Return which signals would end the contexts."""
    return SignalHandlerOptions(run().signal_options)
