import rospy


def main():
    rospy.init_node("wait_for_service")
    try:
        rospy.wait_for_service("/nobody", timeout=0.5)
    except rospy.ROSException as error:
        print("> waited", error)


if __name__ == "__main__":
    main()
