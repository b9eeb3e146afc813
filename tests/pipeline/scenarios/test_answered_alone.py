"""A drafted driver whose motions all fail gives way to an answer alone, which moves nothing."""

import pytest

from tracerisk.pipeline.scenarios.entries import Entries, answered_alone
from tracerisk.ros.controller.needs import Need, NeedKind
from tracerisk.ros.drafts.draft import Draft

DRIVER = {"driver": "cobra/move", "packages": ["cobra_msgs"]}
REPLY = {"name": "/cobra/move", "type": "cobra_msgs/Move", "reply": {"success": True}}


def drafted(kind: NeedKind, value, plain=None) -> Draft:
    need = Need(kind, "/cobra/move", "cobra_msgs/Move")
    return Draft(need, need.name, value, "`joints` are the joints in rad", plain=plain)


@pytest.mark.parametrize(("kind", "section"), [("service", "services"), ("action", "actions")])
def test_a_driver_of_a_service_or_an_action_becomes_an_answer(kind, section):
    driver = drafted(kind, DRIVER, REPLY)
    answered = answered_alone(Entries({(driver.section, driver.key): driver}))
    assert list(answered.drafts) == [(section, "/cobra/move")]
    (draft,) = answered.drafts.values()
    assert draft.value == REPLY
    assert draft.words in ("a reply that says it went well", "a goal that succeeds")


def test_a_driver_that_hears_a_topic_is_left_out():
    driver = drafted("command", DRIVER)
    assert answered_alone(Entries({(driver.section, driver.key): driver})).drafts == {}


def test_what_nothing_else_can_serve_stays():
    driver = drafted("action", DRIVER)
    assert answered_alone(Entries({(driver.section, driver.key): driver})) is None


def test_entries_without_a_driver_stay_as_they_are():
    reply = drafted("service", REPLY)
    assert answered_alone(Entries({(reply.section, reply.key): reply})) is None
