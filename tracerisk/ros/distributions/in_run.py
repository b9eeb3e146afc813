"""The distribution of ROS that a run follows, and which of its rules decided something."""

from __future__ import annotations

from collections.abc import Callable

from tracerisk.config import RosDistro
from tracerisk.errors import Location
from tracerisk.ros.distributions.rules import RULE_OF, RuleValue

_TITLES: dict[RosDistro, str] = {
    "noetic": "ROS 1 Noetic",
    "humble": "ROS 2 Humble",
    "jazzy": "ROS 2 Jazzy",
}


class DistroRules:
    """The rules of the distribution that a run follows.

    `name` is that distribution. `report` gets the words, the place and the rule where a rule
    decided something that another distribution would have decided otherwise; it is `None` where
    nothing is assumed, so that nobody has to know. `precedes_noetic` says that the program is for
    an older ROS 1, for which Noetic stands, `follows_jazzy` that it is for a ROS 2 after Jazzy.
    """

    def __init__(
        self,
        name: RosDistro = "jazzy",
        report: Callable[[str, Location | None, str], None] | None = None,
        *,
        precedes_noetic: bool = False,
        follows_jazzy: bool = False,
    ) -> None:
        self.name = name
        self.precedes_noetic = precedes_noetic
        self.follows_jazzy = follows_jazzy
        self._report = report
        self._reported: set[tuple[str, Location | None]] = set()

    @property
    def is_ros2(self) -> bool:
        """Whether the distribution is one of ROS 2."""
        return self.name != "noetic"

    @property
    def is_assumed(self) -> bool:
        """Whether nothing says that the run follows this distribution."""
        return self._report is not None

    def value(self, rule: str) -> RuleValue:
        """Return what the distribution does by a rule of the table.

        Raises:
            KeyError: the table has no such rule.
        """
        return RULE_OF[rule].of(self.name)

    def decided(self, rule: str, location: Location | None = None) -> None:
        """Note that a rule decided what happened at a line of the controller.

        Call it where the outcome would be another under the other distribution, not where the rule
        is merely read.
        """
        result = RULE_OF[rule]
        if self._report is None or not result.differs or self.name == "noetic":
            return
        if (rule, location) in self._reported:
            return
        self._reported.add((rule, location))
        other: RosDistro = "humble" if self.name == "jazzy" else "jazzy"
        self._report(
            f"{result.subject}: {in_words(result.of(self.name))} in {_TITLES[self.name]}, which is "
            f"assumed, and {in_words(result.of(other))} in {_TITLES[other]}; set ros_distro in "
            "[tool.tracerisk]",
            location,
            rule,
        )


def in_words(value: RuleValue) -> str:
    """Return what a distribution does, as people read it."""
    if value is None:
        return "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:g}" if isinstance(value, float) else str(value)
