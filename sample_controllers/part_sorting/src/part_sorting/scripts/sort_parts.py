#!/usr/bin/env python3
"""Sort the parts of one batch."""

import rospy
from part_sorting.msg import Part
from part_sorting.sorter import Sorter


def main():
    rospy.init_node("part_sorting")
    sorter = Sorter(
        rospy.get_param("~robot_name", "wx250s"),
        rospy.get_param("~bins", {"red": 1.2, "blue": -1.2}),
    )
    batch = [
        Part(colour=Part.RED, bearing=0.15),
        Part(colour=Part.BLUE, bearing=-0.1),
        Part(colour=Part.RED, bearing=0.0),
    ]
    for part in batch:
        if rospy.is_shutdown():
            break
        sorter.sort(part)
    sorter.park()


if __name__ == "__main__":
    try:
        main()
    except rospy.ROSInterruptException:
        pass
