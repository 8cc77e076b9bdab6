"""The animation as a film: frames drawn by matplotlib, packed by Pillow (gif) or PyAV (mp4)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from chain_impact.extras import require
from chain_impact.results.animation.film_page import COLOURS, ROOM, STYLE, FilmPage
from chain_impact.results.animation.frames import Motion

DPI, LEAST_DPI, SMALL_DPI = 100, 60, 80  # pixels for an inch: usual, at least with energies, and without them
RATES = {".gif": 20, ".mp4": 30}  # frames in a second; a gif counts in hundredths of a second
HOLD = 1.5  # s for which a gif stays at its end before it starts anew
BITS = 5  # of red, green and blue each, by which a gif's colours are told apart
SHADES = 6  # of each colour of a gif, towards white
QUALITY = "20"  # of H.264, where 0 loses nothing and 51 is the worst


def write_film(
    motion: Motion, path: Path, speed: float, size: tuple[int, int], progress: Callable[[float], None]
) -> None:
    """Write a gif or an mp4, as the suffix says.

    Args:
        motion: what to show.
        path: the file.
        speed: simulated seconds in a second on the screen, except in slow motion.
        size: width and height [pixels]; an mp4 has even ones.
        progress: called with the fraction done.

    Raises:
        MissingExtraError: when PyAV is not installed, for an mp4.
    """
    kind = path.suffix.lower()
    width, height = (length // 2 * 2 for length in size)
    film_rate = RATES[kind]
    step = speed * motion.frame_rate / film_rate  # frames of the motion in one of the film
    count = 1 + int(np.ceil((len(motion.time) - 1) / step))
    shown = np.minimum(np.rint(np.arange(count) * step), len(motion.time) - 1).astype(int)
    pictures = draw_frames(motion, shown, (width, height), progress)
    if kind == ".gif":
        write_gif(pictures, path, film_rate)
    else:
        write_mp4(pictures, path, film_rate, (width, height))


def draw_frames(
    motion: Motion, shown: np.ndarray, size: tuple[int, int], progress: Callable[[float], None]
) -> Iterator[np.ndarray]:
    """Draw frames of the motion: red, green, blue of each pixel, shape (height, width, 3)."""
    with mpl.rc_context(STYLE):
        dpi = resolution(size)
        figure = Figure(figsize=(size[0] / dpi, size[1] / dpi), dpi=dpi)
        canvas: Any = FigureCanvasAgg(figure)  # matplotlib says nothing of its types
        page = FilmPage(figure, motion)
        canvas.draw()
        ground = canvas.copy_from_bbox(figure.bbox)  # what does not move is drawn once
        rates = np.gradient(motion.time) * motion.frame_rate
        for number, frame in enumerate(shown):
            canvas.restore_region(ground)
            for artist in page.show(int(frame), float(rates[frame])):
                figure.draw_artist(artist)
            yield np.asarray(canvas.buffer_rgba())[..., :3].copy()
            progress((number + 1) / len(shown))


def resolution(size: tuple[int, int]) -> float:
    """The pixels for an inch of a film: fewer for a small one, so that its page has room for all it shows."""
    found = min(pixels / inches for pixels, inches in zip(size, ROOM, strict=True))
    return min(DPI, found) if found >= LEAST_DPI else SMALL_DPI


def write_gif(pictures: Iterable[np.ndarray], path: Path, film_rate: int) -> None:
    """Pack pictures, all with the same few colours, so that what does not move takes no room."""
    from PIL import Image

    palette = shades()
    nearest = nearest_shades(palette)
    packed = []
    for picture in pictures:
        red, green, blue = (picture >> (8 - BITS)).transpose(2, 0, 1)
        packed.append(Image.fromarray(nearest[red, green, blue]))
        packed[-1].putpalette(palette.tobytes())
    duration = 1000 // film_rate
    durations = [duration] * (len(packed) - 1) + [int(1000 * HOLD)]
    packed[0].save(
        path,
        format="GIF",
        save_all=True,
        append_images=packed[1:],
        duration=durations,
        loop=0,
        optimize=False,
    )


def shades() -> np.ndarray:
    """The colours of a gif: white, and those of the page with their shades towards it, shape (C, 3)."""
    full = np.array([to_rgb(colour) for colour in COLOURS])
    share = np.linspace(0.0, 1.0, SHADES, endpoint=False)[:, None, None]
    mixed = np.concatenate([np.ones((1, 3)), (full + share * (1.0 - full)).reshape(-1, 3)])
    return np.rint(255.0 * mixed).astype(np.uint8)


def nearest_shades(palette: np.ndarray) -> np.ndarray:
    """The number of the nearest colour of a palette, for each colour of so many bits, shape (32, 32, 32)."""
    levels = (np.arange(2**BITS) * (255.0 / (2**BITS - 1))).round()
    colours = np.stack(np.meshgrid(levels, levels, levels, indexing="ij"), axis=-1)[..., None, :]
    return np.concatenate(
        [
            np.argmin(((part - palette) ** 2).sum(axis=-1), axis=-1).astype(np.uint8)
            for part in np.split(colours, 8)
        ]
    )


def write_mp4(pictures: Iterable[np.ndarray], path: Path, film_rate: int, size: tuple[int, int]) -> None:
    """Pack pictures as H.264, which every browser and slide program plays."""
    av = require("av", "video")
    with av.open(str(path), "w", format="mp4", options={"movflags": "faststart"}) as container:
        stream = container.add_stream("libx264", rate=film_rate, options={"crf": QUALITY})
        stream.width, stream.height = size
        stream.pix_fmt = "yuv420p"
        for picture in pictures:
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        container.mux(stream.encode())
