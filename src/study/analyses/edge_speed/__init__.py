"""Plateau, capture velocity and size by a contact whose edge opens by its own speed."""
