"""The master of a live run and the node that speaks for the twin, under the Python of ROS.

It knows no message: bytes go through as they are, with the type, md5 sum and text that the twin's
side names. What nodes register and ask for at the master is sent to that side.
"""

from __future__ import annotations

import importlib
import json
import os
import socket
import sys
import threading
import traceback
from typing import Any

from tracerisk.ros.live.link import Link

NODE = "/tracerisk_twin"
_LOOKUP_S = 10.0


class Relay:
    """Does what the frames of a link ask, and sends it what comes from real ROS."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self._rospy: Any = importlib.import_module("rospy")
        self._publishers: dict[str, Any] = {}
        self._classes: dict[str, Any] = {}
        self._subscribers: dict[str, Any] = {}
        self._services: dict[str, Any] = {}
        self._answers: dict[int, _Answer] = {}
        self._number = 0
        self._lock = threading.Lock()

    def ask(self, header: dict[str, Any], body: bytes = b"") -> _Answer:
        """Ask the twin's side and return the answer that will be filled in."""
        with self._lock:
            self._number += 1
            number = self._number
            answer = self._answers[number] = _Answer()
        self._link.send({**header, "number": number}, body)
        return answer

    def send(self, header: dict[str, Any], body: bytes = b"") -> None:
        """Send a frame to the twin's side."""
        self._link.send(header, body)

    def run(self, master: Any) -> None:
        """Serve until the other end is gone."""
        while (frame := self._link.receive()) is not None:
            header, body = frame
            do = header["do"]
            if do == "publish":
                self._publish(header["topic"], body)
            elif do == "advertise":
                self._advertise(header)
            elif do == "subscribe":
                self._subscribe(header["topic"])
            elif do == "serve":
                self._serve(header)
            elif do == "answer":
                answer = self._answers.pop(header["number"])
                answer.header, answer.body = header, body
                answer.came.set()
            elif do == "parameter":
                master.setParam(NODE, header["name"], header["value"])

    def _raw(self, type_name: str, md5: str, text: str = "") -> Any:
        body = {"_type": type_name, "_md5sum": md5, "_full_text": text, "__slots__": ["_buff"]}
        return type("Raw", (self._rospy.AnyMsg,), body)

    def _advertise(self, header: dict[str, Any]) -> None:
        topic = header["topic"]
        if topic in self._publishers:
            return
        kind = self._raw(header["type"], header["md5"], header["text"])
        self._classes[topic] = kind
        self._publishers[topic] = self._rospy.Publisher(
            topic, kind, latch=header["latch"], tcp_nodelay=True, queue_size=0
        )

    def _publish(self, topic: str, body: bytes) -> None:
        message = self._classes[topic]()
        message._buff = body
        self._publishers[topic].publish(message)

    def _subscribe(self, topic: str) -> None:
        if topic not in self._subscribers:
            self._subscribers[topic] = self._rospy.Subscriber(
                topic, self._rospy.AnyMsg, self._received, callback_args=topic, tcp_nodelay=True
            )

    def _received(self, message: Any, topic: str) -> None:
        caller = message._connection_header["callerid"]
        if caller != NODE:
            self.send({"is": "message", "topic": topic, "caller": caller}, message._buff)

    def _serve(self, header: dict[str, Any]) -> None:
        name = header["name"]
        if name in self._services:
            return
        request = self._raw(header["type"] + "Request", header["request_md5"])
        response = self._raw(header["type"] + "Response", header["response_md5"])
        kind = type(
            "RawService",
            (),
            {
                "_type": header["type"],
                "_md5sum": header["md5"],
                "_request_class": request,
                "_response_class": response,
            },
        )

        def handle(asked: Any) -> Any:
            answer = self.ask({"is": "call", "name": name}, asked._buff)
            answer.came.wait()
            if not answer.header["ok"]:
                raise self._rospy.ServiceException(answer.header["message"])
            reply = response()
            reply._buff = answer.body
            return reply

        self._services[name] = self._rospy.Service(name, kind, handle)


class _Answer:
    def __init__(self) -> None:
        self.came = threading.Event()
        self.header: dict[str, Any] = {}
        self.body = b""


def _watched(base: Any, relay: list[Relay]) -> Any:
    """Return the class of a master that reports what nodes register and ask for."""

    def report(what: str, caller: str, name: str, kind: str = "") -> None:
        if relay and caller != NODE:
            relay[0].send({"is": what, "caller": caller, "name": name, "type": kind})

    class Master(base):  # type: ignore[misc]
        def registerPublisher(self, caller_id: str, topic: str, topic_type: str, api: str) -> Any:
            done = base.registerPublisher(self, caller_id, topic, topic_type, api)
            report("publisher", caller_id, topic, topic_type)
            return done

        def unregisterPublisher(self, caller_id: str, topic: str, api: str) -> Any:
            report("no_publisher", caller_id, topic)
            return base.unregisterPublisher(self, caller_id, topic, api)

        def registerSubscriber(self, caller_id: str, topic: str, topic_type: str, api: str) -> Any:
            done = base.registerSubscriber(self, caller_id, topic, topic_type, api)
            report("subscriber", caller_id, topic, topic_type)
            return done

        def unregisterSubscriber(self, caller_id: str, topic: str, api: str) -> Any:
            report("no_subscriber", caller_id, topic)
            return base.unregisterSubscriber(self, caller_id, topic, api)

        def lookupService(self, caller_id: str, service: str) -> Any:
            if relay and caller_id != NODE:
                answer = relay[0].ask({"is": "lookup", "name": service})
                answer.came.wait(_LOOKUP_S)
            return base.lookupService(self, caller_id, service)

        def setParam(self, caller_id: str, key: str, value: Any) -> Any:
            done = base.setParam(self, caller_id, key, value)
            if relay and caller_id != NODE:
                relay[0].send({"is": "parameter", "name": key, "value": value})
            return done

    return Master


def main() -> None:
    """Serve the descriptor that the command line gives in JSON, until its other end is gone."""
    link = Link(socket.socket(fileno=json.loads(sys.argv[1])["descriptor"]))
    api: Any = importlib.import_module("rosmaster.master_api")
    xmlrpc: Any = importlib.import_module("rosgraph.xmlrpc")
    relay: list[Relay] = []
    master = _watched(api.ROSMasterHandler, relay)()
    node = xmlrpc.XmlRpcNode(0, master)
    node.start()
    while not node.uri:
        threading.Event().wait(0.001)
    os.environ["ROS_MASTER_URI"] = node.uri
    rospy: Any = importlib.import_module("rospy")
    rospy.init_node(NODE.strip("/"), disable_rosout=True, disable_signals=True)
    relay.append(Relay(link))
    master.setParam(NODE, "/use_sim_time", True)
    relay[0].send({"is": "ready", "uri": node.uri})
    try:
        relay[0].run(master)
    except BaseException:
        traceback.print_exc()
        raise
    finally:
        # Threads of rospy wait for connections that nobody closes any more.
        os._exit(0)


if __name__ == "__main__":
    main()
