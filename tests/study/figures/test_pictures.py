"""Every figure as it is drawn: texts apart, clear of data, on the sheet; all series named."""

from __future__ import annotations

import re
from itertools import combinations

import numpy as np
import pytest
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.colors import to_hex
from matplotlib.lines import Line2D
from matplotlib.path import Path as Outline
from matplotlib.transforms import Bbox
from tests.shared import ROOT, settings_as_shipped

from study.figures import declaration, style
from study.report.check.results import read_text, table_files
from study.run.config import read_inputs
from study.tables import parse_table

SETTINGS = settings_as_shipped()
SPECS = read_inputs(SETTINGS).figures
FILES = table_files(ROOT / "tests/reference")
# Texts may touch by so much, in points: their boxes hold room for letters that they lack.
SLACK = 1.5
# Lines this thin guide the eye; a name in the colour of a curve and so near is its label.
THIN, NEAR = 0.7, 9.0
NO_MARK, TICKS = ("None", "none", "", " ", None), ("|", "_")


def data_of(figure):
    return [parse_table(read_text(FILES[f"data/{key}.csv"])) for key in figure.data]


def drawn(figure, branch=None, pairs=SETTINGS.pairs):
    """Return a picture drawn from the reference of the small run."""
    tables = dict(zip(figure.data, data_of(figure), strict=True))
    values = SETTINGS.branches[figure.analysis] if branch is None else branch
    sheet = style.Sheet(figure, tables, values, pairs)
    figure.draw(sheet)
    return sheet.figure


def legends(figure):
    found = [*figure.legends, *(ax.get_legend() for ax in figure.axes)]
    return [legend for legend in found if legend is not None and legend.get_visible()]


def shrunk(box, by):
    return Bbox.from_extents(box.x0 + by, box.y0 + by, box.x1 - by, box.y1 - by)


def texts(figure, slack):
    """Return each text that shows with its box; one of a legend includes its mark."""
    found = [*figure.texts]
    for ax in figure.axes:
        found += ax.texts
        if ax.axison:
            for axis in (ax.xaxis, ax.yaxis):
                low, high = sorted(axis.get_view_interval())
                ticks = [t for t in axis.get_major_ticks() if low <= t.get_loc() <= high]
                found += [axis.label, *(label for t in ticks for label in (t.label1, t.label2))]
        found += [child for child in ax.get_children() if child in titles(ax)]
    boxes = [(text, text.get_window_extent()) for text in found if shows(text)]
    for legend in legends(figure):
        boxes += [(legend.get_title(), legend.get_title().get_window_extent())]
        for text in legend.get_texts():
            box, size = text.get_window_extent(), text.get_fontsize() * figure.dpi / 72
            mark = (legend.handlelength + legend.handletextpad) * size
            boxes.append((text, Bbox.from_extents(box.x0 - mark, box.y0, box.x1, box.y1)))
    return [(text, shrunk(box, slack)) for text, box in boxes if shows(text)]


def titles(ax):
    return [ax.title, ax._left_title, ax._right_title]


def shows(text):
    return text.get_visible() and text.get_text().strip() != ""


def data(ax):
    """Return what is drawn of the data: an outline of lines in pixels, and how far marks reach."""
    point = ax.figure.dpi / 72
    for line in (line for line in ax.lines if line.get_visible()):
        outline = line.get_transform().transform_path(line.get_path())
        reach = 0.5 * line.get_markersize() * point if line.get_marker() not in NO_MARK else 0.0
        yield outline, line.get_linestyle() != "None", reach, line.get_clip_on()
    for bars in (c for c in ax.collections if isinstance(c, LineCollection) and c.get_visible()):
        for segment in filter(len, bars.get_segments()):
            outline = bars.get_transform().transform_path(Outline(segment))
            yield outline, True, 0.0, bars.get_clip_on()
    for marks in (c for c in ax.collections if isinstance(c, PathCollection) and c.get_visible()):
        places = marks.get_offset_transform().transform(marks.get_offsets())
        reach = 0.5 * float(np.sqrt(marks.get_sizes().max())) * point
        yield Outline(places), False, reach, marks.get_clip_on()


def covers(box, outline, joined, reach, window):
    """Tell whether a box hides some of the data that shows within a window."""
    if window is not None:
        box = Bbox.intersection(box, window)
        if box is None or box.width <= 0 or box.height <= 0:
            return False
    places = outline.vertices[np.isfinite(outline.vertices).all(axis=1)]
    if joined and len(places) > 1 and outline.intersects_bbox(box, filled=False):
        return True
    around = Bbox.from_extents(box.x0 - reach, box.y0 - reach, box.x1 + reach, box.y1 + reach)
    if window is not None and reach > 0.0:
        places = places[[window.padded(1.0).contains(*place) for place in places]]
    return reach > 0.0 and any(around.contains(*place) for place in places)


def has_ground(text, box, ax):
    """Tell whether a text lies on a ground of its own, or of a part that is drawn over lines."""
    own = text.get_bbox_patch()
    parts = (
        [own] if own else [p for p in ax.patches if p.get_window_extent().padded(1).overlaps(box)]
    )
    solid = [p for p in parts if p.get_visible() and p.get_fill() and p.get_facecolor()[3] == 1.0]
    return any(
        part is own or all(part.get_window_extent().contains(*corner) for corner in box.corners())
        for part in solid
    )


def looks(line):
    """Return what tells a line and its marks from others: colour and dashes, or colour and mark."""
    colour, dashes = to_hex(line.get_color()), line._unscaled_dash_pattern[1] or ()
    if line.get_linestyle() != "None":
        yield colour, *(round(dash / sum(dashes), 2) for dash in dashes)
    if line.get_marker() not in (*NO_MARK, *TICKS):
        fill = "half" if line.get_fillstyle() == "left" else to_hex(line.get_markerfacecolor())
        yield colour, line.get_marker(), fill


