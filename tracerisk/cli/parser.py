"""The parser of the command line: each verb with its own options, errors that suggest."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from functools import partial
from importlib import import_module

from tracerisk.cli.verbs import GROUPS, VERBS, module_of
from tracerisk.common.text.columns import columns_of
from tracerisk.common.version import __version__

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, NoReturn


_EPILOG = """\
Begin with `tracerisk run FILE`; `tracerisk VERB --help` lists a verb's options.

exit codes:
  0    fine
  1    would change, stale, or over a limit
  2    usage or bad input
  3    conflicting manual edit
  4    the controller failed
  5    internal error
  130  interrupted
"""

_MEANT = {"set": "over", "vary": "over"}
"""What of one verb is looked for under the name that it has in another."""
_MOST_IN_USAGE = 8  # options, with which a usage line still reads well


def parse(given: list[str]) -> argparse.Namespace:
    """Return the options of a command line; end with exit code 2 where it is wrong."""
    # The verb is found first: only its own options and its own imports are then made.
    verb = next((word for word in given if not word.startswith("-")), None)
    if not given:
        _parser(None, as_json=False).print_help(sys.stderr)
        sys.exit(2)
    # Where it stands first, nobody can ask for the others either.
    known = (verb,) if verb in VERBS and verb == given[0] else tuple(VERBS)
    parser = _parser(verb if verb in VERBS else None, as_json="--json" in given, known=known)
    if verb is not None and verb not in VERBS:
        parser.error(_unknown_verb(verb))
    options: argparse.Namespace = parser.parse_args(given)
    return options


def _unknown_verb(word: str) -> str:
    from difflib import get_close_matches

    near = get_close_matches(word, VERBS, n=1)
    meant = f"'{near[0]}'" if near else ""
    if not near and os.path.exists(word):  # noqa: PTH110 - pathlib is not needed to start
        meant = f"`tracerisk run {word}`"
    more = f"did you mean {meant}?" if meant else "`tracerisk --help` lists all verbs"
    return f"unknown verb '{word}'; {more}"


def whole_parser() -> argparse.ArgumentParser:
    """Return the parser with the options of every verb, for what describes the command."""
    return _parser(*VERBS, as_json=False)


def _parser(
    *chosen: str | None, as_json: bool, known: Sequence[str] = tuple(VERBS)
) -> argparse.ArgumentParser:
    parser = _Command(
        prog="tracerisk",
        description="Redo the risk assessment of a robot arm at every commit of its controller.",
        epilog=_EPILOG,
        formatter_class=partial(_fitted, argparse.RawDescriptionHelpFormatter),
    )
    parser.verb = chosen[0] if as_json and chosen else None
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version and exit")
    verbs = parser.add_subparsers(
        dest="verb", metavar="VERB", required=True, parser_class=_Parser, prog=parser.prog
    )
    for verb in known:
        summary = VERBS[verb]
        sub = verbs.add_parser(
            verb,
            help=summary,
            description=f"{summary[0].upper()}{summary[1:]}.",
            formatter_class=partial(_fitted, argparse.HelpFormatter),
        )
        if verb in chosen:
            sub.verb = parser.verb
            parser.chosen = sub
            import_module(module_of(verb)).add_options(sub)
    return parser


def _fitted(kind: type[argparse.HelpFormatter], prog: str) -> argparse.HelpFormatter:
    """Return a formatter that fits the terminal, without the import of `shutil` for it alone."""
    return kind(prog, width=columns_of(sys.__stdout__) - 2)


class _Parser(argparse.ArgumentParser):
    """A parser whose errors suggest, and are JSON too where that was asked for.

    `verb` is that of the JSON, `None` for none; `chosen` parses the options of the verb.
    """

    verb: str | None = None
    chosen: _Parser | None = None

    def parse_args(self, args: Any = None, namespace: Any = None) -> Any:
        words = list(sys.argv[1:] if args is None else args)
        options, unknown = self.parse_known_args(words, namespace)
        verb = self.chosen or self
        last: list[str] = []
        if unknown and "--" in words and (verb._list or verb._takes_arguments):
            # argparse fills all positional arguments at the first; what stands behind `--` is last.
            cut = words.index("--")
            options, unknown = self.parse_known_args(words[:cut], namespace)
            last = words[cut + 1 :]
        if unknown and not any(word.startswith("-") for word in unknown) and verb._list:
            # argparse ends a list of files at the first option; what stands behind belongs to it.
            getattr(options, verb._list).extend(unknown)
        elif unknown:
            verb._unknown(unknown)
        if last:
            getattr(options, verb._list or "argv").extend(last)
        return options

    def format_usage(self) -> str:
        self._shorten_usage()
        return super().format_usage()

    def format_help(self) -> str:
        self._shorten_usage()
        return super().format_help()

    def _shorten_usage(self) -> None:
        """Name only what must be given: all else is listed below, in its groups."""
        needed = [
            action for action in self._actions if action.required or not action.option_strings
        ]
        if len(self._actions) - len(needed) > _MOST_IN_USAGE:
            formatter = self._get_formatter()
            formatter.add_usage(None, needed, [], prefix="")
            words = formatter.format_help().split()
            place = len(self.prog.split())
            self.usage = " ".join((*words[:place], "[options]", *words[place:]))

    @property
    def _list(self) -> str | None:
        """The name of the one positional argument, if it takes several."""
        actions = [action for action in self._actions if not action.option_strings]
        is_list = len(actions) == 1 and actions[0].nargs in ("*", "+")
        return actions[0].dest if is_list else None

    @property
    def _takes_arguments(self) -> bool:
        """Whether what stands behind `--` is for the controller."""
        return any(action.dest == "argv" for action in self._actions)

    def _unknown(self, words: list[str]) -> None:
        from difflib import get_close_matches

        # Of a verb with actions, what any of them knows.
        nested = [
            parser
            for action in self._actions
            if isinstance(action, argparse._SubParsersAction)
            for parser in action.choices.values()
        ]
        parsers = (self, *nested)
        options = (word for item in parsers for word in item._option_string_actions)
        known = [word for word in options if word.startswith("--")]
        option = next((word for word in words if word.startswith("-")), None)
        if option is None:
            self.error(f"unexpected: {' '.join(words)}")
        # Without dashes, which are alike in all.
        bare = [word.lstrip("-") for word in known]
        asked = option.partition("=")[0].lstrip("-")
        near = [_MEANT[asked]] if _MEANT.get(asked) in bare else get_close_matches(asked, bare, n=1)
        hint = f"did you mean --{near[0]}?" if near else f"`{self.prog} --help` lists all"
        message = f"unknown option {option}; {hint}"
        if "--answer" in known:
            message += "; options for the controller go after --, as in `FILE -- --speed 2`"
        self.error(message)

    def error(self, message: str) -> NoReturn:
        self.print_usage(sys.stderr)
        from tracerisk.cli.shared.output import place_data, print_json, show

        show(f"{self.prog}: {message} [usage]", to_errors=True)
        if self.verb is not None:
            data = {"kind": "UsageError", "code": "usage", "message": message, **place_data(None)}
            print_json(self.verb, exit_code=2, error=data)
        self.exit(2)


class _Command(_Parser):
    """The parser of the whole command, whose help lists the verbs by who needs them."""

    def format_help(self) -> str:
        verbs = {
            get_subaction.dest: get_subaction
            for action in self._actions
            if isinstance(action, argparse._SubParsersAction)
            for get_subaction in action._get_subactions()
        }
        formatter = self._get_formatter()
        formatter.add_usage(self.usage, self._actions, self._mutually_exclusive_groups)
        formatter.add_text(self.description)
        options = [action for action in self._actions if action.option_strings]
        sections = {
            **{title: [verbs[verb] for verb in group] for title, group in GROUPS.items()},
            "options": options,
        }
        for title, actions in sections.items():
            formatter.start_section(title)
            formatter.add_arguments(actions)
            formatter.end_section()
        formatter.add_text(self.epilog)
        return formatter.format_help()


class _Version(argparse.Action):
    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        print(f"tracerisk {__version__}")
        parser.exit()
