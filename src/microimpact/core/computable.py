"""The one exception that is a result: what physics or the inputs forbid."""


class NotComputable(ValueError):  # noqa: N818  no error of the program is of this kind
    """A quantity that these inputs do not allow, as a rebound where every sphere is captured."""
