"""The declared subset of the PRISM language, its state space, and errors with positions."""

import re
from pathlib import Path

import pytest

from tracerisk.errors import ModelError, TooLargeError
from tracerisk.prm.other_models.formats.explicit_chain import ChainKind
from tracerisk.prm.other_models.formats.prism import read_prism, state_space
from tracerisk.prm.other_models.formats.prism.state_space import StateSpace

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
    assert chain.notes == ()
    assert chain.rewards["flips"].moves == [1.0] * 6
    absorption = chain.markov_chain().solve(chain.entry).absorption()
    assert absorption == {"s=3,d=0": 0.25, "one": 0.25, "s=4,d=0": 0.5}
    assert chain.labelled("over") == ("s=3,d=0", "one", "s=4,d=0")


def test_the_documented_text_is_read_and_solved():
    text = (Path(__file__).parents[4] / "docs" / "formats.md").read_text(encoding="utf-8")
    documented = text.partition("```prism\n")[2].partition("```")[0]
    chain = read_prism(documented, file="docs/formats.md")
    absorption = chain.markov_chain().solve(chain.entry).absorption()
    assert absorption["failed"] == pytest.approx(1e-8 / (0.1 + 1e-8), rel=1e-14)


def test_labels_may_stand_in_labels_whichever_comes_first():
    text = (
        DIE
        + """label "both" = "one" | ("begun" & "over") | "deadlock";
    label "begun" = !"init";
    """
    )
    chain = read_prism(text, constants={"N": 7})
    assert chain.labelled("begun") == tuple(chain.names[1:])
    assert set(chain.labelled("both")) == {"s=3,d=0", "one", "s=4,d=0"}
    assert "deadlock" not in chain.labels


@pytest.mark.parametrize(
    ("labels", "message"),
    [
        ('label "a" = "b"; label "b" = !"a";', 'label "a" is defined in terms of itself'),
        ('label "a" = "overr";', "no label \"overr\"; did you mean 'over'?"),
        ("", ""),
    ],
)
def test_labels_that_have_no_meaning_are_refused(labels, message):
    if not labels:
        text, message = DIE.replace("[] s>2", '[] "over"'), "labels are allowed in labels and"
    else:
        text = DIE + labels
    with pytest.raises(ModelError, match=message):
        read_prism(text, constants={"N": 7})


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
    assert chain.notes == ("2 commands are enabled in s=0; each is chosen with equal probability",)


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
        ("dtmc", "mdp", "m.pm:1:1: a model of kind mdp is not supported; allowed: ctmc, dtmc"),
        ("dtmc", "model", "m.pm:1:1: expected the kind of model, dtmc or ctmc,, found 'model'"),
        ("endmodule", "", "m.pm:10:1: expected 'endmodule', found the end of the file"),
        ("= 0.5;", "= 0.5", "m.pm:3:1: expected ';', found 'module'"),
        ("= 0.5;", "= $;", "m.pm:2:18: '$' is not part of the PRISM language"),
        ("= 0.5;", "= ;", "m.pm:2:18: expected an expression, found ';'"),
        ("= 0.5;", ";", "m.pm:2:14: constant 'p' has no value; give one"),
        ("= 0.5;", "= 1/0;", "m.pm:2:19: cannot be evaluated: "),
        ("= 0.5;", "= q;", "m.pm:2:18: 'q' is not a variable, constant or formula here"),
        ("= 0.5;", "= 0.5; formula p = 1;", "m.pm:2:35: 'p' is declared twice; rename one"),
        ("= 0.5;", "= f; formula f = f;", "m.pm:2:33: formula 'f' is defined in terms of itself"),
        ("= 0.5;", "= sin(1);", "m.pm:2:18: unknown function 'sin'; did you mean 'min'"),
        ("= 0.5;", "= pow(1);", "m.pm:2:18: pow takes 2 arguments"),
        ("[0..3]", "[3..0]", "m.pm:4:3: 's' ranges from 3 to 0; the range is empty"),
        ("[0..3]", "[0..2.5]", "m.pm:4:11: 2.5 is not a whole number"),
        ("[0..3]", "{0}", "m.pm:4:7: expected bool or a range such as [0..3], found '{'"),
        ("init 0", "init 7", "m.pm:4:3: 's' would be 7, outside of 0 to 3"),
        ("(s'=1)", "(s'=5)", "m.pm:6:18: 's' would be 5, outside of 0 to 3"),
        ("(s'=1)", "(t'=1)", "m.pm:6:18: no variable 't'"),
        ("(b'=true)", "(b'=1)", "m.pm:6:33: 'b' is boolean, but is assigned 1"),
        ("1-p", "0.4", "m.pm:6:3: the probabilities sum to 0.9 in s=0,b=false; they must sum to 1"),
        ("1-p", "-0.5", "m.pm:6:26: -0.5 in s=0,b=false is not a probability or rate"),
        ("[] s=0", "[] s", "m.pm:6:3: a guard of 0, neither true nor false"),
        ("[] s=0", "[] s & b", "m.pm:6:8: 0 is neither true nor false"),
        ("[] s=0 ->", "[] s=0", "m.pm:6:10: expected '->', found 'p'"),
        ("[] s>0", "? s>0", "m.pm:7:3: expected a variable, a command or 'endmodule', found '?'"),
        ('"x" = s=1', '"x" = s', 'm.pm:9:13: label "x" is 0, neither true nor false'),
        ('"x" = s=1', "x = s=1", "m.pm:9:7: expected a label in quotes, found 'x'"),
        ('"x" = s=1;', '"x" = s=1; label "x" = s=2;', 'm.pm:9:24: duplicate label "x"'),
        ("label", "init", "m.pm:9:15: expected 'endinit', found ';'"),
        ("label", "lable", "m.pm:9:1: expected a declaration (const, "),
        ("endmodule", "endmodule module m endmodule", "m.pm:8:18: duplicate module 'm'"),
        ("endmodule", "endmodule module n=k [a=b] endmodule", "m.pm:8:20: no module 'k' before"),
        ("endmodule", "endmodule rewards true : 1;", "m.pm:9:7: expected ':', found '\"x\"'"),
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
    with pytest.raises(ModelError, match="unknown constant 'q'; allowed: p"):
        read_prism(PROGRAM, constants={"q": 1})
    with pytest.raises(TooLargeError, match="more than 2 states are reachable; raise the limit"):
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


