"""A change of a header makes blocks stale, so a run depends on those of its own."""

from tracerisk.pipeline.trace.compiled.includes import included_files


def test_headers_below_the_root_are_found_as_builds_find_them(tmp_path):
    for name, text in {
        "src/beside.h": '#include "deep/er.hpp"\n',
        "src/deep/er.hpp": '#include "../beside.h"\n',
        "include/cell/arm.h": "#include <ros/ros.h>\n",
        "include/cell/unused.h": "",
    }.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    (tmp_path.parent / "outside.h").touch()
    source = b'#include "beside.h"\n  # include <cell/arm.h>\n#include "../../outside.h"\n'
    files = included_files({"src/pick.cpp": source}, tmp_path)
    assert files == ("include/cell/arm.h", "src/beside.h", "src/deep/er.hpp")
