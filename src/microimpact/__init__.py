"""microimpact: impact, rebound and capture of microparticles.

The models of "Experiments and Engineering Models of Microparticle Impact and Deposition" (Brach,
Dunn and Li, J. Adhesion 74, 2000), other laws of adhesive contact, and a virtual laboratory, for
any particle and surface. Names are loaded on first use, so that importing the package is cheap.
"""

from importlib.metadata import version

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
__version__ = version("microimpact")
