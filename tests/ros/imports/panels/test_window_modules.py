"""Windows at which nobody sits: their buttons are pressed once, in a run without a screen."""

import importlib
from textwrap import dedent

import pytest

from tracerisk.ros.imports.panels.window_modules import Windows, window_finder
from tracerisk.ros.imports.panels.window_names import needs_screen
from tracerisk.ros.imports.placeholder_modules import PlaceholderValues

POSTURE = (0.1, -0.7, 0.3)
TK = """
    import rospy
    from tkinter import *
    from tkinter import messagebox
    from sensor_msgs.msg import JointState
    from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint


    class App(Frame):
        def __init__(self, master):
            super().__init__(master)
            topic = "/panda_arm_controller/command"
            self.publisher = rospy.Publisher(topic, JointTrajectory, queue_size=1)
            Button(master, text="Quit", command=master.destroy).pack(side=LEFT)
            self.turn = Scale(master, from_=-90, to=90, command=self.show)
            self.seconds = DoubleVar(value=1.5)
            Button(master, text="Send", command=self.send).grid(row=0)
            self.grid()

        def show(self, value):
            rospy.loginfo("at %s", value)

        def send(self):
            point = JointTrajectoryPoint(positions=[0, -0.7, 0, -2.3, 0, 1.5, 0.7])
            point.positions[0] = self.turn.get() * 3.14 / 180
            point.time_from_start = rospy.Duration(self.seconds.get())
            names = [f"panda_joint{number}" for number in range(1, 8)]
            self.publisher.publish(JointTrajectory(joint_names=names, points=[point]))


    rospy.init_node("panel")
    root = Tk()
    App(root)
    root.mainloop()
"""
QT = """
    import sys
    import rospy
    from PyQt5.QtCore import *
    from PyQt5.QtWidgets import QApplication, QMainWindow, QPushButton
    from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint


    class Panel(QMainWindow):
        def __init__(self):
            super().__init__()
            topic = "/panda_arm_controller/command"
            self.publisher = rospy.Publisher(topic, JointTrajectory, queue_size=1)
            self.home = QPushButton("Home", self)
            self.home.clicked.connect(self.send)

        def send(self):
            point = JointTrajectoryPoint(positions=[0.3, -0.7, 0, -2.3, 0, 1.5, 0.7])
            point.time_from_start = rospy.Duration(1)
            names = [f"panda_joint{number}" for number in range(1, 8)]
            self.publisher.publish(JointTrajectory(joint_names=names, points=[point]))


    rospy.init_node("panel")
    app = QApplication(sys.argv)
    panel = Panel()
    panel.show()
    sys.exit(app.exec_())
"""


class _Clock:
    """The simulated time of a window, which passes only while it waits."""

    def __init__(self) -> None:
        self.now_ns = 0

    def sleep(self, duration_ns: int) -> None:
        self.now_ns += duration_ns


@pytest.fixture
def windows():
    clock = _Clock()
    values = PlaceholderValues(lambda: POSTURE, lambda: clock.now_ns)
    return Windows(values, clock.sleep, failed=lambda error: None)


@pytest.fixture
def tk(windows):
    with window_finder(["tkinter", "PyQt5"], windows):
        yield importlib.import_module("tkinter")


def test_buttons_are_pressed_in_their_order_those_that_end_it_last(tk, windows):
    root, pressed = tk.Tk(), []
    for name in ("Exit", "Open", "Close gripper"):
        tk.Button(root, text=name, command=lambda name=name: pressed.append(name))
    root.bind("<Left>", lambda event: pressed.append(event.keysym))
    root.mainloop()
    assert pressed == ["Open", "Close gripper", "Left", "Exit"]
    assert windows.values.now_ns() == 21_000_000_000


def test_a_widget_keeps_what_it_was_given_and_else_gives_a_joint_in_its_range(tk):
    root = tk.Tk()
    text, least = tk.StringVar(value="cup"), tk.Scale(root, from_=0.5, to=2)
    entry = tk.Entry(root, textvariable=text)
    assert (entry.get(), least.get(), tk.Spinbox(root).get()) == ("cup", 0.5, "-0.7")
    text.set("plate")
    degrees = tk.Scale(root, from_=-180, to=180)
    assert (entry.get(), degrees.get()) == ("plate", 17.189)
    assert tk.END == "end"


def test_timers_go_on_while_buttons_are_pressed_and_a_closed_window_ends_the_loop(tk):
    root, ticks = tk.Tk(), []

    def tick() -> None:
        ticks.append(1)
        root.after(500, tick)

    tick()
    tk.Button(root, command=root.destroy)
    tk.Button(root, command=lambda: 1 / 0)
    root.mainloop()
    assert len(ticks) == 13  # one at first, then each half second until 6 s


def test_a_button_that_shows_how_far_it_is_presses_no_other(tk):
    root, pressed = tk.Tk(), []

    def move(name: str) -> None:
        pressed.append(f"{name} begins")
        root.update()
        pressed.append(f"{name} ends")

    for name in ("pick", "place"):
        tk.Button(root, command=lambda name=name: move(name))
    root.mainloop()
    assert pressed == ["pick begins", "pick ends", "place begins", "place ends"]


