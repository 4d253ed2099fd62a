"""A small font for formulas, cut from the one that the figures are set in.

Browsers place indices and bars by a table of the font; without a font that has one, an index falls
to the line of its letter. The glyphs are those of the STIX fonts that Matplotlib brings, the table
is made here. Their licence asks for another name.
"""

from __future__ import annotations

import base64
import io
from functools import cache
from pathlib import Path
from string import ascii_letters

import matplotlib as mpl
from fontTools.otlLib.builder import buildMathTable
from fontTools.subset import Options, Subsetter
from fontTools.ttLib import TTFont

NAME = "Formula"
FONTS = Path(mpl.get_data_path(), "fonts/ttf")
# Upright, and as browsers write single letters of a formula; h has a place of its own.
LETTERS = ascii_letters + "αβγδεζηθκλμνπρστφχψωΔΩ"
ITALIC = [*range(0x1D434, 0x1D455), *range(0x1D456, 0x1D468), 0x210E, *range(0x1D6E2, 0x1D71C)]
SIGNS = "0123456789.,()[]|/·+−=<>≠≤≥±×∫√′˙¨ \u00a0"
# These grow with what they hold: the larger glyphs come from fonts of one size each.
GROWING = "()√"
SIZES = ("One", "Two", "Three", "Four")
# Of 1000 units to the em; distances as TeX sets them (The TeXbook, appendix G).
CONSTANTS = {
    "ScriptPercentScaleDown": 72,
    "ScriptScriptPercentScaleDown": 58,
    "AxisHeight": 250,
    "AccentBaseHeight": 450,
    "SubscriptShiftDown": 200,
    "SubscriptTopMax": 344,
    "SubscriptBaselineDropMin": 50,
    "SuperscriptShiftUp": 400,
    "SuperscriptShiftUpCramped": 289,
    "SuperscriptBottomMin": 108,
    "SuperscriptBaselineDropMax": 386,
    "SubSuperscriptGapMin": 160,
    "SuperscriptBottomMaxWithSubscript": 344,
    "SpaceAfterScript": 50,
    "FractionNumeratorShiftUp": 394,
    "FractionNumeratorDisplayStyleShiftUp": 677,
    "FractionDenominatorShiftDown": 345,
    "FractionDenominatorDisplayStyleShiftDown": 686,
    "FractionNumeratorGapMin": 40,
    "FractionNumDisplayStyleGapMin": 120,
    "FractionRuleThickness": 50,
    "FractionDenominatorGapMin": 40,
    "FractionDenomDisplayStyleGapMin": 120,
    "RadicalVerticalGap": 50,
    "RadicalDisplayStyleVerticalGap": 120,
    "RadicalRuleThickness": 50,
    "RadicalExtraAscender": 50,
    "DisplayOperatorMinHeight": 1300,
}


@cache
def style_sheet() -> str:
    """Return the rules of style that bring the font along and set formulas in it."""
    data = base64.b64encode(_font()).decode()
    return (
        f'@font-face {{ font-family: "{NAME}"; src: url(data:font/ttf;base64,{data}); }}\n'
        f'math {{ font-family: "{NAME}", math; }}\n'
    )


def _font() -> bytes:
    """Return the font as a file; the same versions of the libraries give the same bytes."""
    font = TTFont(FONTS / "STIXGeneral.ttf", recalcTimestamp=False)
    options = Options(layout_features=[], name_IDs=[0, 1, 2, 4, 6, 13], notdef_outline=True)
    options.drop_tables += ["FFTM", "GlyphOrder", "GDEF", "GPOS", "GSUB"]
    subsetter = Subsetter(options)
    subsetter.populate(unicodes=[*map(ord, LETTERS + SIGNS), *ITALIC])
    subsetter.subset(font)
    for record in font["name"].names:
        if record.nameID in {1, 4, 6}:
            record.string = NAME
    _add_maths(font)
    file = io.BytesIO()
    font.save(file)
    return file.getvalue()


def _add_maths(font: TTFont) -> None:
    names = {sign: font.getBestCmap()[ord(sign)] for sign in GROWING}
    variants = {name: [(name, _height(font, name))] for name in names.values()}
    for size in SIZES:
        other = TTFont(FONTS / f"STIXSiz{size}SymReg.ttf")
        for sign, name in names.items():
            source = other.getBestCmap()[ord(sign)]
            # The fourth root is a piece of still larger ones.
            if (height := _height(other, source)) > variants[name][-1][1]:
                larger = f"{name}.{size}"
                font["glyf"][larger] = other["glyf"][source]
                font["hmtx"][larger] = other["hmtx"][source]
                variants[name].append((larger, height))
    buildMathTable(font, constants=CONSTANTS, vertGlyphVariants=variants)


def _height(font: TTFont, name: str) -> int:
    glyph = font["glyf"][name]
    return int(glyph.yMax - glyph.yMin)
