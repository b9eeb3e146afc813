"""Draw pictures with MuJoCo's renderer, in a process that has a context of OpenGL.

Started as `python -m tracerisk.report.png.child FOLDER` with `MUJOCO_GL` set and the pictures as
JSON on standard input. It writes `READY` once OpenGL answers: what fails before that is the
machine's.
"""

from __future__ import annotations

import gc
import io
import json
import math
import sys
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from PIL import Image, ImageDraw, ImageFont, PngImagePlugin

from tracerisk.common.sandbox.limited_process import mark_start
from tracerisk.report.png.film_child import framed, side_by_side, write_gif, write_mp4

READY = "ready"
_OVERSAMPLED = 2  # drawn larger and scaled down: edges are smooth whatever the driver offers
_MARGIN = 24
_PAPER, _INK, _MUTED, _GROUND = "#ffffff", "#1b1d21", "#565b64", "#dde2e9"
_BELOW = 0.003  # the ground lies so far below what stands at z = 0 [m]

_GEOMS = {
    "box": mujoco.mjtGeom.mjGEOM_BOX,
    "sphere": mujoco.mjtGeom.mjGEOM_SPHERE,
    "capsule": mujoco.mjtGeom.mjGEOM_CAPSULE,
    "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
}


def main() -> int:
    """Draw the pictures of standard input into the folder of the command line."""
    gc.enable()
    request = json.load(sys.stdin)
    folder = Path(sys.argv[1])
    width, height = request["size"]
    context = mujoco.GLContext(width * _OVERSAMPLED, height * _OVERSAMPLED)
    context.make_current()
    # Where a driver is missing, it is only when something is drawn that this shows.
    _rendered(mujoco.MjSpec().compile(), None, 16, 16)
    sys.stdout.write(f"{READY}\n")
    sys.stdout.flush()
    mark_start()
    pictures = request["pictures"]
    images = (_drawn(picture, width, height) for picture in pictures)
    if request["films"]:
        single = (framed(image, item) for image, item in zip(images, pictures, strict=True))
        frames = list(side_by_side(single, request["beside"]))
        for name in request["films"]:
            write = {"gif": write_gif, "mp4": write_mp4}[name]
            write(frames, folder / f"film.{name}", request["frame_s"])
    else:
        for number, (image, picture) in enumerate(zip(images, pictures, strict=True)):
            (folder / f"{number}.png").write_bytes(_png(_captioned(image, picture), picture))
    context.free()
    return 0


def _drawn(picture: dict[str, Any], width: int, height: int) -> Image.Image:
    spec = _spec(picture, width, height)
    return Image.fromarray(_rendered(spec.compile(), picture["camera"], width, height))


def _spec(picture: dict[str, Any], width: int, height: int) -> Any:
    """Return a model of what is seen; nothing in it moves."""
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    spec.visual.global_.offwidth = width * _OVERSAMPLED
    spec.visual.global_.offheight = height * _OVERSAMPLED
    spec.visual.quality.offsamples = 0
    spec.visual.quality.numslices = 64
    spec.visual.quality.numstacks = 32
    spec.visual.headlight.ambient = (0.45, 0.45, 0.45)
    spec.visual.headlight.diffuse = (0.38, 0.38, 0.38)
    spec.visual.headlight.specular = (0.05, 0.05, 0.05)
    target, eye = picture["camera"]["target"], picture["camera"]["eye"]
    reach = math.dist(target, eye)
    spec.visual.map.znear = 0.1
    spec.visual.map.zfar = 20.0
    spec.stat.extent = max(reach, 1e-3)
    world = spec.worldbody
    world.add_light(
        pos=(target[0] - 0.2 * reach, target[1] + 0.5 * reach, target[2] + 1.6 * reach),
        dir=(0.12, -0.3, -1.0),
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        diffuse=(0.48, 0.48, 0.48),
        specular=(0.08, 0.08, 0.08),
        # Shadows speckle large floors where the shadow map ends.
        castshadow=False,
    )
    # The camera looks down by more than half its field: it sees no end of the plane.
    world.add_geom(
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=(0.0, 0.0, 1.0),
        pos=(0.0, 0.0, -_BELOW),
        rgba=(*_rgb(_GROUND), 1.0),
    )
    for index, solid in enumerate(picture["solids"]):
        _add(spec, world, index, solid)
    return spec


