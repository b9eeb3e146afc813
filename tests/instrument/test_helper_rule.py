"""Which functions are steps, on call structures as controllers have them.

Each controller runs for real; `command()` stands for what makes hardware act.
"""

import random
from collections.abc import Callable, Sequence
from typing import Any

import pytest

from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.errors import InputError
from tracerisk.instrument.helper_rule import helper_rule
from tracerisk.instrument.tracer import Frame

Run = Callable[[str], Any]


def owners(ran: Any, *, states: Sequence[str] = (), helpers: Sequence[str] = ()) -> list[str]:
    """Return the owner of each command, repetitions in a row told once."""
    stacks = [each.stack for each in ran.commands]
    rule = helper_rule(stacks, states=states, helpers=helpers)
    again = helper_rule(reversed(stacks), states=states, helpers=helpers)
    assert rule == again, "the order of the commands decides nothing"
    names = [str(stack[rule.owner_position(stack)].function.name) for stack in stacks]
    return [name for k, name in enumerate(names) if k == 0 or names[k - 1] != name]


FIVE_STEPS = """
    import robot
    def go_to(pose):
        plan(pose)
    def plan(pose):
        robot.command(pose)
    def open_gripper():
        robot.command("open")
    def close_gripper():
        robot.command("close")

    def init():
        go_to("ready")
        open_gripper()
    def pick_position():
        go_to("above")
    def pick():
        go_to("down")
        close_gripper()
        go_to("up")
    def place_position():
        go_to("rack")
    def place():
        open_gripper()
    def main():
        init()
        for _ in range(2):
            pick_position(); pick(); place_position(); place()
    if __name__ == "__main__":
        main()
"""
CYCLE = ["pick_position", "pick", "place_position", "place"]


def test_five_steps_that_share_helpers_are_the_steps(run: Run) -> None:
    assert owners(run(FIVE_STEPS)) == ["init", *CYCLE, *CYCLE]


def test_class_with_methods_gives_its_steps(run: Run) -> None:
    assert owners(
        run(
            """
            import robot
            class PickNode:
                def __init__(self): self.home()
                def move(self, pose): robot.command(pose)
                def grip(self): robot.command("close")
                def release(self): robot.command("open")
                def home(self): self.move("home")
                def pick(self): self.move("above"); self.move("down"); self.grip()
                def place(self): self.move("rack"); self.release()
                def run(self): self.pick(); self.place()
            PickNode().run()
            """
        )
    ) == ["PickNode.home", "PickNode.pick", "PickNode.place"]


def test_sharing_makes_a_helper_and_what_only_helpers_call_is_one(run: Run) -> None:
    source = """
        import robot
        def execute(plan): robot.command(plan)
        def go_to(pose): execute(pose)
        def pick(): go_to(1); robot.command("grip")
        def place(): go_to(2); robot.command("drop")
        pick(); place()
    """
    ran = run(source)
    assert owners(ran) == ["pick", "place"]
    rule = helper_rule([each.stack for each in ran.commands])
    assert sorted(ref.name for ref in rule.helpers) == ["execute", "go_to"]


def test_helper_shared_only_through_another_helper(run: Run) -> None:
    assert owners(
        run(
            """
            import robot
            def send(goal): robot.command(goal)
            def arm(goal): send(goal)
            def hand(goal): send(goal)
            def pick(): arm(1); hand(0); arm(2)
            def place(): arm(3); hand(1)
            pick(); place()
            """
        )
    ) == ["pick", "place"]


def test_composite_step_called_from_two_places_stays_a_step(run: Run) -> None:
    assert owners(
        run(
            """
            import robot
            def move(p): robot.command(p)
            def grip(w): robot.command(w)
            def regrasp(): move(1); grip(0)
            def first(): move(5); regrasp(); robot.command("a")
            def second(): move(6); regrasp(); robot.command("b")
            first(); second()
            """
        )
    ) == ["first", "regrasp", "first", "second", "regrasp", "second"]


def test_everything_inlined_into_main_belongs_to_main(run: Run) -> None:
    assert owners(
        run(
            """
            import robot
            def main():
                robot.command("home")
                for p in range(3):
                    robot.command(p)
                robot.command("open")
            main()
            """
        )
    ) == ["main"]


def test_flat_script_belongs_to_the_module(run: Run) -> None:
    assert owners(run("import robot\nrobot.command(1)\nrobot.command(2)\n")) == ["<module>"]


def test_flat_script_that_calls_a_helper_from_many_places_is_reported_by_the_function(
    run: Run,
) -> None:
    # One caller, no commands of its own: the function's name says more than `<module>`.
    source = "import robot\ndef go(p): robot.command(p)\ngo(1)\ngo(2)\n"
    assert owners(run(source)) == ["go"]


def test_wrappers_of_one_primitive_each_stay_steps(run: Run) -> None:
    assert owners(
        run(
            """
            import robot
            def home(): robot.command("home")
            def open_hand(): robot.command("open")
            def main(): home(); open_hand(); home()
            main()
            """
        )
    ) == ["home", "open_hand", "home"]


