"""What people ask of chains: probabilities of paths, rewards, and the long run."""

import math
from random import Random

import pytest

from tracerisk.errors import ModelError, TooLargeError
from tracerisk.prm.other_models.formats.explicit import read_explicit
from tracerisk.prm.other_models.formats.prism.prism_reader import read_prism_model
from tracerisk.prm.other_models.properties import ask, parse_properties

GAMBLER = """dtmc
const int N = 5;
const double p = 0.4;
module walk
  x : [0..N] init 2;
  [] x>0 & x<N -> p:(x'=x+1) + 1-p:(x'=x-1);
  [] x=0 | x=N -> true;
endmodule
label "ruin" = x=0;
label "won" = x=N;
rewards "steps" x>0 & x<N : 1; endrewards
rewards "wins" [] x=N-1 : p; endrewards
"""


def values(text, questions, **constants):
    found = ask(read_prism_model(text), questions, constants)
    return [each.value for each in found]


def gambler(question, **constants):
    (value,) = values(GAMBLER, question, **constants)
    return value


def test_ruin_has_its_textbook_answers():
    ratio = 0.6 / 0.4
    won = (ratio**2 - 1) / (ratio**5 - 1)
    assert gambler('P=? [F "won"]') == pytest.approx(won, rel=1e-14)
    assert gambler("P=? [F x=0]") == pytest.approx(1 - won, rel=1e-14)
    assert gambler('S=? ["won"]') == pytest.approx(won, rel=1e-14)
    steps = (2 - 5 * won) / (0.6 - 0.4)
    assert gambler('R{"steps"}=? [F "ruin"|"won"]') == pytest.approx(steps, rel=1e-13)
    assert gambler("R{1}=? [C]") == pytest.approx(steps, rel=1e-13)
    assert gambler('R{"wins"}=? [C]') == pytest.approx(won, rel=1e-13)
    assert gambler('R=? [F "won"]') == math.inf


def test_paths_keep_to_what_they_may_pass():
    # From 2 to 0 without 4: the walk on 0..4 is ruined before it stands on 4.
    ratio = 0.6 / 0.4
    lost = 1 - (ratio**2 - 1) / (ratio**4 - 1)
    assert gambler('P=? [x<4 U "ruin"]') == pytest.approx(lost, rel=1e-14)
    assert gambler("P=? [G x<4]") == pytest.approx(lost, rel=1e-14)
    assert gambler("P=? [x<4 W x=4]") == 1.0
    assert gambler("P=? [X x=3]") == 0.4
    assert gambler("P=? [x<2 U x=5]") == 0.0


def test_times_are_steps_of_a_dtmc():
    assert gambler("P=? [F<=1 x=0]") == 0.0
    assert gambler("P=? [F<=2 x=0]") == pytest.approx(0.36, rel=1e-15)
    assert gambler("P=? [F<3 x=0]") == pytest.approx(0.36, rel=1e-15)
    assert gambler("P=? [F=2 x=2]") == pytest.approx(2 * 0.4 * 0.6, rel=1e-15)
    assert gambler("P=? [G<=1 x>0]") == 1.0
    assert gambler("P=? [F[3,4] x=0]") == pytest.approx(0.36 + 2 * 0.4 * 0.6 * 0.36, rel=1e-14)
    assert gambler("R=? [C<=2]") == 2.0
    assert gambler("R=? [I=2]") == pytest.approx(0.64, rel=1e-15)
    assert gambler("const int k; P=? [F<=k x=0]", k=2) == gambler("P=? [F<=2 x=0]")


def test_filters_limits_formulas_and_labels_of_the_question():
    found = ask(
        read_prism_model(GAMBLER),
        'formula far = x-2; label "near" = far<=1 & far>=-1; '
        '"most": filter(max, P=? [F "won"], "near"); P>=0.5 [F "ruin"]; P<0.5 [F "ruin"]',
    )
    assert found[0].question.name == "most"
    assert found[0].value == gambler('filter(sum, P=? [F "won"], x=3)')
    assert [each.holds for each in found] == [None, True, False]
    assert gambler('filter(avg, P=? [F "won"], x=0|x=5)') == 0.5


REPAIR = """ctmc
module unit
  s : [0..2] init 0;
  [] s<2 -> (2-s)*0.01 : (s'=s+1);
  [] s>0 -> 0.5 : (s'=s-1);
endmodule
label "down" = s=2;
rewards "cost" s=1 : 3; s=2 : 10; endrewards
"""