def _add(spec: Any, world: Any, index: int, solid: dict[str, Any]) -> None:
    placed = {
        "pos": solid["xyz"],
        "quat": solid["quaternion"],
        "rgba": (*_rgb(solid["colour"]), 1.0),
        "contype": 0,
        "conaffinity": 0,
    }
    if solid["kind"] != "mesh":
        size = [*solid["size"], 0.0, 0.0][:3]
        world.add_geom(type=_GEOMS[solid["kind"]], size=size, **placed)
        return
    points = np.array(solid["triangles"], dtype=np.float64)
    faces = np.arange(len(points) // 3, dtype=np.int32)
    mesh = spec.add_mesh(
        name=f"mesh{index}",
        uservert=points,
        userface=faces,
        # A square of a plane has no volume.
        inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
    )
    world.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh.name, **placed)


def _rendered(model: Any, seen_from: dict[str, Any] | None, width: int, height: int) -> Any:
    """Return the pixels (height, width, 3) of a model, drawn larger by `_OVERSAMPLED`."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    camera = mujoco.MjvCamera()
    if seen_from is not None:
        across = [e - t for e, t in zip(seen_from["eye"], seen_from["target"], strict=True)]
        distance = math.hypot(*across)
        camera.lookat[:] = seen_from["target"]
        camera.distance = distance
        # MuJoCo gives where the camera looks to, not where it stands.
        camera.azimuth = math.degrees(math.atan2(-across[1], -across[0]))
        camera.elevation = math.degrees(-math.asin(across[2] / distance))
        model.vis.global_.fovy = math.degrees(seen_from["field"])
    scene = mujoco.MjvScene(model, maxgeom=10_000)
    options = mujoco.MjvOption()
    mujoco.mjv_updateScene(
        model, data, options, None, camera, mujoco.mjtCatBit.mjCAT_ALL.value, scene
    )
    drawing = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100.value)
    mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, drawing)
    area = mujoco.MjrRect(0, 0, width * _OVERSAMPLED, height * _OVERSAMPLED)
    pixels = np.empty((area.height, area.width, 3), dtype=np.uint8)
    mujoco.mjr_render(area, scene, drawing)
    mujoco.mjr_readPixels(pixels, None, area, drawing)
    drawing.free()
    if seen_from is None:
        return pixels
    large = Image.fromarray(pixels[::-1])
    return np.asarray(large.resize((width, height), Image.Resampling.BOX))


def _captioned(image: Image.Image, picture: dict[str, Any]) -> Image.Image:
    """Return the picture with its caption below it."""
    head, body = (ImageFont.load_default(size) for size in (26, 17))
    width = image.width
    room = width - 2 * _MARGIN
    title = _wrapped(picture["title"], head, room)
    lines: list[tuple[str, str | None, int, bool]] = []
    for rank, row in enumerate(picture["rows"]):
        indent = 26 if row["colour"] is not None else 0
        is_muted = rank in (0, len(picture["rows"]) - 1)
        for part, text in enumerate(_wrapped(row["text"], body, room - indent)):
            lines.append((text, row["colour"] if part == 0 else None, indent, is_muted))
    top = image.height
    height = top + 18 + 34 * len(title) + 25 * len(lines) + 16
    page = Image.new("RGB", (width, height), _PAPER)
    page.paste(image, (0, 0))
    pen = ImageDraw.Draw(page)
    y = top + 14
    for text in title:
        pen.text((_MARGIN, y), text, font=head, fill=_INK)
        y += 34
    y += 4
    for text, colour, indent, is_muted in lines:
        if colour is not None:
            pen.rounded_rectangle((_MARGIN, y + 3, _MARGIN + 15, y + 18), 3, fill=colour)
        pen.text((_MARGIN + indent, y), text, font=body, fill=_MUTED if is_muted else _INK)
        y += 25
    return page


def _wrapped(text: str, font: Any, room: float) -> list[str]:
    """Return a text in lines that are no wider than `room` [px]; a long word is cut."""
    lines: list[str] = []
    line = ""
    for word in text.split(" "):
        longer = f"{line} {word}" if line else word
        if font.getlength(longer) <= room:
            line = longer
            continue
        if line:
            lines.append(line)
        line = word
        while font.getlength(line) > room:
            cut = next(
                n for n in range(len(line), 0, -1) if n == 1 or font.getlength(line[:n]) <= room
            )
            lines.append(line[:cut])
            line = line[cut:]
    return [*lines, line]


def _png(image: Image.Image, picture: dict[str, Any]) -> bytes:
    words = PngImagePlugin.PngInfo()
    words.add_itxt("Title", picture["title"])
    words.add_itxt("Description", "\n".join(row["text"] for row in picture["rows"]))
    written = io.BytesIO()
    image.save(written, format="PNG", pnginfo=words, optimize=True)
    return written.getvalue()


def _rgb(colour: str) -> tuple[float, float, float]:
    red, green, blue = (int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5))
    return red, green, blue


if __name__ == "__main__":
    sys.exit(main())
