"""The reader of YAML with places."""

import subprocess
import sys


def test_a_number_that_a_version_writes_otherwise_is_read_without_a_word():
    code = (
        "from tracerisk.common.text.yaml_bounds import bounded_yaml;"
        "print(bounded_yaml('rt', (1, 1)).load('most: 1e300'))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
