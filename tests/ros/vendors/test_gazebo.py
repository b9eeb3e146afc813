"""Gazebo's services on the twin: models that are spawned, moved, welded and refused."""

import pytest

from tracerisk.ros.gazebo.models import ModelRefusedError, model_body
from tracerisk.twin.physics.motion import Pose

HERE = Pose((0.5, 0.0, 0.3), (0.0, 0.0, 0.0, 1.0))
CUBE = (
    "<sdf version='1.6'><model name='cube'><link name='link'>"
    "<inertial><mass>0.1</mass></inertial>"
    "<collision name='c'><geometry><box><size>0.05 0.05 0.05</size></box></geometry></collision>"
    "</link></model></sdf>"
)
URDF = (
    "<robot name='can'><link name='a'/><link name='b'><inertial><mass value='0.2'/></inertial>"
    "<collision><origin xyz='0 0 0.1'/><geometry><cylinder radius='0.03' length='0.2'/></geometry>"
    "</collision></link><joint name='j' type='fixed'><parent link='a'/><child link='b'/>"
    "<origin xyz='0 0 0.5'/></joint></robot>"
)


def test_a_box_of_sdf_is_a_free_body_of_its_mass():
    body = model_body("cube", CUBE, HERE)
    assert body.shapes[0].size == (0.025, 0.025, 0.025)
    assert (body.mass, body.is_free) == (0.1, True)


def test_a_static_model_stands_still_and_a_plane_is_the_ground():
    body = model_body("cube", CUBE.replace("<link", "<static>true</static><link", 1), HERE)
    assert not body.is_free
    plane = CUBE.replace("<box><size>0.05 0.05 0.05</size></box>", "<plane/>")
    assert model_body("ground", plane, HERE).half_spaces


def test_links_of_urdf_that_are_fixed_make_one_body():
    body = model_body("can", URDF, HERE)
    assert body.shapes[0].kind == "cylinder"
    assert body.shapes[0].xyz == pytest.approx((0.0, 0.0, 0.6))
    assert body.mass == 0.2


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("<sdf", "the model is not XML: "),
        ("<!DOCTYPE a [<!ENTITY b 'c'>]><sdf/>", "the model is not XML: "),
        ("<light/>", "<light> is neither an SDF model nor a URDF robot"),
        (CUBE.replace("box", "mesh"), "a collision shape is <mesh>; tracerisk spawns bodies of "),
        (CUBE.replace("</link>", "</link><joint/>"), "the model has joints or includes"),
        (URDF.replace("fixed", "revolute"), "the model has joints; a single body can be spawned"),
        ("<robot><link name='a'/></robot>", "the model has no collision shape"),
        (CUBE.replace("0.05 0.05", "0.05"), "size '0.05 0.05' is not 3 finite number(s)"),
        (CUBE.replace("0.05 0.05 0.05", "0 1 1"), "a box has a length that is not above 0"),
        (CUBE.replace("0.05 0.05 0.05", "1e9 1 1"), "a box is 1e+09 m long; at most 1000 m are si"),
    ],
)
def test_what_is_no_body_is_refused(text, expected):
    with pytest.raises(ModelRefusedError) as refusal:
        model_body("cube", text, HERE)
    assert expected in str(refusal.value)


HEAD1 = f'''
import rospy
from gazebo_msgs.srv import *
from geometry_msgs.msg import Pose, Point, Quaternion
rospy.init_node('spawner')
CUBE = """{CUBE}"""
rospy.wait_for_service('/gazebo/spawn_sdf_model')
spawn = rospy.ServiceProxy('/gazebo/spawn_sdf_model', SpawnModel)
state = rospy.ServiceProxy('/gazebo/get_model_state', GetModelState)
def place(x, y, z):
    return Pose(Point(x, y, z), Quaternion(0, 0, 0, 1))
'''