def test_a_ctmc_has_times_and_a_long_run():
    total = 1 + 0.02 / 0.5 + 0.02 / 0.5 * 0.01 / 0.5
    down = 0.02 / 0.5 * 0.01 / 0.5 / total
    (share,) = values(REPAIR, 'S=? ["down"]')
    assert share == pytest.approx(down, rel=1e-14)
    (cost,) = values(REPAIR, 'R{"cost"}=? [S]')
    assert cost == pytest.approx(3 * 0.02 / 0.5 / total + 10 * down, rel=1e-14)
    (mean,) = values(REPAIR.replace("s=1 : 3; s=2 : 10;", "true : 1;"), 'R=? [F "down"]')
    # T0 = 50 + T1 and 0.51 T1 = 1 + 0.5 T0.
    assert mean == pytest.approx((50 * 0.51 + 1) / 0.01, rel=1e-13)
    never = REPAIR.replace("[] s>0 -> 0.5 : (s'=s-1);", "")
    fails = math.exp(-0.02 * 30), math.exp(-0.01 * 30)
    (by_30,) = values(never, 'P=? [F<=30 "down"]')
    assert by_30 == pytest.approx((1 - fails[1]) ** 2, rel=1e-13)
    (between,) = values(never, "P=? [s<1 U[10,30] s=1]")
    assert between == pytest.approx(math.exp(-0.2) - math.exp(-0.6), rel=1e-13)


def test_several_starts_are_answered_by_a_range():
    text = GAMBLER.replace("init 2", "").replace("endmodule", "endmodule\ninit x>0 & x<N endinit")
    (found,) = ask(read_prism_model(text), 'P=? [F "won"]')
    one = gambler('filter(state, P=? [F "won"], x=1)')
    four = gambler('filter(state, P=? [F "won"], x=4)')
    assert (found.least, found.greatest) == pytest.approx((one, four), rel=1e-14)
    assert not found.single
    with pytest.raises(ModelError, match="depending on the initial state"):
        _ = found.value


def test_a_recurrent_class_of_several_states_has_its_shares():
    text = """dtmc
module m
  s : [0..3] init 0;
  [] s=0 -> 0.25:(s'=1) + 0.75:(s'=3);
  [] s=1 -> 0.5:(s'=1) + 0.5:(s'=2);
  [] s=2 -> (s'=1);
  [] s=3 -> true;
endmodule"""
    (share,) = values(text, "S=? [s=2]")
    assert share == pytest.approx(0.25 / 3, rel=1e-14)
    assert values(text, "P=? [F s=1|s=2]") == [0.25]


def test_files_of_transitions_are_asked_by_labels():
    transitions = "4 5\n0 1 0.5\n0 2 0.5\n1 1 1\n2 3 1\n3 3 1\n"
    chain = read_explicit(transitions, '0="init" 1="end"\n0: 0\n1: 1\n3: 1\n')
    (ends,) = ask(chain, 'P=? [F "end"]')
    (first,) = ask(chain, 'P=? [F<=1 "end"]')
    assert (ends.value, first.value) == (1.0, 0.5)
    with pytest.raises(ModelError, match="has no rewards"):
        ask(chain, "R=? [C]")


HERMAN = """dtmc
module one
  x1 : bool;
  [step] x1=x3 -> 0.5:(x1'=false) + 0.5:(x1'=true);
  [step] !(x1=x3) -> (x1'=x3);
endmodule
module two = one [x1=x2, x3=x1] endmodule
module three = one [x1=x3, x3=x2] endmodule
init true endinit
label "stable" = (x1=x2?1:0)+(x2=x3?1:0)+(x3=x1?1:0)=1;
rewards true : 1; endrewards
"""


def test_a_ring_that_may_start_anywhere_becomes_stable():
    found = ask(read_prism_model(HERMAN), 'P=? [F "stable"]; filter(max, R=? [F "stable"], "init")')
    assert (found[0].least, found[0].greatest) == (1.0, 1.0)
    # Three tokens stay three with 1/4.
    assert found[1].value == pytest.approx(4 / 3, rel=1e-14)


