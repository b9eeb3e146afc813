import rospy


def main():
    rospy.init_node("parameters")
    rospy.set_param("/speed", 0.5)
    rospy.set_param("~private", [1, 2, 3])
    rospy.set_param("/arm", {"joints": {"a": 1, "b": 2}, "name": "left"})
    print("> speed", rospy.get_param("/speed"), rospy.get_param("speed"))
    print("> private", rospy.get_param("~private"), rospy.get_param("/parameters/private"))
    print("> tree", sorted(rospy.get_param("/arm/joints").items()), rospy.get_param("/arm/name"))
    print("> has", rospy.has_param("/arm/joints/a"), rospy.has_param("/arm/joints/c"))
    print("> default", rospy.get_param("/none", 7), rospy.get_param("/none", None))
    print("> search", rospy.search_param("speed"), rospy.search_param("private"))
    rospy.delete_param("/arm/joints")
    print("> left", rospy.get_param("/arm"))
    try:
        rospy.get_param("/gone")
    except KeyError as error:
        print("> missing", error)
    try:
        rospy.delete_param("/gone")
    except KeyError as error:
        print("> undeleted", type(error).__name__)
    print(
        "> names", [n for n in sorted(rospy.get_param_names()) if n.startswith(("/arm", "/speed"))]
    )
    print("> cached", rospy.get_param_cached("/speed"))
    print("> robot", "panda_joint1" in rospy.get_param("robot_description"))
    print("> name", rospy.get_name(), rospy.get_namespace(), rospy.resolve_name("~x"))


if __name__ == "__main__":
    main()
