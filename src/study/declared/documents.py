"""YAML files that hold a mapping: configuration, figure registry, claims; values in their words."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import yaml

from microimpact.core.nearest import nearest


class ConfigError(ValueError):
    """A configuration with problems: one line each, beginning with the dotted key."""


@contextmanager
def located(path: Path | str) -> Iterator[None]:
    """Prefix every line of an error with the name of the file."""
    try:
        yield
    except ValueError as error:
        lines = str(error).splitlines()
        raise ConfigError(
            "\n".join(line if line.startswith(str(path)) else f"{path}: {line}" for line in lines)
        ) from None


# libyaml reads eight times faster; a PyYAML built without it has no such loader.
class _Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]
    """Plain values only; a key that is given twice would silently replace the first."""

    def construct_mapping(self, node: Any, deep: bool = False) -> dict[Any, Any]:
        names = set()
        for key, _ in node.value:
            if isinstance(key.value, str) and key.value != "<<":
                if key.value in names:
                    raise yaml.MarkedYAMLError(
                        problem=f"the key {key.value!r} is given twice", problem_mark=key.start_mark
                    )
                names.add(key.value)
        content: dict[Any, Any] = super().construct_mapping(node, deep)
        return content


def _number(loader: Any, node: Any) -> Any:
    """Return a number, but none that YAML 1.1 reads in base 8 or 60."""
    if re.match(r"[-+]?(0[0-7_]+$|.*:)", node.value):
        raise yaml.MarkedYAMLError(
            problem="a number with a leading zero or a colon is read in base 8 or 60",
            problem_mark=node.start_mark,
        )
    return getattr(loader, f"construct_yaml_{node.tag.rpartition(':')[2]}")(node)


for _tag in ("int", "float"):
    _Loader.add_constructor(f"tag:yaml.org,2002:{_tag}", _number)


def load(path: Path | str) -> dict[str, Any]:
    """Read a YAML file that holds a mapping.

    Raises ConfigError, in one line, if the file is not UTF-8, not YAML, repeats a key, or holds
    something else than a mapping.
    """
    text = ""
    try:
        text = Path(path).read_text(encoding="utf-8-sig")
        content = yaml.load(text, _Loader)
    except yaml.MarkedYAMLError as error:
        if not (mark := error.problem_mark):
            raise ConfigError(f"{path}: not valid YAML: {error.problem}") from None
        near = "".join(text.splitlines()[mark.line : mark.line + 1])[mark.column :][:20]
        raise ConfigError(
            f"{path}, line {mark.line + 1}, column {mark.column + 1}: not valid YAML: "
            f"{error.problem}: {near!r}"
        ) from None
    # The last three come out of the YAML library where a tag does not fit its value.
    except (yaml.YAMLError, ValueError, AttributeError, IndexError, TypeError) as error:
        reason = " ".join(str(error).split())
        raise ConfigError(f"{path}: not valid YAML: {reason}") from None
    if not isinstance(content, dict):
        raise ConfigError(f"{path}: must hold a mapping of keys to values")
    return content


def entries(node: object) -> Mapping[str, Any]:
    """Return a mapping, or an empty one in place of anything else."""
    return node if isinstance(node, Mapping) else {}


Pairs = Mapping[str, tuple[str, str]]
NO_PAIRS: Pairs = {}
_PLACE = re.compile(r"\[\[([^\[\]:]+)(?::([^\]]*))?\]\]")


def filled(node: Any, values: Mapping[str, Any], key: str, pairs: Pairs = NO_PAIRS) -> Any:
    """Put parameters of a study into the words of a figure or a claim.

    ``[[friction]]`` or ``[[friction:.2f]]`` in any text is replaced by the parameter of that name,
    ``[[targets.speed]]`` for one within another, ``[[speeds.0]]`` for the first of a list and
    ``[[speeds]]`` for all of it, or all names of a mapping, so that no word contradicts a changed
    configuration. ``[[case.pair]]``, ``[[case.particle]]`` and ``[[case.surface]]`` are the
    materials of a case, or of several; the name of a case stands for it. A name may hold dots.

    Parameters
    ----------
    node
        What stands in the file under the dotted `key`.
    values
        Parameters of the study.
    key
        For messages.
    pairs
        Materials of particle and surface of every case.

    Raises
    ------
    ConfigError
        If there is no parameter of a name.
    """
    if isinstance(node, Mapping):
        return {name: filled(child, values, f"{key}.{name}", pairs) for name, child in node.items()}
    if isinstance(node, list):
        return [filled(child, values, f"{key}[{i}]", pairs) for i, child in enumerate(node)]
    if not isinstance(node, str):
        return node

    def value(match: re.Match[str]) -> str:
        node: Any = values
        rest = match[1]
        while rest:
            known = {**_named(node), **_materials(node, pairs)}
            if node is values:
                known = dict(zip(pairs, pairs, strict=True)) | known
            part = next((name for name in known if f"{rest}.".startswith(f"{name}.")), None)
            if part is None:
                near = nearest(rest.split(".")[0], known)
                raise ConfigError(f"{key}: no parameter {match[1]!r}{near}")
            node, rest = known[part], rest[len(part) + 1 :]
        *most, last = (
            format(each, match[2] or "").replace("%", " %")
            for each in (list(node) if isinstance(node, list | Mapping) else [node])
        )
        return f"{', '.join(most)} and {last}" if most else last

    return _PLACE.sub(value, node)


def _named(node: Any) -> Mapping[str, Any]:
    """Return the entries of a mapping, or of a list by their numbers."""
    if isinstance(node, list | tuple):
        return {str(number): item for number, item in enumerate(node)}
    return entries(node)


def _materials(node: Any, pairs: Pairs) -> dict[str, list[str]]:
    """Return the materials of a case, or of the cases of a list or mapping, in words."""
    names = [node] if isinstance(node, str) else node if isinstance(node, list | Mapping) else ()
    cases = [pairs[name] for name in names if isinstance(name, str) and name in pairs]
    if isinstance(node, Mapping) and {"particle", "surface"} <= set(node):
        cases = [(node["particle"], node["surface"])]
    if not cases:
        return {}
    words = [tuple(re.sub(r"-\d+$", "", each).replace("-", " ") for each in pair) for pair in cases]
    several = {
        "particle": [particle for particle, _ in words],
        "surface": [surface for _, surface in words],
        "pair": [f"{particle} on {surface}" for particle, surface in words],
    }
    return {key: list(dict.fromkeys(each)) for key, each in several.items()}
