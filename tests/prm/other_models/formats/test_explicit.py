"""Explicit files of transitions and labels, in the dialects of Storm and PRISM."""

import math
import tracemalloc

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracerisk.errors import ModelError, TooLargeError
from tracerisk.prm import MarkovChain, build_model, solve
from tracerisk.prm.other_models.formats.expanded_chain import expanded_chain
from tracerisk.prm.other_models.formats.explicit import read_explicit, write_transitions
from tracerisk.prm.other_models.formats.explicit_chain import ChainKind, explicit_chain
from tracerisk.prm.other_models.formats.explicit_labels import write_labels
from tracerisk.prm.other_models.formats.explicit_lines import Dialect
from tracerisk.prm.other_models.formats.prism import read_prism, write_prism
from tracerisk.prm.other_models.markov import ContinuousChain

CHAIN = MarkovChain(
    {
        "Pick.place": {"Pick.place": 0.5, "lost": 1e-20, "b": 0.5},
        "b": {"Pick.place": 0.9, "won": 0.1},
    },
    ("lost", "won"),
)
RATES = ContinuousChain({"up": {"down": 1e-9}, "down": {"up": 0.1, "gone": 1e-7}}, ("gone",))

STORM_TRA = """dtmc
0 0 0.5
0 1 0.5
0 2 1e-20
1 0 0.9
1 3 0.1
2 2 1.0
3 3 1.0
"""
STORM_LAB = """#DECLARATION
init Pick_place b lost won failed
#END
0 init Pick_place
1 b
2 lost failed
3 won
"""
PRISM_LAB = """0="init" 1="Pick_place" 2="b" 3="lost" 4="won" 5="failed"
0: 0 1
1: 2
2: 3 5
3: 4
"""


def read(transitions, labels=STORM_LAB, **options):
    return read_explicit(
        transitions, labels, transitions_file="m.tra", labels_file="m.lab", **options
    )


def test_storm_and_prism_have_their_own_first_lines_and_labels():
    explicit = explicit_chain(CHAIN, "Pick.place", {"failed": ["lost"]})
    assert write_transitions(explicit) == STORM_TRA
    assert write_labels(explicit) == STORM_LAB
    assert write_transitions(explicit, Dialect.PRISM) == STORM_TRA.replace("dtmc", "4 7")
    assert write_labels(explicit, Dialect.PRISM) == PRISM_LAB


@pytest.mark.parametrize("dialect", Dialect)
def test_what_is_written_reads_back_to_the_same_bits(dialect):
    explicit = explicit_chain(CHAIN, "Pick.place", {"failed": ["lost"]})
    back = read(write_transitions(explicit, dialect), write_labels(explicit, dialect))
    assert (back.kind, back.initial, back.rows) == (explicit.kind, 0, explicit.rows)
    assert back.labels == explicit.labels
    assert back.names == ("Pick_place", "b", "lost", "won")
    assert back.labelled("failed") == ("lost",)
    found = back.markov_chain().solve(back.entry).absorption()
    assert found == CHAIN.solve("Pick.place").absorption()


@given(
    weights=st.lists(
        st.lists(st.one_of(st.just(0.0), st.floats(1e-300, 1.0)), min_size=4, max_size=4),
        min_size=1,
        max_size=3,
    )
)
def test_any_chain_comes_back_from_all_three_formats(weights):
    rows = {}
    for number, row in enumerate(weights):
        row = [*row[:3], row[3] + 0.5]
        targets = [f"s{min(i, len(weights) - 1)}" for i in range(2)]
        total = math.fsum(row)
        rows[f"s{number}"] = {}
        for target, p in zip([*targets, "failed", "done"], row, strict=True):
            rows[f"s{number}"][target] = rows[f"s{number}"].get(target, 0.0) + p / total
    explicit = explicit_chain(MarkovChain(rows, ("failed", "done")), "s0")
    for back in (
        read(write_transitions(explicit), write_labels(explicit)),
        read(write_transitions(explicit, Dialect.PRISM), write_labels(explicit, Dialect.PRISM)),
    ):
        assert back == explicit
    prism = read_prism(write_prism(explicit))
    by_name = {
        prism.names[i]: {prism.names[j]: p for j, p in row.items()}
        for i, row in enumerate(prism.rows)
    }
    for state, row in by_name.items():
        number = explicit.names.index(state)
        assert row == {explicit.names[j]: p for j, p in explicit.rows[number].items()}


