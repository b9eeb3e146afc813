"""The declared subset of the PRISM language, its state space, and errors with positions."""

from __future__ import annotations

from pathlib import Path

import pytest

from tracerisk.errors import ModelError, TooLargeError
from tracerisk.prm.formats.explicit_chain import ChainKind
from tracerisk.prm.formats.prism import read_prism

DIE = """// Knuth and Yao's die, with faces 1 and the rest
dtmc
const double p = 1/2; // a fair coin
const int N;
module die
  s : [0..N] init 0;
  d : [0..6];
  [] s=0 -> p : (s'=1) + 1-p : (s'=2);
  [] s=1 -> 0.5 : (s'=3) + 0.5 : (s'=4)&(d'=d+1);
  [] s=2 -> (s'=4);
  [] s>2 -> true;
endmodule
formula over = s>=3 & s!=N+1;
label "one" = over & d=1;
label "over" = over;
rewards "flips"
  [] s<7 : 1;
endrewards
"""


def test_constants_variables_commands_formulas_and_labels_are_read():
    chain = read_prism(DIE, file="die.pm", constants={"N": 7})
    assert chain.kind is ChainKind.DTMC
    assert len(chain.rows) == 6
    assert chain.notes == ('die.pm:16:1: rewards "flips" are not read',)
    absorption = chain.markov_chain().solve(chain.entry).absorption()
    assert absorption == {"s=3,d=0": 0.25, "one": 0.25, "s=4,d=0": 0.5}
    assert chain.labelled("over") == ("s=3,d=0", "one", "s=4,d=0")


def test_the_documented_text_is_read_and_solved():
    text = (Path(__file__).parents[3] / "docs" / "formats.md").read_text(encoding="utf-8")
    documented = text.partition("```prism\n")[2].partition("```")[0]
    chain = read_prism(documented, file="docs/formats.md")
    absorption = chain.markov_chain().solve(chain.entry).absorption()
    assert absorption["failed"] == pytest.approx(1e-8 / (0.1 + 1e-8), rel=1e-14)


def test_modules_with_a_common_action_move_together():
    text = """dtmc
    module left
      x : [0..2];
      [go] x<2 -> 0.5 : (x'=x+1) + 0.5 : true;
    endmodule
    module right = left [x=y, go=go] endmodule
    """
    chain = read_prism(text)
    row = {chain.names[target]: p for target, p in chain.rows[0].items()}
    assert row == {"x=0,y=0": 0.25, "x=1,y=0": 0.25, "x=0,y=1": 0.25, "x=1,y=1": 0.25}
    # Where x is 2, the left module blocks the action for both.
    assert {chain.names[i] for i in chain.absorbing} == {
        *("x=2,y=0", "x=2,y=1", "x=2,y=2", "x=1,y=2", "x=0,y=2")
    }


def test_rates_of_several_commands_add_up_and_those_of_one_action_multiply():
    text = """ctmc
    const double l = 1e-9;
    module unit
      up : bool init true;
      [] up -> l : (up'=false);
      [] up -> 2*l : (up'=false);
      [fix] !up -> 3 : (up'=true);
    endmodule
    module crew
      [fix] true -> 0.5 : true;
    endmodule
    """
    chain = read_prism(text)
    assert chain.rows == ({1: 1e-9 + 2e-9}, {0: 1.5})
    shares = chain.continuous_chain().steady_state()
    assert shares["up=false"] == pytest.approx(2e-9, rel=1e-8)


def test_commands_of_a_dtmc_that_hold_together_are_taken_equally_often_with_a_note():
    text = """dtmc
    module m
      s : [0..2];
      [] s=0 -> (s'=1);
      [] s<2 -> (s'=2);
    endmodule
    """
    chain = read_prism(text)
    assert chain.rows[0] == {1: 0.5, 2: 0.5}
    assert chain.notes == ("2 commands hold in s=0; where several do, each is taken equally often",)


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("2+3*4", 14),
        ("(2+3)*4", 20),
        ("7-2-1", 4),
        ("-2+10", 8),
        ("floor(7/2)+ceil(1/2)", 4),
        ("mod(17,5)", 2),
        ("pow(2,3)", 8),
        ("min(3,1,2)+max(1,5)", 6),
        ("round(2.5)", 3),
        ("floor(log(8,2)+0.5)", 3),
        ("true ? 1 : 0", 1),
        ("!1=2 ? 3 : 4", 3),
        ("1<2 & 2<=2 | false ? 5 : 6", 5),
        ("(false => false) ? 7 : 8", 7),
        ("(true <=> false) ? 7 : 8", 8),
        ("1.5e1", 15),
    ],
)
def test_expressions_have_the_values_and_the_precedence_of_the_language(expression, value):
    text = f"dtmc\nmodule m\n  s : [0..20] init {expression};\n  [] s>=0 -> true;\nendmodule\n"
    assert read_prism(text).names == (f"s={value}",)


