"""Numbers that decide the claims of the article."""
