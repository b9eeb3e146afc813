# ruff: noqa: F401 - what is imported here is what the module gives
"""Stand-in for rospy, the Python client library of ROS 1."""

from std_msgs.msg import Header

from tracerisk.ros.imports.exported import exported as _exported

from .client import (
    DEBUG,
    ERROR,
    FATAL,
    INFO,
    WARN,
    delete_param,
    get_master,
    get_param,
    get_param_cached,
    get_param_names,
    get_published_topics,
    has_param,
    init_node,
    myargv,
    on_shutdown,
    search_param,
    set_param,
    spin,
    wait_for_message,
)
from .core import (
    get_node_uri,
    get_ros_root,
    is_shutdown,
    logdebug,
    logdebug_once,
    logdebug_throttle,
    logdebug_throttle_identical,
    logerr,
    logerr_once,
    logerr_throttle,
    logerr_throttle_identical,
    logfatal,
    logfatal_once,
    logfatal_throttle,
    logfatal_throttle_identical,
    loginfo,
    loginfo_once,
    loginfo_throttle,
    loginfo_throttle_identical,
    logout,
    logwarn,
    logwarn_once,
    logwarn_throttle,
    logwarn_throttle_identical,
    parse_rosrpc_uri,
    signal_shutdown,
)
from .exceptions import *  # noqa: F403 - each name of it
from .msg import AnyMsg
from .msproxy import MasterProxy
from .names import get_caller_id, get_name, get_namespace, remap_name, resolve_name
from .rostime import Duration, Time, get_rostime, get_time
from .service import Service, ServiceException, ServiceProxy, wait_for_service
from .timer import Rate, Timer, sleep
from .topics import Message, Publisher, SubscribeListener, Subscriber

__all__ = _exported(globals())
