"""What programs import of moveit_commander beside its commanders."""

from tracerisk.ros.imports.finder import StandInFinder
from tracerisk.ros.messages.ros1 import Interfaces


def test_it_gives_the_messages_that_its_modules_import():
    with StandInFinder(Interfaces()):
        import moveit_commander
        from moveit_msgs.msg import Constraints, RobotTrajectory

        assert moveit_commander.RobotTrajectory is RobotTrajectory
        assert moveit_commander.Constraints is Constraints
        assert {"Pose", "RobotState", "MoveItErrorCodes"} <= {*moveit_commander.__all__}
