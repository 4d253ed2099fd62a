"""Assertions of the study about the article: declared criteria, and their outcomes."""
