"""rostopic, rosservice, rosnode and rosparam as libraries."""

import pytest


def test_topics_services_and_nodes_are_reported(run_node):
    def main():
        import rosnode
        import rospy
        import rosservice
        import rostopic
        from geometry_msgs.msg import PointStamped
        from std_srvs.srv import SetBool, SetBoolResponse

        rospy.init_node("tools")
        rospy.Publisher("spot", PointStamped, queue_size=1)
        rospy.Service("switch", SetBool, lambda request: SetBoolResponse(True, str(request.data)))
        kind, name, evaluate = rostopic.get_topic_class("/spot/point/x")
        message = PointStamped()
        message.point.x = 3.0
        assert (kind, name, evaluate(message)) == (PointStamped, "/spot", 3.0)
        assert rostopic.get_topic_type("nothing") == (None, None, None)
        assert rostopic.find_by_type("geometry_msgs/PointStamped") == ["/spot"]
        assert "/switch" in rosservice.get_service_list()
        assert rosservice.get_service_type("switch") == "std_srvs/SetBool"
        assert rosservice.call_service("switch", [True])[1].message == "True"
        with pytest.raises(rosservice.ROSServiceException, match="not available"):
            rosservice.call_service("light", [])
        bring_up = ["/robot_state_publisher", "/rosout", "/rviz"]
        assert rosnode.get_node_names() == [*bring_up, "/tools"]
        assert rosnode.get_node_names("tools") == ["/tools"]
        return rosnode.rosnode_ping("tools"), rosnode.rosnode_ping("nobody")

    assert run_node(main) == (True, False)


def test_parameters_come_from_files(run_node, tmp_path):
    def main():
        import rosparam
        import rospy

        rospy.init_node("tools")
        file = tmp_path / "p.yaml"
        file.write_text("speed: 0.5\narm: {joints: [1, 2]}\n---\n_ns: deep\nlit: yes\n")
        for values, space in rosparam.load_file(str(file), "cell"):
            rosparam.upload_params(space, values)
        with pytest.raises(rosparam.RosParamException, match="does not exist"):
            rosparam.load_file("nowhere.yaml")
        with pytest.raises(rosparam.RosParamException, match="is not set"):
            rosparam.get_param("/nothing")
        return rosparam.get_param("/cell"), rosparam.list_params("cell")

    values, names = run_node(main)
    assert values == {"speed": 0.5, "arm": {"joints": [1, 2]}, "deep": {"lit": True}}
    assert "/cell/speed" in names