def test_rates_come_back_as_rates():
    explicit = explicit_chain(RATES, "up")
    assert explicit.kind is ChainKind.CTMC
    back = read(write_transitions(explicit), write_labels(explicit))
    assert back.continuous_chain().solve("up").expected_time() == RATES.solve("up").expected_time()
    prism = read(
        write_transitions(explicit, Dialect.PRISM),
        write_labels(explicit, Dialect.PRISM),
        kind=ChainKind.CTMC,
    )
    assert prism.rows == explicit.rows
    with pytest.raises(ModelError, match="a ctmc has rates, not probabilities;"):
        back.markov_chain()
    with pytest.raises(ModelError, match="a dtmc has probabilities, not rates"):
        read(STORM_TRA).continuous_chain()


def test_the_published_case_comes_back_with_the_same_figures(case_study):
    model = build_model(case_study, name="case")
    chain = expanded_chain(model)
    failed = [state for state in chain.absorbing if state != "done"]
    explicit = explicit_chain(chain, model.entry, {"failed": failed})
    expected = solve(model).mission.failure_probability
    for back in (
        read(write_transitions(explicit), write_labels(explicit)),
        read(write_transitions(explicit, Dialect.PRISM), write_labels(explicit, Dialect.PRISM)),
        read_prism(write_prism(explicit)),
    ):
        absorption = back.markov_chain().solve(back.entry).absorption()
        assert absorption == chain.solve(model.entry).absorption()
        total = math.fsum(absorption[state] for state in back.labelled("failed"))
        assert total == pytest.approx(expected, rel=1e-15)


def test_hidden_failures_go_out_as_states_and_come_back_with_the_same_figures(block, component):
    pair = component("power", 1e-7, 2, "true")
    model = build_model(
        [
            block("lift", 1, [pair], after={"hold": "1"}),
            block("hold", 2, [pair], after={"lift": "9/10", "done": "1/10"}),
        ],
        name="m",
    )
    chain = expanded_chain(model)
    explicit = explicit_chain(chain, model.entry)
    assert len(explicit.rows) == 7
    back = read_prism(write_prism(explicit))
    absorption = back.markov_chain().solve(back.entry).absorption()
    failed = absorption["lift_failure"] + absorption["hold_failure"]
    assert failed == pytest.approx(solve(model).mission.failure_probability, rel=1e-13)


def test_storm_gives_the_same_figures_for_the_published_case(case_study, tmp_path):
    stormpy = pytest.importorskip("stormpy", reason="stormpy is not installed")
    model = build_model(case_study, name="case")
    chain = expanded_chain(model)
    failed = [state for state in chain.absorbing if state != "done"]
    explicit = explicit_chain(chain, model.entry, {"failed": failed})
    (tmp_path / "m.tra").write_text(write_transitions(explicit), encoding="utf-8")
    (tmp_path / "m.lab").write_text(write_labels(explicit), encoding="utf-8")
    (tmp_path / "m.prism").write_text(write_prism(explicit), encoding="utf-8")
    solution = chain.solve(model.entry)
    expected = {state: p for state, p in solution.absorption().items() if state != "done"}
    expected["failed"] = math.fsum(expected.values())
    program = stormpy.parse_prism_program(str(tmp_path / "m.prism"))
    for built in (
        stormpy.build_model_from_explicit(tmp_path / "m.tra", tmp_path / "m.lab"),
        stormpy.build_model(program),
    ):
        assert built.nr_states == len(explicit.rows)
        for label, p in expected.items():
            (question,) = stormpy.parse_properties(f'P=? [F "{label}"]')
            answer = stormpy.model_checking(
                built, question, environment=stormpy.environments.exact()
            )
            assert answer.get_value(built.initial_states[0]) == pytest.approx(p, rel=1e-12)


