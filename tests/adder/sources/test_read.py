import pytest

from tracerisk.adder.sources.read import read_blocks
from tracerisk.errors import BlockError, SourceError


def block(name: str, indent: str = "    ", newline: str = "\n") -> str:
    lines = ("RiskAnnotation", "@Function {", f"  name = {name}", "  callSequence = 1", "}")
    return "".join(f"{indent}# | {line}{newline}" for line in lines)


READABLE = {
    "a function": (f"def f():\n{block('f')}    pass\n", [("f", 1, "body", 2, 6)]),
    "a signature over lines": (
        f"def f(\n    a,  # | RiskAnnotation\n    b='''\n# | RiskAnnotation\n''',\n):\n"
        f"{block('f')}    pass\n",
        [("f", 1, "body", 7, 11)],
    ),
    "a decorated method": (
        f"class A:\n    @property\n    def f(self):\n{block('A.f', '        ')}        return 1\n",
        [("A.f", 3, "body", 4, 8)],
    ),
    "an async nested function": (
        f"def f():\n    async def g():\n{block('f.<locals>.g', '        ')}        pass\n",
        [("f.<locals>.g", 2, "body", 3, 7)],
    ),
    "a conditional definition": (
        f"try:\n    pass\nexcept E:\n    def f():\n{block('f')}        pass\n",
        [("f", 4, "body", 5, 9)],
    ),
    "a one-line function": (f"{block('f', '')}def f(): pass\n", [("f", 6, "above", 1, 5)]),
    "blank lines below a block above a function": (
        f"import os\n\n{block('f', '')}\n\ndef f(): pass\n",
        [("f", 10, "above", 3, 7)],
    ),
    "a comment below a block above a function": (
        f"import os\n{block('f', '')}\n# a word\n\ndef f(): pass\n",
        [("f", 10, "above", 2, 6)],
    ),
    "decorators below a block above a function": (
        f"import os\n{block('f', '')}\n@a(\n    1\n)\n# b\n\n@c\ndef f(): pass\n",
        [("f", 14, "above", 2, 6)],
    ),
    "a block between decorators and blank lines": (
        f"import os\n@a\n{block('f', '')}\n\n@b\n\ndef f(): pass\n",
        [("f", 12, "above", 3, 7)],
    ),
    "blank lines below blocks in the body of a class": (
        f"class A:\n    x = 1\n{block('A.f')}\n    def f(self): pass\n{block('A.g')}\n\n"
        "    # a word\n    async def g(self): pass\n",
        [("A.f", 9, "above", 3, 7), ("A.g", 18, "above", 10, 14)],
    ),
    "a block whose function a formatter has spread over lines": (
        f"import os\n{block('f', '')}\n\ndef f():\n    pass\n",
        [("f", 9, "above", 2, 6)],
    ),
    "blank lines below the block of a function that begins with another": (
        f"def f():\n{block('f')}\n    def g(): pass\n",
        [("f", 1, "body", 2, 6)],
    ),
    "a string before a function": (
        f'x = """\n{block("f", "")}# | """\n\n\ndef f(): pass\n',
        [],
    ),
    "a function and the one-line function it begins with": (
        f"def f():\n{block('f')}{block('f.<locals>.g')}    def g(): pass\n",
        [("f", 1, "body", 2, 6), ("f.<locals>.g", 12, "above", 7, 11)],
    ),
    "a script": (f"#!x\n{block('<module>', '')}a = 1\n", [("<module>", 7, "module", 2, 6)]),
    "a script with a docstring": (
        f"'''d'''\n{block('<module>', '')}a = 1\n",
        [("<module>", 1, "module", 2, 6)],
    ),
    "a name that Python normalises": (
        f"def ﬁ():\n{block('ﬁ')}    pass\n",
        [("fi", 1, "body", 2, 6)],
    ),
    "carriage returns": (
        f"def f():\r{block('f', newline=chr(13))}    pass\r",
        [("f", 1, "body", 2, 6)],
    ),
    "a comment of someone else with a gutter": (
        "def f():\n    # | a | b |\n    # | 1 | 2 |\n    pass\n",
        [],
    ),
    "block text in a docstring": (f"def f():\n    '''\n{block('f')}    '''\n", []),
    "block text in a string of the module": (f"x = '''\n{block('f', '')}'''\ndef f(): pass\n", []),
    "a bad block in a string": ("x = '''\n# | RiskAnnotation\n# | what\n'''\n", []),
}


