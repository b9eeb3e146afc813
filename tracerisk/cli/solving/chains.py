"""Chains of other tools, as `solve` takes them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

from tracerisk.cli.shared.model_files import read_model, read_text
from tracerisk.cli.shared.model_format import ModelFormat
from tracerisk.cli.shared.sources import read_file
from tracerisk.cli.solving.solved import Render, Solved, chosen
from tracerisk.common.text.plain_data import picked
from tracerisk.errors import InputError
from tracerisk.prm.other_models.formats.explicit_chain import ChainKind, ExplicitChain
from tracerisk.prm.other_models.formats.prism.prism_reader import constant_values, read_prism_model
from tracerisk.prm.other_models.markov.solver import SMALL
from tracerisk.report.model_files import render_answers, render_line, render_states

if TYPE_CHECKING:
    from tracerisk.prm.other_models.formats.prism.prism_reader import PrismModel
    from tracerisk.prm.other_models.properties import PropertyFile
    from tracerisk.prm.questions.uncertainty import Uncertainty


@dataclass(frozen=True, slots=True)
class ChainFile:
    """A PRISM file, or a .tra file with its labels; its figures are its absorbing states."""

    files: tuple[str, ...]
    """The paths of the PRISM file, or of the .tra file and its labels."""
    kind: ModelFormat
    """The format of the files."""
    time: float | None
    """The time at which the chain is solved, in the unit of its rates; `None`: in the long run."""
    constants: Mapping[str, float] = field(default_factory=dict)
    """The constants of the PRISM file that are set, by name."""
    questions: PropertyFile | None = None
    """The properties to check; `None`: the absorption probabilities or long-run shares."""

    @property
    def name(self) -> str:
        """The name of the file."""
        return PurePath(self.files[0]).name

    def with_values(self, values: Mapping[str, float]) -> ChainFile:
        """Return the chain with constants of the PRISM file set."""
        if self.kind is not ModelFormat.PRISM:
            raise InputError(
                "--set and --sweep need names of figures, which a .tra file has none of; they go "
                "with constants of PRISM, trees, linked models and models of functions"
            )
        return replace(self, constants={**self.constants, **values})

    def value_of(self, name: str) -> float:
        """Return what a constant is in the file; not a number where it is left open."""
        if name in self.constants:
            return self.constants[name]
        text = read_file(self.files[0]).decode("utf-8-sig")
        return float(constant_values(text, self.files[0]).get(name, float("nan")))

    def solve(self, figure: str | None, *, importance: bool) -> Solved:
        """Solve the chain from its start."""
        if importance:
            raise InputError(
                "--importance goes with models of components: trees, linked models and models "
                "of functions; a chain has none"
            )
        whole = {name: int(n) if n.is_integer() else n for name, n in self.constants.items()}
        if self.questions is not None:
            return self._answered(self.questions, whole, figure)
        chain = read_model(self.files, self.kind, whole)
        assert isinstance(chain, ExplicitChain)
        if chain.starts:
            raise InputError(
                f"the chain of '{self.name}' has {len(chain.starts)} starts; its figures need one: "
                "ask with --property, which is answered by a range"
            )
        if chain.initial in chain.absorbing:
            raise InputError(f"the chain of '{self.name}' starts in a state that it never leaves")
        if self.time is not None:
            return self._at_time(chain, self.time, figure)
        if chain.kind is ChainKind.DTMC:
            return self._discrete(chain, figure)
        return self._continuous(chain, figure)

    def at(self, mission_time_h: float) -> ChainFile:
        """Return the chain with another time."""
        return replace(self, time=mission_time_h)

    def spread(self, figure: str | None, samples: int, seed: int) -> Uncertainty:  # noqa: ARG002
        """Raise InputError: these files have no distributions."""
        raise InputError(
            "--uncertainty needs distributions, which a file of a chain has none of; it goes with "
            "Open-PSA, linked models and models of functions"
        )

    def _answered(
        self, questions: PropertyFile, constants: Mapping[str, float], figure: str | None
    ) -> Solved:
        """Answer the properties; the figure of one that differs by start is its greatest."""
        from tracerisk.prm.other_models.properties import ask

        if self.time is not None:
            raise InputError("--mission-time: a property has times of its own, as F<=10; leave out")
        own = {name: n for name, n in constants.items() if name in questions.constants}
        rest = {name: n for name, n in constants.items() if name not in questions.constants}
        chain: ExplicitChain | PrismModel
        if self.kind is ModelFormat.PRISM:
            text = read_text(self.files[0])
            chain = read_prism_model(text, file=self.files[0], constants=rest)
            notes = chain.chain.notes
        else:
            read = read_model(self.files, self.kind)
            assert isinstance(read, ExplicitChain)
            chain, notes = read, read.notes
        answers = ask(chain, questions, own)
        names = [answer.question.name or answer.question.text for answer in answers]
        figures = {name: answer.greatest for name, answer in zip(names, answers, strict=True)}
        data = [
            {
                "name": answer.question.name,
                "property": answer.question.text,
                **picked(answer, "least", "greatest", "holds"),
            }
            for answer in answers
        ]
        return Solved(
            {name: figures[name] for name in chosen(tuple(figures), figure, self.name)},
            {"answers": data},
            ((render_answers, (self.name, answers)),),
            notes,
            broken=tuple(
                name for name, answer in zip(names, answers, strict=True) if answer.holds is False
            ),
        )

    def _discrete(self, chain: ExplicitChain, figure: str | None) -> Solved:
        if len(chain.rows) > SMALL:
            # Rows by the names of so many states would take twice the memory.
            large = chain.matrix_chain().solve(chain.initial)
            ended, stayed = large.absorption(), large.expected_visits()
            ends = {chain.names[state]: float(ended[state]) for state in chain.absorbing}
            visits = {
                name: value
                for name, value in zip(chain.names, stayed.tolist(), strict=True)
                if name not in ends
            }
        else:
            solution = chain.markov_chain().solve(chain.entry)
            ends, visits = solution.absorption(), solution.expected_visits()
        steps = math.fsum(visits.values())
        data = {"expected_visits": visits, "expected_steps": steps}
        text = f"mean number of steps: {steps:.6e}"
        return self._absorbed(chain, ends, data, visits, text, figure)

    def _continuous(self, chain: ExplicitChain, figure: str | None) -> Solved:
        continuous = chain.continuous_chain()
        if not chain.absorbing:
            shares = continuous.steady_state()
            names = chosen(tuple(shares), figure, self.name)
            shown = (render_states, (self.name, "share of the time in the long run", shares))
            values = {name: shares[name] for name in names}
            return Solved(values, {"steady_state": shares}, (shown,), chain.notes)
        solution = continuous.solve(chain.entry)
        visits = solution.expected_visits()
        time = solution.expected_time()
        data = {
            "expected_visits": visits,
            "expected_times": solution.expected_times(),
            "expected_time": time,
        }
        text = f"mean time until the end, in the unit of the rates: {time:.6e}"
        return self._absorbed(chain, solution.absorption(), data, visits, text, figure)

    def _absorbed(
        self,
        chain: ExplicitChain,
        ends: Mapping[str, float],
        data: dict[str, Any],
        visits: Mapping[str, float],
        words: str,
        figure: str | None,
    ) -> Solved:
        figures = {name: ends[name] for name in chosen(tuple(ends), figure, self.name)}
        shown: list[tuple[Render, tuple[Any, ...]]] = [
            (render_states, (self.name, "probability of ending there", ends)),
            (render_states, (f"From {chain.entry} on", "expected visits", visits)),
            (render_line, (words,)),
        ]
        data = {"entry": chain.entry, "absorption": dict(ends), **data}
        return Solved(figures, data, tuple(shown), chain.notes)

    def _at_time(self, chain: ExplicitChain, time: float, figure: str | None) -> Solved:
        if chain.kind is ChainKind.DTMC:
            raise InputError("--mission-time goes with a ctmc; a dtmc has steps, and no time")
        transient = chain.continuous_chain().transient(chain.entry, time)
        names = chosen(tuple(transient), figure, self.name)
        heading = f"probability after {time:g}"
        return Solved(
            {name: transient[name] for name in names},
            {"entry": chain.entry, "distribution": transient},
            ((render_states, (self.name, heading, transient)),),
            chain.notes,
        )