def one_state(expression, before=""):
    return (
        f"dtmc\n{before}\nmodule m\n  s : [0..20000] init {expression};\n  [] true -> true;\n"
        "endmodule\n"
    )


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("(" * 20_000 + "7" + ")" * 20_000, 7),
        ("(1+" * 100 + "1" + ")" * 100, 101),
        ("+".join(["1"] * 20_000), 20_000),
        ("1000" + "-1" * 500, 500),
        ("".join(f"{n}>5 ? {n} : " for n in range(5_000)) + "3", 6),
        ("(" + "|".join(["1=2"] * 5_000) + "|true) ? 1 : 2", 1),
        ("2=3 ? 1 : 3=3 ? 4=4 ? 5 : 6 : 7", 5),
        ("1 < 2 ? (2 < 1 ? 3 : 4) : 5", 4),
        ("max(1, 2 > 1 ? 8 : 9, 3)", 8),
        ("0 > 1 ? 1/0 : 2", 2),
        ("8/2/2", 2),
        ("2-(3-4)", 3),
        ("-(-3)", 3),
        ("!!(1=1) ? 1 : 2", 1),
    ],
)
def test_chained_and_bracketed_expressions_of_any_length_are_read(expression, value):
    assert read_prism(one_state(expression)).names == (f"s={value}",)


