"""The one exception that is a result: physics or the inputs forbid it."""


class NotComputable(ValueError):  # noqa: N818  no error of the program is of this kind
    """A quantity that these inputs do not allow, as a rebound where every sphere is captured."""
