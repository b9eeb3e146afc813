"""Sources of Python 2 do what Python 2 does with them; what is expected is from its manual."""

import sys
from pathlib import Path

import pytest

from tracerisk.instrument.import_finder import ControllerFinder, controller_imports
from tracerisk.instrument.loader import run_controller
from tracerisk.instrument.tracer import Tracer

PRINTED = {
    "division": ("print 7 / 2, -7 / 2, 7 / 2.0, 7 // 2, 7 % 2", "3 -4 3.5 3 1"),
    "division of the future": (
        "from __future__ import division\nprint 7 / 2\nx = 7\nx /= 2\nprint x",
        "3.5\n3.5",
    ),
    "division in place": (
        "x = 7\nx /= 2\nl = [9, 7]\nn = []\n"
        "def at():\n    n.append(1)\n    return 1\n"
        "l[at()] /= 2\nclass A: v = 9\nA.v /= 2\nprint x, l, n, A.v",
        "3 [9, 3] [1] 4",
    ),
    "division of arrays": (
        "import numpy as np\na = np.array([4., 6.])\nb = a\na /= 4\nprint np.array([1, 3]) / 2, b, np.fromstring('\\x01\\x02', 'uint8')",
        "[0 1] [1.  1.5] [1 2]",
    ),
    "comparison": (
        "print None < 0, 0 < 'a', [1] < 'a', (1,) > None, sorted([3, None, 'b', 1.5, 'a'])",
        "True True True True [None, 1.5, 3, 'a', 'b']",
    ),
    "a chain of comparisons": (
        "calls = []\ndef two():\n    calls.append(2)\n    return 2\n"
        "print 1 < two() <= 2 != 3, 3 < two() < 9, calls, min(3, None), max([1, 'a'])",
        "True False [2, 2] None a",
    ),
    "rounding": (
        "print round(2.5), round(-0.5), round(2.675, 2), round(1234, -2)",
        "3.0 -1.0 2.67 1200.0",
    ),
    "lists": (
        "print range(3), map(None, [1, 2], [3]), zip([1], 'a'), filter(None, [0, 1]), filter(str.isdigit, 'a1'), map(str, xrange(2))",
        "[0, 1, 2] [(1, 3), (2, None)] [(1, 'a')] [1] 1 ['0', '1']",
    ),
    "dictionaries": (
        "d = {'a': 1}\nprint d.keys()[0], d.values()[0], d.items(), d.has_key('a'), d.iteritems().next()",
        "a 1 [('a', 1)] True ('a', 1)",
    ),
    "dictionaries of one's own": (
        "class D(dict):\n    def keys(self):\n        return 'mine'\n"
        "    def has_key(self, name):\n        return 'asked'\nprint D().keys(), D().has_key(1)",
        "mine asked",
    ),
    "sorting by a function": (
        "l = [3, 1, 2]\nl.sort(lambda a, b: b - a)\nprint l, sorted(l, cmp=lambda a, b: a - b), sorted(l, key=lambda a: -a)",
        "[3, 2, 1] [1, 2, 3] [3, 2, 1]",
    ),
    "names": (
        "print unicode('a', 'utf-8'), isinstance('a', unicode), isinstance(1, long), long('3'), unichr(97), reduce(lambda a, b: a + b, [1, 2]), cmp(2, 1), type(u'') == unicode, apply(max, (1, 2))",
        "a True True 3 a 3 1 True 2",
    ),
    "exceptions": (
        "try:\n    raise ValueError, 'bad'\nexcept ValueError, e:\n    pass\nprint e, e.message",
        "bad bad",
    ),
    "a generator that says its end": (
        "def two():\n    yield 1\n    yield 2\n    raise StopIteration\nprint list(two())",
        "[1, 2]",
    ),
    "generators that end with what they go through": (
        "def all_of(values):\n    'Doc.'\n    values = iter(values)\n    while True:\n        yield values.next()\n"
        "def caught():\n    try:\n        yield 1\n        raise StopIteration\n    except Exception:\n        yield 2\n"
        "print list(all_of('ab')), all_of.__doc__, list(caught())",
        "['a', 'b'] Doc. [1, 2]",
    ),
    "exceptions that are unpacked": (
        "class A: pass\na = A()\ntry:\n    raise IOError(2, 'gone')\n"
        "except (OSError, IOError), (number, text):\n    if number: print number, text\n"
        "try:\n    raise KeyError, 'k'\nexcept KeyError, a.e: print repr(a.e)",
        "2 gone\nKeyError('k')",
    ),
    "literals": (
        "print 0777, 10L, `1`, ur'\\d', '\\u00e9' == '\\\\u00e9', 1 <> 2",
        "511 10 1 \\d True True",
    ),
    "exec and eval": ("exec 'y = 7 / 2; print y,'\nprint eval('7 / 2'), eval(' 8/3')", "3 3 2"),
    "exec in a space": ("n = {'a': 7}\nexec 'b = a / 2' in n\nprint n['b']", "3"),
    "print": (
        "import sys\nprint 'a',\nprint 'b'\nprint ('a', 1)\nprint\nprint >>sys.stdout, 'c'",
        "a b\n('a', 1)\n\nc",
    ),
    "tuple parameters": (
        "def f((a, (b, c)), d=1):\n    '''Doc.'''\n    return a, b, c, d\nprint f((1, (2, 3))), f.__doc__, map(lambda (a, b): a + b, [(1, 2)])",
        "(1, 2, 3, 1) Doc. [3]",
    ),
    "tuple parameters of lambdas": (
        "class P: k = 7\n"
        "print reduce(lambda n, (a, b): n + a * b, [(1, 2), (3, 4)], 0), (lambda (k, p): (p.k <> k, `p.k / 2`))((1, P()))\n"
        "print (lambda (a, (b, c)), (d,), e=5: dict(a=a, e=b + c + d + e))((1, (2, 3)), (4,)), map(lambda (x): x, [(1,)]), map(lambda ((x, y)): y, [(1, 2)])\n"
        "print map(lambda (a, b): (lambda (c, d): a + d)((0, b)), [(1, 2)])",
        "14 (True, '3')\n{'a': 1, 'e': 14} [(1,)] [2]\n[3]",
    ),
    "new keywords as names": ("def f(async=1):\n    return async\nprint f(async=3)", "3"),
    "classes": (
        "class N:\n    def __init__(self, n): self.n = n\n    def next(self):\n"
        "        if self.n == 0: raise StopIteration\n        self.n -= 1\n        return self.n\n"
        "    def __iter__(self): return self\n    def __nonzero__(self): return False\n"
        "    def __cmp__(self, other): return cmp(self.n, other.n)\n"
        "    def __div__(self, by): return 'divided by %s' % by\n"
        "print list(N(3)), bool(N(3)), N(1) < N(2), N(1) == N(1), N(1) / 2, len(set([N(1)])), N(3).next()",
        "[2, 1, 0] False True True divided by 2 1 2",
    ),
    "metaclasses": (
        "class M(type):\n    def __new__(m, name, bases, d):\n        d['made'] = 7 / 2\n        return type.__new__(m, name, bases, d)\n"
        "class A(object):\n    __metaclass__ = M\nprint A.made",
        "3",
    ),
    "modules of the library": (
        "import Queue, ConfigParser, cPickle, StringIO, thread, urllib2, urlparse, commands\n"
        "from urllib import urlencode, quote\nfrom itertools import izip, imap\nimport string, sys, os, math, struct, operator\n"
        "q = Queue.Queue()\nq.put(1)\nprint q.get(), urlencode({'a': 1}), list(izip([1], [2])), string.letters[:2], string.join(['a', 'b'])\n"
        "print sys.maxint > 1, os.path.join('a', 'b'), math.floor(7.5) / 2, struct.unpack('<h', struct.pack('<h', 7)), operator.div(7, 2)\n"
        "print cPickle.loads(cPickle.dumps([1, 'a'])), StringIO.StringIO('x').read(), ascii(struct.pack('<B', 200)), urlparse.urlparse('a://b').netloc",
        "1 a=1 [(1, 2)] ab a b\nTrue a/b 3.5 (7,) 3\n[1, 'a'] x '\\xc8' b",
    ),
    "all of a module": (
        "from math import *\nfrom string import *\nprint floor(2.5), upper('a')",
        "2.0 A",
    ),
    "setting a name of a module": (
        "import os, math\nmath.mine = 3\nimport math\nprint math.mine",
        "3",
    ),
    "texts": (
        "print 'a'.encode('hex'), '61'.decode('hex'), u'\\xe9'.encode('utf-8') == u'\\xe9', b'\\xe9' == '\\xe9', ord(u'a')",
        "61 a True True 97",
    ),
    "letters in the place of others": (
        "import string\nswapped = string.maketrans('ab', 'xy')\n"
        "print 'abc'.translate(None, 'b'), 'abc'.translate(swapped, 'c'), string.translate('abc', swapped)",
        "ac xy xyc",
    ),
    "all of a module in a function": (
        "def f():\n    from math import *\n    return floor(7 / 2)\nprint f()",
        "3.0",
    ),
    "tabs": ("if 1:\n\tx = 1\n        y = '''\n\ta'''\n\tprint x, repr(y)", "1 '\\n\\ta'"),
}


