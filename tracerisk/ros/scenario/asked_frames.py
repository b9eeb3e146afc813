"""The frames that a script looks up by name, where it lacks one of them: a scenario gives all."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from tracerisk.ros.controller.needs import Missed
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.robot.frames import TF, TF_STATIC


def further_frames(
    lacking: Iterable[Missed], asked: Iterable[Missed], runtime: Runtime
) -> Iterator[Missed]:
    """Yield the frames in `asked` that nothing gives, where one is `lacking`.

    A controller that sends frames may send those itself, later.
    """
    if runtime.twin is None or not any(missed.need.kind == "frame" for missed in lacking):
        return
    ends = [end for topic in (TF, TF_STATIC) for end in runtime.graph.publications(topic)]
    if any(end.by_controller for end in ends):
        return
    given = {
        transform.child_frame_id.strip("/")
        for end in ends
        for transform in getattr(end.latched, "transforms", ())
    }
    given.update(runtime.twin.robot.link_names)
    for missed in asked:
        need = missed.need
        is_name = need.kind == "frame" and not need.name.startswith("(")
        if is_name and need.name.strip("/") not in given:
            yield missed
