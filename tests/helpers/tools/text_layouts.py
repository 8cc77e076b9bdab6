"""The layouts of matplotlib's texts, kept for the next text of a figure that looks the same.

A figure lays out each text again in each pass, which takes a fifth of the time of a picture.
"""

from __future__ import annotations

import itertools
from typing import Any
from weakref import WeakKeyDictionary

import matplotlib as mpl
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.text import Text

CHECKED = 50
"""After each CHECKED uses of kept layouts, the layout that is used is compared with a new one."""
_SETTINGS = [name for name in mpl.rcParams if name.startswith(("font.", "mathtext.", "text."))]
_new_layout = Text._get_layout
_kept: WeakKeyDictionary[RendererAgg, dict[tuple[Any, ...], Any]] = WeakKeyDictionary()
_uses = itertools.count(1)


def keep_layouts() -> None:
    """Let all texts in pixels use the kept layouts."""
    Text._get_layout = _layout


def _layout(text: Text, renderer: Any) -> Any:
    """Return the result of ``Text._get_layout``; the key has all that it depends on."""
    if type(renderer) is not RendererAgg:
        return _new_layout(text, renderer)
    written = text._get_wrapped_text(), text.get_fontproperties().copy(), text.get_antialiased()
    placed = text._horizontalalignment, text._verticalalignment, text._get_multialignment()
    turned = text.get_rotation(), text.get_rotation_mode(), text._linespacing
    read = text.get_usetex(), text.get_parse_math(), renderer.dpi, text.get_figure(root=True).dpi
    key = (*written, *placed, *turned, *read, *map(_setting, _SETTINGS))
    # matplotlib keeps the sizes of texts for each renderer, also those of other settings
    kept = _kept.setdefault(renderer, {})
    layout = kept.get(key)
    if layout is None:
        layout = kept[key] = _new_layout(text, renderer)
    elif next(_uses) % CHECKED == 0:
        (box, *rest), (new_box, *new) = layout, _new_layout(text, renderer)
        assert (box.bounds, rest) == (new_box.bounds, new), f"another layout of {text}"
    return layout


def _setting(name: str) -> Any:
    value = dict.__getitem__(mpl.rcParams, name)
    return tuple(value) if isinstance(value, list) else value
