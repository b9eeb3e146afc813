"""`python -m tracerisk_probe [options] FILE [arguments]`."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from tracerisk_probe.starting import controller_name, own_code, record, run_module, run_script


def main() -> None:
    """Run a controller and record its commands; exit as it does, with 2 where it cannot run."""
    parser = argparse.ArgumentParser(
        prog="python -m tracerisk_probe",
        description="Run a controller, and record each command with the functions that issued it.",
    )
    parser.add_argument("--out", metavar="FILE", help="write the commands to a file")
    parser.add_argument("--root", metavar="DIR", help="the folder of the controller's own code")
    parser.add_argument(
        "--package",
        metavar="NAME",
        action="append",
        default=[],
        help="an installed Python package that is the controller's own; repeatable",
    )
    parser.add_argument("--no-publish", action="store_true", help="publish nothing")
    parser.add_argument("-m", dest="module", metavar="MODULE", help="run a module")
    parser.add_argument("program", nargs=argparse.REMAINDER, metavar="FILE [ARGUMENT ...]")
    options = parser.parse_args()
    arguments = list(options.program)
    if options.module is None and not arguments:
        parser.error("FILE is missing: name the controller's Python file, or a module by -m")
    try:
        if options.module is not None:
            top = options.module.partition(".")[0]
            own = own_code(Path("module.py").absolute(), options.root, [*options.package, top])
            record(own, options.module, options.out, publish=not options.no_publish)
        else:
            script = Path(arguments[0])
            if not script.is_file():
                parser.error(f"{script}: there is no such file; name the controller's Python file")
            own = own_code(script, options.root, options.package)
            name = controller_name(own, script)
            record(own, name, options.out, publish=not options.no_publish)
    except OSError as error:
        parser.error(f"{error.filename or options.out}: cannot be written: {error.strerror}")
    if options.module is not None:
        run_module(options.module, arguments)
    else:
        run_script(script, arguments[1:], own)


if __name__ == "__main__":
    main()
    sys.exit(0)
