"""Stand-in for DR_init of Doosan: which robot a program means, and its node.

A program sets `__dsr__id` and `__dsr__model` before it imports DSR_ROBOT, and `__dsr__node` too
before DSR_ROBOT2.
Source: doosan-robotics/doosan-robot2 common2/imp/DR_init.py.
"""

__dsr__id = ""
__dsr__model = ""
