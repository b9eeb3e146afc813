"""The verbs of the command: what each does, who needs it, and the file that carries it out."""

from __future__ import annotations

GROUPS = {
    "for authors of controllers": {
        "run": "run a controller on the twin, annotate it, solve its risk model",
        "trace": "run a controller and print which hardware each function used",
        "attach": "listen to a real robot; print what each function used",
        "scenario": "list a controller's needs; write a scenario that meets them",
        "success": "draft what the mission is from what a good run brought about",
        "check": "check, without a simulation, whether blocks can be trusted",
        "refresh": "bring blocks up to date, simulating only what is stale",
        "annotate": "write risk blocks into a controller from a trace or a log",
        "strip": "remove the risk blocks from sources, every other byte kept",
    },
    "for reviewers of changes": {
        "diff": "print what a change between git versions does to the risk",
        "history": "print how the risk went over the commits, and what raised it",
        "report": "write an HTML report of annotated sources that needs no network",
        "serve": "show a repository's risk in a browser on this machine alone",
        "overrides": "list what was set by hand in blocks, why, and how it drifted",
    },
    "for safety engineers": {
        "hardware": "convert, show, start or update a hardware description",
        "evidence": "fail each unit on the twin and tabulate the effects (FMEA)",
        "sweep": "run a controller over values of settings, parameters, scenario",
        "mutate": "change a controller, place by place; list what none notices",
        "field": "sum up recorded missions: visits, times, what follows",
        "build": "build the risk model from the blocks in sources alone",
        "solve": "solve a model, or the blocks in sources, exactly",
        "cut-sets": "count, sum and list the minimal cut sets of a fault tree",
        "convert": "write a model as Open-PSA, OpenPRA, Galileo, PRISM or .tra",
    },
    "to set up": {
        "init": "write what a repository needs to begin, after showing it",
        "lsp": "serve an editor: figures, findings and fixes where you write",
        "robots": "list the robots that are shipped, or show what one of them has",
        "drivers": "list drivers, or check the description of one",
        "headers": "make C++ headers of messages that this machine lacks",
        "schema": "print a JSON Schema, by which editors complete and check files",
        "docs": "print a page of the documentation, or list all pages",
        "doctor": "check that everything that tracerisk needs works here",
        "lock-merge": "merge tracerisk.lock for git; --install sets git up for it",
        "completion": "print the script by which a shell completes this command",
    },
}
"""What each verb does, by who needs it."""
VERBS = {verb: summary for group in GROUPS.values() for verb, summary in group.items()}
ROOMS = {
    "for authors of controllers": "authors",
    "for reviewers of changes": "reviewers",
    "for safety engineers": "safety_engineers",
    "to set up": "set_up",
}
"""The folder with the verbs of each group."""
_ROOM_OF = {verb: ROOMS[title] for title, group in GROUPS.items() for verb in group}


def module_of(verb: str) -> str:
    """Return the name of the module that carries out a verb."""
    return f"tracerisk.cli.{_ROOM_OF[verb]}.{verb.replace('-', '_')}"
