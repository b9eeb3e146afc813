from tracerisk.adder.blocks.block import RiskBlock
from tracerisk.adder.blocks.values import computed_count, computed_next
from tracerisk.adder.sources.insert import insert_blocks
from tracerisk.adder.sources.line_map import line_map

SOURCE = b"""\
import os


def pick():
    return 1


def place():
    return 2
"""


def block(name: str, following: dict[str, int]) -> RiskBlock:
    return RiskBlock(name, computed_count(1), computed_next(following), ())


def test_every_line_of_the_code_is_found_again():
    after = insert_blocks(
        SOURCE, {"pick": block("pick", {"place": 1}), "place": block("place", {"done": 1})}, "a.py"
    )
    moved = line_map(SOURCE, after, "a.py")
    old, new = SOURCE.splitlines(), after.splitlines()
    assert [new[moved(n) - 1] for n in range(1, len(old) + 1)] == old
    assert moved(4) == 4
    assert moved(5) > 5
    back = line_map(after, SOURCE, "a.py")
    assert [back(moved(n)) for n in range(1, len(old) + 1)] == list(range(1, len(old) + 1))


def test_nothing_moves_where_the_blocks_keep_their_lines():
    one = insert_blocks(SOURCE, {"pick": block("pick", {"pick": 1, "done": 1})}, "a.py")
    other = insert_blocks(SOURCE, {"pick": block("pick", {"pick": 3, "done": 1})}, "a.py")
    moved = line_map(one, other, "a.py")
    assert [moved(n) for n in (1, 4, 20)] == [1, 4, 20]


def test_a_block_that_names_another_function_moves_lines_all_the_same() -> None:
    block = "    # | RiskAnnotation\n    # | @Function {\n    # |   name = {}\n    # |   callSequence = 1\n    # | }\n"
    text = "def stretch():\n{}    arm.go()\n"
    after = text.replace("{}", block.replace("{}", "reach")).encode()
    assert line_map(text.replace("{}", "").encode(), after, "c.py")(2) == 7
