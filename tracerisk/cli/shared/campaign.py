"""The options of the verbs that carry out a campaign of runs."""

from __future__ import annotations

import argparse
from collections.abc import Callable

from tracerisk.cli.shared.values import count, positive, shard
from tracerisk.common.campaign import CampaignOptions


def add_campaign_options(group: argparse._ActionsContainer, thing: str) -> None:
    """Add what all that is run in many parts has: `--time`, `-j`, `--shard`, `--fresh`."""
    group.add_argument(
        "--time",
        metavar="SECONDS",
        type=positive,
        help="end after this, with what was tried by then; the same command goes on from there",
    )
    group.add_argument(
        "-j", "--jobs", metavar="N", type=count, help="processes (default: one a core)"
    )
    group.add_argument(
        "--shard", metavar="I/N", type=shard, default=(1, 1), help=f"try every N-th {thing} alone"
    )
    group.add_argument("--fresh", action="store_true", help="try again what was tried before")


def campaign_options(
    options: argparse.Namespace,
    progress: Callable[[int, int, float], None] | None,
    noted: Callable[[str], None] | None = None,
) -> CampaignOptions:
    """Return how the runs of a campaign are carried out."""
    return CampaignOptions(
        jobs=options.jobs,
        most_s=options.time,
        shard=options.shard,
        fresh=options.fresh,
        progress=progress,
        noted=noted,
    )
