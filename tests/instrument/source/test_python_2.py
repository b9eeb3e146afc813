"""What shows that a source is Python 2, and what does not."""

import pytest

from tracerisk.instrument.source.python_source import is_python_2


@pytest.mark.parametrize(
    "source",
    [
        "name = raw_input()\n",
        "#!/usr/bin/env python2.7\nx = 7 / 2\n",
        "#!/usr/bin/env python\nfor key, value in d.iteritems():\n    f(key)\n",
        "if d.has_key('a'):\n    f(7 / 2)\n",
        "import sys\nprint >>sys.stderr, 'late'\n",
        "import sys\nprint >> sys.stderr\n",
        "import Queue\n",
    ],
)
def test_what_only_python_2_has_shows_it(source):
    assert is_python_2(source.encode())


@pytest.mark.parametrize(
    "source",
    [
        "#!/usr/bin/env python3\nname = raw_input()\n",
        "#!/usr/bin/python3.8\nfor n in xrange(7 / 2):\n    f(n)\n",
        "import six\nfor key, value in six.iteritems(d):\n    f(7 / 2)\n",
        "class Cells:\n    def has_key(self, name):\n        return True\nCells().has_key(1)\n",
        "import sys\nask = raw_input if sys.version_info[0] < 3 else input\n",
        "import sys\nif sys.hexversion < 0x3000000:\n    input = raw_input\n",
        "try:\n    input = raw_input\nexcept NameError:\n    pass\n",
        "x = log >> 2\n",
    ],
)
def test_what_serves_both_or_says_that_it_is_python_3_does_not(source):
    assert not is_python_2(source.encode())