REFUSED = {
    "a range to a float": "range(7 / 2.0)",
    "a lazy range to a float": "xrange(3.0)",
    "a text that is rounded": "round('2.5')",
    "sets have no order with numbers": "set() < 3",
    "dates have no order with numbers": "import datetime\nsorted([datetime.date(2020, 1, 1), 3])",
    "complex numbers have no order": "cmp(1j, 2)",
    "times have no order with numbers": "from tracerisk.ros.time.rostime import Time\nTime(1) > 0.5",
    "what a class refuses": (
        "class A(object):\n    def __cmp__(self, other): raise TypeError('no')\nmax(3, A())"
    ),
    "letters that the encoding lacks": "u'\\xe9'.encode('ascii')",
    "bytes that the encoding lacks": "'\\xe9'.decode('us-ascii')",
}


def run(folder: Path, source: str, **modules: str) -> Tracer:
    for name, text in modules.items():
        path = folder / f"{name.replace('_in_', '/')}.py"
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
    path = folder / "c.py"
    path.write_text(source + "\n")
    tracer = Tracer()
    with controller_imports(ControllerFinder(tracer, folder)):
        run_controller(path, tracer, root=folder)
    return tracer


@pytest.mark.parametrize("name", PRINTED)
def test_a_source_prints_what_it_prints_in_python_2(name, tmp_path, capsys):
    source, expected = PRINTED[name]
    run(tmp_path, source)
    assert capsys.readouterr().out == f"{expected}\n"


