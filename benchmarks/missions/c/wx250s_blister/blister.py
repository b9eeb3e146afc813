from interbotix_xs_modules.arm import InterbotixManipulatorXS
import rospy
from std_msgs.msg import Int32, Float32, Bool
from std_srvs.srv import SetBool

# Fill two pockets of a blister from the vibrating plate, WidowX 250 S.
# All numbers in metres and radians, base_link of the arm.

PLATE = [(0.30, 0.14), (0.36, 0.10)]
POCKETS = [(0.30, -0.12), (0.36, -0.12)]
Z_PART = 0.067
Z_TRAVEL = 0.17
BATCH = 2206
SEAL_C = 165

bot = InterbotixManipulatorXS("wx250s", "arm", "gripper", moving_time=1.2, accel_time=0.4)

pub_pocket = rospy.Publisher("/blister/pocket", Int32, queue_size=5)
pub_batch = rospy.Publisher("/blister/batch", Int32, queue_size=5)
pub_temp = rospy.Publisher("/sealer/setpoint_c", Float32, queue_size=5)
pub_ok = rospy.Publisher("/blister/full", Bool, queue_size=5)
vibrate = rospy.ServiceProxy("/plate/vibrate", SetBool)
rospy.wait_for_service("/plate/vibrate")


def goto(x, y, z):
    ok = bot.arm.set_ee_pose_components(x=x, y=y, z=z, roll=0.0, pitch=1.5)
    # ROS1 API gives (joints, found)
    if isinstance(ok, tuple):
        ok = ok[1]
    if not ok:
        rospy.logerr("no solution at %.3f %.3f %.3f" % (x, y, z))
    return ok


def pick(x, y):
    bot.gripper.open()
    goto(x, y, Z_TRAVEL)
    goto(x, y, Z_PART)
    bot.gripper.close(delay=1.0)
    goto(x, y, Z_TRAVEL)


def place(x, y):
    goto(x, y, Z_TRAVEL)
    goto(x, y, Z_PART + 0.003)
    bot.gripper.open(delay=0.8)
    goto(x, y, Z_TRAVEL)


bot.arm.go_to_home_pose()
pub_batch.publish(BATCH)
vibrate(True)
rospy.sleep(0.5)
vibrate(False)
for i in range(len(POCKETS)):
    pick(*PLATE[i])
    place(*POCKETS[i])
    pub_pocket.publish(i + 1)
pub_temp.publish(SEAL_C)
pub_ok.publish(True)
bot.arm.go_to_sleep_pose()
rospy.sleep(0.3)