def unnamed(figure):
    """Return the series that no legend explains and no text beside them names."""
    entries = [line for legend in legends(figure) for line in legend.findobj(Line2D)]
    known = {look for line in entries for look in looks(line)}
    colours = {look[0] for look in known}
    marks = {line.get_marker() for line in entries}
    for ax in figure.axes:
        for line in ax.lines:
            if not line.get_visible() or not line.get_transform().contains_branch(ax.transData):
                continue
            colour, is_line = to_hex(line.get_color()), line.get_linestyle() != "None"
            is_guide = is_line and line.get_linewidth() <= THIN
            # The key of evidence explains a mark whose colour another entry explains.
            in_key = not is_line and colour in colours and line.get_marker() in marks
            if not (
                is_guide or in_key or known.issuperset(looks(line)) or beside(ax, line, colour)
            ):
                yield f"{line.get_label()!r} {sorted(set(looks(line)) - known)}"


def alike(figure):
    """Return the series of a panel that colour alone tells apart: the same dashes and marks."""
    for ax in figure.axes:
        colours = {}
        for line in (line for line in ax.lines if line.get_visible() and len(line.get_xdata())):
            own, colour = list(looks(line)), to_hex(line.get_color())
            is_guide = line.get_linestyle() != "None" and line.get_linewidth() <= THIN
            is_data = line.get_transform().contains_branch(ax.transData)
            if own and is_data and not is_guide and not beside(ax, line, colour):
                look = ("filled" if part == colour else part for _, *parts in own for part in parts)
                colours.setdefault(tuple(look), set()).add(colour)
        yield from (f"{look}: {sorted(own)}" for look, own in colours.items() if len(own) > 1)


def beside(ax, line, colour):
    outline = line.get_transform().transform_path(line.get_path())
    near = NEAR * ax.figure.dpi / 72
    return any(
        to_hex(text.get_color()) == colour
        and covers(text.get_window_extent().padded(near), outline, True, 1.0, None)
        for text in ax.texts
    )


def faults(figure, *, schematic=False):
    """Return, in words, what hides something, lies off the sheet, is not named or told apart."""
    figure.draw_without_rendering()
    point = figure.dpi / 72
    boxes, sheet = texts(figure, SLACK * point), figure.bbox
    shown = [(ax, ax.get_window_extent(), list(data(ax))) for ax in figure.axes]
    for (one, a), (other, b) in combinations(boxes, 2):
        if a.overlaps(b):
            yield f"{one.get_text()!r} over {other.get_text()!r}"
    for text, box in boxes:
        if not (
            sheet.x0 <= box.x0 and box.x1 <= sheet.x1 and sheet.y0 <= box.y0 <= box.y1 <= sheet.y1
        ):
            yield f"{text.get_text()!r} off the sheet"
        for ax, window, parts in shown:
            hidden = any(
                covers(box, outline, joined, reach, window if clipped else None)
                for outline, joined, reach, clipped in parts
            )
            if hidden and not has_ground(text, box, ax):
                yield f"{text.get_text()!r} over data"
    if not schematic:
        yield from (f"not named: {series}" for series in unnamed(figure))
        yield from (f"told apart by colour alone: {series}" for series in alike(figure))


@pytest.mark.parametrize("name", SPECS)
def test_all_can_be_read(name):
    spec = SPECS[name]
    if missing := [key for key in spec.data if f"data/{key}.csv" not in FILES]:
        pytest.skip(f"no reference yet of {', '.join(missing)}")
    with style.context():
        figure = drawn(spec)
        assert not list(faults(figure, schematic=spec.is_schematic))
    found = [str(text.get_text())[:3] for text, _ in texts(figure, 0.0)]
    letters = sorted(word for word in found if re.fullmatch(r"\([a-h]\)", word))
    assert letters == [f"({letter})" for letter in "abcdefgh"[: len(letters)]]
    panels = sum(ax.axison and bool(ax.lines) for ax in figure.axes)
    assert len(letters) >= (panels if panels > 1 else 0)


# Of a mean, and an error.
OTHERS = {"Bias of $e$", r"Mean impulse ratio $-\mu$", "Mean measured restitution $e_m$"}


def test_a_symbol_has_one_name_at_every_axis():
    """Restitution, impulse ratio, loss and angle are called one way each, with one sign."""
    names = {v for k, v in vars(declaration).items() if k.isupper() and isinstance(v, str)}
    written = set()
    for spec in SPECS.values():
        with style.context():
            written |= {ax.get_xlabel() for ax in drawn(spec).axes}
            written |= {ax.get_ylabel() for ax in drawn(spec).axes}
    for symbol in (r"$\alpha$", r"-\mu$", r"-\mu_m$", " $e$", "$e_m$", "$T_L$", "|v_n|"):
        own = {label for label in written if symbol in label} - OTHERS
        assert own <= names
        assert own


def test_a_case_that_is_left_out_has_no_panel():
    figure = SPECS["sobol"]
    (rows,) = data_of(figure)
    left = rows[~rows["panel"].str.endswith("n = 1")]
    with style.context():
        branch = SETTINGS.branches[figure.analysis]
        sheet = style.Sheet(figure, {"sobol": left}, branch, SETTINGS.pairs)
        figure.draw(sheet)
    shown = [ax.get_label() for ax in sheet.figure.axes if ax.get_visible()]
    assert shown == list(dict.fromkeys(left["panel"]))