def test_a_spawned_model_falls_is_moved_and_deleted(run_on):
    ran = run_on(
        "wx250s",
        HEAD1
        + """
spawned = spawn('cube', CUBE, '', place(0.5, 0.5, 0.2), 'world')
again = spawn('cube', CUBE, '', place(0.5, 0.5, 0.2), 'world')
rospy.sleep(1.0)
fallen = state('cube', 'world')
move = rospy.ServiceProxy('/gazebo/set_model_state', SetModelState)
from gazebo_msgs.msg import LinkStates, ModelState, ModelStates
moved = move(ModelState('cube', place(-0.4, 0.4, 0.5), ModelState().twist, 'world'))
rospy.sleep(1.0)
there = state('cube', '')
names = rospy.ServiceProxy('/gazebo/get_world_properties', GetWorldProperties)().model_names
published = rospy.wait_for_message('/gazebo/model_states', ModelStates).name
links = rospy.wait_for_message('/gazebo/link_states', LinkStates)
height = links.pose[links.name.index('cube::link')].position.z
delete = rospy.ServiceProxy('/gazebo/delete_model', DeleteModel)
gone = delete('cube')
missing = state('cube', '')
""",
    )
    assert ran["spawned"].success
    assert ran["spawned"].status_message == "SpawnModel: Successfully spawned entity"
    assert ran["again"].status_message == "SpawnModel: entity already exists"
    assert ran["fallen"].pose.position.z == pytest.approx(0.025, abs=0.005)
    assert ran["there"].pose.position.x == pytest.approx(-0.4, abs=0.01)
    assert ran["there"].pose.position.z == pytest.approx(0.025, abs=0.005)
    assert list(ran["names"]) == ["wx250s", "floor", "cube"]
    assert list(ran["published"]) == ["wx250s", "floor", "cube"]
    assert {"wx250s::wx250s/base_link", "floor::link"} <= {*ran["links"].name}
    assert ran["height"] == pytest.approx(0.025, abs=0.005)
    assert ran["gone"].success
    assert not ran["missing"].success
    assert any("model 'cube'; allowed: floor, wx250s" in each for each in ran.findings)


def test_a_model_that_is_attached_moves_with_the_link_and_falls_when_it_is_let_go(run_on):
    ran = run_on(
        "wx250s",
        HEAD1
        + """
from gazebo_ros_link_attacher.srv import Attach, AttachRequest
from interbotix_xs_modules.arm import InterbotixManipulatorXS
bot = InterbotixManipulatorXS('wx250s', init_node=False)
bot.arm.go_to_home_pose()
at = bot.arm.get_ee_pose()[:3, 3]
spawn('cube', CUBE, '', place(at[0] + 0.05, 0.0, at[2]), 'world')
attach = rospy.ServiceProxy('/link_attacher_node/attach', Attach)
detach = rospy.ServiceProxy('/link_attacher_node/detach', Attach)
request = AttachRequest('wx250s', 'wx250s/gripper_link', 'cube', 'link')
attached = attach(request)
bot.arm.set_single_joint_position('waist', 1.0)
held = state('cube', 'world').pose.position
detached = detach(request)
rospy.sleep(1.0)
fallen = state('cube', 'world').pose.position
strange = attach('wx250s', 'wx250s/gripper_link', 'sphere', 'link')
twice = detach(request)
""",
    )
    assert ran["attached"].ok
    radius = ran["at"][0] + 0.05
    assert (ran["held"].x, ran["held"].y) == pytest.approx(
        (radius * 0.5403, radius * 0.8415), abs=0.02
    )
    assert ran["held"].z == pytest.approx(ran["at"][2], abs=0.02)
    assert ran["detached"].ok
    assert ran["fallen"].z == pytest.approx(0.025, abs=0.02)
    assert not ran["strange"].ok
    assert not ran["twice"].ok
    assert any("model 'sphere' cannot be held; allowed: cube" in each for each in ran.findings)


