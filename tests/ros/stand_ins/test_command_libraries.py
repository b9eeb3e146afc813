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
        import rosgraph
        import rosparam
        import rospy

        rospy.init_node("tools")
        file = tmp_path / "p.yaml"
        file.write_text("speed: 0.5\narm: {joints: [1, 2]}\n---\n_ns: deep\nlit: yes\n")
        for values, space in rosparam.load_file(str(file), "cell"):
            rosparam.upload_params(space, values)
        with pytest.raises(rosparam.RosParamException, match="does not exist"):
            rosparam.load_file("nowhere.yaml")
        for call in (rosparam.get_param, rosparam.delete_param):
            with pytest.raises(rosgraph.MasterError, match="is not set"):
                call("/nothing")
        return rosparam.get_param("/cell"), rosparam.list_params("cell")

    values, names = run_node(main)
    assert values == {"speed": 0.5, "arm": {"joints": [1, 2]}, "deep": {"lit": True}}
    assert "/cell/speed" in names


def test_parameters_are_written_to_files_and_set_from_yaml(run_node, tmp_path, capsys):
    def main():
        import rosparam
        import rospy

        rospy.init_node("tools")
        rosparam.set_param("/px100/arm", "{speed: 0.5, joints: [1, 2], lit: yes}")
        rosparam.set_param_raw("/px100/arm", {"name": "left"})
        file = tmp_path / "written.yaml"
        rosparam.dump_params(str(file), "/px100")
        rosparam.dump_params(None, "/px100/arm/joints", verbose=True)
        rosparam.delete_param("/px100/arm/name", verbose=True)
        with pytest.raises(rosparam.RosParamException, match="must have string keys"):
            rosparam.set_param("/px100", "{1: 2}")
        assert rosparam.get_param_server().hasParam("/px100/arm")
        assert issubclass(rosparam.RosParamIOException, rosparam.RosParamException)
        loaded = rosparam.load_file(str(file), "/again")
        for values, space in loaded:
            rosparam.upload_params(space, values)
        rosparam.print_params(rosparam.get_param("/again"), "/again")
        return file.read_text(), rospy.get_param("/again"), rospy.get_param("/px100")

    text, again, kept = run_node(main)
    assert text == "arm:\n  joints:\n  - 1\n  - 2\n  lit: true\n  name: left\n  speed: 0.5\n"
    assert again == {"arm": {"speed": 0.5, "joints": [1, 2], "lit": True, "name": "left"}}
    assert kept == {"arm": {"speed": 0.5, "joints": [1, 2], "lit": True}}
    assert "- 1\n- 2\ndeleted parameter [/px100/arm/name]\n" in capsys.readouterr().out