@pytest.mark.parametrize("name", REFUSED)
def test_what_python_2_refuses_is_refused(name, tmp_path):
    with pytest.raises((TypeError, UnicodeError)):
        run(tmp_path, f"print 'begun'\n{REFUSED[name]}")


def test_input_is_evaluated_and_raw_input_is_not(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("builtins.input", lambda prompt="": "7 / 2")
    run(tmp_path, "print input('? '), raw_input()")
    assert capsys.readouterr().out == "3 7 / 2\n"


def test_each_module_is_read_by_its_own_python(tmp_path, capsys):
    run(
        tmp_path,
        "import new, old\nprint new.half(7), old.half(7), 7 / 2",
        new="def half(n: int) -> float:\n    return n / 2\n",
        old="def half(n):\n    print '',\n    return n / 2\n",
    )
    assert capsys.readouterr().out.split() == ["3.5", "3", "3"]


def test_a_module_beside_the_one_that_imports_it_needs_no_dot(tmp_path, capsys):
    run(
        tmp_path,
        "import pack.user\nprint 'done'",
        pack_in___init__="",
        pack_in_user="import helper\nfrom helper import name\nprint helper.__name__, name\n",
        pack_in_helper="name = 'near'\n",
    )
    assert capsys.readouterr().out == "pack.helper near\ndone\n"


def test_a_package_of_the_workspace_outside_the_root_is_converted_too(tmp_path, capsys):
    root = tmp_path / "root"
    root.mkdir()
    package = tmp_path / "other" / "arms"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text("import limb\nprint limb.half(7)\n")
    (package / "limb.py").write_text("def half(n):\n    print '',\n    return n / 2\n")
    (root / "c.py").write_text("import arms\n")
    tracer = Tracer()
    packages = {"arms": package.parent}
    with controller_imports(ControllerFinder(tracer, root, packages=packages)):
        run_controller(root / "c.py", tracer, root=root)
    assert capsys.readouterr().out.split() == ["3"]
    for name in ("arms", "arms.limb"):
        sys.modules.pop(name, None)


def test_functions_keep_their_names_lines_and_tracebacks(tmp_path):
    tracer = Tracer()
    path = tmp_path / "c.py"
    path.write_text(
        "class A:\n\n    def next(self, (a, b)):\n        return a / b\n\nA().next((1, 0))\nprint 1\n"
    )
    with pytest.raises(ZeroDivisionError) as caught:
        run_controller(path, tracer, root=tmp_path)
    place = tracer.where_failed(caught.value)
    assert (place.file, place.line) == ("c.py", 4)
