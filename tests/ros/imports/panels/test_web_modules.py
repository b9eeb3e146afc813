"""Web servers that no browser asks: each route is requested once, in a run without a network."""

import importlib
from textwrap import dedent

import pytest

from tracerisk.ros.imports.panels.web_modules import web_finder
from tracerisk.ros.imports.panels.window_modules import Windows
from tracerisk.ros.imports.placeholder_modules import PlaceholderValues

POSTURE = (0.1, -0.7, 0.3)
APP = """
    import threading
    import rclpy
    from flask import Flask, request, jsonify
    from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

    app = Flask(__name__)
    rclpy.init()
    node = rclpy.create_node("panel")
    publisher = node.create_publisher(
        JointTrajectory, "/panda_arm_controller/joint_trajectory", 1
    )


    @app.route("/move", methods=["POST"])
    def move():
        joints = [float(value) for value in request.get_json()["joints"]]
        if len(joints) != 7:
            return jsonify({"status": "error"}), 400
        point = JointTrajectoryPoint(positions=joints)
        point.time_from_start.sec = 2
        names = [f"panda_joint{number}" for number in range(1, 8)]
        publisher.publish(JointTrajectory(joint_names=names, points=[point]))
        return jsonify({"status": "ok"})


    threading.Thread(target=rclpy.spin, args=(node,), daemon=True).start()
    app.run(host="0.0.0.0", port=5000)
"""


class Clock:
    """A clock that only sleeping moves."""

    def __init__(self):
        self.now_ns = 0

    def sleep(self, ns):
        self.now_ns += ns


@pytest.fixture
def failures():
    return []


@pytest.fixture
def web(failures):
    clock = Clock()
    values = PlaceholderValues(lambda: POSTURE, lambda: clock.now_ns)
    windows = Windows(values, clock.sleep, failures.append)
    with web_finder(("flask", "flask_socketio", "fastapi", "uvicorn"), windows):
        yield clock


def test_each_route_is_requested_once_in_its_order_when_the_app_serves(web):
    flask = importlib.import_module("flask")
    app, asked = flask.Flask("arm"), []

    @app.route("/")
    def index():
        asked.append("index")

    @app.post("/joint/<int:number>")
    def joint(number):
        asked.append(("joint", int(number)))

    assert asked == []
    app.run(port=5000)
    assert asked == ["index", ("joint", 0)]
    assert web.now_ns > 5e9  # a motion has time to end


def test_what_was_sent_holds_a_posture_and_defaults_that_are_something(web):
    request = importlib.import_module("flask").request
    sent = request.get_json()
    assert [float(value) for value in sent["joints"]] == list(POSTURE)
    assert sent.get("speed", 0.5) == 0.5
    assert list(sent.get("joints", [])) == list(POSTURE)
    assert list(request.json["pose"]["xyz"]) == list(POSTURE)
    assert request.method == "POST"
    assert request.method != "GET"


def test_functions_of_other_libraries_are_requested_too(web):
    app, asked = importlib.import_module("fastapi").FastAPI(), []
    io = importlib.import_module("flask_socketio").SocketIO()

    @app.get("/home")
    async def home():
        asked.append("home")

    @io.on("jog")
    def jog(data):
        asked.append(list(data["joints"]))

    importlib.import_module("uvicorn").run(app)
    assert asked == ["home", list(POSTURE)]


def test_a_route_that_raises_is_told_and_the_server_goes_on(web, failures):
    app, asked = importlib.import_module("flask").Flask("arm"), []
    app.route("/bad")(lambda: 1 / 0)
    app.route("/good")(lambda: asked.append("good"))
    app.run()
    assert [type(error) for error in failures] == [ZeroDivisionError]
    assert asked == ["good"]


def test_a_run_requests_the_routes_of_a_server_and_says_so(example):
    example.write("panel.py", dedent(APP))
    ran = example.run("trace", "panel.py", "--robot", "panda", "--json")
    verdict = ran.json["verdict"]
    assert verdict["kind"] == "partial", ran.err
    words = " ".join(reason["words"] for reason in verdict["reasons"])
    assert "modules flask is drafted: a web server of flask without a network" in words
    (function,) = ran.json["trace"]["functions"]
    assert function["ref"]["name"] == "move"
