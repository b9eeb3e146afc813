import rospy
from std_srvs.srv import SetBool, SetBoolResponse, Trigger, TriggerResponse


def switch(request):
    if not request.data:
        raise rospy.ServiceException("it stays on")
    return SetBoolResponse(True, "on")


def main():
    rospy.init_node("services")
    rospy.Service("~trigger", Trigger, lambda request: TriggerResponse(True, "hello"))
    rospy.Service("switch", SetBool, switch)
    rospy.Service("pair", SetBool, lambda request: (request.data, "as tuple"))
    rospy.wait_for_service("switch", timeout=2.0)
    call = rospy.ServiceProxy("switch", SetBool)
    print("> on", call(True).message, call(data=True).success)
    try:
        call(False)
    except rospy.ServiceException as error:
        print("> refused", error)
    print("> pair", rospy.ServiceProxy("pair", SetBool)(True).message)
    print("> trigger", rospy.ServiceProxy("/services/trigger", Trigger)().message)
    try:
        rospy.ServiceProxy("/nobody", Trigger)()
    except rospy.ServiceException as error:
        print("> missing", error)
    try:
        call(1, 2, 3)
    except TypeError as error:
        print("> arguments", type(error).__name__)
    try:
        rospy.wait_for_service("/nobody", timeout=0.5)
    except rospy.ROSException as error:
        print("> waited", error)


if __name__ == "__main__":
    main()
