"""microimpact: impact, rebound and capture of microparticles.

The models of "Experiments and Engineering Models of Microparticle Impact and Deposition" (Brach,
Dunn and Li, J. Adhesion 74, 2000), other laws of adhesive contact, and a virtual laboratory, for
any particle and surface. Names are loaded on first use, so that importing the package is cheap.
"""

from typing import Any

import lazy_loader

_named, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> Any:
    """Load a name of the package, or read its version, on first use."""
    if name == "__version__":
        from importlib.metadata import version

        return version("microimpact")
    return _named(name)