def test_storm_reads_rates_and_a_time(tmp_path):
    stormpy = pytest.importorskip("stormpy", reason="stormpy is not installed")
    chain = ContinuousChain({"up": {"down": 0.01}, "down": {"up": 0.1, "gone": 0.02}}, ("gone",))
    explicit = explicit_chain(chain, "up")
    (tmp_path / "m.tra").write_text(write_transitions(explicit), encoding="utf-8")
    (tmp_path / "m.lab").write_text(write_labels(explicit), encoding="utf-8")
    (tmp_path / "m.prism").write_text(write_prism(explicit), encoding="utf-8")
    program = stormpy.parse_prism_program(str(tmp_path / "m.prism"), prism_compatibility=True)
    expected = chain.transient("up", 300.0)["gone"]
    for built in (
        stormpy.build_model_from_explicit(tmp_path / "m.tra", tmp_path / "m.lab"),
        stormpy.build_model(program),
    ):
        (question,) = stormpy.parse_properties('P=? [F<=300 "gone"]')
        answer = stormpy.model_checking(built, question)
        # Storm answers to a precision of 1e-6.
        assert answer.get_value(built.initial_states[0]) == pytest.approx(expected, rel=1e-5)
    assert 0.3 < expected < 0.5


def test_names_that_are_no_identifiers_get_labels_of_their_own():
    chain = MarkovChain(
        {"a.b": {"a-b": 1.0}, "a-b": {"1st": 0.5, "deadlock": 0.5}}, ("1st", "deadlock")
    )
    labels = explicit_chain(chain, "a.b").labels
    assert list(labels) == ["init", "a_b", "a_b_2", "s1st", "deadlock_2"]


@pytest.mark.parametrize(
    ("labels", "message"),
    [
        ({"init": ["b"]}, "label 'init': a label must be unique, of letters,"),
        ({"so far": ["b"]}, "label 'so far': a label must be unique, of letters,"),
        ({"failed": ["loss"]}, "label 'failed': no state 'loss'; did you mean 'lost'"),
    ],
)
def test_labels_that_cannot_be_written_are_refused(labels, message):
    with pytest.raises(ModelError, match=message):
        explicit_chain(CHAIN, "b", labels)
    with pytest.raises(ModelError, match="the entry 'c' is not a state"):
        explicit_chain(CHAIN, "c")
    with pytest.raises(ModelError, match="no label 'win'; did you mean 'won'"):
        explicit_chain(CHAIN, "b").labelled("win")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "m.tra:1:1: the file is empty; it must begin with dtmc, ctmc"),
        ("mdp\n", "m.tra:1:1: 'mdp' is not a supported kind of chain; allowed: ctmc, dtmc"),
        ("dtmc\n", "m.tra:1: the file contains no transitions"),
        ("dtmc\n0 1\n", "m.tra:2:1: 2 words; expected a state, the next state and a number"),
        ("dtmc\n0 x 1\n", "m.tra:2:3: 'x' is not a whole number of 0 or more"),
        ("dtmc\n0 -1 1\n", "m.tra:2:3: '-1' is not a whole number"),
        ("dtmc\n0  1 0.5x\n", "m.tra:2:6: '0.5x' is not a probability or rate"),
        ("dtmc\n0 1 -0.5\n", "m.tra:2:5: '-0.5' is not a probability or rate; give a number of 0"),
        ("dtmc\n0 1 nan\n", "m.tra:2:5: 'nan' is not a probability or rate"),
        ("dtmc\n0 1 0.5\n\n0 1 0.5\n", "m.tra:4:1: duplicate transition from 0 to 1"),
        ("dtmc\n1 1 1\n0 1 0.9\n", "m.tra:3: the probabilities from state 0 sum to 0.9"),
        ("dtmc\n1 1 1\n00 1 0.9\n", "m.tra:3: the probabilities from state 0 sum to 0.9"),
        (
            "2 3\n0 1 1\n1 1 1\n",
            "m.tra:3: 3 transitions are declared, but the file has 2; it is",
        ),
        ("2 2\n0 2 1\n1 1 1\n", "m.tra:2:1: state 2, but the file has 2 states"),
        ("2 x\n0 1 1\n", "m.tra:1:3: 'x' is not a whole number"),
    ],
)
def test_garbled_transitions_are_refused_with_their_position(text, message):
    with pytest.raises(ModelError) as caught:
        read(text)
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "m.lab:1:1: the file is empty; it must begin with #DECLARATION"),
        ("#DECLARATON\na\n#END\n", "m.lab:1:1: '#DECLARATON' where #DECLARATION is expected"),
        ("#DECLARATION\ninit\n", "m.lab:2: #END is missing after the labels"),
        ("#DECLARATION\ninit\n#EDN\n", "m.lab:3:1: '#EDN' where #END is expected"),
        (
            "#DECLARATION\ninit\n#END\n0 init x\n",
            "m.lab:4:8: label 'x' is not declared; declared: i",
        ),
        (
            "#DECLARATION\ninit\n#END\n9 init\n",
            "m.lab:4:1: state 9, but the chain has states 0 to 3",
        ),
        ("#DECLARATION\ninit\n#END\ninit 0\n", "m.lab:4:1: 'init' is not a whole number"),
        ("#DECLARATION\na\n#END\n0 a\n", "m.lab:1: no state has the label 'init'; label one"),
        ('0="init" 1=x\n0: 0\n', "m.lab:1:10: '1=x' is not a declaration such as 0=\"init\""),
        ('0="init" 0="x"\n0: 0\n', 'm.lab:1:10: 0="x" is declared twice'),
        ('0="init"\n0 0\n', "m.lab:2:1: '0' where a state and a colon are expected"),
        ('0="init"\n0: 1\n', "m.lab:2:4: label 1 is not declared; declared: 0"),
    ],
)
def test_garbled_labels_are_refused_with_their_position(text, message):
    with pytest.raises(ModelError) as caught:
        read(STORM_TRA, text)
    assert str(caught.value).startswith(message)