SENDER = """dtmc
const int N = 16;   // pieces of a file
const int MAX = 2;  // how often each may be sent again
const double lost = 0.02 + 0.98 * 0.01;  // the piece, or its receipt
module sender
  piece : [0..N] init 0;
  again : [0..MAX] init 0;
  failed : bool init false;
  [] !failed & piece<N & again<MAX -> 1-lost:(piece'=piece+1)&(again'=0) + lost:(again'=again+1);
  [] !failed & piece<N & again=MAX -> 1-lost:(piece'=piece+1)&(again'=0) + lost:(failed'=true);
  [] failed | piece=N -> true;
endmodule
"""


def test_a_sender_that_gives_up_has_the_published_figure():
    # D'Argenio and others, "Reachability analysis of probabilistic systems by successive
    # refinements" (2001): the bounded retransmission protocol, N = 16, MAX = 2, 4.2333e-4.
    (found,) = values(SENDER, "P=? [F failed]")
    assert found == pytest.approx(1 - (1 - 0.0298**3) ** 16, rel=1e-12)
    assert f"{found:.4e}" == "4.2333e-04"


def test_random_chains_agree_with_stepping():
    random = Random(7)
    for _ in range(30):
        size = random.randint(2, 7)
        lines, count = [], 0
        for state in range(size):
            targets = random.sample(range(size), random.randint(1, size))
            weights = [random.randint(1, 5) for _ in targets]
            for target, weight in sorted(zip(targets, weights, strict=True)):
                lines.append(f"{state} {target} {weight / sum(weights)!r}")
                count += 1
        goal, via = random.randrange(size), random.sample(range(size), size // 2 + 1)
        labels = [
            f"{state}: {' '.join(names)}"
            for state in range(size)
            if (
                names := [
                    *(["0"] if state == 0 else []),
                    *(["1"] if state == goal else []),
                    *(["2"] if state in via else []),
                ]
            )
        ]
        chain = read_explicit(
            "\n".join([f"{size} {count}", *lines]),
            '0="init" 1="goal" 2="via"\n' + "\n".join(labels),
        )
        now, reached = {0: 1.0}, []
        for _ in range(60):
            reached.append(now.get(goal, 0.0))
            after: dict[int, float] = {}
            for state, mass in now.items():
                ends = state == goal or state not in via
                moves = {state: 1.0} if ends else chain.rows[state]
                for target, p in moves.items():
                    after[target] = after.get(target, 0.0) + mass * p
            now = after
        for steps in (0, 1, 5, 50):
            (found,) = ask(chain, f'P=? ["via" U<={steps} "goal"]')
            assert found.value == pytest.approx(reached[steps], rel=1e-12, abs=1e-15)
        (ever,) = ask(chain, 'P=? ["via" U "goal"]')
        assert reached[-1] <= ever.value * (1 + 1e-12)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("Pmax=? [F x=0]", "choices of a controller"),
        ("P=? [F G x=0]", "LTL is not supported"),
        ("P=? [F P>0.5 [X x=0]]", "P within a property: nested properties are not supported"),
        ("P=? [x=0 R x=1]", "release"),
        ("P=? F x=0", "found 'F'"),
        ('P=? [F "one"]', 'no label "one"'),
        ("P=? [F y=0]", "'y' is not a variable"),
        ("P=? [F x+1]", "neither true nor false"),
        ("P=? [F<=0.5 x=0]", "0.5 is not a whole number of steps"),
        ("P=? [F<=k x=0]", "'k' is not a variable"),
        ("const int k; P=? [F<=k x=0]", "constant 'k' has no value"),
        ('R{"money"}=? [C]', 'no rewards "money"'),
        ("R{7}=? [C]", "no rewards 7; the model has 2"),
        ("filter(max, P=? [F x=0], x>9)", "the filter selects no state"),
        ("filter(argmax, P=? [F x=0])", "filter argmax is not supported"),
        ("P=? [F x=0] + 1", "arithmetic and logic over properties are not supported"),
        ('label "won" = x=1; P=? [F "won"]', "declared in the model already"),
        ("P=? [F x=0", "properties:1:11: expected ']'"),
    ],
)
def test_what_is_not_read_is_reported_by_name(text, message):
    with pytest.raises(ModelError, match=message.replace("?", r"\?").replace("+", r"\+")):
        ask(read_prism_model(GAMBLER), text)


def test_too_long_a_time_is_refused_at_once():
    with pytest.raises(TooLargeError):
        values(
            REPAIR.replace("0..2", "0..3000").replace("s<2", "s<3000").replace("(2-s)*0.01", "1"),
            "P=? [F<=1e14 s=2]",
        )


def test_an_empty_text_asks_nothing():
    assert parse_properties("// nothing\n").properties == ()
