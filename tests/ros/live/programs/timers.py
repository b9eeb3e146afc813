import rospy


def main():
    rospy.init_node("timers")
    ticks = []
    once = []
    start = rospy.Time.now()

    def tick(event):
        ticks.append(event)

    timer = rospy.Timer(rospy.Duration(0.1), tick)
    rospy.Timer(rospy.Duration(0.25), lambda event: once.append(event), oneshot=True)
    rospy.sleep(1.05)
    timer.shutdown()
    rospy.sleep(0.3)
    print("> ticks", len(ticks), "once", len(once))
    print("> first", ticks[0].last_real, round((ticks[0].current_real - start).to_sec(), 1))
    gaps = [(b.current_expected - a.current_expected).to_sec() for a, b in zip(ticks, ticks[1:])]
    print("> gaps", sorted({round(g, 3) for g in gaps}))
    late = [abs((t.current_real - t.current_expected).to_sec()) < 0.02 for t in ticks]
    print("> on time", all(late), ticks[-1].last_expected == ticks[-2].current_expected)


if __name__ == "__main__":
    main()
