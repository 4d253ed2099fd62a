"""Oblique impacts as the article's laboratory measures them, by trajectory imaging (Figs. 6-12)."""
