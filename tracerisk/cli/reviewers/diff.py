"""`tracerisk diff`: what a change does to the risk, by the blocks of two git versions."""

from __future__ import annotations

import argparse
import math
import os
import re
import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING

from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.output import note, print_json, terminal_width, write_alerts, write_file
from tracerisk.cli.shared.sources import read_file
from tracerisk.cli.shared.values import probability
from tracerisk.common.text.printable import escaped
from tracerisk.common.verdict import verdict_line
from tracerisk.errors import ExitCode, InputError
from tracerisk.instrument.source.language import is_c
from tracerisk.pipeline.review.review import review
from tracerisk.pipeline.review.textconv import textconv
from tracerisk.prm.review.change_records import RunVerdicts
from tracerisk.report.ci.open_metrics import render_open_metrics, review_metrics
from tracerisk.report.diff.markdown import render_diff_markdown
from tracerisk.report.diff.sentences import not_assessed, runs_again, whole_headline
from tracerisk.report.diff.text import render_diff
from tracerisk.report.diff.titled_lists import is_asked_less, looks_at_less
from tracerisk.report.diff.wording import first_of

if TYPE_CHECKING:
    from tracerisk.prm.review.risk_diff import Review, RiskDiff


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        "words",
        metavar="REV|FILE",
        nargs="*",
        help="REV, A..B or A...B as git reads them (HEAD against the working tree); then files",
    )
    parser.add_argument(
        "--format",
        choices=["text", "markdown", "json"],
        default="text",
        help="text, Markdown for a pull request, or JSON (text)",
    )
    parser.add_argument(
        "--max-increase",
        metavar="R",
        type=_increase,
        help="exit 1 if a mission's failure probability rises by more than R of it: 0.1 is 10 %%",
    )
    parser.add_argument(
        "--max-failure-probability",
        "--max-risk",
        metavar="P",
        type=probability,
        help="exit 1 if a mission's failure probability is above P after the change, changed or "
        "not, or its run went wrong or is stale",
    )
    shared.add_max_undetected_probability(parser)
    parser.add_argument(
        "--no-new-accepts",
        action="store_true",
        help="exit 1 if the change accepts a reason of its run that was not accepted before",
    )
    parser.add_argument(
        "--no-weaker-checks",
        action="store_true",
        help="exit 1 if `success` asks less, or the controller no longer looks at an answer",
    )
    parser.add_argument(
        "--no-outcome-change",
        action="store_true",
        help="exit 1 if the mission brings about something else (objects, rests, grips, uses of "
        "the cell), or if `success` asks less",
    )
    parser.add_argument(
        "--silent-below",
        metavar="R",
        type=_increase,
        help="print nothing where no mission's failure probability changes by more than R of it",
    )
    parser.add_argument(
        "--textconv",
        metavar="FILE",
        help="print a source with its risk model below it, for `git diff`: `tracerisk docs review`",
    )
    parser.add_argument(
        "--link-base",
        metavar="URL",
        type=_address,
        help="where places in Markdown lead, the address before a commit: "
        "https://github.com/OWNER/NAME/blob (default: what GitHub and GitLab say in their jobs)",
    )
    shared.add_ci_reports(parser)
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    if options.textconv is not None:
        return _textconv(options)
    # An error is JSON too, where JSON was asked for.
    options.json = options.json or options.format == "json"

    limit = options.max_failure_probability
    result = review(options.words, with_others=limit is not None)
    exceeded = [
        line
        for controller in result.controllers
        for line in (
            *_new_accepts(controller, options),
            *_weaker_checks(result, controller, options),
            *_other_outcome(controller, options),
            *_rise(controller, options.max_increase),
            *_above(controller, limit),
            *_undetected(controller, options.max_increase, options.max_undetected_probability),
        )
    ]
    exceeded += [line for controller in result.others for line in _above(controller, limit)]
    code = ExitCode.WOULD_CHANGE if exceeded else ExitCode.FINE
    _write_reports(result, options)
    if options.json:
        _print_json(result, code, exceeded)
    elif options.silent_below is None or result.is_worth_telling(options.silent_below):
        sys.stdout.buffer.write(escaped(_rendered(result, options)).encode())
        sys.stdout.flush()
    for line in exceeded:
        note(f"tracerisk: {line}")
    if not exceeded and options.max_increase is None:
        bad = [diff.name for diff in result.controllers if _bad_run(diff) is not None]
        if bad:
            note(
                f"exit code 0, though {', '.join(bad)} did not pass: --max-increase R makes that "
                "an error",
                quiet=options.quiet,
            )
    return int(code)


