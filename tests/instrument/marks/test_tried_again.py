"""Whether a loop makes up for a call in it that failed."""

import ast
import textwrap

import pytest

from tracerisk.instrument.marks.tried_again import is_tried_until_success

MADE_UP = {
    "break in the body": """
        for name in names:
            try:
                arm = connect(name)
                break
            except RuntimeError:
                continue
        """,
    "break in the else": """
        for name in names:
            try:
                arm = connect(name)
            except RuntimeError:
                print(name)
            else:
                with lock:
                    break
        """,
    "break right after": """
        for name in names:
            try:
                arm = connect(name)
            except RuntimeError:
                continue
            break
        """,
    "return of the call": """
        def first(names):
            for name in names:
                with suppress(RuntimeError):
                    return connect(name)
        """,
    "a condition on what it gave": """
        for name in names:
            try:
                arm = connect(name)
            except RuntimeError:
                arm = None
            if arm is None:
                continue
            break
        """,
    "a flag": """
        for name in names:
            try:
                connect(name)
                found = True
            except RuntimeError:
                found = False
            if found:
                break
        """,
    "the end of a while": """
        arm = None
        while arm is None:
            try:
                arm = connect(names.pop())
            except RuntimeError:
                pass
        """,
    "the same again": """
        for _ in range(3):
            try:
                name = "arm"
                connect(name)
            except RuntimeError:
                sleep(1)
        """,
    "the same again for each": """
        def first(names):
            for name in names:
                for _ in range(3):
                    try:
                        return connect(name)
                    except RuntimeError:
                        sleep(1)
        """,
    "all of them again": """
        while True:
            try:
                for name in names:
                    connect(name)
                break
            except RuntimeError:
                sleep(1)
        """,
}
LOST = {
    "a condition on something else": """
        def all_of(names):
            for name in names:
                try:
                    arms.append(connect(name))
                except RuntimeError:
                    continue
                if stopped():
                    return arms
        """,
    "break after success or failure": """
        for name in names:
            try:
                arm = connect(name)
            except RuntimeError:
                pass
            break
        """,
    "break in the handler": """
        for name in names:
            try:
                connect(name)
            except RuntimeError:
                break
        """,
    "break of an inner loop": """
        for name in names:
            try:
                arm = connect(name)
            except RuntimeError:
                continue
            for step in steps:
                break
        """,
    "the next of a loop around": """
        for name in names:
            for _ in range(3):
                try:
                    connect(name)
                    break
                except RuntimeError:
                    sleep(1)
        """,
    "a condition that failure meets": """
        for name in names:
            try:
                arm = connect(name)
            except RuntimeError:
                arm = None
            if arm is None:
                break
        """,
    "another by an index": """
        index = 0
        while index < 2:
            name = names[index]
            index += 1
            with suppress(RuntimeError):
                connect(name)
        """,
    "another from a list": """
        while names:
            try:
                connect(names.pop())
            except RuntimeError:
                pass
        """,
    "another receiver": """
        for arm in arms:
            try:
                arm.connect("home")
            except RuntimeError:
                pass
        """,
    "no loop": """
        try:
            connect("arm")
        except RuntimeError:
            pass
        """,
    "a function in a loop": """
        for name in names:
            def later():
                try:
                    return connect(name)
                except RuntimeError:
                    return None
        """,
}


def judged(source: str) -> bool:
    tree = ast.parse(textwrap.dedent(source))
    (call,) = [
        node
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and ast.unparse(node.func).endswith("connect")
    ]
    return is_tried_until_success(tree, call)


@pytest.mark.parametrize("way", MADE_UP)
def test_a_loop_that_ends_with_success_or_tries_the_same_makes_up_for_failures(way):
    assert judged(MADE_UP[way])


@pytest.mark.parametrize("way", LOST)
def test_a_loop_that_goes_on_to_another_does_not(way):
    assert not judged(LOST[way])