def test_a_state_of_its_own_label_is_called_by_it_and_others_by_their_values():
    text = 'dtmc\nmodule m\n s : [0..2];\n [] s<2 -> (s\'=s+1);\nendmodule\nlabel "end" = s=2;\n'
    assert read_prism(text).names == ("s=0", "s=1", "end")


PROGRAM = """dtmc
const double p = 0.5;
module m
  s : [0..3] init 0;
  b : bool;
  [] s=0 -> p : (s'=1) + 1-p : (b'=true);
  [] s>0 -> true;
endmodule
label "x" = s=1;
"""


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("dtmc", "mdp", "m.pm:1:1: a model of kind mdp is not read; allowed: ctmc, dtmc"),
        ("dtmc", "model", "m.pm:1:1: 'model' where the kind of model, dtmc or ctmc, is expected"),
        ("endmodule", "", "m.pm:10:1: the file ends where 'endmodule' is expected"),
        ("= 0.5;", "= 0.5", "m.pm:3:1: 'module' where ';' is expected"),
        ("= 0.5;", "= $;", "m.pm:2:18: '$' begins no word of the PRISM language"),
        ("= 0.5;", "= ;", "m.pm:2:18: ';' where an expression is expected"),
        ("= 0.5;", ";", "m.pm:2:14: constant 'p' has no value; give one"),
        ("= 0.5;", "= 1/0;", "m.pm:2:19: no value: "),
        ("= 0.5;", "= q;", "m.pm:2:18: 'q' is not a variable, constant or formula here"),
        ("= 0.5;", "= 0.5; formula p = 1;", "m.pm:2:35: 'p' is declared twice; rename one"),
        ("= 0.5;", "= f; formula f = f;", "m.pm:2:33: formula 'f' leads back to itself"),
        ("= 0.5;", "= sin(1);", "m.pm:2:18: no function 'sin'; did you mean 'min'"),
        ("= 0.5;", "= pow(1);", "m.pm:2:18: pow takes 2 arguments"),
        ("[0..3]", "[3..0]", "m.pm:4:3: 's' ranges from 3 to 0; there is nothing between"),
        ("[0..3]", "[0..2.5]", "m.pm:4:11: 2.5 is not a whole number"),
        ("[0..3]", "{0}", "m.pm:4:7: '{' where bool or a range such as [0..3] is expected"),
        ("init 0", "init 7", "m.pm:4:3: 's' would be 7, outside of 0 to 3"),
        ("(s'=1)", "(s'=5)", "m.pm:6:18: 's' would be 5, outside of 0 to 3"),
        ("(s'=1)", "(t'=1)", "m.pm:6:18: no variable 't'"),
        ("(b'=true)", "(b'=1)", "m.pm:6:33: 'b' is true or false, never 1"),
        ("1-p", "0.4", "m.pm:6:3: the probabilities sum to 0.9 in s=0,b=false; they must sum to 1"),
        ("1-p", "-0.5", "m.pm:6:26: -0.5 in s=0,b=false is not a probability or rate"),
        ("[] s=0", "[] s", "m.pm:6:3: a guard of 0, neither true nor false"),
        ("[] s=0", "[] s & b", "m.pm:6:8: 0 is neither true nor false"),
        ("[] s=0 ->", "[] s=0", "m.pm:6:10: 'p' where '->' is expected"),
        ("[] s>0", "? s>0", "m.pm:7:3: '?' where a variable, a command or 'endmodule' is expected"),
        ('"x" = s=1', '"x" = s', 'm.pm:9:13: label "x" is 0, neither true nor false'),
        ('"x" = s=1', "x = s=1", "m.pm:9:7: 'x' where a label in quotes is expected"),
        ('"x" = s=1;', '"x" = s=1; label "x" = s=2;', 'm.pm:9:24: duplicate label "x"'),
        ("label", "init", "m.pm:9:1: 'init' is not read; one start is"),
        ("label", "lable", "m.pm:9:1: 'lable' where a declaration (const, "),
        ("endmodule", "endmodule module m endmodule", "m.pm:8:18: duplicate module 'm'"),
        ("endmodule", "endmodule module n=k [a=b] endmodule", "m.pm:8:20: no module 'k' before"),
        ("endmodule", "endmodule rewards", "m.pm:10:1: the file ends where 'endrewards'"),
    ],
)
def test_a_garbled_text_is_refused_with_its_position(old, new, message):
    assert old in PROGRAM
    with pytest.raises(ModelError) as caught:
        read_prism(PROGRAM.replace(old, new, 1), file="m.pm")
    assert str(caught.value).startswith(message)