def test_primitive_among_its_callers_own_commands_is_a_helper(run: Run) -> None:
    assert owners(
        run(
            """
            import robot
            def close_hand(): robot.command("close")
            def look(): robot.command("look"); robot.command("again")
            def pick():
                robot.command("down"); close_hand(); robot.command("up")
                look()
            def main(): pick()
            main()
            """
        )
    ) == ["pick", "look"]


def test_name_of_the_caller_says_more_where_it_is_called_from_two_sites(run: Run) -> None:
    source = """
        import robot
        def go_joints(target): robot.command(target)
        def move_home(): go_joints("home")
        def work(): robot.command("a"); robot.command("b")
        def main():
            move_home(); work(){more}
        main()
    """
    assert owners(run(source.format(more="; move_home()"))) == ["move_home", "work", "move_home"]
    assert owners(run(source.format(more=""))) == ["go_joints", "work"]


def test_recursion_is_no_second_caller(run: Run) -> None:
    assert owners(
        run(
            """
            import robot
            def sort(n):
                robot.command(n); robot.command("grip")
                if n: sort(n - 1)
            def other(): robot.command("x"); robot.command("y")
            def main(): sort(2); other()
            main()
            """
        )
    ) == ["sort", "other"]


def test_states_that_call_each_other_in_a_ring_stay_states(run: Run) -> None:
    assert owners(
        run(
            """
            import robot
            def approach(n):
                robot.command("approach")
                grasp(n)
            def grasp(n):
                robot.command("grasp")
                if n: approach(n - 1)
                else: retreat()
            def retreat(): robot.command("a"); robot.command("b")
            approach(1)
            """
        )
    ) == ["approach", "grasp", "approach", "grasp", "retreat"]


def test_a_done_callback_is_no_second_caller(run: Run) -> None:
    source = """
        import robot
        def send_next(): robot.command("a"); robot.command("b")
        def done(): send_next()
        def begin(): robot.command("x"); send_next()
        def other(): robot.command("y"); robot.command("z")
        begin(); other()
        with robot.tracer.root("{kind}"):
            done()
    """
    assert owners(run(source.format(kind="done_callback"))) == [
        "begin",
        "send_next",
        "other",
        "send_next",
    ]
    assert owners(run(source.format(kind="timer"))) == ["begin", "other", "done"]


def test_a_root_of_the_run_is_no_helper_though_two_call_it(run: Run) -> None:
    source = """
        import robot
        def stop(): robot.command("stop"); robot.command("open")
        def first(): robot.command(1); stop()
        def second(): robot.command(2); stop()
        first(); second()
    """
    assert owners(run(source)) == ["first", "second"]
    as_root = source + "    with robot.tracer.root('service'):\n            stop()\n"
    assert owners(run(as_root)) == ["first", "stop", "second", "stop"]


def test_dead_code_decides_nothing(run: Run) -> None:
    dead = FIVE_STEPS.replace(
        "    def main():",
        "    def dead():\n        init(); pick(); pick_position(); place(); place_position()\n"
        "    def main():",
    )
    assert dead != FIVE_STEPS
    assert owners(run(dead)) == owners(run(FIVE_STEPS))


def test_a_person_overrules_by_name(run: Run) -> None:
    ran = run(FIVE_STEPS)
    assert owners(ran, helpers=["place"])[:6] == [
        "init",
        "pick_position",
        "pick",
        "place_position",
        "main",
        "pick_position",
    ]
    assert owners(ran, states=["go_to"])[:3] == ["go_to", "init", "go_to"]
    assert owners(ran, states=["main"], helpers=["init", *CYCLE]) == ["main"]
    assert owners(ran, helpers=["<module>"]) == ["<module>"]


def test_a_state_named_below_a_helper_owns_what_it_does(run: Run) -> None:
    assert owners(run(FIVE_STEPS), states=["plan"])[:2] == ["plan", "init"]


def test_a_name_in_both_lists_is_an_error() -> None:
    with pytest.raises(InputError, match=r"go: named in both `states` and `helpers`"):
        helper_rule([], states=["go", "a"], helpers=["go", "b"])


def test_rules_look_at_the_set_of_stacks_only() -> None:
    """Repeating commands, or renaming activations and functions in order, changes nothing."""
    chance = random.Random(7)
    refs = [FunctionRef("c.py", QualifiedName(f"f{k}")) for k in range(6)]
    for _ in range(200):
        stacks = [
            tuple(
                Frame(ref, 1, chance.randrange(99), (chance.randrange(3), 1), root)
                for ref, root in zip(
                    chance.choices(refs, k=chance.randint(1, 5)),
                    ["main", *[None] * 4],
                    strict=False,
                )
            )
            for _ in range(8)
        ]
        rule = helper_rule(stacks)
        assert rule == helper_rule([*stacks, *chance.sample(stacks, k=5)])
        for stack in stacks:
            place = rule.owner_position(stack)
            assert all(frame.function not in rule.helpers for frame in stack[1 : place + 1])
            assert (
                place == len(stack) - 1
                or stack[place + 1].function in rule.helpers
                or (place == 0 and stack[0].function in rule.helpers)
            )
