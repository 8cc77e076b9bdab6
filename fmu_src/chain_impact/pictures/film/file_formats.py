"""The files of films: Pillow writes a gif, PyAV an mp4."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import to_rgb

from chain_impact.extras import require

SHADES = 6  # number of shades of each colour in a gif: the colour itself, and mixtures with the ground
# A mixture with the ground is left out if each of its red, green and blue, from 0 to 1, differs by at most
# GROUND_DISTANCE from that of the ground, because Pillow would give this mixture to pixels of the ground.
GROUND_DISTANCE = 0.04
HOLD = 1.5  # [s] the time for which a gif shows its last frame before the film starts again
GIF_END = b";"  # the last byte of a gif
QUALITY = "20"  # the quality of H.264: 0 has no loss, 51 is the worst


def write_gif(
    pictures: Iterable[np.ndarray], path: Path, rate: int, colours: Iterable[Any], ground: Any = "white"
) -> None:
    """Write pictures as a gif. The file has the first picture, and of each change the rectangle that changes.

    Args:
        pictures: red, green, blue of each pixel of each picture, shape (height, width, 3).
        path: the file.
        rate: pictures per second.
        colours: the colours of the gif without the ground; mixtures of each with the ground are added.
        ground: the colour of the ground.
    """
    from PIL import Image
    from PIL.GifImagePlugin import getdata, getheader

    exact_colours = np.array([to_rgb(colour) for colour in colours])
    share = np.linspace(0.0, 1.0, SHADES, endpoint=False)[:, None, None]
    back = np.array(to_rgb(ground))
    shades = np.concatenate([back[None], (exact_colours + share * (back - exact_colours)).reshape(-1, 3)])
    shades = shades[(shades == back).all(axis=1) | (np.abs(shades - back) > GROUND_DISTANCE).any(axis=1)]
    palette = Image.new("P", (1, 1))
    palette.putpalette(np.rint(255.0 * shades).astype(np.uint8).tobytes())
    options: dict[str, Any] = {"palette": palette, "dither": Image.Dither.NONE}
    # the frames are written one by one, because Pillow's own `save` would keep all frames in memory
    with path.open("wb") as file:
        for part, corner, seconds in _changes(
            (Image.fromarray(picture).quantize(**options) for picture in pictures), rate
        ):
            if file.tell() == 0:
                file.writelines(getheader(part, info={"loop": 0})[0])
            file.writelines(getdata(part, corner, duration=round(1000 * seconds)))
        file.write(GIF_END)


def _changes(frames: Iterator[Any], rate: int) -> Iterator[tuple[Any, tuple[int, int], float]]:
    """Yield the first frame, and the changed rectangle of each frame that differs from the frame before it.

    The first frame and each rectangle come with their upper left corner [pixels] and with a duration [s]: the
    time until the next change or, after the last change, the time until the last frame plus HOLD.
    """
    from PIL.ImageChops import difference

    last = next(frames)
    part, corner, count = last, (0, 0), 1
    for frame in frames:
        if box := difference(last, frame).getbbox():
            yield part, corner, count / rate
            part, corner, count = frame.crop(box), box[:2], 0
        last, count = frame, count + 1
    yield part, corner, (count - 1) / rate + HOLD


def write_mp4(pictures: Iterable[np.ndarray], path: Path, rate: int, size: tuple[int, int]) -> None:
    """Write pictures as an mp4 with H.264, which browsers and slide programs can play.

    ``pictures`` and ``rate`` are as in ``write_gif``; ``size``: width and height [pixels], even numbers.
    """
    av = require("av", "video")
    with av.open(str(path), "w", format="mp4", options={"movflags": "faststart"}) as container:
        stream = container.add_stream("libx264", rate=rate, options={"crf": QUALITY})
        stream.width, stream.height = size
        stream.pix_fmt = "yuv420p"
        for picture in pictures:
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        container.mux(stream.encode())
