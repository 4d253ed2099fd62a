"""What a figure is made of and how it looks from afar, as far as references record it."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
from numpy.typing import NDArray

from microimpact.declared.parameters import Name, NonNegative
from microimpact.report.check.differences import Difference
from microimpact.report.check.results import ResultsError, read_text

COLUMNS = 64

_SVG = "{http://www.w3.org/2000/svg}"
_HREF = "{http://www.w3.org/1999/xlink}href"
_COMMAND = re.compile(r"[MLHVCSQTA]")

# Place ("figure", "axes_1") -> list ("texts", "x ticks", "y ticks", "artists") -> its items.
Structure = dict[str, dict[str, list[str]]]


@dataclass(frozen=True, slots=True, kw_only=True)
class PictureTolerance:
    """Grey levels (of 255) by which one cell of the thumbnail, and its mean, may differ."""

    cell: NonNegative = 8.0
    mean: NonNegative = 0.5
    reason: Name = "rounding of colours; a moved label or a missing curve changes more"


@dataclass(frozen=True, slots=True)
class FigureShape:
    """The structure of a figure and its thumbnail in grey levels, shape (rows, 64)."""

    structure: Structure
    thumbnail: NDArray[np.uint8]


def read_shape(svg: Path) -> FigureShape:
    """Return the shape of a figure from its SVG and the PNG beside it.

    Raises ResultsError if a file is missing or malformed.
    """
    return FigureShape(structure(read_text(svg), str(svg)), thumbnail(svg.with_suffix(".png")))


def structure(svg: str, name: str = "figure") -> Structure:
    """Return what an SVG of Matplotlib shows.

    Per axes, and for the figure outside them: the texts, the labels of the ticks, and one entry
    per artist with the number of points of its paths and of its marks.

    `svg`: the file's text; `name`: name of the file in errors. Raises ResultsError if it is not
    well-formed.
    """
    builder = ET.TreeBuilder(insert_comments=True)
    try:
        root = ET.fromstring(svg, parser=ET.XMLParser(target=builder))
    except ET.ParseError as error:
        raise ResultsError(f"{name}, line {error.position[0]}: {error}") from None
    found: Structure = {}
    _walk(root, "figure", found)
    return found


def _walk(node: ET.Element, place: str, found: Structure) -> None:
    lists = found.setdefault(place, {"texts": [], "x ticks": [], "y ticks": [], "artists": []})
    for child in node.iterfind(f"{_SVG}g"):
        name = child.get("id", "")
        kind = re.sub(r"_\d+$", "", name)
        if kind == "axes":
            _walk(child, name, found)
        elif kind in {"figure", "legend", "matplotlib.axis"}:
            _walk(child, place, found)
        elif kind in {"xtick", "ytick"}:
            lists[f"{kind[0]} ticks"] += _texts(child)
        elif kind == "text":
            lists["texts"] += _texts(child)
        else:
            lists["artists"].append(_artist(kind, child))


def _texts(node: ET.Element) -> list[str]:
    # Letters are drawn as paths; their text is in a comment before them.
    return [(c.text or "").strip() for c in node.iter() if callable(c.tag)]


def _artist(kind: str, node: ET.Element) -> str:
    marks = len(list(node.iter(f"{_SVG}use"))) + len(list(node.iter(f"{_SVG}image")))
    symbols = {use.get(_HREF, "").removeprefix("#") for use in node.iter(f"{_SVG}use")}
    paths = [p for p in node.iter(f"{_SVG}path") if kind != "line2d" or p.get("id") not in symbols]
    points = sum(len(_COMMAND.findall(path.get("d", ""))) for path in paths)
    return f"{kind or 'group'}: {points} points, {marks} marks"


def thumbnail(png: Path) -> NDArray[np.uint8]:
    """Return a picture reduced to 64 columns of mean grey levels, shape (rows, 64).

    Raises ResultsError if the file is missing or no picture.
    """
    from matplotlib.image import imread

    try:
        pixels = np.asarray(imread(png, format="png"), float)
    except (OSError, SyntaxError, ValueError) as error:
        raise ResultsError(f"{png}: cannot be read: {error}") from None
    # Rec. 601: what the eye makes of red, green and blue.
    grey = pixels[..., :3] @ [0.299, 0.587, 0.114] if pixels.ndim == 3 else pixels
    height, width = grey.shape
    rows = max(1, round(COLUMNS * height / width))
    for axis, count in ((0, rows), (1, COLUMNS)):
        edges = np.linspace(0, grey.shape[axis], count + 1).astype(int)
        sizes = np.diff(edges)
        if not sizes.all():
            raise ResultsError(f"{png}: smaller than {COLUMNS} pixels")
        sums = np.add.reduceat(grey, edges[:-1], axis=axis)
        grey = sums / (sizes[:, None] if axis == 0 else sizes)
    reduced: NDArray[np.uint8] = np.rint(255 * grey).astype(np.uint8)
    return reduced


def as_json(shape: FigureShape) -> str:
    """Return a shape as it is kept among the references."""
    rows = [bytes(row).hex() for row in shape.thumbnail]
    content = {"structure": shape.structure, "thumbnail": rows}
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


def from_json(content: Mapping[str, Any], name: str) -> FigureShape:
    """Return the shape that `as_json` has written.

    Raises ResultsError, naming the file, if it holds anything else.
    """
    try:
        rows = [list(bytes.fromhex(row)) for row in content["thumbnail"]]
        return FigureShape(dict(content["structure"]), np.array(rows, dtype=np.uint8))
    except (KeyError, TypeError, ValueError) as error:
        raise ResultsError(f"{name}: not a reference of a figure: {error!r}") from None


def compare_shapes(
    file: str, reference: FigureShape, found: FigureShape, tolerance: PictureTolerance
) -> list[Difference]:
    """Return the differences of two figures: what each alone is made of, and how they look."""
    differences = []
    for place in dict.fromkeys((*reference.structure, *found.structure)):
        before, after = reference.structure.get(place, {}), found.structure.get(place, {})
        for name in dict.fromkeys((*before, *after)):
            gone, new = _alone(before.get(name, []), after.get(name, []))
            if gone or new:
                differences.append(
                    Difference(
                        file=file,
                        kind="structure",
                        row=place,
                        column=name,
                        reference=gone,
                        found=new,
                    )
                )
    look = _look(reference.thumbnail, found.thumbnail, tolerance)
    if look:
        limit = f"at most {tolerance.cell:g} and {tolerance.mean:g} grey levels"
        differences.append(
            Difference(file=file, kind="picture", column="look", reference=limit, found=look)
        )
    return differences


def _alone(before: Sequence[str], after: Sequence[str]) -> tuple[str, str]:
    gone, new = Counter(before) - Counter(after), Counter(after) - Counter(before)
    if list(before) != list(after) and not gone and not new:
        return "in this order", "in another order"
    return "; ".join(gone.elements()), "; ".join(new.elements())


def _look(before: NDArray[np.uint8], after: NDArray[np.uint8], tolerance: PictureTolerance) -> str:
    if before.shape != after.shape:
        return f"another format: {after.shape[0]} rows for {before.shape[0]}"
    apart = np.abs(before.astype(int) - after.astype(int))
    cell, mean = int(apart.max()), float(apart.mean())
    if cell <= tolerance.cell and mean <= tolerance.mean:
        return ""
    return f"one cell by {cell}, on average by {mean:.2f} grey levels"