def test_a_kind_that_the_file_contradicts_and_too_many_states_are_refused():
    with pytest.raises(ModelError, match=r"m.tra:1:1: the file contains a dtmc, not a ctmc"):
        read(STORM_TRA, kind=ChainKind.CTMC)
    with pytest.raises(TooLargeError, match=r"m.tra:4: state 2; at most 2 states are supported"):
        read(STORM_TRA, most_states=2)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "1000000000000 1\n0 1 1\n",
            "m.tra:1: 1000000000000 states are declared; at most 2000000 are supported",
        ),
        ("999999 1\n0 1 1\n", "m.tra:1: 999999 states are declared, but 1 lines name at"),
        ("dtmc\n0 999999 1\n", "m.tra:2: state 999999, too high for a file with so few lines"),
        ("dtmc\n0 9999999 1\n", "m.tra:2: state 9999999; at most 2000000 states are supported"),
    ],
)
def test_states_that_no_transition_can_name_are_refused_before_memory_is_used(text, message):
    tracemalloc.start()
    try:
        with pytest.raises(TooLargeError) as caught:
            read(text)
        assert str(caught.value).startswith(message)
        assert tracemalloc.get_traced_memory()[1] < 1e6
    finally:
        tracemalloc.stop()


def test_a_file_of_too_many_states_is_refused_by_its_last_lines():
    lines = [f"{state} {state + 1} 1" for state in (*range(500), 2_000_000)]
    with pytest.raises(TooLargeError, match=r"m.tra: state 2000000 in the last lines; at most 20"):
        read("\n".join(("dtmc", *lines)))


def walk(count):
    """The texts of a walk of so many states, with a third way out of each to an end."""
    lines = [
        f"{state} {target} {p}"
        for state in range(count - 2)
        for target, p in ((state + 1, 0.9), (max(state - 3, 0), 0.09), (count - 1, 0.01))
    ]
    ends = (f"{count - 2} {count - 2} 1", f"{count - 1} {count - 1} 1")
    return "\n".join(("dtmc", *lines, *ends)), f'0="init" 1="lost"\n0: 0\n{count - 1}: 1\n'