def _write_reports(review: Review, options: argparse.Namespace) -> None:
    """Write the files for CI that were asked for."""
    if options.sarif is not None or options.code_quality is not None:
        from tracerisk.pipeline.review.alerts import review_alerts

        write_alerts(options, review_alerts(review))
    if options.metrics is not None:
        write_file(options.metrics, render_open_metrics(review_metrics(review)))


def _print_json(review: Review, code: ExitCode, exceeded: list[str]) -> None:
    from tracerisk.prm.formats.diff_json import review_to_json

    print_json(
        "diff",
        exit_code=int(code),
        headline=whole_headline(review),
        exceeded=exceeded,
        **review_to_json(review),
    )


def _rendered(review: Review, options: argparse.Namespace) -> str:
    if options.format == "markdown":
        base = _link_base(os.environ) if options.link_base is None else options.link_base
        return render_diff_markdown(review, link_base=base or None)

    return render_diff(review, width=terminal_width())


def _textconv(options: argparse.Namespace) -> int:
    if options.words:
        raise InputError("--textconv takes one file and no revision")

    sys.stdout.buffer.write(textconv(read_file(options.textconv), options.textconv))
    sys.stdout.flush()
    return int(ExitCode.FINE)


def _new_accepts(diff: RiskDiff, options: argparse.Namespace) -> list[str]:
    if not options.no_new_accepts or diff.verdicts is None:
        return []
    return [
        f"{diff.name}: newly accepted, and --no-new-accepts: {acceptance}"
        for acceptance in diff.verdicts.new_acceptances
    ]


def _weaker_checks(review: Review, diff: RiskDiff, options: argparse.Namespace) -> list[str]:
    if not options.no_weaker_checks:
        return []
    texts = [is_asked_less(diff)] if diff.asked_less else []
    texts += [looks_at_less(review, diff)] if diff.lost_checks else []
    return [f"{diff.name}: {text}; --no-weaker-checks" for text in texts]


def _other_outcome(diff: RiskDiff, options: argparse.Namespace) -> list[str]:
    if not options.no_outcome_change:
        return []
    texts = [f"{is_asked_less(diff)}; --no-outcome-change"] if diff.asked_less else []
    if diff.outcome is not None:
        lines = diff.outcome.of_mission
        texts += [f"{first_of(lines)}; --no-outcome-change"] if lines else []
    elif diff.verdicts is not None and diff.before is not None and diff.after is not None:
        texts.append(
            "what the mission brings about is not known of both versions; "
            f"{runs_again(diff)} says it, and --no-outcome-change"
        )
    # No log says what C and C++ bring about.
    is_log = is_c(diff.name) and diff.verdicts is None
    if diff.stale and diff.after is not None and not is_log:
        texts.append(f"{not_assessed(diff)}; --no-outcome-change")
    return [f"{diff.name}: {text}" for text in texts]


def _bad_run(diff: RiskDiff) -> str | None:
    """Return why no limit can be held against the newer figure; `None` where one can."""
    verdicts = diff.verdicts if diff.verdicts is not None and diff.verdicts.in_after else None
    if verdicts is not None and verdicts.after is None and verdicts.before is not None:
        given = f"{runs_again(diff)} gives it one"
        return f"the verdict of its run is unknown and was known before; {given}"
    if diff.stale:
        return not_assessed(diff)
    if verdicts is None or verdicts.after is None or not verdicts.after.is_bad:
        return None
    return f"its run is {verdict_line(verdicts.after)}"


