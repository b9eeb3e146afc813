"""Functions of nodes of every kind: what was recorded has the names that the source reader gives."""

from pathlib import Path

import pytest

from tracerisk.adder.sources.c_source import parse_c
from tracerisk.adder.sources.lines_of_functions import functions_at
from tracerisk.pipeline.run.live.compiled import CompiledCalls

pytest.importorskip("tree_sitter_cpp")
SOURCES = Path(__file__).with_name("sources")
NODES = {path.stem: [path] for path in sorted(SOURCES.glob("*.c*")) if path.stem != "gripper"}
NODES["two_files"].append(SOURCES / "gripper.cpp")
IMPLICIT = {"Pick::~Pick", "at_file_scope"}
"""What has no body of its own: a destructor of the compiler's, a lambda outside all functions."""
WITHOUT_LINES = {"Stage::run"}
"""What g++ inlines into a thunk to a virtual base, of which it writes no lines."""
WITHOUT_COMMAND = {"wait_for"}
"""Functions that no run of a node enters."""


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("name", NODES)
@pytest.mark.parametrize(
    ("compiler", "flags"),
    [("g++", ["-O2"]), ("clang++", ["-O0"])],
)
def test_each_function_is_recorded_by_its_name_in_the_source(nodes, name, compiler, flags):
    sources = NODES[name]
    if sources[0].suffix == ".c":
        compiler = {"g++": "gcc", "clang++": "clang"}[compiler]
    else:
        flags = [*flags, "-std=c++17"]
    flags = [*flags, "-g", "-fno-optimize-sibling-calls", "-I", str(SOURCES)]
    program = nodes.compile(*flags, source=sources, compiler=compiler, name=name)
    done = nodes.run(program)
    assert done.returncode == 0, done.stderr
    log = nodes.log(functions_at)
    assert log.notes == ()
    files = [*sources, *SOURCES.glob("gripper.h")] if len(sources) > 1 else sources
    read = {str(path): parse_c(path.read_bytes(), str(path)) for path in files}
    recorded = {
        (frame.file, frame.line, frame.function) for call in log.calls for frame in call.stack
    }
    for file, line, function in recorded:
        source = read[file]
        around = [
            each.name
            for each in source.functions
            if each.line <= line <= source.line_of(each.end - 1)
        ]
        assert not around or function == around[-1], f"{file}:{line}"
    expected = {
        (file, function.name)
        for file, source in read.items()
        for function in source.functions
        if function.name not in WITHOUT_COMMAND | WITHOUT_LINES
    }
    assert {(file, function) for file, _, function in recorded} >= expected


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("name", NODES)
def test_names_of_symbols_alone_are_those_of_the_source(nodes, name, monkeypatch):
    """Without lines, and without binutils."""
    sources = NODES[name]
    compiler = "gcc" if sources[0].suffix == ".c" else "g++"
    flags = ["-O0", "-I", str(SOURCES), *(["-std=c++17"] if compiler == "g++" else [])]
    program = nodes.compile(*flags, source=sources, compiler=compiler, name=name)
    nodes.run(program)
    monkeypatch.setenv("PATH", str(nodes.folder))
    recorded = {frame.function for call in nodes.log().calls for frame in call.stack}
    files = [*sources, *SOURCES.glob("gripper.h")] if len(sources) > 1 else sources
    expected = {
        function.name
        for path in files
        for function in parse_c(path.read_bytes(), str(path)).functions
    }
    assert recorded - IMPLICIT == expected - WITHOUT_COMMAND


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("name", ["inheritance", "lambdas", "two_files"])
def test_a_live_run_gives_inlined_functions_their_names_in_the_source(nodes, name):
    flags = ["-O2", "-g", "-std=c++17", "-fno-optimize-sibling-calls", "-I", str(SOURCES)]
    nodes.run(nodes.compile(*flags, source=NODES[name], name=name))
    calls = nodes.log(functions_at).calls
    met = set()
    compiled = CompiledCalls(
        nodes.folder / "calls.jsonl",
        SOURCES,
        f"{name}.cpp",
        lambda function, _line: met.add(function.name),
        lambda _file, _source: None,
    )
    for call in calls:
        compiled.stack(f"{call.name}/goal" if call.kind == "goal" else call.name, None)
    assert met == {frame.function for call in calls for frame in call.stack} - IMPLICIT