WELDS = """
from gazebo_ros_link_attacher.srv import Attach, AttachRequest
attach = rospy.ServiceProxy('/link_attacher_node/attach', Attach)
detach = rospy.ServiceProxy('/link_attacher_node/detach', Attach)
cube = AttachRequest('wx250s', 'wx250s/gripper_link', 'cube', 'link')
tip = AttachRequest('wx250s', 'wx250s/fingertip', 'cube', 'link')
def put_cube():
    spawn('cube', CUBE, '', place(0.5, 0.0, 0.3), 'world')
def take():
    attach(cube)
def let_go():
    detach(cube)
"""


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("calls", "refused"),
    [
        ("take(); let_go()", 2),  # nothing was spawned
        ("take(); put_cube(); take(); let_go()", 0),  # a retry
        ("let_go(); put_cube(); take(); let_go(); let_go()", 0),  # clean-up before and after
        ("put_cube(); take(); detach(tip)", 1),  # another link than it hangs on
    ],
)
def test_calls_to_attach_and_detach_that_are_all_refused_are_failures(run_on, calls, refused):
    ran = run_on("wx250s", f"{HEAD1}{WELDS}{calls}\n")
    failed = [each for each in ran.recording.findings if each.kind == "attach_failure"]
    open_ones = [each for each in failed if each.recovered_s is None]
    assert [each.object for each in open_ones] == ["cube"] * refused


def test_an_object_of_the_scene_is_welded_to_the_hand(run_on):
    ran = run_on(
        "panda",
        """
import rclpy
from linkattacher_msgs.srv import AttachLink, DetachLink
from gazebo_msgs.srv import GetEntityState, GetModelList
rclpy.init()
node = rclpy.create_node('welder')
def call(kind, service, /, **fields):
    client = node.create_client(kind, service)
    client.wait_for_service()
    future = client.call_async(kind.Request(**fields))
    rclpy.spin_until_future_complete(node, future)
    return future.result()
models = call(GetModelList, '/get_model_list').model_names
name = next(each for each in models if each.startswith('tube'))
where = call(GetEntityState, '/gazebo/get_entity_state', name=name)
weld = dict(model1_name='panda', link1_name='panda_hand', model2_name=name, link2_name='link')
on = call(AttachLink, '/ATTACHLINK', **weld)
off = call(DetachLink, '/DETACHLINK', **weld)
wrong = call(AttachLink, '/ATTACHLINK', **{**weld, 'link1_name': 'panda_hnd'})
""",
        ros=2,
        scene="tube_racks",
    )
    assert ran["where"].success
    assert ran["on"].success
    assert ran["off"].success
    assert not ran["wrong"].success
    assert "did you mean 'panda_hand'" in ran["wrong"].message


def test_a_place_that_is_nowhere_is_refused(run_on):
    ran = run_on(
        "panda",
        HEAD1
        + """
nowhere = [spawn('cube', CUBE, '', place(x, 0, 0), 'world') for x in (float('nan'), 1e30)]
rospy.sleep(0.1)
""",
    )
    assert [each.success for each in ran["nowhere"]] == [False, False]
    assert ran["nowhere"][0].status_message.endswith(
        "(nan, 0, 0) m is not within 1000 m of the robot"
    )


def test_what_is_not_simulated_is_refused(run_on):
    ran = run_on(
        "wx250s",
        HEAD1
        + """
from std_srvs.srv import Empty
rospy.ServiceProxy('/gazebo/pause_physics', Empty)()
rospy.ServiceProxy('/gazebo/unpause_physics', Empty)()
answer = rospy.ServiceProxy('/gazebo/set_model_configuration', SetModelConfiguration)()
""",
    )
    assert ran["answer"].status_message.startswith("SetModelConfiguration: it is not simulated")
    assert [each for each in ran.findings if "pause_physics" in each] == [
        "pause_physics changed nothing: the twin's time goes on with the controller's"
    ]
