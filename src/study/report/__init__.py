"""Use of finished results: checks against references, comparisons, pages."""