def test_formulas_and_constants_that_stand_for_one_another_are_read_in_any_order():
    count = 3_000
    constants = "".join(f"const int c{n} = c{n + 1};\n" for n in range(count))
    text = one_state("c0", f"{constants}const int c{count} = last;\nformula last = 5;")
    assert read_prism(text).names == ("s=5",)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (one_state("-" * 3_000 + "1"), "an expression nests more than 200 operations"),
        (one_state("(1+" * 300 + "1" + ")" * 300), "an expression nests more than 200 operations"),
        (one_state("(" * 3_000), "expected an expression, found"),
        (one_state("(1 ? 2) : 3"), "m.pm:4:29: expected ':',"),
        (one_state("(1, 2)"), "m.pm:4:25: expected ')',"),
        (one_state("max(1 ? 2, 3)"), "m.pm:4:32: expected ':',"),
        (one_state("pow(10, 1000000000)"), "cannot be evaluated: a power that is too large"),
        (one_state("pow(-8, 1/2)"), "cannot be evaluated: a power that is no real number"),
        (one_state("1" + "*1000000" * 1_000), "cannot be evaluated: a product that is too large"),
        (one_state("a", "const int a = b;\nconst int b = a;"), "is defined in terms of itself"),
        (one_state("a", "const int a = f;\nformula f = a;"), "is defined in terms of itself"),
        (one_state("f", "formula f = g;\nformula g = f;"), "is defined in terms of itself"),
        (
            one_state(
                "f40",
                "formula f0=1+s;\n" + "".join(f"formula f{n + 1}=f{n}+f{n};\n" for n in range(40)),
            )
            .replace("init f40", "")
            .replace("] true", "] f40=1"),
            "has more than 100000 operations",
        ),
        (
            one_state(
                "0",
                "formula f0=1+s;\n" + "".join(f"formula f{n + 1}=f{n}+1;\n" for n in range(400)),
            ).replace("] true", "] f400=1"),
            "an expression nests more than 200 operations deep",
        ),
    ],
)
def test_what_would_take_too_deep_or_too_much_is_refused(text, message):
    with pytest.raises(ModelError, match=re.escape(message)):
        read_prism(text, file="m.pm")


def test_moves_of_many_modules_together_are_counted_before_they_are_made(monkeypatch):
    monkeypatch.setattr(state_space, "_MOST_WORK", 1_000_000)
    monkeypatch.setattr(StateSpace, "_weight", lambda *_: pytest.fail("a move was made"))
    modules = "".join(
        f"module m{n}\n  x{n} : [0..1];\n  [go] true -> 0.5 : (x{n}'=0) + 0.5 : (x{n}'=1);\n"
        "endmodule\n"
        for n in range(60)
    )
    with pytest.raises(TooLargeError, match="more than 1000000 operations to build; give"):
        read_prism(f"dtmc\n{modules}")


def test_the_states_of_init_are_the_starts_and_come_first():
    text = """dtmc
    module m
      x : [0..2];
      y : bool;
      [] x<2 -> (x'=x+1);
    endmodule
    init x=1 | (x=0 & y) endinit
    """
    chain = read_prism(text)
    assert [chain.names[state] for state in chain.starts] == [
        *("x=0,y=true", "x=1,y=false", "x=1,y=true"),
    ]
    assert chain.labels["init"] == frozenset((0, 1, 2))
    with pytest.raises(ModelError, match="no state satisfies 'init"):
        read_prism(text.replace("x=1 | (x=0 & y)", "x>2"))
    with pytest.raises(ModelError, match="'x' has an initial value of its own beside 'init"):
        read_prism(text.replace("[0..2]", "[0..2] init 0"))


def test_rewards_are_those_of_states_and_of_moves_by_their_action():
    text = """ctmc
    module m
      x : [0..2];
      [go] x<2 -> 3 : (x'=x+1);
      [] x=2 -> 0.5 : (x'=0);
    endmodule
    rewards "both" x>0 : x; true : 1; [go] x=1 : 10; [] true : 4; endrewards
    rewards [go] true : 1; endrewards
    """
    rewards = read_prism(text).rewards
    assert rewards["both"].states == [1.0, 2.0, 3.0]
    assert rewards["both"].moves == [0.0, 30.0, 2.0]
    assert rewards[""].moves == [3.0, 3.0, 0.0]
    with pytest.raises(ModelError, match=r"-1 in x=0 is not a reward; allowed: 0 or more"):
        read_prism(text.replace("x>0 : x", "true : x-1"))


@pytest.mark.parametrize("word", ["system", "invariant", "observables", "player"])
def test_what_is_not_read_is_refused_by_its_name(word):
    with pytest.raises(ModelError, match=rf"m.pm:2:1: .*'{word}'"):
        read_prism(f"dtmc\n{word} x end{word}\n", file="m.pm")
