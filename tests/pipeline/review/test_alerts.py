"""What alerts of a run say beside their place."""

import json

from tests.conftest import quick_controller


def test_an_alert_of_a_fault_in_a_helper_names_the_line_that_called_it(example):
    source = quick_controller("reach(arm, 9.0)").replace(
        "def act(",
        "def reach(arm, x):\n"
        "    arm.set_pose_target([x, 0.0, 0.5, 3.14, 0.0, 0.0])\n"
        "    assert not arm.go(wait=True)\n\n"
        "def act(",
    )
    example.write("c.py", source)
    lines = source.splitlines()
    call = 1 + lines.index("    reach(arm, 9.0)")
    outcome = example.run("run", "c.py", "--check", "--sarif", "out.sarif")
    assert "called from line" in outcome.out + outcome.err
    (run,) = json.loads(example.read("out.sarif"))["runs"]
    (alert,) = [each for each in run["results"] if each["ruleId"] == "faulted-run"]
    region = alert["locations"][0]["physicalLocation"]["region"]
    assert region["startLine"] == 1 + lines.index("    assert not arm.go(wait=True)")
    assert alert["message"]["text"].endswith(f"(called from line {call})")
