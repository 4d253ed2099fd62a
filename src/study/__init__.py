"""The study: declared inputs, analyses, figures, ledgers and report of the article's reproduction.

It stands on `microimpact`, the physics and the virtual laboratory, and is run in place by the
workflow; it is not part of the installed package.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