def test_what_closes_a_widget_or_a_dialog_leaves_the_program_open(tk):
    root, pressed = tk.Tk(), []
    dialog, label = tk.Toplevel(root), tk.Label(root)
    thread = importlib.import_module("PyQt5.QtCore").QThread()
    for closed in (dialog.destroy, label.destroy, thread.quit):
        tk.Button(dialog, command=lambda closed=closed: closed())
    tk.Button(root, command=lambda: pressed.append("pick"))
    root.mainloop()
    assert pressed == ["pick"]


@pytest.mark.parametrize("is_within", [False, True])
def test_a_window_after_another_one_has_its_buttons_pressed(tk, is_within):
    pressed = []

    def main() -> None:
        window = tk.Tk()
        tk.Button(window, command=lambda: pressed.append("pick"))
        tk.Button(window, command=lambda: pressed.append("place"))
        window.mainloop()

    def log_in() -> None:
        login.destroy()
        if is_within:
            main()

    login = tk.Tk()
    tk.Button(login, text="Log in", command=log_in)
    tk.Button(login, text="Cancel", command=lambda: pressed.append("cancel"))
    login.mainloop()
    if not is_within:
        main()
    assert pressed == ["pick", "place"]


def test_a_button_that_starts_and_stops_in_turn_is_pressed_once_for_each(tk):
    root, pressed = tk.Tk(), []

    def start() -> None:
        pressed.append("start")
        button.config(text="Stop", command=stop)

    def stop() -> None:
        pressed.append("stop")
        button.config(text="Start", command=start)

    button = tk.Button(root, text="Start", command=start)
    root.mainloop()
    assert pressed == ["start", "stop"]


def test_widgets_give_values_of_their_own_type(tk):
    widgets = importlib.import_module("PyQt5.QtWidgets")
    entry, text, slider = tk.Entry(tk.Tk()), tk.StringVar(), widgets.QSlider()
    assert entry.get().strip() == "0.1"
    assert text.get().split(",") == ["-0.7"]
    assert list(range(slider.value())) == list(range(17))
    tree = tk.Listbox(tk.Tk())
    tree.insert("", "end", text="cup", values=(1, 2))
    for child in (*tree.winfo_children(), *tree.get_children()):
        child.destroy()


def test_timers_that_are_stopped_call_no_more(tk):
    root, called = tk.Tk(), []
    root.after_cancel(root.after(100, lambda: called.append("cancelled")))
    root.after_idle(lambda: called.append("idle"))
    timer, once = (importlib.import_module("PyQt5.QtCore").QTimer() for _ in range(2))

    def tick() -> None:
        called.append("tick")
        if called.count("tick") == 2:
            timer.stop()

    timer.timeout.connect(tick)
    timer.start(100)
    once.setSingleShot(True)
    once.timeout.connect(lambda: called.append("once"))
    once.start(100)
    root.mainloop()
    assert called == ["idle", "tick", "once", "tick"]


def test_signals_of_qt_call_what_they_are_connected_to(tk):
    core = importlib.import_module("PyQt5.QtCore")

    class Panel(core.QObject):
        said = core.pyqtSignal(str)

        def __init__(self) -> None:
            super().__init__()
            self.heard = []
            self.said.connect(self.heard.append)

    panel = Panel()
    panel.said.emit("home")
    assert panel.heard == ["home"]


def test_only_a_lack_of_a_screen_is_one():
    error = type("TclError", (Exception,), {})
    assert needs_screen(error("no display name and no $DISPLAY environment variable"))
    assert not needs_screen(error('unknown option "-txt"'))


def test_a_callback_of_a_window_that_raises_makes_the_run_faulted(example):
    raising = dedent(TK).replace("def send(self):", "def send(self):\n        1 / 0")
    example.write("panel.py", raising)
    example.write("panel.yaml", "modules:\n  - module: tkinter\n")
    asked = ("trace", "panel.py", "--robot", "panda", "--scenario", "panel.yaml", "--json")
    verdict = example.run(*asked).json["verdict"]
    assert verdict["kind"] == "faulted"
    (reason,) = (reason for reason in verdict["reasons"] if reason["code"] == "callback-raised")
    assert reason["words"].startswith("a callback of a window raised ZeroDivisionError")
    place = raising.splitlines().index("        1 / 0") + 1
    assert (reason["location"]["line"], reason["function"]) == (place, "App.send")


def test_an_error_for_want_of_a_screen_says_what_gives_windows(example):
    error = "class TclError(Exception):\n    pass\n\nraise TclError('no display name')\n"
    example.write("panel.py", error)
    said = example.run("trace", "panel.py", "--robot", "panda", "--no-draft").err
    assert "a scenario with `modules: [{module: tkinter}]` gives windows" in " ".join(said.split())


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(("program", "library"), [(TK, "tkinter"), (QT, "PyQt5")])
def test_a_run_presses_the_buttons_of_a_program_and_says_so(example, program, library):
    example.write("panel.py", dedent(program))
    ran = example.run("trace", "panel.py", "--robot", "panda", "--json")
    verdict = ran.json["verdict"]
    assert verdict["kind"] == "partial", ran.err
    words = " ".join(reason["words"] for reason in verdict["reasons"])
    assert f"modules {library} is drafted: windows of {library} without a screen" in words
    (function,) = ran.json["trace"]["functions"]
    assert function["ref"]["name"].endswith(".send")
