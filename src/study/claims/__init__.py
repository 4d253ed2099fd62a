"""Claims of the article, by its sections: statement, criterion, reason and numbers in one place.

Arguments of all functions: ``context``, the contact, settings and tables of one case; ``dropped``,
particles of a speed class on their surface; ``quantity``, the name of a mean, ``restitution``,
``impulse_ratio`` or ``energy_loss``; angles of incidence in degrees, those of a trend from steep to
shallow. All else is in SI units unless its name or docstring has a unit.
"""
