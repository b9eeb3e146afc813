"""Run a command beside a master of ROS 1 on a free port of loopback; end with its exit code."""

import os
import subprocess
import sys
from xmlrpc.client import ServerProxy

from rosmaster.master import Master

master = Master(port=0)
master.start()
assert ServerProxy(master.uri).getUri("/test")[0] == 1
code = subprocess.call(sys.argv[1:], env={**os.environ, "ROS_MASTER_URI": master.uri})
os._exit(code)
