"""Normal impacts as the article's laboratory measures them: two sieve classes (Figs. 4 and 5)."""
