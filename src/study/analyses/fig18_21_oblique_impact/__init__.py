"""Impulse ratio and energy loss against angle, steel on silicon (Figs. 18 and 21)."""
