"""What an action of move_group does with a goal or a cancel request while a goal goes on."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Literal

from tracerisk.ros.controller.needs import asking_place
from tracerisk.ros.robot.commands import TwinCommands

if TYPE_CHECKING:
    from tracerisk.ros.graph.action_goal import ActionGoal
    from tracerisk.ros.graph.runtime import Runtime

ENDS, WAITS = "ends the one before", "waits for its end"
"""Two of the words by which the table of distributions says what a new goal does."""
STOPS = "stops the motion"
"""What a request to cancel does there, where it does not wait."""


class GoalTurns:
    """The goals of one action, in the order of their sending.

    Its rules are `<action>-goal` and `<action>-cancel` of the table of distributions. Where a new
    goal ends the one before, that is left to the execution of trajectories. `begin` begins a goal,
    `stop` stops what one moves.
    """

    def __init__(
        self,
        runtime: Runtime,
        action: Literal["move-action", "execute-trajectory"],
        begin: Callable[[ActionGoal], None],
        stop: Callable[[ActionGoal], None],
    ) -> None:
        self._runtime = runtime
        self._scheduler = runtime.scheduler
        self._action = action
        self._begin, self._stop = begin, stop
        self._goals: list[ActionGoal] = []

    @property
    def preempts(self) -> bool:
        """Whether a new goal ends the one before."""
        return self._runtime.distro.value(f"{self._action}-goal") == ENDS

    def take(self, goal: ActionGoal) -> None:
        """Begin a goal, or let it wait for its turn, unanswered."""
        rule = f"{self._action}-goal"
        self._goals.append(goal)
        if len(self._goals) > 1:
            self._runtime.distro.decided(rule, asking_place())
            if self._runtime.distro.value(rule) == WAITS:
                # On the stack of the code that sent the goal, whose thread goes on.
                self._scheduler.spawn(
                    lambda: self._begin_in_turn(goal),
                    f"goal of {goal.client.name}",
                    is_controllers=False,
                )
                return
        self._begin(goal)

    def cancel(self, goal: ActionGoal) -> None:
        """Take a request to cancel a goal, which ends with its motion; or leave it unread.

        A server that executes a goal in the callback that accepts it reads no request meanwhile.
        """
        rule = f"{self._action}-cancel"
        self._runtime.distro.decided(rule, asking_place())
        if self._runtime.distro.value(rule) == STOPS:
            goal.accept_cancel()
            self._stop(goal)
            return
        goal.is_cancel_unread = True
        self._runtime.client(TwinCommands).report(
            "command_ignored",
            f"a request to cancel a goal of {goal.client.name} stops nothing: MoveIt 2 reads it "
            "when the motion has ended; publish 'stop' on /trajectory_execution_event",
            object_name=goal.client.name,
        )

    def over(self, goal: ActionGoal) -> None:
        """Note that a goal has ended: the next one begins."""
        if goal in self._goals:
            self._goals.remove(goal)

    def _begin_in_turn(self, goal: ActionGoal) -> None:
        self._scheduler.wait_until(
            lambda: self._goals[0] is goal, reason=f"the turn of a goal of {goal.client.name}"
        )
        self._begin(goal)
