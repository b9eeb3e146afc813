"""Gazebo on the graph: its models can be spawned, deleted, read, moved and welded.

Source of names and answers: ros-simulation/gazebo_ros_pkgs (gazebo_ros_api_plugin of ROS 1,
gazebo_ros_factory and gazebo_ros_state of ROS 2), pal-robotics/gazebo_ros_link_attacher,
IFRA-Cranfield/IFRA_LinkAttacher.
"""

# ruff: noqa: ARG002 - every handler takes a request and an answer
from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any

from tracerisk.ros.controller.needs import Need
from tracerisk.ros.gazebo.world import GazeboWorld, ModelRefusedError
from tracerisk.ros.graph.graph import Change
from tracerisk.ros.graph.topic_ends import Publication
from tracerisk.ros.moveit.messages import set_pose
from tracerisk.ros.moveit.path_constraints import message_pose
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.twin_node import TwinNode
from tracerisk.ros.transforms.poses import compose, inverse
from tracerisk.twin.physics.motion import Pose

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

_PACKAGE = "gazebo_msgs"
_HZ = 50.0
# What changes physics past the drivers of a robot, by its base name.
_NOT_SIMULATED = {
    "set_model_configuration": "SetModelConfiguration",
    "set_joint_properties": "SetJointProperties",
    "set_link_properties": "SetLinkProperties",
    "set_physics_properties": "SetPhysicsProperties",
    "apply_body_wrench": "ApplyBodyWrench",
    "apply_link_wrench": "ApplyLinkWrench",
    "apply_joint_effort": "ApplyJointEffort",
}
_EMPTY = ("pause_physics", "unpause_physics", "reset_world", "reset_simulation")