def _rise(diff: RiskDiff, most: float | None) -> list[str]:
    """Return how a controller exceeds the limit on the increase; a rise within the noise does not.

    A newer run that went wrong fails it; a base that went wrong is no measure, so that its repair
    passes. So does a rise with a fall of the undetected failure that is no smaller: a check stops
    missions that failed unnoticed before.
    """
    if most is None or diff.after is None:
        return []
    verdicts = diff.verdicts
    bad = _bad_run(diff)
    if bad is None and verdicts is not None and not diff.is_comparable and verdicts.does_less:
        bad = f"its run is {verdict_line(verdicts.after)}"
    if bad is not None:
        return [f"{diff.name}: {bad}; --max-increase {most:g}"]
    # Of two runs of unknown verdict, and of two missions, the figures are all there is.
    unknown = verdicts is not None and verdicts == RunVerdicts(None, None)
    is_other = diff.is_other_mission
    is_measured = diff.are_runs_comparable or unknown or is_other
    if diff.before is None or diff.is_same_figure or diff.is_credited or not is_measured:
        return []
    before, risk = diff.before.failure_probability, diff.after.failure_probability
    if risk <= before * (1.0 + most):
        return []
    rise = f"{100.0 * (risk / before - 1.0):.3g} %" if before > 0.0 else "from zero"
    verb, apart = "rises", ""
    if unknown or is_other:
        verb = "is more"
        why = "different missions" if is_other else "runs of unknown verdict"
        why = "different ways" if is_other and diff.goes_another_way else why
        apart = f", though the figures are not comparable, of {why}"
    elif diff.evidence_change:
        verb, apart = "is more", f", though the figures are not comparable: {diff.evidence_change}"
    return [f"{diff.name}: mission failure {verb} by {rise}, over --max-increase {most:g}{apart}"]


def _above(diff: RiskDiff, limit: float | None) -> list[str]:
    """Return how a controller exceeds the limit on its figure; one of a bad run passes none."""
    if limit is None or diff.after is None:
        return []
    bad, risk = _bad_run(diff), (diff.stated or diff.after).failure_probability
    texts = [] if bad is None else [f"{bad}; --max-failure-probability {limit:g}"]
    if risk > limit:
        texts.append(f"mission failure {risk:.4g} is over --max-failure-probability {limit:g}")
    return [f"{diff.name}: {text}" for text in texts]


def _undetected(diff: RiskDiff, max_increase: float | None, limit: float | None) -> list[str]:
    """Return which limits the undetected failure of a controller exceeds.

    Where nothing is said of what follows a failure, nobody is known to notice any.
    """
    if diff.after is None:
        return []
    texts = []
    if max_increase is not None and diff.undetected is not None and _bad_run(diff) is None:
        before, now = diff.undetected
        if diff.undetected_increase > max_increase * before:
            rise = f"{100.0 * (now / before - 1.0):.3g} %" if before > 0.0 else "from zero"
            texts.append(
                f"{diff.name}: undetected failure rises by {rise}, "
                f"over --max-increase {max_increase:g}"
            )
    undetected = (diff.stated or diff.after).undetected_or_all
    if limit is not None and undetected > limit:
        texts.append(
            f"{diff.name}: undetected failure {undetected:.4g} is over "
            f"--max-undetected-probability {limit:g}"
        )
    return texts


def _link_base(environment: Mapping[str, str]) -> str:
    """Return where the files of a commit are, as the environment of a CI job says; else empty."""
    server, name = environment.get("GITHUB_SERVER_URL"), environment.get("GITHUB_REPOSITORY")
    if server and name:
        return _address(f"{server}/{name}/blob")
    project = environment.get("CI_PROJECT_URL")
    return _address(f"{project}/-/blob") if project else ""


def _address(text: str) -> str:
    if text and not re.fullmatch(r"https?://[\w.~:/%+@-]+", text):
        raise argparse.ArgumentTypeError(
            f"{text!r} is no address such as https://github.com/OWNER/NAME/blob"
        )
    return text


def _increase(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0.0 <= value < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is not a share from 0 up, such as 0.1 for 10 %")
    return value
