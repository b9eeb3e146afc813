"""Stand-in for smach_ros of ROS 1: states that call actions and services, and listen to topics."""

import rospy
import smach

from .condition_state import ConditionState
from .introspection import IntrospectionServer
from .monitor_state import MonitorState
from .service_state import ServiceState
from .simple_action_state import SimpleActionState
from .util import set_preempt_handler

__all__ = [
    "ConditionState",
    "IntrospectionServer",
    "MonitorState",
    "ServiceState",
    "SimpleActionState",
    "set_preempt_handler",
]

smach.set_loggers(rospy.loginfo, rospy.logwarn, rospy.logdebug, rospy.logerr)
smach.set_shutdown_check(rospy.is_shutdown)
