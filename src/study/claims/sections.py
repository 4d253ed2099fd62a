"""All claims, by the modules of the sections in the order of the article."""

from study.claims import (
    conclusions,
    designs,
    dynamics,
    empirical,
    experiments,
    oblique,
    rigid_body,
    roughness,
    spores,
)

SECTIONS = (
    experiments,
    oblique,
    spores,
    rigid_body,
    dynamics,
    empirical,
    roughness,
    designs,
    conclusions,
)
