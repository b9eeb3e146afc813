"""Put the frames of a film together, within the process that draws them: GIF by Pillow, MP4 by av.

A frame has a caption of one height, so that all frames have the same size.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

CAPTION = 64
"""How high the caption below a frame is [px]."""
_MARGIN = 14
_GAP = 6  # between frames beside each other [px]
_COLOURS = 96  # of the palette that all frames of a GIF share
_PAPER, _INK, _MUTED = "#ffffff", "#1b1d21", "#565b64"
_PALETTE_FRAMES = 8  # from which the palette is taken, evenly over the film


def framed(image: Image.Image, picture: dict[str, Any]) -> Image.Image:
    """Return a frame with its caption: the function and the time, and how many do what."""
    head, body = (ImageFont.load_default(size) for size in (18, 14))
    page = Image.new("RGB", (image.width, image.height + CAPTION), _PAPER)
    page.paste(image, (0, 0))
    pen = ImageDraw.Draw(page)
    when, *rows = picture["rows"]
    right = page.width - _MARGIN - body.getlength(when["text"])
    title = picture["title"]
    while head.getlength(title) > right - 2 * _MARGIN and len(title) > 1:
        title = title[:-2] + "\N{HORIZONTAL ELLIPSIS}"
    pen.text((_MARGIN, image.height + 10), title, font=head, fill=_INK)
    pen.text((right, image.height + 13), when["text"], font=body, fill=_MUTED)
    x, y = float(_MARGIN), image.height + 38
    for row in rows:
        pen.rounded_rectangle((x, y + 2, x + 12, y + 14), 3, fill=row["colour"])
        pen.text((x + 18, y), row["text"], font=body, fill=_MUTED)
        x += 18 + body.getlength("grasping 00") + 2 * _MARGIN
    return page


def side_by_side(frames: Iterable[Image.Image], count: int) -> Iterator[Image.Image]:
    """Yield frames with so many of them beside each other."""
    waiting: list[Image.Image] = []
    for frame in frames:
        waiting.append(frame)
        if len(waiting) < count:
            continue
        width = sum(image.width for image in waiting) + _GAP * (count - 1)
        page = Image.new("RGB", (width, frame.height), _PAPER)
        left = 0
        for image in waiting:
            page.paste(image, (left, 0))
            left += image.width + _GAP
        waiting = []
        yield page


def write_gif(frames: Sequence[Image.Image], path: Path, frame_s: float) -> None:
    """Write frames as a GIF that repeats; the same frames give the same bytes.

    All share one palette, so that what stands still stays the same from frame to frame.
    """
    step = max(1, len(frames) // _PALETTE_FRAMES)
    chosen = frames[::step]
    sheet = Image.new("RGB", (frames[0].width, frames[0].height * len(chosen)))
    for number, image in enumerate(chosen):
        sheet.paste(image, (0, number * image.height))
    palette = sheet.quantize(_COLOURS, method=Image.Quantize.MEDIANCUT)
    still = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    first, *others = still
    first.save(
        path,
        format="GIF",
        save_all=True,
        append_images=others,
        duration=round(1000 * frame_s),
        loop=0,
        optimize=False,
        disposal=1,
    )


def write_mp4(frames: Sequence[Image.Image], path: Path, frame_s: float) -> None:
    """Write frames as H.264 in MP4, as browsers play it."""
    import av

    with av.open(str(path), "w", options={"movflags": "faststart"}) as container:
        stream = container.add_stream("libx264", rate=Fraction(round(1 / frame_s)))
        # H.264 halves the colours: sides are even.
        stream.width, stream.height = (side // 2 * 2 for side in frames[0].size)
        stream.pix_fmt = "yuv420p"
        stream.options = {"crf": "23", "preset": "medium", "threads": "1"}
        for frame in frames:
            pixels = np.asarray(frame)[: stream.height, : stream.width]
            for packet in stream.encode(av.VideoFrame.from_ndarray(pixels, format="rgb24")):
                container.mux(packet)
        for packet in stream.encode():
            container.mux(packet)