def test_a_long_text_is_read_a_piece_at_a_time(monkeypatch):
    monkeypatch.setattr("tracerisk.prm.other_models.formats.explicit_lines._PIECE", 1_000)
    text, labels = walk(4_000)
    found = read(text, labels)
    assert len(found.rows) == 4_000
    assert found.rows[2_000] == {2_001: 0.9, 1_997: 0.09, 3_999: 0.01}
    assert found.rows[-2:] == ({}, {})
    cut = text.replace("\n3000 3001 0.9", "\n3000 3001 0.8")
    with pytest.raises(ModelError, match=r"m.tra:9002: the probabilities from state 3000 sum to"):
        read(cut, labels)


def test_lines_read_many_at_a_time_are_those_read_one_by_one(monkeypatch):
    monkeypatch.setattr("tracerisk.prm.other_models.formats.explicit_lines._PIECE", 1_000)
    text, labels = walk(400)
    text = text.replace("\n300 301 0.9", "\n300 301 0.9\n300 302 0\n300 0303 0.0")
    found = read(text + "\n", labels)
    assert 302 not in found.rows[300]
    for other in (text.replace("\n", " x\n"), text.replace("\n", "\n\n").replace("\n", "\r\n")):
        again = read(other.replace("dtmc x", "dtmc"), labels)
        assert (again.rows, again.labels) == (found.rows, found.labels)
    for wrong, message in (
        ("200 201 0.0.9", r"m.tra:602:9: '0.0.9' is not a probability or rate"),
        ("200 201 1e999", r"m.tra:602:9: '1e999' is not a probability or rate"),
        ("200 9999 0.9", r"m.tra:602: state 9999, too high for a file with so few lines; number"),
        ("200 197 0.9", r"m.tra:603:1: duplicate transition from 200 to 197"),
    ):
        with pytest.raises(ModelError, match=message):
            read(walk(400)[0].replace("200 201 0.9", wrong), labels)


def test_too_many_transitions_are_refused_before_they_are_read(monkeypatch):
    monkeypatch.setattr("tracerisk.prm.other_models.formats.explicit.MOST_TRANSITIONS", 3)
    with pytest.raises(TooLargeError, match=r"m.tra: 4 lines; at most 3 transitions are supported"):
        read("dtmc\n0 1 x\n1 2 1\n2 3 1\n3 3 1\n")


def test_memory_for_a_chain_from_a_text_is_some_hundred_bytes_a_state():
    text, labels = walk(5_000)
    tracemalloc.start()
    try:
        kept = read(text, labels)
        assert tracemalloc.get_traced_memory()[1] < 600 * len(kept.rows)
    finally:
        tracemalloc.stop()


def test_many_states_have_the_figures_of_few(tmp_path, monkeypatch):
    from tracerisk.cli.shared.model_format import ModelFormat
    from tracerisk.cli.solving import chains

    text, labels = walk(400)
    (tmp_path / "m.tra").write_text(text)
    (tmp_path / "m.lab").write_text(labels)
    file = chains.ChainFile((str(tmp_path / "m.tra"),), ModelFormat.EXPLICIT, None)
    few = file.solve(None, importance=False)
    monkeypatch.setattr(chains, "SMALL", 100)
    many = file.solve(None, importance=False)
    assert many.figures == pytest.approx(few.figures, rel=1e-13)
    assert list(many.figures) == list(few.figures)
    for name in ("expected_visits", "absorption"):
        assert many.data[name] == pytest.approx(few.data[name], rel=1e-13)
        assert list(many.data[name]) == list(few.data[name])


def test_several_starts_come_back_from_all_formats():
    chain = read(STORM_TRA, "#DECLARATION\ninit\n#END\n2 init\n1 init\n")
    assert chain.starts == (1, 2)
    again = read(write_transitions(chain), write_labels(chain))
    assert (again.starts, again.rows) == (chain.starts, chain.rows)
    assert len(read_prism(write_prism(chain)).starts) == 2
