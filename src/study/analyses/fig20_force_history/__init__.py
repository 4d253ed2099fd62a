"""Normal force against time and its four terms (Fig. 20, Eq. 25)."""