class GazeboServices(TwinNode):
    """Answers as Gazebo would of the twin's world; what the twin lacks is refused and reported."""

    node = "/gazebo"

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        self._world = GazeboWorld(runtime)
        self._attached: set[tuple[str, str, str, str]] = set()
        for name, kind, handle in (
            ("spawn_sdf_model", "SpawnModel", self._spawn),
            ("spawn_urdf_model", "SpawnModel", self._spawn),
            ("spawn_entity", "SpawnEntity", self._spawn),
            ("delete_model", "DeleteModel", self._delete),
            ("delete_entity", "DeleteEntity", self._delete),
            ("get_model_state", "GetModelState", self._get_model_state),
            ("set_model_state", "SetModelState", self._set_model_state),
            ("get_entity_state", "GetEntityState", self._get_entity_state),
            ("set_entity_state", "SetEntityState", self._set_entity_state),
            ("get_link_state", "GetLinkState", self._get_link_state),
            ("get_world_properties", "GetWorldProperties", self._get_world),
            ("get_model_list", "GetModelList", self._get_list),
            ("get_model_properties", "GetModelProperties", self._get_model_properties),
        ):
            self._offer(name, f"{_PACKAGE}/{kind}", handle)
        for name, kind in _NOT_SIMULATED.items():
            self._offer(name, f"{_PACKAGE}/{kind}", partial(self._refuse, kind))
        for name in _EMPTY:
            self._offer(name, "std_srvs/Empty", partial(self._empty, name))
        for is_on, name in ((True, "attach"), (False, "detach")):
            self._offer(name, "gazebo_ros_link_attacher/Attach", partial(self._weld, is_on))
            kind = f"linkattacher_msgs/{name.capitalize()}Link"
            self._offer(f"{name.upper()}LINK", kind, partial(self._weld_link, is_on))
        self._graph.watch(self._on_change)

    # Topics

    def _on_change(self, change: Change, name: str, type_name: str) -> None:
        if change == "subscribed" and type_name == f"{_PACKAGE}/ModelStates":
            self._report_on(name, type_name, _HZ, self._model_states)
        elif change == "subscribed" and type_name == f"{_PACKAGE}/LinkStates":
            self._report_on(name, type_name, _HZ, self._link_states)
        elif change == "advertised" and type_name == f"{_PACKAGE}/ModelState":
            self._hear(name, type_name, self._moved)

    def _moved(self, message: Any, publication: Publication) -> None:
        try:
            self._world.move(
                message.model_name, message_pose(message.pose), message.reference_frame
            )
        except ModelRefusedError as refusal:
            self._report(f"a message on {publication.topic} moved no model: {refusal}")

    def _model_states(self, message: Any, topic: str) -> Any:
        return self._states(message, {name: self._world.pose(name) for name in self._world.names})

    def _link_states(self, message: Any, topic: str) -> Any:
        return self._states(message, self._world.link_poses())

    def _states(self, message: Any, poses: Mapping[str, Pose]) -> Any:
        message.name = list(poses)
        message.pose = [self._pose(pose) for pose in poses.values()]
        message.twist = [self._messages.new("geometry_msgs/Twist") for _ in poses]
        return message

    # Models

    def _spawn(self, request: Any, answer: Any) -> None:
        is_entity = hasattr(request, "xml")
        name = request.name if is_entity else request.model_name
        text = request.xml if is_entity else request.model_xml
        pose, frame = message_pose(request.initial_pose), request.reference_frame
        done = "SpawnModel: Successfully spawned entity"
        with self._doing(answer, f"SpawnModel of '{name}'", done):
            self._world.spawn(name, text, pose, frame)

    def _delete(self, request: Any, answer: Any) -> None:
        is_model = hasattr(request, "model_name")
        name = request.model_name if is_model else request.name
        done = "DeleteModel: successfully deleted model"
        with self._doing(answer, f"DeleteModel of '{name}'", done):
            self._world.delete(name)

    def _set_model_state(self, request: Any, answer: Any) -> None:
        state = request.model_state
        self._move(answer, state.model_name, state)

    def _set_entity_state(self, request: Any, answer: Any) -> None:
        self._move(answer, request.state.name, request.state)

    def _move(self, answer: Any, name: str, state: Any) -> None:
        done = "SetModelState: set model state done"
        with self._doing(answer, f"SetModelState of '{name}'", done):
            self._world.move(name, message_pose(state.pose), state.reference_frame)

    def _get_model_state(self, request: Any, answer: Any) -> None:
        self._scheduler.touch()
        asked = f"GetModelState of '{request.model_name}'"
        with self._doing(answer, asked, "GetModelState: got properties"):
            pose = self._relative(request.model_name, request.relative_entity_name)
            answer.pose = self._pose(pose)
            answer.header.frame_id = request.relative_entity_name or "world"
            self._now(answer.header)

    def _get_entity_state(self, request: Any, answer: Any) -> None:
        self._scheduler.touch()
        with self._doing(answer, f"GetEntityState of '{request.name}'"):
            answer.state.pose = self._pose(self._relative(request.name, request.reference_frame))
            answer.state.name = request.name
            answer.state.reference_frame = request.reference_frame or "world"
            self._now(answer.header)

    def _get_link_state(self, request: Any, answer: Any) -> None:
        self._scheduler.touch()
        asked = f"GetLinkState of '{request.link_name}'"
        with self._doing(answer, asked, "GetLinkState: got state"):
            link_pose = self._world.link_pose(request.link_name)
            if link_pose is None:
                raise ModelRefusedError(f"link '{request.link_name}' is not there")
            frame = self._world.frame(request.reference_frame)
            answer.link_state.link_name = request.link_name
            answer.link_state.pose = self._pose(compose(inverse(frame), link_pose))
            answer.link_state.reference_frame = request.reference_frame

    def _get_world(self, request: Any, answer: Any) -> None:
        answer.model_names = list(self._world.names)
        answer.sim_time = self._scheduler.now_ns * 1e-9
        answer.rendering_enabled = False
        answer.success, answer.status_message = True, "GetWorldProperties: got properties"

    def _get_list(self, request: Any, answer: Any) -> None:
        answer.model_names = list(self._world.names)
        self._now(answer.header)
        answer.success = True

    def _get_model_properties(self, request: Any, answer: Any) -> None:
        asked = f"GetModelProperties of '{request.model_name}'"
        with self._doing(answer, asked, "GetModelProperties: got properties"):
            self._world.pose(request.model_name)
            if self._world.is_robot(request.model_name):
                robot = self._commands.twin.robot
                answer.body_names = list(robot.link_names)
                answer.joint_names = [joint.name for joint in robot.joints]
                answer.canonical_body_name = robot.base_link
            else:
                answer.body_names, answer.canonical_body_name = ["link"], "link"

    # Welds

    def _weld(self, is_on: bool, request: Any, answer: Any) -> None:
        answer.ok, _ = self._welded(request, "model_name_{0}", "link_name_{0}", is_on)

    def _weld_link(self, is_on: bool, request: Any, answer: Any) -> None:
        answer.success, answer.message = self._welded(
            request, "model{0}_name", "link{0}_name", is_on
        )

    def _welded(self, request: Any, model: str, link: str, is_on: bool) -> tuple[bool, str]:
        one, one_link, two, two_link = (
            getattr(request, name.format(i)) for i in (1, 2) for name in (model, link)
        )
        key = (one, one_link, two, two_link)
        change = self._world.attach if is_on else self._world.detach
        held = two if self._world.is_robot(one, one_link) else one
        request_text = f"{'attach' if is_on else 'detach'} of '{one}' and '{two}'"
        try:
            change(key)
        except ModelRefusedError as refusal:
            # To detach once more what was attached before is ordinary clean-up.
            kind = "simulator" if not is_on and key in self._attached else "attach_failure"
            message = f"{request_text} was refused: {refusal}"
            self._commands.report(kind, message, object_name=held, asker=key)
            if is_on and held not in self._world.names:
                # The worlds of Gazebo are not read: a scenario says which models there are.
                needs = self._scheduler.needs
                needs.seek(Need("object", held, "model"), self._scheduler.now_ns)
                needs.note_error(message)
            return False, str(refusal)
        if is_on:
            self._attached.add(key)
            self._commands.succeeded("attach_failure", key, held)
        return True, f"{request_text}: done"

    # How

    @contextmanager
    def _doing(self, answer: Any, request_text: str, message: str = "") -> Iterator[None]:
        """Write into an answer how what is done within the block went."""
        try:
            yield
        except ModelRefusedError as refusal:
            self._report(f"{request_text} was refused: {refusal}")
            answer.success, message = False, f"{request_text.split(' ')[0]}: {refusal}"
        else:
            answer.success = True
        if hasattr(answer, "status_message"):
            answer.status_message = message

    def _refuse(self, kind: str, request: Any, answer: Any) -> None:
        with self._doing(answer, kind):
            raise ModelRefusedError("it is not simulated; command the robot's own driver")

    def _empty(self, name: str, request: Any, answer: Any) -> None:
        if name != "unpause_physics":
            self._report(f"{name} changed nothing: the twin's time goes on with the controller's")

    def _relative(self, name: str, frame: str) -> Pose:
        return compose(inverse(self._world.frame(frame)), self._world.pose(name))

    def _pose(self, pose: Pose) -> Any:
        message = self._messages.new("geometry_msgs/Pose")
        set_pose(message, pose)
        return message

    def _report(self, message: str) -> None:
        self._commands.report("simulator", message)
