"""Gazebo on the graph: its models can be spawned, deleted, read, moved and welded.

Source of names and answers: ros-simulation/gazebo_ros_pkgs (gazebo_ros_api_plugin of ROS 1,
gazebo_ros_factory and gazebo_ros_state of ROS 2), pal-robotics/gazebo_ros_link_attacher,
IFRA-Cranfield/IFRA_LinkAttacher.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from tracerisk.ros.gazebo.world import GazeboWorld, ModelRefusedError
from tracerisk.ros.graph.graph import Change, Publication
from tracerisk.ros.moveit.path_constraints import message_pose
from tracerisk.ros.robot.commands import TwinCommands
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.transforms.poses import compose, inverse
from tracerisk.twin.physics.motion import Pose

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

_NODE = "/gazebo"
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


class GazeboServices:
    """Answers as Gazebo would of the twin's world; what the twin lacks is refused and reported."""

    def __init__(self, runtime: Runtime, messages: TwinMessages, commands: TwinCommands) -> None:
        self._graph, self._scheduler = runtime.graph, runtime.scheduler
        self._messages = messages
        self._commands = commands
        self._world = GazeboWorld(runtime)
        self._ticking: set[str] = set()
        self._subscribed: set[str] = set()
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
            *((name, kind, self._refuser(kind)) for name, kind in _NOT_SIMULATED.items()),
        ):
            self._offer(name, f"{_PACKAGE}/{kind}", handle)
        for name in _EMPTY:
            self._offer(name, "std_srvs/Empty", self._empty(name))
        attacher = "gazebo_ros_link_attacher/Attach"
        self._offer("attach", attacher, lambda asked: self._weld(asked, attacher, True))
        self._offer("detach", attacher, lambda asked: self._weld(asked, attacher, False))
        self._offer("ATTACHLINK", "linkattacher_msgs/AttachLink", self._attach_link)
        self._offer("DETACHLINK", "linkattacher_msgs/DetachLink", self._detach_link)
        self._graph.watch(self._on_change)

    def _offer(self, name: str, kind: str, handle: Callable[[Any], Any]) -> None:
        if self._messages.has_service(kind):
            self._graph.offer(name, kind, handle, node=_NODE)

    # Topics

    def _on_change(self, change: Change, name: str, type_name: str) -> None:
        if (
            change == "subscribed"
            and type_name == f"{_PACKAGE}/ModelStates"
            and name not in self._ticking
        ):
            self._ticking.add(name)
            publication = self._graph.advertise(name, type_name, node=_NODE)
            self._schedule(publication)
        elif (
            change == "advertised"
            and type_name == f"{_PACKAGE}/ModelState"
            and name not in self._subscribed
        ):
            self._subscribed.add(name)
            self._graph.subscribe(name, type_name, self._moved, node=_NODE, by_controller=False)

    def _moved(self, message: Any, publication: Publication) -> None:
        try:
            self._world.move(
                message.model_name, message_pose(message.pose), message.reference_frame
            )
        except ModelRefusedError as refusal:
            self._report(f"a message on {publication.topic} moved no model: {refusal}")

    def _schedule(self, publication: Publication) -> None:
        period_ns = round(1e9 / _HZ)
        due_ns = (self._scheduler.now_ns // period_ns + 1) * period_ns
        self._scheduler.call_at(due_ns, lambda: self._publish(publication), background=True)

    def _publish(self, publication: Publication) -> None:
        if not publication.subscriptions:
            self._ticking.discard(publication.topic)
            publication.close()
            return
        message = self._messages.new(f"{_PACKAGE}/ModelStates")
        names = self._world.names
        message.name = list(names)
        message.pose = [self._pose(self._world.pose(name)) for name in names]
        message.twist = [self._messages.new("geometry_msgs/Twist") for _ in names]
        publication.publish(message)
        self._schedule(publication)

    # Models

    def _spawn(self, request: Any) -> Any:
        is_entity = hasattr(request, "xml")
        name = request.name if is_entity else request.model_name
        text = request.xml if is_entity else request.model_xml
        answer = self._answer("SpawnEntity" if is_entity else "SpawnModel")
        pose, frame = message_pose(request.initial_pose), request.reference_frame
        return self._done(
            answer,
            f"SpawnModel of '{name}'",
            lambda: self._world.spawn(name, text, pose, frame),
            "SpawnModel: Successfully spawned entity",
        )

    def _delete(self, request: Any) -> Any:
        is_model = hasattr(request, "model_name")
        name = request.model_name if is_model else request.name
        return self._done(
            self._answer("DeleteModel" if is_model else "DeleteEntity"),
            f"DeleteModel of '{name}'",
            lambda: self._world.delete(name),
            "DeleteModel: successfully deleted model",
        )

    def _set_model_state(self, request: Any) -> Any:
        state = request.model_state
        return self._move(self._answer("SetModelState"), state.model_name, state)

    def _set_entity_state(self, request: Any) -> Any:
        return self._move(self._answer("SetEntityState"), request.state.name, request.state)

    def _move(self, answer: Any, name: str, state: Any) -> Any:
        return self._done(
            answer,
            f"SetModelState of '{name}'",
            lambda: self._world.move(name, message_pose(state.pose), state.reference_frame),
            "SetModelState: set model state done",
        )

    def _get_model_state(self, request: Any) -> Any:
        answer = self._answer("GetModelState")

        def read() -> None:
            pose = self._relative(request.model_name, request.relative_entity_name)
            answer.pose = self._pose(pose)
            answer.header.frame_id = request.relative_entity_name or "world"
            self._messages.stamp(answer.header, self._scheduler.now_ns)

        self._scheduler.touch()
        request_text = f"GetModelState of '{request.model_name}'"
        return self._done(answer, request_text, read, "GetModelState: got properties")

    def _get_entity_state(self, request: Any) -> Any:
        answer = self._answer("GetEntityState")

        def read() -> None:
            answer.state.pose = self._pose(self._relative(request.name, request.reference_frame))
            answer.state.name = request.name
            answer.state.reference_frame = request.reference_frame or "world"
            self._messages.stamp(answer.header, self._scheduler.now_ns)

        self._scheduler.touch()
        return self._done(answer, f"GetEntityState of '{request.name}'", read, "")

    def _get_link_state(self, request: Any) -> Any:
        answer = self._answer("GetLinkState")

        def read() -> None:
            found = self._world.link_pose(request.link_name)
            if found is None:
                raise ModelRefusedError(f"link '{request.link_name}' is not there")
            frame = self._world.frame(request.reference_frame)
            answer.link_state.link_name = request.link_name
            answer.link_state.pose = self._pose(compose(inverse(frame), found))
            answer.link_state.reference_frame = request.reference_frame

        self._scheduler.touch()
        request_text = f"GetLinkState of '{request.link_name}'"
        return self._done(answer, request_text, read, "GetLinkState: got state")

    def _get_world(self, request: Any) -> Any:
        del request
        answer = self._answer("GetWorldProperties")
        answer.model_names = list(self._world.names)
        answer.sim_time = self._scheduler.now_ns * 1e-9
        answer.rendering_enabled = False
        request_text = "GetWorldProperties"
        return self._done(answer, request_text, lambda: None, f"{request_text}: got properties")

    def _get_list(self, request: Any) -> Any:
        del request
        answer = self._answer("GetModelList")
        answer.model_names = list(self._world.names)
        self._messages.stamp(answer.header, self._scheduler.now_ns)
        answer.success = True
        return answer

    def _get_model_properties(self, request: Any) -> Any:
        answer = self._answer("GetModelProperties")

        def read() -> None:
            self._world.pose(request.model_name)
            if self._world.is_robot(request.model_name):
                robot = self._commands.twin.robot
                answer.body_names = list(robot.link_names)
                answer.joint_names = [joint.name for joint in robot.joints]
                answer.canonical_body_name = robot.base_link
            else:
                answer.body_names, answer.canonical_body_name = ["link"], "link"

        request_text = f"GetModelProperties of '{request.model_name}'"
        return self._done(answer, request_text, read, "GetModelProperties: got properties")

    # Welds

    def _weld(self, request: Any, kind: str, is_on: bool) -> Any:
        answer = self._messages.response(kind)
        answer.ok, _ = self._welded(request, "model_name_{0}", "link_name_{0}", is_on)
        return answer

    def _attach_link(self, request: Any) -> Any:
        return self._weld_link(request, "linkattacher_msgs/AttachLink", True)

    def _detach_link(self, request: Any) -> Any:
        return self._weld_link(request, "linkattacher_msgs/DetachLink", False)

    def _weld_link(self, request: Any, kind: str, is_on: bool) -> Any:
        answer = self._messages.response(kind)
        answer.success, answer.message = self._welded(
            request, "model{0}_name", "link{0}_name", is_on
        )
        return answer

    def _welded(self, request: Any, model: str, link: str, is_on: bool) -> tuple[bool, str]:
        one, one_link, two, two_link = (
            getattr(request, each.format(i)) for i in (1, 2) for each in (model, link)
        )
        change = self._world.attach if is_on else self._world.detach
        request_text = f"{'attach' if is_on else 'detach'} of '{one}' and '{two}'"
        try:
            change((one, one_link, two, two_link))
        except ModelRefusedError as refusal:
            self._report(f"{request_text} was refused: {refusal}")
            return False, str(refusal)
        return True, f"{request_text}: done"

    # How

    def _done(self, answer: Any, request_text: str, act: Callable[[], None], message: str) -> Any:
        try:
            act()
        except ModelRefusedError as refusal:
            self._report(f"{request_text} was refused: {refusal}")
            answer.success, message = False, f"{request_text.split(' ')[0]}: {refusal}"
        else:
            answer.success = True
        if hasattr(answer, "status_message"):
            answer.status_message = message
        return answer

    def _refuser(self, kind: str) -> Callable[[Any], Any]:
        def refuse(request: Any) -> Any:
            del request

            def fail() -> None:
                raise ModelRefusedError("it is not simulated; command the robot's own driver")

            return self._done(self._answer(kind), kind, fail, "")

        return refuse

    def _empty(self, name: str) -> Callable[[Any], Any]:
        def answer(request: Any) -> Any:
            del request
            if name != "unpause_physics":
                self._report(
                    f"{name} changed nothing: the twin's time goes on with the controller's"
                )
            return self._messages.response("std_srvs/Empty")

        return answer

    def _relative(self, name: str, frame: str) -> Pose:
        return compose(inverse(self._world.frame(frame)), self._world.pose(name))

    def _pose(self, pose: Pose) -> Any:
        message = self._messages.new("geometry_msgs/Pose")
        place, turn = message.position, message.orientation
        place.x, place.y, place.z = pose.position
        turn.x, turn.y, turn.z, turn.w = pose.orientation
        return message

    def _answer(self, kind: str) -> Any:
        return self._messages.response(f"{_PACKAGE}/{kind}")

    def _report(self, message: str) -> None:
        self._commands.report("simulator", message)