@pytest.mark.parametrize("case", sorted(READABLE))
def test_blocks_are_found_at_their_functions(case: str) -> None:
    source, expected = READABLE[case]
    found = [
        (b.function, b.line, b.place, b.first_line, b.last_line)
        for b in read_blocks(source.encode(), "c.py")
    ]
    assert found == expected


def test_values_know_their_line_in_the_file() -> None:
    (placed,) = read_blocks(f"def f():\n{block('f')}    pass\n".encode(), "c.py")
    assert str(placed.block.call_sequence.location) == "c.py:5"


def test_a_block_is_read_in_the_encoding_of_the_file() -> None:
    source = f"# coding: latin-1\ndef größe():\n{block('größe')}    pass\n"
    (placed,) = read_blocks(source.encode("latin-1"), "c.py")
    assert placed.function == "größe"


def test_a_file_without_blocks_is_not_even_parsed() -> None:
    assert read_blocks(b"this is not Python", "c.py") == ()


REFUSED = {
    "another function's name": (
        f"def f():\n{block('g')}    pass\n",
        BlockError,
        "c.py:2: the risk block of `g` stands at `f`; write `name = f`, there and in what leads to `g`",
    ),
    "a block after the first statement": (
        f"def f():\n    pass\n{block('f')}",
        BlockError,
        "c.py:3: a risk block stands where no function begins; allowed: the first lines",
    ),
    "a block after the docstring": (
        f"def f():\n    'doc'\n{block('f')}    pass\n",
        BlockError,
        "c.py:3: a risk block stands where no function begins",
    ),
    "a block whose function is gone": (
        f"import os\n{block('f', '')}\n\ndef g():\n    pass\n",
        BlockError,
        "c.py:2: a risk block stands where no function begins",
    ),
    "a block apart from its function": (
        f"import os\n{block('f', '')}\nx = 1\ndef f(): pass\n",
        BlockError,
        "c.py:2: a risk block stands where no function begins",
    ),
    "a comment between two parts": (
        f"def f():\n{block('f')}    # a word\n    # | @Component {{\n    # | }}\n    pass\n",
        BlockError,
        "c.py:8: `# | @Component {` is outside a risk block; a block begins with",
    ),
    "two blocks in one function": (
        f"def f():\n{block('f')}{block('f')}    pass\n",
        BlockError,
        "c.py:7: f has two risk blocks, the first at line 2; delete one",
    ),
    "two definitions with a block each": (
        f"if a:\n    def f():\n{block('f')}        pass\nelse:\n    def f():\n{block('f')}"
        "        pass\n",
        BlockError,
        "c.py:11: f has two risk blocks, the first at line 3; delete one",
    ),
    "conflict markers in a block": (
        "def f():\n    # | RiskAnnotation\n<<<<<<< HEAD\n    # | @Function {\n=======\n"
        ">>>>>>> theirs\n    pass\n",
        BlockError,
        "c.py:3: `<<<<<<< HEAD` is a conflict marker; resolve the merge",
    ),
    "no Python": (
        f"def f(:\n{block('f')}    pass\n",
        SourceError,
        "c.py:1:7: cannot be read as Python: invalid syntax",
    ),
    "a null byte": (
        f"def f():\n{block('f')}    pass\0\n",
        SourceError,
        "c.py: cannot be read as Python: source code string cannot contain null bytes",
    ),
}


@pytest.mark.parametrize("case", sorted(REFUSED))
def test_what_cannot_be_read_is_an_error_with_file_and_line(case: str) -> None:
    source, error, message = REFUSED[case]
    with pytest.raises(error) as caught:
        read_blocks(source.encode(), "c.py")
    assert str(caught.value).startswith(message)
