"""Inference of a contact from the article's statements, by several laws at once."""