def test_a_text_without_a_module_an_unknown_constant_and_too_many_states_are_refused():
    with pytest.raises(ModelError, match=r"m.pm:1:5: the model has no module"):
        read_prism("dtmc", file="m.pm")
    with pytest.raises(ModelError, match="no constant 'q'; allowed: p"):
        read_prism(PROGRAM, constants={"q": 1})
    with pytest.raises(TooLargeError, match="more than 2 states can be reached; raise the limit"):
        read_prism(PROGRAM, most_states=2)


EXAMPLES = (
    ("dtmc", "die.pm"),
    ("dtmc", "brp-16-2.pm"),
    ("dtmc", "leader-3-5.pm"),
    ("dtmc", "nand-5-2.pm"),
    ("dtmc", "negativevals.pm"),
    ("ctmc", "cluster2.sm"),
    ("ctmc", "embedded2.sm"),
    ("ctmc", "fms2.sm"),
    ("ctmc", "polling2.sm"),
    ("ctmc", "tandem5.sm"),
)


@pytest.mark.parametrize(("folder", "name"), EXAMPLES)
def test_the_examples_of_stormpy_have_the_states_and_transitions_that_storm_finds(folder, name):
    stormpy = pytest.importorskip("stormpy", reason="stormpy is not installed")
    examples = pytest.importorskip("stormpy.examples", reason="stormpy has no examples")
    path = Path(examples.__file__).parent / "files" / folder / name
    if not path.exists():
        pytest.skip(f"stormpy has no {name}")
    chain = read_prism(path.read_text(encoding="utf-8"), file=name)
    program = stormpy.parse_prism_program(str(path), prism_compatibility=True)
    built = stormpy.build_model(program)
    ways = sum(max(1, len(row)) for row in chain.rows)
    assert (len(chain.rows), ways) == (built.nr_states, built.nr_transitions)


@pytest.mark.parametrize(("name", "label"), [("die.pm", "one"), ("leader-3-5.pm", "elected")])
def test_the_examples_of_stormpy_are_absorbed_as_storm_says(name, label):
    stormpy = pytest.importorskip("stormpy", reason="stormpy is not installed")
    examples = pytest.importorskip("stormpy.examples", reason="stormpy has no examples")
    path = Path(examples.__file__).parent / "files" / "dtmc" / name
    if not path.exists():
        pytest.skip(f"stormpy has no {name}")
    chain = read_prism(path.read_text(encoding="utf-8"), file=name)
    targets = [s for s in chain.labelled(label) if s in chain.markov_chain().absorbing]
    solution = chain.markov_chain().solve(chain.entry)
    built = stormpy.build_model(stormpy.parse_prism_program(str(path)))
    (question,) = stormpy.parse_properties(f'P=? [F "{label}"]')
    answer = stormpy.model_checking(built, question, environment=stormpy.environments.exact())
    assert len(targets) == len(chain.labels[label])
    assert solution.absorption_from_each(targets)[chain.entry] == pytest.approx(
        answer.get_value(built.initial_states[0]), rel=1e-12
    )
